use std::f64::consts::TAU;

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;

use super::*;
use crate::airy::AiryBow;
use crate::airy_integral::airy_squares;

const WATER: f64 = 1.3312;

/// Everything of a direction that depends on the deviation alone, next to the caustic or a seam.
fn numbers(bow: &UniformBow, beyond_rad: f64) -> [f64; 6] {
    let pair = bow.pair(beyond_rad);
    let [even_s, even_p] = pair.even;
    let [odd_s, odd_p] = pair.odd;
    let argument = pair.argument(beyond_rad);
    [pair.stretch, even_s, even_p, odd_s, odd_p, argument]
}

/// Relative step from one side of a seam to the other, 2e-12 rad apart; measured worst 4.8e-11.
const SEAM_TOLERANCE: f64 = 2e-10;

#[test]
fn the_caustic_and_the_ends_of_the_series_are_no_seams() {
    for (n, p) in [
        (WATER, 2),
        (WATER, 3),
        (WATER, 5),
        (WATER, 7),
        (1.2, 2),
        (1.6, 2),
        (1.9, 2),
    ] {
        let bow = UniformBow::new(n, p).unwrap();
        for seam in [-bow.series_rad, 0.0, bow.series_rad] {
            let before = numbers(&bow, seam - 1e-12);
            let after = numbers(&bow, seam + 1e-12);
            let largest = before[1].abs().max(before[3].abs());
            for (before, after) in before.into_iter().zip(after) {
                let off = (after - before).abs() / largest.max(before.abs());
                assert!(
                    off < SEAM_TOLERANCE,
                    "n = {n}, p = {p}, d = {seam}: {off:e}"
                );
            }
        }
    }
}

/// Relative difference of series and rays where both hold; measured worst 2.8e-10.
const SERIES_TOLERANCE: f64 = 1e-9;

#[test]
fn the_series_is_the_one_of_the_rays_on_both_sides() {
    for p in 2..=7 {
        let bow = UniformBow::new(WATER, p).unwrap();
        for part in [-0.9, -0.5, -0.2, 1.0, 1.05, 1.1] {
            let beyond_rad = part * bow.series_rad;
            let series = bow.near_caustic(beyond_rad);
            let rays = if part < 0.0 {
                bow.dark_side(beyond_rad)
            } else {
                bow.bright_side(beyond_rad)
            };
            assert!((series.stretch / rays.stretch - 1.0).abs() < SERIES_TOLERANCE);
            for j in 0..2 {
                let scale = rays.even[0].abs();
                assert!((series.even[j] - rays.even[j]).abs() < SERIES_TOLERANCE * scale);
                assert!((series.odd[j] - rays.odd[j]).abs() < SERIES_TOLERANCE * scale);
            }
        }
    }
}

/// Relative difference from the closed forms at the rainbow ray; measured worst 4.2e-14.
const CAUSTIC_TOLERANCE: f64 = 2e-13;

#[test]
fn at_the_rainbow_ray_it_is_airys_theory_with_its_derivative() {
    for p in 2..=7 {
        let (uniform, airy) = (
            UniformBow::new(WATER, p).unwrap(),
            AiryBow::new(WATER, p).unwrap(),
        );
        let theta = Radians(uniform.ray().theta_rad());
        let (uniform, airy) = (uniform.direction(theta), airy.direction(theta));
        for j in 0..2 {
            for (found, expected) in [
                (uniform.strength[j], airy.strength[j]),
                (uniform.derivative_strength[j], airy.derivative_strength[j]),
            ] {
                let off = (found / expected - 1.0).abs();
                assert!(off < CAUSTIC_TOLERANCE, "p = {p}: off by {off:e}");
            }
        }
    }
}

#[test]
fn the_phase_at_the_caustic_has_the_curvature_of_the_wavefront() {
    // ζ = (x²/h)^(1/3) d.
    for p in 2..=7 {
        let bow = UniformBow::new(WATER, p).unwrap();
        let stretch = bow.near_caustic(0.0).stretch;
        assert!((stretch * stretch * bow.ray.wavefront_h - 1.0).abs() < CAUSTIC_TOLERANCE);
    }
}

/// Relative difference of the two, near the polarising angle where p has almost gone; measured worst 6.4e-8.
const FRINGE_TOLERANCE: f64 = 3e-7;

#[test]
fn the_mean_of_the_fringes_is_the_light_of_both_rays() {
    // Ai² and Ai'² have the means 1/(2π sqrt(ζ)) and sqrt(ζ)/2π: t = 2 (E² + d O²)/(π sin θ sqrt(d)).
    for p in 2..=7 {
        let bow = UniformBow::new(WATER, p).unwrap();
        for part in [0.02, 0.2, 0.5, 0.79] {
            let beyond_rad = part * bow.fading_rad.1;
            let pair = bow.pair(beyond_rad);
            let theta_rad = bow.ray.theta_rad() + bow.ray.bright_side() * beyond_rad;
            let rays = bow
                .rays
                .at_deviation(bow.ray.deviation_rad + beyond_rad, theta_rad);
            for (mean, ray) in pair
                .light_of_both(beyond_rad, theta_rad)
                .into_iter()
                .zip(rays)
            {
                assert!(
                    (mean / ray - 1.0).abs() < FRINGE_TOLERANCE,
                    "p = {p}, {part}: {mean} {ray}"
                );
            }
        }
    }
}

