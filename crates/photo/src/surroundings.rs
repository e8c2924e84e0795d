//! The light of a photograph that drops before it scatter into the view.
//!
//! S(v) = sum_q w_q p(angle(v, q)) L_q / sum_q w_q p(angle(v, q)) a_q,   w_q = Omega_q k_q
//! `L` light and `a` alpha of the photograph around the directions `q`, `Omega` their solid angle, `p` what drops
//! scatter by angle, `k` 1 or 0: whether drops see there what the photograph shows. Drops do not absorb, so that
//! before a photograph of one color they are not seen: T S + (1 - T) S = S. Large drops throw most of what meets them
//! a few tens of degrees from where it went, so that most of S is in the picture; what is outside of it is taken to
//! be like what is in it.

use std::ops::Range;

use glam::DVec3;
use ndarray::Array2;
use ndarray::parallel::prelude::*;

use crate::error::Error;
use crate::linear_picture::LinearPicture;
use crate::resample::mix_colors;
use crate::resample::resample;

/// Blocks along the longer side: p changes over ten degrees.
const LONGER: usize = 48;

/// A photograph as drops before it see it.
pub struct Surroundings<'a, D, S, P> {
    /// Its linear light, premultiplied.
    pub light: &'a LinearPicture,
    /// What it covers; all if there is none.
    pub alpha: Option<&'a Array2<f32>>,
    /// Unit vector into which a point of it is seen, by column and row in pixels; `None` where it has none.
    pub direction: D,
    /// Whether drops see there what the pixel shows, by row and column and direction.
    pub is_seen: S,
    /// What drops scatter by the cosine of the angle, of any scale.
    pub phase: P,
}

/// Pixels that are seen as one.
struct Block {
    direction: DVec3,
    solid_angle: f64,
    light: [f64; 3],
    alpha: f64,
}

impl<D, S, P> Surroundings<'_, D, S, P>
where
    D: Fn(f64, f64) -> Option<DVec3> + Sync,
    S: Fn([usize; 2], DVec3) -> bool + Sync,
    P: Fn(f64) -> f64 + Sync,
{
    /// The light S, linear RGB by row and column as the photograph; black where drops see nothing of it.
    ///
    /// # Errors
    /// None for a photograph that has pixels.
    pub fn scattered(&self) -> Result<LinearPicture, Error> {
        let (height, width) = self.light.dim();
        let step = height.max(width).div_ceil(LONGER).max(1);
        let size = (height.div_ceil(step), width.div_ceil(step));
        let at = |index: usize| [index / size.1.max(1), index % size.1.max(1)];
        let blocks: Vec<Option<Block>> = (0..size.0 * size.1)
            .into_par_iter()
            .map(|index| self.block(size, at(index)))
            .collect();
        let seen: Vec<[f32; 3]> = (0..blocks.len())
            .into_par_iter()
            .map(|index| {
                let [x, y] = center(self.light.dim(), size, at(index));
                let view = (self.direction)(x, y);
                view.map_or([0.0; 3], |view| self.toward(view, &blocks))
            })
            .collect();
        let coarse = Array2::from_shape_vec(size, seen)
            .map_err(|error| Error::Damaged(error.to_string()))?;
        resample(&coarse, (height, width), mix_colors)
    }

    fn block(&self, size: (usize, usize), at: [usize; 2]) -> Option<Block> {
        let [x, y] = center(self.light.dim(), size, at);
        let direction = (self.direction)(x, y)?;
        let beside = (self.direction)(x + 1.0, y)? - direction;
        let below = (self.direction)(x, y + 1.0)? - direction;
        let mut block = Block {
            direction,
            solid_angle: beside.cross(below).length(),
            light: [0.0; 3],
            alpha: 0.0,
        };
        let [rows, columns] = pixels(self.light.dim(), size, at);
        for y in rows {
            for x in columns.clone() {
                if !(self.is_seen)([y, x], direction) {
                    continue;
                }
                for (sum, channel) in block.light.iter_mut().zip(self.light[[y, x]]) {
                    *sum += f64::from(channel);
                }
                block.alpha += self.alpha.map_or(1.0, |alpha| f64::from(alpha[[y, x]]));
            }
        }
        Some(block)
    }

    fn toward(&self, view: DVec3, blocks: &[Option<Block>]) -> [f32; 3] {
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for block in blocks.iter().flatten() {
            let weight = block.solid_angle * (self.phase)(view.dot(block.direction));
            for (sum, channel) in sum.iter_mut().zip(block.light) {
                *sum += weight * channel;
            }
            total += weight * block.alpha;
        }
        if total <= 0.0 {
            return [0.0; 3];
        }
        // f32: what pictures hold.
        sum.map(|sum| (sum / total) as f32)
    }
}

