//! `niji eval index`: refractive indices.

use clap::Args;
use clap::ValueEnum;
use niji_radiometry::Nanometers;
use niji_radiometry::Water;
use niji_radiometry::air_refractive_index;
use niji_radiometry::ice_refractive_index;
use niji_radiometry::sea_water_refractive_index;

use super::csv::line;
use super::csv::wavelengths_nm;
use crate::failure::Failure;

/// Refractive indices: of water and sea water relative to air, of air and ice relative to vacuum.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  niji eval index --material water --wavelengths-nm 400,550,700\n
Columns: wavelength_nm,n,k (k = 0 where absorption does not matter)"
)]
pub(super) struct IndexArguments {
    /// The material.
    #[arg(long)]
    material: Material,
    /// Wavelengths in the air, 300 to 1000 nm.
    #[arg(long, value_name = "NM,NM,…")]
    wavelengths_nm: String,
    /// Temperature of water.
    #[arg(
        long,
        value_name = "C",
        default_value_t = 20.0,
        allow_negative_numbers = true
    )]
    temperature_c: f64,
    /// Salinity [default: 0 of water, 35 of sea-water].
    #[arg(long, value_name = "PER_MILLE")]
    salinity_per_mille: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Material {
    /// Water as drops are made of, with salt if any is given.
    Water,
    /// Sea water by the published formula alone (Quan and Fry 1995), within 4e-5 of water with salt.
    SeaWater,
    Ice,
    Air,
}

pub(super) fn csv(arguments: &IndexArguments) -> Result<String, Failure> {
    let wavelengths_nm = wavelengths_nm(&arguments.wavelengths_nm)?;
    let water = water(arguments);
    let sound = water.check();
    sound.map_err(|error| Failure::Usage(error.to_string()))?;
    let mut csv = "wavelength_nm,n,k\n".to_owned();
    for nm in wavelengths_nm {
        let wavelength = Nanometers(nm);
        let (n, k) = match arguments.material {
            Material::Water => (water.refractive_index(wavelength), 0.0),
            Material::SeaWater => (published(wavelength, water), 0.0),
            Material::Ice => ice_refractive_index(wavelength),
            Material::Air => (air_refractive_index(wavelength), 0.0),
        };
        csv += &line(&[nm, n, k]);
    }
    Ok(csv)
}

fn water(arguments: &IndexArguments) -> Water {
    let usual = match arguments.material {
        Material::SeaWater => Water::of_the_sea(arguments.temperature_c),
        Material::Water | Material::Ice | Material::Air => Water::pure(arguments.temperature_c),
    };
    let salinity = arguments.salinity_per_mille;
    Water {
        salinity_per_mille: salinity.unwrap_or(usual.salinity_per_mille),
        ..usual
    }
}

fn published(wavelength: Nanometers, water: Water) -> f64 {
    sea_water_refractive_index(wavelength, water.temperature_c, water.salinity_per_mille)
}
