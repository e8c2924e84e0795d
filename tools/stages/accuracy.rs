//! Whether a picture is as accurate as was asked for, and what limits it where it is not.
//!
//! error = what the renderer estimated, RMS over the pixels + what the levels that it cannot judge are
//! predicted to cost: theory, air and sky.

use std::path::Path;

use niji_exchange::Aov;
use niji_exchange::SpectralImage;
use niji_scene::SHARE_FOR_LEVELS;
use serde::Serialize;

use crate::failure::Failure;
use crate::scene_file::Planned;

/// Name of the estimated error among the images.
pub(crate) const AOV: &str = "error";

/// Channel of all causes together.
pub(crate) const TOTAL: &str = "Y";

/// Decisions that the renderer takes as given: their errors are not in its estimate.
const NOT_ESTIMATED: [&str; 3] = ["theory", "air_path", "sky"];

/// Channel of what the rays of a pixel miss.
const FOOTPRINT: &str = "footprint";

/// What to do about each cause of error, by its channel.
const REMEDIES: [(&str, &str); 7] = [
    (
        FOOTPRINT,
        "edges for which 256 rays a pixel are too few: render it larger",
    ),
    (
        "orders",
        "multiple scattering, its noise and what lies between its directions: more paths_per_node or \
         nodes_across in accuracy.drop_orders",
    ),
    (
        "quadrature",
        "the integral along the rays: a smaller relative_error in accuracy.integration",
    ),
    (
        "shadow",
        "the way of sunlight through the drops: a smaller voxel_m in accuracy.sun_path, then smaller \
         voxels of the drops",
    ),
    (
        "air",
        "the air's light along the rays: a smaller relative_error in accuracy.integration",
    ),
    (
        "angles",
        "the table's angles and flattenings: make it with more, by a smaller \
         accuracy.table_relative_error",
    ),
    (
        "sizes",
        "the table's sizes: make it with more radii, by a smaller accuracy.table_relative_error",
    ),
];

/// How accurate a picture is, in parts of the reference luminance.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Reached {
    /// What was asked of the levels: half of the tolerance.
    allowed: f64,
    /// Estimated RMSE of luminance.
    pub(crate) error: f64,
    /// The part of it that the renderer estimated.
    estimated: f64,
    /// The part that was predicted of theory, air and sky.
    predicted: f64,
    /// What causes most of it, and what to do.
    #[serde(skip)]
    largest: (f64, String),
}

impl Reached {
    /// The error in words.
    pub(crate) fn text(&self) -> String {
        format!(
            "error reached: {:.2e} of {:.2e} allowed ({:.1e} estimated by the renderer, {:.1e} predicted \
             of theory, air and sky)",
            self.error, self.allowed, self.estimated, self.predicted
        )
    }
}

/// How accurate a picture is; `None` if it holds no estimate.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn reached(
    planned: &Planned,
    image: &Path,
    tolerance: f64,
) -> Result<Option<Reached>, Failure> {
    let picture = SpectralImage::read_spectral(image).map_err(|e| Failure::bad_input(image, e))?;
    Ok(reached_by(planned, &picture, tolerance))
}

/// How accurate a picture is that was read; `None` if it holds no estimate.
pub(crate) fn reached_by(
    planned: &Planned,
    picture: &SpectralImage,
    tolerance: f64,
) -> Option<Reached> {
    let error = estimate(picture)?;
    let reference = planned.plan.reference_luminance_cd_m2;
    let levels = planned.choice.iter().flat_map(|choice| &choice.levels);
    let given = levels.filter(|level| NOT_ESTIMATED.contains(&level.decision));
    let predictions = given.filter_map(|level| Some((level.error?, level)));
    let remedies =
        REMEDIES.map(|(cause, remedy)| (rms(error, cause) / reference, remedy.to_owned()));
    let of_levels = predictions.clone().map(|(error, level)| {
        let remedy = format!("{} = {}: a better level", level.decision, level.level);
        (error, remedy)
    });
    let none = (0.0, "a more accurate preset".to_owned());
    let more =
        |most: (f64, String), cause: (f64, String)| if cause.0 > most.0 { cause } else { most };
    let estimated = rms(error, TOTAL) / reference;
    let predicted = predictions.map(|(error, _)| error).sum();
    Some(Reached {
        allowed: SHARE_FOR_LEVELS * tolerance,
        error: estimated + predicted,
        estimated,
        predicted,
        largest: remedies.into_iter().chain(of_levels).fold(none, more),
    })
}

/// What the renderer estimated of a picture but for its rays, in parts of the reference luminance;
/// `None` if it holds no estimate.
pub(crate) fn estimated_along_rays(planned: &Planned, picture: &SpectralImage) -> Option<f64> {
    let error = estimate(picture)?;
    let causes = REMEDIES.iter().map(|(cause, _)| *cause);
    let along = causes.filter(|cause| *cause != FOOTPRINT);
    let squares: f64 = along.map(|cause| rms(error, cause).powi(2)).sum();
    Some(squares.sqrt() / planned.plan.reference_luminance_cd_m2)
}

fn estimate(picture: &SpectralImage) -> Option<&Aov> {
    picture.aovs.iter().find(|aov| aov.name == AOV)
}

/// Refuses a picture that misses its tolerance, naming the largest cause.
///
/// # Errors
/// [`Failure::AccuracyNotReached`].
pub(crate) fn verdict(reached: &Reached) -> Result<(), Failure> {
    let Reached { error, allowed, .. } = reached;
    if error <= allowed {
        return Ok(());
    }
    let (largest, remedy) = &reached.largest;
    Err(Failure::AccuracyNotReached(format!(
        "the estimated error of the picture is {error:.2e}, expected at most {allowed:.2e}, half of \
         the tolerance; {largest:.1e} of it comes from {remedy} (the picture was written)"
    )))
}

/// Checks that the error of a picture keeps to the part of the tolerance that is for levels.
///
/// # Errors
/// A file that cannot be read; as [`verdict`].
pub(crate) fn check(planned: &Planned, image: &Path, tolerance: f64) -> Result<(), Failure> {
    let reached = reached(planned, image, tolerance)?;
    reached.map_or(Ok(()), |reached| verdict(&reached))
}

/// Root of the mean square of a channel; 0 where there is none.
fn rms(error: &Aov, channel: &str) -> f64 {
    let of_channel = error.channels.iter().find(|(name, _)| name == channel);
    of_channel.map_or(0.0, |(_, values)| {
        let squares: f64 = values.iter().map(|value| f64::from(*value).powi(2)).sum();
        (squares / values.len().max(1) as f64).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use ndarray::array;

    use super::*;

    #[test]
    fn the_rms_is_that_of_the_channel() {
        let error = Aov {
            name: AOV.to_owned(),
            unit: "cd/m^2".to_owned(),
            channels: vec![(TOTAL.to_owned(), array![[3.0, 4.0], [0.0, 0.0]])],
        };
        assert_eq!(rms(&error, TOTAL), 2.5);
        assert_eq!(rms(&error, "sizes"), 0.0);
    }
}
