//! A table whose every axis is as fine as the tolerance asks for.
//!
//! The nodes of [`niji_sizes::radius_axis`] and [`niji_sizes::variance_axis`] are where the search begins. What
//! linear interpolation costs is then measured at every interval, those that miss the tolerance (rms
//! over a stretch of angles, in parts of the row's peak there) are halved, and what is left
//! is stated in the table.

use niji_exchange::AxisError;
use niji_exchange::InterpolationError;
use niji_exchange::ScatteringTable;

use crate::builder::table_at;
use crate::error::Error;
use crate::interpolation_error::IntervalError;
use crate::interpolation_error::Pilots;
use crate::interpolation_error::SizeAxis;
use crate::interpolation_error::bins_errors;
use crate::interpolation_error::interval_errors;
use crate::interpolation_error::theta_error;
use crate::interpolation_error::worse;
use crate::progress::Progress;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::theta_axis::chosen_angles;

/// An interval is halved at most so many times.
const N_HALVINGS: usize = 4;

/// Makes a scattering table that holds the tolerance of the request along every axis. Radii and
/// variances of the request are nodes at least. The result does not depend on the number of threads.
///
/// Where [`ScatteringTable::interpolation_error`] is above the tolerance nevertheless, the rows are
/// means of the exact solution over the cells of single sizes, or four halvings were not enough; along θ, a point sun
/// asks for more angles than there may be.
///
/// # Errors
/// As [`crate::scattering_table`].
pub fn adaptive_table(
    request: &TableRequest,
    progress: Progress,
) -> Result<ScatteringTable, Error> {
    request.check()?;
    let chosen = chosen_angles(request, progress)?;
    let pilots = Pilots {
        theta_rad: &chosen.angles.theta_rad,
        progress,
    };
    request.check_size(&chosen.angles.number())?;
    let mut request = request.clone();
    let [theta, radius, variance] = match request.rows {
        SizeRows::Laws => {
            let mut errors = [AxisError::default(); 2];
            for (axis, error) in [SizeAxis::Variance, SizeAxis::Radius]
                .into_iter()
                .zip(&mut errors)
            {
                (request, *error) = refined(request, pilots, axis)?;
            }
            let [variance, radius] = errors;
            [theta_error(&request, pilots)?, radius, variance]
        }
        SizeRows::Bins {
            ln_step,
            narrowest_variance,
        } => {
            let law = (ln_step, narrowest_variance);
            let [theta, radius] = bins_errors(&request, law, pilots)?;
            [theta, radius, AxisError::default()]
        }
    };
    let mut table = table_at(&request, chosen, progress)?;
    table.interpolation_error = Some(InterpolationError {
        theta,
        radius,
        variance,
    });
    Ok(table)
}

/// The request with enough nodes along an axis, and the error that is left.
fn refined<'a>(
    mut request: TableRequest<'a>,
    pilots: Pilots,
    axis: SizeAxis,
) -> Result<(TableRequest<'a>, AxisError), Error> {
    let mut errors = interval_errors(&request, pilots, axis)?;
    for _ in 0..N_HALVINGS {
        let misses = |error: &IntervalError| error.improvable.rms > request.tolerance;
        if !errors.iter().any(misses) {
            break;
        }
        let nodes = axis.nodes(&request);
        let mut finer = vec![nodes[0]];
        for (pair, error) in nodes.windows(2).zip(&errors) {
            finer.extend(misses(error).then(|| axis.middle(pair[0], pair[1])));
            finer.push(pair[1]);
        }
        request = axis.with_nodes(&request, finer);
        errors = interval_errors(&request, pilots, axis)?;
    }
    let all = errors.iter().map(|error| error.all);
    Ok((request, all.fold(AxisError::default(), worse)))
}
