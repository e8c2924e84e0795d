//! A cloud with a flat base: a cumulus, or a layer that may break up.
//!
//! h = y - y0,   LWC = c h,   N constant:   r_e = (3 c h / (4 pi rho k N))^(1/3),   k = (1 - v)(1 - 2 v)
//! `y0` height of the base, `c` condensate per height of lifted air [g/m³ per m], `N` drops per volume, `v` effective
//! variance. Air that rises moist-adiabatically condenses water on the same drops: c is 1 to 2.5 g/m³ a kilometre from
//! 0 to 20 degrees, and clouds hold that or, where dry air was mixed in, part of it [BSPF00].
//!
//! F = 1 - (1 + a)((h/H)² + rho²) + (a + 2 (1 - C)) b(x) + d,   numbers are N s(F),   s = min(1, max(0, F/w))
//! `H` height of the top, `rho` distance from the axis over half the width (0 in a layer), `a` strength of the gusts and
//! `b` their relief within -1..1, round outwards and creased inwards: b = 2 |g| - 1 with the noise g of
//! `turbulence.rs`; w two voxels wide. Without relief a cumulus is half an ellipsoid of 1/sqrt(1 + a) of the box. d is
//! such that the cloud holds the water of the smooth one, in a layer times its coverage C, so that a layer of less than
//! full coverage is there where its relief is highest: with C = 0.4 over about half of the sky. At the edge drops get fewer, not smaller: dry air that is mixed
//! in evaporates some of them wholly [BCL80]. The relief is plausible, not measured.
//!
//! water of a smooth cumulus = c pi A B H²/(4 (1 + a)²), of a layer = C c X Z H²/(2 (1 + a))
//! `A`, `B` half the widths X and Z of the box. Drops are N times the volume, without relief.
//!
//! [BSPF00] Brenguier et al., J. Atmos. Sci. 57, 803-821 (2000), section 2;
//! [BCL80] Baker, Corbin and Latham, Q. J. R. Meteorol. Soc. 106, 581-598 (1980).

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::DropLeaf;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::Amount;
use niji_sizes::GammaSizes;
use niji_sizes::HansenTravis;
use niji_sizes::SizeMoments;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::Turbulence;
use crate::error::require_in;
use crate::error::require_number_density;
use crate::error::require_positive;
use crate::gusts;
use crate::turbulence::Noise;
use crate::turbulence::squeezed;

/// Condensate of lifted air per height, near 10 degrees [BSPF00] (g/m³ per m).
const ADIABATIC_G_M4: f64 = 2e-3;

/// Effective variance of the drops of many clouds.
const USUAL_VARIANCE: f64 = 0.1;

/// Voxels over which the edge thins out.
const EDGE_VOXELS: f64 = 2.0;

/// Share of the drops from which on they count.
const LEAST_SHARE: f64 = 1e-6;

/// Halvings of the range of d.
const N_HALVINGS: u32 = 48;

/// What a cloud looks like from afar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CloudForm {
    /// A heap, highest in its middle.
    Cumulus,
    /// A sheet that fills its box, or part of it.
    Layer,
}

/// A cloud with a flat base, whose water and drops grow with the height above it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cloud {
    /// A heap or a sheet.
    pub form: CloudForm,
    /// Middle of the cloud, x and z (m).
    pub center_xz_m: [f64; 2],
    /// Extent of its box east-west (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_x_m: f64,
    /// Extent north-south (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub width_z_m: f64,
    /// Height of its base (m).
    pub base_y_m: f64,
    /// Height up to which it may reach (m).
    pub top_y_m: f64,
    /// Share of the water of a whole layer that is there, 0..=1; below 1 of a layer with turbulence alone.
    #[serde(default = "whole")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub coverage: f64,
    /// Drops per cubic metre: 5e7 over the sea to 1e9 in polluted air.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub number_density_m3: f64,
    /// Water per height above the base (g/m³ per m).
    #[serde(default = "adiabatic")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub lwc_gradient_g_m4: f64,
    /// Effective variance of the drops.
    #[serde(default = "usual_variance")]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5))]
    pub effective_variance: f64,
    /// Relief of its faces: the strength is how far they bulge, as a part of the cloud's size.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turbulence: Option<Turbulence>,
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
}

fn whole() -> f64 {
    1.0
}

fn adiabatic() -> f64 {
    ADIABATIC_G_M4
}

