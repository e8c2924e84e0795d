//! Where a sky is seen from, under which sun, and in which direction.
//!
//! On a sphere of air the light from a direction depends on the height of the observer, the cosines
//! mu_s and mu of the sun's and the view's zenith angle, and the azimuth phi between the two:
//!   nu = mu mu_s + sqrt(1 - mu^2) sqrt(1 - mu_s^2) cos phi,  the cosine of the scattering angle

use niji_radiometry::Radians;

use crate::view_ray::ViewRay;

/// An observer and the sun above (or below) him.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyObserver {
    /// Height above sea level, m; any, also below it or above the air.
    pub height_m: f64,
    /// Cosine of the zenith angle of the sun, negative below the horizontal.
    pub cos_sun_zenith: f64,
}

/// A direction of view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkyDirection {
    /// Cosine of the zenith angle.
    pub cos_zenith: f64,
    /// Azimuth from the sun's; the sky is the same on both sides of it.
    pub relative_azimuth: Radians,
}

impl SkyObserver {
    /// An observer under a sun of the given elevation.
    pub fn from_elevation(height_m: f64, sun_elevation: Radians) -> Self {
        Self {
            height_m,
            cos_sun_zenith: sun_elevation.0.sin(),
        }
    }

    /// Cosine between a direction and the sun, and of the scattering angle.
    pub fn cos_scattering(&self, direction: SkyDirection) -> f64 {
        let (mu, mu_s) = (direction.cos_zenith, self.cos_sun_zenith);
        let sines = safe_sqrt((1.0 - mu) * (1.0 + mu)) * safe_sqrt((1.0 - mu_s) * (1.0 + mu_s));
        (mu * mu_s + sines * direction.relative_azimuth.0.cos()).clamp(-1.0, 1.0)
    }

    /// The ray of any length in a direction.
    pub fn ray(&self, direction: SkyDirection) -> ViewRay {
        ViewRay {
            height_m: self.height_m,
            cos_zenith: direction.cos_zenith,
            length_m: f64::INFINITY,
            cos_sun_zenith: self.cos_sun_zenith,
            cos_scattering: self.cos_scattering(direction),
        }
    }
}

impl SkyDirection {
    /// A direction by its elevation over the horizontal and its azimuth from the sun's.
    pub fn from_elevation(elevation: Radians, relative_azimuth: Radians) -> Self {
        Self {
            cos_zenith: elevation.0.sin(),
            relative_azimuth,
        }
    }
}

/// The root of a number that only rounding can make negative.
fn safe_sqrt(square: f64) -> f64 {
    if square > 0.0 { square.sqrt() } else { 0.0 }
}
