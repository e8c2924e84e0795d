//! The angles at which single drops are computed, and how a table averages over them.
//!
//! The interference of the orders is a ripple of period near 5.2/x in the scattering angle. Small drops
//! take a coarser grid that still resolves it; drops so large that no grid would are computed on grids
//! that are shifted from size to size by parts of a step, so that what one size puts into the sun's disc
//! by accident the next one takes out again.

use std::f64::consts::PI;

use niji_mie::ScatteringAngles;
use niji_radiometry::Radians;
use rayon::prelude::*;

use crate::error::Error;
use crate::sun_disc::AverageRow;
use crate::sun_disc::FineGrid;
use crate::sun_disc::disc_row;

/// Step of the finest grid, over 1/x: 24 to a period of the ripple.
const STEP_TIMES_X: f64 = 0.22;
/// Grids, each twice as coarse as the one before.
const N_LEVELS: usize = 3;

/// Grids by level and shift.
#[derive(Clone, Debug)]
pub(crate) struct AngleGrids {
    grids: Vec<AngleGrid>,
    n_shifts: usize,
    finest_step_rad: f64,
}

/// One grid.
#[derive(Clone, Debug)]
pub(crate) struct AngleGrid {
    pub(crate) angles_rad: Vec<f64>,
    pub(crate) folded: ScatteringAngles,
    /// By angle of the table.
    averages: Vec<AverageRow>,
}

/// Where the grids lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent<'a> {
    /// Angles of the table.
    pub(crate) theta_rad: &'a [f64],
    pub(crate) disc_diameter_rad: f64,
    /// Steps of the finest grid across the sun's disc.
    pub(crate) steps_per_disc: f64,
    pub(crate) n_shifts: usize,
}

impl AngleGrids {
    pub(crate) fn new(extent: Extent) -> Result<Self, Error> {
        let radius_rad = 0.5 * extent.disc_diameter_rad;
        if radius_rad <= 0.0 {
            let folded = folded(extent.theta_rad)?;
            let own = |start| AverageRow {
                start,
                weights: vec![1.0],
            };
            return Ok(Self {
                grids: vec![AngleGrid {
                    angles_rad: extent.theta_rad.to_vec(),
                    folded,
                    averages: (0..extent.theta_rad.len()).map(own).collect(),
                }],
                n_shifts: 1,
                finest_step_rad: 0.0,
            });
        }
        let finest_step_rad = extent.disc_diameter_rad / extent.steps_per_disc;
        let grids = (0..N_LEVELS * extent.n_shifts)
            .into_par_iter()
            .map(|index| {
                let (level, shift) = (index / extent.n_shifts, index % extent.n_shifts);
                let step_rad = finest_step_rad * (1_u32 << level) as f64;
                let part = (shift as f64 + 0.5) / extent.n_shifts as f64;
                AngleGrid::even(&extent, step_rad, part)
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            grids,
            n_shifts: extent.n_shifts,
            finest_step_rad,
        })
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &AngleGrid> {
        self.grids.iter()
    }

    /// Index of the grid for the drop number `node` of size parameter `x`.
    pub(crate) fn index(&self, node: usize, x: f64) -> usize {
        let n_levels = self.grids.len() / self.n_shifts;
        let coarser = STEP_TIMES_X / (x * self.finest_step_rad);
        let level = (coarser.max(1.0).log2() as usize).min(n_levels - 1);
        // Neighbouring sizes are about a golden part of a step apart.
        let stride = (0.618 * self.n_shifts as f64).round() as usize | 1;
        level * self.n_shifts + node * stride % self.n_shifts
    }

    pub(crate) fn at(&self, index: usize) -> &AngleGrid {
        &self.grids[index]
    }
}

impl AngleGrid {
    /// An even grid that begins `part` of a step before the first angle needed.
    fn even(extent: &Extent, step_rad: f64, part: f64) -> Result<Self, Error> {
        let radius_rad = 0.5 * extent.disc_diameter_rad;
        let (first, last) = (
            extent.theta_rad[0],
            extent.theta_rad[extent.theta_rad.len() - 1],
        );
        let margin_rad = radius_rad + step_rad;
        // Up to a step outside of 0 to π, where the light is that of the mirrored angle.
        let first_rad = (first - margin_rad).max(0.0) - part * step_rad;
        let last_rad = (last + margin_rad).min(PI);
        let n_steps = ((last_rad - first_rad) / step_rad).ceil().max(1.0) as usize;
        let fine = FineGrid {
            first_rad,
            step_rad,
            n: n_steps + 1,
        };
        let angles_rad: Vec<f64> = (0..fine.n)
            .map(|index| mirrored(first_rad + step_rad * index as f64))
            .collect();
        let average = |&theta: &f64| disc_row(&fine, theta, radius_rad);
        Ok(Self {
            folded: folded(&angles_rad)?,
            angles_rad,
            averages: extent.theta_rad.iter().map(average).collect(),
        })
    }

    /// The averages that the table wants of the light at the angles of the grid.
    pub(crate) fn averages(&self, light: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.averages.iter().map(|row| row.apply(light)).collect()
    }
}

fn folded(angles_rad: &[f64]) -> Result<ScatteringAngles, Error> {
    let angles: Vec<Radians> = angles_rad.iter().copied().map(Radians).collect();
    ScatteringAngles::new(&angles).map_err(|error| Error::Drop(error.to_string()))
}

/// The scattering angle between 0 and π of a direction a little beyond.
fn mirrored(theta_rad: f64) -> f64 {
    let theta_rad = theta_rad.abs();
    theta_rad.min(2.0 * PI - theta_rad).clamp(0.0, PI)
}
