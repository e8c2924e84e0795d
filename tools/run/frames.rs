//! `niji run --frames`: the frames of a sequence, with tables that are made once.

use std::path::Path;
use std::path::PathBuf;

use serde::Serialize;

use crate::choice_file;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::output::Existing;
use crate::run::Outcome;
use crate::run::RunCommand;
use crate::run::closing;
use crate::run::files::Files;
use crate::run::report;
use crate::run::run_stages_to;
use crate::run::tables;
use crate::run::told;
use crate::sequence_file::SequenceFile;
use crate::stages::Done;
use crate::stages::accuracy;
use crate::stages::accuracy::Reached;
use crate::stages::given_table;
use crate::stages::seconds_of;

/// What was done for a frame.
#[derive(Serialize)]
pub(super) struct FrameDone {
    /// Its number.
    pub(super) frame: u32,
    /// Its spectral image, or the folder of its tiles.
    pub(super) image: PathBuf,
    /// How accurate it is, where it is there as a whole.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) accuracy: Option<Reached>,
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
    let (folder, options): (&Path, _) = (&command.output, common.options_of_run());
    let sequence = SequenceFile::read(&command.scene, common)?;
    sequence.check(numbers)?;
    let kept = folder.join(choice_file::FILE);
    let choice = sequence.choice(choice_file::kept(&kept, options.existing)?)?;
    let verbosity = common.verbosity();
    for warning in &choice.plan.warnings {
        verbosity.warn(warning);
    }
    let (mut frames, mut shared) = (Vec::new(), Vec::new());
    let mut accuracy = Ok(());
    for number in numbers.iter() {
        let in_frame = |failure: Failure| failure.within(&format!("frame {number}"));
        report::check_own(folder, Some(number), options.existing)?;
        let planned = sequence.frame(number, &choice)?;
        planned.check().map_err(Failure::from).map_err(in_frame)?;
        choice_file::write(&choice, &kept, Existing::Replace)?;
        let given = given_table::given(&planned, command.table.as_deref(), verbosity);
        let files = Files::of_frame(&planned, folder, number)
            .with_table(given.map_err(in_frame)?)
            .with_tiles(command.tiles.as_ref());
        if command.until.is_some() {
            shared.extend(tables(planned, &files, options).map_err(in_frame)?);
            continue;
        }
        verbosity.say(format_args!("{:>11}  {number}", "frame"));
        let outcome = run_stages_to((&planned, None), &files, options);
        let Outcome { done, .. } = outcome.map_err(in_frame)?;
        let reached = if files.tiles.is_none() {
            accuracy::reached(&planned, &files.image).map_err(in_frame)?
        } else {
            None
        };
        if let Some(reached) = &reached {
            let seconds = seconds_of(&done);
            verbosity.say(format_args!(
                "             {}; {seconds:.1} s",
                reached.text()
            ));
            let asked = common.goal().tolerance;
            if let Some(cause) = reached.too_much().filter(|_| asked.is_none()) {
                verbosity.say(format_args!("             most of it from {cause}"));
            }
            if accuracy.is_ok() && asked.is_some() {
                accuracy = reached.verdict().map_err(in_frame);
            }
        }
        let done = FrameDone {
            frame: number,
            image: files.picture(),
            accuracy: reached,
            stages: done,
        };
        // After each frame: whoever waits for frames may look.
        if command.tiles.is_none() {
            report::write(&report::of_frames(&[&done]), folder, Some(number))?;
        }
        frames.push(done);
    }
    if command.until.is_some() {
        return told(&shared, common);
    }
    if command.tiles.is_none() && common.choice.is_none() {
        report::write_summary(folder)?;
    }
    for line in closing::left_out(&choice.plan) {
        verbosity.say(line);
    }
    finish(&frames, folder, common)?;
    accuracy
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
        return output::print(&format!(
            "{:#}\n",
            report::of_frames(&frames.iter().collect::<Vec<_>>())
        ));
    }
    let images = frames
        .iter()
        .map(|frame| format!("{}\n", frame.image.display()));
    output::print(&images.collect::<String>())
}
