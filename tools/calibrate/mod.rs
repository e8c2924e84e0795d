//! `niji calibrate`: what each level of accuracy costs and how wrong it is, measured.
//!
//! One decision at a time: every level of it is rendered with all others at the preset, and compared
//! with its best level. error = RMSE of spectral radiance / RMS of the best one; time = that of the
//! stage that the decision belongs to, over the preset's level, best of repeated runs.

mod air;
mod ice;
mod theories;

use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use niji_dropfield::Interpolation;
use niji_exchange::SpectralImage;
use niji_render::AirPath;
use niji_render::DropExtinctionModel;
use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_render::SunPath;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::MeasuredLevel;
use niji_scene::Stage;
use serde::Serialize;

use crate::cli::Common;
use crate::failure::Failure;
use crate::output;
use crate::output::Existing;
use crate::progress;
use crate::progress::Verbosity;
use crate::run::run_stages;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::Done;
use crate::stages::Manner;

/// Runs of each level; the fastest counts, because other programs only ever slow one down.
const N_REPEATS: usize = 3;

/// Measure error and time of every accuracy level.
///
/// The CSV has the columns stage, level, scene, error, relative_time, seconds, date; plans and the
/// table at the end of a run read it when the program is built. With --theories: error against time
/// of the theories of one drop by radius, for both bows, against the exact order and the exact light.
/// With --air: of the methods for lengths, segments and skies of air, against converged quadrature.
/// With --ice: of the levels of light through ice, against many more paths.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji calibrate data/scenes/paper-c-figure-3.toml data/scenes/paper-b-sun-10-inscatter.toml \\
      --date 2026-11-21 -o data/measurements/levels.csv --force
  niji calibrate --theories --date 2026-11-21 -o data/measurements/theories.csv --force
  niji calibrate --air --date 2026-11-21 -o data/measurements/air.csv --force
  niji calibrate --ice --date 2026-11-21 -o data/measurements/ice.csv --force")]
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
    /// Day of the measurement, written into the file.
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: String,
    /// The file to write.
    #[arg(short, long, value_name = "CSV")]
    output: PathBuf,
}

/// A level of one decision, put in place of the preset's.
type Change = fn(&mut Accuracy, f64);

/// A decision, the stage it costs time in, and its levels with the best one last.
struct Decision {
    key: &'static str,
    stage: Stage,
    needs_air: bool,
    levels: &'static [Change],
}

