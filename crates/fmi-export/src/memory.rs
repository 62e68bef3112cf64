//! Memory is asked for before it is taken: where there is not enough, a call fails and the process goes on.

use std::hint::black_box;

/// Left over for what is small: messages, threads, and what the host does next, bytes.
const RESERVE: usize = 4 << 20;

/// From this size on the machine's free memory counts as well, bytes: Linux promises more than it has.
const LARGE: usize = 64 << 20;

/// Refuses work that takes about so many bytes where the system would not give them, or the machine has not got them.
///
/// A model calls this before it makes something large. Rust ends the process where memory runs out, so that this has
/// to be known before. On systems other than Linux only the process's own limits count.
pub fn require_memory(bytes: usize) -> Result<(), String> {
    let megabytes = |bytes: usize| bytes.div_ceil(1 << 20);
    if bytes >= LARGE
        && let Some(available) = available()
        && available < bytes
    {
        let (needed, left) = (megabytes(bytes), megabytes(available));
        return Err(format!("this takes about {needed} MB of memory, but the machine has {left} MB left"));
    }
    let mut probe = Vec::<u8>::new();
    let given = probe.try_reserve_exact(bytes.saturating_add(RESERVE));
    black_box(&probe);
    given.map_err(|_| format!("this takes about {} MB of memory, which the system does not give", megabytes(bytes)))
}

/// What the machine can give without swapping, bytes.
fn available() -> Option<usize> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix(" kB")?.parse().ok().map(|kilobytes: usize| kilobytes.saturating_mul(1024))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_machine_has_is_refused_with_its_size() {
        assert_eq!(require_memory(1 << 20), Ok(()));
        for bytes in [1 << 45, usize::MAX] {
            let message = require_memory(bytes).unwrap_err();
            assert!(message.contains(&format!("{} MB", bytes.div_ceil(1 << 20))), "{message}");
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn the_free_memory_of_the_machine_is_known() {
        assert!(available().is_some_and(|bytes| bytes > 1 << 20));
    }
}
