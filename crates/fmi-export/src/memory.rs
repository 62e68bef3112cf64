//! Check of the free memory before large allocations, so that a call fails and the process survives.

use std::fs;
use std::hint::black_box;
use std::path::Path;

/// Reserve for small allocations, bytes: messages, threads and the host.
const RESERVE: usize = 4 << 20;

/// Size from which the free memory of the machine counts, bytes: Linux grants more memory than it has.
const LARGE: usize = 64 << 20;

/// Refuse an allocation of about `bytes` that exceeds the limits of the process or the free memory of the machine.
///
/// A model calls this function before a large allocation, because Rust ends the process when an allocation fails. The
/// free memory counts on Linux only, as the limits of control groups do, in which containers run.
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

/// Return the free memory of the machine without swapping, or of the process's control group where that is less, bytes.
fn available() -> Option<usize> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let machine =
        line.trim().strip_suffix(" kB")?.parse().ok().map(|kilobytes: usize| kilobytes.saturating_mul(1024))?;
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    Some(available_to(&groups, Path::new("/sys/fs/cgroup")).map_or(machine, |group| group.min(machine)))
}

/// Return the memory that control groups leave, bytes: `groups` is the text of `/proc/self/cgroup`, and `root` the
/// folder of the groups. Version 2 has one tree, version 1 a tree for memory. `None` without a limit.
fn available_to(groups: &str, root: &Path) -> Option<usize> {
    let left = |line: &str| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, group) = (parts.next()?, parts.next()?.trim_start_matches('/'));
        let (tree, limit, usage) = match controllers {
            "" => (root.to_path_buf(), "memory.max", "memory.current"),
            names if names.split(',').any(|name| name == "memory") => {
                (root.join("memory"), "memory.limit_in_bytes", "memory.usage_in_bytes")
            }
            _ => return None,
        };
        // In a container the path may be of the host: then the tree's own folder is the group.
        let folders = tree.join(group);
        folders
            .ancestors()
            .take_while(|folder| folder.starts_with(&tree))
            .filter_map(|folder| {
                let number = |name: &str| fs::read_to_string(folder.join(name)).ok()?.trim().parse::<usize>().ok();
                let files = fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
                let cached = |line: &str| line.strip_prefix("inactive_file ")?.trim().parse::<usize>().ok();
                let reclaimable = files.lines().find_map(cached).unwrap_or(0);
                Some(number(limit)?.saturating_sub(number(usage)?.saturating_sub(reclaimable)))
            })
            .min()
    };
    groups.lines().filter_map(left).min()
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

    /// A tree of groups, of which the outer one has 300 MB and uses 250, 100 of them files, and the inner one no limit.
    #[test]
    fn the_least_of_the_limits_of_the_groups_counts() {
        let root = std::env::temp_dir().join(format!("nervure-groups-{}", std::process::id()));
        for (tree, limit, usage, groups) in [
            ("", "memory.max", "memory.current", "0::/outer/inner\n"),
            ("memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "5:cpu:/\n4:pids,memory:/outer/inner\n"),
        ] {
            let outer = root.join(tree).join("outer");
            fs::create_dir_all(outer.join("inner")).unwrap();
            fs::write(outer.join("inner").join(limit), "max\n").unwrap();
            fs::write(outer.join("inner").join(usage), "1\n").unwrap();
            assert_eq!(available_to(groups, &root), None);
            fs::write(outer.join(limit), "300000000\n").unwrap();
            fs::write(outer.join(usage), "250000000\n").unwrap();
            assert_eq!(available_to(groups, &root), Some(50_000_000));
            fs::write(outer.join("memory.stat"), "anon 7\ninactive_file 100000000\n").unwrap();
            assert_eq!(available_to(groups, &root), Some(150_000_000));
            fs::write(outer.join(usage), "400000000\n").unwrap();
            assert_eq!(available_to(groups, &root), Some(0));
            fs::remove_dir_all(&root).unwrap();
        }
        assert_eq!(available_to("0::/elsewhere\n1:cpu:/\n", &root), None);
    }
}
