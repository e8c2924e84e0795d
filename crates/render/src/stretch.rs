//! Thin cells in a row, whose light is gathered at one point.
//!
//! A fine lattice has cells over which next to nothing changes. Their light needs one exponential and
//! one place in the table together:
//!
//! W = A exp(-Q m) (1 + Q² V / 2),  A = T (1 - exp(-Q dtau)) / Q as for a piece
//!
//! `m`, `V` mean and variance over the light of the optical depth to the sun. Inside a cell M2 and it are
//! cubics, in Legendre polynomials y_0 + y_1 P1 + y_2 P2 + ...; over the light the second has the mean
//! t_0 + (m_1 t_1/3 + m_2 t_2/5)/m_0. The distance, t_1 P1 alone, has so too; the fading of the view path
//! counts as a part of m_1. Next come -Q³ c/6 and Q⁴ k/24 with the third and fourth central moments `c`
//! and `k`. Over a span s = Q |dtau_sun| the first is below s³/62, that of two points, by which cells are
//! taken in; the error that is told takes twice c as it is and k ~ V s²/2, twice that of even light and
//! two thirds more: cells have moments of their own.
//! Sizes are those of the stretch's mean moments, as those of a point are of a mixture, in which each cell
//! has the weight w (1 - Q (tau_sun - m)).
//!
//! Each of several modes has a stretch and a point of its own. They begin and end together: A is that of
//! the optical depth of all, and is shared out by their sums of the weights.

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
    /// M3/M2 of the means, half its slope (um), slope and bend of M2 over its mean.
    radius: f32,
    radius_half: f32,
    growth: f32,
    growth_bend: f32,
    /// Mean of the optical depth to the sun as far as M2 and it bend together, its slope, its variance
    /// where it bends, its least and largest value.
    tau_sun: f32,
    sun_slope: f32,
    sun_bend: f32,
    sun: (f32, f32),
    /// Optical depth at Q = 1 of the drops of its mode; 0 where they are so few that 1/M2 is infinite.
    pub(crate) depth: f64,
    /// Relative error of its light because of its lanes.
    error: f64,
}

impl ThinCell {
    /// The run of a ray through a cell whose lanes make a relative `error`.
    #[inline]
    pub(crate) fn new(start_m: f64, length_m: f64, lanes: &LaneCubic, error: f32) -> Self {
        let mean = lanes.mean();
        let [start, end] = lanes.ends();
        // Comparisons: `min` and `max` take care of NaN, of which there is none.
        let (low, high) = if start.w < end.w {
            (start.w, end.w)
        } else {
            (end.w, start.w)
        };
        let (slope, bend) = lanes.slope_and_bend();
        let per_m2 = 1.0 / mean.x;
        let radius = mean.y * per_m2;
        let growth_bend = bend.x * per_m2;
        let bend_w = bend.w * (1.0 / 180.0);
        // c2 (x² - x) + r x runs beyond its ends by no more than (|c2| - |r|)/4.
        let beyond = 0.25 * (bend.w.abs() - (high - low));
        let beyond = if beyond > 0.0 { beyond } else { 0.0 };
        Self {
            start_m,
            length_m,
            ends: [start, end],
            mean,
            radius,
            radius_half: 0.5 * per_m2 * (slope.y - radius * slope.x),
            growth: slope.x * per_m2,
            growth_bend,
            tau_sun: mean.w + growth_bend * bend_w,
            sun_slope: slope.w,
            // Moments of P2 over 1 + b P2: its square has the mean (1 + 2/7 b)/5.
            sun_bend: bend.w * bend_w * (1.0 + growth_bend * (1.0 / 21.0 - growth_bend / 180.0)),
            sun: (low - beyond, high + beyond),
            depth: if per_m2.is_finite() {
                EXTINCTION_PER_M2 * length_m * f64::from(mean.x)
            } else {
                0.0
            },
            error: f64::from(error),
        }
    }
}

