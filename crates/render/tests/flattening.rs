//! Pictures of bows that the flat shape of drops moves, against a table whose values are known.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Array6;
use niji_dropfield::GridBox;
use niji_exchange::ScatteringTable;
use niji_geometry::Camera;
use niji_render::Error;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::flattening_along;
use niji_render::render;

/// Where spheres make the bow, how far it moves at m = 1, and its width, rad.
const BOW_RAD: f64 = 2.41;
const SHIFT_RAD: f64 = 0.05;
const WIDTH_RAD: f64 = 0.01;

/// A bow of the shape of a bell.
fn bell(theta_rad: f64, flattening: f64) -> f64 {
    let off = (theta_rad - BOW_RAD - SHIFT_RAD * flattening) / WIDTH_RAD;
    0.02 + (-0.5 * off * off).exp()
}

fn flat_table(flattening: &[f64]) -> ScatteringTable {
    let mut table = isotropic(1.0);
    let angles = table.theta_rad.clone();
    let shape = (2, 1, 1, flattening.len(), 3, angles.len());
    table.values = Array6::from_shape_fn(shape, |(j, _, _, m, w, a)| {
        ([0.5, 1.5][j] * bell(angles[a], flattening[m]) * (1 + w) as f64) as f32
    });
    table.flattening = flattening.to_vec();
    table
}

/// Nodes at even steps from -1 to 1.
fn nodes(n: u32) -> Vec<f64> {
    let place = |index: u32| 2.0 * f64::from(index) / f64::from(n - 1) - 1.0;
    (0..n).map(place).collect()
}

/// A wall of drops to the north.
fn wall(sun: DVec3) -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-120.0, -120.0, -80.0),
        max: DVec3::new(120.0, 120.0, -60.0),
        voxel_m: 20.0,
    };
    LitDrops::new(vec![bricks(&grid, |_| 1e-3)], sun, SunPath::Ignore).unwrap()
}

/// The whole bow of a low sun.
fn wide_camera() -> Camera {
    camera(DVec3::ZERO, (0.0, 10.0), 100.0, (60, 45))
}

fn picture(table: &ScatteringTable, sun: DVec3) -> Rendered {
    let (camera, drops) = (wide_camera(), wall(sun));
    rendered(&request(&camera, sun, &drops, table))
}

/// t of every pixel: a picture over that of drops that scatter 1/sr into all directions.
fn seen(table: &ScatteringTable, sun: DVec3) -> ndarray::Array3<f32> {
    picture(table, sun).radiance / picture(&isotropic(1.0), sun).radiance
}

/// t by bilinear interpolation in theta and flattening, written out.
fn lookup(table: &ScatteringTable, theta_rad: f64, flattening: f64) -> f64 {
    let place = |axis: &[f64], value: f64| {
        let lower = (0..axis.len() - 1)
            .rev()
            .find(|node| axis[*node] <= value)
            .unwrap();
        let fraction = (value - axis[lower]) / (axis[lower + 1] - axis[lower]);
        (lower, fraction)
    };
    let (a, fa) = place(&table.theta_rad, theta_rad);
    let (m, fm) = place(&table.flattening, flattening);
    let at = |m: usize, a: usize| {
        let [s, p] = [0, 1].map(|j| f64::from(table.values[[j, 0, 0, m, 1, a]]));
        0.5 * (s + p)
    };
    (1.0 - fm) * ((1.0 - fa) * at(m, a) + fa * at(m, a + 1))
        + fm * ((1.0 - fa) * at(m + 1, a) + fa * at(m + 1, a + 1))
}

#[test]
fn every_pixel_is_the_literal_lookup_at_its_angle_and_flattening() {
    let sun = sun_in_the_south(12.0);
    let (camera, table) = (
        wide_camera(),
        flat_table(&[-1.0, -0.3, 0.0, 0.45, 0.8, 1.0]),
    );
    let found = seen(&table, sun);
    for y in 0..45_u32 {
        for x in 0..60_u32 {
            let view = camera
                .ray(f64::from(x) + 0.5, f64::from(y) + 0.5)
                .unwrap()
                .direction;
            let expected = lookup(&table, sun.dot(view).acos(), flattening_along(view, sun));
            let found = f64::from(found[[1, y as usize, x as usize]]);
            assert!(
                relative(found, expected) < 1e-4,
                "{x} {y}: {found} {expected}"
            );
        }
    }
}

