//! The scattering angles of a table: as few as linear interpolation to a tolerance allows.
//!
//! An order that moves has fewer angles of its own, some of the table's: it has no ripple.
//!
//! Judged on every wavelength, because each has its bow elsewhere, on the smallest, the largest and
//! some radii between, and on the narrowest and the broadest law, by the theory itself (the uniform one
//! with diffracted light for exact theories) after the sun's disc. One thing these curves do not show: exact theories
//! keep a ripple, of the orders' interference or of small drops. After a disc it is as wide as that, so that steps are
//! limited; without one angles between are measured ([`crate::measured_angles`]).

use std::f64::consts::PI;

use niji_radiometry::Micrometers;
use rayon::prelude::*;

use crate::bow_rows::BowLights;
use crate::bow_rows::BowRows;
use crate::bow_rows::Drops;
use crate::diffraction::DiffractedLight;
use crate::error::Error;
use crate::measured_angles::measured_angles;
use crate::moved_orders::MovedOrders;
use crate::needed_angles::Nearness;
use crate::needed_angles::needed_angles;
use crate::progress::Progress;
use crate::progress::unwatched;
use crate::request::SizeRow;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::table_rows::RowLight;
use crate::table_rows::add;
use niji_radiometry::size_parameter;

/// Amplitude of the ripple of a single size after the disc, in parts of the peak.
const RIPPLE: f64 = 0.02;
/// Widest step between the angles of an order that moves: none is dark at one end and bright at the other,
/// far from its bow.
const WIDEST_MOVED_STEP_RAD: f64 = PI / 180.0;
/// Candidates at most.
const MOST_ANGLES: usize = 40_000;
/// Up to how many of its radii from the sun's middle candidates are closer, and how many times as close.
const EDGE_IN_RADII: f64 = 2.5;
const N_PARTS_AT_EDGE: u8 = 4;
/// Radii that are judged, at most.
const N_RADII: usize = 7;
/// Without a disc: how far inside the primary bow fringes are resolved, 12 degrees.
const RESOLVED_RAD: f64 = 12.0 * PI / 180.0;

/// How many angles there are.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NumberOfAngles {
    /// Of all light.
    pub all: usize,
    /// Of the orders that are kept apart, each.
    pub of_orders: Vec<usize>,
}

/// How many angles a table will have: all that it costs to know how large it will be.
///
/// # Errors
/// As [`crate::scattering_table`].
pub fn number_of_angles(request: &TableRequest) -> Result<NumberOfAngles, Error> {
    Ok(chosen_angles(request, &unwatched)?.angles.number())
}

/// The angles of a table.
#[derive(Clone, Debug)]
pub(crate) struct TableAngles {
    pub(crate) theta_rad: Vec<f64>,
    /// Which of them the orders have that are kept apart, ascending.
    pub(crate) of_orders: Vec<Vec<usize>>,
}

impl TableAngles {
    pub(crate) fn number(&self) -> NumberOfAngles {
        NumberOfAngles {
            all: self.theta_rad.len(),
            of_orders: self.of_orders.iter().map(Vec::len).collect(),
        }
    }
}

/// The angles of a table, and what was computed of its bows on the way.
pub(crate) struct ChosenAngles {
    pub(crate) angles: TableAngles,
    pub(crate) lights: BowLights,
}

/// Chooses the angles. `progress` hears that nothing of the table itself is done yet.
pub(crate) fn chosen_angles(
    request: &TableRequest,
    progress: Progress,
) -> Result<ChosenAngles, Error> {
    let candidates = candidates(request);
    let probe = probe(request);
    let lights = BowLights::new(&probe, &candidates)?;
    let rows = BowRows::new(&probe, lights, &candidates);
    // Without a disc it is measured.
    let diffracted = (request.disc_radius_rad() > 0.0)
        .then(|| DiffractedLight::of_request(&probe, &candidates))
        .transpose()?
        .flatten();
    let sizes: Vec<SizeRow> = probe.size_rows().collect();
    // Natural light by angle, of each wavelength and size.
    let curves = |light: &(dyn Fn(usize, Drops) -> RowLight + Sync)| -> Vec<Vec<f64>> {
        let of_wavelengths: Vec<Vec<Vec<f64>>> = (0..request.wavelengths.len())
            .into_par_iter()
            .map(|index| {
                let natural = |size: &SizeRow| {
                    let row = light(index, Drops::of_row(size));
                    row.iter().map(|[s, p]| 0.5 * (s + p)).collect()
                };
                sizes.iter().map(natural).collect()
            })
            .collect();
        of_wavelengths.into_iter().flatten().collect()
    };
    let of_order = |order: u32| curves(&|index, drops| rows.light(index, drops, &[order]));
    let orders = probe.orders_in();
    let all = curves(&|index, drops| {
        let mut light = rows.light(index, drops, &orders);
        if let Some(diffracted) = &diffracted {
            let wavelength = request.wavelengths.center(index);
            add(&mut light, 1.0, &diffracted.light(drops, wavelength));
        }
        light
    });
    let needed = |curves: &[Vec<f64>], widest_step_rad: f64| -> Vec<f64> {
        let nearness = Nearness {
            tolerance: request.tolerance,
            of: &all,
            widest_step_rad,
        };
        let kept = needed_angles(&candidates, curves, nearness).into_iter();
        kept.map(|index| candidates[index]).collect()
    };
    let moved = MovedOrders::new(request).orders;
    let of_orders: Vec<Vec<f64>> = moved
        .iter()
        .map(|order| needed(&of_order(*order), WIDEST_MOVED_STEP_RAD))
        .collect();
    let mut theta_rad = needed(&all, f64::INFINITY);
    theta_rad.extend(of_orders.iter().flatten());
    theta_rad.sort_by(f64::total_cmp);
    theta_rad.dedup();
    if request.theory.is_exact() {
        theta_rad = with_ripple(request, &theta_rad, progress)?;
    }
    let place = |theta: &f64| theta_rad.partition_point(|of_all| of_all < theta);
    Ok(ChosenAngles {
        angles: TableAngles {
            of_orders: of_orders
                .iter()
                .map(|of_order| of_order.iter().map(place).collect())
                .collect(),
            theta_rad,
        },
        lights: rows.lights,
    })
}

