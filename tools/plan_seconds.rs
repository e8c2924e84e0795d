//! `niji plan --seconds`: how long a run will take for several tolerances, from a part of each stage.

use std::path::Path;
use std::time::Instant;

use niji_picture::PlannedScene;
use niji_picture::TOLERANCES;
use niji_picture::stage_seconds;
use niji_scene::Stage;
use serde::Serialize;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::plan::in_form;
use crate::scene_file;
use crate::stages::accuracy::of_white;

/// Tolerances that are told besides the one asked for, finest last.
const TOLD: std::ops::Range<usize> = 1..5;

/// Where it takes longer to tell of a tolerance, no finer one is told of, seconds.
const LONG_S: f64 = 10.0;

/// Stages that are told of, in their order.
const STAGES: [Stage; 6] = [
    Stage::Depth,
    Stage::Drops,
    Stage::Airy,
    Stage::Scatter,
    Stage::Atmosphere,
    Stage::Render,
];

/// What a picture of a tolerance takes.
#[derive(Debug, Serialize)]
struct Foretold {
    /// Over display white.
    tolerance: f64,
    /// Whether it is asked for.
    asked: bool,
    /// To plan it.
    plan_s: f64,
    /// Stages in their order.
    stages_s: Vec<(Stage, f64)>,
    /// All of it.
    seconds: f64,
}

/// Measures and prints, a line for each tolerance as soon as it is known; to plan the one that is asked for took `plan_s`.
///
/// # Errors
/// As those of a plan and of its stages.
pub(crate) fn print(
    (planned, plan_s): (&PlannedScene, f64),
    path: &Path,
    common: &Common,
) -> Result<(), Failure> {
    let asked = planned.plan.tolerance;
    let mut tolerances = TOLERANCES[TOLD].to_vec();
    if !tolerances.contains(&asked) {
        tolerances.push(asked);
        tolerances.sort_by(|a, b| b.total_cmp(a));
    }
    let mut names = STAGES.to_vec();
    names.retain(|stage| planned.plan.runs(*stage));
    if !common.json {
        let columns: Vec<String> = (names.iter())
            .map(|it| format!("{:>12}", it.name()))
            .collect();
        let columns = columns.concat();
        output::print(&format!(
            "{:>10}{:>8}{columns}{:>10}\n",
            "error", "plan", "seconds"
        ))?;
    }
    let mut all = Vec::new();
    for tolerance in tolerances {
        let start = Instant::now();
        let clock = || start.elapsed().as_secs_f64();
        let foretold = if tolerance == asked {
            Foretold::of((planned, plan_s), true)?
        } else {
            // Not that of the plan, which may have closer nodes of drops than another tolerance asks for.
            let scene = scene_file::at_tolerance(scene_file::read(path, common)?, tolerance);
            let planned = scene_file::planned(scene, path, common)?;
            Foretold::of((&planned, clock()), false)?
        };
        if !common.json {
            output::print(&foretold.line(&names))?;
        }
        all.push(foretold);
        if tolerance <= asked && clock() > LONG_S {
            break;
        }
    }
    if common.json {
        output::print(&in_form(common, &all, |_| String::new())?)?;
    }
    Ok(())
}

impl Foretold {
    /// Measures a scene that it took so many seconds to plan.
    fn of((planned, plan_s): (&PlannedScene, f64), asked: bool) -> Result<Self, Failure> {
        let start = Instant::now();
        let stages_s = stage_seconds(planned, &|| start.elapsed().as_secs_f64())?;
        let of_stages: f64 = stages_s.iter().map(|(_, seconds)| seconds).sum();
        Ok(Self {
            tolerance: planned.plan.tolerance,
            asked,
            plan_s,
            seconds: plan_s + of_stages,
            stages_s,
        })
    }

    fn line(&self, names: &[Stage]) -> String {
        let of_stage = |name: &Stage| {
            let found = self.stages_s.iter().find(|(stage, _)| stage == name);
            format!("{:>12.1}", found.map_or(0.0, |(_, seconds)| *seconds))
        };
        let columns: Vec<String> = names.iter().map(of_stage).collect();
        format!(
            "{:>10}{:>8.1}{}{:>10.1}{}\n",
            of_white(self.tolerance),
            self.plan_s,
            columns.concat(),
            self.seconds,
            if self.asked { "  as asked" } else { "" }
        )
    }
}
