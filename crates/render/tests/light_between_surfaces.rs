//! What is told of the light that surfaces send each other, which no ray follows.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleMesh;
use niji_radiometry::Reflectance;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::Surfaces;
use niji_render::Toggle;

fn rectangle(middle: DVec3, [a, b]: [DVec3; 2], albedo: f64) -> Solid {
    let corners = [-a - b, a - b, a + b, b - a].map(|corner| middle + 0.5 * corner);
    let mesh = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    Solid {
        shape: SolidShape::Mesh(MeshBvh::new(mesh)),
        albedo: Some(Reflectance::Even(albedo).into()),
    }
}

/// A floor and a wall across the north that stands on it, by their albedos, both kilometres large.
fn floor(albedo: f64) -> Solid {
    rectangle(DVec3::ZERO, [2e4 * DVec3::Z, 2e4 * DVec3::X], albedo)
}

fn wall(albedo: f64) -> Solid {
    let middle = DVec3::new(0.0, 5e3, -1.0);
    rectangle(middle, [2e4 * DVec3::X, 1e4 * DVec3::Y], albedo)
}

/// Told error and light of the lit surface along one ray, in a vacuum.
fn seen(surfaces: &Surfaces, sun: DVec3, eye: DVec3, look_deg: (f64, f64)) -> (f64, f64) {
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let camera = camera(eye, look_deg, 1e-3, (1, 1));
    let mut request = request(&camera, sun, &drops, &table);
    request.surfaces = Some(surfaces);
    request.effects = RenderEffects {
        lit_surfaces: Toggle::On,
        ..RenderEffects::BOWS_ONLY
    };
    let picture = rendered(&request);
    let error = f64::from(picture.error_from("surfaces").unwrap()[[0, 0]]);
    let all = f64::from(picture.error_from("Y").unwrap()[[0, 0]]);
    assert!(error <= all * (1.0 + 1e-6), "{error} of {all}");
    let light = f64::from(picture[PictureLayer::LitSurface][[1, 0, 0]]);
    (error, light)
}

/// The one over the other.
fn told(surfaces: &Surfaces, sun: DVec3, eye: DVec3, look_deg: (f64, f64)) -> f64 {
    let (error, light) = seen(surfaces, sun, eye, look_deg);
    error / light
}

const DOWN: (f64, f64) = (0.0, -90.0);
const NORTH: (f64, f64) = (0.0, 0.0);

#[test]
fn a_surface_that_sees_no_other_errs_by_nothing() {
    let sun = sun_in_the_south(40.0);
    let eye = DVec3::new(0.0, 4.0, 3.0);
    let alone = Surfaces::default().with(floor(0.9));
    assert_eq!(told(&alone, sun, eye, DOWN), 0.0);
    let alone = Surfaces::default().with(wall(0.9));
    assert_eq!(told(&alone, sun, eye, NORTH), 0.0);
    // Black surfaces send nothing to each other, whatever they hide.
    let corner = Surfaces::default().with(floor(0.0)).with(wall(0.0));
    assert_eq!(seen(&corner, sun, eye, NORTH), (0.0, 0.0));
}

