//! Directions on a lattice, what they see of the drops, and the means of paths there.

use std::ops::Range;

use niji_geometry::Aabb;
use niji_geometry::Ray;
use rayon::prelude::*;

use crate::error::Error;
use crate::progress::tell;

use super::column::Column;
use super::column::N_STRATA;
use super::column::Stratum;
use super::paths::Mean;
use super::paths::Paths;
use super::paths::standard_error;
use super::request::OrdersRequest;
use super::view_grid::ViewGrid;

/// What is seen along the directions of a lattice.
pub(super) struct Lattice<'a> {
    pub(super) request: &'a OrdersRequest<'a>,
    pub(super) grid: ViewGrid,
    columns: Vec<Column>,
    /// For each node the nearest one whose column holds drops: itself, or for rays past the drops
    /// another.
    nearest: Vec<usize>,
}

impl<'a> Lattice<'a> {
    /// Look along all directions.
    pub(super) fn new(grid: ViewGrid, bounds: Aabb, request: &'a OrdersRequest<'a>) -> Self {
        let columns: Vec<Column> = (0..grid.n_nodes())
            .into_par_iter()
            .map(|node| {
                let ray = Ray {
                    origin: request.eye,
                    direction: grid.direction(node),
                };
                Column::along(request.drops.bricks(), bounds, ray)
            })
            .collect();
        let nearest = nearest_with_drops(&grid, &columns);
        Self {
            request,
            grid,
            columns,
            nearest,
        }
    }

    /// Means of these paths of each replicate by node and stratum, dimmed by air.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub(super) fn means(&self, paths: &Paths, of_each: Range<usize>) -> Result<Vec<Mean>, Error> {
        let found: Vec<Option<Mean>> = (0..self.columns.len() * N_STRATA)
            .into_par_iter()
            .map(|index| {
                let column = &self.columns[index / N_STRATA];
                let Some(stratum) = column.stratum(index % N_STRATA) else {
                    return Ok(None);
                };
                tell(self.request.progress, 0)?;
                let mut mean = paths.mean(&stratum, of_each.clone());
                self.dim(&stratum, &mut mean);
                Ok(Some(mean))
            })
            .collect::<Result<_, Error>>()?;
        let at = |index: usize| {
            let node = self.nearest[index / N_STRATA];
            // Strata deeper than the drops hold what the deepest one does.
            let stratum = self.columns[node].deepest(index % N_STRATA);
            let dark = || Mean::dark(self.request.table.wavelengths.len());
            found[node * N_STRATA + stratum]
                .clone()
                .unwrap_or_else(dark)
        };
        Ok((0..found.len()).map(at).collect())
    }

    /// RMS noise of the light of all strata that is seen in the directions [cd/m²].
    pub(super) fn noise_cd_m2(&self, means: &[Mean]) -> f64 {
        self.rms(|node, column| {
            let mut seen = Mean::dark(0);
            for (index, share) in strata(node, column) {
                seen.add(share, &means[index]);
            }
            standard_error(&seen.replicates_cd_m2)
        })
    }

    /// RMS over the directions of errors of its nodes and strata.
    pub(super) fn rms_of_errors(&self, errors: &[f32]) -> f64 {
        self.rms(|node, column| {
            let seen = strata(node, column).map(|(index, share)| share * errors[index]);
            seen.sum()
        })
    }

    fn rms(&self, of_column: impl Fn(usize, &Column) -> f32) -> f64 {
        let columns = self.columns.iter().enumerate();
        let squares = columns.map(|(node, column)| f64::from(of_column(node, column)).powi(2));
        (squares.sum::<f64>() / self.columns.len().max(1) as f64).sqrt()
    }

    /// Take away what the air in front of a stratum and above it absorbs and scatters.
    fn dim(&self, stratum: &Stratum, mean: &mut Mean) {
        let request = self.request;
        let mut transmitted = vec![1.0_f32; mean.source_sr1.len()];
        let place = stratum.middle();
        if let Some(air) = request.sunlight_air {
            match air.to_sun(place) {
                Some(lengths) => air.transmit(&lengths, &mut transmitted),
                None => transmitted.fill(0.0),
            }
            mean.dim(&transmitted, request.luminance_weights);
        }
        if let Some(air) = request.view_air {
            let ray = air.ray(request.eye, stratum.direction());
            let lengths = air.to_eye(ray, place.distance(request.eye));
            air.transmit(&lengths, &mut transmitted);
            mean.dim(&transmitted, request.luminance_weights);
        }
    }
}

fn nearest_with_drops(grid: &ViewGrid, columns: &[Column]) -> Vec<usize> {
    let with_drops: Vec<usize> = (0..columns.len())
        .filter(|node| columns[*node].stratum(0).is_some())
        .collect();
    let nearest = |node: usize| {
        let direction = grid.direction(node);
        let cosine = |other: &usize| grid.direction(*other).dot(direction);
        let best = with_drops.iter().copied();
        // The first of the nearest.
        best.max_by(|a, b| cosine(a).total_cmp(&cosine(b)).then(b.cmp(a)))
    };
    (0..columns.len())
        .into_par_iter()
        .map(|node| match columns[node].stratum(0) {
            Some(_) => node,
            None => nearest(node).unwrap_or(node),
        })
        .collect()
}

/// Where the strata of a node stand, with the share of the view that each has.
fn strata(node: usize, column: &Column) -> impl Iterator<Item = (usize, f32)> {
    let strata = (0..N_STRATA).filter_map(|index| column.stratum(index));
    strata.map(move |it| (node * N_STRATA + it.index, it.share() as f32))
}
