//! Meshes with normals against the smooth body that they stand for.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DAffine3;
use glam::DVec3;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleAttributes;
use niji_geometry::TriangleMesh;
use niji_radiometry::Reflectance;
use niji_render::LitDrops;
use niji_render::RenderEffects;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::Surfaces;
use niji_render::Toggle;

use std::f64::consts::FRAC_1_PI;
use std::f64::consts::PI;

const ALBEDO: f64 = 0.3;
const MIDDLE: DVec3 = DVec3::new(0.0, 50.0, -100.0);
const EYE: DVec3 = DVec3::new(0.0, 50.0, 0.0);
const RADIUS_M: f64 = 10.0;

/// Parallels from pole to pole; twice as many meridians.
const N_BANDS: u32 = 32;

/// Largest angle between the normals of a triangle and of the sphere on it: half of the diagonal of a patch.
fn off_rad() -> f64 {
    PI / f64::from(N_BANDS) / 2.0_f64.sqrt()
}

/// A sphere of radius 1 with radial normals that have a sign.
fn ball(sign: Option<f32>) -> TriangleMesh {
    let place = |band: u32, meridian: u32| {
        let (sin, cos) = (PI * f64::from(band) / f64::from(N_BANDS)).sin_cos();
        // The last meridian is the first, to the last bit.
        let (east, south) =
            (PI * f64::from(meridian % (2 * N_BANDS)) / f64::from(N_BANDS)).sin_cos();
        DVec3::new(sin * east, cos, sin * south)
    };
    let (mut corners, mut triangles, mut attributes) =
        (Vec::new(), Vec::new(), TriangleAttributes::default());
    for band in 0..N_BANDS {
        for meridian in 0..2 * N_BANDS {
            let patch = [(0, 0), (1, 0), (1, 1), (0, 1)]
                .map(|(down, east)| place(band + down, meridian + east));
            for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
                let first = corners.len() as u32;
                corners.extend([patch[a], patch[b], patch[c]]);
                triangles.push([first, first + 1, first + 2]);
                let normal = |index: usize| sign.map(|sign| sign * patch[index].as_vec3());
                let normals = [a, b, c].map(normal);
                attributes
                    .normals
                    .extend(normals[0].map(|_| normals.map(Option::unwrap_or_default)));
            }
        }
    }
    TriangleMesh::with_attributes(&corners, &triangles, attributes).unwrap()
}

fn placed(mesh: &TriangleMesh) -> Solid {
    let to_world =
        DAffine3::from_translation(MIDDLE) * DAffine3::from_scale(DVec3::splat(RADIUS_M));
    Solid {
        shape: SolidShape::Mesh(MeshBvh::new(mesh.placed(&to_world).unwrap())),
        albedo: Some(Reflectance::Even(ALBEDO).into()),
    }
}

fn sun() -> DVec3 {
    DVec3::new(1.0, 0.4, -0.2).normalize()
}

/// Light over that of a face across the sun along one ray, by its azimuth and elevation (deg).
fn cos_seen(surfaces: &Surfaces, look_deg: (f64, f64)) -> f64 {
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let camera = camera(EYE, look_deg, 1e-6, (1, 1));
    let mut request = request(&camera, sun(), &drops, &table);
    request.surfaces = Some(surfaces);
    request.effects = RenderEffects {
        lit_surfaces: Toggle::On,
        ..RenderEffects::BOWS_ONLY
    };
    f64::from(rendered(&request).radiance[[1, 0, 0]]) / (SUN[1] * ALBEDO * FRAC_1_PI)
}

