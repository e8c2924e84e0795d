//! `niji farm`: a sequence or a picture in tiles, handed to an engine that has many machines.
//!
//! `job` is the graph of steps, as plain data; one file an engine writes it down; `needs` sizes its tasks, and
//! `status` says from the files alone what is done.

mod bundle;
mod hyperqueue;
mod job;
mod needs;
mod openjd;
mod record;
mod slurm;
mod status;

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use clap::Subcommand;
use clap::ValueEnum;
use niji_picture::PlannedScene;
use serde_json::json;

use crate::failure::Failure;
use crate::farm::bundle::Places;
use crate::farm::job::Request;
use crate::farm::job::Step;
use crate::farm::needs::Chunk;
use crate::farm::needs::Needs;
use crate::farm::record::Record;
use crate::farm::status::StatusCommand;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::output::Existing;
use crate::scene_file;
use crate::sequence_file::SequenceFile;

/// Hand a sequence, or a picture in tiles, to Slurm, OpenJD or HyperQueue.
///
/// Writes a folder of job files, DIR/farm/ENGINE, whose tasks are commands of this program: one decides for all
/// frames and makes what they share, the others make frames or tiles of them, put tiles together and check. Tasks may
/// be killed and run again at any time. All machines see the scene and DIR under the same path.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "Examples:
  niji farm sequence.toml -o out --frames 1-240 --engine slurm --dry-run
  niji farm sequence.toml -o out --frames 1-240 --engine slurm --submit
  niji farm scene.toml -o out --tiles 16 --engine openjd
  niji farm status out
  niji farm sequence.toml -o out --frames $(niji farm status out -q) --engine slurm --submit

A task asks for --threads and --memory [default: the plan's memory and a quarter, a thread for each 2 GiB of it].
The program is called `niji` on the machines, or what NIJI says there (of OpenJD the parameter Niji).")]
pub(crate) struct FarmCommand {
    #[command(subcommand)]
    look: Option<Look>,
    /// The scene.
    #[arg(required = true)]
    scene: Option<PathBuf>,
    /// The folder of the pictures; the job files stand in its folder `farm`.
    #[arg(short, long, value_name = "DIR", required = true)]
    output: Option<PathBuf>,
    /// Who runs the tasks.
    #[arg(long, value_enum, required_unless_present = "dry_run")]
    engine: Option<Engine>,
    /// The frames of a sequence, as 1-240 or 1-3,7,10-20:2.
    #[arg(long, value_name = "LIST", value_parser = FrameList::parse, required_unless_present = "tiles")]
    frames: Option<FrameList>,
    /// Share every picture out in N tiles, bands of rows, that are put together.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    tiles: Option<u32>,
    /// Frames, or with --tiles tiles of one picture, that a task makes at most [default: as many frames as take ten
    /// minutes, by the slowest of which a report in DIR tells, else 10; one tile].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    chunk: Option<u32>,
    /// Hand the job to the engine, too.
    #[arg(long, conflicts_with = "dry_run")]
    submit: bool,
    /// Print the steps of the job, and write nothing.
    #[arg(long)]
    dry_run: bool,
}

/// What there is to see of a job.
#[derive(Debug, Subcommand)]
enum Look {
    Status(StatusCommand),
}

/// Who runs tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Slurm, by sbatch.
    Slurm,
    /// Open Job Description, as AWS Deadline Cloud takes it.
    Openjd,
    /// HyperQueue, by its package of Python.
    Hyperqueue,
}

impl Engine {
    fn name(self) -> &'static str {
        match self {
            Self::Slurm => "slurm",
            Self::Openjd => "openjd",
            Self::Hyperqueue => "hyperqueue",
        }
    }
}

/// Writes a job, and submits it where that is asked for.
///
/// # Errors
/// A scene that cannot be run, a folder of another job, or an engine that refuses.
pub(crate) fn execute(command: &FarmCommand, common: &Common) -> Result<(), Failure> {
    if let Some(Look::Status(command)) = &command.look {
        return status::execute(command, common);
    }
    // Both are required by the command line.
    let (Some(scene), Some(out)) = (&command.scene, &command.output) else {
        return Ok(());
    };
    if common.choice.is_some() {
        let message = "--choice is made by the job's first task: leave it out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let planned = planned(command, scene, common)?;
    let places = Places::new(scene, out)?;
    let needs = Needs::new(common.threads, common.memory, &planned);
    let chunk = match (command.chunk, command.tiles) {
        (Some(most), _) => Chunk::of(most as usize),
        (None, Some(_)) => Chunk::of(1),
        (None, None) => Chunk::of_frames(out),
    };
    let mut flags = common.picture_flags();
    for folder in &common.sandbox {
        flags.extend(["--sandbox".to_owned(), bundle::absolute(folder)?]);
    }
    let request = Request {
        frames: command.frames.as_ref(),
        n_tiles: command.tiles,
        chunk: chunk.most,
        flags: &flags,
        replaces: common.force,
    };
    let steps = request.steps();
    if command.dry_run {
        return print(&steps, (needs, &chunk), common.json);
    }
    let Some(engine) = command.engine else {
        return Ok(());
    };
    let bundle = match engine {
        Engine::Slurm => slurm::bundle(&steps, &places, needs),
        Engine::Openjd => openjd::bundle(&steps, &places, needs),
        Engine::Hyperqueue => hyperqueue::bundle(&steps, &places, needs),
    };
    let record = Record::of(&places, &request).joined(&places.out, common.options().existing)?;
    let folder = record::folder(&places.out).join(engine.name());
    // What stands beside a record is of a job before.
    let existing = if record::is_there(&places.out) {
        Existing::Replace
    } else {
        common.options().existing
    };
    bundle.write(&folder, existing)?;
    record.write(&places.out)?;
    output::print(&format!("{}\n", folder.display()))?;
    if command.submit {
        return bundle.submit(&folder);
    }
    Ok(())
}

/// The picture, or the first frame: what is wrong with a scene is told before it is handed out.
fn planned(command: &FarmCommand, scene: &Path, common: &Common) -> Result<PlannedScene, Failure> {
    let planned = match &command.frames {
        None => scene_file::load(scene, common)?,
        Some(frames) => {
            let sequence = SequenceFile::read(scene, common)?;
            let first = frames.iter().next().unwrap_or(0);
            scene_file::planned(sequence.scene(first)?, scene, common)?
        }
    };
    let usage = |message: String| Err(Failure::Usage(message));
    if planned.scene.sequence.is_some() && command.frames.is_none() {
        let scene = scene.display();
        return usage(format!(
            "{scene} is a sequence: say which frames with --frames"
        ));
    }
    if planned.scene.photo.is_some() {
        return usage(format!(
            "{} is of a photograph, expected a scene that is one picture of `niji render`: make it by `niji run`",
            scene.display()
        ));
    }
    planned.check()?;
    let region = planned.scene.camera.region();
    let bands = region.and_then(|region| region.bands(command.tiles.unwrap_or(1)));
    bands.map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(planned)
}

/// The steps for people, or as JSON.
fn print(steps: &[Step], (needs, chunk): (Needs, &Chunk), as_json: bool) -> Result<(), Failure> {
    if as_json {
        let job = json!({"steps": steps, "needs": needs, "chunk": chunk});
        return output::print(&format!("{job:#}\n"));
    }
    let lines: Vec<String> = steps.iter().map(Step::to_string).collect();
    output::print(&format!("{}\n\n{needs}{chunk}\n", lines.join("\n")))
}
