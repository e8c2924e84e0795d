//! The light of a piece of a ray inside one cell, and what the piece takes from the light behind it.
//!
//! dW/ds = pi M2(s) exp(-Q tau(s)) exp(-Q tau_sun(s)),  tau(s) = int_0^s pi M2 ds'
//!
//! `M2` second moment [m²/m³], `Q` extinction efficiency (0 where extinction is off), `tau_sun`
//! optical depth to the sun at Q = 1. Without the sun's factor the integral over a piece is known:
//!
//! A = T (1 - exp(-Q dtau)) / Q   (dtau where Q = 0),  T = exp(-Q tau) at the entry.
//!
//! The Gauss points x_g only share it out, f_g ~ w_g M2(x_g) exp(-Q tau(x_g)), sum f_g = 1:
//!
//! W = A sum_g f_g exp(-Q tau_sun(x_g)), and f_g A of it goes to the sizes at x_g.
//!
//! So a piece of any thickness never gives out more light than it takes, a homogeneous medium
//! without shadow is exact, and thin pieces use `expm1` because 1 - exp(-tau) has no digits there.
//! M2 is a cubic on a piece and tau its exact integral.
//!
//! Errors: with the variation v = Q dtau + Q |dtau_sun| of the exponent, the N-point rule errs by
//! about v²/24, v⁴/4320 and v⁶/2016000 for N = 1, 2, 3 (error term of Gauss-Legendre for exp).

use glam::Vec4;

use crate::deposits::Deposits;
use crate::exponential::transmittance;
use crate::lane_cubic::LaneCubic;
use crate::levels::Integration;
use crate::piece::EXTINCTION_PER_M2;
use crate::piece::Piece;
use crate::size_axes::SizeAxes;
use crate::stretch::Stretch;
use crate::stretch::StretchPoint;

/// Optical depth below which series replace `exp` and `expm1`; their errors are 4e-10 and, for the
/// shares of the Gauss points alone, 2e-5.
const THIN: f64 = 0.05;

/// Optical depth of drops in front at which a ray ends: what lies behind adds 4e-18.
pub(crate) const OPAQUE: f64 = 40.0;

/// A piece is cut into no more parts than this.
const MAX_PARTS: f64 = 64.0;

/// Relative error of a part at the level that is exact in the cell.
const CELL_EXACT_ERROR: f64 = 1e-6;

/// Q dtau of the view path over a part with one, two and three points. It makes no error in the
/// light, but light at one end of a part has that end's size and distance.
const VIEW_LIMITS: [f64; 3] = [0.5, 1.0, 2.0];

/// Nodes of the table's radius axis over a part with one, two and three points. The axis is as fine
/// as the rows need for linear interpolation, so nodes are a measure of how fast rows change.
/// No part has one point only: it would lose where in the part the light is, which air dims.
const CELL_EXACT_BINS: [f64; 3] = [-1.0, 6.0, 9.0];

/// The same over a stretch. Across a node of the table, where the rows bend, one point errs by a part
/// of the table's own error that grows with the square of the span; measured 6e-6 for 512 sizes.
const CELL_EXACT_STRETCH_BINS: f64 = 0.8;

/// The same at the other levels, in parts of what one point of a piece may span.
const ADAPTIVE_STRETCH: f64 = 0.75;

/// Nodes of the table's radius axis for each point at a relative error of 1; they shrink with its
/// fourth root, as the error of two points grows with the fourth power of their distance.
const ADAPTIVE_BINS: f64 = 7.0;

/// What the variance of sizes counts for that N points stand for, in squares of their span: twice the
/// largest value of the rule's Peano kernel. Interpolated linearly, rows have a kink at each node of the
/// table; wherever in the span it lies, the mean error is a quarter to a half of what this makes of it.
const SIZE_VARIANCE: [f64; 3] = [0.25, 0.0447, 0.0349];

/// v^(2N) times this is the relative error of the N-point rule.
const GAUSS_ERROR: [f64; 3] = [1.0 / 24.0, 1.0 / 4320.0, 1.0 / 2.016e6];

