//! Values that others have published.
//!
//! [W79] Wiscombe, NCAR Technical Note TN-140+STR (1979), as kept in the MIEV0 test driver; it
//! writes m = n - ik and conjugate amplitudes. [D04] Du, Applied Optics 43, 1951-1956 (2004), table
//! 1.
//! [BH83] Bohren and Huffman, Absorption and Scattering of Light by Small Particles (1983), app. A.

use num_complex::Complex64;

use crate::support::degrees;
use crate::support::sphere;

/// Half a unit of the last of seven printed digits, and Wiscombe's single precision.
const SEVEN_DIGITS: f64 = 6e-7;

/// x, n, k, `Q_ext`, `Q_sca`, g; a g of 2 is not printed.
const WISCOMBE_AND_DU: [(f64, f64, f64, f64, f64, f64); 15] = [
    (0.099, 0.75, 0.0, 7.417859e-6, 7.417859e-6, 0.001448),
    (0.101, 0.75, 0.0, 8.033538e-6, 8.033538e-6, 0.001507),
    (10.0, 0.75, 0.0, 2.232265, 2.232265, 2.0),
    (1000.0, 0.75, 0.0, 1.997908, 1.997908, 2.0),
    (1.0, 1.33, 1e-5, 9.395198e-2, 9.392330e-2, 0.184517),
    (100.0, 1.33, 1e-5, 2.101321, 2.096594, 0.868959),
    (10000.0, 1.33, 1e-5, 2.004089, 1.723857, 0.907840),
    (0.055, 1.5, 1.0, 0.10149104, 1.131687e-5, 0.000491),
    (0.056, 1.5, 1.0, 0.1033467, 1.216311e-5, 0.000509),
    (1.0, 1.5, 1.0, 2.336321, 0.6634538, 0.192136),
    (100.0, 1.5, 1.0, 2.097502, 1.283697, 0.850252),
    (10000.0, 1.5, 1.0, 2.004368, 1.236574, 0.846309),
    (1.0, 10.0, 10.0, 2.532993, 2.049405, -0.110664),
    (100.0, 10.0, 10.0, 2.071124, 1.836785, 0.556215),
    (10000.0, 10.0, 10.0, 2.005914, 1.795393, 0.548194),
];

/// Angle, S1, S2 of [W79] as printed, for m = n - ik.
type Printed = (f64, (f64, f64), (f64, f64));

/// Compares conjugates, each to `tolerance` of the larger amplitude.
fn check_wiscombe((x, n, k): (f64, f64, f64), printed: &[Printed], tolerance: f64) {
    let angles: Vec<f64> = printed.iter().map(|row| row.0).collect();
    let found = sphere(x, n, k).amplitudes(&degrees(&angles));
    for (i, (theta_deg, s1, s2)) in printed.iter().enumerate() {
        let (s1, s2) = (Complex64::new(s1.0, -s1.1), Complex64::new(s2.0, -s2.1));
        let error = (found.s1[i] - s1).norm().max((found.s2[i] - s2).norm());
        let scale = s1.norm().max(s2.norm());
        assert!(
            error <= tolerance * scale,
            "x = {x} at {theta_deg}: {}",
            found.s1[i]
        );
    }
}

#[test]
fn efficiencies_of_wiscombe_and_du() {
    for (x, n, k, q_ext, q_sca, g) in WISCOMBE_AND_DU {
        let q = *sphere(x, n, k).efficiencies();
        assert!(
            (q.q_ext / q_ext - 1.0).abs() <= SEVEN_DIGITS,
            "x = {x}: {}",
            q.q_ext
        );
        assert!(
            (q.q_sca / q_sca - 1.0).abs() <= SEVEN_DIGITS,
            "x = {x}: {}",
            q.q_sca
        );
        assert!(
            g > 1.0 || (q.asymmetry - g).abs() <= 1e-6,
            "x = {x}: {}",
            q.asymmetry
        );
    }
}

