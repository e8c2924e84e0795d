//! What a scene of ice becomes for the renderer: body, light, camera.

use std::f64::consts::PI;
use std::path::Path;

use glam::DMat3;
use glam::DVec3;
use niji_atmosphere::DiffuseDome;
use niji_atmosphere::PreparedSky;
use niji_atmosphere::SUN_RADIUS;
use niji_atmosphere::ScatteringOrders;
use niji_atmosphere::SkyDirection;
use niji_atmosphere::SkyMethod;
use niji_atmosphere::SkyObserver;
use niji_atmosphere::Suns;
use niji_atmosphere::sun_irradiance_at;
use niji_exchange::AtmosphereTable;
use niji_geometry::Aabb;
use niji_geometry::MeshDetail;
use niji_geometry::PinholeCamera;
use niji_geometry::TriangleMesh;
use niji_geometry::read_mesh;
use niji_ice::Body;
use niji_ice::Ground;
use niji_ice::Ice;
use niji_ice::IcePicture;
use niji_ice::IceRequest;
use niji_ice::Light;
use niji_ice::Sky;
use niji_ice::SkyMap;
use niji_ice::ice_absorption_spectrum;
use niji_ice::render_ice;
use niji_picture::air::AirRequest;
use niji_picture::unwatched;
use niji_radiometry::Radians;
use niji_radiometry::WavelengthGrid;
use niji_render::SkyModel;
use niji_scene::IceAccuracy;
use niji_scene::IceScene;
use niji_scene::IceShape;

use crate::failure::Failure;
use crate::stages::sky::no_less_than_dark;

/// Azimuths and elevations of the map of the sky.
const SKY_NODES: [usize; 2] = [128, 48];
/// Sine of the elevation of the lowest row of the map: the sky, not the ground at the horizon.
const ABOVE_HORIZON: f64 = 1e-4;

/// Everything that a picture of ice is made from.
pub(crate) struct World {
    pub(crate) camera: PinholeCamera,
    pub(crate) wavelengths: WavelengthGrid,
    pub(crate) body: Body,
    pub(crate) ice: Ice,
    pub(crate) light: Light,
    pub(crate) ground: Ground,
}

impl World {
    /// Builds what a scene describes; `mesh` is the file that its shape names.
    ///
    /// # Errors
    /// A mesh that is missing, damaged or encloses nothing, or a scene without any light.
    pub(crate) fn new(scene: &IceScene, mesh: Option<&Path>) -> Result<Self, Failure> {
        let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
        let wavelengths = scene.spectrum;
        let light = light(scene, wavelengths)?;
        if is_dark(&light) {
            return Err(Failure::Impossible(format!(
                "{}: nothing shines: the sun is below the horizon, and the scene has neither [sky] \
                 nor an [air] that it lights",
                scene.name
            )));
        }
        Ok(Self {
            camera: scene.camera.pinhole().map_err(|error| usage(&error))?,
            wavelengths,
            body: body(scene, mesh)?,
            ice: Ice {
                absorption_per_m: ice_absorption_spectrum(&wavelengths),
                surface: scene.ice.surface,
                bubbles: scene.ice.bubbles,
                snow: scene.ice.snow,
            },
            light,
            ground: scene.ground,
        })
    }

