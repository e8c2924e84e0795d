//! Which single drops a table needs, and with which weight each enters its rows.
//!
//! t̄(r_e, v_e) = Σ_i w_i t(r_i),   Σ_i w_i = 1,   w_i the share of the cross-section at r_i
//! because (dσ/dΩ)/(π⟨r²⟩) of a mixture is the mean of (dσ/dΩ)/(π r²) weighted by r² n(r).
//!
//! A row with v_e = 0 needs its own radius. Broad rows share one grid that is even in ln r, so that a
//! drop is computed once for all of them: the trapezoidal rule in ln r converges faster than any power
//! for the smooth density. Rows narrower than the grid resolves have nodes of their own.

use std::collections::BTreeMap;

use niji_radiometry::Micrometers;
use niji_sizes::GammaSizes;
use niji_sizes::gamma_area_quadrature;

use crate::error::Error;

/// Nodes of the shared grid for each factor e of radius. Fringes that this cannot resolve are blurred
/// away by the broad laws that use it.
const NODES_PER_EFOLD: f64 = 64.0;
/// Standard deviations that the shared grid must resolve, in steps of the grid.
const RESOLVED_STEPS: f64 = 2.5;
/// Nodes of a row of its own.
const N_OWN_NODES: usize = 48;
/// Weights below this are dropped; what is left is normalised.
const SMALLEST_WEIGHT: f64 = 1e-9;

/// A drop to be computed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SizeNode {
    pub(crate) radius: Micrometers,
    /// Row of the table and weight in it.
    pub(crate) uses: Vec<(usize, f64)>,
}

/// The drops for all rows (radii × variances, the variance fastest), by ascending radius.
pub(crate) fn size_nodes(radii_um: &[f64], variances: &[f64]) -> Result<Vec<SizeNode>, Error> {
    let mut own = Vec::new();
    let mut shared: BTreeMap<i64, Vec<(usize, f64)>> = BTreeMap::new();
    for (radius_index, &radius_um) in radii_um.iter().enumerate() {
        for (variance_index, &variance) in variances.iter().enumerate() {
            let row = radius_index * variances.len() + variance_index;
            if variance.sqrt() * NODES_PER_EFOLD > RESOLVED_STEPS {
                add_shared(&mut shared, row, radius_um, variance)?;
            } else {
                add_own(&mut own, row, radius_um, variance)?;
            }
        }
    }
    own.extend(shared.into_iter().map(|(index, uses)| SizeNode {
        radius: shared_radius(index),
        uses,
    }));
    own.sort_by(|a, b| a.radius.0.total_cmp(&b.radius.0));
    Ok(own)
}

fn shared_radius(index: i64) -> Micrometers {
    Micrometers((index as f64 / NODES_PER_EFOLD).exp())
}

fn refused(error: &niji_sizes::Error) -> Error {
    Error::Drop(error.to_string())
}

fn add_own(
    own: &mut Vec<SizeNode>,
    row: usize,
    radius_um: f64,
    variance: f64,
) -> Result<(), Error> {
    let nodes = gamma_area_quadrature(Micrometers(radius_um), variance, N_OWN_NODES);
    for (radius_um, weight) in nodes.map_err(|error| refused(&error))? {
        if weight > SMALLEST_WEIGHT {
            own.push(SizeNode {
                radius: Micrometers(radius_um),
                uses: vec![(row, weight)],
            });
        }
    }
    Ok(())
}

fn add_shared(
    shared: &mut BTreeMap<i64, Vec<(usize, f64)>>,
    row: usize,
    radius_um: f64,
    variance: f64,
) -> Result<(), Error> {
    let law = GammaSizes::new(Micrometers(radius_um), variance).map_err(|error| refused(&error))?;
    // Share of the cross-section in a step of ln r: p(x) x dlnx.
    let weight = |index: i64| {
        let relative = shared_radius(index).0 / radius_um;
        (law.ln_area_density(relative - 1.0) + relative.ln()).exp()
    };
    let center = (radius_um.ln() * NODES_PER_EFOLD).round() as i64;
    let reach = (12.0 * NODES_PER_EFOLD) as i64;
    let indices = center - reach..=center + reach;
    let weights: Vec<(i64, f64)> = indices.map(|index| (index, weight(index))).collect();
    let total: f64 = weights.iter().map(|(_, weight)| weight).sum();
    let kept = weights
        .iter()
        .filter(|(_, weight)| *weight > SMALLEST_WEIGHT * total);
    let kept_total: f64 = kept.clone().map(|(_, weight)| weight).sum();
    for (index, weight) in kept {
        shared
            .entry(*index)
            .or_default()
            .push((row, weight / kept_total));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean over the cross-section of ln(r/r_e) and of (r/r_e − 1)² from the nodes of one row.
    fn moments(variance: f64) -> (f64, f64, f64) {
        let nodes = size_nodes(&[100.0], &[variance]).unwrap();
        let mut sums = (0.0, 0.0, 0.0);
        for node in nodes {
            for (row, weight) in node.uses {
                assert_eq!(row, 0);
                let relative = node.radius.0 / 100.0;
                sums.0 += weight;
                sums.1 += weight * relative;
                sums.2 += weight * (relative - 1.0).powi(2);
            }
        }
        sums
    }

    #[test]
    fn weights_reproduce_effective_radius_and_variance() {
        // By definition r_e is the mean and v_e the variance over the cross-section.
        for variance in [1e-12, 1e-6, 1e-3, 0.002, 0.02, 0.1, 1.0 / 3.0, 0.45] {
            let (total, mean, spread) = moments(variance);
            assert!((total - 1.0).abs() < 1e-12);
            assert!((mean - 1.0).abs() < 1e-5, "v_e = {variance}: mean {mean}");
            assert!(
                (spread / variance - 1.0).abs() < 1e-4,
                "v_e = {variance}: spread {spread}"
            );
        }
    }

    #[test]
    fn a_single_size_is_one_drop_of_that_size() {
        let nodes = size_nodes(&[12.5], &[0.0]).unwrap();
        assert_eq!(
            nodes,
            vec![SizeNode {
                radius: Micrometers(12.5),
                uses: vec![(0, 1.0)]
            }]
        );
    }

    #[test]
    fn broad_rows_share_their_drops() {
        let radii: Vec<f64> = (0..50)
            .map(|i| 200.0 * (0.02 * f64::from(i)).exp())
            .collect();
        let alone = size_nodes(&radii[..1], &[1.0 / 3.0]).unwrap().len();
        let all = size_nodes(&radii, &[1.0 / 3.0]).unwrap().len();
        assert!(all < alone + 70, "{all} drops for 50 rows, {alone} for one");
    }
}
