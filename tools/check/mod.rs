//! `niji check`: what nature would not do in a photograph with a bow.

pub(crate) mod ephemeris;

use std::path::PathBuf;

use clap::Args;
use clap::ValueEnum;
use glam::DVec3;
use niji_exchange::SpectralImage;
use niji_geometry::PinholeCamera;
use niji_geometry::direction_from_azimuth_elevation;
use niji_photo::AddedLight;
use niji_photo::DropSource;
use niji_photo::Exposure;
use niji_photo::Finding;
use niji_photo::Photograph;
use niji_photo::Severity;
use niji_photo::bow_on_the_suns_side;
use niji_photo::bow_outside_picture;
use niji_photo::bow_path;
use niji_photo::card_value;
use niji_photo::cloud_cover;
use niji_photo::contrast_too_low;
use niji_photo::flattened_drops;
use niji_photo::fogbow_of_large_drops;
use niji_photo::hidden_by_surface;
use niji_photo::hidden_share;
use niji_photo::inside_not_brighter;
use niji_photo::luminance_around_bow;
use niji_photo::peak_contrast;
use niji_photo::read_depth_map;
use niji_photo::shadows_point_elsewhere;
use niji_photo::sun_below_horizon;
use niji_photo::sun_elsewhere;
use niji_photo::sun_too_high;
use niji_photo::supernumeraries_washed_out;
use niji_radiometry::Micrometers;
use niji_radiometry::Radians;

use crate::check::ephemeris::TimeAndPlace;
use crate::cli;
use crate::cli::Common;
use crate::failure::Failure;
use crate::sun::bow_edges::Bow;
use crate::sun::bow_edges::Edge;
use crate::sun::bow_edges::edge_angle;
use crate::sun::camera_flags::CameraFlags;
use crate::sun::report::FindingText;
use crate::sun::report::print_json;

/// Say what nature would not do in a photograph with a bow.
///
/// The sun is the one that the bow asks for (`niji sun`). Only what is given is checked. Findings
/// stand on standard output, each with a reason and a suggestion; an error among them ends with exit
/// code 4.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji check data/photos/pavilion.jpg --fov-deg 60 --sun-elevation-deg 28 --sun-azimuth-deg 180 --cloud-cover 0.4
  niji check photo.jpg --sun-elevation-deg 12 --sun-azimuth-deg 95 --time 2024-06-01T18:30:00 --utc-offset-h 2 --place-deg 48.1,11.6")]
pub(crate) struct CheckCommand {
    /// The photograph (PNG, JPEG, EXR).
    photo: PathBuf,
    /// Elevation of the sun.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    sun_elevation_deg: f64,
    /// Azimuth of the sun, clockwise from north.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    sun_azimuth_deg: f64,
    /// Standard error of the sun's direction.
    #[arg(long, value_name = "DEG", default_value_t = 0.5)]
    sun_error_deg: f64,
    /// Which bow is wanted.
    #[arg(long, value_enum, default_value_t = Bow::Primary)]
    bow: Bow,
    /// Time of exposure on the camera's clock [default: by EXIF].
    #[arg(long, value_name = "YYYY-MM-DDThh:mm:ss", value_parser = time)]
    time: Option<[u32; 6]>,
    /// What that clock is ahead of UTC in hours [default: by EXIF].
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    utc_offset_h: Option<f64>,
    /// Latitude and longitude in degrees, north and east positive [default: by EXIF].
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    place_deg: Option<[f64; 2]>,
    /// Part of the sky under clouds, 0 to 1.
    #[arg(long, value_name = "PART")]
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
    #[arg(long, value_name = "EXR", requires = "drops_distance_m")]
    depth: Option<PathBuf>,
    /// Distance of the drops in metres.
    #[arg(long, value_name = "M", requires = "depth")]
    drops_distance_m: Option<f64>,
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

/// What all checks of one call share.
struct Case<'a> {
    command: &'a CheckCommand,
    photo: &'a Photograph,
    camera: PinholeCamera,
    sun: DVec3,
    elevation: Radians,
    bow_angle: Radians,
    path_px: Vec<[f64; 2]>,
}

/// Checks.
///
/// # Errors
/// Inputs that cannot be read, or [`Failure::Impossible`] after the report where a finding is an
/// error.
pub(crate) fn execute(command: &CheckCommand, common: &Common) -> Result<(), Failure> {
    let photo = Photograph::read(&command.photo)
        .map_err(|error| Failure::bad_input(&command.photo, error))?;
    let camera = command.camera.camera(&photo)?.pinhole()?;
    let elevation = Radians::from_degrees(command.sun_elevation_deg);
    let azimuth = Radians::from_degrees(command.sun_azimuth_deg);
    let sun = direction_from_azimuth_elevation(azimuth, elevation);
    if !sun.is_finite() {
        return Err(Failure::Usage(
            "expected finite angles of the sun".to_owned(),
        ));
    }
    let bow_angle = edge_angle(command.bow, Edge::Red);
    let path = bow_path(&camera, -sun, bow_angle);
    let case = Case {
        command,
        photo: &photo,
        camera,
        sun,
        elevation,
        bow_angle,
        path_px: path.into_iter().flatten().collect(),
    };
    let mut findings = case.geometry();
    findings.extend(case.weather_and_drops());
    findings.extend(case.ephemeris()?);
    findings.extend(case.files()?);
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let texts: Vec<FindingText> = findings.iter().map(FindingText::from).collect();
    if common.json {
        print_json(&texts)?;
    } else if texts.is_empty() {
        println!("no contradiction found");
    } else {
        texts.iter().for_each(FindingText::print);
    }
    let errors = findings.iter().filter(|f| f.severity == Severity::Error);
    match errors.count() {
        0 => Ok(()),
        n => Err(Failure::Impossible(format!(
            "nature would not do this, for {n} reasons"
        ))),
    }
}

