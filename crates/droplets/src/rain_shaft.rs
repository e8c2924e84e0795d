//! A shaft of rain below a cloud, slanted by wind shear, with soft edges.
//!
//! Inside, drops are those of Marshall-Palmer rain; towards the edge their number falls, their
//! sizes stay. At a depth h below the top the shaft is displaced horizontally by
//! x(h) = -S h²/(2 v)
//! `S` wind shear dU/dy, a horizontal vector [1/s]; `v` fall speed of drops of the mass-weighted
//! mean diameter 4/Lambda. A drop released at the top sees, relative to the cloud that moves with
//! the wind up there, the wind -S h. [Mar53] J. S. Marshall, J. Meteorology 10, 25-29 (1953).
//!
//! v = 9.65 - 10.3 exp(-0.6 D) m/s, D in mm [ASS73] Atlas, Srivastava and Sekhon, Reviews of
//! Geophysics 11, 1-35 (1973); never below 1 m/s here, since the fit fails for D < 0.3 mm.
//!
//! The edge is a cubic ramp of width e, centred on the footprint's outline, so that
//! total drops = N H (w d)              for a box of w times d
//! total drops = N H pi (r² + e²/20)    for a column of radius r
//! `H` height of the shaft. Slant does not change either: every level is only displaced.

use std::f64::consts::PI;

use glam::DVec2;
use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_sizes::BulkProperties;
use niji_sizes::MarshallPalmer;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::error::require_finite;
use crate::error::require_not_negative;
use crate::error::require_positive;

/// Slowest fall that is used for the slant (m/s).
const SLOWEST_FALL_M_S: f64 = 1.0;

/// Outline of a shaft from above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Footprint {
    /// A rectangle.
    Box {
        /// Extent east-west (m).
        width_x_m: f64,
        /// Extent north-south (m).
        width_z_m: f64,
    },
    /// A disc.
    Column {
        /// Radius (m).
        radius_m: f64,
    },
}

/// A shaft of Marshall-Palmer rain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RainShaft {
    /// Rain rate (mm/h).
    pub rain_rate_mm_h: f64,
    /// Smallest drop diameter (mm); 0 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_min_mm: Option<f64>,
    /// Largest drop diameter (mm); no limit if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_max_mm: Option<f64>,
    /// Outline.
    pub footprint: Footprint,
    /// Middle of the outline at the top, x and z (m).
    pub center_xz_m: [f64; 2],
    /// Height of the lower end (m).
    pub base_y_m: f64,
    /// Height of the upper end, the cloud base (m).
    pub top_y_m: f64,
    /// Wind shear, change of the wind's x and z component per metre of height (1/s).
    #[serde(default)]
    pub wind_shear_xz_1_s: [f64; 2],
    /// Width over which the edge fades (m); 0 is a sharp edge.
    #[serde(default)]
    pub edge_m: f64,
    /// Edge length of a voxel (m).
    pub voxel_m: f64,
}