#[test]
fn a_raindrop_that_catches_a_recurrence_started_too_low() {
    // 60-digit arithmetic; the classical start 16 terms above |mx| gives 2.01968.
    let q_ext = sphere(1000.0, 1.333, 0.0).efficiencies().q_ext;
    assert!((q_ext - 2.0228114332201634).abs() <= 1e-13, "{q_ext}");
    let q_ext = sphere(10000.0, 1.333, 0.0).efficiencies().q_ext;
    assert!((q_ext - 2.0049383224698247).abs() <= 1e-13, "{q_ext}");
}

#[test]
fn amplitudes_of_wiscombe_at_x_100() {
    let printed = [
        (0.0, (5.253302e3, -1.243188e2), (5.253302e3, -1.243188e2)),
        (30.0, (-55.34573, -29.71881), (-84.67204, -19.99470)),
        (60.0, (17.10488, -15.20096), (33.10764, -2.709787)),
        (90.0, (-3.655758, 8.769860), (-6.550512, -4.675370)),
        (120.0, (2.414318, 0.5380874), (6.039011, -11.69971)),
        (150.0, (-1.222996, 32.83917), (-9.653812, 14.74455)),
        (180.0, (-56.59205, 46.50974), (56.59205, -46.50974)),
    ];
    check_wiscombe((100.0, 1.33, 1e-5), &printed, SEVEN_DIGITS);
}

#[test]
fn amplitudes_of_wiscombe_at_x_10000() {
    let printed = [
        (0.0, (5.010222e7, -1.535815e5), (5.010222e7, -1.535815e5)),
        (30.0, (3.786814e3, -7.654293e3), (5.074755e3, -7.515986e3)),
        (60.0, (-2.731172e3, 1.326633e3), (-3.076558e3, -1.775975e2)),
        (90.0, (-1.061003e3, -1.930155e2), (2.430920e2, 8.409836e1)),
        (120.0, (-1.058140e3, 2.298414e1), (5.906487e1, -5.370283e2)),
        (150.0, (-2.748855e3, 2.298181e3), (-8.036201e1, -4.939186)),
        (180.0, (-1.821193e2, -9.519122e2), (1.821193e2, 9.519122e2)),
    ];
    // His single precision shows at 180 degrees: 5e-6.
    check_wiscombe((10000.0, 1.33, 1e-5), &printed, 1e-5);
    let absorbing = [
        (30.0, (-3690.394, -1573.897), (-933.3175, -1839.736)),
        (60.0, (239.1551, 3247.786), (-1202.951, -189.9647)),
        (90.0, (-2607.463, 741.4859), (1013.073, -1064.666)),
        (180.0, (-218.4719, -2064.610), (218.4719, 2064.610)),
    ];
    check_wiscombe((10000.0, 1.5, 1.0), &absorbing, 1e-5);
}

#[test]
fn amplitudes_of_wiscombe_at_x_1() {
    let printed = [
        (0.0, (0.584080, 0.190515), (0.584080, 0.190515)),
        (30.0, (0.565702, 0.187200), (0.500161, 0.145611)),
        (60.0, (0.517525, 0.178443), (0.287964, 0.041054)),
        (90.0, (0.456340, 0.167167), (0.0362285, -0.0618265)),
        (120.0, (0.400212, 0.156643), (-0.174875, -0.122959)),
        (150.0, (0.362157, 0.149391), (-0.305682, -0.143846)),
        (180.0, (0.348844, 0.146829), (-0.348844, -0.146829)),
    ];
    check_wiscombe((1.0, 1.5, 1.0), &printed, 2e-6);
}