/// Positions and weights of the Gauss-Legendre rules on 0..1.
const GAUSS_1: [(f64, f64); 1] = [(0.5, 1.0)];
const GAUSS_2: [(f64, f64); 2] = [
    (0.211_324_865_405_187_1, 0.5),
    (0.788_675_134_594_812_9, 0.5),
];
const GAUSS_3: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];

/// Drops at a point of a ray, before the sun's way is taken off their light.
#[derive(Clone, Copy)]
struct LitPoint {
    lanes: Vec4,
    light: f64,
    /// Mean and variance of the distance of the stretch that it stands for [m, m²].
    distance_m: f64,
    distance_variance_m2: f64,
}

/// How pieces are evaluated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PieceRule {
    /// Extinction efficiency on the view path, 0 where extinction is off.
    pub(crate) view_efficiency: f64,
    /// One over it; not asked for where it is 0.
    per_view_efficiency: f64,
    /// Extinction efficiency on the sun's path, 0 where drops cast no shadow.
    pub(crate) sun_efficiency: f64,
    control: Control,
}

/// What a part may span.
#[derive(Clone, Copy, Debug)]
struct Control {
    /// Largest relative error of its light.
    relative_error: f64,
    /// Largest span on the table's radius axis in nodes for one, two and three points.
    bins: [f64; 3],
    /// Largest span of a stretch.
    stretch_bins: f64,
}

/// What varies over a piece.
#[derive(Clone, Copy, Debug)]
struct Variation {
    /// Q dtau on the view path.
    view: f64,
    /// Q |dtau_sun|.
    sun: f64,
    /// Optical depth at Q = 1 of the change of M2.
    m2_depth: f64,
    /// Optical depth at Q = 1.
    depth: f64,
    /// Place on the table's radius axis, in nodes.
    bins: f64,
}

impl PieceRule {
    /// The rule of a level.
    pub(crate) fn new(view_efficiency: f64, sun_efficiency: f64, level: Integration) -> Self {
        let (relative_error, bins, stretch_bins) = match level {
            // The literal march has no pieces and never asks.
            Integration::CellExact | Integration::FixedStep { .. } => {
                (CELL_EXACT_ERROR, CELL_EXACT_BINS, CELL_EXACT_STRETCH_BINS)
            }
            Integration::Adaptive { relative_error } => {
                let bins = ADAPTIVE_BINS * relative_error.powf(0.25);
                (
                    relative_error,
                    [bins, 2.0 * bins, 3.0 * bins],
                    ADAPTIVE_STRETCH * bins,
                )
            }
        };
        let control = Control {
            relative_error,
            bins,
            stretch_bins,
        };
        Self {
            view_efficiency,
            per_view_efficiency: 1.0 / view_efficiency,
            sun_efficiency,
            control,
        }
    }

    /// The same rule at another level.
    pub(crate) fn at(&self, level: Integration) -> Self {
        Self::new(self.view_efficiency, self.sun_efficiency, level)
    }

    /// Largest relative error of the light of a stretch.
    #[inline]
    pub(crate) fn relative_error(&self) -> f64 {
        self.control.relative_error
    }

    /// Nodes of the table's radius axis that a stretch may span.
    #[inline]
    pub(crate) fn stretch_bins(&self) -> f64 {
        self.control.stretch_bins
    }

    /// Deposit the light of a stretch of each mode, whose cells let `through` pass in front of them, as
    /// for [`PieceRule::gather`].
    #[inline]
    pub(crate) fn gather_stretches(
        &self,
        axes: &SizeAxes,
        stretches: &mut [Stretch],
        through: &mut f64,
        deposits: &mut Deposits,
    ) {
        let light = self.unshadowed(stretches[0].depth, through);
        let weight: f64 = stretches.iter().map(|stretch| stretch.weight).sum();
        for stretch in stretches {
            let share = stretch.weight / weight;
            if share > 0.0 {
                self.gather_point(axes, &stretch.point(self, axes), share * light, deposits);
            }
            *stretch = Stretch::default();
        }
    }

