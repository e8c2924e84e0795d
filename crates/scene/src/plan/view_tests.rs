use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::Lens;
use niji_geometry::PanoramaCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::Ray;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::Radians;

use super::*;

const WIDTH: u32 = 90;
const HEIGHT: u32 = 70;

fn camera(position: DVec3, azimuth_deg: f64, elevation_deg: f64) -> Camera {
    let camera = PinholeCamera::new(PinholeRequest {
        position,
        azimuth: Radians::from_degrees(azimuth_deg),
        elevation: Radians::from_degrees(elevation_deg),
        roll: Radians::from_degrees(13.0),
        horizontal_fov: Radians::from_degrees(100.0),
        width_px: WIDTH,
        height_px: HEIGHT,
    });
    camera.unwrap().into()
}

/// The same eye behind a pinhole, two fisheyes and a panorama.
fn cameras(position: DVec3, azimuth_deg: f64, elevation_deg: f64) -> [Camera; 4] {
    let pinhole = camera(position, azimuth_deg, elevation_deg);
    let fisheye = |mapping, fov_deg| {
        let camera = FisheyeCamera::new(FisheyeRequest {
            pose: *pinhole.pose(),
            mapping,
            lens: Lens::HorizontalFov(Radians::from_degrees(fov_deg)),
            image_circle: None,
            width_px: WIDTH,
            height_px: HEIGHT,
        });
        Camera::from(camera.unwrap())
    };
    let panorama = PanoramaCamera::new(*pinhole.pose(), [2 * HEIGHT, HEIGHT]).unwrap();
    [
        pinhole,
        fisheye(FisheyeMapping::Equidistant, 190.0),
        fisheye(FisheyeMapping::Equisolid, 360.0),
        panorama.into(),
    ]
}

fn extent(whole: &Aabb) -> Extent<'static> {
    Extent {
        whole: *whole,
        extinction_m1: 1.0,
        parts: &[],
    }
}

/// The block that holds a pixel.
fn block_of(blocks: &[Block], x: u32, y: u32) -> &Block {
    let find = |p: u32, size: u32, n: u32| {
        (0..n)
            .find(|i| u64::from(p) < u64::from(i + 1) * u64::from(size) / u64::from(n))
            .unwrap()
    };
    let row = find(y, HEIGHT, MAX_BLOCKS.1) * MAX_BLOCKS.0;
    &blocks[(row + find(x, WIDTH, MAX_BLOCKS.0)) as usize]
}

#[test]
fn bounds_hold_for_every_ray_of_every_pixel() {
    let bounds = Aabb {
        min: DVec3::new(-60.0, -5.0, -90.0),
        max: DVec3::new(30.0, 40.0, -20.0),
    };
    let sun = direction_from_azimuth_elevation(Radians(3.0), Radians(0.4));
    for (position, azimuth_deg, elevation_deg) in [
        (DVec3::new(0.0, 1.6, 0.0), 0.0, 10.0),
        (DVec3::new(0.0, 1.6, -50.0), 70.0, -20.0),
        (DVec3::new(50.0, 80.0, -100.0), 230.0, -40.0),
        (DVec3::new(0.0, 1.6, 0.0), 180.0, 80.0),
    ] {
        for camera in cameras(position, azimuth_deg, elevation_deg) {
            for (rectangle, block) in placed_blocks(&camera, sun, &extent(&bounds)) {
                for ray in rays_of(&camera, &rectangle) {
                    let block = block.as_ref().expect("a block with a ray is there");
                    check_ray(&ray, block, (sun, &bounds));
                }
            }
        }
    }
}

#[test]
fn blocks_share_the_picture() {
    let eye = DVec3::new(0.0, 1.6, 0.0);
    let far = Aabb {
        min: DVec3::splat(1e3),
        max: DVec3::splat(2e3),
    };
    let share = |camera: &Camera| -> f64 {
        let blocks = blocks(camera, DVec3::Y, &extent(&far));
        blocks.iter().map(|block| block.share).sum()
    };
    let [pinhole, round, _, panorama] = cameras(eye, 0.0, 10.0);
    assert!((share(&pinhole) - 1.0).abs() < 1e-12);
    assert!((share(&panorama) - 1.0).abs() < 1e-12);
    // The corners of a fisheye's picture are black.
    assert!((0.9..0.99).contains(&share(&round)), "{}", share(&round));
}

