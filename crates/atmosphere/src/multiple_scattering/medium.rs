//! What a volume of air makes of the moments of the light in it.
//!
//! source function over extinction  S_lm = q_l X_lm,
//! q_l(h, lambda) = sum over c of w_c p_l,c,
//! w_c(h, lambda) = beta_s,c rho_c(h) / sum over c of beta_e,c rho_c(h)
//! `X_lm` moments of the radiance, `beta_s, beta_e` scattering and extinction coefficient, `rho`
//! relative density, `p_l` moments of the phase function,  p_l = integral of P P_l over the sphere,
//! p_0 = 1. Forward lobes are cut off at the largest degree that is kept; what is cut belongs to
//! light that hardly changes its direction.

use std::f64::consts::PI;

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::legendre_polynomials;

use crate::gathered::scatters;
use crate::gauss_legendre::Rule;
use crate::multiple_scattering::MAX_ORDERS;

/// Nodes for the moments of a phase function; 16 degrees of an asymmetry of 0.95 to 1e-6.
const N_ANGLES: usize = 128;
/// Moments below this are not kept.
const SMALLEST_MOMENT: f64 = 1e-3;
/// Share of the light that was scattered so often, straight forward, below which its largest order m
/// is not followed.
const SMALLEST_SHARE: f64 = 0.02;
/// Order m that all light keeps: that of molecules.
const LEAST_ORDER: usize = 2;

/// Phase functions by their moments.
#[derive(Debug, Clone)]
pub(crate) struct Medium {
    pub(crate) max_degree: usize,
    pub(crate) n_wavelengths: usize,
    /// Which constituents scatter.
    scatters: Vec<bool>,
    /// `[constituent][degree][wavelength]`
    // f32: as the light.
    moments: Vec<Vec<Vec<f32>>>,
}

impl Medium {
    /// The phase functions of an air up to a degree, or as far as they have any moments.
    pub(crate) fn new(air: &AtmosphereTable, max_degree: usize) -> Self {
        let max_degree = max_degree.max(1);
        let n_wavelengths = air.wavelengths.len();
        let scatters: Vec<bool> = air.constituents.iter().map(scatters).collect();
        let mut moments: Vec<Vec<Vec<f32>>> = air
            .constituents
            .iter()
            .map(|constituent| phase_moments(constituent, n_wavelengths, max_degree))
            .collect();
        let matters = |degree: &usize| {
            let mut scatterers = moments.iter().zip(&scatters).filter(|pair| *pair.1);
            scatterers.any(|(rows, _)| {
                let largest = rows[*degree].iter().fold(0.0_f32, |a, b| a.max(b.abs()));
                f64::from(largest) > SMALLEST_MOMENT
            })
        };
        // Degree 1 is the net flux, which is of use where nothing scatters by it.
        let max_degree = (1..=max_degree).rev().find(matters).unwrap_or(1);
        for rows in &mut moments {
            rows.truncate(max_degree + 1);
        }
        Self {
            max_degree,
            n_wavelengths,
            scatters,
            moments,
        }
    }

    /// Moments of every constituent: `[constituent][degree][wavelength]`.
    pub(crate) fn phase_moments(&self) -> Vec<f32> {
        let rows = self.moments.iter().flatten().flatten();
        rows.copied().collect()
    }

    /// Moments of the constituents that scatter, by degree and wavelength.
    pub(crate) fn scatterers(&self) -> impl Iterator<Item = &Vec<Vec<f32>>> {
        let pairs = self.moments.iter().zip(&self.scatters);
        pairs.filter(|pair| *pair.1).map(|pair| pair.0)
    }

    /// w_c of the constituents that scatter at every shell: `[shell][constituent, wavelength]`.
    ///
    /// A shell without air takes what the air below it has, for sources are linear from shell to
    /// shell.
    pub(crate) fn shares_at_shells(
        &self,
        air: &AtmosphereTable,
        shells_m: &[f64],
    ) -> Vec<Vec<f32>> {
        let mut shares: Vec<Vec<f32>> = Vec::with_capacity(shells_m.len());
        for &shell_m in shells_m {
            let has_air = air
                .constituents
                .iter()
                .any(|constituent| constituent.density_at(shell_m) > 0.0);
            let below = shares.last().filter(|_| !has_air).cloned();
            shares.push(below.unwrap_or_else(|| self.shares_at(air, shell_m)));
        }
        shares
    }

