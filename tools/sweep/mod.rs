//! `niji sweep`: what accuracy costs in time, for one scene: every level of every decision in place of
//! the scene's own, and the presets, each run from nothing and set against the reference preset.

mod levels;
mod page;
mod picture_distance;
mod point;

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_scene::Accuracy;
use niji_scene::Preset;
use niji_scene::Scene;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::output::Existing;
use crate::plot::Cloud;
use crate::progress;
use crate::scene_file;
use crate::sweep::levels::DECISIONS;
use crate::sweep::page::Page;
use crate::sweep::point::Point;
use crate::sweep::point::Runs;
use niji_picture::PlannedScene;

/// Name under which presets stand among the decisions.
const PRESET: &str = "preset";
/// The table of all points.
const CSV: &str = "sweep.csv";
/// Error against time.
const PLOT: &str = "sweep.svg";
/// Everything on one page.
const PAGE: &str = "sweep.html";
/// Runs that an interrupted sweep goes on from.
const RUNS: &str = "runs";
/// First columns of the table.
const TABLE_HEAD: &str = "decision,level,seconds,";

/// Show what accuracy costs in time for one scene: CSV, SVG and a page of HTML.
///
/// Runs the presets, and every level of every decision in place of the scene's own, each from nothing.
/// The error is relative to the preset `reference`; that against the best level of the same decision
/// stands beside it. An interrupted sweep goes on where it was.
#[derive(Debug, Args)]
#[command(after_help = "Example:
  niji sweep data/scenes/paper-c-figure-3.toml -o sweep

Writes sweep.csv, sweep.svg and sweep.html (pictures, maps of the differences and the Pareto front
inside). Columns: decision, level, seconds, peak_memory_mb, relative_rmse (of spectral radiance),
own_relative_rmse (against the best level of the decision), max_over_white, mean_color_difference,
max_color_difference (CIEDE2000 of the previews), on_front.")]
pub(crate) struct SweepCommand {
    /// The scene.
    scene: PathBuf,
    /// The folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
}

