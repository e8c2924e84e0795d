//! A coarse lattice of view directions around the sun's axis.
//!
//! d = cos(theta) s + sin(theta) (cos(phi) u + sin(phi) v)
//!
//! `s` unit vector towards the sun, `u` and `v` across it, `theta` scattering angle, along which the
//! light of drops changes most, `phi` azimuth around the sun. The lattice covers what the camera sees
//! of the drops and nothing else; its ends hold beyond it.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::scattering_angle::scattering_angle_rad;

/// Sectors in which azimuths are gathered.
const N_SECTORS: usize = 360;

/// Directions closer than this are one: 0.006 degrees, far below a pixel.
const ONE_DIRECTION_RAD: f64 = 1e-4;

/// The directions of some rays.
#[derive(Clone, Debug)]
pub(crate) struct SeenDirections {
    theta_rad: (f64, f64),
    sectors: Vec<bool>,
}

impl SeenDirections {
    /// None yet.
    pub(crate) fn none() -> Self {
        Self {
            theta_rad: (f64::INFINITY, f64::NEG_INFINITY),
            sectors: vec![false; N_SECTORS],
        }
    }

    /// Besides, a direction.
    pub(crate) fn add(&mut self, axes: &SunAxes, direction: DVec3) {
        let (theta_rad, azimuth_rad) = axes.angles_rad(direction);
        self.theta_rad.0 = self.theta_rad.0.min(theta_rad);
        self.theta_rad.1 = self.theta_rad.1.max(theta_rad);
        let sector = (azimuth_rad / TAU * N_SECTORS as f64) as usize;
        self.sectors[sector.min(N_SECTORS - 1)] = true;
    }

    /// The directions of both.
    pub(crate) fn union(mut self, other: &Self) -> Self {
        self.theta_rad.0 = self.theta_rad.0.min(other.theta_rad.0);
        self.theta_rad.1 = self.theta_rad.1.max(other.theta_rad.1);
        for (seen, also) in self.sectors.iter_mut().zip(&other.sectors) {
            *seen |= also;
        }
        self
    }

    /// Start and length of the shortest arc that holds every sector seen.
    fn arc_rad(&self) -> (f64, f64) {
        let seen: Vec<usize> = (0..N_SECTORS)
            .filter(|index| self.sectors[*index])
            .collect();
        let gap = |index: usize| {
            let next = seen[(index + 1) % seen.len()];
            (next + N_SECTORS - seen[index] - 1) % N_SECTORS
        };
        // The first of the widest gaps.
        let widest = (0..seen.len()).max_by_key(|index| (gap(*index), usize::MAX - index));
        let Some(widest) = widest else {
            return (0.0, 0.0);
        };
        let start = seen[(widest + 1) % seen.len()] as f64;
        let length = (N_SECTORS - gap(widest)) as f64;
        let sector_rad = TAU / N_SECTORS as f64;
        if seen.len() == 1 {
            // Its middle stands for it.
            return ((start + 0.5) * sector_rad, 0.0);
        }
        (start * sector_rad, length * sector_rad)
    }
}

/// The sun's direction and two across it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SunAxes {
    sun: DVec3,
    across: [DVec3; 2],
}

impl SunAxes {
    /// Axes of a sun.
    pub(crate) fn of(sun: DVec3) -> Self {
        let (u, v) = sun.any_orthonormal_pair();
        Self {
            sun,
            across: [u, v],
        }
    }

    /// Scattering angle, and azimuth in 0..2 pi.
    fn angles_rad(&self, direction: DVec3) -> (f64, f64) {
        let [u, v] = self.across.map(|axis| axis.dot(direction));
        let azimuth_rad = v.atan2(u).rem_euclid(TAU);
        (scattering_angle_rad(direction, self.sun), azimuth_rad)
    }
}

/// The lattice.
#[derive(Clone, Debug)]
pub(crate) struct ViewGrid {
    axes: SunAxes,
    theta: Line,
    azimuth: Line,
}

/// Even nodes on an axis.
#[derive(Clone, Copy, Debug)]
struct Line {
    start: f64,
    step: f64,
    n_nodes: usize,
    /// Whether the last node is followed by the first.
    closed: bool,
}

