//! The part of the sun's disc that stands above the horizon.
//!
//! A strip of the disc at height y over its center (radius a) has the width 2 sqrt(a^2 - y^2). With
//! y = a sin v, the visible part of the disc's area from y0 = -e (e = elevation of the center over
//! the horizon) up is
//!   fraction = 1/2 + (w + sin w cos w)/pi,  w = asin(e/a)
//! and the mean over it of any function of elevation is a Gauss-Legendre sum in v with weight cos^2 v.
//! The horizon is that of a smooth sphere seen from the observer's height.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::gauss_legendre::Rule;

/// Mean apparent radius of the sun, half of 0.533 degrees.
pub const SUN_RADIUS: Radians = Radians(0.00465);

/// Strips of the visible part of the disc.
const N_STRIPS: usize = 8;

/// Elevation of a direction over the horizon of an observer.
pub(crate) fn elevation_above_horizon(planet: Planet, height_m: f64, cos_zenith: f64) -> Radians {
    let elevation_rad = cos_zenith.clamp(-1.0, 1.0).asin();
    Radians(elevation_rad + planet.horizon_dip(height_m).0)
}

/// Offsets in elevation from the center and their shares of the whole disc, for the visible part.
pub(crate) fn visible_strips(elevation: Radians, disc_radius: Radians) -> Vec<(f64, f64)> {
    if disc_radius.0 <= 0.0 {
        let is_up = elevation.0 >= 0.0;
        return if is_up { vec![(0.0, 1.0)] } else { Vec::new() };
    }
    let lowest = -(elevation.0 / disc_radius.0).clamp(-1.0, 1.0).asin();
    let width = FRAC_PI_2 - lowest;
    if width <= 0.0 {
        return Vec::new();
    }
    let strip = |(x, weight): (f64, f64)| {
        let v = lowest + width * x;
        (
            disc_radius.0 * v.sin(),
            width * weight * 2.0 / PI * v.cos().powi(2),
        )
    };
    Rule::new(N_STRIPS).pairs().map(strip).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form of the share of the disc's area that stands above the horizon, 0 to 1.
    fn visible_fraction(elevation: Radians, disc_radius: Radians) -> f64 {
        let sin_w = (elevation.0 / disc_radius.0).clamp(-1.0, 1.0);
        let w = sin_w.asin();
        (0.5 + (w + sin_w * w.cos()) / PI).clamp(0.0, 1.0)
    }

    #[test]
    fn the_strips_cover_the_visible_part() {
        for elevation in [-0.9, -0.5, 0.0, 0.3, 1.0, 20.0] {
            let elevation = Radians(elevation * SUN_RADIUS.0);
            let sum: f64 = visible_strips(elevation, SUN_RADIUS)
                .iter()
                .map(|strip| strip.1)
                .sum();
            assert!((sum - visible_fraction(elevation, SUN_RADIUS)).abs() < 1e-8);
        }
        assert!(visible_strips(Radians(-0.01), SUN_RADIUS).is_empty());
    }

    #[test]
    fn a_point_sun_is_up_or_down() {
        assert_eq!(visible_strips(Radians(0.0), Radians(0.0)), [(0.0, 1.0)]);
        assert!(visible_strips(Radians(-1e-9), Radians(0.0)).is_empty());
    }
}
