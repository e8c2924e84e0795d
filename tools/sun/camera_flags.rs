//! The camera of a photograph by flags and EXIF.

use clap::Args;
use glam::DVec3;
use ndarray::Array2;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_photo::ExifNotes;
use niji_photo::Lens;
use niji_photo::Photograph;
use niji_photo::is_cropped;
use niji_photo::tilt_from_horizon;
use niji_photo::tilt_from_sky;
use niji_radiometry::Radians;
use serde::Serialize;

use crate::failure::Failure;
use crate::flags;

/// What is known of the camera.
#[derive(Clone, Debug, Args, Serialize)]
#[command(next_help_heading = "Camera")]
pub(crate) struct CameraFlags {
    /// Horizontal field of view in degrees [default: by EXIF].
    #[arg(long, value_name = "DEG", conflicts_with_all = ["focal_35mm_mm", "sensor_width_mm"])]
    fov_deg: Option<f64>,
    /// Focal length as on 35 mm film, in mm.
    #[arg(long, value_name = "MM", conflicts_with = "sensor_width_mm")]
    focal_35mm_mm: Option<f64>,
    /// Width of the sensor in mm, with --focal-mm or the focal length of EXIF.
    #[arg(long, value_name = "MM")]
    sensor_width_mm: Option<f64>,
    /// Focal length of the lens in mm [default: by EXIF].
    #[arg(long, value_name = "MM", requires = "sensor_width_mm")]
    focal_mm: Option<f64>,
    /// Azimuth of the optical axis, clockwise from north [default: by EXIF, else 0].
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    azimuth_deg: Option<f64>,
    /// Elevation of the optical axis above the horizon [default: 0, a level camera].
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        conflicts_with = "horizon"
    )]
    elevation_deg: Option<f64>,
    /// Rotation about the optical axis, positive where the right side goes down [default: 0].
    #[arg(
        long,
        value_name = "DEG",
        allow_negative_numbers = true,
        conflicts_with = "horizon"
    )]
    roll_deg: Option<f64>,
    /// A point of the horizon in pixels; give two, and elevation and roll follow.
    #[arg(long, value_name = "X,Y", value_parser = point, allow_hyphen_values = true)]
    horizon: Vec<[f64; 2]>,
}

/// The camera, and where its numbers come from.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Camera {
    /// Width of the picture, pixels.
    pub(crate) width_px: u32,
    /// Height of the picture, pixels.
    pub(crate) height_px: u32,
    /// Horizontal field of view, degrees.
    pub(crate) horizontal_fov_deg: f64,
    /// Where the field of view comes from.
    pub(crate) fov_source: &'static str,
    /// Where elevation and roll come from; none where the camera is taken to be level.
    #[serde(skip)]
    pub(crate) tilt_source: Option<&'static str>,
    /// Azimuth of the axis, degrees.
    pub(crate) azimuth_deg: f64,
    /// Elevation of the axis, degrees.
    pub(crate) elevation_deg: f64,
    /// Roll, degrees.
    pub(crate) roll_deg: f64,
    /// Has the picture another shape than the camera gave it?
    pub(crate) cropped: bool,
}

impl CameraFlags {
    /// The pinhole camera of a scene with a photograph.
    pub(crate) fn of_scene(camera: &niji_scene::Camera) -> Self {
        Self {
            fov_deg: camera.horizontal_fov_deg,
            focal_35mm_mm: None,
            sensor_width_mm: None,
            focal_mm: None,
            azimuth_deg: Some(camera.azimuth_deg),
            elevation_deg: Some(camera.elevation_deg),
            roll_deg: Some(camera.roll_deg),
            horizon: Vec::new(),
        }
    }

    /// The camera of a photograph.
    ///
    /// # Errors
    /// [`Failure::Usage`] if nothing tells the field of view, or values are out of range.
    pub(crate) fn camera(&self, photo: &Photograph) -> Result<Camera, Failure> {
        let usage = |error: &dyn std::fmt::Display| Failure::Usage(error.to_string());
        let (width, height) = (photo.width(), photo.height());
        let (lens, fov_source) = self.lens(&photo.notes)?;
        let fov = lens
            .horizontal_fov(width, height)
            .map_err(|error| usage(&error))?;
        let mut camera = Camera {
            width_px: width as u32,
            height_px: height as u32,
            horizontal_fov_deg: self.fov_deg.unwrap_or_else(|| fov.to_degrees()),
            fov_source,
            tilt_source: self.tilt_source(),
            azimuth_deg: self.azimuth_deg.or(photo.notes.azimuth_deg).unwrap_or(0.0),
            elevation_deg: self.elevation_deg.unwrap_or(0.0),
            roll_deg: self.roll_deg.unwrap_or(0.0),
            cropped: fov_source == "EXIF" && is_cropped(&photo.notes, width, height),
        };
        match self.horizon[..] {
            [] => {}
            [first, second] => {
                let level = Camera {
                    azimuth_deg: 0.0,
                    ..camera.clone()
                };
                let tilt = tilt_from_horizon(&level.pinhole()?, [first, second]);
                let (elevation, roll) = tilt.map_err(|error| usage(&error))?;
                camera.elevation_deg = elevation.to_degrees();
                camera.roll_deg = roll.to_degrees();
            }
            _ => {
                let found = self.horizon.len();
                return Err(Failure::Usage(format!(
                    "found {found} points of the horizon, expected --horizon X,Y twice"
                )));
            }
        }
        Ok(camera)
    }

