//! `niji calibrate`: what each level of accuracy costs and how wrong it is, measured.
//!
//! One decision at a time: every level of it is rendered with all others at the preset, and compared
//! with its yardstick, or with its best level. error = RMSE of spectral radiance / RMS of that one;
//! time = that of the stage that the decision belongs to, over the preset's level, best of repeated runs.

mod air;
mod ice;
mod theories;
mod tolerances;

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_exchange::SpectralImage;
use niji_scene::Change;
use niji_scene::DECISIONS;
use niji_scene::Decision;
use niji_scene::MeasuredLevel;
use niji_scene::Plan;
use niji_scene::Stage;
use niji_scene::light_of;
use serde::Serialize;

use crate::cli::Common;
use crate::cli::numbers;
use crate::failure::Failure;
use crate::measure_effects::measure;
use crate::output;
use crate::progress;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages::Done;
use crate::timed_run::luminance_rmse;
use crate::timed_run::relative_rmse;
use crate::timed_run::rounded;
use crate::timed_run::timed_run;

/// Measure error and time of every accuracy level.
///
/// The CSV has the columns stage, level, scene, error, relative_time, seconds, date; plans and the
/// table at the end of a run read it when the program is built. With --theories: error against time
/// of the theories of one drop by radius, for both bows, against the exact order and the exact light.
/// With --air: of the methods for lengths, segments and skies of air, against converged quadrature.
/// With --ice: of the levels of light through ice, against many more paths. With --tolerances: how far
/// pictures with the levels chosen for a tolerance are from the reference levels. With --effects: what
/// switching every effect over changes, as `niji plan --measure`, beside its bound.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji calibrate data/measurements/calibration-fog.toml data/measurements/calibration-rain.toml \\
      --date 2026-11-21 -o data/measurements/levels.csv --force
  niji calibrate --tolerances 0.003,0.01,0.03 data/scenes/garden-fountain.toml \\
      --date 2026-11-21 -o tolerances.csv
  niji calibrate --effects data/scenes/moonbow.toml --date 2026-11-22 -o bounds.csv
  niji calibrate --theories --date 2026-11-21 -o data/measurements/theories.csv --force
  niji calibrate --air --date 2026-11-21 -o data/measurements/air.csv --force
  niji calibrate --ice --date 2026-11-21 -o data/measurements/ice.csv --force")]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
pub(crate) struct CalibrateCommand {
    /// The scenes to measure on.
    #[arg(required_unless_present_any = ["theories", "air", "ice"])]
    scenes: Vec<PathBuf>,
    /// Measure the theories of one drop instead.
    #[arg(long, conflicts_with = "scenes")]
    theories: bool,
    /// Measure the methods of the air instead.
    #[arg(long, conflicts_with_all = ["scenes", "theories"])]
    air: bool,
    /// Measure the levels of light through ice instead.
    #[arg(long, conflicts_with_all = ["scenes", "theories", "air"])]
    ice: bool,
    /// Ask the scenes, made small, for these tolerances, and compare with the reference levels instead.
    #[arg(long, value_name = "T,T,…", value_parser = numbers, requires = "scenes")]
    tolerances: Option<std::vec::Vec<f64>>,
    /// Measure what every effect of the scenes changes, beside its bound, instead.
    #[arg(long, requires = "scenes", conflicts_with = "tolerances")]
    effects: bool,
    /// Day of the measurement, written into the file.
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: String,
    /// The file to write.
    #[arg(short, long, value_name = "CSV")]
    output: PathBuf,
}

