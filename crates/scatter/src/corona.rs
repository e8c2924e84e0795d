//! The corona: light that drops diffract around the sun.
//!
//! t(θ) = (x²/(4π)) / (1 + (π/4) u³),   u = x θ,   x = 2π r/λ
//! the pattern of a round hole as large as the drop, without its rings: the peak of
//! x²/(4π) [2 J1(u)/u]² at u = 0 and the mean of that far from it, J1(u)² → 1/(π u): 1/(π² x θ³). `t` in
//! 1/sr over the drop's shadow, `θ` scattering angle, `r` radius, `λ` wavelength. None beyond 15 degrees.
//! [BH83] C. F. Bohren and D. R. Huffman, Absorption and Scattering of Light by Small Particles, Wiley
//! (1983), eq. 4.73.

use std::f64::consts::PI;

/// Where it ends.
const END_RAD: f64 = 15.0 * PI / 180.0;

/// t of drops of the size parameter `x`, 1/sr.
pub(crate) fn corona(x: f64, theta_rad: f64) -> f64 {
    if theta_rad > END_RAD {
        return 0.0;
    }
    let u = x * theta_rad;
    x * x / (4.0 * PI) / (1.0 + 0.25 * PI * u.powi(3))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use niji_mie::RefractiveIndex;
    use niji_mie::ScatteringAngles;
    use niji_mie::Sphere;
    use niji_radiometry::Micrometers;
    use niji_radiometry::Nanometers;
    use niji_radiometry::Radians;
    use niji_sizes::gamma_area_quadrature;

    use niji_radiometry::size_parameter;

    use super::*;

    #[test]
    fn the_pattern_holds_the_light_that_a_drop_diffracts() {
        // All of it is one shadow's worth; the rounded pattern has 4/sqrt(27) (4/π)^(2/3) π/2 ... of it.
        let x = 500.0;
        let n = 200_000;
        let step = END_RAD / f64::from(n);
        let light: f64 = (0..n)
            .map(|i| step * (f64::from(i) + 0.5))
            .map(|theta| TAU * theta.sin() * corona(x, theta) * step)
            .sum();
        // int u du/(1 + c u³) = (2π/(3 sqrt 3)) c^(-2/3), half of it the share.
        let expected = 0.5 * TAU / (3.0 * 3.0_f64.sqrt()) * (0.25 * PI).powf(-2.0 / 3.0);
        assert!((light / expected - 1.0).abs() < 0.02, "{light} {expected}");
    }

    #[test]
    fn it_is_the_exact_light_near_the_sun() {
        let (radius_um, wavelength) = (20.0, Nanometers(650.0));
        let theta = [0.0, 1.0_f64.to_radians(), 2.0_f64.to_radians()];
        let angles = ScatteringAngles::new(&theta.map(Radians)).unwrap();
        let law = gamma_area_quadrature(Micrometers(radius_um), 0.1, 64).unwrap();
        let mut exact = [0.0; 3];
        for (radius, weight) in law {
            let index = RefractiveIndex::from(1.331);
            let sphere = Sphere::from_radius(Micrometers(radius), wavelength, index).unwrap();
            let light = sphere.waves().normalized_cross_sections(&angles);
            for (sum, [s, p]) in exact.iter_mut().zip(light) {
                *sum += weight * 0.5 * (s + p);
            }
        }
        // Rays through the drop add to it; at 0 the spread of sizes does.
        let x = size_parameter(Micrometers(radius_um), wavelength);
        for (exact, theta) in exact.into_iter().zip(theta) {
            let ratio = corona(x, theta) / exact;
            assert!((0.4..1.3).contains(&ratio), "{theta}: {ratio}");
        }
    }

    #[test]
    fn far_from_the_sun_there_is_none() {
        assert_eq!(corona(1e3, 0.3), 0.0);
        assert!(corona(1e3, 0.0) > 7e4);
    }
}
