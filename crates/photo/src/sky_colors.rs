//! Which pixels have the colors of the sky and which those of the ground.
//!
//! u(p) = log p(c, x | sky) − log p(c, x | ground)
//! Both densities are mixtures of Gaussians over color (Oklab) and place with diagonal covariances, found
//! by k-means. Neighbours of one color belong together: with s = u + G g + A a clamped to ±[`MOST`],
//! q(p) = 1/(1 + exp(−s(p) − P sum_n w_n (2 q(n) − 1))),   w_n = exp(−|c(p) − c(n)|²/(2 r²))
//! over the eight neighbours, some rounds, `g` what was guessed before, `G` [`GUESS`], `a` what any sky looks like
//! ([`sky_prior`](crate::sky_prior)), `A` [`PRIOR`], `P` [`PULL`], `r` [`SAME_COLOR`]: the mean field of a
//! contrast-sensitive Potts model.
//! [BJ01] Y. Boykov, M.-P. Jolly, Interactive graph cuts, Proc. ICCV, 105-112 (2001), for the model.
//! [KK11] P. Krähenbühl, V. Koltun, Efficient inference in fully connected CRFs, NIPS 24 (2011), eq. 4,
//! for the rounds.

use ndarray::Array2;
use ndarray::Zip;

use crate::k_means::Feature;
use crate::k_means::k_means;
use crate::k_means::nearest_center;
use crate::perceptual::square_apart;

/// Most pixels that a mixture is found from.
const MOST_SAMPLES: usize = 2000;
/// Gaussians of the sky and of the ground.
const N_SKY: usize = 6;
const N_GROUND: usize = 8;
/// Weight of place beside color.
const PLACE: f32 = 0.25;
/// Least standard deviations of color and of weighted place.
const LEAST_COLOR: f32 = 0.02;
const LEAST_PLACE: f32 = 0.03;
/// Largest log ratio that counts.
const MOST: f32 = 4.0;
/// What a guess counts beside it.
const GUESS: f32 = 0.5;
/// What the look of any sky counts beside it.
const PRIOR: f32 = 0.25;
/// Pull of a neighbour of the same color.
const PULL: f32 = 1.0;
/// Difference of color over which that ends.
const SAME_COLOR: f32 = 0.03;
/// Rounds of neighbours.
const N_ROUNDS: usize = 12;

/// A Gaussian with its weight.
struct Lobe {
    center: Feature,
    inverse_variance: Feature,
    log_weight: f32,
}

/// A density of colors and places.
struct Mixture(Vec<Lobe>);

impl Mixture {
    fn new(points: &[Feature], n_lobes: usize) -> Self {
        let centers = k_means(points, n_lobes).centers;
        let mut counts = vec![0.0_f32; centers.len()];
        let mut squares = vec![[0.0_f32; 5]; centers.len()];
        for point in points {
            let index = nearest_center(point, &centers).0;
            counts[index] += 1.0;
            for axis in 0..5 {
                squares[index][axis] += (point[axis] - centers[index][axis]).powi(2);
            }
        }
        let lobes = centers.into_iter().zip(counts.iter().zip(squares));
        let lobes = lobes.filter(|(_, (count, _))| **count > 0.0);
        let lobe = |(center, (count, squares)): (Feature, (&f32, Feature))| {
            let least = [
                LEAST_COLOR,
                LEAST_COLOR,
                LEAST_COLOR,
                LEAST_PLACE,
                LEAST_PLACE,
            ];
            let variance: Feature =
                std::array::from_fn(|axis| squares[axis] / count + least[axis] * least[axis]);
            let log_volume: f32 = variance.iter().map(|value| 0.5 * value.ln()).sum();
            Lobe {
                center,
                inverse_variance: variance.map(f32::recip),
                log_weight: (count / points.len() as f32).ln() - log_volume,
            }
        };
        Self(lobes.map(lobe).collect())
    }

    /// The logarithm of the largest lobe.
    fn log_density(&self, point: &Feature) -> f32 {
        let lobes = self.0.iter().map(|lobe| {
            let apart: f32 = (0..5)
                .map(|axis| (point[axis] - lobe.center[axis]).powi(2) * lobe.inverse_variance[axis])
                .sum();
            lobe.log_weight - 0.5 * apart
        });
        lobes.fold(f32::NEG_INFINITY, f32::max)
    }
}

