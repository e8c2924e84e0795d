//! The phase functions that constituents may have, 1/sr, integral over the sphere 1.

use std::f64::consts::PI;

use niji_radiometry::Radians;

use crate::cornette_shanks::cornette_shanks;
use crate::error::Error;
use crate::error::within;
use crate::henyey_greenstein::henyey_greenstein;
use crate::king_factor::KingFactor;
use crate::rayleigh_phase::rayleigh_phase;

/// Largest asymmetry that the table's 0.5 degree steps resolve.
const LARGEST_ASYMMETRY: f64 = 0.95;

/// How light leaves a volume element of a constituent.
#[derive(Debug, Clone, PartialEq)]
pub enum PhaseFunction {
    /// Equal in all directions; also where nothing is scattered.
    Isotropic,
    /// Air molecules.
    Rayleigh {
        /// King factor by wavelength; 1 is Rayleigh's own phase function.
        king_factor: Vec<f64>,
    },
    /// Aerosol with a forward lobe.
    HenyeyGreenstein {
        /// Mean of the scattering cosine.
        asymmetry: f64,
    },
    /// Aerosol with a forward lobe and more light backwards than sideways.
    CornetteShanks {
        /// The parameter g of the formula.
        parameter: f64,
    },
}

impl PhaseFunction {
    /// Value at a scattering angle, 1/sr.
    pub fn at(&self, wavelength_index: usize, theta: Radians) -> f64 {
        match self {
            Self::Isotropic => 1.0 / (4.0 * PI),
            Self::Rayleigh { king_factor } => rayleigh_phase(king_factor[wavelength_index], theta),
            Self::HenyeyGreenstein { asymmetry } => henyey_greenstein(*asymmetry, theta),
            Self::CornetteShanks { parameter } => cornette_shanks(*parameter, theta),
        }
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        let range = [-LARGEST_ASYMMETRY, LARGEST_ASYMMETRY];
        match self {
            Self::Isotropic => Ok(()),
            Self::Rayleigh { king_factor } => king_factor
                .iter()
                .try_for_each(|factor| KingFactor::Constant(*factor).check()),
            Self::HenyeyGreenstein { asymmetry: g } | Self::CornetteShanks { parameter: g } => {
                within("asymmetry", *g, range).map(|_| ())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gauss_legendre::Rule;

    fn all() -> Vec<PhaseFunction> {
        vec![
            PhaseFunction::Isotropic,
            PhaseFunction::Rayleigh {
                king_factor: vec![1.0],
            },
            PhaseFunction::Rayleigh {
                king_factor: vec![1.05],
            },
            PhaseFunction::HenyeyGreenstein { asymmetry: 0.7 },
            PhaseFunction::HenyeyGreenstein { asymmetry: -0.5 },
            PhaseFunction::CornetteShanks { parameter: 0.76 },
            PhaseFunction::CornetteShanks { parameter: 0.95 },
        ]
    }

    fn mean(phase: &PhaseFunction, weight: impl Fn(f64) -> f64) -> f64 {
        let integrand =
            |theta: f64| 2.0 * PI * theta.sin() * weight(theta.cos()) * phase.at(0, Radians(theta));
        Rule::new(200).integrate(0.0, PI, integrand)
    }

    #[test]
    fn every_phase_function_integrates_to_1() {
        for phase in all() {
            let total = mean(&phase, |_| 1.0);
            assert!((total - 1.0).abs() < 1e-9, "{phase:?}: {total}");
        }
    }

    #[test]
    fn the_asymmetry_is_the_mean_cosine() {
        let phase = PhaseFunction::HenyeyGreenstein { asymmetry: 0.7 };
        assert!((mean(&phase, |mu| mu) - 0.7).abs() < 1e-9);
    }

    #[test]
    fn cornette_shanks_without_asymmetry_is_rayleighs() {
        let (cs, rayleigh) = (
            PhaseFunction::CornetteShanks { parameter: 0.0 },
            PhaseFunction::Rayleigh {
                king_factor: vec![1.0],
            },
        );
        for theta in [0.0, 0.5, 1.6, PI] {
            let theta = Radians(theta);
            assert!((cs.at(0, theta) - rayleigh.at(0, theta)).abs() < 1e-16);
        }
        // 3/(16 pi) at 90 degrees, twice that forward.
        assert!((rayleigh.at(0, Radians(0.5 * PI)) - 0.059_683_103_659_460_75).abs() < 1e-15);
    }

    #[test]
    fn cornette_shanks_is_0_94_of_henyey_greenstein_where_the_bow_stands() {
        let theta = Radians::from_degrees(138.0);
        let ratio = cornette_shanks(0.7, theta) / henyey_greenstein(0.7, theta);
        assert!((ratio - 0.935).abs() < 2e-3, "{ratio}");
    }

    #[test]
    fn depolarization_fills_the_minimum_at_90_degrees() {
        let plain = rayleigh_phase(1.0, Radians(0.5 * PI));
        let real = rayleigh_phase(1.0488, Radians(0.5 * PI));
        // gamma = 0.01436: (1 + 3 gamma)/(1 + 2 gamma) = 1.01396.
        assert!((real / plain - 1.01396).abs() < 1e-4, "{}", real / plain);
    }
}
