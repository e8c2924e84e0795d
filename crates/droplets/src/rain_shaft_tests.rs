//! Claims about rain shafts.

use super::*;

fn shaft() -> RainShaft {
    RainShaft {
        rain_rate_mm_h: 5.0,
        d_min_mm: Some(0.1),
        d_max_mm: Some(6.0),
        footprint: Footprint::Box {
            width_x_m: 80.0,
            width_z_m: 40.0,
        },
        center_xz_m: [10.0, -300.0],
        base_y_m: 0.0,
        top_y_m: 120.0,
        wind_shear_xz_1_s: [0.0, 0.0],
        edge_m: 20.0,
        voxel_m: 4.0,
    }
}

#[test]
fn totals_of_the_volume_equal_the_closed_forms() {
    let slanted = RainShaft {
        wind_shear_xz_1_s: [0.02, -0.01],
        ..shaft()
    };
    let column = Footprint::Column { radius_m: 40.0 };
    // The nodes sample a smooth ramp: measured worst 4e-6 for a box, 8e-5 for a column.
    for (shape, tolerance) in [
        (shaft(), 1e-5),
        (slanted, 1e-5),
        (
            RainShaft {
                footprint: column,
                ..shaft()
            },
            1e-3,
        ),
        (
            RainShaft {
                footprint: column,
                ..slanted
            },
            1e-3,
        ),
    ] {
        let volume = shape.volume().unwrap().summary();
        let gamma_drops = shape.total_drops() * shape.law().moments().equivalent_gamma_drops();
        let error = (volume.total_drops / gamma_drops - 1.0).abs();
        assert!(error < tolerance, "{shape:?}: {error:e}");
        let error = (volume.total_water_g / shape.total_water_g() - 1.0).abs();
        assert!(error < tolerance, "{shape:?}: {error:e}");
    }
}

#[test]
fn inside_it_is_marshall_palmer_rain() {
    let volume = shaft().volume().unwrap();
    let node = volume.modes[0].nodes().map(|(_, drops)| drops);
    let densest = node.max_by(|a, b| a.number_density_m3.total_cmp(&b.number_density_m3));
    let drops = densest.unwrap();
    // R = 5 mm/h cut to 0.1..6 mm: r_e = 0.5146 mm, v_e = 0.3294, 1.0018 /km.
    let moments = niji_dropfield::AreaMoments::from_drops(&drops);
    assert!((2.0 * moments.extinction_m1_q1() - 1.00180e-3).abs() < 1e-8);
    assert!((drops.effective_radius_m - 5.1456e-4).abs() < 1e-8);
    assert!((drops.effective_variance - 0.32939).abs() < 1e-5);
    assert!((2.0 * shaft().max_extinction_m1_q1() - 1.00180e-3).abs() < 1e-8);
}

#[test]
fn the_shaft_lags_behind_the_cloud_by_the_shear() {
    // 4/Lambda = 1.368 mm falls at 5.117 m/s; 120 m in shear 0.02 /s: 0.02 14400/(2 5.117).
    let shape = RainShaft {
        wind_shear_xz_1_s: [0.02, 0.0],
        ..shaft()
    };
    let [x, z] = shape.displacement_m(0.0);
    assert!((x + 28.14).abs() < 0.02 && z.abs() < 1e-12, "{x} {z}");
    assert!(
        shape
            .displacement_m(120.0)
            .iter()
            .all(|shift| shift.abs() < 1e-300)
    );
    // Halfway down a quarter of it.
    assert!((shape.displacement_m(60.0)[0] / x - 0.25).abs() < 1e-12);
}

#[test]
fn the_box_holds_the_whole_slanted_shaft() {
    let shape = RainShaft {
        wind_shear_xz_1_s: [-0.05, 0.03],
        ..shaft()
    };
    let grid = shape.grid();
    for y in [0.0, 60.0, 120.0] {
        let [x, z] = shape.displacement_m(y);
        let corner = DVec3::new(10.0 + x + 50.0, y, -300.0 + z + 30.0);
        assert!(corner.cmple(grid.max + 1e-9).all() && corner.cmpge(grid.min - 1e-9).all());
    }
    assert!(shape.coverage(grid.min - 0.01) < 1e-12 && shape.coverage(grid.max + 0.01) < 1e-12);
}

#[test]
fn edges_are_half_at_the_outline_and_sharp_without_width() {
    assert!((ramp(0.0, 10.0) - 0.5).abs() < 1e-15);
    assert_eq!((ramp(5.0, 10.0), ramp(-5.0, 10.0)), (1.0, 0.0));
    assert_eq!((ramp(1e-9, 0.0), ramp(-1e-9, 0.0)), (1.0, 0.0));
}

#[test]
fn drizzle_still_falls() {
    // The fit for the fall speed is negative below 0.11 mm.
    let shape = RainShaft {
        rain_rate_mm_h: 1e-6,
        wind_shear_xz_1_s: [0.01, 0.0],
        ..shaft()
    };
    assert!(shape.displacement_m(0.0)[0] < 0.0);
}

#[test]
fn unsound_parameters_are_refused() {
    for shape in [
        RainShaft {
            rain_rate_mm_h: 0.0,
            ..shaft()
        },
        RainShaft {
            rain_rate_mm_h: f64::NAN,
            ..shaft()
        },
        RainShaft {
            d_min_mm: Some(7.0),
            ..shaft()
        },
        RainShaft {
            top_y_m: 0.0,
            ..shaft()
        },
        RainShaft {
            edge_m: -1.0,
            ..shaft()
        },
        RainShaft {
            edge_m: 41.0,
            ..shaft()
        },
        RainShaft {
            center_xz_m: [f64::NAN, 0.0],
            ..shaft()
        },
        RainShaft {
            wind_shear_xz_1_s: [0.0, f64::INFINITY],
            ..shaft()
        },
        RainShaft {
            wind_shear_xz_1_s: [1e6, 0.0],
            ..shaft()
        },
        RainShaft {
            footprint: Footprint::Column { radius_m: 0.0 },
            ..shaft()
        },
        RainShaft {
            voxel_m: -4.0,
            ..shaft()
        },
    ] {
        assert!(shape.volume().is_err(), "{shape:?}");
    }
}
