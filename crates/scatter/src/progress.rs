//! How whoever waits for a table hears of it, and stops it.

use std::ops::ControlFlow;

use crate::error::Error;

/// Hears the part of a table that is done, from 0 to 1, from any thread, and says whether to go on.
pub type Progress<'a> = &'a (dyn Fn(f64) -> ControlFlow<()> + Sync);

/// Nobody waits.
pub fn unwatched(_: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Counts so many steps more, or refuses to go on.
pub(crate) type Count<'a> = &'a (dyn Fn(usize) -> Result<(), Error> + Sync);

/// Says which part is done.
pub(crate) fn tell(progress: Progress, part: f64) -> Result<(), Error> {
    match progress(part) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Stopped),
    }
}
