//! What the air is made of, by flags: the section `[air]` of a scene, and what scenes do not set.

use clap::Arg;
use clap::Args;
use niji_atmosphere::AirModel;
use niji_atmosphere::KingFactor;
use niji_atmosphere::NishitaAir;
use niji_atmosphere::USUAL_TOP_M;
use niji_geometry::EARTH;
use niji_radiometry::Reflectance;
use niji_radiometry::WavelengthGrid;
use niji_scene::Air;
use niji_scene::Constituent;
use niji_scene::RayleighModel;
use niji_scene::Sun;
use serde_json::json;

use crate::failure::Failure;
use crate::schema_flags::Flagged;
use crate::schema_flags::Flags;
use crate::schema_flags::Given;

/// The air by flags.
#[derive(Debug, Args)]
pub(super) struct AirFlags {
    #[command(flatten)]
    section: Given<Air>,
    #[command(flatten)]
    nishita: Option<NishitaFlags>,
    #[command(flatten)]
    planet: PlanetFlags,
}

impl Flagged for Air {
    fn flags() -> Flags {
        Flags::of::<Self>().with_default("constituents", &json!([Constituent::Rayleigh]))
    }

    fn arguments() -> Vec<Arg> {
        let arguments = Self::flags().arguments().into_iter();
        arguments
            .map(|flag| flag.conflicts_with("scene").help_heading("Air"))
            .collect()
    }
}

/// The constants that publications with `nishita` differ in.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Constants of --rayleigh nishita")]
#[group(multiple = true, conflicts_with = "scene")]
struct NishitaFlags {
    /// Refractive index n [default: 1.0003].
    #[arg(long, value_name = "N")]
    refractive_index: Option<f64>,
    /// Molecules N_s at sea level [default: 2.545e25].
    #[arg(long, value_name = "1/M3")]
    molecules_m3: Option<f64>,
    /// Scale height of the molecules [default: 7994].
    #[arg(long, value_name = "M")]
    rayleigh_scale_height_m: Option<f64>,
    /// King factor F of cross section and phase function [default: 1].
    #[arg(long, value_name = "F")]
    king_factor: Option<f64>,
}

impl From<NishitaFlags> for NishitaAir {
    fn from(given: NishitaFlags) -> Self {
        let usual = Self::PUBLISHED;
        Self {
            refractive_index: given.refractive_index.unwrap_or(usual.refractive_index),
            molecules_m3: given.molecules_m3.unwrap_or(usual.molecules_m3),
            scale_height_m: given
                .rayleigh_scale_height_m
                .unwrap_or(usual.scale_height_m),
            king_factor: given
                .king_factor
                .map_or(usual.king_factor, KingFactor::Constant),
        }
    }
}

/// What is below and above the air.
#[derive(Debug, Args)]
#[command(next_help_heading = "Planet")]
#[group(multiple = true, conflicts_with = "scene")]
struct PlanetFlags {
    /// Radius of the planet.
    #[arg(long, value_name = "M", default_value_t = EARTH.radius_m)]
    planet_radius_m: f64,
    /// Height above which there is no air.
    #[arg(long, value_name = "M", default_value_t = USUAL_TOP_M)]
    top_height_m: f64,
    /// Share of the light that the ground gives back.
    #[arg(long, value_name = "A", default_value_t = 0.0)]
    ground_albedo: f64,
}

impl AirFlags {
    /// The air under a sun.
    pub(super) fn model(
        &self,
        wavelengths: WavelengthGrid,
        sun: &Sun,
    ) -> Result<AirModel, Failure> {
        let air = self.section.read()?;
        if let Some((key, constituent)) = air.idle_setting() {
            return Err(Failure::Usage(format!(
                "--{} has no effect without {} among --constituents",
                key.replace('_', "-"),
                constituent.name()
            )));
        }
        let ground = Reflectance::Even(self.planet.ground_albedo);
        let mut model = air.model(wavelengths, ground, sun).map_err(usage)?;
        model.planet.radius_m = self.planet.planet_radius_m;
        model.top_height_m = self.planet.top_height_m;
        if let Some(nishita) = self.nishita {
            let molecules = NishitaAir::from(nishita);
            let molecules = molecules.constituent(&wavelengths).map_err(usage)?;
            let is_nishita = air.rayleigh == Some(RayleighModel::Nishita);
            let mut constituents = model.constituents.iter_mut();
            let place = constituents.find(|one| is_nishita && one.name == molecules.name);
            *place.ok_or_else(|| {
                Failure::Usage("constants of nishita found without --rayleigh nishita".to_owned())
            })? = molecules;
        }
        Ok(model)
    }
}

fn usage(error: impl std::fmt::Display) -> Failure {
    Failure::Usage(error.to_string())
}
