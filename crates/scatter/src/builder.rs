//! A theory × a size average × the sun's disc = a scattering table.

use std::f64::consts::PI;
use std::sync::Mutex;

use ndarray::Array4;
use ndarray::Array5;
use ndarray::ArrayViewMut3;
use ndarray::ArrayViewMut4;
use ndarray::Axis;
use niji_exchange::MovedBows;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use rayon::prelude::*;

use crate::bow_light::Bin;
use crate::bow_rows::BowLights;
use crate::bow_rows::BowRows;
use crate::dark_band::dark_band_rad;
use crate::drop_rows::DropRows;
use crate::error::Error;
use crate::moved_orders::MovedOrders;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::small_drops::RowLight;
use crate::small_drops::SmallDrops;
use crate::theta_axis::axis_and_lights;

/// Half of the light that a large drop takes out of a beam is diffracted forward.
const DIFFRACTED_FRACTION: f64 = 0.5;
/// Part of the time that uniform light takes of a table by size.
const LARGE_DROPS_PROGRESS: f64 = 0.1;
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
    table_at(request, axis_and_lights(request)?, progress)
}

/// The table at angles that were chosen already.
pub(crate) fn table_at(
    request: &TableRequest,
    (theta_rad, lights): (Vec<f64>, BowLights),
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ScatteringTable, Error> {
    let lights = lights.are_rings().then_some(lights);
    let values = values_with((request, lights), &theta_rad, progress)?;
    let moved = MovedOrders::new(request).bows(values.moved);
    Ok(described((request, theta_rad), values.all, moved))
}

/// The values of a table.
pub(crate) struct Values {
    /// All light, as in a [`ScatteringTable`].
    pub(crate) all: Array5<f32>,
    /// That of each order which is kept apart, for the radii that move.
    moved: Vec<Array4<f32>>,
}

/// All light and that of each order that is kept apart, at one wavelength.
type Planes<'a> = (ArrayViewMut4<'a, f32>, Vec<ArrayViewMut3<'a, f32>>);

impl Values {
    /// Adds the rows of each wavelength, all light and then each order that is kept apart, to a share of
    /// what is there. Wavelength by wavelength: rows are f64, and all of them would take more than the table.
    fn add(
        &mut self,
        rows_at: impl Fn(usize) -> Result<Vec<RowLight>, Error> + Sync,
    ) -> Result<(), Error> {
        let (_, n_radii, n_variances, _, _) = self.all.dim();
        let n_rows = n_radii * n_variances;
        let n_still = n_radii - self.moved.first().map_or(0, |order| order.dim().1);
        let add_all = |(index, (mut all, mut moved)): (usize, Planes<'_>)| {
            for (row, light) in rows_at(index)?.into_iter().enumerate() {
                let (part, row) = (row / n_rows, row % n_rows);
                let (radius, variance) = (row / n_variances, row % n_variances);
                if part > 0 && (radius < n_still || moved.is_empty()) {
                    continue;
                }
                for (angle, pair) in light.added.iter().enumerate() {
                    for (j, &added) in pair.iter().enumerate() {
                        let value = if part == 0 {
                            &mut all[[j, radius, variance, angle]]
                        } else {
                            &mut moved[part - 1][[j, radius - n_still, angle]]
                        };
                        *value = stored(light.uniform_share * f64::from(*value) + added);
                    }
                }
            }
            Ok(())
        };
        let planes = self.planes().into_par_iter().enumerate();
        planes.try_for_each(add_all)
    }

    /// By wavelength.
    fn planes(&mut self) -> Vec<Planes<'_>> {
        let moved = self.moved.iter_mut();
        let mut moved: Vec<_> = moved.map(|order| order.axis_iter_mut(Axis(2))).collect();
        let of_orders = |all| (all, moved.iter_mut().filter_map(Iterator::next).collect());
        self.all.axis_iter_mut(Axis(3)).map(of_orders).collect()
    }
}

/// The values of a table at angles of one's own.
pub(crate) fn values_at(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    values_with((request, None), theta_rad, progress)
}

/// The values, with what is known of the bows.
fn values_with(
    (request, lights): (&TableRequest, Option<BowLights>),
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    request.check_size(theta_rad.len())?;
    let method = request.theory.method();
    let Some(theory) = method.bows else {
        return drop_values(request, theta_rad, progress);
    };
    let lights = match lights {
        Some(lights) => lights,
        None => BowLights::new(request, theory, theta_rad)?,
    };
    if method.blends() {
        by_size_values((request, &lights), theta_rad, progress)
    } else {
        values_of_bows((request, &lights), theta_rad, progress)
    }
}