impl ViewGrid {
    /// `n_across` nodes along both angles; `None` where nothing was seen.
    pub(crate) fn over(seen: &SeenDirections, axes: SunAxes, n_across: usize) -> Option<Self> {
        let (low_rad, high_rad) = seen.theta_rad;
        if low_rad > high_rad {
            return None;
        }
        let (start_rad, length_rad) = seen.arc_rad();
        Some(Self {
            axes,
            theta: Line::between(low_rad, high_rad - low_rad, n_across),
            azimuth: if length_rad < TAU {
                Line::between(start_rad, length_rad, n_across)
            } else {
                Line::around(n_across)
            },
        })
    }

    /// Number of nodes.
    pub(crate) fn n_nodes(&self) -> usize {
        self.theta.n_nodes * self.azimuth.n_nodes
    }

    /// The direction of a node.
    pub(crate) fn direction(&self, node: usize) -> DVec3 {
        let theta = self.theta.node(node / self.azimuth.n_nodes);
        let azimuth = self.azimuth.node(node % self.azimuth.n_nodes);
        let (sin_theta, cos_theta) = theta.sin_cos();
        let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
        let [u, v] = self.axes.across;
        cos_theta * self.axes.sun + sin_theta * (cos_azimuth * u + sin_azimuth * v)
    }

    /// The nodes before and after a node along both axes; at an end the node itself stands for both.
    pub(crate) fn neighbors(&self, node: usize) -> [[usize; 2]; 2] {
        let n = self.azimuth.n_nodes;
        let (row, column) = (node / n, node % n);
        [
            self.theta.neighbors(row).map(|row| row * n + column),
            self.azimuth
                .neighbors(column)
                .map(|column| row * n + column),
        ]
    }

    /// Nodes around a direction with weights that sum to 1.
    pub(crate) fn around(&self, direction: DVec3) -> [(usize, f32); 4] {
        let (theta_rad, azimuth_rad) = self.axes.angles_rad(direction);
        let [below, above] = self.theta.around_value(theta_rad);
        // As far behind the start as ahead of it in turns.
        let ahead_rad = (azimuth_rad - self.azimuth.start).rem_euclid(TAU);
        let past_rad = ahead_rad - self.azimuth.length();
        let ahead_rad = if past_rad > 0.5 * (TAU - self.azimuth.length()) {
            ahead_rad - TAU
        } else {
            ahead_rad
        };
        let [left, right] = self.azimuth.around_value(self.azimuth.start + ahead_rad);
        [(below, left), (below, right), (above, left), (above, right)].map(|(row, column)| {
            // f32: weights of a light that is known to percents.
            let weight = (row.1 * column.1) as f32;
            (row.0 * self.azimuth.n_nodes + column.0, weight)
        })
    }
}

impl Line {
    fn between(start: f64, length: f64, n_nodes: usize) -> Self {
        let n_nodes = if length > ONE_DIRECTION_RAD {
            n_nodes.max(2)
        } else {
            1
        };
        let step = length / (n_nodes.max(2) - 1) as f64;
        Self {
            start,
            step,
            n_nodes,
            closed: false,
        }
    }

    /// A whole turn.
    fn around(n_nodes: usize) -> Self {
        Self {
            start: 0.0,
            step: TAU / n_nodes.max(2) as f64,
            n_nodes: n_nodes.max(2),
            closed: true,
        }
    }

    fn length(&self) -> f64 {
        let n_steps = if self.closed {
            self.n_nodes
        } else {
            self.n_nodes - 1
        };
        n_steps as f64 * self.step
    }

    fn node(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }

    fn neighbors(&self, index: usize) -> [usize; 2] {
        let last = self.n_nodes - 1;
        match (index, self.closed) {
            (0, true) => [last, 1],
            (index, true) => [index - 1, (index + 1) % self.n_nodes],
            (index, false) if index == 0 || index == last => [index; 2],
            (index, false) => [index - 1, index + 1],
        }
    }

