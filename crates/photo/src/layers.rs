//! A photograph in layers of similar color, each with a distance.
//!
//! Pixels are clustered by color in Oklab and by position, x' = w x/D, y' = w y/D with D the diagonal
//! and `w` the weight of position. Clusters are found on a grid of at most 40000 pixels and applied to
//! all; they are numbered from the largest. Distances are proposed, for a person to correct:
//!
//!   sky: touches the top of the picture, is brighter than the mean and lies mostly above the horizon
//!   else: d = h/sin(delta), `h` the height of the eye, `delta` the depression of the layer's foot,
//!         the view ray below which 5 % of its pixels lie: where it stands on level ground.
//!
//! Layers without position are the published method; position keeps apart what shares a color.

use ndarray::Array2;
use ndarray::Zip;
use niji_geometry::PinholeCamera;
use niji_radiometry::Meters;

use crate::error::Error;
use crate::k_means::Feature;
use crate::k_means::k_means;
use crate::k_means::k_means_by_criterion;
use crate::k_means::nearest_center;
use crate::linear_picture::LinearPicture;
use crate::perceptual::from_oklab;
use crate::perceptual::oklab;

/// Most pixels of the grid on which clusters are found.
const MOST_SAMPLES: usize = 40_000;
/// Numbers of clusters that the criterion compares.
const CANDIDATES: std::ops::RangeInclusive<usize> = 2..=12;
/// Most clusters.
pub(crate) const MOST_CLUSTERS: usize = 64;
/// Part of the top row that a sky covers at least.
const SKY_TOP_SHARE: f64 = 0.1;
/// Part of a sky that lies above the horizon at least.
const SKY_ABOVE_SHARE: f64 = 0.9;
/// Part of a layer below its foot.
const FOOT_SHARE: f64 = 0.05;
/// Farthest that the ground is proposed, m.
const FARTHEST_M: f64 = 10_000.0;

/// How many clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClusterCount {
    /// This many.
    Given(usize),
    /// The number with the largest index of Caliński and Harabasz, 2 to 12.
    Criterion,
}

/// Layers of a photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// The number of each pixel's layer.
    pub labels: Array2<u8>,
    /// The layers, the largest first.
    pub layers: Vec<Layer>,
}

/// One layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Its color, linear Rec.709.
    pub color: [f32; 3],
    /// Its part of the picture, 0..1.
    pub share: f64,
    /// Its distance, m; infinity for the sky.
    pub distance_m: f64,
}

/// How layers are proposed for a photograph.
#[derive(Clone, Copy, Debug)]
pub struct LayersRequest<'a> {
    /// How many clusters.
    pub count: ClusterCount,
    /// Weight of position beside color, at least 0; 0 is the published method.
    pub position_weight: f64,
    /// The camera of the photograph.
    pub camera: &'a PinholeCamera,
    /// Height of the eye above level ground.
    pub eye_height: Meters,
}

impl LayersRequest<'_> {
    fn check(&self, photo: &LinearPicture) -> Result<(), Error> {
        let range = |what, found, expected| {
            Err(Error::Range {
                what,
                found,
                expected,
            })
        };
        if let ClusterCount::Given(n) = self.count
            && !(1..=MOST_CLUSTERS).contains(&n)
        {
            return range("the number of clusters", n as f64, "1 to 64");
        }
        if !(self.position_weight >= 0.0 && self.position_weight.is_finite()) {
            return range(
                "the weight of position",
                self.position_weight,
                "a number of at least 0",
            );
        }
        if !(self.eye_height.0 > 0.0 && self.eye_height.0.is_finite()) {
            return range(
                "the height of the eye in metres",
                self.eye_height.0,
                "a height above 0",
            );
        }
        let size = (
            self.camera.height_px() as usize,
            self.camera.width_px() as usize,
        );
        crate::compositing::check_size("the photograph", size, photo.dim())
    }
}

/// Clusters a photograph and proposes the distances of its layers.
///
/// # Errors
/// No or too many clusters, a camera of another size, or an eye that is not above the ground.
pub fn propose_layers(photo: &LinearPicture, request: &LayersRequest) -> Result<Layers, Error> {
    request.check(photo)?;
    let weight = request.position_weight as f32;
    let diagonal = (photo.nrows() as f32).hypot(photo.ncols() as f32);
    let feature = |y: usize, x: usize| -> Feature {
        let [l, a, b] = oklab(photo[[y, x]]);
        let scale = weight / diagonal;
        [l, a, b, scale * x as f32, scale * y as f32]
    };
    let samples = samples(photo.dim(), feature);
    let clusters = match request.count {
        ClusterCount::Given(n_clusters) => k_means(&samples, n_clusters),
        ClusterCount::Criterion => k_means_by_criterion(&samples, CANDIDATES),
    };
    let mut labels = Array2::zeros(photo.dim());
    Zip::indexed(&mut labels).par_for_each(|(y, x), label: &mut u8| {
        // At most 64 centers.
        *label = nearest_center(&feature(y, x), &clusters.centers).0 as u8;
    });
    let colors = clusters.centers.iter();
    let colors: Vec<[f32; 3]> = colors
        .map(|[l, a, b, ..]| from_oklab([*l, *a, *b]))
        .collect();
    Ok(ranked(
        labels,
        &colors,
        request.camera,
        request.eye_height.0,
    ))
}

