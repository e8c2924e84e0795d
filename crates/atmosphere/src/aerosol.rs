//! Aerosol: haze near the ground.
//!
//! tau(lambda) = beta (lambda/1 um)^-alpha                                    (A29)
//! extinction at the ground = tau/H at density exp(-h/H),  scattering = albedo * extinction
//! From a visibility V: extinction(550 nm) = 3.912/V - Rayleigh's, since V is where contrast has
//! fallen to e^-3.912 = 2 % in all of the air (K24).
//! [A29] Angstrom, Geografiska Annaler 11, 156-166 (1929).
//! [K24] Koschmieder, Beitraege zur Physik der freien Atmosphaere 12, 33-53 (1924).
//! [SF79] Shettle and Fenn, AFGL-TR-79-0214 (1979): the types of aerosol; the presets hold
//! representative values of theirs at 70 to 80 % humidity, good to 10 %.

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::constituent::Constituent;
use crate::density_profile::DensityProfile;
use crate::error::Error;
use crate::error::positive;
use crate::error::within;
use crate::phase_function::PhaseFunction;
use crate::rayleigh_bodhaine::rayleigh_bodhaine_m1;

/// ln(1/0.02): contrast at the limit of visibility (K24).
const VISIBLE_CONTRAST: f64 = 3.912_023_005_428_146;
/// Wavelength of visibility.
const VISIBILITY_WAVELENGTH: Nanometers = Nanometers(550.0);

/// An aerosol with an Angstrom law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aerosol {
    /// Exponent alpha of the Angstrom law.
    pub angstrom_exponent: f64,
    /// Vertical optical depth at 1 um, beta of the Angstrom law.
    pub optical_depth_at_1_um: f64,
    /// Scattering over extinction.
    pub single_scattering_albedo: f64,
    /// Height over which the density falls to 1/e, m.
    pub scale_height_m: f64,
    /// Where the scattered light goes.
    pub lobe: AerosolLobe,
}

/// Phase function of an aerosol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AerosolLobe {
    /// Henyey and Greenstein, by the mean cosine.
    HenyeyGreenstein {
        /// Mean of the scattering cosine.
        asymmetry: f64,
    },
    /// Cornette and Shanks, by the parameter.
    CornetteShanks {
        /// The parameter g of the formula.
        parameter: f64,
    },
}

/// A named kind of aerosol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AerosolKind {
    /// Clear continental air: alpha 0.8, beta 0.04, albedo 0.8 as in Bruneton, IEEE TVCG 23, 2641
    /// (2017).
    Clear,
    /// Country air: dust and soluble particles.
    Rural,
    /// Sea salt and soluble particles: large and hardly absorbing.
    Maritime,
    /// Rural with soot: strongly absorbing.
    Urban,
}

impl AerosolKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Clear, Self::Rural, Self::Maritime, Self::Urban];

    /// Name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Rural => "rural",
            Self::Maritime => "maritime",
            Self::Urban => "urban",
        }
    }

    /// The kind with its usual amount: 23 km of visibility, `Clear` with beta = 0.04.
    pub fn aerosol(self) -> Aerosol {
        let cornette_shanks = |parameter| AerosolLobe::CornetteShanks { parameter };
        let (exponent, depth, albedo, lobe) = match self {
            Self::Clear => (0.8, 0.04, 0.8, cornette_shanks(0.7)),
            Self::Rural => (1.2, 0.093, 0.95, cornette_shanks(0.65)),
            Self::Maritime => (0.4, 0.150, 0.99, cornette_shanks(0.72)),
            Self::Urban => (1.1, 0.098, 0.65, cornette_shanks(0.68)),
        };
        Aerosol {
            angstrom_exponent: exponent,
            optical_depth_at_1_um: depth,
            single_scattering_albedo: albedo,
            scale_height_m: 1200.0,
            lobe,
        }
    }
}

