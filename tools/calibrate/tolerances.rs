//! Whether a tolerance that is asked for is met: scenes, made small, with the levels chosen for it and
//! with the reference levels.
//!
//! true error = RMSE of luminance over the picture against the reference, over the reference luminance
//!
//! The reference is the preset of that name with a tenth of the smallest tolerance for effects left out.
//! So that a scene takes minutes and not hours, it is no finer than it must be to show a missed tolerance
//! of 0.01 to a tenth of it (figures in gray cards in the sun, November 2026):
//! - the scene's exact theory where the table has few rows or a choice takes drops that exactly; the
//!   uniform one else;
//! - the error of the table doubles until it has no more than 200 rows. With drops of 10 um to 1.5 mm, a
//!   table of 0.01 instead of 0.001 changed the picture by 0.0002;
//! - lengths of air come from its table: on a hazy scene 0.0001 from quadrature;
//! - light of further orders comes from other nodes than that of the best level and, but for the
//!   nearest quarter of it, from other paths, so that the noise of both is seen;
//! - rays lie no farther apart than a tenth of a degree, and at least 12 x 12 to a pixel: where the
//!   horizon runs along a row, 4 x 4 rays instead of 9 x 9 changed a picture by 1.6 %.
//!
//! What this leaves along the rays is in the column `reference_error`: the reference's estimate of
//! itself, which knows nothing of the choice. Its estimate of so many rays is of their neighbors alone
//! and is left out.

use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::SpectralImage;
use niji_render::AirPath;
use niji_render::DropOrders;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Plan;
use niji_scene::Preset;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::Spectrum;
use niji_scene::exact_theory;
use serde::Serialize;

use crate::cli::Common;
use crate::failure::Failure;
use crate::progress;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages::accuracy;
use crate::timed_run::luminance_rmse;
use crate::timed_run::rounded;
use crate::timed_run::run_once;
use crate::timed_run::shrink;
use crate::timed_run::temporary_folder;

/// Width of the small pictures, pixels.
const WIDTH_PX: u32 = 96;

/// Their wavelengths: five bins from 380 to 780 nm.
const SPECTRUM: Spectrum = Spectrum {
    first_nm: 420.0,
    step_nm: 80.0,
    n_wavelengths: 5,
};

/// Part of the smallest tolerance that the reference may leave out.
const REFERENCE_SHARE: f64 = 0.1;

/// Most rows of an exact table, and of any, for each wavelength.
const MOST_EXACT_ROWS: usize = 2;
const MOST_ROWS: usize = 200;

/// Coarsest table of a reference.
const COARSEST_TABLE: f64 = 1e-2;

/// Light of further orders, with other nodes and so other noise than any level that is chosen.
const ORDERS: DropOrders = DropOrders::MultipleScattering {
    nodes_across: 48,
    paths_per_node: 8192,
};

/// Rays of the reference lie so far apart, degrees, but for the limits of their number along a pixel.
const RAY_SPACING_DEG: f64 = 0.1;
const RAYS_ALONG: (f64, f64) = (12.0, 16.0);

/// A tolerance, asked of a scene.
#[derive(Serialize)]
pub(super) struct Row {
    scene: String,
    tolerance: f64,
    /// Sum of what the levels are predicted to err.
    predicted_error: f64,
    /// What the run reports.
    estimated_error: Option<f64>,
    /// Against the reference.
    true_error: f64,
    predicted_seconds: Option<f64>,
    seconds: f64,
    /// The levels chosen.
    levels: String,
    /// The theory of the reference.
    reference: &'static str,
    /// What it estimates of its own error, but for its rays.
    reference_error: Option<f64>,
    reference_seconds: f64,
    date: String,
}

