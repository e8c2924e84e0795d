//! A box in which radius and number density run linearly along an axis.
//!
//! a(t) = a0 (1 - t) + a1 t,   N(t) = N0 (1 - t) + N1 t,   t = 0 at the low face, 1 at the high one
//!
//! Rain below and cloud drops above: a from 1.5 mm to 0.01 mm with height, N from 0 to 1000 /m³.
//! With V the volume of the box, da = a1 - a0, dN = N1 - N0:
//! total drops = V (N0 + N1)/2
//! total water = (4/3) pi rho_w V (1 - v)(1 - 2v) [N0 (4 a0³ + 3 a0² a1 + 2 a0 a1² + a1³)
//!                                                + N1 (a0³ + 2 a0² a1 + 3 a0 a1² + 4 a1³)]/20
//! `v` effective variance, rho_w density of water. The extinction pi N a² has its maximum at a face
//! or where dN a + 2 N da = 0.

use std::f64::consts::PI;

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_radiometry::Micrometers;
use niji_sizes::GammaSizes;
use niji_sizes::liquid_water_g_m3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::error::require_number_density;

/// Square metres in a square micrometre.
const M2_PER_UM2: f64 = 1e-12;

/// An axis of world space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// East.
    X,
    /// Up.
    Y,
    /// South.
    Z,
}

impl Axis {
    fn index(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// A box with a linear run of radius and number density.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gradient {
    /// Lowest corner (m).
    pub box_min_m: [f64; 3],
    /// Highest corner (m).
    pub box_max_m: [f64; 3],
    /// Edge length of a voxel (m).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: f64,
    /// The axis along which both run.
    pub axis: Axis,
    /// Effective radius at the low face (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_at_min_um: f64,
    /// Effective radius at the high face (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_at_max_um: f64,
    /// Number density at the low face (1/m³).
    #[schemars(range(min = 0.0))]
    pub number_density_at_min_m3: f64,
    /// Number density at the high face (1/m³).
    #[schemars(range(min = 0.0))]
    pub number_density_at_max_m3: f64,
    /// Effective variance everywhere; 0, a single size at every place, if left out.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5))]
    pub effective_variance: f64,
}

impl Gradient {
    /// Check all parameters.
    ///
    /// # Errors
    /// The parameter that is wrong, what was found and what was expected.
    pub fn validate(&self) -> Result<(), Error> {
        for radius in [self.radius_at_min_um, self.radius_at_max_um] {
            GammaSizes::new(Micrometers(radius), self.effective_variance)?;
        }
        require_number_density("number_density_at_min_m3", self.number_density_at_min_m3)?;
        require_number_density("number_density_at_max_m3", self.number_density_at_max_m3)?;
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

    /// Lay the shape out as a volume.
    ///
    /// # Errors
    /// As [`Gradient::validate`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        self.validate()?;
        let axis = self.axis.index();
        let (low, high) = (self.box_min_m[axis], self.box_max_m[axis]);
        let mode = DropMode::from_fn("", &self.grid(), |position| {
            let t = ((position[axis] - low) / (high - low)).clamp(0.0, 1.0);
            let (radius_um, number_density_m3) = self.at(t);
            Drops {
                number_density_m3: number_density_m3 as f32,
                effective_radius_m: (1e-6 * radius_um) as f32,
                effective_variance: self.effective_variance as f32,
            }
        })?;
        Ok(DropVolume { modes: vec![mode] })
    }

    /// Radius (um) and number density (1/m³) at a fraction of the way from the low to the high face.
    pub fn at(&self, t: f64) -> (f64, f64) {
        let run = |from: f64, to: f64| from * (1.0 - t) + to * t;
        (
            run(self.radius_at_min_um, self.radius_at_max_um),
            run(self.number_density_at_min_m3, self.number_density_at_max_m3),
        )
    }

    /// Smallest and largest effective radius (um).
    pub fn effective_radius_range_um(&self) -> (f64, f64) {
        let (a, b) = (self.radius_at_min_um, self.radius_at_max_um);
        (a.min(b), a.max(b))
    }

    /// Smallest and largest effective variance at the nodes. Between nodes of different radius the
    /// moments are those of a mixture, which is wider; that depends on the voxel size.
    pub fn effective_variance_range(&self) -> (f64, f64) {
        (self.effective_variance, self.effective_variance)
    }

    /// Largest extinction without diffraction (1/m).
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let (a0, n0) = self.at(0.0);
        let (da, dn) = (
            self.radius_at_max_um - a0,
            self.number_density_at_max_m3 - n0,
        );
        // dN a + 2 N da = 0 is linear in t; without a solution this is not finite.
        let stationary = -(dn * a0 + 2.0 * da * n0) / (3.0 * da * dn);
        let inside = if (0.0..=1.0).contains(&stationary) {
            stationary
        } else {
            0.0
        };
        let area = |t| {
            let (a, n) = self.at(t);
            PI * M2_PER_UM2 * n * a * a * self.second_moment_factor()
        };
        [0.0, inside, 1.0].into_iter().map(area).fold(0.0, f64::max)
    }

    /// Drops in the whole box.
    pub fn total_drops(&self) -> f64 {
        let mean = 0.5 * (self.number_density_at_min_m3 + self.number_density_at_max_m3);
        mean * self.grid().volume_m3()
    }

    /// Water in the whole box (g).
    pub fn total_water_g(&self) -> f64 {
        let (a0, n0) = self.at(0.0);
        let (a1, n1) = self.at(1.0);
        let from_n0 =
            n0 * (4.0 * a0.powi(3) + 3.0 * a0 * a0 * a1 + 2.0 * a0 * a1 * a1 + a1.powi(3));
        let from_n1 =
            n1 * (a0.powi(3) + 2.0 * a0 * a0 * a1 + 3.0 * a0 * a1 * a1 + 4.0 * a1.powi(3));
        let mean_third_moment = self.second_moment_factor() * (from_n0 + from_n1) / 20.0;
        liquid_water_g_m3(mean_third_moment) * self.grid().volume_m3()
    }

