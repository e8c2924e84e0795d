//! The scene of a photograph, as it is written for people who go on with it.

use std::path::Path;

use ndarray::Array2;
use niji_photo::LinearPicture;
use niji_photo::mean_luminance_where;

use crate::failure::Failure;
use crate::photo::LABELS;
use crate::photo::LAYERS;
use crate::photo::wanted::WantedBow;
use crate::sun::camera_flags::Camera;

/// Longest side of the rendered picture: the bow is smooth, its edges are those of the photograph.
const LONGEST_PX: u32 = 640;
/// Where the rain begins, behind everything that stands before the sky, m.
const NEAR_M: f64 = 300.0;
/// How far beyond the corners of the picture it reaches, radians.
const BEYOND_RAD: f64 = 0.14;
/// Largest sine of its half-width.
const WIDEST: f64 = 0.85;
/// Rain before a black sky and what a white one adds, mm/h.
const LEAST_MM_H: f64 = 2.0;
const MORE_MM_H: f64 = 3.0;

/// Rain that fits the light.
pub(super) struct Rain {
    rate_mm_h: f64,
    radius_m: f64,
    /// What is to be said of it.
    pub(super) told: String,
}

impl Rain {
    /// The rain that is asked for, or more of it the brighter the sky is.
    ///
    /// # Errors
    /// A rate that is none.
    pub(super) fn of(
        asked_mm_h: Option<f64>,
        photo: &LinearPicture,
        (is_sky, camera): (&Array2<bool>, &Camera),
    ) -> Result<Self, Failure> {
        if let Some(found) = asked_mm_h
            && !(found > 0.0 && found <= 200.0)
        {
            let message =
                format!("found --rain {found}, expected a rate above 0 and up to 200 mm/h");
            return Err(Failure::Usage(message));
        }
        let [sky, ground] = [true, false].map(|it| mean_luminance_where(photo, is_sky, it));
        // Of all the light that there is, the sky's part.
        let brightness = sky / (sky + ground).max(f64::MIN_POSITIVE);
        let fitting = ((LEAST_MM_H + MORE_MM_H * brightness) * 2.0).round() / 2.0;
        let rate_mm_h = asked_mm_h.unwrap_or(fitting);
        let pinhole = camera.pinhole()?;
        let corner = pinhole.ray(0.0, 0.0).direction;
        let half = corner.angle_between(pinhole.forward()) + BEYOND_RAD;
        let sine = half.min(std::f64::consts::FRAC_PI_2).sin().min(WIDEST);
        let radius_m = (NEAR_M * sine / (1.0 - sine)).round();
        let why = if asked_mm_h.is_some() {
            "as --rain says".to_owned()
        } else if ground <= 0.0 {
            "there is no light but the sky's, and the brighter it is, the more rain a bow needs"
                .to_owned()
        } else {
            format!(
                "the sky is {:.1} times as bright as the ground, and the brighter it is, the more rain a bow needs",
                sky / ground
            )
        };
        Ok(Self {
            rate_mm_h,
            radius_m,
            told: format!(
                "{rate_mm_h} mm/h, {NEAR_M:.0} to {:.0} m away: {why}",
                NEAR_M + 2.0 * radius_m
            ),
        })
    }
}

/// What the scene says.
pub(super) struct SceneText<'a> {
    /// The photograph, as it is named from the folder of the scene.
    pub(super) picture: &'a Path,
    /// What took it.
    pub(super) camera: &'a Camera,
    /// The sun.
    pub(super) wanted: &'a WantedBow,
    /// The drops.
    pub(super) rain: &'a Rain,
}

impl SceneText<'_> {
    /// The scene.
    ///
    /// # Errors
    /// A photograph whose name is no text.
    pub(super) fn toml(&self) -> Result<String, Failure> {
        let no_text = || Failure::bad_input(self.picture, "expected a name in UTF-8");
        let path = self.picture.to_str().ok_or_else(no_text)?;
        let stem = self.picture.file_stem().unwrap_or_default();
        let stem = stem.to_str().ok_or_else(no_text)?;
        let camera = self.camera;
        let longest = camera.width_px.max(camera.height_px);
        let shrunk = |side: u32| {
            let scale = f64::from(LONGEST_PX.min(longest)) / f64::from(longest);
            (f64::from(side) * scale).round().max(1.0)
        };
        let (sin, cos) = camera.azimuth_deg.to_radians().sin_cos();
        let away_m = NEAR_M + self.rain.radius_m;
        Ok(format!(
            "# A bow in a photograph, written by `niji photo` to be edited; `niji run` makes it.
format = 1
name = {name:?}
description = \"A bow in a photograph\"

# The layers, each a gray in photo.labels.png. All that is no sky is taken to stand before the rain; give hills and
# shores behind it their distances in {LAYERS}, and the bow stands before them.
[photo]
picture = {path:?}
layers = {LAYERS:?}
labels = {LABELS:?}

# {told}.
[sun]
{keys}
# The camera that took the photograph ({fov_source}). Its picture may be smaller than the photograph, in its shape.
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = {azimuth:.4}
elevation_deg = {elevation:.4}
roll_deg = {roll:.4}
horizontal_fov_deg = {fov:.4}
width_px = {width}
height_px = {height}

# Rain: {why}.
[drops]
shape = \"rain-shaft\"
rain_rate_mm_h = {rate:?}
footprint = {{ column = {{ radius_m = {radius:.1} }} }}
center_xz_m = [{x:.1}, {z:.1}]
base_y_m = 0.0
top_y_m = 1500.0
edge_m = 100.0
voxel_m = 50.0

[air]
constituents = [\"rayleigh\"]

[ground]
albedo = 0.2

[accuracy]
preset = \"standard\"
",
            name = format!("photo-{stem}"),
            told = self.wanted.told,
            keys = self.wanted.keys,
            fov_source = camera.fov_source,
            azimuth = camera.azimuth_deg,
            elevation = camera.elevation_deg,
            roll = camera.roll_deg,
            fov = camera.horizontal_fov_deg,
            width = shrunk(camera.width_px),
            height = shrunk(camera.height_px),
            why = self.rain.told,
            rate = self.rain.rate_mm_h,
            radius = self.rain.radius_m,
            x = away_m * sin,
            z = -away_m * cos,
        ))
    }
}