/// Blocks with their places, those without rays too.
fn placed_blocks(
    camera: &Camera,
    sun: DVec3,
    drops: &Extent<'_>,
) -> Vec<(Rectangle, Option<Block>)> {
    let place = |rectangle: Rectangle| {
        let rays = rectangle.rays(camera);
        let block = rays.map(|rays| rays.block(camera.position(), sun, drops));
        (rectangle, block)
    };
    let rectangles = rectangles(frame(camera), most_blocks(camera)).into_iter();
    rectangles.map(place).collect()
}

fn frame(camera: &Camera) -> PixelRegion {
    PixelRegion::frame(camera.width_px(), camera.height_px())
}

fn blocks(camera: &Camera, sun: DVec3, drops: &Extent<'_>) -> Vec<Block> {
    super::blocks(camera, frame(camera), sun, drops)
}

fn rays_of(camera: &Camera, rectangle: &Rectangle) -> Vec<Ray> {
    let ((x0, x1), (y0, y1)) = (rectangle.x_px, rectangle.y_px);
    let shares = [0.0, 0.21, 0.5, 0.83, 1.0];
    let places = shares.map(|v| shares.map(|u| (x0 + u * (x1 - x0), y0 + v * (y1 - y0))));
    let rays = places.iter().flatten();
    rays.filter_map(|(x, y)| camera.ray(*x, *y)).collect()
}

fn check_ray(ray: &Ray, block: &Block, (sun, bounds): (DVec3, &Aabb)) {
    let theta = angle_rad(ray.direction, sun);
    let slack = 1e-7;
    assert!(theta >= block.theta_rad.0 - slack && theta <= block.theta_rad.1 + slack);
    let rise = rise(ray.direction, sun);
    assert!(rise >= block.rise.0 - slack && rise <= block.rise.1 + slack);
    if let Some((enter, leave)) = bounds.intersect(ray) {
        let chord = block.drops.expect("a ray of the block meets the box");
        assert!(enter >= chord.enter_m - slack && leave <= chord.leave_m + slack);
        assert!(leave - enter <= chord.length_m + slack);
    }
}

#[test]
fn bounds_are_tight_in_the_middle_of_a_distant_box() {
    let bounds = Aabb {
        min: DVec3::new(-90.0, -90.0, -120.0),
        max: DVec3::new(90.0, 90.0, -100.0),
    };
    let camera = camera(DVec3::ZERO, 0.0, 0.0);
    let blocks = blocks(&camera, DVec3::Y, &extent(&bounds));
    let chord = block_of(&blocks, WIDTH / 2, HEIGHT / 2).drops.unwrap();
    assert!(chord.length_m < 1.05 * 20.0, "{chord:?}");
    assert!(chord.enter_m > 99.9 && chord.leave_m < 121.0, "{chord:?}");
}

#[test]
fn overscan_widens_the_angles_that_are_seen_to_those_of_a_larger_picture() {
    let far = Aabb {
        min: DVec3::splat(1e3),
        max: DVec3::splat(2e3),
    };
    let sun = DVec3::new(0.0, 0.6, 0.8);
    let range = |blocks: &[Block]| {
        let low = blocks.iter().map(|block| block.theta_rad.0);
        let high = blocks.iter().map(|block| block.theta_rad.1);
        (low.fold(PI, f64::min), high.fold(0.0, f64::max))
    };
    let camera = camera(DVec3::ZERO, 0.0, 0.0);
    let region = frame(&camera).grown(WIDTH / 4).unwrap();
    let seen = super::blocks(&camera, region, sun, &extent(&far));
    assert!((seen.iter().map(|block| block.share).sum::<f64>() - 1.0).abs() < 1e-12);
    let (low, high) = range(&seen);
    let edge = |x, y| angle_rad(camera.ray(x, y).unwrap().direction, sun);
    let corner = edge(region.x_px.into(), region.y_px.into());
    assert!(low <= corner && corner <= high);
    let (frame_low, _) = range(&blocks(&camera, sun, &extent(&far)));
    assert!(low < frame_low, "{low} {frame_low}");
}

#[test]
fn a_camera_that_looks_away_sees_no_drops() {
    let bounds = Aabb {
        min: DVec3::new(-9.0, 0.0, -30.0),
        max: DVec3::new(9.0, 9.0, -20.0),
    };
    let blocks = blocks(&camera(DVec3::ZERO, 180.0, 0.0), DVec3::Y, &extent(&bounds));
    assert!(blocks.iter().all(|block| block.drops.is_none()));
}

