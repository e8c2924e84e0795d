//! What linear interpolation between the nodes of a table costs, measured.
//!
//! error = rms and maximum over the angles of |linear − computed| / peak of the computed row
//! in natural light, half way between nodes: in θ at every interval, in radius (geometric mean),
//! variance and flattening at three intervals spread over the axis; the worst over the ends of the other
//! axes, at the middle wavelength. The computed light is that of the same theory, so that errors of the theory
//! do not enter.

use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;

use crate::builder::values_at;
use crate::error::Error;
use crate::request::TableRequest;

/// Intervals of an axis that are judged, at most.
const N_INTERVALS: usize = 3;

/// Error of linear interpolation in parts of the peak of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisError {
    /// Root of the mean square over the angles.
    pub rms: f64,
    /// Largest over the angles.
    pub max: f64,
}

/// Errors of interpolation along each axis; 0 for an axis of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InterpolationError {
    /// Along the scattering angle.
    pub theta: AxisError,
    /// Along the effective radius.
    pub radius: AxisError,
    /// Along the effective variance.
    pub variance: AxisError,
    /// Along the flattening.
    pub flattening: AxisError,
}

/// One axis besides the angle.
#[derive(Clone, Copy)]
enum SizeAxis {
    Radius,
    Variance,
    Flattening,
}

/// Measures the errors of interpolation of the tables of a request. It costs a few rows of the table.
///
/// # Errors
/// As [`crate::scattering_table`].
pub fn interpolation_error(
    request: &TableRequest,
    table: &ScatteringTable,
) -> Result<InterpolationError, Error> {
    request.check()?;
    let ends = ends_of(request);
    Ok(InterpolationError {
        theta: theta_error(&ends, &table.theta_rad)?,
        radius: size_error(&ends, request, &table.theta_rad, SizeAxis::Radius)?,
        variance: size_error(&ends, request, &table.theta_rad, SizeAxis::Variance)?,
        flattening: size_error(&ends, request, &table.theta_rad, SizeAxis::Flattening)?,
    })
}

/// The request at the ends of its axes, in the middle of the spectrum.
fn ends_of<'a>(request: &TableRequest<'a>) -> TableRequest<'a> {
    let middle = request.wavelengths.center(request.wavelengths.len() / 2).0;
    let one = WavelengthGrid::new(middle, request.wavelengths.step_nm(), 1);
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

fn theta_error(ends: &TableRequest, theta_rad: &[f64]) -> Result<AxisError, Error> {
    // Every node, and a middle after all but the last.
    let last = theta_rad.len() - 1;
    let with_middles: Vec<f64> = (0..=2 * last)
        .map(|index| 0.5 * (theta_rad[index / 2] + theta_rad[index.div_ceil(2)]))
        .collect();
    let rows = natural_rows(ends, &with_middles)?;
    let error = |row: &Vec<f64>| {
        let middles = (0..last).map(|i| 2 * i + 1);
        let pairs = middles.map(|i| (0.5 * (row[i - 1] + row[i + 1]), row[i]));
        error(pairs.collect(), row)
    };
    Ok(rows.iter().map(error).fold(AxisError::default(), worse))
}

fn size_error(
    ends: &TableRequest,
    request: &TableRequest,
    theta_rad: &[f64],
    axis: SizeAxis,
) -> Result<AxisError, Error> {
    let nodes = match axis {
        SizeAxis::Radius => &request.effective_radius_um,
        SizeAxis::Variance => &request.effective_variance,
        SizeAxis::Flattening => &request.flattening,
    };
    let mut worst = AxisError::default();
    for interval in intervals(nodes.len()) {
        let (low, high) = (nodes[interval], nodes[interval + 1]);
        let mut three = ends.clone();
        // Both ends in one table with the middle: single sizes of the exact solution are means over
        // the cells of a table.
        match axis {
            SizeAxis::Radius => three.effective_radius_um = vec![low, (low * high).sqrt(), high],
            SizeAxis::Variance => three.effective_variance = vec![low, 0.5 * (low + high), high],
            SizeAxis::Flattening => three.flattening = vec![low, 0.5 * (low + high), high],
        }
        let n_inner = match axis {
            SizeAxis::Radius => three.effective_variance.len() * three.flattening.len(),
            SizeAxis::Variance => three.flattening.len(),
            SizeAxis::Flattening => 1,
        };
        let rows = natural_rows(&three, theta_rad)?;
        for group in rows.chunks(3 * n_inner) {
            for inner in 0..n_inner {
                let [left, computed, right] = [0, 1, 2].map(|node| &group[node * n_inner + inner]);
                let line = left.iter().zip(right).map(|(a, b)| 0.5 * (a + b));
                let pairs = line.zip(computed.iter().copied()).collect();
                worst = worse(worst, error(pairs, computed));
            }
        }
    }
    Ok(worst)
}

/// First nodes of the intervals that are judged.
fn intervals(n_nodes: usize) -> Vec<usize> {
    let Some(last) = n_nodes.checked_sub(2) else {
        return Vec::new();
    };
    let mut chosen: Vec<usize> = (0..N_INTERVALS)
        .map(|index| index * last / (N_INTERVALS - 1))
        .collect();
    chosen.dedup();
    chosen
}

/// Natural light of every row and wavelength at the angles.
fn natural_rows(request: &TableRequest, theta_rad: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
    let values = values_at(request, theta_rad, &|_| {})?;
    let (_, n_radii, n_variances, n_flattenings, n_wavelengths, n_angles) = values.dim();
    let mut rows = Vec::new();
    for index in 0..n_radii * n_variances * n_flattenings * n_wavelengths {
        let (index, wavelength) = (index / n_wavelengths, index % n_wavelengths);
        let (index, flattening) = (index / n_flattenings, index % n_flattenings);
        let (radius, variance) = (index / n_variances, index % n_variances);
        let at = |j, angle| f64::from(values[[j, radius, variance, flattening, wavelength, angle]]);
        rows.push(
            (0..n_angles)
                .map(|angle| 0.5 * (at(0, angle) + at(1, angle)))
                .collect(),
        );
    }
    Ok(rows)
}

/// Error of pairs of (linear, computed) over the peak of a row.
fn error(pairs: Vec<(f64, f64)>, row: &[f64]) -> AxisError {
    let peak = row.iter().fold(0.0_f64, |peak, &value| peak.max(value));
    if peak <= 0.0 || pairs.is_empty() {
        return AxisError::default();
    }
    let n = pairs.len() as f64;
    let off = pairs
        .into_iter()
        .map(|(line, computed)| (line - computed).abs() / peak);
    let (squares, max) = off.fold((0.0, 0.0_f64), |(sum, max), off| {
        (sum + off * off, max.max(off))
    });
    AxisError {
        rms: (squares / n).sqrt(),
        max,
    }
}

fn worse(a: AxisError, b: AxisError) -> AxisError {
    AxisError {
        rms: a.rms.max(b.rms),
        max: a.max.max(b.max),
    }
}
