//! What the ice of a body is like.

use serde::Deserialize;
use serde::Serialize;

use crate::bubbles::Bubbles;
use crate::error::Error;
use crate::error::check_range;
use crate::light::check_spectrum;
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

/// Snow where the surface is not too steep and above the plane y = 0: a white diffuse layer that lets
/// through what it does not throw back.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Snow {
    /// Share of the light that it throws back; at least as much as the ice.
    #[serde(default = "usual_snow_albedo")]
    pub albedo: f64,
    /// Steepest slope on which it lies, degrees.
    #[serde(default = "usual_slope_deg")]
    pub steepest_deg: f64,
}

fn usual_snow_albedo() -> f64 {
    0.9
}

fn usual_slope_deg() -> f64 {
    35.0
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
        let expected = "at least the reflectance of the ice, and less than 1";
        check_range("snow.albedo", snow.albedo, [least, 0.999], expected)?;
        check_range("steepest_deg", snow.steepest_deg, [0.0, 90.0], "0 to 90")
    }
}