/// Every decision. The second argument of a change is the edge of a voxel in metres.
const DECISIONS: [Decision; 9] = [
    Decision {
        key: "theory",
        stage: Stage::Scatter,
        needs_air: false,
        levels: &[
            |a, _| {
                a.theory = Some(Theory::Geometric);
            },
            |a, _| {
                a.theory = Some(Theory::AiryPublished);
            },
            |a, _| {
                a.theory = Some(Theory::Airy);
            },
            |a, _| {
                a.theory = Some(Theory::Uniform);
            },
            |a, _| {
                a.theory = Some(Theory::Debye { max_order: 7 });
            },
            |a, _| {
                a.theory = Some(Theory::Mie);
            },
        ],
    },
    Decision {
        key: "table_relative_error",
        stage: Stage::Scatter,
        needs_air: false,
        levels: &[
            |a, _| {
                a.table_relative_error = Some(2e-2);
            },
            |a, _| {
                a.table_relative_error = Some(5e-3);
            },
            |a, _| {
                a.table_relative_error = Some(2e-4);
            },
        ],
    },
    Decision {
        key: "integration",
        stage: Stage::Render,
        needs_air: false,
        levels: &[
            |a, voxel_m| {
                a.integration = Some(Integration::FixedStep {
                    step_m: 2.0 * voxel_m,
                });
            },
            |a, voxel_m| {
                a.integration = Some(Integration::FixedStep {
                    step_m: 0.25 * voxel_m,
                });
            },
            |a, _| {
                a.integration = Some(Integration::Adaptive {
                    relative_error: 1e-2,
                });
            },
            |a, _| {
                a.integration = Some(Integration::CellExact);
            },
            |a, _| {
                a.integration = Some(Integration::Adaptive {
                    relative_error: 1e-6,
                });
            },
        ],
    },
    Decision {
        key: "interpolation",
        stage: Stage::Render,
        needs_air: false,
        levels: &[
            |a, _| {
                a.interpolation = Some(Interpolation::RadiusDensity);
            },
            |a, _| {
                a.interpolation = Some(Interpolation::Moments);
            },
        ],
    },
    Decision {
        key: "drop_extinction",
        stage: Stage::Render,
        needs_air: false,
        levels: &[
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::Full);
            },
            |a, _| {
                a.drop_extinction = Some(DropExtinctionModel::WithoutDiffraction);
            },
        ],
    },
    Decision {
        key: "sun_path",
        stage: Stage::Render,
        needs_air: false,
        levels: &[
            |a, _| {
                a.sun_path = Some(SunPath::Ignore);
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::Volume {
                    voxel_m: 2.0 * voxel_m,
                });
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::Volume { voxel_m });
            },
            |a, voxel_m| {
                a.sun_path = Some(SunPath::March {
                    step_m: 0.5 * voxel_m,
                });
            },
        ],
    },
    Decision {
        key: "air_path",
        stage: Stage::Render,
        needs_air: true,
        levels: &[
            |a, _| {
                a.air_path = Some(AirPath::Constant);
            },
            |a, _| {
                a.air_path = Some(AirPath::Midpoint { n_steps: 50 });
            },
            |a, _| {
                a.air_path = Some(AirPath::Table);
            },
            |a, _| {
                a.air_path = Some(AirPath::Quadrature { n_nodes: 32 });
            },
        ],
    },
    Decision {
        key: "sky",
        stage: Stage::Render,
        needs_air: true,
        levels: &[
            |a, _| {
                a.sky = Some(SkyModel::None);
            },
            |a, _| {
                a.sky = Some(SkyModel::SingleScattering);
            },
            |a, _| {
                a.sky = Some(SkyModel::MultipleScattering);
            },
        ],
    },
    Decision {
        key: "pixel_footprint",
        stage: Stage::Render,
        needs_air: false,
        levels: &[
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Center);
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Prefiltered);
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Grid { n: 2 });
            },
            |a, _| {
                a.pixel_footprint = Some(PixelFootprint::Grid { n: 4 });
            },
        ],
    },
];

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

fn write_csv(rows: &[impl Serialize], path: &Path) -> Result<(), Failure> {
    output::write_file(path, |writer| {
        let mut csv = csv::Writer::from_writer(writer);
        for row in rows {
            csv.serialize(row).map_err(|error| error.to_string())?;
        }
        csv.flush().map_err(|error| error.to_string())
    })?;
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
    seconds: f64,
    image: SpectralImage,
}

