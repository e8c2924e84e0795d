//! Surfaces with an albedo against closed forms: light of sun and sky, shadows of walls, terrain and drops.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_exchange::AtmosphereTable;
use niji_geometry::Camera;
use niji_geometry::HeightField;
use niji_geometry::HeightMap;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleMesh;
use niji_radiometry::Reflectance;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::RenderEffects;
use niji_render::Rendered;
use niji_render::SkyModel;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;

use std::f64::consts::FRAC_1_PI;

/// Albedo of the ground in the tests' air.
const ALBEDO: f64 = 0.3;

/// Light stored in f32; measured 1.2e-7.
const F32: f64 = 1e-6;

/// A rectangle from its middle and two sides.
fn rectangle(middle: DVec3, [a, b]: [DVec3; 2]) -> SolidShape {
    let corners = [-a - b, a - b, a + b, b - a].map(|corner| middle + 0.5 * corner);
    let mesh = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    SolidShape::Mesh(MeshBvh::new(mesh))
}

fn lit(shape: SolidShape) -> Solid {
    Solid {
        shape,
        albedo: Some(Reflectance::Even(ALBEDO).into()),
    }
}

/// The plane y = 0, kilometres wide.
fn floor() -> Solid {
    lit(rectangle(DVec3::ZERO, [2e4 * DVec3::Z, 2e4 * DVec3::X]))
}

/// A wall across the north, upright on the floor.
fn wall(distance_m: f64, height_m: f64) -> SolidShape {
    let middle = DVec3::new(0.0, 0.5 * height_m, -distance_m);
    rectangle(middle, [400.0 * DVec3::X, height_m * DVec3::Y])
}

struct Scene<'a> {
    sun: DVec3,
    drops: LitDrops,
    air: Option<&'a AtmosphereTable>,
    surfaces: Option<Surfaces>,
}

impl Scene<'_> {
    fn seen(&self, camera: &Camera, tolerance_cd_m2: Option<f64>) -> Rendered {
        let table = isotropic(0.0);
        let mut request = request(camera, self.sun, &self.drops, &table);
        request.air = self.air;
        request.surfaces = self.surfaces.as_ref();
        request.tolerance_cd_m2 = tolerance_cd_m2;
        let is_on = |is_on| if is_on { Toggle::On } else { Toggle::Off };
        let has_air = self.air.is_some();
        request.effects = RenderEffects {
            lit_surfaces: Toggle::On,
            sky: is_on(has_air),
            drop_shadow: is_on(self.drops.bounds().is_some()),
            drop_extinction: Toggle::On,
            ..RenderEffects::BOWS_ONLY
        };
        if self.air.is_some_and(|air| air.diffuse.is_some()) {
            request.levels.sky_model = SkyModel::MultipleScattering;
        }
        rendered(&request)
    }

    /// Light of the middle wavelength along one ray.
    fn ray(&self, eye: DVec3, look_deg: (f64, f64)) -> f64 {
        let picture = self.seen(&camera(eye, look_deg, 1e-3, (1, 1)), None);
        f64::from(picture.radiance[[1, 0, 0]])
    }
}

fn in_a_vacuum(sun: DVec3, surfaces: Surfaces) -> Scene<'static> {
    Scene {
        sun,
        drops: LitDrops::none(),
        air: None,
        surfaces: Some(surfaces),
    }
}

