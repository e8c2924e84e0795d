//! How whoever waits for a picture hears of it, and stops it.

use std::ops::ControlFlow;

use crate::error::Error;

/// Hears how many pixels were just finished, from any thread, and says whether to go on; it hears of none
/// while what comes before the first pixel is made.
pub type Progress<'a> = &'a (dyn Fn(u64) -> ControlFlow<()> + Sync);

/// Nobody waits.
pub fn unwatched(_: u64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Says how many pixels were just finished.
pub(crate) fn tell(progress: Progress, n_pixels: u64) -> Result<(), Error> {
    match progress(n_pixels) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Stopped),
    }
}
