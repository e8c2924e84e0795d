//! Glory and corona: the light around the antisolar point and the sun that only exact theories have.
//!
//! Corona: the pattern of a round hole as large as the drop, without its rings,
//!   t(theta) = (x^2/(4 pi)) / (1 + (pi/4) u^3),  u = x theta,  x = 2 pi r/lambda,
//! which is the peak x^2/(4 pi) [2 J1(u)/u]^2 at u = 0 and the mean of that far from it,
//! J1(u)^2 -> 1/(pi u): 1/(pi^2 x theta^3). [BH83] Bohren and Huffman, Absorption and Scattering of
//! Light by Small Particles, Wiley (1983), eq. 4.73.
//! Glory: the exact light within 15 degrees of 180 less that of the orders that theories of bows have.
//! Its rings lie at u = x (pi - theta) of a few, so that drops above some size hide them in the sun's
//! disc; the first stands at u = 3.05, where J2(u)^2 is largest (van de Hulst, Light Scattering by Small
//! Particles, Wiley (1957), section 13.3). It belongs to light reflected once inside the drop. [La05]
//! Laven, Appl. Opt. 44, 5675-5683 (2005).

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_scatter::Theory;
use niji_sizes::gamma_area_quadrature;

use crate::effect::Effect;

use super::bow_light::Line;

/// Where the glory begins, rad.
pub(super) const GLORY_RAD: f64 = 165.0 * PI / 180.0;

/// Where the corona ends, rad.
pub(super) const CORONA_RAD: f64 = 15.0 * PI / 180.0;

/// Larger drops have a glory within 0.3 degrees of the antisolar point, where the sun's disc blurs it.
const LARGEST_GLORY_UM: f64 = 60.0;

/// A law this narrow stands for one size: it spreads as many sizes as a bin of light spreads x.
const NARROWEST_VARIANCE: f64 = 1e-4;

/// Sizes that stand for a law: enough for an envelope, not for a table.
const N_SIZES: usize = 8;

/// Steps of angle and of radius across a ring, over 1/x.
const STEP: f64 = 0.25;

/// The rings that a table of a theory holds when these effects are on.
pub(super) fn held(theory: Theory, on: &BTreeSet<Effect>) -> Vec<Effect> {
    let is_on = |effect: Effect| on.contains(&effect);
    // Without fringes a table is made of rays.
    if !is_on(Effect::Supernumeraries) {
        return Vec::new();
    }
    let held = |effect: Effect, carrier: Effect| is_on(carrier).then_some(effect);
    let of_orders = [
        held(Effect::Glory, Effect::PrimaryBow),
        held(Effect::Corona, Effect::HigherOrders),
    ];
    match theory {
        Theory::Mie | Theory::BySize => {
            // It has all orders, but no table is made for none of them.
            let carriers = [
                Effect::PrimaryBow,
                Effect::SecondaryBow,
                Effect::HigherOrders,
            ];
            if carriers.into_iter().any(is_on) {
                vec![Effect::Glory, Effect::Corona]
            } else {
                Vec::new()
            }
        }
        Theory::Debye { .. } => of_orders.into_iter().flatten().collect(),
        Theory::GeometricPublished
        | Theory::Geometric
        | Theory::AiryPublished
        | Theory::Airy
        | Theory::Uniform => Vec::new(),
    }
}

/// Exact light of a law of sizes in one line at angles within the glory, natural light, 1/sr; zeros
/// elsewhere and for drops whose rings are too narrow to be seen.
pub(super) fn exact_glory(
    (radius_um, variance): (f64, f64),
    line: &Line,
    water: Water,
    theta_rad: &[f64],
) -> Vec<f64> {
    let mut light = vec![0.0; theta_rad.len()];
    let first = theta_rad.partition_point(|theta| *theta < GLORY_RAD);
    let (Some(low), Some(high)) = (theta_rad.get(first), theta_rad.last()) else {
        return light;
    };
    let law = gamma_area_quadrature(
        Micrometers(radius_um),
        variance.max(NARROWEST_VARIANCE),
        N_SIZES,
    );
    let sizes = law.unwrap_or_default();
    let largest_um = sizes.last().map_or(0.0, |(radius, _)| *radius);
    if radius_um > LARGEST_GLORY_UM || largest_um <= 0.0 {
        return light;
    }
    let index = water.refractive_index(line.wavelength);
    let coarse = coarse_angles((*low, *high), TAU * 1e3 * largest_um / line.wavelength.0);
    let Ok(angles) = ScatteringAngles::new(&coarse) else {
        return light;
    };
    let mut mean = vec![0.0; coarse.len()];
    for (radius, weight) in sizes {
        let sphere = Sphere::from_radius(
            Micrometers(radius),
            line.wavelength,
            RefractiveIndex::from(index),
        );
        // A drop too small for the series has no rings.
        let Ok(sphere) = sphere else { continue };
        let both = sphere.waves().normalized_cross_sections(&angles);
        for (sum, [s, p]) in mean.iter_mut().zip(both) {
            *sum += weight * 0.5 * (s + p);
        }
    }
    let step = (high - low) / (coarse.len() as f64 - 1.0);
    for (value, theta) in light.iter_mut().zip(theta_rad).skip(first) {
        let place = ((theta - low) / step).clamp(0.0, coarse.len() as f64 - 1.0);
        let lower = (place as usize).min(coarse.len() - 2);
        let part = place - lower as f64;
        *value = mean[lower] * (1.0 - part) + mean[lower + 1] * part;
    }
    light
}

