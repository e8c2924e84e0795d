//! The stage `render`: drops, scattering and air become a picture.

use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use ndarray::Array3;
use ndarray::Axis;
use niji_dropfield::Bricks;
use niji_dropfield::Interpolation;
use niji_exchange::Aov;
use niji_exchange::AtmosphereTable;
use niji_exchange::Attributes;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_photo::DepthAlong;
use niji_photo::DepthKind;
use niji_photo::depth_from_values;
use niji_photo::read_depth_map;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::LitDrops;
use niji_render::RenderEffects;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_render::render;
use niji_scene::Along;
use niji_scene::Camera;
use niji_scene::Effect;
use niji_scene::Levels;
use niji_scene::Picture;
use niji_scene::Scene;
use niji_scene::Spectrum;
use niji_scene::Sun;
use niji_scene::canonical_json;
use serde::Serialize;

use crate::failure::Failure;
use crate::output;
use crate::progress;
use crate::progress::Verbosity;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::Request;
use crate::stages::perform;

/// Name of the spectral image in the folder of a run.
pub(crate) const FILE: &str = "image.exr";

/// What files hold for the distance of the sky (m).
const NO_SURFACE_M: f32 = 1e10;

/// What a picture depends on besides its input files.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Settings {
    /// The eye.
    pub camera: Camera,
    /// The light.
    pub sun: Sun,
    /// The wavelengths.
    pub spectrum: Spectrum,
    /// What is simulated, by name.
    pub effects: Vec<&'static str>,
    /// How accurately.
    pub levels: Levels,
    /// How the preview is shown.
    pub picture: Picture,
    /// What is simulated, as the renderer takes it.
    #[serde(skip)]
    pub render_effects: RenderEffects,
}

impl Settings {
    /// What the plan of a scene says.
    #[must_use]
    pub(crate) fn of(planned: &Planned) -> Self {
        let (scene, plan) = (&planned.scene, &planned.plan);
        let on = Effect::ALL.into_iter().filter(|effect| plan.is_on(*effect));
        let mut render_effects = plan.render_effects();
        // The level that ignores the sun's path is the shadow left out.
        if plan.sun_path() == SunPath::Ignore {
            render_effects.drop_shadow = Toggle::Off;
        }
        Self {
            camera: scene.camera,
            sun: scene.sun,
            spectrum: scene.spectrum,
            effects: on.map(Effect::name).collect(),
            levels: plan.levels,
            picture: scene.picture,
            render_effects,
        }
    }
}

/// The files that a picture is made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Inputs<'a> {
    /// The drop volume.
    pub drops: &'a Path,
    /// The scattering table, where a bow is on.
    pub table: Option<&'a Path>,
    /// The air, where an effect of the air is on.
    pub air: Option<&'a Path>,
    /// Surfaces that hide what is behind them.
    pub surfaces: Option<&'a Surfaces>,
}

/// A depth map, and what it is measured along.
#[derive(Clone, Debug)]
pub(crate) struct Surfaces {
    /// The file.
    pub path: PathBuf,
    /// The view ray, or the optical axis.
    pub along: Along,
}

/// The surfaces that a scene names, relative to its file.
#[must_use]
pub(crate) fn scene_surfaces(scene: &Scene, scene_file: &Path) -> Option<Surfaces> {
    let folder = scene_file.parent().unwrap_or(Path::new(""));
    scene.occluders.as_ref().map(|occluders| Surfaces {
        path: folder.join(&occluders.depth),
        along: occluders.along,
    })
}

/// The plain image and the preview beside a spectral image.
#[must_use]
pub(crate) fn companions(image: &Path) -> [PathBuf; 2] {
    [image.with_extension("rgb.exr"), image.with_extension("png")]
}

/// Renders a picture: the spectral image, the plain one and the preview.
///
/// # Errors
/// Inputs that are missing, damaged or contradict each other, an output that exists, or a file that
/// cannot be written.
pub(crate) fn make(
    settings: &Settings,
    inputs: Inputs,
    to: &Path,
    manner: Manner,
) -> Result<Done, Failure> {
    let mut files = vec![("drops", inputs.drops)];
    files.extend(inputs.table.map(|path| ("table", path)));
    files.extend(inputs.air.map(|path| ("air", path)));
    files.extend(inputs.surfaces.map(|surfaces| ("depth", &*surfaces.path)));
    let [plain, preview] = companions(to);
    let outputs = vec![to, &plain, &preview];
    let text = match inputs.surfaces.map(|surfaces| surfaces.along) {
        // As it was before there were surfaces, so that files made then still fit.
        None | Some(Along::Ray) => canonical_json(settings),
        Some(Along::Axis) => canonical_json(&(settings, Along::Axis)),
    };
    let request = Request {
        stage: "render",
        settings: text,
        inputs: files,
        outputs,
    };
    perform(&request, manner, |provenance| {
        let image = picture(settings, inputs, provenance, manner.verbosity)?;
        let exposure_ev = settings.picture.exposure_ev;
        output::write_file(&preview, |writer| image.write_png(writer, exposure_ev))?;
        output::write_file(&plain, |writer| image.write_rgb_exr(writer))?;
        output::write_file(to, |writer| image.write_spectral(writer))
    })
}

