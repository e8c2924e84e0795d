use super::*;
use crate::airy_integral::airy_squares;
use spec_math::Bessel;

const RED: Nanometers = Nanometers(650.0);
const RED_INDEX: f64 = 1.3312;

/// Error of a difference quotient; measured worst 3.2e-5.
const DIFFERENCE_TOLERANCE: f64 = 1e-4;
/// Offset of a first peak; measured worst 0.013 at 20 µm.
const PEAK_TOLERANCE_DEG: f64 = 0.03;

fn unpolarized(bow: &AiryBow, radius_um: f64, theta_deg: f64) -> f64 {
    let theta = Radians::from_degrees(theta_deg);
    let [s, p] =
        bow.direction(theta)
            .normalized_cross_section(Micrometers(radius_um), RED, airy_squares);
    0.5 * (s + p)
}

/// Angle beyond the rainbow ray, in degrees, and height of the highest peak.
fn peak(bow: &AiryBow, radius_um: f64) -> (f64, f64) {
    let start_deg = bow.ray().theta_rad().to_degrees();
    (0..9000)
        .map(|step| 1e-3 * f64::from(step))
        .map(|beyond| {
            let theta_deg = start_deg + bow.ray().bright_side() * beyond;
            // Without the factor 1/sin θ, whose slope would move the peak of small drops.
            (
                beyond,
                unpolarized(bow, radius_um, theta_deg) * theta_deg.to_radians().sin(),
            )
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
}

#[test]
fn the_papers_variables_give_the_textbook_form() {
    // |S_j|² = 2π x^(7/3) h^(−2/3) (sin i0/sin θ) [ε_j² Ai²(−ζ) + (ε_j'/(cos i0 (x h)^(1/3)))² Ai'²(−ζ)],
    // ζ = x^(2/3) h^(−1/3) (D − D_R), on the dark side, where nothing is drawn to the rays.
    let bow = AiryBow::new(RED_INDEX, 2).unwrap();
    let ray = *bow.ray();
    for radius_um in [10.0, 100.0, 1000.0_f64] {
        let x = TAU * radius_um / 0.65;
        let theta_rad = ray.theta_rad() - 0.4 * x.powf(-2.0 / 3.0);
        let zeta =
            x.powf(2.0 / 3.0) * ray.wavefront_h.powf(-1.0 / 3.0) * (theta_rad - ray.theta_rad());
        let airy = (-zeta).airy();
        let direction = bow.direction(Radians(theta_rad));
        let found = direction.normalized_cross_section(Micrometers(radius_um), RED, airy_squares);
        for j in 0..2 {
            let derivative = bow.derivative_amplitudes[j] * x.powf(-1.0 / 3.0) * airy.aip;
            let expected = 2.0
                * x.powf(1.0 / 3.0)
                * ray.wavefront_h.powf(-2.0 / 3.0)
                * (ray.incidence_rad.sin() / theta_rad.sin())
                * ((ray.amplitudes[j] * airy.ai).powi(2) + derivative.powi(2));
            assert!(
                (found[j] / expected - 1.0).abs() < 2e-4,
                "{found:?} against {expected}"
            );
        }
    }
}

#[test]
fn the_derivative_of_the_amplitude_is_its_difference_quotient() {
    // B = ε sqrt(sin i cos i sqrt(D − D_R)/|dD/di|) to either side, in steps of sqrt(D − D_R).
    for p in 2..=7 {
        let bow = AiryBow::new(RED_INDEX, p).unwrap();
        let ray = *bow.ray();
        let path = RayPath { n: RED_INDEX, p };
        let step = 1e-3;
        let side = |sign: f64| {
            let ray = path.ray(ray.incidence_rad + sign * step);
            let root = (ray.deviation - bow.ray.deviation_rad).sqrt();
            let spread = ray.sin_incidence * ray.cos_incidence * root / ray.slope.abs();
            ray.amplitudes().map(|amplitude| amplitude * spread.sqrt())
        };
        let (inner, outer) = (side(-1.0), side(1.0));
        let center =
            (0.5 * (ray.incidence_rad * 2.0).sin() / (2.0 * ray.half_curvature().sqrt())).sqrt();
        for j in 0..2 {
            let length = ray.incidence_rad.cos() * ray.wavefront_h.cbrt();
            let expected = (outer[j] - inner[j]) / (2.0 * step) / center / length;
            let off = (bow.derivative_amplitudes[j] - expected).abs();
            assert!(off < DIFFERENCE_TOLERANCE, "p = {p}: off by {off:e}");
        }
    }
}

#[test]
fn first_peaks_lie_where_the_exact_debye_order_has_them() {
    // Ai² alone has them at 1.01879 h^(1/3) x^(−2/3): 2.98, 1.62, 1.02, 0.64 and 0.35 degrees.
    let bow = AiryBow::new(RED_INDEX, 2).unwrap();
    for (radius_um, offset_deg) in [
        (20.0, 2.677),
        (50.0, 1.552),
        (100.0, 0.996),
        (200.0, 0.631),
        (500.0, 0.348),
        (1000.0, 0.219),
    ] {
        let found = peak(&bow, radius_um).0;
        assert!(
            (found - offset_deg).abs() < PEAK_TOLERANCE_DEG,
            "{radius_um} um: {found}"
        );
    }
}

#[test]
fn peaks_grow_as_the_seventh_third_power_of_the_radius() {
    // t = (dσ/dΩ)/(π a²), so t grows with the power 1/3; sin θ changes a little with the peak.
    let bow = AiryBow::new(RED_INDEX, 2).unwrap();
    let slope = (peak(&bow, 1000.0).1 / peak(&bow, 250.0).1).ln() / 4.0_f64.ln();
    assert!((slope - 1.0 / 3.0).abs() < 0.01, "slope {slope}");
}

#[test]
fn the_mean_over_the_fringes_is_that_of_the_rays_at_the_caustic() {
    // The closed form of the mean is the leading term of the rays as D approaches D_R.
    for p in [2, 3, 5] {
        let bow = AiryBow::new(RED_INDEX, p).unwrap();
        let rays = GeometricOrder::new(RED_INDEX, p).unwrap();
        let beyond_rad = 0.05_f64.to_radians();
        let theta_rad = bow.ray().theta_rad() + bow.ray().bright_side() * beyond_rad;
        let spread = bow.ray().incidence_rad.sin() / theta_rad.sin();
        let mean = fringe_mean(beyond_rad, bow.ray().wavefront_h)
            * spread
            * bow.ray().amplitudes[0].powi(2);
        let ratio = rays.normalized_cross_section(Radians(theta_rad))[0] / mean;
        assert!((ratio - 1.0).abs() < 6e-3, "p = {p}: {ratio}");
    }
}

#[test]
fn every_angle_and_size_gives_a_finite_value_that_is_not_negative() {
    for p in [2, 3, 4, 5, 6, 7] {
        let bow = AiryBow::new(RED_INDEX, p).unwrap();
        for radius_um in [1.0, 10.0, 1500.0] {
            for theta_deg in [0.0, 1e-7, 30.0, 128.0, 138.0, 165.0, 179.999_999, 180.0] {
                let t = unpolarized(&bow, radius_um, theta_deg);
                assert!(
                    t.is_finite() && t >= 0.0,
                    "p = {p}, {radius_um} um, {theta_deg} deg: {t}"
                );
            }
        }
    }
}

#[test]
fn the_published_form_meets_the_absolute_one_where_it_is_scaled_and_leaves_it_elsewhere() {
    let bow = AiryBow::new(RED_INDEX, 2).unwrap();
    let theta = Radians(bow.ray().theta_rad());
    let ratio = |radius_um, wavelength_nm| {
        let (radius, wavelength) = (Micrometers(radius_um), Nanometers(wavelength_nm));
        // The published form has no derivative.
        let absolute = BowDirection {
            derivative_strength: [0.0; 2],
            ..bow.direction(theta)
        };
        let published = bow.published_direction(theta);
        assert!(published.argument.abs() < 1e-12, "z = 0 at the rainbow ray");
        AiryForm::Published.size_factor(radius, wavelength)
            * published.strength[0]
            * airy_squares(0.0)[0]
            / absolute.normalized_cross_section(radius, wavelength, airy_squares)[0]
    };
    assert!((ratio(100.0, 550.0) - 1.0).abs() < 1e-12);
    // The missing factor is a λ.
    assert!((ratio(1000.0, 550.0) - 0.1).abs() < 1e-12);
    assert!((ratio(100.0, 700.0) - 550.0 / 700.0).abs() < 1e-12);
}
