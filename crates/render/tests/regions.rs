//! A picture is the same however it is cut: every value of a pixel, to the last bit.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::ops::ControlFlow;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering;

use glam::DVec3;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::s;
use niji_exchange::AtmosphereTable;
use niji_geometry::Camera;
use niji_geometry::HeightField;
use niji_geometry::HeightMap;
use niji_geometry::PixelRegion;
use niji_radiometry::Reflectance;
use niji_render::Afforded;
use niji_render::Deadline;
use niji_render::DropOrders;
use niji_render::Error;
use niji_render::Integration;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::Progress;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;
use niji_render::render;
use niji_render::render_in_steps;
use niji_render::render_in_strips;
use niji_render::unwatched;

use common::air;
use common::bricks;
use common::camera;
use common::levels;
use common::rendered;
use common::request;
use common::sized_table;
use common::sun_in_the_south;
use common::with_shadow;

const WIDTH: usize = 23;
const HEIGHT: usize = 17;

/// Some pixels need more than one ray for it.
const TOLERANCE_CD_M2: f64 = 2e-5;

/// A cloud of drops, air, a wall to the right of it.
struct World {
    camera: Camera,
    drops: LitDrops,
    air: AtmosphereTable,
    surfaces: Surfaces,
}

impl World {
    fn new() -> Self {
        let grid = niji_dropfield::GridBox {
            min: DVec3::new(-40.0, -5.0, -90.0),
            max: DVec3::new(30.0, 35.0, -40.0),
            voxel_m: 2.5,
        };
        let bricks = bricks(&grid, |p| {
            0.01 * (1.0 + (0.2 * p.x).sin() * (0.3 * p.y).cos())
        });
        let path = SunPath::Volume { voxel_m: 2.5 };
        let size = (WIDTH as u32, HEIGHT as u32);
        Self {
            camera: camera(DVec3::new(0.0, 2.0, 0.0), (0.0, 20.0), 80.0, size),
            drops: LitDrops::new(vec![bricks], sun_in_the_south(12.0), path).unwrap(),
            air: air([1e-4, 2e-4, 3e-4], [1e-4, 1e-4, 2e-4]),
            surfaces: Surfaces::new(Array2::from_shape_fn((HEIGHT, WIDTH), |(_, x)| {
                if x > 15 { 60.0 } else { f32::INFINITY }
            }))
            .unwrap()
            .with(hills()),
        }
    }
}

/// Terrain with an albedo in front of the map, whose hills shade each other.
fn hills() -> Solid {
    let height_m =
        |index: usize| 2.0 * (0.7 * (index % 40) as f32).sin() * (index / 40) as f32 / 40.0;
    let field = HeightField::new(HeightMap {
        size: (40, 30),
        height_m: (0..1200).map(height_m).collect(),
        spacing_m: 2.0,
        corner: DVec3::new(-40.0, 0.5, -58.0),
    });
    Solid {
        shape: SolidShape::Heights(field.unwrap()),
        albedo: Some(Reflectance::of_rgb([0.3, 0.5, 0.1]).into()),
    }
}

/// One footprint and one integration after the other, everything else on.
fn with_each_request(world: &World, check: impl Fn(&RenderRequest)) {
    let table = sized_table(&[50.0, 200.0], |radius_um, wavelength, theta| {
        0.1 * (1.0 + (0.01 * radius_um * theta * (wavelength + 3) as f64).sin())
    });
    let of_world = request(&world.camera, sun_in_the_south(12.0), &world.drops, &table);
    let once = DropOrders::SingleScattering;
    let often = DropOrders::MultipleScattering {
        nodes_across: 2,
        paths_per_node: 32,
    };
    let exact = Integration::CellExact;
    let steps = Integration::FixedStep { step_m: 1.0 };
    for (pixel_footprint, integration, drop_orders, tolerance_cd_m2) in [
        (PixelFootprint::Center, exact, once, None),
        (PixelFootprint::Prefiltered, exact, once, None),
        (PixelFootprint::Grid { n: 2 }, steps, once, None),
        (PixelFootprint::Center, exact, once, Some(TOLERANCE_CD_M2)),
        (PixelFootprint::Center, exact, often, None),
    ] {
        let levels = RenderLevels {
            pixel_footprint,
            integration,
            drop_orders,
            ..levels()
        };
        check(&RenderRequest {
            levels,
            tolerance_cd_m2,
            effects: RenderEffects {
                sunlight_through_air: Toggle::On,
                air_extinction: Toggle::On,
                air_inscatter: Toggle::On,
                skylit_drops: Toggle::On,
                sky: Toggle::On,
                lit_surfaces: Toggle::On,
                ..with_shadow()
            },
            air: Some(&world.air),
            surfaces: Some(&world.surfaces),
            ..of_world
        });
    }
}

