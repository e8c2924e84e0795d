//! Whether a picture is as accurate as was asked for, and what limits it where it is not.

use std::path::Path;

use niji_exchange::Aov;
use niji_exchange::SpectralImage;

use crate::failure::Failure;
use crate::scene_file::Planned;

/// Part of a tolerance that is for levels; the rest is for effects that are left out.
pub(crate) const SHARE_FOR_LEVELS: f64 = 0.5;

/// Name of the estimated error among the images.
pub(crate) const AOV: &str = "error";

/// Channel of all causes together.
pub(crate) const TOTAL: &str = "Y";

/// What to do about each cause of error, by its channel.
const REMEDIES: [(&str, &str); 5] = [
    (
        "footprint",
        "64 rays a pixel are too few for it: render it larger",
    ),
    (
        "orders",
        "noise of multiple scattering: more paths_per_node in accuracy.drop_orders",
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
        "sizes",
        "the table's sizes: make it with more radii, by a smaller accuracy.table_relative_error",
    ),
];

/// Checks that the estimated error of a picture, RMS over its pixels, keeps to the part of the
/// tolerance that is for levels.
///
/// # Errors
/// A file that cannot be read; [`Failure::AccuracyNotReached`], which names the largest cause.
pub(crate) fn check(planned: &Planned, image: &Path, tolerance: f64) -> Result<(), Failure> {
    let parts = SpectralImage::read_spectral(image).map_err(|e| Failure::bad_input(image, e))?;
    let Some(error) = parts.aovs.iter().find(|aov| aov.name == AOV) else {
        return Ok(());
    };
    let reference = planned.plan.reference_luminance_cd_m2;
    let reached = rms(error, TOTAL) / reference;
    let allowed = SHARE_FOR_LEVELS * tolerance;
    if reached <= allowed {
        return Ok(());
    }
    let causes = REMEDIES.map(|(cause, remedy)| (rms(error, cause) / reference, remedy));
    let (largest, remedy) =
        causes
            .into_iter()
            .fold((0.0, "a more accurate preset"), |most, cause| {
                if cause.0 > most.0 { cause } else { most }
            });
    Err(Failure::AccuracyNotReached(format!(
        "the estimated error of the picture is {reached:.1e}, expected at most {allowed:.1e}, half of \
         the tolerance; {largest:.1e} of it comes from {remedy} (the picture was written)"
    )))
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
