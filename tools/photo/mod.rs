//! `niji photo`: a bow set into a photograph with one command, by a scene that is written for it.

mod beside;
mod foreground;
mod scene_text;
mod seen;
mod wanted;

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use ndarray::Array2;
use niji_photo::Photograph;
use niji_photo::Profile;
use niji_photo::SURE_OF_SKY;
use niji_photo::find_sky;
use niji_photo::layers_to_toml;
use niji_photo::read_labels;
use niji_photo::upsample_labels;
use niji_photo::write_labels;

use crate::check::place;
use crate::checksums;
use crate::failure::Failure;
use crate::flags;
use crate::flags::Common;
use crate::output;
use crate::output::Existing;
use crate::photo::foreground::foreground;
use crate::photo::scene_text::Rain;
use crate::photo::scene_text::SceneText;
use crate::photo::wanted::WantedBow;
use crate::run;
use crate::run::RunCommand;
use crate::shell_word::quoted;
use crate::stages;
use crate::sun::camera_flags::CameraFlags;
use crate::sun::camera_flags::point;

/// Names of the files that are written beside those of `niji run`.
const SCENE: &str = "photo.toml";
const SKY: &str = "sky.png";
const LAYERS: &str = "photo.layers.toml";
const LABELS: &str = "photo.labels.png";
/// What a mask is noted as made for that nobody has corrected yet.
const DRAFT: &str = "what could be a sky";

/// Set a bow into a photograph: find its sky, write a scene for it, and run that.
///
/// Say where the bow should stand: its top (--apex), two or three of its points (--bow), the sun (--sun), or place and
/// time. Points count in pixels from the top left corner of the upright picture. The scene, photo.toml, and the layers
/// beside it are proposals to be edited: `niji run DIR/photo.toml -o DIR` goes on from them.
#[derive(Debug, Args)]
#[command(
    group(clap::ArgGroup::new("wanted").required(true).args(["apex", "bow", "sun", "place"])),
    after_help = "Examples:
  niji photo data/photos/pavilion.jpg --apex 400,45 --fov-deg 60 -o bow
  niji photo photo.jpg --bow 412,900 --bow 1800,300 --bow 3100,880 -o bow
  niji photo photo.jpg --sun 185,27 --rain 8 --horizon 0,1510 --horizon 4000,1530 -o bow
  niji photo photo.jpg --place 48.1,11.6 --time 2026-06-21T19:30:00+02:00 --azimuth-deg 110 -o bow
  niji photo photo.jpg --apex 400,45 --sky mask.png -o bow

Leaves photo.toml (the scene), sky.png (the sky, white), photo.layers.toml and photo.labels.png (distances, to be
corrected), and what `niji run` leaves of a photograph: composite.png, image.exr, depth.exr, check.json and so on."
)]
pub(crate) struct PhotoCommand {
    /// The photograph (PNG, JPEG).
    photo: PathBuf,
    /// The top of the bow.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    apex: Option<[f64; 2]>,
    /// A point of the bow; give two or three.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    bow: Vec<[f64; 2]>,
    /// Azimuth, clockwise from north, and elevation of the sun in degrees.
    #[arg(long, value_name = "AZ,ELEV", value_parser = sun, allow_hyphen_values = true)]
    sun: Option<[f64; 2]>,
    /// Latitude and longitude in degrees, north and east positive; with --time the sun follows.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true, requires = "time")]
    place: Option<[f64; 2]>,
    /// When the photograph was taken, with its zone.
    #[arg(long, value_name = "YYYY-MM-DDThh:mm:ss+hh:mm", requires = "place")]
    time: Option<String>,
    /// The sky as a picture, white, instead of the one that is found; of the size of the photograph or smaller.
    #[arg(long, value_name = "PNG")]
    sky: Option<PathBuf>,
    /// Rain in mm/h, instead of one that fits the light.
    #[arg(long, value_name = "MM_H")]
    rain: Option<f64>,
    /// The folder to write to.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The camera.
    #[command(flatten)]
    camera: CameraFlags,
}