/// The rows and columns of a block.
fn pixels(of: (usize, usize), size: (usize, usize), at: [usize; 2]) -> [Range<usize>; 2] {
    let along = |n: usize, parts: usize, index: usize| {
        let end = |index: usize| index * n / parts;
        end(index)..end(index + 1)
    };
    [along(of.0, size.0, at[0]), along(of.1, size.1, at[1])]
}

/// The middle of a block, column and row.
fn center(of: (usize, usize), size: (usize, usize), [row, column]: [usize; 2]) -> [f64; 2] {
    let along =
        |n: usize, parts: usize, index: usize| (index as f64 + 0.5) * n as f64 / parts as f64;
    [along(of.1, size.1, column), along(of.0, size.0, row)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A view 90 degrees wide.
    fn direction(x: f64, y: f64) -> DVec3 {
        DVec3::new(x - 30.0, 20.0 - y, -30.0).normalize()
    }

    fn forward(cosine: f64) -> f64 {
        (4.0 * cosine).exp()
    }

    fn scattered(
        light: &LinearPicture,
        alpha: Option<&Array2<f32>>,
        is_seen: impl Fn([usize; 2], DVec3) -> bool + Sync,
    ) -> LinearPicture {
        let all = Surroundings {
            light,
            alpha,
            direction: |x: f64, y: f64| Some(direction(x, y)),
            is_seen,
            phase: forward,
        };
        all.scattered().unwrap()
    }

    #[test]
    fn of_one_color_it_is_that_color_whatever_alpha_covers() {
        let light = Array2::from_elem((40, 60), [0.2, 0.5, 3.0]);
        for pixel in scattered(&light, None, |_, _| true) {
            for (found, expected) in pixel.into_iter().zip([0.2, 0.5, 3.0]) {
                assert!((found - expected).abs() < 1e-6 * expected);
            }
        }
        let alpha = Array2::from_shape_fn((40, 60), |(y, _)| if y < 10 { 0.5 } else { 0.0 });
        let light = alpha.mapv(|alpha| [0.2 * alpha; 3]);
        for pixel in scattered(&light, Some(&alpha), |_, _| true) {
            assert!((pixel[0] - 0.2).abs() < 1e-6);
        }
    }

    #[test]
    fn it_is_the_integral_over_what_is_seen() {
        // Bright on the left half: the closed sum over pixels at one view.
        let light = Array2::from_shape_fn((40, 60), |(_, x)| [if x < 30 { 1.0 } else { 0.0 }; 3]);
        let found = scattered(&light, None, |[y, _], _| y < 20);
        let view = direction(45.5, 10.5);
        let (mut bright, mut all) = (0.0, 0.0);
        for y in 0..20 {
            for x in 0..60 {
                let toward = DVec3::new(f64::from(x) - 29.5, 19.5 - f64::from(y), -30.0);
                let weight = forward(view.dot(toward.normalize())) / toward.length().powi(3);
                all += weight;
                bright += if x < 30 { weight } else { 0.0 };
            }
        }
        let relative = f64::from(found[[10, 45]][0]) / (bright / all) - 1.0;
        assert!(relative.abs() < 0.02, "{relative}");
        assert!(found[[10, 15]][0] > 2.0 * found[[10, 45]][0]);
    }

    #[test]
    fn where_nothing_is_seen_it_is_black() {
        let light = Array2::from_elem((40, 60), [1.0; 3]);
        let found = scattered(&light, None, |_, _| false);
        assert!(found.iter().flatten().all(|it| it.to_bits() == 0));
    }
}
