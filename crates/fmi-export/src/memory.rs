//! Check of the free memory before large allocations, so that a call fails and the process survives.

use std::hint::black_box;

/// Reserve for small allocations, bytes: messages, threads and the host.
const RESERVE: usize = 4 << 20;

/// Size from which the free memory of the machine counts, bytes: Linux grants more memory than it has.
const LARGE: usize = 64 << 20;

/// Refuse an allocation of about `bytes` that exceeds the limits of the process or the free memory of the machine.
///
/// A model calls this function before a large allocation, because Rust ends the process when an allocation fails. The
/// free memory counts on Linux only.
pub fn require_memory(bytes: usize) -> Result<(), String> {
    let megabytes = |bytes: usize| bytes.div_ceil(1 << 20);
    if bytes >= LARGE
        && let Some(available) = available()
        && available < bytes
    {
        let (needed, left) = (megabytes(bytes), megabytes(available));
        return Err(format!("about {needed} MB of memory are needed, but the machine has {left} MB left"));
    }
    let mut probe = Vec::<u8>::new();
    let given = probe.try_reserve_exact(bytes.saturating_add(RESERVE));
    black_box(&probe);
    given.map_err(|_| format!("about {} MB of memory are needed, but the system refuses them", megabytes(bytes)))
}

/// Return the free memory of the machine without swapping, bytes.
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
