//! Claims about gusts.

use niji_dropfield::Drops;
use niji_dropfield::GridBox;

use super::*;

fn gusts() -> Turbulence {
    Turbulence {
        strength: 0.8,
        eddy_m: 5.0,
        seed: 7,
        time_s: 0.0,
        wind_m_s: [3.0, 0.0, 0.0],
    }
}

/// Points that fill a cube of 200 m evenly (additive recurrence of the plastic number's kin).
fn points(n: u32) -> impl Iterator<Item = DVec3> {
    (0..n).map(|index| {
        let i = f64::from(index);
        let along = |step: f64| 200.0 * (i * step).fract();
        DVec3::new(
            along(0.819_172_513_396_164),
            along(0.671_043_606_703_789),
            along(0.549_700_477_901_970),
        )
    })
}

/// Large drops below, small ones above, in numbers that differ by a factor 1000.
fn rain_and_mist() -> DropMode {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::new(24.0, 24.0, 12.0),
        voxel_m: 0.75,
    };
    DropMode::from_fn("", &grid, |position| {
        let share = position.y / 24.0;
        Drops {
            number_density_m3: (1e3 * 1000.0_f64.powf(share)) as f32,
            effective_radius_m: (5e-4 * 0.05_f64.powf(share)) as f32,
            effective_variance: 0.1,
        }
    })
    .unwrap()
}

fn noise(gusts: &Turbulence, point: DVec3) -> f64 {
    squeezed(gusts.noise().sum(point))
}

