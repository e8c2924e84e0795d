//! Claims about rain cells.

use glam::DVec3;
use niji_dropfield::AreaMoments;

use super::*;

fn cell() -> RainCell {
    RainCell {
        max_rain_rate_mm_h: 25.0,
        radius_m: 300.0,
        center_xz_m: [100.0, -3000.0],
        base_y_m: 0.0,
        top_y_m: 600.0,
        wind_shear_xz_1_s: [0.01, -0.005],
        turbulence: None,
        voxel_m: 40.0,
    }
}

/// The nodes whose whole cell lies in the box, with their positions; the others stand for the middle
/// of a part of a cell.
fn whole_nodes(shape: &RainCell) -> Vec<(DVec3, Drops)> {
    let volume = shape.volume().unwrap();
    let highest = shape.grid().max - 0.5 * shape.voxel_m;
    let mode = &volume.modes[0];
    let nodes = mode.nodes();
    let placed = nodes.map(|(node, drops)| (mode.node_position(node), drops));
    placed
        .filter(|(position, _)| position.cmple(highest + 1e-9).all())
        .collect()
}

#[test]
fn totals_of_the_volume_equal_the_closed_forms() {
    let upright = RainCell {
        wind_shear_xz_1_s: [0.0; 2],
        ..cell()
    };
    let fine = RainCell {
        voxel_m: 25.0,
        ..upright
    };
    for shape in [cell(), upright, fine] {
        let found = shape.volume().unwrap().summary();
        let water = found.total_water_g / shape.total_water_g() - 1.0;
        let drops = found.total_drops / shape.total_drops() - 1.0;
        // Nodes at the cut, which has 0.3 % of the water and 23 % of the drops of the axis: measured
        // worst 8e-5 and 2e-3.
        assert!(water.abs() < 2e-4, "{shape:?}: {water:e}");
        assert!(drops.abs() < 5e-3, "{shape:?}: {drops:e}");
    }
}

#[test]
fn every_node_holds_marshall_palmer_rain_of_its_rate() {
    let shape = cell();
    let nodes = whole_nodes(&shape);
    assert!(nodes.len() > 1000, "{}", nodes.len());
    for (position, drops) in nodes {
        let rate = shape.rain_rate_mm_h(shape.slant().offset_m(position).length());
        // r_e = 3/(2 Lambda), Lambda = 4.1 R^-0.21 /mm; N = 8000/Lambda per m³.
        let slope_per_mm = 4.1 * rate.powf(-0.21);
        let radius_mm = 1e3 * f64::from(drops.effective_radius_m);
        let number_m3 = f64::from(drops.number_density_m3);
        assert!((radius_mm * slope_per_mm / 1.5 - 1.0).abs() < 1e-6);
        assert!((number_m3 * slope_per_mm / 8000.0 - 1.0).abs() < 1e-6);
        assert!((drops.effective_variance - 1.0 / 3.0).abs() < 1e-7);
    }
}

#[test]
fn the_axis_has_the_figures_of_the_law() {
    // Marshall-Palmer at 25 mm/h: r_e = 0.719 mm, 2.771 /km at Q = 2, 1.329 g/m³.
    let shape = cell();
    assert!((1e-3 * shape.effective_radius_range_um().1 - 0.719).abs() < 6e-4);
    assert!((2e3 * shape.max_extinction_m1_q1() - 2.771).abs() < 6e-4);
    let water_g = 1.329 * 600.0 * PI * 300.0_f64.powi(2) / 0.84;
    // The cut takes s^0.84 = 0.3 % of it.
    assert!((shape.total_water_g() / water_g - 0.997).abs() < 4e-4);
}

#[test]
fn rain_falls_to_its_edge_and_ends_there() {
    let shape = cell();
    assert!((shape.rain_rate_mm_h(0.0) - 25.0).abs() < 1e-12);
    assert!((shape.rain_rate_mm_h(300.0) * std::f64::consts::E / 25.0 - 1.0).abs() < 1e-12);
    let edge_m = shape.reach_m();
    assert!((shape.rain_rate_mm_h(edge_m * (1.0 - 1e-12)) / 0.025 - 1.0).abs() < 1e-9);
    assert_eq!(shape.rain_rate_mm_h(edge_m), 0.0);
    for (position, _) in whole_nodes(&shape) {
        assert!((0.0..=600.0).contains(&position.y));
        assert!(shape.slant().offset_m(position).length() < edge_m);
    }
}

#[test]
fn the_box_holds_the_slanted_cell() {
    let shape = cell();
    let (grid, edge_m) = (shape.grid(), shape.reach_m());
    for y in [0.0, 300.0, 600.0] {
        let axis = -shape.slant().offset_m(DVec3::new(0.0, y, 0.0));
        for reach in [DVec2::splat(edge_m), DVec2::splat(-edge_m)] {
            let corner = axis + reach;
            let corner = DVec3::new(corner.x, y, corner.y);
            assert!(corner.cmple(grid.max + 1e-9).all() && corner.cmpge(grid.min - 1e-9).all());
        }
    }
}

#[test]
fn the_heaviest_rain_is_the_bound() {
    let shape = RainCell {
        voxel_m: 10.0,
        base_y_m: 590.0,
        ..cell()
    };
    let volume = shape.volume().unwrap();
    let extinctions = volume.modes[0].nodes().map(|(_, drops)| {
        let moments = AreaMoments::from_drops(&drops);
        moments.extinction_m1_q1()
    });
    let most = extinctions.fold(0.0, f64::max);
    let ratio = most / shape.max_extinction_m1_q1();
    assert!(ratio <= 1.0 + 1e-6 && ratio > 0.999, "{ratio}");
}

#[test]
fn unsound_cells_are_refused() {
    for shape in [
        RainCell {
            max_rain_rate_mm_h: 0.0,
            ..cell()
        },
        RainCell {
            max_rain_rate_mm_h: f64::NAN,
            ..cell()
        },
        RainCell {
            radius_m: 0.0,
            ..cell()
        },
        RainCell {
            voxel_m: 301.0,
            ..cell()
        },
        RainCell {
            voxel_m: 0.0,
            ..cell()
        },
        RainCell {
            voxel_m: f64::NAN,
            ..cell()
        },
        RainCell {
            top_y_m: 0.0,
            ..cell()
        },
        RainCell {
            wind_shear_xz_1_s: [f64::INFINITY, 0.0],
            ..cell()
        },
        RainCell {
            center_xz_m: [0.0, f64::NAN],
            ..cell()
        },
        RainCell {
            wind_shear_xz_1_s: [1e6, 0.0],
            ..cell()
        },
    ] {
        assert!(shape.volume().is_err(), "{shape:?}");
    }
}
