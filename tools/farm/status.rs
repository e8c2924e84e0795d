//! `niji farm status`: what is done of a job, by its files alone.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use super::record::Record;
use crate::checksums;
use crate::checksums::Found;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::run::files::image;
use crate::run::files::tile;
use crate::stages::render::companions;
use crate::stages::tile::TileOfMany;

/// Letters of a list within a line.
const MOST_LETTERS: usize = 60;

/// Count frames and tiles that are done, missing and damaged, and print those frames to submit again.
///
/// Nothing is asked of an engine. A picture is done when its files have the bytes that were written; with --verify
/// those are read again that look unchanged. Where frames are not done, their list goes to standard output, and the
/// exit code is 6.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji farm status out
  niji farm sequence.toml -o out --frames $(niji farm status out -q) --engine slurm --submit")]
pub(super) struct StatusCommand {
    /// The folder of the pictures, as `niji farm` had it.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Pictures by what was found of them.
#[derive(Debug, PartialEq, Eq, Serialize)]
struct Count {
    /// How many are done.
    done: usize,
    /// Those that are not there, or not finished.
    missing: FrameList,
    /// Those whose bytes are other than those written.
    damaged: FrameList,
}

/// What is done of a job.
#[derive(Debug, Serialize)]
struct Status {
    /// Frames of a sequence.
    frames: Option<Count>,
    /// Whether a single picture is done.
    picture: Option<Found>,
    /// Tiles of the pictures that are not done.
    tiles: Option<Vec<TileCount>>,
}

/// Tiles of a picture that is not done.
#[derive(Debug, Serialize)]
struct TileCount {
    /// Its frame.
    frame: Option<u32>,
    /// Its tiles.
    #[serde(flatten)]
    tiles: Count,
}

/// Prints what is done.
///
/// # Errors
/// A folder without a job; [`Failure::ComparisonFailed`] where something is not done.
pub(super) fn execute(command: &StatusCommand, common: &Common) -> Result<(), Failure> {
    let folder = &command.folder;
    let record = Record::read(folder)?;
    let status = Status::of(&record, folder, common.verify);
    if common.json {
        let json = serde_json::to_string_pretty(&status);
        output::print(&(json.map_err(|error| Failure::Failed(error.to_string()))? + "\n"))?;
    } else if let Some(frames) = &status.frames
        && !frames.is_done()
    {
        output::print(&format!("{}\n", frames.again()))?;
    }
    let verbosity = common.verbosity();
    status.lines().iter().for_each(|line| verbosity.say(line));
    status.verdict(folder)
}

impl Status {
    fn of(record: &Record, folder: &Path, reads: bool) -> Self {
        let numbers = record.frames.as_ref();
        let numbers: Option<Vec<u32>> = numbers.map(|frames| frames.iter().collect());
        let of_frame = |frame: Option<u32>| found(&image(folder, frame), reads);
        let frames = numbers
            .as_ref()
            .map(|numbers| Count::of(numbers, |frame| of_frame(Some(frame))));
        let picture = numbers.is_none().then(|| of_frame(None));
        let not_done: Vec<Option<u32>> = match (&frames, picture) {
            (Some(frames), _) => frames.again().iter().map(Some).collect(),
            (None, Some(Found::Whole)) => Vec::new(),
            (None, _) => vec![None],
        };
        let tiles = record.n_tiles.map(|n_tiles| {
            let numbers: Vec<u32> = (1..=n_tiles).collect();
            let of_frame = |frame: Option<u32>| TileCount {
                frame,
                tiles: Count::of(&numbers, |number| {
                    let of_many = TileOfMany { number, n_tiles };
                    found(&tile(&image(folder, frame), of_many), reads)
                }),
            };
            not_done.into_iter().map(of_frame).collect()
        });
        Self {
            frames,
            picture,
            tiles,
        }
    }

    /// For people.
    fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.frames.iter().map(|it| it.text("frames")).collect();
        for TileCount { frame, tiles } in self.tiles.iter().flatten() {
            let of = frame.map_or("tiles".to_owned(), |frame| format!("frame {frame}, tiles"));
            lines.push(tiles.text(&of));
        }
        lines
    }

    fn verdict(&self, folder: &Path) -> Result<(), Failure> {
        let not_done = match (&self.frames, self.picture) {
            (Some(frames), _) if frames.is_done() => return Ok(()),
            (Some(frames), _) => format!("{} frames are", frames.again().len()),
            (None, Some(Found::Whole) | None) => return Ok(()),
            (None, Some(_)) => "the picture is".to_owned(),
        };
        Err(Failure::ComparisonFailed(format!(
            "{}: {not_done} not done: submit again what is missing, with --force what is damaged",
            folder.display()
        )))
    }
}

/// The worst of a picture's files.
fn found(image: &Path, reads: bool) -> Found {
    let [plain, preview] = companions(image);
    let files = [image, &plain, &preview].map(|path| checksums::found(path, reads));
    files.into_iter().max().unwrap_or(Found::Missing)
}

impl Count {
    fn of(numbers: &[u32], found: impl Fn(u32) -> Found + Sync) -> Self {
        let found: Vec<Found> = numbers.par_iter().map(|number| found(*number)).collect();
        let those = |state: Found| {
            let those = numbers
                .iter()
                .zip(&found)
                .filter(|(_, found)| **found == state);
            FrameList::of(those.map(|(number, _)| *number))
        };
        Self {
            done: those(Found::Whole).len(),
            missing: those(Found::Missing),
            damaged: those(Found::Changed),
        }
    }

    fn is_done(&self) -> bool {
        self.missing.len() + self.damaged.len() == 0
    }

    /// Those to make again.
    fn again(&self) -> FrameList {
        FrameList::of(self.missing.iter().chain(self.damaged.iter()))
    }

    fn text(&self, what: &str) -> String {
        let listed = |list: &FrameList, what: &str| match list.len() {
            0 => String::new(),
            n => format!(", {n} {what} ({})", brief(list)),
        };
        let n = self.done + self.missing.len() + self.damaged.len();
        format!(
            "{what}: {} of {n} done{}{}",
            self.done,
            listed(&self.missing, "missing"),
            listed(&self.damaged, "damaged")
        )
    }
}

/// A list for people, who get the whole one on standard output.
fn brief(list: &FrameList) -> String {
    let text = list.to_string();
    let cut = text
        .match_indices(',')
        .map(|(at, _)| at)
        .find(|at| *at > MOST_LETTERS);
    cut.map_or(text.clone(), |at| format!("{}, ...", &text[..at]))
}
