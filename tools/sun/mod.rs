//! `niji sun`: where the sun stands by pixels of a photograph where a bow is or should be.

pub(crate) mod camera_flags;
pub(crate) mod report;

use std::path::PathBuf;

use clap::Args;
use glam::DVec3;
use niji_geometry::PinholeCamera;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::PickedEdge;
use niji_photo::bow_path;
use niji_photo::draw_line;
use niji_photo::published_directions;
use niji_photo::write_png;
use niji_picture::BowEdge;
use niji_picture::EDGE_ERROR;
use niji_picture::PICK_ERROR_PX;
use niji_picture::PickedSuns;
use niji_picture::PicksRequest;
use niji_picture::PlannedScene;
use niji_radiometry::Radians;
use niji_scene::PickedBow;
use niji_scene::PickedColor;
use serde_json::json;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::photo_source::PhotoSource;
use crate::schema_flags::names;
use crate::stages;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;
use crate::stages::photo;
use crate::sun::camera_flags::Camera;
use crate::sun::camera_flags::CameraFlags;
use crate::sun::camera_flags::point;
use crate::water_flags::WaterFlags;

/// Temperature of the water unless another is said; 10 degrees move the bow by 0.1 degree.
pub(crate) const TEMPERATURE_C: &str = "15";

/// Colors of the drawn bows, linear: the best one, the others, the picks.
const BEST: [f32; 3] = [1.0, 1.0, 1.0];
const OTHER: [f32; 3] = [1.0, 0.6, 0.0];
const PICK: [f32; 3] = [1.0, 0.0, 0.0];

/// Say where the sun stands, by pixels where a bow is or should be.
///
/// All fits are listed, mirror solutions too, each with standard errors. Pixels count from the top
/// left corner of the upright picture. Results on standard output, `--json` for scripts.
#[derive(Debug, Args)]
#[command(
    mut_arg("scene", |scene| scene.conflicts_with_all([
        "picks", "bow", "edge", "bow_angle_deg", "bow_angle_error_deg", "no_prior", "noise_px",
        "published", "CameraFlags", "WaterFlags"
    ])),
    mut_arg("temperature_c", |flag| flag.default_value(TEMPERATURE_C)),
    after_help = "Examples:
  niji sun data/photos/pavilion.jpg --fov-deg 60 --pick 119,113 --pick 320,72 --pick 521,113
  niji sun photo.jpg --pick 412,900 --pick 1800,300 --pick 3100,880 --edge red --preview bow.png")]
pub(crate) struct SunCommand {
    /// The photograph.
    #[command(flatten)]
    source: PhotoSource,
    /// A point of the bow in pixels; give three or more, on one color edge (two, unless --no-prior).
    #[arg(long = "pick", value_name = "X,Y", value_parser = point, required_unless_present = "scene", allow_hyphen_values = true)]
    picks: Vec<[f64; 2]>,
    /// Which bow was picked.
    #[arg(long, value_name = "BOW", value_parser = names::<PickedBow>(), default_value = "primary")]
    bow: PickedBow,
    /// Which color edge of it was picked.
    #[arg(long, value_name = "EDGE", value_parser = names::<PickedColor>(), default_value = "red")]
    edge: PickedColor,
    /// The water of the drops.
    #[command(flatten)]
    water: WaterFlags,
    /// The bow angle in degrees, instead of that of the edge for large drops.
    #[arg(long, value_name = "DEG")]
    bow_angle_deg: Option<f64>,
    /// Standard error of the bow angle in degrees.
    #[arg(long, value_name = "DEG", default_value_t = EDGE_ERROR.to_degrees())]
    bow_angle_error_deg: f64,
    /// Assume no bow angle: it comes out and is a check.
    #[arg(long)]
    no_prior: bool,
    /// Standard error of a pick in pixels.
    #[arg(long, value_name = "PX", default_value_t = PICK_ERROR_PX)]
    noise_px: f64,
    /// Search as published: directions on a grid of this step with 40 to 43 degrees at every pick.
    #[arg(long, value_name = "STEP_DEG", num_args = 0..=1, default_missing_value = "0.25")]
    published: Option<f64>,
    /// Write the report as JSON too.
    #[arg(short, long, value_name = "JSON", conflicts_with = "published")]
    output: Option<PathBuf>,
    /// Draw the picks and the bows that follow into a copy of the picture.
    #[arg(long, value_name = "PNG", conflicts_with = "published")]
    preview: Option<PathBuf>,
    /// The camera.
    #[command(flatten)]
    camera: CameraFlags,
}

