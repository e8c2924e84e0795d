//! The squares of the rainbow integral and of its derivative averaged over drop sizes, in advance.
//!
//! F(z) = ⟨t^q f²⟩,            P(z) = ∫_−∞^z F dz' = ⟨t^q (z f² + t^(−2/3) f'²/c)⟩,   c = π²/12
//! G(z) = ⟨t^(q−2/3) f'²⟩,   Q(z) = ∫_−∞^z G dz' = ⟨t^(q−4/3) (u f'² + c u² f² + 2 f f')/3⟩
//! `f` and `f'` at u = z t^(2/3), `t` radius over effective radius, `q` the power of the radius in front
//! of f² (1/3 absolute, −2/3 as published), ⟨⟩ the mean over the cross-section of the gamma law: weight
//! t^(1/v_e) e^(−t/v_e) d ln t. Light of a bow is x^(1/3) (A F + B x^(−2/3) G), x of the effective radius.
//!
//! The theories of Airy and of Chester, Friedman and Ursell depend on radius and wavelength through z
//! alone, so two functions of z serve every effective radius, wavelength and angle of a table: the size
//! average costs nothing per value and is not sampled in any radius. P and Q give exact means over steps
//! of the angle, however many fringes they hold. Both follow from f'' = −c z f by differentiation; for
//! Ai they are DLMF 9.11.4 and the like.
//!
//! Where the sizes have blurred the fringes to below 1e-5 only their mean is left, smooth in ln z. Far enough
//! out for most of the small drops too it is (DLMF 9.8.20, 9.8.21)
//! F = V²/(2π) (⟨t^(q−1/3)⟩ y^(−1/2) − (5/32) ⟨t^(q−7/3)⟩ y^(−7/2)),   y = A z,   A = c^(1/3)
//! G = A² V²/(2π) (⟨t^(q−1/3)⟩ y^(1/2) + (7/32) ⟨t^(q−7/3)⟩ y^(−5/2)),   f = V Ai(−y)
//! [HT74] J. E. Hansen and L. D. Travis, Space Sci. Rev. 16, 527-610 (1974), eq. 2.56. [DLMF]
//! dlmf.nist.gov.

use niji_airy::AiryTable;
use niji_airy::HermiteNode;
use niji_airy::airy_integral_with_derivative;
use niji_airy::airy_squares;
use niji_airy::fringe_coordinate;
use niji_airy::from_fringe_coordinate;
use niji_airy::quintic;
use niji_airy::quintic_coefficients;
use rayon::prelude::*;

use crate::gamma_sample::GammaSample;
use crate::gamma_sample::PHASE;
use crate::gamma_sample::SINGLE_SIZE;
use crate::gamma_sample::single_size;

/// V²/(2π), half the square of the amplitude of f times sqrt(A z).
const MEAN: f64 = 0.55884639773991457;
/// A = (π²/12)^(1/3).
const ARGUMENT: f64 = 0.936_927_888_800_636_4;

/// Lowest z for a single size: f² is below 1e-15 there.
const LOWEST_Z: f64 = -9.0;
/// Largest ratio of both moments of the expansion.
const BROADEST: f64 = 27.0;
/// Lowest z for any law, and the value of F that a broad law may have left there.
const LOWEST_OF_ALL_Z: f64 = -150.0;
const LEFT_BELOW: f64 = 1e-10;
/// Step between nodes in the coordinate of [`fringe_coordinate`]: 0.18 rad of the phase of f².
const STEP: f64 = 0.1;
/// Step of ln z between nodes where fringes are damped: these are left to 1e-5, and their curvature must not
/// be taken for that of the mean.
const SMOOTH_STEP: f64 = 0.05;
/// The expansion of the mean is good to the error from this z on, for a narrow law.
const MEAN_FROM_Z: f64 = 30.0;

/// The error for which the constants above are.
const FINE: f64 = 1e-5;

/// F, G, P and Q.
#[derive(Clone, Debug)]
pub(crate) enum MeanSquare {
    /// Of one size: nothing to be averaged.
    Single,
    /// At nodes.
    Law(LawMean),
}

/// F, G, P and Q of a law between nodes that are even in phase, and then in ln z.
#[derive(Clone, Debug)]
pub(crate) struct LawMean {
    pieces: Vec<Piece>,
    axis: Axis,
    end: End,
    /// ⟨t^(q−1/3)⟩ and ⟨t^(q−7/3)⟩.
    moments: [f64; 2],
}

/// From one node to the next: its z, the width, and the quintics of P and Q, and of F and G. Of a table's millions
/// of look-ups each finds its coefficients made.
#[derive(Clone, Copy, Debug)]
struct Piece {
    z: f64,
    width: f64,
    primitives: [[f64; 6]; 2],
    values: [[f64; 6]; 2],
}

