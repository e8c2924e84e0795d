//! A theory × a size average × the sun's disc = a scattering table.

use std::f64::consts::PI;
use std::sync::Mutex;

use ndarray::Array4;
use ndarray::Array5;
use ndarray::Axis;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_radiometry::Micrometers;
use rayon::prelude::*;

use crate::bow_light::Bin;
use crate::bow_light::BowTheory;
use crate::bow_rows::BowRows;
use crate::bow_shift::bow_shift;
use crate::dark_band::dark_band_rad;
use crate::drop_rows::DropRows;
use crate::error::Error;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::theta_axis::theta_axis;

/// Half of the light that a large drop takes out of a beam is diffracted forward.
const DIFFRACTED_FRACTION: f64 = 0.5;
/// A table that starts at larger angles holds nothing of the diffracted light.
const FORWARD_LOBE_RAD: f64 = 5.0 * PI / 180.0;

/// Makes a scattering table. `progress` hears the part that is done, from 0 to 1. The result does not
/// depend on the number of threads.
///
/// # Errors
/// An axis that is empty, not ascending or outside its range, orders without a bow, or drops that the
/// theory refuses.
pub fn scattering_table(
    request: &TableRequest,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ScatteringTable, Error> {
    request.check()?;
    table_at(request, theta_axis(request)?, progress)
}

/// The table at angles that were chosen already.
pub(crate) fn table_at(
    request: &TableRequest,
    theta_rad: Vec<f64>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ScatteringTable, Error> {
    let values = values_at(request, &theta_rad, progress)?;
    Ok(described(request, theta_rad, values))
}

/// The values of a table.
pub(crate) struct Values {
    /// All light, as in a [`ScatteringTable`].
    pub(crate) all: Array5<f32>,
    /// That of each order which is kept apart.
    moved: Vec<Array4<f32>>,
}

/// The values of a table at angles of one's own.
pub(crate) fn values_at(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    request.check_size(theta_rad.len())?;
    let Some(theory) = request.theory.bow_theory() else {
        return drop_values(request, theta_rad, progress);
    };
    let moved = request.moved_orders();
    let still: Vec<u32> = request
        .orders_in()
        .into_iter()
        .filter(|p| !moved.contains(p))
        .collect();
    let mut parts: Vec<Vec<u32>> = moved.iter().map(|order| vec![*order]).collect();
    parts.extend((!still.is_empty()).then_some(still));
    let n_parts = parts.len() as f64;
    let part = |(index, orders): (usize, Vec<u32>)| {
        let request = TableRequest {
            orders,
            ..request.clone()
        };
        let progress = |done: f64| progress((index as f64 + done) / n_parts);
        bow_values(&request, theory, theta_rad, &progress)
    };
    let mut parts = parts
        .into_iter()
        .enumerate()
        .map(part)
        .collect::<Result<Vec<_>, _>>()?;
    // All of them, in the order of the parts; one alone is not copied.
    let all = match &parts[..] {
        [_] if moved.is_empty() => parts.remove(0),
        parts => {
            let mut all = zeros(request, theta_rad.len());
            for part in parts {
                all += part;
            }
            all
        }
    };
    parts.truncate(moved.len());
    let moved = parts.into_iter().map(|part| part.remove_axis(Axis(2)));
    Ok(Values {
        all,
        moved: moved.collect(),
    })
}

fn bow_values(
    request: &TableRequest,
    theory: BowTheory,
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Array5<f32>, Error> {
    let rows = BowRows::new(request, theory, theta_rad)?;
    let sizes = rows.size_rows();
    let count = Count::new(request.wavelengths.len() * sizes.len(), progress);
    let mut values = zeros(request, theta_rad.len());
    let planes: Vec<_> = values.axis_iter_mut(Axis(3)).enumerate().collect();
    planes.into_par_iter().for_each(|(index, mut plane)| {
        for size in &sizes {
            let row = rows.row(index, size);
            for (angle, pair) in row.iter().enumerate() {
                let [s, p] = [0, 1].map(|j| [j, size.radius_index, size.variance_index, angle]);
                plane[s] = stored(pair[0]);
                plane[p] = stored(pair[1]);
            }
            count.add(1);
        }
    });
    Ok(values)
}

fn drop_values(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    let rows = DropRows::new(request, theta_rad)?;
    let n_variances = request.effective_variance.len();
    let n_rows = request.effective_radius_um.len() * n_variances;
    let count = Count::new(request.wavelengths.len() * rows.n_drops(), progress);
    let mut all = zeros(request, theta_rad.len());
    let of_part = all.clone().remove_axis(Axis(2));
    let mut moved = vec![of_part; request.moved_orders().len()];
    let mut of_moved: Vec<_> = (moved.iter_mut())
        .map(|values| values.axis_iter_mut(Axis(2)))
        .collect();
    let mut planes = Vec::with_capacity(request.wavelengths.len());
    for plane in all.axis_iter_mut(Axis(3)) {
        let of_orders: Vec<_> = of_moved.iter_mut().filter_map(Iterator::next).collect();
        planes.push((plane, of_orders));
    }
    // Wavelength by wavelength: rows are f64, and all of them would take more than the table.
    planes
        .into_par_iter()
        .enumerate()
        .try_for_each(|(index, (mut all, mut moved))| {
            let rows = rows.at(Bin::new(request, index), &|n| count.add(n))?;
            for (row, light) in rows.iter().enumerate() {
                let (part, row) = (row / n_rows, row % n_rows);
                let (radius, variance) = (row / n_variances, row % n_variances);
                for (angle, pair) in light.iter().enumerate() {
                    for (j, &value) in pair.iter().enumerate() {
                        if part == 0 {
                            all[[j, radius, variance, angle]] = stored(value);
                        } else {
                            moved[part - 1][[j, radius, angle]] = stored(value);
                        }
                    }
                }
            }
            Ok::<(), Error>(())
        })?;
    Ok(Values { all, moved })
}

/// A value as the file holds it: f32, 1e-7 of a value, and never below 0. The sun's disc is averaged
/// over parabolas through the means of neighboring rings, which undershoot zero by up to 1e-5 of the
/// peak where the dark side falls steeply.
fn stored(value: f64) -> f32 {
    value.max(0.0) as f32
}

fn zeros(request: &TableRequest, n_angles: usize) -> Array5<f32> {
    let n_radii = request.effective_radius_um.len();
    let n_variances = request.effective_variance.len();
    let n_wavelengths = request.wavelengths.len();
    Array5::zeros((2, n_radii, n_variances, n_wavelengths, n_angles))
}

/// Tells how much is done.
struct Count<'a> {
    n_done: Mutex<usize>,
    n_total: usize,
    progress: &'a (dyn Fn(f64) + Sync),
}

impl<'a> Count<'a> {
    fn new(n_total: usize, progress: &'a (dyn Fn(f64) + Sync)) -> Self {
        Self {
            n_done: Mutex::new(0),
            n_total,
            progress,
        }
    }

    fn add(&self, n: usize) {
        let mut n_done = self
            .n_done
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        *n_done += n;
        (self.progress)(*n_done as f64 / self.n_total as f64);
    }
}

fn described(request: &TableRequest, theta_rad: Vec<f64>, values: Values) -> ScatteringTable {
    let theory = request.theory;
    let names = request.orders_in().into_iter().map(|p| p.to_string());
    let orders = if theory.holds_every_order() {
        "all".to_owned()
    } else {
        names.collect::<Vec<_>>().join(",")
    };
    // Order 0 is reflection and diffraction together.
    let holds_diffraction = theory.is_exact()
        && theta_rad[0] < FORWARD_LOBE_RAD
        && (theory.holds_every_order() || request.orders.contains(&0));
    let [primary_rad, secondary_rad] = dark_band_rad(request.water);
    ScatteringTable {
        theory: theory.name().to_owned(),
        orders,
        wavelengths: request.wavelengths,
        theta_rad,
        effective_radius_um: request.effective_radius_um.clone(),
        effective_variance: request.effective_variance.clone(),
        moved: moved_bows(request, values.moved),
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
        interpolation_error: None,
    }
}

/// How the orders move that are kept apart.
fn moved_bows(request: &TableRequest, values: Vec<Array4<f32>>) -> Option<MovedBows> {
    let motion = request.motion.filter(|_| !values.is_empty())?;
    let radii = request.effective_radius_um.iter().copied().map(Micrometers);
    let order = |(order, values): (u32, Array4<f32>)| {
        let shift = |wavelength| {
            let index = request.water.refractive_index(wavelength);
            // An order without a bow stays.
            bow_shift(index, order).unwrap_or_default()
        };
        MovedOrder {
            order,
            shifts: request.wavelengths.centers().map(shift).collect(),
            values,
        }
    };
    let orders = request.moved_orders().into_iter().zip(values);
    Some(MovedBows {
        drops: radii.map(|radius| motion.drops(radius)).collect(),
        orders: orders.map(order).collect(),
    })
}