/// Every tolerance on every scene.
///
/// # Errors
/// A scene that cannot be run.
pub(super) fn rows(
    scenes: &[PathBuf],
    tolerances: &[f64],
    (date, common): (&str, &Common),
) -> Result<Vec<Row>, Failure> {
    let n_steps = scenes.len() * (tolerances.len() + 1);
    let bar = progress::bar("calibrate", n_steps as u64, common.verbosity());
    let smallest = tolerances.iter().copied().fold(1.0, f64::min);
    let mut rows = Vec::new();
    for path in scenes {
        let scene = small(scene_file::read(path, common)?);
        let plan_for =
            |&tolerance| scene_file::planned_for(scene.clone(), path, (tolerance, common));
        let choices: Vec<Planned> = tolerances.iter().map(plan_for).collect::<Result<_, _>>()?;
        let exact = choices
            .iter()
            .any(|asked| is_exact(asked.plan.levels.theory));
        let reference = reference((&scene, path), smallest, exact)?;
        let (expected, reference_seconds) = made(&reference)?;
        let reference_error = accuracy::estimated_along_rays(&reference, &expected).map(rounded);
        bar.inc(1);
        for (&tolerance, asked) in tolerances.iter().zip(&choices) {
            let (found, seconds) = made(asked)?;
            let reached = accuracy::reached_by(asked, &found, tolerance);
            let off = luminance_rmse(&found, &expected) / asked.plan.reference_luminance_cd_m2;
            rows.push(Row {
                scene: scene.name.clone(),
                tolerance,
                predicted_error: rounded(
                    asked.choice.as_ref().map_or(0.0, |it| it.predicted_error),
                ),
                estimated_error: reached.map(|reached| rounded(reached.error)),
                true_error: rounded(off),
                predicted_seconds: asked
                    .choice
                    .as_ref()
                    .and_then(|choice| choice.predicted_seconds)
                    .map(rounded),
                seconds: rounded(seconds),
                levels: levels(asked),
                reference: reference.plan.levels.theory.name(),
                reference_error,
                reference_seconds: rounded(reference_seconds),
                date: date.to_owned(),
            });
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// The scene with few wavelengths and a small picture of the same field of view; the layers of a
/// photograph, which end between its pixels, would have edges inside larger ones.
fn small(mut scene: Scene) -> Scene {
    scene.spectrum = SPECTRUM;
    if scene.photo.is_none() {
        shrink(&mut scene.camera, WIDTH_PX);
    }
    scene
}

/// The scene as accurately as is feasible; what it says about the drops themselves stays.
fn reference(
    (scene, path): (&Scene, &Path),
    smallest_tolerance: f64,
    exact: bool,
) -> Result<Planned, Failure> {
    let own = scene.accuracy;
    let mut accuracy = Accuracy {
        preset: Preset::Reference,
        tolerance: REFERENCE_SHARE * smallest_tolerance,
        theory: own.theory.or(Some(Theory::Uniform)),
        interpolation: own.interpolation,
        drop_extinction: own.drop_extinction,
        drop_orders: own.drop_orders.or(Some(ORDERS)),
        air_path: Some(AirPath::Table),
        ..Accuracy::default()
    };
    let planned = |accuracy: Accuracy| {
        let scene = Scene {
            accuracy,
            ..scene.clone()
        };
        scene_file::planned(scene, path)
    };
    let mut plan = planned(accuracy)?.plan;
    let n = (plan.work.pixel_deg / RAY_SPACING_DEG).ceil();
    let n = n.clamp(RAYS_ALONG.0, RAYS_ALONG.1) as u32;
    accuracy.pixel_footprint = Some(PixelFootprint::Grid { n });
    while n_rows(&plan) > MOST_ROWS && plan.levels.table_relative_error < COARSEST_TABLE {
        let coarser = (2.0 * plan.levels.table_relative_error).min(COARSEST_TABLE);
        accuracy.table_relative_error = Some(coarser);
        plan = planned(accuracy)?.plan;
    }
    if exact || n_rows(&plan) <= MOST_EXACT_ROWS {
        accuracy.theory = own.theory.or(Some(exact_theory(scene)));
    }
    planned(accuracy)
}

/// Whether a theory solves the wave equation in the drop, with one order of Debye or all.
fn is_exact(theory: Theory) -> bool {
    matches!(theory, Theory::Debye { .. } | Theory::Mie)
}

/// Rows of the scattering table that take time of their own: those that differ in variance alone share
/// their drops.
fn n_rows(plan: &Plan) -> usize {
    plan.scattering.as_ref().map_or(0, ScatteringNeed::n_rows)
}

/// Runs a plan: its picture and its time in s.
fn made(planned: &Planned) -> Result<(SpectralImage, f64), Failure> {
    let folder = temporary_folder()?;
    let start = Instant::now();
    let (_, image) = run_once(planned, folder.path())?;
    Ok((image, start.elapsed().as_secs_f64()))
}

/// The levels chosen, as `theory: mie, sky: none`.
fn levels(planned: &Planned) -> String {
    let levels = planned.choice.iter().flat_map(|choice| &choice.levels);
    let words = levels.map(|level| format!("{}: {}", level.decision, level.level));
    words.collect::<Vec<_>>().join(", ")
}