/// Where the expansion begins: z, P and Q there, and what it has for them.
#[derive(Clone, Copy, Debug)]
struct End {
    z: f64,
    primitives: [f64; 2],
    rises: [f64; 2],
}

/// Where nodes stand.
#[derive(Clone, Copy, Debug)]
struct Axis {
    /// Phase coordinate of the first, and the step from one to the next.
    low: f64,
    step: f64,
    /// From here on they are [`SMOOTH_STEP`] apart; how many steps this is from the first.
    damped_z: f64,
    damped_position: f64,
}

/// z and there P, F, F', F'' and Q, G, G', G''.
#[derive(Clone, Copy, Debug)]
struct Node {
    z: f64,
    squares: [[f64; 4]; 2],
}

/// What the average is taken of, and over which law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Averaging<'a> {
    /// The power q.
    pub(crate) exponent: f64,
    pub(crate) effective_variance: f64,
    /// Largest error of F and G, about.
    pub(crate) error: f64,
    /// No z above it will be asked for.
    pub(crate) highest_z: f64,
    pub(crate) airy_table: Option<&'a AiryTable>,
}

/// An argument with P and Q there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Primitives {
    z: f64,
    values: [f64; 2],
}

impl MeanSquare {
    pub(crate) fn compute(averaging: Averaging) -> Self {
        if averaging.effective_variance < SINGLE_SIZE {
            Self::Single
        } else {
            Self::Law(LawMean::compute(averaging))
        }
    }

    /// F(z) and G(z).
    pub(crate) fn values(&self, z: f64) -> [f64; 2] {
        match self {
            Self::Single if z > LOWEST_Z => airy_squares(z),
            Self::Single => [0.0; 2],
            Self::Law(law) => law.values(z),
        }
    }

    /// P(z) and Q(z).
    pub(crate) fn primitives(&self, z: f64) -> Primitives {
        let values = match self {
            Self::Single if z > LOWEST_Z => {
                single_size(z, airy_integral_with_derivative).map(|[primitive, ..]| primitive)
            }
            Self::Single => [0.0; 2],
            Self::Law(law) => law.primitives(z),
        };
        Primitives { z, values }
    }

    /// The means of F and G between two places.
    pub(crate) fn means(&self, from: &Primitives, to: &Primitives) -> [f64; 2] {
        let width = to.z - from.z;
        if width.abs() < 1e-6 {
            return self.values(from.z);
        }
        [0, 1].map(|j| (to.values[j] - from.values[j]) / width)
    }
}

impl LawMean {
    fn compute(averaging: Averaging) -> Self {
        let Averaging {
            exponent,
            effective_variance,
            error,
            ..
        } = averaging;
        // The error of a quintic goes with the sixth power of the step, that of the expansion with z^-3.
        let coarser = error / FINE;
        let step = STEP * coarser.powf(1.0 / 6.0);
        let sample = |highest_z| GammaSample::new(exponent, effective_variance, highest_z);
        let of_law = sample(0.0);
        let first = of_law.moment(-1.0 / 3.0);
        // The expansion is not meant for the tiny drops of the broadest laws, where it has no end.
        let broad = (of_law.moment(-7.0 / 3.0) / first).min(BROADEST);
        let moments = [first, broad * first];
        let damped_z = damped_from_z(exponent, effective_variance, error);
        // There the second term of the expansion is as small as it is for a narrow law.
        let mean_z = damped_z.max((broad / coarser).cbrt() * MEAN_FROM_Z);
        let highest_z = averaging.highest_z.min(mean_z).max(1.0);
        let axis = Axis::new(lowest_z(exponent, effective_variance), step, damped_z);
        let n_nodes = axis.position(highest_z).ceil() as usize + 2;
        let law = sample(highest_z);
        // A sum over sizes evens out the error of a table, 2e-8.
        let integral = |z: f64| {
            averaging.airy_table.map_or_else(
                || airy_integral_with_derivative(z),
                |table| table.value_with_derivative(z),
            )
        };
        let nodes: Vec<Node> = (0..n_nodes)
            .into_par_iter()
            .map(|index| {
                let z = axis.z(index);
                let squares = law.mean(z, integral);
                Node { z, squares }
            })
            .collect();
        let last = nodes[n_nodes - 1];
        Self {
            pieces: nodes.windows(2).map(Piece::between).collect(),
            axis,
            end: End {
                z: last.z,
                primitives: last.squares.map(|[primitive, ..]| primitive),
                rises: rises(moments, last.z),
            },
            moments,
        }
    }

