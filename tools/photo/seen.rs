//! Whether anything of a bow is seen before the sky of its photograph.

use ndarray::Array2;
use niji_photo::bow_path;
use niji_scene::Scene;
use niji_scene::SceneError;

use crate::failure::Failure;
use crate::photo::PhotoCommand;
use crate::photo::wanted::brightest_of_bow;
use crate::sun::camera_flags::Camera;

/// What to do about a bow that is not seen.
const WAY_OUT: &str = "point at another place, or give the sky in white with --sky MASK.png";

/// Column and row of the pixel that is the top of the bow, in a picture of so many rows and columns.
///
/// # Errors
/// [`Failure::Usage`] for one outside of the picture.
pub(super) fn pixel_of_apex(
    command: &PhotoCommand,
    (height, width): (usize, usize),
) -> Result<Option<[usize; 2]>, Failure> {
    let Some([x, y]) = command.apex else {
        return Ok(None);
    };
    let inside_of = |at: f64, n_px: usize| (0.0..=n_px as f64).contains(&at);
    if !inside_of(x, width) || !inside_of(y, height) {
        return Err(Failure::Usage(format!(
            "--apex {x},{y} is outside the picture, which has {width} x {height} pixels: expected X,Y of the bow's \
             top, from its upper left corner"
        )));
    }
    let pixel = [(x, width), (y, height)].map(|(at, n_px)| (at as usize).min(n_px - 1));
    Ok(Some(pixel))
}

/// Refuses a scene that none can be, by the flag at fault, and a bow of which nothing is seen.
///
/// # Errors
/// [`Failure::Usage`] for the scene, [`Failure::Impossible`] for the bow.
pub(super) fn check(
    command: &PhotoCommand,
    scene: &str,
    (is_sky, camera): (&Array2<bool>, &Camera),
) -> Result<(), Failure> {
    let scene = Scene::from_toml(scene).map_err(|error| by_flag(&error, command))?;
    if let Some([column, row]) = pixel_of_apex(command, is_sky.dim())?
        && !is_sky[[row, column]]
    {
        return Err(Failure::Impossible(format!(
            "no sky is at --apex {column},{row}, so that the bow would stand behind what is there: {WAY_OUT}"
        )));
    }
    let pinhole = camera.pinhole()?;
    let path = bow_path(&pinhole.into(), -scene.sun.direction(), brightest_of_bow());
    let mut points = path.into_iter().flatten().peekable();
    // Of one outside of the picture `niji check` tells.
    if points.peek().is_none() {
        return Ok(());
    }
    let (height, width) = is_sky.dim();
    let is_seen = points.into_iter().any(|[x, y]| {
        let at = [(y as usize).min(height - 1), (x as usize).min(width - 1)];
        is_sky[at] && pinhole.ray(x, y).direction.y > 0.0
    });
    if is_seen {
        return Ok(());
    }
    Err(Failure::Impossible(format!(
        "nothing of the bow is before the sky: all of it that is in the picture is behind what stands there, or below \
         the horizon; {WAY_OUT}"
    )))
}

/// What is wrong with the scene, said of the flag that it comes from.
fn by_flag(error: &SceneError, command: &PhotoCommand) -> Failure {
    let message = match error {
        SceneError::OutOfRange {
            key,
            found,
            expected,
            ..
        } => {
            let flag = match key.as_str() {
                "sun.date_time" => "--time",
                "sun.latitude_deg" | "sun.longitude_deg" => "--place",
                "sun.azimuth_deg" | "sun.elevation_deg" if command.sun.is_some() => "--sun",
                key => key,
            };
            format!("{flag} is {found}, expected {expected}")
        }
        other => other.to_string(),
    };
    Failure::Usage(message)
}
