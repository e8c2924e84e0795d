//! Hard cases of spheres: from x = 1e-6 to 5e4, black, faint and hollow ones, the poles, waves that
//! tunnel, and the Debye series.

use niji_mie::Error;
use niji_mie::RefractiveIndex;
use niji_mie::ScatteringAngles;
use niji_mie::Sphere;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;

use crate::selftest::hard_case::HardCase;
use crate::selftest::hard_case::relative;
use crate::selftest::hard_case::violations;
use crate::selftest::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "efficiencies of x from 1e-6 to 5e4 agree with 20 digits",
        measure: "relative error of Q_ext and Q_sca",
        allowed: 5e-14,
        error: efficiencies,
    },
    HardCase {
        claim: "straight back the amplitude agrees with 20 digits",
        measure: "relative error of S1",
        allowed: 5e-10,
        error: backward_amplitudes,
    },
    HardCase {
        claim: "extinction is what the forward amplitude says up to x = 1e5",
        measure: "relative error of Q_ext, at 0 and 1e-9 degrees",
        // The pole is a sum of its own, exact to 2e-16.
        allowed: 5e-12,
        error: optical_theorem,
    },
    HardCase {
        claim: "a sphere without absorption scatters all that it takes",
        measure: "relative difference of Q_sca and Q_ext",
        allowed: 1e-14,
        error: conservation,
    },
    HardCase {
        claim: "an absorbing sphere nears twice its shadow",
        measure: "relative error of the edge term 1.9924 x^(-2/3)",
        allowed: 0.05,
        error: edge_term,
    },
    HardCase {
        claim: "0 and 180 degrees are the limits of the angles beside them",
        measure: "relative difference of S1 1e-8 degrees away",
        allowed: 3e-9,
        error: poles,
    },
    HardCase {
        claim: "waves that tunnel, n > x, keep the digits of each part",
        measure: "relative error of parts of a_n and b_n down to 1e-28",
        allowed: 1e-11,
        error: tunnelling,
    },
    HardCase {
        claim: "no size or index gives a NaN or light from nothing",
        measure: "spheres of 136 that do",
        allowed: 0.0,
        error: light_from_nothing,
    },
    HardCase {
        claim: "no size or index gives a NaN in an order of Debye",
        measure: "orders of 544 that do",
        allowed: 0.0,
        error: not_a_number_in_an_order,
    },
    HardCase {
        claim: "a sphere of air in air does exactly nothing",
        measure: "largest efficiency or amplitude",
        allowed: 0.0,
        error: air_in_air,
    },
    HardCase {
        claim: "Debye orders sum to Mie",
        measure: "relative error of S1",
        allowed: 1e-12,
        error: debye_sum,
    },
    HardCase {
        claim: "spheres that cannot be are refused for what they are",
        measure: "spheres without the error",
        allowed: 0.0,
        error: impossible_spheres,
    },
];

/// Nothing, nearly nothing, bubbles, metals, mirrors, crystals, black spheres.
const INDICES: [(f64, f64); 17] = [
    (1.0, 0.0),
    (1.0, 1e-8),
    (1.000000000001, 0.0),
    (0.75, 0.0),
    (0.05, 0.0),
    (1e-6, 0.0),
    (1e-3, 1e-3),
    (0.05, 3.0),
    (1e-9, 99.0),
    (1.5, 1.0),
    (10.0, 10.0),
    (70.0, 70.0),
    (99.0, 0.0),
    (1.333, 1e-300),
    (1.333, 1e-12),
    (1.333, 0.5),
    (1.333, 30.0),
];

/// x, n, k from the smallest size to the largest.
const SPHERES: [(f64, f64, f64); 8] = [
    (1e-6, 1.333, 0.0),
    (0.3, 1.333, 1e-3),
    (5.213, 1.55, 0.0),
    (62.8, 1.3337, 0.0),
    (100.0, 0.75, 0.0),
    (1000.0, 1.333, 1e-5),
    (10000.0, 1.333, 0.0),
    (100_000.0, 1.333, 0.0),
];

/// x, n, k; Q_ext; Q_sca; S1 at 180 degrees.
type Precise = ((f64, f64, f64), f64, f64, (f64, f64));

