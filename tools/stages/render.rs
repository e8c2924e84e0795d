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
use niji_exchange::AttributeValue;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_geometry::FisheyeMapping;
use niji_geometry::PixelRegion;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::solar_irradiance;
use niji_render::Input;
use niji_render::LitDrops;
use niji_render::MirroredLight;
use niji_render::RenderEffects;
use niji_render::RenderRequest;
use niji_render::Rendered;
use niji_render::SunPath;
use niji_render::Toggle;
use niji_scene::Camera;
use niji_scene::Effect;
use niji_scene::Levels;
use niji_scene::Picture;
use niji_scene::Projection;
use niji_scene::ScatteringNeed;
use niji_scene::Spectrum;
use niji_scene::Sun;
use niji_scene::WaterSurface;
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
use crate::stages::accuracy;
use crate::stages::given_table;
use crate::stages::perform;
use crate::stages::saved_rows;
use crate::stages::saved_rows::Saving;
use crate::stages::saved_rows::Work;
use crate::stages::sun_volume;
use crate::stages::sun_volume::Allowed;
use crate::stages::surfaces::Surfaces;
use crate::stages::tile::Tile;

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
    /// Largest error of a pixel, relative to the reference luminance, where one is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// How the preview is shown.
    pub picture: Picture,
    /// Water that lights the drops too, where it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub water_surface: Option<WaterSurface>,
    /// The same, and what of its light is followed.
    #[serde(skip)]
    pub mirrored_water: Option<(WaterSurface, MirroredLight)>,
    /// What is simulated, as the renderer takes it.
    #[serde(skip)]
    pub render_effects: RenderEffects,
    /// What a tolerance is relative to [cd/m²].
    #[serde(skip)]
    pub reference_luminance_cd_m2: f64,
    /// What the scattering table has to hold.
    #[serde(skip)]
    pub scattering: Option<ScatteringNeed>,
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
        let mirrored_water = scene.water_surface.zip(plan.mirrored_light());
        Self {
            camera: scene.camera,
            sun: scene.sun,
            spectrum: scene.spectrum,
            effects: on.map(Effect::name).collect(),
            levels: plan.levels,
            tolerance: planned.tolerance_for_rays(),
            picture: scene.picture,
            water_surface: mirrored_water.map(|(surface, _)| surface),
            mirrored_water,
            render_effects,
            reference_luminance_cd_m2: plan.reference_luminance_cd_m2,
            scattering: plan.scattering.clone(),
        }
    }

    /// All pixels of the picture, overscan included.
    ///
    /// # Errors
    /// Never for a scene that was read from a file.
    pub(crate) fn whole(&self) -> Result<PixelRegion, Failure> {
        let region = self.camera.region();
        region.map_err(|error| Failure::Usage(error.to_string()))
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
    pub surfaces: &'a Surfaces,
}

/// An image to be made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target<'a> {
    /// Its file.
    pub path: &'a Path,
    /// The pixels that it shall hold.
    pub region: PixelRegion,
}

/// The plain image and the preview beside a spectral image.
#[must_use]
pub(crate) fn companions(image: &Path) -> [PathBuf; 2] {
    [image.with_extension("rgb.exr"), image.with_extension("png")]
}

/// Renders a picture or a tile: the spectral image, the plain one and the preview.
///
/// # Errors
/// Inputs that are missing, damaged or contradict each other, an output that exists, or a file that
/// cannot be written.
pub(crate) fn make(
    settings: &Settings,
    inputs: Inputs,
    target: Target,
    manner: Manner,
) -> Result<Done, Failure> {
    let mut files = vec![("drops", inputs.drops)];
    files.extend(inputs.table.map(|path| ("table", path)));
    files.extend(inputs.air.map(|path| ("air", path)));
    files.extend(inputs.surfaces.inputs());
    let [plain, preview] = companions(target.path);
    let outputs = vec![target.path, &plain, &preview];
    let region = target.region;
    let whole = settings.whole()?;
    let text = inputs.surfaces.settings(settings);
    let request = Request {
        stage: "render",
        settings: Tile { region, whole }.settings(&text),
        inputs: files,
        outputs,
    };
    let done = perform(&request, manner, |provenance| {
        let image = picture(settings, inputs, target, (provenance, manner.verbosity))?;
        write(&image, &settings.picture, target.path)
    })?;
    saved_rows::clear(target.path);
    Ok(done)
}

