//! `niji check`: what nature would not do in a photograph with a bow.

mod case;

use std::path::Path;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use clap::ValueEnum;
use clap::builder::ArgPredicate;
use niji_photo::Finding;
use niji_photo::Severity;
use niji_picture::PlannedScene;
use niji_scene::PickedBow;
use niji_scene::Scene;
use serde_json::json;

use crate::check::case::findings;
use crate::failure::Failure;
use crate::flags;
use crate::flags::Common;
use crate::flags::within;
use crate::output;
use crate::photo_source::PhotoSource;
use crate::schema_flags::names;
use crate::stages;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::stages::photo;
use crate::sun::TEMPERATURE_C;
use crate::sun::camera_flags::CameraFlags;
use crate::sun::report;
use crate::sun::report::FindingText;
use crate::water_flags::WaterFlags;

/// Standard error of the sun's direction, degrees.
const SUN_ERROR_DEG: f64 = 0.5;

/// Say what nature would not do in a photograph with a bow.
///
/// The sun is the one that the bow asks for (`niji sun`). Only what is given is checked. Findings
/// stand on standard output, each with a reason and a suggestion; an error among them ends with exit
/// code 4.
#[derive(Debug, Args)]
#[command(
    mut_arg("scene", |scene| scene.conflicts_with_all([
        "sun_elevation_deg", "sun_azimuth_deg", "sun_error_deg", "bow", "time", "utc_offset_h",
        "place_deg", "cloud_cover", "drops", "radius_um", "variance", "supernumeraries", "fogbow",
        "shadow", "drops_distance_m", "CameraFlags", "WaterFlags"
    ])),
    mut_arg("temperature_c", |flag| flag.default_value(TEMPERATURE_C)),
    after_help = "Examples:
  niji check data/photos/pavilion.jpg --fov-deg 60 --sun-elevation-deg 28 \\
      --sun-azimuth-deg 180 --cloud-cover 0.4
  niji check photo.jpg --sun-elevation-deg 12 --sun-azimuth-deg 95 \\
      --time 2024-06-01T18:30:00 --utc-offset-h 2 --place-deg 48.1,11.6")]
pub(crate) struct CheckCommand {
    /// The photograph.
    #[command(flatten)]
    source: PhotoSource,
    /// Elevation of the sun.
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        value_parser = within(-90.0, 90.0),
        required_unless_present = "scene",
        default_value_if("scene", ArgPredicate::IsPresent, "0")
    )]
    sun_elevation_deg: f64,
    /// Azimuth of the sun, clockwise from north.
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        required_unless_present = "scene",
        default_value_if("scene", ArgPredicate::IsPresent, "0")
    )]
    sun_azimuth_deg: f64,
    /// Standard error of the sun's direction.
    #[arg(long, value_name = "DEG", default_value_t = SUN_ERROR_DEG, value_parser = within(0.0, 180.0))]
    sun_error_deg: f64,
    /// Which bow is wanted.
    #[arg(long, value_name = "BOW", value_parser = names::<PickedBow>(), default_value = "primary")]
    bow: PickedBow,
    /// The water of the drops.
    #[command(flatten)]
    water: WaterFlags,
    /// Time of exposure on the camera's clock [default: by EXIF].
    #[arg(long, value_name = "YYYY-MM-DDThh:mm:ss", value_parser = time)]
    time: Option<[u32; 6]>,
    /// What that clock is ahead of UTC in hours [default: by EXIF].
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = within(-18.0, 18.0))]
    utc_offset_h: Option<f64>,
    /// Latitude and longitude in degrees, north and east positive [default: by EXIF].
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    place_deg: Option<[f64; 2]>,
    /// Part of the sky under clouds, 0 to 1.
    #[arg(long, value_name = "PART", value_parser = within(0.0, 1.0))]
    cloud_cover: Option<f64>,
    /// Where the drops come from.
    #[arg(long, value_enum, default_value_t = Source::Rain)]
    drops: Source,
    /// Effective radius of the drops in micrometres.
    #[arg(long, value_name = "UM")]
    radius_um: Option<f64>,
    /// Effective variance of the drops.
    #[arg(long, value_name = "V")]
    variance: Option<f64>,
    /// Supernumerary bows are wanted.
    #[arg(long, requires = "variance")]
    supernumeraries: bool,
    /// A white fogbow is wanted.
    #[arg(long, requires = "radius_um")]
    fogbow: bool,
    /// A shadow on level ground: the foot of what casts it and its tip, in pixels.
    #[arg(long, value_name = "X,Y,X,Y", value_parser = shadow)]
    shadow: Option<[f64; 4]>,
    /// The image of `niji render`, for the contrast of the bow.
    #[arg(long, value_name = "EXR")]
    image: Option<PathBuf>,
    /// Distances of the photographed surfaces (`niji depth`).
    #[arg(long, value_name = "EXR")]
    depth: Option<PathBuf>,
    /// Distance of the drops in metres.
    #[arg(long, value_name = "M", requires = "depth")]
    drops_distance_m: Option<f64>,
    /// Write the findings as JSON too.
    #[arg(short, long, value_name = "JSON")]
    output: Option<PathBuf>,
    /// The camera.
    #[command(flatten)]
    camera: CameraFlags,
}

