//! Pixels that an edge cuts are the mean over their footprint within the tolerance, and tell what is left.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use ndarray::Array2;
use ndarray::Axis;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::EARTH;
use niji_geometry::FisheyeCamera;
use niji_geometry::FisheyeMapping;
use niji_geometry::FisheyeRequest;
use niji_geometry::Lens;
use niji_geometry::MeshBvh;
use niji_geometry::PinholeCamera;
use niji_geometry::TriangleMesh;
use niji_radiometry::Colorimetry;
use niji_radiometry::Radians;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::Surfaces;
use niji_render::Toggle;

/// Tolerance of a pixel over the luminance of the ground, and the most that a pixel may err by in which gaps are
/// narrower than cells.
const TOLERANCE: f64 = 1e-3;
const NARROW: f64 = 1e-2;

/// Places along a side of a pixel at which the truth asks what is seen: it errs by 1e-4.
const N_PLACES: u32 = 400;
const OF_TRUTH: f64 = 1e-4;
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Part of the pixels whose error the layer has to cover.
const COVERED: f64 = 0.97;

const EYE_M: f64 = 200.0;

/// A view by azimuth, elevation and roll.
fn pose(look_deg: [f64; 3]) -> CameraPose {
    let eye = DVec3::new(0.0, EYE_M, 0.0);
    CameraPose::looking(eye, look_deg.map(Radians::from_degrees)).unwrap()
}

fn pinhole(look_deg: [f64; 3], fov_deg: f64, size_px: [u32; 2]) -> Camera {
    let lens = Lens::HorizontalFov(Radians::from_degrees(fov_deg));
    let camera = PinholeCamera::with_lens(pose(look_deg), lens, size_px);
    camera.unwrap().into()
}

fn fisheye(look_deg: [f64; 3]) -> Camera {
    let camera = FisheyeCamera::new(FisheyeRequest {
        pose: pose(look_deg),
        mapping: FisheyeMapping::Equidistant,
        lens: Lens::HorizontalFov(Radians::from_degrees(170.0)),
        image_circle: None,
        width_px: 15,
        height_px: 15,
    });
    camera.unwrap().into()
}

/// Luminance and told error of every pixel over the luminance of the ground, which the sun in the zenith lights
/// below a black sky; surfaces are black.
fn picture(camera: &Camera, surfaces: Option<&Surfaces>, has_tolerance: bool) -> [Array2<f64>; 2] {
    let (drops, table) = (LitDrops::none(), isotropic(0.1));
    let air = air([0.0; 3], [0.0; 3]);
    let observer = Colorimetry::new(&wavelengths());
    let weights = || observer.weights().iter().map(|[_, y, _]| *y);
    let ground = 0.3 * std::f64::consts::FRAC_1_PI;
    let ground_cd_m2: f64 = weights().zip(SUN).map(|(y, sun)| y * sun * ground).sum();
    let mut request = request(camera, sun_in_the_south(90.0), &drops, &table);
    request.air = Some(&air);
    request.effects.sky = Toggle::On;
    request.surfaces = surfaces;
    request.levels.pixel_footprint = PixelFootprint::Prefiltered;
    request.tolerance_cd_m2 = has_tolerance.then_some(TOLERANCE * ground_cd_m2);
    let picture = rendered(&request);
    let luminance = picture.radiance.map_axis(Axis(0), |spectrum| {
        let terms = spectrum.iter().zip(weights());
        terms.map(|(value, y)| f64::from(*value) * y).sum::<f64>() / ground_cd_m2
    });
    let told = picture.error_from("Y").unwrap();
    [
        luminance,
        told.mapv(|error| f64::from(error) / ground_cd_m2),
    ]
}

