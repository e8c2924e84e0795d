//! The command line: subcommands, and their groups in the help.

use clap::Parser;
use clap::Subcommand;

use crate::airy::AiryCommand;
use crate::atmosphere::AtmosphereCommand;
use crate::calibrate::CalibrateCommand;
use crate::check::CheckCommand;
use crate::composite::CompositeCommand;
use crate::depth::DepthCommand;
use crate::diff::DiffCommand;
use crate::drops::DropsCommand;
use crate::eval::EvalCommand;
use crate::farm::FarmCommand;
use crate::flags::Common;
use crate::ice::IceCommand;
use crate::info::InfoCommand;
use crate::lee::LeeCommand;
use crate::merge::MergeCommand;
use crate::photo::PhotoCommand;
use crate::plan::PlanCommand;
use crate::render::RenderCommand;
use crate::run::RunCommand;
use crate::scatter::ScatterCommand;
use crate::schema::SchemaCommand;
use crate::selftest::SelftestCommand;
use crate::shell::CompletionsCommand;
use crate::shell::ManCommand;
use crate::sun::SunCommand;
use crate::sweep::SweepCommand;
use crate::version;
use crate::view::ViewCommand;

/// Subcommands by group; the help prints this instead of one long list.
const GROUPS: &str = "\
Whole scenes:
  run          Make the picture of a scene, leaving every intermediate file
  view         Show a scene in the browser while you work on it
  plan         Say which effects and stages a scene calls for, and why
  farm         Hand a sequence, or a picture in tiles, to Slurm, OpenJD or HyperQueue
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
  photo        Set a bow into a photograph with one command
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
  selftest     Try what a machine can break: measured error beside allowed error

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
#[command(name = "niji", version, long_version = version(), help_template = TEMPLATE, before_help = GROUPS)]
#[command(after_help = EXAMPLES, disable_help_subcommand = true)]
pub(crate) struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Flags of every subcommand.
    #[command(flatten)]
    pub common: Common,
}

/// The subcommands.
#[derive(Debug, Subcommand)]
#[allow(missing_docs, reason = "the text of each stands with its struct")]
pub(crate) enum Command {
    Run(RunCommand),
    View(ViewCommand),
    Plan(PlanCommand),
    Farm(FarmCommand),
    Sweep(SweepCommand),
    Calibrate(CalibrateCommand),
    Drops(DropsCommand),
    Airy(AiryCommand),
    Scatter(ScatterCommand),
    Atmosphere(AtmosphereCommand),
    Render(RenderCommand),
    Merge(MergeCommand),
    Photo(PhotoCommand),
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
