//! Claims about rain shafts.

use glam::DVec3;

use super::*;

fn shaft() -> RainShaft {
    RainShaft {
        rain_rate_mm_h: Some(5.0),
        reflectivity_dbz: None,
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
        turbulence: None,
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
    for outside in [grid.min - 0.01, grid.max + 0.01] {
        assert!(shape.coverage(shape.slant().offset_m(outside)) < 1e-12);
    }
}

#[test]
fn edges_are_half_at_the_outline_and_sharp_without_width() {
    assert!((ramp(0.0, 10.0) - 0.5).abs() < 1e-15);
    assert_eq!((ramp(5.0, 10.0), ramp(-5.0, 10.0)), (1.0, 0.0));
    assert_eq!((ramp(1e-9, 0.0), ramp(-1e-9, 0.0)), (1.0, 0.0));
}

#[test]
fn a_radar_sees_the_rain_of_its_rate() {
    // Z = 296 R^1.47 is what Marshall and Palmer's law gives: 35.0 dBZ at 5 mm/h.
    let seen = RainShaft {
        rain_rate_mm_h: None,
        reflectivity_dbz: Some(10.0 * (296.0 * 5.0_f64.powf(1.47)).log10()),
        ..shaft()
    };
    // Measured 6e-4 of the rate: the coefficients 296 and 1.47 are rounded.
    assert!((seen.law().rain_rate_mm_h / 5.0 - 1.0).abs() < 2e-3);
    assert_eq!(seen.law().d_max_mm, Some(6.0));
    let water = seen.volume().unwrap().summary().total_water_g;
    assert!((water / seen.total_water_g() - 1.0).abs() < 1e-5);
}

#[test]
fn the_amount_of_rain_is_given_once() {
    for (rain_rate_mm_h, reflectivity_dbz, word) in [
        (None, None, "found neither"),
        (Some(5.0), Some(35.0), "found both"),
    ] {
        let shape = RainShaft {
            rain_rate_mm_h,
            reflectivity_dbz,
            ..shaft()
        };
        let message = shape.validate().unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
        assert!(message.contains("rain_rate_mm_h") && message.contains("reflectivity_dbz"));
    }
}

#[test]
fn gusts_move_water_and_raise_the_bound() {
    let calm = shaft();
    let gusty = RainShaft {
        turbulence: Some(Turbulence {
            strength: 0.8,
            eddy_m: 30.0,
            seed: 7,
            time_s: 0.0,
            wind_m_s: [0.0; 3],
        }),
        ..calm
    };
    let found = gusty.volume().unwrap().summary();
    assert!((found.total_water_g / calm.total_water_g() - 1.0).abs() < 1e-5);
    assert!(found.max_extinction_m1_q1 > 1.2 * calm.max_extinction_m1_q1());
    assert!(found.max_extinction_m1_q1 <= gusty.max_extinction_m1_q1());
}

#[test]
fn unsound_parameters_are_refused() {
    for shape in [
        RainShaft {
            rain_rate_mm_h: Some(0.0),
            ..shaft()
        },
        RainShaft {
            rain_rate_mm_h: Some(f64::NAN),
            ..shaft()
        },
        RainShaft {
            rain_rate_mm_h: None,
            reflectivity_dbz: Some(f64::NAN),
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
