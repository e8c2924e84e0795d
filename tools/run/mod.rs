//! `niji run`: a whole scene, stage by stage, with every intermediate file left in a folder.

mod closing;
mod report;

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_exchange::SpectralImage;
use niji_photo::Finding;
use niji_scene::Stage;

use crate::check;
use crate::cli::Common;
use crate::failure::Failure;
use crate::output;
use crate::progress::Verbosity;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::render::Inputs;
use crate::sun::report::FindingText;

/// Make the picture of a scene, leaving every intermediate file.
///
/// Runs the stages that the plan calls for. A file whose request still fits is kept, so that a second
/// run says "up to date" and an interrupted one goes on; anything else that exists is refused
/// without --force.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji run data/scenes/paper-c-figure-3.toml -o out
  niji run scene.toml -o draft --accuracy draft

Leaves drops.vdb, airy.exr, scatter.exr, atmosphere.exr (where the plan needs them), image.exr,
image.rgb.exr, image.png and report.json; of a photograph also depth.exr, sun.json (with picks),
check.json and composite.png.")]
pub(crate) struct RunCommand {
    /// The scene.
    scene: PathBuf,
    /// The folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs a scene.
///
/// # Errors
/// A scene that is missing, wrong or without light, an output that exists, or whatever a stage
/// reports.
pub(crate) fn execute(command: &RunCommand, common: &Common) -> Result<(), Failure> {
    let planned = scene_file::load(&command.scene, common)?;
    planned.check_light()?;
    let folder = &command.output;
    if folder.exists() && !folder.is_dir() {
        let message = format!(
            "{} is a file, expected the name of a folder",
            folder.display()
        );
        return Err(Failure::Usage(message));
    }
    let manner = common.manner();
    let Outcome { done, findings } = run_stages(&planned, folder, manner)?;
    report::write(&planned, &done, folder)?;
    if manner.verbosity > Verbosity::Quiet {
        for warning in &planned.plan.warnings {
            eprintln!("    warning  {warning}");
        }
        for finding in findings.iter().map(FindingText::from) {
            eprint!("{}", finding.text());
        }
        closing::print(&planned.plan, &done)?;
        if done.iter().all(|done| done.up_to_date) {
            eprintln!("{}: everything is up to date", folder.display());
        }
    }
    let image = folder.join(stages::render::FILE);
    if common.json {
        output::print(&format!("{:#}\n", report::json(&planned, &done)))?;
    } else {
        let shown = match planned.scene.photo {
            Some(_) => folder.join(stages::photo::COMPOSITE),
            None => image.clone(),
        };
        output::print(&format!("{}\n", shown.display()))?;
    }
    // Everything is written by now, for whoever wants the impossible.
    check::verdict(&findings)?;
    common.tolerance.map_or(Ok(()), |tolerance| {
        check_accuracy(&planned, &image, tolerance)
    })
}

/// Half of a tolerance is for effects that are left out, half for levels: is the estimated error of
/// the picture, RMS over its pixels, within that half?
fn check_accuracy(planned: &Planned, image: &Path, tolerance: f64) -> Result<(), Failure> {
    let parts = SpectralImage::read_spectral(image).map_err(|e| Failure::bad_input(image, e))?;
    let error = parts.aovs.iter().find(|aov| aov.name == "error");
    let Some((_, errors)) = error.and_then(|aov| aov.channels.first()) else {
        return Ok(());
    };
    let squares: f64 = errors.iter().map(|&error| f64::from(error).powi(2)).sum();
    let reference = planned.plan.reference_luminance_cd_m2;
    let reached = (squares / errors.len().max(1) as f64).sqrt() / reference;
    if reached <= 0.5 * tolerance {
        return Ok(());
    }
    Err(Failure::AccuracyNotReached(format!(
        "the estimated error of the picture is {reached:.1e}, more than half of the tolerance \
         {tolerance:.1e}: take a more accurate preset (the picture was written)"
    )))
}

/// What the stages of a run did.
pub(crate) struct Outcome {
    /// The stages, in order.
    pub(crate) done: Vec<Done>,
    /// What nature would not do in a photograph.
    pub(crate) findings: Vec<Finding>,
}

/// Runs the stages of a plan in order.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn run_stages(
    planned: &Planned,
    folder: &Path,
    manner: Manner,
) -> Result<Outcome, Failure> {
    let (scene, plan) = (&planned.scene, &planned.plan);
    let inside = |name: &str| folder.join(name);
    let drops = planned
        .drop_file
        .clone()
        .unwrap_or_else(|| inside(stages::drops::FILE));
    let airy = inside(stages::airy::FILE);
    let table = inside(stages::scatter::FILE);
    let air = inside(stages::atmosphere::FILE);
    let surfaces = stages::photo::surfaces(planned, folder);
    let (mut done, mut findings) = (Vec::new(), Vec::new());
    for stage in &plan.stages {
        let outcome = match stage.stage {
            Stage::Drops => {
                let Some(source) = &planned.drop_source else {
                    continue;
                };
                stages::drops::make(source, niji_vdb::Compression::None, &drops, manner)
            }
            Stage::Airy => stages::airy::make(&airy, manner),
            Stage::Scatter => {
                let Some(need) = &plan.scattering else {
                    continue;
                };
                let wavelengths = scene.spectrum.grid();
                let wavelengths = wavelengths.map_err(|e| Failure::Failed(e.to_string()))?;
                stages::scatter::make(need, wavelengths, Some(&airy), &table, manner)
            }
            Stage::Atmosphere => stages::atmosphere::make(scene, &air, manner),
            stage @ (Stage::Depth | Stage::Sun | Stage::Check | Stage::Composite) => {
                let made = stages::photo::make(planned, stage, folder, manner);
                made.map(|(done, found)| {
                    findings.extend(found);
                    done
                })
            }
            Stage::Render => {
                let inputs = Inputs {
                    drops: &drops,
                    table: plan.runs(Stage::Scatter).then_some(table.as_path()),
                    air: plan.runs(Stage::Atmosphere).then_some(air.as_path()),
                    surfaces: surfaces.as_ref(),
                };
                let settings = stages::render::Settings::of(planned);
                stages::render::make(&settings, inputs, &inside(stages::render::FILE), manner)
            }
        };
        done.push(outcome?);
    }
    Ok(Outcome { done, findings })
}
