//! Spray above a rough sea, thinning out with height.
//!
//! LWC(z) = L exp(-z/h)
//! `L` liquid water content at the water [g/m³], `z` height above it [m], `h` scale height [m]. The
//! radii are lognormal everywhere,
//! <r^k> = r_g^k exp(k² ln²(sigma_g)/2)
//! `r_g` median radius [um], `sigma_g` geometric standard deviation. Wave impact throws lognormal
//! spray [WI16], and the water of drops splashed up by rain on a pool falls exponentially with height
//! [LZD24]; that both hold for spray above a rough sea is plausible, not measured.
//!
//! total water = L A h (1 - exp(-H/h))
//! total drops = total water/((4/3) pi rho_w <r³>)
//! `A` area and `H` height of the box, rho_w density of water. A node holds the mean over its cell,
//! L exp(-z1/h)(1 - exp(-dz/h)) h/dz from z1 to z1 + dz, so that a thin layer keeps its water in
//! large voxels.
//!
//! The volume holds the gamma law of the same extinction, water and effective radius. From
//! sigma_g = 1.88 on the variance is wider than a gamma law can be; it is then set to 0.49.
//! [WI16] Watanabe and Ingram, Proc. R. Soc. A 472, 20160423 (2016);
//! [LZD24] Liu, Zheng and Duncan, Spray in the atmospheric surface layer by raindrops impacting water
//! surface, J. Fluid Mech. (2024).

use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_dropfield::MAX_EFFECTIVE_VARIANCE;
use niji_sizes::Amount;
use niji_sizes::BulkProperties;
use niji_sizes::Lognormal;
use niji_sizes::SizeMoments;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::error::require_not_negative;
use crate::error::require_positive;
use crate::gusts;

/// Spray that thins out with height. Plausible, not measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SeaSpray {
    /// Lowest corner; its height is that of the water (m).
    pub box_min_m: [f64; 3],
    /// Highest corner (m).
    pub box_max_m: [f64; 3],
    /// Liquid water content at the water (g/m³).
    #[schemars(range(min = 0.0))]
    pub surface_lwc_g_m3: f64,
    /// Height over which the water falls to 1/e (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub scale_height_m: f64,
    /// Median radius of the lognormal law (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub median_radius_um: f64,
    /// Geometric standard deviation of the radius, above 1.
    #[schemars(extend("exclusiveMinimum" = 1.0, "maximum" = 100.0))]
    pub geometric_standard_deviation: f64,
    /// Gusts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

