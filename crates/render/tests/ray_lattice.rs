//! Pixels between the rays of a lattice are those that rays of their own have, to within a part of the tolerance.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::ArrayView2;
use ndarray::Axis;
use ndarray::s;
use niji_dropfield::GridBox;
use niji_exchange::AtmosphereTable;
use niji_geometry::Camera;
use niji_geometry::HeightField;
use niji_geometry::HeightMap;
use niji_geometry::MeshBvh;
use niji_geometry::PixelRegion;
use niji_geometry::TriangleMesh;
use niji_radiometry::Colorimetry;
use niji_radiometry::Reflectance;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;
use niji_render::WaterSurface;

const SIZE: (u32, u32) = (96, 64);

/// Pixels whose spectrum is not that of the ray through them.
fn n_changed(picture: &Rendered, rays: &Rendered) -> usize {
    let changed = |(a, b): (&Array3<f32>, &Array3<f32>)| {
        let pixels = a.lanes(Axis(0)).into_iter().zip(b.lanes(Axis(0)));
        pixels.filter(|(a, b)| a != b).count()
    };
    changed((&picture.radiance, &rays.radiance))
}

fn luminance(picture: &Rendered) -> Array2<f64> {
    let weights = Colorimetry::new(&wavelengths());
    picture.radiance.map_axis(Axis(0), |spectrum| {
        let spectrum: Vec<f64> = spectrum.iter().map(|it| f64::from(*it)).collect();
        weights.xyz(&spectrum)[1]
    })
}

/// A shower 100 m away, in air and with hills beneath if wanted.
struct World {
    camera: Camera,
    drops: LitDrops,
    /// None where rays of pictures with a tolerance are to be those of pictures without: these have more nodes in the air.
    air: Option<AtmosphereTable>,
    surfaces: Option<Surfaces>,
    water: Option<WaterSurface>,
    /// Whether surfaces and ground have shadows.
    is_shaded: bool,
}

impl World {
    /// Seen `fov_deg` wide; extinction by point [1/m].
    fn of(fov_deg: f64, extinction_m1: impl Fn(DVec3) -> f64 + Sync) -> Self {
        let grid = GridBox {
            min: DVec3::new(-20.0, 20.0, -120.0),
            max: DVec3::new(20.0, 50.0, -100.0),
            voxel_m: 1.0,
        };
        let sun = sun_in_the_south(12.0);
        let path = SunPath::Volume { voxel_m: 1.0 };
        Self {
            camera: camera(DVec3::new(0.0, 2.0, 0.0), (0.0, 16.0), fov_deg, SIZE),
            drops: LitDrops::new(vec![bricks(&grid, extinction_m1)], sun, path).unwrap(),
            air: None,
            surfaces: None,
            water: None,
            is_shaded: false,
        }
    }

    /// Pictures with a tolerance and without, which follows a ray for each pixel.
    fn pictures(&self, tolerance_cd_m2: f64) -> [Rendered; 2] {
        let mut pictures = Vec::new();
        self.with_request(|request| {
            for tolerance_cd_m2 in [Some(tolerance_cd_m2), None] {
                pictures.push(rendered(&RenderRequest {
                    tolerance_cd_m2,
                    // No pixel gets more rays.
                    coarser_rays: 1e9,
                    ..*request
                }));
            }
        });
        pictures.try_into().unwrap()
    }

    fn with_request(&self, mut use_it: impl FnMut(&RenderRequest)) {
        let table = sized_table(&[50.0, 200.0], |radius_um, wavelength, theta| {
            0.1 * (1.0 + (0.004 * radius_um * theta * (wavelength + 3) as f64).sin())
        });
        use_it(&RenderRequest {
            levels: RenderLevels {
                pixel_footprint: PixelFootprint::Prefiltered,
                ..levels()
            },
            effects: RenderEffects {
                sunlight_through_air: on(self.air.is_some()),
                air_extinction: on(self.air.is_some()),
                air_inscatter: on(self.air.is_some()),
                skylit_drops: on(self.air.is_some()),
                sky: on(self.air.is_some()),
                lit_surfaces: on(self.is_shaded),
                ..with_shadow()
            },
            air: self.air.as_ref(),
            surfaces: self.surfaces.as_ref(),
            water: self.water,
            ..request(&self.camera, sun_in_the_south(12.0), &self.drops, &table)
        });
    }
}

fn on(is_on: bool) -> Toggle {
    if is_on { Toggle::On } else { Toggle::Off }
}

fn eddies(p: DVec3) -> f64 {
    0.01 * (1.0 + (0.2 * p.x).sin() * (0.3 * p.y).cos())
}

/// It lets the sun through, which has 100 km of it to cross.
fn thin_air() -> AtmosphereTable {
    air([1e-6, 2e-6, 3e-6], [1e-6, 1e-6, 2e-6])
}

/// Largest luminance.
fn brightest(light: &ArrayView2<f64>) -> f64 {
    light.iter().copied().fold(0.0, f64::max)
}

