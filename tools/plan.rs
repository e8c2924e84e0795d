//! `niji plan`: what a scene calls for, before anything runs.

use std::fmt::Write as _;
use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use niji_scene::Effect;
use niji_scene::Explanation;
use niji_scene::Plan;
use niji_scene::Stage;
use serde::Serialize;

use crate::bow_place;
use crate::choice_file;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::measure_effects::MeasuredEffects;
use crate::measure_effects::measure;
use crate::output;
use crate::plan_preview;
use crate::plan_seconds;
use crate::scene_file;
use crate::sequence_file::SequenceFile;
use crate::sequence_file::refuse_shutter;
use crate::shell_word::quoted;
use crate::stages;
use niji_picture::PlannedScene;

/// Say which effects and stages a scene calls for, and why.
///
/// Nothing is run. Every effect has a bound on what it can contribute; those that are off say what
/// leaving them out can cost.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji plan data/scenes/garden-fountain.toml
  niji plan data/scenes/rain-cell-8-km.toml --explain air_inscatter
  niji plan data/scenes/garden-fountain.toml --measure
  niji plan data/scenes/rain-cell.toml --seconds
  niji plan data/scenes/reflection-bow.toml --preview where.png
  niji plan scene.toml -o choice.toml && niji run scene.toml --choice choice.toml -o out
  niji plan sequence.toml --frames 1-240 -o choice.toml
  niji plan scene.toml --script -o out > chain.sh && sh chain.sh")]
pub(crate) struct PlanCommand {
    /// The scene.
    scene: PathBuf,
    /// Print the chain of stage commands instead; it gives the bytes of `niji run`.
    #[arg(long, conflicts_with = "json")]
    script: bool,
    /// Say what an effect is, how its bound comes about, and what switching it over would do; `all`
    /// lists every effect.
    #[arg(long, value_name = "EFFECT", conflicts_with = "script")]
    explain: Option<String>,
    /// Make a small picture (96 pixels wide) with every effect switched over in turn, and print bounds
    /// beside changes and times.
    #[arg(long, conflicts_with_all = ["script", "explain"])]
    measure: bool,
    /// Say how long a run will take on this machine, stage by stage, for several tolerances: by making a part of each
    /// stage, in seconds.
    #[arg(long, conflicts_with_all = ["script", "explain", "measure"])]
    seconds: bool,
    /// Decide for these frames of a sequence, as 1-240, and for all others of it: once for the whole sequence, from
    /// first, last and some frames between.
    #[arg(long, value_name = "LIST", value_parser = FrameList::parse)]
    #[arg(conflicts_with_all = ["script", "explain", "measure", "seconds"])]
    frames: Option<FrameList>,
    /// Write what was decided to a file for `--choice` instead; with --script the folder that the chain writes to
    /// [default: out].
    #[arg(short, long, value_name = "FILE", conflicts_with_all = ["json", "explain", "measure", "seconds"])]
    output: Option<PathBuf>,
    /// Draw where the bows, the horizon and the antisolar point lie over a coarse picture, beside the plan.
    #[arg(long, value_name = "PNG", conflicts_with_all = ["script", "explain", "measure", "seconds", "frames"])]
    preview: Option<PathBuf>,
}

/// The folder of a chain, unless another is asked for.
const FOLDER: &str = "out";

/// The name that stands for every effect.
const ALL: &str = "all";

/// Prints the plan.
///
/// # Errors
/// A scene that is missing or wrong.
pub(crate) fn execute(command: &PlanCommand, common: &Common) -> Result<(), Failure> {
    if let Some(frames) = &command.frames {
        return execute_sequence(command, frames, common);
    }
    let start = Instant::now();
    let planned = scene_file::load(&command.scene, common)?;
    let plan_s = start.elapsed().as_secs_f64();
    planned.check_inputs()?;
    if command.seconds {
        planned.check()?;
        return plan_seconds::print((&planned, plan_s), &command.scene, common);
    }
    if let Some(preview) = &command.preview {
        let existing = common.options().existing;
        plan_preview::write(&planned, (&command.scene, preview), existing)?;
    }
    let output = command.output.as_deref();
    if let (Some(file), false) = (output, command.script) {
        return choice_file::write(&planned.choice, file, common.options().existing);
    }
    let text = if command.script {
        refuse_shutter(&command.scene, &planned.scene)?;
        let folder = output.unwrap_or(Path::new(FOLDER));
        script(&planned, &command.scene, folder, common)
    } else if let Some(name) = &command.explain {
        explained(&planned, name, common)?
    } else if command.measure {
        let measured = measure(&planned, common.verbosity())?;
        in_form(common, &measured, MeasuredEffects::text)?
    } else {
        let bows = bow_place::text(&planned)?;
        in_form(common, &planned.plan, |plan| format!("{plan}{bows}"))?
    };
    output::print(&text)?;
    // What the run would refuse, with the plan as the reason.
    planned.check_light()?;
    Ok(planned.check_memory()?)
}

