//! How much memory the content of one file may take, a picture, and drops that are laid out.
//!
//! limit = min(memory of the machine, of its control group, address space of the process)/2
//! A header can promise anything: what it promises is held against this before memory is asked for, because a
//! system that has given too much ends the program, or another one. Where the system does not say what
//! it has, the limit is 4 GiB.

use std::fs;
use std::sync::OnceLock;

use crate::byte_count::Bytes;

/// Limit where the system does not say how much memory it has.
const UNKNOWN: u128 = 4 << 30;

/// The limit, once it was set or asked for.
static LIMIT: OnceLock<Bytes> = OnceLock::new();

/// Sets the limit for good.
///
/// # Errors
/// The limit that stands already.
pub fn set_memory_limit(limit: Bytes) -> Result<(), Bytes> {
    LIMIT.set(limit).map_err(|_| memory_limit())
}

/// The limit: as it was set, or half of the memory that this process can have.
pub fn memory_limit() -> Bytes {
    *LIMIT.get_or_init(|| {
        let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
        let machine = number_after(&read("/proc/meminfo"), "MemTotal:").map(|kib| kib << 10);
        let group = read("/sys/fs/cgroup/memory.max").trim().parse().ok();
        let process = number_after(&read("/proc/self/limits"), "Max address space");
        let least = [machine, group, process].into_iter().flatten().min();
        Bytes(least.map_or(UNKNOWN, |bytes: u128| bytes / 2))
    })
}

/// The number in the line of a text that begins so, if it is one.
fn number_after(text: &str, start: &str) -> Option<u128> {
    let line = text.lines().find_map(|line| line.strip_prefix(start))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_of_the_system_are_found() {
        let text = "MemFree: 7 kB\nMemTotal:       24 kB\nMax address space  unlimited\n";
        assert_eq!(number_after(text, "MemTotal:"), Some(24));
        assert_eq!(number_after(text, "Max address space"), None);
        assert_eq!(number_after("", "MemTotal:"), None);
        let limit = memory_limit();
        assert!(limit > Bytes(1 << 20));
        assert_eq!(set_memory_limit(Bytes(1)), Err(limit));
        assert_eq!(memory_limit(), limit);
    }
}
