//! The size laws by name.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Cloud;
use crate::Error;
use crate::HansenTravis;
use crate::Lognormal;
use crate::MarshallPalmer;
use crate::MarshallPalmerDbz;
use crate::ModifiedGamma;
use crate::Monodisperse;
use crate::Normal;
use crate::RosinRammler;
use crate::SizeMoments;
use crate::TruncatedNormal;
use crate::Ulbrich;
use crate::Uniform;

/// How the radii of drops are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SizeLaw {
    /// One radius.
    Monodisperse(Monodisperse),
    /// A range of radii, all equally frequent.
    Uniform(Uniform),
    /// Normally distributed radii, cut off at 0.
    Normal(Normal),
    /// Natural rain by rain rate.
    MarshallPalmer(MarshallPalmer),
    /// Natural rain by what a radar measures.
    MarshallPalmerDbz(MarshallPalmerDbz),
    /// A published cloud or fog.
    Cloud(Cloud),
    /// Cloud drops by the exponents of a modified gamma law.
    ModifiedGamma(ModifiedGamma),
    /// A gamma law by effective radius and effective variance.
    HansenTravis(HansenTravis),
    /// Raindrops of a gamma law by shape and slope.
    Ulbrich(Ulbrich),
    /// Lognormally distributed radii.
    Lognormal(Lognormal),
    /// A spray by share of the water.
    RosinRammler(RosinRammler),
    /// Normally distributed radii, cut off at two diameters.
    TruncatedNormal(TruncatedNormal),
}