/// Largest change, either way.
fn largest(change: &Array2<f64>) -> f64 {
    change.iter().fold(0.0, |a, b| a.max(b.abs()))
}

/// Assert that more than a part of a picture are sums, within a quarter of its tolerance of the rays; how these differ.
#[track_caller]
fn assert_held(
    [picture, rays]: [&Rendered; 2],
    (tolerance_cd_m2, least): (f64, f64),
) -> Array2<f64> {
    let part = n_changed(picture, rays) as f64 / f64::from(SIZE.0 * SIZE.1);
    assert!(part > least, "{part} are sums");
    let change = luminance(picture) - luminance(rays);
    let of_tolerance = largest(&change) / tolerance_cd_m2;
    assert!(of_tolerance <= 0.25, "{of_tolerance} of the tolerance");
    change
}

#[test]
fn pixels_of_smooth_light_follow_from_others_within_a_quarter_of_the_tolerance() {
    let world = World::of(8.0, eddies);
    let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
    for (relative, least) in [(1e-2, 0.5), (1e-3, 0.1)] {
        let tolerance_cd_m2 = relative * brightest;
        let [picture, rays] = world.pictures(tolerance_cd_m2);
        let change = assert_held([&picture, &rays], (tolerance_cd_m2, least));
        let errors = picture.error_from("quadrature").unwrap();
        let untold = change
            .indexed_iter()
            .filter(|(place, change)| change.abs() > f64::from(errors[*place]) + 1e-6 * brightest);
        assert!(
            untold.count() < (SIZE.0 * SIZE.1) as usize / 100,
            "{relative}"
        );
    }
}

#[test]
fn a_finer_tolerance_asks_for_more_rays() {
    let world = World::of(8.0, eddies);
    let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
    let n = [1e-2, 1e-4].map(|relative| {
        let [picture, rays] = world.pictures(relative * brightest);
        let change = luminance(&picture) - luminance(&rays);
        change.iter().map(|it| it * it).sum::<f64>()
    });
    assert!(n[1] < 0.1 * n[0], "{n:?}");
}

/// A strand of a single voxel's width stands between the nodes wherever it is.
#[test]
fn nothing_as_thin_as_a_voxel_is_passed_over() {
    for column in 0..6 {
        let x_m = -2.5 + f64::from(column);
        let strand = move |p: DVec3| if (p.x - x_m).abs() < 0.6 { 0.2 } else { 1e-4 };
        let world = World::of(30.0, strand);
        let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
        let [picture, rays] = world.pictures(1e-2 * brightest);
        let largest = largest(&(luminance(&picture) - luminance(&rays)));
        assert!(
            largest <= 2e-3 * brightest,
            "strand at {x_m}: {}",
            largest / brightest
        );
    }
}

/// Voxels of a twentieth of those of the shower, which look finer than pixels from as far away.
#[test]
fn fine_drops_in_front_ask_for_no_more_rays_of_coarse_ones_behind() {
    for strand_m in [-0.26, -0.1, 0.24] {
        let mut world = World::of(8.0, eddies);
        let mist = GridBox {
            min: DVec3::new(-0.3, 4.6, -10.2),
            max: DVec3::new(0.3, 5.1, -10.0),
            voxel_m: 0.05,
        };
        let strand = |p: DVec3| {
            if (p.x - strand_m).abs() < 0.03 {
                2.0
            } else {
                1e-3
            }
        };
        let mut drops = world.drops.bricks().to_vec();
        drops.push(bricks(&mist, strand));
        let path = SunPath::Volume { voxel_m: 1.0 };
        world.drops = LitDrops::new(drops, sun_in_the_south(12.0), path).unwrap();
        let tolerance_cd_m2 = 1e-2 * brightest(&luminance(&world.pictures(1e9)[1]).view());
        let [picture, rays] = world.pictures(tolerance_cd_m2);
        assert_held([&picture, &rays], (tolerance_cd_m2, 0.4));
    }
}

#[test]
fn pixels_of_hills_and_at_their_edge_have_their_own_rays() {
    let height_m = |index: usize| 9.0 + 3.0 * (0.7 * (index % 40) as f32).sin();
    let hills = HeightField::new(HeightMap {
        size: (40, 30),
        height_m: (0..1200).map(height_m).collect(),
        spacing_m: 2.0,
        corner: DVec3::new(-40.0, 0.5, -98.0),
    });
    let world = World {
        surfaces: Some(Surfaces::default().with(Solid {
            shape: SolidShape::Heights(hills.unwrap()),
            albedo: Some(Reflectance::of_rgb([0.3, 0.5, 0.1]).into()),
        })),
        is_shaded: true,
        ..World::of(20.0, eddies)
    };
    let [picture, rays] = world.pictures(1e3);
    assert!(n_changed(&picture, &rays) > 100, "none is a sum");
    let surface_m = &picture[niji_render::PictureLayer::Surface];
    assert_eq!(*surface_m, rays[niji_render::PictureLayer::Surface]);
    let (mut n_hills, size) = (0, (SIZE.1 as usize, SIZE.0 as usize));
    for y in 1..size.0 - 1 {
        for x in 1..size.1 - 1 {
            let around = surface_m.slice(s![0, y - 1..y + 2, x - 1..x + 2]);
            if around.iter().any(|it| it.is_finite()) {
                n_hills += 1;
                let [a, b] = [&picture, &rays].map(|it| it.radiance.slice(s![.., y, x]).to_owned());
                assert_eq!(a, b, "({x}, {y})");
            }
        }
    }
    assert!(n_hills > 300);
}