impl Aerosol {
    /// The same aerosol, as much of it as makes a visibility at sea level.
    ///
    /// # Errors
    /// If the visibility is no positive number, or farther than in air without any aerosol (334 km).
    pub fn with_visibility_m(self, visibility_m: f64) -> Result<Self, Error> {
        let visibility_m = positive("visibility", visibility_m, "m")?;
        let rayleigh_m1 = rayleigh_bodhaine_m1(VISIBILITY_WAVELENGTH);
        let aerosol_m1 = VISIBLE_CONTRAST / visibility_m - rayleigh_m1;
        if aerosol_m1 <= 0.0 {
            let clean_air_m = VISIBLE_CONTRAST / rayleigh_m1;
            return Err(Error::TooClear {
                visibility_m,
                clean_air_m,
            });
        }
        let depth = aerosol_m1 * self.scale_height_m;
        let wavelength_um = Micrometers::from(VISIBILITY_WAVELENGTH).0;
        Ok(Self {
            optical_depth_at_1_um: depth * wavelength_um.powf(self.angstrom_exponent),
            ..self
        })
    }

    /// The aerosol on a grid of wavelengths, evaluated at the centers of the bins.
    ///
    /// # Errors
    /// If a number lies outside its range.
    pub fn constituent(&self, wavelengths: &WavelengthGrid) -> Result<Constituent, Error> {
        let scale_height_m = positive("scale height of the aerosol", self.scale_height_m, "m")?;
        let exponent = within("Angstrom exponent", self.angstrom_exponent, [-1.0, 4.0])?;
        let albedo = within(
            "single-scattering albedo",
            self.single_scattering_albedo,
            [0.0, 1.0],
        )?;
        let depth = within(
            "aerosol optical depth",
            self.optical_depth_at_1_um,
            [0.0, 1e6],
        )?;
        let extinction = |wavelength: Nanometers| {
            depth * Micrometers::from(wavelength).0.powf(-exponent) / scale_height_m
        };
        let extinction_m1: Vec<f64> = wavelengths.centers().map(extinction).collect();
        let phase = match self.lobe {
            AerosolLobe::HenyeyGreenstein { asymmetry } => {
                PhaseFunction::HenyeyGreenstein { asymmetry }
            }
            AerosolLobe::CornetteShanks { parameter } => {
                PhaseFunction::CornetteShanks { parameter }
            }
        };
        phase.check()?;
        Ok(Constituent {
            name: "aerosol".to_owned(),
            profile: DensityProfile::Exponential { scale_height_m },
            scattering_m1: extinction_m1
                .iter()
                .map(|extinction| albedo * extinction)
                .collect(),
            extinction_m1,
            phase,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clear_preset_has_the_published_optical_depths() {
        let grid = WavelengthGrid::new(450.0, 100.0, 3).unwrap();
        let found = AerosolKind::Clear.aerosol().constituent(&grid).unwrap();
        for (found, depth) in found
            .vertical_optical_depth()
            .iter()
            .zip([0.0758, 0.0645, 0.0565])
        {
            assert!((found - depth).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn contrast_falls_to_two_percent_at_the_visibility() {
        let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
        for kind in AerosolKind::ALL {
            let aerosol = kind.aerosol().with_visibility_m(23e3).unwrap();
            let aerosol_m1 = aerosol.constituent(&grid).unwrap().extinction_m1[0];
            let total_m1 = aerosol_m1 + rayleigh_bodhaine_m1(Nanometers(550.0));
            assert!(((-total_m1 * 23e3).exp() - 0.02).abs() < 1e-12);
        }
    }

    #[test]
    fn the_presets_for_haze_have_a_visibility_of_23_km() {
        for kind in [
            AerosolKind::Rural,
            AerosolKind::Maritime,
            AerosolKind::Urban,
        ] {
            let usual = kind.aerosol();
            let exact = usual.with_visibility_m(23e3).unwrap();
            let ratio = usual.optical_depth_at_1_um / exact.optical_depth_at_1_um;
            assert!((ratio - 1.0).abs() < 0.01, "{}: {ratio}", kind.name());
        }
    }

    #[test]
    fn clearer_than_clean_air_is_refused() {
        let error = AerosolKind::Rural.aerosol().with_visibility_m(400e3);
        assert!(matches!(error, Err(Error::TooClear { .. })), "{error:?}");
        assert!(
            AerosolKind::Rural
                .aerosol()
                .with_visibility_m(f64::NAN)
                .is_err()
        );
    }
}