/// Sources of drops by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Source {
    /// Rain.
    Rain,
    /// A fountain, a waterfall or the sea.
    Spray,
    /// Fog.
    Fog,
}

/// Shapes whose drops are no rain.
const SPRAYS: [&str; 3] = ["fountain", "waterfall", "sea-spray"];
const FOGS: [&str; 2] = ["fog-bank", "cloud"];

impl Source {
    /// Where the drops of a scene come from.
    fn of_scene(scene: &Scene) -> Self {
        let populations = scene.drops.populations();
        let are_all = |kind: &[&str]| {
            let mut names = populations.iter().map(|it| it.source.name());
            names.all(|name| kind.contains(&name))
        };
        if are_all(&SPRAYS) {
            Self::Spray
        } else if are_all(&FOGS) {
            Self::Fog
        } else {
            Self::Rain
        }
    }
}

impl CheckCommand {
    /// What a scene says of its photograph, whose image and depth map are there. The map counts where the
    /// scene's plan knows how far away the drops are.
    ///
    /// # Errors
    /// A scene without a photograph.
    pub(crate) fn of_scene(
        planned: &PlannedScene,
        image: Option<PathBuf>,
        depth: Option<PathBuf>,
    ) -> Result<Self, Failure> {
        let (section, scene) = (photo::section(planned)?, &planned.scene);
        let depth = depth.zip(planned.plan.view.distance_m);
        let (depth, drops_distance_m) = depth
            .map(|(depth, (nearest_m, _))| (depth, nearest_m))
            .unzip();
        Ok(Self {
            source: PhotoSource::of_scene(planned)?,
            sun_elevation_deg: scene.sun.elevation_deg,
            sun_azimuth_deg: scene.sun.azimuth_deg,
            sun_error_deg: SUN_ERROR_DEG,
            bow: section.bow,
            water: WaterFlags::from(scene.water()),
            time: None,
            utc_offset_h: None,
            place_deg: None,
            cloud_cover: section.cloud_cover,
            drops: Source::of_scene(scene),
            radius_um: None,
            variance: None,
            supernumeraries: false,
            fogbow: false,
            shadow: None,
            image,
            depth,
            drops_distance_m,
            output: None,
            camera: CameraFlags::of_scene(&scene.camera),
        })
    }
}

/// Checks.
///
/// # Errors
/// Inputs that cannot be read, or [`Failure::Impossible`] after the report where a finding is an
/// error.
pub(crate) fn execute(command: &CheckCommand, common: &Common) -> Result<(), Failure> {
    let of_scene = command.source.command(common, |planned| {
        CheckCommand::of_scene(planned, command.image.clone(), command.depth.clone())
    })?;
    let output = command.output.as_deref();
    let command = of_scene.as_ref().unwrap_or(command);
    if command.depth.is_some() && command.drops_distance_m.is_none() {
        let message = "found --depth, expected --drops-distance-m beside it";
        return Err(Failure::Usage(message.to_owned()));
    }
    let findings = findings(command)?;
    let texts: Vec<FindingText> = findings.iter().map(FindingText::from).collect();
    let text = if common.json {
        report::json_text(&texts)?
    } else if texts.is_empty() {
        "no contradiction found\n".to_owned()
    } else {
        texts.iter().map(FindingText::text).collect()
    };
    output::print(&text)?;
    if let Some(path) = output {
        files(command, path, common.options(), &texts)?;
    }
    verdict(&findings)
}

