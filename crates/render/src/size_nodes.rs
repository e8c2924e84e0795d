//! The sizes between which the light of a ray is kept apart.
//!
//! A table of size laws has them on its axes. A table of single sizes serves any law: then they are nodes of
//! (r_e, v_e) over what the drops have, and the row of a node is the sum over single sizes
//! t(r_e, v_e) = sum_a w_a t(a)  with the weights of a gamma law.

use std::borrow::Cow;

use ndarray::Array5;
use ndarray::s;
use niji_dropfield::SizeRange;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_radiometry::Micrometers;
use niji_sizes::law_weights;
use niji_sizes::narrowest_variance;
use niji_sizes::radius_axis;
use niji_sizes::variance_axis;

use crate::size_axes::SizeAxes;

/// Below it sizes are one; f32 moments of one size vary by 1e-6.
const SETTLED: f64 = 1e-5;

/// Nodes of size, radius by variance.
#[derive(Clone, Debug)]
pub(crate) struct SizeNodes {
    pub(crate) radius_um: Vec<f64>,
    pub(crate) variance: Vec<f64>,
    /// Whether the table's rows are single sizes and the nodes laws.
    pub(crate) are_laws: bool,
}

impl SizeNodes {
    /// Those of a table itself.
    pub(crate) fn of_table(table: &ScatteringTable) -> Self {
        Self {
            radius_um: table.effective_radius_um.clone(),
            variance: table.effective_variance.clone(),
            are_laws: false,
        }
    }

    /// Those of drops in the light of a table.
    pub(crate) fn of_drops(table: &ScatteringTable, drops: Option<SizeRange>) -> Self {
        let own = Self::of_table(table);
        let Some(drops) = drops.filter(|_| table.row_use == RowUse::Sums) else {
            return own;
        };
        let tolerance = table.relative_error.clamp(1e-5, 1.0);
        let (radius_um, variance) = (
            settled(drops.effective_radius_um),
            settled(drops.effective_variance),
        );
        // Laws narrower than the table's single sizes lie apart have their width.
        let narrowest = narrowest_variance(step(table), tolerance);
        let variance = (variance.0.max(narrowest), variance.1.max(narrowest));
        let radii = radius_axis(radius_um, variance.0, tolerance);
        match (radii, variance_axis(variance)) {
            (Ok(radius_um), Ok(variance)) => Self {
                radius_um,
                variance,
                are_laws: true,
            },
            // Drops that no law has, which nobody can have written.
            _ => own,
        }
    }

    /// The axes through the nodes.
    pub(crate) fn axes(&self) -> SizeAxes {
        SizeAxes::new(&self.radius_um, &self.variance)
    }

    /// Weights of single sizes in the row of a node.
    pub(crate) fn weights(&self, bin: usize, radii_um: &[f64]) -> Vec<(usize, f64)> {
        let n_variances = self.variance.len();
        let radius = Micrometers(self.radius_um[bin / n_variances]);
        let weights = law_weights(radii_um, radius, self.variance[bin % n_variances]);
        weights.expect("nodes lie within what laws can have")
    }
}

/// The largest step of ln r from one radius of a table to the next; 0 for one radius.
pub(crate) fn step(table: &ScatteringTable) -> f64 {
    let radii = table.effective_radius_um.windows(2);
    radii
        .map(|pair| (pair[1] / pair[0]).ln())
        .fold(0.0, f64::max)
}

/// The ends of a range, one where rounding alone sets them apart.
fn settled((low, high): (f64, f64)) -> (f64, f64) {
    if high - low <= SETTLED * high.max(1.0) {
        (high, high)
    } else {
        (low, high)
    }
}

/// The table by nodes of sizes for spheres, with at most so many radii: itself where its rows are those of
/// the drops already.
pub(crate) fn table_of_laws(
    table: &ScatteringTable,
    drops: Option<SizeRange>,
    kept: impl Fn(usize) -> Vec<usize>,
) -> Cow<'_, ScatteringTable> {
    let mut nodes = SizeNodes::of_drops(table, drops);
    if !nodes.are_laws {
        return Cow::Borrowed(table);
    }
    let kept = kept(nodes.radius_um.len()).into_iter();
    nodes.radius_um = kept.map(|index| nodes.radius_um[index]).collect();
    let (_, _, _, n_wavelengths, n_angles) = table.values.dim();
    let (n_radii, n_variances) = (nodes.radius_um.len(), nodes.variance.len());
    let mut values = Array5::zeros((2, n_radii, n_variances, n_wavelengths, n_angles));
    for bin in 0..n_radii * n_variances {
        let (radius, variance) = (bin / n_variances, bin % n_variances);
        for (row, weight) in nodes.weights(bin, &table.effective_radius_um) {
            let of_row = table.values.slice(s![.., row, 0, .., ..]);
            let mut sum = values.slice_mut(s![.., radius, variance, .., ..]);
            sum.scaled_add(weight as f32, &of_row);
        }
    }
    Cow::Owned(ScatteringTable {
        theory: table.theory.clone(),
        orders: table.orders.clone(),
        wavelengths: table.wavelengths,
        theta_rad: table.theta_rad.clone(),
        effective_radius_um: nodes.radius_um,
        effective_variance: nodes.variance,
        values,
        moved: None,
        row_use: RowUse::Laws,
        relative_error: table.relative_error,
        sun_disc_diameter_rad: table.sun_disc_diameter_rad,
        split_theta_rad: table.split_theta_rad,
        forward_fraction_left_out: table.forward_fraction_left_out,
        water: table.water,
        phase_functions: None,
        interpolation_error: table.interpolation_error,
    })
}
