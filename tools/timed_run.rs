//! A scene run from nothing, several times, and how far its picture is from another.

use std::fs;
use std::path::Path;
use std::time::Instant;

use ndarray::Array3;
use niji_exchange::SpectralImage;
use tempfile::TempDir;

use crate::failure::Failure;
use crate::output::Existing;
use crate::progress::Verbosity;
use crate::run::run_stages;
use crate::stages;
use crate::stages::Done;
use crate::stages::StageOptions;
use niji_picture::PlannedScene;

/// Runs of each level; the fastest counts, because other programs only ever slow one down.
pub(crate) const N_REPEATS: usize = 3;

/// Runs a plan from nothing several times in a folder of its own: the fastest time of each stage, and the picture.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn timed_run(
    planned: &PlannedScene,
    folder: &Path,
) -> Result<(Vec<Done>, SpectralImage), Failure> {
    let start = Instant::now();
    let (mut fastest, image) = run_anew(planned, folder)?;
    for _ in 1..N_REPEATS {
        // Long runs are less noisy, and their repeats cost the most.
        if start.elapsed().as_secs_f64() > 5.0 {
            break;
        }
        let (done, _) = run_anew(planned, folder)?;
        for (best, stage) in fastest.iter_mut().zip(done) {
            best.seconds = best.seconds.min(stage.seconds);
        }
    }
    Ok((fastest, image))
}

/// In a folder that holds nothing before, not even what an interrupted run left, and is gone afterwards.
fn run_anew(planned: &PlannedScene, folder: &Path) -> Result<(Vec<Done>, SpectralImage), Failure> {
    let _ = fs::remove_dir_all(folder);
    let made = run_once(planned, folder);
    let _ = fs::remove_dir_all(folder);
    made
}

/// A folder that vanishes with what stands in it.
///
/// # Errors
/// A system without room for it.
pub(crate) fn temporary_folder() -> Result<TempDir, Failure> {
    tempfile::tempdir().map_err(|error| Failure::Failed(error.to_string()))
}

/// Runs a plan into a folder of one's own, where tables that fit are kept: what was done, and the
/// picture.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn run_once(
    planned: &PlannedScene,
    folder: &Path,
) -> Result<(Vec<Done>, SpectralImage), Failure> {
    let options = StageOptions {
        existing: Existing::Replace,
        verifies: false,
        verbosity: Verbosity::Quiet,
    };
    let done = run_stages(planned, folder, options)?.done;
    let path = folder.join(stages::render::FILE);
    let image = SpectralImage::read_spectral(&path);
    Ok((
        done,
        image.map_err(|error| Failure::bad_input(&path, error))?,
    ))
}

/// RMSE of spectral radiance over the RMS of the reference; 0 where that is dark.
pub(crate) fn relative_rmse(radiance: &Array3<f32>, reference: &Array3<f32>) -> f64 {
    let (mut squares, mut total) = (0.0, 0.0);
    for (&value, &expected) in radiance.iter().zip(reference) {
        squares += f64::from(value - expected).powi(2);
        total += f64::from(expected).powi(2);
    }
    if total > 0.0 {
        (squares / total).sqrt()
    } else {
        0.0
    }
}

/// Three digits: more would be noise.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}
