//! The angles at which single drops are computed, and how a table averages over them.
//!
//! The interference of the orders is a ripple of period near 5.2/x in the scattering angle. Small drops
//! take a coarser grid that still resolves it; drops so large that no grid would are computed on grids
//! that are shifted from size to size by parts of a step, so that what one size puts into the sun's disc
//! by accident the next one takes out again.
//!
//! A grid of step h is (k − shift) h for whole k, counted from 0 degrees in front of the drop and from 180
//! behind it: the light of an angle and of its mirror is one computation, so that a sphere costs as
//! much as half of it.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_mie::ScatteringAngles;
use niji_radiometry::Radians;
use rayon::prelude::*;

use crate::error::Error;
use crate::rings::DiscAverage;
use crate::sun_disc::AverageRow;
use crate::sun_disc::FineGrid;
use crate::sun_disc::disc_row;

/// Step of the finest grid, over 1/x: 12 to a period of the ripple, 7 to the narrowest fringe π/x.
const STEP_TIMES_X: f64 = 0.44;
/// Steps of the coarsest grid across the sun's disc, at least; grids are each √2 as coarse as the one before.
const LEAST_STEPS_PER_DISC: f64 = 2.1;
/// Consecutive drops on one grid.
pub(crate) const N_TOGETHER: usize = 8;

/// Grids by level and shift, those that are used.
#[derive(Clone, Debug)]
pub(crate) struct AngleGrids {
    grids: BTreeMap<usize, AngleGrid>,
    lattice: Option<Lattice>,
}

/// Steps and shifts of the grids.
#[derive(Clone, Copy, Debug)]
struct Lattice {
    finest_step_rad: f64,
    coarsest_level: usize,
    n_shifts: usize,
}

/// One grid.
#[derive(Clone, Debug)]
pub(crate) struct AngleGrid {
    pub(crate) angles_rad: Vec<f64>,
    pub(crate) folded: ScatteringAngles,
    pub(crate) averages: DiscAverage,
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
    /// The grids for drops by number and size parameter.
    pub(crate) fn new(
        extent: Extent,
        drops: impl Iterator<Item = (usize, f64)>,
    ) -> Result<Self, Error> {
        if extent.disc_diameter_rad <= 0.0 {
            let grid = AngleGrid {
                folded: folded(extent.theta_rad)?,
                angles_rad: extent.theta_rad.to_vec(),
                averages: DiscAverage::of_point(extent.theta_rad.len()),
            };
            return Ok(Self {
                grids: BTreeMap::from([(0, grid)]),
                lattice: None,
            });
        }
        let lattice = Lattice {
            finest_step_rad: extent.disc_diameter_rad / extent.steps_per_disc,
            coarsest_level: (2.0 * (extent.steps_per_disc / LEAST_STEPS_PER_DISC).log2()) as usize,
            n_shifts: extent.n_shifts,
        };
        let used: BTreeSet<usize> = drops.map(|(drop, x)| lattice.index(drop, x)).collect();
        let used: Vec<usize> = used.into_iter().collect();
        let grids: Vec<AngleGrid> = used
            .par_iter()
            .map(|&index| AngleGrid::even(&extent, lattice.grid(index)))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            grids: used.into_iter().zip(grids).collect(),
            lattice: Some(lattice),
        })
    }

    /// Index of the grid for a drop of size parameter `x`, one of those it was made for.
    pub(crate) fn index(&self, drop: usize, x: f64) -> usize {
        self.lattice.map_or(0, |lattice| lattice.index(drop, x))
    }

    pub(crate) fn at(&self, index: usize) -> &AngleGrid {
        &self.grids[&index]
    }
}

impl Lattice {
    fn index(self, drop: usize, x: f64) -> usize {
        let coarser = STEP_TIMES_X / (x * self.finest_step_rad);
        let level = ((2.0 * coarser.max(1.0).log2()) as usize).min(self.coarsest_level);
        if level > 0 {
            return self.n_shifts + level;
        }
        // Neighbouring sizes are about a golden part of a step apart.
        let stride = (0.618 * self.n_shifts as f64).round() as usize | 1;
        drop / N_TOGETHER * stride % self.n_shifts
    }

    /// Step and shift.
    fn grid(self, index: usize) -> (f64, f64) {
        let level = index.saturating_sub(self.n_shifts);
        // Grids that resolve their drops are not shifted.
        let shift = if level > 0 {
            0.5
        } else {
            (index as f64 + 0.5) / self.n_shifts as f64
        };
        let step_rad = self.finest_step_rad * (0.5 * level as f64).exp2();
        (step_rad, shift)
    }
}

impl AngleGrid {
    /// An even grid of a step and a shift, in parts of the step.
    fn even(extent: &Extent, (step_rad, shift): (f64, f64)) -> Result<Self, Error> {
        let radius_rad = 0.5 * extent.disc_diameter_rad;
        let n_front = extent
            .theta_rad
            .partition_point(|theta| *theta <= FRAC_PI_2);
        let (front, back) = extent.theta_rad.split_at(n_front);
        let back: Vec<f64> = back.iter().map(|theta| PI - theta).collect();
        let mut angles_rad = Vec::new();
        let mut averages = Vec::with_capacity(extent.theta_rad.len());
        for (from_axis_rad, is_behind) in [(front, false), (&back, true)] {
            let least = from_axis_rad.iter().copied().reduce(f64::min);
            let Some((least, most)) = least.zip(from_axis_rad.iter().copied().reduce(f64::max))
            else {
                continue;
            };
            // Up to a step outside of 0 to π, where the light is that of the mirrored angle.
            let first = ((least - radius_rad).max(0.0) / step_rad + shift).floor() - shift;
            let last = ((most + radius_rad) / step_rad + shift).ceil() - shift;
            let fine = FineGrid {
                first_rad: first * step_rad,
                step_rad,
                n: (last - first).round() as usize + 1,
            };
            let start = angles_rad.len();
            angles_rad.extend((0..fine.n).map(|index| {
                let from_axis = ((first + index as f64) * step_rad).abs();
                if is_behind { PI - from_axis } else { from_axis }
            }));
            averages.extend(from_axis_rad.iter().map(|&theta| {
                let row = disc_row(&fine, theta, radius_rad);
                AverageRow {
                    start: start + row.start,
                    ..row
                }
            }));
        }
        Ok(Self {
            folded: folded(&angles_rad)?,
            angles_rad,
            averages: DiscAverage(averages),
        })
    }
}

fn folded(angles_rad: &[f64]) -> Result<ScatteringAngles, Error> {
    let angles: Vec<Radians> = angles_rad.iter().copied().map(Radians).collect();
    Ok(ScatteringAngles::new(&angles)?)
}
