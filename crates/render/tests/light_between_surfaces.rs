//! Light that surfaces send each other: one reflection by closed forms, all of them within what is told.

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

const DOWN: (f64, f64) = (0.0, -90.0);
const NORTH: (f64, f64) = (0.0, 0.0);

#[test]
fn a_surface_that_sees_no_other_errs_by_nothing() {
    let sun = sun_in_the_south(40.0);
    let eye = DVec3::new(0.0, 4.0, 3.0);
    let told =
        |solid: Solid, look_deg| seen(&Surfaces::default().with(solid), sun, eye, look_deg).0;
    assert_eq!(told(floor(0.9), DOWN), 0.0);
    assert_eq!(told(wall(0.9), NORTH), 0.0);
    // Black surfaces send nothing to each other, whatever they hide.
    let corner = Surfaces::default().with(floor(0.0)).with(wall(0.0));
    assert_eq!(seen(&corner, sun, eye, NORTH), (0.0, 0.0));
}

/// Relative to what sun and sky send straight to a place of one surface: what it has from another, and its told error.
fn sent(pair: [Solid; 2], sun: DVec3, (eye, look_deg): (DVec3, (f64, f64))) -> [f64; 2] {
    let [own, other] = pair;
    let alone = Surfaces::default().with(own.clone());
    let (_, straight) = seen(&alone, sun, eye, look_deg);
    let (told, light) = seen(&alone.with(other), sun, eye, look_deg);
    [light / straight - 1.0, told / straight]
}

#[test]
fn floor_and_wall_send_each_other_light_of_the_form_factor_between_them() {
    // One reflection, F A E, beside a place that is so dark that there is no other. Of a wall 10 km high F is half of
    // 1 - cos of the angle up to its top.
    for albedo in [0.2, 0.5, 0.9] {
        for elevation_deg in [20.0, 60.0] {
            let sun = sun_in_the_south(elevation_deg);
            for distance_m in [0.1, 1.0, 100.0] {
                let factor = 0.5 * (1.0 - distance_m / f64::hypot(distance_m, 1e4));
                let above = (DVec3::new(0.0, 4.0, -1.0 + distance_m), DOWN);
                let of_floor = sent([floor(1e-3), wall(albedo)], sun, above);
                let before = (DVec3::new(0.0, distance_m, 4.0), NORTH);
                let of_wall = sent([wall(1e-3), floor(albedo)], sun, before);
                for ([light, told], other) in [(of_floor, sun.z / sun.y), (of_wall, sun.y / sun.z)]
                {
                    let expected = factor * albedo * other;
                    let case = format!("{albedo} {elevation_deg} {distance_m}: {light} {expected}");
                    assert!(relative(light, expected) < 0.012, "{case}");
                    assert!(told < 0.01 * expected, "{case} {told}");
                }
            }
        }
    }
}

#[test]
fn floor_and_wall_have_all_light_of_the_series_between_them_within_what_is_told() {
    // Both see half of each other: E = (E_straight + A/2 E_other)/(1 - A^2/4).
    for albedo in [0.2, 0.5, 0.9] {
        for elevation_deg in [20.0, 60.0] {
            let sun = sun_in_the_south(elevation_deg);
            let half = 0.5 * albedo;
            let all = |other: f64| (1.0 + half * other) / (1.0 - half * half) - 1.0;
            let above = (DVec3::new(0.0, 4.0, -0.9), DOWN);
            let of_floor = sent([floor(albedo), wall(albedo)], sun, above);
            let before = (DVec3::new(0.0, 0.1, 4.0), NORTH);
            let of_wall = sent([wall(albedo), floor(albedo)], sun, before);
            for ([light, told], other) in [(of_floor, sun.z / sun.y), (of_wall, sun.y / sun.z)] {
                let expected = all(other);
                assert!(
                    (light - expected).abs() < told,
                    "{albedo} {elevation_deg}: {light} {expected} {told}"
                );
                assert!(
                    told < 0.7 * expected,
                    "{albedo} {elevation_deg}: {told} {expected}"
                );
            }
        }
    }
}

#[test]
fn a_wall_sends_its_own_color_and_none_where_another_stands_before_the_sun() {
    let sun = sun_in_the_south(40.0);
    let above = (DVec3::new(0.0, 4.0, -0.9), DOWN);
    let [bright, _] = sent([floor(0.01), wall(0.6)], sun, above);
    let [dark, _] = sent([floor(0.01), wall(0.2)], sun, above);
    assert!(relative(bright, 3.0 * dark) < 0.05, "{bright} {dark}");
    let [black, told] = sent([floor(0.5), wall(0.0)], sun, above);
    assert_eq!([black, told], [0.0, 0.0]);
    // Night on the wall: the sun stands behind it, and the floor before it is in its shadow.
    let behind = sun_in_the_south(40.0) * DVec3::new(1.0, 1.0, -1.0);
    let far = (DVec3::new(0.0, 4.0, 5.0), DOWN);
    let surfaces = Surfaces::default().with(floor(0.5)).with(wall(0.5));
    let (told, light) = seen(&surfaces, behind, far.0, far.1);
    assert!(light <= told, "what is told may be all: {light} {told}");
}

/// Irradiance that the middle of the floor of an endless street, one wide, has from the sun, its walls and the walls from it
/// and each other, over what the sun straight above the street's axis gives level ground: radiosity with Hottel's crossed
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
    straight[N / 2] + from_others[N / 2]
}

#[test]
fn light_in_a_street_is_that_of_all_reflections_within_what_is_told() {
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
            let (told, light) = seen(&street, sun, DVec3::new(0.0, 0.2, 0.0), DOWN);
            let level = Surfaces::default().with(floor(albedo));
            let (_, of_level) = seen(&level, sun, DVec3::new(0.0, 0.2, 0.0), DOWN);
            let (told, light) = (told / of_level, light / of_level);
            let expected = in_a_street(height, albedo, sun);
            let case = format!("{albedo} {height} {elevation_deg}: {light} {expected} {told}");
            // Worst found 0.96 of what is told, in the low street of white walls.
            assert!((light - expected).abs() < told, "{case}");
            assert!(told < expected, "{case}");
        }
    }
}

#[test]
fn white_surfaces_that_enclose_a_place_tell_a_finite_error() {
    let sun = sun_in_the_south(40.0);
    let roof = rectangle(
        DVec3::new(0.0, 9.0, 0.0),
        [20.0 * DVec3::Z, 20.0 * DVec3::X],
        1.0,
    );
    let cave = Surfaces::default()
        .with(floor(1.0))
        .with(wall(1.0))
        .with(roof);
    let (error, _) = seen(&cave, sun, DVec3::new(0.0, 4.0, 3.0), DOWN);
    assert!(error.is_finite() && error > 0.0, "{error}");
}