#[test]
fn a_face_in_the_sun_sends_its_irradiance_over_pi_from_both_sides() {
    for tilt_deg in [0.0, 20.0, 63.0, 110.0_f64] {
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        let normal = DVec3::new(0.0, cos, sin);
        let sides = [1000.0 * DVec3::X, 1000.0 * DVec3::X.cross(normal)];
        let surfaces = Surfaces::default().with(lit(rectangle(DVec3::ZERO, sides)));
        for elevation_deg in [5.0, 40.0, 90.0] {
            let sun = sun_in_the_south(elevation_deg);
            let scene = in_a_vacuum(sun, surfaces.clone());
            // Along the normal, from both sides.
            for side in [1.0, -1.0] {
                let look_deg = (
                    if side * normal.z >= 0.0 { 0.0 } else { 180.0 },
                    (-side * normal.y).asin().to_degrees(),
                );
                let found = scene.ray(30.0 * side * normal, look_deg);
                let cos_sun = (side * normal.dot(sun)).max(0.0);
                let expected = SUN[1] * ALBEDO * FRAC_1_PI * cos_sun;
                assert!(
                    (found - expected).abs() <= F32 * SUN[1],
                    "{tilt_deg} {elevation_deg} {side}"
                );
            }
        }
    }
}

#[test]
fn without_an_albedo_or_with_the_effect_off_a_surface_is_black() {
    let camera = camera(DVec3::new(0.0, 30.0, 0.0), (0.0, -45.0), 20.0, (6, 4));
    let black = Solid {
        albedo: None,
        ..floor()
    };
    let scene = in_a_vacuum(sun_in_the_south(40.0), Surfaces::default().with(black));
    assert!(
        scene
            .seen(&camera, None)
            .radiance
            .iter()
            .all(|light| *light == 0.0)
    );
    let surfaces = Surfaces::default().with(floor());
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let mut off = request(&camera, sun_in_the_south(40.0), &drops, &table);
    off.surfaces = Some(&surfaces);
    assert!(rendered(&off).radiance.iter().all(|light| *light == 0.0));
}

#[test]
fn a_floor_is_as_bright_as_the_ground_of_the_air() {
    let mut air = air([4e-5, 2e-5, 1e-5], [4e-5, 2e-5, 1e-5]);
    for radiance in [None, Some(0.02)] {
        air.diffuse = radiance.map(uniform_light);
        for elevation_deg in [10.0, 55.0] {
            let scene = |surfaces| Scene {
                sun: sun_in_the_south(elevation_deg),
                drops: LitDrops::none(),
                air: Some(&air),
                surfaces,
            };
            let (eye, look_deg) = (DVec3::new(0.0, 20.0, 0.0), (30.0, -25.0));
            let ground = scene(None).ray(eye, look_deg);
            let floor = scene(Some(Surfaces::default().with(floor()))).ray(eye, look_deg);
            // Measured 3e-5: the planet is curved.
            assert!(
                relative(floor, ground) < 1e-4,
                "{elevation_deg}: {floor} {ground}"
            );
            assert!(ground > 0.0);
        }
    }
}

#[test]
fn ground_beside_a_wall_has_the_light_that_it_sends_a_floor() {
    let mut air = air([4e-5, 2e-5, 1e-5], [4e-5, 2e-5, 1e-5]);
    for radiance in [None, Some(0.02)] {
        air.diffuse = radiance.map(uniform_light);
        for (away_m, look_deg) in [(12.0, (0.0, -30.0)), (9.5, (10.0, -60.0))] {
            let seen = |surfaces| {
                let scene = Scene {
                    sun: sun_in_the_south(30.0),
                    drops: LitDrops::none(),
                    air: Some(&air),
                    surfaces: Some(surfaces),
                };
                scene.ray(DVec3::new(0.0, 8.0, 4.0), look_deg)
            };
            let white = || lit(wall(away_m, 20.0));
            let black = Solid {
                albedo: None,
                ..white()
            };
            let ground = seen(Surfaces::default().with(white()));
            let on_floor = seen(Surfaces::default().with(white()).with(floor()));
            let without = seen(Surfaces::default().with(black));
            // Measured 0.32 % at most: light goes on from the floor as from the ground, but by another ray.
            assert!(
                relative(ground, on_floor) < 0.005,
                "{away_m}: {ground} {on_floor}"
            );
            assert!(ground > 1.08 * without, "{away_m}: {ground} {without}");
        }
    }
}

