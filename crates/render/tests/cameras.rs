//! Bows through every kind of lens: the circle in the picture is the circle of the table.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::Lens;
use niji_geometry::PanoramaCamera;
use niji_radiometry::Radians;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::Rendered;
use niji_render::SunPath;

/// The bow of these tests: a circle of 42 degrees around the antisolar point, 3 degrees wide.
const BOW_DEG: f64 = 42.0;
const WIDTH_DEG: f64 = 1.5;

/// A circle in a picture is measured by the mean over pixels that sample it: measured 3.7e-3.
const RADIUS_TOLERANCE_DEG: f64 = 0.01;

const SIDE_PX: u32 = 240;

fn one_bow() -> niji_exchange::ScatteringTable {
    table(|_, theta| {
        let away = (180.0 - theta.to_degrees() - BOW_DEG) / WIDTH_DEG;
        (-0.5 * away * away).exp()
    })
}

/// Thin drops all around the eye.
fn mist(sun: DVec3) -> LitDrops {
    let grid = GridBox {
        min: DVec3::splat(-30.0),
        max: DVec3::splat(30.0),
        voxel_m: 10.0,
    };
    LitDrops::new(vec![bricks(&grid, |_| 1e-4)], sun, SunPath::Ignore).unwrap()
}

fn picture(camera: &Camera, sun_deg: f64, footprint: PixelFootprint) -> Rendered {
    let sun = sun_in_the_south(sun_deg);
    let (drops, table) = (mist(sun), one_bow());
    let mut request = request(camera, sun, &drops, &table);
    request.levels.pixel_footprint = footprint;
    rendered(&request)
}

fn pose(elevation_deg: f64) -> CameraPose {
    let angles = [0.0, elevation_deg, 0.0].map(Radians::from_degrees);
    CameraPose::looking(DVec3::ZERO, angles).unwrap()
}

/// A fisheye of 180 degrees that looks at the antisolar point of a sun 45 degrees high.
fn from_an_aeroplane(mapping: FisheyeMapping) -> Camera {
    let camera = FisheyeCamera::new(FisheyeRequest {
        pose: pose(-45.0),
        mapping,
        lens: Lens::HorizontalFov(Radians::from_degrees(180.0)),
        image_circle: None,
        width_px: SIDE_PX,
        height_px: SIDE_PX,
    });
    camera.unwrap().into()
}

/// Mean radius of the light in a quarter of a picture [deg], by the published mapping alone.
fn radius_deg(picture: &Rendered, mapping: FisheyeMapping, quarter: [bool; 2]) -> f64 {
    let half = 0.5 * f64::from(SIDE_PX);
    let (mut sum, mut weighted) = (0.0, 0.0);
    for ((y, x), light) in picture
        .radiance
        .index_axis(ndarray::Axis(0), 1)
        .indexed_iter()
    {
        let (x, y) = (x as f64 + 0.5 - half, y as f64 + 0.5 - half);
        if [x > 0.0, y > 0.0] != quarter {
            continue;
        }
        let r = x.hypot(y) / half;
        let (theta_rad, solid_angle) = match mapping {
            FisheyeMapping::Equidistant => (r * FRAC_PI_2, (r * FRAC_PI_2).sin() / r),
            FisheyeMapping::Equisolid => (2.0 * (r * (0.25 * PI).sin()).min(1.0).asin(), 1.0),
        };
        // A ring's light by angle, not by solid angle.
        let share = f64::from(*light) * solid_angle / theta_rad.sin();
        sum += share;
        weighted += share * theta_rad.to_degrees();
    }
    weighted / sum
}

#[test]
fn a_whole_circle_from_an_aeroplane_has_the_radius_of_the_table() {
    for mapping in [FisheyeMapping::Equidistant, FisheyeMapping::Equisolid] {
        let camera = from_an_aeroplane(mapping);
        let picture = picture(&camera, 45.0, PixelFootprint::Center);
        for quarter in [[false, false], [true, false], [false, true], [true, true]] {
            let found_deg = radius_deg(&picture, mapping, quarter);
            let away_deg = (found_deg - BOW_DEG).abs();
            assert!(
                away_deg < RADIUS_TOLERANCE_DEG,
                "{mapping:?} {quarter:?}: {found_deg}"
            );
        }
    }
}