/// Sights of the ball up to 50 degrees off the line from its middle to the eye, and its normals there.
fn sights() -> Vec<((f64, f64), DVec3)> {
    let mut sights = Vec::new();
    for row in -9..=9 {
        for column in -9..=9 {
            let look_deg = (0.49 * f64::from(column), 0.47 * f64::from(row));
            let (up, level) = look_deg.1.to_radians().sin_cos();
            let (east, north) = look_deg.0.to_radians().sin_cos();
            let along = DVec3::new(level * east, up, -level * north);
            let half = along.dot(MIDDLE - EYE);
            let square = half * half - (MIDDLE - EYE).length_squared() + RADIUS_M * RADIUS_M;
            let normal = (EYE + (half - square.max(0.0).sqrt()) * along - MIDDLE) / RADIUS_M;
            if square > 0.0 && normal.dot(-along) > 0.64 {
                sights.push((look_deg, normal));
            }
        }
    }
    sights
}

#[test]
fn a_mesh_with_the_normals_of_a_sphere_is_lit_as_the_sphere_and_without_them_is_not() {
    let [smooth, flat, inwards] =
        [Some(1.0), None, Some(-1.0)].map(|sign| Surfaces::default().with(placed(&ball(sign))));
    let (mut worst, mut worst_flat, mut n_beside_night) = (0.0_f64, 0.0_f64, 0);
    let sights = sights();
    for (look_deg, normal) in &sights {
        let expected = normal.dot(sun()).max(0.0);
        let found = cos_seen(&smooth, *look_deg);
        assert!(found.is_finite() && found >= 0.0);
        // Normals that point inwards are those of a mesh that runs the other way round.
        assert_eq!(found, cos_seen(&inwards, *look_deg), "{look_deg:?}");
        // What is so near to the edge of night may lie on a triangle that turns away.
        if expected < off_rad().sin() {
            n_beside_night += 1;
            assert!(found <= off_rad().sin() + 0.006, "{look_deg:?}: {found}");
            continue;
        }
        worst = worst.max((found - expected).abs());
        worst_flat = worst_flat.max((cos_seen(&flat, *look_deg) - expected).abs());
    }
    assert!(
        sights.len() > 200 && n_beside_night > 50,
        "{} {n_beside_night}",
        sights.len()
    );
    // Places lie up to (1 - cos 4 degrees) of the radius below the sphere, and beside as much times the tangent of 50.
    let below = (1.0 - off_rad().cos()) * 50.0_f64.to_radians().tan();
    // Worst found 0.0018 of the light of a face across the sun, 0.057 of the flat mesh.
    assert!(worst < below, "{worst} {below}");
    assert!(worst_flat > 10.0 * worst, "{worst_flat} {worst}");
}

#[test]
fn the_sun_behind_a_triangle_never_lights_it() {
    // The sun 10 degrees behind a face towards the eye and before it, with normals that lean to the sun.
    let across = DVec3::Z.reject_from_normalized(sun()).normalize();
    for before_deg in [-10.0_f64, 10.0] {
        let (sin, cos) = before_deg.to_radians().sin_cos();
        let side = cos * across + sin * sun();
        let normal = (side + 0.6 * sun()).normalize();
        let east = side.any_orthonormal_vector();
        let north = side.cross(east);
        let corners = [-east - north, east - north, north].map(|at| 20.0 * at + MIDDLE);
        let attributes = TriangleAttributes {
            normals: vec![[normal.as_vec3(); 3]],
            ..TriangleAttributes::default()
        };
        let mesh = TriangleMesh::with_attributes(&corners, &[[0, 1, 2]], attributes).unwrap();
        let solid = Solid {
            shape: SolidShape::Mesh(MeshBvh::new(mesh)),
            albedo: Some(Reflectance::Even(ALBEDO).into()),
        };
        let found = cos_seen(&Surfaces::default().with(solid), (0.0, 0.0));
        let of_normal = normal.dot(sun());
        assert!(of_normal > 0.3, "{of_normal}");
        let expected = if before_deg > 0.0 { of_normal } else { 0.0 };
        assert!(
            (found - expected).abs() < 1e-6,
            "{before_deg}: {found} {expected}"
        );
    }
}
