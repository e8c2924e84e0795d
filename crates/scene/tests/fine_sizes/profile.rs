//! Pictures of one line, from the outside of the bow to the antisolar point.

use glam::DMat3;
use glam::DMat4;
use glam::DVec3;
use ndarray::Array5;
use ndarray::s;
use niji_exchange::ScatteringTable;
use niji_geometry::Camera;
use niji_geometry::CameraPose;
use niji_geometry::Lens;
use niji_geometry::PinholeCamera;
use niji_geometry::Up;
use niji_radiometry::Radians;
use niji_render::RenderRequest;

use crate::common::rendered;
use crate::common::request;
use crate::common::sun_in_the_south;
use crate::rain::Rain;

/// Middle of the line and its length (degrees from the antisolar point), pixels.
const MIDDLE_DEG: f64 = 40.0;
const LENGTH_DEG: f64 = 20.0;
const N_PIXELS: u32 = 250;

/// Height of the sun and angle around the bow from its top (degrees).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    sun_deg: f64,
    clock_deg: f64,
}

/// A pixel's direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    pub(crate) theta_rad: f64,
    /// Squares of the vertical's components along s + d and s - d, `s` towards the sun, `d` into the view.
    pub(crate) t2: f64,
    pub(crate) b2: f64,
}

impl Place {
    pub(crate) const fn new(sun_deg: f64, clock_deg: f64) -> Self {
        Self { sun_deg, clock_deg }
    }

    fn sun(self) -> DVec3 {
        sun_in_the_south(self.sun_deg)
    }

    fn camera(self) -> Camera {
        let antisolar = -self.sun();
        let right = antisolar.cross(DVec3::Y).normalize();
        let up = right.cross(antisolar);
        let clock = self.clock_deg.to_radians();
        let outwards = right * clock.sin() + up * clock.cos();
        let (sin, cos) = MIDDLE_DEG.to_radians().sin_cos();
        let forward = antisolar * cos + outwards * sin;
        // From column to column towards the antisolar point.
        let across = antisolar * sin - outwards * cos;
        let axes = DMat3::from_cols(across, across.cross(forward), -forward);
        let pose = CameraPose::from_matrix(DMat4::from_mat3(axes), Up::Y).unwrap();
        let lens = Lens::HorizontalFov(Radians::from_degrees(LENGTH_DEG));
        PinholeCamera::with_lens(pose, lens, [N_PIXELS, 1])
            .unwrap()
            .into()
    }

    /// The pixels' directions, by ascending scattering angle.
    pub(crate) fn sights(self) -> Vec<Sight> {
        let (camera, sun) = (self.camera(), self.sun());
        let sight = |x: u32| {
            let view = camera.ray(f64::from(x) + 0.5, 0.5).unwrap().direction;
            let [t2, b2] = [sun + view, sun - view].map(|axis| axis.normalize().y.powi(2));
            Sight {
                theta_rad: sun.dot(view).acos(),
                t2,
                b2,
            }
        };
        (0..N_PIXELS).map(sight).collect()
    }

    /// How the bow of spheres moves there, from -1 to 1.
    pub(crate) fn m(self) -> f64 {
        let sights = self.sights();
        let middle = sights[sights.len() / 2];
        middle.t2 - middle.b2
    }

    /// Light of rain in a picture [1/sr], over that of drops that send 1/sr everywhere.
    pub(crate) fn picture(self, rain: &Rain, table: &ScatteringTable) -> Vec<f64> {
        let (camera, sun) = (self.camera(), self.sun());
        let drops = rain.around(sun);
        let radiance = |table: &ScatteringTable| {
            let request = RenderRequest {
                wavelengths: table.wavelengths,
                sun_irradiance: &[1.0],
                ..request(&camera, sun, &drops, table)
            };
            rendered(&request).radiance.slice_move(s![0, 0, ..])
        };
        let [found, even] = [radiance(table), radiance(&even(table))];
        let ratios = found.iter().zip(&even);
        ratios
            .map(|(found, even)| f64::from(found / even))
            .collect()
    }
}

/// The same sizes, which send 1/sr everywhere.
fn even(table: &ScatteringTable) -> ScatteringTable {
    ScatteringTable {
        moved: None,
        values: Array5::ones(table.values.dim()),
        ..table.clone()
    }
}
