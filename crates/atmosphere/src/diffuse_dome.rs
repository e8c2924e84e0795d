//! Light of higher orders over a whole sky, as a table of directions.
//!
//! It has no features finer than ten degrees but at the horizon, so that a thousand rays hold it:
//!   elevation = horizon + (end - horizon) x^2,  x and the azimuth from the sun's in even steps,
//! a table above and one below the horizon, interpolated by cubics. In elevation, not its sine, the
//! light is smooth at the zenith too. Error: 4e-4 of all light at most (see the tests).

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_exchange::Stencil;
use niji_geometry::Planet;
use niji_radiometry::Radians;
use rayon::iter::IntoParallelIterator;
use rayon::iter::ParallelIterator;

use crate::error::Error;
use crate::multiple_scattering::DiffuseSky;
use crate::sky_view::SkyDirection;
use crate::sky_view::SkyObserver;

/// Nodes from the horizon to the zenith and to the nadir.
const N_RISES: usize = 28;
/// Nodes of the azimuth on one side of the sun.
const N_AZIMUTHS: usize = 19;
/// By how much nodes at the horizon are moved off it, rad, so that rounding decides nothing.
const BESIDE_HORIZON: f64 = 1e-9;

/// The light of higher orders that one observer sees.
#[derive(Debug, Clone)]
pub struct DiffuseDome {
    /// Elevation of the horizon, rad.
    horizon_rad: f64,
    n_wavelengths: usize,
    /// x, 0 to 1.
    rises: Vec<f64>,
    azimuths_rad: Vec<f64>,
    /// Above and below the horizon: `[rise][azimuth][wavelength]`, W m^-2 sr^-1 nm^-1.
    // f32: the light is known to 1e-3.
    halves: [Vec<f32>; 2],
}

impl DiffuseDome {
    /// Tabulates the light of an air that holds it.
    ///
    /// # Errors
    /// If the air's table holds no diffuse light, or one that does not fit it.
    pub fn new(air: &AtmosphereTable, observer: SkyObserver) -> Result<Self, Error> {
        let sky = DiffuseSky::new(air)?;
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let horizon_rad = -planet.horizon_dip(observer.height_m).0;
        let even = |n: usize| (0..n).map(move |i| i as f64 / (n - 1) as f64);
        let rises: Vec<f64> = even(N_RISES).collect();
        let azimuths_rad: Vec<f64> = even(N_AZIMUTHS).map(|share| PI * share).collect();
        let half = |end: f64| -> Vec<f32> {
            let cosine = |x: &f64| {
                let beside_rad = BESIDE_HORIZON * (end - horizon_rad).signum();
                let from_rad = horizon_rad + beside_rad;
                (from_rad + (end - from_rad) * x * x).sin()
            };
            let nodes = rises.iter().flat_map(|x| {
                let cos_zenith = cosine(x);
                let direction = move |azimuth_rad: &f64| SkyDirection {
                    cos_zenith,
                    relative_azimuth: Radians(*azimuth_rad),
                };
                azimuths_rad.iter().map(direction)
            });
            let spectra = nodes.collect::<Vec<_>>().into_par_iter().map(|direction| {
                let per_sun = sky.radiance_per_sun(&observer.ray(direction));
                let suns = per_sun.into_iter().zip(&air.sun_irradiance);
                suns.map(|(light, sun)| (light * sun) as f32).collect()
            });
            spectra.collect::<Vec<Vec<f32>>>().concat()
        };
        let halves = [half(FRAC_PI_2), half(-FRAC_PI_2)];
        Ok(Self {
            horizon_rad,
            n_wavelengths: air.wavelengths.len(),
            rises,
            azimuths_rad,
            halves,
        })
    }

    /// Adds the radiance that arrives from a direction, W m^-2 sr^-1 nm^-1, one value for each
    /// wavelength of the air.
    ///
    /// # Panics
    /// If `radiance` has another length.
    pub fn add_radiance(&self, direction: SkyDirection, radiance: &mut [f32]) {
        let n = self.n_wavelengths;
        assert_eq!(radiance.len(), n, "one value for each wavelength");
        let elevation_rad = direction.cos_zenith.clamp(-1.0, 1.0).asin();
        let (half, end_rad) = if elevation_rad >= self.horizon_rad {
            (&self.halves[0], FRAC_PI_2)
        } else {
            (&self.halves[1], -FRAC_PI_2)
        };
        let x2 = (elevation_rad - self.horizon_rad) / (end_rad - self.horizon_rad);
        let azimuth_rad = direction.relative_azimuth.0.cos().clamp(-1.0, 1.0).acos();
        let rises = Stencil::<4>::new(&self.rises, x2.clamp(0.0, 1.0).sqrt());
        let azimuths = Stencil::<4>::new(&self.azimuths_rad, azimuth_rad);
        for (rise, rise_weight) in rises.weighted_nodes() {
            for (azimuth, azimuth_weight) in azimuths.weighted_nodes() {
                let start = (rise * N_AZIMUTHS + azimuth) * n;
                let weight = (rise_weight * azimuth_weight) as f32;
                for (sum, value) in radiance.iter_mut().zip(&half[start..start + n]) {
                    *sum += weight * value;
                }
            }
        }
    }
}