/// Every array of a picture as planes of bits by name.
fn planes(picture: &Rendered) -> Vec<(&'static str, Array3<u32>)> {
    let bits = |planes: &Array3<f32>| planes.mapv(f32::to_bits);
    let layers = picture.layers();
    let layers = layers.map(|(layer, planes)| (layer.name(), bits(planes)));
    std::iter::once(("radiance", bits(&picture.radiance)))
        .chain(layers)
        .collect()
}

/// Is `part` cut out of `whole`, whose top left pixel is `corner`?
fn assert_cut_out(whole: &Rendered, corner: (i32, i32), part: &Rendered, region: PixelRegion) {
    let (x, y) = (
        (region.x_px - corner.0) as usize,
        (region.y_px - corner.1) as usize,
    );
    let (width, height) = (region.width_px as usize, region.height_px as usize);
    for ((name, whole), (_, part)) in planes(whole).into_iter().zip(planes(part)) {
        let cut = whole.slice(s![.., y..y + height, x..x + width]);
        assert!(cut == part, "{name} of the region {region}");
    }
}

fn region(x_px: i32, y_px: i32, width_px: u32, height_px: u32) -> PixelRegion {
    PixelRegion {
        x_px,
        y_px,
        width_px,
        height_px,
    }
}

#[test]
fn any_region_has_the_bits_of_the_whole_picture() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let picture = rendered(whole);
        assert!(
            picture
                .error_from("Y")
                .unwrap()
                .iter()
                .any(|error| *error > 0.0)
        );
        if whole.tolerance_cd_m2.is_some() {
            let unrefined = rendered(&RenderRequest {
                tolerance_cd_m2: None,
                ..*whole
            });
            assert!(
                unrefined.radiance != picture.radiance,
                "nothing was refined"
            );
        }
        let mut cuts = whole.region.bands(5).unwrap();
        cuts.extend([
            region(0, 0, 1, 1),
            region(WIDTH as i32 - 1, HEIGHT as i32 - 1, 1, 1),
            region(7, 0, 1, HEIGHT as u32),
            region(3, 5, 11, 4),
        ]);
        for region in cuts {
            let part = rendered(&RenderRequest { region, ..*whole });
            assert_cut_out(&picture, (0, 0), &part, region);
        }
        let middle = region(0, 4, WIDTH as u32, 9);
        assert_cut_out(&picture, (0, 0), &picture.rows(4..13), middle);
    });
}

/// A picture in so much time on a clock that goes on by a second whenever somebody looks at it.
fn in_time(request: &RenderRequest, seconds: f64) -> (Rendered, Afforded) {
    let looks = AtomicU32::new(0);
    let deadline = Deadline {
        now_s: &|| f64::from(looks.fetch_add(1, Ordering::Relaxed)),
        end_s: seconds,
    };
    let (picture, spent) = render_in_steps(request, (&unwatched, deadline), 1).unwrap();
    assert!(spent.more_rays.change > 0.0 || spent.afforded.coarser_rays > 1.0);
    (picture, spent.afforded)
}

#[test]
fn what_there_was_time_for_is_the_same_picture_without_a_clock() {
    let world = World::new();
    with_each_request(&world, |request| {
        let (Some(_), PixelFootprint::Center) =
            (request.tolerance_cd_m2, request.levels.pixel_footprint)
        else {
            return;
        };
        let of_paths = |paths_per_node, orders_error_cd_m2| {
            let mut request = *request;
            request.levels.drop_orders = DropOrders::MultipleScattering {
                nodes_across: 2,
                paths_per_node,
            };
            request.orders_error_cd_m2 = orders_error_cd_m2;
            request
        };
        let of_level = 2048;
        // Sixteen times as many paths, and as small an error of a pixel.
        let most = 16 * of_level;
        let all = rendered(&RenderRequest {
            coarser_rays: 1.0 / 16.0,
            ..of_paths(most, None)
        });
        let mut coarser = Vec::new();
        for seconds in [-1.0, 24.0, 1e6] {
            let (picture, afforded) = in_time(&of_paths(of_level, Some(0.0)), seconds);
            let again = rendered(&RenderRequest {
                coarser_rays: afforded.coarser_rays,
                ..of_paths(afforded.paths_per_node.unwrap(), None)
            });
            assert!(planes(&picture) == planes(&again), "{afforded:?}");
            let is_all = planes(&picture) == planes(&all);
            assert_eq!(is_all, seconds > 1e5, "{afforded:?}");
            coarser.push(afforded);
        }
        assert!(
            coarser[0].coarser_rays > coarser[1].coarser_rays,
            "{coarser:?}"
        );
        assert!(
            coarser[1].coarser_rays > coarser[2].coarser_rays,
            "{coarser:?}"
        );
        assert_eq!(coarser[0].paths_per_node, Some(512), "the first round");
        assert_eq!(
            coarser[2],
            Afforded {
                coarser_rays: 1.0 / 16.0,
                paths_per_node: Some(most)
            }
        );
    });
}

