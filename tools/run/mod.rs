//! `niji run`: a whole scene, stage by stage, with every intermediate file left in a folder.

mod budget;
mod closing;
pub(crate) mod files;
mod frames;
pub(crate) mod report;

use std::collections::BTreeSet;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use niji_photo::Finding;
use niji_picture::Afforded;
use niji_picture::Choice;
use niji_picture::PictureSettings;
use niji_scene::Stage;

use crate::check;
use crate::checksums;
use crate::checksums::Found;
use crate::choice_file;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::output::Existing;
use crate::run::budget::Budget;
use crate::run::budget::parse_seconds;
use crate::run::files::Files;
use crate::scene_file;
use crate::stages;
use crate::stages::Done;
use crate::stages::StageOptions;
use crate::stages::accuracy;
use crate::stages::accuracy::Reached;
use crate::stages::given_table;
use crate::stages::render::Inputs;
use crate::stages::render::RenderStage;
use crate::stages::render::Target;
use crate::stages::scatter::TableInputs;
use crate::stages::seconds_of;
use crate::stages::tile::TilesOfMany;
use crate::stages::tile::parse_tiles;
use crate::sun::report::FindingText;
use niji_picture::PlannedScene;

/// Make the picture of a scene, leaving every intermediate file.
///
/// Runs the stages that the plan calls for. A file whose request still fits is kept, so that a second
/// run says "up to date" and an interrupted one goes on; after an edit what no longer fits is made anew, and where
/// only [picture] changed, how the image is shown. Files that are not as a run left them are refused without
/// --force, and with --choice all that do not fit.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji run data/scenes/paper-c-figure-3.toml -o out
  niji run scene.toml -o draft --accuracy draft
  niji run scene.toml -o out --tolerance 0.01
  niji run scene.toml -o out --table any-rain.exr
  niji run sequence.toml -o out --frames 1-240
  niji run sequence.toml -o out --frames 1-240 --until tables
  niji run sequence.toml -o out --frames 1-3,7,10-20:2 --choice out/choice.toml

Leaves drops.vdb, airy.exr, scatter.exr, atmosphere.exr (where the plan needs them), image.exr,
image.layers.exr, image.png, choice.toml and report.json; of a photograph also depth.exr, sun.json (with picks),
check.json and composite.png. Of a sequence, image.0001.exr, report.0001.json and so on, and without --choice in
report.json all of them; effects, levels and tables are decided once, in choice.toml, and frames share what they
need alike, as scatter.1a2b3c4d.exr.")]
pub(crate) struct RunCommand {
    /// The scene.
    scene: PathBuf,
    /// The folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// A finished scattering table in place of the scene's own: of the same water, wavelengths and theory,
    /// with at least the sizes, angles and orders that the plan asks for (see `niji scatter --radii-um`).
    #[arg(long, value_name = "EXR")]
    table: Option<PathBuf>,
    /// Make the best picture in a time, as 10s or 2min: the tolerance of its tables, rays and paths follow from the
    /// time they take on this machine. What was settled goes into choice.toml; with it as --choice any machine makes
    /// the same picture.
    #[arg(long, value_name = "TIME", value_parser = parse_seconds)]
    #[arg(conflicts_with_all = ["tolerance", "accuracy", "choice", "frames"])]
    budget: Option<f64>,
    /// The frames of a sequence to make, as 12, 1-240 or 1-3,7,10-20:2 (from 10 to 20 every second one); what
    /// changes from frame to frame stands in the scene's section [sequence] and in file names with ####.
    /// Values lie between those given as numbers do, angles too: a turn over north is from 350 to 370 degrees.
    #[arg(long, value_name = "LIST", value_parser = FrameList::parse)]
    frames: Option<FrameList>,
    /// Make tiles of each picture only, I of N from 1 or I to J: bands of rows from the top, in a folder of DIR/tiles;
    /// `niji merge DIR` puts them together.
    #[arg(long, value_name = "I-J/N", value_parser = parse_tiles, conflicts_with = "budget")]
    tiles: Option<TilesOfMany>,
    /// Decide, and make the tables that frames share, but no picture: then frames can be made with --choice
    /// DIR/choice.toml in any number of processes, with the bytes of one.
    #[arg(long, value_name = "WHAT", conflicts_with_all = ["budget", "tiles"])]
    until: Option<Until>,
}

impl RunCommand {
    /// The whole picture of a scene.
    pub(crate) fn of(scene: PathBuf, output: PathBuf) -> Self {
        Self {
            scene,
            output,
            table: None,
            budget: None,
            frames: None,
            tiles: None,
            until: None,
        }
    }
}

/// The last of what is made.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Until {
    /// What was decided, and the tables of drops and air, which frames share; no picture.
    Tables,
}

