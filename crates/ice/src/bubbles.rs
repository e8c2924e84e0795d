//! Air bubbles, which make ice white.
//!
//! Ways between two bubbles have density beta exp(-beta s); a bubble turns light by theta with
//!   p(theta) = (1 - g²)/(4 pi (1 + g² - 2 g cos theta)^(3/2))
//! `beta` scattering coefficient [1/m], `g` mean of cos theta, 0.86 for bubbles in ice.
//! [HG41] L. Henyey and J. Greenstein, Astrophysical J. 93, 70-83 (1941); g from [MB91] P. Mullen and
//! S. Warren, J. Geophysical Research 93, 8403-8414 (1988).

use std::f64::consts::TAU;

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::directions::frame;
use crate::error::Error;
use crate::error::check_range;

/// Air bubbles in ice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bubbles {
    /// Scattering coefficient, 1/m: 0.1 where one sees some, 100 in white ice.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub scattering_per_m: f64,
    /// Mean cosine of the angle by which a bubble turns light, -1..1.
    #[serde(default = "usual_asymmetry")]
    #[schemars(range(min = -0.99, max = 0.99))]
    pub asymmetry: f64,
}

fn usual_asymmetry() -> f64 {
    0.86
}

impl Bubbles {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A coefficient that is negative or not finite, or an asymmetry beyond ±0.99.
    pub fn check(&self) -> Result<(), Error> {
        let expected = "0 to 1e6";
        check_range(
            "scattering_per_m",
            self.scattering_per_m,
            [0.0, 1e6],
            expected,
        )?;
        check_range("asymmetry", self.asymmetry, [-0.99, 0.99], "-0.99 to 0.99")
    }

    /// Way to the next bubble for a random number in 0..1, m; infinite without bubbles.
    pub(crate) fn free_path_m(&self, random: f64) -> f64 {
        if self.scattering_per_m > 0.0 {
            -(-random).ln_1p() / self.scattering_per_m
        } else {
            f64::INFINITY
        }
    }

    /// Direction after a bubble, by inversion (HG41).
    pub(crate) fn scattered(&self, direction: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let g = self.asymmetry;
        let cos_theta = if g.abs() < 1e-3 {
            // The inverse is 0/0 for g = 0; this is its first order.
            let x = 2.0 * u - 1.0;
            x + 1.5 * g * (1.0 - x * x)
        } else {
            let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
            (1.0 + g * g - ratio * ratio) / (2.0 * g)
        };
        let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * v).sin_cos();
        let local = DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
        (frame(direction) * local).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;

    const N_DRAWS: u64 = 100_000;

    #[test]
    fn turned_directions_have_the_density_of_henyey_and_greenstein() {
        for asymmetry in [-0.5, 0.0, 9e-4, 0.3, 0.86] {
            let bubbles = Bubbles {
                scattering_per_m: 1.0,
                asymmetry,
            };
            let mut chi2 = Chi2::new(40);
            let mut sum = 0.0;
            for index in 0..N_DRAWS {
                let turned = bubbles.scattered(DVec3::X, pseudo_random(index));
                let cos_theta = turned.dot(DVec3::X);
                chi2.count(((0.5 * cos_theta + 0.5) * 40.0).min(39.0) as usize);
                sum += cos_theta;
            }
            // Share of cosines below x, from the density.
            let below = |x: f64| {
                let g = asymmetry;
                if g == 0.0 {
                    return 0.5 * (1.0 + x);
                }
                let root = (1.0 + g * g - 2.0 * g * x).sqrt();
                (1.0 - g * g) / (2.0 * g) * (1.0 / root - 1.0 / (1.0 + g))
            };
            let edges: Vec<f64> = (0..=40).map(|i| below(f64::from(i) / 20.0 - 1.0)).collect();
            let shares: Vec<f64> = edges.windows(2).map(|pair| pair[1] - pair[0]).collect();
            chi2.assert_fits(&shares);
            // Standard error below 2e-3.
            assert!((sum / N_DRAWS as f64 - asymmetry).abs() < 6e-3);
        }
    }

    #[test]
    fn free_paths_are_exponential() {
        let bubbles = Bubbles {
            scattering_per_m: 4.0,
            asymmetry: 0.0,
        };
        let mut chi2 = Chi2::new(20);
        for index in 0..N_DRAWS {
            let [random] = pseudo_random(index);
            let share = 1.0 - (-4.0 * bubbles.free_path_m(random)).exp();
            chi2.count((share * 20.0).min(19.0) as usize);
        }
        chi2.assert_fits(&[0.05; 20]);
        let none = Bubbles {
            scattering_per_m: 0.0,
            asymmetry: 0.0,
        };
        assert!(none.free_path_m(0.5).is_infinite());
    }

    #[test]
    fn impossible_bubbles_are_refused() {
        for (scattering_per_m, asymmetry) in [(-1.0, 0.0), (f64::NAN, 0.0), (1.0, 1.0)] {
            let bubbles = Bubbles {
                scattering_per_m,
                asymmetry,
            };
            assert!(bubbles.check().is_err());
        }
    }
}
