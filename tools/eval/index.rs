//! `niji eval index`: refractive indices.

use clap::Args;
use clap::ValueEnum;
use niji_radiometry::Nanometers;
use niji_radiometry::air_refractive_index;
use niji_radiometry::ice_refractive_index;
use niji_radiometry::sea_water_refractive_index;
use niji_radiometry::water_refractive_index;

use super::line;
use super::wavelengths_nm;
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
    /// Salinity of sea water.
    #[arg(long, value_name = "PER_MILLE", default_value_t = 35.0)]
    salinity_per_mille: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Material {
    Water,
    SeaWater,
    Ice,
    Air,
}

pub(super) fn csv(arguments: &IndexArguments) -> Result<String, Failure> {
    let wavelengths_nm = wavelengths_nm(&arguments.wavelengths_nm)?;
    let temperature_c = arguments.temperature_c;
    if !(-30.0..=100.0).contains(&temperature_c) {
        return Err(Failure::Usage(format!(
            "found {temperature_c} C, expected -30 to 100 C"
        )));
    }
    let salinity = arguments.salinity_per_mille;
    if !(0.0..=40.0).contains(&salinity) {
        return Err(Failure::Usage(format!(
            "found {salinity} per mille, expected 0 to 40"
        )));
    }
    let mut csv = "wavelength_nm,n,k\n".to_owned();
    for nm in wavelengths_nm {
        let wavelength = Nanometers(nm);
        let (n, k) = match arguments.material {
            Material::Water => (water_refractive_index(wavelength, temperature_c), 0.0),
            Material::SeaWater => (
                sea_water_refractive_index(wavelength, temperature_c, salinity),
                0.0,
            ),
            Material::Ice => ice_refractive_index(wavelength),
            Material::Air => (air_refractive_index(wavelength), 0.0),
        };
        csv += &line(&[nm, n, k]);
    }
    Ok(csv)
}
