//! How tilts and oscillations of falling drops blur a bow: its evaluation.
//!
//! The axis of a drop lies about the vertical by Fisher's law, p(τ) ∝ exp(cos τ/σ²) sin τ:
//!   S2 = ⟨sin² τ⟩ = 2 σ² L,   S4 = ⟨sin⁴ τ⟩ = 8 σ⁴ (1 − 3 σ² L),   L = coth(1/σ²) − σ²
//!   ⟨T²⟩ = T² + (1 − 3 T²) S2/2, and so B² and N²;   mean shift = Δθ(⟨T²⟩, ⟨B²⟩)
//!   var = (3 μ − t)² (S4 − S2²)/4 + 2 (S2 − S4) g² + S4 A²/2 + (∂Δθ/∂e)² sd(e)²
//!   P = ∂Δθ/∂T²,   R = ∂Δθ/∂B²,   t = P + R,   μ = P T² + R B²,   g² = P² T² + R² B² − μ²,
//!   A² = (P² + R² − μ²)/2 − g² − (t − μ)²/4,   sd(e) = 2 sd(q)/(1 + q)²
//! `τ` angle of the axis to the vertical, `σ` standard deviation of its tilt in each of two upright planes
//! (radians), `T`, `B`, `N`, `e` and `Δθ` of [`crate::BowShift`] for the upright drop, `q` axis ratio and
//! `sd(q)` its scatter by oscillation. P and R are taken at the mean squares and at the root mean square
//! of e, ∂Δθ/∂e at the mean squares.
//!
//! To first order of e, Δθ = e k m with m = T² − B², the mean is that of m (1 − 3 S2/2), nearly
//! m (1 − 3 σ²), and
//!   var(m) = (9/4) m² (S4 − S2²) + 2 (S2 − S4) (1 − N² − m²) + S4 (N² + m²/4)/2,
//! nearly 4 σ² (1 − N² − m²): hypot(2 σ e k sqrt(1 − N² − m²), k m sd(q)/2). Where the shift is
//! stationary (m = 1) 10 σ⁴ are left, a standard deviation of 3.2 σ².
//!
//! Derivation, accuracy and sources stand with `DropMotion` of `niji-scatter`, which makes these numbers.

use crate::bow_shift::BowShift;
use crate::bow_shift::SeenShift;

/// Drops of one size in motion: how flat they are and how they lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FallingDrops {
    /// e of the drops at rest.
    pub eccentricity: f64,
    /// Standard deviation of e.
    pub eccentricity_sd: f64,
    /// S2, mean of the square of the sine of the tilt.
    pub mean_sin2: f64,
    /// S4, mean of its fourth power.
    pub mean_sin4: f64,
}

/// How tilted drops lie to one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// ⟨T²⟩ and ⟨B²⟩.
    pub mean_squares: [f64; 2],
    /// The part of var that tilts make, as a form in P², P R and R².
    form: [f64; 3],
}

impl FallingDrops {
    /// Mean over the tilts of the square of a component of the axis, T², B² or N², which is `square` for
    /// upright drops.
    pub fn mean_square(&self, square: f64) -> f64 {
        square + 0.5 * self.mean_sin2 * (1.0 - 3.0 * square)
    }

    /// How drops that tilt so lie; T² and B² are those of upright drops.
    pub fn attitude(&self, t2: f64, b2: f64) -> Attitude {
        let (s2, s4) = (self.mean_sin2, self.mean_sin4);
        let variance = |p: f64, r: f64| {
            let (trace, mu) = (p + r, p * t2 + r * b2);
            let g2 = p * p * t2 + r * r * b2 - mu * mu;
            let a2 = 0.5 * (p * p + r * r - mu * mu) - g2 - 0.25 * (trace - mu).powi(2);
            0.25 * (3.0 * mu - trace).powi(2) * (s4 - s2 * s2)
                + 2.0 * (s2 - s4) * g2
                + 0.5 * s4 * a2
        };
        let (p2, r2) = (variance(1.0, 0.0), variance(0.0, 1.0));
        Attitude {
            mean_squares: [t2, b2].map(|square| self.mean_square(square)),
            form: [p2, variance(1.0, 1.0) - p2 - r2, r2],
        }
    }

