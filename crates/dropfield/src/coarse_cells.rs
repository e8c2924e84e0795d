//! How wrong a brick's field is in coarser cells.
//!
//! e_2w = RMS_8 e_w + RMS (I_2w(x) - f(x)),  e_1 = 0,  relative to mean f
//!
//! of a cell 2w voxels wide: `I_2w` trilinear between its corners, `f` lanes at the nodes x that stand w
//! apart in it, `RMS_8` over the cells half as wide; of the optical depth to the sun twice the
//! difference, which is the error of sunlight at Q = 2; of M3 that of M3/M2, the effective radius, eight
//! times, as it moves the fringes of a bow. The largest lane counts. A ray sees the mean
//! difference along its way, whose sign is that of the field's bend. An even or linear field errs by
//! nothing but rounding.

use glam::IVec3;
use glam::Vec4;

use crate::brick_layout::place_in_cube;
use crate::bricks::BRICK_DIM;
use crate::bricks::STRIDE_X;
use crate::bricks::STRIDE_Y;
use crate::bricks::cell_base;

/// Where nothing is known, and in place of errors that nobody would allow.
pub(crate) const TOO_COARSE: CoarseErrors = CoarseErrors {
    of_twos: [f32::INFINITY; 64],
    of_fours: [f32::INFINITY; 8],
    of_eight: f32::INFINITY,
    least: f32::INFINITY,
};

/// In place of the error of a cell without drops.
pub(crate) const NO_DROPS: f32 = -1.0;

/// The largest error that is kept.
const MOST_ERROR: f32 = 0.1;

/// Relative change of a bow's light for each of the radius. In a narrow law fringes are seen up to the
/// fourth or so, whose phase of 25 goes with r^(2/3), and whose contrast is about a half.
const RADIUS_SCALE: f32 = 8.0;

/// What twice a difference of optical depth is divided by.
const DEPTH_SCALE: f32 = 0.5;

/// Relative errors of a brick's cells 2, 4 and 8 voxels wide, z fastest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CoarseErrors {
    of_twos: [f32; 64],
    of_fours: [f32; 8],
    of_eight: f32,
    /// Of the cells with drops, if there are any.
    least: f32,
}

impl CoarseErrors {
    /// Those of a brick whose nodes hold moments.
    pub(crate) fn of(lanes: &[Vec4]) -> Self {
        let radii: Vec<f32> = lanes.iter().map(radius).collect();
        let nodes = Nodes {
            lanes,
            radii: &radii,
        };
        let twos: [Block; 64] = std::array::from_fn(|index| Block::of::<1>(&nodes, index, &[]));
        let fours: [Block; 8] = std::array::from_fn(|index| {
            let place = place_in_cube(2, index) << 1;
            let halves: [_; 8] =
                std::array::from_fn(|half| twos[number_of::<4>(place + place_in_cube(2, half))]);
            Block::of::<2>(&nodes, index, &halves)
        });
        let eight = Block::of::<4>(&nodes, 0, &fours);
        let of_twos = twos.map(|block| block.relative_error());
        let of_fours = fours.map(|block| block.relative_error());
        let of_eight = eight.relative_error();
        let finer = of_twos.iter().chain(&of_fours);
        let with_drops = finer.filter(|error| **error > NO_DROPS);
        Self {
            of_twos,
            of_fours,
            of_eight,
            least: with_drops.fold(of_eight, |least, error| least.min(*error)),
        }
    }

    /// Whether there is a coarse cell with drops that errs by no more than `allowed`, or no drops at all.
    #[inline]
    pub(crate) fn allow(&self, allowed: f32) -> bool {
        self.least <= allowed
    }

    /// Width in voxels of the coarsest cell around a voxel that errs by no more than `allowed`, and its
    /// error or [`NO_DROPS`].
    #[inline]
    pub(crate) fn coarsest(&self, voxel: IVec3, allowed: f32) -> (i32, f32) {
        if self.of_eight <= allowed {
            return (8, self.of_eight);
        }
        let inside = voxel & (BRICK_DIM - 1);
        let of_four = self.of_fours[number_of::<2>(inside >> 2)];
        if of_four <= allowed {
            return (4, of_four);
        }
        let of_two = self.of_twos[number_of::<4>(inside >> 1)];
        if of_two <= allowed {
            return (2, of_two);
        }
        (1, 0.0)
    }
}

/// The nodes of a brick.
struct Nodes<'a> {
    lanes: &'a [Vec4],
    /// M3/M2 (um).
    radii: &'a [f32],
}

/// M3/M2, 0 without drops.
fn radius(lanes: &Vec4) -> f32 {
    if lanes.x > 0.0 {
        lanes.y / lanes.x
    } else {
        0.0
    }
}

/// Lanes in a cell of several voxels.
#[derive(Clone, Copy)]
struct Block {
    mean: Vec4,
    /// RMS of their difference from the interpolant between the corners; of M3 less that of as many drops
    /// of the radius there.
    error: Vec4,
}

