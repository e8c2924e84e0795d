//! Rows of a table from single drops: drop after drop, averaged over the sun's disc, then summed over
//! sizes.
//!
//! t̄(θ; r_e, v_e) = Σ_i w_i ⟨t(θ'; r_i)⟩ over the disc around θ
//! with the weights of [`crate::size_average`].
//!
//! Blocks of drops are independent and are added in one order, so that a table does not depend on the
//! number of threads, and no more than a block of rows a thread is held at once.

use std::collections::BTreeSet;
use std::ops::Range;

use niji_radiometry::Micrometers;
use rayon::prelude::*;

use crate::angle_grids::AngleGrids;
use crate::angle_grids::Extent;
use crate::angle_grids::N_TOGETHER;
use crate::bow_light::Bin;
use crate::drop_theory::DropTheory;
use crate::drop_theory::Part;
use crate::drop_theory::STILL_UM;
use crate::drop_theory::Setting;
use crate::drop_theory::Solution;
use crate::error::Error;
use crate::progress::Count;
use crate::request::SizeRows;
use crate::size_average::SizeNode;
use crate::size_average::SizeSampling;
use crate::size_average::size_nodes;
use crate::table_rows::RowLight;
use crate::table_rows::Task;
use crate::table_rows::add;
use crate::theory::SingleDrops;
use niji_radiometry::size_parameter;

/// Largest size parameter that the exact theories take, but for what the radius of such a drop rounds it up by; drops
/// beyond it, in the tails of laws of the largest raindrops, scatter per area as one of this size.
const LARGEST_SIZE_PARAMETER: f64 = 1e5 * (1.0 - 8.0 * f64::EPSILON);
/// Sizes in a bin, and in the cell of a single size, at least.
const LEAST_IN_BIN: usize = 2;
const LEAST_IN_CELL: usize = 8;
/// Blocks of drops for a table of one wavelength; tables of more wavelengths have fewer each.
const N_BLOCKS: usize = 32;
/// Fineness of the angles: their steps across the sun's disc, times the tolerance.
const STEPS_TIMES_TOLERANCE: f64 = 0.06;

/// What the rows of all wavelengths share.
pub(crate) struct DropRows<'a> {
    task: Task<'a>,
    solution: Solution,
    grids: AngleGrids,
    pub(crate) nodes: Vec<SizeNode>,
}

/// All rows of one wavelength, and then once more those of each order that is kept apart.
pub(crate) type Rows = Vec<RowLight>;

impl<'a> DropRows<'a> {
    pub(crate) fn new(task: Task<'a>, method: SingleDrops) -> Result<Self, Error> {
        let request = task.request;
        let sizes = size_sampling(task, method.solution);
        let mut nodes = size_nodes(
            &request.effective_radius_um,
            &request.effective_variance,
            sizes,
        )?;
        // Of the longest wavelength most drops are small.
        let longest = request.wavelengths.center(request.wavelengths.len() - 1);
        for node in &mut nodes {
            let weight = |row| task.blend.share_of_drop(row, node.radius, longest);
            node.uses.retain(|(row, _)| weight(*row) > 0.0);
        }
        nodes.retain(|node| !node.uses.is_empty());
        let bins = (0..request.wavelengths.len()).map(|index| Bin::new(request, index));
        let drops = bins.flat_map(|bin| {
            let numbered = nodes.iter().enumerate();
            numbered.map(move |(index, node)| (index, computed_parameter(node.radius, bin)))
        });
        let [least, most] = method.steps_per_disc;
        let extent = Extent {
            theta_rad: task.theta_rad,
            disc_diameter_rad: 2.0 * request.disc_radius_rad(),
            steps_per_disc: (STEPS_TIMES_TOLERANCE / request.tolerance).clamp(least, most),
            n_shifts: method.n_shifts,
        };
        Ok(Self {
            grids: AngleGrids::new(extent, drops)?,
            solution: method.solution,
            task,
            nodes,
        })
    }

    /// All rows at one wavelength.
    pub(crate) fn at(&self, bin: Bin, count: Count) -> Result<Rows, Error> {
        let setting = Setting {
            bin,
            orders: self.task.request.orders_in(),
            flattened: self.flattened(bin),
            grids: &self.grids,
        };
        let theory = DropTheory::new(self.solution, setting)?;
        let n_blocks = N_BLOCKS.div_ceil(self.task.request.wavelengths.len());
        let of_blocks: Vec<Rows> = self
            .blocks(n_blocks)
            .into_par_iter()
            .map(|block| {
                let rows = self.block(&theory, bin, block.clone())?;
                count(block.len())?;
                Ok(rows)
            })
            .collect::<Result<_, Error>>()?;
        // In the order of the blocks.
        let sum = of_blocks.into_iter().reduce(|mut sum, rows| {
            for (sum, row) in sum.iter_mut().zip(&rows) {
                add(sum, 1.0, row);
            }
            sum
        });
        Ok(sum.unwrap_or_default())
    }

    /// Ranges of drops of about the same cost, which goes with the radius.
    fn blocks(&self, n_blocks: usize) -> Vec<Range<usize>> {
        let total: f64 = self.nodes.iter().map(|node| node.radius.0).sum();
        let mut blocks = Vec::with_capacity(n_blocks);
        let (mut start, mut sum) = (0, 0.0);
        for (index, node) in self.nodes.iter().enumerate() {
            sum += node.radius.0;
            let is_last = index + 1 == self.nodes.len();
            if is_last || sum >= total * (blocks.len() + 1) as f64 / n_blocks as f64 {
                blocks.push(start..index + 1);
                start = index + 1;
            }
        }
        blocks
    }

