//! Water that is seen: Fresnel's share of the sky, the bow by its polarization and in its place, sun and surfaces.

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec2;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_exchange::ScatteringTable;
use niji_geometry::MeshBvh;
use niji_geometry::TriangleMesh;
use niji_radiometry::Nanometers;
use niji_radiometry::Reflectance;
use niji_radiometry::Water;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::RenderRequest;
use niji_render::Solid;
use niji_render::SolidShape;
use niji_render::SunPath;
use niji_render::Surfaces;
use niji_render::Toggle;
use niji_render::WaterSurface;

use std::f64::consts::PI;

/// R_s and R_p by Fresnel's laws of sine and tangent, at an elevation and a wavelength of the tests.
fn fresnel(elevation_deg: f64, wavelength: usize) -> [f64; 2] {
    let nm = Nanometers(450.0 + 100.0 * wavelength as f64);
    let incidence = (90.0 - elevation_deg).to_radians();
    let refraction = (incidence.sin() / Water::pure(15.0).refractive_index(nm)).asin();
    let (less, more) = (incidence - refraction, incidence + refraction);
    [less.sin() / more.sin(), less.tan() / more.tan()].map(|it| it * it)
}

/// Radiance along a direction.
fn along(request: &RenderRequest, eye: DVec3, look_deg: (f64, f64)) -> [f64; 3] {
    let camera = camera(eye, look_deg, 1e-4, (1, 1));
    let picture = rendered(&RenderRequest {
        camera: &camera,
        region: niji_geometry::PixelRegion::frame(1, 1),
        ..*request
    });
    [0, 1, 2].map(|wavelength| f64::from(picture.radiance[[wavelength, 0, 0]]))
}

fn curtain() -> LitDrops {
    let grid = GridBox {
        min: DVec3::new(-900.0, 0.0, -600.0),
        max: DVec3::new(900.0, 900.0, -100.0),
        voxel_m: 50.0,
    };
    LitDrops::new(
        vec![bricks(&grid, |_| 1e-4)],
        sun_in_the_south(10.0),
        SunPath::Ignore,
    )
    .unwrap()
}

#[test]
fn water_mirrors_fresnels_share_of_the_sky() {
    let air = air([4e-5, 2e-5, 1e-5], [4e-5, 2e-5, 1e-5]);
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let any = camera(DVec3::Y, (0.0, 0.0), 1.0, (1, 1));
    let mut request = request(&any, sun_in_the_south(30.0), &drops, &table);
    request.effects.sky = Toggle::On;
    request.air = Some(&air);
    let mut worst = 0.0_f64;
    for elevation_deg in [1.0, 5.0, 20.0, 53.0, 80.0] {
        for azimuth_deg in [0.0, 110.0] {
            // A decimetre above the water: of air in front next to nothing.
            let eye = DVec3::new(0.0, 0.1, 0.0);
            let sky = along(&request, eye, (azimuth_deg, elevation_deg));
            let wet = RenderRequest {
                water: Some(endless(0.0)),
                ..request
            };
            let found = along(&wet, eye, (azimuth_deg, -elevation_deg));
            for wavelength in 0..3 {
                let [s, p] = fresnel(elevation_deg, wavelength);
                let expected = 0.5 * (s + p) * sky[wavelength];
                worst = worst.max(relative(found[wavelength], expected));
            }
        }
    }
    println!("{worst:.1e}");
    assert!(worst < 5e-3, "{worst}");
}

#[test]
fn a_bow_in_water_is_mirrored_by_its_polarization() {
    // Isotropic drops of which the light across the plane of scattering is a third of that along it.
    let (drops, table) = (curtain(), isotropic(0.05));
    let any = camera(DVec3::Y, (0.0, 0.0), 1.0, (1, 1));
    let sun = sun_in_the_south(10.0);
    let request = request(&any, sun, &drops, &table);
    let mut worst = 0.0_f64;
    for (azimuth_deg, elevation_deg) in [(0.0, 3.0), (0.0, 30.0), (25.0, 10.0), (-40.0, 37.0_f64)] {
        let dry = along(
            &request,
            DVec3::new(0.0, -2.0, 0.0),
            (azimuth_deg, elevation_deg),
        );
        let wet = RenderRequest {
            water: Some(endless(0.0)),
            ..request
        };
        let found = along(
            &wet,
            DVec3::new(0.0, 2.0, 0.0),
            (azimuth_deg, -elevation_deg),
        );
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let (east, north) = f64::to_radians(azimuth_deg).sin_cos();
        let way = DVec3::new(cos * east, sin, -cos * north);
        // Two fields that have nothing to do with each other, and what of each is horizontal.
        let across = sun.cross(way).normalize();
        let fields = [across, way.cross(across)];
        let level = way.cross(DVec3::Y).normalize();
        for wavelength in 0..3 {
            let [s, p] = fresnel(elevation_deg, wavelength);
            let mirrored = |field: DVec3| {
                let share = field.dot(level).powi(2);
                s * share + p * (1.0 - share)
            };
            let light = 0.25 * mirrored(fields[0]) + 0.75 * mirrored(fields[1]);
            worst = worst.max(relative(found[wavelength], light * dry[wavelength]));
        }
    }
    println!("{worst:.1e}");
    // The planet turns rays 40 m away by 1e-5.
    assert!(worst < 1e-3, "{worst}");
}

