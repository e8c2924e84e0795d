//! k-means with k-means++ seeds.
//!
//! minimise W = sum_i |x_i − c_(l_i)|²:   l_i = nearest center,   c_l = mean of its points
//! Seeds: the first uniformly, each further one with a chance proportional to the squared distance
//! from the nearest seed. The number of clusters, where it is not given, maximises
//!   CH = (B/(k − 1)) / (W/(n − k))
//! with `B` the sum of squares between clusters. The generator is seeded with a constant and sums run
//! over fixed blocks in a fixed order, so that the result depends on the points alone.
//! [Llo82] S. P. Lloyd, IEEE Trans. Information Theory 28, 129-137 (1982).
//! [AV07] D. Arthur, S. Vassilvitskii, Proc. SODA '07, 1027-1035 (2007).
//! [CH74] T. Caliński, J. Harabasz, Communications in Statistics 3, 1-27 (1974).

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;
use rayon::prelude::*;

/// Color and scaled position.
pub(crate) type Feature = [f32; 5];

/// Seed of the generator: any constant; the result is not sensitive to it.
const SEED: u128 = 0x6e69_6a69;
/// Most rounds; centers stand still after 20 to 60.
const MOST_ROUNDS: usize = 100;
/// Starts of which the best counts.
const N_STARTS: usize = 4;
/// Points in a block of a sum.
const BLOCK: usize = 4096;

/// Clusters.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Clusters {
    /// Their centers.
    pub(crate) centers: Vec<Feature>,
    /// Sum of squared distances W.
    pub(crate) within: f64,
}

/// The best of some starts.
pub(crate) fn k_means(points: &[Feature], n_clusters: usize) -> Clusters {
    let mut random = Pcg64Mcg::new(SEED);
    let mut best: Option<Clusters> = None;
    for _ in 0..N_STARTS {
        let found = descend(points, seeds(points, n_clusters, &mut random));
        if best.as_ref().is_none_or(|best| found.within < best.within) {
            best = Some(found);
        }
    }
    best.expect("there is at least one start")
}

/// The clusters whose number maximises CH among `candidates`.
pub(crate) fn k_means_by_criterion(
    points: &[Feature],
    candidates: std::ops::RangeInclusive<usize>,
) -> Clusters {
    let total = descend(points, vec![points[0]]).within;
    let n = points.len() as f64;
    let mut best: Option<(f64, Clusters)> = None;
    for k in candidates {
        let found = k_means(points, k);
        let between = total - found.within;
        let index = (between / (k as f64 - 1.0)) / (found.within / (n - k as f64));
        if best.as_ref().is_none_or(|(value, _)| index > *value) {
            best = Some((index, found));
        }
    }
    best.map_or_else(|| k_means(points, 1), |(_, clusters)| clusters)
}

/// The nearest center and the squared distance to it; of equals the first.
pub(crate) fn nearest_center(point: &Feature, centers: &[Feature]) -> (usize, f32) {
    let mut best = (0, f32::INFINITY);
    for (index, center) in centers.iter().enumerate() {
        let squared = squared_distance(point, center);
        if squared < best.1 {
            best = (index, squared);
        }
    }
    best
}

fn squared_distance(a: &Feature, b: &Feature) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Uniform in 0..1.
fn uniform(random: &mut Pcg64Mcg) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

fn seeds(points: &[Feature], n_clusters: usize, random: &mut Pcg64Mcg) -> Vec<Feature> {
    let first = (uniform(random) * points.len() as f64) as usize;
    let mut seeds = vec![points[first.min(points.len() - 1)]];
    let mut squared: Vec<f32> = vec![f32::INFINITY; points.len()];
    while seeds.len() < n_clusters {
        let newest = seeds[seeds.len() - 1];
        squared
            .par_iter_mut()
            .zip(points)
            .for_each(|(squared, point)| {
                *squared = squared.min(squared_distance(point, &newest));
            });
        let total: f64 = squared.iter().map(|value| f64::from(*value)).sum();
        let mut left = uniform(random) * total;
        let chosen = squared.iter().position(|value| {
            left -= f64::from(*value);
            left < 0.0
        });
        // Fewer different points than clusters: the rest of the seeds repeat one.
        seeds.push(points[chosen.unwrap_or(0)]);
    }
    seeds
}

