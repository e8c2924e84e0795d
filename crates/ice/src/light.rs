//! The light around ice: the sun as a direction, the sky above the horizon as a map.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::f64::consts::TAU;

use glam::DVec3;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::Radians;

use crate::directions::frame;
use crate::directions::unit_disc;
use crate::error::Error;
use crate::error::check_range;

/// Sunlight and skylight, one value for each wavelength.
#[derive(Debug, Clone)]
pub struct Light {
    /// Unit vector towards the middle of the sun.
    pub sun_direction: DVec3,
    /// Angular radius of its disc; 0 for a point, whose shadows are sharp.
    pub sun_radius: Radians,
    /// What arrives on a plane across the sunlight, W m^-2 nm^-1.
    pub sun_irradiance: Vec<f64>,
    /// The sky.
    pub sky: Sky,
}

/// The sky.
#[derive(Debug, Clone)]
pub enum Sky {
    /// The same radiance from everywhere above the horizon, W m^-2 sr^-1 nm^-1.
    Uniform(Vec<f64>),
    /// By direction.
    Map(SkyMap),
}

/// Radiance by azimuth and elevation, bilinear between nodes that lie closer at the horizon:
/// elevation = pi/2 (row/last row)².
#[derive(Debug, Clone)]
pub struct SkyMap {
    n_azimuths: usize,
    n_elevations: usize,
    n_wavelengths: usize,
    /// `[elevation, azimuth, wavelength]`. f32: the tables it comes from hold no more.
    radiance: Vec<f32>,
}

impl SkyMap {
    /// A map from radiances by direction.
    ///
    /// `radiance` writes one value for each wavelength, W m^-2 sr^-1 nm^-1, into the buffer.
    pub fn new(
        [n_azimuths, n_elevations]: [usize; 2],
        n_wavelengths: usize,
        radiance: impl Fn(DVec3, &mut [f32]) + Sync,
    ) -> Self {
        use rayon::prelude::*;
        let (n_azimuths, n_elevations) = (n_azimuths.max(1), n_elevations.max(2));
        let mut values = vec![0.0; n_azimuths * n_elevations * n_wavelengths];
        values
            .par_chunks_mut(n_wavelengths.max(1))
            .enumerate()
            .for_each(|(node, values)| {
                let (row, column) = (node / n_azimuths, node % n_azimuths);
                let height = row as f64 / (n_elevations - 1) as f64;
                let azimuth = Radians(TAU * column as f64 / n_azimuths as f64);
                let elevation = Radians(FRAC_PI_2 * height * height);
                radiance(direction_from_azimuth_elevation(azimuth, elevation), values);
            });
        Self {
            n_azimuths,
            n_elevations,
            n_wavelengths,
            radiance: values,
        }
    }

    /// The four nodes around a direction, with their weights; below the horizon those on it.
    fn nodes(&self, direction: DVec3) -> [(&[f32], f32); 4] {
        let elevation_rad = direction.y.clamp(0.0, 1.0).asin();
        let height = (elevation_rad / FRAC_PI_2).sqrt() * (self.n_elevations - 1) as f64;
        let turn = (direction.x.atan2(-direction.z) / TAU).rem_euclid(1.0) * self.n_azimuths as f64;
        let row = (height as usize).min(self.n_elevations - 2);
        let column = (turn as usize).min(self.n_azimuths - 1);
        let (up, on) = ((height - row as f64) as f32, (turn - column as f64) as f32);
        let next = (column + 1) % self.n_azimuths;
        let node = |row: usize, column: usize| {
            &self.radiance[(row * self.n_azimuths + column) * self.n_wavelengths..]
                [..self.n_wavelengths]
        };
        [
            (node(row, column), (1.0 - up) * (1.0 - on)),
            (node(row, next), (1.0 - up) * on),
            (node(row + 1, column), up * (1.0 - on)),
            (node(row + 1, next), up * on),
        ]
    }
}

