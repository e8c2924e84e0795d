//! What a whole command takes: each run of `niji run` is a process of its own.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::process::Stdio;
use std::time::Instant;

use nix::sys::resource::UsageWho;
use nix::sys::resource::getrusage;
use serde_json::Value;
use serde_json::json;

use crate::processor_time::processor_time;

/// The argument with which a benchmark measures one command.
pub(crate) const MEASURE: &str = "--measure";
/// Peaks are told in kibibytes, by Darwin in bytes.
const PEAK_UNIT_BYTES: f64 = if cfg!(target_os = "macos") {
    1.0
} else {
    1024.0
};

pub(crate) type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// What a run took.
pub(crate) struct WholeRun {
    pub(crate) wall_s: f64,
    pub(crate) processor_s: f64,
    pub(crate) peak_bytes: f64,
    /// Seconds of its stages by the clock.
    stages_s: BTreeMap<String, f64>,
}

impl WholeRun {
    /// Seconds of a stage, by the clock; 0 of one that there is not.
    pub(crate) fn stage_s(&self, name: &str) -> f64 {
        self.stages_s.get(name).copied().unwrap_or_default()
    }

    /// The least of both of everything.
    pub(crate) fn least(&self, other: &Self) -> Self {
        let stages = self.stages_s.iter();
        let stages = stages.map(|(name, seconds)| (name.clone(), seconds.min(other.stage_s(name))));
        Self {
            wall_s: self.wall_s.min(other.wall_s),
            processor_s: self.processor_s.min(other.processor_s),
            peak_bytes: self.peak_bytes.min(other.peak_bytes),
            stages_s: stages.collect(),
        }
    }
}

/// Seconds of the stages in a report.
fn stages_s(report: &Value) -> BTreeMap<String, f64> {
    let mut stages_s = BTreeMap::new();
    for stage in report["stages"].as_array().into_iter().flatten() {
        let name = stage["stage"].as_str().unwrap_or_default().to_owned();
        *stages_s.entry(name).or_default() += stage["seconds"].as_f64().unwrap_or_default();
    }
    stages_s
}

/// Runs a program on a scene into a folder, by a process that it alone is a child of: a process knows of its children
/// the largest.
pub(crate) fn whole_run(
    program: &Path,
    scene: &Path,
    out: &Path,
    flags: &[&str],
) -> Result<WholeRun> {
    let output = Command::new(std::env::current_exe()?)
        .arg(MEASURE)
        .args([program, scene, out])
        .args(flags)
        .stderr(Stdio::inherit())
        .output()?;
    if !output.status.success() {
        return Err(format!("{}: the run failed", scene.display()).into());
    }
    let told: Value = serde_json::from_slice(&output.stdout)?;
    let report = serde_json::from_str(&fs::read_to_string(out.join("report.json"))?)?;
    let number = |key: &str| told[key].as_f64().ok_or("a figure is missing");
    Ok(WholeRun {
        wall_s: number("wall_s")?,
        processor_s: number("processor_s")?,
        peak_bytes: number("peak_bytes")?,
        stages_s: stages_s(&report),
    })
}

/// Runs a program on a scene into a folder and tells what it took: what [`MEASURE`] asks for.
pub(crate) fn measured_here(arguments: &[String]) -> Result<()> {
    let [program, scene, out, flags @ ..] = arguments else {
        return Err("expected a program, a scene and a folder".into());
    };
    let start = Instant::now();
    let status = Command::new(program)
        .arg("run")
        .arg(scene)
        .args(["-q", "-o"].map(OsStr::new))
        .arg(out)
        .args(flags)
        .stdout(Stdio::null())
        .status()?;
    let wall_s = start.elapsed().as_secs_f64();
    if !status.success() {
        return Err("niji run failed".into());
    }
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    println!(
        "{}",
        json!({
            "wall_s": wall_s,
            "processor_s": processor_time(&usage).as_secs_f64(),
            "peak_bytes": usage.max_rss() as f64 * PEAK_UNIT_BYTES,
        })
    );
    Ok(())
}

/// Machine, commit and program.
pub(crate) fn circumstances() -> String {
    let cpus = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpus.lines().find_map(|line| {
        let (key, value) = line.split_once(':')?;
        (key.trim() == "model name").then(|| value.trim().to_owned())
    });
    let n_threads = std::thread::available_parallelism().map_or(1, usize::from);
    let commit = Command::new("git")
        .args(["describe", "--always", "--dirty"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output();
    let commit = commit.map_or_else(
        |_| "no commit".to_owned(),
        |it| String::from_utf8_lossy(&it.stdout).trim().to_owned(),
    );
    format!(
        "{}, {n_threads} threads, commit {commit}",
        model.as_deref().unwrap_or(std::env::consts::ARCH)
    )
}