impl SizeLaw {
    /// Check the parameters; the other functions assume that they are sound.
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::EmptyRange`], naming the parameter.
    pub fn validate(&self) -> Result<(), Error> {
        match self {
            Self::Monodisperse(law) => law.validate(),
            Self::Uniform(law) => law.validate(),
            Self::Normal(law) => law.validate(),
            Self::MarshallPalmer(law) => law.validate(),
            Self::MarshallPalmerDbz(law) => law.validate(),
            // Published numbers are sound.
            Self::Cloud(_) => Ok(()),
            Self::ModifiedGamma(law) => law.validate(),
            Self::HansenTravis(law) => law.validate(),
            Self::Ulbrich(law) => law.validate(),
            Self::Lognormal(law) => law.validate(),
            Self::RosinRammler(law) => law.validate(),
            Self::TruncatedNormal(law) => law.validate(),
        }
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        match self {
            Self::Monodisperse(law) => law.moments(),
            Self::Uniform(law) => law.moments(),
            Self::Normal(law) => law.moments(),
            Self::MarshallPalmer(law) => law.moments(),
            Self::MarshallPalmerDbz(law) => law.moments(),
            Self::Cloud(cloud) => cloud.preset.law().moments(),
            Self::ModifiedGamma(law) => law.moments(),
            Self::HansenTravis(law) => law.moments(),
            Self::Ulbrich(law) => law.moments(),
            Self::Lognormal(law) => law.moments(),
            Self::RosinRammler(law) => law.moments(),
            Self::TruncatedNormal(law) => law.moments(),
        }
    }

    /// The number density (1/m³), if the law says it and not only the shape of the distribution.
    pub fn natural_number_density_m3(&self) -> Option<f64> {
        match self {
            Self::MarshallPalmer(law) => Some(law.number_density_m3()),
            Self::MarshallPalmerDbz(law) => Some(law.number_density_m3()),
            Self::Cloud(cloud) => Some(cloud.preset.number_density_m3()),
            Self::Monodisperse(_)
            | Self::Uniform(_)
            | Self::Normal(_)
            | Self::ModifiedGamma(_)
            | Self::HansenTravis(_)
            | Self::Ulbrich(_)
            | Self::Lognormal(_)
            | Self::RosinRammler(_)
            | Self::TruncatedNormal(_) => None,
        }
    }

    /// The name by which scene files and the program call the law.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Monodisperse(_) => "monodisperse",
            Self::Uniform(_) => "uniform",
            Self::Normal(_) => "normal",
            Self::MarshallPalmer(_) => "marshall-palmer",
            Self::MarshallPalmerDbz(_) => "marshall-palmer-dbz",
            Self::Cloud(_) => "cloud",
            Self::ModifiedGamma(_) => "modified-gamma",
            Self::HansenTravis(_) => "hansen-travis",
            Self::Ulbrich(_) => "ulbrich",
            Self::Lognormal(_) => "lognormal",
            Self::RosinRammler(_) => "rosin-rammler",
            Self::TruncatedNormal(_) => "truncated-normal",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_are_written_with_their_name_and_units() {
        let law = SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0));
        let text = serde_json::to_string(&law).unwrap();
        assert_eq!(text, r#"{"marshall-palmer":{"rain_rate_mm_h":5.0}}"#);
        assert_eq!(serde_json::from_str::<SizeLaw>(&text).unwrap(), law);
    }

    #[test]
    fn radar_rain_and_clouds_say_how_many_drops_they_have() {
        for (text, number_density_m3) in [
            // 5 mm/h by Z = 296 R^1.47, where N0/Lambda = 2736.
            (
                r#"{"marshall-palmer-dbz":{"reflectivity_dbz":34.988}}"#,
                2736.0,
            ),
            (r#"{"cloud":{"preset":"fog"}}"#, 1.5e7),
        ] {
            let law: SizeLaw = serde_json::from_str(text).unwrap();
            law.validate().unwrap();
            let found = law.natural_number_density_m3().unwrap();
            assert!((found / number_density_m3 - 1.0).abs() < 1e-3, "{found}");
            assert_eq!(serde_json::to_string(&law).unwrap(), text);
        }
    }

    #[test]
    fn misspelt_keys_are_refused() {
        let text = r#"{"monodisperse":{"radius_mm":0.1}}"#;
        let message = serde_json::from_str::<SizeLaw>(text)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("radius_mm") && message.contains("radius_um"),
            "{message}"
        );
    }

    #[test]
    fn every_law_has_the_variance_of_its_own_moments() {
        let laws = [
            SizeLaw::Monodisperse(Monodisperse { radius_um: 10.0 }),
            SizeLaw::Uniform(Uniform {
                radius_min_um: 10.0,
                radius_max_um: 90.0,
            }),
            SizeLaw::Normal(Normal {
                radius_mean_um: 50.0,
                radius_standard_deviation_um: 10.0,
            }),
            SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0)),
        ];
        for law in laws {
            assert_eq!(law.validate(), Ok(()));
            let m = law.moments();
            assert!(m.mean_r_um.powi(2) <= m.mean_r2_um2 && m.mean_r_um <= m.effective_radius().0);
            assert!((0.0..0.5).contains(&m.effective_variance), "{}", law.name());
        }
    }

    #[test]
    fn gamma_laws_are_their_own_equivalent() {
        let exact = [
            SizeLaw::Monodisperse(Monodisperse { radius_um: 10.0 }),
            SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0)),
        ];
        for law in exact {
            assert!((law.moments().equivalent_gamma_drops() - 1.0).abs() < 1e-14);
        }
        let (d_min_mm, d_max_mm) = (Some(0.1), Some(6.0));
        let cut = MarshallPalmer {
            rain_rate_mm_h: 5.0,
            d_min_mm,
            d_max_mm,
        };
        // 2042 drops instead of about 2736 N0/Lambda, of which the cut took the smallest.
        let share = 1.0 / cut.moments().equivalent_gamma_drops();
        assert!((share - 0.776).abs() < 1e-3, "{share}");
    }

    #[test]
    fn a_law_too_wide_for_a_gamma_law_keeps_its_area_and_water() {
        let spray = SizeLaw::Lognormal(Lognormal {
            radius_median_um: 50.0,
            geometric_standard_deviation: 2.0,
            d_min_mm: None,
            d_max_mm: None,
        });
        let (all, bounded) = (spray.moments(), spray.moments().with_variance_at_most(0.49));
        assert!(all.effective_variance > 0.6 && bounded.effective_variance == 0.49);
        let (all, bounded) = (all.bulk_properties(1e6), bounded.bulk_properties(1e6));
        assert_eq!(all.lwc_g_m3, bounded.lwc_g_m3);
        assert_eq!(all.extinction_m1, bounded.extinction_m1);
    }

    #[test]
    fn a_cubic_metre_of_known_drops_holds_known_water() {
        // 1e6 drops of 10 um: (4/3) pi 1e-15 m³ of water each, 2 pi 1e-10 m² of shadow each.
        let law = SizeLaw::Monodisperse(Monodisperse { radius_um: 10.0 });
        let fog = law.moments().bulk_properties(1e6);
        assert!((fog.lwc_g_m3 / 4.18879020478639e-3 - 1.0).abs() < 1e-14);
        assert!((fog.extinction_m1 / 6.283185307179586e-4 - 1.0).abs() < 1e-14);
        assert!((fog.effective_radius_m / 1e-5 - 1.0).abs() < 1e-15);
    }
}