    fn values(&self, z: f64) -> [f64; 2] {
        if z >= self.end.z {
            let [first, second] = self.moments;
            let y = ARGUMENT * z;
            let f = MEAN / y.sqrt() * (first - 5.0 / 32.0 * second * y.powi(-3));
            let g = MEAN * y.sqrt() * (first + 7.0 / 32.0 * second * y.powi(-3));
            return [f, ARGUMENT * ARGUMENT * g];
        }
        // Not the slope of P or Q: that would magnify their rounding.
        self.look_up(z, |piece| piece.values)
    }

    fn primitives(&self, z: f64) -> [f64; 2] {
        if z < self.end.z {
            return self.look_up(z, |piece| piece.primitives);
        }
        let (
            here,
            End {
                primitives,
                rises: there,
                ..
            },
        ) = (rises(self.moments, z), self.end);
        [0, 1].map(|j| primitives[j] + MEAN * (here[j] - there[j]))
    }

    fn look_up(&self, z: f64, quintics: impl Fn(&Piece) -> [[f64; 6]; 2]) -> [f64; 2] {
        let position = self.axis.position(z);
        if position.is_nan() || position < 0.0 {
            return [0.0; 2];
        }
        let piece = &self.pieces[(position as usize).min(self.pieces.len() - 1)];
        let t = (z - piece.z) / piece.width;
        quintics(piece).map(|coefficients| quintic(coefficients, t))
    }
}

impl Piece {
    /// Between two nodes.
    fn between(nodes: &[Node]) -> Self {
        let [left, right] = [&nodes[0], &nodes[1]];
        let quintics = |quantity: fn([f64; 4]) -> [f64; 3]| {
            [0, 1].map(|j| {
                let end = |node: &Node| {
                    let [value, slope, curvature] = quantity(node.squares[j]);
                    HermiteNode {
                        at: node.z,
                        value,
                        slope,
                        curvature,
                    }
                };
                quintic_coefficients(end(left), end(right))
            })
        };
        Self {
            z: left.z,
            width: right.z - left.z,
            primitives: quintics(|[value, slope, curvature, _]| [value, slope, curvature]),
            values: quintics(|[_, value, slope, curvature]| [value, slope, curvature]),
        }
    }
}

/// Integrals of the expansion of F and G over z, over V²/(2π).
fn rises([first, second]: [f64; 2], z: f64) -> [f64; 2] {
    let y = ARGUMENT * z;
    let root = y.sqrt();
    let p = 2.0 * first * root + 5.0 / 32.0 * 0.4 * second / (y * y * root);
    let q = 2.0 / 3.0 * (first * y * root - 7.0 / 32.0 * second / (y * root));
    [p / ARGUMENT, q * ARGUMENT]
}

impl Axis {
    fn new(lowest_z: f64, step: f64, damped_z: f64) -> Self {
        let low = fringe_coordinate(lowest_z);
        Self {
            low,
            step,
            damped_z,
            damped_position: (fringe_coordinate(damped_z) - low) / step,
        }
    }

    /// Steps from the first node to a place.
    fn position(&self, z: f64) -> f64 {
        if z <= self.damped_z {
            (fringe_coordinate(z) - self.low) / self.step
        } else {
            self.damped_position + (z / self.damped_z).ln() / SMOOTH_STEP
        }
    }

    /// Place of a node.
    fn z(&self, index: usize) -> f64 {
        let beyond = index as f64 - self.damped_position;
        if beyond <= 0.0 {
            from_fringe_coordinate(self.low + self.step * index as f64)
        } else {
            self.damped_z * (SMOOTH_STEP * beyond).exp()
        }
    }
}

/// Below it nothing is left of the bow: a share t^(1/v_e + q) of the drops, those with
/// t < 1/(2 PHASE |z|^(3/2)), reaches that far into the dark.
pub(crate) fn lowest_z(exponent: f64, variance: f64) -> f64 {
    let radius = LEFT_BELOW.powf(1.0 / (1.0 / variance + exponent));
    let z = -(1.0 / (2.0 * PHASE * radius)).powf(2.0 / 3.0);
    z.clamp(LOWEST_OF_ALL_Z, LOWEST_Z)
}

/// The fringes of phase φ t have the amplitude (1 + φ² v_e²)^(−k/2), k = 1/v_e + q − 1/3, over their
/// mean: where that is `damped`.
fn damped_from_z(exponent: f64, variance: f64, damped: f64) -> f64 {
    let power = 1.0 / variance + exponent - 1.0 / 3.0;
    let squared = (-2.0 / power * damped.ln()).exp_m1() / (variance * variance);
    (squared.sqrt() / PHASE).powf(2.0 / 3.0)
}

#[cfg(test)]
#[path = "mean_square_tests.rs"]
mod tests;
