//! What the air is made of, by flags: the section `[air]` of a scene, and the constants of its
//! constituents, which scenes do not set.

use clap::ArgMatches;
use clap::Args;
use clap::Command;
use clap::FromArgMatches;
use clap::ValueEnum;
use niji_atmosphere::Aerosol;
use niji_atmosphere::AerosolLobe;
use niji_atmosphere::AirComponent;
use niji_atmosphere::AirModel;
use niji_atmosphere::BodhaineAir;
use niji_atmosphere::KingFactor;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::OzoneLayer;
use niji_geometry::EARTH;
use niji_radiometry::WavelengthGrid;
use niji_scene::Air;
use niji_scene::Constituent;
use niji_scene::RayleighModel;
use niji_scene::Sun;
use serde_json::json;

use crate::failure::Failure;
use crate::schema_flags;
use crate::schema_flags::Flags;

/// The air by flags.
#[derive(Debug, Args)]
pub(super) struct AirFlags {
    #[command(flatten)]
    section: SectionFlags,
    #[command(flatten)]
    constants: Constants,
}

/// The flags of a section `[air]`.
#[derive(Debug)]
struct SectionFlags(ArgMatches);

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Lobe {
    HenyeyGreenstein,
    CornetteShanks,
}

/// What is usual unless it is given.
#[derive(Debug, Args)]
#[command(next_help_heading = "Constants of the air")]
#[group(multiple = true, conflicts_with = "scene")]
struct Constants {
    /// Refractive index n of nishita [default: 1.0003].
    #[arg(long, value_name = "N")]
    refractive_index: Option<f64>,
    /// Molecules N_s at sea level of nishita [default: 2.545e25].
    #[arg(long, value_name = "1/M3")]
    molecules_m3: Option<f64>,
    /// Scale height of the molecules [default: nishita 7994, bodhaine 8449.65].
    #[arg(long, value_name = "M")]
    rayleigh_scale_height_m: Option<f64>,
    /// King factor F of cross section and phase function, 1 without depolarization, or `air`
    /// [default: bodhaine air, nishita 1].
    #[arg(long, value_name = "F|air", value_parser = king_factor)]
    king_factor: Option<KingFactor>,
    /// Bottom, peak and top of the layer of ozone [default: 10000,25000,40000].
    #[arg(long, value_name = "M,M,M", value_delimiter = ',')]
    ozone_heights_m: Option<Vec<f64>>,
    /// Exponent alpha of the Angstrom law.
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    angstrom_alpha: Option<f64>,
    /// Vertical optical depth of the haze at 1 um, beta of the Angstrom law, instead of --visibility-km.
    #[arg(long, value_name = "BETA", conflicts_with = "visibility-km")]
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
    /// Path over the vertical one on which water-vapor and oxygen are exact [default: the sun's].
    #[arg(long, value_name = "M")]
    band_air_mass: Option<f64>,
    /// Radius of the planet [default: 6371000].
    #[arg(long, value_name = "M")]
    planet_radius_m: Option<f64>,
    /// Height above which there is no air [default: 100000].
    #[arg(long, value_name = "M")]
    top_height_m: Option<f64>,
    /// Share of the light that the ground gives back.
    #[arg(long, value_name = "A", default_value_t = 0.0)]
    ground_albedo: f64,
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
        sun: &Sun,
    ) -> Result<AirModel, Failure> {
        let air = self.section.air()?;
        let constants = &self.constants;
        constants.check_idle(&air)?;
        let albedo = constants.ground_albedo;
        let mut model = air.model(wavelengths, albedo, sun).map_err(usage)?;
        model.planet.radius_m = constants.planet_radius_m.unwrap_or(EARTH.radius_m);
        model.top_height_m = constants.top_height_m.unwrap_or(model.top_height_m);
        for component in &mut model.components {
            *component = match component {
                AirComponent::RayleighNishita => constants.nishita(&wavelengths)?,
                AirComponent::RayleighBodhaine { pressure_pa } => {
                    constants.bodhaine(*pressure_pa, &wavelengths)?
                }
                AirComponent::Ozone { column_dobson } => {
                    constants.ozone(*column_dobson, &wavelengths)?
                }
                AirComponent::Aerosol(usual) => constants.haze(*usual, air.visibility_km)?,
                AirComponent::Band { gas, .. } => {
                    let of_sun = || gas.air_mass(model.planet, sun.direction().y);
                    AirComponent::Band {
                        gas: *gas,
                        air_mass: constants.band_air_mass.unwrap_or_else(of_sun),
                    }
                }
                AirComponent::Custom(_) => continue,
            };
        }
        Ok(model)
    }
}

impl SectionFlags {
    fn flags() -> Flags {
        Flags::of::<Air>().with_default("constituents", &json!([Constituent::Rayleigh]))
    }

    fn air(&self) -> Result<Air, Failure> {
        let air: Air = schema_flags::read(Self::flags().value(&self.0)?)?;
        match air.idle_setting() {
            Some((key, constituent)) => Err(idle(&key.replace('_', "-"), constituent.name())),
            None => Ok(air),
        }
    }
}

