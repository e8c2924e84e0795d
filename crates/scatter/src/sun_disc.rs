//! The average over the sun's disc.
//!
//! t̄(θ) = ∫ t(θ') w(θ, θ') dθ' / ∫ w dθ',   w = 2 ψ sin θ',
//! cos ψ = (cos R − cos θ cos θ')/(sin θ sin θ')
//! `R` radius of the disc, ψ half the angle of the circle of scattering angle θ' that lies on the disc
//! (π where all of it does). This is the true average over a uniform disc at every θ; the usual chord
//! kernel 2 sqrt(R² − (θ' − θ)²) is its limit away from 0 and 180 degrees and wrong near them, where
//! it inflates the norm. Intensities are averaged, never amplitudes.
//!
//! `t` is held on a fine even grid and taken as linear between its nodes; the weights of the hat
//! functions come from midpoints on sixteen parts of each cell.

use std::f64::consts::PI;

/// Parts of a cell in which the kernel is sampled.
const N_PARTS: usize = 16;

/// An even grid of scattering angles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FineGrid {
    pub(crate) first_rad: f64,
    pub(crate) step_rad: f64,
    pub(crate) n: usize,
}

/// Weights of consecutive nodes of the fine grid; they sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct AverageRow {
    pub(crate) start: usize,
    pub(crate) weights: Vec<f64>,
}

impl AverageRow {
    /// The row whose weights are in proportion to these.
    pub(crate) fn normalized(start: usize, mut weights: Vec<f64>) -> Self {
        let total: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= total;
        }
        Self { start, weights }
    }

    /// The average of both polarisations held at the nodes of the fine grid.
    pub(crate) fn apply(&self, values: &[[f64; 2]]) -> [f64; 2] {
        let nodes = &values[self.start..self.start + self.weights.len()];
        let mut sum = [0.0; 2];
        for (weight, value) in self.weights.iter().zip(nodes) {
            sum[0] += weight * value[0];
            sum[1] += weight * value[1];
        }
        sum
    }
}

/// The average over a disc of radius `radius_rad` around θ.
pub(crate) fn disc_row(grid: &FineGrid, theta_rad: f64, radius_rad: f64) -> AverageRow {
    let first = (theta_rad - radius_rad).abs().min(theta_rad).max(0.0);
    let low = if theta_rad < radius_rad { 0.0 } else { first };
    let high = (theta_rad + radius_rad).min(PI);
    let index = |angle: f64| ((angle - grid.first_rad) / grid.step_rad).max(0.0);
    let start = (index(low).floor() as usize).min(grid.n - 2);
    let end = (index(high).ceil() as usize).clamp(start + 1, grid.n - 1);
    let mut weights = vec![0.0; end - start + 1];
    for cell in start..end {
        for part in 0..N_PARTS {
            let t = (part as f64 + 0.5) / N_PARTS as f64;
            let angle = grid.first_rad + grid.step_rad * (cell as f64 + t);
            let weight = kernel(theta_rad, angle, radius_rad);
            weights[cell - start] += (1.0 - t) * weight;
            weights[cell - start + 1] += t * weight;
        }
    }
    AverageRow::normalized(start, weights)
}

/// w(θ, θ') = 2 ψ sin θ'.
pub(crate) fn kernel(theta_rad: f64, angle_rad: f64, radius_rad: f64) -> f64 {
    if !(0.0..=PI).contains(&angle_rad) {
        return 0.0;
    }
    // cos R − cos(θ − θ') without cancellation; then the disc's edge and the pole within it.
    let half = |sum: f64, difference: f64| (0.5 * sum).sin() * (0.5 * difference).sin();
    let apart = angle_rad - theta_rad;
    let inside = 2.0 * half(radius_rad + apart.abs(), radius_rad - apart.abs());
    let product = theta_rad.sin() * angle_rad.sin();
    // 1 − cos ψ = (cos(θ − θ') − cos R)/(sin θ sin θ').
    if inside <= 0.0 {
        return 0.0;
    }
    if inside >= 2.0 * product {
        return 2.0 * PI * angle_rad.sin();
    }
    let half_sine = (0.5 * inside / product).sqrt();
    4.0 * half_sine.asin() * angle_rad.sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.2665 * PI / 180.0;

    /// Angle of a node.
    fn angle(grid: &FineGrid, index: usize) -> f64 {
        (grid.first_rad + grid.step_rad * index as f64).min(PI)
    }

    fn grid() -> FineGrid {
        let step_rad = RADIUS / 20.0;
        FineGrid {
            first_rad: 0.0,
            step_rad,
            n: (PI / step_rad) as usize + 2,
        }
    }

    #[test]
    fn the_kernel_covers_the_solid_angle_of_the_disc() {
        for theta_deg in [0.0, 0.1, 0.2665, 0.4, 42.0, 90.0, 137.9, 179.8, 180.0_f64] {
            let n = 400_000;
            let (low, high) = (
                theta_deg.to_radians() - RADIUS,
                theta_deg.to_radians() + RADIUS,
            );
            let step = (high - low) / f64::from(n);
            let sum: f64 = (0..n)
                .map(|i| {
                    kernel(
                        theta_deg.to_radians(),
                        low + step * (f64::from(i) + 0.5),
                        RADIUS,
                    )
                })
                .sum();
            let solid_angle = 4.0 * PI * (0.5 * RADIUS).sin().powi(2);
            assert!(
                (sum * step / solid_angle - 1.0).abs() < 1e-5,
                "at {theta_deg} degrees"
            );
        }
    }

    #[test]
    fn away_from_the_poles_it_is_the_chord_kernel() {
        let theta = 1.2;
        for part in [-0.9, -0.3, 0.0, 0.6, 0.95] {
            let apart = part * RADIUS;
            let chord = 2.0 * (RADIUS * RADIUS - apart * apart).sqrt();
            let ratio = kernel(theta, theta + apart, RADIUS) / chord;
            assert!((ratio - 1.0).abs() < 3.0 * RADIUS, "ratio {ratio}");
        }
    }

    #[test]
    fn a_constant_stays_and_the_disc_blurs_a_step_evenly() {
        let grid = grid();
        for theta in [0.0, 0.5 * RADIUS, 1.0, PI - 0.2 * RADIUS, PI] {
            let row = disc_row(&grid, theta, RADIUS);
            assert!((row.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
        let edge = 2.0;
        let step: Vec<[f64; 2]> = (0..grid.n)
            .map(|i| {
                if angle(&grid, i) < edge {
                    [0.0; 2]
                } else {
                    [1.0; 2]
                }
            })
            .collect();
        let middle = disc_row(&grid, edge, RADIUS).apply(&step)[0];
        assert!((middle - 0.5).abs() < 0.02);
    }

    #[test]
    fn a_cone_around_the_antisolar_point_is_averaged_in_two_dimensions() {
        // t = π − θ' around θ = π: the mean distance from the center of a disc is 2R/3.
        let grid = grid();
        let cone: Vec<[f64; 2]> = (0..grid.n).map(|i| [PI - angle(&grid, i); 2]).collect();
        let mean = disc_row(&grid, PI, RADIUS).apply(&cone)[0];
        assert!(
            (mean / (2.0 * RADIUS / 3.0) - 1.0).abs() < 5e-3,
            "{}",
            mean / RADIUS
        );
    }
}