/// Runs a scene.
///
/// # Errors
/// A scene that is missing, wrong or without light, an output that exists, or whatever a stage
/// reports.
pub(crate) fn execute(command: &RunCommand, common: &Common) -> Result<(), Failure> {
    let folder = &command.output;
    if folder.exists() && !folder.is_dir() {
        let message = format!(
            "{} is a file, expected the name of a folder",
            folder.display()
        );
        return Err(Failure::Usage(message));
    }
    report::check_own(folder, None, common.options_of_run().existing)?;
    if let Some(frames) = &command.frames {
        return frames::execute(command, frames, common);
    }
    let kept = folder.join(choice_file::FILE);
    let budget = command.budget.map(Budget::new);
    let start = Instant::now();
    let mut planned = planned(command, (common, budget.as_ref()), &kept)?;
    let decided_s = start.elapsed().as_secs_f64();
    planned.check()?;
    if let Some(photo) = &planned.scene.photo {
        let picture = planned.folder.join(&photo.picture);
        stages::photo::check_no_input(folder, &[&picture])?;
    }
    if planned.scene.photo.is_some() && command.tiles.is_some() {
        let message = "--tiles is of a picture that is rendered: leave it out for a photograph";
        return Err(Failure::Usage(message.to_owned()));
    }
    let options = common.options_of_run();
    let given = given_table::given(&planned, command.table.as_deref(), options.verbosity)?;
    let files = Files::of_scene(&planned, folder)
        .with_table(given)
        .with_tiles(command.tiles.as_ref());
    if command.until.is_some() {
        choice_file::write(&planned.choice, &kept, Existing::Replace)?;
        let done = tables(planned, &files, options)?;
        return told(&done, common);
    }
    if files.tiles.is_some() {
        choice_file::write(&planned.choice, &kept, Existing::Replace)?;
        run_stages_to((&planned, None), &files, options)?;
        return output::print(&format!("{}\n", files.picture().display()));
    }
    let Outcome {
        done,
        findings,
        afforded,
    } = run_stages_to((&planned, budget.as_ref()), &files, options)?;
    planned.choice.afforded = afforded;
    let image = folder.join(stages::render::FILE);
    let reached = accuracy::reached(&planned, &image)?;
    choice_file::write(&planned.choice, &kept, Existing::Replace)?;
    let total_s = decided_s + seconds_of(&done);
    let cheaper = reached
        .as_ref()
        .map(|it| accuracy::cheaper(&planned, (&done, total_s), it));
    let cheaper = cheaper.unwrap_or_default();
    let report = report::json(&planned, (decided_s, &done), (reached.as_ref(), &cheaper));
    report::write(&report, folder, None)?;
    let verbosity = options.verbosity;
    let plan = planned.plan_as_shown();
    for warning in &plan.warnings {
        verbosity.warn(warning);
    }
    for finding in findings.iter().map(FindingText::from) {
        verbosity.say(finding.text().trim_end());
    }
    verbosity.say(closing::text(
        &plan,
        (&done, reached.as_ref()),
        (decided_s, budget.as_ref()),
    ));
    for line in &cheaper {
        verbosity.say(line.text());
    }
    if let Some(line) = closing::exposure(&planned, &done) {
        verbosity.say(line);
    }
    let too_much = reached.as_ref().and_then(Reached::too_much);
    // Of a tolerance on the command line it is an error, which names its cause.
    if let (Some(cause), None, None) = (too_much, common.tolerance, &budget) {
        verbosity.say(format_args!("most of it from {cause}"));
    }
    if done.iter().all(|done| done.up_to_date) {
        verbosity.say(format_args!(
            "{}: everything is up to date",
            folder.display()
        ));
    }
    if common.json {
        output::print(&format!("{report:#}\n"))?;
    } else {
        let shown = match planned.scene.photo {
            Some(_) => folder.join(stages::photo::COMPOSITE),
            None => image.clone(),
        };
        output::print(&format!("{}\n", shown.display()))?;
    }
    // Everything is written by now, for whoever wants the impossible.
    check::verdict(&findings)?;
    let asked = reached.filter(|_| common.tolerance.is_some());
    asked.map_or(Ok(()), |reached| reached.verdict())
}

/// The scene with its plan, decided as in a run before, whose choice is `kept`, where that was the same one.
fn planned(
    command: &RunCommand,
    (common, budget): (&Common, Option<&Budget>),
    kept: &Path,
) -> Result<PlannedScene, Failure> {
    let before: Option<Choice> = choice_file::kept(kept, common.options_of_run().existing)?;
    let scene = scene_file::read(&command.scene, common)?;
    if scene.sequence.is_some() {
        return Err(Failure::Usage(format!(
            "{} is a sequence: say which frames with --frames, as 1-240 or 12",
            command.scene.display()
        )));
    }
    if common.choice.is_some() {
        return scene_file::as_asked(scene, &command.scene, common);
    }
    if let Some(budget) = budget {
        return budget.planned(&scene, (&command.scene, common), before.as_ref());
    }
    // Without a budget nothing is left out for one, nor left unmeasured.
    let before = before.filter(|it| it.afforded.is_none());
    let path = &command.scene;
    let planned = scene_file::planned_as_before(scene.clone(), path, (common, before.as_ref()))?;
    if planned.shown == planned.scene.picture || serves(&planned, kept)? {
        return Ok(planned);
    }
    scene_file::planned(scene, path, common)
}

