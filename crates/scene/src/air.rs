//! The section `[air]`: what the air is made of.

use niji_atmosphere::Aerosol;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AirModel;
use niji_atmosphere::BandGas;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::DensityProfile;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::STANDARD_PRESSURE_PA;
use niji_atmosphere::USUAL_TOP_M;
use niji_exchange::DensityLaw;
use niji_geometry::EARTH;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::sections::Body;
use crate::sections::Sun;

/// A usual column of ozone, Dobson units.
const USUAL_OZONE_DOBSON: f64 = 300.0;
/// Precipitable water of the US standard atmosphere, cm.
const USUAL_WATER_CM: f64 = 1.42;

/// The section `[air]`; a scene without it lies in a vacuum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Air {
    /// What the air is made of, each at most once.
    #[schemars(length(min = 1), extend("uniqueItems" = true))]
    pub constituents: Vec<Constituent>,
    /// Whose constants the molecules have: `bodhaine` where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rayleigh: Option<RayleighModel>,
    /// Pressure at sea level, hPa: 1013.25 where it is left out. The constants of `nishita` have a
    /// pressure of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 2000.0))]
    pub pressure_hpa: Option<f64>,
    /// The kind of haze: `clear` where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub aerosol: Option<Haze>,
    /// How far one sees through the haze, km; its kind says where it is left out. Below 1 km it is fog, which
    /// lies as much lower as it is denser.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub visibility_km: Option<f64>,
    /// Vertical column of ozone, Dobson units: 300 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10000.0))]
    pub ozone_dobson: Option<f64>,
    /// Water in a vertical column of vapor, cm: 1.42 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 20.0))]
    pub precipitable_water_cm: Option<f64>,
    /// Densities by height in the place of a constituent's own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<Layer>,
}

/// Density of one constituent by height.
///
/// Densities are relative: how much of it there is in a vertical column stays, and where a
/// visibility is given, how much of it there is at sea level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Layer {
    /// Which constituent.
    pub constituent: Constituent,
    /// How the density runs between the heights: linearly where it is left out.
    #[serde(default)]
    pub between: LayerLaw,
    /// Rising heights above sea level, m. Above the last there is nothing, below the first as much as there: a
    /// layer aloft begins with a density of 0.
    pub height_m: Vec<f64>,
    /// Relative density at each height.
    pub density: Vec<f64>,
}

/// How the density runs between two heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LayerLaw {
    /// Linearly.
    #[default]
    Linear,
    /// Like an exponential, never 0.
    Exponential,
}

impl Layer {
    fn profile(&self) -> Result<DensityProfile, niji_atmosphere::Error> {
        let (n_heights, n_densities) = (self.height_m.len(), self.density.len());
        if n_heights != n_densities {
            let problem =
                format!("{n_heights} heights and {n_densities} densities found, expected pairs");
            return Err(niji_atmosphere::Error::Profile { problem });
        }
        let pairs = self.height_m.iter().zip(&self.density);
        Ok(DensityProfile::Tabulated {
            law: match self.between {
                LayerLaw::Linear => DensityLaw::Linear,
                LayerLaw::Exponential => DensityLaw::Exponential,
            },
            nodes: pairs
                .map(|(&height_m, &density)| [height_m, density])
                .collect(),
        })
    }
}

/// Something that air is made of.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Constituent {
    /// Molecules, which scatter without absorbing.
    Rayleigh,
    /// Haze.
    Aerosol,
    /// Ozone, which absorbs yellow and orange light.
    Ozone,
    /// Water vapor, which absorbs around 590 and 720 nm.
    WaterVapor,
    /// Oxygen, which absorbs around 690 and 760 nm.
    Oxygen,
}

impl Constituent {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rayleigh => "rayleigh",
            Self::Aerosol => "aerosol",
            Self::Ozone => "ozone",
            Self::WaterVapor => "water-vapor",
            Self::Oxygen => "oxygen",
        }
    }
}

/// Whose constants Rayleigh scattering has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RayleighModel {
    /// Bodhaine, Wood, Dutton and Slusser, J. Atmos. Oceanic Technol. 16, 1854-1861 (1999).
    Bodhaine,
    /// The constants of Nishita, Miyawaki and Nakamae (1987), 3 to 7 % stronger.
    Nishita,
}

