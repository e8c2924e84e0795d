//! References in 60-digit arithmetic (mpmath): h = sqrt(r0^2 + 2 r0 mu s + s^2) - R and the roots
//! of the quadratic, from the decimal inputs as f64 holds them.

use super::*;

/// (h0, mu, s, height, cosine of the zenith angle there).
const ALONG_RAY: [(f64, f64, f64, f64, f64); 9] = [
    (
        0.0,
        0.0,
        20.0,
        0.000031392246115132202706,
        3.139224611505486217e-6,
    ),
    (
        0.0,
        0.0,
        500000.0,
        19590.035356672760254,
        0.078240036871977801669,
    ),
    (
        2.0,
        -0.0005,
        20.0,
        1.9900313922284616185,
        -0.00049686077715138219558,
    ),
    (
        -5.0,
        0.1,
        100000.0,
        10770.693939496288259,
        0.11550078110766232136,
    ),
    (
        1.7,
        1e-09,
        500000.0,
        19591.730643876118776,
        0.078240017113505202976,
    ),
    (
        120000.0,
        -0.3,
        1000000.0,
        -106937.34067099228668,
        -0.15122773374388189323,
    ),
    (0.0, 1.0, 20.0, 20.0, 1.0),
    (
        1500.0,
        -0.02,
        500000.0,
        11108.29193613730531,
        0.058374127006074300313,
    ),
    (
        0.003,
        0.0,
        0.001,
        0.0030000000000784806777,
        1.569612305021372358e-10,
    ),
];

/// (h0, mu, shell height, nearer root, farther root).
const SHELLS: [(f64, f64, f64, f64, f64); 12] = [
    (0.0, 0.0, 1e5, -1133225.485064645023, 1133225.485064645023),
    (0.0, 1.0, 1e5, -12842000.0, 100000.0),
    (
        99990.0,
        0.0,
        1e5,
        -11376.286740408752549,
        11376.286740408752549,
    ),
    (
        0.0,
        0.0,
        10.0,
        -11288.051204703139545,
        11288.051204703139545,
    ),
    (
        2.0,
        -0.0001,
        1e5,
        -1132577.3198868010663,
        1133851.5202868010663,
    ),
    (
        -5.0,
        0.2,
        0.0,
        -2548422.9997645627301,
        24.999764562588658286,
    ),
    (4e5, -0.5, 1e5, 648894.39268278922866, 6122105.6073172107713),
    (
        3.6e7,
        -0.99,
        1e5,
        39467907.346172646489,
        44426672.653827352758,
    ),
    (1e5, 0.3, 1e5, -3882599.9999999998563, 0.0),
    (1e5, -0.01, 1e5, 0.0, 129420.00000000000269),
    (
        2000.0,
        -0.03,
        0.0,
        85996.767803246967712,
        296383.23219675301814,
    ),
    (
        2e-3,
        -0.01,
        0.0,
        0.20000031389205418588,
        127419.8000396861106,
    ),
];

/// Relative to the larger of height and rise; worst found 1.9e-16.
const HEIGHT_TOLERANCE: f64 = 1e-15;
/// Relative to the root; worst found 2.2e-16.
const ROOT_TOLERANCE: f64 = 1e-15;

#[test]
fn heights_along_rays_agree_with_60_digits_from_millimetres_to_500_km() {
    for (h0, mu, s, height, cosine) in ALONG_RAY {
        let found = EARTH.height_along_ray(h0, mu, s);
        let scale = h0.abs().max((height - h0).abs());
        assert!(
            (found - height).abs() <= HEIGHT_TOLERANCE * scale,
            "{h0} {mu} {s}: {found}"
        );
        let found = EARTH.cos_zenith_along_ray(h0, mu, s);
        assert!(
            (found - cosine).abs() <= 1e-15 * cosine.abs(),
            "{h0} {mu} {s}: {found}"
        );
    }
}

#[test]
fn crossings_of_shells_agree_with_60_digits() {
    for (h0, mu, shell, near, far) in SHELLS {
        let (enter, leave) = EARTH.shell_chord(h0, mu, shell).unwrap();
        let is_close = |found: f64, root: f64| {
            (found - root.max(0.0)).abs() <= ROOT_TOLERANCE * root.abs().max(1e-12)
        };
        assert!(
            is_close(enter, near),
            "{h0} {mu} {shell}: enters at {enter}"
        );
        assert!(is_close(leave, far), "{h0} {mu} {shell}: leaves at {leave}");
        let first = EARTH.distance_to_shell(h0, mu, shell).unwrap();
        assert!(
            is_close(first, if near >= 0.0 { near } else { far }),
            "{h0} {mu} {shell}: {first}"
        );
    }
}

#[test]
fn a_ray_that_starts_on_the_top_of_the_air_and_leads_down_still_crosses_the_air() {
    let (enter, leave) = EARTH.shell_chord(1e5, -0.01, 1e5).unwrap();
    assert!(enter <= 0.0 && leave > 129_000.0);
    assert_eq!(EARTH.shell_chord(1e5, 0.0, 1e5), Some((0.0, 0.0)));
}