impl SeaSpray {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.law().validate()?;
        require_not_negative("surface_lwc_g_m3", self.surface_lwc_g_m3)?;
        require_positive("scale_height_m", self.scale_height_m)?;
        gusts::check(self.turbulence)?;
        self.grid().n_nodes()?;
        Ok(())
    }

    /// The box and its voxels.
    pub fn grid(&self) -> GridBox {
        GridBox {
            min: self.box_min_m.into(),
            max: self.box_max_m.into(),
            voxel_m: self.voxel_m,
        }
    }

    /// Sizes of the drops.
    pub fn law(&self) -> Lognormal {
        Lognormal {
            radius_median_um: self.median_radius_um,
            geometric_standard_deviation: self.geometric_standard_deviation,
            d_min_mm: None,
            d_max_mm: None,
        }
    }

    /// Moments per drop, with the variance that a volume can hold.
    fn moments(&self) -> SizeMoments {
        let widest = f64::from(MAX_EFFECTIVE_VARIANCE);
        self.law().moments().with_variance_at_most(widest)
    }

    /// Mean share of the surface's water over a layer above the water.
    fn share(&self, low_m: f64, thickness_m: f64) -> f64 {
        let (low, thickness) = (
            low_m / self.scale_height_m,
            thickness_m / self.scale_height_m,
        );
        (-low).exp() * -(-thickness).exp_m1() / thickness
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`SeaSpray::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let (moments, surface_m3) = (self.moments(), self.densest().number_density_m3);
        let height_m = self.box_max_m[1] - self.box_min_m[1];
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            // The node is asked in the middle of the part of its cell that is in the box.
            let layer = ((position.y - self.box_min_m[1]) / self.voxel_m).floor();
            let low_m = layer * self.voxel_m;
            let thickness_m = self.voxel_m.min(height_m - low_m);
            Drops::of_law(&moments, surface_m3 * self.share(low_m, thickness_m))
        })?;
        let mode = gusts::stir(self.turbulence, mode)?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// What a cubic metre holds at the water.
    fn densest(&self) -> BulkProperties {
        let moments = self.moments();
        let water = Amount::LiquidWater(self.surface_lwc_g_m3);
        moments.bulk_properties(water.number_density_m3(&moments))
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let radius = self.moments().effective_radius().0;
        (radius, radius)
    }

    /// Smallest and largest effective variance.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        let variance = self.moments().effective_variance;
        (variance, variance)
    }

    /// Largest extinction without diffraction (1/m), that at the water.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        0.5 * self.densest().extinction_m1 * gusts::max_factor(self.turbulence)
    }

    /// Drops in the whole box, by the lognormal law.
    pub fn total_drops(&self) -> f64 {
        self.densest().number_density_m3 * self.equivalent_volume_m3()
    }

    /// Water in the whole box (g).
    pub fn total_water_g(&self) -> f64 {
        self.densest().lwc_g_m3 * self.equivalent_volume_m3()
    }

    /// Volume that would hold as much at the values of the water's surface (m³).
    fn equivalent_volume_m3(&self) -> f64 {
        let height_m = self.box_max_m[1] - self.box_min_m[1];
        self.grid().volume_m3() * self.share(0.0, height_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spray() -> SeaSpray {
        SeaSpray {
            box_min_m: [-20.0, 1.0, -60.0],
            box_max_m: [20.0, 13.0, -20.0],
            surface_lwc_g_m3: 0.05,
            scale_height_m: 3.0,
            median_radius_um: 50.0,
            geometric_standard_deviation: 1.5,
            turbulence: None,
            voxel_m: 1.0,
        }
    }

    #[test]
    fn totals_of_the_volume_equal_the_closed_forms_for_any_voxel() {
        // 5 m are two and a half voxels of the scale height, and cut the box unevenly.
        for voxel_m in [0.5, 1.0, 5.0, 50.0] {
            let shape = SeaSpray { voxel_m, ..spray() };
            let found = shape.volume().unwrap().summary();
            let gamma_drops = shape.total_drops() * shape.moments().equivalent_gamma_drops();
            let water = found.total_water_g / shape.total_water_g() - 1.0;
            let drops = found.total_drops / gamma_drops - 1.0;
            // f32; measured worst 1e-7.
            assert!(water.abs() < 3e-7, "{voxel_m}: {water:e}");
            assert!(drops.abs() < 3e-7, "{voxel_m}: {drops:e}");
        }
    }

    #[test]
    fn closed_forms_are_the_integrals_of_the_profile() {
        let shape = spray();
        let step_m = 12.0 / 1e4;
        let column: f64 = (0..10_000)
            .map(|i| 0.05 * (-(f64::from(i) + 0.5) * step_m / 3.0).exp() * step_m)
            .sum();
        assert!((shape.total_water_g() / (1600.0 * column) - 1.0).abs() < 1e-8);
        // A drop of the law has (4/3) pi 1e-12 g/um³ r_g³ e^(9 ln² sigma_g / 2).
        let drop_g = 4.188790204786391e-12 * 1.25e5 * (4.5 * 1.5_f64.ln().powi(2)).exp();
        assert!((shape.total_water_g() / (drop_g * shape.total_drops()) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_deep_scale_height_is_an_even_box() {
        let shape = SeaSpray {
            scale_height_m: 1e12,
            ..spray()
        };
        assert!((shape.total_water_g() / (0.05 * 19_200.0) - 1.0).abs() < 1e-10);
        let found = shape.volume().unwrap().summary();
        assert!((found.number_density_m3.0 / found.number_density_m3.1 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn water_falls_by_e_over_a_scale_height() {
        let volume = spray().volume().unwrap();
        let at = |layer| f64::from(volume.modes[0].drops([3, layer, 3]).number_density_m3);
        assert!((at(0) / at(3) / std::f64::consts::E - 1.0).abs() < 1e-6);
        let summary = volume.summary();
        let share = summary.max_extinction_m1_q1 / spray().max_extinction_m1_q1();
        // The mean over the lowest metre of three: 3 (1 - e^(-1/3)).
        assert!((share / 0.850_406_068 - 1.0).abs() < 1e-6, "{share}");
    }

    #[test]
    fn spray_too_wide_for_a_gamma_law_keeps_its_water_and_extinction() {
        let wide = SeaSpray {
            geometric_standard_deviation: 2.0,
            ..spray()
        };
        assert!(wide.law().moments().effective_variance > 0.6);
        let found = wide.volume().unwrap().summary();
        assert!((found.total_water_g / wide.total_water_g() - 1.0).abs() < 1e-6);
        let (radius, _) = wide.effective_radius_range_um();
        assert!((radius / wide.law().moments().effective_radius().0 - 1.0).abs() < 1e-12);
        assert!(found.effective_variance.1 <= wide.effective_variance_range().1 * (1.0 + 1e-6));
    }

    #[test]
    fn unsound_sprays_are_refused_and_dry_ones_are_empty() {
        for shape in [
            SeaSpray {
                surface_lwc_g_m3: -1.0,
                ..spray()
            },
            SeaSpray {
                scale_height_m: 0.0,
                ..spray()
            },
            SeaSpray {
                median_radius_um: f64::NAN,
                ..spray()
            },
            SeaSpray {
                geometric_standard_deviation: 1.0,
                ..spray()
            },
            SeaSpray {
                box_max_m: [20.0, 1.0, -20.0],
                ..spray()
            },
        ] {
            assert!(shape.volume().is_err(), "{shape:?}");
        }
        let dry = SeaSpray {
            surface_lwc_g_m3: 0.0,
            ..spray()
        };
        assert_eq!(dry.volume().unwrap().summary().n_nodes, 0);
        assert_eq!(dry.total_water_g(), 0.0);
    }
}