/// The distance of each pixel.
///
/// # Errors
/// A label without a layer, or a distance that is not above 0.
pub fn depth_of_layers(layers: &Layers) -> Result<Array2<f32>, Error> {
    for layer in &layers.layers {
        let is_distance = layer.distance_m > 0.0;
        if !is_distance {
            return Err(Error::Range {
                what: "the distance of a layer in metres",
                found: layer.distance_m,
                expected: "a number above 0, or inf for the sky",
            });
        }
    }
    let highest = layers.labels.iter().copied().max().unwrap_or(0);
    if usize::from(highest) >= layers.layers.len() {
        return Err(Error::Range {
            what: "a label",
            found: f64::from(highest),
            expected: "the number of a layer, from 0",
        });
    }
    // f32: what files hold.
    let depth = |label: u8| layers.layers[usize::from(label)].distance_m as f32;
    Ok(layers.labels.mapv(depth))
}

fn samples(
    (height, width): (usize, usize),
    feature: impl Fn(usize, usize) -> Feature,
) -> Vec<Feature> {
    let step = ((height * width) as f64 / MOST_SAMPLES as f64)
        .sqrt()
        .max(1.0);
    let grid = |n: usize| {
        let n_steps = (n as f64 / step).floor().max(1.0) as usize;
        (0..n_steps).map(move |index| {
            let at = (index as f64 + 0.5) * n as f64 / n_steps as f64;
            (at as usize).min(n - 1)
        })
    };
    let rows = grid(height);
    rows.flat_map(|y| grid(width).map(move |x| (y, x)))
        .map(|(y, x)| feature(y, x))
        .collect()
}

/// What is counted of a layer.
#[derive(Clone, Default)]
struct Count {
    n_pixels: u64,
    n_top: u64,
    n_above_horizon: u64,
    /// Pixels by row.
    by_row: Vec<u64>,
    /// Column sum by row, for the middle of the foot.
    column_sum: Vec<u64>,
}

fn ranked(
    mut labels: Array2<u8>,
    colors: &[[f32; 3]],
    camera: &PinholeCamera,
    eye_height_m: f64,
) -> Layers {
    let counts = count(&labels, colors.len(), camera);
    let mut order: Vec<usize> = (0..colors.len()).collect();
    order.retain(|index| counts[*index].n_pixels > 0);
    order.sort_by_key(|index| std::cmp::Reverse(counts[*index].n_pixels));
    let mut rank = vec![0_u8; colors.len()];
    for (place, index) in order.iter().enumerate() {
        // At most 64 clusters.
        rank[*index] = place as u8;
    }
    labels.par_mapv_inplace(|label| rank[usize::from(label)]);
    let n_pixels = labels.len() as f64;
    let lightness = |index: usize| f64::from(oklab(colors[index])[0]);
    let mean: f64 = order
        .iter()
        .map(|index| lightness(*index) * counts[*index].n_pixels as f64)
        .sum::<f64>()
        / n_pixels;
    let layers = order.into_iter().map(|index| {
        let is_sky = is_sky(&counts[index], labels.ncols()) && lightness(index) > mean;
        Layer {
            color: colors[index],
            share: counts[index].n_pixels as f64 / n_pixels,
            distance_m: if is_sky {
                f64::INFINITY
            } else {
                foot_distance_m(&counts[index], camera, eye_height_m)
            },
        }
    });
    Layers {
        layers: layers.collect(),
        labels,
    }
}

fn count(labels: &Array2<u8>, n_layers: usize, camera: &PinholeCamera) -> Vec<Count> {
    let empty = Count {
        by_row: vec![0; labels.nrows()],
        column_sum: vec![0; labels.nrows()],
        ..Count::default()
    };
    let mut counts = vec![empty; n_layers];
    for ((y, x), label) in labels.indexed_iter() {
        let count = &mut counts[usize::from(*label)];
        count.n_pixels += 1;
        count.n_top += u64::from(y == 0);
        count.by_row[y] += 1;
        count.column_sum[y] += x as u64;
    }
    let middle = 0.5 * f64::from(camera.width_px());
    for y in 0..labels.nrows() {
        // A camera's roll tilts the horizon; its middle decides.
        if camera.ray(middle, y as f64 + 0.5).direction.y > 0.0 {
            for count in &mut counts {
                count.n_above_horizon += count.by_row[y];
            }
        }
    }
    counts
}