    /// <r²>/r_e² = <r³>/r_e³ of the gamma law.
    fn second_moment_factor(&self) -> f64 {
        (1.0 - self.effective_variance) * (1.0 - 2.0 * self.effective_variance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rain below, cloud above, number density rising with height.
    fn gradient() -> Gradient {
        Gradient {
            box_min_m: [-50.0, 0.0, -200.0],
            box_max_m: [50.0, 64.0, -100.0],
            voxel_m: 1.0,
            axis: Axis::Y,
            radius_at_min_um: 1500.0,
            radius_at_max_um: 10.0,
            number_density_at_min_m3: 0.0,
            number_density_at_max_m3: 1000.0,
            effective_variance: 0.0,
        }
    }

    fn small(shape: Gradient) -> Gradient {
        Gradient {
            box_min_m: [0.0; 3],
            box_max_m: [4.0, 64.0, 4.0],
            ..shape
        }
    }

    #[test]
    fn totals_of_the_volume_equal_the_closed_forms() {
        for shape in [
            small(gradient()),
            Gradient {
                effective_variance: 0.1,
                ..small(gradient())
            },
            Gradient {
                number_density_at_min_m3: 500.0,
                ..small(gradient())
            },
        ] {
            let volume = shape.volume().unwrap().summary();
            // Linear: the midpoint rule over the nodes is exact up to f32.
            assert!((volume.total_drops / shape.total_drops() - 1.0).abs() < 2e-7);
            // A quartic: the error of the midpoint rule at 64 nodes, measured worst 2.0e-4.
            assert!((volume.total_water_g / shape.total_water_g() - 1.0).abs() < 3e-4);
        }
    }

    #[test]
    fn water_of_the_nodes_converges_quadratically_to_the_closed_form() {
        let error = |voxel_m: f64| {
            let shape = Gradient {
                voxel_m,
                ..small(gradient())
            };
            let water = shape.volume().unwrap().summary().total_water_g;
            (water / shape.total_water_g() - 1.0).abs()
        };
        let ratio = error(2.0) / error(1.0);
        assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
    }

    #[test]
    fn a_constant_gradient_is_a_uniform_box() {
        let shape = Gradient {
            radius_at_min_um: 100.0,
            radius_at_max_um: 100.0,
            number_density_at_min_m3: 1000.0,
            ..gradient()
        };
        let volume_m3 = 100.0 * 64.0 * 100.0;
        assert!((shape.total_water_g() / (4.188_790_204_786e-3 * volume_m3) - 1.0).abs() < 1e-12);
        assert!((shape.max_extinction_m1_q1() / 3.141_592_653_6e-5 - 1.0).abs() < 1e-10);
    }

    #[test]
    fn largest_extinction_is_found_inside_and_at_the_faces() {
        let cases = [
            gradient(),
            Gradient {
                number_density_at_min_m3: 1000.0,
                ..gradient()
            },
            Gradient {
                number_density_at_max_m3: 0.0,
                ..gradient()
            },
            Gradient {
                radius_at_max_um: 1500.0,
                ..gradient()
            },
        ];
        for shape in cases {
            let scan = (0..=10_000).map(|i| {
                let (a, n) = shape.at(f64::from(i) / 1e4);
                PI * M2_PER_UM2 * n * a * a
            });
            let scanned = scan.fold(0.0, f64::max);
            let bound = shape.max_extinction_m1_q1();
            assert!(scanned <= bound * (1.0 + 1e-12) && bound <= scanned * (1.0 + 1e-7) + 1e-300);
        }
    }

    #[test]
    fn nodes_run_from_face_to_face_along_each_axis() {
        for (axis, index) in [(Axis::X, 0), (Axis::Y, 1), (Axis::Z, 2)] {
            let box_max_m = [8.0; 3];
            let shape = Gradient {
                axis,
                box_min_m: [0.0; 3],
                box_max_m,
                ..gradient()
            };
            let mode = shape.volume().unwrap().modes.remove(0);
            let mut node = [3; 3];
            for step in 0..8 {
                node[index] = step;
                // A sixteenth of the way, three sixteenths, ...
                let t = (f64::from(step) + 0.5) / 8.0;
                let drops = mode.drops(node);
                assert!((1e6 * f64::from(drops.effective_radius_m) - shape.at(t).0).abs() < 1e-3);
                assert!((f64::from(drops.number_density_m3) - shape.at(t).1).abs() < 1e-3);
            }
        }
    }

    #[test]
    fn the_published_range_is_reported_as_unnatural() {
        let warnings = small(gradient()).volume().unwrap().summary().warnings;
        let text: Vec<_> = warnings.iter().map(ToString::to_string).collect();
        assert!(text.iter().any(|line| line.contains("fog")), "{text:?}");
    }

    #[test]
    fn unsound_parameters_are_refused() {
        for shape in [
            Gradient {
                radius_at_min_um: -1.0,
                ..gradient()
            },
            Gradient {
                radius_at_max_um: f64::NAN,
                ..gradient()
            },
            Gradient {
                effective_variance: 0.5,
                ..gradient()
            },
            Gradient {
                number_density_at_min_m3: -1.0,
                ..gradient()
            },
            Gradient {
                number_density_at_max_m3: f64::INFINITY,
                ..gradient()
            },
            Gradient {
                voxel_m: 0.0,
                ..gradient()
            },
        ] {
            assert!(shape.volume().is_err(), "{shape:?}");
        }
    }
}
