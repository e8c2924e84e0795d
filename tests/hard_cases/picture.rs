//! Hard cases of whole pictures: fog, scenes far from the origin, the sun on the horizon and in the zenith, one pixel of
//! one wavelength.

use std::f64::consts::PI;
use std::path::Path;

use niji_atmosphere::DiffuseSky;
use niji_atmosphere::InScattering;
use niji_atmosphere::SingleScattering;
use niji_atmosphere::ViewRay;
use niji_exchange::SpectralImage;
use niji_geometry::EARTH;
use niji_picture::Error;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::scene_from_toml;
use niji_picture::unwatched;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "without air a scene is the same 10, 100 and 1000 km from the origin",
        measure: "difference over the peak",
        // Tables and levels are those of the origin; what is left is of f32 cells.
        allowed: 1e-4,
        error: far_from_the_origin,
    },
    HardCase {
        claim: "a picture of one pixel and one wavelength is that pixel of a larger one",
        measure: "relative difference",
        allowed: 1e-3,
        error: one_pixel_of_one_wavelength,
    },
    HardCase {
        claim: "a sun on the horizon and one in the zenith light drops alike where they scatter alike",
        measure: "relative difference of the light",
        allowed: 1e-4,
        error: horizon_and_zenith,
    },
    HardCase {
        claim: "a sun below the horizon lights no drops, and that is said",
        measure: "scenes that are not refused",
        allowed: 0.0,
        error: sun_below_the_horizon,
    },
    HardCase {
        claim: "fog of 10, 30 and 100 m of visibility is as bright as integrals with other nodes say",
        measure: "relative error of the radiance, and pictures darker than a hundredth of white",
        allowed: 0.03,
        error: bright_fog,
    },
];

fn planned(text: &str) -> Result<PlannedScene, Error> {
    let folder = Path::new(".");
    let request = PlanRequest {
        folder,
        ..PlanRequest::default()
    };
    PlannedScene::new(scene_from_toml(text, folder)?, request)
}

/// A cube of drops seen from a place, with a sun; no air, no shadows.
struct View {
    middle_m: [f64; 3],
    eye_m: [f64; 3],
    look_deg: [f64; 2],
    sun_deg: [f64; 2],
    size_px: u32,
    n_wavelengths: usize,
}

impl View {
    /// Northwards at the bow, from the origin.
    fn usual() -> Self {
        Self {
            middle_m: [0.0, 20.0, -100.0],
            eye_m: [0.0, 2.0, 0.0],
            look_deg: [0.0, 12.0],
            sun_deg: [180.0, 30.0],
            size_px: 5,
            n_wavelengths: 2,
        }
    }

    fn moved(self, by_m: [f64; 3]) -> Self {
        let moved = |place: [f64; 3]| [0, 1, 2].map(|axis| place[axis] + by_m[axis]);
        Self {
            middle_m: moved(self.middle_m),
            eye_m: moved(self.eye_m),
            ..self
        }
    }

    fn picture(&self) -> Result<SpectralImage, Error> {
        let Self {
            eye_m,
            look_deg: [azimuth_deg, elevation_deg],
            sun_deg: [sun_azimuth_deg, sun_elevation_deg],
            size_px,
            n_wavelengths,
            ..
        } = self;
        let [min_m, max_m] = [-16.0, 16.0].map(|off| self.middle_m.map(|axis| axis + off));
        let text = format!(
            r#"format = 1
name = "hard"
[sun]
elevation_deg = {sun_elevation_deg:?}
azimuth_deg = {sun_azimuth_deg:?}
[camera]
position_m = {eye_m:?}
azimuth_deg = {azimuth_deg:?}
elevation_deg = {elevation_deg:?}
horizontal_fov_deg = 4.0
width_px = {size_px}
height_px = {size_px}
[spectrum]
first_nm = 480.0
step_nm = 120.0
n_wavelengths = {n_wavelengths}
[drops]
shape = "uniform"
box_min_m = {min_m:?}
box_max_m = {max_m:?}
voxel_m = 8.0
law = {{ monodisperse = {{ radius_um = 100.0 }} }}
number_density_m3 = 1e4
[effects]
supernumeraries = "on"
sun_disc = "off"
drop_shadow = "off"
drop_flattening = "off"
multiple_scattering = "off"
[accuracy]
theory = "airy"
integration = "cell-exact"
pixel_footprint = "center"
"#
        );
        let planned = planned(&text)?;
        planned.check()?;
        planned.picture(&unwatched)
    }

    fn radiance(&self) -> Vec<f64> {
        let image = self.picture().expect("the cases name sound scenes");
        image
            .radiance
            .iter()
            .map(|light| f64::from(*light))
            .collect()
    }
}

