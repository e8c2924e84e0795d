//! Where theories of the bow usually break: far inside, past the grazing ray, on the axis, in the dark.

use std::f64::consts::PI;

use niji_airy::AiryBow;
use niji_airy::BowDirection;
use niji_airy::GeometricOrder;
use niji_airy::UniformBow;
use niji_airy::airy_squares;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;

const WATER: f64 = 1.3312;
const RED: Nanometers = Nanometers(650.0);

/// A theory by direction.
type Theory = Box<dyn Fn(Radians) -> BowDirection>;

fn theories(p: u32) -> [(&'static str, Theory); 2] {
    let airy = AiryBow::new(WATER, p).expect("water has bows of every order");
    let uniform = UniformBow::new(WATER, p).expect("water has bows of every order");
    [
        ("Airy", Box::new(move |theta| airy.direction(theta))),
        ("uniform", Box::new(move |theta| uniform.direction(theta))),
    ]
}

fn unpolarized(direction: BowDirection, radius_um: f64) -> f64 {
    let [s, p] = direction.normalized_cross_section(Micrometers(radius_um), RED, airy_squares);
    0.5 * (s + p)
}

/// Difference of the means over the fringes from the rays; measured worst 0.0054.
const MEAN_TOLERANCE: f64 = 0.01;

#[test]
fn far_inside_the_bow_the_fringes_average_to_the_rays() {
    let primary = (140..180).map(f64::from).chain([179.9]);
    let secondary = (60..129).map(f64::from);
    let places = primary
        .map(|deg| (2, deg))
        .chain(secondary.map(|deg| (3, deg)));
    let theories = [2, 3].map(theories);
    let rays = [2, 3].map(|p| GeometricOrder::new(WATER, p).unwrap());
    for (p, center_deg) in places {
        // A Hann window.
        let half_deg = 1.2_f64.min(180.0 - center_deg);
        let window = (-600..600).map(|step| {
            let part = f64::from(step) / 600.0;
            let theta = Radians::from_degrees(center_deg + half_deg * part);
            ((0.5 * PI * part).cos().powi(2), theta)
        });
        let rays: f64 = window
            .clone()
            .map(|(weight, theta)| {
                let [s, parallel] = rays[p - 2].normalized_cross_section(theta);
                0.5 * weight * (s + parallel)
            })
            .sum();
        for (name, theory) in &theories[p - 2] {
            let wave: f64 = window
                .clone()
                .map(|(weight, theta)| weight * unpolarized(theory(theta), 1500.0))
                .sum();
            let off = (wave / rays - 1.0).abs();
            assert!(
                off < MEAN_TOLERANCE,
                "{name}, p = {p}, {center_deg} deg: off by {off}"
            );
        }
    }
}

#[test]
fn past_the_grazing_ray_every_theory_is_the_single_ray() {
    // The grazing ray of p = 2 leaves at 165.2 degrees, that of p = 3 at 112.2.
    for (p, degrees) in [(2, [173.0, 176.0, 179.9]), (3, [107.0, 90.0, 30.0])] {
        let rays = GeometricOrder::new(WATER, p).unwrap();
        for theta_deg in degrees {
            let theta = Radians::from_degrees(theta_deg);
            let [s, parallel] = rays.normalized_cross_section(theta);
            for (name, theory) in theories(p) {
                let found = unpolarized(theory(theta), 100.0);
                let off = (found / (0.5 * (s + parallel)) - 1.0).abs();
                assert!(
                    off < 1e-12,
                    "{name}, p = {p}, {theta_deg} deg: off by {off:e}"
                );
            }
        }
    }
}

#[test]
fn on_the_axis_and_beside_it_every_order_is_finite() {
    for p in 0..=7 {
        let rays = GeometricOrder::new(WATER, p).unwrap();
        for theta_deg in [0.0, 1e-7, 0.1, 90.0, 179.9, 179.999_999_9, 180.0] {
            let theta = Radians::from_degrees(theta_deg);
            for t in rays.normalized_cross_section(theta) {
                assert!(
                    t.is_finite() && t >= 0.0,
                    "rays, p = {p}, {theta_deg} deg: {t}"
                );
            }
            if p < 2 {
                continue;
            }
            for (name, theory) in theories(p) {
                for radius_um in [1.0, 10.0, 1500.0] {
                    let t = unpolarized(theory(theta), radius_um);
                    assert!(
                        t.is_finite() && t >= 0.0,
                        "{name}, p = {p}, {theta_deg}: {t}"
                    );
                }
            }
        }
    }
}

#[test]
fn deep_in_the_dark_the_theories_fall_on_to_the_end_of_f64() {
    // In Alexander's band 8 degrees from the primary bow: drops of 100 µm to 1.5 mm.
    for (name, theory) in theories(2) {
        let direction = theory(Radians::from_degrees(130.0));
        let mut before = f64::INFINITY;
        for radius_um in [100.0, 200.0, 400.0, 800.0, 1500.0] {
            let t = unpolarized(direction, radius_um);
            assert!(
                t > 0.0 && t < 1e-9 * before,
                "{name}, {radius_um} um: {t:e}"
            );
            before = t;
        }
    }
}

#[test]
fn a_direction_that_is_not_a_number_is_not_an_endless_loop() {
    for p in [2, 3, 7] {
        for (name, theory) in theories(p) {
            let t = unpolarized(theory(Radians(f64::NAN)), 100.0);
            assert!(t.is_nan(), "{name}, p = {p}: {t}");
        }
    }
}