    /// Variance of Δθ in rad² of a shift seen at the mean squares of an attitude.
    #[inline]
    pub fn variance_rad2(&self, seen: &SeenShift, attitude: &Attitude) -> f64 {
        let e = (self.eccentricity.powi(2) + self.eccentricity_sd.powi(2)).sqrt();
        let [p, r] = seen.slopes(e);
        let [p2, pr, r2] = attitude.form;
        let by_e = seen.eccentricity_slope(self.eccentricity) * self.eccentricity_sd;
        // Roundoff may leave a variance of 0 a little below.
        (p2 * p * p + pr * p * r + r2 * r * r + by_e * by_e).max(0.0)
    }

    /// Δθ in radians at the mean squares; T² and B² are those of upright drops.
    pub fn mean_shift_rad(&self, shift: &BowShift, t2: f64, b2: f64) -> f64 {
        let [t2, b2] = self.attitude(t2, b2).mean_squares;
        shift.shift_rad(self.eccentricity, t2, b2)
    }

    /// Standard deviation of Δθ in radians; T² and B² are those of upright drops.
    pub fn shift_sd_rad(&self, shift: &BowShift, t2: f64, b2: f64) -> f64 {
        let attitude = self.attitude(t2, b2);
        let [t2, b2] = attitude.mean_squares;
        self.variance_rad2(&shift.seen(t2, b2), &attitude).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear in T² and B²: e² (T² + B²) is the second order.
    const LINEAR: BowShift = BowShift {
        coefficients_rad: [1.7, 0.9, 1.8, 0.9, 0.9],
    };
    /// Components of the upright axis: along T, B and N, none of them, no first order.
    const AXES: [[f64; 3]; 5] = [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.48, 0.6, 0.64],
        [0.6, 0.6, 0.529_150_262_212_918_2],
    ];
    const STILL: FallingDrops = FallingDrops {
        eccentricity: 0.2,
        eccentricity_sd: 0.0,
        mean_sin2: 0.0,
        mean_sin4: 0.0,
    };
    /// Of means and variances; measured worst 6e-17.
    const ROUNDING: f64 = 1e-15;

    /// Drops that all tilt by one angle.
    fn on_a_cone(tilt_rad: f64) -> FallingDrops {
        let mean_sin2 = tilt_rad.sin().powi(2);
        FallingDrops {
            mean_sin2,
            mean_sin4: mean_sin2 * mean_sin2,
            ..STILL
        }
    }

    /// Mean and variance of the shift of drops whose axes lie evenly on a cone.
    fn of_a_cone(axis: [f64; 3], tilt_rad: f64) -> [f64; 2] {
        let [x, y, z] = axis;
        // Two directions across the axis and each other, by one mirror.
        let factor = 1.0 / (1.0 + z);
        let across = [
            [1.0 - factor * x * x, -factor * x * y],
            [-factor * x * y, 1.0 - factor * y * y],
        ];
        let n = 16;
        let shifts = (0..n).map(|index| {
            let (s, c) = (std::f64::consts::TAU * f64::from(index) / f64::from(n)).sin_cos();
            let square = |j: usize| {
                let side = c * across[0][j] + s * across[1][j];
                (tilt_rad.cos() * axis[j] + tilt_rad.sin() * side).powi(2)
            };
            LINEAR.shift_rad(STILL.eccentricity, square(0), square(1))
        });
        let shifts: Vec<f64> = shifts.collect();
        let mean = shifts.iter().sum::<f64>() / f64::from(n);
        let squares: f64 = shifts.iter().map(|shift| (shift - mean).powi(2)).sum();
        [mean, squares / f64::from(n)]
    }