impl Calibration<'_> {
    fn row(&self, planned: &Planned, stage: &str, level: &str) -> MeasuredLevel {
        MeasuredLevel {
            stage: stage.to_owned(),
            level: level.to_owned(),
            scene: planned.scene.name.clone(),
            error: None,
            relative_time: None,
            seconds: None,
            date: self.date.to_owned(),
        }
    }

    /// Times of the stages with every level as the scene has it.
    fn totals(&self) -> Result<Vec<MeasuredLevel>, Failure> {
        let planned = scene_file::load(self.path, self.common)?;
        let (done, _) = run(&planned, N_REPEATS)?;
        let total = |done: &Done| MeasuredLevel {
            seconds: Some(rounded(done.seconds)),
            ..self.row(&planned, done.stage, "total")
        };
        Ok(done.iter().map(total).collect())
    }

    fn decision(&self, decision: &Decision) -> Result<Vec<MeasuredLevel>, Failure> {
        let base = scene_file::load(self.path, self.common)?;
        let in_vacuum = base.scene.air.is_none();
        let has_table = base.plan.runs(Stage::Scatter);
        if (decision.needs_air && in_vacuum) || (decision.stage == Stage::Scatter && !has_table) {
            return Ok(Vec::new());
        }
        let named = base.plan.levels.named();
        let standard = named.into_iter().find(|(key, _)| key == decision.key);
        let standard = standard.map(|(_, level)| level).unwrap_or_default();
        let mut measured = Vec::new();
        for change in decision.levels {
            measured.push(self.level(decision, *change)?);
        }
        let Some(best) = measured.last() else {
            return Ok(Vec::new());
        };
        let standard_seconds = measured
            .iter()
            .find(|level| level.level == standard)
            .map(|level| level.seconds);
        let rows = measured.iter().map(|level| MeasuredLevel {
            error: Some(rounded(relative_rmse(&level.image, &best.image))),
            relative_time: standard_seconds.map(|standard| rounded(level.seconds / standard)),
            seconds: Some(rounded(level.seconds)),
            ..self.row(&base, decision.key, &level.level)
        });
        Ok(rows.collect())
    }

    fn level(&self, decision: &Decision, change: Change) -> Result<Measured, Failure> {
        let mut scene = scene_file::read(self.path, self.common)?;
        let voxel_m = scene
            .drops
            .shape()
            .map_or(1.0, |shape| shape.grid().voxel_m);
        change(&mut scene.accuracy, voxel_m);
        let planned = scene_file::planned(scene, self.path)?;
        let named = planned.plan.levels.named();
        let level = named.into_iter().find(|(key, _)| key == decision.key);
        let (done, image) = run(&planned, N_REPEATS)?;
        let of_stage = done.iter().find(|done| done.stage == decision.stage.name());
        Ok(Measured {
            level: level.map(|(_, level)| level).unwrap_or_default(),
            seconds: of_stage.map_or(0.0, |done| done.seconds),
            image,
        })
    }
}

/// Runs a plan from nothing several times: the fastest time of each stage, and the picture.
fn run(planned: &Planned, n_repeats: usize) -> Result<(Vec<Done>, SpectralImage), Failure> {
    let manner = Manner {
        existing: Existing::Refuse,
        verbosity: Verbosity::Quiet,
    };
    let mut fastest: Vec<Done> = Vec::new();
    let mut image = None;
    let start = Instant::now();
    for repeat in 0..n_repeats {
        let folder = tempfile::tempdir().map_err(|error| Failure::Failed(error.to_string()))?;
        let done = run_stages(planned, folder.path(), manner)?.done;
        for (index, stage) in done.into_iter().enumerate() {
            match fastest.get_mut(index) {
                Some(best) => best.seconds = best.seconds.min(stage.seconds),
                None => fastest.push(stage),
            }
        }
        if repeat == 0 {
            let path = folder.path().join(stages::render::FILE);
            let read = SpectralImage::read_spectral(&path);
            image = Some(read.map_err(|error| Failure::bad_input(&path, error))?);
        }
        // Long runs are less noisy, and their repeats cost the most.
        if start.elapsed().as_secs_f64() > 5.0 {
            break;
        }
    }
    let image = image.ok_or_else(|| Failure::Failed("nothing was run".to_owned()))?;
    Ok((fastest, image))
}

/// RMSE over the RMS of the reference.
fn relative_rmse(image: &SpectralImage, reference: &SpectralImage) -> f64 {
    let (mut squares, mut total) = (0.0, 0.0);
    for (&value, &expected) in image.radiance.iter().zip(&reference.radiance) {
        squares += f64::from(value - expected).powi(2);
        total += f64::from(expected).powi(2);
    }
    if total > 0.0 {
        (squares / total).sqrt()
    } else {
        0.0
    }
}

/// Three digits: more would be noise.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
