//! The scenes of `tests/unprepared`, on which nothing is fitted, beside truths far beyond what is asked of
//! pictures.
//!
//! A truth is the same picture at half of the smallest tolerance tried, with every effect on that may change it,
//! exact theory (of scenes with drops too large for that the theory by size), half of the grid spacing of authored
//! drops, sunlight followed through every cell, and 4 x 4 pixels for each of its own, each with up to 256 rays where
//! edges ask for them. What is kept of it is luminance over that of display white.
//!
//!     cargo bench --bench unprepared -- truths [SCENE]...
//!     cargo bench --bench unprepared -- measure [SCENE]... [-- FLAGS OF NIJI RUN]
//!     cargo bench --bench unprepared -- lines [SCENE]...
//!     cargo bench --bench unprepared -- seconds [SCENE]...
//!     cargo bench --bench unprepared -- cheapest [SCENE]...
//!     cargo bench --bench unprepared -- draw SEED FOLDER
//!
//! A scene is a name in `tests/unprepared` or the path of a file, whose truth then lies in `truths` beside it.
//! `draw` writes twelve scenes that follow from a seed alone, hexadecimal digits such as the hash of a commit.
//!
//! `measure` runs the program as a stranger does and prints, in percent of display white, the true RMS
//! error, the error that was told, and of the pixels whose error is above 0.01 % how many err by no more than
//! the layer `error` says and how many times too much it says in the median. `lines` does what the lines
//! `cheaper:` at the end of a run say, each by itself, and prints what they promised beside what came of it. `seconds`
//! does the same for the lines of `niji plan --seconds`, up to runs of a minute; it needs no truth. `cheapest`
//! looks for a way to make each picture that would have kept the tolerance and costs less than the chosen one.

#[cfg(unix)]
#[path = "unprepared/cheapest.rs"]
mod cheapest;
#[path = "unprepared/draw.rs"]
mod draw;
#[cfg(unix)]
#[path = "support/processor_time.rs"]
mod processor_time;

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;
use std::time::Instant;

use ndarray::Array2;
use ndarray::s;
use niji_exchange::Channel;
use niji_exchange::PlainPart;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
use niji_exchange::read_plain;
use niji_exchange::write_plain;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::Scene;
use niji_picture::scene_from_toml;
use niji_picture::unwatched;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::SunPath;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Effect;
use niji_scene::Preset;
use niji_scene::Switch;
use serde_json::Value;

use draw::Dice;

/// Pixels of a truth along each side of a pixel.
const FINER: usize = 4;
/// Tolerance of the truth; pixels of it get more rays at a third of that.
const FINEST: f64 = 2e-4;
/// Light of further orders, whose noise would else be as much as the tolerance has room for: told 0.01 % of display
/// white on fog of 20 um, where errors are counted from as much on.
const ORDERS: DropOrders = DropOrders::MultipleScattering {
    nodes_across: 24,
    paths_per_node: 1 << 17,
};
/// Largest error of the scattering table, relative to its peak.
const TABLE_ERROR: f64 = 1e-3;
/// Errors below are not counted against the layer `error`.
const LEAST_COUNTED: f64 = 1e-4;
/// No run that is told to take longer is made, seconds.
const LONGEST_S: f64 = 60.0;
/// Scenes of a seed.
const N_DRAWN: usize = 12;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

fn main() -> Result<()> {
    // Cargo adds `--bench`.
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|it| it != "--bench")
        .collect();
    let mut parts = arguments.split(|it| it == "--");
    let asked = parts.next().unwrap_or_default();
    let flags = parts.next().unwrap_or_default();
    let rest = asked.get(1..).unwrap_or_default();
    match (asked.first().map(String::as_str), rest) {
        (Some("truths"), _) => names(rest)?.iter().try_for_each(|name| make_truth(name)),
        (Some("measure"), _) => measure(&names(rest)?, flags),
        (Some("lines"), _) => names(rest)?.iter().try_for_each(|name| hold_lines(name)),
        (Some("seconds"), _) => names(rest)?.iter().try_for_each(|name| hold_seconds(name)),
        #[cfg(unix)]
        (Some("cheapest"), _) => names(rest)?
            .iter()
            .try_for_each(|name| cheapest::search(name)),
        (Some("draw"), [seed, folder]) => draw_scenes(seed, Path::new(folder)),
        _ => Err(
            "say `truths`, `measure`, `lines`, `seconds` or `cheapest`, then names of scenes, or `draw SEED FOLDER`"
                .into(),
        ),
    }
}

