//! `niji run --frames`: the frames of a sequence, with tables that are made once.

use std::collections::BTreeSet;
use std::path::Path;
use std::path::PathBuf;

use niji_scene::Effect;
use niji_scene::Plan;
use niji_scene::Sequence;
use serde::Serialize;

use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::run::Outcome;
use crate::run::RunCommand;
use crate::run::files::Files;
use crate::run::report;
use crate::run::run_stages_to;
use crate::scene_file;
use crate::stages::Done;
use crate::stages::accuracy;
use crate::stages::given_table;
use crate::text_file;

/// What was done for a frame.
#[derive(Serialize)]
pub(super) struct FrameDone {
    /// Its number.
    pub(super) frame: u32,
    /// Its spectral image, or the folder of its tiles.
    pub(super) image: PathBuf,
    /// What was done, in order.
    pub(super) stages: Vec<Done>,
}

/// Runs frames of a sequence.
///
/// # Errors
/// A scene in which nothing changes, or whatever a frame reports, with its number.
pub(super) fn execute(
    command: &RunCommand,
    numbers: &FrameList,
    common: &Common,
) -> Result<(), Failure> {
    let (scene_file, folder): (&Path, &Path) = (&command.scene, &command.output);
    let sequence = sequence(scene_file)?;
    // What is wrong with the last frame is told before the first is made.
    for number in numbers.iter() {
        let text = sequence.scene_text(number);
        scene_file::frame_scene(&text, scene_file, common)
            .map_err(|failure| failure.within(&format!("frame {number}")))?;
    }
    let verbosity = common.verbosity();
    let (mut frames, mut effects) = (Vec::new(), None);
    let mut accuracy = Ok(());
    for number in numbers.iter() {
        let in_frame = |failure: Failure| failure.within(&format!("frame {number}"));
        let text = sequence.scene_text(number);
        let planned = scene_file::frame(&text, scene_file, common).map_err(in_frame)?;
        planned.check().map_err(Failure::from).map_err(in_frame)?;
        verbosity.say(format_args!("{:>11}  {number}", "frame"));
        for warning in planned
            .plan
            .warnings
            .iter()
            .chain(&jumps(&planned.plan, &mut effects))
        {
            verbosity.warn(warning);
        }
        let given = given_table::given(&planned, command.table.as_deref(), verbosity);
        let files = Files::of_frame(&planned, folder, number)
            .with_table(given.map_err(in_frame)?)
            .with_tiles(command.tiles.as_ref());
        let outcome = run_stages_to((&planned, None), &files, common.options());
        let Outcome { done, .. } = outcome.map_err(in_frame)?;
        if accuracy.is_ok() && files.tiles.is_none() {
            accuracy = accuracy::check(&planned, &files.image, common.goal()).map_err(in_frame);
        }
        frames.push(FrameDone {
            frame: number,
            image: files.picture(),
            stages: done,
        });
        // After each frame: whoever waits for frames may look.
        if command.tiles.is_none() {
            report::write(&report::of_frames(&frames), folder)?;
        }
    }
    finish(&frames, folder, common)?;
    accuracy
}

/// The sequence of a scene file.
///
/// # Errors
/// A scene that is missing or wrong, or in which nothing changes.
pub(crate) fn sequence(scene_file: &Path) -> Result<Sequence, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(scene_file, error);
    let text = text_file::read(scene_file)?;
    let sequence = Sequence::from_toml(&text).map_err(|error| bad(&error))?;
    sequence.ok_or_else(|| {
        Failure::Usage(format!(
            "nothing changes from frame to frame in {}: give it a section [sequence], say \
             sun.elevation_deg = [[1, 10.0], [240, 20.0]], or a drop file named \"spray.####.vdb\"",
            scene_file.display()
        ))
    })
}

/// Where another set of effects is simulated than in the frame before: `auto` decides for each
/// frame, and what is left out is below the tolerance, but it goes all at once.
fn jumps(plan: &Plan, before: &mut Option<BTreeSet<Effect>>) -> Vec<String> {
    let on: BTreeSet<Effect> = plan.effects_on().collect();
    let jump = |effect: &Effect| {
        let now = if on.contains(effect) { "on" } else { "off" };
        format!("{effect} is {now} from here: set it in [effects] for all frames alike")
    };
    let switched = before
        .iter()
        .flat_map(|before| on.symmetric_difference(before));
    let jumps = switched.map(jump).collect();
    *before = Some(on);
    jumps
}

fn finish(frames: &[FrameDone], folder: &Path, common: &Common) -> Result<(), Failure> {
    let is_kept = |frame: &FrameDone| frame.stages.iter().all(|done| done.up_to_date);
    if frames.iter().all(is_kept) {
        let verbosity = common.verbosity();
        verbosity.say(format_args!(
            "{}: everything is up to date",
            folder.display()
        ));
    }
    if common.json {
        return output::print(&format!("{:#}\n", report::of_frames(frames)));
    }
    let images = frames
        .iter()
        .map(|frame| format!("{}\n", frame.image.display()));
    output::print(&images.collect::<String>())
}
