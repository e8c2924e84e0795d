//! The average over the sun's disc of light that is known as means over rings of scattering angle.
//!
//! t̄(θ) = Σ_rings Σ_k m_k a_k,   m_k = ∫_ring s^k w(θ, θ') dθ' / ∫ w dθ',   s = (θ' − middle)/step
//! `w` is the kernel of [`crate::sun_disc`], a_0 + a_1 s + a_2 s² the parabola whose means over the ring
//! and its two neighbours are the given ones. A mean over a ring has lost most of the fringes that are
//! narrower than it, so they cannot pass for wider ones.
//! At the poles the neighbour is the ring itself (t is even there).

use std::f64::consts::PI;

use crate::sun_disc::AverageRow;
use crate::sun_disc::kernel;

/// Nodes and weights of Gauss and Legendre on −1..1, for the part of the disc within a ring.
const GAUSS_NODES: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_8),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_8),
];

/// Even rings of scattering angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rings {
    /// Lower edge of the first.
    pub first_rad: f64,
    /// Width of each.
    pub step_rad: f64,
    /// How many.
    pub n: usize,
}

/// The average over a sun's disc of light that is known at some places: a row of weights by angle.
#[derive(Clone, Debug)]
pub struct DiscAverage(pub(crate) Vec<AverageRow>);

impl DiscAverage {
    /// The average around the middle of each ring, none of it below 0.
    pub fn of(&self, light: &[f64]) -> Vec<f64> {
        let mean = |row: &AverageRow| {
            let terms = row.weights.iter().zip(&light[row.start..]);
            let sum: f64 = terms.map(|(weight, light)| weight * light).sum();
            sum.max(0.0)
        };
        self.0.iter().map(mean).collect()
    }

    /// No average: the light of places that are the angles themselves.
    pub(crate) fn of_point(n_angles: usize) -> Self {
        let own = |start| AverageRow {
            start,
            weights: vec![1.0],
        };
        Self((0..n_angles).map(own).collect())
    }

    /// The averages of both polarizations.
    pub(crate) fn of_both(&self, light: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.0.iter().map(|row| row.apply(light)).collect()
    }
}

impl Rings {
    /// Rings around evenly spaced angles, from the lower end of a range to its upper one or a step beyond.
    pub fn around((low_rad, high_rad): (f64, f64), step_rad: f64) -> Self {
        let n_steps = ((high_rad - low_rad).max(0.0) / step_rad).ceil() as usize;
        Self {
            first_rad: low_rad - 0.5 * step_rad,
            step_rad,
            n: n_steps + 1,
        }
    }

    /// The middles of the rings, none above π.
    pub fn angles(&self) -> Vec<f64> {
        let middle = |index| self.middle_rad(index).min(PI);
        (0..self.n).map(middle).collect()
    }

    /// The ring with an angle in it.
    pub(crate) fn holding(&self, theta_rad: f64) -> Option<usize> {
        let place = (theta_rad - self.first_rad) / self.step_rad;
        (place >= 0.0 && place < self.n as f64).then_some(place as usize)
    }

    /// The average over a sun's disc of this diameter; light ends where the rings do.
    pub fn seen_from_disc(&self, diameter_rad: f64) -> DiscAverage {
        let angles = self.angles().into_iter();
        let row = |theta_rad| self.disc_row(theta_rad, 0.5 * diameter_rad);
        DiscAverage(angles.map(row).collect())
    }

    /// Rings of about `step_rad` over a range and as far around it as a disc and a neighbour need.
    pub(crate) fn over((low, high): (f64, f64), step_rad: f64, radius_rad: f64) -> Self {
        let margin_rad = radius_rad + 2.0 * step_rad;
        let first_rad = (low - margin_rad).max(0.0);
        let last_rad = (high + margin_rad).min(PI);
        let n = ((last_rad - first_rad) / step_rad).ceil().max(3.0);
        Self {
            first_rad,
            step_rad: (last_rad - first_rad) / n,
            n: n as usize,
        }
    }

