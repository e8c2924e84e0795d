//! From the moments of a size law to what a cubic metre of air holds.
//!
//! LWC = (4/3) pi rho_w N <r³>        liquid water content [g/m³]
//! sigma = Q pi N <r²>                extinction [1/m], Q = 2 for drops that are large against
//!                                    the wavelength
//! r_e = <r³>/<r²>                    effective radius
//! v_e = <(r - r_e)² r²>/(r_e² <r²>) = <r²> <r⁴>/<r³>² - 1     effective variance
//! `N` number density [1/m³], `<>` mean over the drops, rho_w density of water.
//! [HT74] Hansen and Travis, Space Science Reviews 16, 527-610 (1974), eqs. 2.53, 2.54.

use std::f64::consts::PI;

use niji_radiometry::Micrometers;

/// Density of liquid water at 4 °C, to the 3 digits that a rain rate deserves (g/m³).
pub const WATER_DENSITY_G_M3: f64 = 1e6;

/// Extinction efficiency of a drop that is large against the wavelength, diffraction included.
const LARGE_DROP_EXTINCTION_EFFICIENCY: f64 = 2.0;

/// Cubic metres in a cubic micrometre.
const M3_PER_UM3: f64 = 1e-18;

/// Square metres in a square micrometre.
const M2_PER_UM2: f64 = 1e-12;

/// Liquid water content (g/m³) of a third moment N <r³> (um³/m³).
pub fn liquid_water_g_m3(third_moment_um3_m3: f64) -> f64 {
    4.0 / 3.0 * PI * WATER_DENSITY_G_M3 * M3_PER_UM3 * third_moment_um3_m3
}

/// Means over the drops of a law, each per drop.
///
/// The effective variance stands beside the moments because it cannot be had from them: for a
/// narrow law <r²><r⁴>/<r³>² - 1 loses all its digits. <r⁴> follows, see
/// [`SizeMoments::mean_r4_um4`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeMoments {
    /// `<r>` (um).
    pub mean_r_um: f64,
    /// `<r²>` (um²).
    pub mean_r2_um2: f64,
    /// `<r³>` (um³).
    pub mean_r3_um3: f64,
    /// Effective variance v_e.
    pub effective_variance: f64,
}

impl SizeMoments {
    /// <r⁴> = (1 + v_e) <r³>²/<r²> (um⁴).
    pub fn mean_r4_um4(&self) -> f64 {
        (1.0 + self.effective_variance) * self.mean_r3_um3 * self.effective_radius().0
    }

    /// Effective radius r_e.
    pub fn effective_radius(&self) -> Micrometers {
        Micrometers(self.mean_r3_um3 / self.mean_r2_um2)
    }

    /// The same area and water with a variance that a gamma law can have.
    ///
    /// A gamma law needs v_e < 1/2, wide lognormal and spray laws have more. The fourth moment is
    /// then given up: extinction, water and effective radius stay.
    #[must_use]
    pub fn with_variance_at_most(self, limit: f64) -> Self {
        Self {
            effective_variance: self.effective_variance.min(limit),
            ..self
        }
    }

    /// Drops of the gamma law with the same <r²>, r_e and v_e, per drop of this law:
    /// <r²>/(r_e² (1 - v_e)(1 - 2 v_e)).
    ///
    /// 1 for a single size and for untruncated Marshall-Palmer rain. Rain cut off at 0.1 mm has 0.78
    /// times the drops of its gamma law, which keeps the smallest ones; water and extinction are
    /// equal, and light sees no more.
    pub fn equivalent_gamma_drops(&self) -> f64 {
        let (r_e, v_e) = (self.effective_radius().0, self.effective_variance);
        self.mean_r2_um2 / (r_e * r_e * (1.0 - v_e) * (1.0 - 2.0 * v_e))
    }

    /// What a cubic metre with that many drops holds.
    pub fn bulk_properties(&self, number_density_m3: f64) -> BulkProperties {
        let area_m1 = PI * M2_PER_UM2 * number_density_m3 * self.mean_r2_um2;
        BulkProperties {
            number_density_m3,
            lwc_g_m3: liquid_water_g_m3(number_density_m3 * self.mean_r3_um3),
            extinction_m1: LARGE_DROP_EXTINCTION_EFFICIENCY * area_m1,
            effective_radius_m: 1e-6 * self.effective_radius().0,
            effective_variance: self.effective_variance,
        }
    }
}

/// What a cubic metre of air with drops holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BulkProperties {
    /// Drops per cubic metre (1/m³).
    pub number_density_m3: f64,
    /// Liquid water content (g/m³).
    pub lwc_g_m3: f64,
    /// Extinction at Q = 2 (1/m).
    pub extinction_m1: f64,
    /// Effective radius (m).
    pub effective_radius_m: f64,
    /// Effective variance.
    pub effective_variance: f64,
}