/// A kind of haze.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// A setting that belongs to constituents none of which the air has: (key, constituent).
    pub fn idle_setting(&self) -> Option<(&'static str, Constituent)> {
        use Constituent::{Aerosol, Oxygen, Ozone, Rayleigh, WaterVapor};
        let under_pressure: &[_] = match self.rayleigh {
            Some(RayleighModel::Nishita) => &[Oxygen],
            Some(RayleighModel::Bodhaine) | None => &[Rayleigh, Oxygen],
        };
        let settings: [(_, _, &[Constituent]); 6] = [
            ("rayleigh", self.rayleigh.is_some(), &[Rayleigh]),
            ("pressure_hpa", self.pressure_hpa.is_some(), under_pressure),
            ("aerosol", self.aerosol.is_some(), &[Aerosol]),
            ("visibility_km", self.visibility_km.is_some(), &[Aerosol]),
            ("ozone_dobson", self.ozone_dobson.is_some(), &[Ozone]),
            (
                "precipitable_water_cm",
                self.precipitable_water_cm.is_some(),
                &[WaterVapor],
            ),
        ];
        let idle_layer = |layer: &&Layer| !self.constituents.contains(&layer.constituent);
        if let Some(layer) = self.layers.iter().find(idle_layer) {
            return Some(("layers", layer.constituent));
        }
        settings
            .into_iter()
            .find(|(_, given, of)| *given && !of.iter().any(|one| self.constituents.contains(one)))
            .map(|(key, _, of)| (key, of[0]))
    }

    /// Does its table depend on what shines from where? Water vapor and oxygen absorb in bands, which
    /// are tabulated for the path of the sun's light; and moonlight is no sunlight.
    pub fn depends_on(&self, sun: &Sun) -> bool {
        let bands = [Constituent::WaterVapor, Constituent::Oxygen];
        let has_bands = bands.iter().any(|gas| self.constituents.contains(gas));
        has_bands || sun.body != Body::Sun
    }

    /// The air as the stage that tabulates it takes it.
    ///
    /// # Errors
    /// If a number lies outside its range; never for the air of a scene that was read from a file.
    pub fn model(
        &self,
        wavelengths: WavelengthGrid,
        ground: Reflectance,
        sun: &Sun,
    ) -> Result<AirModel, niji_atmosphere::Error> {
        let constituents = self.constituents.iter();
        let constituents =
            constituents.map(|constituent| self.layered(*constituent, &wavelengths, sun));
        Ok(AirModel {
            planet: EARTH,
            top_height_m: USUAL_TOP_M,
            wavelengths,
            sun_scale: sun.irradiance_scale(),
            ground,
            constituents: constituents.collect::<Result<_, _>>()?,
        })
    }

    /// A constituent with the density that its layer gives it.
    fn layered(
        &self,
        constituent: Constituent,
        wavelengths: &WavelengthGrid,
        sun: &Sun,
    ) -> Result<niji_atmosphere::Constituent, niji_atmosphere::Error> {
        let usual = self.usual(constituent, wavelengths, sun)?;
        let mut layers = self
            .layers
            .iter()
            .filter(|layer| layer.constituent == constituent);
        let Some(layer) = layers.next() else {
            return Ok(usual);
        };
        if layers.next().is_some() {
            let problem = format!("two layers of {} found, expected one", constituent.name());
            return Err(niji_atmosphere::Error::Profile { problem });
        }
        let keeps_ground = constituent == Constituent::Aerosol && self.visibility_km.is_some();
        if keeps_ground {
            usual.with_ground_density_in(layer.profile()?)
        } else {
            usual.with_column_in(layer.profile()?)
        }
    }

    /// A constituent with the density of its own.
    fn usual(
        &self,
        constituent: Constituent,
        wavelengths: &WavelengthGrid,
        sun: &Sun,
    ) -> Result<niji_atmosphere::Constituent, niji_atmosphere::Error> {
        let band = |gas: BandGas| {
            let air_mass = gas.air_mass(EARTH, sun.direction().y);
            gas.constituent(wavelengths, air_mass)
        };
        let pressure_pa = self
            .pressure_hpa
            .map_or(STANDARD_PRESSURE_PA, |hpa| 100.0 * hpa);
        match constituent {
            Constituent::Rayleigh => match self.rayleigh {
                Some(RayleighModel::Nishita) => NishitaAir::PUBLISHED.constituent(wavelengths),
                Some(RayleighModel::Bodhaine) | None => {
                    BodhaineAir::at_pressure(pressure_pa).constituent(wavelengths)
                }
            },
            Constituent::Aerosol => self.haze()?.constituent(wavelengths),
            Constituent::Ozone => {
                let column_dobson = self.ozone_dobson.unwrap_or(USUAL_OZONE_DOBSON);
                OzoneLayer::of_column(column_dobson).constituent(wavelengths)
            }
            Constituent::WaterVapor => band(BandGas::WaterVapor {
                precipitable_cm: self.precipitable_water_cm.unwrap_or(USUAL_WATER_CM),
            }),
            Constituent::Oxygen => band(BandGas::Oxygen { pressure_pa }),
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