#[test]
#[allow(clippy::approx_constant, reason = "0.785390 is a ratio of intensities")]
fn the_sample_of_bohren_and_huffman() {
    // a = 0.525 um, 632.8 nm, m = 1.55: S11 relative to forward, and polarization -S12/S11.
    let sphere = sphere(std::f64::consts::TAU * 0.525 / 0.6328, 1.55, 0.0);
    let q = sphere.efficiencies();
    assert!((q.q_ext - 3.10543).abs() <= 5e-6 && (q.q_sca - 3.10543).abs() <= 5e-6);
    assert!((q.q_back - 2.92534).abs() <= 5e-6, "{}", q.q_back);
    assert!((q.asymmetry - 0.63314).abs() <= 5e-6, "{}", q.asymmetry);
    let printed = [
        (0.0, 1.0, 0.0),
        (9.0, 0.785390, -0.00459811),
        (18.0, 0.356897, -0.0458541),
        (36.0, 0.0355355, -0.534997),
        (54.0, 0.0574313, 0.0477927),
        (72.0, 0.0125959, -0.831996),
        (90.0, 0.0124601, 0.230462),
        (108.0, 0.00954239, -0.756255),
        (126.0, 0.00227421, -0.239612),
        (144.0, 0.0160243, -0.706334),
        (162.0, 0.0195254, -0.783319),
        (180.0, 0.0383189, 0.0),
    ];
    let angles: Vec<f64> = printed.iter().map(|row| row.0).collect();
    let amplitudes = sphere.amplitudes(&degrees(&angles));
    let p11 = sphere.p11(&amplitudes);
    let polarization = amplitudes.degrees_of_polarization();
    for (i, (theta_deg, s11, pol)) in printed.iter().enumerate() {
        // Printed to six digits by a single-precision program.
        assert!(
            (p11[i] / p11[0] / s11 - 1.0).abs() <= 2e-5,
            "{theta_deg}: {}",
            p11[i] / p11[0]
        );
        assert!(
            (polarization[i] - pol).abs() <= 2e-5,
            "{theta_deg}: {}",
            polarization[i]
        );
    }
}

#[test]
fn double_precision_values_of_other_programs() {
    // miepython's tests (m = 1.55 + 0.1i at the size above) and scattnlay's (x = 2 pi).
    let size = std::f64::consts::TAU * 0.525 / 0.6328;
    let q = *sphere(size, 1.55, 0.1).efficiencies();
    assert!((q.q_ext - 2.86165188243).abs() <= 1e-10, "{}", q.q_ext);
    assert!((q.q_sca - 1.66424911991).abs() <= 1e-10, "{}", q.q_sca);
    assert!((q.q_back - 0.20599534080).abs() <= 1e-10, "{}", q.q_back);
    assert!(
        (q.asymmetry - 0.80128972639).abs() <= 1e-10,
        "{}",
        q.asymmetry
    );
    let q = *sphere(std::f64::consts::TAU, 1.5, 0.0).efficiencies();
    assert!((q.q_ext - 2.351382357157882).abs() <= 1e-13, "{}", q.q_ext);
    assert!(
        (q.asymmetry - 0.583423159613144).abs() <= 1e-13,
        "{}",
        q.asymmetry
    );
    let q = *sphere(std::f64::consts::TAU, 1.5, 0.1).efficiencies();
    assert!((q.q_ext - 2.5837269073859774).abs() <= 1e-13, "{}", q.q_ext);
    assert!((q.q_sca - 1.3566707303067342).abs() <= 1e-13, "{}", q.q_sca);
    assert!(
        (q.asymmetry - 0.8266873213103347).abs() <= 1e-13,
        "{}",
        q.asymmetry
    );
}

#[test]
fn backscattering_of_the_old_miev0_cases() {
    // m = 1.5: Q_sca and S(180) at x = 10 and 100, |S(180)|^2 beyond.
    for (x, q_sca, s1) in [
        (10.0, 2.8820, (4.322, 4.868)),
        (100.0, 2.0944, (40.77, 51.75)),
    ] {
        let sphere = sphere(x, 1.5, 0.0);
        assert!((sphere.efficiencies().q_sca - q_sca).abs() <= 6e-5);
        let found = sphere.amplitudes(&degrees(&[180.0])).s1[0];
        let printed = Complex64::new(s1.0, -s1.1);
        assert!(
            (found - printed).norm() <= 2e-4 * printed.norm(),
            "x = {x}: {found}"
        );
    }
    for (x, q_sca, i1) in [(1000.0, 2.0139, 2.576e6), (5000.0, 2.0086, 2.378e8)] {
        let sphere = sphere(x, 1.5, 0.0);
        assert!((sphere.efficiencies().q_sca - q_sca).abs() <= 6e-5);
        let found = sphere.amplitudes(&degrees(&[180.0])).s1[0].norm_sqr();
        assert!((found / i1 - 1.0).abs() <= 4e-4, "x = {x}: {found}");
    }
}