#[test]
fn floor_and_wall_tell_the_series_of_light_between_faces_that_see_half_of_each_other() {
    // The form factor from a face beside an endless wall to it is 1/2, and so is that back.
    for albedo in [0.2, 0.5, 0.9] {
        for elevation_deg in [20.0, 60.0] {
            let sun = sun_in_the_south(elevation_deg);
            let corner = Surfaces::default().with(floor(albedo)).with(wall(albedo));
            let series: f64 = (1..2000).map(|n| f64::powi(0.5 * albedo, n)).sum();
            let of_floor = told(&corner, sun, DVec3::new(0.0, 4.0, -0.9), DOWN);
            let of_wall = told(&corner, sun, DVec3::new(0.0, 0.1, 4.0), NORTH);
            for (found, cos_sun) in [(of_floor, sun.y), (of_wall, sun.z)] {
                let expected = series / cos_sun;
                // Halvings of the horizon leave 0.7 degrees.
                assert!(
                    relative(found, expected) < 0.02,
                    "{albedo} {elevation_deg}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn what_is_told_covers_one_reflection_of_a_wall_in_the_sun() {
    // Beside an endless wall that is evenly lit, level ground gets F A E cos from it: closed form of one reflection.
    let (albedo, elevation_deg) = (0.5, 30.0);
    let sun = sun_in_the_south(elevation_deg);
    let corner = Surfaces::default().with(floor(albedo)).with(wall(albedo));
    for distance_m in [0.1, 1.0, 100.0, 5e3] {
        let eye = DVec3::new(0.0, 4.0, -1.0 + distance_m);
        let told = told(&corner, sun, eye, DOWN);
        // Half of 1 - cos of the angle up to the top of the wall, 10 km high.
        let seen = 0.5 * (1.0 - distance_m / distance_m.hypot(1e4));
        let reflected = seen * albedo * sun.z / sun.y;
        assert!(told > reflected, "{distance_m}: {told} {reflected}");
        assert!(told < 3.0 * reflected, "{distance_m}: {told} {reflected}");
    }
}

/// Irradiance that the middle of the floor of an endless street, one wide, has from its walls and the walls from it and
/// each other, over what the sun straight above the street's axis gives level ground: radiosity with Hottel's crossed
/// strings, in strips.
fn in_a_street(height: f64, albedo: f64, sun: DVec3) -> f64 {
    const N: usize = 41;
    let strip = |index: usize| {
        let (side, at) = (index / N, (index % N) as f64 / N as f64);
        let end = |more: f64| match side {
            0 => (at + more, 0.0),
            1 => (0.0, height * (at + more)),
            _ => (1.0, height * (at + more)),
        };
        (side, [end(0.0), end(1.0 / N as f64)])
    };
    let far = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let factor = |to: usize, from: usize| {
        let ((side, [a, b]), (other, [c, d])) = (strip(to), strip(from));
        let strings = far(a, c) + far(b, d) - far(a, d) - far(b, c);
        f64::from(u8::from(side != other)) * strings.abs() / (2.0 * far(a, b))
    };
    let factors: Vec<Vec<f64>> = (0..3 * N)
        .map(|to| (0..3 * N).map(|from| factor(to, from)).collect())
        .collect();
    // The sun stands above the wall on the left: the floor from where it comes in, and the wall on the right.
    let cot = sun.x.abs() / sun.y;
    let straight: Vec<f64> = (0..3 * N)
        .map(|index| {
            let (side, [a, b]) = strip(index);
            let (x, y) = (0.5 * (a.0 + b.0), 0.5 * (a.1 + b.1));
            let is_lit = height - y < x / cot;
            let cos = [sun.y, 0.0, sun.x.abs()][side];
            f64::from(u8::from(is_lit)) * cos / sun.y
        })
        .collect();
    let mut from_others = vec![0.0; 3 * N];
    for _ in 0..400 {
        let sent: Vec<f64> = straight
            .iter()
            .zip(&from_others)
            .map(|(a, b)| albedo * (a + b))
            .collect();
        let seen = |to: &Vec<f64>| {
            to.iter()
                .zip(&sent)
                .map(|(factor, sent)| factor * sent)
                .sum()
        };
        from_others = factors.iter().map(seen).collect();
    }
    from_others[N / 2]
}

#[test]
fn what_is_told_in_a_street_covers_all_reflections_and_stays_finite() {
    for albedo in [0.2, 0.5, 0.9] {
        for (height, elevation_deg) in [(0.5, 35.0), (1.0, 60.0), (3.0, 80.0), (8.0, 85.0)] {
            let (sine, cosine) = f64::to_radians(elevation_deg).sin_cos();
            let sun = DVec3::new(-cosine, sine, 0.0);
            let side = |east: f64| {
                let middle = DVec3::new(east, 0.5 * height, 0.0);
                rectangle(
                    middle,
                    [height * DVec3::Y, -2e3 * east.signum() * DVec3::Z],
                    albedo,
                )
            };
            let street = Surfaces::default()
                .with(floor(albedo))
                .with(side(-0.5))
                .with(side(0.5));
            let (told, _) = seen(&street, sun, DVec3::new(0.0, 0.2, 0.0), DOWN);
            let level = Surfaces::default().with(floor(albedo));
            let (_, of_level) = seen(&level, sun, DVec3::new(0.0, 0.2, 0.0), DOWN);
            let (told, expected) = (told / of_level, in_a_street(height, albedo, sun));
            let case = format!("{albedo} {height} {elevation_deg}: {told} {expected}");
            // Of a slit twelve azimuths see less sky than there is.
            let least = if height > 4.0 { 0.6 } else { 1.0 };
            assert!(told > least * expected, "{case}");
            assert!(told < 5.0 * expected && told < 2.0 / sine, "{case}");
        }
    }
}

#[test]
fn white_surfaces_that_enclose_a_place_tell_a_finite_error() {
    let sun = sun_in_the_south(40.0);
    let roof = rectangle(
        DVec3::new(0.0, 9.0, 0.0),
        [2e3 * DVec3::Z, 2e3 * DVec3::X],
        1.0,
    );
    let cave = Surfaces::default()
        .with(floor(1.0))
        .with(wall(1.0))
        .with(roof);
    let (error, _) = seen(&cave, sun, DVec3::new(0.0, 4.0, 3.0), DOWN);
    assert!(error.is_finite() && error > 0.0, "{error}");
}
