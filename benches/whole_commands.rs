//! What a person waits for: whole commands on scenes with air, sky and files, cold and again with nothing touched.
//!
//! Each run of `niji run` is a process of its own: cold in a fresh folder, then again in that folder. Of several runs
//! each figure is the least, because other programs only ever add to it; seconds of the clock suffer from them most,
//! processor seconds little. `rest` is what no stage accounts for: the plan, the pictures it looks at, start and end.
//!
//! Beside them stands a bound that no program with these results gets below on one processor:
//!
//! seconds ≥ (table + picture)/(multiply-adds a second) + bytes/(bytes a second)
//!   table: two multiply-adds an order for each value (A F + B G of `niji_scatter`); of Lorenz and Mie's series at
//!     least a drop a row and wavelength, x + 4.05 x^(1/3) + 2 waves of it (W. J. Wiscombe, Appl. Opt. 19, 1505-1509
//!     (1980)) times half of the angles, five multiply-adds each
//!   picture: a multiply-add for each polarization, pixel and wavelength
//!   bytes: of all files written, at the rate of a plain write to the same disk
//! Sizes under a row, cells under a ray, and paths are choices of the program and not in it.
//!
//!     cargo bench --bench whole_commands -- [--runs N] [--against PROGRAM] [SCENE]...
//!
//! A scene is the name of a copy in `benches/scenes`, which does not change with what ships, or the path of a file.
//! Another build is run in turn with this one, so that both meet the same noise.

#[path = "whole_commands/bound.rs"]
mod bound;
#[path = "support/processor_time.rs"]
mod processor_time;
#[path = "support/whole_run.rs"]
mod whole_run;

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::time::SystemTime;

use bound::Rates;
use bound::Work;
use whole_run::MEASURE;
use whole_run::Result;
use whole_run::WholeRun;
use whole_run::circumstances;
use whole_run::measured_here;
use whole_run::whole_run;

const SCENES: [&str; 6] = [
    "paper-b-sun-20-inscatter",
    "rain-cell",
    "rain-5-mm-h-flattened",
    "garden-fountain",
    "waterfall-gorge",
    "fog-bank-fogbow-multiple",
];
const STAGES: [&str; 5] = ["drops", "airy", "scatter", "atmosphere", "render"];
/// Runs of each scene where none are asked for.
const N_RUNS: usize = 3;

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    arguments.retain(|it| it != "--bench");
    if arguments.first().is_some_and(|it| it == MEASURE) {
        return measured_here(&arguments[1..]);
    }
    let asked = Asked::parsed(arguments)?;
    let rates = Rates::measured()?;
    println!("{}\n{rates}", circumstances());
    print_heads();
    for path in &asked.scenes {
        let least = least_of(path, &asked)?;
        for ((cold, again, made), program) in least.iter().zip(&asked.programs) {
            if asked.programs.len() > 1 {
                println!("{}", program.display());
            }
            let name = path.file_stem().unwrap_or_default().to_string_lossy();
            print_row(&name, cold, Some(rates.bound_s(made)));
            print_row("  again", again, None);
        }
    }
    Ok(())
}

/// What is asked for.
struct Asked {
    n_runs: usize,
    programs: Vec<PathBuf>,
    scenes: Vec<PathBuf>,
}

impl Asked {
    fn parsed(arguments: Vec<String>) -> Result<Self> {
        let mut asked = Self {
            n_runs: N_RUNS,
            programs: vec![PathBuf::from(env!("CARGO_BIN_EXE_niji"))],
            scenes: Vec::new(),
        };
        let mut arguments = arguments.into_iter();
        while let Some(argument) = arguments.next() {
            match argument.as_str() {
                "--runs" => {
                    let given = arguments.next().and_then(|it| it.parse().ok());
                    let given = given.filter(|n| *n > 0);
                    asked.n_runs = given.ok_or("--runs: expected a number from 1, as --runs 3")?;
                }
                "--against" => {
                    let given = arguments.next().ok_or("--against: expected a program")?;
                    asked.programs.push(given.into());
                }
                name => asked.scenes.push(scene(name)?),
            }
        }
        if asked.scenes.is_empty() {
            asked.scenes = SCENES.into_iter().map(scene).collect::<Result<_>>()?;
        }
        Ok(asked)
    }
}

/// The file of a scene by its name or path.
fn scene(name: &str) -> Result<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("benches/scenes/{name}.toml"));
    [own, PathBuf::from(name)]
        .into_iter()
        .find(|path| path.is_file())
        .ok_or_else(|| format!("{name}: found neither a scene in benches/scenes nor a file").into())
}

/// What a command took, and bytes of the files that it wrote.
struct Measured {
    run: WholeRun,
    written_bytes: f64,
}

impl Measured {
    /// The least of both of everything.
    fn least(&self, other: &Self) -> Self {
        Self {
            run: self.run.least(&other.run),
            written_bytes: self.written_bytes.min(other.written_bytes),
        }
    }
}

/// The least of some runs of each program, cold and again, and the work in what they made.
fn least_of(scene: &Path, asked: &Asked) -> Result<Vec<(Measured, Measured, Work)>> {
    let mut least: Vec<(Measured, Measured, Work)> = Vec::new();
    for _ in 0..asked.n_runs {
        for (index, program) in asked.programs.iter().enumerate() {
            let folder = tempfile::tempdir()?;
            let out = folder.path().join("out");
            let run = || measured(program, scene, &out);
            let (cold, again) = (run()?, run()?);
            if let Some((least_cold, least_again, _)) = least.get_mut(index) {
                *least_cold = least_cold.least(&cold);
                *least_again = least_again.least(&again);
            } else {
                let work = Work::of(&out, cold.written_bytes)?;
                least.push((cold, again, work));
            }
        }
    }
    Ok(least)
}

/// What `niji run` takes.
fn measured(program: &Path, scene: &Path, out: &Path) -> Result<Measured> {
    let started = SystemTime::now();
    Ok(Measured {
        run: whole_run(program, scene, out, &[])?,
        written_bytes: written_since(out, started)? as f64,
    })
}

/// Bytes of the files of a folder that are as new.
fn written_since(folder: &Path, start: SystemTime) -> Result<u64> {
    let mut bytes = 0;
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let about = entry.metadata()?;
        if about.is_dir() {
            bytes += written_since(&entry.path(), start)?;
        } else if about.modified()? >= start {
            bytes += about.len();
        }
    }
    Ok(bytes)
}

fn print_heads() {
    print!("{:26} {:>7} {:>7}", "seconds", "all", "cpu");
    for stage in STAGES {
        print!(" {stage:>10}");
    }
    println!(
        " {:>7} {:>7} {:>8} {:>8}",
        "rest", "bound", "peak MB", "write MB"
    );
}

fn print_row(name: &str, of: &Measured, bound_s: Option<f64>) {
    let run = &of.run;
    print!("{name:26} {:7.2} {:7.2}", run.wall_s, run.processor_s);
    let stages_s = STAGES.map(|stage| run.stage_s(stage));
    for stage_s in stages_s {
        print!(" {stage_s:10.3}");
    }
    let rest_s = run.wall_s - stages_s.iter().sum::<f64>();
    let bound = bound_s.map_or_else(String::new, |it| format!("{it:.3}"));
    println!(
        " {rest_s:7.2} {bound:>7} {:8.0} {:8.1}",
        run.peak_bytes / 1e6,
        of.written_bytes / 1e6
    );
}
