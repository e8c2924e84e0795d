use super::*;
use crate::fresnel::order_amplitudes;

#[test]
fn the_light_of_an_order_is_what_fresnel_lets_through() {
    // ∫ t dΩ = ∫ 2 sin i cos i ε² di, both by the midpoint rule.
    for p in [0, 1, 2, 3] {
        let order = GeometricOrder::new(1.333, p).unwrap();
        let n_steps = 40_000;
        let (mut over_sphere, mut over_incidence) = ([0.0; 2], [0.0; 2]);
        for step in 0..n_steps {
            let part = (f64::from(step) + 0.5) / f64::from(n_steps);
            let theta = PI * part;
            let t = order.normalized_cross_section(Radians(theta));
            let incidence = FRAC_PI_2 * part;
            let cos_refraction = (1.0 - (incidence.sin() / 1.333).powi(2)).sqrt();
            let amplitudes = order_amplitudes(1.333, p, incidence.cos(), cos_refraction);
            for j in 0..2 {
                over_sphere[j] += TAU * theta.sin() * t[j] * PI / f64::from(n_steps);
                over_incidence[j] += (2.0 * incidence).sin() * amplitudes[j].powi(2) * FRAC_PI_2
                    / f64::from(n_steps);
            }
        }
        for j in 0..2 {
            assert!(
                (over_sphere[j] / over_incidence[j] - 1.0).abs() < 5e-3,
                "p = {p}: {over_sphere:?} against {over_incidence:?}"
            );
        }
    }
}

/// Energy on the sphere over energy that enters; measured worst 4.2e-11, the sum over incidence.
const ENERGY_TOLERANCE: f64 = 1e-10;

#[test]
fn rings_share_out_all_the_light_of_an_order() {
    for p in [0, 1, 2, 3, 4, 5, 6, 7] {
        let order = GeometricOrder::new(1.333, p).unwrap();
        let n_rings = 3000;
        let mut over_sphere = [0.0; 2];
        for ring in 0..n_rings {
            let edge = |ring: i32| PI * f64::from(ring) / f64::from(n_rings);
            let mean = order.mean_over_ring(Radians(edge(ring)), Radians(edge(ring + 1)));
            let solid_angle = TAU * (edge(ring).cos() - edge(ring + 1).cos());
            for (sum, mean) in over_sphere.iter_mut().zip(mean) {
                *sum += mean * solid_angle;
            }
        }
        // 2 ∫ sin i cos i ε² di in one piece of 400 000 midpoints.
        let n_steps = 400_000;
        let mut entering = [0.0; 2];
        for step in 0..n_steps {
            let i = FRAC_PI_2 * (f64::from(step) + 0.5) / f64::from(n_steps);
            let cos_refraction = (1.0 - (i.sin() / 1.333).powi(2)).sqrt();
            let amplitudes = order_amplitudes(1.333, p, i.cos(), cos_refraction);
            for (sum, amplitude) in entering.iter_mut().zip(amplitudes) {
                *sum += (2.0 * i).sin() * amplitude * amplitude * FRAC_PI_2 / f64::from(n_steps);
            }
        }
        for j in 0..2 {
            let off = (over_sphere[j] / entering[j] - 1.0).abs();
            assert!(off < ENERGY_TOLERANCE, "p = {p}: off by {off:e}");
        }
    }
}

