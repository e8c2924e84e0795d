//! A scene run from nothing, several times, and how far its picture is from another.

use std::time::Instant;

use ndarray::Array3;
use niji_exchange::SpectralImage;

use crate::failure::Failure;
use crate::output::Existing;
use crate::progress::Verbosity;
use crate::run::run_stages;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::Done;
use crate::stages::Manner;

/// Runs of each level; the fastest counts, because other programs only ever slow one down.
pub(crate) const N_REPEATS: usize = 3;

/// Runs a plan from nothing several times: the fastest time of each stage, and the picture.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn timed_run(planned: &Planned) -> Result<(Vec<Done>, SpectralImage), Failure> {
    let manner = Manner {
        existing: Existing::Refuse,
        verbosity: Verbosity::Quiet,
    };
    let mut fastest: Vec<Done> = Vec::new();
    let mut image = None;
    let start = Instant::now();
    for repeat in 0..N_REPEATS {
        let folder = tempfile::tempdir().map_err(|error| Failure::Failed(error.to_string()))?;
        let done = run_stages(planned, folder.path(), manner)?.done;
        for (index, stage) in done.into_iter().enumerate() {
            match fastest.get_mut(index) {
                Some(best) => best.seconds = best.seconds.min(stage.seconds),
                None => fastest.push(stage),
            }
        }
        if repeat == 0 {
            let path = folder.path().join(stages::render::FILE);
            let read = SpectralImage::read_spectral(&path);
            image = Some(read.map_err(|error| Failure::bad_input(&path, error))?);
        }
        // Long runs are less noisy, and their repeats cost the most.
        if start.elapsed().as_secs_f64() > 5.0 {
            break;
        }
    }
    let image = image.ok_or_else(|| Failure::Failed("nothing was run".to_owned()))?;
    Ok((fastest, image))
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