/// Sets the bow.
///
/// # Errors
/// A photograph that cannot be read or has no sky, a bow that cannot be, files that exist, or whatever
/// `niji run` reports.
pub(crate) fn execute(command: &PhotoCommand, common: &Common) -> Result<(), Failure> {
    check_no_input(command)?;
    let photo = Photograph::read(&command.photo)
        .map_err(|error| Failure::bad_input(&command.photo, error))?;
    WantedBow::check_points(command)?;
    let camera = command.camera.camera(&photo)?;
    let existing = common.options().existing;
    let (is_sky, told) = sky(command, &photo, existing)?;
    let camera = camera.below_sky(&is_sky)?;
    let wanted = WantedBow::of(command, &camera)?;
    let rain = Rain::of(command.rain, &photo.light, (&is_sky, &camera))?;
    let layers = foreground(&photo.light, &is_sky, &camera.pinhole()?);
    let folder = &command.output;
    let text = SceneText {
        picture: &beside::name_from(folder, &command.photo)
            .map_err(|error| Failure::bad_input(&command.photo, error))?,
        camera: &camera,
        wanted: &wanted,
        rain: &rain,
    };
    let text = text.toml()?;
    seen::check(command, &text, (&is_sky, &camera))?;
    let mut files = vec![
        (SCENE, text.into_bytes()),
        (LAYERS, layers_to_toml(&layers.layers).into_bytes()),
        (LABELS, png(&layers.labels, layers.layers.len())?),
    ];
    // Somebody's own mask stays as it is.
    if !is_own_mask(command) {
        files.push((SKY, png(&is_sky.mapv(u8::from), 2)?));
    }
    for (name, bytes) in &files {
        check_own(&folder.join(name), bytes, existing)?;
    }
    for (name, bytes) in &files {
        output::write_file(&folder.join(name), |to| {
            std::io::Write::write_all(to, bytes)
        })?;
    }
    let verbosity = common.verbosity();
    if let Some(Profile { name, is_used }) = &photo.profile {
        let told = if *is_used {
            format!("by its profile, {name}")
        } else {
            format!("taken for sRGB: its profile, {name}, has no curves and matrix")
        };
        verbosity.say(format_args!("     colors  {told}"));
    }
    verbosity.say(format_args!("        sky  {told}"));
    verbosity.say(format_args!("     camera  {}", camera.told()));
    verbosity.say(format_args!("        bow  {}", wanted.told));
    verbosity.say(format_args!("       rain  {}", rain.told));
    let scene = folder.join(SCENE);
    run::execute(&RunCommand::of(scene.clone(), folder.clone()), common)?;
    verbosity.say(format_args!(
        "to drag the bow in the browser: niji view {}",
        quoted(&scene)
    ));
    Ok(())
}

/// Refuses a folder where the photograph or the mask would be written over.
fn check_no_input(command: &PhotoCommand) -> Result<(), Failure> {
    let mask = command.sky.as_deref().filter(|_| !is_own_mask(command));
    let inputs: Vec<&Path> = [&*command.photo].into_iter().chain(mask).collect();
    let folder = &command.output;
    let own = [SCENE, SKY, LAYERS, LABELS].map(|name| folder.join(name));
    output::check_no_input(&own.each_ref().map(PathBuf::as_path), &inputs)?;
    stages::photo::check_no_input(folder, &inputs)
}

/// Is the mask the one of the folder, as somebody corrected it?
fn is_own_mask(command: &PhotoCommand) -> bool {
    let own = command.output.join(SKY).canonicalize();
    let given = command.sky.as_ref().map(|path| path.canonicalize());
    matches!((own, given), (Ok(own), Some(Ok(given))) if own == given)
}