impl Block {
    /// The cell of a number that is `2 WIDTH` voxels wide, made of `halves` half as wide unless these are
    /// voxels.
    fn of<const WIDTH: usize>(nodes: &Nodes, index: usize, halves: &[Self]) -> Self {
        let low = place_in_cube(4 / WIDTH, index) * (2 * WIDTH as i32);
        let first = cell_base(0, low);
        let place = |x, y, z| first + (x * STRIDE_X + y * STRIDE_Y + z) * WIDTH;
        let node = |x, y, z| nodes.lanes[place(x, y, z)];
        // Eight times the interpolant: of equal values exactly their own.
        let row = |x, y| between(node(x, y, 0), node(x, y, 2));
        let face = |x| across(row(x, 0), row(x, 2));
        let (low_face, high_face) = (face(0), face(2));
        let (mut mean, mut squares) = (Vec4::ZERO, Vec4::ZERO);
        for y in 0..3 {
            for z in 0..3 {
                for (x, eight) in between(low_face[y][z], high_face[y][z])
                    .into_iter()
                    .enumerate()
                {
                    let value = node(x, y, z);
                    let mut difference = 0.125 * eight - value;
                    difference.y -= nodes.radii[place(x, y, z)] * difference.x;
                    let weight = TRAPEZOID[x] * TRAPEZOID[y] * TRAPEZOID[z];
                    mean += weight * value;
                    squares += weight * difference * difference;
                }
            }
        }
        if !halves.is_empty() {
            // Between nodes far apart drops may be missed.
            mean = 0.125 * halves.iter().map(|half| half.mean).sum::<Vec4>();
        }
        let of_halves: Vec4 = halves.iter().map(|half| half.error * half.error).sum();
        Self {
            mean,
            error: squares.map(f32::sqrt) + (0.125 * of_halves).map(f32::sqrt),
        }
    }

    fn relative_error(&self) -> f32 {
        if self.mean.x <= 0.0 {
            return NO_DROPS;
        }
        let scale = Vec4::new(1.0, RADIUS_SCALE, 1.0, 1.0);
        let error = scale * self.error / self.mean.with_w(DEPTH_SCALE);
        // Squares may leave the range of f32.
        if error.is_finite() && error.max_element() <= MOST_ERROR {
            error.max_element()
        } else {
            f32::INFINITY
        }
    }
}

/// Weights of a cell's first face, middle and last face.
const TRAPEZOID: [f32; 3] = [0.25, 0.5, 0.25];

/// Twice the values at two ends and in the middle between them.
fn between(low: Vec4, high: Vec4) -> [Vec4; 3] {
    [low + low, low + high, high + high]
}

/// The same of rows.
fn across(low: [Vec4; 3], high: [Vec4; 3]) -> [[Vec4; 3]; 3] {
    let z = |z: usize| between(low[z], high[z]);
    let columns = [z(0), z(1), z(2)];
    std::array::from_fn(|y| std::array::from_fn(|z| columns[z][y]))
}

