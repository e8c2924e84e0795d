//! Airy's and the uniform theory against the exact Debye series.

mod references;

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_airy::AiryBow;
use niji_airy::BowDirection;
use niji_airy::UniformBow;
use niji_airy::airy_squares;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::Radians;
use references::BOWS;
use references::DARK;
use references::N;
use references::PEAKS;

/// Exact |S|² of one order for drops of one size.
struct Reference {
    x: f64,
    order: u32,
    /// Scattering angle in degrees, (|S1|², |S2|²).
    intensities: &'static [(f64, [f64; 2])],
}

/// |S_j|² = π x² t_j.
fn intensity(direction: BowDirection, x: f64) -> [f64; 2] {
    let wavelength = Nanometers(1000.0);
    let t = direction.normalized_cross_section(Micrometers(x / TAU), wavelength, airy_squares);
    t.map(|t| PI * x * x * t)
}

/// RMS of the difference over RMS of the reference.
fn rms(
    reference: &Reference,
    model: impl Fn(Radians) -> BowDirection,
    part: impl Fn([f64; 2]) -> f64,
) -> f64 {
    let (mut difference, mut square) = (0.0, 0.0);
    for (theta_deg, exact) in reference.intensities {
        let found = intensity(model(Radians::from_degrees(*theta_deg)), reference.x);
        difference += (part(found) - part(*exact)).powi(2);
        square += part(*exact).powi(2);
    }
    (difference / square).sqrt()
}

fn highest(intensities: impl Iterator<Item = [f64; 2]>) -> f64 {
    intensities.map(|[s, p]| s + p).fold(0.0, f64::max)
}

/// Highest peak of a theory over that of the reference, at the angles of the reference.
fn peak_ratio(reference: &Reference, model: impl Fn(Radians) -> BowDirection) -> f64 {
    let angles = reference.intensities.iter();
    let found = angles
        .map(|(theta_deg, _)| intensity(model(Radians::from_degrees(*theta_deg)), reference.x));
    highest(found) / highest(reference.intensities.iter().map(|(_, exact)| *exact))
}

/// Airy's theory as textbooks have it, f² at the amplitude of the rainbow ray.
fn textbook(bow: &AiryBow, theta: Radians) -> BowDirection {
    let at_rainbow_ray = bow.direction(Radians(bow.ray().theta_rad()));
    let spread = bow.ray().theta_rad().sin() / theta.0.sin();
    BowDirection {
        argument: bow.argument(theta),
        strength: at_rainbow_ray.strength.map(|strength| spread * strength),
        derivative_strength: [0.0; 2],
        rays: [0.0; 2],
    }
}

/// RMS of a theory at a size and an order: x, order, natural light, p-polarisation.
type Bound = (f64, u32, f64, f64);

/// Measured: 6.05e-2 and 0.148, 5.92e-3 and 3.06e-2, 2.49e-3 and 1.56e-2, 4.34e-4 and 2.62e-3, 1.83e-4
/// and 1.18e-3; p = 3: 0.155 and 2.16e-2, 1.78e-2 and 8.6e-3, 2.08e-3 and 2.03e-3; p = 4: 2.17e-2
/// and 8.6e-3, p = 5: 1.63e-2 and 7.3e-3, p = 6: 4.18e-2 and 2.10e-2, p = 7: 7.94e-2 and 4.30e-2, where
/// the rainbow ray comes within two widths (2/x)^(1/3) of the grazing one.
const UNIFORM_BOUNDS: [Bound; 12] = [
    (97.0, 2, 0.062, 0.16),
    (483.0, 2, 6e-3, 0.032),
    (967.0, 2, 2.5e-3, 0.016),
    (4833.0, 2, 4.5e-4, 2.7e-3),
    (9666.0, 2, 1.9e-4, 1.2e-3),
    (97.0, 3, 0.16, 0.022),
    (967.0, 3, 0.018, 9e-3),
    (4833.0, 3, 2.1e-3, 2.1e-3),
    (4833.0, 4, 0.022, 9e-3),
    (4833.0, 5, 0.017, 7.5e-3),
    (4833.0, 6, 0.042, 0.0215),
    (4833.0, 7, 0.08, 0.044),
];