#[test]
fn overscan_adds_pixels_and_changes_none() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let overscan = rendered(&RenderRequest {
            region: whole.region.grown(3).unwrap(),
            ..*whole
        });
        assert_eq!(
            overscan.error_from("Y").unwrap().dim(),
            (HEIGHT + 6, WIDTH + 6)
        );
        assert_cut_out(&overscan, (-3, -3), &rendered(whole), whole.region);
        // Beyond the left edge lies more of the same cloud.
        assert!(
            overscan[PictureLayer::BowPrimary]
                .slice(s![.., .., ..3])
                .sum()
                > 0.0
        );
    });
}

#[test]
fn threads_do_not_change_a_bit_of_a_region() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let request = RenderRequest {
            region: region(2, -1, 19, 12),
            ..*whole
        };
        let picture = |n_threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads);
            pool.build().unwrap().install(|| rendered(&request))
        };
        let one = picture(1);
        for n_threads in [2, 7] {
            assert!(picture(n_threads) == one, "{n_threads} threads");
        }
    });
}

#[test]
fn a_region_needs_the_table_for_its_own_pixels_only() {
    let world = World::new();
    let mut table = sized_table(&[50.0, 200.0], |_, _, _| 0.1);
    // The left edge of the frame sees angles below these, the middle does not.
    let first = table
        .theta_rad
        .partition_point(|theta| theta.to_degrees() < 140.0);
    table.theta_rad.drain(..first);
    let values = table.values.slice(s![.., .., .., .., first..]);
    table.values = values.to_owned();
    let whole = request(&world.camera, sun_in_the_south(12.0), &world.drops, &table);
    let refusal = render(&whole, &|_| ()).unwrap_err();
    assert!(matches!(refusal, Error::AngleRange { .. }), "{refusal}");
    let middle = RenderRequest {
        region: region(11, 8, 2, 2),
        ..whole
    };
    rendered(&middle);
}

#[test]
fn a_region_without_pixels_is_refused() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let nothing = RenderRequest {
            region: region(0, 0, 0, 5),
            ..*whole
        };
        assert!(matches!(render(&nothing, &|_| ()), Err(Error::Region(_))));
    });
}

#[test]
fn a_picture_larger_than_any_memory_is_refused_before_a_ray_is_followed() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let side_px = 1 << 24;
        let huge = RenderRequest {
            region: region(0, 0, side_px, side_px),
            ..*whole
        };
        let Err(Error::Memory { size_px, bytes, .. }) = render(&huge, &|_| ()) else {
            panic!("expected a refusal");
        };
        assert_eq!(size_px, (side_px, side_px));
        // Layers beside the spectrum, 4 bytes a pixel each.
        let n_layers = whole.wavelengths.len() as u64 + 20;
        assert!(bytes >= 4 * n_layers * u64::from(side_px) * u64::from(side_px));
    });
}

#[test]
fn strips_do_not_change_a_bit_and_follow_on_each_other() {
    let world = World::new();
    with_each_request(&world, |whole| {
        let picture = rendered(whole);
        for n_rows in [0, 1, 2, 5, 16, 17, HEIGHT as u32] {
            let mut next = 0;
            let mut check = |strip: PixelRegion, rows: Rendered| {
                let first = strip.y_px.abs_diff(whole.region.y_px) as usize;
                assert_eq!((first, strip.x_px), (next, whole.region.x_px));
                next += strip.height_px as usize;
                assert!(rows == picture.rows(first..next), "{n_rows}, {strip}");
                ControlFlow::Continue(())
            };
            let watch = (&unwatched as Progress, Deadline::NEVER);
            render_in_strips(whole, watch, n_rows, &mut check).unwrap();
            assert_eq!(next, HEIGHT, "{n_rows}");
            let (stepped, _) = render_in_steps(whole, watch, n_rows).unwrap();
            assert!(stepped == picture, "steps of {n_rows} rows");
        }
        let watch = (&unwatched as Progress, Deadline::NEVER);
        let mut n_taken = 0;
        let stopped = render_in_strips(whole, watch, 5, &mut |_, _| {
            n_taken += 1;
            ControlFlow::Break(())
        });
        assert_eq!((stopped, n_taken), (Err(Error::Stopped), 1));
    });
}
