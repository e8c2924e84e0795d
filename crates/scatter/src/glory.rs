//! The glory: exact light around the antisolar point, by few sizes.
//!
//! t(θ) = Σ_i w_i t(θ; r_i) from 165 degrees on
//! `t` of the exact solution in natural light (1/sr), `w_i` share of the cross-section at `r_i`. Its rings lie
//! at u = x (π − θ) of a few, the first at u = 3.05, where J2(u)² is largest, so that drops above some size
//! hide them in the sun's disc: of those there is none here. They belong to light reflected once inside the
//! drop [La05], which theories of bows do not focus at the axis.
//! [vdH57] H. C. van de Hulst, Light Scattering by Small Particles, Wiley (1957), section 13.3. [La05] P.
//! Laven, Appl. Opt. 44, 5675-5683 (2005).

use std::f64::consts::PI;

use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;
use niji_sizes::gamma_area_quadrature;

use crate::bow_light::Bin;
use crate::order_light::natural;

/// Where the glory begins, as a scattering angle (rad).
pub const GLORY_START_RAD: f64 = 165.0 * PI / 180.0;
/// Larger drops have it within 0.3 degrees of the antisolar point, where the sun's disc blurs it (µm).
pub const GLORY_LARGEST_UM: f64 = 60.0;
/// A law this narrow stands for one size: it spreads as many sizes as a bin of light spreads x.
const NARROWEST_VARIANCE: f64 = 1e-4;
/// Sizes that stand for a law: enough for an envelope, not for a table.
const N_SIZES: usize = 8;

/// t in 1/sr at ascending scattering angles, of a law by its effective radius (µm) and effective variance.
pub(crate) fn glory((radius_um, variance): (f64, f64), bin: Bin, theta_rad: &[f64]) -> Vec<f64> {
    let mut light = vec![0.0; theta_rad.len()];
    let lit = theta_rad.iter().map(|theta| Radians(*theta));
    let lit: Vec<Radians> = lit.filter(|theta| theta.0 >= GLORY_START_RAD).collect();
    let Ok(angles) = ScatteringAngles::new(&lit) else {
        return light;
    };
    if lit.is_empty() || radius_um > GLORY_LARGEST_UM {
        return light;
    }
    let first = light.len() - lit.len();
    let variance = variance.max(NARROWEST_VARIANCE);
    let law = gamma_area_quadrature(Micrometers(radius_um), variance, N_SIZES);
    for (radius, weight) in law.unwrap_or_default() {
        let index = RefractiveIndex::from(bin.index);
        let sphere = Sphere::from_radius(Micrometers(radius), bin.center, index);
        // A drop too small for the series has no rings.
        let Ok(sphere) = sphere else { continue };
        let both = sphere.waves().normalized_cross_sections(&angles);
        for (sum, both) in light[first..].iter_mut().zip(both) {
            *sum += weight * natural(both);
        }
    }
    light
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use niji_radiometry::Nanometers;

    use super::*;

    fn at(law: (f64, f64), theta_rad: &[f64]) -> Vec<f64> {
        let bin = Bin {
            center: Nanometers(650.0),
            width: Nanometers(10.0),
            index: 1.331,
        };
        glory(law, bin, theta_rad)
    }

    #[test]
    fn the_first_ring_is_the_largest_of_the_bessel_function_of_order_two() {
        let theta: Vec<f64> = (0..=200).map(|i| PI - 1e-3 * f64::from(200 - i)).collect();
        let light = at((10.0, 0.01), &theta);
        let ring = (0..190).filter(|i| (1.2..3.0).contains(&(PI - theta[*i]).to_degrees()));
        let brightest = ring.max_by(|a, b| light[*a].total_cmp(&light[*b])).unwrap();
        // van de Hulst (1957), section 13.3: J2(u) is largest at u = 3.054.
        let expected_rad = 3.054 / (TAU * 10.0 / 0.65);
        let found_rad = PI - theta[brightest];
        assert!(
            (found_rad / expected_rad - 1.0).abs() < 0.07,
            "{found_rad} {expected_rad}"
        );
    }

    #[test]
    fn drops_of_rain_have_none_that_the_sun_does_not_blur() {
        let theta = [PI - 0.1, PI - 0.01, PI];
        assert_eq!(at((300.0, 0.1), &theta), [0.0; 3]);
        assert_eq!(at((10.0, 0.1), &[1.0, 2.0]), [0.0; 2]);
        assert!(at((10.0, 0.1), &theta).iter().all(|light| *light > 0.0));
    }

    #[test]
    fn each_angle_has_its_own_light() {
        let several = at((10.0, 0.1), &[2.0, PI - 1e-3, PI]);
        assert_eq!(several[0], 0.0);
        assert_eq!(at((10.0, 0.1), &[PI]), several[2..]);
        assert!(at((10.0, 0.1), &[]).is_empty());
    }
}
