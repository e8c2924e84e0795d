//! Hard cases of drop sizes: laws of no width, cuts of no width and far out in a tail, laws of which
//! a moment diverges.

use std::f64::consts::PI;

use niji_radiometry::Micrometers;
use niji_sizes::GammaSizes;
use niji_sizes::HansenTravis;
use niji_sizes::Lognormal;
use niji_sizes::MarshallPalmer;
use niji_sizes::Monodisperse;
use niji_sizes::Normal;
use niji_sizes::RosinRammler;
use niji_sizes::SizeLaw;
use niji_sizes::TruncatedNormal;
use niji_sizes::Ulbrich;
use niji_sizes::Uniform;
use niji_sizes::gamma_area_quadrature;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "a gamma law narrows to a single size without losing its width",
        measure: "relative error of the variance of nodes, v_e from 1e-12 to 0.1",
        // Of the radii, whose rounding is 2e-16 and whose spread 1e-6; measured 1.1e-6.
        allowed: 5e-6,
        error: vanishing_variance,
    },
    HardCase {
        claim: "the density of a law of v_e = 1e-12 keeps its digits",
        measure: "error of its logarithm against 40 digits",
        allowed: 2e-14,
        error: narrow_density,
    },
    HardCase {
        claim: "a cut of a millionth of the diameter is a box of that width",
        measure: "relative error of v_e = w^2/12, 8e-14",
        allowed: 1e-5,
        error: narrow_cut,
    },
    HardCase {
        claim: "a cut 290 e-foldings out in a tail keeps its mean sizes",
        measure: "relative error of r_e against the closed form",
        allowed: 1e-12,
        error: cut_in_the_tail,
    },
    HardCase {
        claim: "a spray of n = 3.000001 has the radius of the closed form",
        measure: "relative error of r_e = X/(2 Gamma(2/3))",
        allowed: 1e-6,
        error: nearly_divergent_spray,
    },
    HardCase {
        claim: "a spray whose number or area diverges is refused",
        measure: "accepted laws",
        allowed: 0.0,
        error: divergent_sprays,
    },
    HardCase {
        claim: "parameters that are 0, negative, NaN or infinite are refused",
        measure: "accepted laws",
        allowed: 0.0,
        error: impossible_parameters,
    },
];

fn vanishing_variance() -> f64 {
    worst([1e-12, 1e-9, 1e-6, 1e-3, 0.02, 0.1].map(|variance| {
        let nodes = gamma_area_quadrature(Micrometers(100.0), variance, 64)
            .expect("a variance from 0 to 1/2");
        let moment = |power: i32| -> f64 {
            let terms = nodes.iter();
            terms
                .map(|(radius_um, weight)| weight * (radius_um / 100.0 - 1.0).powi(power))
                .sum()
        };
        // Weighted by cross-section the radius over r_e has mean 1 and variance v_e.
        relative(moment(2) / moment(0), variance)
    }))
}

fn narrow_density() -> f64 {
    // 40-digit arithmetic, k ln k - ln Gamma(k) + (k - 1) ln x - k x with k = 1/v_e.
    let places = [
        (1e-6, 1e-3, 5.488150245644214),
        (1e-12, 2e-6, 10.896572691424185),
        (1e-12, 0.0, 12.89657202475952),
    ];
    worst(places.map(|(variance, off, expected)| {
        let law = GammaSizes::new(Micrometers(1.0), variance).expect("a variance from 0 to 1/2");
        (law.ln_area_density(off) - expected).abs()
    }))
}

fn rain(d_min_mm: f64, d_max_mm: Option<f64>) -> MarshallPalmer {
    MarshallPalmer {
        rain_rate_mm_h: 5.0,
        d_min_mm: Some(d_min_mm),
        d_max_mm,
    }
}

fn narrow_cut() -> f64 {
    let moments = rain(1.0, Some(1.000_001)).moments();
    let width = (1.000_001 - 1.0) / 1.000_000_5;
    let radius = relative(moments.effective_radius().0, 500.000_25);
    relative(moments.effective_variance, width * width / 12.0).max(radius)
}

fn cut_in_the_tail() -> f64 {
    // Marshall and Palmer (1948): N(D) ~ exp(-D/s) with s = R^0.21/4.1 mm. Beyond d,
    // <D^2> = d^2 + 2 d s + 2 s^2 and <D^3> = d^3 + 3 d^2 s + 6 d s^2 + 6 s^3.
    let s = 5_f64.powf(0.21) / 4.1;
    worst([6.0, 30.0, 100.0].map(|d: f64| {
        let square = d * d + 2.0 * d * s + 2.0 * s * s;
        let cube = d.powi(3) + 3.0 * d * d * s + 6.0 * d * s * s + 6.0 * s.powi(3);
        relative(
            rain(d, None).moments().effective_radius().0,
            500.0 * cube / square,
        )
    }))
}

fn spray(spread: f64, d_min_mm: Option<f64>) -> RosinRammler {
    RosinRammler {
        diameter_mm: 1.0,
        spread,
        d_min_mm,
        d_max_mm: None,
    }
}

fn nearly_divergent_spray() -> f64 {
    let law = spray(3.000_001, None);
    // r_e = X/(2 Gamma(1 - 1/n)), v_e = (pi/n)/sin(pi/n) - 1; Gamma(2/3) = 1.3541179394264.
    let variance = PI / 3.0 / (PI / 3.0).sin() - 1.0;
    let moments = law.moments();
    let radius = relative(moments.effective_radius().0, 500.0 / 1.3541179394264004);
    let is_accepted = violations([law.validate().is_ok()]);
    worst([
        radius,
        relative(moments.effective_variance, variance),
        is_accepted,
    ])
}

fn divergent_sprays() -> f64 {
    let spreads = [0.5, 1.0, 1.5, 2.0, 3.0].into_iter();
    violations(
        spreads
            .flat_map(|spread| [None, Some(0.0)].map(|cut| spray(spread, cut).validate().is_err())),
    )
}

fn impossible_parameters() -> f64 {
    let laws = [0.0, -1.0, f64::NAN, f64::INFINITY]
        .into_iter()
        .flat_map(|bad| {
            [
                SizeLaw::Monodisperse(Monodisperse { radius_um: bad }),
                SizeLaw::Uniform(Uniform {
                    radius_min_um: bad,
                    radius_max_um: bad,
                }),
                SizeLaw::Normal(Normal {
                    radius_mean_um: bad,
                    radius_standard_deviation_um: 1.0,
                }),
                SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(bad)),
                SizeLaw::MarshallPalmer(rain(2.0, Some(bad))),
                SizeLaw::HansenTravis(HansenTravis {
                    effective_radius_um: bad,
                    effective_variance: 0.1,
                    d_min_mm: None,
                    d_max_mm: None,
                }),
                SizeLaw::Ulbrich(Ulbrich {
                    shape: 2.0,
                    slope_per_mm: bad,
                    d_min_mm: None,
                    d_max_mm: None,
                }),
                SizeLaw::Lognormal(Lognormal {
                    radius_median_um: bad,
                    geometric_standard_deviation: 2.0,
                    d_min_mm: None,
                    d_max_mm: None,
                }),
                SizeLaw::RosinRammler(spray(bad, Some(0.1))),
                SizeLaw::TruncatedNormal(TruncatedNormal {
                    radius_mean_um: 50.0,
                    radius_standard_deviation_um: bad,
                    d_min_mm: 0.05,
                    d_max_mm: 0.2,
                }),
            ]
        });
    violations(laws.map(|law| law.validate().is_err()))
}
