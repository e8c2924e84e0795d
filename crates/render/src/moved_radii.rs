//! The radii at which light of flattened drops is moved: as many as the narrowest law of a picture asks for.
//!
//! A table's single sizes may lie closer together than a picture needs. A law of effective variance v is the
//! sum of fewer: every second, fourth, ... of them, each the mean over what lies around it, where their step of
//! ln r is no more than [`bin_step`] of v, as if the table had been made for that law alone.
//!
//! Where the light is blurred over angles anyhow, as waves do, radii whose bows lie no farther apart than a part of that
//! are one, as long as a law is still a sum of them.
//!
//! A radius stands for all half way to its neighbors. Their bows lie over a stretch of angles, which belongs to
//! the width over which its light is taken: the stretches of neighbors touch, however far their bows lie apart.

use niji_exchange::Attitude;
use niji_exchange::FallingDrops;
use niji_exchange::MovedBows;
use niji_exchange::ScatteringTable;
use niji_exchange::SeenShift;
use niji_sizes::bin_step;

use crate::size_nodes::SizeNodes;
use crate::size_nodes::step;

/// Widest step of ln r of radii of which a law is a sum of smooth light, over its width: sums over even steps err by
/// exp(-2 pi²/step²) of a bell.
const WIDEST_STEP: f64 = 0.75;

/// Rows of what moves and their weights in a row that is moved.
pub(crate) type RowMean = Vec<(usize, f64)>;

/// Radii at which light is moved, and those that stay.
#[derive(Clone, Debug)]
pub(crate) struct MovedRadii {
    /// Micrometres, ascending: first those too round to move, then those that do, whose bows are subtracted from
    /// the rows that stay.
    pub(crate) radii_um: Vec<f64>,
    /// How many of them do not move.
    pub(crate) n_still: usize,
    /// What each that moves is made of.
    pub(crate) rows: Vec<RowMean>,
    /// The drops of each that moves.
    pub(crate) drops: Vec<DropsAround>,
}

/// Drops around a radius.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DropsAround {
    pub(crate) drops: FallingDrops,
    /// From half way to the smaller neighbor to half way to the larger one.
    pub(crate) eccentricity_step: f64,
}

impl MovedRadii {
    /// Those that the nodes of sizes ask for where bows may lie `apart_rad` apart, or farther.
    pub(crate) fn new(
        table: &ScatteringTable,
        moved: &MovedBows,
        nodes: &SizeNodes,
        apart_rad: f64,
    ) -> Self {
        let (table_um, n_still) = (&table.effective_radius_um, first_moved_row(table, moved));
        let all = Moving(moved.drops.len());
        let of_sizes = stride_of(table, nodes.variance[0]);
        let widest_step = WIDEST_STEP * nodes.variance[0].sqrt();
        let is_blurred = |stride: &usize| {
            *stride < all.0
                && *stride as f64 * step(table) <= widest_step
                && farthest_rad(moved, &all.every(*stride)) <= apart_rad
        };
        let wider = std::iter::successors(Some(2 * of_sizes), |stride| Some(2 * stride));
        let stride = wider.take_while(is_blurred).last().unwrap_or(of_sizes);
        let kept = all.every(stride);
        let eccentricity = |place: usize| moved.drops[kept[place]].eccentricity;
        let last = kept.len().saturating_sub(1);
        let around = |(place, row): (usize, &usize)| {
            let (below, above) = (place.saturating_sub(1), (place + 1).min(last));
            DropsAround {
                drops: moved.drops[*row],
                eccentricity_step: 0.5 * (eccentricity(above) - eccentricity(below)).abs(),
            }
        };
        let still_um = table_um[..n_still].iter();
        let moving_um = kept.iter().map(|row| &table_um[n_still + row]);
        Self {
            radii_um: still_um.chain(moving_um).copied().collect(),
            n_still,
            rows: kept
                .iter()
                .map(|&row| all.mean_around(row, stride))
                .collect(),
            drops: kept.iter().enumerate().map(around).collect(),
        }
    }
}

impl DropsAround {
    /// How wide a stretch their bows lie over, seen from a direction, as a variance in rad².
    #[inline]
    pub(crate) fn variance_rad2(&self, seen: &SeenShift, attitude: &Attitude) -> f64 {
        let apart_rad = seen.eccentricity_slope(self.drops.eccentricity) * self.eccentricity_step;
        self.drops.variance_rad2(seen, attitude) + apart_rad * apart_rad / 12.0
    }
}

/// How far apart the bows of neighbors lie at most, over all directions.
fn farthest_rad(moved: &MovedBows, kept: &[usize]) -> f64 {
    let shifts = || moved.orders.iter().flat_map(|order| &order.shifts);
    let pairs = kept.windows(2).map(|pair| {
        let drops = [pair[0], pair[1]].map(|row| moved.drops[row].eccentricity);
        let apart = shifts().map(|shift| {
            let [a, b] = drops.map(|eccentricity| shift.largest_rad(eccentricity));
            (b - a).abs()
        });
        apart.fold(0.0, f64::max)
    });
    pairs.fold(0.0, f64::max)
}

/// How many rows of the table apart the radii of a law may lie, a power of two.
fn stride_of(table: &ScatteringTable, variance: f64) -> usize {
    let step = step(table);
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