    /// Renders it.
    ///
    /// # Errors
    /// Settings that contradict each other.
    pub(crate) fn render(
        &self,
        accuracy: IceAccuracy,
        tolerance_cd_m2: Option<f64>,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<IcePicture, Failure> {
        let request = IceRequest {
            camera: &self.camera,
            wavelengths: self.wavelengths,
            body: &self.body,
            ice: &self.ice,
            light: &self.light,
            ground: self.ground,
            transport: accuracy.transport,
            tolerance_cd_m2,
            seed: accuracy.seed,
        };
        render_ice(&request, progress).map_err(|error| Failure::Usage(error.to_string()))
    }
}

fn body(scene: &IceScene, mesh: Option<&Path>) -> Result<Body, Failure> {
    let base = DVec3::from(scene.ice.base_m);
    let failed = |error: &dyn std::fmt::Display| match mesh {
        Some(path) => Failure::bad_input(path, error),
        None => Failure::Usage(error.to_string()),
    };
    let moved = |mesh: &TriangleMesh, place: &dyn Fn(DVec3) -> DVec3| {
        mesh.moved(|corner| place(corner) + base)
            .map_err(|error| failed(&error))
    };
    let body = match &scene.ice.shape {
        // Stored zeros are exact.
        &IceShape::Cube {
            edge_m,
            turn_deg: 0.0,
        } => Body::of_box(box_on(base, DVec3::splat(edge_m))),
        &IceShape::Cube { edge_m, turn_deg } => {
            let turn = DMat3::from_rotation_y(-turn_deg.to_radians());
            let cube = TriangleMesh::of_box(box_on(DVec3::ZERO, DVec3::splat(edge_m)));
            Body::of_mesh(moved(&cube, &|corner| turn * corner)?)
        }
        IceShape::Box { size_m } => Body::of_box(box_on(base, DVec3::from(*size_m))),
        IceShape::Mesh { length_m, up, .. } => {
            let path = mesh.ok_or_else(|| Failure::Usage("the scene names no mesh".to_owned()))?;
            let mesh = read_mesh(path, MeshDetail::Shape).map_err(|error| failed(&error))?;
            let longest_m = mesh.bounds().size().max_element();
            let scale = length_m.map_or(1.0, |length_m| length_m / longest_m);
            let turn = up.to_y_up();
            Body::of_mesh(moved(&mesh, &|corner| scale * (turn * corner))?)
        }
        IceShape::Iceberg(iceberg) => {
            let mesh = iceberg.mesh().map_err(|error| failed(&error))?;
            Body::of_mesh(moved(&mesh, &|corner| corner)?)
        }
    };
    body.map_err(|error| failed(&error))
}

/// A box on the middle of its base.
fn box_on(base: DVec3, size: DVec3) -> Aabb {
    let half = DVec3::new(0.5 * size.x, 0.0, 0.5 * size.z);
    Aabb {
        min: base - half,
        max: base + half + DVec3::new(0.0, size.y, 0.0),
    }
}

fn light(scene: &IceScene, wavelengths: WavelengthGrid) -> Result<Light, Failure> {
    let orders = match scene.accuracy.sky_model() {
        SkyModel::None | SkyModel::SingleScattering => None,
        SkyModel::MultipleScattering => Some(ScatteringOrders::STANDARD),
    };
    let table = |air| {
        let request = AirRequest {
            air,
            wavelengths,
            ground: scene.ground_reflectance(),
            sun: &scene.sun,
            orders,
            suns: Suns::All,
        };
        request.table(&unwatched)
    };
    let air = scene.air.as_ref().map(table).transpose()?;
    let above_air = scene.sun.irradiance(&wavelengths);
    let sun_direction = scene.sun.direction();
    let sky = match (&scene.sky, &air) {
        (Some(sky), _) => {
            let share = sky.irradiance_share / PI;
            Sky::Uniform(above_air.iter().map(|sun| share * sun).collect())
        }
        (None, Some(air)) if scene.accuracy.sky_model() != SkyModel::None => {
            Sky::Map(sky_map(scene, air))
        }
        (None, _) => Sky::Uniform(vec![0.0; above_air.len()]),
    };
    let sun_irradiance = match &air {
        Some(air) => sun_irradiance_at(air, 0.0, sun_direction.y, SUN_RADIUS),
        None => above_air,
    };
    Ok(Light {
        sun_direction,
        sun_radius: SUN_RADIUS,
        sun_irradiance,
        sky,
    })
}

/// The sky over sea level: light scattered once, and that of further orders where the table has it.
fn sky_map(scene: &IceScene, air: &AtmosphereTable) -> SkyMap {
    let sun_elevation = Radians::from_degrees(scene.sun.elevation_deg);
    let observer = SkyObserver::from_elevation(0.0, sun_elevation);
    let sky = PreparedSky::new(air, observer, SkyMethod::STANDARD_DOME);
    // Without light of higher orders in the table one is enough.
    let diffuse = DiffuseDome::new(air, observer).ok();
    let sun_azimuth_rad = scene.sun.azimuth_deg.to_radians();
    SkyMap::new(SKY_NODES, air.wavelengths.len(), |direction, radiance| {
        let azimuth_rad = direction.x.atan2(-direction.z) - sun_azimuth_rad;
        let elevation = Radians(direction.y.clamp(ABOVE_HORIZON, 1.0).asin());
        let direction = SkyDirection::from_elevation(elevation, Radians(azimuth_rad));
        sky.write_radiance(direction, radiance);
        if let Some(diffuse) = &diffuse {
            diffuse.add_radiance(direction, radiance);
        }
        radiance.iter_mut().for_each(no_less_than_dark);
    })
}

fn is_dark(light: &Light) -> bool {
    let sun_is_down = light.sun_direction.y <= 0.0;
    let no_sun = sun_is_down || light.sun_irradiance.iter().all(|&value| value <= 0.0);
    let no_sky = light.sky_irradiance().iter().all(|&value| value <= 0.0);
    no_sun && no_sky
}