/// How like the sky pixels are.
pub(crate) struct Likeness {
    /// By themselves: u with what was guessed, clamped.
    pub(crate) alone: Array2<f32>,
    /// With their neighbors: 2 q − 1, above 0 for the sky.
    pub(crate) settled: Array2<f32>,
}

/// A picture in Oklab with how like any sky its pixels are.
pub(crate) struct Colors {
    pub(crate) lab: Array2<[f32; 3]>,
    pub(crate) prior: Array2<f32>,
    /// Pulls of the neighbors at [`BESIDE`].
    pulls: Array2<[f32; 4]>,
}

/// Columns to the left or right and rows down of half the neighbors; the others pull as these do from there.
const BESIDE: [(isize, usize); 4] = [(1, 0), (-1, 1), (0, 1), (1, 1)];

impl Colors {
    pub(crate) fn new(lab: Array2<[f32; 3]>, prior: Array2<f32>) -> Self {
        let (height, width) = lab.dim();
        let mut pulls = Array2::from_elem(lab.dim(), [0.0; 4]);
        Zip::indexed(&mut pulls).par_for_each(|(y, x), pulls: &mut [f32; 4]| {
            *pulls = BESIDE.map(|(dx, dy)| match x.checked_add_signed(dx) {
                Some(column) if column < width && y + dy < height => {
                    let apart = square_apart(lab[[y, x]], lab[[y + dy, column]]);
                    PULL * (-apart / (2.0 * SAME_COLOR * SAME_COLOR)).exp()
                }
                _ => 0.0,
            });
        });
        Self { lab, prior, pulls }
    }

    /// How like the sky of a guess pixels are; a guess is 1 for the sky, −1 for the ground, and less where it is less
    /// sure. `None` where either is empty.
    pub(crate) fn likeness(&self, guess: &Array2<f32>) -> Option<Likeness> {
        let diagonal = (self.lab.nrows() as f32).hypot(self.lab.ncols() as f32);
        let feature = |(y, x): (usize, usize)| -> Feature {
            let [l, a, b] = self.lab[[y, x]];
            let place = |index: usize| PLACE * index as f32 / diagonal;
            [l, a, b, place(x), place(y)]
        };
        let samples = |wanted: f32| -> Vec<Feature> {
            let all: Vec<_> = guess
                .indexed_iter()
                .filter(|(_, is)| **is * wanted > 0.0)
                .collect();
            let step = all.len().div_ceil(MOST_SAMPLES).max(1);
            let some = all.iter().step_by(step);
            some.map(|(at, _)| feature(*at)).collect()
        };
        let (sky, ground) = (samples(1.0), samples(-1.0));
        if sky.is_empty() || ground.is_empty() {
            return None;
        }
        let (sky, ground) = rayon::join(
            || Mixture::new(&sky, N_SKY),
            || Mixture::new(&ground, N_GROUND),
        );
        let mut alone = Array2::zeros(self.lab.dim());
        Zip::indexed(&mut alone).par_for_each(|at, alone: &mut f32| {
            let point = feature(at);
            let ratio = sky.log_density(&point) - ground.log_density(&point);
            *alone = (ratio + GUESS * guess[at] + PRIOR * self.prior[at]).clamp(-MOST, MOST);
        });
        let settled = self.settled(&alone);
        Some(Likeness { alone, settled })
    }

    /// 2 q − 1 after the rounds.
    fn settled(&self, own: &Array2<f32>) -> Array2<f32> {
        let (height, width) = own.dim();
        let mut state = own.mapv(above_even);
        for _ in 0..N_ROUNDS {
            let mut next = Array2::zeros(own.dim());
            Zip::indexed(&mut next).par_for_each(|(y, x), next: &mut f32| {
                let mut sum = own[[y, x]];
                for (index, (dx, dy)) in BESIDE.into_iter().enumerate() {
                    if let Some(column) = x.checked_add_signed(dx)
                        && column < width
                        && y + dy < height
                    {
                        sum += self.pulls[[y, x]][index] * state[[y + dy, column]];
                    }
                    if let (Some(row), Some(column)) =
                        (y.checked_sub(dy), x.checked_add_signed(-dx))
                        && column < width
                    {
                        sum += self.pulls[[row, column]][index] * state[[row, column]];
                    }
                }
                *next = above_even(sum);
            });
            state = next;
        }
        state
    }
}

/// 2 q − 1 of a log ratio.
fn above_even(ratio: f32) -> f32 {
    1.0 - 2.0 / (1.0 + ratio.exp())
}
