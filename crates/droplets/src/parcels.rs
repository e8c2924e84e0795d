//! Water laid into voxels as Gaussian parcels, none of which is lost however small it is.
//!
//! Of a parcel at (x0, z0) the cell [x1, x2] [y1, y2] [z1, z2] gets the share
//! (G(x2 - x0) - G(x1 - x0)) (V(y2) - V(y1)) (G(z2 - z0) - G(z1 - z0))
//! G(x) = [Phi(x/s) - Phi(-c)]/[Phi(c) - Phi(-c)] for |x| <= c s,   c = 4
//! Phi normal distribution; `s` standard deviation [m], never below a quarter of a voxel; `V` share of the parcel's water below
//! a height, given with it. The shares of all cells add up to 1, so that a sheet thinner than a voxel
//! keeps its water. Parcels of equal water that lie no more than `s` apart in a row add up to an even
//! line: its ripple is 2 exp(-2 pi²) = 5e-9, besides the steps of 1e-4 of a parcel's peak at its cut.

use glam::DVec2;
use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::Drops;
use niji_dropfield::GridBox;
use niji_sizes::Amount;
use niji_sizes::SizeMoments;
use spec_math::NormDist;

use crate::Error;

/// Standard deviations at which a parcel is cut, c.
pub(crate) const CUT: f64 = 4.0;

/// Least standard deviation of a parcel, in voxels.
const LEAST_SPREAD: f64 = 0.25;

/// What lies between two places on an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    /// The lower end (m).
    pub(crate) low_m: f64,
    /// The upper end (m).
    pub(crate) high_m: f64,
}

/// Standard deviation with which a parcel is laid out (m).
pub(crate) fn resolved_spread_m(spread_m: f64, voxel_m: f64) -> f64 {
    spread_m.max(LEAST_SPREAD * voxel_m)
}

/// Share of a normal law of unit deviation, cut at ±c, below a point.
pub(crate) fn cut_normal_share(deviations: f64) -> f64 {
    let below = |x: f64| x.norm_cdf() - (-CUT).norm_cdf();
    below(deviations.clamp(-CUT, CUT)) / below(CUT)
}

/// One of a row of parcels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parcel {
    /// Its middle, x and z (m).
    pub(crate) middle: DVec2,
    /// Its part of the row's water.
    pub(crate) share: f64,
}

/// Shares of the cells of one axis, from a first cell on.
#[derive(Debug, Clone)]
pub(crate) struct Shares {
    first: usize,
    shares: Vec<f64>,
}

/// Parcels on the columns of cells that they touch: line after line along z.
struct FromAbove {
    first_x: usize,
    first_z: usize,
    n_z: usize,
    shares: Vec<f64>,
}

/// First cell and number of cells of an axis that any of the parcels touches.
fn cells_of<'a>(parcels: impl Iterator<Item = &'a Shares>) -> (usize, usize) {
    let ends = parcels.map(|parcel| (parcel.first, parcel.first + parcel.shares.len()));
    let whole = ends.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    whole.map_or((0, 1), |(first, end)| (first, end - first))
}

/// Grams of water in every cell of a box.
#[derive(Debug, Clone)]
pub(crate) struct Parcels {
    grid: GridBox,
    n_cells: [usize; 3],
    grams: Vec<f64>,
}

impl Parcels {
    /// A dry box. Its size must be a whole number of voxels.
    ///
    /// # Errors
    /// As [`GridBox::n_nodes`].
    pub(crate) fn new(grid: GridBox) -> Result<Self, Error> {
        let n_cells = grid.n_nodes()?.map(|count| count as usize);
        let grams = vec![0.0; n_cells.iter().product()];
        Ok(Self {
            grid,
            n_cells,
            grams,
        })
    }

    /// Edge length of a voxel (m).
    pub(crate) fn voxel_m(&self) -> f64 {
        self.grid.voxel_m
    }

    /// Shares of the layers between two heights, by the share of the water below a height.
    pub(crate) fn layers(&self, heights: Span, share_below: impl Fn(f64) -> f64) -> Shares {
        self.shares(1, heights, share_below)
    }