/// Writes an image, the plain one and the preview.
///
/// # Errors
/// A file that cannot be written.
pub(crate) fn write(image: &SpectralImage, shown: &Picture, to: &Path) -> Result<(), Failure> {
    let [plain, preview] = companions(to);
    output::write_file(&preview, |writer| {
        image.write_png(writer, shown.exposure_ev)
    })?;
    output::write_file(&plain, |writer| {
        image.write_rgb_exr(shown.primaries.into(), writer)
    })?;
    output::write_file(to, |writer| image.write_spectral(writer))
}

fn picture(
    settings: &Settings,
    inputs: Inputs,
    target: Target,
    (provenance, verbosity): (Provenance, Verbosity),
) -> Result<SpectralImage, Failure> {
    let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
    let camera = settings.camera.camera().map_err(|error| usage(&error))?;
    let wavelengths = settings.spectrum.grid().map_err(|error| usage(&error))?;
    // First, as nothing takes more memory than drops beside their bricks.
    let drops = lit_drops(settings, inputs.drops)?;
    let need = settings.scattering.as_ref();
    let table = inputs.table.zip(need).map(|(path, need)| {
        let table = given_table::read(path, need, wavelengths)?;
        Ok(given_table::as_needed(table, need))
    });
    let table: Option<ScatteringTable> = table.transpose()?;
    let air: Option<AtmosphereTable> = inputs.air.map(stages::atmosphere::read).transpose()?;
    let surfaces = inputs.surfaces.read(settings.camera)?;
    let sun_irradiance = settings.sun.irradiance(&wavelengths);
    let bar = progress::bar("render", target.region.n_pixels(), verbosity);
    let work = Work {
        request: RenderRequest {
            camera: &camera,
            region: target.region,
            sun_direction: settings.sun.direction(),
            wavelengths,
            sun_irradiance: &sun_irradiance,
            drops: &drops,
            table: table.as_ref(),
            air: air.as_ref(),
            surfaces: surfaces.as_ref(),
            effects: settings.render_effects,
            levels: settings.levels.render_levels(),
            tolerance_cd_m2: settings
                .tolerance
                .map(|tolerance| tolerance * settings.reference_luminance_cd_m2),
        },
        provenance,
        image: &|rendered, region, provenance| {
            image(rendered, &camera, wavelengths, (region, provenance))
        },
        progress: &|n_pixels| bar.inc(n_pixels),
    };
    let image = saved_rows::render(&work, target.path, Saving::STANDARD);
    bar.finish_and_clear();
    image.map_err(|error| refusal(&error, inputs))
}

/// A picture that was refused, said of the file that contradicts the scene.
fn refusal(error: &niji_render::Error, inputs: Inputs) -> Failure {
    let of_table = |path: Option<&Path>, maker: &str| {
        let path = path.unwrap_or(inputs.drops);
        let anew = format!("make it anew with `niji {maker}` for this scene and accuracy");
        Failure::bad_input(path, format!("{error}: {anew}"))
    };
    match (error.input(), error, &inputs.surfaces.depth) {
        (Some(Input::ScatteringTable), _, _) => of_table(inputs.table, "scatter"),
        (Some(Input::AtmosphereTable | Input::DiffuseLight), _, _) => {
            of_table(inputs.air, "atmosphere")
        }
        (None, niji_render::Error::SurfaceShape { .. }, Some(depth)) => {
            Failure::bad_input(&depth.path, error)
        }
        (None, niji_render::Error::Memory { .. }, _) => {
            Failure::Failed(format!("{error} (`niji render --tiles` or `--region`)"))
        }
        (None, _, _) => Failure::bad_input(inputs.table.unwrap_or(inputs.drops), error),
    }
}