    #[test]
    fn drops_at_rest_shift_without_blur() {
        for [t, b, _] in AXES {
            let (t2, b2) = (t * t, b * b);
            let shift = LINEAR.shift_rad(STILL.eccentricity, t2, b2);
            assert_eq!(STILL.mean_shift_rad(&LINEAR, t2, b2), shift);
            assert_eq!(STILL.shift_sd_rad(&LINEAR, t2, b2), 0.0);
        }
    }

    #[test]
    fn mean_and_variance_are_those_of_axes_on_a_cone() {
        for tilt_rad in [1e-3, 0.13, 0.8, 1.5] {
            let drops = on_a_cone(tilt_rad);
            for axis in AXES {
                let (t2, b2) = (axis[0] * axis[0], axis[1] * axis[1]);
                let [mean, variance] = of_a_cone(axis, tilt_rad);
                assert!((drops.mean_shift_rad(&LINEAR, t2, b2) - mean).abs() < ROUNDING);
                let found = drops.shift_sd_rad(&LINEAR, t2, b2).powi(2);
                assert!((found - variance).abs() < ROUNDING, "{found} {variance}");
            }
        }
    }

    #[test]
    fn axes_of_all_directions_are_the_same_from_everywhere() {
        // ⟨T²⟩ = 1/3, var(T²) = 4/45 and cov(T², B²) = −2/45.
        let drops = FallingDrops {
            mean_sin2: 2.0 / 3.0,
            mean_sin4: 8.0 / 15.0,
            ..STILL
        };
        let e = drops.eccentricity;
        let [p, r] = [1.7, -1.7].map(|k| e * k + e * e * 0.9);
        let variance = (p * p + r * r - p * r) * 4.0 / 45.0;
        for [t, b, _] in AXES {
            let mean = drops.mean_shift_rad(&LINEAR, t * t, b * b);
            assert!((mean - (p + r) / 3.0).abs() < ROUNDING);
            let found = drops.shift_sd_rad(&LINEAR, t * t, b * b).powi(2);
            assert!((found - variance).abs() < ROUNDING);
        }
    }

    #[test]
    fn a_stationary_shift_is_blurred_by_the_square_of_the_tilt() {
        let first = BowShift {
            coefficients_rad: [1.0, 0.0, 0.0, 0.0, 0.0],
        };
        let variance = 0.01_f64.powi(2);
        let drops = FallingDrops {
            mean_sin2: 2.0 * variance,
            mean_sin4: 8.0 * variance * variance,
            ..STILL
        };
        for (t2, b2) in [(1.0, 0.0), (0.0, 1.0)] {
            let found = drops.shift_sd_rad(&first, t2, b2) / drops.eccentricity;
            // Measured worst 4e-16.
            assert!((found / variance - 10.0_f64.sqrt()).abs() < 1e-14);
        }
    }

    #[test]
    fn oscillations_add_the_variance_of_a_product() {
        // Of first order alone: ⟨e²⟩ var(m) + sd(e)² ⟨m⟩², since e and m are independent.
        let first = BowShift {
            coefficients_rad: [1.0, 0.0, 0.0, 0.0, 0.0],
        };
        let tilted = FallingDrops {
            eccentricity: 1.0,
            ..on_a_cone(0.13)
        };
        let trembling = FallingDrops {
            eccentricity: 0.2,
            eccentricity_sd: 0.05,
            ..tilted
        };
        for [t, b, _] in AXES {
            let (t2, b2) = (t * t, b * b);
            let mean = tilted.mean_shift_rad(&first, t2, b2);
            let variance = tilted.shift_sd_rad(&first, t2, b2).powi(2);
            let expected = (0.2_f64.powi(2) + 0.05_f64.powi(2)) * variance + (0.05 * mean).powi(2);
            let found = trembling.shift_sd_rad(&first, t2, b2).powi(2);
            assert!((found - expected).abs() < ROUNDING);
        }
    }
}