#[test]
fn the_argument_rises_with_the_deviation_from_axis_to_axis() {
    for n in [1.05, 1.2, WATER, 1.5, 1.9] {
        for p in 2..=7 {
            let bow = UniformBow::new(n, p).unwrap();
            let mut before = f64::NEG_INFINITY;
            for step in 0..=1800 {
                let part = PI * f64::from(step) / 1800.0;
                let up = bow.ray.bright_side() > 0.0;
                let argument = bow.argument(Radians(if up { part } else { PI - part }));
                assert!(
                    argument > before,
                    "n = {n}, p = {p}, {part} rad: {argument}"
                );
                before = argument;
            }
        }
    }
}

#[test]
fn every_direction_index_order_and_size_is_finite_and_not_negative() {
    for n in [1.000_3, 1.05, 1.2, WATER, 1.5, 1.9, 1.999] {
        for p in 2..=7 {
            let bow = UniformBow::new(n, p).unwrap();
            for step in -2..=3602 {
                // A little beyond either axis too, where rounding may lead.
                let theta = Radians((PI * f64::from(step) / 3600.0).clamp(-1e-16, PI + 1e-15));
                let direction = bow.direction(theta);
                for radius_um in [1.0, 1500.0] {
                    let (radius, wavelength) = (Micrometers(radius_um), Nanometers(650.0));
                    for t in direction.normalized_cross_section(radius, wavelength, airy_squares) {
                        let is_right = t.is_finite() && t >= 0.0;
                        assert!(is_right, "n = {n}, p = {p}, {theta:?}: {t}, {direction:?}");
                    }
                }
            }
        }
    }
}

/// Relative difference of rays at nodes and by Newton's rule; measured worst 1.6e-10.
const RAYS_TOLERANCE: f64 = 1e-9;

#[test]
fn past_the_grazing_ray_a_single_ray_is_left_and_nothing_jumps() {
    for p in 2..=7 {
        let bow = UniformBow::new(WATER, p).unwrap();
        let (grazing_rad, faded_rad) = bow.fading_rad;
        let at = |beyond_rad: f64| {
            let theta = Radians(bow.ray.theta_rad() + bow.ray.bright_side() * beyond_rad);
            let (radius, wavelength) = (Micrometers(500.0), Nanometers(650.0));
            let rays = bow.rays.normalized_cross_section(theta);
            let direction = bow.direction(theta);
            let wave = direction.normalized_cross_section(radius, wavelength, airy_squares);
            (direction, wave, rays)
        };
        let (direction, wave, rays) = at(faded_rad + 1e-9);
        assert_eq!(direction.strength, [0.0; 2]);
        assert_eq!(direction.derivative_strength, [0.0; 2]);
        for j in 0..2 {
            let off = (wave[j] / rays[j] - 1.0).abs();
            assert!(off < RAYS_TOLERANCE, "p = {p}: {off:e}");
        }
        for seam in [grazing_rad, faded_rad] {
            let (before, after) = (at(seam - 1e-9).1, at(seam + 1e-9).1);
            for j in 0..2 {
                assert!((after[j] / before[j] - 1.0).abs() < 1e-5, "p = {p}");
            }
        }
        // In between the second ray has gone, and what is left of the fringes is (1/6)/ζ^(3/2).
        let (direction, wave, rays) = at(0.5 * (grazing_rad + faded_rad));
        let zeta = direction.argument * (TAU / 1.3e-3).powf(2.0 / 3.0);
        for j in 0..2 {
            let off = (wave[j] / rays[j] - 1.0).abs();
            assert!(
                off < 0.2 * zeta.powf(-1.5) + 1e-9,
                "p = {p}: {off:e}, {zeta}"
            );
        }
    }
}

#[test]
fn what_is_not_a_direction_gives_what_is_not_a_number() {
    let bow = UniformBow::new(WATER, 2).unwrap();
    assert!(bow.argument(Radians(f64::NAN)).is_nan());
    assert!(bow.direction(Radians(f64::NAN)).strength[0].is_nan());
    for (n, p) in [
        (f64::NAN, 2),
        (f64::INFINITY, 2),
        (1.0, 2),
        (2.0, 2),
        (1.333, 1),
        (1.333, 0),
    ] {
        assert_eq!(UniformBow::new(n, p), None);
    }
}

#[test]
fn without_the_darkest_light_all_other_is_the_same() {
    for p in 2..=4 {
        let whole = UniformBow::new(WATER, p).unwrap();
        // Drops of 30 µm at 650 nm, down to z = −9.
        let scale = (TAU * 30.0 / 0.65).powf(2.0 / 3.0);
        let above = whole.clone().above(-9.0 / scale);
        let (mut n_dark, mut brightest) = (0, 0.0_f64);
        for step in 0..=3600 {
            let theta = Radians(PI * f64::from(step) / 3600.0);
            let (whole, above) = (whole.direction(theta), above.direction(theta));
            assert_eq!(above.rays, whole.rays);
            if above.strength == [0.0; 2] && whole.strength != [0.0; 2] {
                let (radius, wavelength) = (Micrometers(30.0), Nanometers(650.0));
                let light = whole.normalized_cross_section(radius, wavelength, airy_squares);
                n_dark += 1;
                brightest = brightest.max(light[0] - whole.rays[0]);
            } else {
                assert_eq!(above, whole);
            }
        }
        assert!(
            n_dark > 0 && brightest < 1e-12,
            "p = {p}: {n_dark}, {brightest:e}"
        );
    }
}
