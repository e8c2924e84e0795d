//! What a volume of air makes of the moments of the light in it.
//!
//! source function over extinction  S_lm = q_l X_lm,
//! q_l(h, lambda) = sum over c of beta_s,c rho_c(h) p_l,c / sum over c of beta_e,c rho_c(h)
//! `X_lm` moments of the radiance, `beta_s, beta_e` scattering and extinction coefficient, `rho`
//! relative density, `p_l` moments of the phase function,  p_l = integral of P P_l over the sphere,
//! p_0 = 1. Forward lobes are cut off at the largest degree that is kept; what is cut belongs to
//! light that hardly changes its direction.

use std::f64::consts::PI;

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;

use crate::gauss_legendre::Rule;
use crate::multiple_scattering::harmonics::legendre;

/// Nodes for the moments of a phase function; 16 degrees of an asymmetry of 0.95 to 1e-6.
const N_ANGLES: usize = 128;
/// Moments below this are not kept.
const SMALLEST_MOMENT: f64 = 1e-3;

/// Phase functions by their moments.
#[derive(Debug, Clone)]
pub(crate) struct Medium {
    pub(crate) max_degree: usize,
    /// `[constituent][degree][wavelength]`
    moments: Vec<Vec<Vec<f64>>>,
}

impl Medium {
    /// The phase functions of an air up to a degree, or as far as they have any moments.
    pub(crate) fn new(air: &AtmosphereTable, max_degree: usize) -> Self {
        let max_degree = max_degree.max(1);
        let n_wavelengths = air.wavelengths.len();
        let moments: Vec<_> = air
            .constituents
            .iter()
            .map(|constituent| phase_moments(constituent, n_wavelengths, max_degree))
            .collect();
        let matters = |degree: &usize| {
            moments
                .iter()
                .any(|rows: &Vec<Vec<f64>>| rows[*degree].iter().any(|p| p.abs() > SMALLEST_MOMENT))
        };
        Self {
            // Degree 1 is the net flux, which is of use where nothing scatters by it.
            max_degree: (1..=max_degree).rev().find(matters).unwrap_or(1),
            moments,
        }
    }

    /// q_l at a height: `[degree * n_wavelengths + wavelength]`; zeros where there is no air.
    pub(crate) fn source_per_extinction(&self, air: &AtmosphereTable, height_m: f64) -> Vec<f64> {
        let n_wavelengths = air.wavelengths.len();
        let mut ratios = vec![0.0; (self.max_degree + 1) * n_wavelengths];
        let mut extinction = vec![0.0; n_wavelengths];
        for (constituent, moments) in air.constituents.iter().zip(&self.moments) {
            let density = constituent.density_at(height_m);
            for (total, beta) in extinction.iter_mut().zip(&constituent.extinction_m1) {
                *total += beta * density;
            }
            for (row, moments) in ratios.chunks_mut(n_wavelengths).zip(moments) {
                let spectra = row.iter_mut().zip(&constituent.scattering_m1).zip(moments);
                for ((ratio, beta), moment) in spectra {
                    *ratio += beta * density * moment;
                }
            }
        }
        for row in ratios.chunks_mut(n_wavelengths) {
            for (ratio, &extinction) in row.iter_mut().zip(&extinction) {
                *ratio = if extinction > 0.0 {
                    *ratio / extinction
                } else {
                    0.0
                };
            }
        }
        ratios
    }
}

fn phase_moments(
    constituent: &AirConstituent,
    n_wavelengths: usize,
    max_degree: usize,
) -> Vec<Vec<f64>> {
    let mut moments = vec![vec![0.0; n_wavelengths]; max_degree + 1];
    for (x, weight) in Rule::new(N_ANGLES).pairs() {
        let theta_rad = PI * x;
        let weight = 2.0 * PI * PI * weight * theta_rad.sin();
        let phases_sr1 = constituent.phases_at(theta_rad);
        for (row, polynomial) in moments
            .iter_mut()
            .zip(legendre(max_degree, theta_rad.cos()))
        {
            for (moment, phase_sr1) in row.iter_mut().zip(&phases_sr1) {
                *moment += weight * polynomial * phase_sr1;
            }
        }
    }
    // The tabulated phase function integrates to 1 within its interpolation error: no light is lost.
    let totals = moments[0].clone();
    for row in &mut moments {
        for (moment, total) in row.iter_mut().zip(&totals) {
            *moment /= if *total > 0.0 { *total } else { 1.0 };
        }
    }
    moments
}