impl SunCommand {
    /// What a scene says of its photograph.
    ///
    /// # Errors
    /// A scene without one.
    pub(crate) fn of_scene(
        planned: &PlannedScene,
        output: Option<PathBuf>,
        preview: Option<PathBuf>,
    ) -> Result<Self, Failure> {
        let section = photo::section(planned)?;
        Ok(Self {
            source: PhotoSource::of_scene(planned)?,
            picks: section.picks_px.clone(),
            bow: section.bow,
            edge: section.edge,
            water: WaterFlags::from(planned.scene.water()),
            bow_angle_deg: None,
            bow_angle_error_deg: EDGE_ERROR.to_degrees(),
            no_prior: false,
            noise_px: PICK_ERROR_PX,
            published: None,
            output,
            preview,
            camera: CameraFlags::of_scene(&planned.scene.camera),
        })
    }
}

/// What picks say about the sun.
pub(crate) struct Solved {
    camera: Camera,
    pinhole: PinholeCamera,
    photo: Photograph,
    suns: PickedSuns,
}

/// Solves for the sun.
///
/// # Errors
/// A photograph that cannot be read, flags that contradict each other, or [`Failure::Impossible`]
/// after the report where no place of the sun is possible.
pub(crate) fn execute(command: &SunCommand, common: &Common) -> Result<(), Failure> {
    let of_scene = command.source.command(common, |planned| {
        SunCommand::of_scene(planned, command.output.clone(), command.preview.clone())
    })?;
    let command = of_scene.as_ref().unwrap_or(command);
    if let Some(step_deg) = command.published {
        return published(command, step_deg, common);
    }
    let solved = solve(command)?;
    let report = solved.report();
    let text = if common.json {
        report::json_text(&report)?
    } else {
        report::text(&report)
    };
    output::print(&text)?;
    let possible = solved.suns.best();
    if command.output.is_some() || command.preview.is_some() {
        files(command, common.options(), || Ok(solved))?;
    }
    possible?;
    Ok(())
}

/// Writes what the picks say, or keeps files that fit.
///
/// # Errors
/// As [`solve`], or outputs that exist.
pub(crate) fn make(command: &SunCommand, options: StageOptions) -> Result<Done, Failure> {
    files(command, options, || solve(command))
}

/// What the picks of a command say.
///
/// # Errors
/// A photograph that cannot be read, or flags that contradict each other.
pub(crate) fn solve(command: &SunCommand) -> Result<Solved, Failure> {
    let photo = Photograph::read(&command.source.photo)
        .map_err(|error| Failure::bad_input(&command.source.photo, error))?;
    let camera = command.camera.camera(&photo)?;
    let pinhole = camera.pinhole()?;
    let request = PicksRequest {
        camera: &pinhole,
        picks_px: &command.picks,
        noise_px: command.noise_px,
        edge: edge(command)?,
        is_angle_known: !command.no_prior,
    };
    let suns = request.suns();
    let suns = suns.map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(Solved {
        camera,
        pinhole,
        photo,
        suns,
    })
}

impl Solved {
    fn report(&self) -> report::Report<'_> {
        report::Report::new(&self.camera, &self.suns)
    }
}