/// Cells of a mode that one point stands for. Sums over them have weights w = dtau exp(-Q tau) from the
/// start on, dtau of the mode, tau of all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stretch {
    /// Optical depth at Q = 1 of the drops of all modes.
    pub(crate) depth: f64,
    /// Sum of the weights.
    pub(crate) weight: f64,
    /// Sums of distance and its square [m, m²].
    distance: [f64; 2],
    /// Sums of the optical depth to the sun, its square and its cube.
    tau_sun: [f64; 3],
    /// Sum of the relative errors.
    error: f64,
    /// Sums of the moments, and of them times the optical depth to the sun.
    moments: [Vec4; 2],
    spans: Spans,
    /// What it would span with the cell that was admitted last.
    admitted: Spans,
}

/// What a stretch spans.
#[derive(Clone, Copy, Debug, Default)]
struct Spans {
    /// Least and largest optical depth to the sun.
    sun: (f32, f32),
    /// Mean radius of the first cell (um).
    radius: f32,
    /// Radii where it begins and ends (um).
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
    /// Nothing gathered yet, and no drops of other modes passed.
    pub(crate) fn is_empty(&self) -> bool {
        self.depth <= 0.0
    }

    /// Take a cell with drops in; false, and nothing done, if it does not fit.
    #[inline]
    pub(crate) fn join(&mut self, cell: &ThinCell, rule: &PieceRule, axes: &SizeAxes) -> bool {
        let fits = self.admits(cell, cell.depth, rule, axes);
        if fits {
            self.add(cell, cell.depth, rule);
        }
        fits
    }

    /// Whether a cell with drops in fits that has an optical depth of `depth` with those of other modes.
    #[inline]
    fn admits(&mut self, cell: &ThinCell, depth: f64, rule: &PieceRule, axes: &SizeAxes) -> bool {
        let [start, end] = cell.ends;
        let first = self.weight <= 0.0;
        let (low, high) = cell.sun;
        let span = if first {
            (low, high)
        } else {
            let (least, most) = self.spans.sun;
            (
                if low < least { low } else { least },
                if high > most { high } else { most },
            )
        };
        let view = rule.view_efficiency * (self.depth + depth);
        let sun = rule.sun_efficiency * f64::from(span.1 - span.0);
        let most_error = MOST_ERROR * sun * (sun + view) * (sun + view);
        if view > MOST_VIEW || most_error > rule.relative_error() {
            return false;
        }
        let radius = if first {
            cell.radius
        } else {
            self.spans.radius
        };
        if axes.n_radii() > 1 {
            // |r - r_0|/r_0 in nodes, times r_0 and M2: no division.
            let per_ln = axes.radii_per_ln();
            let (half, slack) = (0.5 * rule.stretch_bins() as f32, SIZE_SLACK * cell.mean.x);
            let fits = |at: Vec4| {
                per_ln * (at.y - radius * at.x).abs() <= radius * (half * at.x + per_ln * slack)
            };
            if !(fits(start) && fits(end)) {
                return false;
            }
        }
        let begin = if first {
            cell.radius - cell.radius_half
        } else {
            self.spans.radii.0
        };
        self.admitted = Spans {
            sun: span,
            radius,
            radii: (begin, cell.radius + cell.radius_half),
        };
        true
    }

