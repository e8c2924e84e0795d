//! The sections of a scene file, each a plain struct with the unit in the name of every key.

use glam::DVec3;
use niji_exchange::Spectra;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::GamutPolicy;
use niji_radiometry::Radians;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::moon_over_sun;
use niji_radiometry::solar_irradiance;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::albedo::Albedo;

/// Name of the shape that is made of the sea's water, [`niji_droplets::SeaSpray`].
const SEA_SPRAY: &str = "sea-spray";

/// The section `[sun]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// What shines: the sun where it is left out.
    #[serde(default, skip_serializing_if = "Body::is_sun")]
    pub body: Body,
    /// Phase angle of the moon, 0 at full moon, degrees: 0 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -150.0, max = 150.0))]
    pub phase_angle_deg: Option<f64>,
    /// Apparent elevation above the horizon, degrees.
    #[schemars(range(min = -90.0, max = 90.0))]
    pub elevation_deg: f64,
    /// Azimuth, clockwise from north, degrees.
    #[schemars(range(min = -3600.0, max = 3600.0))]
    pub azimuth_deg: f64,
}

/// What shines in the section `[sun]`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
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

    /// Irradiance above the air on a surface that faces the sun or moon, W m⁻² nm⁻¹, mean of each bin.
    pub fn irradiance(&self, wavelengths: &WavelengthGrid) -> Vec<f64> {
        let scale = self.irradiance_scale();
        let sun = solar_irradiance(wavelengths).into_iter();
        sun.map(|irradiance| scale * irradiance).collect()
    }

    /// Unit vector towards the sun.
    pub fn direction(&self) -> DVec3 {
        direction_from_azimuth_elevation(
            Radians::from_degrees(self.azimuth_deg),
            Radians::from_degrees(self.elevation_deg),
        )
    }
}

/// The section `[water]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Water {
    /// Temperature, degrees Celsius, of salt water 0 to 30: 15 where it is left out.
    #[schemars(range(min = -20.0, max = 100.0))]
    pub temperature_c: f64,
    /// Salinity, per mille: where it is left out 35 in the shape `sea-spray`, 0 in all others.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 40.0))]
    pub salinity_per_mille: Option<f64>,
}

impl Default for Water {
    fn default() -> Self {
        Self {
            temperature_c: 15.0,
            salinity_per_mille: None,
        }
    }
}

impl Water {
    /// The water of drops of these kinds, of the sea if all of them are its spray.
    pub(crate) fn of<'a>(self, kinds: impl IntoIterator<Item = &'a str>) -> niji_radiometry::Water {
        let mut kinds = kinds.into_iter().peekable();
        let usual = if kinds.peek().is_some() && kinds.all(|kind| kind == SEA_SPRAY) {
            niji_radiometry::Water::of_the_sea(self.temperature_c)
        } else {
            niji_radiometry::Water::pure(self.temperature_c)
        };
        niji_radiometry::Water {
            salinity_per_mille: self.salinity_per_mille.unwrap_or(usual.salinity_per_mille),
            ..usual
        }
    }
}

/// The section `[ground]`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ground {
    /// Share of the light that it gives back, 0..1, or red, green and blue, or the name of a ground whose spectrum was
    /// measured: 0.2, between dry grass and sand, where the section is left out.
    pub albedo: Albedo,
}

impl Default for Ground {
    fn default() -> Self {
        Self {
            albedo: Albedo::Even(0.2),
        }
    }
}

/// The section `[picture]`: how the picture is shown and kept; what is computed does not depend on it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Exposure in stops; at 0 a white card in the sun above the air is display white.
    #[serde(default)]
    #[schemars(range(min = -40.0, max = 40.0))]
    pub exposure_ev: f64,
    /// What happens to colors that the display cannot show.
    #[serde(default)]
    pub gamut: Gamut,
    /// What red, green and blue are in the plain image for compositors.
    #[serde(default)]
    pub primaries: Primaries,
    /// What its spectral file keeps of spectra.
    #[serde(default)]
    pub spectral: Spectral,
}

/// What the file of a picture keeps of its spectra.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spectral {
    /// All, in single precision.
    #[default]
    Full,
    /// All, in half floats, and the layers of light and errors too: a relative error of 2^-11.
    Half,
    /// Nothing: colors X, Y, Z take their place; layers of light and errors are half floats.
    None,
}

impl Spectral {
    /// Its spelling in scenes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Half => "half",
            Self::None => "none",
        }
    }
}

impl From<Spectral> for Spectra {
    fn from(spectral: Spectral) -> Self {
        match spectral {
            Spectral::Full => Self::Full,
            Spectral::Half => Self::Half,
            Spectral::None => Self::Left,
        }
    }
}

/// What red, green and blue are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Primaries {
    /// Rec.709, as displays have them.
    #[default]
    Rec709,
    /// AP1, in which compositors exchange ACES.
    AcesCg,
}

impl From<Primaries> for RgbPrimaries {
    fn from(primaries: Primaries) -> Self {
        match primaries {
            Primaries::Rec709 => Self::Rec709,
            Primaries::AcesCg => Self::AcesCg,
        }
    }
}

/// What happens to colors that the display cannot show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
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