/// Sums of a block by cluster.
struct Sums {
    totals: Vec<[f64; 5]>,
    counts: Vec<u64>,
    within: f64,
}

fn descend(points: &[Feature], mut centers: Vec<Feature>) -> Clusters {
    let mut within = f64::INFINITY;
    for _ in 0..MOST_ROUNDS {
        let blocks: Vec<Sums> = points
            .par_chunks(BLOCK)
            .map(|block| sums(block, &centers))
            .collect();
        let next_within = blocks.iter().map(|block| block.within).sum();
        for (index, center) in centers.iter_mut().enumerate() {
            let count: u64 = blocks.iter().map(|block| block.counts[index]).sum();
            // A cluster that has lost its points stays where it is.
            if count > 0 {
                *center = std::array::from_fn(|axis| {
                    let sum: f64 = blocks.iter().map(|block| block.totals[index][axis]).sum();
                    // f32: points are f32.
                    (sum / count as f64) as f32
                });
            }
        }
        let has_settled = next_within >= within * (1.0 - 1e-6);
        within = next_within;
        if has_settled {
            break;
        }
    }
    Clusters { centers, within }
}

fn sums(block: &[Feature], centers: &[Feature]) -> Sums {
    let mut sums = Sums {
        totals: vec![[0.0; 5]; centers.len()],
        counts: vec![0; centers.len()],
        within: 0.0,
    };
    for point in block {
        let (index, squared) = nearest_center(point, centers);
        for (sum, value) in sums.totals[index].iter_mut().zip(point) {
            *sum += f64::from(*value);
        }
        sums.counts[index] += 1;
        sums.within += f64::from(squared);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blobs of 500 points around corners, each within ±0.05.
    fn blobs(n_blobs: usize) -> Vec<Feature> {
        let mut random = Pcg64Mcg::new(5);
        (0..500 * n_blobs)
            .map(|index| {
                let blob = index % n_blobs;
                std::array::from_fn(|axis| {
                    let corner = if blob >> axis & 1 == 1 { 1.0 } else { 0.0 };
                    corner + 0.1 * (uniform(&mut random) as f32 - 0.5)
                })
            })
            .collect()
    }

    #[test]
    fn separate_blobs_are_found_with_their_means() {
        let points = blobs(6);
        let found = k_means(&points, 6);
        for blob in 0..6 {
            let corner = std::array::from_fn(|axis| if blob >> axis & 1 == 1 { 1.0 } else { 0.0 });
            let (_, squared) = nearest_center(&corner, &found.centers);
            // Standard error of a mean of 500: 0.0013 along each axis.
            assert!(squared.sqrt() < 0.01, "{blob}");
        }
    }

    #[test]
    fn the_criterion_finds_the_number_of_blobs() {
        for n_blobs in [2, 3, 5, 8] {
            let found = k_means_by_criterion(&blobs(n_blobs), 2..=12);
            assert_eq!(found.centers.len(), n_blobs);
        }
    }

    #[test]
    fn more_clusters_never_fit_worse_and_one_is_the_mean() {
        let points = blobs(4);
        let one = k_means(&points, 1);
        let mean: f64 =
            points.iter().map(|point| f64::from(point[0])).sum::<f64>() / points.len() as f64;
        assert!((f64::from(one.centers[0][0]) - mean).abs() < 1e-6);
        let mut last = one.within;
        for k in 2..7 {
            let within = k_means(&points, k).within;
            assert!(within <= last);
            last = within;
        }
    }

    #[test]
    fn fewer_points_than_clusters_and_equal_points_are_settled() {
        let same = vec![[0.25; 5]; 3];
        let found = k_means(&same, 4);
        assert_eq!(found.centers, vec![[0.25; 5]; 4]);
        assert!(found.within <= 0.0);
    }
}
