//! What linear interpolation between the nodes of a table costs, measured.
//!
//! error = rms and maximum over the angles of |linear − computed| / peak of the computed row
//! in natural light, half way between nodes: in θ and in radius (geometric mean), variance and
//! flattening at every interval, at the ends of the other axes and the shortest wavelength, whose bow is
//! the sharpest. The computed light is that of the same theory, so that errors of the theory do not
//! enter.

use niji_exchange::AxisError;
use niji_radiometry::WavelengthGrid;

use crate::builder::values_at;
use crate::error::Error;
use crate::request::TableRequest;
use crate::size_average::is_cell_row;
use crate::theory::Theory;

/// One axis besides the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SizeAxis {
    /// Effective radius.
    Radius,
    /// Effective variance.
    Variance,
    /// Flattening.
    Flattening,
}

/// Error half way between two nodes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct IntervalError {
    /// The worst of all rows.
    pub(crate) all: AxisError,
    /// The worst of the rows that a further node brings nearer: not of means over cells, which are
    /// other drops with other cells.
    pub(crate) improvable: AxisError,
}

impl SizeAxis {
    pub(crate) fn nodes<'a>(self, request: &'a TableRequest) -> &'a [f64] {
        match self {
            Self::Radius => &request.effective_radius_um,
            Self::Variance => &request.effective_variance,
            Self::Flattening => &request.flattening,
        }
    }

    pub(crate) fn with_nodes<'a>(
        self,
        request: &TableRequest<'a>,
        nodes: Vec<f64>,
    ) -> TableRequest<'a> {
        let mut request = request.clone();
        match self {
            Self::Radius => request.effective_radius_um = nodes,
            Self::Variance => request.effective_variance = nodes,
            Self::Flattening => request.flattening = nodes,
        }
        request
    }

    /// Half way between two nodes.
    pub(crate) fn middle(self, low: f64, high: f64) -> f64 {
        match self {
            Self::Radius => (low * high).sqrt(),
            Self::Variance | Self::Flattening => 0.5 * (low + high),
        }
    }
}

/// Error in θ between the nodes `theta_rad`.
pub(crate) fn theta_error(request: &TableRequest, theta_rad: &[f64]) -> Result<AxisError, Error> {
    // Every node, and a middle after all but the last.
    let last = theta_rad.len() - 1;
    let with_middles: Vec<f64> = (0..=2 * last)
        .map(|index| 0.5 * (theta_rad[index / 2] + theta_rad[index.div_ceil(2)]))
        .collect();
    let rows = natural_rows(&ends_of(request), &with_middles)?;
    let error = |row: &Vec<f64>| {
        let middles = (0..last).map(|i| 2 * i + 1);
        let pairs = middles.map(|i| (0.5 * (row[i - 1] + row[i + 1]), row[i]));
        error(pairs, row)
    };
    Ok(rows.iter().map(error).fold(AxisError::default(), worse))
}

/// Errors of all intervals of an axis; it costs two tables of one wavelength and the ends of the
/// other axes.
pub(crate) fn interval_errors(
    request: &TableRequest,
    theta_rad: &[f64],
    axis: SizeAxis,
) -> Result<Vec<IntervalError>, Error> {
    let nodes = axis.nodes(request);
    let Some(n_intervals) = nodes.len().checked_sub(1).filter(|n| *n > 0) else {
        return Ok(Vec::new());
    };
    let mut with_middles = Vec::with_capacity(2 * nodes.len());
    for pair in nodes.windows(2) {
        with_middles.extend([pair[0], axis.middle(pair[0], pair[1])]);
    }
    with_middles.extend(nodes.last());
    let pilot = axis.with_nodes(&ends_of(request), with_middles);
    let n_variances = pilot.effective_variance.len();
    let n_flattenings = pilot.flattening.len();
    let rows = natural_rows(&pilot, theta_rad)?;
    let n_inner = match axis {
        SizeAxis::Radius => n_variances * n_flattenings,
        SizeAxis::Variance => n_flattenings,
        SizeAxis::Flattening => 1,
    };
    let is_cell = |row: usize| {
        let (sizes, exact) = (row / n_flattenings, pilot.theory == Theory::Mie);
        let (radius, variance) = (sizes / n_variances, sizes % n_variances);
        exact
            && is_cell_row(
                &pilot.effective_radius_um,
                radius,
                pilot.effective_variance[variance],
            )
    };
    let mut errors = vec![IntervalError::default(); n_intervals];
    let n_group = (2 * n_intervals + 1) * n_inner;
    for first in (0..rows.len()).step_by(n_group) {
        for (interval, worst) in errors.iter_mut().enumerate() {
            for inner in 0..n_inner {
                let three = [0, 1, 2].map(|node| first + (2 * interval + node) * n_inner + inner);
                let [left, computed, right] = three.map(|row| &rows[row]);
                let line = left.iter().zip(right).map(|(a, b)| 0.5 * (a + b));
                let found = error(line.zip(computed.iter().copied()), computed);
                worst.all = worse(worst.all, found);
                if !three.into_iter().any(is_cell) {
                    worst.improvable = worse(worst.improvable, found);
                }
            }
        }
    }
    Ok(errors)
}

/// The request at the ends of its axes and the shortest wavelength.
fn ends_of<'a>(request: &TableRequest<'a>) -> TableRequest<'a> {
    let first_nm = request.wavelengths.first_nm();
    let one = WavelengthGrid::new(first_nm, request.wavelengths.step_nm(), 1);
    TableRequest {
        wavelengths: one.unwrap_or(request.wavelengths),
        effective_radius_um: first_and_last(&request.effective_radius_um),
        effective_variance: first_and_last(&request.effective_variance),
        flattening: first_and_last(&request.flattening),
        ..request.clone()
    }
}

fn first_and_last(values: &[f64]) -> Vec<f64> {
    let mut ends = vec![values[0], values[values.len() - 1]];
    ends.dedup();
    ends
}

/// Natural light of every row at the angles.
fn natural_rows(request: &TableRequest, theta_rad: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
    let values = values_at(request, theta_rad, &|_| {})?;
    let (_, n_radii, n_variances, n_flattenings, _, n_angles) = values.dim();
    let mut rows = Vec::new();
    for index in 0..n_radii * n_variances * n_flattenings {
        let (sizes, flattening) = (index / n_flattenings, index % n_flattenings);
        let (radius, variance) = (sizes / n_variances, sizes % n_variances);
        let at = |j, angle| f64::from(values[[j, radius, variance, flattening, 0, angle]]);
        rows.push(
            (0..n_angles)
                .map(|angle| 0.5 * (at(0, angle) + at(1, angle)))
                .collect(),
        );
    }
    Ok(rows)
}

/// Error of pairs of (linear, computed) over the peak of a row.
fn error(pairs: impl Iterator<Item = (f64, f64)>, row: &[f64]) -> AxisError {
    let peak = row.iter().fold(0.0_f64, |peak, &value| peak.max(value));
    if peak <= 0.0 {
        return AxisError::default();
    }
    let off = pairs.map(|(line, computed)| (line - computed).abs() / peak);
    let (n, squares, max) = off.fold((0_usize, 0.0, 0.0_f64), |(n, sum, max), off| {
        (n + 1, sum + off * off, max.max(off))
    });
    AxisError {
        rms: (squares / n.max(1) as f64).sqrt(),
        max,
    }
}

pub(crate) fn worse(a: AxisError, b: AxisError) -> AxisError {
    AxisError {
        rms: a.rms.max(b.rms),
        max: a.max.max(b.max),
    }
}