/// By recurrences upwards with enough digits for their instability, as `crates/mie/tests/spheres`.
const PRECISE: [Precise; 6] = [
    (
        (2.5e-06, 1.333, 0.0),
        4.4073573910477937819e-24,
        4.4073573910477937819e-24,
        (6.8864959235121789109e-36, -3.2139918925286059962e-18),
    ),
    (
        (0.02, 1.5, 0.01),
        3.9874108427111782406e-4,
        3.6925173724566836335e-8,
        (3.9864863823266632034e-8, -2.3529004943631986005e-6),
    ),
    (
        (31.0, 1.333, 0.001),
        1.9377161245528435662,
        1.8243131259481732843,
        (3.9931347301967513837, 1.2403407994129891594),
    ),
    (
        (444.4, 1.34, 0.0),
        2.0202000913778665112,
        2.0202000913778665112,
        (2.1809900127554863339e+2, -1.9866558781153965443e+2),
    ),
    (
        (6000.0, 1.333, 0.0001),
        2.0060632393221677966,
        1.1890169465349680405,
        (-2.6295106169359983600e+2, 3.1660098056079782808e+2),
    ),
    (
        (45000.0, 1.333, 1e-07),
        2.0018423409933860688,
        1.9867823618500102680,
        (5.4596364673177988621e+4, 7.4630395370009776552e+2),
    ),
];

fn sphere((x, n, k): (f64, f64, f64)) -> Sphere {
    Sphere::new(x, RefractiveIndex { n, k }).expect("the cases name real spheres")
}

fn degrees(angles_deg: &[f64]) -> ScatteringAngles {
    ScatteringAngles::from_degrees(angles_deg).expect("the cases name 0 to 180 degrees")
}

fn efficiencies() -> f64 {
    worst(PRECISE.into_iter().flat_map(|(sizes, q_ext, q_sca, _)| {
        let q = *sphere(sizes).efficiencies();
        [relative(q.q_ext, q_ext), relative(q.q_sca, q_sca)]
    }))
}

fn backward_amplitudes() -> f64 {
    worst(PRECISE.into_iter().map(|(sizes, _, _, backward)| {
        let s1 = sphere(sizes).amplitudes(&degrees(&[180.0])).s1[0];
        (s1.re - backward.0).hypot(s1.im - backward.1) / backward.0.hypot(backward.1)
    }))
}

fn optical_theorem() -> f64 {
    worst(SPHERES.into_iter().flat_map(|sizes| {
        let sphere = sphere(sizes);
        let s1 = sphere.amplitudes(&degrees(&[0.0, 1e-9])).s1;
        let q_ext = sphere.efficiencies().q_ext;
        s1.into_iter()
            .map(move |s1| relative(4.0 * s1.re / sizes.0.powi(2), q_ext))
    }))
}

fn conservation() -> f64 {
    let transparent = SPHERES.into_iter().filter(|(_, _, k)| *k <= 0.0);
    worst(transparent.map(|sizes| {
        let q = *sphere(sizes).efficiencies();
        relative(q.q_sca, q.q_ext)
    }))
}

fn edge_term() -> f64 {
    // Nussenzveig and Wiscombe, Phys. Rev. Lett. 45, 1490 (1980).
    worst([1e3_f64, 1e4, 1e5].map(|x| {
        let q_ext = sphere((x, 1.333, 0.1)).efficiencies().q_ext;
        relative(q_ext - 2.0, 1.9924 * x.powf(-2.0 / 3.0))
    }))
}

fn poles() -> f64 {
    worst(SPHERES.into_iter().flat_map(|sizes| {
        let s1 = sphere(sizes)
            .amplitudes(&degrees(&[0.0, 1e-8, 180.0, 180.0 - 1e-8]))
            .s1;
        [(0, 1), (2, 3)].map(|(pole, beside)| (s1[pole] - s1[beside]).norm() / s1[pole].norm())
    }))
}

/// x, n, a_n and b_n for m = 1.333 and n > x, by recurrences upwards with enough digits.
type Tunnelling = (f64, usize, [f64; 2], [f64; 2]);

const TUNNELLING: [Tunnelling; 6] = [
    (
        100.0,
        105,
        [5.8008984486199226868e-4, 2.4078067626657257531e-2],
        [8.9941908980721674078e-4, 2.9976826635054403279e-2],
    ),
    (
        100.0,
        115,
        [4.4037508759451471720e-13, -6.6360763075353555415e-7],
        [8.3693042607927253186e-13, 9.1483901648244762611e-7],
    ),
    (
        100.0,
        125,
        [3.8728261293918431650e-21, -6.2232034591453324627e-11],
        [2.9613259274122086916e-19, -5.4418066185892793913e-10],
    ),
    (
        1000.0,
        1010,
        [8.4214550711369802626e-4, -2.9007521404948514467e-2],
        [8.9645278485599784846e-5, -9.4676946618300393996e-3],
    ),
    (
        1000.0,
        1040,
        [4.7473265942767187853e-14, 2.1788360641123263302e-7],
        [2.5023887253443922639e-14, 1.5818940310097669891e-7],
    ),
    (
        1000.0,
        1065,
        [4.5090732749189162129e-28, -2.1234578580510883812e-14],
        [1.7887233040662419651e-27, -4.2293300936037635854e-14],
    ),
];

