//! Every set of vector instructions gives the same bits; errors say what was wrong.

use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use pulp::Arch;

use crate::support::degrees;
use crate::support::sphere;

#[test]
fn every_processor_with_fused_multiply_add_gives_the_same_bits() {
    let mut fused = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        fused.extend(pulp::x86::V3::try_new().map(Arch::V3));
        fused.extend(pulp::x86::V4::try_new().map(Arch::V4));
    }
    #[cfg(target_arch = "aarch64")]
    fused.extend(pulp::aarch64::Neon::try_new().map(Arch::Neon));
    let grid: Vec<f64> = (0..=180).map(f64::from).collect();
    let angles = degrees(&grid);
    for (x, n, k) in [
        (0.5, 1.333, 0.0),
        (600.0, 1.333, 1e-4),
        (5000.0, 1.333, 0.0),
    ] {
        let sphere = sphere(x, n, k);
        let best = sphere.amplitudes(&angles);
        for arch in &fused {
            assert_eq!(
                sphere.waves().amplitudes_by(&angles, *arch),
                best,
                "x = {x}"
            );
        }
        let plain = sphere.waves().amplitudes_by(&angles, Arch::Scalar);
        for (best, plain) in best.s1.iter().zip(&plain.s1) {
            // Without it the last digits differ: worst found 2.2e-13.
            assert!(
                (best - plain).norm() <= 2e-12 * best.norm(),
                "{best} {plain}"
            );
        }
    }
}

#[test]
fn an_error_says_what_was_found_and_what_was_expected() {
    let message = |x, n, k| {
        let found = Sphere::new(x, RefractiveIndex { n, k });
        found.unwrap_err().to_string()
    };
    assert_eq!(
        message(0.0, 1.333, 0.0),
        "size parameter 0 found, expected 0.000001 to 100000"
    );
    assert_eq!(
        message(1.0, 1.333, -1e-9),
        "refractive index 1.333 + -0.000000001i found, expected a real part above 0, an imaginary \
         part of at least 0 and a modulus of at most 100"
    );
    let message = ScatteringAngles::from_degrees(&[0.0, 180.5]).unwrap_err();
    assert_eq!(
        message.to_string(),
        "scattering angle number 1 is 180.5 degrees, expected 0 to 180"
    );
}