impl Light {
    /// Checks that all spectra are sound and have as many values as there are wavelengths.
    ///
    /// # Errors
    /// A spectrum of another length, or with values that are negative or not finite.
    pub fn check(&self, n_wavelengths: usize) -> Result<(), Error> {
        check_range("sun_radius", self.sun_radius.0, [0.0, 0.1], "0 to 0.1")?;
        check_spectrum("sun_irradiance", &self.sun_irradiance, n_wavelengths)?;
        match &self.sky {
            Sky::Uniform(radiance) => check_spectrum("sky_radiance", radiance, n_wavelengths),
            Sky::Map(map) => {
                if map.n_wavelengths != n_wavelengths {
                    let (what, found) = ("sky_radiance", map.n_wavelengths);
                    let expected = n_wavelengths;
                    return Err(Error::Spectrum {
                        what,
                        found,
                        expected,
                    });
                }
                let values: Vec<f64> = map.radiance.iter().map(|&value| value.into()).collect();
                check_spectrum("sky_radiance", &values, values.len())
            }
        }
    }

    /// A direction towards the disc of the sun, uniform by solid angle to the second order of its
    /// radius, 2e-5.
    pub(crate) fn towards_disc(&self, uv: [f64; 2]) -> DVec3 {
        let [x, y] = unit_disc(uv).map(|part| self.sun_radius.0 * part);
        (self.sun_direction + frame(self.sun_direction) * DVec3::new(x, y, 0.0)).normalize()
    }

    /// Calls `add` with spectra and weights that sum to the radiance of the sky in a direction.
    pub(crate) fn for_sky(&self, direction: DVec3, mut add: impl FnMut(SkyPart)) {
        match &self.sky {
            Sky::Uniform(radiance) => add(SkyPart::Exact(radiance)),
            Sky::Map(map) => {
                for (values, weight) in map.nodes(direction) {
                    add(SkyPart::Node(values, weight));
                }
            }
        }
    }

    /// Irradiance of level ground by sun and sky, W m^-2 nm^-1.
    pub(crate) fn ground_irradiance(&self) -> Vec<f64> {
        let cos_sun = self.sun_direction.y.max(0.0);
        let sun = self.sun_irradiance.iter().map(|sun| sun * cos_sun);
        sun.zip(self.sky_irradiance())
            .map(|(sun, sky)| sun + sky)
            .collect()
    }

    /// Irradiance of level ground by the sky, W m^-2 nm^-1, from 64 x 32 directions.
    pub fn sky_irradiance(&self) -> Vec<f64> {
        let (n_azimuths, n_rings) = (64, 32);
        let share = 1.0 / f64::from(n_azimuths * n_rings);
        let mut irradiance = vec![0.0; self.sun_irradiance.len()];
        for node in 0..n_azimuths * n_rings {
            // Equal shares of cos², so that every direction counts alike.
            let cos2 = (f64::from(node / n_azimuths) + 0.5) / f64::from(n_rings);
            let azimuth_rad = TAU * f64::from(node % n_azimuths) / f64::from(n_azimuths);
            let (sin, cos) = azimuth_rad.sin_cos();
            let level = (1.0 - cos2).sqrt();
            let direction = DVec3::new(level * sin, cos2.sqrt(), level * cos);
            self.for_sky(direction, |part| part.add_to(&mut irradiance, PI * share));
        }
        irradiance
    }
}

/// A spectrum of the sky and its weight.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SkyPart<'a> {
    Exact(&'a [f64]),
    Node(&'a [f32], f32),
}

impl SkyPart<'_> {
    pub(crate) fn add_to(self, sum: &mut [f64], weight: f64) {
        match self {
            Self::Exact(values) => {
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += weight * value;
                }
            }
            Self::Node(values, share) => {
                let weight = weight * f64::from(share);
                for (sum, value) in sum.iter_mut().zip(values) {
                    *sum += weight * f64::from(*value);
                }
            }
        }
    }
}