    /// Deposit what the sun's way leaves of the light of a stretch.
    #[inline]
    fn gather_point(
        &self,
        axes: &SizeAxes,
        point: &StretchPoint,
        light: f64,
        deposits: &mut Deposits,
    ) {
        if point.lanes.x <= 0.0 {
            return;
        }
        let bend = 0.5 * self.sun_efficiency * self.sun_efficiency * point.tau_sun_variance;
        let lit = LitPoint {
            lanes: point.lanes,
            light: light * (1.0 + bend),
            distance_m: point.distance_m,
            distance_variance_m2: point.distance_variance_m2,
        };
        let light = self.deposit(axes, &lit, deposits);
        deposits.error += light * point.relative_error;
        deposits.size_variance += light * SIZE_VARIANCE[0] * point.bins * point.bins;
    }

    /// Deposit what the sun's way leaves of the light of a point; returns it.
    #[inline]
    fn deposit(&self, axes: &SizeAxes, point: &LitPoint, deposits: &mut Deposits) -> f64 {
        let LitPoint {
            lanes,
            light,
            distance_m,
            distance_variance_m2,
        } = *point;
        let sunlit = transmittance(self.sun_efficiency as f32 * lanes.w);
        let light = light * f64::from(sunlit);
        let place = axes.place(lanes.x, lanes.y, lanes.z);
        deposits.add(place, distance_m, f64::from(lanes.w), light);
        deposits.light_m2 += light * distance_variance_m2;
        light
    }

    /// A, the light of a part of optical depth `depth` at Q = 1; the part then lies in front.
    #[inline]
    fn unshadowed(&self, depth: f64, through: &mut f64) -> f64 {
        if self.view_efficiency <= 0.0 {
            return depth;
        }
        let absorbed = *through * absorbed(self.view_efficiency * depth);
        *through -= absorbed;
        absorbed * self.per_view_efficiency
    }

    /// Deposit the light of a piece behind drops that let `through` of it pass, exp(-Q tau), which
    /// becomes what the piece lets pass in addition.
    #[inline]
    pub(crate) fn gather(
        &self,
        axes: &SizeAxes,
        piece: &Piece,
        through: &mut f64,
        deposits: &mut Deposits,
    ) {
        let depth = piece.depth();
        if depth <= 0.0 {
            return;
        }
        let variation = self.variation(axes, piece, depth);
        let mut gathering = Gathering {
            rule: self,
            axes,
            piece,
            through,
            deposits,
        };
        let whole = Part {
            from: 0.0,
            to: 1.0,
            depth_before: 0.0,
            depth,
        };
        if let Some(error) = variation.error_of(1, &self.control) {
            gathering.part(&GAUSS_1, &whole, error, variation.bins);
        } else if let Some(error) = variation.error_of(2, &self.control) {
            gathering.part(&GAUSS_2, &whole, error, variation.bins);
        } else {
            gathering.parts(variation.n_parts(&self.control), &variation);
        }
    }

    /// What varies over a piece of optical depth `depth`.
    #[inline]
    fn variation(&self, axes: &SizeAxes, piece: &Piece, depth: f64) -> Variation {
        let view = self.view_efficiency * depth;
        let mut variation = Variation {
            view,
            sun: 0.0,
            m2_depth: 0.0,
            depth,
            bins: 0.0,
        };
        for mode in piece.modes {
            // An arch between equal ends varies too.
            let (slope, bend) = mode.slope_and_bend();
            let change = slope.abs() + bend.abs();
            variation.sun = variation.sun.max(self.sun_efficiency * f64::from(change.w));
            variation.m2_depth = variation
                .m2_depth
                .max(EXTINCTION_PER_M2 * piece.length_m * f64::from(change.x));
            if axes.n_radii() > 1 {
                // At the ends of a piece there may be no drops, and so no size.
                let [(early, _), (late, _)] = GAUSS_2;
                let (a, b) = (mode.at(early as f32), mode.at(late as f32));
                // ln(r_b/r_a) ~ 2 (r_b - r_a)/(r_a + r_b), r = M3/M2, written with one division;
                // short of it by an eighth where the radius triples.
                let [r_a, r_b] = [a.y * (b.x / a.x), b.y];
                let ln_ratio = 2.0 * (r_b - r_a).abs() / (r_a + r_b) * 3.0_f32.sqrt();
                variation.bins = variation
                    .bins
                    .max(f64::from(ln_ratio * axes.radii_per_ln()));
            }
        }
        variation
    }
}