impl Case<'_> {
    fn geometry(&self) -> Vec<Finding> {
        let (width, height) = (
            f64::from(self.camera.width_px()),
            f64::from(self.camera.height_px()),
        );
        let corner = |x: f64, y: f64| self.camera.ray(x * width, y * height).direction;
        let corners = [
            corner(0.0, 0.0),
            corner(1.0, 0.0),
            corner(0.0, 1.0),
            corner(1.0, 1.0),
        ];
        let lowest = corners.iter().map(|view| view.y).fold(1.0, f64::min);
        let forward = self.camera.forward();
        let half_diagonal = corners
            .iter()
            .map(|view| view.angle_between(forward))
            .fold(0.0, f64::max);
        let around =
            luminance_around_bow(&self.photo.light, &self.camera, (-self.sun, self.bow_angle));
        let [inside, outside] = around;
        let from_sun = Radians(forward.angle_between(self.sun));
        [
            sun_below_horizon(self.elevation),
            sun_too_high(self.elevation, self.bow_angle, Radians(lowest.asin())),
            bow_on_the_suns_side(from_sun, Radians(half_diagonal)),
            bow_outside_picture(self.path_px.len()),
            inside_not_brighter(inside, outside),
            self.shadow_error().and_then(shadows_point_elsewhere),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Angle on the ground between a shadow and the direction away from the sun.
    fn shadow_error(&self) -> Option<Radians> {
        let [x, y, tip_x, tip_y] = self.command.shadow?;
        let ground = |x: f64, y: f64| {
            let view = self.camera.ray(x, y).direction;
            (view.y < 0.0).then(|| view / -view.y)
        };
        let along = ground(tip_x, tip_y)? - ground(x, y)?;
        let away = DVec3::new(-self.sun.x, 0.0, -self.sun.z);
        let angle = along.angle_between(away);
        angle.is_finite().then_some(Radians(angle))
    }

    fn weather_and_drops(&self) -> Vec<Finding> {
        let command = self.command;
        let source = match command.drops {
            Source::Rain => DropSource::Rain,
            Source::Spray => DropSource::Spray,
            Source::Fog => DropSource::Fog,
        };
        let radius = command.radius_um.map(Micrometers);
        let fringes = command.variance.filter(|_| command.supernumeraries);
        [
            command
                .cloud_cover
                .and_then(|cover| cloud_cover(cover, source)),
            radius.and_then(|radius| flattened_drops(radius, self.elevation)),
            radius
                .filter(|_| command.fogbow)
                .and_then(fogbow_of_large_drops),
            fringes.and_then(supernumeraries_washed_out),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn ephemeris(&self) -> Result<Option<Finding>, Failure> {
        let (command, notes) = (self.command, &self.photo.notes);
        let time = command.time.or(notes.local_time);
        let offset = command.utc_offset_h.or(notes.utc_offset_h);
        let place = command.place_deg.or(notes.position_deg);
        let (Some(local_time), Some(utc_offset_h), Some(position_deg)) = (time, offset, place)
        else {
            return Ok(None);
        };
        let at = TimeAndPlace {
            local_time,
            utc_offset_h,
            position_deg,
        };
        let difference = Radians(at.sun()?.angle_between(self.sun));
        let error = Radians::from_degrees(command.sun_error_deg);
        let Some(mut finding) = sun_elsewhere(difference, error) else {
            return Ok(None);
        };
        let (shift_h, left) = at.best_shift_h(self.sun)?;
        if shift_h != 0 && left.0 < 0.5 * difference.0 {
            finding.suggestion = format!(
                "a clock {:+} hours ahead of UTC would fit to {:.1} degrees: is the camera on another \
                 time zone?",
                utc_offset_h + f64::from(shift_h),
                left.to_degrees()
            );
        }
        Ok(Some(finding))
    }

    fn files(&self) -> Result<Vec<Finding>, Failure> {
        let mut findings = Vec::new();
        let command = self.command;
        if let Some(path) = &command.image {
            let image = SpectralImage::read_spectral(path)
                .map_err(|error| Failure::bad_input(path, error))?;
            let of_image = |error: niji_photo::Error| Failure::bad_input(path, error);
            let light = AddedLight::of_image(&image).map_err(of_image)?;
            let added = light.resized(self.photo.light.dim()).map_err(of_image)?;
            let gain = card_value(Exposure::GreyWorld, &self.photo.light, &self.photo.notes)
                .map_err(of_image)?;
            let contrast = peak_contrast(&self.photo.light, &added, gain).map_err(of_image)?;
            let name = match command.bow {
                Bow::Primary => "primary",
                Bow::Secondary => "secondary",
            };
            findings.extend(contrast_too_low(contrast, name));
        }
        if let (Some(path), Some(drops_m)) = (&command.depth, command.drops_distance_m) {
            let depth_m = read_depth_map(path).map_err(|error| Failure::bad_input(path, error))?;
            if depth_m.dim() != self.photo.light.dim() {
                let message = "found another size than that of the photograph";
                return Err(Failure::bad_input(path, message));
            }
            findings.extend(hidden_by_surface(hidden_share(
                &self.path_px,
                &depth_m,
                drops_m,
            )));
        }
        Ok(findings)
    }
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
fn place(text: &str) -> Result<[f64; 2], String> {
    let values = cli::numbers(text)?;
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
    let values = cli::numbers(text)?;
    <[f64; 4]>::try_from(values.as_slice())
        .map_err(|_| format!("found {text:?}, expected X,Y,X,Y in pixels"))
}