/// Measures and writes the file.
///
/// # Errors
/// A scene that cannot be run, or an output that exists or cannot be written.
pub(crate) fn execute(command: &CalibrateCommand, common: &Common) -> Result<(), Failure> {
    let manner = common.manner();
    output::check_free(&command.output, manner.existing)?;
    if command.theories {
        let rows = theories::rows(&command.date, manner.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    if command.air {
        let rows = air::rows(&command.date, manner.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    if command.ice {
        let rows = ice::rows(&command.date, manner.verbosity)?;
        return write_csv(&rows, &command.output);
    }
    if command.effects {
        let mut rows = Vec::new();
        for path in &command.scenes {
            let measured = measure(&scene_file::load(path, common)?, manner.verbosity)?;
            rows.extend(measured.rows(&command.date));
        }
        return write_csv(&rows, &command.output);
    }
    if let Some(tolerances) = &command.tolerances {
        let rows = tolerances::rows(&command.scenes, tolerances, (&command.date, common))?;
        return write_csv(&rows, &command.output);
    }
    let n_levels: usize = DECISIONS.iter().map(|decision| decision.levels.len()).sum();
    let n_steps = (n_levels + 1) * command.scenes.len();
    let bar = progress::bar("calibrate", n_steps as u64, manner.verbosity);
    let mut rows = Vec::new();
    for path in &command.scenes {
        let scene = Calibration {
            path,
            common,
            date: &command.date,
        };
        rows.extend(scene.totals()?);
        bar.inc(1);
        for decision in &DECISIONS {
            rows.extend(scene.decision(decision)?);
            bar.inc(decision.levels.len() as u64);
        }
    }
    bar.finish_and_clear();
    write_csv(&rows, &command.output)
}

/// The work of a stage at the levels of a plan.
fn of_stage(plan: &Plan, stage: Stage) -> Option<f64> {
    plan.work.of_stage(stage, &plan.levels).map(rounded)
}

fn write_csv(rows: &[impl Serialize], path: &Path) -> Result<(), Failure> {
    output::write_csv(path, rows)?;
    output::print(&format!("{}\n", path.display()))
}

/// One scene to measure on.
struct Calibration<'a> {
    path: &'a Path,
    common: &'a Common,
    date: &'a str,
}

/// One level, rendered.
struct Measured {
    level: String,
    stages: Vec<Done>,
    image: SpectralImage,
}

impl Measured {
    fn seconds(&self, stage: Stage) -> f64 {
        let done = self.stages.iter().find(|done| done.stage == stage.name());
        done.map_or(0.0, |done| done.seconds)
    }
}

impl Calibration<'_> {
    fn row(&self, planned: &Planned, stage: &str, level: &str) -> MeasuredLevel {
        MeasuredLevel {
            stage: stage.to_owned(),
            level: level.to_owned(),
            scene: planned.scene.name.clone(),
            radius_um: Some(planned.plan.work.smallest_radius_um),
            date: self.date.to_owned(),
            ..MeasuredLevel::default()
        }
    }

    /// Times of the stages with every level as the scene has it.
    fn totals(&self) -> Result<Vec<MeasuredLevel>, Failure> {
        let planned = scene_file::load(self.path, self.common)?;
        let (done, _) = timed_run(&planned)?;
        let stages = planned.plan.stages.iter().map(|planned| planned.stage);
        let timed = stages.filter_map(|stage| {
            let done = done.iter().find(|done| done.stage == stage.name())?;
            Some(MeasuredLevel {
                seconds: Some(rounded(done.seconds)),
                work: of_stage(&planned.plan, stage),
                ..self.row(&planned, stage.name(), "total")
            })
        });
        Ok(timed.collect())
    }

    fn decision(&self, decision: &Decision) -> Result<Vec<MeasuredLevel>, Failure> {
        let base = scene_file::load(self.path, self.common)?;
        if !decision.concerns(&base.scene, &base.plan) {
            return Ok(Vec::new());
        }
        let plan = &base.plan;
        let standard = decision.measured_name(&plan.levels, plan.work.voxel_m);
        let mut measured = Vec::new();
        for change in decision.levels_for(plan) {
            measured.push(self.level(decision, (change, &base))?);
        }
        let yardstick = decision
            .yardstick
            .map(|change| self.level(decision, (change, &base)))
            .transpose()?;
        let Some(best) = yardstick.as_ref().or(measured.last()) else {
            return Ok(Vec::new());
        };
        let seconds = |level: &Measured| level.seconds(decision.stage);
        let standard_seconds = measured
            .iter()
            .find(|level| level.level == standard)
            .map(seconds);
        let light = rounded(light_of(decision, plan));
        let rows = measured.iter().map(|level| MeasuredLevel {
            error: Some(rounded(relative_rmse(
                &level.image.radiance,
                &best.image.radiance,
            ))),
            luminance_error: Some(rounded(
                luminance_rmse(&level.image, &best.image) / plan.reference_luminance_cd_m2,
            )),
            light: Some(light),
            relative_time: standard_seconds.map(|standard| rounded(seconds(level) / standard)),
            seconds: Some(rounded(seconds(level))),
            ..self.row(&base, decision.key, &level.level)
        });
        let of_table = |stage: Stage| {
            let rows = measured.iter().map(move |level| (stage, level));
            rows.map(|(stage, level)| MeasuredLevel {
                seconds: Some(rounded(level.seconds(stage))),
                work: of_stage(plan, stage),
                ..self.row(&base, stage.name(), &level.level)
            })
        };
        let tables = decision.table.into_iter().flat_map(of_table);
        Ok(rows.chain(tables).collect())
    }

    fn level(
        &self,
        decision: &Decision,
        (change, base): (Change, &Planned),
    ) -> Result<Measured, Failure> {
        let mut scene = base.scene.clone();
        let voxel_m = base.plan.work.voxel_m;
        change(&mut scene.accuracy, voxel_m);
        let planned = scene_file::planned(scene, self.path)?;
        let (stages, image) = timed_run(&planned)?;
        Ok(Measured {
            level: decision.measured_name(&planned.plan.levels, voxel_m),
            stages,
            image,
        })
    }
}
