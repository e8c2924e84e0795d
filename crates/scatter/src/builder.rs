//! A theory × a size average × the sun's disc = a scattering table.

use std::f64::consts::PI;
use std::sync::Mutex;
use std::sync::PoisonError;

use ndarray::Array5;
use ndarray::ArrayViewMut4;
use ndarray::Axis;
use ndarray::s;
use niji_exchange::MovedBows;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use crate::bow_rows::BowLights;
use crate::by_size::Blend;
use crate::dark_band::dark_band_rad;
use crate::error::Error;
use crate::moved_orders::MovedOrders;
use crate::progress::Progress;
use crate::progress::tell;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::table_rows::TableRows;
use crate::table_rows::Task;
use crate::theta_axis::ChosenAngles;
use crate::theta_axis::TableAngles;
use crate::theta_axis::chosen_angles;

/// Half of the light that a large drop takes out of a beam is diffracted forward.
const DIFFRACTED_FRACTION: f64 = 0.5;
/// A table that starts at larger angles holds nothing of the diffracted light.
const FORWARD_LOBE_RAD: f64 = 5.0 * PI / 180.0;

/// Makes a scattering table. The result does not depend on the number of threads.
///
/// # Errors
/// An axis that is empty, not ascending or outside its range, orders without a bow, or drops that the
/// theory refuses; [`Error::Stopped`].
pub fn scattering_table(
    request: &TableRequest,
    progress: Progress,
) -> Result<ScatteringTable, Error> {
    request.check()?;
    table_at(request, chosen_angles(request, progress)?, progress)
}

/// The table at angles that were chosen already.
pub(crate) fn table_at(
    request: &TableRequest,
    chosen: ChosenAngles,
    progress: Progress,
) -> Result<ScatteringTable, Error> {
    let ChosenAngles { angles, lights } = chosen;
    let lights = lights.are_rings().then_some(lights);
    let values = values_at(request, &angles, lights, progress)?;
    Ok(described(request, angles.theta_rad, values))
}

/// What a table holds by row, wavelength and angle.
pub(crate) struct Values {
    /// All light, as in a [`ScatteringTable`].
    pub(crate) all: Array5<f32>,
    /// That of the orders which are kept apart, for the radii that move.
    moved: Option<MovedBows>,
}

/// The values of a table at angles of one's own, with what is known of its bows.
pub(crate) fn values_at(
    request: &TableRequest,
    angles: &TableAngles,
    lights: Option<BowLights>,
    progress: Progress,
) -> Result<Values, Error> {
    request.check_size(&angles.number())?;
    let theta_rad = &angles.theta_rad;
    let (blend, moved) = (Blend::new(request)?, MovedOrders::new(request));
    let task = Task {
        request,
        theta_rad,
        blend: &blend,
        moved: &moved,
    };
    let rows = TableRows::new(task, lights)?;
    let n_total = request.wavelengths.len() * (rows.n_drops() + request.n_rows());
    let n_done = Mutex::new(0_usize);
    let count = |n: usize| {
        let mut n_done = n_done.lock().unwrap_or_else(PoisonError::into_inner);
        *n_done += n;
        tell(progress, *n_done as f64 / n_total as f64)
    };
    let (n_radii, n_variances) = (
        request.effective_radius_um.len(),
        request.effective_variance.len(),
    );
    let zeros = |(n_radii, n_variances), n_angles| {
        let n_wavelengths = request.wavelengths.len();
        Array5::zeros((2, n_radii, n_variances, n_wavelengths, n_angles))
    };
    // All light, and the orders that are kept apart, each at its angles.
    let mut parts = vec![zeros((n_radii, n_variances), theta_rad.len())];
    let of_orders = angles.of_orders.iter();
    parts.extend(of_orders.map(|of_order| zeros((moved.n_moved(), 1), of_order.len())));
    let all: Vec<usize> = (0..theta_rad.len()).collect();
    let angles_of_parts: Vec<&Vec<usize>> = [&all].into_iter().chain(&angles.of_orders).collect();
    // Wavelength by wavelength: rows are f64, and all of them would take more than the table.
    let mut planes: Vec<_> = parts
        .iter_mut()
        .map(|part| part.axis_iter_mut(Axis(3)))
        .collect();
    let of_wavelength = |_| planes.iter_mut().filter_map(Iterator::next).collect();
    let planes: Vec<Vec<ArrayViewMut4<f32>>> =
        (0..request.wavelengths.len()).map(of_wavelength).collect();
    let fill = |(index, mut planes): (usize, Vec<ArrayViewMut4<f32>>)| {
        let of_drops = rows.of_drops(index, &count)?;
        for row in request.size_rows() {
            let parts = planes.iter_mut().zip(&angles_of_parts);
            for ((plane, angles), light) in parts.zip(rows.row(index, &row, &of_drops)) {
                // Of orders that are kept apart there are but the radii that move, the last ones.
                let radius_index = row.radius_index + plane.len_of(Axis(1)) - n_radii;
                let mut values = plane.slice_mut(s![.., radius_index, row.variance_index, ..]);
                for ((j, angle), value) in values.indexed_iter_mut() {
                    // As the file holds it: f32, 1e-7 of a value, and never below 0.
                    *value = light[angles[angle]][j].max(0.0) as f32;
                }
            }
        }
        count(request.n_rows())
    };
    planes.into_par_iter().enumerate().try_for_each(fill)?;
    let all = parts.remove(0);
    let of_orders = angles.of_orders.iter().zip(parts).map(|(angles, part)| {
        let theta_rad = angles.iter().map(|angle| theta_rad[*angle]).collect();
        (theta_rad, part.remove_axis(Axis(2)))
    });
    Ok(Values {
        all,
        moved: moved.bows(of_orders),
    })
}

/// The table of these values.
pub(crate) fn described(
    request: &TableRequest,
    theta_rad: Vec<f64>,
    values: Values,
) -> ScatteringTable {
    let theory = request.theory;
    let names = request.orders_in().into_iter().map(|p| p.to_string());
    let orders = if theory.ignores_orders() {
        "all".to_owned()
    } else {
        names.collect::<Vec<_>>().join(",")
    };
    let holds_diffraction = request.holds_diffraction() && theta_rad[0] < FORWARD_LOBE_RAD;
    let [primary_rad, secondary_rad] = dark_band_rad(request.water);
    ScatteringTable {
        theory: theory.name().to_owned(),
        orders,
        wavelengths: request.wavelengths,
        theta_rad,
        effective_radius_um: request.effective_radius_um.clone(),
        effective_variance: request.effective_variance.clone(),
        moved: values.moved,
        values: values.all,
        row_use: match request.rows {
            SizeRows::Laws => RowUse::Laws,
            SizeRows::Bins { .. } => RowUse::Sums,
        },
        relative_error: request.tolerance,
        sun_disc_diameter_rad: request.sun_disc_diameter_rad,
        split_theta_rad: 0.5 * (primary_rad + secondary_rad),
        forward_fraction_left_out: if holds_diffraction {
            0.0
        } else {
            DIFFRACTED_FRACTION
        },
        water: request.water,
        phase_functions: None,
        interpolation_error: None,
    }
}