fn far_from_the_origin() -> f64 {
    let here = View::usual().radiance();
    let peak = here.iter().copied().fold(0.0, f64::max);
    let is_lit = violations([peak > 0.0]);
    let places = [[1e4, 0.0, 0.0], [0.0, 0.0, -1e5], [-1e6, 0.0, 1e6]];
    worst(places.map(|by_m| {
        let far = View::usual().moved(by_m).radiance();
        let differences = far.iter().zip(&here).map(|(far, near)| (far - near).abs());
        worst(differences) / peak + is_lit
    }))
}

fn one_pixel_of_one_wavelength() -> f64 {
    let of_size = |size_px: u32, n_wavelengths: usize| {
        let view = View {
            size_px,
            n_wavelengths,
            ..View::usual()
        };
        view.radiance()
    };
    let (one, all) = (of_size(1, 1), of_size(3, 2));
    // Of the first wavelength the middle.
    let n_values = violations([one.len() == 1, all.len() == 18]);
    relative(one[0], all[4]) + n_values
}

fn horizon_and_zenith() -> f64 {
    // By 138 degrees both, the drops 100 m ahead: the eye looks 42 degrees from the antisolar point.
    let looks = |elevation_deg: f64| {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let eye_m = [0.0, 1000.0, 0.0];
        let middle_m = [0.0, 1000.0 + 100.0 * sin, -100.0 * cos];
        (eye_m, middle_m, [0.0, elevation_deg])
    };
    let light = |sun_elevation_deg: f64, elevation_deg: f64| {
        let (eye_m, middle_m, look_deg) = looks(elevation_deg);
        let view = View {
            eye_m,
            middle_m,
            look_deg,
            sun_deg: [180.0, sun_elevation_deg],
            size_px: 1,
            ..View::usual()
        };
        view.radiance()
    };
    // A level cube's diagonals differ with the elevation: views 45 degrees apart are alike.
    let (horizon, zenith) = (light(0.0, 42.0), light(90.0, -48.0));
    let (x, y) = (42.0_f64.to_radians(), 48.0_f64.to_radians());
    // Chords through a cube are its side over the larger cosine.
    let chords = y.cos().max(y.sin()) / x.cos().max(x.sin());
    worst(
        horizon
            .iter()
            .zip(&zenith)
            .map(|(horizon, zenith)| relative(*zenith * chords, *horizon)),
    )
}

fn sun_below_the_horizon() -> f64 {
    violations([-1.0, -30.0, -90.0].map(|elevation_deg| {
        let view = View {
            sun_deg: [180.0, elevation_deg],
            ..View::usual()
        };
        matches!(view.picture(), Err(Error::Dark { .. }))
    }))
}

/// Fog of a visibility of so many km, and drops that nobody sees.
const FOG: &str = r#"format = 1
name = "fog"
[sun]
elevation_deg = 40.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 30.0
elevation_deg = 10.0
horizontal_fov_deg = 60.0
width_px = 3
height_px = 5
[spectrum]
first_nm = 550.0
step_nm = 10.0
n_wavelengths = 1
[drops]
shape = "uniform"
box_min_m = [1000.0, 0.0, 1000.0]
box_max_m = [1200.0, 50.0, 1200.0]
voxel_m = 50.0
law = { monodisperse = { radius_um = 10.0 } }
number_density_m3 = 1e6
[air]
constituents = ["rayleigh", "aerosol"]
aerosol = "maritime"
visibility_km = 0.01
[accuracy]
pixel_footprint = "center"
"#;

fn bright_fog() -> f64 {
    worst(["0.01", "0.03", "0.1"].map(|visibility_km| {
        let text = FOG.replace("_km = 0.01", &format!("_km = {visibility_km}"));
        let planned = planned(&text).expect("a sound scene");
        let air = planned.air(&unwatched).expect("sound air").expect("fog");
        let image = planned.picture(&unwatched).expect("a picture");
        let sky = DiffuseSky::new(&air).expect("it has diffuse light");
        let single = SingleScattering::new(&air, InScattering::STANDARD);
        let scene = &planned.scene;
        let camera = scene.camera.camera().expect("a sound camera");
        let white = air.sun_irradiance[0] / PI;
        worst(image.radiance.indexed_iter().map(|((_, y, x), found)| {
            let at = camera
                .ray(x as f64 + 0.5, y as f64 + 0.5)
                .expect("a pinhole");
            let directions = [at.origin, at.direction, scene.sun.direction()];
            let ray = ViewRay::new(EARTH, directions, f64::INFINITY);
            let diffuse = air.sun_irradiance[0] * sky.radiance_per_sun(&ray)[0];
            let expected = single.sky_radiance(&ray)[0] + diffuse;
            let found = f64::from(*found);
            relative(found, expected) + violations([found > 0.01 * white])
        }))
    }))
}