impl Args for SectionFlags {
    fn augment_args(command: Command) -> Command {
        let flags = Self::flags().arguments().into_iter();
        command.args(flags.map(|flag| flag.conflicts_with("scene").help_heading("Air")))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SectionFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(matches.clone()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0 = matches.clone();
        Ok(())
    }
}

impl Constants {
    fn nishita(&self, wavelengths: &WavelengthGrid) -> Result<AirComponent, Failure> {
        let usual = NishitaAir::PUBLISHED;
        let air = NishitaAir {
            refractive_index: self.refractive_index.unwrap_or(usual.refractive_index),
            molecules_m3: self.molecules_m3.unwrap_or(usual.molecules_m3),
            scale_height_m: self.rayleigh_scale_height_m.unwrap_or(usual.scale_height_m),
            king_factor: self.king_factor.unwrap_or(usual.king_factor),
        };
        air.constituent(wavelengths)
            .map(AirComponent::Custom)
            .map_err(usage)
    }

    fn bodhaine(
        &self,
        pressure_pa: f64,
        wavelengths: &WavelengthGrid,
    ) -> Result<AirComponent, Failure> {
        let usual = BodhaineAir::at_pressure(pressure_pa);
        let air = BodhaineAir {
            scale_height_m: self.rayleigh_scale_height_m.unwrap_or(usual.scale_height_m),
            king_factor: self.king_factor.unwrap_or(usual.king_factor),
            ..usual
        };
        air.constituent(wavelengths)
            .map(AirComponent::Custom)
            .map_err(usage)
    }

    fn ozone(
        &self,
        column_dobson: f64,
        wavelengths: &WavelengthGrid,
    ) -> Result<AirComponent, Failure> {
        let mut layer = OzoneLayer::of_column(column_dobson);
        if let Some(heights_m) = &self.ozone_heights_m {
            let n = heights_m.len();
            let message = format!("found {n} heights of ozone, expected 3: bottom, peak, top");
            layer.heights_m = heights_m
                .as_slice()
                .try_into()
                .map_err(|_| Failure::Usage(message))?;
        }
        layer
            .constituent(wavelengths)
            .map(AirComponent::Custom)
            .map_err(usage)
    }

    fn haze(&self, usual: Aerosol, visibility_km: Option<f64>) -> Result<AirComponent, Failure> {
        let (AerosolLobe::HenyeyGreenstein { asymmetry: usual_g }
        | AerosolLobe::CornetteShanks { parameter: usual_g }) = usual.lobe;
        let g = self.asymmetry.unwrap_or(usual_g);
        let albedo = self.single_scattering_albedo;
        let haze = Aerosol {
            angstrom_exponent: self.angstrom_alpha.unwrap_or(usual.angstrom_exponent),
            optical_depth_at_1_um: self.angstrom_beta.unwrap_or(usual.optical_depth_at_1_um),
            single_scattering_albedo: albedo.unwrap_or(usual.single_scattering_albedo),
            scale_height_m: self.aerosol_scale_height_m.unwrap_or(usual.scale_height_m),
            lobe: match self.phase_function {
                Some(Lobe::HenyeyGreenstein) => AerosolLobe::HenyeyGreenstein { asymmetry: g },
                Some(Lobe::CornetteShanks) | None => AerosolLobe::CornetteShanks { parameter: g },
            },
        };
        // The constants change how much haze makes a visibility.
        let seen = visibility_km.map(|km| haze.with_visibility_m(1e3 * km));
        seen.unwrap_or(Ok(haze))
            .map(AirComponent::Aerosol)
            .map_err(usage)
    }

    /// Refuses a constant of something that the air does not have.
    fn check_idle(&self, air: &Air) -> Result<(), Failure> {
        let has = |constituent| air.constituents.contains(&constituent);
        let rayleigh = (has(Constituent::Rayleigh), "rayleigh");
        let is_nishita = rayleigh.0 && air.rayleigh == Some(RayleighModel::Nishita);
        let nishita = (is_nishita, "--rayleigh nishita and rayleigh");
        let aerosol = (has(Constituent::Aerosol), "aerosol");
        let ozone = (has(Constituent::Ozone), "ozone");
        let bands = has(Constituent::WaterVapor) || has(Constituent::Oxygen);
        let bands = (bands, "water-vapor or oxygen");
        let users = [
            ("refractive-index", self.refractive_index.is_some(), nishita),
            ("molecules-m3", self.molecules_m3.is_some(), nishita),
            (
                "rayleigh-scale-height-m",
                self.rayleigh_scale_height_m.is_some(),
                rayleigh,
            ),
            ("king-factor", self.king_factor.is_some(), rayleigh),
            ("ozone-heights-m", self.ozone_heights_m.is_some(), ozone),
            ("angstrom-alpha", self.angstrom_alpha.is_some(), aerosol),
            ("angstrom-beta", self.angstrom_beta.is_some(), aerosol),
            (
                "single-scattering-albedo",
                self.single_scattering_albedo.is_some(),
                aerosol,
            ),
            ("asymmetry", self.asymmetry.is_some(), aerosol),
            ("phase-function", self.phase_function.is_some(), aerosol),
            (
                "aerosol-scale-height-m",
                self.aerosol_scale_height_m.is_some(),
                aerosol,
            ),
            ("band-air-mass", self.band_air_mass.is_some(), bands),
        ];
        for (flag, is_given, (is_there, needed)) in users {
            if is_given && !is_there {
                return Err(idle(flag, needed));
            }
        }
        Ok(())
    }
}

fn idle(flag: &str, needed: &str) -> Failure {
    Failure::Usage(format!(
        "--{flag} has no effect without {needed} among --constituents"
    ))
}

fn usage(error: impl std::fmt::Display) -> Failure {
    Failure::Usage(error.to_string())
}
