//! Claims about waterfalls.

use niji_dropfield::AreaMoments;

use super::*;

/// 20 m high, 6 m wide, towards the west-south-west, so that no axis of the lattice is its own.
fn fall() -> Waterfall {
    Waterfall {
        foot_m: [3.0, 10.0, -80.0],
        azimuth_deg: 250.0,
        height_m: 20.0,
        width_m: 6.0,
        flow_kg_s: 50.0,
        splash_fraction: 0.1,
        mist_fraction: 0.01,
        curtain_effective_radius_um: 1000.0,
        splash_effective_radius_um: 300.0,
        mist_effective_radius_um: 40.0,
        wind_xz_m_s: [1.5, -1.0],
        strands: None,
        turbulence: None,
        voxel_m: 1.0,
    }
}

/// Positions of the nodes of a mode with their water (g).
fn water(volume: &DropVolume, name: &str) -> Vec<(DVec3, f64)> {
    let mode = volume.modes.iter().find(|mode| mode.name == name).unwrap();
    let voxel_m3 = mode.voxel_m().powi(3);
    let grams = mode.nodes().map(|(node, drops)| {
        let water = AreaMoments::from_drops(&drops).liquid_water_g_m3();
        (mode.node_position(node), water * voxel_m3)
    });
    grams.collect()
}

fn total(water: &[(DVec3, f64)]) -> f64 {
    water.iter().map(|(_, grams)| grams).sum()
}

#[test]
fn totals_of_the_volume_equal_the_closed_forms_for_any_voxel_and_azimuth() {
    for (voxel_m, azimuth_deg) in [(0.5, 250.0), (1.0, 0.0), (2.0, 45.0), (7.0, 100.0)] {
        let shape = Waterfall {
            azimuth_deg,
            voxel_m,
            ..fall()
        };
        let found = shape.volume().unwrap().summary();
        let water = found.total_water_g / shape.total_water_g() - 1.0;
        let drops = found.total_drops / shape.total_drops() - 1.0;
        // f32.
        assert!(water.abs() < 1e-6, "{voxel_m}: {water:e}");
        assert!(drops.abs() < 1e-6, "{voxel_m}: {drops:e}");
    }
}

#[test]
fn water_of_a_mode_is_its_flow_times_its_stay() {
    let volume = fall().volume().unwrap();
    // 50 kg/s fall 20 m in sqrt(40/9.80665) = 2.01962 s.
    assert!((total(&water(&volume, "curtain")) / 100_980.8 - 1.0).abs() < 1e-5);
    // A tenth, rising 1 m on average: sqrt(2 pi/9.80665) = 0.800437 s.
    assert!((total(&water(&volume, "splash")) / 4002.19 - 1.0).abs() < 1e-5);
}

#[test]
fn as_much_water_passes_every_height_of_the_curtain() {
    let shape = Waterfall {
        azimuth_deg: 37.0,
        ..fall()
    };
    let volume = shape.volume().unwrap();
    let curtain = water(&volume, "curtain");
    for layer in 0..20 {
        let low_m = 10.0 + f64::from(layer);
        let inside = |position: &DVec3| position.y > low_m && position.y < low_m + 1.0;
        let grams: f64 = curtain
            .iter()
            .filter(|(position, _)| inside(position))
            .map(|(_, grams)| grams)
            .sum();
        let fall_s = |y_m: f64| (2.0 * (30.0 - y_m) / 9.80665).sqrt();
        let flux_g_s = grams / (fall_s(low_m) - fall_s(low_m + 1.0));
        // f32.
        assert!((flux_g_s / 5e4 - 1.0).abs() < 1e-6, "{layer}: {flux_g_s}");
    }
}

