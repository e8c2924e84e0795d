//! What the air is made of, by flags: every physical constant can be set.

use clap::Args;
use clap::ValueEnum;
use niji_atmosphere::Aerosol;
use niji_atmosphere::AerosolKind;
use niji_atmosphere::AerosolLobe;
use niji_atmosphere::AirComponent;
use niji_atmosphere::AirModel;
use niji_atmosphere::BandGas;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::KingFactor;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::OzoneLayer;
use niji_atmosphere::USUAL_TOP_M;
use niji_geometry::EARTH;
use niji_geometry::Planet;
use niji_radiometry::WavelengthGrid;

use crate::failure::Failure;

/// Pressure at sea level, hPa.
const STANDARD_PRESSURE_HPA: f64 = 1013.25;
/// Usual column of ozone, Dobson units.
const USUAL_OZONE_DOBSON: f64 = 300.0;
/// Precipitable water of the US standard atmosphere, cm.
const USUAL_WATER_CM: f64 = 1.42;

/// What air can be made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    Rayleigh,
    Ozone,
    Aerosol,
    WaterVapor,
    Oxygen,
}

/// Whose constants the molecules have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Rayleigh {
    Bodhaine,
    Nishita,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Haze {
    Clear,
    Rural,
    Maritime,
    Urban,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Lobe {
    HenyeyGreenstein,
    CornetteShanks,
}

/// The air by its constants.
#[derive(Debug, Args)]
#[command(next_help_heading = "Air")]
#[group(id = "air_flags", multiple = true, conflicts_with = "scene")]
pub(super) struct AirFlags {
    /// What the air is made of [default: rayleigh].
    #[arg(long, value_name = "NAME,NAME,…", value_delimiter = ',')]
    constituents: Option<Vec<Part>>,
    /// Whose constants the molecules have [default: bodhaine].
    #[arg(long, value_name = "MODEL")]
    rayleigh: Option<Rayleigh>,
    /// Refractive index n of nishita [default: 1.0003].
    #[arg(long, value_name = "N")]
    refractive_index: Option<f64>,
    /// Molecules N_s at sea level of nishita [default: 2.545e25].
    #[arg(long, value_name = "1/M3")]
    molecules_m3: Option<f64>,
    /// Scale height of the molecules [default: nishita 7994, bodhaine 8449.65].
    #[arg(long, value_name = "M")]
    rayleigh_scale_height_m: Option<f64>,
    /// Pressure at sea level, for bodhaine and oxygen [default: 1013.25].
    #[arg(long, value_name = "HPA")]
    pressure_hpa: Option<f64>,
    /// King factor F of cross section and phase function, 1 without depolarization, or `air`
    /// [default: bodhaine air, nishita 1].
    #[arg(long, value_name = "F|air", value_parser = king_factor)]
    king_factor: Option<KingFactor>,
    /// Column of ozone [default: 300].
    #[arg(long, value_name = "DU")]
    ozone_dobson: Option<f64>,
    /// Bottom, peak and top of the layer of ozone [default: 10000,25000,40000].
    #[arg(long, value_name = "M,M,M", value_delimiter = ',')]
    ozone_heights_m: Option<Vec<f64>>,
    /// Kind of haze, whose constants hold unless they are given [default: clear].
    #[arg(long, value_name = "KIND")]
    aerosol: Option<Haze>,
    /// Amount of haze by visibility, instead of --angstrom-beta.
    #[arg(long, value_name = "KM", conflicts_with = "angstrom_beta")]
    visibility_km: Option<f64>,
    /// Exponent alpha of the Angstrom law.
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    angstrom_alpha: Option<f64>,
    /// Vertical optical depth of the haze at 1 um, beta of the Angstrom law.
    #[arg(long, value_name = "BETA")]
    angstrom_beta: Option<f64>,
    /// Scattering over extinction of the haze.
    #[arg(long, value_name = "W0")]
    single_scattering_albedo: Option<f64>,
    /// Parameter g of the phase function of the haze.
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    asymmetry: Option<f64>,
    /// Phase function of the haze [default: cornette-shanks].
    #[arg(long, value_name = "NAME")]
    phase_function: Option<Lobe>,
    /// Scale height of the haze.
    #[arg(long, value_name = "M")]
    aerosol_scale_height_m: Option<f64>,
    /// Water in a vertical column, for water-vapor [default: 1.42].
    #[arg(long, value_name = "CM")]
    precipitable_water_cm: Option<f64>,
    /// Path over the vertical one on which water-vapor and oxygen are exact [default: the sun's].
    #[arg(long, value_name = "M")]
    band_air_mass: Option<f64>,
    /// Radius of the planet [default: 6371000].
    #[arg(long, value_name = "M")]
    planet_radius_m: Option<f64>,
    /// Height above which there is no air [default: 100000].
    #[arg(long, value_name = "M")]
    top_height_m: Option<f64>,
    /// Share of the light that the ground gives back [default: 0].
    #[arg(long, value_name = "A")]
    ground_albedo: Option<f64>,
}

fn king_factor(text: &str) -> Result<KingFactor, String> {
    if text == "air" {
        return Ok(KingFactor::Air);
    }
    match text.parse::<f64>() {
        Ok(factor) if factor >= 1.0 && factor.is_finite() => Ok(KingFactor::Constant(factor)),
        _ => Err(format!("found {text}, expected `air` or a number from 1")),
    }
}

impl AirFlags {
    /// The air under a sun.
    pub(super) fn model(
        &self,
        wavelengths: WavelengthGrid,
        cos_sun_zenith: f64,
    ) -> Result<AirModel, Failure> {
        self.check_idle_flags()?;
        let planet = Planet {
            radius_m: self.planet_radius_m.unwrap_or(EARTH.radius_m),
        };
        let mut components = Vec::new();
        for part in self.parts() {
            components.push(match part {
                Part::Rayleigh => self.molecules(&wavelengths)?,
                Part::Ozone => self.ozone(&wavelengths)?,
                Part::Aerosol => AirComponent::Aerosol(self.haze()?),
                Part::WaterVapor => self.band(
                    BandGas::WaterVapor {
                        precipitable_cm: self.precipitable_water_cm.unwrap_or(USUAL_WATER_CM),
                    },
                    planet,
                    cos_sun_zenith,
                ),
                Part::Oxygen => self.band(
                    BandGas::Oxygen {
                        pressure_pa: self.pressure_pa(),
                    },
                    planet,
                    cos_sun_zenith,
                ),
            });
        }
        Ok(AirModel {
            planet,
            top_height_m: self.top_height_m.unwrap_or(USUAL_TOP_M),
            wavelengths,
            sun_scale: 1.0,
            ground_albedo: self.ground_albedo.unwrap_or(0.0),
            components,
        })
    }

    fn parts(&self) -> Vec<Part> {
        self.constituents
            .clone()
            .unwrap_or_else(|| vec![Part::Rayleigh])
    }

    fn is_nishita(&self) -> bool {
        self.rayleigh == Some(Rayleigh::Nishita)
    }

    fn pressure_pa(&self) -> f64 {
        100.0 * self.pressure_hpa.unwrap_or(STANDARD_PRESSURE_HPA)
    }

    fn molecules(&self, wavelengths: &WavelengthGrid) -> Result<AirComponent, Failure> {
        let constituent = if self.is_nishita() {
            let published = NishitaAir::PUBLISHED;
            NishitaAir {
                refractive_index: self.refractive_index.unwrap_or(published.refractive_index),
                molecules_m3: self.molecules_m3.unwrap_or(published.molecules_m3),
                scale_height_m: self
                    .rayleigh_scale_height_m
                    .unwrap_or(published.scale_height_m),
                king_factor: self.king_factor.unwrap_or(published.king_factor),
            }
            .constituent(wavelengths)
        } else {
            let usual = BodhaineAir::at_pressure(self.pressure_pa());
            BodhaineAir {
                scale_height_m: self.rayleigh_scale_height_m.unwrap_or(usual.scale_height_m),
                king_factor: self.king_factor.unwrap_or(usual.king_factor),
                ..usual
            }
            .constituent(wavelengths)
        };
        constituent.map(AirComponent::Custom).map_err(usage)
    }

    fn ozone(&self, wavelengths: &WavelengthGrid) -> Result<AirComponent, Failure> {
        let mut layer = OzoneLayer::of_column(self.ozone_dobson.unwrap_or(USUAL_OZONE_DOBSON));
        if let Some(heights_m) = &self.ozone_heights_m {
            let message = || {
                Failure::Usage(format!(
                    "found {} heights of ozone, expected 3: bottom, peak, top",
                    heights_m.len()
                ))
            };
            layer.heights_m = heights_m.as_slice().try_into().map_err(|_| message())?;
        }
        layer
            .constituent(wavelengths)
            .map(AirComponent::Custom)
            .map_err(usage)
    }

    fn haze(&self) -> Result<Aerosol, Failure> {
        let kind = match self.aerosol.unwrap_or(Haze::Clear) {
            Haze::Clear => AerosolKind::Clear,
            Haze::Rural => AerosolKind::Rural,
            Haze::Maritime => AerosolKind::Maritime,
            Haze::Urban => AerosolKind::Urban,
        };
        let usual = kind.aerosol();
        let (AerosolLobe::HenyeyGreenstein { asymmetry: usual_g }
        | AerosolLobe::CornetteShanks { parameter: usual_g }) = usual.lobe;
        let g = self.asymmetry.unwrap_or(usual_g);
        let aerosol = Aerosol {
            angstrom_exponent: self.angstrom_alpha.unwrap_or(usual.angstrom_exponent),
            optical_depth_at_1_um: self.angstrom_beta.unwrap_or(usual.optical_depth_at_1_um),
            single_scattering_albedo: self
                .single_scattering_albedo
                .unwrap_or(usual.single_scattering_albedo),
            scale_height_m: self.aerosol_scale_height_m.unwrap_or(usual.scale_height_m),
            lobe: match self.phase_function {
                Some(Lobe::HenyeyGreenstein) => AerosolLobe::HenyeyGreenstein { asymmetry: g },
                Some(Lobe::CornetteShanks) | None => AerosolLobe::CornetteShanks { parameter: g },
            },
        };
        match self.visibility_km {
            Some(visibility_km) => aerosol
                .with_visibility_m(1e3 * visibility_km)
                .map_err(usage),
            None => Ok(aerosol),
        }
    }

    fn band(&self, gas: BandGas, planet: Planet, cos_sun_zenith: f64) -> AirComponent {
        let air_mass = self
            .band_air_mass
            .unwrap_or_else(|| gas.air_mass(planet, cos_sun_zenith));
        AirComponent::Band { gas, air_mass }
    }

    /// Refuses a constant of something that the air does not have.
    fn check_idle_flags(&self) -> Result<(), Failure> {
        let parts = self.parts();
        let has = |part: Part| parts.contains(&part);
        let molecules = has(Part::Rayleigh);
        let nishita = molecules && self.is_nishita();
        let pressure = (molecules && !self.is_nishita()) || has(Part::Oxygen);
        let bands = has(Part::WaterVapor) || has(Part::Oxygen);
        let users = [
            ("rayleigh", molecules, self.molecule_flags()),
            ("--rayleigh nishita", nishita, self.nishita_flags()),
            ("ozone", has(Part::Ozone), self.ozone_flags()),
            ("aerosol", has(Part::Aerosol), self.haze_flags()),
            (
                "water-vapor",
                has(Part::WaterVapor),
                self.precipitable_water_cm.map(|_| "precipitable-water-cm"),
            ),
            (
                "--rayleigh bodhaine or oxygen",
                pressure,
                self.pressure_hpa.map(|_| "pressure-hpa"),
            ),
            (
                "water-vapor or oxygen",
                bands,
                self.band_air_mass.map(|_| "band-air-mass"),
            ),
        ];
        for (needed, is_there, flag) in users {
            if let (false, Some(flag)) = (is_there, flag) {
                return Err(Failure::Usage(format!(
                    "--{flag} has no effect without {needed} among --constituents"
                )));
            }
        }
        Ok(())
    }

    /// The first flag given of those for molecules of either model.
    fn molecule_flags(&self) -> Option<&'static str> {
        let height = self.rayleigh_scale_height_m;
        self.rayleigh
            .map(|_| "rayleigh")
            .or(height.map(|_| "rayleigh-scale-height-m"))
            .or(self.king_factor.map(|_| "king-factor"))
    }

    fn nishita_flags(&self) -> Option<&'static str> {
        self.refractive_index
            .map(|_| "refractive-index")
            .or(self.molecules_m3.map(|_| "molecules-m3"))
    }

    fn ozone_flags(&self) -> Option<&'static str> {
        let heights = self.ozone_heights_m.as_ref();
        self.ozone_dobson
            .map(|_| "ozone-dobson")
            .or(heights.map(|_| "ozone-heights-m"))
    }

    fn haze_flags(&self) -> Option<&'static str> {
        let albedo = self.single_scattering_albedo;
        let height = self.aerosol_scale_height_m;
        self.aerosol
            .map(|_| "aerosol")
            .or(self.visibility_km.map(|_| "visibility-km"))
            .or(self.angstrom_alpha.map(|_| "angstrom-alpha"))
            .or(self.angstrom_beta.map(|_| "angstrom-beta"))
            .or(albedo.map(|_| "single-scattering-albedo"))
            .or(self.asymmetry.map(|_| "asymmetry"))
            .or(self.phase_function.map(|_| "phase-function"))
            .or(height.map(|_| "aerosol-scale-height-m"))
    }
}

fn usage(error: impl std::fmt::Display) -> Failure {
    Failure::Usage(error.to_string())
}
