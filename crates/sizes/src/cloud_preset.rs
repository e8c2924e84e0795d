//! Published cloud and fog laws of the modified gamma form.
//!
//! The optical-properties package OPAC gives alpha, B, gamma and the number of drops of six water
//! clouds [HKS98]; Deirmendjian gives three models of 100 drops per cm³ [Dei69].
//! [HKS98] Hess, Koepke and Schult, Bull. Am. Meteorol. Soc. 79, 831-844 (1998), table 1b;
//! [Dei69] D. Deirmendjian, Electromagnetic Scattering on Spherical Polydispersions, Elsevier (1969),
//! table 4.1 and page 78.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::ModifiedGamma;

/// A cloud by name.
///
/// ```
/// use niji_sizes::CloudPreset;
///
/// let fog = CloudPreset::Fog;
/// let air = fog.law().moments().bulk_properties(fog.number_density_m3());
/// assert!((1e6 * air.effective_radius_m - 10.72).abs() < 0.01);
/// assert!((air.lwc_g_m3 - 0.058).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CloudPreset {
    /// Stratus over land (HKS98).
    StratusContinental,
    /// Stratus over the sea (HKS98).
    StratusMaritime,
    /// Cumulus over land in clean air (HKS98).
    CumulusContinentalClean,
    /// Cumulus over land in polluted air (HKS98).
    CumulusContinentalPolluted,
    /// Cumulus over the sea (HKS98).
    CumulusMaritime,
    /// Fog (HKS98).
    Fog,
    /// Cumulus of moderate thickness, C1 (Dei69).
    DeirmendjianC1,
    /// Corona, C2 (Dei69).
    DeirmendjianC2,
    /// Mother-of-pearl cloud, C3 (Dei69).
    DeirmendjianC3,
}

impl CloudPreset {
    /// All presets in the order of their sources.
    pub const ALL: [Self; 9] = [
        Self::StratusContinental,
        Self::StratusMaritime,
        Self::CumulusContinentalClean,
        Self::CumulusContinentalPolluted,
        Self::CumulusMaritime,
        Self::Fog,
        Self::DeirmendjianC1,
        Self::DeirmendjianC2,
        Self::DeirmendjianC3,
    ];

    /// alpha, B, gamma, drops per cm³.
    fn numbers(self) -> (f64, f64, f64, f64) {
        match self {
            Self::StratusContinental => (5.0, 0.938, 1.05, 250.0),
            Self::StratusMaritime => (3.0, 0.193, 1.30, 80.0),
            Self::CumulusContinentalClean => (5.0, 0.0782, 2.16, 400.0),
            Self::CumulusContinentalPolluted => (8.0, 0.247, 2.15, 1300.0),
            Self::CumulusMaritime => (4.0, 0.00713, 2.34, 65.0),
            Self::Fog => (4.0, 0.0562, 1.77, 15.0),
            Self::DeirmendjianC1 => (6.0, 1.5, 1.0, 100.0),
            Self::DeirmendjianC2 => (8.0, 1.0 / 24.0, 3.0, 100.0),
            Self::DeirmendjianC3 => (8.0, 1.0 / 3.0, 3.0, 100.0),
        }
    }

    /// Sizes of the drops.
    pub fn law(self) -> ModifiedGamma {
        let (alpha, b, gamma, _) = self.numbers();
        ModifiedGamma::untruncated(alpha, b, gamma)
    }

    /// Number density that the source gives (1/m³).
    pub fn number_density_m3(self) -> f64 {
        1e6 * self.numbers().3
    }
}

/// Drops of a published cloud, with the number that its source gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cloud {
    /// Which cloud.
    pub preset: CloudPreset,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opac_clouds_have_their_published_sizes_and_water() {
        // r_e [um], v_e, LWC [g/m³], extinction at Q = 2 [1/km]; r_e of 7.33 and 5.77 um as published.
        let table = [
            (7.33, 0.119, 0.276, 56.4),
            (11.28, 0.129, 0.302, 40.2),
            (5.77, 0.060, 0.261, 67.7),
            (4.00, 0.043, 0.301, 112.8),
            (12.68, 0.064, 0.440, 52.0),
            (10.72, 0.082, 0.058, 8.07),
        ];
        for (preset, (r_e, v_e, lwc, extinction)) in CloudPreset::ALL.into_iter().zip(table) {
            let bulk = preset
                .law()
                .moments()
                .bulk_properties(preset.number_density_m3());
            assert!(
                (1e6 * bulk.effective_radius_m - r_e).abs() < 0.006,
                "{preset:?} {bulk:?}"
            );
            assert!(
                (bulk.effective_variance - v_e).abs() < 6e-4,
                "{preset:?} {bulk:?}"
            );
            assert!((bulk.lwc_g_m3 - lwc).abs() < 6e-4, "{preset:?} {bulk:?}");
            assert!(
                (1e3 * bulk.extinction_m1 / extinction - 1.0).abs() < 2e-3,
                "{preset:?} {bulk:?}"
            );
        }
    }

    #[test]
    fn deirmendjian_clouds_have_their_published_constants() {
        let table = [
            (CloudPreset::DeirmendjianC1, 2.373),
            (CloudPreset::DeirmendjianC2, 1.085e-2),
            (CloudPreset::DeirmendjianC3, 5.556),
        ];
        for (preset, constant) in table {
            let found = 1e-6 * preset.number_density_m3() * preset.law().normalization();
            assert!((found / constant - 1.0).abs() < 3e-4, "{preset:?}: {found}");
        }
    }
}
