//! Random directions about an axis.
//!
//! cosine: density cos(theta)/pi on the hemisphere, from the uniform disc of P. Shirley and K. Chiu,
//! J. Graphics Tools 2(3), 45-52 (1997).
//! Frames: T. Duff et al., J. Computer Graphics Techniques 6(1), 1-8 (2017).

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::FRAC_PI_4;

use glam::DMat3;
use glam::DVec3;

/// The frame with `axis`, a unit vector, as its z.
pub(crate) fn frame(axis: DVec3) -> DMat3 {
    let sign = 1.0_f64.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    DMat3::from_cols(
        DVec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        DVec3::new(b, sign + axis.y * axis.y * a, -axis.y),
        axis,
    )
}

/// A point of the unit disc, from a point of the unit square.
pub(crate) fn unit_disc([u, v]: [f64; 2]) -> [f64; 2] {
    let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if x == 0.0 && y == 0.0 {
        return [0.0; 2];
    }
    let (radius, angle) = if x.abs() > y.abs() {
        (x, FRAC_PI_4 * (y / x))
    } else {
        (y, FRAC_PI_2 - FRAC_PI_4 * (x / y))
    };
    let (sin, cos) = angle.sin_cos();
    [radius * cos, radius * sin]
}

/// A unit vector about `axis` with density cos(theta)/pi.
pub(crate) fn cosine_about(axis: DVec3, uv: [f64; 2]) -> DVec3 {
    let [x, y] = unit_disc(uv);
    // Never exactly within the surface: a path must leave it.
    let z = (1.0 - x * x - y * y).max(1e-24).sqrt();
    (frame(axis) * DVec3::new(x, y, z)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for axis in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(0.6, -0.48, -0.64)] {
            let frame = frame(axis);
            assert!((frame.determinant() - 1.0).abs() < 1e-14);
            assert!(
                (frame * frame.transpose() - DMat3::IDENTITY)
                    .to_cols_array()
                    .iter()
                    .all(|x| x.abs() < 1e-14)
            );
            assert_eq!(frame.z_axis, axis);
        }
    }

    #[test]
    fn cosine_directions_have_their_density() {
        // Equal shares of cos² and azimuth.
        let axis = DVec3::new(0.6, -0.48, -0.64);
        let to_local = frame(axis).transpose();
        let mut chi2 = Chi2::new(200);
        for index in 0..200_000 {
            let local = to_local * cosine_about(axis, pseudo_random(index));
            assert!(local.z > 0.0);
            let ring = (local.z * local.z * 10.0).min(9.0) as usize;
            let sector = ((local.y.atan2(local.x) / std::f64::consts::TAU + 0.5) * 20.0).min(19.0);
            chi2.count(ring * 20 + sector as usize);
        }
        chi2.assert_fits(&[1.0 / 200.0; 200]);
    }

    #[test]
    fn the_middle_of_the_square_is_the_axis() {
        assert!(cosine_about(DVec3::X, [0.5, 0.5]).distance(DVec3::X) < 1e-15);
    }
}
