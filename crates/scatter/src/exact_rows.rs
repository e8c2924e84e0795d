//! Rows of a table by the exact theories: drop after drop, then the sun's disc, then the sizes.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_radiometry::Nanometers;
use niji_radiometry::water_refractive_index;
use rayon::prelude::*;

use crate::drop_theory::DropTheory;
use crate::drop_theory::Setting;
use crate::error::Error;
use crate::request::TableRequest;
use crate::size_average::SizeNode;
use crate::size_average::size_nodes;
use crate::sun_disc::AverageRow;
use crate::sun_disc::FineGrid;
use crate::sun_disc::disc_row;

/// Finest and coarsest steps of the angles at which single drops are computed.
const FINE_STEPS_RAD: (f64, f64) = (0.01 * PI / 180.0, 0.05 * PI / 180.0);
/// Steps of the fine grid across the sun's disc, at least.
const STEPS_PER_DISC: f64 = 24.0;
/// Steps of the fine grid in a fringe of the largest drop, 6 degrees inside the primary bow.
const STEPS_PER_FRINGE: f64 = 4.0;
/// Largest number of samples along θ.
const MOST_ANGLES: usize = 40_000;

/// What the rows of all wavelengths share.
pub(crate) struct ExactRows<'a> {
    request: &'a TableRequest<'a>,
    angles_rad: Vec<f64>,
    averages: Vec<AverageRow>,
    drops: Vec<SizeNode>,
}

impl<'a> ExactRows<'a> {
    pub(crate) fn new(request: &'a TableRequest<'a>, theta_rad: &[f64]) -> Result<Self, Error> {
        let fine = fine_grid(request);
        let radius_rad = 0.5 * request.sun_disc_diameter_rad;
        let row = |&theta: &f64| {
            if radius_rad > 0.0 {
                disc_row(&fine, theta, radius_rad)
            } else {
                fine.row(theta)
            }
        };
        Ok(Self {
            request,
            angles_rad: (0..fine.n).map(|index| fine.angle(index)).collect(),
            averages: theta_rad.par_iter().map(row).collect(),
            drops: size_nodes(&request.effective_radius_um, &request.effective_variance)?,
        })
    }

    pub(crate) fn n_drops(&self) -> usize {
        self.drops.len()
    }

    /// All rows at one wavelength: by row and angle, both polarisations in 1/sr.
    pub(crate) fn at(
        &self,
        wavelength: Nanometers,
        count: &dyn Fn(usize),
    ) -> Result<Vec<Vec<[f64; 2]>>, Error> {
        let theory = DropTheory::new(Setting {
            theory: self.request.theory,
            orders: &self.request.orders,
            wavelength,
            index: water_refractive_index(wavelength, self.request.temperature_c),
            angles_rad: &self.angles_rad,
        })?;
        let n_rows = self.request.effective_radius_um.len() * self.request.effective_variance.len();
        let mut rows = vec![vec![[0.0; 2]; self.averages.len()]; n_rows];
        // Ascending radii, so that every sum has one order.
        for node in &self.drops {
            let drop = theory.drop(node.radius)?;
            let averaged: Vec<[f64; 2]> =
                self.averages.iter().map(|row| row.apply(&drop)).collect();
            for &(row, weight) in &node.uses {
                for (sum, value) in rows[row].iter_mut().zip(&averaged) {
                    sum[0] += weight * value[0];
                    sum[1] += weight * value[1];
                }
            }
            count(1);
        }
        Ok(rows)
    }
}

/// Even angles that resolve the fringes of the largest drop and the sun's disc, and reach a disc
/// beyond the table.
fn fine_grid(request: &TableRequest) -> FineGrid {
    let largest_um = request.effective_radius_um.last().copied().unwrap_or(1.0);
    let x = TAU * 1e3 * largest_um / request.wavelengths.center(0).0;
    // Scale of the bow (h/x²)^(1/3) with h near 5; fringe period π scale/sqrt(ζ) at ζ = d/scale.
    let scale_rad = 1.7 * x.powf(-2.0 / 3.0);
    let fringe_rad = PI * scale_rad * (scale_rad / 0.105).sqrt();
    let mut step_rad = (fringe_rad / STEPS_PER_FRINGE).clamp(FINE_STEPS_RAD.0, FINE_STEPS_RAD.1);
    if request.sun_disc_diameter_rad > 0.0 {
        step_rad = step_rad.min(request.sun_disc_diameter_rad / STEPS_PER_DISC);
    }
    let margin_rad = 0.5 * request.sun_disc_diameter_rad + step_rad;
    let first_rad = (request.theta_range_rad.0 - margin_rad).max(0.0);
    let last_rad = (request.theta_range_rad.1 + margin_rad).min(PI);
    let n_steps = ((last_rad - first_rad) / step_rad).ceil().max(1.0);
    let n_steps = n_steps.min(MOST_ANGLES as f64);
    FineGrid {
        first_rad,
        step_rad: (last_rad - first_rad) / n_steps,
        n: n_steps as usize + 1,
    }
}
