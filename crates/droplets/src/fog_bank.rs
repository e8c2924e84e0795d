//! A bank of fog or cloud whose water changes with height.
//!
//! t = (y - y0)/H runs from 0 at the lower face to 1 at the upper one.
//! adiabatic:      LWC = L t,         r_e = a t^(1/3),   N constant: rising air condenses water on
//!                                                       the same drops [PK97]
//! ground-based:   LWC = L (1 - t),   r_e = a (1 - t/2): radiation fog, large drops at the ground
//! even:           LWC = L,           r_e = a
//! `L` largest liquid water content [g/m³], `a` largest effective radius [um], `H` height [m].
//!
//! L, a and the effective variance are given as numbers or taken from a published cloud; the drops
//! follow the gamma law of that effective radius and variance.
//!
//! total water = L V/2 (even: L V); with N1 the number density where LWC = L and r_e = a,
//! total drops = N1 V in all three cases; for the ground-based one because
//! integral (1 - t)/(1 - t/2)³ dt = 1.
//! [PK97] Pruppacher and Klett, Microphysics of Clouds and Precipitation, 2nd ed., Kluwer (1997),
//! chapters 2 and 13.

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::Amount;
use niji_sizes::BulkProperties;
use niji_sizes::CloudPreset;
use niji_sizes::GammaSizes;
use niji_sizes::HansenTravis;
use niji_sizes::SizeMoments;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::error::require_not_negative;
use crate::gusts;

/// How the water of a fog bank changes with height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FogProfile {
    /// Lifted air: water rises linearly, the radius with its cube root.
    Adiabatic,
    /// Radiation fog: water and radius are largest at the ground.
    GroundBased,
    /// The same everywhere.
    Even,
}

/// A bank of fog.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FogBank {
    /// Lowest corner (m).
    pub box_min_m: [f64; 3],
    /// Highest corner (m).
    pub box_max_m: [f64; 3],
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
    /// How water and radius change with height.
    pub profile: FogProfile,
    /// A published cloud that gives L, a and the effective variance, in place of the three numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<CloudPreset>,
    /// Largest liquid water content L (g/m³).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub max_lwc_g_m3: Option<f64>,
    /// Largest effective radius a (um).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub max_effective_radius_um: Option<f64>,
    /// Effective variance everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5))]
    pub effective_variance: Option<f64>,
    /// Gusts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
}

