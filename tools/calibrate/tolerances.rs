//! Whether a tolerance that is asked for is met: scenes, made small, with the levels chosen for it and
//! with the reference levels.
//!
//! true error = RMSE of luminance over the picture against the reference, over the reference luminance
//!
//! The reference is the preset of that name with a tenth of the smallest tolerance for effects left out;
//! the scene's exact theory where the table has few rows, and the uniform one where exact rows would
//! take hours; and rays no farther apart than a tenth of a degree.

use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use niji_exchange::SpectralImage;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::Spectrum;
use niji_scene::exact_theory;
use serde::Serialize;

use crate::cli::Common;
use crate::failure::Failure;
use crate::progress;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::accuracy;
use crate::timed_run::luminance_rmse;
use crate::timed_run::rounded;
use crate::timed_run::run_once;
use crate::timed_run::temporary_folder;

/// Width of the small pictures, pixels.
const WIDTH_PX: u32 = 96;

/// Their wavelengths: nine bins from 380 to 780 nm.
const SPECTRUM: Spectrum = Spectrum {
    first_nm: 380.0,
    step_nm: 50.0,
    n_wavelengths: 9,
};

/// Part of the smallest tolerance that the reference may leave out.
const REFERENCE_SHARE: f64 = 0.1;

/// Most rows of an exact table, for each wavelength.
const MOST_EXACT_ROWS: usize = 64;

/// Rays of the reference lie so far apart, degrees, but for the limits of their number along a pixel.
const RAY_SPACING_DEG: f64 = 0.1;
const RAYS_ALONG: (f64, f64) = (4.0, 16.0);

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
        let reference = reference(&scene, path, smallest)?;
        let (_, expected, reference_seconds) = made(&reference)?;
        bar.inc(1);
        for &tolerance in tolerances {
            let asked = scene_file::planned_for(scene.clone(), path, (tolerance, common))?;
            let (folder, found, seconds) = made(&asked)?;
            let image = folder.path().join(stages::render::FILE);
            let reached = accuracy::reached(&asked, &image, tolerance)?;
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
                levels: levels(&asked),
                reference: reference.plan.levels.theory.name(),
                reference_seconds: rounded(reference_seconds),
                date: date.to_owned(),
            });
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// The scene with a small picture of the same field of view and few wavelengths.
fn small(mut scene: Scene) -> Scene {
    scene.spectrum = SPECTRUM;
    let camera = &mut scene.camera;
    let shrink = f64::from(WIDTH_PX) / f64::from(camera.width_px);
    if shrink < 1.0 {
        // An even number of rows: a panorama is twice as wide as high.
        let half_height = (0.5 * f64::from(camera.height_px) * shrink)
            .round()
            .max(1.0);
        camera.height_px = 2 * half_height as u32;
        camera.width_px = WIDTH_PX;
        camera.overscan_px = 0;
    }
    scene
}

/// The scene as accurately as is feasible; what it says about the drops themselves stays.
fn reference(scene: &Scene, path: &Path, smallest_tolerance: f64) -> Result<Planned, Failure> {
    let own = scene.accuracy;
    let mut accuracy = Accuracy {
        preset: Preset::Reference,
        tolerance: REFERENCE_SHARE * smallest_tolerance,
        theory: own.theory.or(Some(Theory::Uniform)),
        interpolation: own.interpolation,
        drop_extinction: own.drop_extinction,
        drop_orders: own.drop_orders,
        ..Accuracy::default()
    };
    let planned = |accuracy: Accuracy| {
        let scene = Scene {
            accuracy,
            ..scene.clone()
        };
        scene_file::planned(scene, path)
    };
    let plan = planned(accuracy)?.plan;
    let along = (plan.work.pixel_deg / RAY_SPACING_DEG).ceil();
    let n = along.clamp(RAYS_ALONG.0, RAYS_ALONG.1) as u32;
    accuracy.pixel_footprint = Some(PixelFootprint::Grid { n });
    let n_rows = plan.scattering.map_or(0, |need| {
        need.effective_radius_um.len() * need.effective_variance.len() * need.flattening.len()
    });
    if n_rows <= MOST_EXACT_ROWS {
        accuracy.theory = own.theory.or(Some(exact_theory(scene)));
    }
    planned(accuracy)
}

/// Runs a plan: the folder with its files, its picture and its time in s.
fn made(planned: &Planned) -> Result<(tempfile::TempDir, SpectralImage, f64), Failure> {
    let folder = temporary_folder()?;
    let start = Instant::now();
    let (_, image) = run_once(planned, folder.path())?;
    Ok((folder, image, start.elapsed().as_secs_f64()))
}

/// The levels chosen, as `theory: mie, sky: none`.
fn levels(planned: &Planned) -> String {
    let levels = planned.choice.iter().flat_map(|choice| &choice.levels);
    let words = levels.map(|level| format!("{}: {}", level.decision, level.level));
    words.collect::<Vec<_>>().join(", ")
}
