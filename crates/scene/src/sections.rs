//! The sections of a scene file, each a plain struct with the unit in the name of every key.

use glam::DVec3;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::GamutPolicy;
use niji_radiometry::Radians;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::moon_over_sun;
use serde::Deserialize;
use serde::Serialize;

/// The section `[sun]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// What shines: the sun where it is left out.
    #[serde(default, skip_serializing_if = "Body::is_sun")]
    pub body: Body,
    /// Phase angle of the moon, 0 at full moon, degrees: 0 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_angle_deg: Option<f64>,
    /// Apparent elevation above the horizon, degrees.
    pub elevation_deg: f64,
    /// Azimuth, clockwise from north, degrees.
    pub azimuth_deg: f64,
}

/// What shines in the section `[sun]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Body {
    /// The sun.
    #[default]
    Sun,
    /// The moon, as large as the sun and as white, but 400000 times weaker or more.
    Moon,
}

impl Body {
    /// The body in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sun => "sun",
            Self::Moon => "moon",
        }
    }

    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands it over so")]
    fn is_sun(&self) -> bool {
        *self == Self::Sun
    }
}

impl Sun {
    /// Irradiance over that by the sun: 1, or the moon's at its phase.
    pub fn irradiance_scale(&self) -> f64 {
        match self.body {
            Body::Sun => 1.0,
            Body::Moon => moon_over_sun(Radians::from_degrees(self.phase_angle_deg.unwrap_or(0.0))),
        }
    }

    /// Unit vector towards the sun.
    pub fn direction(&self) -> DVec3 {
        direction_from_azimuth_elevation(
            Radians::from_degrees(self.azimuth_deg),
            Radians::from_degrees(self.elevation_deg),
        )
    }
}

/// The section `[camera]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Position of the eye, metres: x east, y up, z south.
    pub position_m: [f64; 3],
    /// Azimuth of the optical axis, clockwise from north, degrees.
    pub azimuth_deg: f64,
    /// Elevation of the optical axis above the horizon, degrees.
    pub elevation_deg: f64,
    /// Rotation about the optical axis, positive where the right side goes down, degrees.
    #[serde(default)]
    pub roll_deg: f64,
    /// Full field of view across the width, degrees.
    pub horizontal_fov_deg: f64,
    /// Width of the picture, pixels.
    pub width_px: u32,
    /// Height of the picture, pixels.
    pub height_px: u32,
}

impl Camera {
    /// The camera as the renderer takes it.
    ///
    /// # Errors
    /// As [`PinholeCamera::new`]; never for a camera of a scene that was read from a file.
    pub fn pinhole(&self) -> Result<PinholeCamera, niji_geometry::Error> {
        PinholeCamera::new(PinholeRequest {
            position: DVec3::from(self.position_m),
            azimuth: Radians::from_degrees(self.azimuth_deg),
            elevation: Radians::from_degrees(self.elevation_deg),
            roll: Radians::from_degrees(self.roll_deg),
            horizontal_fov: Radians::from_degrees(self.horizontal_fov_deg),
            width_px: self.width_px,
            height_px: self.height_px,
        })
    }
}

/// The section `[spectrum]`: 380 to 780 nm by 10 nm where it is left out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spectrum {
    /// Center of the first bin, nm.
    pub first_nm: f64,
    /// Width of a bin, nm.
    pub step_nm: f64,
    /// Number of bins.
    pub n_wavelengths: usize,
}

impl Spectrum {
    /// The wavelength bins.
    ///
    /// # Errors
    /// As [`WavelengthGrid::new`]; never for a spectrum of a scene that was read from a file.
    pub fn grid(&self) -> Result<WavelengthGrid, niji_radiometry::Error> {
        WavelengthGrid::new(self.first_nm, self.step_nm, self.n_wavelengths)
    }
}

impl Default for Spectrum {
    fn default() -> Self {
        let grid = WavelengthGrid::visible();
        let (first_nm, step_nm) = (grid.first_nm(), grid.step_nm());
        Self {
            first_nm,
            step_nm,
            n_wavelengths: grid.len(),
        }
    }
}

/// The section `[water]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Water {
    /// Temperature, degrees Celsius: 15 where the section is left out.
    pub temperature_c: f64,
}

impl Default for Water {
    fn default() -> Self {
        Self {
            temperature_c: 15.0,
        }
    }
}

/// The section `[ground]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Share of the light that it gives back, 0..1: 0.2, grass, where the section is left out.
    pub albedo: f64,
}

impl Default for Ground {
    fn default() -> Self {
        Self { albedo: 0.2 }
    }
}

/// The section `[picture]`: how the preview is shown; radiances do not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Exposure in stops; at 0 a white card in the sun above the air is display white.
    #[serde(default)]
    pub exposure_ev: f64,
    /// What happens to colors that the display cannot show.
    #[serde(default)]
    pub gamut: Gamut,
}

/// What happens to colors that the display cannot show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gamut {
    /// They go towards the gray of the same luminance until they fit.
    #[default]
    Desaturate,
    /// Negative channels become 0.
    Clip,
}

impl From<Gamut> for GamutPolicy {
    fn from(gamut: Gamut) -> Self {
        match gamut {
            Gamut::Desaturate => Self::Desaturate,
            Gamut::Clip => Self::Clip,
        }
    }
}