/// What was rendered of a region, as an image with a provenance.
fn image(
    rendered: Rendered,
    camera: &niji_geometry::Camera,
    wavelengths: WavelengthGrid,
    (region, provenance): (PixelRegion, Provenance),
) -> SpectralImage {
    let world_to_camera = camera.world_to_camera().to_cols_array();
    SpectralImage {
        wavelengths,
        aovs: aovs(&rendered),
        radiance: rendered.radiance,
        windows: ImageWindows {
            data: region,
            display: PixelRegion::frame(camera.width_px(), camera.height_px()),
        },
        white_luminance_cd_m2: white_luminance_cd_m2(&wavelengths),
        // f32 is what the attribute holds.
        world_to_camera: Some(world_to_camera.map(|value| value as f32)),
        attributes: projection_attributes(camera),
        provenance,
    }
}

/// What a reader of a picture needs to know of its projection beside `worldToCamera`; nothing for a
/// pinhole, which every reader takes for granted.
fn projection_attributes(camera: &niji_geometry::Camera) -> Attributes {
    let named = |name: &str| {
        let projection = AttributeValue::Text(name.to_owned());
        ("niji:projection".to_owned(), projection)
    };
    match camera {
        niji_geometry::Camera::Pinhole(_) => Attributes::new(),
        niji_geometry::Camera::Fisheye(fisheye) => {
            let name = match fisheye.mapping() {
                FisheyeMapping::Equidistant => Projection::FisheyeEquidistant.name(),
                FisheyeMapping::Equisolid => Projection::FisheyeEquisolid.name(),
            };
            let focal_px = AttributeValue::Number(fisheye.focal_length_px());
            Attributes::from([named(name), ("niji:focalLengthPx".to_owned(), focal_px)])
        }
        niji_geometry::Camera::Panorama(_) => {
            Attributes::from([named(Projection::Panorama.name())])
        }
    }
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
    // A mode is given back as soon as its bricks stand.
    let bricks = volume
        .modes
        .into_iter()
        .map(|mode| Bricks::build(&mode, interpolation));
    let bricks = bricks.collect::<Result<Vec<_>, _>>();
    let bricks = bricks.map_err(|error| Failure::bad_input(path, error))?;
    let sun_path = if settings.render_effects.drop_shadow.is_on() {
        settings.levels.sun_path
    } else {
        SunPath::Ignore
    };
    let water = settings.mirrored_water;
    let allowed = settings.tolerance.map(|tolerance| Allowed {
        tolerance,
        efficiency: settings.levels.drop_extinction.efficiency(),
    });
    let sun_direction = settings.sun.direction();
    let lit = sun_volume::lit(bricks, sun_direction, sun_path, allowed);
    let lit = lit.and_then(|drops| match water {
        Some((surface, light)) => drops.beside_water(surface.surface(), light, sun_direction),
        None => Ok(drops),
    });
    lit.map_err(|error| Failure::bad_input(path, error))
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
    let multiple = rendered.bow_multiple.iter();
    aovs.extend(multiple.map(|light| xyz("bow.multiple", light)));
    let reflected = rendered.bow_reflected.iter();
    aovs.extend(reflected.map(|light| xyz("bow.reflected", light)));
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
    aovs.push(error_aov(rendered));
    aovs
}

/// The estimated error, and what it is made of.
fn error_aov(rendered: &Rendered) -> Aov {
    let parts = rendered.error_parts.named().into_iter();
    let total = [(accuracy::TOTAL, &rendered.error)].into_iter();
    let channels = total.chain(parts);
    Aov {
        name: accuracy::AOV.to_owned(),
        unit: "cd/m^2".to_owned(),
        channels: channels
            .map(|(name, plane)| (name.to_owned(), plane.clone()))
            .collect(),
    }
}