/// Drops that stay have all of their light in one, the others each order that moves apart.
fn values_of_bows(
    (request, lights): (&TableRequest, &BowLights),
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    let n_still = MovedOrders::new(request).n_still;
    let (still, moving) = request.effective_radius_um.split_at(n_still);
    let of_radii = |radii: &[f64], motion| TableRequest {
        effective_radius_um: radii.to_vec(),
        motion,
        ..request.clone()
    };
    if moving.is_empty() {
        let all = bow_values((request, lights), theta_rad, progress)?;
        return Ok(Values {
            all,
            moved: Vec::new(),
        });
    }
    if still.is_empty() {
        return values_of_moving((request, lights), theta_rad, progress);
    }
    // One part of light to three.
    let share = 1.0 / (1.0 + 3.0 * moving.len() as f64 / still.len() as f64);
    let of_still = |done: f64| progress(share * done);
    let of_moving = |done: f64| progress(share + (1.0 - share) * done);
    let still = bow_values((&of_radii(still, None), lights), theta_rad, &of_still)?;
    let moving = of_radii(moving, request.motion);
    let moving = values_of_moving((&moving, lights), theta_rad, &of_moving)?;
    let mut all = zeros(request, theta_rad.len());
    let (mut low, mut high) = all.view_mut().split_at(Axis(1), n_still);
    low.assign(&still);
    high.assign(&moving.all);
    Ok(Values {
        all,
        moved: moving.moved,
    })
}

fn values_of_moving(
    (request, lights): (&TableRequest, &BowLights),
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
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
        bow_values((&request, lights), theta_rad, &progress)
    };
    let mut parts = parts
        .into_iter()
        .enumerate()
        .map(part)
        .collect::<Result<Vec<_>, _>>()?;
    // In the order of the parts.
    let mut all = zeros(request, theta_rad.len());
    for part in &parts {
        all += part;
    }
    parts.truncate(moved.len());
    let moved = parts.into_iter().map(|part| part.remove_axis(Axis(2)));
    Ok(Values {
        all,
        moved: moved.collect(),
    })
}

fn bow_values(
    (request, lights): (&TableRequest, &BowLights),
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Array5<f32>, Error> {
    let rows = BowRows::new(request, lights, theta_rad)?;
    let sizes = rows.size_rows();
    let count = Count::new(request.wavelengths.len() * sizes.len(), progress);
    let mut values = zeros(request, theta_rad.len());
    let planes: Vec<_> = values.axis_iter_mut(Axis(3)).enumerate().collect();
    planes.into_par_iter().for_each(|(index, mut plane)| {
        for size in sizes.iter().filter(|size| rows.is_lit(index, size)) {
            let row = rows.row(index, size);
            for (angle, pair) in row.iter().enumerate() {
                let [s, p] = [0, 1].map(|j| [j, size.radius_index, size.variance_index, angle]);
                plane[s] = stored(pair[0]);
                plane[p] = stored(pair[1]);
            }
        }
        count.add(sizes.len());
    });
    Ok(values)
}

fn drop_values(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    let rows = DropRows::new(request, theta_rad)?;
    let count = Count::new(request.wavelengths.len() * rows.nodes().len(), progress);
    let orders = MovedOrders::new(request);
    let all = zeros(request, theta_rad.len());
    let (_, n_radii, _, n_wavelengths, n_angles) = all.dim();
    let of_order = Array4::zeros((2, n_radii - orders.n_still, n_wavelengths, n_angles));
    let moved = vec![of_order; orders.len()];
    let mut values = Values { all, moved };
    values.add(|index| {
        let rows = rows.at(Bin::new(request, index), &|n| count.add(n))?;
        let light = |added| RowLight {
            uniform_share: 0.0,
            added,
        };
        Ok(rows.into_iter().map(light).collect())
    })?;
    Ok(values)
}

/// Uniform light first, then the drops that take its place.
fn by_size_values(
    (request, lights): (&TableRequest, &BowLights),
    theta_rad: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Values, Error> {
    let small = SmallDrops::new(request, theta_rad)?;
    let in_laws = small.in_laws();
    let uniform = match &in_laws {
        Some(request) => Some(BowRows::new(request, lights, theta_rad)?),
        None => None,
    };
    let of_large = |done: f64| progress(LARGE_DROPS_PROGRESS * done);
    let mut values = values_of_bows((request, lights), theta_rad, &of_large)?;
    let of_small = |done: f64| progress(LARGE_DROPS_PROGRESS + (1.0 - LARGE_DROPS_PROGRESS) * done);
    let n_drops = request.wavelengths.len() * small.n_drops().max(1);
    let count = Count::new(n_drops, &of_small);
    values.add(|index| small.at(index, uniform.as_ref(), &|n| count.add(n)))?;
    Ok(values)
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

fn described(
    (request, theta_rad): (&TableRequest, Vec<f64>),
    values: Array5<f32>,
    moved: Option<MovedBows>,
) -> ScatteringTable {
    let theory = request.theory;
    let names = request.orders_in().into_iter().map(|p| p.to_string());
    let orders = if theory.ignores_orders() {
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
        moved,
        values,
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