    /// Add the cell that was admitted last.
    #[inline]
    fn add(&mut self, cell: &ThinCell, depth: f64, rule: &PieceRule) {
        self.spans = self.admitted;
        let view = rule.view_efficiency * depth;
        let in_front = rule.view_efficiency * self.depth + 0.5 * view;
        self.depth += depth;
        // exp(-in_front) to 3e-4 at the longest stretch: the weights share the light out, no more.
        let high = 0.5 - in_front * (1.0 / 6.0 - in_front * (1.0 / 24.0));
        let fade = 1.0 - in_front * (1.0 - in_front * high);
        let weight = fade * cell.depth;
        // Where M2 grows along the cell, so does the part of its light at the far end; the cell itself
        // takes some of that away.
        let lean = (f64::from(cell.growth) - view) / 12.0;
        let middle_m = cell.start_m + cell.length_m * (0.5 + lean);
        // Variance of the place of its light: ends without drops take some of it away.
        let even = 1.0 / 12.0 + f64::from(cell.growth_bend) / 180.0;
        let spread = (even - lean * lean).max(0.0);
        let rise = f64::from(cell.sun_slope);
        let tau_sun = f64::from(cell.tau_sun) + lean * rise;
        self.weight += weight;
        self.error += weight * cell.error;
        self.distance[0] += weight * middle_m;
        self.distance[1] += weight * (middle_m * middle_m + spread * cell.length_m * cell.length_m);
        let spread = spread * rise * rise + f64::from(cell.sun_bend);
        let square = tau_sun * tau_sun;
        self.tau_sun[0] += weight * tau_sun;
        self.tau_sun[1] += weight * (square + spread);
        self.tau_sun[2] += weight * (tau_sun * (square + 3.0 * spread));
        let moments = (fade * cell.length_m) as f32 * cell.mean;
        self.moments[0] += moments;
        self.moments[1] += tau_sun as f32 * moments;
    }

    /// The stretch as one point.
    #[inline]
    pub(crate) fn point(&self, rule: &PieceRule, axes: &SizeAxes) -> StretchPoint {
        let per_weight = 1.0 / self.weight;
        let variance = |mean: f64, square: f64| (square - mean * mean).max(0.0);
        let [tau_sun, square, cube] = self.tau_sun.map(|sum| sum * per_weight);
        let tau_sun_variance = variance(tau_sun, square);
        let skew = cube - tau_sun * (3.0 * square - 2.0 * tau_sun * tau_sun);
        let [distance_m, square_m2] = self.distance.map(|sum| sum * per_weight);
        let q = rule.sun_efficiency;
        let span = q * f64::from(self.spans.sun.1 - self.spans.sun.0);
        let of_point = q * q * ((q * skew).abs() / 3.0 + span * span * tau_sun_variance / 48.0);
        let relative_error = self.error * per_weight + of_point;
        let (first, last) = self.spans.radii;
        let bins = if axes.n_radii() > 1 {
            f64::from(2.0 * (last - first).abs() / (first + last) * axes.radii_per_ln())
        } else {
            0.0
        };
        // A cell's sizes count as its light does, 1 - Q (tau_sun - m), and never less than nothing.
        let q_of_sizes = if span > 1.0 { q / span } else { q };
        let [moments, by_tau_sun] = self.moments;
        let lanes = moments + q_of_sizes as f32 * (tau_sun as f32 * moments - by_tau_sun);
        StretchPoint {
            lanes: lanes.with_w(tau_sun as f32),
            tau_sun_variance,
            distance_m,
            distance_variance_m2: variance(distance_m, square_m2),
            relative_error,
            bins,
        }
    }
}

/// How drops are crossed, and which sizes their light goes to.
#[derive(Clone, Copy)]
pub(crate) struct Crossing<'a> {
    pub(crate) rule: &'a PieceRule,
    pub(crate) axes: &'a SizeAxes,
}

/// Let cells of a piece of optical depth `depth` join the stretches of their modes, all or none.
pub(crate) fn join_all(
    stretches: &mut [Stretch],
    cells: &[Option<ThinCell>],
    depth: f64,
    crossing: Crossing,
) -> bool {
    let Crossing { rule, axes } = crossing;
    for (stretch, cell) in stretches.iter_mut().zip(cells) {
        if let Some(cell) = cell
            && !stretch.admits(cell, depth, rule, axes)
        {
            return false;
        }
    }
    for (stretch, cell) in stretches.iter_mut().zip(cells) {
        match cell {
            Some(cell) => stretch.add(cell, depth, rule),
            None => stretch.depth += depth,
        }
    }
    true
}

#[cfg(test)]
#[path = "stretch_tests.rs"]
mod tests;
