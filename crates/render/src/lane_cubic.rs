//! The moments on a piece of a ray inside one cell.
//!
//! On a straight line a trilinear interpolant is a cubic of the position x = 0..1 along the piece. For
//! a whole cell it comes from the cell's corners; on a part of a cell, and where lanes are only nearly
//! cubic, four samples at x = 0, 1/3, 2/3, 1 determine it:
//!
//! y(x) = c0 + c1 x + c2 x² + c3 x³, by Newton's forward differences d1, d2, d3 with s = 3x,
//! c1 = 3 d1 - 1.5 d2 + d3,  c2 = 4.5 (d2 - d3),  c3 = 4.5 d3.
//!
//! Differences of equal samples are exactly zero, so a homogeneous volume stays exactly homogeneous;
//! the Lagrange form would leave 1e-6 of noise. Lanes: (M2, M3, M4, optical depth to the sun), f32:
//! sampled moments carry 1e-7 themselves, and sums over a ray are taken in f64 outside.

use glam::DVec4;
use glam::Vec4;

/// Where the four samples lie.
pub(crate) const SAMPLE_POSITIONS: [f32; 4] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0];

/// The four lanes as cubics of the position along a piece of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneCubic {
    coefficients: [Vec4; 4],
}

impl LaneCubic {
    /// The cubic through samples at [`SAMPLE_POSITIONS`].
    #[inline]
    pub(crate) fn through(samples: [Vec4; 4]) -> Self {
        let (first, second, third) = (
            samples[1] - samples[0],
            samples[2] - samples[1],
            samples[3] - samples[2],
        );
        let (d1, d2) = (first, second - first);
        let d3 = (third - second) - d2;
        let c0 = samples[0];
        let c1 = 3.0 * d1 - 1.5 * d2 + d3;
        let c2 = 4.5 * (d2 - d3);
        let c3 = 4.5 * d3;
        Self::new([c0, c1, c2, c3])
    }

    /// The cubic of the coefficients c0 to c3.
    #[inline]
    pub(crate) fn new(coefficients: [Vec4; 4]) -> Self {
        Self { coefficients }
    }

    /// All lanes at `x`.
    #[inline]
    pub(crate) fn at(&self, x: f32) -> Vec4 {
        let [c0, c1, c2, c3] = self.coefficients;
        (c0 + x * c1) + (x * x) * (c2 + x * c3)
    }

    /// The cubic of a part of `width` from `start` on.
    #[inline]
    pub(crate) fn part(&self, start: f32, width: f32) -> Self {
        let [_, c1, c2, c3] = self.coefficients;
        let (slope, bend) = (
            c1 + start * (2.0 * c2 + 3.0 * start * c3),
            c2 + 3.0 * start * c3,
        );
        let square = width * width;
        Self::new([
            self.at(start),
            width * slope,
            square * bend,
            square * width * c3,
        ])
    }

    /// All lanes at both ends.
    #[inline]
    pub(crate) fn ends(&self) -> [Vec4; 2] {
        let [c0, c1, c2, c3] = self.coefficients;
        [c0, c0 + ((c1 + c2) + c3)]
    }

    /// Slope and bend of all lanes, as their mean over a piece has them: in Legendre polynomials of
    /// 2x - 1, y = mean + slope/2 P1 + bend/6 P2 + c3/20 P3.
    #[inline]
    pub(crate) fn slope_and_bend(&self) -> (Vec4, Vec4) {
        let [_, c1, c2, c3] = self.coefficients;
        ((c1 + c2) + 0.9 * c3, c2 + 1.5 * c3)
    }

    /// Means of all lanes.
    #[inline]
    pub(crate) fn mean(&self) -> Vec4 {
        let [c0, c1, c2, c3] = self.coefficients;
        (c0 + 0.5 * c1) + (c2 * (1.0 / 3.0) + 0.25 * c3)
    }

    /// Factors m0..m3 of the integral of M2 from 0 to x in units of the piece's length,
    /// x (m0 + x (m1 + x (m2 + x m3))).
    #[inline]
    pub(crate) fn m2_integral(&self) -> DVec4 {
        let [c0, c1, c2, c3] = self.coefficients;
        let m2 = DVec4::new(c0.x as f64, c1.x as f64, c2.x as f64, c3.x as f64);
        m2 * DVec4::new(1.0, 0.5, 1.0 / 3.0, 0.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest error found: 4e-7.
    const TOLERANCE: f32 = 2e-6;

    fn cubic(x: f32) -> Vec4 {
        Vec4::new(
            1.0 + x * (2.0 - x * (3.0 - 0.5 * x)),
            4.0,
            2.0 * x * x * x,
            (1.0 - x) * (1.0 - x) * (1.0 + x),
        )
    }

    fn m2_up_to(cubic: &LaneCubic, x: f64) -> f64 {
        let m = cubic.m2_integral();
        x * (m.x + x * (m.y + x * (m.z + x * m.w)))
    }

    #[test]
    fn four_samples_determine_a_cubic() {
        let fitted = LaneCubic::through(SAMPLE_POSITIONS.map(cubic));
        for step in 0..=20 {
            let x = step as f32 / 20.0;
            assert!((fitted.at(x) - cubic(x)).abs().max_element() < TOLERANCE);
        }
        for (end, expected) in fitted.ends().into_iter().zip([cubic(0.0), cubic(1.0)]) {
            assert!((end - expected).abs().max_element() < TOLERANCE);
        }
    }

    #[test]
    fn the_integral_is_that_of_the_cubic() {
        let fitted = LaneCubic::through(SAMPLE_POSITIONS.map(cubic));
        for x in [0.0, 0.3, 1.0] {
            let expected = x + x * x - x * x * x + 0.125 * x * x * x * x;
            assert!((m2_up_to(&fitted, x) - expected).abs() < f64::from(TOLERANCE));
        }
    }

    #[test]
    fn slope_and_bend_are_those_of_legendre_polynomials() {
        let cubic_of = |x: f32| {
            let p1 = 2.0 * x - 1.0;
            let (p2, p3) = (1.5 * p1 * p1 - 0.5, 2.5 * p1 * p1 * p1 - 1.5 * p1);
            Vec4::splat(0.3 + 0.5 * 0.7 * p1 - 0.4 / 6.0 * p2 + 0.1 * p3)
        };
        let fitted = LaneCubic::through(SAMPLE_POSITIONS.map(cubic_of));
        let (slope, bend) = fitted.slope_and_bend();
        let errors = [fitted.mean() - 0.3, slope - 0.7, bend + 0.4];
        for error in errors {
            assert!(error.abs().max_element() < TOLERANCE, "{error}");
        }
    }

    #[test]
    fn a_part_is_the_cubic_on_it() {
        let whole = LaneCubic::through(SAMPLE_POSITIONS.map(cubic));
        let part = whole.part(0.3, 0.45);
        for step in 0..=20 {
            let x = step as f32 / 20.0;
            let error = part.at(x) - cubic(0.3 + 0.45 * x);
            assert!(error.abs().max_element() < TOLERANCE);
        }
        assert_eq!(whole.part(0.0, 1.0).at(0.37), whole.at(0.37));
    }

    #[test]
    fn a_constant_stays_exactly_constant() {
        let value = Vec4::new(0.1, 1.0e7, 3.3e-5, 0.7);
        let fitted = LaneCubic::through([value; 4]);
        assert_eq!(fitted.at(0.37), value);
        assert_eq!(m2_up_to(&fitted, 1.0), f64::from(value.x));
    }
}
