//! A shaft of rain below a cloud, slanted by wind shear, with soft edges.
//!
//! Inside, drops are those of Marshall-Palmer rain; towards the edge their number falls, their
//! sizes stay. The rain is given by its rate or by what a radar sees of it, and wind shear displaces
//! every level as a whole (`slant.rs`).
//!
//! The edge is a cubic ramp of width e, centred on the footprint's outline, so that
//! total drops = N H (w d)              for a box of w times d
//! total drops = N H pi (r² + e²/20)    for a column of radius r
//! `H` height of the shaft. Slant does not change either: every level is only displaced.

use std::f64::consts::PI;

use glam::DVec2;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_sizes::BulkProperties;
use niji_sizes::MarshallPalmer;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::error::require_in;
use crate::error::require_not_negative;
use crate::error::require_positive;
use crate::gusts;
use crate::slant::Slant;

/// Outline of a shaft from above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Footprint {
    /// A rectangle.
    Box {
        /// Extent east-west (m).
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width_x_m: f64,
        /// Extent north-south (m).
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        width_z_m: f64,
    },
    /// A disc.
    Column {
        /// Radius (m).
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius_m: f64,
    },
}

/// A shaft of Marshall-Palmer rain.
///
/// ```
/// use niji_droplets::{Footprint, RainShaft};
///
/// let shaft = RainShaft {
///     rain_rate_mm_h: Some(5.0),
///     reflectivity_dbz: None,
///     d_min_mm: None,
///     d_max_mm: None,
///     footprint: Footprint::Column { radius_m: 500.0 },
///     center_xz_m: [0.0, -2000.0],
///     base_y_m: 0.0,
///     top_y_m: 1000.0,
///     wind_shear_xz_1_s: [0.0, 0.0],
///     edge_m: 0.0,
///     turbulence: None,
///     voxel_m: 50.0,
/// };
/// shaft.validate()?;
/// assert!((shaft.bulk_properties().lwc_g_m3 - 0.344).abs() < 5e-4);
/// # Ok::<(), niji_droplets::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RainShaft {
    /// Rain rate (mm/h); either this or the radar reflectivity.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 10000.0))]
    pub rain_rate_mm_h: Option<f64>,
    /// Radar reflectivity of the rain before any cut of its diameters (dBZ).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -100.0, max = 80.0))]
    pub reflectivity_dbz: Option<f64>,
    /// Smallest drop diameter (mm); 0 if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub d_min_mm: Option<f64>,
    /// Largest drop diameter (mm); no limit if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
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
    #[schemars(range(min = 0.0))]
    pub edge_m: f64,
    /// Gusts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

impl RainShaft {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.check_amount()?;
        self.law().validate()?;
        gusts::check(self.turbulence)?;
        require_not_negative("edge_m", self.edge_m)?;
        self.slant().validate()?;
        self.check_outline()?;
        self.grid().n_nodes()?;
        Ok(())
    }

    /// The amount of rain is given in one of two ways.
    fn check_amount(&self) -> Result<(), Error> {
        let found = match (self.rain_rate_mm_h, self.reflectivity_dbz) {
            (Some(_), None) => return Ok(()),
            (None, Some(dbz)) => {
                let expected = "-100 to 80 dBZ";
                return require_in(-100.0..=80.0, "reflectivity_dbz", dbz, expected);
            }
            (None, None) => "neither",
            (Some(_), Some(_)) => "both",
        };
        Err(Error::EitherOr {
            found,
            first: "rain_rate_mm_h",
            second: "reflectivity_dbz",
        })
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
        let seen = |dbz| MarshallPalmer::from_reflectivity_dbz(dbz).rain_rate_mm_h;
        let rate = self.rain_rate_mm_h.or(self.reflectivity_dbz.map(seen));
        MarshallPalmer {
            // Without either there is no law, and `validate` says so.
            rain_rate_mm_h: rate.unwrap_or(f64::NAN),
            d_min_mm: self.d_min_mm,
            d_max_mm: self.d_max_mm,
        }
    }

    /// What a cubic metre holds inside the edge.
    pub fn bulk_properties(&self) -> BulkProperties {
        self.law()
            .moments()
            .bulk_properties(self.law().number_density_m3())
    }

    fn slant(&self) -> Slant {
        Slant {
            center_xz_m: self.center_xz_m,
            base_y_m: self.base_y_m,
            top_y_m: self.top_y_m,
            wind_shear_xz_1_s: self.wind_shear_xz_1_s,
            rain: self.law(),
        }
    }

    /// Horizontal displacement (x, z) of the shaft at a height (m).
    pub fn displacement_m(&self, y_m: f64) -> [f64; 2] {
        self.slant().displacement_m(y_m).to_array()
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
        self.slant().grid(half + 0.5 * self.edge_m, self.voxel_m)
    }

    /// Share of the full number density at an offset from the axis, 0..=1.
    fn coverage(&self, offset_m: DVec2) -> f64 {
        match self.footprint {
            Footprint::Box {
                width_x_m,
                width_z_m,
            } => {
                let inside = 0.5 * DVec2::new(width_x_m, width_z_m) - offset_m.abs();
                ramp(inside.x, self.edge_m) * ramp(inside.y, self.edge_m)
            }
            Footprint::Column { radius_m } => ramp(radius_m - offset_m.length(), self.edge_m),
        }
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`RainShaft::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let (moments, density) = (self.law().moments(), self.law().number_density_m3());
        let slant = self.slant();
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            Drops::of_law(&moments, density * self.coverage(slant.offset_m(position)))
        })?;
        let mode = gusts::stir(self.turbulence, mode)?;
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
        0.5 * self.bulk_properties().extinction_m1 * gusts::max_factor(self.turbulence)
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
