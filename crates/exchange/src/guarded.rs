//! Foreign decoders that cannot end the program.
//!
//! A codec that panics at damaged bytes would end the program, in the threads of the crate exr by an abort. So
//! codecs run in ours, and a panic there is damage of the file.

use std::panic::AssertUnwindSafe;
use std::panic::catch_unwind;

/// What `read` returns; `None` where a decoder panics.
pub fn guarded<T>(read: impl FnOnce() -> T) -> Option<T> {
    // What was half read is dropped, so nobody sees it.
    catch_unwind(AssertUnwindSafe(read)).ok()
}