    fn tilt_source(&self) -> Option<&'static str> {
        let is_said = self.elevation_deg.or(self.roll_deg).is_some();
        let said = is_said.then_some("--elevation-deg and --roll-deg");
        said.or((!self.horizon.is_empty()).then_some("--horizon"))
    }

    fn lens(&self, notes: &ExifNotes) -> Result<(Lens, &'static str), Failure> {
        if let Some(fov_deg) = self.fov_deg {
            return Ok((
                Lens::FieldOfView(Radians::from_degrees(fov_deg)),
                "--fov-deg",
            ));
        }
        if let Some(focal_length_mm) = self.focal_35mm_mm {
            return Ok((Lens::Film35 { focal_length_mm }, "--focal-35mm-mm"));
        }
        if let Some(width_mm) = self.sensor_width_mm {
            let Some(focal_length_mm) = self.focal_mm.or(notes.focal_length_mm) else {
                return Err(Failure::Usage(
                    "the picture notes no focal length: give --focal-mm".to_owned(),
                ));
            };
            let lens = Lens::Sensor {
                focal_length_mm,
                width_mm,
            };
            return Ok((lens, "--sensor-width-mm"));
        }
        let lens = Lens::from_notes(notes).map(|lens| (lens, "EXIF"));
        lens.ok_or_else(|| {
            Failure::Usage(
                "the picture does not note its field of view: give --fov-deg, --focal-35mm-mm, or \
                 --sensor-width-mm with --focal-mm"
                    .to_owned(),
            )
        })
    }
}

impl Camera {
    /// The same, looking up as far as its sky tells where nothing else tells how it is tilted.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a camera that cannot be.
    pub(crate) fn below_sky(mut self, is_sky: &Array2<bool>) -> Result<Self, Failure> {
        if self.tilt_source.is_none()
            && let Some(elevation) = tilt_from_sky(&self.pinhole()?, is_sky)
        {
            self.elevation_deg = elevation.to_degrees();
            self.tilt_source = Some("the lowest sky, which lies above the horizon");
        }
        Ok(self)
    }

    /// The camera as geometry, its eye at the origin.
    ///
    /// # Errors
    /// [`Failure::Usage`] for a camera that cannot be.
    pub(crate) fn pinhole(&self) -> Result<PinholeCamera, Failure> {
        PinholeCamera::new(self.request()).map_err(|error| Failure::Usage(error.to_string()))
    }

    /// Where it looks, in words, and what says it better.
    pub(crate) fn told(&self) -> String {
        let tilt = match self.tilt_source {
            Some(source) => {
                let (up, roll) = (self.elevation_deg, self.roll_deg);
                format!("{up:.1} degrees up, turned by {roll:.1} degrees, by {source}")
            }
            None => "taken to be level, its horizon across the middle".to_owned(),
        };
        let is_said = self.tilt_source.is_some_and(|it| it.starts_with("--"));
        let better = if is_said {
            ""
        } else {
            "; --horizon X,Y twice tells it, or --elevation-deg and --roll-deg"
        };
        format!(
            "{:.1} degrees across by {}, {tilt}{better}",
            self.horizontal_fov_deg, self.fov_source
        )
    }

    /// What that is made from.
    pub(crate) fn request(&self) -> PinholeRequest {
        PinholeRequest {
            position: DVec3::ZERO,
            azimuth: Radians::from_degrees(self.azimuth_deg),
            elevation: Radians::from_degrees(self.elevation_deg),
            roll: Radians::from_degrees(self.roll_deg),
            horizontal_fov: Radians::from_degrees(self.horizontal_fov_deg),
            width_px: self.width_px,
            height_px: self.height_px,
        }
    }
}

/// A point of a picture: `320,41.5`.
pub(crate) fn point(text: &str) -> Result<[f64; 2], String> {
    let values = flags::numbers(text)?;
    <[f64; 2]>::try_from(values.as_slice())
        .map_err(|_| format!("found {text:?}, expected a point X,Y in pixels, say 320,41.5"))
}