fn is_sky(count: &Count, width: usize) -> bool {
    let top_share = count.n_top as f64 / width as f64;
    let above_share = count.n_above_horizon as f64 / count.n_pixels as f64;
    top_share >= SKY_TOP_SHARE && above_share >= SKY_ABOVE_SHARE
}

fn foot_distance_m(count: &Count, camera: &PinholeCamera, eye_height_m: f64) -> f64 {
    let mut below = 0;
    for y in (0..count.by_row.len()).rev() {
        below += count.by_row[y];
        if below as f64 >= FOOT_SHARE * count.n_pixels as f64 {
            let x = count.column_sum[y] as f64 / count.by_row[y].max(1) as f64;
            let down = -camera.ray(x + 0.5, y as f64 + 0.5).direction.y;
            // The distance along the ray is h/sin(delta).
            return if down * FARTHEST_M > eye_height_m {
                eye_height_m / down
            } else {
                FARTHEST_M
            };
        }
    }
    FARTHEST_M
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use niji_geometry::PinholeRequest;
    use niji_radiometry::Radians;

    /// Sky above, grass below, a dark tree that stands on the grass, and a hill on the horizon.
    fn photo() -> LinearPicture {
        Array2::from_shape_fn((120, 160), |(y, x)| {
            // Different in each channel, so that no layer falls into stripes.
            let ripple =
                |a: usize, b: usize| 0.06 * ((a * x * x + b * y + x * y) % 97) as f32 / 97.0;
            if (40..70).contains(&x) && (30..100).contains(&y) {
                [0.01, 0.012, 0.01]
            } else if y < 55 {
                [
                    0.4 + ripple(3, 5),
                    0.6 + ripple(7, 11),
                    0.95 + ripple(13, 17),
                ]
            } else {
                [
                    0.1 + ripple(3, 7),
                    0.3 + ripple(5, 13),
                    0.05 + ripple(11, 3),
                ]
            }
        })
    }

    fn camera() -> PinholeCamera {
        PinholeCamera::new(PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians(0.0),
            elevation: Radians(0.0),
            roll: Radians(0.0),
            horizontal_fov: Radians::from_degrees(60.0),
            width_px: 160,
            height_px: 120,
        })
        .unwrap()
    }

    fn propose(count: ClusterCount, weight: f64) -> Layers {
        let request = LayersRequest {
            count,
            position_weight: weight,
            camera: &camera(),
            eye_height: Meters(1.6),
        };
        propose_layers(&photo(), &request).unwrap()
    }

    #[test]
    fn sky_grass_and_tree_are_layers_with_fitting_distances() {
        let layers = propose(ClusterCount::Given(3), 0.2);
        let of = |y: usize, x: usize| layers.layers[usize::from(layers.labels[[y, x]])];
        assert!(of(5, 5).distance_m.is_infinite(), "sky");
        // The tree's foot is 40 of 60 rows below the horizon: tan(delta) = 0.29.
        let foot_m = 1.6 / (0.29_f64.atan()).sin();
        assert!((of(60, 55).distance_m / foot_m - 1.0).abs() < 0.15);
        assert!(
            of(110, 100).distance_m < foot_m,
            "the grass starts at our feet"
        );
        let shares: f64 = layers.layers.iter().map(|layer| layer.share).sum();
        assert!((shares - 1.0).abs() < 1e-12);
        assert!(layers.layers.is_sorted_by(|a, b| a.share >= b.share));
    }

    #[test]
    fn the_criterion_and_the_same_picture_give_the_same_layers() {
        let first = propose(ClusterCount::Criterion, 0.0);
        assert_eq!(first.layers.len(), 3);
        let one_thread = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .build()
            .unwrap();
        assert_eq!(
            one_thread.install(|| propose(ClusterCount::Criterion, 0.0)),
            first
        );
    }

    #[test]
    fn depth_follows_the_distances_of_the_layers() {
        let mut layers = propose(ClusterCount::Given(3), 0.2);
        let depth = depth_of_layers(&layers).unwrap();
        assert!(depth[[5, 5]].is_infinite());
        layers.layers[0].distance_m = -1.0;
        assert!(depth_of_layers(&layers).is_err());
        layers.layers.truncate(1);
        layers.layers[0].distance_m = 5.0;
        assert!(depth_of_layers(&layers).is_err(), "labels without a layer");
    }

    #[test]
    fn impossible_requests_are_refused() {
        let (photo, camera) = (photo(), camera());
        let refuse = |count, weight, eye_m| {
            let request = LayersRequest {
                count,
                position_weight: weight,
                camera: &camera,
                eye_height: Meters(eye_m),
            };
            assert!(propose_layers(&photo, &request).is_err());
        };
        refuse(ClusterCount::Given(0), 0.2, 1.6);
        refuse(ClusterCount::Given(65), 0.2, 1.6);
        refuse(ClusterCount::Criterion, -0.1, 1.6);
        refuse(ClusterCount::Criterion, 0.2, 0.0);
    }
}
