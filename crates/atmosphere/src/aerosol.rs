//! Aerosol: haze near the ground.
//!
//! tau(lambda) = beta (lambda/1 um)^-alpha                                    (A29)
//! extinction at the ground = tau/H at density exp(-h/H),  scattering = albedo * extinction
//! From a visibility V: extinction(550 nm) = 3.912/V - Rayleigh's, since V is where contrast has
//! fallen to e^-3.912 = 2 % in all of the air (K24).
//! Below 1 km it is fog (WMO07), which lies as much lower as it is denser:
//!   H(V) = H min(1, V/1 km)
//! so that its column is that of 1 km. A haze of 2 km that dense would let no light down at all, where fog is
//! bright.
//! [A29] Angstrom, Geografiska Annaler 11, 156-166 (1929).
//! [K24] Koschmieder, Beitraege zur Physik der freien Atmosphaere 12, 33-53 (1924).
//! [WMO07] WMO, International Cloud Atlas (2017), section 4.2: fog, visibility below 1 km.
//! [SF79] Shettle and Fenn, AFGL-TR-79-0214 (1979), at 70 % relative humidity as tabulated in LOWTRAN
//! 7 (Kneizys et al., AFGL-TR-88-0177, 1988): rural, maritime and urban. Their spectra are no exact
//! power laws; exponents here are those between 337 and 694 nm, and the law lies within 4 % of the
//! tables from 337 to 694 nm. Albedos are those of 550 nm. The parameter of the lobe gives the mean
//! cosine of 550 nm; its form away from the forward direction is that of the formula. Their number
//! falls by 1/e in 2140 m up to 2 km of height at 23 km of visibility; 2100 m gives the whole column.

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

/// Visibility below which an aerosol is fog, m (WMO07).
const FOG_M: f64 = 1000.0;

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
    /// Country air: soluble particles and some dust (SF79).
    Rural,
    /// Sea salt and soluble particles: large and hardly absorbing (SF79).
    Maritime,
    /// Rural with soot: strongly absorbing (SF79).
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
        let [exponent, depth, albedo, parameter, scale_height_m] = match self {
            Self::Clear => [0.8, 0.04, 0.8, 0.7, 1200.0],
            Self::Rural => [1.043, 0.1785, 0.946, 0.5986, 2100.0],
            Self::Maritime => [0.387, 0.2643, 0.987, 0.6602, 2100.0],
            Self::Urban => [0.940, 0.1899, 0.703, 0.6369, 2100.0],
        };
        Aerosol {
            angstrom_exponent: exponent,
            optical_depth_at_1_um: depth,
            single_scattering_albedo: albedo,
            scale_height_m,
            lobe: AerosolLobe::CornetteShanks { parameter },
        }
    }
}