    /// Lower edge of a ring, or the upper one of the last ring for `index` = n.
    pub(crate) fn edge_rad(&self, index: usize) -> f64 {
        (self.first_rad + self.step_rad * index as f64).min(PI)
    }

    pub(crate) fn middle_rad(&self, index: usize) -> f64 {
        self.first_rad + self.step_rad * (index as f64 + 0.5)
    }

    /// Weights of the rings for a disc of radius `radius_rad` around θ; they sum to 1.
    pub(crate) fn disc_row(&self, theta_rad: f64, radius_rad: f64) -> AverageRow {
        let [first, last] = self.under_disc(theta_rad, radius_rad);
        let start = first.saturating_sub(1);
        let end = (last + 1).min(self.n - 1);
        let mut weights = vec![0.0; end - start + 1];
        for ring in first..=last {
            let [m0, m1, m2] = self.moments(ring, theta_rad, radius_rad);
            // a_0 = t − (t_+ − 2 t + t_−)/24, a_1 = (t_+ − t_−)/2, a_2 = (t_+ − 2 t + t_−)/2.
            let bend = 0.5 * m2 - m0 / 24.0;
            weights[ring.saturating_sub(1) - start] += bend - 0.5 * m1;
            weights[ring - start] += m0 - 2.0 * bend;
            weights[(ring + 1).min(self.n - 1) - start] += bend + 0.5 * m1;
        }
        AverageRow::normalized(start, weights)
    }

    /// The same for light that is taken as even within each ring: whole rings are exact then, however steep
    /// the light is that is in them.
    pub(crate) fn even_disc_row(&self, theta_rad: f64, radius_rad: f64) -> AverageRow {
        let [first, last] = self.under_disc(theta_rad, radius_rad);
        let share = |ring: usize| self.moments(ring, theta_rad, radius_rad)[0];
        AverageRow::normalized(first, (first..=last).map(share).collect())
    }

    /// The first and the last ring under a disc around θ.
    fn under_disc(&self, theta_rad: f64, radius_rad: f64) -> [usize; 2] {
        [theta_rad - radius_rad, theta_rad + radius_rad].map(|angle| {
            let position = (angle - self.first_rad) / self.step_rad;
            (position.max(0.0) as usize).min(self.n - 1)
        })
    }

