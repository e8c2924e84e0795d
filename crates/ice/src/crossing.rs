//! Transmittance of a body for light that crosses it once.
//!
//! T = mean of exp(-alpha c) over chords c: entry uniform on the surface, cosine law inwards, straight
//! to the surface again, no Fresnel losses. For a convex body these are the chords of isotropic light,
//! of mean 4V/S; T depends on alpha times size only.

use niji_geometry::Ray;

use crate::body::Body;
use crate::body::Way;
use crate::directions::cosine_about;
use crate::sampler::Sampler;
use crate::sampler::pixel_seed;

/// Independent scrambles of the same points, whose scatter is the standard error.
const N_REPEATS: u32 = 32;

/// A mean over chords.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OneCrossing {
    /// Share of the light that passes.
    pub transmittance: f64,
    /// Standard error of it.
    pub standard_error: f64,
}

/// Transmittance at each absorption coefficient [1/m], all over the same chords.
///
/// ```
/// use niji_geometry::Aabb;
/// use niji_ice::{Body, one_crossing};
/// use glam::DVec3;
/// let cube = Body::of_box(Aabb { min: DVec3::ZERO, max: DVec3::ONE })?;
/// let clear = one_crossing(&cube, &[0.0], 1024, 1);
/// assert_eq!(clear[0].transmittance, 1.0);
/// # Ok::<(), niji_ice::Error>(())
/// ```
pub fn one_crossing(
    body: &Body,
    absorption_per_m: &[f64],
    n_chords: u32,
    seed: u64,
) -> Vec<OneCrossing> {
    let n_each = n_chords.div_ceil(N_REPEATS).max(1);
    let means: Vec<Vec<f64>> = (0..N_REPEATS)
        .map(|repeat| {
            let mut sums = vec![0.0; absorption_per_m.len()];
            for index in 0..n_each {
                let chord_m = chord_m(body, Sampler::new(pixel_seed(seed, repeat.into()), index));
                for (sum, alpha) in sums.iter_mut().zip(absorption_per_m) {
                    *sum += (-alpha * chord_m).exp();
                }
            }
            sums.iter().map(|sum| sum / f64::from(n_each)).collect()
        })
        .collect();
    (0..absorption_per_m.len())
        .map(|index| of_repeats(means.iter().map(|mean| mean[index])))
        .collect()
}

fn chord_m(body: &Body, sampler: Sampler) -> f64 {
    let [u, v, across, along, part] = sampler.coordinates(0, [0, 1, 2, 3, 4]);
    let (origin, normal) = body.surface_point([part, across, along]);
    let direction = cosine_about(-normal, [u, v]);
    match body.leave(&Ray { origin, direction }, 1, f64::INFINITY) {
        Way::Out(crossing) => crossing.distance_m,
        // No way is longer than infinite.
        Way::Within(_) => f64::INFINITY,
    }
}

fn of_repeats(means: impl Iterator<Item = f64> + Clone) -> OneCrossing {
    let n = f64::from(N_REPEATS);
    let mean = means.clone().sum::<f64>() / n;
    let squares: f64 = means.map(|value| (value - mean).powi(2)).sum();
    OneCrossing {
        transmittance: mean,
        standard_error: (squares / (n * (n - 1.0))).sqrt(),
    }
}
