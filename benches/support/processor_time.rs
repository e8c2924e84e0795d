//! Processor time as the system tells it.

use std::time::Duration;

use nix::sys::resource::Usage;
use nix::sys::time::TimeValLike;

/// That of all threads, by the program and by the system for it.
pub(crate) fn processor_time(usage: &Usage) -> Duration {
    let microseconds = (usage.user_time() + usage.system_time()).num_microseconds();
    Duration::from_micros(microseconds as u64)
}
