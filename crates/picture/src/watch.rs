//! How whoever waits for a picture hears of it, and stops it.

use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
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

/// A stage that is watched.
pub(crate) struct Watched<'a> {
    stage: Stage,
    watch: Watch<'a>,
    n_done: AtomicU64,
    n_total: u64,
    is_stopped: AtomicBool,
}

impl<'a> Watched<'a> {
    /// A stage of so many steps.
    pub(crate) fn new(stage: Stage, n_total: u64, watch: Watch<'a>) -> Self {
        Self {
            stage,
            watch,
            n_done: AtomicU64::new(0),
            n_total: n_total.max(1),
            is_stopped: AtomicBool::new(false),
        }
    }

    /// So many steps more are done.
    pub(crate) fn add(&self, n: u64) {
        let n_done = n + self.n_done.fetch_add(n, Ordering::Relaxed);
        let part = n_done as f64 / self.n_total as f64;
        if (self.watch)(self.stage, part).is_break() {
            self.is_stopped.store(true, Ordering::Relaxed);
        }
    }

    /// Whether somebody stopped it.
    pub(crate) fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }

    /// Refuses to go on where it was stopped.
    pub(crate) fn check(&self) -> Result<(), Error> {
        if self.is_stopped() {
            Err(Error::Stopped)
        } else {
            Ok(())
        }
    }
}
