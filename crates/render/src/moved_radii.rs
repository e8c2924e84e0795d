//! The radii at which light of flattened drops is moved: as many as a size law asks for.
//!
//! A table's single sizes lie as close together as its narrowest law asks for. A law of effective variance
//! v is the sum of fewer: every second, fourth, ... of them, each the mean over what lies around it, where
//! their step of ln r is no more than [`bin_step`] of v, as if the table had been made for that law alone.
//!
//! The bow of a large drop moves by more than the sun is wide from one radius to the next. There a row is
//! used several times, each at the shift of its own radius.

use std::f64::consts::PI;

use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::ScatteringTable;
use niji_sizes::bin_step;

use crate::size_nodes::SizeNodes;

/// How far a bow may move from one shaded radius to the next: half of the sun's diameter, or the standard
/// deviation of trembling drops.
pub(crate) const SHIFT_STEP_RAD: f64 = 0.25 * PI / 180.0;
/// Most radii for one row.
const MOST_USES: f64 = 64.0;

/// Rows of what moves and their weights in a row that is moved.
pub(crate) type RowMean = Vec<(usize, f64)>;

/// A radius at which light is moved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadedRadius {
    /// Of the rows that are moved, the nearest one.
    pub(crate) row: usize,
    pub(crate) drops: FallingDrops,
}

/// Radii for laws of any width.
#[derive(Clone, Debug)]
pub(crate) struct MovedRadii {
    /// By distance of their radii, from the closest.
    rungs: Vec<Rung>,
    /// All rows that are moved.
    pub(crate) rows: Vec<RowMean>,
    /// All radii at which they are.
    pub(crate) shaded: Vec<ShadedRadius>,
}

/// Radii at about one distance.
#[derive(Clone, Debug)]
pub(crate) struct Rung {
    /// Rows of the table from one to the next.
    stride: usize,
    /// Micrometres, ascending, those that do not move before those that do.
    pub(crate) radii_um: Vec<f64>,
    /// How many of them do not move.
    pub(crate) n_still: usize,
    /// Where those that do stand among all shaded radii.
    pub(crate) first: usize,
}

impl MovedRadii {
    /// Those that the nodes of sizes ask for.
    pub(crate) fn new(table: &ScatteringTable, moved: &MovedBows, nodes: &SizeNodes) -> Self {
        let mut radii = Self {
            rungs: Vec::new(),
            rows: Vec::new(),
            shaded: Vec::new(),
        };
        let mut strides: Vec<usize> = (nodes.variance.iter())
            .map(|variance| stride_of(table, *variance))
            .collect();
        strides.sort_unstable();
        strides.dedup();
        for stride in strides {
            radii.add_rung((table, moved), stride);
        }
        radii
    }

    /// The radii for a law of an effective variance.
    pub(crate) fn of_law(&self, table: &ScatteringTable, variance: f64) -> &Rung {
        let stride = stride_of(table, variance);
        let index = self.rungs.partition_point(|rung| rung.stride < stride);
        &self.rungs[index]
    }