#[test]
fn nodes_of_a_leaf_have_the_noise_of_their_places() {
    let mode = rain_and_mist();
    // Cells of the lattice that are as large as leaves, as voxels, and smaller.
    for eddy_m in [40.0, 5.0, 0.3] {
        let gusts = Turbulence { eddy_m, ..gusts() };
        for leaf in mode.leaves() {
            let found = gusts.noise().of_leaf(&mode, leaf);
            for (place, drops) in leaf.drops.iter().enumerate() {
                let expected = noise(&gusts, mode.node_position(leaf.node(place)));
                assert!(!drops.exist() || (found[place] - expected).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn noise_has_the_spread_that_its_fade_gives() {
    // S² = (2 ∫ f² t² dt)(2 ∫ f² dt)³ by the trapezoidal rule.
    let n = 4096;
    let at = |index: i32| f64::from(index) / f64::from(n);
    let integral = |power: i32| -> f64 {
        let sum: f64 = (0..n)
            .map(|i| fade(at(i)).powi(2) * at(i).powi(power))
            .sum();
        2.0 * (sum - if power == 0 { 0.5 } else { 0.0 }) / f64::from(n)
    };
    let closed = (integral(2) * integral(0).powi(3)).sqrt();
    assert!((closed / NOISE_RMS - 1.0).abs() < 1e-6, "{closed}");
    let square = |point: DVec3| gradient_noise((0.37 * point).extend(0.11 * point.x), 3).powi(2);
    let measured = (points(100_000).map(square).sum::<f64>() / 1e5).sqrt();
    // Measured 0.07 % off, the scatter of the points.
    assert!((measured / NOISE_RMS - 1.0).abs() < 0.02, "{measured}");
}

#[test]
fn noise_is_balanced_and_uses_its_range() {
    let n = 100_000;
    let values: Vec<f64> = points(n).map(|point| noise(&gusts(), point)).collect();
    let mean = values.iter().sum::<f64>() / f64::from(n);
    let largest = values.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let strong = values.iter().filter(|value| value.abs() > 0.5).count();
    assert!(mean.abs() < 0.02, "{mean}");
    assert!(largest < 1.0 && largest > 0.9, "{largest}");
    // A normal x squeezed by x/sqrt(1 + x²) has 56 % beyond 1/2.
    assert!(
        (strong as f64 / f64::from(n) - 0.56).abs() < 0.03,
        "{strong}"
    );
}

#[test]
fn one_octave_stays_within_its_bound_and_vanishes_at_corners() {
    for point in points(100_000) {
        let value = gradient_noise((0.61 * point).extend(0.23 * point.y), 11);
        assert!(value.abs() <= 1.0);
    }
    for corner in [-3.0, 0.0, 5.0] {
        assert_eq!(gradient_noise(DVec4::new(corner, 1.0, -2.0, 4.0), 11), 0.0);
    }
}

/// |grad n| <= 1 + 2 (15/8) sqrt(4): the weighted gradients, and per axis the steepest fade, 15/8,
/// times the difference of two products of at most 1.
const STEEPEST_NOISE: f64 = 8.5;

#[test]
fn noise_is_continuous_in_space_and_time() {
    let gusts = gusts();
    let (mut steepness, mut variance) = (0.0, 0.0);
    for octave in 0..N_OCTAVES {
        let finer = f64::from(1_u32 << octave);
        steepness += finer.powf(2.0 / 3.0) * STEEPEST_NOISE / gusts.eddy_m;
        variance += finer.powf(-2.0 / 3.0);
    }
    let per_meter = steepness / (NOISE_RMS * variance.sqrt());
    let mut worst = 0.0_f64;
    for point in points(20_000) {
        for (distance_m, along) in [(1e-3, DVec3::X), (1e-3, DVec3::Y), (0.1, DVec3::Z)] {
            let change = noise(&gusts, point + distance_m * along) - noise(&gusts, point);
            worst = worst.max(change.abs() / distance_m / per_meter);
        }
        let later = Turbulence {
            time_s: 1e-3,
            ..gusts
        };
        // The wind carries the eddies past at 3 m/s; they change within 6.4 s besides.
        let change = noise(&later, point) - noise(&gusts, point);
        worst = worst.max(change.abs() / 1e-3 / (per_meter * 3.3));
    }
    assert!(worst < 1.0 && worst > 0.05, "{worst}");
}

#[test]
fn a_seed_gives_its_pattern_on_any_number_of_threads() {
    let stir = || gusts().stir(rain_and_mist()).unwrap();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert_eq!(pool.install(stir), stir());
    let other = Turbulence { seed: 8, ..gusts() };
    let correlation = correlation(&gusts(), &other);
    assert!(correlation.abs() < 0.05, "{correlation}");
    // The pattern is part of scene files: it may not change unnoticed.
    let known = noise(&gusts(), DVec3::new(1.0, 2.0, 3.0));
    assert!((known - PATTERN_OF_SEED_7).abs() < 1e-12, "{known:.15}");
}

/// Noise of seed 7 at (1, 2, 3) m.
const PATTERN_OF_SEED_7: f64 = -0.589_742_099_762_811;

fn correlation(a: &Turbulence, b: &Turbulence) -> f64 {
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for point in points(20_000) {
        let (one, other) = (noise(a, point), noise(b, point));
        aa += one * one;
        bb += other * other;
        ab += one * other;
    }
    ab / (aa * bb).sqrt()
}

#[test]
fn water_stays_and_numbers_stay_within_bounds() {
    let before = rain_and_mist();
    for (strength, seed) in [(0.0, 1), (0.5, 1), (1.0, 2), (1.0, 3)] {
        let gusts = Turbulence {
            strength,
            seed,
            ..gusts()
        };
        let after = gusts.stir(before.clone()).unwrap();
        let lost = after.total_water_g() / before.total_water_g() - 1.0;
        // Measured worst 8e-9: f32 number densities.
        assert!(lost.abs() < 1e-7, "{strength} {seed}: {lost:e}");
        for (node, drops) in before.nodes() {
            let stirred = after.drops(node);
            let factor = f64::from(stirred.number_density_m3 / drops.number_density_m3);
            assert!(factor >= 0.0 && factor <= gusts.max_factor() * (1.0 + 1e-6));
            assert_eq!(stirred.effective_radius_m, drops.effective_radius_m);
        }
        assert_eq!(strength == 0.0, after == before);
    }
}

#[test]
fn eddies_ride_on_the_wind_and_change_within_a_few_turnovers() {
    let calm = Turbulence {
        wind_m_s: [0.0; 3],
        ..gusts()
    };
    assert!((calm.turnover_s() - 10.0).abs() < 1e-12);
    let after = |turnovers: f64| Turbulence {
        time_s: turnovers * calm.turnover_s(),
        ..calm
    };
    assert!(correlation(&calm, &after(0.05)) > 0.9);
    let half = correlation(&calm, &after(0.3));
    assert!(half > 0.3 && half < 0.9, "{half}");
    assert!(correlation(&calm, &after(3.0)).abs() < 0.05);
    // A short time later the pattern has moved by wind times time.
    let windy = gusts();
    let later = Turbulence {
        time_s: 0.2,
        ..windy
    };
    let (mut moved, mut left) = (0.0, 0.0);
    for point in points(5000) {
        let value = noise(&later, point);
        moved += (value - noise(&windy, point - DVec3::new(0.6, 0.0, 0.0))).powi(2);
        left += (value - noise(&windy, point)).powi(2);
    }
    assert!(moved < 0.1 * left, "{moved} {left}");
}

#[test]
fn wrong_parameters_are_refused() {
    let sound = gusts();
    for wrong in [
        Turbulence {
            strength: 1.01,
            ..sound
        },
        Turbulence {
            strength: f64::NAN,
            ..sound
        },
        Turbulence {
            eddy_m: 0.0,
            ..sound
        },
        Turbulence {
            time_s: f64::INFINITY,
            ..sound
        },
        Turbulence {
            wind_m_s: [0.0, f64::NAN, 0.0],
            ..sound
        },
    ] {
        assert!(wrong.validate().is_err(), "{wrong:?}");
        assert!(wrong.stir(rain_and_mist()).is_err());
    }
}

#[test]
fn air_without_drops_stays_empty() {
    let grid = GridBox {
        min: DVec3::ZERO,
        max: DVec3::ONE,
        voxel_m: 0.5,
    };
    let empty = DropMode::from_fn("", &grid, |_| Drops::NONE).unwrap();
    assert_eq!(gusts().stir(empty).unwrap().nodes().count(), 0);
}
