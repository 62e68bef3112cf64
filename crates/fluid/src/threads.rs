//! Work shared by threads.

use float::Modes;

/// Do `work` with each of the parts on a thread of its own, with the first on this one, all in the floating-point modes
/// of this one.
///
/// Threads that end with the phase leave nothing behind when the library is unloaded or the process forks.
pub fn on_threads<T: Send>(parts: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
    let mut parts = parts.peekable();
    let Some(first) = parts.next() else { return };
    if parts.peek().is_none() {
        // A scope allocates, one thread must not.
        return work(first);
    }
    let modes = Modes::of_thread();
    std::thread::scope(|scope| {
        let work = &work;
        parts.for_each(|part| {
            scope.spawn(move || {
                modes.apply();
                work(part);
            });
        });
        work(first);
    });
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use float::Fast;

    use super::*;

    #[test]
    fn every_thread_works_in_the_modes_of_the_first() {
        let seen = Mutex::new(Vec::new());
        let _fast = Fast::enter();
        let own = Modes::of_thread();
        on_threads(0..4, |_| seen.lock().expect("no thread panics").push(Modes::of_thread()));
        assert_eq!(seen.into_inner().expect("no thread panics"), [own; 4]);
    }
}
