//! What a task asks for: memory and threads by the plan, and so many frames that it takes some minutes.

use std::fmt;
use std::path::Path;

use niji_picture::PlannedScene;
use niji_radiometry::Bytes;
use serde::Serialize;
use serde_json::Value;

use crate::run::report;

/// What a task should take at most, seconds: what a machine that is taken away loses, and what a queue likes.
const TASK_S: f64 = 600.0;

/// Frames of a task where no time is known.
const UNTIMED_FRAMES: usize = 10;

/// Memory that a machine of a farm has for each of its threads, MiB: a task that takes more takes more of those.
const THREAD_MIB: u64 = 2048;

/// What is asked for beyond the plan's figure, which was measured on single scenes.
const MARGIN: f64 = 1.25;

const MIB: u64 = 1 << 20;

/// What a task asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(super) struct Needs {
    /// Threads.
    pub(super) threads: u64,
    /// Memory, MiB.
    pub(super) memory_mib: u64,
}

impl Needs {
    /// As they are asked for, or else as a plan has them.
    pub(super) fn new(
        threads: Option<usize>,
        memory: Option<Bytes>,
        planned: &PlannedScene,
    ) -> Self {
        let stages = planned.plan.stages.iter();
        let most = stages.filter_map(|it| it.estimate.memory_bytes).max();
        let by_plan = (most.unwrap_or(0) as f64 * MARGIN) as u64;
        let bytes = memory.map_or(by_plan, |it| u64::try_from(it.0).unwrap_or(u64::MAX));
        let memory_mib = bytes.div_ceil(MIB).max(1);
        let by_memory = memory_mib.div_ceil(THREAD_MIB);
        Self {
            threads: threads.map_or(by_memory, |it| it as u64),
            memory_mib,
        }
    }
}

/// Frames of a task, and what that stands on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Chunk {
    /// How many.
    pub(super) most: usize,
    /// Seconds of the slowest that was made here, where one was.
    pub(super) slowest_s: Option<f64>,
}

impl Chunk {
    /// As many as are asked for.
    pub(super) fn of(most: usize) -> Self {
        Self {
            most,
            slowest_s: None,
        }
    }

    /// By the slowest frame of which a report in the folder tells.
    pub(super) fn of_frames(out: &Path) -> Self {
        let reports = report::frames_in(out);
        let slowest_s = reports.values().filter_map(slowest_s).reduce(f64::max);
        let most = slowest_s.map_or(UNTIMED_FRAMES, |slowest_s| {
            (TASK_S / slowest_s).floor().max(1.0) as usize
        });
        Self { most, slowest_s }
    }
}

/// Seconds of the picture of a frame, without tables, where it was made.
fn slowest_s(report: &Value) -> Option<f64> {
    let frames = report["frames"].as_array()?.iter();
    let made = frames
        .flat_map(|frame| frame["stages"].as_array().into_iter().flatten())
        .filter(|stage| stage["stage"] == "render" && stage["up_to_date"] == false);
    made.filter_map(|stage| stage["seconds"].as_f64())
        .reduce(f64::max)
}

impl fmt::Display for Needs {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            threads,
            memory_mib,
        } = self;
        write!(
            out,
            "a task asks for {threads} threads and {memory_mib} MiB"
        )
    }
}

impl fmt::Display for Chunk {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let slowest_s = self.slowest_s;
        slowest_s.map_or(Ok(()), |slowest_s| {
            write!(out, "; the slowest frame here took {slowest_s:.0} s")
        })
    }
}
