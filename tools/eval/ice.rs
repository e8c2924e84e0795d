//! `niji eval ice`: transmittance of a cube of ice for light that crosses it once.

use clap::Args;
use glam::DVec3;
use niji_geometry::Aabb;
use niji_ice::Body;
use niji_ice::ice_absorption_per_m;
use niji_ice::one_crossing;
use niji_radiometry::Nanometers;

use super::csv::line;
use super::csv::wavelengths_nm;
use crate::failure::Failure;

/// Share of light that passes a cube of pure ice once: in anywhere by the cosine law, straight to
/// another face, without what surfaces reflect.
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  niji eval ice --cube-m 50 --wavelengths-nm 400,520,550,590,700\n
Columns: wavelength_nm,absorption_per_m,transmittance,standard_error"
)]
pub(super) struct IceArguments {
    /// Edge of the cube, m.
    #[arg(long, value_name = "M")]
    cube_m: f64,
    /// Wavelengths, 300 to 1000 nm.
    #[arg(long, value_name = "NM,NM,…")]
    wavelengths_nm: String,
    /// Chords to draw.
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u32).range(1..))]
    chords: u32,
    /// Another seed draws other chords.
    #[arg(long, value_name = "SEED", default_value_t = 0)]
    seed: u64,
}

pub(super) fn csv(arguments: &IceArguments) -> Result<String, Failure> {
    let wavelengths_nm = wavelengths_nm(&arguments.wavelengths_nm)?;
    let edge_m = arguments.cube_m;
    if !(1e-6..=1e6).contains(&edge_m) {
        return Err(Failure::Usage(format!(
            "found a cube of {edge_m} m, expected 1e-6 to 1e6 m"
        )));
    }
    let (min, max) = (DVec3::ZERO, DVec3::splat(edge_m));
    let cube = Body::of_box(Aabb { min, max });
    let cube = cube.map_err(|error| Failure::Usage(error.to_string()))?;
    let absorption = wavelengths_nm.iter().map(|&nm| Nanometers(nm));
    let absorption: Vec<f64> = absorption.map(ice_absorption_per_m).collect();
    let crossings = one_crossing(&cube, &absorption, arguments.chords, arguments.seed);
    let mut csv = "wavelength_nm,absorption_per_m,transmittance,standard_error\n".to_owned();
    for ((nm, alpha), crossing) in wavelengths_nm.iter().zip(absorption).zip(crossings) {
        csv += &line(&[*nm, alpha, crossing.transmittance, crossing.standard_error]);
    }
    Ok(csv)
}
