//! Where the sun has to stand for the bow that is wanted.

use niji_photo::sun_below_apex;
use niji_picture::BowEdge;
use niji_picture::EDGE_ERROR;
use niji_picture::PICK_ERROR_PX;
use niji_picture::PicksRequest;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_scene::PickedBow;
use niji_scene::PickedColor;
use niji_scene::SunPosition;

use crate::failure::Failure;
use crate::photo::PhotoCommand;
use crate::sun::camera_flags::Camera;

/// Temperature of the water, where 10 degrees move the bow by 0.1 degree.
const WATER_C: f64 = 15.0;
/// How far the brightest of a rain's bow lies inside the angle of Descartes' ray, degrees: at its top, where flattened
/// drops take 0.65 of it, and about midway down. Found for rain of 2 and 5 mm/h with the sun 3 to 36 degrees high: 0.9 to
/// 1.0 at the top.
const TOP_INSIDE_DEG: f64 = 0.95;
const SIDE_INSIDE_DEG: f64 = 0.6;

/// The sun of the bow, as the scene says it.
pub(super) struct WantedBow {
    /// The keys of the section `[sun]`.
    pub(super) keys: String,
    /// What is to be said of it.
    pub(super) told: String,
}

impl WantedBow {
    /// What the flags ask for.
    ///
    /// # Errors
    /// [`Failure::Impossible`] for a bow without a sun.
    pub(super) fn of(command: &PhotoCommand, camera: &Camera) -> Result<Self, Failure> {
        if let (Some([latitude, longitude]), Some(time)) = (command.place, &command.time) {
            return Ok(Self {
                keys: format!(
                    "date_time = {time:?}\nlatitude_deg = {latitude:?}\nlongitude_deg = {longitude:?}\n"
                ),
                told: format!(
                    "by the sun at {time}, camera looking to azimuth {:.1}",
                    camera.azimuth_deg
                ),
            });
        }
        if let Some([azimuth_deg, elevation_deg]) = command.sun {
            let position = SunPosition {
                elevation_deg,
                azimuth_deg,
            };
            return Ok(Self::by(position, "as --sun says"));
        }
        if let Some([x, y]) = command.apex {
            let pinhole = camera.pinhole()?;
            let view = pinhole.ray(x, y).direction;
            let [azimuth, elevation] = sun_below_apex(view, inside(TOP_INSIDE_DEG));
            let position = SunPosition {
                elevation_deg: elevation.to_degrees(),
                azimuth_deg: azimuth.to_degrees(),
            };
            check_up(position, view.y.asin())?;
            return Ok(Self::by(position, "its top where --apex says"));
        }
        Self::by_points(&command.bow, camera)
    }

    /// Refuses a number of points that is none, before anything is looked for.
    ///
    /// # Errors
    /// [`Failure::Usage`].
    pub(super) fn check_points(command: &PhotoCommand) -> Result<(), Failure> {
        match command.bow.len() {
            0 | 2 | 3 => Ok(()),
            found => Err(Failure::Usage(format!(
                "found {found} points of the bow, expected --bow X,Y two or three times"
            ))),
        }
    }

    fn by(position: SunPosition, why: &str) -> Self {
        let SunPosition {
            elevation_deg,
            azimuth_deg,
        } = position;
        Self {
            keys: format!("elevation_deg = {elevation_deg:.3}\nazimuth_deg = {azimuth_deg:.3}\n"),
            told: format!(
                "{why}: the sun {elevation_deg:.1} degrees high, azimuth {azimuth_deg:.1}"
            ),
        }
    }

    /// The sun of the possible bow that is nearest to the points.
    fn by_points(points_px: &[[f64; 2]], camera: &Camera) -> Result<Self, Failure> {
        let request = PicksRequest {
            camera: &camera.pinhole()?,
            picks_px: points_px,
            noise_px: PICK_ERROR_PX,
            edge: middle().picked(inside(SIDE_INSIDE_DEG), EDGE_ERROR),
            is_angle_known: true,
        };
        let suns = request.suns();
        let suns = suns.map_err(|error| Failure::Usage(error.to_string()))?;
        let nearest = suns.nearest()?;
        let why = format!(
            "the nearest possible one misses the points by {:.2} degrees (root mean square)",
            nearest.missed_deg
        );
        Ok(Self::by(nearest.position, &why))
    }
}

/// What people point at: the bright middle of the primary bow.
fn middle() -> BowEdge {
    BowEdge {
        bow: PickedBow::Primary,
        color: PickedColor::Middle,
        water: Water::pure(WATER_C),
    }
}

/// Half the opening angle of what is brightest of a rain's bow.
pub(super) fn brightest_of_bow() -> Radians {
    inside(TOP_INSIDE_DEG)
}

/// The bow angle that is seen, so far inside that of Descartes.
fn inside(degrees: f64) -> Radians {
    Radians(middle().angle().0 - degrees.to_radians())
}

fn check_up(position: SunPosition, top_rad: f64) -> Result<(), Failure> {
    if position.elevation_deg >= 0.0 {
        return Ok(());
    }
    Err(Failure::Impossible(format!(
        "the top of the bow would stand {:.1} degrees above the horizon, expected at most {:.1}, with the sun setting: \
         point lower, or say how the camera is tilted (--horizon, --elevation-deg)",
        Radians(top_rad).to_degrees(),
        Radians(top_rad).to_degrees() + position.elevation_deg
    )))
}
