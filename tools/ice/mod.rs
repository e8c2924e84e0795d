//! `niji ice`: the picture of a scene of ice.

mod world;

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use ndarray::Array2;
use niji_exchange::Aov;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_ice::IcePicture;
use niji_scene::IceAccuracy;
use niji_scene::IceScene;
use niji_scene::IceShape;
use niji_scene::canonical_json;

use crate::failure::Failure;
use crate::flags::Common;
use crate::progress;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::stages::render::companions;
use crate::text_file;
use niji_picture::white_luminance_cd_m2;

pub(crate) use world::World;

/// Follow light through ice (EXR, PNG).
///
/// Writes the spectral image with its AOVs, *.layers.exr for compositors and a PNG preview beside it. Exit code 5
/// if the scene's paths did not reach the tolerance; the picture is written then.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji ice data/scenes/ice-cube-50-m.toml -o cube.exr
  niji ice data/scenes/ice-iceberg-sun-10.toml --accuracy draft -o iceberg.exr")]
pub(crate) struct IceCommand {
    /// The scene of ice.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The spectral image to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// Renders the picture.
///
/// # Errors
/// A scene or a mesh that is missing or wrong, an output that exists or cannot be written, or a
/// tolerance that was not reached.
pub(crate) fn execute(command: &IceCommand, common: &Common) -> Result<(), Failure> {
    let scene = read(&command.scene, common)?;
    let folder = command.scene.parent().unwrap_or(Path::new(""));
    make(&scene, folder, &command.output, common.options())
}

/// Reads a scene of ice, with the accuracy asked for on the command line.
fn read(path: &Path, common: &Common) -> Result<IceScene, Failure> {
    let text = text_file::read(path)?;
    let mut scene = IceScene::from_toml(&text).map_err(|error| Failure::bad_input(path, error))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    common.sandbox()?.check(&scene.files(), folder)?;
    if let Some(preset) = common.accuracy {
        scene.accuracy.transport = IceAccuracy::transport_of(preset);
    }
    if let Some(spectral) = common.spectral {
        scene.picture.spectral = spectral;
    }
    if common.tolerance.is_some() {
        scene.accuracy.tolerance = common.tolerance;
    }
    Ok(scene)
}

fn make(scene: &IceScene, folder: &Path, to: &Path, options: StageOptions) -> Result<(), Failure> {
    let mesh = match &scene.ice.shape {
        IceShape::Mesh { file, .. } => Some(folder.join(file)),
        IceShape::Cube { .. } | IceShape::Box { .. } | IceShape::Iceberg(_) => None,
    };
    let [plain, preview] = companions(to);
    let request = Request {
        stage: "ice",
        settings: canonical_json(scene),
        inputs: mesh.iter().map(|path| ("mesh", path.as_path())).collect(),
        outputs: vec![to, &plain, &preview],
    };
    let mut reached = Ok(());
    perform(&request, options, |provenance| {
        let world = World::new(scene, mesh.as_deref())?;
        let tolerance_cd_m2 = tolerance_cd_m2(scene, &world);
        let picture = draw(scene, &world, options.verbosity)?;
        reached = check_tolerance(&picture, tolerance_cd_m2);
        let image = image(&world, picture, provenance);
        let image = image.keeping(scene.picture.spectral.into());
        stages::render::write(&image, &scene.picture, to)
    })?;
    reached
}

fn draw(scene: &IceScene, world: &World, verbosity: Verbosity) -> Result<IcePicture, Failure> {
    let (width, height) = (world.camera.width_px(), world.camera.height_px());
    let bar = progress::bar("ice", u64::from(width) * u64::from(height), verbosity);
    let tolerance = tolerance_cd_m2(scene, world);
    let picture = world.render(scene.accuracy, tolerance, &|n_pixels| bar.inc(n_pixels));
    bar.finish_and_clear();
    picture
}

fn tolerance_cd_m2(scene: &IceScene, world: &World) -> Option<f64> {
    let white_cd_m2 = white_luminance_cd_m2(&world.wavelengths);
    scene.accuracy.tolerance.map(|part| part * white_cd_m2)
}

/// Refuses a picture whose error, RMS over its pixels, is above the tolerance.
fn check_tolerance(picture: &IcePicture, tolerance_cd_m2: Option<f64>) -> Result<(), Failure> {
    let Some(tolerance) = tolerance_cd_m2 else {
        return Ok(());
    };
    let squares: f64 = picture
        .error
        .iter()
        .map(|&error| f64::from(error).powi(2))
        .sum();
    let rms = (squares / picture.error.len() as f64).sqrt();
    if rms <= tolerance {
        return Ok(());
    }
    Err(Failure::AccuracyNotReached(format!(
        "the picture is written, but its error is {:.1} times the tolerance: it needs more \
         paths_per_pixel",
        rms / tolerance
    )))
}

fn image(world: &World, picture: IcePicture, provenance: Provenance) -> SpectralImage {
    let plane = |name: &str, [channel, unit]: [&str; 2], values: Array2<f32>| Aov {
        name: name.to_owned(),
        unit: unit.to_owned(),
        channels: vec![(channel.to_owned(), values)],
    };
    let world_to_camera = world.camera.world_to_camera().to_cols_array();
    let (_, height, width) = picture.radiance.dim();
    SpectralImage {
        wavelengths: world.wavelengths,
        radiance: picture.radiance,
        spectra: Spectra::Full,
        windows: ImageWindows::whole(width, height),
        aovs: vec![
            plane("error", ["Y", "cd/m^2"], picture.error),
            plane("depth", ["Z", "m"], picture.depth),
            plane("paths", ["Y", "-"], picture.n_paths),
        ],
        white_luminance_cd_m2: white_luminance_cd_m2(&world.wavelengths),
        // f32 is what the attribute holds.
        world_to_camera: Some(world_to_camera.map(|value| value as f32)),
        attributes: Attributes::new(),
        provenance,
    }
}
