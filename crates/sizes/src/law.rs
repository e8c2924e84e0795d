//! The size laws by name.

use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::MarshallPalmer;
use crate::Monodisperse;
use crate::Normal;
use crate::SizeMoments;
use crate::Uniform;

/// How the radii of drops are distributed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
        }
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        match self {
            Self::Monodisperse(law) => law.moments(),
            Self::Uniform(law) => law.moments(),
            Self::Normal(law) => law.moments(),
            Self::MarshallPalmer(law) => law.moments(),
        }
    }

    /// The number density (1/m³), if the law says it and not only the shape of the distribution.
    pub fn natural_number_density_m3(&self) -> Option<f64> {
        match self {
            Self::MarshallPalmer(law) => Some(law.number_density_m3()),
            Self::Monodisperse(_) | Self::Uniform(_) | Self::Normal(_) => None,
        }
    }

    /// The name by which scene files and the program call the law.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Monodisperse(_) => "monodisperse",
            Self::Uniform(_) => "uniform",
            Self::Normal(_) => "normal",
            Self::MarshallPalmer(_) => "marshall-palmer",
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
    fn a_cubic_metre_of_known_drops_holds_known_water() {
        // 1e6 drops of 10 um: (4/3) pi 1e-15 m³ of water each, 2 pi 1e-10 m² of shadow each.
        let law = SizeLaw::Monodisperse(Monodisperse { radius_um: 10.0 });
        let fog = law.moments().bulk_properties(1e6);
        assert!((fog.lwc_g_m3 / 4.18879020478639e-3 - 1.0).abs() < 1e-14);
        assert!((fog.extinction_m1 / 6.283185307179586e-4 - 1.0).abs() < 1e-14);
        assert!((fog.effective_radius_m / 1e-5 - 1.0).abs() < 1e-15);
    }
}
