//! Light that ends at surfaces, in the resolution of a photograph.
//!
//! L(p) = sum_q w(q) L_q / sum_q w(q),   w = b(p, q) max(0, 1 − (ln(d(p)/d_q)/s)²)²
//! `p` pixel of the photograph and `d(p)` the distance of its surface [m], `q` the four pixels of the
//! light nearest to p and `d_q` the distances at which their light ends, `b` bilinear weights,
//! `s` = 0.1. The light up to a distance changes slowly across the picture; what changes at once is
//! the distance. So an edge in the photograph takes the light of its own side and none of the other's,
//! if that is 10 % nearer or farther. Where no light of the four ends near d(p), that of the pixel
//! within two whose distance is nearest counts alone.
//! [KCLU07] J. Kopf et al., Joint bilateral upsampling, ACM Trans. Graphics 26(3), 96 (2007), eq. 3.

use ndarray::Array2;
use ndarray::Zip;

use crate::compositing::AddedLight;
use crate::compositing::check_size;
use crate::error::Error;
use crate::picture_files::NO_DEPTH_M;
use crate::resample::same_shape;

/// Difference of the logarithms of two distances that have nothing in common.
const LOG_DISTANCE: f32 = 0.1;
/// Reach of the search where the four nearest fail, pixels of the light.
const REACH: usize = 2;
/// Sums of weights below this are failures.
const LEAST_WEIGHT: f32 = 0.05;
/// Distances below this are at the eye, m.
const LEAST_DISTANCE_M: f32 = 1e-3;

impl AddedLight {
    /// The same light at the surfaces of a photograph: `ends_m` says where the light of each of its
    /// pixels ends, `surface_m` how far the surfaces of the photograph are (m, infinite for the sky).
    ///
    /// # Errors
    /// Pictures of other shapes.
    pub fn at_surfaces(self, ends_m: &Array2<f32>, surface_m: &Array2<f32>) -> Result<Self, Error> {
        let (found, size) = (self.light.dim(), surface_m.dim());
        check_size("the surfaces of the light", found, ends_m.dim())?;
        if found == size {
            return Ok(self);
        }
        if !same_shape(found, size) {
            check_size("the light", size, found)?;
        }
        let coarse = Coarse {
            ends: ends_m.mapv(log_distance),
            light: &self,
            scale: [0, 1].map(|axis| ends_m.shape()[axis] as f32 / surface_m.shape()[axis] as f32),
        };
        let mut fine = Self {
            light: Array2::from_elem(size, [0.0; 3]),
            transmittance: Array2::ones(size),
        };
        Zip::indexed(&mut fine.light)
            .and(&mut fine.transmittance)
            .and(surface_m)
            .par_for_each(|(y, x), light, transmittance, surface_m| {
                (*light, *transmittance) = coarse.at([y, x], log_distance(*surface_m));
            });
        Ok(fine)
    }
}

fn log_distance(distance_m: f32) -> f32 {
    distance_m.clamp(LEAST_DISTANCE_M, NO_DEPTH_M).ln()
}

/// Light in its own resolution.
struct Coarse<'a> {
    light: &'a AddedLight,
    ends: Array2<f32>,
    /// Pixels of the light in a pixel of the photograph, down and across.
    scale: [f32; 2],
}