#[test]
fn outside_the_image_circle_the_picture_is_black_and_clear() {
    for footprint in [
        PixelFootprint::Center,
        PixelFootprint::Prefiltered,
        PixelFootprint::Grid { n: 3 },
    ] {
        let camera = from_an_aeroplane(FisheyeMapping::Equisolid);
        // A low sun: the bow crosses the rim.
        let picture = picture(&camera, 10.0, footprint);
        let (mut n_lit, mut n_outside) = (0, 0);
        for ((_, y, x), transmittance) in picture[PictureLayer::Transmittance].indexed_iter() {
            let light = picture.radiance[[1, y, x]];
            let (right, down) = (x as f64 + 0.5 - 120.0, y as f64 + 0.5 - 120.0);
            if right.hypot(down) > 121.0 {
                n_outside += 1;
                assert_eq!((light, *transmittance), (0.0, 1.0));
            } else if light > 0.0 && right.hypot(down) > 118.0 {
                n_lit += 1;
            }
        }
        assert!(n_outside > 10_000 && n_lit > 10, "{n_outside} {n_lit}");
    }
}

/// The bow in a panorama: 42 degrees from the antisolar point, which lies 15 degrees below north.
#[test]
fn a_panorama_shows_the_bow_at_its_elevation_and_its_feet_at_their_azimuth() {
    let camera = Camera::from(PanoramaCamera::new(pose(0.0), [720, 360]).unwrap());
    let picture = picture(&camera, 15.0, PixelFootprint::Center);
    let light = picture.radiance.index_axis(ndarray::Axis(0), 1);
    let mean = |values: &mut dyn Iterator<Item = (f64, f64)>| {
        let (sum, weighted) = values.fold((0.0, 0.0), |(sum, weighted), (at, light)| {
            (sum + light, weighted + at * light)
        });
        weighted / sum
    };
    // Half a degree a pixel; north is the edge between the two middle columns.
    let mut up_north =
        (0..180).map(|y| (90.0 - 0.5 * (y as f64 + 0.5), f64::from(light[[y, 360]])));
    let top_deg = mean(&mut up_north);
    // A row is half a degree high, the light of a ring falls with the way through the box: 0.019.
    assert!((top_deg - (BOW_DEG - 15.0)).abs() < 0.04, "{top_deg}");
    let mut east = (360..540).map(|x| {
        let on_horizon = 0.5 * (light[[179, x]] + light[[180, x]]);
        (0.5 * (x as f64 + 0.5) - 180.0, f64::from(on_horizon))
    });
    let foot_deg = mean(&mut east);
    let cos_foot = BOW_DEG.to_radians().cos() / 15_f64.to_radians().cos();
    let expected_deg = cos_foot.acos().to_degrees();
    // The circle stands slantwise on the horizon and bends there: the mean of its width lies
    // 0.014 degrees beside its middle.
    assert!(
        (foot_deg - expected_deg).abs() < 0.03,
        "{foot_deg} {expected_deg}"
    );
    // West is as east is.
    for x in 0..360 {
        assert!((light[[150, x]] - light[[150, 719 - x]]).abs() <= 1e-5 * light[[150, x]]);
    }
}

#[test]
fn a_direction_has_the_same_radiance_through_every_lens() {
    let panorama = Camera::from(PanoramaCamera::new(pose(0.0), [72, 36]).unwrap());
    let whole = picture(&panorama, 20.0, PixelFootprint::Center);
    let mut n_bright = 0;
    for (x, y) in [
        (36, 12),
        (43, 17),
        (30, 15),
        (45, 20),
        (28, 22),
        (36, 35),
        (0, 0),
    ] {
        let elevation_deg = 90.0 - 5.0 * (f64::from(y) + 0.5);
        let azimuth_deg = 5.0 * (f64::from(x) + 0.5) - 180.0;
        let narrow = camera(DVec3::ZERO, (azimuth_deg, elevation_deg), 1e-3, (1, 1));
        let here = picture(&narrow, 20.0, PixelFootprint::Center);
        for wavelength in 0..3 {
            let [a, b] = [
                whole.radiance[[wavelength, y as usize, x as usize]],
                here.radiance[[wavelength, 0, 0]],
            ];
            // The f32 of the rows, at a slope of up to 1 per degree; measured 0.
            assert!((a - b).abs() <= 1e-5 * a.max(b), "{x} {y}: {a} {b}");
        }
        n_bright += usize::from(here.radiance[[0, 0, 0]] > 1e-6);
    }
    assert!(n_bright >= 2);
}
