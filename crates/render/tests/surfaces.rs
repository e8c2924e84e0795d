//! Surfaces end the ray integral: bow, light of the air and transmittance.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Array2;
use niji_dropfield::GridBox;
use niji_geometry::Camera;
use niji_render::Error;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;
use niji_render::render;

/// Extinction of the drops at Q = 1 [1/m], between 20 and 60 m to the north.
const EXTINCTION_M1: f64 = 0.02;
const NEAR_M: f64 = 20.0;
const FAR_M: f64 = 60.0;

/// Share of the light that may be missing by rounding in f32; found: 1.7e-6.
const F32: f64 = 5e-6;

/// The fog begins and ends within one voxel; inside it is homogeneous to the rounding.
fn fog() -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-40.0, -40.0, -FAR_M),
        max: DVec3::new(40.0, 40.0, -NEAR_M),
        voxel_m: 1.0,
    };
    let bricks = bricks(&grid, |_| EXTINCTION_M1);
    LitDrops::new(vec![bricks], sun_in_the_south(30.0), SunPath::Ignore).unwrap()
}

fn wall(camera: &Camera, distance_m: f64) -> Surfaces {
    let size = (camera.height_px() as usize, camera.width_px() as usize);
    Surfaces::new(Array2::from_elem(size, distance_m as f32)).unwrap()
}

/// Light and transmittance of one ray to the north with dimming drops and a wall.
fn behind_wall(integration: Integration, distance_m: f64) -> (f64, f64) {
    let (drops, camera) = (fog(), one_ray(DVec3::ZERO));
    let (table, surfaces) = (isotropic(0.1), wall(&camera, distance_m));
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    request.effects.drop_extinction = Toggle::On;
    request.levels.integration = integration;
    request.surfaces = Some(&surfaces);
    let picture = rendered(&request);
    (
        f64::from(picture.radiance[[0, 0, 0]]),
        f64::from(picture[PictureLayer::Transmittance][[0, 0, 0]]),
    )
}

#[test]
fn a_wall_in_the_fog_leaves_the_line_integral_up_to_it() {
    for integration in [
        Integration::CellExact,
        Integration::Adaptive {
            relative_error: 1e-6,
        },
    ] {
        let light_up_to = |distance_m| behind_wall(integration, distance_m).0;
        let first = light_up_to(24.3);
        for distance_m in [25.0, 25.5, 31.7, 48.25, 58.9] {
            // From 24.3 m on the fog is homogeneous: the light grows as 1 - exp(-tau).
            let (light, through) = behind_wall(integration, distance_m);
            let (_, through_first) = behind_wall(integration, 24.3);
            let tau = EXTINCTION_M1 * (distance_m - 24.3);
            assert!((through / through_first / (-tau).exp() - 1.0).abs() < F32);
            let expected = SUN[0] * 0.1 * through_first * -(-tau).exp_m1();
            assert!(
                ((light - first) / expected - 1.0).abs() < 2e-4,
                "{integration:?} {distance_m}: {} {expected}",
                light - first
            );
        }
    }
}

#[test]
fn the_published_march_stops_at_the_wall_too() {
    let integration = Integration::FixedStep { step_m: 0.25 };
    let (published, _) = behind_wall(integration, 33.3);
    let (exact, _) = behind_wall(Integration::CellExact, 33.3);
    assert!(
        (published / exact - 1.0).abs() < 1e-3,
        "{published} {exact}"
    );
}

#[test]
fn a_wall_before_the_drops_hides_them_and_one_behind_them_changes_nothing() {
    let integration = Integration::CellExact;
    for distance_m in [0.0, 1e-3, NEAR_M - 1.0] {
        assert_eq!(behind_wall(integration, distance_m), (0.0, 1.0));
    }
    let open = behind_wall(integration, f64::INFINITY);
    assert_eq!(behind_wall(integration, FAR_M + 1.0), open);
    assert!(open.0 > 0.0 && open.1 < 1.0);
}