/// The part of every pixel in which the ground is seen.
fn ground_seen(camera: &Camera, mesh: Option<&MeshBvh>) -> Array2<f64> {
    let is_ground = |x, y| {
        let Some(ray) = camera.ray(x, y) else {
            return false;
        };
        EARTH.hits_ground(EYE_M, ray.direction.y)
            && mesh.is_none_or(|mesh| mesh.nearest(&ray, 0.0).is_none())
    };
    let size = (camera.height_px() as usize, camera.width_px() as usize);
    Array2::from_shape_fn(size, |(y, x)| {
        let n = f64::from(N_PLACES);
        // Shifted by the golden section: an edge along rows or columns meets n² distances.
        let places = (0..N_PLACES * N_PLACES).map(|index| {
            let [column, row] = [index % N_PLACES, index / N_PLACES].map(f64::from);
            let shifted = |place: f64, by: f64| (place + (by * GOLDEN).fract()) / n;
            (
                x as f64 + shifted(column, row),
                y as f64 + shifted(row, column),
            )
        });
        places.filter(|(x, y)| is_ground(*x, *y)).count() as f64 / (n * n)
    })
}

/// Every pixel is its mean within the tolerance, and the layer says what it errs by.
fn assert_means(camera: &Camera, mesh: Option<&MeshBvh>, name: &str) {
    let most = mesh.map_or(TOLERANCE, |_| NARROW);
    let surfaces = mesh.cloned().map(Surfaces::of_mesh);
    let [found, told] = picture(camera, surfaces.as_ref(), true);
    let expected = ground_seen(camera, mesh);
    let n_cut = expected
        .iter()
        .filter(|part| **part > 0.0 && **part < 1.0)
        .count();
    assert!(n_cut > 5, "{name}: {n_cut}");
    let mut worst = 0.0_f64;
    let mut n_told = 0;
    for ((found, expected), told) in found.iter().zip(&expected).zip(&told) {
        let error = (found - expected).abs();
        worst = worst.max(error);
        n_told += usize::from(error <= told + OF_TRUTH);
    }
    println!("{name}: {worst:.1e}");
    assert!(worst < most, "{name}: {worst:.1e}");
    let n_pixels = found.len();
    assert!(
        n_told as f64 >= COVERED * n_pixels as f64,
        "{name}: {n_told} of {n_pixels}"
    );
}

#[test]
fn pixels_on_the_horizon_are_the_mean_of_their_footprint() {
    for (elevation_deg, roll_deg) in [
        (0.0, 0.0),
        (3.0, 0.0),
        (-2.0, 17.0),
        (0.5, 45.0),
        (1.0, 90.0),
    ] {
        let camera = pinhole([10.0, elevation_deg, roll_deg], 40.0, [15, 11]);
        assert_means(&camera, None, &format!("{elevation_deg} {roll_deg}"));
    }
    for roll_deg in [0.0, 30.0] {
        assert_means(&fisheye([0.0, -35.0, roll_deg]), None, "fisheye");
    }
}

#[test]
fn a_horizon_through_the_corners_of_pixels_is_halved_by_them() {
    // A square picture around a point of the horizon, rolled by an eighth of a turn.
    let dip_deg = EARTH.horizon_dip(EYE_M).0.to_degrees();
    let camera = pinhole([0.0, -dip_deg, 45.0], 2.0, [8, 8]);
    let [found, _] = picture(&camera, None, true);
    for index in 0..8 {
        let error = (found[[index, 7 - index]] - 0.5).abs();
        assert!(error < TOLERANCE, "{index}: {error:.1e}");
    }
}

#[test]
fn a_horizon_on_the_border_of_pixels_is_as_none_in_them() {
    let dip_deg = EARTH.horizon_dip(EYE_M).0.to_degrees();
    let camera = pinhole([0.0, -dip_deg, 0.0], 2.0, [8, 6]);
    let [cut, _] = picture(&camera, None, true);
    let [middles, _] = picture(&camera, None, false);
    for (cut, middle) in cut.iter().zip(&middles) {
        assert!((cut - middle).abs() < TOLERANCE, "{cut} {middle}");
    }
}

#[test]
fn pixels_on_the_edges_and_corners_of_a_mesh_are_the_mean_of_their_footprint() {
    let corners = [
        [-9.0, 190.0],
        [7.0, 193.0],
        [8.0, 180.0],
        [-8.0, 178.0],
        [9.5, 196.0],
        [11.5, 196.5],
    ];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, -30.0));
    let mesh = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3], [2, 4, 5]]).unwrap();
    let camera = pinhole([0.0, -20.0, 4.0], 50.0, [25, 17]);
    assert_means(&camera, Some(&MeshBvh::new(mesh)), "mesh");
}
