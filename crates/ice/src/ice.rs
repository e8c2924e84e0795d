//! What the ice of a body is like.

use crate::bubbles::Bubbles;
use crate::error::Error;
use crate::light::check_spectrum;
use crate::snow::Snow;
use crate::surface::IceSurface;

/// Ice.
#[derive(Debug, Clone, PartialEq)]
pub struct Ice {
    /// Absorption coefficient, 1/m, one value for each wavelength.
    pub absorption_per_m: Vec<f64>,
    /// Its surface.
    pub surface: IceSurface,
    /// Bubbles in it; `None` for clear ice.
    pub bubbles: Option<Bubbles>,
    /// Snow on it; `None` for bare ice.
    pub snow: Option<Snow>,
}

impl Ice {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A setting out of its range, or an absorption that is not one sound value for each wavelength.
    pub fn check(&self, n_wavelengths: usize) -> Result<(), Error> {
        check_spectrum("absorption_per_m", &self.absorption_per_m, n_wavelengths)?;
        self.surface.check()?;
        if let Some(bubbles) = &self.bubbles {
            bubbles.check()?;
        }
        let Some(snow) = &self.snow else {
            return Ok(());
        };
        let least = match self.surface {
            IceSurface::Diffuse {
                outer_reflectance, ..
            } => outer_reflectance,
            IceSurface::RoughDielectric { .. } => 0.0,
        };
        snow.check(least)
    }
}
