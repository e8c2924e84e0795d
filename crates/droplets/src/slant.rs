//! How wind shear slants falling rain.
//!
//! x(h) = -S h²/(2 v)
//! `h` depth below the cloud base [m]; `S` wind shear dU/dy, a horizontal vector [1/s]; `v` speed of
//! fall of drops of the mass-weighted mean diameter 4/Lambda. A drop released at the base of the
//! cloud sees, relative to the cloud that moves with the wind up there, the wind -S h.
//! [Mar53] J. S. Marshall, J. Meteorology 10, 25-29 (1953).
//!
//! v = 9.65 - 10.3 exp(-0.6 D) m/s, D in mm [ASS73] Atlas, Srivastava and Sekhon, Reviews of
//! Geophysics 11, 1-35 (1973); never below 1 m/s here, since the fit fails for D < 0.3 mm.

use glam::DVec2;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_sizes::MarshallPalmer;

use crate::Error;
use crate::error::require_finite;
use crate::error::require_positive;

/// Slowest fall that is used for the slant (m/s).
const SLOWEST_FALL_M_S: f64 = 1.0;

/// The axis of rain below a cloud.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slant {
    /// Where the axis begins at the cloud, x and z (m).
    pub(crate) center_xz_m: [f64; 2],
    /// Height of the lower end (m).
    pub(crate) base_y_m: f64,
    /// Height of the cloud base (m).
    pub(crate) top_y_m: f64,
    /// Wind shear, x and z (1/s).
    pub(crate) wind_shear_xz_1_s: [f64; 2],
    /// The rain, of which the drops of mean mass set the speed of fall.
    pub(crate) rain: MarshallPalmer,
}

impl Slant {
    /// Check the place and the shear.
    pub(crate) fn validate(&self) -> Result<(), Error> {
        require_finite("base_y_m", self.base_y_m)?;
        require_positive("top_y_m - base_y_m", self.top_y_m - self.base_y_m)?;
        for (name, value) in [
            ("center_xz_m", self.center_xz_m),
            ("wind_shear_xz_1_s", self.wind_shear_xz_1_s),
        ] {
            value
                .into_iter()
                .try_for_each(|component| require_finite(name, component))?;
        }
        Ok(())
    }

    /// Horizontal displacement (x, z) of the rain at a height (m).
    pub(crate) fn displacement_m(&self, y_m: f64) -> DVec2 {
        let mass_mean_diameter_mm = 4.0 / self.rain.slope_per_mm();
        let fall_m_s = 9.65 - 10.3 * (-0.6 * mass_mean_diameter_mm).exp();
        let h = self.top_y_m - y_m;
        DVec2::from(self.wind_shear_xz_1_s) * (-h * h / (2.0 * fall_m_s.max(SLOWEST_FALL_M_S)))
    }

    /// Horizontal offset (x, z) of a point from the axis at its height (m).
    pub(crate) fn offset_m(&self, position: DVec3) -> DVec2 {
        let axis = DVec2::from(self.center_xz_m) + self.displacement_m(position.y);
        DVec2::new(position.x, position.z) - axis
    }

    /// The box around everything within a reach (x, z) of the axis.
    pub(crate) fn grid(&self, reach_m: DVec2, voxel_m: f64) -> GridBox {
        let center = DVec2::from(self.center_xz_m);
        let foot = center + self.displacement_m(self.base_y_m);
        let (low, high) = (center.min(foot) - reach_m, center.max(foot) + reach_m);
        GridBox {
            min: DVec3::new(low.x, self.base_y_m, low.y),
            max: DVec3::new(high.x, self.top_y_m, high.y),
            voxel_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slant(rain_rate_mm_h: f64) -> Slant {
        Slant {
            center_xz_m: [10.0, -300.0],
            base_y_m: 0.0,
            top_y_m: 120.0,
            wind_shear_xz_1_s: [0.02, -0.01],
            rain: MarshallPalmer::untruncated(rain_rate_mm_h),
        }
    }

    #[test]
    fn rain_lags_behind_the_cloud_by_the_shear() {
        // 4/Lambda = 1.368 mm falls at 5.117 m/s; 120 m in shear 0.02 /s: 0.02 14400/(2 5.117).
        let foot = slant(5.0).displacement_m(0.0);
        assert!((foot.x + 28.14).abs() < 0.02, "{foot}");
        assert!((foot.y / foot.x + 0.5).abs() < 1e-12, "{foot}");
        assert_eq!(slant(5.0).displacement_m(120.0).length(), 0.0);
        // Halfway down a quarter of it.
        assert!((slant(5.0).displacement_m(60.0).x / foot.x - 0.25).abs() < 1e-12);
    }

    #[test]
    fn offsets_are_measured_from_the_slanted_axis() {
        let foot = slant(5.0).displacement_m(0.0);
        let position = DVec3::new(10.0 + foot.x + 3.0, 0.0, -300.0 + foot.y - 4.0);
        let offset = slant(5.0).offset_m(position);
        assert!(
            (offset - DVec2::new(3.0, -4.0)).length() < 1e-12,
            "{offset}"
        );
    }

    #[test]
    fn drizzle_still_falls() {
        // The fit for the speed of fall is negative below 0.11 mm: at 1 m/s, 0.02 14400/2.
        let foot = slant(1e-6).displacement_m(0.0);
        assert!((foot.x + 144.0).abs() < 1e-9, "{foot}");
    }
}