#[test]
fn optical_depth_is_bounded_by_the_parts_that_a_ray_crosses() {
    let part = |x: f64| Aabb {
        min: DVec3::new(x, -9.0, -30.0),
        max: DVec3::new(x + 4.0, 9.0, -20.0),
    };
    let whole = Aabb {
        min: part(-20.0).min,
        max: part(16.0).max,
    };
    let parts = [(part(-20.0), 0.3), (part(16.0), 0.1)];
    let parts = parts.map(|(bounds, max_extinction_m1_q1)| DropPart {
        bounds,
        max_extinction_m1_q1,
        mode: 0,
        within: Vec::new(),
    });
    let camera = camera(DVec3::ZERO, 0.0, 0.0);
    let drops = Extent {
        whole,
        extinction_m1: 0.3,
        parts: &parts,
    };
    for block in blocks(&camera, DVec3::Y, &drops) {
        assert!(block.depth <= 0.3 * block.drops.map_or(0.0, |chord| chord.length_m));
    }
    let drops = blocks(&camera, DVec3::Y, &drops);
    let middle = block_of(&drops, WIDTH / 2, HEIGHT / 2);
    assert!(middle.drops.is_some() && middle.depth < 1e-12, "{middle:?}");
    assert!(drops.iter().any(|block| block.depth > 1.0));
}

#[test]
fn shadows_are_bounded_on_all_ground_that_a_ray_meets() {
    let bounds = Aabb {
        min: DVec3::new(-600.0, 0.0, -900.0),
        max: DVec3::new(300.0, 400.0, -200.0),
    };
    let extinction_m1 = 1e-3;
    let parts = [DropPart {
        bounds,
        max_extinction_m1_q1: extinction_m1,
        mode: 0,
        within: Vec::new(),
    }];
    let drops = Extent {
        whole: bounds,
        extinction_m1,
        parts: &parts,
    };
    let sun = direction_from_azimuth_elevation(Radians(3.0), Radians(0.4));
    let (mut n_shaded, mut n_without) = (0, 0);
    for (position, elevation_deg) in [
        (DVec3::new(0.0, 1.6, 0.0), 5.0),
        (DVec3::new(50.0, 800.0, 300.0), -40.0),
    ] {
        for camera in cameras(position, 20.0, elevation_deg) {
            for (rectangle, block) in placed_blocks(&camera, sun, &drops) {
                for ray in rays_of(&camera, &rectangle) {
                    let block = block.as_ref().unwrap();
                    let cos_zenith = EARTH.cos_zenith(ray.origin, ray.direction);
                    let height_m = EARTH.height_m(ray.origin);
                    let Some(ground_m) = EARTH.distance_to_ground(height_m, cos_zenith) else {
                        n_without += usize::from(block.ground_sun_depth.is_none());
                        continue;
                    };
                    let origin = ray.at(ground_m);
                    let towards_sun = Ray {
                        origin,
                        direction: sun,
                    };
                    let way_m = bounds.intersect(&towards_sun);
                    let depth = way_m.map_or(0.0, |(enter, leave)| extinction_m1 * (leave - enter));
                    let most = block.ground_sun_depth.expect("the ray meets the ground");
                    assert!(depth <= most + 1e-9, "{depth} {most}");
                    n_shaded += usize::from(depth > 0.1);
                }
            }
        }
    }
    assert!(
        n_shaded > 1000 && n_without > 1000,
        "{n_shaded} {n_without}"
    );
    // A set sun shades nothing, and from below the ground none is seen.
    let under = camera(DVec3::new(0.0, -9.0, 0.0), 0.0, -40.0);
    let over = camera(DVec3::new(0.0, 800.0, 0.0), 0.0, -40.0);
    for (camera, sun) in [(under, sun), (over, sun.with_y(-0.1))] {
        let mut blocks = blocks(&camera, sun, &drops).into_iter();
        assert!(blocks.all(|block| block.ground_sun_depth.is_none()));
    }
}

#[test]
fn the_longest_chord_of_a_cube_is_its_diagonal() {
    let cube = Aabb {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    };
    let diagonal = longest_chord_m(&cube, DVec3::ONE.normalize());
    assert!((diagonal - 3.0_f64.sqrt()).abs() < 1e-15);
    assert!((longest_chord_m(&cube, DVec3::Y) - 1.0).abs() < 1e-15);
}