    fn shares(&self, axis: usize, span: Span, share_below: impl Fn(f64) -> f64) -> Shares {
        let (origin_m, voxel_m) = (self.grid.min[axis], self.grid.voxel_m);
        let last = self.n_cells[axis] - 1;
        // Casts saturate: a parcel that roundoff puts outside goes to the outermost cell.
        let cell =
            |position_m: f64| (((position_m - origin_m) / voxel_m).floor() as usize).min(last);
        let (first, end) = (cell(span.low_m), cell(span.high_m));
        let mut below = 0.0;
        let shares = (first..=end).map(|index| {
            let edge_m = origin_m + (index as f64 + 1.0) * voxel_m;
            // Roundoff must not make a share negative.
            let upper = if index == end {
                1.0
            } else {
                share_below(edge_m).min(1.0).max(below)
            };
            let share = upper - below;
            below = upper;
            share
        });
        Shares {
            first,
            shares: shares.collect(),
        }
    }

    /// Lay out water (g) as parcels of one height profile and one standard deviation (m).
    ///
    /// The parcels are added up as seen from above before they are spread over the layers: a row of
    /// a hundred costs little more than one.
    pub(crate) fn add_row(&mut self, water_g: f64, row: &[Parcel], spread_m: f64, layers: &Shares) {
        let above = self.seen_from_above(row, spread_m);
        let [_, ny, nz] = self.n_cells;
        for (x, line) in (above.first_x..).zip(above.shares.chunks_exact(above.n_z)) {
            let Some(first) = line.iter().position(|share| *share > 0.0) else {
                continue;
            };
            for (y, y_share) in (layers.first..).zip(&layers.shares) {
                let start = (x * ny + y) * nz + above.first_z;
                let cells = &mut self.grams[start + first..start + above.n_z];
                for (cell, share) in cells.iter_mut().zip(&line[first..]) {
                    *cell += water_g * y_share * share;
                }
            }
        }
    }

    fn seen_from_above(&self, row: &[Parcel], spread_m: f64) -> FromAbove {
        let s = resolved_spread_m(spread_m, self.grid.voxel_m);
        let around = |axis: usize, middle_m: f64| {
            let span = Span {
                low_m: middle_m - CUT * s,
                high_m: middle_m + CUT * s,
            };
            self.shares(axis, span, |edge_m| {
                cut_normal_share((edge_m - middle_m) / s)
            })
        };
        let parcel = |parcel: &Parcel| {
            let DVec2 { x, y: z } = parcel.middle;
            (around(0, x), around(2, z), parcel.share)
        };
        let parcels: Vec<(Shares, Shares, f64)> = row.iter().map(parcel).collect();
        let (first_x, n_x) = cells_of(parcels.iter().map(|(columns, ..)| columns));
        let (first_z, n_z) = cells_of(parcels.iter().map(|(_, rows, _)| rows));
        let mut shares = vec![0.0; n_x * n_z];
        for (columns, rows, share) in &parcels {
            for (x, x_share) in (columns.first - first_x..).zip(&columns.shares) {
                let line = &mut shares[x * n_z + rows.first - first_z..];
                for (cell, z_share) in line.iter_mut().zip(&rows.shares) {
                    *cell += share * x_share * z_share;
                }
            }
        }
        FromAbove {
            first_x,
            first_z,
            n_z,
            shares,
        }
    }

    /// The water as drops of the same sizes everywhere.
    ///
    /// # Errors
    /// As [`DropMode::from_fn`].
    pub(crate) fn into_mode(self, name: &str, moments: &SizeMoments) -> Result<DropMode, Error> {
        let per_g = Amount::LiquidWater(1.0).number_density_m3(moments) / self.grid.voxel_m.powi(3);
        let mode = DropMode::from_fn(name, &self.grid, |position| {
            Drops::of_law(moments, per_g * self.grams_at(position))
        })?;
        Ok(mode)
    }