/// Runs the sweep.
///
/// # Errors
/// A scene that cannot be run, or an output that exists or cannot be written.
pub(crate) fn execute(command: &SweepCommand, common: &Common) -> Result<(), Failure> {
    let options = common.options();
    let folder = &command.output;
    let [csv, plot, page] = [CSV, PLOT, PAGE].map(|name| folder.join(name));
    let runs = folder.join(RUNS);
    let existing = if was_killed(&csv, &runs) {
        Existing::Replace
    } else {
        options.existing
    };
    for path in [&csv, &plot, &page] {
        output::check_free(path, existing)?;
    }
    let cannot = |error: std::io::Error| Failure::Failed(format!("{}: {error}", folder.display()));
    fs::create_dir_all(&runs).map_err(cannot)?;
    let scene = scene_file::read(&command.scene, common)?;
    let planned = scene_file::planned(scene.clone(), &command.scene, common)?;
    planned.check_light()?;
    let variants = variants(&planned);
    let bar = progress::bar("sweep", variants.len() as u64 + 1, options.verbosity);
    let with = |accuracy: Accuracy| {
        let scene = Scene {
            accuracy,
            ..scene.clone()
        };
        planned.replanned(scene)
    };
    let mut runs = Runs::new(
        &runs,
        options.verifies,
        &with(of_preset(&scene, Preset::Reference))?,
    )?;
    bar.inc(1);
    let mut points = Vec::new();
    for variant in &variants {
        points.push(runs.point(variant, &with(variant.accuracy)?)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    mark_front(&mut points);
    write(&planned, &points, &runs, [&csv, &plot, &page])?;
    runs.remove();
    let written = [&page, &csv, &plot].map(|path| format!("{}\n", path.display()));
    output::print(&written.concat())
}

/// Whether a sweep was killed while it wrote its results: then its runs still stand beside its table, the first of them.
fn was_killed(csv: &Path, runs: &Path) -> bool {
    let table = fs::read_to_string(csv).unwrap_or_default();
    runs.is_dir() && table.starts_with(TABLE_HEAD)
}

/// One choice in place of the scene's.
pub(crate) struct Variant {
    /// The decision, or [`PRESET`].
    pub(crate) decision: &'static str,
    /// What is chosen.
    pub(crate) accuracy: Accuracy,
    /// Whether it is the best level of its decision.
    pub(crate) is_best: bool,
}

/// A preset for a scene, which keeps what it says about the drops themselves.
fn of_preset(scene: &Scene, preset: Preset) -> Accuracy {
    Accuracy {
        preset,
        tolerance: scene.accuracy.tolerance,
        interpolation: scene.accuracy.interpolation,
        drop_extinction: scene.accuracy.drop_extinction,
        drop_orders: scene.accuracy.drop_orders,
        ..Accuracy::default()
    }
}

/// Presets, then the levels of each decision, best first: the others are compared with it.
fn variants(planned: &PlannedScene) -> Vec<Variant> {
    let scene = &planned.scene;
    let presets = [Preset::Reference, Preset::Standard, Preset::Draft];
    let mut variants: Vec<Variant> = presets
        .into_iter()
        .map(|preset| Variant {
            decision: PRESET,
            accuracy: of_preset(scene, preset),
            is_best: preset == Preset::Reference,
        })
        .collect();
    let voxel_m = planned.plan.voxel_m;
    for decision in DECISIONS
        .iter()
        .filter(|decision| decision.concerns(scene, &planned.plan))
    {
        let changes = decision
            .levels_for(&planned.plan)
            .into_iter()
            .rev()
            .enumerate();
        variants.extend(changes.map(|(index, change)| {
            let mut accuracy = scene.accuracy;
            change(&mut accuracy, voxel_m);
            Variant {
                decision: decision.key,
                accuracy,
                is_best: index == 0,
            }
        }));
    }
    variants
}

/// Marks the points that no other beats in time and error at once.
fn mark_front(points: &mut [Point]) {
    let costs: Vec<(f64, f64)> = points
        .iter()
        .map(|point| (point.seconds, point.relative_rmse))
        .collect();
    for (point, cost) in points.iter_mut().zip(&costs) {
        point.on_front = !costs.iter().any(|other| {
            other.0 <= cost.0 && other.1 <= cost.1 && (other.0 < cost.0 || other.1 < cost.1)
        });
    }
}

fn write(
    planned: &PlannedScene,
    points: &[Point],
    runs: &Runs,
    [csv, plot, page]: [&Path; 3],
) -> Result<(), Failure> {
    output::write_csv(csv, points)?;
    let svg = cloud(planned, points).svg()?;
    output::write_text(plot, &svg)?;
    let page_of = Page {
        title: &planned.scene.name,
        points,
        plot: &svg,
    };
    let html = page_of.html(runs)?;
    output::write_text(page, &html)
}

/// Error against time, a color for each decision.
fn cloud(planned: &PlannedScene, points: &[Point]) -> Cloud {
    let mut groups: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for point in points {
        let place = (point.seconds, point.relative_rmse);
        match groups.iter_mut().find(|(name, _)| *name == point.decision) {
            Some((_, places)) => places.push(place),
            None => groups.push((point.decision.clone(), vec![place])),
        }
    }
    let mut front: Vec<(f64, f64)> = points
        .iter()
        .filter(|point| point.on_front)
        .map(|point| (point.seconds, point.relative_rmse))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    Cloud {
        title: format!("{}: what accuracy costs", planned.scene.name),
        x_label: "time of the whole run (s)",
        y_label: "relative RMSE against the reference preset",
        groups,
        front,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_table_of_ours_beside_kept_runs_is_of_a_killed_sweep() {
        let folder = tempfile::tempdir().unwrap();
        let (csv, runs) = (folder.path().join(CSV), folder.path().join(RUNS));
        assert!(!was_killed(&csv, &runs));
        output::write_csv(&csv, &[Point::default()]).unwrap();
        assert!(!was_killed(&csv, &runs));
        fs::create_dir(&runs).unwrap();
        assert!(was_killed(&csv, &runs));
        fs::write(&csv, "mine,too\n").unwrap();
        assert!(!was_killed(&csv, &runs));
    }
}
