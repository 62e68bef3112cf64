//! Work shared by threads.
//!
//! A team is there for one advance of the fluid. Its threads start once, take parts of the work of every phase as they
//! come, and have ended with the advance: nothing is left when the library is unloaded or the process forks. Nobody waits
//! for a thread that has taken nothing, so one that starts or wakes late, or whose core is busy, costs little.

use std::hint::spin_loop;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard};
use std::thread;
use std::time::{Duration, Instant};

use float::Modes;

/// How long a thread looks for what it waits for before it sleeps. To be woken takes about as long.
const PATIENCE: Duration = Duration::from_micros(50);

/// Parts of a phase for each thread: enough that none waits long for the last part of another.
const PARTS_PER_THREAD: usize = 4;

/// The calling thread and those that help it.
pub struct Team {
    threads: usize,
    call: Mutex<Call>,
    /// Number of calls so far, changed while `call` is locked.
    calls: AtomicUsize,
    /// Helpers at work, changed while `call` is locked.
    busy: AtomicUsize,
    called: Condvar,
    left: Condvar,
}

/// What helpers are called to.
struct Call {
    /// Takes parts until there are none.
    work: Option<&'static (dyn Fn() + Sync)>,
    is_over: bool,
    has_panicked: bool,
}

impl Team {
    /// Do `work` with a team of so many threads, all in the floating-point modes of this one. Where the system gives
    /// fewer, there are fewer. One thread allocates nothing.
    pub fn with<T>(threads: usize, work: impl FnOnce(&Self) -> T) -> T {
        let team = Self::alone();
        if threads < 2 {
            return work(&team);
        }
        let team = Self { threads, ..team };
        let modes = Modes::of_thread();
        thread::scope(|scope| {
            let _end = End(&team);
            for _ in 1..threads {
                let help = || {
                    modes.apply();
                    team.help();
                };
                if thread::Builder::new().spawn_scoped(scope, help).is_err() {
                    break;
                }
            }
            work(&team)
        })
    }

    /// The calling thread.
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

    /// In how many parts a phase is best divided.
    pub fn parts(&self) -> usize {
        if self.threads == 1 { 1 } else { PARTS_PER_THREAD * self.threads }
    }

    /// Do `work` with each of the parts. Who takes which is left to chance.
    pub fn share<T: Send>(&self, parts: impl Iterator<Item = T> + Send, work: impl Fn(T) + Sync) {
        self.share_with(&mut vec![(); self.threads], parts, |part, ()| work(part));
    }

    /// The same with something that each thread has for itself: at least as many as the threads.
    pub fn share_with<T: Send, S: Send>(
        &self,
        own: &mut [S],
        mut parts: impl Iterator<Item = T> + Send,
        work: impl Fn(T, &mut S) + Sync,
    ) {
        if self.threads == 1 {
            return parts.for_each(|part| work(part, &mut own[0]));
        }
        let (own, parts) = (Mutex::new(own.iter_mut()), Mutex::new(parts.by_ref()));
        self.call(&|| {
            let Some(own) = lock(&own).next() else { return };
            loop {
                let Some(part) = lock(&parts).next() else { return };
                work(part, own);
            }
        });
    }

    /// Call the helpers to what this thread does as well, and return when all have done.
    fn call(&self, work: &(dyn Fn() + Sync)) {
        // SAFETY: helpers run `work` only while they are counted as busy, which they become while it is in `call`.
        // `Return` takes it out and waits until none is busy, before the borrow ends, also where this thread panics.
        let work_for_helpers = unsafe { std::mem::transmute::<&(dyn Fn() + Sync), &'static (dyn Fn() + Sync)>(work) };
        let end = Return(self);
        lock(&self.call).work = Some(work_for_helpers);
        self.wake();
        work();
        drop(end);
        assert!(!lock(&self.call).has_panicked, "a thread that shared the work panicked");
    }

    /// Say that there is something new in `call`.
    fn wake(&self) {
        {
            let _call = lock(&self.call);
            self.calls.fetch_add(1, Ordering::Release);
        }
        self.called.notify_all();
    }

    /// Come whenever called, until it is over.
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

/// Where a call ends, also by a panic.
struct Return<'a>(&'a Team);

impl Drop for Return<'_> {
    fn drop(&mut self) {
        let Self(team) = self;
        lock(&team.call).work = None;
        let is_done = || team.busy.load(Ordering::Acquire) == 0;
        wait_shortly(is_done);
        drop(team.left.wait_while(lock(&team.call), |_| !is_done()));
    }
}

/// Where a team ends, also by a panic.
struct End<'a>(&'a Team);

impl Drop for End<'_> {
    fn drop(&mut self) {
        lock(&self.0.call).is_over = true;
        self.0.wake();
    }
}

fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("nothing panics under the lock")
}

/// Wait for something as long as it is not worth to sleep.
fn wait_shortly(is_there: impl Fn() -> bool) {
    let begin = Instant::now();
    while !is_there() && begin.elapsed() < PATIENCE {
        (0..16).for_each(|_| spin_loop());
    }
}
