//! How wrong a brick's field is in coarser cells.
//!
//! e_2w = e_w + RMS (I_2w(x) - f(x)) / mean f(x),  e_1 = 0
//!
//! `I_2w` trilinear between every 2w-th node, `f` lanes at the nodes x that stand w apart; of the
//! optical depth to the sun twice the difference, which is the error of sunlight at Q = 2. The largest
//! lane counts. A ray sees the mean difference along its way, whose sign is that of the field's bend.
//! An even or linear field errs by nothing but rounding.

use glam::Vec4;

use crate::bricks::BRICK_NODES;
use crate::bricks::NODES_PER_BRICK;
use crate::bricks::STRIDE_X;
use crate::bricks::STRIDE_Y;

/// Relative errors of cells 2, 4 and 8 voxels wide.
pub(crate) type CoarseErrors = [f32; 3];

/// Where nothing is known, and in place of errors that nobody would allow.
pub(crate) const TOO_COARSE: CoarseErrors = [f32::INFINITY; 3];

/// The largest error that is kept.
const MOST_ERROR: f32 = 0.1;

/// What twice a difference of optical depth is divided by.
const DEPTH_SCALE: f32 = 0.5;

/// The errors of a brick whose nodes hold moments.
pub(crate) fn coarse_errors(lanes: &[Vec4]) -> CoarseErrors {
    let rules = [
        error_at_twice::<1>,
        error_at_twice::<2>,
        error_at_twice::<4>,
    ];
    let mut errors = TOO_COARSE;
    let mut sum = 0.0;
    for (error, rule) in errors.iter_mut().zip(rules) {
        sum += rule(lanes);
        if sum > MOST_ERROR {
            break;
        }
        *error = sum;
    }
    errors
}

/// Width in voxels of the coarsest cells that err by no more than `relative_error`.
pub(crate) fn coarsest(errors: &CoarseErrors, relative_error: f32) -> i32 {
    let allowed = errors.iter().take_while(|error| **error <= relative_error);
    1 << allowed.count()
}

/// Relative difference of nodes `WIDTH` apart from the mean of those around that stand twice as far
/// apart.
fn error_at_twice<const WIDTH: usize>(lanes: &[Vec4]) -> f32 {
    let lanes = &lanes[..NODES_PER_BRICK];
    let step = |place: usize| place / WIDTH % 2 * WIDTH;
    let (mut squares, mut sum, mut n) = (Vec4::ZERO, Vec4::ZERO, 0.0);
    for x in (0..BRICK_NODES).step_by(WIDTH) {
        for y in (0..BRICK_NODES).step_by(WIDTH) {
            let (x_step, y_step) = (step(x) * STRIDE_X, step(y) * STRIDE_Y);
            let row = x * STRIDE_X + y * STRIDE_Y;
            // The four rows around. In pairs, so that equal values have exactly their own mean.
            let edge = |node: usize| lanes[node - x_step] + lanes[node + x_step];
            let around = |z: usize| edge(row + z - y_step) + edge(row + z + y_step);
            let mut last = around(0);
            let mut add = |z: usize, mean: Vec4| {
                let value = lanes[row + z];
                squares += (mean - value) * (mean - value);
                sum += value;
                n += 1.0;
            };
            add(0, 0.25 * last);
            for z in (2 * WIDTH..BRICK_NODES).step_by(2 * WIDTH) {
                let next = around(z);
                add(z - WIDTH, 0.125 * (last + next));
                add(z, 0.25 * next);
                last = next;
            }
        }
    }
    let mean = (sum / n)
        .with_w(DEPTH_SCALE)
        .max(Vec4::splat(f32::MIN_POSITIVE));
    // Squares may leave the range of f32.
    let error = (squares / n).map(f32::sqrt) / mean;
    if error.is_finite() {
        error.max_element()
    } else {
        f32::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::brick_layout::node_in_brick;

    fn brick(value: impl Fn(Vec3) -> Vec4) -> Vec<Vec4> {
        let at = |index| value(node_in_brick(index).as_vec3());
        (0..NODES_PER_BRICK).map(at).collect()
    }

    #[test]
    fn trilinear_fields_have_no_error() {
        let value = Vec4::new(0.1, 1.0e7, 3.3e-5, 0.7);
        assert_eq!(coarse_errors(&brick(|_| value)), [0.0; 3]);
        let sloped = brick(|p| value * (1.0 + p.x) * (2.0 + p.y) * (1.0 + 0.1 * p.z));
        // Rounding of numbers up to 100 at the depth.
        assert!(coarse_errors(&sloped).iter().all(|error| *error < 1e-4));
    }

    #[test]
    fn a_parabola_errs_by_its_bend() {
        // f'' / 8 = 1/4 of the squared width at every second node, 4 of 9 and 2 of 5; a depth counts
        // twice.
        let curved = brick(|p| Vec4::new(90.0 + p.y * p.y, 1.0, 1.0, 0.0));
        let errors = coarse_errors(&curved);
        let [first, second] = [(4.0_f32 / 9.0).sqrt(), 4.0 * 0.4_f32.sqrt()];
        let [of_all, of_even] = [90.0 + 204.0 / 9.0, 90.0 + 120.0 / 5.0];
        assert!((errors[0] - first / of_all).abs() < 1e-6);
        assert!((errors[1] - (first / of_all + second / of_even)).abs() < 1e-6);
        let third = 16.0 * (1.0_f32 / 3.0).sqrt() / (90.0 + 80.0 / 3.0);
        assert!(first / of_all + second / of_even + third > MOST_ERROR);
        assert_eq!(errors[2], f32::INFINITY);
        let depth = brick(|p| Vec4::new(1.0, 1.0, 1.0, 1e-3 * p.x * p.x));
        assert!((coarse_errors(&depth)[0] - 2e-3 * first).abs() < 1e-6);
        assert_eq!(coarsest(&errors, 1e-3), 1);
        assert_eq!(coarsest(&errors, 0.01), 2);
        assert_eq!(coarsest(&errors, 1.0), 4);
    }

    #[test]
    fn where_drops_end_no_cell_is_coarse() {
        for n in 0..8 {
            let end = n as f32;
            let ending = brick(|p| if p.z > end { Vec4::ONE } else { Vec4::ZERO });
            assert_eq!(coarse_errors(&ending), TOO_COARSE);
        }
    }
}
