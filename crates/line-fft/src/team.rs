//! A team of threads that shares the parts of a phase.
//!
//! A team lives as long as the call of [`ThreadTeam::with`]: no thread is left when a library is unloaded or the process
//! forks. Threads take parts as they come. No thread waits for one that has not taken a part: a thread that starts or
//! wakes late does not delay the others.

use std::hint::spin_loop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use fpenv::Modes;

/// Time for which a thread spins before it sleeps. Times from 5 to 50 µs made no measurable difference on busy cores.
const SPIN_TIME: Duration = Duration::from_micros(50);

/// Parts of a phase for each thread: enough that no thread waits long for the last part of another.
const PARTS_PER_THREAD: usize = 4;

/// The calling thread and its helpers.
pub struct ThreadTeam {
    threads: usize,
    call: Mutex<Call>,
    /// Number of calls so far, changed while `call` is locked.
    calls: AtomicUsize,
    /// Helpers at work, changed while `call` is locked.
    busy: AtomicUsize,
    called: Condvar,
    left: Condvar,
}

/// What the helpers are called for.
struct Call {
    /// Takes parts until none is left.
    work: Option<&'static (dyn Fn() + Sync)>,
    is_over: bool,
    has_panicked: bool,
}

impl ThreadTeam {
    /// Run `work` with a team of `threads` threads, all in the floating-point modes of the calling one. The team is
    /// smaller if the system gives fewer threads. A team of one allocates nothing.
    pub fn with<T>(threads: usize, work: impl FnOnce(&Self) -> T) -> T {
        let team = Self::alone();
        if threads < 2 {
            return work(&team);
        }
        let team = Self { threads, ..team };
        let modes = Modes::of_thread();
        thread::scope(|scope| {
            let help = || {
                modes.apply();
                team.help();
            };
            let mut end = End { team: &team, helpers: Vec::with_capacity(threads - 1) };
            end.helpers.extend((1..threads).map_while(|_| thread::Builder::new().spawn_scoped(scope, help).ok()));
            work(&team)
        })
    }

    /// Return a team of the calling thread.
    pub fn alone() -> Self {
        Self {
            threads: 1,
            call: Mutex::new(Call { work: None, is_over: false, has_panicked: false }),
            calls: AtomicUsize::new(0),
            busy: AtomicUsize::new(0),
            called: Condvar::new(),
            left: Condvar::new(),
        }
    }

    /// Return whether there is no helper.
    pub fn is_alone(&self) -> bool {
        self.threads == 1
    }

    /// Return the number of parts into which a phase is best divided.
    pub fn parts(&self) -> usize {
        if self.is_alone() { 1 } else { PARTS_PER_THREAD * self.threads }
    }

    /// Run `first` on one thread while the helpers begin, and `work` with each of the parts on any thread.
    pub fn share<T: Send>(
        &self,
        first: impl FnOnce() + Send,
        parts: impl Iterator<Item = T> + Send,
        work: impl Fn(T) + Sync,
    ) {
        self.share_with(&mut vec![(); self.threads], first, parts, |part, ()| work(part));
    }

    /// [`Self::share`] with an element of `own` for each thread; there must be as many as threads.
    pub fn share_with<T: Send, S: Send>(
        &self,
        own: &mut [S],
        first: impl FnOnce() + Send,
        mut parts: impl Iterator<Item = T> + Send,
        work: impl Fn(T, &mut S) + Sync,
    ) {
        if self.is_alone() {
            first();
            return parts.for_each(|part| work(part, &mut own[0]));
        }
        let (own, first, parts) = (Mutex::new(own.iter_mut()), Mutex::new(Some(first)), Mutex::new(parts.by_ref()));
        self.call(&|| {
            let Some(own) = lock(&own).next() else { return };
            let first = lock(&first).take();
            first.into_iter().for_each(|first| first());
            loop {
                let Some(part) = lock(&parts).next() else { return };
                work(part, own);
            }
        });
    }

    /// Run `work` on this thread and on the helpers, and return when all have ended.
    fn call(&self, work: &(dyn Fn() + Sync)) {
        // SAFETY: helpers run `work` only while they are counted as busy, which they become while it is in `call`.
        // `Return` takes it out and waits until none is busy, before the borrow ends, also where this thread panics.
        let work_for_helpers = unsafe { std::mem::transmute::<&(dyn Fn() + Sync), &'static (dyn Fn() + Sync)>(work) };
        let end = Return(self);
        self.tell(|call| call.work = Some(work_for_helpers));
        work();
        drop(end);
        assert!(!lock(&self.call).has_panicked, "a thread that shared the work panicked");
    }

    /// Change the call and wake the helpers.
    fn tell(&self, news: impl FnOnce(&mut Call)) {
        let mut call = lock(&self.call);
        news(&mut call);
        self.calls.fetch_add(1, Ordering::Release);
        drop(call);
        self.called.notify_all();
    }

    /// Work at every call until the team is over.
    fn help(&self) {
        let mut seen = 0;
        loop {
            wait_shortly(|| self.calls.load(Ordering::Acquire) != seen);
            let call = lock(&self.call);
            let call = self.called.wait_while(call, |_| self.calls.load(Ordering::Relaxed) == seen);
            let call = call.expect("nothing panics under the lock");
            seen = self.calls.load(Ordering::Relaxed);
            if call.is_over {
                return;
            }
            let Some(work) = call.work else { continue };
            self.busy.fetch_add(1, Ordering::Relaxed);
            drop(call);
            let done = catch_unwind(AssertUnwindSafe(work));
            let mut call = lock(&self.call);
            call.has_panicked |= done.is_err();
            self.busy.fetch_sub(1, Ordering::Release);
            drop(call);
            self.left.notify_one();
        }
    }
}

/// Ends a call, also by a panic.
struct Return<'a>(&'a ThreadTeam);

