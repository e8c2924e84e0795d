//! Meshes end view rays as a map of their distances does.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Array2;
use niji_dropfield::GridBox;
use niji_geometry::Camera;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleMesh;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;

/// The drops begin and end here, to the north, and fade over a voxel of 4 m [m].
const NEAR_M: f64 = 20.0;
const FAR_M: f64 = 60.0;

/// Light up to a distance that is stored in f32; measured 3.2e-7.
const F32: f64 = 2e-6;

fn fog() -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-80.0, -80.0, -FAR_M),
        max: DVec3::new(80.0, 80.0, -NEAR_M),
        voxel_m: 4.0,
    };
    let bricks = bricks(&grid, |_| 0.02);
    LitDrops::new(vec![bricks], sun_in_the_south(30.0), SunPath::Ignore).unwrap()
}

/// A wall across the north at a distance, from `x_m.0` to `x_m.1`.
fn wall_between(distance_m: f64, x_m: (f64, f64)) -> MeshBvh {
    let corner = |x, y| DVec3::new(x, y, -distance_m);
    let corners = [
        corner(x_m.0, -900.0),
        corner(x_m.1, -900.0),
        corner(x_m.1, 900.0),
        corner(x_m.0, 900.0),
    ];
    MeshBvh::new(TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap())
}

fn wall(distance_m: f64) -> MeshBvh {
    wall_between(distance_m, (-900.0, 900.0))
}

/// The distances of the wall along the rays through the middles of pixels.
fn map(camera: &Camera, distance_m: f64) -> Array2<f32> {
    let size = (camera.height_px() as usize, camera.width_px() as usize);
    Array2::from_shape_fn(size, |(y, x)| {
        let ray = camera.ray(x as f64 + 0.5, y as f64 + 0.5).unwrap();
        (distance_m / -ray.direction.z) as f32
    })
}

fn picture(camera: &Camera, surfaces: Option<&Surfaces>, footprint: PixelFootprint) -> Rendered {
    let (drops, table) = (fog(), isotropic(0.1));
    let mut request = request(camera, sun_in_the_south(30.0), &drops, &table);
    request.effects.drop_extinction = Toggle::On;
    request.levels.pixel_footprint = footprint;
    request.surfaces = surfaces;
    rendered(&request)
}

/// Odd in both directions: the ray of the middle pixel runs along the axis.
fn wide() -> Camera {
    camera(DVec3::ZERO, (0.0, 0.0), 70.0, (21, 15))
}

#[test]
fn a_wall_is_a_map_of_its_distances() {
    let camera = wide();
    for distance_m in [25.0, 39.5, 58.0] {
        let of_mesh = Surfaces::of_mesh(wall(distance_m));
        let of_map = Surfaces::new(map(&camera, distance_m)).unwrap();
        let of_mesh = picture(&camera, Some(&of_mesh), PixelFootprint::Center);
        let of_map = picture(&camera, Some(&of_map), PixelFootprint::Center);
        for (mesh, map) in of_mesh.radiance.iter().zip(&of_map.radiance) {
            assert!(*map > 0.0);
            assert!(
                relative(f64::from(*mesh), f64::from(*map)) < F32,
                "{mesh} {map}"
            );
        }
        let (mesh, map) = (
            &of_mesh[PictureLayer::Surface],
            &of_map[PictureLayer::Surface],
        );
        for (mesh, map) in mesh.iter().zip(map) {
            assert!(relative(f64::from(*mesh), f64::from(*map)) < F32);
        }
    }
}

#[test]
fn before_the_drops_a_mesh_hides_them_and_behind_them_it_changes_nothing() {
    let camera = wide();
    let open = picture(&camera, None, PixelFootprint::Center);
    assert!(open.radiance.iter().all(|light| *light > 0.0));
    let near = Surfaces::of_mesh(wall(NEAR_M - 5.0));
    let near = picture(&camera, Some(&near), PixelFootprint::Center);
    assert!(near.radiance.iter().all(|light| *light == 0.0));
    assert!(
        near[PictureLayer::Transmittance]
            .iter()
            .all(|through| *through == 1.0)
    );
    let far = Surfaces::of_mesh(wall(FAR_M + 5.0));
    let far = picture(&camera, Some(&far), PixelFootprint::Center);
    assert_eq!(far.radiance, open.radiance);
    assert_eq!(
        far[PictureLayer::Transmittance],
        open[PictureLayer::Transmittance]
    );
}

#[test]
fn of_map_and_mesh_the_nearer_counts() {
    let camera = wide();
    for (map_m, mesh_m) in [(30.0, 45.0), (45.0, 30.0)] {
        let both = Surfaces::new(map(&camera, map_m)).unwrap();
        let both = both.with_mesh(wall(mesh_m));
        let both = picture(&camera, Some(&both), PixelFootprint::Center);
        let near = Surfaces::new(map(&camera, 30.0)).unwrap();
        let near = picture(&camera, Some(&near), PixelFootprint::Center);
        for (both, near) in both.radiance.iter().zip(&near.radiance) {
            assert!(relative(f64::from(*both), f64::from(*near)) < F32);
        }
    }
}

/// The diagonal of the wall runs through the axis, its parts meet on it and on the ray of every
/// pixel of the middle column.
#[test]
fn rays_along_edges_slip_through_nowhere() {
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 70.0, (21, 21));
    let corner = |x, y| DVec3::new(x, y, -30.0);
    let corners = [
        corner(-90.0, -90.0),
        corner(0.0, -90.0),
        corner(90.0, -90.0),
        corner(-90.0, 90.0),
        corner(0.0, 90.0),
        corner(90.0, 90.0),
        corner(0.0, 0.0),
    ];
    let triangles = [
        [0, 1, 6],
        [1, 2, 6],
        [2, 5, 6],
        [5, 4, 6],
        [4, 3, 6],
        [3, 0, 6],
    ];
    let mesh = TriangleMesh::new(&corners, &triangles).unwrap();
    let surfaces = Surfaces::of_mesh(MeshBvh::new(mesh));
    let picture = picture(&camera, Some(&surfaces), PixelFootprint::Center);
    let expected = map(&camera, 30.0);
    for (found, expected) in picture[PictureLayer::Surface].iter().zip(&expected) {
        assert!(
            relative(f64::from(*found), f64::from(*expected)) < F32,
            "{found}"
        );
    }
}

#[test]
fn an_edge_through_a_pixel_takes_its_share_of_the_rays() {
    let camera = camera(DVec3::ZERO, (0.0, 0.0), 10.0, (3, 1));
    let footprint = PixelFootprint::Grid { n: 4 };
    let open = picture(&camera, None, footprint);
    // From the left to the middle of the middle pixel.
    let half = Surfaces::of_mesh(wall_between(10.0, (-900.0, 0.0)));
    let half = picture(&camera, Some(&half), footprint);
    let share = |x: usize| half.radiance[[0, 0, x]] / open.radiance[[0, 0, x]];
    assert_eq!((share(0), share(2)), (0.0, 1.0));
    assert!((share(1) - 0.5).abs() < 1e-6, "{}", share(1));
}

#[test]
fn an_eye_on_a_mesh_looks_away_from_it() {
    let camera = wide();
    let open = picture(&camera, None, PixelFootprint::Center);
    let here = Surfaces::of_mesh(wall(0.0));
    let here = picture(&camera, Some(&here), PixelFootprint::Center);
    assert_eq!(here.radiance, open.radiance);
}