impl Coarse<'_> {
    fn at(&self, pixel: [usize; 2], log_distance: f32) -> ([f32; 3], f32) {
        let (mut light, mut through, mut total) = ([0.0; 3], 0.0, 0.0);
        let [(y, fy), (x, fx)] = [0, 1].map(|axis: usize| self.place(axis, pixel[axis]));
        let [n_y, n_x] = [self.ends.nrows(), self.ends.ncols()];
        for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
            for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
                let at = [(y + dy).min(n_y - 1), (x + dx).min(n_x - 1)];
                let apart = (self.ends[at] - log_distance) / LOG_DISTANCE;
                let weight = wy * wx * (1.0 - apart * apart).max(0.0).powi(2);
                for (sum, value) in light.iter_mut().zip(self.light.light[at]) {
                    *sum += weight * value;
                }
                through += weight * self.light.transmittance[at];
                total += weight;
            }
        }
        if total < LEAST_WEIGHT {
            let at = self.nearest_in_distance([y, x], log_distance);
            return (self.light.light[at], self.light.transmittance[at]);
        }
        (light.map(|value| value / total), through / total)
    }

    /// The pixel whose center lies before that of a pixel of the photograph, and how far after it.
    fn place(&self, axis: usize, index: usize) -> (usize, f32) {
        let last = self.ends.shape()[axis] - 1;
        let center = ((index as f32 + 0.5) * self.scale[axis] - 0.5).clamp(0.0, last as f32);
        let low = (center as usize).min(last);
        (low, center - low as f32)
    }

    fn nearest_in_distance(&self, [y, x]: [usize; 2], log_distance: f32) -> [usize; 2] {
        let mut best = ([y, x], f32::INFINITY);
        for row in y.saturating_sub(REACH)..(y + REACH + 1).min(self.ends.nrows()) {
            for column in x.saturating_sub(REACH)..(x + REACH + 1).min(self.ends.ncols()) {
                let apart = (self.ends[[row, column]] - log_distance).abs();
                if apart < best.1 {
                    best = ([row, column], apart);
                }
            }
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light that grows across a picture of 16 x 24 pixels, hidden by a disc at 10 m.
    fn coarse(hides: impl Fn(f32, f32) -> bool) -> (AddedLight, Array2<f32>) {
        let size = (16, 24);
        let hidden = |y: usize, x: usize| hides(y as f32 + 0.5, x as f32 + 0.5);
        let ends_m = Array2::from_shape_fn(
            size,
            |(y, x)| {
                if hidden(y, x) { 10.0 } else { f32::INFINITY }
            },
        );
        let of = |open: f32, closed: f32| {
            Array2::from_shape_fn(size, |(y, x)| if hidden(y, x) { closed } else { open })
        };
        let ramp = Array2::from_shape_fn(size, |(_, x)| 1.0 + 0.1 * (x as f32 + 0.5));
        let light = AddedLight {
            light: (ramp * of(1.0, 0.0)).mapv(|value| [value; 3]),
            transmittance: of(0.5, 1.0),
        };
        (light, ends_m)
    }

    fn disc(y: f32, x: f32) -> bool {
        (y - 8.0).hypot(x - 11.0) < 5.0
    }

    #[test]
    fn no_light_of_one_side_of_an_edge_gets_to_the_other() {
        let (light, ends_m) = coarse(disc);
        let surface_m = Array2::from_shape_fn((112, 168), |(y, x)| {
            let hidden = disc((y as f32 + 0.5) / 7.0, (x as f32 + 0.5) / 7.0);
            if hidden { 10.0 } else { f32::INFINITY }
        });
        let fine = light.at_surfaces(&ends_m, &surface_m).unwrap();
        for ((y, x), surface) in surface_m.indexed_iter() {
            let (light, through) = (fine.light[[y, x]][1], fine.transmittance[[y, x]]);
            if surface.is_finite() {
                assert_eq!((light, through), (0.0, 1.0), "{y} {x}");
            } else {
                // The ramp itself, up to half a pixel of it at edges: 0.05.
                let expected = 1.0 + 0.1 * (x as f32 + 0.5) / 7.0;
                assert!(
                    (light - expected).abs() < 0.11,
                    "{y} {x}: {light} {expected}"
                );
                assert!((through - 0.5).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_thing_thinner_than_a_pixel_takes_the_light_of_its_distance() {
        // A mast of one pixel of the photograph, seen by one pixel of the light beside it.
        let (light, ends_m) = coarse(|_, x| (x - 6.5).abs() < 0.1);
        let surface_m =
            Array2::from_shape_fn(
                (112, 168),
                |(_, x)| {
                    if x == 52 { 10.0 } else { f32::INFINITY }
                },
            );
        let fine = light.at_surfaces(&ends_m, &surface_m).unwrap();
        assert!(fine.light.column(52).iter().all(|light| light[0] == 0.0));
        assert!(fine.light.column(51).iter().all(|light| light[0] > 1.0));
    }

    #[test]
    fn without_edges_it_is_the_bilinear_picture() {
        let (light, ends_m) = coarse(|_, _| false);
        let surface_m = Array2::from_elem((32, 48), f32::INFINITY);
        let bilinear = light.clone().resized((32, 48)).unwrap();
        let fine = light.at_surfaces(&ends_m, &surface_m).unwrap();
        for (fine, bilinear) in fine.light.iter().zip(&bilinear.light) {
            assert!((fine[0] - bilinear[0]).abs() < 1e-6);
        }
    }

    #[test]
    fn other_shapes_are_refused_and_the_same_size_is_kept() {
        let (light, ends_m) = coarse(disc);
        assert_eq!(light.clone().at_surfaces(&ends_m, &ends_m).unwrap(), light);
        let square = Array2::from_elem((48, 48), 1.0);
        assert!(light.clone().at_surfaces(&ends_m, &square).is_err());
        assert!(light.at_surfaces(&square, &ends_m).is_err());
    }
}
