//! A shower whose rain rate falls off from its axis.
//!
//! R(d) = R0 exp(-d²/a²)   where R > s R0, no rain elsewhere; s = 1e-3
//! `R` rain rate [mm/h], `d` horizontal distance from the axis [m], `a` radius at which the rate is
//! R0/e. Wind shear displaces every level as a whole (`slant.rs`), by the fall of the drops of R0.
//!
//! At every place the drops are those of untruncated Marshall-Palmer rain of the rate there, so that
//! they are largest on the axis: r_e = 3/(2 Lambda) ~ R^0.21, v_e = 1/3. By the powers of the law,
//! N = N0/Lambda ~ R^0.21, extinction ~ R^0.63 and LWC ~ R^0.84 are again Gaussians:
//! integral of R^p over a level = R0^p (pi a²/p)(1 - s^p)
//! total drops = N(R0) H (pi a²/0.21)(1 - s^0.21)
//! total water = LWC(R0) H (pi a²/0.84)(1 - s^0.84)
//! `H` height of the cell. Slant changes neither. At the cut the extinction is 1.3 % of the axis'.
//!
//! The Gaussian is the usual idealisation. Radar finds cells more peaked, exponential on average
//! [HFP03]: with the same total, the heaviest rain of a real cell is heavier.
//! [MP48] Marshall and Palmer, J. Meteorology 5, 165-166 (1948), eq. 3;
//! [HFP03] von Hardenberg, Ferraris and Provenzale, Geophys. Res. Lett. 30(24), 2280 (2003).

use std::f64::consts::PI;

use glam::DVec2;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_sizes::BulkProperties;
use niji_sizes::MOST_RAIN_MM_H;
use niji_sizes::MarshallPalmer;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::error::require_in;
use crate::error::require_positive;
use crate::gusts;
use crate::slant::Slant;

/// Share of the largest rain rate below which there is no rain.
const CUT_SHARE: f64 = 1e-3;

/// Power of the rain rate in the number of drops, that of 1/Lambda (MP48, eq. 3).
const NUMBER_POWER: f64 = 0.21;

/// Power of the rain rate in the liquid water, that of 1/Lambda⁴.
const WATER_POWER: f64 = 4.0 * NUMBER_POWER;

/// A shower of Marshall-Palmer rain, heaviest in its middle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RainCell {
    /// Largest rain rate, on the axis (mm/h).
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 10000.0))]
    pub max_rain_rate_mm_h: f64,
    /// Radius at which the rain rate has fallen to 1/e (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_m: f64,
    /// Axis of the cell at its top, x and z (m).
    pub center_xz_m: [f64; 2],
    /// Height of the lower end (m).
    pub base_y_m: f64,
    /// Height of the upper end, the cloud base (m).
    pub top_y_m: f64,
    /// Wind shear, change of the wind's x and z component per metre of height (1/s).
    #[serde(default)]
    pub wind_shear_xz_1_s: [f64; 2],
    /// Gusts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

impl RainCell {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        let rate = self.max_rain_rate_mm_h;
        require_positive("max_rain_rate_mm_h", rate)?;
        let most = 0.0..=MOST_RAIN_MM_H;
        require_in(most, "max_rain_rate_mm_h", rate, "at most 10000 mm/h")?;
        require_positive("radius_m", self.radius_m)?;
        // Nodes further apart than the radius would miss the cell.
        let resolved = 0.0..=self.radius_m;
        require_in(resolved, "voxel_m", self.voxel_m, "at most radius_m")?;
        self.slant().validate()?;
        gusts::check(self.turbulence)?;
        self.grid().n_nodes()?;
        Ok(())
    }

    fn slant(&self) -> Slant {
        Slant {
            center_xz_m: self.center_xz_m,
            base_y_m: self.base_y_m,
            top_y_m: self.top_y_m,
            wind_shear_xz_1_s: self.wind_shear_xz_1_s,
            rain: self.heaviest(),
        }
    }

    /// The rain on the axis.
    fn heaviest(&self) -> MarshallPalmer {
        MarshallPalmer::untruncated(self.max_rain_rate_mm_h)
    }

    /// Distance from the axis at which the rain ends (m).
    fn reach_m(&self) -> f64 {
        self.radius_m * (-CUT_SHARE.ln()).sqrt()
    }

    /// The box around the cell, slant included, and its voxels.
    pub fn grid(&self) -> GridBox {
        self.slant()
            .grid(DVec2::splat(self.reach_m()), self.voxel_m)
    }

    /// Rain rate at a distance from the axis (mm/h).
    pub fn rain_rate_mm_h(&self, distance_m: f64) -> f64 {
        if distance_m >= self.reach_m() {
            return 0.0;
        }
        self.max_rain_rate_mm_h * (-(distance_m / self.radius_m).powi(2)).exp()
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`RainCell::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let slant = self.slant();
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            let rate = self.rain_rate_mm_h(slant.offset_m(position).length());
            if rate > 0.0 {
                let law = MarshallPalmer::untruncated(rate);
                Drops::of_law(&law.moments(), law.number_density_m3())
            } else {
                Drops::NONE
            }
        })?;
        let mode = gusts::stir(self.turbulence, mode)?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// What a cubic metre holds on the axis.
    fn densest(&self) -> BulkProperties {
        let law = self.heaviest();
        law.moments().bulk_properties(law.number_density_m3())
    }

    /// Smallest and largest effective radius (um): at the cut and on the axis.
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let faintest = MarshallPalmer::untruncated(CUT_SHARE * self.max_rain_rate_mm_h);
        let radius = |law: MarshallPalmer| law.moments().effective_radius().0;
        (radius(faintest), radius(self.heaviest()))
    }

    /// Smallest and largest effective variance at the nodes. Between nodes of different rain rate
    /// the moments are those of a mixture, which is wider; that depends on the voxel size.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        let variance = self.heaviest().moments().effective_variance;
        (variance, variance)
    }

    /// Largest extinction without diffraction (1/m), that on the axis.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        0.5 * self.densest().extinction_m1 * gusts::max_factor(self.turbulence)
    }

    /// Drops in the whole cell; gusts that keep its water change them a little.
    pub fn total_drops(&self) -> f64 {
        self.densest().number_density_m3 * self.equivalent_volume_m3(NUMBER_POWER)
    }

    /// Water in the whole cell (g).
    pub fn total_water_g(&self) -> f64 {
        self.densest().lwc_g_m3 * self.equivalent_volume_m3(WATER_POWER)
    }

    /// Volume that would hold as much at the values of the axis, of a quantity that goes with a power
    /// of the rain rate (m³).
    fn equivalent_volume_m3(&self, power: f64) -> f64 {
        let area_m2 = PI * self.radius_m.powi(2) / power * (1.0 - CUT_SHARE.powf(power));
        area_m2 * (self.top_y_m - self.base_y_m)
    }
}

#[cfg(test)]
#[path = "rain_cell_tests.rs"]
mod tests;