/// Number of a place in a cube of `N` along each side, z fastest.
#[inline]
fn number_of<const N: usize>(place: IVec3) -> usize {
    let place = place.as_usizevec3();
    (place.x * N + place.y) * N + place.z
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::brick_layout::node_in_brick;
    use crate::bricks::NODES_PER_BRICK;

    fn errors(value: impl Fn(Vec3) -> Vec4) -> CoarseErrors {
        let at = |index| value(node_in_brick(index).as_vec3());
        CoarseErrors::of(&(0..NODES_PER_BRICK).map(at).collect::<Vec<_>>())
    }

    /// Widths at the voxels of a column along z.
    fn widths(errors: &CoarseErrors, allowed: f32) -> [i32; 8] {
        [0, 1, 2, 3, 4, 5, 6, 7].map(|z| errors.coarsest(IVec3::new(2, 5, z), allowed).0)
    }

    #[test]
    fn trilinear_fields_have_no_error() {
        let value = Vec4::new(0.1, 1.0e7, 3.3e-5, 0.7);
        let even = errors(|_| value);
        assert_eq!(even.coarsest(IVec3::ZERO, 0.0), (8, 0.0));
        assert_eq!((even.of_twos, even.of_fours), ([0.0; 64], [0.0; 8]));
        let sloped = errors(|p| value * (1.0 + p.x) * (2.0 + p.y) * (1.0 + 0.1 * p.z));
        // Rounding of numbers up to 100 at the depth.
        let errors = sloped.of_twos.iter().chain(&sloped.of_fours);
        assert!(sloped.of_eight < 1e-4 && errors.into_iter().all(|error| *error < 1e-4));
    }

    #[test]
    fn a_parabola_errs_by_its_bend() {
        // f'' h²/8 at the middle of a cell, which has half of the weight; cells of all places along y.
        let half = 0.5_f32.sqrt();
        let curved = errors(|p| (90.0 + p.y * p.y) * Vec4::new(1.0, 2.0, 4.0, 0.0));
        let mean_of_two =
            |y: f32| 90.0 + (y * y + 2.0 * (y + 1.0).powi(2) + (y + 2.0).powi(2)) / 4.0;
        for y in 0..8 {
            let voxel = IVec3::new(7, y, 3);
            let of_two = half / mean_of_two((y & 6) as f32);
            let low = (y & 4) as f32;
            let of_four = 5.0 * half / (0.5 * (mean_of_two(low) + mean_of_two(low + 2.0)));
            for (allowed, width, error) in [(0.02, 2, of_two), (0.05, 4, of_four)] {
                let found = curved.coarsest(voxel, allowed);
                assert_eq!(found.0, width);
                assert!(
                    (found.1 / error - 1.0).abs() < 1e-4,
                    "{y}: {found:?} {error}"
                );
            }
            assert_eq!(curved.coarsest(voxel, 1e-3), (1, 0.0));
        }
        // (1 + 4 + 16) half of 112 is more than anybody allows.
        assert_eq!(curved.of_eight, f32::INFINITY);
        // Of a radius, in as many drops everywhere, eight times.
        let radius = errors(|p| Vec4::new(1.0, 90.0 + p.y * p.y, 1.0, 0.0));
        let of_two = radius.of_twos[number_of::<4>(IVec3::new(3, 2, 1))];
        assert!((of_two / (8.0 * half / mean_of_two(4.0)) - 1.0).abs() < 1e-4);
        // Of a depth twice the difference.
        let depth = errors(|p| Vec4::new(1.0, 1.0, 1.0, 1e-3 * p.x * p.x));
        let errs_by_two = |error: &f32| (error - 2e-3 * half).abs() < 1e-6;
        assert!(depth.of_twos.iter().all(errs_by_two));
    }

    #[test]
    fn where_drops_end_no_cell_is_coarse() {
        for end in 0..8 {
            let step = errors(|p| {
                if p.z > end as f32 {
                    Vec4::ONE
                } else {
                    Vec4::ZERO
                }
            });
            let expected = std::array::from_fn(|z| match z as i32 ^ end {
                0..2 => 1,
                2..4 => 2,
                _ => 4,
            });
            assert_eq!(widths(&step, 1.0), expected);
            // Of cells with drops only those behind the end are coarse.
            assert_eq!(step.allow(1.0), end < 6);
        }
        let none = errors(|_| Vec4::ZERO);
        assert_eq!(none.coarsest(IVec3::ONE, 1e-6), (8, NO_DROPS));
    }

    #[test]
    fn drops_at_a_single_node_are_not_missed() {
        let single = errors(|p| {
            if p == Vec3::new(3.0, 5.0, 1.0) {
                Vec4::ONE
            } else {
                Vec4::ZERO
            }
        });
        assert_eq!(widths(&single, 1.0), [1, 1, 2, 2, 4, 4, 4, 4]);
    }

    #[test]
    fn the_least_error_tells_whether_any_cell_is_coarse() {
        for length in [2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 400.0, 1000.0] {
            let wave = errors(|p| Vec4::splat(2.0 + (p.dot(Vec3::ONE) / length).sin()));
            for exponent in 5..80 {
                let allowed = 0.8_f32.powi(exponent);
                let is_coarse = |index| wave.coarsest(place_in_cube(8, index), allowed).0 > 1;
                let any = (0..512).any(is_coarse);
                assert_eq!(wave.allow(allowed), any, "{length} {allowed}");
            }
        }
    }

    #[test]
    fn a_cell_may_err_less_than_each_of_its_halves() {
        // The middles of halves differ, of each in another lane; in one cell of four voxels less.
        let spiked = errors(|p| {
            let middle = p.as_ivec3();
            let mut value = Vec4::ONE;
            if middle & 1 == IVec3::ONE {
                let half: IVec3 = middle >> 1;
                let in_first = middle.max_element() < 4;
                let spike = if in_first { 0.01 } else { 0.1 };
                value += spike
                    * match (half & 1).element_sum() % 3 {
                        // More drops of the same radius.
                        0 => Vec4::new(1.0, 1.0, 0.0, 0.0),
                        1 => Vec4::Z,
                        _ => DEPTH_SCALE * Vec4::W,
                    };
            }
            value
        });
        let allowed = 0.9
            * spiked
                .of_twos
                .iter()
                .fold(1.0_f32, |least, error| least.min(*error));
        assert_eq!(spiked.coarsest(IVec3::ZERO, allowed).0, 4);
        assert_eq!(spiked.coarsest(IVec3::splat(4), allowed).0, 1);
        assert!(spiked.allow(allowed));
    }
}