    /// q_l at every shell: `[shell][degree, wavelength]`.
    pub(crate) fn at_shells(&self, air: &AtmosphereTable, shells_m: &[f64]) -> Vec<Vec<f64>> {
        let n = self.n_wavelengths;
        let ratios = |shares: Vec<f32>| {
            let mut ratios = vec![0.0; (self.max_degree + 1) * n];
            for (shares, moments) in shares.chunks(n.max(1)).zip(self.scatterers()) {
                for (row, moments) in ratios.chunks_mut(n.max(1)).zip(moments) {
                    for ((ratio, share), moment) in row.iter_mut().zip(shares).zip(moments) {
                        *ratio += f64::from(share * moment);
                    }
                }
            }
            ratios
        };
        let shares = self.shares_at_shells(air, shells_m).into_iter();
        shares.map(ratios).collect()
    }

    /// Largest order m that light needs after 2, 3, … scatterings.
    ///
    /// Over flat ground each m is on its own and cannot exceed l: after n scatterings and one more
    /// into the view it has a weight of (2m+1) q_m^(n+1) at most.
    pub(crate) fn azimuth_orders(&self, ratios: &[Vec<f64>]) -> Vec<usize> {
        let n = self.n_wavelengths.max(1);
        let largest = |l: usize| {
            let values = ratios.iter().flat_map(|shell| &shell[l * n..(l + 1) * n]);
            values.fold(0.0_f64, |largest, q| largest.max(q.abs()))
        };
        let largest: Vec<f64> = (0..=self.max_degree).map(largest).collect();
        let least = LEAST_ORDER.min(self.max_degree);
        let mut order = self.max_degree;
        (2..=MAX_ORDERS)
            .map(|n_scatterings| {
                let share = |m: usize| {
                    let exponent = n_scatterings as i32 + 1;
                    (2.0 * m as f64 + 1.0) * largest[m].powi(exponent)
                };
                while order > least && share(order) < SMALLEST_SHARE {
                    order -= 1;
                }
                order
            })
            .collect()
    }

    /// w_c at a height; zeros where there is no air.
    fn shares_at(&self, air: &AtmosphereTable, height_m: f64) -> Vec<f32> {
        let mut extinction = vec![0.0; self.n_wavelengths];
        for constituent in &air.constituents {
            let density = constituent.density_at(height_m);
            for (total, beta) in extinction.iter_mut().zip(&constituent.extinction_m1) {
                *total += beta * density;
            }
        }
        let mut shares = Vec::new();
        let scatterers = air.constituents.iter().zip(&self.scatters);
        for (constituent, _) in scatterers.filter(|pair| *pair.1) {
            let density = constituent.density_at(height_m);
            let spectra = constituent.scattering_m1.iter().zip(&extinction);
            shares.extend(spectra.map(|(beta, &extinction)| {
                if extinction > 0.0 {
                    // f32: as the light.
                    (beta * density / extinction) as f32
                } else {
                    0.0
                }
            }));
        }
        shares
    }
}

fn phase_moments(
    constituent: &AirConstituent,
    n_wavelengths: usize,
    max_degree: usize,
) -> Vec<Vec<f32>> {
    let mut moments = vec![vec![0.0; n_wavelengths]; max_degree + 1];
    for (x, weight) in Rule::new(N_ANGLES).pairs() {
        let theta_rad = PI * x;
        let weight = 2.0 * PI * PI * weight * theta_rad.sin();
        let phases_sr1 = constituent.phases_at(theta_rad);
        let polynomials = legendre_polynomials(max_degree, theta_rad.cos());
        for (row, polynomial) in moments.iter_mut().zip(polynomials) {
            for (moment, phase_sr1) in row.iter_mut().zip(&phases_sr1) {
                *moment += weight * polynomial * phase_sr1;
            }
        }
    }
    // The tabulated phase function integrates to 1 within its interpolation error: no light is lost.
    let totals = moments[0].clone();
    let share = |(moment, total): (&f64, &f64)| {
        let total = if *total > 0.0 { *total } else { 1.0 };
        (moment / total) as f32
    };
    let rows = moments.iter();
    rows.map(|row| row.iter().zip(&totals).map(share).collect())
        .collect()
}
