//! The flags that all subcommands share, and values as people type them.

use std::path::PathBuf;

use clap::Args;
use niji_picture::Sandbox;
use niji_radiometry::Bytes;
use niji_scene::Goal;
use niji_scene::Preset;
use niji_scene::Spectral;

use crate::failure::Failure;
use crate::output::Existing;
use crate::progress::Verbosity;
use crate::schema_flags::names;
use crate::stages::StageOptions;

/// Flags of every subcommand.
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
#[command(next_help_heading = "Common options")]
pub(crate) struct Common {
    /// Replace files that exist.
    #[arg(long, global = true)]
    pub force: bool,
    /// Read every output before it is called up to date, also those that look unchanged (same size, inode and
    /// time of change).
    #[arg(long, global = true)]
    pub verify: bool,
    /// Memory that the content of a file may take, a picture and drops, say 4GiB [default: half of the machine's].
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory)]
    pub memory: Option<Bytes>,
    /// Read files that a scene names in this folder only, for scenes of strangers; may be given several times.
    /// Links and `..` do not lead out of it, and what the command line names is not meant.
    #[arg(long, global = true, value_name = "DIR")]
    pub sandbox: Vec<PathBuf>,
    /// Threads to use [default: all cores]; the result does not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = thread_count)]
    pub threads: Option<usize>,
    /// Accuracy preset, instead of the scene's. Beside --tolerance `draft` and `reference` keep their
    /// levels, and the tolerance decides on effects, rays and the exit code.
    #[arg(long, global = true, value_name = "PRESET", value_parser = names::<Preset>())]
    pub accuracy: Option<Preset>,
    /// Tolerance instead of the scene's: RMSE of luminance over that of display white. Levels
    /// follow from it, but for those that the scene or --accuracy names, and pixels get more rays where
    /// they need them; a picture that misses it ends with code 5, and so does one below 1e-6 at once.
    #[arg(long, global = true, value_name = "T", value_parser = tolerance)]
    pub tolerance: Option<f64>,
    /// What the file of a picture keeps of its spectra, instead of the scene's picture.spectral: `full`; `half`, in half
    /// floats; `none`, colors in their place.
    #[arg(long, global = true, value_name = "WHAT", value_parser = names::<Spectral>())]
    pub spectral: Option<Spectral>,
    /// Decide as `niji plan SCENE -o FILE` did, for a sequence with --frames, without measuring again; refused for another scene or accuracy.
    #[arg(long, global = true, value_name = "TOML")]
    pub choice: Option<PathBuf>,
    /// Folder that keeps what was decided for scenes, so that the next command for one measures nothing again; `none`
    /// for nowhere [default: niji in the user's folder for caches].
    #[arg(long, global = true, value_name = "DIR", env = "NIJI_CACHE")]
    pub cache: Option<PathBuf>,
    /// Results as JSON on standard output.
    #[arg(long, global = true)]
    pub json: bool,
    /// Only errors on standard error.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say what each stage decides.
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

impl Common {
    /// How much to print on standard error.
    #[must_use]
    pub(crate) fn verbosity(&self) -> Verbosity {
        match (self.quiet, self.verbose) {
            (true, _) => Verbosity::Quiet,
            (false, true) => Verbosity::Verbose,
            (false, false) => Verbosity::Normal,
        }
    }

    /// What is asked of the picture.
    #[must_use]
    pub(crate) fn goal(&self) -> Goal {
        Goal {
            preset: self.accuracy,
            tolerance: self.tolerance,
        }
    }

    /// What is asked of a picture, as words of a command line.
    pub(crate) fn picture_flags(&self) -> Vec<String> {
        let goal = self.goal();
        let preset = goal
            .preset
            .map(|preset| ["--accuracy", preset.name()].map(str::to_owned));
        let tolerance = goal
            .tolerance
            .map(|it| ["--tolerance".to_owned(), it.to_string()]);
        let spectral = self
            .spectral
            .map(|it| ["--spectral", it.name()].map(str::to_owned));
        let flags = preset.into_iter().chain(tolerance).chain(spectral);
        flags.flatten().collect()
    }

    /// Where files may lie that a scene names.
    ///
    /// # Errors
    /// A folder that is missing.
    pub(crate) fn sandbox(&self) -> Result<Sandbox, Failure> {
        Ok(Sandbox::new(&self.sandbox)?)
    }

    /// How the stages of a run go on where one before it left its files: what it made for another scene, before an
    /// edit, is made anew. Not with a choice, which others share: they would undo each other's frames.
    #[must_use]
    pub(crate) fn options_of_run(&self) -> StageOptions {
        let mut options = self.options();
        if options.existing == Existing::Refuse && self.choice.is_none() {
            options.existing = Existing::ReplaceOwn;
        }
        options
    }

    /// How stages are run.
    #[must_use]
    pub(crate) fn options(&self) -> StageOptions {
        let existing = if self.force {
            Existing::Replace
        } else {
            Existing::Refuse
        };
        StageOptions {
            existing,
            verifies: self.verify,
            verbosity: self.verbosity(),
        }
    }
}

fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n_threads) if (1..=1024).contains(&n_threads) => Ok(n_threads),
        _ => Err(format!(
            "found {text}, expected a number of threads from 1 to 1024"
        )),
    }
}

fn memory(text: &str) -> Result<Bytes, String> {
    Bytes::parse(text)
        .ok_or_else(|| format!("found {text}, expected KiB, MiB, GiB or TiB, say 4GiB"))
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err(format!(
            "found {text}, expected a tolerance above 0 and at most 1, say 0.01"
        )),
    }
}

/// A list of numbers as people type it: `1,2.5,3e-2`.
///
/// # Errors
/// The entry that is not a finite number.
pub(crate) fn numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split([',', ' ', '\n', '\t', '\r'])
        .filter(|entry| !entry.is_empty())
        .map(|entry| match entry.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(format!("found {entry:?}, expected a finite number")),
        })
        .collect()
}

/// A parser of a number between two, both included.
pub(crate) fn within(
    low: f64,
    high: f64,
) -> impl Fn(&str) -> Result<f64, String> + Clone + 'static {
    move |text| match text.parse() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ => Err(format!(
            "found {text}, expected a number from {low} to {high}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        common: Common,
    }

    #[test]
    fn what_is_asked_of_a_picture_is_written_as_it_was_typed() {
        let flags_of = |words: &str| {
            let line = Line::parse_from(words.split(' '));
            line.common.picture_flags().join(" ")
        };
        assert_eq!(
            flags_of("niji --tolerance 0.02 --accuracy draft"),
            "--accuracy draft --tolerance 0.02"
        );
        assert_eq!(flags_of("niji"), "");
    }
}