#[test]
fn a_curtain_far_thinner_than_a_voxel_is_even_along_its_width() {
    // 30 kg/s over 30 m: 2 mm thick at the lip. Columns across the middle of the diagonal sheet.
    let shape = Waterfall {
        azimuth_deg: 45.0,
        width_m: 30.0,
        flow_kg_s: 30.0,
        ..fall()
    };
    let volume = shape.volume().unwrap();
    let curtain = water(&volume, "curtain");
    let across = |x_m: f64| -> f64 {
        let near = |position: &DVec3| (position.x - x_m).abs() < 0.5;
        let column = curtain.iter().filter(|(position, _)| near(position));
        column.map(|(_, grams)| grams).sum()
    };
    let first_m = curtain[0].0.x.rem_euclid(1.0);
    let expected_g = shape.populations()[0].part.water_g() * 2.0_f64.sqrt() / 30.0;
    for index in -4..4 {
        let grams = across(3.0_f64.floor() + first_m + f64::from(index));
        // Measured worst 2e-5.
        assert!((grams / expected_g - 1.0).abs() < 1e-4, "{index}: {grams}");
    }
}

#[test]
fn the_lip_is_a_free_overfall() {
    // 1 m²/s: critical depth (1/9.80665)^(1/3) = 0.46718 m, brink 0.33403 m, 2.99371 m/s.
    let shape = Waterfall {
        flow_kg_s: 6000.0,
        azimuth_deg: 90.0,
        voxel_m: 0.25,
        ..fall()
    };
    let volume = shape.volume().unwrap();
    let curtain = water(&volume, "curtain");
    let middle_m = |low_m: f64, high_m: f64| {
        let layer = |position: &DVec3| position.y > low_m && position.y < high_m;
        let (mut grams, mut moment) = (0.0, 0.0);
        for (position, water) in curtain.iter().filter(|(position, _)| layer(position)) {
            grams += water;
            moment += water * position.x;
        }
        moment / grams
    };
    // Towards the east; mean times of the uppermost and lowest quarter metre: 0.112 and 2.013 s.
    let thrown_m = middle_m(10.0, 10.25) - middle_m(29.75, 30.0);
    let expected_m = 2.993_71 * (2.013_3 - 0.112_9);
    // Half a step, over which the sheet moves by its deviation of 0.084 m; measured 0.018 m.
    assert!((thrown_m - expected_m).abs() < 0.042, "{thrown_m}");
    assert!((middle_m(10.0, 10.25) - 3.0).abs() < 0.042);
}

#[test]
fn splash_is_exponential_upwards_gamma_forwards_and_gaussian_across() {
    let shape = Waterfall {
        azimuth_deg: 130.0,
        voxel_m: 0.5,
        ..fall()
    };
    let volume = shape.volume().unwrap();
    let splash = water(&volume, "splash");
    let all = total(&splash);
    let frame = shape.frame();
    let mean = |value: &dyn Fn(DVec3) -> f64| {
        let sum: f64 = splash.iter().map(|(at, grams)| grams * value(*at)).sum();
        sum / all
    };
    let forward = |at: DVec3| frame.forward.dot(DVec2::new(at.x, at.z) - frame.foot_xz());
    let across = |at: DVec3| {
        frame
            .forward
            .perp()
            .dot(DVec2::new(at.x, at.z) - frame.foot_xz())
    };
    // h0 = 1 m, d = 2 m: mean distance 2 d, 1.1 % less by the cut at 8 d. Rows of parcels stand in
    // the middle of their part of the gamma law: measured 5e-3 less.
    let distance_m = mean(&forward);
    assert!((distance_m / 3.957 - 1.0).abs() < 1e-2, "{distance_m}");
    // Variance across: (6² - 1²)/12 of six parcels side by side, 0.9989 of the Gaussian cut at 4
    // deviations, 0.5²/12 of the voxels.
    let variance = mean(&|at| across(at).powi(2));
    assert!((variance / 3.9364 - 1.0).abs() < 1e-4, "{variance}");
    assert!(mean(&across).abs() < 1e-3);
    // Water above y falls as e^-y, cut at 6.
    for (y_m, share) in [(1.0_f64, 0.366_307), (3.0, 0.047_426)] {
        let above = mean(&|at| f64::from(u8::from(at.y > 10.0 + y_m)));
        assert!((above / share - 1.0).abs() < 1e-4, "{above}");
    }
}