/// A picture in air with everything on, behind a map of surfaces.
fn in_air(surfaces: Option<&Surfaces>) -> Rendered {
    let drops = fog();
    let camera = camera(DVec3::new(0.0, 2.0, 0.0), (0.0, 20.0), 40.0, (8, 6));
    let (table, air) = (isotropic(0.1), air([1e-4; 3], [1e-4; 3]));
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    request.effects = RenderEffects {
        drop_shadow: Toggle::Off,
        ..RenderEffects::ALL
    };
    request.air = Some(&air);
    request.surfaces = surfaces;
    rendered(&request)
}

#[test]
fn the_sky_does_not_shine_through_a_wall() {
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 40.0, (8, 6));
    let open = in_air(None);
    // Ten metres of air of 1e-4/m are all that is left before a wall at 10 m.
    let near = in_air(Some(&wall(&camera, 10.0)));
    for (near, open) in near.radiance.iter().zip(&open.radiance) {
        assert!(*near > 0.0 && *near < 1e-2 * open, "{near} {open}");
    }
    assert!(
        near[PictureLayer::Inscatter]
            .iter()
            .all(|light| *light == 0.0)
    );
    // Behind the drops the wall takes the sky, not the light of drops and air before it.
    let far = in_air(Some(&wall(&camera, 100.0)));
    assert_eq!(
        far[PictureLayer::BowPrimary],
        open[PictureLayer::BowPrimary]
    );
    assert_eq!(far[PictureLayer::Inscatter], open[PictureLayer::Inscatter]);
    assert_eq!(far[PictureLayer::Skylit], open[PictureLayer::Skylit]);
    assert!(
        far.radiance
            .iter()
            .zip(&open.radiance)
            .all(|(far, open)| far < open)
    );
    // In the fog it takes a part of all of them.
    let inside = in_air(Some(&wall(&camera, 40.0)));
    let less = |a: &ndarray::Array3<f32>, b: &ndarray::Array3<f32>| {
        a.iter().zip(b).all(|(a, b)| *a < *b || *b == 0.0)
    };
    assert!(less(
        &inside[PictureLayer::Inscatter],
        &open[PictureLayer::Inscatter]
    ));
    assert!(less(
        &inside[PictureLayer::BowPrimary],
        &open[PictureLayer::BowPrimary]
    ));
    let skylit = |picture: &Rendered| picture[PictureLayer::Skylit].clone();
    assert!(less(&skylit(&inside), &skylit(&open)));
}

#[test]
fn edges_of_surfaces_are_those_of_the_map() {
    let drops = fog();
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 20.0, (8, 6));
    let table = isotropic(0.1);
    // The left half is hidden by a wall at 5 m; the map is four times as fine as the picture.
    let fine = Array2::from_shape_fn((24, 32), |(_, x)| if x < 18 { 5.0 } else { f32::NAN });
    let surfaces = Surfaces::new(fine).unwrap();
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    let open = rendered(&request);
    request.surfaces = Some(&surfaces);
    let hidden = rendered(&request);
    let surface = hidden[PictureLayer::Surface].clone();
    for ((y, x), light) in hidden
        .radiance
        .index_axis(ndarray::Axis(0), 0)
        .indexed_iter()
    {
        let expected = if x < 4 { 0.0 } else { open.radiance[[0, y, x]] };
        assert_eq!(*light, expected, "{x} {y}");
        assert_eq!(surface[[0, y, x]], if x < 4 { 5.0 } else { f32::INFINITY });
    }
    // Four rays across a pixel see half of the wall in pixel 4.
    request.levels.pixel_footprint = PixelFootprint::Grid { n: 4 };
    let fine = rendered(&request);
    let share = fine.radiance[[0, 3, 4]] / fine.radiance[[0, 3, 5]];
    assert!((share - 0.5).abs() < 1e-3, "{share}");
}

#[test]
fn maps_of_another_shape_are_refused() {
    let drops = fog();
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 20.0, (80, 60));
    let table = isotropic(0.1);
    let surfaces = Surfaces::new(Array2::from_elem((60, 90), 5.0)).unwrap();
    let mut request = request(&camera, sun_in_the_south(30.0), &drops, &table);
    request.surfaces = Some(&surfaces);
    let error = render(&request, &|_| ()).unwrap_err();
    let (found, expected) = ((90, 60), (80, 60));
    assert_eq!(error, Error::SurfaceShape { found, expected });
    assert!(error.to_string().contains("90 x 60"), "{error}");
}
