//! Snow on ice.
//!
//! A white diffuse layer where the surface is above the plane y = 0 and
//!   cos(slope) + 0.1 noise(x/s) >= cos(steepest)
//! `slope` smoothed over the triangles of a mesh, `noise` fractal, -1..1, for what wind leaves and takes:
//! the snow line wanders by a few degrees of slope. `s` a fiftieth of the body's diagonal.

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::error::check_range;
use crate::noise::fractal_noise;

/// By how much noise shifts the cosine of the steepest slope at most.
const WIND: f64 = 0.1;
/// Patches on a diagonal of the body.
const PATCHES: f64 = 50.0;
/// Octaves of noise.
const N_OCTAVES: u32 = 4;
/// Another seed would be another wind.
const SEED: u32 = 0x5e0;

/// Snow where the surface is not too steep and above the plane y = 0: a white diffuse layer that lets
/// through what it does not throw back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Snow {
    /// Share of the light that it throws back; at least as much as the ice.
    #[serde(default = "usual_snow_albedo")]
    #[schemars(range(min = 0.0, max = 0.999))]
    pub albedo: f64,
    /// Steepest slope on which it lies, degrees; wind shifts it by a few degrees from place to place.
    #[serde(default = "usual_slope_deg")]
    #[schemars(range(min = 0.0, max = 90.0))]
    pub steepest_deg: f64,
}

fn usual_snow_albedo() -> f64 {
    0.9
}

fn usual_slope_deg() -> f64 {
    35.0
}

impl Snow {
    /// Checks the ranges, on ice that throws back `least`.
    pub(crate) fn check(&self, least: f64) -> Result<(), Error> {
        let expected = "at least the reflectance of the ice, and less than 1";
        check_range("snow.albedo", self.albedo, [least, 0.999], expected)?;
        check_range("steepest_deg", self.steepest_deg, [0.0, 90.0], "0 to 90")
    }

    /// Whether it lies at a point of a body of `diagonal_m`, where the slope has `cos_slope`.
    pub(crate) fn lies_at(&self, point: DVec3, cos_slope: f64, diagonal_m: f64) -> bool {
        let above = cos_slope - self.steepest_deg.to_radians().cos();
        if point.y <= 0.0 || above < -WIND {
            return false;
        }
        // Level ground keeps its snow.
        if above >= WIND || cos_slope >= 1.0 {
            return true;
        }
        let patches = point * (PATCHES / diagonal_m);
        above + WIND * fractal_noise(patches, N_OCTAVES, SEED) >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SNOW: Snow = Snow {
        albedo: 0.9,
        steepest_deg: 35.0,
    };

    #[test]
    fn snow_lies_on_level_ice_and_not_on_cliffs_or_under_water() {
        for index in 0..100 {
            let point = DVec3::new(0.37 * f64::from(index), 3.0, 0.11);
            let lies = |cos_slope| SNOW.lies_at(point, cos_slope, 50.0);
            assert!(lies(1.0) && lies(0.93) && !lies(0.7) && !lies(-1.0));
            assert!(!SNOW.lies_at(-point, 1.0, 50.0));
        }
        let level_only = Snow {
            steepest_deg: 0.0,
            ..SNOW
        };
        assert!(level_only.lies_at(DVec3::Y, 1.0, 50.0));
    }

    #[test]
    fn the_snow_line_wanders_about_the_steepest_slope() {
        let steepest = 35.0_f64.to_radians().cos();
        let share = |cos_slope| {
            let at = |index| DVec3::new(1.7 * f64::from(index), 2.0, 0.9 * f64::from(index));
            let lies = |index: &i32| SNOW.lies_at(at(*index), cos_slope, 50.0);
            (0..2000).filter(lies).count() as f64 / 2000.0
        };
        // Found 0.50 and 0.16.
        assert!((share(steepest) - 0.5).abs() < 0.06, "{}", share(steepest));
        let steeper = share(steepest - 0.02);
        assert!(steeper > 0.02 && steeper < 0.4, "{steeper}");
    }
}