/// Writes the scenes of a seed.
fn draw_scenes(seed: &str, folder: &Path) -> Result<()> {
    let mut dice = Dice::new(seed).ok_or("a seed is of hexadecimal digits")?;
    std::fs::create_dir_all(folder)?;
    for (index, text) in draw::scenes(&mut dice, N_DRAWN).iter().enumerate() {
        std::fs::write(folder.join(format!("drawn-{}.toml", index + 1)), text)?;
    }
    Ok(())
}

/// Where the scenes lie.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/unprepared")
}

fn scene_file(name: &str) -> PathBuf {
    let path = PathBuf::from(name);
    if path.extension().is_some_and(|it| it == "toml") {
        return path;
    }
    folder().join(format!("{name}.toml"))
}

fn truth_file(name: &str) -> PathBuf {
    let scene = scene_file(name).with_extension("exr");
    let file = scene.file_name().unwrap_or_default();
    scene.with_file_name("truths").join(file)
}

/// The scenes that are asked for, all where none is.
fn names(asked: &[String]) -> Result<Vec<String>> {
    if !asked.is_empty() {
        return Ok(asked.to_vec());
    }
    let mut names = Vec::new();
    for entry in folder().read_dir()? {
        let path = entry?.path();
        if path.extension().is_some_and(|it| it == "toml")
            && let Some(name) = path.file_stem()
        {
            names.push(name.to_string_lossy().into_owned());
        }
    }
    names.sort();
    Ok(names)
}

/// A scene with every number of pixels times [`FINER`] and half of the grid spacing.
fn finer(text: &str) -> Result<String> {
    let mut finer = String::new();
    for line in text.lines() {
        let changed = match line.split_once(" = ") {
            Some((key @ ("width_px" | "height_px"), number)) => {
                let n: usize = number.parse()?;
                format!("{key} = {}", FINER * n)
            }
            Some((key @ "voxel_m", number)) => format!("{key} = {}", 0.5 * number.parse::<f64>()?),
            _ => line.to_owned(),
        };
        finer += &changed;
        finer.push('\n');
    }
    Ok(finer)
}

/// The truth of a scene, planned.
fn truth(name: &str) -> Result<PlannedScene> {
    let file = scene_file(name);
    let folder = file.parent().unwrap_or(Path::new("."));
    let text = std::fs::read_to_string(&file)?;
    let mut scene: Scene = scene_from_toml(&finer(&text)?, folder)?;
    scene.accuracy = Accuracy {
        preset: Preset::Standard,
        tolerance: Some(FINEST),
        theory: Some(Theory::Mie),
        table_relative_error: Some(TABLE_ERROR),
        integration: Some(Integration::Adaptive {
            relative_error: 1e-6,
        }),
        ..scene.accuracy
    };
    let request = PlanRequest {
        folder,
        ..PlanRequest::default()
    };
    let first = PlannedScene::new(scene.clone(), request).or_else(|_| {
        scene.accuracy.theory = None;
        PlannedScene::new(scene.clone(), request)
    })?;
    scene.accuracy.sun_path = Some(SunPath::March {
        step_m: first.plan.voxel_m,
    });
    scene.accuracy.drop_orders = Some(ORDERS);
    let seen = first.plan.effects.iter().filter(|it| {
        it.asked == Switch::Auto && !it.effect.comes_with_theory() && it.bound.value > 0.0
    });
    for decision in seen {
        scene.effects.set(decision.effect, Switch::On);
    }
    Ok(PlannedScene::new(scene, request)?)
}