fn tunnelling() -> f64 {
    worst(TUNNELLING.into_iter().flat_map(|(x, n, a, b)| {
        let sphere = sphere((x, 1.333, 0.0));
        let (found_a, found_b) = (sphere.waves().a()[n - 1], sphere.waves().b()[n - 1]);
        [
            relative(found_a.re, a[0]),
            relative(found_a.im, a[1]),
            relative(found_b.re, b[0]),
            relative(found_b.im, b[1]),
        ]
    }))
}

fn light_from_nothing() -> f64 {
    let angles = degrees(&[0.0, 1e-9, 0.01, 90.0, 138.0, 179.99, 180.0]);
    let sizes = [1e-6, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e3, 1e4];
    violations(sizes.into_iter().flat_map(|x| {
        INDICES.map(|(n, k)| {
            let sphere = sphere((x, n, k));
            let q = sphere.efficiencies();
            let p11 = sphere.p11(&sphere.amplitudes(&angles));
            q.q_sca >= 0.0
                && q.q_abs() >= -1e-14 * q.q_ext
                && q.asymmetry.abs() <= 1.0
                && p11.iter().all(|p| p.is_finite() && *p >= 0.0)
        })
    }))
}

fn not_a_number_in_an_order() -> f64 {
    let spheres = [1e-6, 0.1, 10.0, 1e3]
        .into_iter()
        .flat_map(|x| INDICES.map(|(n, k)| sphere((x, n, k))));
    let n_violations = spheres.map(|sphere| {
        let series = sphere.debye_series();
        violations((0..8).map(|order| {
            let waves = series.order(order);
            let mut coefficients = waves.a().iter().chain(waves.b());
            coefficients.all(|c| c.is_finite())
        }))
    });
    n_violations.sum()
}

fn air_in_air() -> f64 {
    worst([0.1, 100.0, 1e4].into_iter().flat_map(|x| {
        let sphere = sphere((x, 1.0, 0.0));
        let q = sphere.efficiencies();
        let amplitudes = sphere.amplitudes(&degrees(&[0.0, 30.0, 180.0]));
        // What passes through cancels the shadow, wave by wave.
        let (shadow, through) = (sphere.debye(0), sphere.debye(1));
        let sums = shadow.a().iter().zip(through.a());
        let sums = sums.map(|(shadow, through)| (shadow + through).norm());
        let efficiencies = [q.q_ext, q.q_sca, q.q_back, q.asymmetry].map(f64::abs);
        let scattered = amplitudes.s1.iter().map(|s1| s1.norm());
        efficiencies
            .into_iter()
            .chain(sums)
            .chain(scattered)
            .collect::<Vec<_>>()
    }))
}

fn debye_sum() -> f64 {
    // Absorption makes the series short: each passage keeps exp(-4 k x cos r) of the intensity.
    let sphere = sphere((100.0, 1.333, 0.02));
    let angles = degrees(&[0.0, 10.0, 90.0, 138.0, 179.0, 180.0]);
    let mie = sphere.amplitudes(&angles).s1;
    let series = sphere.debye_series();
    let orders: Vec<_> = (0..20)
        .map(|order| series.order(order).amplitudes(&angles).s1)
        .collect();
    worst(mie.iter().enumerate().map(|(place, mie)| {
        let rest = orders.iter().fold(*mie, |rest, s1| rest - s1[place]);
        rest.norm() / mie.norm()
    }))
}

fn impossible_spheres() -> f64 {
    let water = RefractiveIndex::from(1.333);
    let sizes = [0.0, -1.0, 1e-7, 1e6, f64::NAN, f64::INFINITY];
    let indices = [
        (1.333, -1e-9),
        (0.0, 0.0),
        (-1.3, 0.0),
        (f64::NAN, 0.0),
        (1.3, f64::NAN),
        (1e9, 0.0),
    ];
    let radii = [(0.0, 500.0), (1.0, 0.0)];
    let of_size = |x| matches!(Sphere::new(x, water), Err(Error::SizeParameter { .. }));
    let of_index = |(n, k)| {
        let sphere = Sphere::new(1.0, RefractiveIndex { n, k });
        matches!(sphere, Err(Error::RefractiveIndex { .. }))
    };
    violations(sizes.map(of_size))
        + violations(indices.map(of_index))
        + violations(radii.map(|(radius_um, wavelength_nm)| {
            let (radius, wavelength) = (Micrometers(radius_um), Nanometers(wavelength_nm));
            Sphere::from_radius(radius, wavelength, water).is_err()
        }))
}