    fn grams_at(&self, position: DVec3) -> f64 {
        let cell = ((position - self.grid.min) / self.grid.voxel_m).to_array();
        let [x, y, z] = cell.map(|along| along as usize);
        let [nx, ny, nz] = self.n_cells;
        if x < nx && y < ny && z < nz {
            self.grams[(x * ny + y) * nz + z]
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::SQRT_2;

    use super::*;

    fn alike(middles: &[DVec2]) -> Vec<Parcel> {
        let share = 1.0 / middles.len() as f64;
        let parcel = |middle: &DVec2| Parcel {
            middle: *middle,
            share,
        };
        middles.iter().map(parcel).collect()
    }

    fn dry(voxel_m: f64) -> Parcels {
        let grid = GridBox {
            min: DVec3::new(-10.0, 0.0, -10.0),
            max: DVec3::new(10.0, 8.0, 10.0),
            voxel_m,
        };
        Parcels::new(grid).unwrap()
    }

    fn even(parcels: &Parcels, low_m: f64, high_m: f64) -> Shares {
        parcels.layers(Span { low_m, high_m }, |y| (y - low_m) / (high_m - low_m))
    }

    #[test]
    fn a_parcel_keeps_its_water_for_any_size_and_place() {
        for voxel_m in [0.5, 1.0, 2.0] {
            for spread_m in [1e-6, 0.3, 1.7] {
                let mut parcels = dry(voxel_m);
                let layers = even(&parcels, 1.3, 1.31);
                let center = DVec2::new(0.37, -2.9);
                parcels.add_row(5.0, &alike(&[center]), spread_m, &layers);
                let sum: f64 = parcels.grams.iter().sum();
                assert!((sum / 5.0 - 1.0).abs() < 1e-13, "{sum}");
                let first_m: f64 = (0..parcels.n_cells[0])
                    .map(|x| {
                        let plane = parcels.n_cells[1] * parcels.n_cells[2];
                        let grams: f64 = parcels.grams[x * plane..(x + 1) * plane].iter().sum();
                        grams * (-10.0 + (x as f64 + 0.5) * voxel_m)
                    })
                    .sum();
                // The middle of the cells is off by the cell's own gradient for narrow parcels.
                assert!((first_m / 5.0 - 0.37).abs() < 0.15 * voxel_m, "{first_m}");
            }
        }
    }

    #[test]
    fn a_row_of_parcels_is_an_even_line() {
        let mut parcels = dry(1.0);
        let layers = even(&parcels, 0.0, 8.0);
        // 64 parcels a spread of 0.25 m apart, along the diagonal.
        let places: Vec<DVec2> = (0..64)
            .map(|index| DVec2::splat((f64::from(index) - 31.5) * 0.25 / SQRT_2))
            .collect();
        parcels.add_row(64.0, &alike(&places), 0.25, &layers);
        let column = |x: usize| {
            let row = |z: usize| parcels.grams_at(DVec3::new(x as f64 - 9.5, 0.5, z as f64 - 9.5));
            (0..20).map(row).sum::<f64>()
        };
        let middle = column(10);
        for x in 8..12 {
            assert!((column(x) / middle - 1.0).abs() < 1e-4, "{x}");
        }
        // 4 sqrt 2 parcels to a metre along x, in 8 layers.
        assert!(
            (middle * 8.0 / (4.0 * SQRT_2) - 1.0).abs() < 1e-4,
            "{middle}"
        );
    }

    #[test]
    fn shares_are_those_of_the_normal_law() {
        // Within one, two and three deviations: 0.682689, 0.954500, 0.997300 of 0.999937.
        for (deviations, inside) in [(1.0, 0.682_689), (2.0, 0.954_500), (3.0, 0.997_300)] {
            let found = cut_normal_share(deviations) - cut_normal_share(-deviations);
            assert!((found * 0.999_937 - inside).abs() < 2e-6, "{found}");
        }
        assert_eq!((cut_normal_share(4.0), cut_normal_share(-9.0)), (1.0, 0.0));
    }

    #[test]
    fn water_becomes_drops_of_its_sizes() {
        let mut parcels = dry(2.0);
        let layers = even(&parcels, 0.0, 4.0);
        parcels.add_row(3.0, &alike(&[DVec2::ZERO]), 1.0, &layers);
        let law = niji_sizes::Monodisperse { radius_um: 100.0 };
        let mode = parcels.into_mode("mist", &law.moments()).unwrap();
        // f32.
        assert!((mode.total_water_g() / 3.0 - 1.0).abs() < 1e-6);
        // A drop of 100 um has 4.18879e-6 g.
        assert!((mode.total_drops() * 4.188_790_2e-6 / 3.0 - 1.0).abs() < 1e-6);
    }
}
