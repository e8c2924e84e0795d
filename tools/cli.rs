//! The command line: subcommands, their groups in the help, and the flags all share.

use clap::Args;
use clap::Parser;
use clap::Subcommand;
use clap::ValueEnum;
use niji_scene::Preset;

use crate::airy::AiryCommand;
use crate::atmosphere::AtmosphereCommand;
use crate::calibrate::CalibrateCommand;
use crate::check::CheckCommand;
use crate::composite::CompositeCommand;
use crate::depth::DepthCommand;
use crate::diff::DiffCommand;
use crate::drops::DropsCommand;
use crate::eval::EvalCommand;
use crate::ice::IceCommand;
use crate::info::InfoCommand;
use crate::lee::LeeCommand;
use crate::merge::MergeCommand;
use crate::output::Existing;
use crate::plan::PlanCommand;
use crate::progress::Verbosity;
use crate::render::RenderCommand;
use crate::run::RunCommand;
use crate::scatter::ScatterCommand;
use crate::schema::SchemaCommand;
use crate::selftest::SelftestCommand;
use crate::shell::CompletionsCommand;
use crate::shell::ManCommand;
use crate::stages::Manner;
use crate::sun::SunCommand;
use crate::sweep::SweepCommand;

/// Subcommands by group; the help prints this instead of one long list.
const GROUPS: &str = "\
Whole scenes:
  run          Make the picture of a scene, leaving every intermediate file
  plan         Say which effects and stages a scene calls for, and why
  sweep        Show what accuracy costs in time for one scene (CSV, SVG, HTML)
  calibrate    Measure error and time of every accuracy level

Stages, in order:
  drops        Author a drop volume (VDB)
  airy         Tabulate the rainbow integral f(z) (EXR)
  scatter      Tabulate how drops scatter (EXR)
  atmosphere   Tabulate the air (EXR)
  render       Integrate along the view rays (EXR, PNG)
  merge        Put tiles of a picture together (EXR, PNG)

Photographs:
  depth        Find layers of depth in a photograph, or take a depth map from elsewhere
  sun          Find the sun from pixels where the bow should stand
  check        Say where the wanted bow contradicts the photograph
  composite    Set the bow into the photograph

Ice:
  ice          Follow light through ice: cubes, meshes, icebergs (EXR, PNG)

Looking:
  info         Say what a VDB or EXR file holds; assert it in scripts
  diff         Compare a VDB or EXR file with a reference
  lee          Draw the color of the bow against drop radius (EXR, PNG, SVG)
  eval         Print physics as CSV: airy, scatter, sizes, index, air, sun, ice
  selftest     Try the hard cases: measured error beside allowed error

Shell:
  completions  Completions for bash, zsh, fish, elvish or PowerShell
  man          Manual pages
  schema       The JSON Schema of scene files, for editors";

const TEMPLATE: &str = "\
{about-with-newline}
{usage-heading} {usage}

{before-help}
Options:
{options}{after-help}";

const EXAMPLES: &str = "
Examples:
  niji run data/scenes/paper-c-figure-3.toml -o out
  niji plan data/scenes/paper-b-sun-10-inscatter.toml --script > chain.sh
  niji info out/drops.vdb
  niji eval index --material water --wavelengths-nm 400,550,700

Exit codes: 0 done, 1 failed, 2 usage (also an output that exists), 3 bad input,
4 physically impossible, 5 accuracy not reached, 6 comparison failed, 130 interrupted.";

/// Physically based pictures of rainbows, stage by stage.
#[derive(Debug, Parser)]
#[command(name = "niji", version, help_template = TEMPLATE, before_help = GROUPS)]
#[command(after_help = EXAMPLES, disable_help_subcommand = true)]
pub(crate) struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Flags of every subcommand.
    #[command(flatten)]
    pub common: Common,
}

/// Flags of every subcommand.
#[derive(Debug, Args)]
#[allow(clippy::struct_excessive_bools, reason = "flags of a command line")]
#[command(next_help_heading = "Common options")]
pub(crate) struct Common {
    /// Replace files that exist.
    #[arg(long, global = true)]
    pub force: bool,
    /// Threads to use [default: all cores]; the result does not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = thread_count)]
    pub threads: Option<usize>,
    /// Accuracy preset, instead of the scene's.
    #[arg(long, global = true, value_name = "PRESET")]
    pub accuracy: Option<PresetName>,
    /// Tolerance instead of the scene's: RMSE of luminance over that of a gray card in the sun. Levels
    /// follow from it, but for those that the scene or --accuracy names, and pixels get more rays where
    /// they need them; a picture that misses it ends with code 5.
    #[arg(long, global = true, value_name = "T", value_parser = tolerance)]
    pub tolerance: Option<f64>,
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

    /// How stages are run.
    #[must_use]
    pub(crate) fn manner(&self) -> Manner {
        let existing = if self.force {
            Existing::Replace
        } else {
            Existing::Refuse
        };
        Manner {
            existing,
            verbosity: self.verbosity(),
        }
    }
}

/// The presets by the name they have on the command line.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum PresetName {
    /// For layout: seconds.
    Draft,
    /// For pictures.
    Standard,
    /// The most accurate level of every stage.
    Reference,
}

impl From<PresetName> for Preset {
    fn from(name: PresetName) -> Self {
        match name {
            PresetName::Draft => Self::Draft,
            PresetName::Standard => Self::Standard,
            PresetName::Reference => Self::Reference,
        }
    }
}

/// The subcommands.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "the text of each stands with its struct")]
pub(crate) enum Command {
    Run(RunCommand),
    Plan(PlanCommand),
    Sweep(SweepCommand),
    Calibrate(CalibrateCommand),
    Drops(DropsCommand),
    Airy(AiryCommand),
    Scatter(ScatterCommand),
    Atmosphere(AtmosphereCommand),
    Render(RenderCommand),
    Merge(MergeCommand),
    Depth(DepthCommand),
    Sun(SunCommand),
    Check(CheckCommand),
    Composite(CompositeCommand),
    Ice(IceCommand),
    Info(InfoCommand),
    Diff(DiffCommand),
    Lee(LeeCommand),
    Eval(EvalCommand),
    Selftest(SelftestCommand),
    Completions(CompletionsCommand),
    Man(ManCommand),
    Schema(SchemaCommand),
}

fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n_threads) if (1..=1024).contains(&n_threads) => Ok(n_threads),
        _ => Err(format!(
            "found {text}, expected a number of threads from 1 to 1024"
        )),
    }
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