    fn add_rung(&mut self, (table, moved): (&ScatteringTable, &MovedBows), stride: usize) {
        let table_um = &table.effective_radius_um;
        let (k_rad, n_still) = (largest_k_rad(moved), first_moved_row(table, moved));
        let rows = Moving(moved.drops.len());
        let moved_um = &table_um[n_still..];
        let kept = rows.every(stride);
        let mut rung = Rung {
            stride,
            // All of them, so that what moves is what rows that stay leave out.
            radii_um: table_um[..n_still].to_vec(),
            n_still,
            first: self.shaded.len(),
        };
        for (index, &here) in kept.iter().enumerate() {
            let of_rows = self.rows.len();
            self.rows.push(rows.mean_around(here, stride));
            let next = *kept.get(index + 1).unwrap_or(&here);
            let [drops, next_drops] = [here, next].map(|row| moved.drops[row]);
            let apart_rad = k_rad * (next_drops.eccentricity - drops.eccentricity).abs();
            let step_rad = SHIFT_STEP_RAD.max(k_rad * drops.eccentricity_sd);
            let n = (apart_rad / step_rad).ceil().clamp(1.0, MOST_USES);
            for use_index in 0..n as usize {
                let part = use_index as f64 / n;
                let mixed = |a: f64, b: f64| a * (1.0 - part) + b * part;
                let ratio = moved_um[next] / moved_um[here];
                rung.radii_um.push(moved_um[here] * ratio.powf(part));
                self.shaded.push(ShadedRadius {
                    row: if part < 0.5 { of_rows } else { of_rows + 1 },
                    drops: FallingDrops {
                        eccentricity: mixed(drops.eccentricity, next_drops.eccentricity),
                        eccentricity_sd: mixed(drops.eccentricity_sd, next_drops.eccentricity_sd),
                        ..drops
                    },
                });
            }
        }
        self.rungs.push(rung);
    }
}

/// How many rows of the table apart the radii of a law may lie, a power of two.
fn stride_of(table: &ScatteringTable, variance: f64) -> usize {
    let radii = &table.effective_radius_um;
    let steps = radii.windows(2).map(|pair| (pair[1] / pair[0]).ln());
    let step = steps.fold(0.0, f64::max);
    match bin_step(variance, table.relative_error.clamp(1e-5, 1.0)) {
        Some(wanted) if step > 0.0 && wanted >= step => {
            1 << ((wanted / step).log2() as u32).min(16)
        }
        Some(_) | None => 1,
    }
}

/// How many rows of a table move.
#[derive(Clone, Copy, Debug)]
struct Moving(usize);

impl Moving {
    /// Every so many, counted from the largest drops, which move most, and the first.
    fn every(self, stride: usize) -> Vec<usize> {
        let mut kept: Vec<usize> = (0..self.0).rev().step_by(stride).collect();
        if kept.last().is_some_and(|row| *row > 0) {
            kept.push(0);
        }
        kept.reverse();
        kept
    }

    /// The mean of the rows around one, half as far as the next.
    fn mean_around(self, row: usize, stride: usize) -> RowMean {
        let half = stride / 2;
        let around = row.saturating_sub(half)..(row + half + 1).min(self.0);
        // The outermost belong to two.
        let share = |other: usize| match other.abs_diff(row) {
            distance if half > 0 && distance == half => 0.5,
            _ => 1.0,
        };
        let total: f64 = around.clone().map(share).sum();
        around.map(|other| (other, share(other) / total)).collect()
    }
}

/// The first row of a table whose bows move.
pub(crate) fn first_moved_row(table: &ScatteringTable, moved: &MovedBows) -> usize {
    table.effective_radius_um.len() - moved.drops.len()
}

/// The largest factor of the first order in the shift.
fn largest_k_rad(moved: &MovedBows) -> f64 {
    let shifts = moved.orders.iter().flat_map(|order| &order.shifts);
    let k_rad = shifts.map(|shift| shift.coefficients_rad[0].abs());
    k_rad.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_every_stride_hold_each_row_once() {
        for (n_rows, stride) in [(33, 1), (33, 2), (33, 4), (34, 16), (65, 8)] {
            let moving = Moving(n_rows);
            let mut shares = vec![0.0; n_rows];
            let kept = moving.every(stride);
            assert_eq!((kept[0], kept[kept.len() - 1]), (0, n_rows - 1));
            for row in kept {
                let mean = moving.mean_around(row, stride);
                let total: f64 = mean.iter().map(|(_, share)| share).sum();
                assert!((total - 1.0).abs() < 1e-14);
                for (other, share) in mean {
                    shares[other] += share * stride as f64;
                }
            }
            // Those at either end are of half a mean.
            let inside = &shares[stride..n_rows - stride];
            assert!(inside.iter().all(|share| (share - 1.0).abs() < 1e-14));
        }
    }
}
