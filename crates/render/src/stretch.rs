//! Thin cells in a row, whose light is gathered at one point.
//!
//! A fine lattice has cells over which next to nothing changes. Their light needs one exponential and
//! one place in the table together:
//!
//! W = A exp(-Q m) (1 + Q² V / 2),  A = T (1 - exp(-Q dtau)) / Q as for a piece
//!
//! `m`, `V` mean and variance over the light of the optical depth to the sun, whose cubics are taken as
//! linear inside a cell; so are the moments of the distance. Next come -Q³ c/6 and Q⁴ k/24 with the
//! third and fourth central moments `c` and `k`. Over a span s = Q |dtau_sun| the first is below s³/62,
//! that of two points, by which cells are taken in; the error that is told takes c as it is and
//! k ~ V s²/4, that of even light and two thirds more.
//! Sizes are those of the stretch's mean moments, as those of a point are of a mixture, in which each cell
//! has the weight w (1 - Q (tau_sun - m)).

use glam::Vec4;

use crate::lane_cubic::LaneCubic;
use crate::piece::EXTINCTION_PER_M2;
use crate::piece_rule::PieceRule;
use crate::size_axes::SizeAxes;

/// Q dtau over a stretch.
const MOST_VIEW: f64 = 0.5;

/// s (s + v)² times this is at least the relative error of a stretch; v = Q dtau of the view path.
const MOST_ERROR: f64 = 1.0 / 60.0;

/// Part of the mean M2 of a cell up to which rounding may move M3 / r from M2 at its ends.
const SIZE_SLACK: f32 = 1e-3;

/// A cell on its way into a stretch.
pub(crate) struct ThinCell {
    start_m: f64,
    length_m: f64,
    /// Lanes at the ends.
    ends: [Vec4; 2],
    /// Means of the lanes over the cell.
    mean: Vec4,
    /// Optical depth at Q = 1.
    pub(crate) depth: f64,
    /// Relative error of its light because of its lanes.
    error: f64,
}

impl ThinCell {
    /// The run of a ray through a cell whose lanes make a relative `error`.
    #[inline]
    pub(crate) fn new(start_m: f64, length_m: f64, lanes: &LaneCubic, error: f32) -> Self {
        let mean = lanes.mean();
        let start = lanes.at(0.0);
        Self {
            start_m,
            length_m,
            ends: [start, start + lanes.change()],
            mean,
            depth: EXTINCTION_PER_M2 * length_m * f64::from(mean.x),
            error: f64::from(error),
        }
    }
}

/// Cells that one point stands for. Sums over them have weights w = dtau exp(-Q tau) from the start on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stretch {
    /// Optical depth at Q = 1.
    pub(crate) depth: f64,
    /// Sum of the weights.
    weight: f64,
    /// Sums of distance and its square [m, m²].
    distance: [f64; 2],
    /// Sums of the optical depth to the sun, its square and its cube.
    tau_sun: [f64; 3],
    /// Sum of the relative errors.
    error: f64,
    /// Sums of the moments, and of them times the optical depth to the sun.
    moments: [Vec4; 2],
    /// Least and largest optical depth to the sun.
    span: (f32, f32),
    /// Radii of the first and the last cell (um).
    radii: (f32, f32),
}

/// What a stretch is to its point.
pub(crate) struct StretchPoint {
    /// Means of the moments and of the optical depth to the sun, as lanes.
    pub(crate) lanes: Vec4,
    /// Variance of the optical depth to the sun.
    pub(crate) tau_sun_variance: f64,
    /// Mean and variance of the distance [m, m²].
    pub(crate) distance_m: f64,
    pub(crate) distance_variance_m2: f64,
    /// Relative error of its light.
    pub(crate) relative_error: f64,
    /// Nodes of the table's radius axis that it spans.
    pub(crate) bins: f64,
}

impl Stretch {
    pub(crate) fn is_empty(&self) -> bool {
        self.depth <= 0.0
    }