impl Variation {
    /// Relative error of the whole piece's light with `n_points`, if they suffice.
    #[inline]
    fn error_of(&self, n_points: usize, control: &Control) -> Option<f64> {
        let spans_little =
            self.bins <= control.bins[n_points - 1] && self.view <= VIEW_LIMITS[n_points - 1];
        let error = self.relative_error(n_points);
        (spans_little && error <= control.relative_error).then_some(error)
    }

    /// Parts of three points that a piece needs: their error falls with the sixth power.
    fn n_parts(&self, control: &Control) -> usize {
        let error = self.relative_error(3) / control.relative_error;
        // Most pieces are in one part: no power for them.
        let of_error = if error > 1.0 {
            error.powf(1.0 / 6.0)
        } else {
            1.0
        };
        let wanted = of_error
            .max(self.bins / control.bins[2])
            .max(self.view / VIEW_LIMITS[2]);
        wanted.ceil().clamp(1.0, MAX_PARTS) as usize
    }

    fn divided_by(&self, n_parts: usize) -> Self {
        let share = 1.0 / n_parts as f64;
        Self {
            view: share * self.view,
            sun: share * self.sun,
            m2_depth: share * self.m2_depth,
            depth: self.depth,
            bins: share * self.bins,
        }
    }

    /// Relative error of the light of a part with `n_points`. The light without the sun's factor is
    /// exact, so that one factor of the error term is the sun's.
    #[inline]
    fn relative_error(&self, n_points: usize) -> f64 {
        if self.sun <= 0.0 {
            return 0.0;
        }
        let change = self.view + self.sun + self.m2_depth / self.depth;
        self.sun * change.powi(2 * n_points as i32 - 1) * GAUSS_ERROR[n_points - 1]
    }
}

/// A piece on its way through the rule.
struct Gathering<'a> {
    rule: &'a PieceRule,
    axes: &'a SizeAxes,
    piece: &'a Piece<'a>,
    /// exp(-Q tau) of what lies in front.
    through: &'a mut f64,
    deposits: &'a mut Deposits,
}

/// A part of a piece.
struct Part {
    /// Fractions of the piece at its ends.
    from: f64,
    to: f64,
    /// Optical depths at Q = 1 of the piece in front of it, and of itself.
    depth_before: f64,
    depth: f64,
}

/// A Gauss rule laid over a part of a piece: positions, and weights times exp(-Q tau) from the
/// part's start.
type Points<const N: usize> = [(f64, f64); N];

