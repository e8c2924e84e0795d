//! Whole pictures: conservation of energy, form factors, levels against each other.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_ice::Body;
use niji_ice::Error;
use niji_ice::Ground;
use niji_ice::Ice;
use niji_ice::IcePicture;
use niji_ice::IceRequest;
use niji_ice::IceSurface;
use niji_ice::IceTransport;
use niji_ice::Light;
use niji_ice::PathWavelengths;
use niji_ice::Sky;
use niji_ice::render_ice;
use niji_radiometry::Radians;
use niji_radiometry::WavelengthGrid;

const N_WAVELENGTHS: usize = 5;

/// Looks at a cube of 1 m from the south, from 8 m away and above.
fn camera(side_px: u32) -> PinholeCamera {
    view(DVec3::new(3.0, 2.0, 7.0), [-23.2, -11.0, 16.0], side_px)
}

fn view(position: DVec3, [azimuth, elevation, fov]: [f64; 3], side_px: u32) -> PinholeCamera {
    PinholeCamera::new(PinholeRequest {
        position,
        azimuth: Radians::from_degrees(azimuth),
        elevation: Radians::from_degrees(elevation),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(fov),
        width_px: side_px,
        height_px: side_px,
    })
    .unwrap()
}

fn cube(edge_m: f64) -> Body {
    let half = 0.5 * edge_m;
    Body::of_box(Aabb {
        min: DVec3::new(-half, 0.0, -half),
        max: DVec3::new(half, edge_m, half),
    })
    .unwrap()
}

fn ice(absorption_per_m: f64) -> Ice {
    Ice {
        absorption_per_m: vec![absorption_per_m; N_WAVELENGTHS],
        surface: IceSurface::PUBLISHED,
        bubbles: None,
        snow: None,
    }
}

fn light(sun: f64, sky: f64) -> Light {
    Light {
        sun_direction: DVec3::new(0.48, 0.6, 0.64),
        sun_radius: Radians(0.0),
        sun_irradiance: vec![sun; N_WAVELENGTHS],
        sky: Sky::Uniform(vec![sky; N_WAVELENGTHS]),
    }
}

const PATHS: IceTransport = IceTransport::PathTraced {
    paths_per_pixel: 64,
    wavelengths: PathWavelengths::All,
};

struct Scene {
    camera: PinholeCamera,
    body: Body,
    ice: Ice,
    light: Light,
    ground: Ground,
    transport: IceTransport,
    tolerance_cd_m2: Option<f64>,
}

impl Scene {
    /// A cube in a uniform surround of radiance 1 on ground that gives back all.
    fn furnace() -> Self {
        Self {
            camera: camera(16),
            body: cube(1.0),
            ice: ice(0.0),
            light: light(0.0, 1.0),
            ground: Ground::Land { albedo: 1.0 },
            transport: PATHS,
            tolerance_cd_m2: None,
        }
    }

    fn render(&self) -> Result<IcePicture, Error> {
        let request = IceRequest {
            camera: &self.camera,
            wavelengths: WavelengthGrid::new(450.0, 50.0, N_WAVELENGTHS).unwrap(),
            body: &self.body,
            ice: &self.ice,
            light: &self.light,
            ground: self.ground,
            transport: self.transport,
            tolerance_cd_m2: self.tolerance_cd_m2,
            seed: 7,
        };
        render_ice(&request, &|_| ())
    }
}

fn mean(picture: &IcePicture) -> f64 {
    let sum: f64 = picture.radiance.iter().map(|&value| f64::from(value)).sum();
    sum / picture.radiance.len() as f64
}

/// RMSE over the RMS of the reference.
fn relative_rmse(picture: &IcePicture, reference: &IcePicture) -> f64 {
    let both = picture.radiance.iter().zip(&reference.radiance);
    let (squares, total) = both.fold((0.0, 0.0), |(squares, total), (&a, &b)| {
        (
            squares + f64::from(a - b).powi(2),
            total + f64::from(b).powi(2),
        )
    });
    (squares / total).sqrt()
}

#[test]
fn the_side_of_a_clear_cube_shows_the_form_factor_of_its_top() {
    // Neighboring faces of a cube exchange 0.20004 of their light (J. Howell, A catalog of radiation
    // heat transfer configuration factors, C-14); black ground, the sun at the zenith, no sky.
    let mut scene = Scene::furnace();
    scene.camera = view(DVec3::new(0.0, 0.5, 1000.0), [0.0, 0.0, 0.0572], 16);
    scene.ground = Ground::Land { albedo: 0.0 };
    scene.light = light(PI, 0.0);
    scene.light.sun_direction = DVec3::Y;
    scene.ice.surface = IceSurface::Diffuse {
        outer_reflectance: 0.0,
        inner_reflectance: 0.0,
    };
    scene.transport = IceTransport::PathTraced {
        paths_per_pixel: 1024,
        wavelengths: PathWavelengths::All,
    };
    let found = mean(&scene.render().unwrap());
    // The picture is 0.2 % smaller than the face. Worst found 5e-4.
    assert!((found - 0.20004).abs() < 1e-3, "{found}");
}