#[test]
fn a_narrow_ring_has_the_intensity_of_its_middle() {
    for (p, theta_deg) in [(2, 150.0), (2, 175.0), (3, 100.0), (3, 120.0)] {
        let order = GeometricOrder::new(1.333, p).unwrap();
        let at = |deg: f64| Radians::from_degrees(deg);
        let mean = order.mean_over_ring(at(theta_deg - 0.01), at(theta_deg + 0.01));
        let middle = order.normalized_cross_section(at(theta_deg));
        for j in 0..2 {
            assert!((mean[j] / middle[j] - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn alexanders_band_is_dark_and_the_poles_are_finite() {
    let primary = GeometricOrder::new(1.333, 2).unwrap();
    let secondary = GeometricOrder::new(1.333, 3).unwrap();
    for theta_deg in [129.5, 133.0, 137.5] {
        let theta = Radians::from_degrees(theta_deg);
        assert_eq!(primary.normalized_cross_section(theta), [0.0; 2]);
        assert_eq!(secondary.normalized_cross_section(theta), [0.0; 2]);
    }
    for (order, pole_deg) in [(primary, 180.0), (secondary, 0.0)] {
        let at = order.normalized_cross_section(Radians::from_degrees(pole_deg))[0];
        let near_deg = (pole_deg - 1e-4_f64).abs();
        let near = order.normalized_cross_section(Radians::from_degrees(near_deg))[0];
        assert!(
            at > 0.0 && (at / near - 1.0).abs() < 1e-6,
            "{at} at the pole, {near} beside"
        );
    }
}

#[test]
fn past_the_grazing_ray_a_single_ray_is_left() {
    // p = 2, n = 1.333: the grazing ray leaves at D = 165.63 degrees, with no light of its own.
    let order = GeometricOrder::new(1.333, 2).unwrap();
    let at = |deg| order.normalized_cross_section(Radians::from_degrees(deg))[0];
    assert!(
        (at(165.5) / at(165.8) - 1.0).abs() < 0.02,
        "continuous across the grazing ray"
    );
}

/// Light of all orders over what meets the drop; measured worst 2e-14.
const ALL_LIGHT_TOLERANCE: f64 = 1e-12;

#[test]
fn all_orders_together_carry_all_the_light_that_meets_the_drop() {
    const LAST: u32 = 20;
    let n_rings = 900;
    let edge = |ring: i32| Radians(PI * f64::from(ring) / f64::from(n_rings));
    let mut light = [0.0; 2];
    for p in 0..=LAST {
        let order = GeometricOrder::new(1.333, p).unwrap();
        for ring in 0..n_rings {
            let mean = order.mean_over_ring(edge(ring), edge(ring + 1));
            let solid_angle = TAU * (edge(ring).0.cos() - edge(ring + 1).0.cos());
            for (sum, mean) in light.iter_mut().zip(mean) {
                *sum += mean * solid_angle;
            }
        }
    }
    // Of ρ² + (1 − ρ²)² (1 + ρ² + ρ⁴ + …) = 1 the orders beyond are (1 − ρ²) ρ^(2 LAST).
    let n_steps = 20_000;
    for step in 0..n_steps {
        let i = FRAC_PI_2 * (f64::from(step) + 0.5) / f64::from(n_steps);
        let weight = (2.0 * i).sin() * FRAC_PI_2 / f64::from(n_steps);
        for (sum, rho) in light
            .iter_mut()
            .zip(RayPath { n: 1.333, p: 0 }.ray(i).amplitudes())
        {
            *sum += weight * (1.0 - rho * rho) * rho.powi(2 * LAST as i32);
        }
    }
    for light in light {
        assert!((light - 1.0).abs() < ALL_LIGHT_TOLERANCE, "{light}");
    }
}

#[test]
fn reflection_at_normal_incidence_is_that_of_the_textbook() {
    // ((n − 1)/(n + 1))²/4π straight back, and 1/4π of all that meets the drop at grazing incidence.
    let outside = GeometricOrder::new(1.333, 0).unwrap();
    let normal = ((1.333_f64 - 1.0) / (1.333 + 1.0)).powi(2);
    let back = outside.normalized_cross_section(Radians(PI));
    let forward = outside.normalized_cross_section(Radians(0.0));
    for j in 0..2 {
        assert!((back[j] * 4.0 * PI / normal - 1.0).abs() < 1e-12);
        assert!((forward[j] * 4.0 * PI - 1.0).abs() < 1e-12);
    }
}

#[test]
fn light_that_goes_through_is_focused_forward_and_ends_at_the_grazing_ray() {
    // On the axis t = (1 − ρ²)²/(π (dD/di)²), dD/di = 2 − 2/n; the last ray leaves at π − 2 asin(1/n).
    let through = GeometricOrder::new(1.333, 1).unwrap();
    let rho = (1.333_f64 - 1.0) / (1.333 + 1.0);
    let slope = 2.0 - 2.0 / 1.333;
    let expected = (1.0 - rho * rho).powi(2) / (PI * slope * slope);
    let last_rad = PI - 2.0 * (1.0 / 1.333_f64).asin();
    for (s, theta_rad) in [(expected, 0.0), (expected, 1e-5)] {
        let found = through.normalized_cross_section(Radians(theta_rad));
        assert!((found[0] / s - 1.0).abs() < 1e-8 && (found[1] / s - 1.0).abs() < 1e-8);
    }
    assert!(through.normalized_cross_section(Radians(last_rad - 1e-3))[0] > 0.0);
    assert_eq!(
        through.normalized_cross_section(Radians(last_rad + 1e-9)),
        [0.0; 2]
    );
}

#[test]
fn orders_without_a_bow_have_rays_and_media_without_a_drop_have_none() {
    for (n, p) in [(1.333, 0), (1.333, 1), (2.5, 2), (2.0, 2), (1.000_3, 7)] {
        let order = GeometricOrder::new(n, p).unwrap();
        for theta_deg in [0.0, 30.0, 90.0, 170.0, 180.0] {
            let t = order.normalized_cross_section(Radians::from_degrees(theta_deg));
            assert!(t[0].is_finite() && t[0] >= 0.0, "n = {n}, p = {p}: {t:?}");
        }
    }
    for n in [1.0, 0.75, f64::NAN, f64::INFINITY] {
        assert_eq!(GeometricOrder::new(n, 2), None);
    }
}