impl RainShaft {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.law().validate()?;
        require_not_negative("edge_m", self.edge_m)?;
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
        self.check_outline()?;
        self.grid().n_nodes()?;
        Ok(())
    }

    /// The outline must have room for half of the edge inside.
    fn check_outline(&self) -> Result<(), Error> {
        let (parameter, inner) = match self.footprint {
            Footprint::Box {
                width_x_m,
                width_z_m,
            } => {
                require_positive("width_x_m", width_x_m)?;
                require_positive("width_z_m", width_z_m)?;
                ("edge_m", width_x_m.min(width_z_m))
            }
            Footprint::Column { radius_m } => {
                require_positive("radius_m", radius_m)?;
                ("edge_m", 2.0 * radius_m)
            }
        };
        if self.edge_m <= inner {
            return Ok(());
        }
        let expected = "at most the width of the shaft";
        Err(Error::Parameter {
            parameter,
            found: self.edge_m,
            expected,
        })
    }

    /// Sizes and number of the drops.
    pub fn law(&self) -> MarshallPalmer {
        let Self {
            rain_rate_mm_h,
            d_min_mm,
            d_max_mm,
            ..
        } = *self;
        MarshallPalmer {
            rain_rate_mm_h,
            d_min_mm,
            d_max_mm,
        }
    }

    /// What a cubic metre holds inside the edge.
    pub fn bulk_properties(&self) -> BulkProperties {
        self.law()
            .moments()
            .bulk_properties(self.law().number_density_m3())
    }

    /// Horizontal displacement (x, z) of the shaft at a height (m).
    pub fn displacement_m(&self, y_m: f64) -> [f64; 2] {
        let mass_mean_diameter_mm = 4.0 / self.law().slope_per_mm();
        let fall_m_s = 9.65 - 10.3 * (-0.6 * mass_mean_diameter_mm).exp();
        let h = self.top_y_m - y_m;
        let seconds_m = -h * h / (2.0 * fall_m_s.max(SLOWEST_FALL_M_S));
        self.wind_shear_xz_1_s.map(|shear| shear * seconds_m)
    }

    /// The box around the shaft, edges and slant included, and its voxels.
    pub fn grid(&self) -> GridBox {
        let half = match self.footprint {
            Footprint::Box {
                width_x_m,
                width_z_m,
            } => 0.5 * DVec2::new(width_x_m, width_z_m),
            Footprint::Column { radius_m } => DVec2::splat(radius_m),
        };
        let reach = half + 0.5 * self.edge_m;
        let center = DVec2::from(self.center_xz_m);
        let foot = center + DVec2::from(self.displacement_m(self.base_y_m));
        let (low, high) = (center.min(foot) - reach, center.max(foot) + reach);
        GridBox {
            min: DVec3::new(low.x, self.base_y_m, low.y),
            max: DVec3::new(high.x, self.top_y_m, high.y),
            voxel_m: self.voxel_m,
        }
    }

    /// Share of the full number density at a point, 0..=1.
    fn coverage(&self, position: DVec3) -> f64 {
        let center = DVec2::from(self.center_xz_m) + DVec2::from(self.displacement_m(position.y));
        let from_axis = DVec2::new(position.x, position.z) - center;
        match self.footprint {
            Footprint::Box {
                width_x_m,
                width_z_m,
            } => {
                let inside = 0.5 * DVec2::new(width_x_m, width_z_m) - from_axis.abs();
                ramp(inside.x, self.edge_m) * ramp(inside.y, self.edge_m)
            }
            Footprint::Column { radius_m } => ramp(radius_m - from_axis.length(), self.edge_m),
        }
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`RainShaft::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let (moments, density) = (self.law().moments(), self.law().number_density_m3());
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            Drops::of_law(&moments, density * self.coverage(position))
        })?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let radius = self.law().moments().effective_radius().0;
        (radius, radius)
    }

    /// Smallest and largest effective variance.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        let variance = self.law().moments().effective_variance;
        (variance, variance)
    }

    /// Largest extinction without diffraction (1/m).
    pub fn max_extinction_m1_q1(&self) -> f64 {
        0.5 * self.bulk_properties().extinction_m1
    }

    /// Drops in the whole shaft, by the size law.
    pub fn total_drops(&self) -> f64 {
        self.bulk_properties().number_density_m3 * self.equivalent_volume_m3()
    }

    /// Water in the whole shaft (g).
    pub fn total_water_g(&self) -> f64 {
        self.bulk_properties().lwc_g_m3 * self.equivalent_volume_m3()
    }

    /// Volume that would hold as many drops at full number density (m³).
    fn equivalent_volume_m3(&self) -> f64 {
        let area_m2 = match self.footprint {
            Footprint::Box {
                width_x_m,
                width_z_m,
            } => width_x_m * width_z_m,
            Footprint::Column { radius_m } => PI * (radius_m.powi(2) + self.edge_m.powi(2) / 20.0),
        };
        area_m2 * (self.top_y_m - self.base_y_m)
    }
}

/// From 0 outside to 1 inside, over `edge_m` centred on the outline, as 3 t² - 2 t³.
fn ramp(distance_inside_m: f64, edge_m: f64) -> f64 {
    if distance_inside_m.abs() >= 0.5 * edge_m {
        return if distance_inside_m >= 0.0 { 1.0 } else { 0.0 };
    }
    let t = distance_inside_m / edge_m + 0.5;
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
#[path = "rain_shaft_tests.rs"]
mod tests;