    /// ∫ s^k w dθ' over a ring, k = 0, 1, 2, in the variable ψ, θ' = θ + R sin ψ, in which the edge of
    /// the disc is smooth.
    fn moments(&self, ring: usize, theta_rad: f64, radius_rad: f64) -> [f64; 3] {
        let psi = |angle: f64| ((angle - theta_rad) / radius_rad).clamp(-1.0, 1.0).asin();
        let (low, high) = (psi(self.edge_rad(ring)), psi(self.edge_rad(ring + 1)));
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let mut sums = [0.0; 3];
        for (node, share) in GAUSS_NODES {
            let (sine, cosine) = (middle + half * node).sin_cos();
            let angle = theta_rad + radius_rad * sine;
            let s = (angle - self.middle_rad(ring)) / self.step_rad;
            let weight = kernel(theta_rad, angle, radius_rad) * radius_rad * cosine * half * share;
            sums[0] += weight;
            sums[1] += weight * s;
            sums[2] += weight * s * s;
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.2665 * PI / 180.0;

    fn rings() -> Rings {
        Rings::over((0.0, PI), RADIUS / 10.0, RADIUS)
    }

    /// Means over the rings of a function with the primitive given.
    fn means(rings: &Rings, primitive: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let mean = |ring| {
            let (low, high) = (rings.edge_rad(ring), rings.edge_rad(ring + 1));
            [(primitive(high) - primitive(low)) / (high - low); 2]
        };
        (0..rings.n).map(mean).collect()
    }

    #[test]
    fn a_parabola_is_averaged_exactly() {
        // Over a disc of radius R far from the poles ⟨u²⟩ = R²/4 and ⟨u⟩ = R² cot θ/8.
        let rings = rings();
        let theta = 2.3_f64;
        let values = means(&rings, |x| (x - theta).powi(3) / 3.0);
        let mean = rings.disc_row(theta, RADIUS).apply(&values)[0];
        assert!((mean / (RADIUS * RADIUS / 4.0) - 1.0).abs() < 2e-3);
        let values = means(&rings, |x| (x - theta).powi(2) / 2.0);
        let mean = rings.disc_row(theta, RADIUS).apply(&values)[0];
        assert!((mean / (RADIUS * RADIUS / (8.0 * theta.tan())) - 1.0).abs() < 2e-2);
    }

    #[test]
    fn a_constant_stays_everywhere() {
        let rings = rings();
        let values = vec![[1.0; 2]; rings.n];
        for theta in [0.0, 0.5 * RADIUS, 1.0, PI - 0.2 * RADIUS, PI] {
            let mean = rings.disc_row(theta, RADIUS).apply(&values)[0];
            assert!((mean - 1.0).abs() < 1e-12, "{mean} at {theta}");
        }
    }

    #[test]
    fn a_cone_around_the_antisolar_point_is_averaged_in_two_dimensions() {
        let rings = rings();
        let values = means(&rings, |x| PI * x - 0.5 * x * x);
        let mean = rings.disc_row(PI, RADIUS).apply(&values)[0];
        assert!((mean / (2.0 * RADIUS / 3.0) - 1.0).abs() < 5e-3);
    }

    #[test]
    fn fringes_hardly_wider_than_a_ring_are_blurred_as_the_disc_does() {
        // The disc leaves 2 J1(ω R)/(ω R) of a fringe, at most 1.6 (ω R)^(−3/2): below 0.7 % here.
        let rings = rings();
        for period in [1.0, 1.3, 1.7, 2.0, 2.6] {
            let frequency = 2.0 * PI / (period * rings.step_rad);
            let values = means(&rings, |x| (frequency * x).sin() / frequency);
            for theta in [2.0, 2.001, 2.0021] {
                let left = rings.disc_row(theta, RADIUS).apply(&values)[0].abs();
                assert!(left < 0.01, "{left} of a fringe at period {period}");
            }
        }
    }

    #[test]
    fn even_light_stays_and_a_step_is_half_lit_in_its_middle() {
        let rings = Rings::around((2.2, 2.6), 1e-3);
        let disc = rings.seen_from_disc(2.0 * RADIUS);
        let even = disc.of(&vec![1.0; rings.n]);
        assert!(even.iter().all(|value| (value - 1.0).abs() < 1e-12));
        let step: Vec<f64> = (0..rings.n)
            .map(|i| f64::from(u8::from(i >= 200)))
            .collect();
        let seen = disc.of(&step);
        // The step lies between the angles 199 and 200.
        let middle = 0.5 * (seen[199] + seen[200]);
        assert!((middle - 0.5).abs() < 2e-3, "{middle}");
        assert!(seen[190] < 1e-3 && seen[209] > 1.0 - 1e-3);
    }

    #[test]
    fn angles_end_at_the_antisolar_point() {
        let rings = Rings::around((3.1, PI), 1e-3);
        assert!(rings.angles().iter().all(|theta_rad| *theta_rad <= PI));
        assert_eq!(rings.angles().last(), Some(&PI));
        assert_eq!(rings.holding(3.0999), Some(0));
        assert_eq!(rings.holding(3.0), None);
        let even = rings.seen_from_disc(2.0 * RADIUS).of(&vec![2.0; rings.n]);
        assert!(even.iter().all(|value| (value - 2.0).abs() < 1e-12));
    }

    #[test]
    fn one_angle_is_its_own_average() {
        let rings = Rings::around((2.0, 2.0), 1e-3);
        assert_eq!(rings.n, 1);
        let seen = rings.seen_from_disc(2.0 * RADIUS).of(&[3.0]);
        assert!((seen[0] - 3.0).abs() < 1e-12);
    }
}