/// Scattering angle at which t is largest along a line of views from the antisolar point.
fn brightest_rad(table: &ScatteringTable, sun: DVec3, clock_deg: f64) -> f64 {
    let clock = clock_deg.to_radians();
    let right = (-sun).cross(DVec3::Y).normalize();
    let out = right * clock.sin() + right.cross(-sun) * clock.cos();
    let drops = wall(sun);
    let at = |step: u32| {
        let bow_rad = (30.0 + 0.05 * f64::from(step)).to_radians();
        let view = -sun * bow_rad.cos() + out * bow_rad.sin();
        let azimuth_deg = view.x.atan2(-view.z).to_degrees();
        let look_deg = (azimuth_deg, view.y.asin().to_degrees());
        let camera = camera(DVec3::ZERO, look_deg, 1e-3, (1, 1));
        let of = |table: &ScatteringTable| {
            let picture = rendered(&request(&camera, sun, &drops, table));
            f64::from(picture.radiance[[1, 0, 0]])
        };
        (
            of(table) / of(&isotropic(1.0)),
            std::f64::consts::PI - bow_rad,
        )
    };
    let brightest = (0..400).map(at).max_by(|a, b| a.0.total_cmp(&b.0));
    brightest.unwrap().1
}

#[test]
fn the_top_of_the_bow_moves_inwards_and_the_feet_of_a_setting_sun_stay() {
    let table = flat_table(&nodes(201));
    let sun = sun_in_the_south(0.0);
    // Half of the table's step and of the scan's, with something to spare.
    let tolerance_rad = 0.1_f64.to_radians();
    for clock_deg in [90.0, -90.0] {
        let foot_rad = brightest_rad(&table, sun, clock_deg);
        assert!((foot_rad - BOW_RAD).abs() < tolerance_rad, "{foot_rad}");
    }
    // At the top m is the cosine of the bow angle, which moves with m.
    let mut top_rad = BOW_RAD;
    for _ in 0..20 {
        top_rad = BOW_RAD - SHIFT_RAD * top_rad.cos();
    }
    let found_rad = brightest_rad(&table, sun, 0.0);
    assert!((found_rad - top_rad).abs() < tolerance_rad, "{found_rad}");
    assert!(found_rad > BOW_RAD + 0.6 * SHIFT_RAD);
}

#[test]
fn drops_whose_bow_does_not_move_look_like_spheres() {
    let sun = sun_in_the_south(25.0);
    let mut table = flat_table(&nodes(7));
    for m in 0..7 {
        let spheres = table.values.slice(ndarray::s![.., .., .., 3..4, .., ..]);
        let spheres = spheres.to_owned();
        let mut part = table
            .values
            .slice_mut(ndarray::s![.., .., .., m..=m, .., ..]);
        part.assign(&spheres);
    }
    let (flat, round) = (picture(&table, sun), picture(&flat_table(&[0.0]), sun));
    for (flat, round) in flat.radiance.iter().zip(&round.radiance) {
        assert!((flat - round).abs() <= 1e-6 * round, "{flat} {round}");
    }
}

#[test]
fn one_flattening_stands_for_all_rays() {
    let sun = sun_in_the_south(25.0);
    let (camera, table) = (wide_camera(), flat_table(&[0.7]));
    let found = seen(&table, sun);
    let view = camera.ray(30.5, 10.5).unwrap().direction;
    let expected = 2.0 * bell(sun.dot(view).acos(), 0.7);
    assert!(relative(f64::from(found[[1, 10, 30]]), expected) < 5e-3);
}

#[test]
fn threads_do_not_change_a_bit_of_flat_drops() {
    let sun = sun_in_the_south(12.0);
    let (camera, drops) = (wide_camera(), wall(sun));
    let table = flat_table(&nodes(5));
    let mut request = request(&camera, sun, &drops, &table);
    request.levels.pixel_footprint = PixelFootprint::Prefiltered;
    let picture = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build();
        pool.unwrap().install(|| rendered(&request).radiance)
    };
    assert!(picture(1) == picture(7), "7 threads differ from one");
}

#[test]
fn a_table_that_moves_the_bow_less_than_the_picture_needs_is_refused() {
    let sun = sun_in_the_south(0.0);
    let (camera, drops) = (wide_camera(), wall(sun));
    let refusal = |flattening: &[f64]| {
        let table = flat_table(flattening);
        render(&request(&camera, sun, &drops, &table), &|_| ()).unwrap_err()
    };
    match refusal(&[-1.0, 0.0, 0.3]) {
        Error::FlatteningRange { found, expected } => {
            assert_eq!(found, (-1.0, 0.3));
            assert!(expected.1 > 0.7 && expected.1 < 1.0, "{expected:?}");
        }
        other => panic!("{other}"),
    }
    for not_an_axis in [&[0.5, 0.0][..], &[-1.0, 1.5], &[], &[f64::NAN]] {
        let found = refusal(not_an_axis);
        assert!(matches!(found, Error::BadTable { .. }), "{found}");
    }
}