/// Measured: 6.91e-2 and 0.156, 1.20e-2 and 7.69e-2, 9.34e-3 and 3.64e-2, 2.36e-2 and 4.33e-2, 2.68e-2
/// and 6.73e-2; p = 3: 0.165 and 1.64e-2, 2.72e-2 and 4.19e-2, 1.02e-2 and 2.78e-2; p = 4: 2.64e-2
/// and 4.57e-2, p = 5: 2.79e-2 and 4.07e-2, p = 6: 6.80e-2 and 9.51e-2, p = 7: 0.120 and 0.154.
const AIRY_BOUNDS: [Bound; 12] = [
    (97.0, 2, 0.07, 0.16),
    (483.0, 2, 0.0125, 0.08),
    (967.0, 2, 0.01, 0.04),
    (4833.0, 2, 0.025, 0.045),
    (9666.0, 2, 0.028, 0.07),
    (97.0, 3, 0.17, 0.017),
    (967.0, 3, 0.028, 0.043),
    (4833.0, 3, 0.011, 0.029),
    (4833.0, 4, 0.027, 0.047),
    (4833.0, 5, 0.029, 0.042),
    (4833.0, 6, 0.07, 0.097),
    (4833.0, 7, 0.125, 0.16),
];

fn assert_bounds<T>(
    bounds: &[Bound],
    theory: impl Fn(u32) -> T,
    direction: impl Fn(&T, Radians) -> BowDirection,
) {
    assert_eq!(bounds.len(), BOWS.len());
    for (&(x, order, natural, parallel), reference) in bounds.iter().zip(&BOWS) {
        assert_eq!((x, order), (reference.x, reference.order));
        let theory = theory(order);
        let found = rms(reference, |theta| direction(&theory, theta), |[s, p]| s + p);
        assert!(found < natural, "x = {x}, p = {order}: {found:.2e}");
        let found = rms(reference, |theta| direction(&theory, theta), |[_, p]| p);
        assert!(found < parallel, "x = {x}, p = {order}, weak: {found:.2e}");
    }
}

#[test]
fn the_uniform_theory_has_its_published_error() {
    let theory = |order| UniformBow::new(N, order).unwrap();
    assert_bounds(&UNIFORM_BOUNDS, theory, UniformBow::direction);
}

#[test]
fn airys_theory_is_drawn_to_the_exact_order_by_derivative_and_rays() {
    let theory = |order| AiryBow::new(N, order).unwrap();
    assert_bounds(&AIRY_BOUNDS, theory, AiryBow::direction);
}

#[test]
fn without_its_derivative_airys_theory_is_wrong_by_half_in_the_weak_polarisation() {
    // 0.38 to 0.77, measured; the fringes of natural light have the error of the literature.
    let bow = AiryBow::new(N, 2).unwrap();
    for (reference, natural) in BOWS.iter().zip([0.139, 0.049, 0.035, 0.046, 0.055]) {
        let model = |theta| textbook(&bow, theta);
        assert!(rms(reference, model, |[_, p]| p) > 0.35);
        let found = rms(reference, model, |[s, p]| s + p);
        assert!(
            (found / natural - 1.0).abs() < 0.25,
            "x = {}: {found}",
            reference.x
        );
    }
}

#[test]
fn small_drops_leave_airys_theory() {
    let airy = AiryBow::new(N, 2).unwrap();
    let uniform = UniformBow::new(N, 2).unwrap();
    let expected = [[1.132, 0.881, 0.929], [1.080, 0.975, 0.990]];
    for (reference, expected) in PEAKS.iter().zip(expected) {
        let found = [
            peak_ratio(reference, |theta| textbook(&airy, theta)),
            peak_ratio(reference, |theta| airy.direction(theta)),
            peak_ratio(reference, |theta| uniform.direction(theta)),
        ];
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-3,
                "x = {}: {found}",
                reference.x
            );
        }
    }
}

/// Relative error of the uniform theory on the dark side, s and p; measured worst 2.7e-3 and 0.040,
/// where the light is 4e-9 of the peak.
const DARK_TOLERANCE: [f64; 2] = [3e-3, 0.041];

#[test]
fn the_dark_side_of_the_uniform_theory_keeps_its_relative_accuracy() {
    let bow = UniformBow::new(N, 2).unwrap();
    for (theta_deg, exact) in DARK.intensities {
        let found = intensity(bow.direction(Radians::from_degrees(*theta_deg)), DARK.x);
        for j in 0..2 {
            let off = (found[j] / exact[j] - 1.0).abs();
            assert!(
                off < DARK_TOLERANCE[j],
                "{theta_deg} deg: {found:?} against {exact:?}"
            );
        }
    }
}