impl Aerosol {
    /// The same aerosol, as much of it as makes a visibility at sea level, and lower where that is fog.
    ///
    /// ```
    /// use niji_atmosphere::{AerosolKind, rayleigh_bodhaine_m1};
    /// use niji_radiometry::{Nanometers, WavelengthGrid};
    ///
    /// // Koschmieder: at the end of the visibility a contrast of 2 % is left, -ln 0.02 = 3.912.
    /// let haze = AerosolKind::Rural.aerosol().with_visibility_m(10_000.0)?;
    /// let haze_m1 = haze.constituent(&WavelengthGrid::new(550.0, 10.0, 1)?)?.extinction_m1[0];
    /// let all_m1 = haze_m1 + rayleigh_bodhaine_m1(Nanometers(550.0));
    /// assert!((10_000.0 * all_m1 - 3.912).abs() < 5e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
        let scale_height_m = self.scale_height_m * (visibility_m / FOG_M).min(1.0);
        let depth = aerosol_m1 * scale_height_m;
        let wavelength_um = Micrometers::from(VISIBILITY_WAVELENGTH).0;
        Ok(Self {
            optical_depth_at_1_um: depth * wavelength_um.powf(self.angstrom_exponent),
            scale_height_m,
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
    fn fog_of_any_visibility_has_the_column_of_one_kilometre() {
        let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
        for kind in AerosolKind::ALL {
            let of = |visibility_m: f64| {
                let aerosol = kind.aerosol().with_visibility_m(visibility_m).unwrap();
                aerosol.constituent(&grid).unwrap()
            };
            let depth = |visibility_m: f64| of(visibility_m).vertical_optical_depth()[0];
            for visibility_m in [10.0, 30.0, 100.0] {
                // Molecules take 1e-5/m of the extinction in 1 km and next to none in 10 m.
                assert!((depth(visibility_m) / depth(1e3) - 1.0).abs() < 4e-3);
                let dense = of(visibility_m).extinction_m1[0] * visibility_m;
                assert!((dense / VISIBLE_CONTRAST - 1.0).abs() < 1e-3);
            }
            assert!(
                (depth(2e3) / depth(1e3) - 0.5).abs() < 2e-3,
                "haze is as deep as it was"
            );
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
            assert!((ratio - 1.0).abs() < 1e-3, "{}: {ratio}", kind.name());
        }
    }

    /// Extinction at 337.1 and 694.3 nm over that at 550 nm, albedo and mean cosine at 550 nm (SF79,
    /// 70 % humidity).
    const TABLES: [(AerosolKind, [f64; 4]); 3] = [
        (AerosolKind::Rural, [1.59981, 0.75316, 0.9462, 0.6638]),
        (AerosolKind::Maritime, [1.20835, 0.91367, 0.9870, 0.7214]),
        (AerosolKind::Urban, [1.53070, 0.77614, 0.7026, 0.6998]),
    ];
    /// Worst deviation of the Angstrom law from the tabulated extinctions; the worst is 4.1e-2.
    const LAW_TOLERANCE: f64 = 0.042;

    #[test]
    fn the_presets_have_the_published_spectra_albedos_and_asymmetries() {
        for (kind, [at_337, at_694, albedo, cosine]) in TABLES {
            let aerosol = kind.aerosol();
            for (nm, published) in [(337.1, at_337), (694.3, at_694)] {
                let found = (nm / 550.0_f64).powf(-aerosol.angstrom_exponent);
                assert!(
                    (found / published - 1.0).abs() < LAW_TOLERANCE,
                    "{} {nm} nm: {found}",
                    kind.name()
                );
            }
            assert!((aerosol.single_scattering_albedo - albedo).abs() < 1e-3);
            let AerosolLobe::CornetteShanks { parameter: g } = aerosol.lobe else {
                panic!("another lobe than documented");
            };
            // Mean cosine of Cornette and Shanks' formula.
            let mean = 0.6 * g * (4.0 + g * g) / (2.0 + g * g);
            assert!((mean - cosine).abs() < 2e-4, "{}: {mean}", kind.name());
        }
    }

    #[test]
    fn a_hazy_country_has_the_published_optical_depth() {
        let depth_at = |visibility_m: f64| {
            let usual = AerosolKind::Rural.aerosol();
            let aerosol = usual.with_visibility_m(visibility_m).unwrap();
            let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
            aerosol.constituent(&grid).unwrap().vertical_optical_depth()[0]
        };
        // Columns of Shettle's rural summer model (Shettle, AGARD CP-454, 15-1 to 15-12, 1989). In
        // clearer air more of the column lies above the haze layer: 13 % are missing at 49 km.
        for (visibility_m, published, tolerance) in [
            (20.8e3, 0.362, 0.03),
            (22.9e3, 0.332, 0.03),
            (49e3, 0.165, 0.14),
        ] {
            let found = depth_at(visibility_m);
            assert!((found / published - 1.0).abs() < tolerance, "{found}");
        }
    }

    #[test]
    fn the_layer_of_haze_falls_off_as_published() {
        // Extinction at 0, 1 and 2 km at 23 km of visibility, 1/km (SF79, as in LOWTRAN 7).
        let grid = WavelengthGrid::new(550.0, 10.0, 1).unwrap();
        let rural = AerosolKind::Rural.aerosol().constituent(&grid).unwrap();
        for (height_m, published) in [(0.0, 0.158), (1e3, 0.0991), (2e3, 0.0621)] {
            let density = (-height_m / AerosolKind::Rural.aerosol().scale_height_m).exp();
            let found = 1e3 * rural.extinction_m1[0] * density;
            assert!(
                (found / published - 1.0).abs() < 0.02,
                "{height_m} m: {found}"
            );
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