impl Gathering<'_> {
    /// The light of a piece in `n_parts` parts of three points.
    fn parts(&mut self, n_parts: usize, variation: &Variation) {
        let variation = variation.divided_by(n_parts);
        let error = variation.relative_error(3);
        let end = |part: usize| part as f64 / n_parts as f64;
        let mut depth_before = 0.0;
        for part in 0..n_parts {
            let (from, to) = (end(part), end(part + 1));
            let depth_up_to = self.piece.depth_up_to(to);
            let depth = (depth_up_to - depth_before).max(0.0);
            let part = Part {
                from,
                to,
                depth_before,
                depth,
            };
            self.part(&GAUSS_3, &part, error, variation.bins);
            depth_before = depth_up_to;
        }
    }

    /// The light of a part, and its relative error.
    #[inline]
    fn part<const N: usize>(
        &mut self,
        rule: &Points<N>,
        part: &Part,
        relative_error: f64,
        bins: f64,
    ) {
        let light_before = self.deposits.light;
        let light = self.rule.unshadowed(part.depth, self.through);
        if light <= 0.0 {
            return;
        }
        let mut points = *rule;
        for (x, weight) in &mut points {
            *x = part.from + (part.to - part.from) * *x;
            // A single point has all the light.
            if N > 1 {
                *weight *= self.fade(self.piece.depth_up_to(*x) - part.depth_before);
            }
        }
        let lanes_of = |mode: &LaneCubic| lanes_at(mode, &points);
        match self.piece.modes {
            [mode] if N == 1 => {
                let lane = lanes_of(mode)[0];
                if lane.x > 0.0 {
                    self.deposit::<N>(points[0].0, lane, light);
                }
            }
            [mode] => {
                let lanes = lanes_of(mode);
                let total = total_share(&points, &lanes);
                self.share_out(&points, &lanes, light / total);
            }
            modes => {
                let total: f64 = modes
                    .iter()
                    .map(|mode| total_share(&points, &lanes_of(mode)))
                    .sum();
                for mode in modes {
                    self.share_out(&points, &lanes_of(mode), light / total);
                }
            }
        }
        let light = self.deposits.light - light_before;
        self.deposits.error += light * relative_error;
        self.deposits.size_variance += light * SIZE_VARIANCE[N - 1] * bins * bins;
    }

    /// exp(-Q tau) inside a part. Only the shares of the points depend on it, so that for thin parts
    /// the start of its series suffices.
    #[inline]
    fn fade(&self, depth: f64) -> f64 {
        let depth = self.rule.view_efficiency * depth;
        if depth < THIN {
            1.0 - depth * (1.0 - 0.5 * depth)
        } else {
            (-depth).exp()
        }
    }

    #[inline]
    fn share_out<const N: usize>(
        &mut self,
        points: &Points<N>,
        lanes: &[Vec4; N],
        light_per_share: f64,
    ) {
        // A part without drops at any point has a total of 0 and a ratio that is not finite.
        if !light_per_share.is_finite() {
            return;
        }
        for ((x, weight), lane) in points.iter().zip(lanes) {
            if lane.x > 0.0 {
                let light = light_per_share * weight * f64::from(lane.x);
                self.deposit::<N>(*x, *lane, light);
            }
        }
    }

    /// What the sun's way leaves of the light of one of `N` points.
    #[inline]
    fn deposit<const N: usize>(&mut self, x: f64, lane: Vec4, light: f64) {
        let length_m = self.piece.length_m;
        // One point stands for a stretch of even light.
        let distance_variance_m2 = if N == 1 {
            length_m * length_m / 12.0
        } else {
            0.0
        };
        let point = LitPoint {
            lanes: lane,
            light,
            distance_m: self.piece.start_m + x * length_m,
            distance_variance_m2,
        };
        self.rule.deposit(self.axes, &point, self.deposits);
    }
}

/// The lanes of a mode at the points.
#[inline]
fn lanes_at<const N: usize>(mode: &LaneCubic, points: &Points<N>) -> [Vec4; N] {
    // A plain loop: `map` on arrays of vectors is not unrolled.
    let mut lanes = [Vec4::ZERO; N];
    for (lanes, (x, _)) in lanes.iter_mut().zip(points) {
        *lanes = mode.at(*x as f32);
    }
    lanes
}

/// Sum of the Gauss weights times exp(-Q tau) times M2.
#[inline]
fn total_share<const N: usize>(points: &Points<N>, lanes: &[Vec4; N]) -> f64 {
    points
        .iter()
        .zip(lanes)
        .map(|((_, weight), lane)| weight * f64::from(lane.x.max(0.0)))
        .sum()
}

/// 1 - exp(-x) for x >= 0, by its series where x is small: 1e-16 has no digits in 1 - exp(-x).
#[inline]
fn absorbed(x: f64) -> f64 {
    if x < THIN {
        let x2 = x * x;
        x * ((1.0 - 0.5 * x) + x2 * ((1.0 / 6.0 - x * (1.0 / 24.0)) + x2 * (1.0 / 120.0)))
    } else {
        -(-x).exp_m1()
    }
}

#[cfg(test)]
#[path = "piece_rule_tests.rs"]
mod tests;
