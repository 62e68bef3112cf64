//! Work shared by threads.

/// Do `work` with each of the parts on a thread of its own, with the first on this one.
///
/// Threads that end with the phase leave nothing behind when the library is unloaded or the process forks.
pub fn on_threads<T: Send>(parts: impl Iterator<Item = T>, work: impl Fn(T) + Sync) {
    let mut parts = parts.peekable();
    let Some(first) = parts.next() else { return };
    if parts.peek().is_none() {
        // A scope allocates, one thread must not.
        return work(first);
    }
    std::thread::scope(|scope| {
        let work = &work;
        parts.for_each(|part| drop(scope.spawn(move || work(part))));
        work(first);
    });
}
