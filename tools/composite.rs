//! `niji composite`: a rendered bow set into a photograph.

use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_photo::AddedLight;
use niji_photo::Exposure;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::card_value;
use niji_photo::composite;
use niji_photo::distance_of_light;
use niji_photo::read_depth_map;
use niji_photo::scale_to_white;
use niji_photo::surface_of_light;
use niji_photo::write_jpeg;
use niji_photo::write_png;
use niji_photo::write_premultiplied;
use serde_json::json;

use crate::cli::Common;
use crate::failure::Failure;
use crate::output;
use crate::progress::Verbosity;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::Request;
use crate::stages::perform;

/// Set a rendered bow into a photograph (EXR, PNG, JPEG).
///
/// In linear light: photograph x transmittance + bow + veil. The image of `niji render` gives bow,
/// veil and transmittance; it may be smaller than the photograph, in the same shape. A name ending
/// in .exr writes the premultiplied bow alone for compositors, and the picture as PNG beside it; .png
/// and .jpg write the picture.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji composite data/photos/pavilion.jpg --image out/image.exr -o bow-in-photo.png
  niji composite plate.exr --image out/image.exr --depth depth.exr --exposure 0.8 -o bow.exr

With --depth, light that niji render integrated up to the same surfaces is sharp at their edges, however
small the image is; of an image rendered without them a bow whose mean distance is beyond the surface is
hidden: all light of a pixel is taken to come from one distance.")]
pub(crate) struct CompositeCommand {
    /// The photograph (PNG, JPEG) or plate (EXR, linear Rec.709).
    photo: PathBuf,
    /// The spectral image of `niji render`.
    #[arg(long, value_name = "EXR")]
    image: PathBuf,
    /// Distances of the photographed surfaces (`niji depth`), which hide the bow behind them.
    #[arg(long, value_name = "EXR")]
    depth: Option<PathBuf>,
    /// Value of a sunlit white card in the photograph, linear: `match` takes the mean of the picture
    /// for grey, `camera` the f-number, time and speed in EXIF, a number is taken as it is.
    #[arg(long, value_name = "match|camera|VALUE", default_value = "match", value_parser = exposure)]
    exposure: ExposureChoice,
    /// The published rule for what is too bright: scale all channels so that the largest is white.
    #[arg(long)]
    published: bool,
    /// The picture to write: .exr, .png or .jpg.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

/// The exposure by its name on the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ExposureChoice {
    Match,
    Camera,
    Value(f64),
}

/// Kind of a picture by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Exr,
    Png,
    Jpeg,
}

/// Composites.
///
/// # Errors
/// As [`make`].
pub(crate) fn execute(command: &CompositeCommand, common: &Common) -> Result<(), Failure> {
    make(command, common.manner()).map(|_| ())
}

/// Composites, or keeps a picture that fits.
///
/// # Errors
/// Inputs that are missing, damaged or of other shapes, an output that exists or cannot be written.
pub(crate) fn make(command: &CompositeCommand, manner: Manner) -> Result<Done, Failure> {
    let kind = kind(&command.output)?;
    let beside = command.output.with_extension("png");
    let mut outputs: Vec<&Path> = vec![&command.output];
    if kind == Kind::Exr {
        outputs.push(&beside);
    }
    let mut inputs = vec![
        ("photo", command.photo.as_path()),
        ("image", command.image.as_path()),
    ];
    inputs.extend(command.depth.iter().map(|path| ("depth", path.as_path())));
    let job = Request {
        stage: "composite",
        settings: settings(command),
        inputs,
        outputs,
    };
    perform(&job, manner, |provenance| {
        let result = picture(command)?;
        if manner.verbosity > Verbosity::Quiet {
            eprintln!(
                "  composite  a sunlit white card has the value {:.4} in the photograph",
                result.gain
            );
        }
        write(&result, kind, (&command.output, &beside), &provenance)
    })
}

/// The picture and what it is made of.
struct Composite {
    picture: LinearPicture,
    added: AddedLight,
    gain: f64,
}

