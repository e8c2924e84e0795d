//! Bows of rain in the picture against sums over thousands of radii.
//!
//! The picture is made from the table that a plan asks for at a preset, in green light and with the sun's disc;
//! the reference is in `literal`. Theory and shift of a single drop are the same in both: what is held here is
//! how light is summed over sizes. A drop volume knows a law by its effective radius and variance alone, so the
//! reference of any law is the gamma law of these.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

#[path = "../../../render/tests/common/mod.rs"]
mod common;
mod fraser;
mod literal;
mod profile;
mod rain;
#[allow(dead_code, reason = "the tests of shifts use the rest")]
#[path = "../../../scatter/src/spheroid_trace.rs"]
mod spheroid_trace;
#[path = "../support/mod.rs"]
mod support;

use niji_sizes::Lognormal;
use niji_sizes::MarshallPalmer;

use literal::Literal;
use profile::Place;
use rain::Rain;
use rain::STILL;

/// Where m, by which the bow moves, is 1, 0.77, 0 and -1: at the top, at the feet of a setting sun, and at the
/// lowest point of the circle.
const PLACES: [Place; 4] = [
    Place::new(21.0, 0.0),
    Place::new(0.0, 0.0),
    Place::new(0.0, 90.0),
    Place::new(69.0, 180.0),
];

/// A preset and how far it may err: the root mean square of the errors from 30 to 50 degrees from the antisolar
/// point, in parts of the bow's peak.
type Bound = (&'static str, f64);
/// Goals. Measured worst 2.5e-3 and 4.4e-4, of spheres 2.0e-3 and 1.8e-4.
const STANDARD: Bound = ("standard", 5e-3);
const REFERENCE: Bound = ("reference", 5e-4);
fn rms_error(found: &[f64], expected: &[f64]) -> f64 {
    let peak = expected.iter().copied().fold(0.0, f64::max);
    let both = found.iter().zip(expected);
    let squares: f64 = both
        .map(|(found, expected)| (found - expected).powi(2))
        .sum();
    (squares / expected.len() as f64).sqrt() / peak
}

/// Holds pictures of rain against their reference, as spheres and flat.
fn check((name, rain): (&str, &Rain)) -> Literal {
    let literal = Literal::gamma(rain);
    let hold = |(preset, bound): Bound, place: Place, light: [Vec<f64>; 2]| {
        let [found, expected] = light;
        let error = rms_error(&found, &expected);
        println!("{name}, {preset}, m {:.2}: {error:.1e}", place.m());
        assert!(error < bound, "{name}: {error}");
    };
    let of_spheres = literal.of_spheres(&PLACES[0].sights());
    let of_flat_drops = PLACES.map(|place| literal.of_flat_drops(&place.sights()));
    for bound in [STANDARD, REFERENCE] {
        let table = rain.table(bound.0, None);
        let found = PLACES[0].picture(rain, &table);
        hold(bound, PLACES[0], [found, of_spheres.clone()]);
        let table = rain.table(bound.0, Some(STILL));
        for (place, expected) in PLACES.into_iter().zip(&of_flat_drops) {
            hold(
                bound,
                place,
                [place.picture(rain, &table), expected.clone()],
            );
        }
    }
    literal
}

#[test]
fn bows_of_natural_rain_are_the_literal_sum_over_its_radii() {
    for rate_mm_h in [1.0, 5.0, 25.0] {
        let rain = Rain::of(&MarshallPalmer::untruncated(rate_mm_h).moments());
        check((&format!("{rate_mm_h} mm/h"), &rain));
    }
}

#[test]
fn bows_of_narrow_laws_and_of_two_modes_are_the_literal_sum_over_their_radii() {
    check(("gamma", &Rain(vec![(300.0, 0.1)])));
    check(("two modes", &Rain(vec![(200.0, 0.02), (500.0, 0.005)])));
}

/// Radii of the lognormal law; their reach in standard deviations either way.
const N_LOGNORMAL: i32 = 2400;
const REACH: f64 = 6.0;

#[test]
fn bows_of_a_lognormal_law_are_those_of_its_gamma_law() {
    let law = Lognormal {
        radius_median_um: 200.0,
        geometric_standard_deviation: 1.4,
        d_min_mm: None,
        d_max_mm: None,
    };
    let rain = Rain::of(&law.moments());
    let gamma = check(("lognormal", &rain));
    // By cross-section ln r is normal about ln r_g + 2 s²: what the volume no longer knows.
    let s = law.geometric_standard_deviation.ln();
    let radius = |step: i32| {
        let t = REACH * (2.0 * f64::from(step) / f64::from(N_LOGNORMAL) - 1.0);
        let radius_um = law.radius_median_um * (s * (t + 2.0 * s)).exp();
        (radius_um, (-0.5 * t * t).exp())
    };
    let mut radii: Vec<(f64, f64)> = (0..=N_LOGNORMAL).map(radius).collect();
    let total: f64 = radii.iter().map(|(_, share)| share).sum();
    for (_, share) in &mut radii {
        *share /= total;
    }
    let mean_um: f64 = radii
        .iter()
        .map(|(radius_um, share)| radius_um * share)
        .sum();
    assert!((mean_um / rain.0[0].0 - 1.0).abs() < 1e-6, "{mean_um}");
    let lognormal = Literal::of(radii);
    for place in PLACES {
        let sights = place.sights();
        let [spheres, flat] = [
            rms_error(&gamma.of_spheres(&sights), &lognormal.of_spheres(&sights)),
            rms_error(
                &gamma.of_flat_drops(&sights),
                &lognormal.of_flat_drops(&sights),
            ),
        ];
        println!(
            "gamma for lognormal, m {:.2}: {spheres:.1e} {flat:.1e}",
            place.m()
        );
    }
}
