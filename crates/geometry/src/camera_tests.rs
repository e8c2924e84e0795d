use std::f64::consts::PI;
use std::f64::consts::TAU;

use super::*;
use crate::fisheye::FisheyeMapping;
use crate::fisheye::FisheyeRequest;
use crate::lens::FocalLength;
use crate::lens::Lens;
use crate::pinhole::PinholeRequest;

/// Angles found again through a picture; measured 4.4e-16 away from a fisheye's rim.
const ANGLE_TOLERANCE: f64 = 4e-15;

fn pose() -> CameraPose {
    let angles = [200.0, -35.0, 17.0].map(Radians::from_degrees);
    CameraPose::looking(DVec3::new(1.0, 2.0, 3.0), angles).unwrap()
}

fn level() -> CameraPose {
    CameraPose::looking(DVec3::ZERO, [Radians(0.0); 3]).unwrap()
}

fn fisheye(pose: CameraPose, mapping: FisheyeMapping, fov_deg: f64, side_px: u32) -> FisheyeCamera {
    FisheyeCamera::new(FisheyeRequest {
        pose,
        mapping,
        lens: Lens::HorizontalFov(Radians::from_degrees(fov_deg)),
        image_circle: None,
        width_px: side_px,
        height_px: side_px,
    })
    .unwrap()
}

fn pinhole() -> PinholeCamera {
    PinholeCamera::new(PinholeRequest {
        position: DVec3::new(1.0, 2.0, 3.0),
        azimuth: Radians::from_degrees(200.0),
        elevation: Radians::from_degrees(-35.0),
        roll: Radians::from_degrees(17.0),
        horizontal_fov: Radians::from_degrees(60.0),
        width_px: 64,
        height_px: 32,
    })
    .unwrap()
}

fn all() -> [Camera; 6] {
    let round = |mapping, fov_deg| Camera::from(fisheye(pose(), mapping, fov_deg, 64));
    [
        pinhole().into(),
        round(FisheyeMapping::Equidistant, 180.0),
        round(FisheyeMapping::Equidistant, 360.0),
        round(FisheyeMapping::Equisolid, 180.0),
        round(FisheyeMapping::Equisolid, 360.0),
        PanoramaCamera::new(pose(), [64, 32]).unwrap().into(),
    ]
}

fn pixel_centers(camera: &Camera) -> impl Iterator<Item = (f64, f64)> {
    let (width, height) = (camera.width_px(), camera.height_px());
    (0..width * height).map(move |i| (f64::from(i % width) + 0.5, f64::from(i / width) + 0.5))
}