fn make_truth(name: &str) -> Result<()> {
    let start = Instant::now();
    let planned = truth(name)?;
    let image = planned.picture(&unwatched)?;
    let white = planned.plan.display_white_cd_m2;
    let fine = luminance(&image.radiance, &image.wavelengths) / white;
    let (height, width) = (fine.nrows() / FINER, fine.ncols() / FINER);
    let mean = Array2::from_shape_fn((height, width), |(y, x)| {
        let (top, left) = (FINER * y, FINER * x);
        let inside = fine.slice(s![top..top + FINER, left..left + FINER]);
        inside.sum() / (FINER * FINER) as f64
    });
    let path = truth_file(name);
    std::fs::create_dir_all(path.parent().unwrap_or(&path))?;
    let channel = Channel {
        name: "Y".to_owned(),
        values: mean.mapv(|value| value as f32),
    };
    let part = PlainPart {
        name: "luminance".to_owned(),
        channels: vec![channel],
    };
    write_plain(&[part], BufWriter::new(File::create(&path)?))?;
    let on: Vec<&str> = planned.plan.effects_on().map(Effect::name).collect();
    println!(
        "{name}: {:.0} s, {}, mean {:.4} of white, {}",
        start.elapsed().as_secs_f64(),
        planned.plan.levels.theory.name(),
        mean.mean().unwrap_or(0.0),
        on.join(" ")
    );
    Ok(())
}

fn measure(names: &[String], flags: &[String]) -> Result<()> {
    println!(
        "{:<20} {:>4} {:>8} {:>8} {:>7} {:>8} {:>7}",
        "scene", "code", "true %", "told %", "s", "covered", "times"
    );
    for name in names {
        let run = match Run::of((name, &scene_file(name)), flags)? {
            Ok(run) => run,
            Err((code, said)) => {
                println!("{name:<20} {code:>4} {said}");
                continue;
            }
        };
        let (covered, times) = run.coverage();
        println!(
            "{name:<20} {:>4} {:>8.4} {:>8.4} {:>7.2} {covered:>8.3} {times:>7.2}",
            run.code,
            100.0 * run.true_error(),
            100.0 * run.told(),
            run.seconds
        );
    }
    Ok(())
}

/// Runs a scene, then with the change of each line `cheaper:`.
fn hold_lines(name: &str) -> Result<()> {
    let path = scene_file(name);
    let asked = Run::of((name, &path), &[])?.map_err(|(_, said)| said)?;
    let text = std::fs::read_to_string(&path)?;
    for line in asked.report["cheaper"].as_array().into_iter().flatten() {
        let number = |key: &str| line[key].as_f64().ok_or("a line without its numbers");
        let change = line["change"].as_str().ok_or("a line without its change")?;
        // Beside the scene, whose files have names from there.
        let changed = tempfile::Builder::new()
            .suffix(".toml")
            .tempfile_in(path.parent().unwrap_or(Path::new(".")))?;
        std::fs::write(changed.path(), with_key(&text, change)?)?;
        let run = Run::of((name, changed.path()), &[])?.map_err(|(_, said)| said)?;
        println!(
            "{name:<20} {change:<46} less: said {:>6.2} s, found {:>6.2} s; error: said {:.3} %, told then \
             {:.3} %, true {:.3} %",
            number("seconds")?,
            asked.seconds - run.seconds,
            100.0 * number("error")?,
            100.0 * run.told(),
            100.0 * run.true_error()
        );
    }
    Ok(())
}

/// Runs a scene for each tolerance that `niji plan --seconds` tells of.
fn hold_seconds(name: &str) -> Result<()> {
    let niji = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_niji"));
        command.args(words);
        command
    };
    let scene = scene_file(name);
    let scene = scene.to_str().ok_or("a path that is no text")?;
    let told = niji(&["plan", scene, "--seconds", "--json"]).output()?;
    let lines: Vec<Value> = serde_json::from_slice(&told.stdout)?;
    for line in lines {
        let said = line["seconds"].as_f64().ok_or("a line without seconds")?;
        if said > LONGEST_S {
            break;
        }
        let tolerance = line["tolerance"].to_string();
        let out = tempfile::tempdir()?;
        let start = Instant::now();
        let run = niji(&["run", scene, "--quiet", "--tolerance", &tolerance, "-o"]);
        { run }.arg(out.path()).output()?;
        let found = start.elapsed().as_secs_f64();
        println!(
            "{name:<24} {tolerance:>6} said {said:>6.1} s, found {found:>6.1} s, {:.2} times",
            said / found
        );
    }
    Ok(())
}

