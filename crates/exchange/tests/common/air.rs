//! A small table of air with diffuse light, for tests.

use std::f64::consts::PI;

use ndarray::Array2;
use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_exchange::DiffuseLight;
use niji_exchange::harmonics;
use niji_exchange::moment_index;
use niji_radiometry::WavelengthGrid;

pub(crate) const N_WAVELENGTHS: usize = 2;
pub(crate) const MAX_DEGREE: usize = 3;

pub(crate) fn even_air(name: &str) -> AirConstituent {
    AirConstituent {
        name: name.to_owned(),
        extinction_m1: vec![1e-5; N_WAVELENGTHS],
        scattering_m1: vec![1e-5; N_WAVELENGTHS],
        law: DensityLaw::Linear,
        height_m: vec![0.0, 1e5],
        density: vec![1.0, 1.0],
        reach_height_m: Vec::new(),
        reach_mu: Vec::new(),
        reach_m: Array2::zeros((0, 0)),
        phase_angle_rad: vec![0.0, PI],
        phase_sr1: Array2::from_elem((N_WAVELENGTHS, 2), 0.25 / PI),
    }
}

/// Light whose moments at each node are those of a ray from a direction, times a number of the node.
pub(crate) fn beam_light(n_constituents: usize, cos_zenith: f64, azimuth_rad: f64) -> DiffuseLight {
    let (height_m, sun_zenith_rad) = (vec![0.0, 2e3, 1e5], vec![0.0, 0.5, 1.5]);
    let y = harmonics(MAX_DEGREE, cos_zenith);
    let mut moments = Vec::new();
    for height in 0..3 {
        for sun in 0..3 {
            for l in 0..=MAX_DEGREE {
                for m in 0..=l {
                    let moment = y[moment_index(l, m)] * (m as f64 * azimuth_rad).cos();
                    let node = f64::from(1 + height + 10 * sun);
                    moments.extend([(moment * node) as f32; N_WAVELENGTHS]);
                }
            }
        }
    }
    DiffuseLight {
        height_m,
        sun_zenith_rad,
        max_degree: MAX_DEGREE,
        moments,
        on_ground: vec![0.25; 3 * N_WAVELENGTHS],
        phase_moments: vec![0.5; n_constituents * (MAX_DEGREE + 1) * N_WAVELENGTHS],
    }
}

/// A table of air whose second constituent bears the name of a part.
pub(crate) fn air_table() -> AtmosphereTable {
    let constituents = vec![even_air("haze"), even_air("diffuse_light")];
    AtmosphereTable {
        planet_radius_m: 6.371e6,
        top_height_m: 1e5,
        wavelengths: WavelengthGrid::new(450.0, 100.0, N_WAVELENGTHS).unwrap(),
        sun_irradiance: vec![1.5; N_WAVELENGTHS],
        ground_albedo: vec![0.25; N_WAVELENGTHS],
        diffuse: Some(beam_light(constituents.len(), 0.5, 1.0)),
        constituents,
    }
}
