//! What linear interpolation between the nodes of a table costs, measured.
//!
//! error = rms and maximum over a stretch of angles of |linear − computed| / peak of the computed row there
//! in natural light, the largest of all stretches ([`niji_exchange::stretch_of`]), half way between nodes: in θ and in
//! radius (geometric mean) and variance at every interval, at the ends of the other axes and the shortest
//! wavelength, whose bow is the sharpest. Of single sizes, which no ray sees alone, it is that of the narrowest
//! law that they are for. The computed light is that of the same theory, so that errors of the theory do not
//! enter.

use std::ops::Range;

use niji_exchange::AxisError;
use niji_radiometry::Micrometers;
use niji_radiometry::WavelengthGrid;
use niji_sizes::law_weights;

use crate::builder::values_at;
use crate::error::Error;
use crate::needed_angles::stretches;
use crate::progress::Progress;
use crate::request::SizeRow;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::size_average::is_cell_row;
use crate::theta_axis::TableAngles;

/// What the pilots of a table share: small tables that are compared.
#[derive(Clone, Copy)]
pub(crate) struct Pilots<'a> {
    pub(crate) theta_rad: &'a [f64],
    /// Hears that nothing of the table itself is done yet.
    pub(crate) progress: Progress<'a>,
}

impl Pilots<'_> {
    /// Natural light of the rows of some radii at the angles.
    fn rows(self, request: &TableRequest, radii: Radii) -> Result<Vec<PilotRow>, Error> {
        let theta_rad = self.theta_rad;
        let angles = TableAngles {
            theta_rad: theta_rad.to_vec(),
            of_orders: Vec::new(),
        };
        let values = values_at(request, &angles, None, &|_| (self.progress)(0.0))?.all;
        let all_um = &request.effective_radius_um;
        let counts = |row: &SizeRow| {
            radii == Radii::All || [0, all_um.len() - 1].contains(&row.radius_index)
        };
        let pilot = |row: SizeRow| {
            let (radius, variance) = (row.radius_index, row.variance_index);
            let at = |j, angle| f64::from(values[[j, radius, variance, 0, angle]]);
            let light = (0..theta_rad.len()).map(|angle| 0.5 * (at(0, angle) + at(1, angle)));
            PilotRow {
                light: light.collect(),
                is_of_cell: has_cells(request) && is_cell_row(all_um, radius, row.variance),
            }
        };
        Ok(request.size_rows().filter(counts).map(pilot).collect())
    }
}

/// One axis besides the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SizeAxis {
    /// Effective radius.
    Radius,
    /// Effective variance.
    Variance,
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
        }
        request
    }

    /// Half way between two nodes.
    pub(crate) fn middle(self, low: f64, high: f64) -> f64 {
        match self {
            Self::Radius => (low * high).sqrt(),
            Self::Variance => 0.5 * (low + high),
        }
    }
}

/// Error in θ between the angles, of laws at the ends of the axes.
pub(crate) fn theta_error(request: &TableRequest, pilots: Pilots) -> Result<AxisError, Error> {
    let with_middles = with_middles(pilots.theta_rad);
    let pilots = Pilots {
        theta_rad: &with_middles,
        ..pilots
    };
    let rows = pilots.rows(&ends_of(request), Radii::Ends)?;
    let rows = rows.iter().map(|row| row.light.as_slice());
    Ok(error_at_middles(&with_middles, rows))
}

/// Every node, and a middle after all but the last.
fn with_middles(nodes: &[f64]) -> Vec<f64> {
    let last = nodes.len() - 1;
    (0..=2 * last)
        .map(|index| 0.5 * (nodes[index / 2] + nodes[index.div_ceil(2)]))
        .collect()
}

/// The worst of rows at angles of which every second is a middle.
fn error_at_middles<'a>(with_middles: &[f64], rows: impl Iterator<Item = &'a [f64]>) -> AxisError {
    let middles = |range: Range<usize>| range.filter(|index| index % 2 == 1);
    let error = |row: &[f64]| {
        let off = |index: usize| 0.5 * (row[index - 1] + row[index + 1]) - row[index];
        worst_stretch(with_middles, row, |stretch| {
            middles(stretch).map(off).collect()
        })
    };
    rows.map(error).fold(AxisError::default(), worse)
}

/// Errors of all intervals of an axis; it costs two tables of one wavelength and the ends of the
/// other axes.
pub(crate) fn interval_errors(
    request: &TableRequest,
    pilots: Pilots,
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
    let (n_inner, radii) = match axis {
        SizeAxis::Radius => (n_variances, Radii::All),
        SizeAxis::Variance => (1, Radii::Ends),
    };
    let rows = pilots.rows(&pilot, radii)?;
    let mut errors = vec![IntervalError::default(); n_intervals];
    let n_group = (2 * n_intervals + 1) * n_inner;
    for first in (0..rows.len()).step_by(n_group) {
        for (interval, worst) in errors.iter_mut().enumerate() {
            for inner in 0..n_inner {
                let three =
                    [0, 1, 2].map(|node| &rows[first + (2 * interval + node) * n_inner + inner]);
                let [left, computed, right] = three.map(|row| &row.light);
                let off = |angle: usize| 0.5 * (left[angle] + right[angle]) - computed[angle];
                let found = worst_stretch(pilots.theta_rad, computed, |stretch| {
                    stretch.map(off).collect()
                });
                worst.all = worse(worst.all, found);
                if !three.iter().any(|row| row.is_of_cell) {
                    worst.improvable = worse(worst.improvable, found);
                }
            }
        }
    }
    Ok(errors)
}

