//! The section `[air]`: what the air is made of.

use niji_atmosphere::Aerosol;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirComponent;
use niji_atmosphere::AirModel;
use niji_atmosphere::USUAL_TOP_M;
use niji_geometry::EARTH;
use niji_radiometry::WavelengthGrid;
use serde::Deserialize;
use serde::Serialize;

/// A usual column of ozone, Dobson units.
const USUAL_OZONE_DOBSON: f64 = 300.0;

/// The section `[air]`; a scene without it lies in a vacuum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Air {
    /// What the air is made of, each at most once.
    pub constituents: Vec<Constituent>,
    /// Whose constants the molecules have: `bodhaine` where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<RayleighModel>,
    /// Pressure at sea level, hPa: 1013.25 where it is left out. The constants of `nishita` have a
    /// pressure of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_hpa: Option<f64>,
    /// The kind of haze: `clear` where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aerosol: Option<Haze>,
    /// How far one sees through the haze, km; its kind says where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visibility_km: Option<f64>,
    /// Vertical column of ozone, Dobson units: 300 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ozone_dobson: Option<f64>,
}

/// Something that air is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Constituent {
    /// Molecules, which scatter without absorbing.
    Rayleigh,
    /// Haze.
    Aerosol,
    /// Ozone, which absorbs yellow and orange light.
    Ozone,
}

impl Constituent {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rayleigh => "rayleigh",
            Self::Aerosol => "aerosol",
            Self::Ozone => "ozone",
        }
    }
}

/// Whose constants Rayleigh scattering has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayleighModel {
    /// Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999).
    Bodhaine,
    /// The constants of Nishita, Miyawaki and Nakamae (1987), 3 to 7 % stronger.
    Nishita,
}

/// A kind of haze.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Haze {
    /// Clear continental air.
    Clear,
    /// Country air.
    Rural,
    /// Sea salt.
    Maritime,
    /// Soot.
    Urban,
}

impl Haze {
    fn kind(self) -> AerosolKind {
        match self {
            Self::Clear => AerosolKind::Clear,
            Self::Rural => AerosolKind::Rural,
            Self::Maritime => AerosolKind::Maritime,
            Self::Urban => AerosolKind::Urban,
        }
    }
}

impl Air {
    /// A setting that belongs to a constituent which the air does not have: (key, constituent).
    pub(crate) fn idle_setting(&self) -> Option<(&'static str, Constituent)> {
        let settings = [
            ("rayleigh", self.rayleigh.is_some(), Constituent::Rayleigh),
            (
                "pressure_hpa",
                self.pressure_hpa.is_some(),
                Constituent::Rayleigh,
            ),
            ("aerosol", self.aerosol.is_some(), Constituent::Aerosol),
            (
                "visibility_km",
                self.visibility_km.is_some(),
                Constituent::Aerosol,
            ),
            (
                "ozone_dobson",
                self.ozone_dobson.is_some(),
                Constituent::Ozone,
            ),
        ];
        let idle =
            |(_, given, of): &(&str, bool, Constituent)| *given && !self.constituents.contains(of);
        settings
            .into_iter()
            .find(idle)
            .map(|(key, _, of)| (key, of))
    }

    /// The air as the stage that tabulates it takes it.
    ///
    /// # Errors
    /// If a number lies outside its range; never for the air of a scene that was read from a file.
    pub fn model(
        &self,
        wavelengths: WavelengthGrid,
        ground_albedo: f64,
    ) -> Result<AirModel, niji_atmosphere::Error> {
        let components = self
            .constituents
            .iter()
            .map(|constituent| match constituent {
                Constituent::Rayleigh => Ok(self.molecules()),
                Constituent::Aerosol => self.haze().map(AirComponent::Aerosol),
                Constituent::Ozone => Ok(AirComponent::Ozone {
                    column_dobson: self.ozone_dobson.unwrap_or(USUAL_OZONE_DOBSON),
                }),
            });
        Ok(AirModel {
            planet: EARTH,
            top_height_m: USUAL_TOP_M,
            wavelengths,
            sun_scale: 1.0,
            ground_albedo,
            components: components.collect::<Result<_, _>>()?,
        })
    }

    fn molecules(&self) -> AirComponent {
        match (
            self.rayleigh.unwrap_or(RayleighModel::Bodhaine),
            self.pressure_hpa,
        ) {
            (RayleighModel::Nishita, _) => AirComponent::RayleighNishita,
            (RayleighModel::Bodhaine, None) => AirComponent::STANDARD_RAYLEIGH,
            (RayleighModel::Bodhaine, Some(pressure_hpa)) => AirComponent::RayleighBodhaine {
                pressure_pa: 100.0 * pressure_hpa,
            },
        }
    }

    fn haze(&self) -> Result<Aerosol, niji_atmosphere::Error> {
        let usual = self.aerosol.unwrap_or(Haze::Clear).kind().aerosol();
        match self.visibility_km {
            Some(visibility_km) => usual.with_visibility_m(1000.0 * visibility_km),
            None => Ok(usual),
        }
    }
}
