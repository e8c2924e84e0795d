//! The path of a ray of order p through a drop.
//!
//! D(i) = 2 i − 2 p r + (p − 1) π,   dD/di = 2 − 2 p cos i/(n cos r),   n sin r = sin i
//! G(i) = 2 p n cos r − 2 cos i,   dG/di = sin i dD/di
//! `i` angle of incidence, `r` of refraction, `n` index relative to the air, `D` deviation, `G` optical
//! path in radii of the drop against that through its center. p = 0 is reflected outside, p = 1 goes
//! straight through, p >= 2 is reflected p − 1 times inside. Real for 0 <= i <= π/2; on the dark side
//! of a bow, where no ray arrives, the same formulas hold for a complex `i`.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, ch. 12.22 (1957).

use std::f64::consts::PI;

use num_complex::Complex64;
use num_complex::ComplexFloat;

use crate::fresnel::order_amplitudes;

/// An angle of incidence: `f64`, or complex where there is no real ray.
pub(crate) trait Incidence: ComplexFloat<Real = f64> + From<f64> {
    /// A real number of the same type.
    fn real(value: f64) -> Self {
        value.into()
    }

    /// Sine and cosine at once.
    fn sine_and_cosine(self) -> [Self; 2];

    /// The angle of a sine and a cosine, whose real part is not negative.
    fn angle(sine_and_cosine: [Self; 2]) -> Self;
}

impl Incidence for f64 {
    fn sine_and_cosine(self) -> [f64; 2] {
        self.sin_cos().into()
    }

    fn angle([sine, _]: [f64; 2]) -> f64 {
        sine.asin()
    }
}

impl Incidence for Complex64 {
    /// Four functions of real numbers serve both.
    fn sine_and_cosine(self) -> [Complex64; 2] {
        let (sin, cos) = self.re.sin_cos();
        let (sinh, cosh) = (self.im.sinh(), self.im.cosh());
        [
            Complex64::new(sin * cosh, cos * sinh),
            Complex64::new(cos * cosh, -sin * sinh),
        ]
    }

    /// −i ln(cos r + i sin r), without the root that an inverse sine would take again.
    fn angle([sine, cosine]: [Complex64; 2]) -> Complex64 {
        let turned = (cosine + Complex64::new(-sine.im, sine.re)).ln();
        Complex64::new(turned.im, -turned.re)
    }
}

/// All rays of one order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayPath {
    /// Refractive index of the drop relative to the air.
    pub(crate) n: f64,
    /// Order.
    pub(crate) p: u32,
}

/// One ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray<T> {
    path: RayPath,
    /// D in radians, not folded.
    pub(crate) deviation: T,
    /// dD/di.
    pub(crate) slope: T,
    pub(crate) sin_incidence: T,
    pub(crate) cos_incidence: T,
    cos_refraction: T,
}

impl RayPath {
    pub(crate) fn ray<T: Incidence>(self, incidence: T) -> Ray<T> {
        let (n, order) = (T::real(self.n), T::real(f64::from(self.p)));
        let (one, two) = (T::one(), T::real(2.0));
        let [sin_incidence, cos_incidence] = incidence.sine_and_cosine();
        let sin_refraction = sin_incidence / n;
        let cos_refraction = (one - sin_refraction * sin_refraction).sqrt();
        Ray {
            path: self,
            deviation: two * incidence - two * order * T::angle([sin_refraction, cos_refraction])
                + (order - one) * T::real(PI),
            slope: two - two * order * cos_incidence / (n * cos_refraction),
            sin_incidence,
            cos_incidence,
            cos_refraction,
        }
    }
}

impl<T: Incidence> Ray<T> {
    /// G, dimensionless.
    pub(crate) fn optical_path(&self) -> T {
        let [n, order, two] = [self.path.n, f64::from(self.path.p), 2.0].map(T::real);
        two * order * n * self.cos_refraction - two * self.cos_incidence
    }

    /// ε_s and ε_p.
    pub(crate) fn amplitudes(&self) -> [T; 2] {
        let RayPath { n, p } = self.path;
        order_amplitudes(n, p, self.cos_incidence, self.cos_refraction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Error of a central difference of step 1e-5 over the value; measured worst 5.5e-10.
    const DIFFERENCE_TOLERANCE: f64 = 2e-9;

    #[test]
    fn slopes_are_the_derivatives_of_deviation_and_optical_path() {
        for p in 0..=7 {
            let path = RayPath { n: 1.333, p };
            for incidence in [
                Complex64::new(0.3, 0.0),
                Complex64::new(1.2, 0.0),
                Complex64::new(1.1, 0.4),
            ] {
                let step = 1e-5;
                let (before, at, after) = (
                    path.ray(incidence - step),
                    path.ray(incidence),
                    path.ray(incidence + step),
                );
                let slope = (after.deviation - before.deviation) / (2.0 * step);
                let rise = (after.optical_path() - before.optical_path()) / (2.0 * step);
                assert!((slope - at.slope).norm() < DIFFERENCE_TOLERANCE * at.slope.norm());
                let expected = at.sin_incidence * at.slope;
                assert!((rise - expected).norm() < DIFFERENCE_TOLERANCE * expected.norm());
            }
        }
    }

    #[test]
    fn the_central_ray_is_turned_back_by_every_reflection() {
        for p in 0..=7 {
            let ray = RayPath { n: 1.333, p }.ray(0.0);
            assert!((ray.deviation - (f64::from(p) - 1.0) * PI).abs() < 1e-15);
        }
    }

    #[test]
    fn real_rays_are_the_complex_ones_on_the_real_axis() {
        let path = RayPath { n: 1.333, p: 3 };
        let (real, complex) = (path.ray(1.1), path.ray(Complex64::new(1.1, 0.0)));
        assert!((complex.deviation - real.deviation).norm() < 1e-15);
        assert!((complex.optical_path() - real.optical_path()).norm() < 1e-14);
        for (complex, real) in complex.amplitudes().into_iter().zip(real.amplitudes()) {
            assert!((complex - real).norm() < 1e-15);
        }
    }
}