/// Errors of a table of single sizes for laws no narrower than a variance: in θ, of that law in the middle and at
/// both ends of the radii; in radius, in the middle, what the sum changes by once there are twice as many.
pub(crate) fn bins_errors(
    request: &TableRequest,
    (ln_step, narrowest_variance): (f64, f64),
    pilots: Pilots,
) -> Result<[AxisError; 2], Error> {
    let radii = &request.effective_radius_um;
    let ends_um = [radii[0], radii[radii.len() - 1]];
    let middle_um = (ends_um[0] * ends_um[1]).sqrt();
    let with_middles = with_middles(pilots.theta_rad);
    let at_middles = Pilots {
        theta_rad: &with_middles,
        ..pilots
    };
    let rows = single_sizes(request, at_middles)?;
    let of_law = |effective_um: f64| law_sum(&rows, radii, (effective_um, narrowest_variance));
    let coarse = of_law(middle_um)?;
    let laws = [of_law(ends_um[0])?, of_law(ends_um[1])?];
    let laws = laws.iter().chain([&coarse]).map(Vec::as_slice);
    let theta = error_at_middles(&with_middles, laws);
    let mut finer = vec![radii[0]];
    for pair in radii.windows(2) {
        finer.extend([SizeAxis::Radius.middle(pair[0], pair[1]), pair[1]]);
    }
    let finer = TableRequest {
        rows: SizeRows::Bins {
            ln_step: 0.5 * ln_step,
            narrowest_variance,
        },
        ..SizeAxis::Radius.with_nodes(request, finer)
    };
    let rows = single_sizes(&finer, pilots)?;
    let fine = law_sum(
        &rows,
        &finer.effective_radius_um,
        (middle_um, narrowest_variance),
    )?;
    let off = |angle: usize| coarse[2 * angle] - fine[angle];
    let radius = worst_stretch(pilots.theta_rad, &fine, |stretch| {
        stretch.map(off).collect()
    });
    Ok([theta, radius])
}

/// All single sizes of a request at the shortest wavelength.
fn single_sizes(request: &TableRequest, pilots: Pilots) -> Result<Vec<PilotRow>, Error> {
    let radii = request.effective_radius_um.clone();
    let all = SizeAxis::Radius.with_nodes(&ends_of(request), radii);
    pilots.rows(&all, Radii::All)
}

/// Light of a law, by its effective radius (µm) and variance, from that of single sizes.
fn law_sum(
    rows: &[PilotRow],
    radii_um: &[f64],
    (effective_um, variance): (f64, f64),
) -> Result<Vec<f64>, Error> {
    let weights = law_weights(radii_um, Micrometers(effective_um), variance)?;
    let at = |angle: usize| {
        let terms = weights
            .iter()
            .map(|(row, weight)| weight * rows[*row].light[angle]);
        terms.sum()
    };
    Ok((0..rows[0].light.len()).map(at).collect())
}

/// Which radii of a pilot count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Radii {
    All,
    /// The first and the last, of the request of [`ends_of`].
    Ends,
}

/// A row that is compared with others.
struct PilotRow {
    /// Natural light by angle.
    light: Vec<f64>,
    /// Whether it is the mean over the cell of a radius.
    is_of_cell: bool,
}

/// The request at the ends of its axes and the shortest wavelength. The exact solution has the neighbors
/// of the outer radii too: how wide cells are depends on them.
fn ends_of<'a>(request: &TableRequest<'a>) -> TableRequest<'a> {
    let first_nm = request.wavelengths.first_nm();
    let one = WavelengthGrid::new(first_nm, request.wavelengths.step_nm(), 1);
    let n_radii = if has_cells(request) { 2 } else { 1 };
    TableRequest {
        wavelengths: one.unwrap_or(request.wavelengths),
        effective_radius_um: outermost(&request.effective_radius_um, n_radii),
        effective_variance: outermost(&request.effective_variance, 1),
        motion: None,
        ..request.clone()
    }
}

/// Whether single sizes are means over the cells of their radii: where orders interfere.
fn has_cells(request: &TableRequest) -> bool {
    request.theory.holds_every_order()
}

/// As many values from both ends, ascending.
fn outermost(values: &[f64], n: usize) -> Vec<f64> {
    let is_outer = |index: usize| index < n || index + n >= values.len();
    let indices = (0..values.len()).filter(|index| is_outer(*index));
    indices.map(|index| values[index]).collect()
}

/// The largest of the errors of all stretches, from the differences that `off` makes at some angles of one.
fn worst_stretch(
    theta_rad: &[f64],
    row: &[f64],
    off: impl Fn(Range<usize>) -> Vec<f64>,
) -> AxisError {
    let of_stretch = |stretch: Range<usize>| error(&off(stretch.clone()), &row[stretch]);
    stretches(theta_rad)
        .map(of_stretch)
        .fold(AxisError::default(), worse)
}

/// Error of differences over the peak of a row.
fn error(off: &[f64], row: &[f64]) -> AxisError {
    let peak = row.iter().fold(0.0_f64, |peak, &value| peak.max(value));
    if peak <= 0.0 || off.is_empty() {
        return AxisError::default();
    }
    let squares: f64 = off.iter().map(|off| (off / peak).powi(2)).sum();
    AxisError {
        rms: (squares / off.len() as f64).sqrt(),
        max: off.iter().fold(0.0, |max, off| max.max((off / peak).abs())),
    }
}

pub(crate) fn worse(a: AxisError, b: AxisError) -> AxisError {
    AxisError {
        rms: a.rms.max(b.rms),
        max: a.max.max(b.max),
    }
}