/// Does the picture of a run before, whose choice is `kept`, keep the tolerance as it is shown now?
fn serves(planned: &PlannedScene, kept: &Path) -> Result<bool, Failure> {
    let image = kept.with_file_name(stages::render::FILE);
    if checksums::found(&image, false) != Found::Whole {
        return Ok(false);
    }
    let reached = accuracy::reached(planned, &image)?;
    Ok(reached.is_some_and(|it| it.too_much().is_none()))
}

/// Makes the tables of a plan, and nothing else.
fn tables(
    mut planned: PlannedScene,
    files: &Files,
    options: StageOptions,
) -> Result<Vec<Done>, Failure> {
    let of_tables = [Stage::Airy, Stage::Scatter, Stage::Atmosphere];
    let stages = &mut planned.plan.stages;
    stages.retain(|it| of_tables.contains(&it.stage));
    Ok(run_stages_to((&planned, None), files, options)?.done)
}

/// Tells the files that were made, or as JSON all about them.
fn told(done: &[Done], common: &Common) -> Result<(), Failure> {
    if common.json {
        return output::print(&format!("{:#}\n", serde_json::json!({ "stages": done })));
    }
    let files: BTreeSet<&String> = done.iter().flat_map(|it| &it.files).collect();
    let files = files.into_iter().map(|file| format!("{file}\n"));
    output::print(&files.collect::<String>())
}

/// What the stages of a run did.
pub(crate) struct Outcome {
    /// The stages, in order.
    pub(crate) done: Vec<Done>,
    /// What nature would not do in a photograph.
    pub(crate) findings: Vec<Finding>,
    /// What there was time for, where there was a budget.
    afforded: Option<Afforded>,
}

/// Runs the stages of a plan in order.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn run_stages(
    planned: &PlannedScene,
    folder: &Path,
    options: StageOptions,
) -> Result<Outcome, Failure> {
    run_stages_to((planned, None), &Files::of_scene(planned, folder), options)
}

/// As [`run_stages`], with a name for each file and the time there is.
///
/// # Errors
/// As [`run_stages`].
fn run_stages_to(
    (planned, budget): (&PlannedScene, Option<&Budget>),
    files: &Files,
    options: StageOptions,
) -> Result<Outcome, Failure> {
    let mut afforded = planned.choice.afforded;
    let (scene, plan) = (&planned.scene, &planned.plan);
    let Files {
        folder,
        drops,
        airy,
        table,
        is_table_given,
        air,
        ..
    } = files;
    let surfaces = stages::photo::surfaces(planned, folder);
    let (mut done, mut findings) = (Vec::new(), Vec::new());
    for stage in &plan.stages {
        let outcome = match stage.stage {
            Stage::Drops => {
                let Some(source) = &planned.drop_source else {
                    continue;
                };
                stages::drops::make(source, niji_vdb::Compression::None, drops, options)
            }
            Stage::Airy | Stage::Scatter if *is_table_given => continue,
            Stage::Airy => stages::airy::make(airy, options),
            Stage::Scatter => {
                let Some(need) = &plan.scattering else {
                    continue;
                };
                let made_from = TableInputs {
                    need,
                    wavelengths: scene.spectrum,
                    airy: Some(airy),
                };
                stages::scatter::make(made_from, table, options)
            }
            Stage::Atmosphere => {
                let orders = plan.scattering_orders();
                stages::atmosphere::make((scene, orders), air, options)
            }
            stage @ (Stage::Depth | Stage::Sun | Stage::Check | Stage::Composite) => {
                let made = stages::photo::make(planned, stage, folder, options);
                made.map(|(done, found)| {
                    findings.extend(found);
                    done
                })
            }
            Stage::Render => {
                let inputs = Inputs {
                    drops,
                    table: plan.runs(Stage::Scatter).then_some(table.as_path()),
                    air: plan.runs(Stage::Atmosphere).then_some(air.as_path()),
                    surfaces: &surfaces,
                };
                let settings = PictureSettings::of(planned);
                for (path, region) in files.targets(settings.whole()?)? {
                    let stage = RenderStage {
                        settings: &settings,
                        inputs,
                        target: Target {
                            path: &path,
                            region,
                        },
                    };
                    done.push(match budget.filter(|_| afforded.is_none()) {
                        None => stages::render::make(stage, options)?,
                        Some(budget) => {
                            let clock = || budget.elapsed_s();
                            let deadline = budget.deadline(planned, &clock);
                            let (done, rendered) =
                                stages::render::make_until(stage, deadline, options)?;
                            afforded = Some(budget.afforded(planned, rendered));
                            done
                        }
                    });
                }
                continue;
            }
        };
        done.push(outcome?);
    }
    Ok(Outcome {
        done,
        findings,
        afforded,
    })
}