#[test]
fn an_even_sky_lights_faces_of_all_tilts_alike_and_a_wall_takes_its_part() {
    // No ground that reflects: with it, and as bright all around, the same.
    let (radiance, elevation_deg) = (0.02_f32, 30.0);
    let mut air = air([0.0; 3], [0.0; 3]);
    air.ground_albedo = vec![0.0; 3];
    air.diffuse = Some(uniform_light(radiance));
    let sun = sun_in_the_south(elevation_deg);
    let scene = |surfaces| Scene {
        sun,
        drops: LitDrops::none(),
        air: Some(&air),
        surfaces: Some(surfaces),
    };
    let expected = SUN[1] * ALBEDO * f64::from(radiance);
    for tilt_deg in [100.0, 140.0, 180.0_f64] {
        // Away from the sun.
        let (sin, cos) = tilt_deg.to_radians().sin_cos();
        let normal = DVec3::new(0.0, cos, -sin);
        let middle = DVec3::new(0.0, 100.0, 0.0);
        let shape = rectangle(middle, [10.0 * DVec3::X, 10.0 * DVec3::X.cross(normal)]);
        let eye = middle + 3.0 * normal;
        let look_deg = (180.0, (-normal.y).asin().to_degrees());
        let found = scene(Surfaces::default().with(lit(shape))).ray(eye, look_deg);
        assert!(
            relative(found, expected) < 1e-5,
            "{tilt_deg}: {found} {expected}"
        );
    }
    // In the shadow close behind a wall half of the sky is left. A lit one has half of its own, and both send each other
    // A/2 of what they have.
    let in_shadow = |wall: Solid| {
        let shaded = scene(Surfaces::default().with(floor()).with(wall));
        shaded.ray(DVec3::new(0.0, 5.0, -0.5), (0.0, -90.0)) / expected
    };
    let high = || wall(0.0, 4000.0);
    let black = in_shadow(Solid {
        shape: high(),
        albedo: None,
    });
    assert!((black - 0.5).abs() < 0.01, "{black}");
    let alike = in_shadow(lit(high()));
    let series = 0.5 / (1.0 - 0.5 * ALBEDO);
    assert!(relative(alike, series) < 0.05, "{alike} {series}");
}

/// Where along a column of pixels that look straight down from a height the light falls to half (m north).
fn edge_m(picture: &Rendered, height_m: f64, fov_deg: f64) -> f64 {
    let light = picture.radiance.slice(ndarray::s![1, .., 0]);
    let (dark, bright) = light
        .iter()
        .fold((f32::MAX, 0.0_f32), |(a, b), it| (a.min(*it), b.max(*it)));
    assert!(dark < 1e-3 * bright, "{dark} {bright}");
    let sunlit: f64 = light
        .iter()
        .map(|it| f64::from((it - dark) / (bright - dark)))
        .sum();
    let n = light.len() as f64;
    // Pixels are even on the floor; rows run from north to south, and the south is in the shadow.
    let reach_m = height_m * (0.5 * fov_deg.to_radians()).tan();
    reach_m - 2.0 * reach_m * sunlit / n
}

#[test]
fn the_shadow_of_a_wall_ends_where_the_sun_looks_over_it() {
    let (elevation_deg, height_m, eye_m, fov_deg) = (35.0_f64, 10.0, 200.0, 12.0);
    let expected_m = height_m / elevation_deg.to_radians().tan();
    let mut clear = air([0.0; 3], [0.0; 3]);
    clear.ground_albedo = vec![ALBEDO; 3];
    // A column of one pixel: the horizontal field of view is that of its width.
    let n = 21;
    let width_deg = 2.0
        * ((0.5 * f64::to_radians(fov_deg)).tan() / f64::from(n))
            .atan()
            .to_degrees();
    for (surfaces, air) in [
        (Surfaces::default().with(floor()), None),
        (Surfaces::default(), Some(&clear)),
    ] {
        // A wall without an albedo throws a shadow all the same.
        let black = Solid {
            shape: wall(0.0, height_m),
            albedo: None,
        };
        let scene = Scene {
            sun: sun_in_the_south(elevation_deg),
            drops: LitDrops::none(),
            air,
            surfaces: Some(surfaces.with(black)),
        };
        let eye = DVec3::new(0.0, eye_m, -20.0);
        let camera = camera(eye, (0.0, -89.999_999), width_deg, (1, n));
        let picture = scene.seen(&camera, Some(1.0));
        let found_m = 20.0 + edge_m(&picture, eye_m, fov_deg);
        // Pixels are 2 m wide: an edge through one is where it is to a hundredth.
        assert!(
            (found_m - expected_m).abs() < 0.02,
            "{found_m} {expected_m}"
        );
    }
}