#[test]
fn an_observer_above_the_air_sees_it_only_downwards() {
    assert_eq!(EARTH.shell_chord(4e5, 0.1, 1e5), None);
    assert_eq!(EARTH.shell_chord(4e5, 0.0, 1e5), None);
    // The horizon of the shell from 400 km: sqrt(1 - ((R + t)/(R + h))^2) = 0.29463.
    assert_eq!(EARTH.shell_chord(4e5, -0.29, 1e5), None);
    assert!(EARTH.shell_chord(4e5, -0.30, 1e5).is_some());
    assert_eq!(EARTH.distance_to_shell(4e5, -0.1, 1e5), None);
}

#[test]
fn the_crossing_lies_at_the_height_of_the_shell() {
    for (h0, mu, shell, _, _) in SHELLS {
        let s = EARTH.distance_to_shell(h0, mu, shell).unwrap();
        let height = EARTH.height_along_ray(h0, mu, s);
        // Worst found 7.8e-17 of the path.
        assert!(
            (height - shell).abs() <= 1e-15 * (s + shell),
            "{h0} {mu}: {height}"
        );
    }
}

#[test]
fn the_horizon_dips_as_navigators_know() {
    for (height, dip) in [
        (2.0, 0.00079236655536356120447),
        (20.0, 0.0025056801069837248351),
        (200.0, 0.0079235629497860657516),
        (2000.0, 0.025053557048271261073),
        (1e5, 0.17603141188087335172),
    ] {
        let found = EARTH.horizon_dip(height).0;
        assert!((found / dip - 1.0).abs() <= 5e-16, "{height} m: {found}");
    }
    assert!(EARTH.horizon_dip(0.0).0 <= 0.0 && EARTH.horizon_dip(-50.0).0 <= 0.0);
}

#[test]
fn perigees_agree_with_60_digits() {
    for (h0, mu, perigee) in [
        (2.0_f64, -1e-3, -1.1855017963756483205_f64),
        (2000.0, -0.025, 8.1262210771094167087),
        (1e5, -0.2, -30740.749780021825291),
        (0.0, -1e-6, -3.1855000000007960867e-6),
        (4e5, -0.99, -5415832.9068168225435),
    ] {
        let found = EARTH.perigee_height(h0, mu);
        let scale = h0.abs() + perigee.abs();
        // Worst found 2.1e-16.
        assert!(
            (found - perigee).abs() <= 1e-15 * scale,
            "{h0} {mu}: {found}"
        );
    }
}

#[test]
fn the_sun_seen_from_2_km_sets_at_a_zenith_angle_of_91_43_degrees() {
    let cosine = |zenith_deg: f64| zenith_deg.to_radians().cos();
    assert!(!EARTH.hits_ground(2000.0, cosine(91.43)));
    assert!(EARTH.hits_ground(2000.0, cosine(91.44)));
}

#[test]
fn the_ground_ends_exactly_the_rays_whose_perigee_lies_below_it() {
    for height in [0.5, 2.0, 1e3, 1e5, 4e5] {
        let dip = EARTH.horizon_dip(height).0;
        for (factor, is_hit) in [
            (0.5, false),
            (1.0 - 1e-9, false),
            (1.0 + 1e-9, true),
            (2.0, true),
        ] {
            let cosine = -(factor * dip).sin();
            assert_eq!(
                EARTH.hits_ground(height, cosine),
                is_hit,
                "{height} m, {factor}"
            );
            assert_eq!(
                EARTH.perigee_height(height, cosine) < 0.0,
                is_hit,
                "{height} m, {factor}"
            );
        }
        assert_eq!(EARTH.distance_to_ground(height, 0.0), None);
        let straight_down = EARTH.distance_to_ground(height, -1.0).unwrap();
        assert!(
            (straight_down / height - 1.0).abs() <= 1e-15,
            "{straight_down}"
        );
    }
}

#[test]
fn heights_of_points_agree_with_60_digits() {
    for ([x, y, z], height) in [
        ([0.0, 100.0, 0.0], 100.0),
        ([1e3, 0.0, 0.0], 0.0784806148046455109),
        ([3e5, -1e3, 4e5], 18593.101285871395969),
        ([1e-3, 1e-3, 0.0], 0.0010000000000784806361),
        ([1e6, 2e5, -1e6], 350461.22506111017735),
        ([0.0, -5.0, 0.0], -5.0),
    ] {
        let found = EARTH.height_m(DVec3::new(x, y, z));
        assert!(
            (found - height).abs() <= 1e-15 * height.abs(),
            "{x} {y} {z}: {found}"
        );
    }
}

#[test]
fn heights_of_points_are_those_along_the_ray_to_them() {
    let origin = DVec3::new(0.0, 30.0, 0.0);
    let direction = DVec3::new(0.6, -0.01, -0.79).normalize();
    let cosine = EARTH.cos_zenith(origin, direction);
    for s in [20.0, 1e3, 5e4, 5e5] {
        let along = EARTH.height_along_ray(30.0, cosine, s);
        let direct = EARTH.height_m(origin + s * direction);
        assert!(
            (along - direct).abs() <= 1e-15 * s.max(30.0),
            "{s}: {along} {direct}"
        );
    }
}

#[test]
fn nan_gives_no_crossing_and_the_center_a_zenith() {
    assert_eq!(EARTH.shell_chord(f64::NAN, 0.1, 1e5), None);
    assert_eq!(EARTH.shell_chord(0.0, f64::NAN, 1e5), None);
    assert_eq!(EARTH.distance_to_ground(10.0, f64::NAN), None);
    assert_eq!(
        EARTH.zenith(DVec3::new(0.0, -EARTH.radius_m, 0.0)),
        DVec3::Y
    );
}