/// Checks into the file that the command names, which is always made anew: it costs no more than a
/// look at what stands there.
///
/// # Errors
/// Inputs that cannot be read, or an output that is another one.
pub(crate) fn make(
    command: &CheckCommand,
    path: &Path,
    options: StageOptions,
) -> Result<(Done, Vec<Finding>), Failure> {
    let start = Instant::now();
    let findings = findings(command)?;
    let texts: Vec<FindingText> = findings.iter().map(FindingText::from).collect();
    let mut done = files(command, path, options, &texts)?;
    done.seconds = start.elapsed().as_secs_f64();
    Ok((done, findings))
}

/// Refuses what nature would not do.
///
/// # Errors
/// [`Failure::Impossible`] if a finding is an error.
pub(crate) fn verdict(findings: &[Finding]) -> Result<(), Failure> {
    let errors = findings.iter().filter(|f| f.severity == Severity::Error);
    match errors.count() {
        0 => Ok(()),
        n => Err(Failure::Impossible(format!(
            "nature would not do this, for {n} reason{}",
            if n == 1 { "" } else { "s" }
        ))),
    }
}

fn files(
    command: &CheckCommand,
    path: &Path,
    options: StageOptions,
    texts: &[FindingText],
) -> Result<Done, Failure> {
    let mut inputs = vec![("photo", command.source.photo.as_path())];
    inputs.extend(command.image.iter().map(|path| ("image", path.as_path())));
    inputs.extend(command.depth.iter().map(|path| ("depth", path.as_path())));
    let job = Request {
        stage: "check",
        settings: settings(command),
        inputs,
        outputs: vec![path],
    };
    perform(&job, options, |provenance| {
        let text = stages::json_text(&provenance, texts)?;
        output::write_text(path, &text)
    })
}

fn settings(command: &CheckCommand) -> String {
    json!({
        "camera": command.camera,
        "sun_deg": [command.sun_elevation_deg, command.sun_azimuth_deg, command.sun_error_deg],
        "bow": format!("{:?}", command.bow),
        "water": command.water,
        "time": command.time,
        "utc_offset_h": command.utc_offset_h,
        "place_deg": command.place_deg,
        "cloud_cover": command.cloud_cover,
        "drops": format!("{:?}", command.drops),
        "radius_um": command.radius_um,
        "variance": command.variance,
        "supernumeraries": command.supernumeraries,
        "fogbow": command.fogbow,
        "shadow": command.shadow,
        "drops_distance_m": command.drops_distance_m,
    })
    .to_string()
}

/// `2024-06-01T18:30:00`.
pub(crate) fn time(text: &str) -> Result<[u32; 6], String> {
    let wrong = || format!("found {text:?}, expected a time, say 2024-06-01T18:30:00");
    let numbers: Result<Vec<u32>, _> = text.split(['-', 'T', ':', ' ']).map(str::parse).collect();
    numbers
        .map_err(|_| wrong())?
        .try_into()
        .map_err(|_| wrong())
}

/// `48.1,11.6`.
pub(crate) fn place(text: &str) -> Result<[f64; 2], String> {
    let values = flags::numbers(text)?;
    match values[..] {
        [latitude, longitude] if latitude.abs() <= 90.0 && longitude.abs() <= 180.0 => {
            Ok([latitude, longitude])
        }
        _ => Err(format!(
            "found {text:?}, expected LAT,LON in degrees, say 48.1,11.6"
        )),
    }
}

/// `100,300,180,350`.
fn shadow(text: &str) -> Result<[f64; 4], String> {
    let values = flags::numbers(text)?;
    <[f64; 4]>::try_from(values.as_slice())
        .map_err(|_| format!("found {text:?}, expected X,Y,X,Y in pixels"))
}