#[test]
fn drops_dim_the_floor_and_the_ground_as_a_layer_does_that_scatters_light_down() {
    let sun = sun_in_the_south(50.0);
    // Eddington's layer, 1 - g = 0.283; `under_drops` holds it against adding and doubling.
    let through = |depth: f64| {
        let (sine, scaled) = (sun.y, 0.283 * sun.y * depth);
        let lit = 2.0 / 3.0 + sine + (2.0 / 3.0 - sine) * (-scaled / sine).exp();
        lit / (4.0 / 3.0 + scaled)
    };
    let clear = air([0.0; 3], [0.0; 3]);
    for depth in [0.1, 1.0, 4.0_f64] {
        let thick_m = 100.0;
        let grid = GridBox {
            min: DVec3::new(-300.0, 100.0, -400.0),
            max: DVec3::new(300.0, 100.0 + thick_m, 400.0),
            voxel_m: 5.0,
        };
        let slab = bricks(&grid, |_| depth * sun.y / thick_m);
        let path = SunPath::Volume { voxel_m: 5.0 };
        let light = |surfaces, air, has_drops| {
            let drops = if has_drops {
                LitDrops::new(vec![slab.clone()], sun, path).unwrap()
            } else {
                LitDrops::none()
            };
            let scene = Scene {
                sun,
                drops,
                air,
                surfaces,
            };
            // From below the slab.
            scene.ray(DVec3::new(0.0, 10.0, 0.0), (0.0, -60.0))
        };
        for (surfaces, air) in [
            (Some(Surfaces::default().with(floor())), None),
            (None, Some(&clear)),
        ] {
            let dimmed = light(surfaces.clone(), air, true) / light(surfaces, air, false);
            // Drops in f32, and outermost voxels that they fade in: measured 2e-7.
            assert!(relative(dimmed, through(depth)) < 1e-4, "{depth}: {dimmed}");
        }
    }
}

#[test]
fn an_overcast_sky_is_darker_by_what_its_clouds_keep() {
    let mut air = air([0.0; 3], [0.0; 3]);
    air.ground_albedo = vec![0.0; 3];
    air.diffuse = Some(uniform_light(0.02));
    // Below the horizon: all light is of the sky.
    let sun = sun_in_the_south(-20.0);
    let light = |depth: f64| {
        let grid = GridBox {
            min: DVec3::new(-900.0, 80.0, -900.0),
            max: DVec3::new(900.0, 120.0, 900.0),
            voxel_m: 20.0,
        };
        let path = SunPath::Volume { voxel_m: 20.0 };
        let layer = bricks(&grid, |_| depth / 40.0);
        let scene = Scene {
            sun,
            drops: LitDrops::new(vec![layer], sun, path).unwrap(),
            air: Some(&air),
            surfaces: Some(Surfaces::default().with(floor())),
        };
        scene.ray(DVec3::new(0.0, 10.0, 0.0), (0.0, -60.0))
    };
    let open = light(1e-9);
    for depth in [0.5, 5.0, 25.0] {
        let expected = 1.0 / (1.0 + 0.75 * 0.283 * depth);
        // The lowest of the directions looked along sees 370 m far; measured 2e-6.
        let found = light(depth) / open;
        assert!(
            relative(found, expected) < 1e-4,
            "{depth}: {found} {expected}"
        );
    }
}