/// Labels as the bytes of a PNG.
fn png(labels: &Array2<u8>, n_layers: usize) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let written = write_labels(labels, n_layers, &mut bytes);
    written.map_err(|error| Failure::Failed(error.to_string()))?;
    Ok(bytes)
}

/// The sky of the photograph, and what is to be said of it.
fn sky(
    command: &PhotoCommand,
    photo: &Photograph,
    existing: Existing,
) -> Result<(Array2<bool>, String), Failure> {
    let share = |part: f64| format!("{:.0} % of the picture", 100.0 * part);
    if let Some(path) = &command.sky {
        let of_mask = |error: niji_photo::Error| Failure::bad_input(path, error);
        let mask = read_labels(path, 2).map_err(of_mask)?;
        let mask = upsample_labels(&mask, &photo.light).map_err(of_mask)?;
        let is_sky = mask.mapv(|label| label == 1);
        let part = is_sky.iter().filter(|is_sky| **is_sky).count() as f64 / is_sky.len() as f64;
        if part <= 0.0 {
            return Err(Failure::bad_input(
                path,
                "found no white pixel, expected the sky in white",
            ));
        }
        return Ok((is_sky, format!("{} by {}", share(part), path.display())));
    }
    let pointed = seen::pixel_of_apex(command, photo.light.dim())?;
    let mask = find_sky(&photo.light, pointed)
        .map_err(|error| Failure::bad_input(&command.photo, error))?;
    if mask.confidence < SURE_OF_SKY && !mask.is_pointed {
        let how = draft(&command.output, &mask.is_sky, existing)?;
        return Err(Failure::Impossible(format!(
            "{}: found no sky for a bow to stand in (what could be one has the confidence {:.2}: {}); if there is one, \
             {how}",
            command.photo.display(),
            mask.confidence,
            mask.reasons.join(", ")
        )));
    }
    let told = format!(
        "{}, confidence {:.2}: {}; sky.png shows it, --sky takes a better one",
        share(mask.share),
        mask.confidence,
        mask.reasons.join(", ")
    );
    Ok((mask.is_sky, told))
}

/// Leaves what could be a sky as a mask to be corrected, and says how to give a better one.
fn draft(folder: &Path, is_sky: &Array2<bool>, existing: Existing) -> Result<String, Failure> {
    let path = folder.join(SKY);
    let bytes = png(&is_sky.mapv(u8::from), 2)?;
    if !is_sky.iter().any(|is_sky| *is_sky) || check_own(&path, &bytes, existing).is_err() {
        return Ok(
            "paint it white and all else black, and give that with --sky MASK.png".to_owned(),
        );
    }
    output::write_file(&path, |to| std::io::Write::write_all(to, &bytes))?;
    // Until somebody corrects it, another one may take its place.
    checksums::note(&path, DRAFT)?;
    let path = path.display();
    Ok(format!(
        "correct {path}, which has in white what could be one, and give it with --sky {path}"
    ))
}

/// Refuses to write over a file that somebody edited.
fn check_own(path: &Path, bytes: &[u8], existing: Existing) -> Result<(), Failure> {
    let mut found = Vec::new();
    let read = File::open(path).and_then(|file| {
        // One more than may be is another one.
        file.take(bytes.len() as u64 + 1).read_to_end(&mut found)
    });
    let is_draft = || checksums::fits(path, DRAFT, true);
    if existing == Existing::Replace || read.is_err() || found == bytes || is_draft() {
        return Ok(());
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    Err(Failure::Usage(format!(
        "{} exists and is another one: `niji run {} -o {}` goes on with it, --force writes it anew",
        path.display(),
        folder.join(SCENE).display(),
        folder.display()
    )))
}

/// `185,27`.
fn sun(text: &str) -> Result<[f64; 2], String> {
    match flags::numbers(text)?[..] {
        [azimuth, elevation] if elevation.abs() <= 90.0 => Ok([azimuth, elevation]),
        _ => Err(format!(
            "found {text:?}, expected AZ,ELEV in degrees, say 185,27"
        )),
    }
}