fn usual_variance() -> f64 {
    USUAL_VARIANCE
}

impl Cloud {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("width_x_m", self.width_x_m)?;
        require_positive("width_z_m", self.width_z_m)?;
        require_positive("number_density_m3", self.number_density_m3)?;
        require_number_density("number_density_m3", self.number_density_m3)?;
        require_positive("lwc_gradient_g_m4", self.lwc_gradient_g_m4)?;
        require_in(
            0.0..=1.0,
            "lwc_gradient_g_m4",
            self.lwc_gradient_g_m4,
            "at most 1",
        )?;
        require_positive("coverage", self.coverage)?;
        let (most, expected) = match (self.form, self.turbulence) {
            (CloudForm::Cumulus, _) => (1.0..=1.0, "1: a cumulus is whole"),
            (CloudForm::Layer, None) => (
                1.0..=1.0,
                "1 without turbulence, by which a layer breaks up",
            ),
            (CloudForm::Layer, Some(_)) => (0.0..=1.0, "at most 1"),
        };
        require_in(most, "coverage", self.coverage, expected)?;
        gusts::check(self.turbulence)?;
        self.grid().n_nodes()?;
        GammaSizes::new(
            Micrometers(self.effective_radius_um(self.height_m())),
            self.effective_variance,
        )?;
        Ok(())
    }

    /// The box and its voxels.
    pub fn grid(&self) -> GridBox {
        let [x, z] = self.center_xz_m;
        let (half_x, half_z) = (0.5 * self.width_x_m, 0.5 * self.width_z_m);
        GridBox {
            min: DVec3::new(x - half_x, self.base_y_m, z - half_z),
            max: DVec3::new(x + half_x, self.top_y_m, z + half_z),
            voxel_m: self.voxel_m,
        }
    }

    /// H (m).
    fn height_m(&self) -> f64 {
        self.top_y_m - self.base_y_m
    }

    /// Moments per drop at an effective radius (um).
    fn moments(&self, radius_um: f64) -> SizeMoments {
        HansenTravis::untruncated(Micrometers(radius_um), self.effective_variance).moments()
    }

    /// Effective radius at a height above the base (um).
    pub fn effective_radius_um(&self, above_base_m: f64) -> f64 {
        let lwc_g_m3 = self.lwc_gradient_g_m4 * above_base_m.max(0.0);
        let of_1_um = Amount::LiquidWater(lwc_g_m3).number_density_m3(&self.moments(1.0));
        (of_1_um / self.number_density_m3).cbrt()
    }

    /// What the cloud holds at a height above its base, away from its edge.
    fn inside(&self, above_base_m: f64) -> Drops {
        let radius_um = self.effective_radius_um(above_base_m);
        if radius_um <= 0.0 {
            return Drops::NONE;
        }
        Drops::of_law(&self.moments(radius_um), self.number_density_m3)
    }

    /// a.
    fn strength(&self) -> f64 {
        self.turbulence.map_or(0.0, |gusts| gusts.strength)
    }

    /// F without d.
    fn inwards(&self, position: DVec3, noise: Option<&Noise>) -> f64 {
        let [x, z] = self.center_xz_m;
        let (half_x, half_z) = (0.5 * self.width_x_m, 0.5 * self.width_z_m);
        let height = (position.y - self.base_y_m) / self.height_m();
        let off_axis = match self.form {
            CloudForm::Cumulus => {
                ((position.x - x) / half_x).powi(2) + ((position.z - z) / half_z).powi(2)
            }
            CloudForm::Layer => 0.0,
        };
        let strength = self.strength();
        let relief = noise.map_or(0.0, |noise| 2.0 * squeezed(noise.sum(position)).abs() - 1.0);
        let bulges = strength + 2.0 * (1.0 - self.coverage);
        1.0 - (1.0 + strength) * (height * height + off_axis) + bulges * relief
    }

    /// w.
    fn edge(&self) -> f64 {
        let (half_x, half_z) = (0.5 * self.width_x_m, 0.5 * self.width_z_m);
        let least_m = match self.form {
            CloudForm::Cumulus => self.height_m().min(half_x).min(half_z),
            CloudForm::Layer => self.height_m(),
        };
        (2.0 * EDGE_VOXELS * self.voxel_m / least_m).min(1.0)
    }

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`Cloud::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let noise = self.turbulence.map(|gusts| gusts.noise());
        let edge = self.edge();
        let whole = DropMode::from_fn("", &self.grid(), |position| {
            self.inside(position.y - self.base_y_m)
        })?;
        let of_leaf = |leaf: &DropLeaf| -> Vec<(f64, f64)> {
            let nodes = leaf.drops.iter().enumerate();
            nodes
                .filter(|(_, drops)| drops.exist())
                .map(|(place, drops)| {
                    let position = whole.node_position(leaf.node(place));
                    let water = f64::from(drops.number_density_m3)
                        * f64::from(drops.effective_radius_m).powi(3);
                    (self.inwards(position, noise.as_ref()), water)
                })
                .collect()
        };
        let nodes: Vec<Vec<(f64, f64)>> = whole.leaves().par_iter().map(of_leaf).collect();
        let kept = self.total_water_g() / whole.total_water_g();
        let outwards = outwards(&nodes.concat(), edge, kept);
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            let share = share(self.inwards(position, noise.as_ref()) + outwards, edge);
            if share < LEAST_SHARE {
                return Drops::NONE;
            }
            let drops = self.inside(position.y - self.base_y_m);
            Drops {
                // f32 as in the file.
                number_density_m3: (f64::from(drops.number_density_m3) * share) as f32,
                ..drops
            }
        })?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Smallest and largest effective radius (um): at the lowest nodes and at the top.
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let height_m = self.height_m();
        let lowest_m = 0.5 * self.voxel_m.min(height_m);
        (
            self.effective_radius_um(lowest_m),
            self.effective_radius_um(height_m),
        )
    }

    /// Smallest and largest effective variance at the nodes.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        (self.effective_variance, self.effective_variance)
    }

    /// Largest extinction without diffraction (1/m): that of the highest top.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let moments = self.moments(self.effective_radius_um(self.height_m()));
        let bulk = moments.bulk_properties(self.number_density_m3);
        0.5 * bulk.extinction_m1
    }

    /// Drops in the whole cloud; relief changes them a little.
    pub fn total_drops(&self) -> f64 {
        let flatter = (1.0 + self.strength()).sqrt();
        let box_m3 = self.width_x_m * self.width_z_m * self.height_m();
        let volume_m3 = match self.form {
            CloudForm::Cumulus => box_m3 * PI / 6.0 / flatter.powi(3),
            CloudForm::Layer => self.coverage * box_m3 / flatter,
        };
        self.number_density_m3 * volume_m3
    }

    /// Water in the whole cloud (g).
    pub fn total_water_g(&self) -> f64 {
        let flatter = 1.0 + self.strength();
        let of_column = self.lwc_gradient_g_m4 * self.height_m().powi(2);
        match self.form {
            CloudForm::Cumulus => {
                0.25 * of_column * PI * 0.25 * self.width_x_m * self.width_z_m / (flatter * flatter)
            }
            CloudForm::Layer => {
                0.5 * of_column * self.coverage * self.width_x_m * self.width_z_m / flatter
            }
        }
    }
}

/// s(F).
fn share(inwards: f64, edge: f64) -> f64 {
    (inwards / edge).clamp(0.0, 1.0)
}

/// d at which a part of the water of nodes, of which F and the water are given, is in the cloud.
fn outwards(nodes: &[(f64, f64)], edge: f64, kept: f64) -> f64 {
    let all: f64 = nodes.iter().map(|(_, water)| water).sum();
    let (lowest, highest) = nodes
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (f, _)| {
            (low.min(*f), high.max(*f))
        });
    let (mut none, mut every) = (-highest, edge - lowest);
    for _ in 0..N_HALVINGS {
        let middle = 0.5 * (none + every);
        let held: f64 = nodes
            .iter()
            .map(|(f, water)| water * share(f + middle, edge))
            .sum();
        if held < kept * all {
            none = middle;
        } else {
            every = middle;
        }
    }
    0.5 * (none + every)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cumulus() -> Cloud {
        Cloud {
            form: CloudForm::Cumulus,
            center_xz_m: [100.0, -200.0],
            width_x_m: 800.0,
            width_z_m: 600.0,
            base_y_m: 500.0,
            top_y_m: 900.0,
            coverage: 1.0,
            number_density_m3: 2e8,
            lwc_gradient_g_m4: ADIABATIC_G_M4,
            effective_variance: USUAL_VARIANCE,
            turbulence: None,
            voxel_m: 20.0,
        }
    }

    fn relief(strength: f64, seed: u32) -> Turbulence {
        Turbulence {
            strength,
            eddy_m: 200.0,
            seed,
            time_s: 0.0,
            wind_m_s: [0.0; 3],
        }
    }

    fn layer(coverage: f64) -> Cloud {
        Cloud {
            form: CloudForm::Layer,
            coverage,
            ..cumulus()
        }
    }

    #[test]
    fn drops_grow_as_the_water_does_on_the_same_number_of_them() {
        // 0.4 g/m³ on 200 drops a cm³: 4/3 pi r_v³ rho N, r_v³ = k r_e³, k = 0.72.
        let radius_um = cumulus().effective_radius_um(200.0);
        let water_g_m3 = 4.0 / 3.0 * PI * 0.72 * (1e-6 * radius_um).powi(3) * 1e6 * 2e8;
        // Water of a little less than 1000 kg/m³.
        assert!((water_g_m3 / 0.4 - 1.0).abs() < 5e-3, "{water_g_m3}");
        assert!((cumulus().effective_radius_um(25.0) / radius_um - 0.5).abs() < 1e-12);
        let volume = layer(1.0).volume().unwrap();
        let mode = &volume.modes[0];
        let (low, high) = (mode.drops([4, 0, 4]), mode.drops([4, 15, 4]));
        assert_eq!(low.number_density_m3, high.number_density_m3);
        let growth = high.effective_radius_m / low.effective_radius_m;
        assert!((growth / 31.0_f32.cbrt() - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_smooth_cloud_is_the_body_whose_water_is_stated() {
        // d is small where the stated water is that of the body: the edge, w wide, lies inside.
        for shape in [cumulus(), layer(1.0)] {
            let smooth = Cloud {
                voxel_m: 10.0,
                ..shape
            };
            let found = smooth.volume().unwrap().summary();
            let drops = found.total_drops / smooth.total_drops() - 1.0;
            // Measured 2.3 and 0.3 %: the edge.
            assert!(drops.abs() < 0.04, "{:?}: {drops}", shape.form);
            assert!(found.min_m.y >= 490.0 && found.max_m.y <= 910.0);
        }
    }

    #[test]
    fn relief_and_coverage_keep_the_water_and_change_the_cloud() {
        for (shape, cloudy) in [
            (cumulus(), 0.3..0.7),
            (layer(1.0), 0.9..1.1),
            (layer(0.4), 0.3..0.7),
        ] {
            let rough = Cloud {
                turbulence: Some(relief(0.5, 3)),
                ..shape
            };
            let volume = rough.volume().unwrap();
            let found = volume.summary();
            let water = found.total_water_g / rough.total_water_g() - 1.0;
            assert!(water.abs() < 1e-5, "{:?}: {water:e}", shape.form);
            assert!((rough.total_water_g() / shape.total_water_g()) < 0.7);
            let other = Cloud {
                turbulence: Some(relief(0.5, 4)),
                ..shape
            };
            assert_ne!(other.volume().unwrap(), volume);
            // Of the nodes above the base.
            let mode = &volume.modes[0];
            let n_above = |x: i32, z: i32| i32::from(mode.drops([x, 1, z]).exist());
            let n: i32 = (0..40)
                .flat_map(|x| (0..30).map(move |z| n_above(x, z)))
                .sum();
            let share = f64::from(n) / 1200.0;
            assert!(cloudy.contains(&share), "{cloudy:?}: {share}");
        }
    }

    #[test]
    fn unsound_clouds_are_refused() {
        let parts = [
            Cloud {
                coverage: 0.5,
                ..cumulus()
            },
            Cloud {
                coverage: 1.5,
                ..layer(1.0)
            },
            Cloud {
                coverage: 0.0,
                ..layer(1.0)
            },
            Cloud {
                number_density_m3: 0.0,
                ..cumulus()
            },
            Cloud {
                lwc_gradient_g_m4: -1.0,
                ..cumulus()
            },
            Cloud {
                effective_variance: 0.5,
                ..cumulus()
            },
            Cloud {
                top_y_m: 500.0,
                ..cumulus()
            },
            Cloud {
                width_x_m: 0.0,
                ..cumulus()
            },
        ];
        for shape in parts {
            assert!(shape.volume().is_err(), "{shape:?}");
        }
    }
}