/// Angles as close as the rings of the largest drop ask for, both ends included.
fn coarse_angles((low, high): (f64, f64), x: f64) -> Vec<Radians> {
    let n_steps = ((high - low) * x / STEP).ceil().max(1.0);
    (0..=n_steps as usize)
        .map(|index| Radians((low + (high - low) * index as f64 / n_steps).min(PI)))
        .collect()
}

/// Diffracted light of drops of one size, 1/sr.
pub(super) fn diffracted(radius_um: f64, line: &Line, theta_rad: f64) -> f64 {
    let x = TAU * 1e3 * radius_um / line.wavelength.0;
    let u = x * theta_rad;
    x * x / (4.0 * PI) / (1.0 + 0.25 * PI * u.powi(3))
}

#[cfg(test)]
mod tests {
    use niji_radiometry::Nanometers;

    use super::*;

    const WATER: Water = Water::pure(15.0);

    fn line() -> Line {
        Line {
            index: 0,
            wavelength: Nanometers(650.0),
            width: Nanometers(10.0),
            weight: 1.0,
        }
    }

    #[test]
    fn the_first_ring_of_the_glory_is_the_largest_of_the_bessel_function_of_order_two() {
        let theta: Vec<f64> = (0..=200).map(|i| PI - 1e-3 * f64::from(200 - i)).collect();
        let light = exact_glory((10.0, 0.01), &line(), WATER, &theta);
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
    fn drops_of_rain_have_no_glory_that_the_sun_does_not_blur() {
        let theta = [PI - 0.1, PI - 0.01, PI];
        assert_eq!(exact_glory((300.0, 0.1), &line(), WATER, &theta), [0.0; 3]);
        assert_eq!(
            exact_glory((10.0, 0.1), &line(), WATER, &[1.0, 2.0]),
            [0.0; 2]
        );
    }

    #[test]
    fn diffraction_is_that_of_the_exact_light_near_the_sun() {
        let (radius_um, line) = (20.0, line());
        let index = WATER.refractive_index(line.wavelength);
        let theta = [0.0, 1.0_f64.to_radians(), 2.0_f64.to_radians()];
        let angles = ScatteringAngles::new(&theta.map(Radians)).unwrap();
        let law = gamma_area_quadrature(Micrometers(radius_um), 0.1, 64).unwrap();
        let mut exact = [0.0; 3];
        for (radius, weight) in law {
            let index = RefractiveIndex::from(index);
            let sphere = Sphere::from_radius(Micrometers(radius), line.wavelength, index).unwrap();
            let light = sphere.waves().normalized_cross_sections(&angles);
            for (sum, [s, p]) in exact.iter_mut().zip(light) {
                *sum += weight * 0.5 * (s + p);
            }
        }
        // Rays through the drop add to it; at 0 the spread of sizes does.
        for (exact, theta) in exact.into_iter().zip(theta) {
            let ratio = diffracted(radius_um, &line, theta) / exact;
            assert!((0.4..1.3).contains(&ratio), "{theta}: {ratio}");
        }
    }

    #[test]
    fn only_exact_theories_hold_rings() {
        let all: BTreeSet<Effect> = Effect::ALL.into_iter().collect();
        for theory in [Theory::Mie, Theory::BySize] {
            assert_eq!(held(theory, &all), [Effect::Glory, Effect::Corona]);
        }
        let debye = Theory::Debye { max_order: 7 };
        let mut less = all.clone();
        less.remove(&Effect::HigherOrders);
        assert_eq!(held(debye, &less), [Effect::Glory]);
        less.remove(&Effect::Supernumeraries);
        assert!(held(debye, &less).is_empty() && held(Theory::Mie, &less).is_empty());
        assert!(held(Theory::Uniform, &all).is_empty());
    }
}
