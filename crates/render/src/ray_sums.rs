//! What a ray adds up over its slabs: its light, and what its estimate of errors is made of.

use niji_geometry::Ray;

use crate::deposits::Deposits;
use crate::error_parts::RayErrors;
use crate::scattering_rows::SunlitLuminance;
use crate::shadow_error::ShadowError;

/// Rows bend unevenly between two nodes of an axis.
const ANGLES_SAFETY: f64 = 1.5;

/// Sums over the slabs of a ray.
#[derive(Default)]
pub(crate) struct RaySums {
    pub(crate) light: f64,
    pub(crate) light_m: f64,
    light_m2: f64,
    pub(crate) light_tau_sun: f64,
    pub(crate) luminance_cd_m2: f64,
    pub(crate) errors: RayErrors,
}

impl RaySums {
    /// Mean error of the optical depth to the sun over the light of a ray, of which there is some, at Q = 1.
    pub(crate) fn shadow_depth(&self, error: &ShadowError, ray: &Ray) -> f64 {
        let middle_m = self.light_m / self.light;
        // As if the light came evenly from a stretch of its mean and variance.
        let variance = (self.light_m2 / self.light - middle_m * middle_m).max(0.0);
        let half_m = (3.0 * variance).sqrt();
        error.along(ray, (middle_m - half_m, middle_m + half_m))
    }

    pub(crate) fn add(&mut self, luminance: &SunlitLuminance, deposits: &Deposits) {
        self.light += deposits.light;
        self.light_m += deposits.light_m;
        self.light_m2 += deposits.light_m2;
        self.light_tau_sun += deposits.light_tau_sun;
        self.luminance_cd_m2 += luminance.value;
        // A function errs by half its second derivative times the variance over which it is taken at one
        // point; where it is interpolated linearly, by an eighth at most in the middle of a step.
        let of_sizes = 0.5 * luminance.kinks * deposits.size_variance;
        let of_pieces = luminance.value * deposits.error.abs();
        self.errors.quadrature += (of_pieces + of_sizes) / deposits.light;
        self.errors.angles += ANGLES_SAFETY * luminance.off_lines;
        self.errors.sizes += luminance.bend.abs() / 8.0;
    }
}