/// A bow at 138 degrees.
fn bow() -> ScatteringTable {
    table_of(&[100.0], 50.0, |_, _, theta| {
        (-0.5 * ((theta.to_degrees() - 138.0) / 0.3).powi(2)).exp()
    })
}

#[test]
fn the_bow_in_water_stands_where_that_of_the_eye_below_it_does() {
    let (drops, table) = (curtain(), bow());
    let sun_deg = 10.0_f64;
    for azimuth_deg in [0.0, 20.0, -33.0_f64] {
        // cos 42 = cos e cos h cos A - sin e sin h, the antisolar point at -h.
        let on_bow = |elevation_deg: f64| {
            let ((sin_e, cos_e), (sin_h, cos_h)) = (
                elevation_deg.to_radians().sin_cos(),
                sun_deg.to_radians().sin_cos(),
            );
            let cosine = cos_e * cos_h * azimuth_deg.to_radians().cos() - sin_e * sin_h;
            cosine.acos().to_degrees() - 42.0
        };
        let (mut low, mut high) = (0.0, 60.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if on_bow(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        // A strip of pixels 0.02 degrees high across it, seen in the water.
        let eye = DVec3::new(0.0, 2.0, 0.0);
        let n = 101;
        let strip = camera(eye, (azimuth_deg, -low), 0.02, (1, n));
        let mut request = request(&strip, sun_in_the_south(sun_deg), &drops, &table);
        request.water = Some(endless(0.0));
        let picture = rendered(&request);
        let light = |row: u32| f64::from(picture.radiance[[1, row as usize, 0]]);
        let all: f64 = (0..n).map(light).sum();
        let place: f64 = (0..n).map(|row| (f64::from(row) - 50.0) * light(row)).sum();
        let off_deg = 0.02 * place / all;
        println!("{azimuth_deg} {off_deg:.4}");
        assert!(off_deg.abs() < 0.05, "{azimuth_deg} {off_deg}");
    }
}

#[test]
fn the_sun_in_still_water_is_its_disc_and_waves_that_settle_leave_it() {
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let any = camera(DVec3::Y, (0.0, 0.0), 1.0, (1, 1));
    let request = request(&any, sun_in_the_south(25.0), &drops, &table);
    let disc_sr = PI * f64::powi(0.533_f64.to_radians() / 2.0, 2);
    for slope in [0.0, 1e-6] {
        let wet = RenderRequest {
            water: Some(endless(slope)),
            ..request
        };
        let eye = DVec3::new(0.0, 2.0, 0.0);
        let found = along(&wet, eye, (180.0, -25.0));
        for wavelength in 0..3 {
            let [s, p] = fresnel(25.0, wavelength);
            let expected = 0.5 * (s + p) * SUN[wavelength] / disc_sr;
            assert!(relative(found[wavelength], expected) < 2e-3, "{slope}");
        }
        assert_eq!(along(&wet, eye, (180.0, -25.4)), [0.0; 3]);
    }
}

#[test]
fn waves_that_settle_show_bow_and_sky_as_still_water_does() {
    let air = air([4e-5, 2e-5, 1e-5], [4e-5, 2e-5, 1e-5]);
    let (drops, table) = (curtain(), bow());
    let any = camera(DVec3::Y, (0.0, 0.0), 1.0, (1, 1));
    let mut request = request(&any, sun_in_the_south(10.0), &drops, &table);
    request.effects.sky = Toggle::On;
    request.air = Some(&air);
    for elevation_deg in [1.0, 30.0, 32.0, 60.0] {
        let seen = |slope| {
            let wet = RenderRequest {
                water: Some(endless(slope)),
                ..request
            };
            along(&wet, DVec3::new(0.0, 2.0, 0.0), (0.0, -elevation_deg))
        };
        let (still, settled) = (seen(0.0), seen(1e-5));
        for wavelength in 0..3 {
            let off = relative(settled[wavelength], still[wavelength]);
            assert!(off < 3e-3, "{elevation_deg}: {off}");
        }
        // Waves without wind blur the bow.
        assert!(seen(0.039)[1] > 0.0);
    }
}

#[test]
fn a_lit_wall_stands_on_its_head_in_the_water() {
    let corners = [(-50.0, 0.0), (50.0, 0.0), (50.0, 30.0), (-50.0, 30.0)];
    let corners = corners.map(|(x, y)| DVec3::new(x, y, -40.0));
    let mesh = TriangleMesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let surfaces = Surfaces::default().with(Solid {
        shape: SolidShape::Mesh(MeshBvh::new(mesh)),
        albedo: Some(Reflectance::Even(0.4).into()),
    });
    let (drops, table) = (LitDrops::none(), isotropic(0.0));
    let any = camera(DVec3::Y, (0.0, 0.0), 1.0, (1, 1));
    let mut request = request(&any, sun_in_the_south(20.0), &drops, &table);
    request.surfaces = Some(&surfaces);
    request.effects.lit_surfaces = Toggle::On;
    request.water = Some(endless(0.0));
    let eye = DVec3::new(0.0, 3.0, 0.0);
    let wall = along(&request, eye, (0.0, 20.0));
    let found = along(&request, eye, (0.0, -20.0));
    for wavelength in 0..3 {
        let [s, p] = fresnel(20.0, wavelength);
        assert!(relative(found[wavelength], 0.5 * (s + p) * wall[wavelength]) < 1e-5);
    }
    // Over its top is nothing, nor in water that ends before it.
    assert_eq!(along(&request, eye, (0.0, -40.0)), [0.0; 3]);
    request.water = Some(WaterSurface {
        extent_m: [DVec2::new(-9.0, -5.0), DVec2::new(9.0, 5.0)],
        ..endless(0.0)
    });
    assert_eq!(along(&request, eye, (0.0, -20.0)), [0.0; 3]);
}

#[test]
fn surfaces_in_the_water_do_not_depend_on_the_pixels_before() {
    // How much of the sky a wall sees grows away from the corner that it makes with the other.
    let corners = [(-30.0, -40.0), (50.0, -40.0), (-30.0, -1.0)];
    let corners = corners.map(|(x, z)| [0.0, 30.0].map(|y| DVec3::new(x, y, z)));
    let triangles = [[0, 2, 3], [0, 3, 1], [4, 0, 1], [4, 1, 5]];
    let mesh = TriangleMesh::new(&corners.concat(), &triangles).unwrap();
    let surfaces = Surfaces::default().with(Solid {
        shape: SolidShape::Mesh(MeshBvh::new(mesh)),
        albedo: Some(Reflectance::Even(0.4).into()),
    });
    let drops = LitDrops::none();
    let mut air = air([0.0; 3], [0.0; 3]);
    air.diffuse = Some(uniform_light(0.02));
    let table = isotropic(0.0);
    let eye = DVec3::new(0.0, 3.0, 0.0);
    let camera = camera(eye, (-20.0, -20.0), 30.0, (40, 27));
    for slope in [0.0, 0.05] {
        let mut request = request(&camera, sun_in_the_south(20.0), &drops, &table);
        request.air = Some(&air);
        request.surfaces = Some(&surfaces);
        request.effects.lit_surfaces = Toggle::On;
        request.water = Some(endless(slope));
        let whole = rendered(&request);
        request.region = OFF_CENTER;
        let part = rendered(&request);
        let (rows, columns) = off_center();
        for ((wavelength, y, x), value) in part.radiance.indexed_iter() {
            let place = [
                wavelength,
                y + rows.start as usize,
                x + columns.start as usize,
            ];
            assert_eq!(*value, whole.radiance[place], "{slope}: {place:?}");
            assert!(*value > 0.0);
        }
    }
}

#[test]
fn water_that_nobody_sees_changes_no_bit_and_grazing_water_is_finite() {
    let (drops, table) = (curtain(), bow());
    let above = camera(DVec3::new(0.0, 2.0, 0.0), (0.0, 30.0), 40.0, (12, 9));
    let below = camera(DVec3::new(0.0, -2.0, 0.0), (0.0, 10.0), 60.0, (12, 9));
    for camera in [&above, &below] {
        let dry = request(camera, sun_in_the_south(10.0), &drops, &table);
        let wet = RenderRequest {
            water: Some(endless(0.02)),
            ..dry
        };
        assert_eq!(rendered(&dry).radiance, rendered(&wet).radiance);
    }
    let level = camera(DVec3::new(0.0, 1e-3, 0.0), (0.0, 0.0), 1.0, (3, 64));
    for slope in [0.0, 0.01, 0.35] {
        let even = isotropic(0.05);
        let mut request = request(&level, sun_in_the_south(10.0), &drops, &even);
        request.water = Some(endless(slope));
        let picture = rendered(&request);
        assert!(picture[PictureLayer::Water].iter().all(|it| it.is_finite()));
        assert!(picture[PictureLayer::Water].iter().any(|it| *it > 0.0));
    }
}