    fn block(&self, theory: &DropTheory, bin: Bin, block: Range<usize>) -> Result<Rows, Error> {
        let moved = &self.task.moved.orders;
        let n_rows = self.task.request.n_rows();
        let n_angles = self.task.theta_rad.len();
        let mut rows = vec![vec![[0.0; 2]; n_angles]; n_rows * (1 + moved.len())];
        // Ascending radii, so that every sum has one order.
        for (grid_index, together) in self.runs(bin, block) {
            let (mut radii, mut uses) = (Vec::new(), Vec::new());
            for node in &self.nodes[together] {
                let used = self.uses(node, bin);
                if !used.is_empty() {
                    radii.push(computed(node.radius, bin));
                    uses.push(used);
                }
            }
            let lights = theory.drops(&radii, grid_index)?;
            let grid = self.grids.at(grid_index);
            for (uses, parts) in summed(uses, lights) {
                for part in &parts {
                    let averaged = grid.averages.of_both(&part.light);
                    let own = moved.iter().position(|order| part.moved == Some(*order));
                    for &(row, weight) in &uses {
                        let own_row = own.map(|index| (1 + index) * n_rows + row);
                        for row in [Some(row), own_row].into_iter().flatten() {
                            add(&mut rows[row], weight, &averaged);
                        }
                    }
                }
            }
        }
        Ok(rows)
    }

    /// The grids of drops whose light is moved.
    fn flattened(&self, bin: Bin) -> BTreeSet<usize> {
        if self.task.request.motion.is_none() {
            return BTreeSet::new();
        }
        let nodes = self.nodes.iter().enumerate();
        let flattened = nodes.filter(|(_, node)| node.radius.0 >= STILL_UM);
        let grid = |(index, node): (usize, &SizeNode)| {
            self.grids
                .index(index, computed_parameter(node.radius, bin))
        };
        flattened.map(grid).collect()
    }

    /// What a drop is used for at a wavelength.
    fn uses(&self, node: &SizeNode, bin: Bin) -> Uses {
        let weighed = |(row, weight): &(usize, f64)| {
            let of_row = self.task.blend.share_of_drop(*row, node.radius, bin.center);
            (*row, weight * of_row)
        };
        let uses = node.uses.iter().map(weighed);
        uses.filter(|(_, weight)| *weight > 0.0).collect()
    }

    /// Stretches of drops on one grid, with its index.
    fn runs(&self, bin: Bin, block: Range<usize>) -> Vec<(usize, Range<usize>)> {
        let mut runs: Vec<(usize, Range<usize>)> = Vec::new();
        for index in block {
            let grid_index = self
                .grids
                .index(index, computed_parameter(self.nodes[index].radius, bin));
            match runs.last_mut() {
                Some((of_run, run)) if *of_run == grid_index && run.len() < N_TOGETHER => {
                    run.end = index + 1;
                }
                Some(_) | None => runs.push((grid_index, index..index + 1)),
            }
        }
        runs
    }
}

/// The radius that stands for one, no larger than theories take.
fn computed(radius: Micrometers, bin: Bin) -> Micrometers {
    Micrometers(radius.0 * computed_parameter(radius, bin) / size_parameter(radius, bin.center))
}

fn computed_parameter(radius: Micrometers, bin: Bin) -> f64 {
    size_parameter(radius, bin.center).min(LARGEST_SIZE_PARAMETER)
}

/// Rows and weights in them.
type Uses = Vec<(usize, f64)>;

/// Light with what it is used for; neighbors that serve the same row alone are added up, so that they are
/// averaged over the disc at once.
fn summed(uses: Vec<Uses>, lights: Vec<Vec<Part>>) -> Vec<(Uses, Vec<Part>)> {
    let mut summed: Vec<(Uses, Vec<Part>)> = Vec::new();
    for (uses, parts) in uses.into_iter().zip(lights) {
        match summed.last_mut() {
            Some((of_sum, sum))
                if of_sum.len() == 1 && *of_sum == uses && sum.len() == parts.len() =>
            {
                for (sum, part) in sum.iter_mut().zip(&parts) {
                    add(&mut sum.light, 1.0, &part.light);
                }
            }
            Some(_) | None => summed.push((uses, parts)),
        }
    }
    summed
}

fn size_sampling(task: Task, solution: Solution) -> SizeSampling {
    // Bins are never seen alone: the narrowest law is three of them wide.
    let rows = task.request.rows;
    let is_bin = matches!(rows, SizeRows::Bins { ln_step, .. } if ln_step > 0.0);
    match solution {
        Solution::LorenzMie => SizeSampling::Rippled {
            tolerance: task.request.tolerance,
            least_in_cell: if is_bin { LEAST_IN_BIN } else { LEAST_IN_CELL },
        },
        Solution::Debye => SizeSampling::Smooth,
    }
}

#[cfg(test)]
mod tests {
    use niji_radiometry::Nanometers;

    use super::*;

    #[test]
    fn drops_of_any_size_are_no_larger_than_the_theories_take() {
        for step in 0..1000 {
            let bin = Bin {
                center: Nanometers(380.0 + 0.4 * f64::from(step)),
                width: Nanometers(10.0),
                index: 1.33,
            };
            for radius_um in [6100.0, 7000.0 + 3.7 * f64::from(step), 20_000.0] {
                let radius = computed(Micrometers(radius_um), bin);
                let found = size_parameter(radius, bin.center);
                assert!(found <= 1e5, "{radius_um} um at {:?}: {found}", bin.center);
            }
        }
    }
}