fn files(
    command: &SunCommand,
    options: StageOptions,
    solved: impl FnOnce() -> Result<Solved, Failure>,
) -> Result<Done, Failure> {
    let job = Request {
        stage: "sun",
        settings: settings(command),
        inputs: vec![("photo", &command.source.photo)],
        outputs: [&command.output, &command.preview]
            .into_iter()
            .flatten()
            .map(PathBuf::as_path)
            .collect(),
    };
    perform(&job, options, |provenance| {
        let solved = solved()?;
        let text = stages::json_text(&provenance, solved.report())?;
        if let Some(path) = &command.preview {
            let drawn = drawn(solved, &command.picks);
            output::write_file(path, |writer| write_png(&drawn, &provenance, writer))?;
        }
        match &command.output {
            Some(path) => output::write_text(path, &text),
            None => Ok(()),
        }
    })
}

fn settings(command: &SunCommand) -> String {
    json!({
        "camera": command.camera,
        "picks_px": command.picks,
        "bow": format!("{:?}", command.bow),
        "edge": format!("{:?}", command.edge),
        "bow_angle_deg": command.bow_angle_deg,
        "bow_angle_error_deg": command.bow_angle_error_deg,
        "no_prior": command.no_prior,
        "noise_px": command.noise_px,
        "water": command.water,
    })
    .to_string()
}

fn edge(command: &SunCommand) -> Result<PickedEdge, Failure> {
    let error_deg = command.bow_angle_error_deg;
    let angle_deg = command.bow_angle_deg;
    let is_sound = error_deg > 0.0
        && error_deg.is_finite()
        && angle_deg.is_none_or(|angle| angle > 0.0 && angle < 180.0);
    if !is_sound {
        return Err(Failure::Usage(format!(
            "found a bow angle of {angle_deg:?} ± {error_deg} degrees, expected 0 to 180 and an error \
             above 0; --no-prior assumes none"
        )));
    }
    let edge = BowEdge {
        bow: command.bow,
        color: command.edge,
        water: command.water.water()?,
    };
    let angle = angle_deg.map_or_else(|| edge.angle(), Radians::from_degrees);
    Ok(edge.picked(angle, Radians::from_degrees(error_deg)))
}

fn published(command: &SunCommand, step_deg: f64, common: &Common) -> Result<(), Failure> {
    let photo = Photograph::read(&command.source.photo)
        .map_err(|error| Failure::bad_input(&command.source.photo, error))?;
    let camera = command.camera.camera(&photo)?.pinhole()?;
    let picks = command.picks.iter();
    let views: Vec<DVec3> = picks
        .map(|[x_px, y_px]| camera.ray(*x_px, *y_px).direction)
        .collect();
    let examples = published_directions(&views, Radians::from_degrees(step_deg))
        .map_err(|error| Failure::Usage(error.to_string()))?;
    output::print(&report::examples_text(&examples, common.json)?)?;
    if examples.is_empty() {
        return Err(Failure::Impossible(
            "no direction of the sun puts a bow of 40 to 43 degrees through all picks".to_owned(),
        ));
    }
    Ok(())
}

/// The photograph with the picks and the bows that follow.
fn drawn(solved: Solved, picks: &[[f64; 2]]) -> LinearPicture {
    let camera = solved.pinhole.into();
    let mut picture = solved.photo.light;
    let width_px = (picture.ncols() as f64 / 500.0).max(1.5);
    for (index, solution) in solved.suns.solutions.iter().enumerate().rev() {
        let color = if index == 0 { BEST } else { OTHER };
        let fit = &solution.fit;
        for line in bow_path(&camera, fit.antisolar, fit.bow_angle) {
            draw_line(&mut picture, &line, color, width_px);
        }
    }
    let arm = 4.0 * width_px;
    for [x, y] in picks {
        for line in [
            [[x - arm, *y], [x + arm, *y]],
            [[*x, y - arm], [*x, y + arm]],
        ] {
            draw_line(&mut picture, &line, PICK, width_px);
        }
    }
    picture
}