/// Solid angle of a pixel's quadrilateral, from its four corners (Van Oosterom and Strackee, IEEE
/// Trans. Biomedical Engineering 30, 125 (1983)).
fn solid_angle_sr(camera: &Camera, x: f64, y: f64) -> f64 {
    let corner = |dx, dy| camera.ray(x + dx, y + dy).unwrap().direction;
    let triangle = |a: DVec3, b: DVec3, c: DVec3| {
        let below = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
        2.0 * a.dot(b.cross(c)).atan2(below)
    };
    let [a, b, c, d] = [
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    triangle(a, b, c) + triangle(a, c, d)
}

#[test]
fn project_undoes_ray_in_every_projection() {
    for camera in all() {
        let mut n_rays = 0;
        for (x, y) in pixel_centers(&camera) {
            let Some(ray) = camera.ray(x, y) else {
                continue;
            };
            n_rays += 1;
            assert!((ray.direction.length() - 1.0).abs() < 1e-15);
            assert_eq!(ray.origin, camera.position());
            let (x_back, y_back) = camera.project(ray.direction).unwrap();
            let away = (x_back - x).hypot(y_back - y);
            // Pixels; measured 2.5e-12 next to the rim of 360 degrees.
            assert!(away < 2e-11, "{camera:?}: {x} {y}: {away}");
        }
        assert!(n_rays > 1000);
    }
}

#[test]
fn every_axis_goes_through_the_middle_and_the_matrix_puts_it_on_minus_z() {
    for camera in all() {
        let middle = (
            0.5 * f64::from(camera.width_px()),
            0.5 * f64::from(camera.height_px()),
        );
        let ray = camera.ray(middle.0, middle.1).unwrap();
        assert!(ray.direction.distance(camera.forward()) < 1e-15);
        let matrix = camera.world_to_camera();
        assert!(matrix.transform_point3(camera.position()).length() < 1e-14);
        let axis = matrix.transform_vector3(camera.forward());
        assert!(axis.distance(DVec3::NEG_Z) < 1e-14);
        // Right of the middle is right of the axis, above it is up.
        let right = camera.ray(middle.0 + 1.0, middle.1).unwrap().direction;
        assert!(matrix.transform_vector3(right).x > 0.0);
        let up = camera.ray(middle.0, middle.1 - 1.0).unwrap().direction;
        assert!(matrix.transform_vector3(up).y > 0.0);
    }
}

#[test]
fn the_pinhole_gives_the_rays_of_the_pinhole_camera() {
    let (plain, camera) = (pinhole(), Camera::from(pinhole()));
    for (x, y) in pixel_centers(&camera) {
        assert_eq!(camera.ray(x, y), Some(plain.ray(x, y)));
    }
    assert_eq!(PinholeCamera::try_from(camera), Ok(plain));
    assert_eq!(PinholeCamera::try_from(all()[1]), Err(Error::NotPinhole));
}

#[test]
fn an_equidistant_radius_grows_with_the_angle_and_an_equisolid_one_with_the_chord() {
    for (mapping, radius) in [
        (
            FisheyeMapping::Equidistant,
            (|theta: f64| theta) as fn(f64) -> f64,
        ),
        (FisheyeMapping::Equisolid, |theta| 2.0 * (0.5 * theta).sin()),
    ] {
        let camera = fisheye(level(), mapping, 220.0, 1000);
        let focal_px = 500.0 / radius(110_f64.to_radians());
        for theta_deg in [1e-3, 10.0, 42.0, 90.0, 109.999] {
            let theta = f64::to_radians(theta_deg);
            let (x, y) = (
                500.0 + 0.6 * focal_px * radius(theta),
                500.0 - 0.8 * focal_px * radius(theta),
            );
            let found = camera.ray(x, y).unwrap().direction;
            let expected = DVec3::new(0.6 * theta.sin(), 0.8 * theta.sin(), -theta.cos());
            assert!(found.distance(expected) < ANGLE_TOLERANCE, "{theta_deg}");
        }
    }
}

/// A half space is pi f wide in an equidistant picture and 2 sqrt(2) f in an equisolid one.
#[test]
fn a_lens_of_8_mm_draws_the_half_space_as_wide_as_its_mapping_says() {
    for (mapping, sensor_width_mm) in [
        (FisheyeMapping::Equidistant, 8.0 * PI),
        (FisheyeMapping::Equisolid, 16.0 * 2_f64.sqrt()),
    ] {
        let camera = FisheyeCamera::new(FisheyeRequest {
            pose: level(),
            mapping,
            lens: Lens::FocalLength(FocalLength {
                focal_length_mm: 8.0,
                sensor_width_mm,
            }),
            image_circle: Some(Radians::from_degrees(200.0)),
            width_px: 640,
            height_px: 480,
        })
        .unwrap();
        let edge = camera.ray(640.0, 240.0).unwrap().direction;
        assert!(edge.distance(DVec3::X) < ANGLE_TOLERANCE, "{edge}");
    }
}

#[test]
fn every_pixel_of_an_equisolid_fisheye_spans_the_same_solid_angle() {
    let camera = Camera::from(fisheye(pose(), FisheyeMapping::Equisolid, 180.0, 512));
    let focal_px = 256.0 / (2.0 * (PI / 4.0).sin());
    let expected_sr = 1.0 / (focal_px * focal_px);
    for (x, y) in [(256.0, 256.0), (300.0, 200.0), (30.0, 256.0), (100.0, 90.0)] {
        let ratio = solid_angle_sr(&camera, x, y) / expected_sr;
        // The sides of a pixel are no great circles: of the second order in its width, 4.4e-6.
        assert!((ratio - 1.0).abs() < 2e-5, "{x} {y}: {ratio}");
    }
}

#[test]
fn pixels_of_a_panorama_shrink_with_the_cosine_of_the_latitude_and_fill_the_sphere() {
    let camera = Camera::from(PanoramaCamera::new(pose(), [720, 360]).unwrap());
    for y in [0.0, 1.0, 60.0, 179.0, 180.0, 359.0] {
        let latitude = |y: f64| (PI * (0.5 - y / 360.0)).sin();
        let expected_sr = TAU / 720.0 * (latitude(y) - latitude(y + 1.0));
        let found_sr = solid_angle_sr(&camera, 37.0, y);
        // Great circles instead of parallels: 1.3e-5 next to the pole.
        assert!((found_sr / expected_sr - 1.0).abs() < 3e-5, "{y}");
    }
    let small = Camera::from(PanoramaCamera::new(pose(), [32, 16]).unwrap());
    let whole: f64 = (0..512)
        .map(|i| solid_angle_sr(&small, f64::from(i % 32), f64::from(i / 32)))
        .sum();
    assert!((whole / (2.0 * TAU) - 1.0).abs() < 1e-12, "{whole}");
}

#[test]
fn a_panorama_repeats_and_goes_on_beyond_its_poles() {
    let camera = PanoramaCamera::new(pose(), [64, 32]).unwrap();
    for (x, y, again) in [
        (-0.5, 10.0, (63.5, 10.0)),
        (64.5, 10.0, (0.5, 10.0)),
        (10.0, -0.5, (42.0, 0.5)),
        (10.0, 32.5, (42.0, 31.5)),
    ] {
        let (found, expected) = (camera.ray(x, y), camera.ray(again.0, again.1));
        assert!(found.direction.distance(expected.direction) < 1e-15);
    }
}

#[test]
fn poles_and_the_direction_straight_back_have_a_place() {
    let camera = PanoramaCamera::new(level(), [64, 32]).unwrap();
    assert_eq!(camera.project(DVec3::Y), (32.0, 0.0));
    assert_eq!(camera.project(DVec3::NEG_Y), (32.0, 32.0));
    for x in [0.0, 17.0, 64.0] {
        assert!(camera.ray(x, 0.0).direction.distance(DVec3::Y) < 1e-15);
    }
    for mapping in [FisheyeMapping::Equidistant, FisheyeMapping::Equisolid] {
        let camera = fisheye(level(), mapping, 360.0, 64);
        let (x, y) = camera.project(DVec3::Z).unwrap();
        assert!((x - 64.0).abs() < 1e-12 && (y - 32.0).abs() < 1e-12);
        // The rim is the direction straight back, from every side; f64 finds it to 1e-8 there.
        for (x, y) in [(64.0, 32.0), (0.0, 32.0), (32.0, 0.0)] {
            let back = camera.ray(x, y).unwrap().direction;
            assert!(back.distance(DVec3::Z) < 1e-7, "{back}");
        }
        assert!(camera.ray(64.0 + 1e-6, 32.0).is_none());
    }
}

#[test]
fn outside_the_image_circle_there_is_nothing() {
    for camera in all() {
        let Camera::Fisheye(fisheye) = camera else {
            continue;
        };
        assert!(fisheye.ray(0.5, 0.5).is_none());
        assert!(fisheye.ray(0.0, 32.0).is_some());
        assert!(fisheye.ray(-0.1, 32.0).is_none());
    }
    let half = fisheye(level(), FisheyeMapping::Equisolid, 180.0, 64);
    assert!(half.project(DVec3::X).is_some());
    assert!(half.project(DVec3::new(1.0, 0.0, 1e-9)).is_none());
    // A wide circle fills the corners of a picture.
    let wide = FisheyeCamera::new(FisheyeRequest {
        pose: level(),
        mapping: FisheyeMapping::Equidistant,
        lens: Lens::HorizontalFov(Radians::from_degrees(120.0)),
        image_circle: Some(Radians::from_degrees(180.0)),
        width_px: 64,
        height_px: 64,
    });
    assert!(wide.unwrap().ray(0.0, 0.0).is_some());
}

#[test]
fn no_pixel_spans_more_than_the_largest_angle() {
    for camera in all() {
        let largest = camera.pixel_angle().0;
        assert!(largest.is_finite() && largest > 0.0);
        for (x, y) in pixel_centers(&camera) {
            for (dx, dy) in [(0.5, 0.0), (0.0, 0.5)] {
                let ends = [camera.ray(x - dx, y - dy), camera.ray(x + dx, y + dy)];
                if let [Some(a), Some(b)] = ends {
                    let angle = 2.0 * (0.5 * a.direction.distance(b.direction)).asin();
                    assert!(angle <= largest * (1.0 + 1e-9), "{camera:?} {x} {y}");
                }
            }
        }
    }
}

#[test]
fn no_ray_is_farther_than_its_reach() {
    for camera in all() {
        for (x, y) in pixel_centers(&camera).step_by(7) {
            for (dx, dy) in [(3.0, 4.0), (-5.0, 0.0), (0.6, -0.8), (9.0, -12.0)] {
                let rays = [camera.ray(x, y), camera.ray(x + dx, y + dy)];
                if let [Some(a), Some(b)] = rays {
                    let angle = 2.0 * (0.5 * a.direction.distance(b.direction)).asin();
                    let reach = camera.reach((x, y), dx.hypot(dy)).0;
                    assert!(angle <= reach * (1.0 + 1e-9), "{camera:?} {x} {y}: {reach}");
                }
            }
        }
    }
}

#[test]
fn impossible_cameras_are_refused() {
    let request = FisheyeRequest {
        pose: level(),
        mapping: FisheyeMapping::Equidistant,
        lens: Lens::HorizontalFov(Radians::from_degrees(180.0)),
        image_circle: None,
        width_px: 64,
        height_px: 64,
    };
    for fov_deg in [0.0, -1.0, 360.1, f64::NAN, f64::INFINITY] {
        let angle = Radians::from_degrees(fov_deg);
        let lens = Lens::HorizontalFov(angle);
        let of_lens = FisheyeCamera::new(FisheyeRequest { lens, ..request });
        assert!(matches!(of_lens, Err(Error::FisheyeAngle { .. })));
        let image_circle = Some(angle);
        let of_circle = FisheyeCamera::new(FisheyeRequest {
            image_circle,
            ..request
        });
        assert!(matches!(of_circle, Err(Error::FisheyeAngle { .. })));
    }
    for [focal_length_mm, sensor_width_mm] in [
        [0.0, 36.0],
        [8.0, -1.0],
        [f64::NAN, 36.0],
        [8.0, f64::INFINITY],
    ] {
        let lens = Lens::FocalLength(FocalLength {
            focal_length_mm,
            sensor_width_mm,
        });
        let camera = FisheyeCamera::new(FisheyeRequest { lens, ..request });
        assert!(matches!(camera, Err(Error::LensLength { .. })));
        let camera = PinholeCamera::with_lens(level(), lens, [64, 64]);
        assert!(matches!(camera, Err(Error::LensLength { .. })));
    }
    let flat = FisheyeCamera::new(FisheyeRequest {
        height_px: 0,
        ..request
    });
    assert!(matches!(flat, Err(Error::EmptyPicture { .. })));
    for (size, is_empty) in [
        ([64, 33], false),
        ([0, 0], true),
        ([u32::MAX, u32::MAX / 2 + 1], false),
    ] {
        let error = PanoramaCamera::new(level(), size).unwrap_err();
        assert_eq!(matches!(error, Error::EmptyPicture { .. }), is_empty);
        assert_eq!(matches!(error, Error::PanoramaShape { .. }), !is_empty);
    }
}