/// A fall towards the east with the wind from behind: the mist drifts along x.
fn eastward(mist_effective_radius_um: f64) -> Waterfall {
    Waterfall {
        azimuth_deg: 90.0,
        wind_xz_m_s: [2.0, 0.0],
        mist_effective_radius_um,
        ..fall()
    }
}

#[test]
fn mist_that_passes_a_plane_is_what_has_not_settled() {
    for radius_um in [10.0, 40.0, 100.0] {
        let shape = eastward(radius_um);
        let volume = shape.volume().unwrap();
        let mist = water(&volume, "mist");
        // Drift: wind and 0.05 of 19.8057 m/s; growth 0.06, from 1 m.
        let drift_m_s = 2.990_28;
        let power = 0.797_885 * terminal_speed_m_s(1e-6 * radius_um) / (0.06 * drift_m_s);
        let mut worst = 0.0_f64;
        for plane in 10..30 {
            let at_m = f64::from(plane) + 0.5;
            let (low_m, high_m) = (at_m - 1.0 + 3.0, at_m + 1.0 + 3.0);
            let slab = mist.iter().filter(|(at, _)| at.x > low_m && at.x < high_m);
            let cells: Vec<_> = slab.collect();
            let columns = cells.iter().map(|(at, _)| at.x);
            let (first, last) =
                columns.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            let length_m = last - first + 1.0;
            let grams: f64 = cells.iter().map(|(_, grams)| grams).sum();
            let middle_m = 0.5 * (first + last) - 3.0;
            let flux_g_s = grams / length_m * drift_m_s;
            let expected_g_s = 500.0 * (1.0 + 0.06 * middle_m).powf(-power);
            worst = worst.max((flux_g_s / expected_g_s - 1.0).abs());
        }
        // The parcels smooth along the drift too; measured worst 6e-3.
        assert!(worst < 0.01, "{radius_um}: {worst}");
    }
}

#[test]
fn nothing_lies_outside_the_box_of_its_part() {
    let shape = fall();
    let volume = shape.volume().unwrap();
    let grid = shape.grid();
    for population in shape.populations() {
        let (low, high) = population.part.extent();
        for (position, _) in water(&volume, population.name) {
            // The middle of a cell that the region only touches.
            assert!(position.cmpge(low - 0.5).all() && position.cmple(high + 0.5).all());
        }
        assert!(low.cmpge(grid.min).all() && high.cmple(grid.max + 1e-5).all());
    }
}

#[test]
fn the_densest_cell_stays_below_the_bound_and_near_it() {
    for (azimuth_deg, width_m, voxel_m) in [
        (250.0, 6.0, 1.0),
        (0.0, 6.0, 0.5),
        (45.0, 0.1, 1.0),
        (30.0, 60.0, 3.0),
    ] {
        let shape = Waterfall {
            azimuth_deg,
            width_m,
            voxel_m,
            ..fall()
        };
        let volume = shape.volume().unwrap();
        for population in shape.populations() {
            let most = water(&volume, population.name)
                .into_iter()
                .fold(0.0_f64, |most, (_, grams)| {
                    most.max(grams / voxel_m.powi(3))
                });
            let ratio = most / population.part.densest_g_m3();
            // Measured 0.26 to 0.69.
            assert!(ratio <= 1.0 && ratio > 0.2, "{}: {ratio}", population.name);
        }
        let found = volume.summary().max_extinction_m1_q1;
        assert!(found <= shape.max_extinction_m1_q1());
    }
}