/// Refuses a spectrum of another length or with values that cannot be.
pub(crate) fn check_spectrum(
    what: &'static str,
    values: &[f64],
    expected: usize,
) -> Result<(), Error> {
    let found = values.len();
    if found != expected {
        return Err(Error::Spectrum {
            what,
            found,
            expected,
        });
    }
    let is_bad = |value: &&f64| !(**value >= 0.0 && value.is_finite());
    match values.iter().find(is_bad) {
        Some(&found) => Err(Error::BadSpectrum { what, found }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chi_square::Chi2;
    use crate::chi_square::pseudo_random;

    fn look(light: &Light, direction: DVec3) -> f64 {
        let mut sum = [0.0];
        light.for_sky(direction, |part| part.add_to(&mut sum, 1.0));
        sum[0]
    }

    fn light(sky: Sky) -> Light {
        Light {
            sun_direction: DVec3::Y,
            sun_radius: Radians(0.0),
            sun_irradiance: vec![0.0],
            sky,
        }
    }

    #[test]
    fn a_map_gives_back_what_was_drawn_into_it() {
        let radiance = |direction: DVec3| 2.0 + direction.x + 0.5 * direction.y - 0.3 * direction.z;
        let map = SkyMap::new([128, 64], 1, |direction, out| {
            out[0] = radiance(direction) as f32;
        });
        let light = light(Sky::Map(map));
        for index in 0..200 {
            let [a, b] = pseudo_random(index);
            let direction =
                direction_from_azimuth_elevation(Radians(TAU * a), Radians(FRAC_PI_2 * b));
            // Worst found 5e-4.
            assert!((look(&light, direction) - radiance(direction)).abs() < 1e-3);
        }
        assert!((look(&light, DVec3::Y) - 2.5).abs() < 1e-6);
        assert!((look(&light, DVec3::new(0.6, -0.8, 0.0)) - 3.0).abs() < 1e-6);
    }

    #[test]
    fn a_uniform_sky_lights_the_ground_with_pi() {
        let uniform = light(Sky::Uniform(vec![1.0]));
        assert!((uniform.ground_irradiance()[0] - PI).abs() < 1e-12);
        let map = SkyMap::new([8, 4], 1, |_, out| out[0] = 1.0);
        assert!((light(Sky::Map(map)).ground_irradiance()[0] - PI).abs() < 1e-6);
        let mut sunny = light(Sky::Uniform(vec![0.0]));
        sunny.sun_irradiance = vec![2.0];
        sunny.sun_direction = DVec3::new(0.8, 0.6, 0.0);
        assert!((sunny.ground_irradiance()[0] - 1.2).abs() < 1e-15);
    }

    #[test]
    fn directions_fill_the_disc_of_the_sun() {
        let mut low = light(Sky::Uniform(vec![0.0]));
        low.sun_direction = DVec3::new(0.6, 0.0, -0.8);
        assert_eq!(low.towards_disc([0.1, 0.7]), low.sun_direction);
        low.sun_radius = Radians(0.00465);
        let across = [DVec3::new(0.8, 0.0, 0.6), DVec3::Y];
        let mut chi2 = Chi2::new(100);
        for index in 0..50_000 {
            let towards = low.towards_disc(pseudo_random(index));
            let [x, y] = across.map(|axis| axis.dot(towards) / 0.00465);
            let ring = ((x * x + y * y) * 10.0).min(9.0) as usize;
            let sector = (y.atan2(x) / TAU + 0.5) * 10.0;
            chi2.count(ring * 10 + sector.min(9.0) as usize);
        }
        chi2.assert_fits(&[0.01; 100]);
    }

    #[test]
    fn unsound_spectra_are_refused() {
        let sound = light(Sky::Uniform(vec![1.0]));
        assert!(sound.check(1).is_ok());
        assert!(matches!(
            sound.check(2),
            Err(Error::Spectrum { found: 1, .. })
        ));
        assert!(light(Sky::Uniform(vec![f64::NAN])).check(1).is_err());
        assert!(light(Sky::Uniform(vec![-1.0])).check(1).is_err());
        let map = SkyMap::new([8, 4], 1, |_, out| out[0] = f32::INFINITY);
        assert!(light(Sky::Map(map)).check(1).is_err());
    }
}