/// Over the shadow of drops, which lies 100 to 250 m north of them.
#[test]
fn the_shadow_of_drops_on_the_ground_is_held_to_the_same() {
    let over = |is_shaded| World {
        camera: camera(DVec3::new(0.0, 300.0, -100.0), (0.0, -60.0), 3.0, SIZE),
        air: Some(thin_air()),
        is_shaded,
        ..World::of(8.0, eddies)
    };
    let world = over(true);
    let [lit, dark] = [false, true].map(|is_shaded| luminance(&over(is_shaded).pictures(1e9)[1]));
    let brightest = brightest(&lit.view());
    let shadow = (&lit - &dark).iter().fold(0.0_f64, |a, b| a.max(*b));
    assert!(shadow > 0.02 * brightest, "{}", shadow / brightest);
    let tolerance_cd_m2 = 0.3 * shadow;
    let [picture, rays] = world.pictures(tolerance_cd_m2);
    let mut layers = picture.layers().map(|(layer, _)| layer);
    assert!(
        layers.all(|it| it != niji_render::PictureLayer::LitSurface),
        "no surface is lit"
    );
    assert_held([&picture, &rays], (tolerance_cd_m2, 0.3));
}

/// Over water, towards the shower and towards the sun.
#[test]
fn water_is_held_to_the_same() {
    for (slope, azimuth_deg) in [(0.0, 0.0), (0.1, 0.0), (0.03, 180.0), (0.2, 180.0)] {
        let world = World {
            camera: camera(DVec3::new(0.0, 12.0, 0.0), (azimuth_deg, -10.0), 8.0, SIZE),
            air: Some(thin_air()),
            water: Some(endless(slope)),
            ..World::of(8.0, eddies)
        };
        let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
        let tolerance_cd_m2 = 1e-2 * brightest;
        let [picture, rays] = world.pictures(tolerance_cd_m2);
        assert_held([&picture, &rays], (tolerance_cd_m2, 0.5));
    }
}

/// A pole, which stands in water and in the middle between nodes.
#[test]
fn what_still_water_mirrors_is_passed_over_no_more_than_what_is_seen() {
    let pole = |left_m: f64| {
        let corners = [
            DVec3::new(left_m, -1.0, -60.0),
            DVec3::new(left_m + 0.15, -1.0, -60.0),
            DVec3::new(left_m + 0.15, 9.0, -60.0),
            DVec3::new(left_m, 9.0, -60.0),
        ];
        let mesh = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        Surfaces::default().with(Solid {
            shape: SolidShape::Mesh(MeshBvh::new(mesh)),
            albedo: None,
        })
    };
    for step in 0..5 {
        let world = World {
            camera: camera(DVec3::new(0.0, 12.0, 0.0), (0.0, -14.0), 12.0, SIZE),
            air: Some(thin_air()),
            water: Some(endless(0.0)),
            surfaces: Some(pole(0.13 * f64::from(step))),
            ..World::of(12.0, eddies)
        };
        let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
        let [picture, rays] = world.pictures(1e-2 * brightest);
        assert!(n_changed(&picture, &rays) > 1000, "none is a sum");
        let largest = largest(&(luminance(&picture) - luminance(&rays)));
        assert!(
            largest <= 2.5e-3 * brightest,
            "{step}: {}",
            largest / brightest
        );
    }
}

#[test]
fn any_region_has_the_bits_of_the_whole_picture() {
    let world = World {
        air: Some(thin_air()),
        ..World::of(8.0, eddies)
    };
    let brightest = brightest(&luminance(&world.pictures(1e9)[1]).view());
    world.with_request(|request| {
        let request = RenderRequest {
            tolerance_cd_m2: Some(3e-3 * brightest),
            ..*request
        };
        let whole = rendered(&request);
        for (x_px, y_px, width_px, height_px) in [
            (0, 0, 1, 1),
            (95, 63, 1, 1),
            (37, 11, 23, 31),
            (0, 33, 96, 5),
            (50, 0, 1, 64),
        ] {
            let region = PixelRegion {
                x_px,
                y_px,
                width_px,
                height_px,
            };
            let part = rendered(&RenderRequest { region, ..request });
            let (x, y) = (x_px as usize, y_px as usize);
            let place = s![.., y..y + height_px as usize, x..x + width_px as usize];
            assert!(whole.radiance.slice(place) == part.radiance, "{region}");
            for (layer, values) in part.layers() {
                assert!(
                    whole[layer].slice(place) == values,
                    "{} of {region}",
                    layer.name()
                );
            }
        }
    });
}