    /// Take a cell with drops in; false, and nothing done, if it does not fit.
    #[inline]
    pub(crate) fn join(&mut self, cell: &ThinCell, rule: &PieceRule, axes: &SizeAxes) -> bool {
        let [start, end] = cell.ends;
        let first = self.is_empty();
        // Comparisons: `min` and `max` take care of NaN, of which there is none.
        let (low, high) = if start.w < end.w {
            (start.w, end.w)
        } else {
            (end.w, start.w)
        };
        let span = if first {
            (low, high)
        } else {
            let (least, most) = self.span;
            (
                if low < least { low } else { least },
                if high > most { high } else { most },
            )
        };
        let depth = self.depth + cell.depth;
        let view = rule.view_efficiency * depth;
        let sun = rule.sun_efficiency * f64::from(span.1 - span.0);
        let most_error = MOST_ERROR * sun * (sun + view) * (sun + view);
        if view > MOST_VIEW || most_error > rule.relative_error() {
            return false;
        }
        if axes.n_radii() > 1 {
            let radius = if first {
                cell.mean.y / cell.mean.x
            } else {
                self.radii.0
            };
            // |r - r_0|/r_0 in nodes, times r_0 and M2: no division.
            let per_ln = axes.radii_per_ln();
            let (half, slack) = (0.5 * rule.stretch_bins() as f32, SIZE_SLACK * cell.mean.x);
            let fits = |at: Vec4| {
                per_ln * (at.y - radius * at.x).abs() <= radius * (half * at.x + per_ln * slack)
            };
            if !(fits(start) && fits(end)) {
                return false;
            }
            self.radii = (radius, cell.mean.y / cell.mean.x);
        }
        self.span = span;
        self.add(cell, rule.view_efficiency);
        true
    }

    /// Add a cell.
    #[inline]
    fn add(&mut self, cell: &ThinCell, view_efficiency: f64) {
        let view = view_efficiency * cell.depth;
        let in_front = view_efficiency * self.depth + 0.5 * view;
        self.depth += cell.depth;
        // exp(-in_front) to 3e-4 at the longest stretch: the weights share the light out, no more.
        let high = 0.5 - in_front * (1.0 / 6.0 - in_front * (1.0 / 24.0));
        let fade = 1.0 - in_front * (1.0 - in_front * high);
        let weight = fade * cell.depth;
        let [start, end] = cell.ends;
        let change = end - start;
        // Where M2 grows along the cell, so does the part of its light at the far end; the cell itself
        // takes some of that away.
        let lean = (f64::from(change.x / cell.mean.x) - view) / 12.0;
        let middle_m = cell.start_m + cell.length_m * (0.5 + lean);
        // Variance of the place of its light where M2 is linear; in a corner of the drops' box it is not.
        let spread = (1.0 / 12.0 - lean * lean).max(0.0);
        let rise = f64::from(change.w);
        let tau_sun = f64::from(cell.mean.w) + lean * rise;
        self.weight += weight;
        self.error += weight * cell.error;
        self.distance[0] += weight * middle_m;
        self.distance[1] += weight * (middle_m * middle_m + spread * cell.length_m * cell.length_m);
        let (square, spread) = (tau_sun * tau_sun, spread * rise * rise);
        self.tau_sun[0] += weight * tau_sun;
        self.tau_sun[1] += weight * (square + spread);
        self.tau_sun[2] += weight * (tau_sun * (square + 3.0 * spread));
        let moments = (fade * cell.length_m) as f32 * cell.mean;
        self.moments[0] += moments;
        self.moments[1] += tau_sun as f32 * moments;
    }

    /// The stretch as one point; it is empty again.
    #[inline]
    pub(crate) fn take(&mut self, rule: &PieceRule, axes: &SizeAxes) -> StretchPoint {
        let per_weight = 1.0 / self.weight;
        let variance = |mean: f64, square: f64| (square - mean * mean).max(0.0);
        let [tau_sun, square, cube] = self.tau_sun.map(|sum| sum * per_weight);
        let tau_sun_variance = variance(tau_sun, square);
        let skew = cube - tau_sun * (3.0 * square - 2.0 * tau_sun * tau_sun);
        let [distance_m, square_m2] = self.distance.map(|sum| sum * per_weight);
        let q = rule.sun_efficiency;
        let span = q * f64::from(self.span.1 - self.span.0);
        let of_point = q * q * ((q * skew).abs() / 6.0 + span * span * tau_sun_variance / 96.0);
        let relative_error = self.error * per_weight + of_point;
        let (first, last) = self.radii;
        let bins = if axes.n_radii() > 1 {
            f64::from(2.0 * (last - first).abs() / (first + last) * axes.radii_per_ln())
        } else {
            0.0
        };
        // A cell's sizes count as its light does, 1 - Q (tau_sun - m), and never less than nothing.
        let q_of_sizes = if span > 1.0 { q / span } else { q };
        let [moments, by_tau_sun] = self.moments;
        let lanes = moments + q_of_sizes as f32 * (tau_sun as f32 * moments - by_tau_sun);
        let point = StretchPoint {
            lanes: lanes.with_w(tau_sun as f32),
            tau_sun_variance,
            distance_m,
            distance_variance_m2: variance(distance_m, square_m2),
            relative_error,
            bins,
        };
        *self = Self::default();
        point
    }
}

#[cfg(test)]
#[path = "stretch_tests.rs"]
mod tests;
