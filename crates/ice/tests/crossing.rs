//! One crossing of a cube against an independent quadrature, and the colors that follow.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::TriangleMesh;
use niji_ice::Body;
use niji_ice::OneCrossing;
use niji_ice::ice_absorption_per_m;
use niji_ice::ice_absorption_spectrum;
use niji_ice::one_crossing;
use niji_radiometry::Colorimetry;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_radiometry::xy_chromaticity;

const N_CHORDS: u32 = 1 << 18;

fn cube(edge_m: f64) -> Body {
    let max = DVec3::splat(edge_m);
    let min = DVec3::ZERO;
    Body::of_box(Aabb { min, max }).unwrap()
}

/// Transmittance of a cube of edge 1 by quadrature over directions.
///
/// Along a direction (a, b, c), c across the entered face, the way of light that entered at distances
/// X, Y from the far sides is min(X/a, Y/b, 1/c); so the share that goes farther than t is
/// (1 - a t)(1 - b t) up to the end, and  T = 1 - alpha int exp(-alpha t) (1 - a t)(1 - b t) dt.
fn cube_quadrature(alpha: f64) -> f64 {
    let n = 400;
    let mut sum = 0.0;
    for i in 0..n {
        // Equal shares of the cosine law.
        let c = ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
        let level = (1.0 - c * c).sqrt();
        for j in 0..n {
            let phi = 0.25 * PI * (f64::from(j) + 0.5) / f64::from(n);
            let (a, b) = (level * phi.cos(), level * phi.sin());
            let end = (1.0 / c).min(1.0 / a).min(1.0 / b);
            sum += 1.0 - alpha * way_integral(alpha, [a, b], end);
        }
    }
    sum / f64::from(n * n)
}

/// int_0^end exp(-alpha t) (1 - a t)(1 - b t) dt
fn way_integral(alpha: f64, [a, b]: [f64; 2], end: f64) -> f64 {
    let x = alpha * end;
    if x > 1.0 {
        let left = (-x).exp();
        let i0 = (1.0 - left) / alpha;
        let i1 = (1.0 - left * (1.0 + x)) / alpha.powi(2);
        let i2 = (2.0 - left * (2.0 + 2.0 * x + x * x)) / alpha.powi(3);
        return i0 - (a + b) * i1 + a * b * i2;
    }
    // Simpson's rule, where the formula would subtract nearly equal numbers.
    let value = |t: f64| (-alpha * t).exp() * (1.0 - a * t) * (1.0 - b * t);
    let h = end / 16.0;
    let inner: f64 = (1..16)
        .map(|k| f64::from(2 + 2 * (k % 2)) * value(h * f64::from(k)))
        .sum();
    h / 3.0 * (value(0.0) + inner + value(end))
}

#[test]
fn a_crossing_agrees_with_an_independent_quadrature() {
    let wavelengths_nm = [
        400.0, 450.0, 480.0, 520.0, 550.0, 590.0, 620.0, 650.0, 700.0, 750.0,
    ];
    let alpha = wavelengths_nm.map(|nm| ice_absorption_per_m(Nanometers(nm)));
    for edge_m in [0.1, 50.0] {
        let found = one_crossing(&cube(edge_m), &alpha, N_CHORDS, 1);
        for (
            index,
            OneCrossing {
                transmittance,
                standard_error,
            },
        ) in found.into_iter().enumerate()
        {
            let expected = cube_quadrature(alpha[index] * edge_m);
            let deviation = (transmittance - expected).abs() / standard_error;
            // Worst found 2.1 standard errors, which are 1e-9 to 2e-5.
            assert!(
                deviation < 3.0,
                "{edge_m} m, {} nm: {deviation}",
                wavelengths_nm[index]
            );
        }
    }
}

#[test]
fn a_mesh_of_a_cube_is_crossed_like_the_cube() {
    let (min, max) = (DVec3::splat(-25.0), DVec3::splat(25.0));
    let mesh = Body::of_mesh(TriangleMesh::of_box(Aabb { min, max })).unwrap();
    for found in one_crossing(&mesh, &[0.01, 0.1], 1 << 15, 2)
        .iter()
        .zip([0.5, 5.0])
    {
        let (
            OneCrossing {
                transmittance,
                standard_error,
            },
            depth,
        ) = found;
        assert!((transmittance - cube_quadrature(depth)).abs() < 4.0 * standard_error);
    }
}

#[test]
fn transmittance_depends_on_absorption_times_size_only() {
    let small = one_crossing(&cube(0.1), &[5.0, 50.0], 4096, 3);
    let large = one_crossing(&cube(50.0), &[0.01, 0.1], 4096, 3);
    for (small, large) in small.iter().zip(&large) {
        // Rounding: the same chords but for their scale.
        assert!((small.transmittance - large.transmittance).abs() < 1e-12);
    }
}

#[test]
fn a_tenth_of_a_metre_is_white_and_fifty_metres_are_blue() {
    // From the refractive index of Warren and Brandt 2008 and the extraterrestrial G173 by an
    // independent Monte Carlo over chords of a cube.
    let grid = WavelengthGrid::visible();
    for (edge_m, x, y) in [(0.1, 0.322, 0.333), (50.0, 0.190, 0.203)] {
        let passed = one_crossing(&cube(edge_m), &ice_absorption_spectrum(&grid), 1 << 14, 6);
        let light = solar_irradiance(&grid).into_iter().zip(passed);
        let light: Vec<f64> = light
            .map(|(sun, passed)| sun * passed.transmittance)
            .collect();
        let found = xy_chromaticity(Colorimetry::new(&grid).xyz(&light)).unwrap();
        assert!(
            (found[0] - x).abs() < 5e-3 && (found[1] - y).abs() < 5e-3,
            "{edge_m} m: {found:?}"
        );
    }
}
