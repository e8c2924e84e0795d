//! The most memory that the process has held at once.

use std::fs;

/// Watches the process from now on.
pub(crate) struct PeakMemory {
    /// Whether the system let the mark be set back.
    is_reset: bool,
}

impl PeakMemory {
    /// Sets the mark back to what is held now.
    pub(crate) fn start() -> Self {
        // Linux: 5 resets the peak of resident memory.
        let is_reset = fs::write("/proc/self/clear_refs", "5").is_ok();
        Self { is_reset }
    }

    /// Resident memory at its highest since the start, in bytes; `None` where the system does not say.
    pub(crate) fn bytes(&self) -> Option<u64> {
        let status = fs::read_to_string("/proc/self/status").ok()?;
        let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
        let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
        self.is_reset.then_some(1024 * kibibytes)
    }
}