impl FogBank {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        self.check_amount()?;
        let full = self.fullest();
        GammaSizes::new(Micrometers(full.radius_um), full.effective_variance)?;
        require_not_negative("max_lwc_g_m3", full.lwc_g_m3)?;
        gusts::check(self.turbulence)?;
        self.grid().n_nodes()?;
        Ok(())
    }

    /// Water and sizes are given in one of two ways.
    fn check_amount(&self) -> Result<(), Error> {
        let numbers = [
            self.max_lwc_g_m3,
            self.max_effective_radius_um,
            self.effective_variance,
        ];
        let n_given = numbers.iter().flatten().count();
        let found = match (self.preset, n_given) {
            (Some(_), 0) | (None, 3) => return Ok(()),
            (Some(_), _) => "both",
            (None, 0) => "neither",
            (None, _) => "only some of the numbers",
        };
        Err(Error::EitherOr {
            found,
            first: "preset",
            second: "max_lwc_g_m3 with max_effective_radius_um and effective_variance",
        })
    }

    /// Water and sizes where the water is largest.
    fn fullest(&self) -> Fullest {
        if let Some(cloud) = self.preset {
            let bulk = cloud
                .law()
                .moments()
                .bulk_properties(cloud.number_density_m3());
            return Fullest {
                lwc_g_m3: bulk.lwc_g_m3,
                radius_um: 1e6 * bulk.effective_radius_m,
                effective_variance: bulk.effective_variance,
            };
        }
        // A number that is missing has no value, and `validate` says so.
        Fullest {
            lwc_g_m3: self.max_lwc_g_m3.unwrap_or(f64::NAN),
            radius_um: self.max_effective_radius_um.unwrap_or(f64::NAN),
            effective_variance: self.effective_variance.unwrap_or(f64::NAN),
        }
    }

    /// The box and its voxels.
    pub fn grid(&self) -> GridBox {
        let (min, max) = (DVec3::from(self.box_min_m), DVec3::from(self.box_max_m));
        GridBox {
            min,
            max,
            voxel_m: self.voxel_m,
        }
    }

    /// Liquid water (g/m³) and effective radius (um) at a share 0..1 of the height.
    pub fn at(&self, height_share: f64) -> (f64, f64) {
        let full = self.fullest();
        let (water_share, radius_share) = self.profile.shares(height_share);
        (full.lwc_g_m3 * water_share, full.radius_um * radius_share)
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`FogBank::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let full = self.fullest();
        let (low, high) = (self.box_min_m[1], self.box_max_m[1]);
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            let height_share = (position.y - low) / (high - low);
            full.drops(self.profile.shares(height_share))
        })?;
        let mode = gusts::stir(self.turbulence, mode)?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Smallest and largest effective radius (um), at the lowest nodes and at the top: at its foot an adiabatic bank
    /// has none.
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let height_m = self.box_max_m[1] - self.box_min_m[1];
        let lowest = 0.5 * self.voxel_m / height_m;
        let (lowest, top) = (self.at(lowest).1, self.at(1.0).1);
        (lowest.min(top), lowest.max(top))
    }

    /// Smallest and largest effective variance at the nodes.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        let variance = self.fullest().effective_variance;
        (variance, variance)
    }

    /// Largest extinction without diffraction (1/m): where the water is largest, since
    /// LWC/r_e rises with t^(2/3), falls with (1 - t)/(1 - t/2), or is constant.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let extinction_m1 = self.fullest().bulk_properties().extinction_m1;
        0.5 * extinction_m1 * gusts::max_factor(self.turbulence)
    }

    /// Drops in the whole bank; gusts that keep the water of an uneven bank change them a little.
    pub fn total_drops(&self) -> f64 {
        self.fullest().bulk_properties().number_density_m3 * self.grid().volume_m3()
    }

    /// Water in the whole bank (g).
    pub fn total_water_g(&self) -> f64 {
        let mean_share = match self.profile {
            FogProfile::Adiabatic | FogProfile::GroundBased => 0.5,
            FogProfile::Even => 1.0,
        };
        mean_share * self.fullest().lwc_g_m3 * self.grid().volume_m3()
    }
}

impl FogProfile {
    /// Shares of the largest water and of the largest radius at a share of the height.
    fn shares(self, height_share: f64) -> (f64, f64) {
        let t = height_share.clamp(0.0, 1.0);
        match self {
            Self::Adiabatic => (t, t.cbrt()),
            Self::GroundBased => (1.0 - t, 1.0 - 0.5 * t),
            Self::Even => (1.0, 1.0),
        }
    }
}

/// The fog where its water is largest.
struct Fullest {
    lwc_g_m3: f64,
    radius_um: f64,
    effective_variance: f64,
}

impl Fullest {
    fn bulk_properties(&self) -> BulkProperties {
        let moments = self.moments(1.0);
        let water = Amount::LiquidWater(self.lwc_g_m3);
        moments.bulk_properties(water.number_density_m3(&moments))
    }

    fn drops(&self, (water_share, radius_share): (f64, f64)) -> Drops {
        if self.lwc_g_m3 * water_share * radius_share <= 0.0 {
            return Drops::NONE;
        }
        let moments = self.moments(radius_share);
        let water = Amount::LiquidWater(self.lwc_g_m3 * water_share);
        Drops::of_law(&moments, water.number_density_m3(&moments))
    }

    /// Moments per drop of the gamma law of a share of the largest radius.
    fn moments(&self, radius_share: f64) -> SizeMoments {
        let radius = Micrometers(self.radius_um * radius_share);
        HansenTravis::untruncated(radius, self.effective_variance).moments()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bank(profile: FogProfile) -> FogBank {
        FogBank {
            box_min_m: [-8.0, 0.0, -8.0],
            box_max_m: [8.0, 64.0, 8.0],
            voxel_m: 1.0,
            profile,
            preset: None,
            max_lwc_g_m3: Some(0.3),
            max_effective_radius_um: Some(10.0),
            effective_variance: Some(0.08),
            turbulence: None,
        }
    }

    #[test]
    fn totals_of_the_volume_equal_the_closed_forms() {
        for profile in [
            FogProfile::Adiabatic,
            FogProfile::GroundBased,
            FogProfile::Even,
        ] {
            let shape = bank(profile);
            let found = shape.volume().unwrap().summary();
            let water = found.total_water_g / shape.total_water_g() - 1.0;
            let drops = found.total_drops / shape.total_drops() - 1.0;
            // f32 for linear profiles; the midpoint rule over 64 nodes for the ground-based number.
            assert!(water.abs() < 1e-6, "{profile:?}: {water:e}");
            assert!(drops.abs() < 1e-3, "{profile:?}: {drops:e}");
            let densest = found.max_extinction_m1_q1 / shape.max_extinction_m1_q1();
            assert!(
                densest <= 1.0 + 1e-6 && densest > 0.97,
                "{profile:?}: {densest}"
            );
        }
    }

    #[test]
    fn lifted_air_keeps_its_drops_and_grows_them() {
        let volume = bank(FogProfile::Adiabatic).volume().unwrap();
        let (low, high) = (
            volume.modes[0].drops([4, 0, 4]),
            volume.modes[0].drops([4, 63, 4]),
        );
        assert!((low.number_density_m3 / high.number_density_m3 - 1.0).abs() < 1e-5);
        // Nodes at t = 1/128 and 127/128.
        let growth = high.effective_radius_m / low.effective_radius_m;
        assert!((growth / 127.0_f32.cbrt() - 1.0).abs() < 1e-5);
        let least_um = bank(FogProfile::Adiabatic).effective_radius_range_um().0;
        assert!((f64::from(low.effective_radius_m) * 1e6 / least_um - 1.0).abs() < 1e-6);
    }

    fn published(preset: CloudPreset) -> FogBank {
        FogBank {
            preset: Some(preset),
            max_lwc_g_m3: None,
            max_effective_radius_um: None,
            effective_variance: None,
            ..bank(FogProfile::Even)
        }
    }

    #[test]
    fn a_published_fog_has_its_published_water_and_sizes() {
        // OPAC fog: r_e = 10.72 um, v_e = 0.082, 0.058 g/m³, 8.07 /km at Q = 2.
        let fog = published(CloudPreset::Fog);
        let found = fog.volume().unwrap().summary();
        assert!((found.effective_radius_um.1 - 10.72).abs() < 0.006);
        assert!((found.effective_variance.1 - 0.082).abs() < 6e-4);
        assert!((found.max_liquid_water_g_m3 - 0.058).abs() < 6e-4);
        assert!((2e3 * found.max_extinction_m1_q1 / 8.07 - 1.0).abs() < 2e-3);
        assert!((found.total_water_g / fog.total_water_g() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_preset_and_its_numbers_are_the_same_bank() {
        let stratus = published(CloudPreset::StratusMaritime);
        let (lwc, radius) = stratus.at(0.5);
        let numbers = FogBank {
            preset: None,
            max_lwc_g_m3: Some(lwc),
            max_effective_radius_um: Some(radius),
            effective_variance: Some(stratus.effective_variance_range().0),
            ..stratus
        };
        assert_eq!(numbers.volume().unwrap(), stratus.volume().unwrap());
    }

    #[test]
    fn water_and_sizes_are_given_once() {
        let numbers = bank(FogProfile::Even);
        let preset = Some(CloudPreset::Fog);
        let (lwc, radius) = (numbers.max_lwc_g_m3, numbers.max_effective_radius_um);
        for (preset, max_lwc_g_m3, max_effective_radius_um, word) in [
            (preset, lwc, radius, "found both"),
            (None, lwc, None, "found only some"),
        ] {
            let shape = FogBank {
                preset,
                max_lwc_g_m3,
                max_effective_radius_um,
                ..numbers
            };
            let message = shape.validate().unwrap_err().to_string();
            assert!(
                message.contains(word) && message.contains("preset"),
                "{message}"
            );
        }
        let none = FogBank {
            preset: None,
            ..published(CloudPreset::Fog)
        };
        let message = none.validate().unwrap_err().to_string();
        assert!(message.contains("found neither"), "{message}");
    }

    #[test]
    fn unsound_banks_are_refused_and_dry_ones_are_empty() {
        let even = bank(FogProfile::Even);
        let wide = FogBank {
            effective_variance: Some(0.5),
            ..even
        };
        let negative = FogBank {
            max_lwc_g_m3: Some(-1.0),
            ..even
        };
        let flat = FogBank {
            box_max_m: [8.0, 0.0, 8.0],
            ..even
        };
        for shape in [wide, negative, flat] {
            assert!(shape.volume().is_err(), "{shape:?}");
        }
        let dry = FogBank {
            max_lwc_g_m3: Some(0.0),
            ..even
        };
        assert_eq!(dry.volume().unwrap().summary().n_nodes, 0);
    }
}