fn picture(
    settings: &Settings,
    inputs: Inputs,
    provenance: Provenance,
    verbosity: Verbosity,
) -> Result<SpectralImage, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
    let camera = settings.camera.pinhole().map_err(|error| usage(&error))?;
    let wavelengths = settings.spectrum.grid().map_err(|error| usage(&error))?;
    let table: Option<ScatteringTable> = inputs.table.map(stages::scatter::read).transpose()?;
    let air: Option<AtmosphereTable> = inputs.air.map(stages::atmosphere::read).transpose()?;
    let drops = lit_drops(settings, inputs.drops)?;
    let surfaces = inputs
        .surfaces
        .map(|surfaces| read_surfaces(surfaces, settings.camera));
    let surfaces = surfaces.transpose()?;
    let scale = settings.sun.irradiance_scale();
    let sun_irradiance: Vec<f64> = solar_irradiance(&wavelengths)
        .into_iter()
        .map(|irradiance| scale * irradiance)
        .collect();
    let bar = progress::bar(
        "render",
        u64::from(camera.width_px()) * u64::from(camera.height_px()),
        verbosity,
    );
    let rendered = render(
        &RenderRequest {
            camera: &camera,
            sun_direction: settings.sun.direction(),
            wavelengths,
            sun_irradiance: &sun_irradiance,
            drops: &drops,
            table: table.as_ref(),
            air: air.as_ref(),
            surfaces: surfaces.as_ref(),
            effects: settings.render_effects,
            levels: settings.levels.render_levels(),
        },
        &|n_pixels| bar.inc(n_pixels),
    );
    bar.finish_and_clear();
    // What contradicts here are the files: a table without the angles or sizes that the drops need,
    // or a depth map of another shape.
    let rendered = rendered.map_err(|error| match (&error, inputs.surfaces) {
        (niji_render::Error::SurfaceShape { .. }, Some(surfaces)) => {
            Failure::bad_input(&surfaces.path, error)
        }
        (_, _) => Failure::bad_input(inputs.table.unwrap_or(inputs.drops), error),
    })?;
    let white_luminance_cd_m2 = white_luminance_cd_m2(&wavelengths);
    let world_to_camera = camera.world_to_camera().to_cols_array();
    Ok(SpectralImage {
        wavelengths,
        aovs: aovs(&rendered),
        radiance: rendered.radiance,
        white_luminance_cd_m2,
        // f32 is what the attribute holds.
        world_to_camera: Some(world_to_camera.map(|value| value as f32)),
        attributes: Attributes::new(),
        provenance,
    })
}

/// Luminance of a white card that faces the sun above the air.
pub(crate) fn white_luminance_cd_m2(wavelengths: &WavelengthGrid) -> f64 {
    let radiance: Vec<f64> = solar_irradiance(wavelengths)
        .iter()
        .map(|value| value / std::f64::consts::PI)
        .collect();
    Colorimetry::new(wavelengths).xyz(&radiance)[1]
}

fn lit_drops(settings: &Settings, path: &Path) -> Result<LitDrops, Failure> {
    let volume = stages::drops::read(path)?;
    let interpolation: Interpolation = settings.levels.interpolation;
    let bricks = volume
        .modes
        .iter()
        .map(|mode| Bricks::build(mode, interpolation));
    let bricks = bricks.collect::<Result<Vec<_>, _>>();
    let bricks = bricks.map_err(|error| Failure::bad_input(path, error))?;
    let sun_path = if settings.render_effects.drop_shadow.is_on() {
        settings.levels.sun_path
    } else {
        SunPath::Ignore
    };
    LitDrops::new(bricks, settings.sun.direction(), sun_path)
        .map_err(|error| Failure::bad_input(path, error))
}

/// Reads surfaces as distances along the rays of a camera.
fn read_surfaces(surfaces: &Surfaces, camera: Camera) -> Result<niji_render::Surfaces, Failure> {
    let bad = |error: &dyn std::fmt::Display| Failure::bad_input(&surfaces.path, error);
    let mut distance_m = read_depth_map(&surfaces.path).map_err(|error| bad(&error))?;
    if surfaces.along == Along::Axis {
        let (height, width) = distance_m.dim();
        // The same view in the pixels of the map.
        let of_map = Camera {
            width_px: width as u32,
            height_px: height as u32,
            ..camera
        };
        let pinhole = of_map.pinhole().map_err(|error| bad(&error))?;
        distance_m = depth_from_values(&distance_m, &DepthKind::Metres, DepthAlong::Axis, &pinhole)
            .map_err(|error| bad(&error))?;
    }
    niji_render::Surfaces::new(distance_m).map_err(|error| bad(&error))
}

fn aovs(rendered: &Rendered) -> Vec<Aov> {
    let xyz = |name: &str, values: &Array3<f32>| {
        let planes = values.axis_iter(Axis(0)).map(|plane| plane.to_owned());
        let channels = ["X", "Y", "Z"]
            .into_iter()
            .map(str::to_owned)
            .zip(planes)
            .collect();
        Aov {
            name: name.to_owned(),
            unit: "cd/m^2".to_owned(),
            channels,
        }
    };
    let plane = |name: &str, [channel, unit]: [&str; 2], values: &Array2<f32>| Aov {
        name: name.to_owned(),
        unit: unit.to_owned(),
        channels: vec![(channel.to_owned(), values.clone())],
    };
    let mut aovs = vec![
        xyz("bow.primary", &rendered.bow_primary),
        xyz("bow.secondary", &rendered.bow_secondary),
        xyz("inscatter", &rendered.inscatter),
    ];
    aovs.extend(rendered.skylit.iter().map(|light| xyz("skylit", light)));
    aovs.extend([
        plane("transmittance", ["Y", "-"], &rendered.transmittance),
        plane("tau_sun", ["Y", "-"], &rendered.tau_sun),
        plane("depth", ["Z", "m"], &rendered.depth),
    ]);
    aovs.extend(rendered.surface.iter().map(|surface| {
        let finite = surface.mapv(|distance| distance.min(NO_SURFACE_M));
        plane("surface", ["Z", "m"], &finite)
    }));
    aovs.push(plane("error", ["Y", "cd/m^2"], &rendered.error));
    aovs
}