/// Heights over a square of `n` nodes, 2 m apart.
fn field(n: usize, height_m: impl Fn(f64, f64) -> f64) -> HeightField {
    let spacing_m = 2.0;
    let half_m = 0.5 * spacing_m * (n - 1) as f64;
    let at = |index: usize| spacing_m * index as f64 - half_m;
    let places = (0..n * n).map(|place| (at(place % n), at(place / n)));
    HeightField::new(HeightMap {
        size: (n, n),
        height_m: places.map(|(x, z)| height_m(x, z) as f32).collect(),
        spacing_m,
        corner: DVec3::new(-half_m, 0.0, -half_m),
    })
    .unwrap()
}

#[test]
fn terrain_is_lit_by_its_slope_and_shades_itself() {
    let sun = sun_in_the_south(30.0);
    let slope = |x: f64, z: f64| 0.4 * x - 0.2 * z;
    let normal = DVec3::new(-0.4, 1.0, 0.2).normalize();
    let plane = lit(SolidShape::Heights(field(101, slope)));
    let found = in_a_vacuum(sun, Surfaces::default().with(plane))
        .ray(DVec3::new(3.0, 90.0, 5.0), (0.0, -90.0));
    let expected = SUN[1] * ALBEDO * FRAC_1_PI * normal.dot(sun);
    // Heights in f32: measured 4e-7.
    assert!(relative(found, expected) < 1e-5, "{found} {expected}");
    // A bump of 12 m on a plane, with 20 m of shadow to its north.
    let bump = |x: f64, z: f64| 12.0 * (-(x * x + z * z) / 30.0).exp();
    let hill = lit(SolidShape::Heights(field(101, bump)));
    let scene = in_a_vacuum(sun, Surfaces::default().with(hill));
    let level = SUN[1] * ALBEDO * FRAC_1_PI * sun.y;
    let north = |distance_m: f64| scene.ray(DVec3::new(0.3, 50.0, -distance_m), (0.0, -90.0));
    for (distance_m, is_sunlit) in [(15.0, false), (17.0, false), (30.0, true), (-25.0, true)] {
        let straight = if is_sunlit { level } else { 0.0 };
        // The sunlit side of the hill sends a little.
        let more = north(distance_m) - straight;
        let most = if distance_m < 0.0 { 0.01 } else { 1e-3 };
        assert!(
            (-1e-6..most).contains(&(more / level)),
            "{distance_m}: {more}"
        );
    }
}

#[test]
fn drops_in_front_of_a_lit_wall_count_as_before_any_end_of_a_ray() {
    // So high that it shines on the wall above the fog.
    let sun = sun_in_the_south(80.0);
    let grid = GridBox {
        min: DVec3::new(-40.0, -40.0, -60.0),
        max: DVec3::new(40.0, 40.0, -20.0),
        voxel_m: 1.0,
    };
    let fog = bricks(&grid, |_| 0.02);
    let surfaces = || Surfaces::default().with(lit(wall(100.0, 200.0)));
    let scene = |drops| Scene {
        sun,
        drops,
        air: None,
        surfaces: Some(surfaces()),
    };
    let camera = one_ray(DVec3::new(0.0, 1.0, 0.0));
    let open = scene(LitDrops::none()).seen(&camera, None);
    let path = SunPath::Volume { voxel_m: 1.0 };
    let foggy = scene(LitDrops::new(vec![fog], sun, path).unwrap()).seen(&camera, None);
    let through = foggy[PictureLayer::Transmittance][[0, 0, 0]];
    assert!(
        (f64::from(through) / (-0.8_f64).exp() - 1.0).abs() < 1e-4,
        "{through}"
    );
    let (found, expected) = (
        foggy.radiance[[1, 0, 0]],
        through * open.radiance[[1, 0, 0]],
    );
    assert!(
        relative(f64::from(found), f64::from(expected)) < F32,
        "{found} {expected}"
    );
    assert_eq!(open[PictureLayer::Surface][[0, 0, 0]], 100.0);
}
