//! Foreign decoders that cannot end the program.
//!
//! A codec that panics at damaged bytes would end the program, in the threads of the crate exr by an abort. So
//! codecs run in ours, and a panic there is damage of the file.

use std::panic::AssertUnwindSafe;
use std::panic::catch_unwind;

/// What `read` returns, or damage, as errors of the caller call it, where a decoder panics.
///
/// # Errors
/// As `read`, and `damaged`.
pub fn guarded<T, E>(
    damaged: fn(String) -> E,
    read: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    // What was half read is dropped, so nobody sees it.
    let outcome = catch_unwind(AssertUnwindSafe(read));
    outcome.unwrap_or_else(|_| Err(damaged("its pixels cannot be unpacked".to_owned())))
}