/// Prints or writes what is decided for all frames of a sequence.
fn execute_sequence(
    command: &PlanCommand,
    frames: &FrameList,
    common: &Common,
) -> Result<(), Failure> {
    let sequence = SequenceFile::read(&command.scene, common)?;
    sequence.check(frames)?;
    let choice = sequence.choice(None)?;
    match &command.output {
        Some(file) => choice_file::write(&choice, file, common.options().existing),
        None => output::print(&in_form(common, &choice.plan, Plan::to_string)?),
    }
}

/// A result as JSON where that is asked for, else as text.
pub(crate) fn in_form<T: Serialize>(
    common: &Common,
    result: &T,
    text: impl Fn(&T) -> String,
) -> Result<String, Failure> {
    if !common.json {
        return Ok(text(result));
    }
    let json = serde_json::to_string_pretty(result);
    Ok(json.map_err(|error| Failure::Failed(error.to_string()))? + "\n")
}

/// What one effect is in a scene, or all of them.
fn explained(planned: &PlannedScene, name: &str, common: &Common) -> Result<String, Failure> {
    if name == ALL {
        let all = Effect::ALL.into_iter();
        let all: Vec<Explanation> = all.map(|it| planned.plan.explain(it, None)).collect();
        return in_form(common, &all, |all| Explanation::table(all));
    }
    let effect = Effect::from_name(name).map_err(Failure::Usage)?;
    let switched = planned.plan.switched(&planned.scene, effect);
    let switched = switched.map(|scene| planned.replanned(scene));
    let switched = switched.transpose()?.map(|planned| planned.plan);
    let explanation = planned.plan.explain(effect, switched.as_ref());
    in_form(common, &explanation, Explanation::to_string)
}

fn script(planned: &PlannedScene, scene: &Path, folder: &Path, common: &Common) -> String {
    let scene = quoted(scene);
    let inside = |name: &str| quoted(&folder.join(name));
    let drops = planned
        .drop_file
        .as_deref()
        .map_or_else(|| inside(stages::drops::FILE), quoted);
    let rendered = || {
        let [image, depth] = [stages::render::FILE, stages::photo::DEPTH].map(inside);
        format!("--image {image} --depth {depth}")
    };
    let choice = inside(choice_file::FILE);
    let accuracy = [vec![String::new()], common.picture_flags()].concat();
    let accuracy = accuracy.join(" ");
    let flags = format!("{accuracy} --choice {choice}");
    let plan = &planned.plan;
    let mut script = format!("#!/bin/sh\nset -e\nniji plan {scene}{accuracy} -o {choice}\n");
    for stage in &plan.stages {
        let line = match stage.stage {
            Stage::Drops => format!("drops --scene {scene} -o {drops}"),
            Stage::Airy => format!("airy -o {}", inside(stages::airy::FILE)),
            Stage::Scatter => {
                let uses_airy = plan.runs(Stage::Airy);
                let airy = uses_airy.then(|| format!(" --airy {}", inside(stages::airy::FILE)));
                let to = inside(stages::scatter::FILE);
                format!(
                    "scatter --scene {scene}{} -o {to}",
                    airy.unwrap_or_default()
                )
            }
            Stage::Atmosphere => {
                format!(
                    "atmosphere --scene {scene} -o {}",
                    inside(stages::atmosphere::FILE)
                )
            }
            Stage::Render => {
                let table = plan.runs(Stage::Scatter);
                let table = table.then(|| format!(" --table {}", inside(stages::scatter::FILE)));
                let depth = stages::photo::surfaces(planned, folder).depth;
                let depth = depth.filter(|_| planned.scene.photo.is_some());
                let depth = depth.map(|depth| format!(" --depth {}", quoted(&depth.path)));
                let air = plan.runs(Stage::Atmosphere);
                let air = air.then(|| format!(" --air {}", inside(stages::atmosphere::FILE)));
                format!(
                    "render --scene {scene} --drops {drops}{}{}{} -o {}",
                    table.unwrap_or_default(),
                    air.unwrap_or_default(),
                    depth.unwrap_or_default(),
                    inside(stages::render::FILE)
                )
            }
            Stage::Depth => {
                let to = inside(stages::photo::DEPTH);
                format!("depth --scene {scene} -o {to}")
            }
            Stage::Sun => {
                let preview = inside(stages::photo::SUN_PREVIEW);
                let to = inside(stages::photo::SUN);
                format!("sun --scene {scene} --preview {preview} -o {to}")
            }
            Stage::Check => {
                let to = inside(stages::photo::CHECK);
                format!("check --scene {scene} {} -o {to}", rendered())
            }
            Stage::Composite => {
                let to = inside(stages::photo::COMPOSITE);
                format!("composite --scene {scene} {} -o {to}", rendered())
            }
        };
        let _ = writeln!(script, "niji {line}{flags}");
    }
    script
}