/// A scene with a key as a line says it, `section.key = value`.
fn with_key(text: &str, change: &str) -> Result<String> {
    let (key, value) = change.split_once(" = ").ok_or("expected a key = value")?;
    let (section, key) = key.split_once('.').ok_or("expected a section.key")?;
    let mut scene: toml::Table = text.parse()?;
    let section = scene.entry(section).or_insert(toml::Table::new().into());
    let keys = section.as_table_mut().ok_or("expected a section")?;
    let line: toml::Table = format!("value = {value}").parse()?;
    keys.extend(line.into_iter().map(|(_, value)| (key.to_owned(), value)));
    Ok(toml::to_string(&scene)?)
}

/// What a run of the program made of a scene.
struct Run {
    code: i32,
    seconds: f64,
    report: Value,
    /// Over display white, by row and column.
    off: Array2<f64>,
    estimate: Option<Array2<f64>>,
}

impl Run {
    /// Of a scene whose truth has that name; the code and what was said last where there is no picture.
    fn of((name, scene): (&str, &Path), flags: &[String]) -> Result<Outcome> {
        let out = tempfile::tempdir()?;
        let start = Instant::now();
        let ended = Command::new(env!("CARGO_BIN_EXE_niji"))
            .arg("run")
            .arg(scene)
            .arg("-o")
            .arg(out.path())
            .args(flags)
            .output()?;
        let seconds = start.elapsed().as_secs_f64();
        let code = ended.status.code().unwrap_or(-1);
        let Ok(report) = std::fs::read_to_string(out.path().join("report.json")) else {
            let said = String::from_utf8_lossy(&ended.stderr).into_owned();
            let last = said.lines().last().unwrap_or_default();
            return Ok(Err((code, last.to_owned())));
        };
        let report: Value = serde_json::from_str(&report)?;
        let white = report["plan"]["display_white_cd_m2"].as_f64();
        let white = white.ok_or("a report without its white")?;
        let image = SpectralImage::read_spectral(&out.path().join("image.exr"))?;
        let found = luminance(&image.radiance, &image.wavelengths) / white;
        let truth = read_plain(&truth_file(name))?;
        let truth = truth[0].channels[0].values.mapv(f64::from);
        let estimate = (image.aovs.iter()).find(|aov| aov.name == "error");
        Ok(Ok(Self {
            code,
            seconds,
            report,
            off: found - &truth,
            estimate: estimate.map(|aov| aov.channels[0].1.mapv(|it| f64::from(it) / white)),
        }))
    }

    /// RMS over the pixels.
    fn true_error(&self) -> f64 {
        (self.off.mapv(|it| it * it).sum() / self.off.len() as f64).sqrt()
    }

    /// What the program said of that.
    fn told(&self) -> f64 {
        let told = self.report["accuracy"]["error"].as_f64();
        told.unwrap_or(f64::NAN)
    }

    /// Part of the pixels whose error is told, and how many times too much in the median.
    fn coverage(&self) -> (f64, f64) {
        let estimate = self.estimate.as_ref();
        estimate.map_or((f64::NAN, f64::NAN), |it| coverage(&self.off, it))
    }
}

/// A run, or the code and the last line of one without a picture.
type Outcome = std::result::Result<Run, (i32, String)>;

/// Part of the pixels with an error that is told, and estimate over error in the median.
fn coverage(off: &Array2<f64>, estimate: &Array2<f64>) -> (f64, f64) {
    let mut times: Vec<f64> = (off.iter().zip(estimate))
        .filter(|(off, _)| off.abs() > LEAST_COUNTED)
        .map(|(off, estimate)| estimate / off.abs())
        .collect();
    times.sort_by(f64::total_cmp);
    let told = times.iter().filter(|it| **it >= 1.0).count();
    let n = times.len().max(1);
    (
        told as f64 / n as f64,
        times.get(n / 2).copied().unwrap_or(1.0),
    )
}