#[test]
fn calm_air_and_a_wind_against_the_rock_have_mist_too() {
    let outflow_m_s = 0.05 * fall().frame().impact_m_s();
    let against = -fall().frame().forward * outflow_m_s;
    for wind_xz_m_s in [[0.0, 0.0], against.to_array()] {
        let shape = Waterfall {
            wind_xz_m_s,
            ..fall()
        };
        let found = shape.volume().unwrap().summary();
        assert!((found.total_water_g / shape.total_water_g() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn gusts_stir_splash_and_mist_and_keep_their_water() {
    let gusty = Waterfall {
        turbulence: Some(Turbulence {
            strength: 0.7,
            eddy_m: 8.0,
            seed: 3,
            time_s: 1.0,
            wind_m_s: [1.0, 0.0, 0.0],
        }),
        ..fall()
    };
    let (still, stirred) = (fall().volume().unwrap(), gusty.volume().unwrap());
    assert_eq!(still.modes[0], stirred.modes[0]);
    for index in [1, 2] {
        assert_ne!(still.modes[index], stirred.modes[index]);
        let ratio = stirred.modes[index].total_water_g() / still.modes[index].total_water_g();
        assert!((ratio - 1.0).abs() < 1e-6);
    }
    assert!(stirred.summary().max_extinction_m1_q1 <= gusty.max_extinction_m1_q1());
}

#[test]
fn strands_gather_the_curtain_alone_and_keep_its_water_and_its_bound() {
    let strands = Strands {
        strength: 1.0,
        width_m: 3.0,
        seed: 5,
        time_s: 2.0,
    };
    let torn = Waterfall {
        strands: Some(strands),
        ..fall()
    };
    let (even, gathered) = (fall().volume().unwrap(), torn.volume().unwrap());
    assert_ne!(even.modes[0], gathered.modes[0]);
    assert_eq!(even.modes[1..], gathered.modes[1..]);
    let ratio = gathered.modes[0].total_water_g() / even.modes[0].total_water_g();
    assert!((ratio - 1.0).abs() < 1e-6);
    let densest = |volume: &DropVolume| volume.summary().max_extinction_m1_q1;
    assert!(densest(&gathered) <= torn.max_extinction_m1_q1());
}

#[test]
fn a_dry_part_has_no_drops_and_a_dry_fall_none_at_all() {
    let shape = Waterfall {
        mist_fraction: 0.0,
        ..fall()
    };
    let volume = shape.volume().unwrap();
    assert_eq!(volume.modes[2].nodes().count(), 0);
    assert_eq!(shape.effective_radius_range_um(), (300.0, 1000.0));
    let dry = Waterfall {
        flow_kg_s: 0.0,
        ..fall()
    };
    assert_eq!(dry.volume().unwrap().summary().n_nodes, 0);
    assert_eq!((dry.total_water_g(), dry.total_drops()), (0.0, 0.0));
}

#[test]
fn unsound_falls_are_refused() {
    let refused = |change: fn(&mut Waterfall)| {
        let mut shape = fall();
        change(&mut shape);
        assert!(shape.volume().is_err(), "{shape:?}");
    };
    refused(|fall| fall.foot_m[1] = f64::NAN);
    refused(|fall| fall.azimuth_deg = f64::INFINITY);
    refused(|fall| fall.height_m = 0.0);
    refused(|fall| fall.height_m = 1e7);
    refused(|fall| fall.width_m = -1.0);
    refused(|fall| fall.flow_kg_s = -1.0);
    refused(|fall| fall.flow_kg_s = f64::NAN);
    refused(|fall| fall.splash_fraction = 1.1);
    refused(|fall| fall.mist_fraction = -0.1);
    refused(|fall| (fall.splash_fraction, fall.mist_fraction) = (0.6, 0.6));
    refused(|fall| fall.mist_effective_radius_um = 0.0);
    refused(|fall| fall.wind_xz_m_s[0] = f64::NAN);
    refused(|fall| fall.voxel_m = 0.0);
    refused(|fall| {
        fall.strands = Some(Strands {
            strength: 2.0,
            width_m: 3.0,
            seed: 0,
            time_s: 0.0,
        });
    });
    let both = Waterfall {
        splash_fraction: 0.6,
        mist_fraction: 0.6,
        ..fall()
    };
    let message = both.validate().unwrap_err().to_string();
    assert!(
        message.contains("splash_fraction + mist_fraction = 1.2"),
        "{message}"
    );
}
