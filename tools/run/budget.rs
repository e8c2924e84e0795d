//! A picture in the time that there is: which tolerance its tables have, and what was left out for the time.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::Instant;

use niji_picture::Afforded;
use niji_picture::Choice;
use niji_picture::Error;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::TOLERANCES;
use niji_picture::WRITTEN_BYTES_PER_S;
use niji_picture::table_seconds;
use niji_render::Clock;
use niji_render::Deadline;
use niji_scene::Scene;
use niji_scene::Stage;

use crate::failure::Failure;
use crate::flags::Common;
use crate::scene_file;
use crate::stages::Done;
use crate::stages::seconds_of;

/// Part of the time left that tables may take.
const FOR_TABLES: f64 = 0.5;

/// Part of the time after which nothing is measured any more.
const FOR_PLAN: f64 = 0.4;

/// Part of the time within which finer tables are asked about.
const FOR_SEARCH: f64 = 0.3;

/// A budget below gets the coarsest tolerance, seconds; above, the search begins at the third.
const SHORT_S: f64 = 5.0;
const FIRST: usize = 2;

/// Plans and tables of the next finer tolerance take at least so many times as long.
const LIKELY_TIMES: f64 = 1.5;

/// What comes after the rays besides writing the picture, seconds.
const LAST_S: f64 = 0.05;

/// A time to keep, from now on.
pub(crate) struct Budget {
    pub(super) seconds: f64,
    start: Instant,
}

impl Budget {
    /// The clock starts.
    pub(super) fn new(seconds: f64) -> Self {
        Self {
            seconds,
            start: Instant::now(),
        }
    }

    /// Seconds since the start.
    pub(super) fn elapsed_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// The scene with the finest tables that there is time for, or as in a run before with the same budget.
    pub(super) fn planned(
        &self,
        scene: &Scene,
        (path, common): (&Path, &Common),
        before: Option<&Choice>,
    ) -> Result<PlannedScene, Failure> {
        let scene = |tolerance: f64| scene_file::at_tolerance(scene.clone(), tolerance);
        let is_same = |it: &Afforded| it.budget_s == self.seconds;
        let same = before.and_then(|it| it.afforded).filter(is_same);
        if let Some(afforded) = same {
            let planned =
                scene_file::planned_as_before(scene(afforded.tolerance), path, (common, before))?;
            if planned.choice.afforded.is_some() {
                return Ok(planned);
            }
        }
        let clock = || self.elapsed_s();
        let allowed_s = || FOR_TABLES * (self.seconds - clock());
        let may_measure = || clock() < FOR_PLAN * self.seconds;
        let in_time = |_: Stage, _: f64| {
            if may_measure() {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        // With the seconds of its tables; nothing where there was no time to measure what it asks for.
        let tried = |index: usize, other: Option<&PlannedScene>| {
            if !may_measure() {
                return Ok(None);
            }
            let request = PlanRequest {
                measured: other.map(|it| &it.choice),
                watch: &in_time,
                ..scene_file::beside(path)
            };
            let planned = match PlannedScene::new(scene(TOLERANCES[index]), request) {
                Err(Error::Stopped) => return Ok(None),
                planned => planned.map_err(|error| scene_file::unplannable(path, error))?,
            };
            let tables_s = table_seconds(&planned, &clock)?;
            Ok::<_, Failure>(Some((planned, tables_s)))
        };
        let mut index = FIRST;
        let first = if self.seconds < SHORT_S {
            None
        } else {
            tried(index, None)?
        };
        // Where there is no time to ask.
        let unasked = |index: usize, other: Option<&PlannedScene>| {
            let request = PlanRequest {
                measured: other.map(|it| &it.choice),
                is_hasty: true,
                ..scene_file::beside(path)
            };
            scene_file::planned_for(scene(TOLERANCES[index]), path, request)
        };
        let Some((mut best, mut tables_s)) = first else {
            return unasked(0, None);
        };
        if tables_s > allowed_s() {
            while index > 0 && tables_s > allowed_s() {
                index -= 1;
                let Some(coarser) = tried(index, Some(&best))? else {
                    let is_near = tables_s < LIKELY_TIMES * allowed_s();
                    return unasked(if is_near { index } else { 0 }, Some(&best));
                };
                (best, tables_s) = coarser;
            }
            return Ok(best);
        }
        // What small pictures showed is not asked again: the second takes about as long as the first.
        let mut likely_s = clock();
        let may_ask = |likely_s| clock() + likely_s < FOR_SEARCH * self.seconds;
        while index + 1 < TOLERANCES.len()
            && may_ask(likely_s)
            && LIKELY_TIMES * tables_s < allowed_s()
        {
            index += 1;
            let start_s = clock();
            let Some(finer) = tried(index, Some(&best))?.filter(|it| it.1 <= allowed_s()) else {
                break;
            };
            likely_s = LIKELY_TIMES * (clock() - start_s);
            (best, tables_s) = finer;
        }
        Ok(best)
    }

    /// When the rays of a picture have to end.
    pub(super) fn deadline<'a>(&self, planned: &PlannedScene, now_s: Clock<'a>) -> Deadline<'a> {
        let mut stages = planned.plan.stages.iter();
        let picture = stages.find(|it| it.stage == Stage::Render);
        let bytes = picture.and_then(|it| it.estimate.file_bytes).unwrap_or(0);
        Deadline {
            now_s,
            end_s: self.seconds - LAST_S - bytes as f64 / WRITTEN_BYTES_PER_S,
        }
    }

    /// What a render afforded, with what the plan did.
    pub(super) fn afforded(
        &self,
        planned: &PlannedScene,
        rendered: niji_render::Afforded,
    ) -> Afforded {
        Afforded {
            budget_s: self.seconds,
            tolerance: planned.plan.tolerance,
            coarser_rays: rendered.coarser_rays,
            paths_per_node: rendered.paths_per_node,
        }
    }

    /// The time in words, with what took most of it where it was not enough.
    pub(super) fn text(&self, done: &[Done]) -> String {
        let (elapsed_s, asked_s) = (self.elapsed_s(), self.seconds);
        if elapsed_s <= asked_s {
            return format!("{elapsed_s:.1} s of {asked_s} s");
        }
        let longest = done.iter().max_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let decided_s = elapsed_s - seconds_of(done);
        let longest = match longest {
            Some(it) if it.seconds >= decided_s => {
                format!(": {} alone takes {:.1} s", it.stage, it.seconds)
            }
            _ => format!(": to decide what there is time for took {decided_s:.1} s"),
        };
        format!("{elapsed_s:.1} s, more than the {asked_s} s asked for{longest}")
    }
}

/// Seconds as people type them: `10s`, `2min`, `1.5`.
///
/// # Errors
/// What is no time above 0.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    let units = [("min", 60.0), ("m", 60.0), ("s", 1.0), ("", 1.0)];
    let found = units
        .iter()
        .find_map(|(unit, seconds)| Some((text.strip_suffix(unit)?, seconds)));
    let number = found.and_then(|(number, unit)| Some(number.trim().parse::<f64>().ok()? * unit));
    number
        .filter(|it| it.is_finite() && *it > 0.0)
        .ok_or_else(|| format!("found {text}, expected a time above 0, say 10s or 2min"))
}