fn picture(command: &CompositeCommand) -> Result<Composite, Failure> {
    let photo = Photograph::read(&command.photo)
        .map_err(|error| Failure::bad_input(&command.photo, error))?;
    let image = SpectralImage::read_spectral(&command.image)
        .map_err(|error| Failure::bad_input(&command.image, error))?;
    let of_image = |error: niji_photo::Error| Failure::bad_input(&command.image, error);
    let size = photo.light.dim();
    let light = AddedLight::of_image(&image).map_err(of_image)?;
    let added = match &command.depth {
        Some(path) => before_surfaces(light, &image, (&command.image, path))?,
        None => light.resized(size).map_err(of_image)?,
    };
    let exposure = match command.exposure {
        ExposureChoice::Match => Exposure::GreyWorld,
        ExposureChoice::Camera => Exposure::Camera {
            card_cd_m2: image.white_luminance_cd_m2,
        },
        ExposureChoice::Value(value) => Exposure::Card(value),
    };
    drop(image);
    let gain = card_value(exposure, &photo.light, &photo.notes)
        .map_err(|error| Failure::bad_input(&command.photo, error))?;
    let mut picture = composite(&photo.light, &added, gain).map_err(of_image)?;
    if command.published {
        scale_to_white(&mut picture);
    }
    Ok(Composite {
        picture,
        added,
        gain,
    })
}

/// The light in front of the photographed surfaces: integrated up to them, or hidden as a whole.
fn before_surfaces(
    light: AddedLight,
    image: &SpectralImage,
    (image_path, depth_path): (&Path, &Path),
) -> Result<AddedLight, Failure> {
    let of_image = |error: niji_photo::Error| Failure::bad_input(image_path, error);
    let of_depth = |error: niji_photo::Error| Failure::bad_input(depth_path, error);
    let surface_m = read_depth_map(depth_path).map_err(of_depth)?;
    if let Some(ends_m) = surface_of_light(image) {
        return light.at_surfaces(ends_m, &surface_m).map_err(of_depth);
    }
    let mut added = light.resized(surface_m.dim()).map_err(of_image)?;
    let light_m = distance_of_light(image).map_err(of_image)?;
    added.hide_behind(&surface_m, light_m).map_err(of_depth)?;
    Ok(added)
}

fn write(
    result: &Composite,
    kind: Kind,
    (main, beside): (&Path, &Path),
    provenance: &Provenance,
) -> Result<(), Failure> {
    match kind {
        Kind::Png => output::write_file(main, |to| write_png(&result.picture, provenance, to)),
        Kind::Jpeg => output::write_file(main, |to| write_jpeg(&result.picture, to)),
        Kind::Exr => {
            output::write_file(beside, |to| write_png(&result.picture, provenance, to))?;
            // f32: what the file holds.
            let gain = result.gain as f32;
            let light = result
                .added
                .light
                .mapv(|pixel| pixel.map(|value| gain * value));
            let alpha = result.added.transmittance.mapv(|t| 1.0 - t);
            output::write_file(main, |to| {
                write_premultiplied(&light, &alpha, provenance, to)
            })
        }
    }
}

fn settings(command: &CompositeCommand) -> String {
    let exposure = match command.exposure {
        ExposureChoice::Match => json!("match"),
        ExposureChoice::Camera => json!("camera"),
        ExposureChoice::Value(value) => json!(value),
    };
    json!({ "exposure": exposure, "published": command.published }).to_string()
}

fn exposure(text: &str) -> Result<ExposureChoice, String> {
    match text {
        "match" => Ok(ExposureChoice::Match),
        "camera" => Ok(ExposureChoice::Camera),
        _ => match text.parse() {
            Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(ExposureChoice::Value(value)),
            _ => Err(format!(
                "found {text:?}, expected match, camera or a number above 0"
            )),
        },
    }
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    let extension = path.extension().and_then(|extension| extension.to_str());
    match extension.map(str::to_ascii_lowercase).as_deref() {
        Some("exr") => Ok(Kind::Exr),
        Some("png") => Ok(Kind::Png),
        Some("jpg" | "jpeg") => Ok(Kind::Jpeg),
        _ => Err(Failure::Usage(format!(
            "{}: expected a name that ends in .exr, .png or .jpg",
            path.display()
        ))),
    }
}