#[test]
fn all_levels_agree_where_they_should() {
    let mut scene = Scene::furnace();
    scene.light = light(2.0, 0.5);
    scene.ground = Ground::Land { albedo: 0.3 };
    let mut at = |transport| {
        scene.transport = transport;
        scene.render().unwrap()
    };
    let paths = |paths_per_pixel, wavelengths| IceTransport::PathTraced {
        paths_per_pixel,
        wavelengths,
    };
    let reference = at(paths(2048, PathWavelengths::All));
    let all = relative_rmse(&at(paths(128, PathWavelengths::All)), &reference);
    let four = at(paths(512, PathWavelengths::Four));
    let one = at(paths(512, PathWavelengths::One));
    assert!(all < 0.03, "{all}");
    // The same light, with more noise.
    assert!((mean(&one) / mean(&reference) - 1.0).abs() < 0.01);
    assert!((mean(&four) / mean(&reference) - 1.0).abs() < 0.01);
    assert!(relative_rmse(&one, &reference) < 0.2);
    // Without absorption the mean chord keeps the energy, though not its place.
    let chord = at(IceTransport::MeanChord {
        paths_per_pixel: 128,
    });
    let far = relative_rmse(&chord, &reference);
    assert!(far > all && far < 0.2, "{far}");
}

#[test]
fn the_stated_error_covers_the_true_one_and_a_tolerance_is_kept() {
    let mut scene = Scene::furnace();
    scene.light = light(2.0, 0.5);
    scene.ground = Ground::Land { albedo: 0.3 };
    scene.ice = ice(0.5);
    let at = |scene: &mut Scene, paths_per_pixel, tolerance| {
        scene.tolerance_cd_m2 = tolerance;
        scene.transport = IceTransport::PathTraced {
            paths_per_pixel,
            wavelengths: PathWavelengths::All,
        };
        scene.render().unwrap()
    };
    let luminance = |picture: &IcePicture, y, x| {
        let colorimetry = niji_radiometry::Colorimetry::new(
            &WavelengthGrid::new(450.0, 50.0, N_WAVELENGTHS).unwrap(),
        );
        let spectrum = (0..N_WAVELENGTHS).map(|j| picture.radiance[[j, y, x]].into());
        colorimetry.xyz(&spectrum.collect::<Vec<f64>>())[1]
    };
    let reference = at(&mut scene, 4096, None);
    let rms = |picture: &IcePicture, tolerance: f64| {
        let (mut stated, mut found) = (0.0, 0.0);
        for y in 0..16 {
            for x in 0..16 {
                stated += f64::from(picture.error[[y, x]]).powi(2);
                found += (luminance(picture, y, x) - luminance(&reference, y, x)).powi(2);
            }
        }
        let rms = |squares: f64| (squares / 256.0_f64).sqrt();
        (rms(stated) <= tolerance, rms(stated) / rms(found))
    };
    let (_, ratio) = rms(&at(&mut scene, 256, None), f64::MAX);
    // Found 1.6.
    assert!(ratio > 0.9 && ratio < 4.0, "{ratio}");
    let tolerance = 0.01 * luminance(&reference, 8, 8);
    let picture = at(&mut scene, 1 << 16, Some(tolerance));
    assert!(rms(&picture, tolerance).0);
    let most = picture.n_paths.iter().copied().fold(0.0, f32::max);
    let fewest = picture.n_paths.iter().copied().fold(f32::MAX, f32::min);
    assert!(fewest < most && most < 65536.0, "{fewest} to {most}");
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let scene = Scene::furnace();
    let with = |n_threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(n_threads)
            .build();
        pool.unwrap().install(|| scene.render().unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn ice_in_the_sea_sees_the_light_of_the_sea_below() {
    let mut scene = Scene::furnace();
    scene.body = Body::of_box(Aabb {
        min: DVec3::new(-1.0, -5.0, -1.0),
        max: DVec3::new(1.0, 0.5, 1.0),
    })
    .unwrap();
    scene.ground = Ground::Sea {
        albedo: 0.05,
        wind_m_s: 3.0,
    };
    let picture = scene.render().unwrap();
    // Darker than the surround, brighter than the glow.
    assert!(
        picture
            .radiance
            .iter()
            .all(|&value| value > 0.04 && value < 1.01)
    );
    scene.camera = view(DVec3::new(4.0, -1.0, 0.0), [-90.0, 0.0, 20.0], 4);
    let under_water = scene.render().unwrap();
    assert!(
        under_water
            .radiance
            .iter()
            .all(|&value| (value - 0.05).abs() < 1e-3)
    );
}
