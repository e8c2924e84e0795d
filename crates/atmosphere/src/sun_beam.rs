//! Direct sunlight at a point.
//!
//! E(lambda) = E_sun(lambda) * mean over the visible part of the disc of exp(-tau(lambda, mu))
//! Zero, not NaN, where the sun is below the horizon; from a height the sun is seen below 0 degrees.

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::sun_disc::elevation_above_horizon;
use crate::sun_disc::visible_strips;

/// Share of the sun's light that arrives at a point, by wavelength, 0 to 1.
///
/// `disc_radius` of 0 makes the sun a point.
pub fn sun_transmittance(
    air: &AtmosphereTable,
    height_m: f64,
    cos_sun_zenith: f64,
    disc_radius: Radians,
) -> Vec<f64> {
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    let elevation = elevation_above_horizon(planet, height_m, cos_sun_zenith);
    let n_wavelengths = air.wavelengths.len();
    let mut transmittance = vec![0.0; n_wavelengths];
    let center_rad = cos_sun_zenith.clamp(-1.0, 1.0).asin();
    for (offset_rad, share) in visible_strips(elevation, disc_radius) {
        // A point keeps the cosine as given: asin and sin would round a sun at the very horizon.
        let mu = if disc_radius.0 > 0.0 {
            (center_rad + offset_rad).sin()
        } else {
            cos_sun_zenith
        };
        for (transmittance, depth) in transmittance
            .iter_mut()
            .zip(optical_depths(air, height_m, mu))
        {
            *transmittance += share * (-depth).exp();
        }
    }
    transmittance
}

/// Optical depth to the top of the air by wavelength; one column for all of them.
fn optical_depths(air: &AtmosphereTable, height_m: f64, mu: f64) -> Vec<f64> {
    let mut depths = vec![0.0; air.wavelengths.len()];
    for (index, constituent) in air.constituents.iter().enumerate() {
        let length_m = air.column_at(index, height_m, mu);
        for (depth, &extinction_m1) in depths.iter_mut().zip(&constituent.extinction_m1) {
            // The column behind the ground is infinite: what does not extinguish adds 0 there, not NaN.
            if extinction_m1 > 0.0 {
                *depth += extinction_m1 * length_m;
            }
        }
    }
    depths
}

/// Irradiance by the sun at a point on a surface that faces it, W m^-2 nm^-1.
pub fn sun_irradiance_at(
    air: &AtmosphereTable,
    height_m: f64,
    cos_sun_zenith: f64,
    disc_radius: Radians,
) -> Vec<f64> {
    let transmittance = sun_transmittance(air, height_m, cos_sun_zenith, disc_radius);
    air.sun_irradiance
        .iter()
        .zip(transmittance)
        .map(|(sun, share)| sun * share)
        .collect()
}
