//! How whoever waits for a picture hears of it, and stops it.

use std::ops::ControlFlow;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

use niji_scene::Stage;

use crate::error::Error;

/// Hears which part of a stage is done, from 0 to 1, from any thread, and says whether to go on. The parts of
/// a stage come in no order.
pub type Watch<'a> = &'a (dyn Fn(Stage, f64) -> ControlFlow<()> + Sync);

/// Nobody waits.
pub fn unwatched(_: Stage, _: f64) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Says which part of a stage is done, and refuses to go on where that is stopped.
pub(crate) fn go_on(watch: Watch, stage: Stage, part: f64) -> Result<(), Error> {
    match watch(stage, part) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Stopped),
    }
}

/// A stage that is watched.
pub(crate) struct Watched<'a> {
    stage: Stage,
    watch: Watch<'a>,
    n_done: AtomicU64,
    n_total: u64,
}

impl<'a> Watched<'a> {
    /// A stage of so many steps.
    pub(crate) fn new(stage: Stage, n_total: u64, watch: Watch<'a>) -> Self {
        Self {
            stage,
            watch,
            n_done: AtomicU64::new(0),
            n_total: n_total.max(1),
        }
    }

    /// So many steps more are done; says whether to go on.
    pub(crate) fn add(&self, n: u64) -> ControlFlow<()> {
        let n_done = n + self.n_done.fetch_add(n, Ordering::Relaxed);
        let part = n_done as f64 / self.n_total as f64;
        (self.watch)(self.stage, part)
    }
}