impl Drop for Return<'_> {
    fn drop(&mut self) {
        let Self(team) = self;
        lock(&team.call).work = None;
        let is_done = || team.busy.load(Ordering::Acquire) == 0;
        wait_shortly(is_done);
        drop(team.left.wait_while(lock(&team.call), |_| !is_done()));
    }
}

/// Ends a team, also by a panic. A scope alone would not wait until the threads of the system have ended.
struct End<'scope, 'a> {
    team: &'a ThreadTeam,
    helpers: Vec<ScopedJoinHandle<'scope, ()>>,
}

impl Drop for End<'_, '_> {
    fn drop(&mut self) {
        self.team.tell(|call| call.is_over = true);
        for helper in self.helpers.drain(..) {
            // A helper catches every panic.
            let _ = helper.join();
        }
    }
}

/// A `first` of [`ThreadTeam::share`] that does nothing.
pub fn nothing() {}

fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("nothing panics under the lock")
}

/// Spin until `is_there` or until [`SPIN_TIME`] has passed.
fn wait_shortly(is_there: impl Fn() -> bool) {
    let begin = Instant::now();
    while !is_there() && begin.elapsed() < SPIN_TIME {
        (0..16).for_each(|_| spin_loop());
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use fpenv::Fast;

    use super::*;

    const CALLER: &str = "on the calling thread";
    const HELPER: &str = "on a helper";

    /// Give each thread of a team one part at the same time.
    fn all_at_once(team: &ThreadTeam, threads: usize, work: impl Fn() + Sync) {
        let barrier = Barrier::new(threads);
        team.share(nothing, 0..threads, |_| {
            barrier.wait();
            work();
        });
    }

    #[test]
    fn every_thread_works_in_the_modes_of_the_first() {
        let seen = Mutex::new(Vec::new());
        let _fast = Fast::enter();
        let own = Modes::of_thread();
        ThreadTeam::with(4, |team| {
            all_at_once(team, 4, || lock(&seen).push((thread::current().id(), Modes::of_thread())))
        });
        let mut seen = seen.into_inner().expect("no thread panics");
        seen.dedup_by_key(|(thread, _)| *thread);
        assert_eq!(seen.len(), 4);
        assert!(seen.iter().all(|(_, modes)| *modes == own), "{seen:?}");
    }

    #[test]
    fn every_part_is_done_once_by_threads_that_run_or_sleep() {
        for threads in [1, 2, 5] {
            let mut parts = [0; 37];
            let (mut own, mut firsts) = (vec![0; threads], 0);
            ThreadTeam::with(threads, |team| {
                for call in 0..200 {
                    if call % 20 == 0 {
                        thread::sleep(4 * SPIN_TIME);
                    }
                    let first = || firsts += 1;
                    team.share_with(&mut own, first, parts.iter_mut(), |part, own| {
                        *part += 1;
                        *own += 1;
                    });
                }
            });
            assert_eq!((parts, own.iter().sum(), firsts), ([200; 37], 200 * 37, 200), "{threads} threads");
        }
    }

    /// Return the message of a panic of the caller or the helpers, and the number of threads that ended their work.
    fn panicked(who: &'static str) -> (String, usize) {
        let (caller, ended) = (thread::current().id(), AtomicUsize::new(0));
        let result = catch_unwind(AssertUnwindSafe(|| {
            ThreadTeam::with(3, |team| {
                all_at_once(team, 3, || {
                    let is_caller = thread::current().id() == caller;
                    if is_caller == (who == CALLER) {
                        panic!("{who}");
                    }
                    thread::sleep(Duration::from_millis(20));
                    ended.fetch_add(1, Ordering::Relaxed);
                });
            });
        }));
        let payload = result.expect_err("the panic comes out");
        let text =
            payload.downcast_ref::<String>().cloned().or(payload.downcast_ref().map(|text: &&str| text.to_string()));
        (text.expect("a panic has a text"), ended.into_inner())
    }

    #[test]
    fn a_panic_comes_out_once_all_have_ended() {
        // A helper at work borrows from the caller, so the caller must wait.
        assert_eq!(panicked(CALLER), (CALLER.into(), 2));
        assert_eq!(panicked(HELPER), ("a thread that shared the work panicked".into(), 1));
    }
}