/// The same angles, with those between them that the ripple of exact theories needs.
fn with_ripple(
    request: &TableRequest,
    theta_rad: &[f64],
    progress: Progress,
) -> Result<Vec<f64>, Error> {
    let radius_rad = request.disc_radius_rad();
    if radius_rad <= 0.0 {
        return measured_angles(request, theta_rad, progress);
    }
    let root = (2.0 * request.tolerance / ripple(request)).sqrt();
    let largest_rad = root * 2.0 * radius_rad / PI;
    Ok(with_steps_up_to(theta_rad, largest_rad))
}

/// Amplitude of the ripple after the disc in what is seen of a table, in parts of the peak: in sums over
/// single sizes, which ripple each by itself, as much less as their number of equal weights has it.
fn ripple(request: &TableRequest) -> f64 {
    match request.rows {
        SizeRows::Bins {
            ln_step,
            narrowest_variance,
        } if ln_step > 0.0 => {
            let n_sizes = 2.0 * (PI * narrowest_variance).sqrt() / ln_step;
            RIPPLE / n_sizes.max(1.0).sqrt()
        }
        SizeRows::Bins { .. } | SizeRows::Laws => RIPPLE,
    }
}

/// The same angles, with even ones between those that are farther apart than `largest_rad`.
fn with_steps_up_to(angles: &[f64], largest_rad: f64) -> Vec<f64> {
    let mut filled = vec![angles[0]];
    for pair in angles.windows(2) {
        let width = pair[1] - pair[0];
        // A step that is the largest itself is not halved by rounding.
        let n = (width / largest_rad - 1e-6)
            .ceil()
            .clamp(1.0, MOST_ANGLES as f64) as usize;
        filled.extend((1..n).map(|index| pair[0] + width * index as f64 / n as f64));
        filled.push(pair[1]);
    }
    filled
}

/// Even angles, close enough that linear interpolation between neighbours keeps the tolerance; closer around the edge of
/// the sun's disc, outside of which diffracted light falls as steeply as inverse squares of the distance from it.
fn candidates(request: &TableRequest) -> Vec<f64> {
    let radius_rad = request.disc_radius_rad();
    let root = request.tolerance.sqrt();
    let step_rad = if radius_rad > 0.0 {
        // Nothing is sharper than a disc of light: half a cosine as wide as the disc bends by
        // (π/2R)²/2, so that h² (π/2R)²/16 is the error.
        (0.8 * root).min(0.25) * radius_rad
    } else {
        root * fringe_period_rad(request) / PI
    };
    let (low, high) = request.theta_range_rad;
    let n_steps = ((high - low) / step_rad).ceil().max(1.0) as usize;
    let n_steps = n_steps.min(MOST_ANGLES);
    let at = |index: usize, fraction: f64| {
        // Both ends exactly.
        let part = (index as f64 + fraction) / n_steps as f64;
        low * (1.0 - part) + high * part
    };
    let holds_diffraction = request.holds_diffraction();
    let mut angles = Vec::with_capacity(n_steps + 1);
    for index in 0..n_steps {
        let is_at_edge = holds_diffraction && at(index, 0.0) < EDGE_IN_RADII * radius_rad;
        let n_parts = if is_at_edge { N_PARTS_AT_EDGE } else { 1 };
        angles.extend((0..n_parts).map(|part| at(index, f64::from(part) / f64::from(n_parts))));
    }
    angles.push(at(n_steps, 0.0));
    angles
}

/// Narrowest fringe of the largest drop: of phase (4/3) ζ^(3/2), ζ = (x²/h)^(1/3) d with h near 5.
fn fringe_period_rad(request: &TableRequest) -> f64 {
    let largest_um = request.effective_radius_um.last().copied().unwrap_or(1.0);
    let x = size_parameter(Micrometers(largest_um), request.wavelengths.center(0));
    PI / (x * (RESOLVED_RAD / 5.0).sqrt())
}

/// The request with the few sizes that are judged.
fn probe<'a>(request: &TableRequest<'a>) -> TableRequest<'a> {
    let orders = if request.orders.is_empty() {
        vec![2, 3]
    } else {
        request.orders.clone()
    };
    TableRequest {
        orders,
        effective_radius_um: some_of(&request.effective_radius_um, N_RADII),
        effective_variance: some_of(&request.effective_variance, 2),
        ..request.clone()
    }
}

/// At most `n` values, the ends among them.
pub(crate) fn some_of(values: &[f64], n: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let mut indices: Vec<usize> = (0..n).map(|index| index * last / (n - 1)).collect();
    indices.dedup();
    indices.into_iter().map(|index| values[index]).collect()
}
