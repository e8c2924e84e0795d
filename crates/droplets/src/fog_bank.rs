//! A bank of fog or cloud whose water changes with height.
//!
//! t = (y - y0)/H runs from 0 at the lower face to 1 at the upper one.
//! adiabatic:      LWC = L t,         r_e = a t^(1/3),   N constant: rising air condenses water on
//!                                                       the same drops [PK97]
//! ground-based:   LWC = L (1 - t),   r_e = a (1 - t/2): radiation fog, large drops at the ground
//! even:           LWC = L,           r_e = a
//! `L` largest liquid water content [g/m³], `a` largest effective radius [um], `H` height [m].
//!
//! total water = L V/2 (even: L V); with N1 the number density where LWC = L and r_e = a,
//! total drops = N1 V in all three cases; for the ground-based one because
//! integral (1 - t)/(1 - t/2)³ dt = 1.
//! [PK97] Pruppacher and Klett, Microphysics of Clouds and Precipitation, 2nd ed., Kluwer (1997),
//! chapters 2 and 13.

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::GammaSizes;
use niji_sizes::SizeMoments;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::error::require_not_negative;

/// How the water of a fog bank changes with height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FogBank {
    /// Lowest corner (m).
    pub box_min_m: [f64; 3],
    /// Highest corner (m).
    pub box_max_m: [f64; 3],
    /// Edge length of a voxel (m).
    pub voxel_m: f64,
    /// How water and radius change with height.
    pub profile: FogProfile,
    /// Largest liquid water content L (g/m³).
    pub max_lwc_g_m3: f64,
    /// Largest effective radius a (um).
    pub max_effective_radius_um: f64,
    /// Effective variance everywhere.
    pub effective_variance: f64,
}

impl FogBank {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        GammaSizes::new(
            Micrometers(self.max_effective_radius_um),
            self.effective_variance,
        )?;
        require_not_negative("max_lwc_g_m3", self.max_lwc_g_m3)?;
        self.grid().n_nodes()?;
        Ok(())
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
        let (lwc, radius) = (self.max_lwc_g_m3, self.max_effective_radius_um);
        let t = height_share.clamp(0.0, 1.0);
        match self.profile {
            FogProfile::Adiabatic => (lwc * t, radius * t.cbrt()),
            FogProfile::GroundBased => (lwc * (1.0 - t), radius * (1.0 - 0.5 * t)),
            FogProfile::Even => (lwc, radius),
        }
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`FogBank::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let (low, high) = (self.box_min_m[1], self.box_max_m[1]);
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            let (lwc_g_m3, radius_um) = self.at((position.y - low) / (high - low));
            if lwc_g_m3 > 0.0 && radius_um > 0.0 {
                self.drops(lwc_g_m3, radius_um)
            } else {
                Drops::NONE
            }
        })?;
        Ok(DropVolume { modes: vec![mode] })
    }

    fn drops(&self, lwc_g_m3: f64, radius_um: f64) -> Drops {
        let moments = self.moments(radius_um);
        let per_drop_g = moments.bulk_properties(1.0).lwc_g_m3;
        Drops::of_law(&moments, lwc_g_m3 / per_drop_g)
    }

    /// Moments per drop of the gamma law of that effective radius.
    fn moments(&self, radius_um: f64) -> SizeMoments {
        let b = self.effective_variance;
        let mean_r2_um2 = radius_um * radius_um * (1.0 - b) * (1.0 - 2.0 * b);
        SizeMoments {
            mean_r_um: radius_um * (1.0 - 2.0 * b),
            mean_r2_um2,
            mean_r3_um3: radius_um * mean_r2_um2,
            effective_variance: b,
        }
    }

    /// Smallest and largest effective radius (um); an adiabatic bank begins with none.
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let (foot, top) = (self.at(0.0).1, self.at(1.0).1);
        (foot.min(top), foot.max(top))
    }

    /// Smallest and largest effective variance at the nodes.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        (self.effective_variance, self.effective_variance)
    }

    /// Largest extinction without diffraction (1/m): where the water is largest, since
    /// LWC/r_e rises with t^(2/3), falls with (1 - t)/(1 - t/2), or is constant.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let moments = self.moments(self.max_effective_radius_um);
        1e-12 * PI * self.densest_m3() * moments.mean_r2_um2
    }

    /// Number density where water and radius are largest (1/m³).
    fn densest_m3(&self) -> f64 {
        let moments = self.moments(self.max_effective_radius_um);
        self.max_lwc_g_m3 / moments.bulk_properties(1.0).lwc_g_m3
    }

    /// Drops in the whole bank.
    pub fn total_drops(&self) -> f64 {
        self.densest_m3() * self.grid().volume_m3()
    }

    /// Water in the whole bank (g).
    pub fn total_water_g(&self) -> f64 {
        let mean_share = match self.profile {
            FogProfile::Adiabatic | FogProfile::GroundBased => 0.5,
            FogProfile::Even => 1.0,
        };
        mean_share * self.max_lwc_g_m3 * self.grid().volume_m3()
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
            max_lwc_g_m3: 0.3,
            max_effective_radius_um: 10.0,
            effective_variance: 0.08,
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
    }

    #[test]
    fn unsound_banks_are_refused_and_dry_ones_are_empty() {
        let even = bank(FogProfile::Even);
        let wide = FogBank {
            effective_variance: 0.5,
            ..even
        };
        let negative = FogBank {
            max_lwc_g_m3: -1.0,
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
            max_lwc_g_m3: 0.0,
            ..even
        };
        assert_eq!(dry.volume().unwrap().summary().n_nodes, 0);
    }
}