    /// The two nodes around a value with their weights; the ends hold beyond them.
    fn around_value(&self, value: f64) -> [(usize, f64); 2] {
        if self.n_nodes == 1 {
            return [(0, 1.0), (0, 0.0)];
        }
        let last = if self.closed {
            self.n_nodes - 1
        } else {
            self.n_nodes - 2
        };
        let place = ((value - self.start) / self.step).max(0.0);
        let lower = (place as usize).min(last);
        let fraction = (place - lower as f64).min(1.0);
        let upper = (lower + 1) % self.n_nodes;
        [(lower, 1.0 - fraction), (upper, fraction)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SUN: DVec3 = DVec3::new(0.0, 0.6, 0.8);

    fn direction(axes: &SunAxes, theta_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (theta, azimuth) = (theta_deg.to_radians(), azimuth_deg.to_radians());
        let [u, v] = axes.across;
        theta.cos() * axes.sun + theta.sin() * (azimuth.cos() * u + azimuth.sin() * v)
    }

    fn grid(directions_deg: &[(f64, f64)], n_across: usize) -> (SunAxes, ViewGrid) {
        let axes = SunAxes::of(SUN);
        let mut seen = SeenDirections::none();
        for (theta_deg, azimuth_deg) in directions_deg {
            seen.add(&axes, direction(&axes, *theta_deg, *azimuth_deg));
        }
        (axes, ViewGrid::over(&seen, axes, n_across).unwrap())
    }

    #[test]
    fn a_function_linear_in_both_angles_is_reproduced_also_across_azimuth_zero() {
        let (axes, grid) = grid(&[(100.0, 340.5), (170.0, 20.5), (140.0, 0.5)], 9);
        let value = |theta_deg: f64, azimuth_deg: f64| theta_deg + 3.0 * azimuth_deg;
        let stored: Vec<f64> = (0..grid.n_nodes())
            .map(|node| {
                let (theta, azimuth) = axes.angles_rad(grid.direction(node));
                let azimuth_deg = (azimuth.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
                value(theta.to_degrees(), azimuth_deg)
            })
            .collect();
        for (theta_deg, azimuth_deg) in [(100.0, -19.0), (133.0, 0.0), (169.0, 19.0)] {
            let found: f64 = grid
                .around(direction(&axes, theta_deg, azimuth_deg))
                .iter()
                .map(|(node, weight)| stored[*node] * f64::from(*weight))
                .sum();
            // f32 weights.
            assert!(
                (found - value(theta_deg, azimuth_deg)).abs() < 1e-4,
                "{theta_deg}"
            );
        }
    }

    #[test]
    fn a_full_circle_is_closed() {
        let all: Vec<(f64, f64)> = (0..360)
            .map(|step| (140.0, f64::from(step) + 0.5))
            .collect();
        let (axes, grid) = grid(&all, 12);
        assert_eq!(grid.n_nodes(), 12);
        let [(left, a), (right, b), ..] = grid.around(direction(&axes, 140.0, 345.0));
        assert_eq!((left, right), (11, 0));
        assert!((a - 0.5).abs() < 1e-5 && (b - 0.5).abs() < 1e-5);
    }

    #[test]
    fn weights_sum_to_one_and_the_nearest_end_holds_beyond_the_lattice() {
        let (axes, grid) = grid(&[(130.0, 50.5), (150.0, 90.5)], 5);
        for (theta_deg, azimuth_deg) in [(0.0, 0.0), (180.0, 70.0), (120.0, 200.0), (140.0, 300.0)]
        {
            let around = grid.around(direction(&axes, theta_deg, azimuth_deg));
            let sum: f32 = around.iter().map(|(_, weight)| weight).sum();
            assert!((sum - 1.0).abs() < 1e-6);
        }
        let before = grid.around(direction(&axes, 130.0, 30.0));
        assert!((before[0].0, before[0].1) == (0, 1.0), "{before:?}");
        let beyond = grid.around(direction(&axes, 130.0, 110.0));
        assert!(beyond[1].0 == 4 && beyond[1].1 > 0.999, "{beyond:?}");
    }

    #[test]
    fn nothing_seen_is_no_lattice_and_one_direction_one_angle() {
        let axes = SunAxes::of(SUN);
        assert!(ViewGrid::over(&SeenDirections::none(), axes, 8).is_none());
        let (_, grid) = grid(&[(140.0, 10.5)], 8);
        assert_eq!(grid.theta.n_nodes, 1);
    }
}
