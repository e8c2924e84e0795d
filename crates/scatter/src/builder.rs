//! A theory × a size average × the sun's disc = a scattering table.

use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::sync::Mutex;

use ndarray::Array5;
use ndarray::Axis;
use niji_airy::AiryTable;
use niji_airy::rainbow_ray;
use niji_exchange::ScatteringTable;
use niji_radiometry::Meters;
use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;
use niji_radiometry::water_refractive_index;
use rayon::prelude::*;

use crate::axes::needed_nodes;
use crate::drop_theory::DropTheory;
use crate::drop_theory::Setting;
use crate::error::Error;
use crate::size_average::SizeNode;
use crate::size_average::size_nodes;
use crate::sun_disc::AverageRow;
use crate::sun_disc::FineGrid;
use crate::sun_disc::disc_row;
use crate::theory::Theory;

/// Finest and coarsest steps of the angles at which single drops are computed.
const FINE_STEPS_RAD: (f64, f64) = (0.01 * PI / 180.0, 0.05 * PI / 180.0);
/// Steps of the fine grid across the sun's disc, at least.
const STEPS_PER_DISC: f64 = 24.0;
/// Steps of the fine grid in a fringe of the largest drop, 6 degrees inside the primary bow.
const STEPS_PER_FRINGE: f64 = 4.0;
/// Largest number of samples along θ before they are thinned.
const MOST_ANGLES: usize = 40_000;
/// Wavelength that decides where the two bows are split.
const SPLIT_WAVELENGTH: Nanometers = Nanometers(560.0);
/// Half of the light that a large drop takes out of a beam is diffracted forward.
const DIFFRACTED_FRACTION: f64 = 0.5;
/// A table that starts at larger angles holds nothing of the diffracted light.
const FORWARD_LOBE_RAD: f64 = 5.0 * PI / 180.0;

/// What a scattering table is made from.
#[derive(Clone, Debug)]
pub struct TableRequest<'a> {
    /// How a drop scatters.
    pub theory: Theory,
    /// Orders with a bow that take part, 2 primary, 3 secondary; ignored by [`Theory::Mie`].
    pub orders: Vec<u32>,
    /// Smallest and largest scattering angle in radians.
    pub theta_range_rad: (f64, f64),
    /// Error of linear interpolation in θ over the peak of the bow.
    pub theta_tolerance: f64,
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Effective radii in micrometres, see [`crate::radius_axis`].
    pub effective_radius_um: Vec<f64>,
    /// Effective variances, see [`crate::variance_axis`].
    pub effective_variance: Vec<f64>,
    /// Diameter of the sun's disc in radians; 0 for a point.
    pub sun_disc_diameter_rad: f64,
    /// Temperature of the water in degrees Celsius.
    pub temperature_c: f64,
    /// Airy's integral in advance; `None` computes every value.
    pub airy_table: Option<&'a AiryTable>,
}

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
    check(request)?;
    let fine = fine_grid(request);
    let angles_rad: Vec<f64> = (0..fine.n).map(|index| fine.angle(index)).collect();
    let theta_rad = theta_axis(request, &fine, &angles_rad)?;
    let averages = averages(request, &fine, &theta_rad);
    let nodes = size_nodes(&request.effective_radius_um, &request.effective_variance)?;

    let (n_radii, n_variances) = (
        request.effective_radius_um.len(),
        request.effective_variance.len(),
    );
    let shape = (
        2,
        n_radii,
        n_variances,
        request.wavelengths.len(),
        theta_rad.len(),
    );
    let mut values = Array5::<f32>::zeros(shape);
    let n_done = Mutex::new(0_usize);
    let n_total = (request.wavelengths.len() * nodes.len()) as f64;
    let count = |n: usize| {
        let mut done = n_done
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        *done += n;
        progress(*done as f64 / n_total);
    };
    let planes: Vec<_> = values.axis_iter_mut(Axis(3)).enumerate().collect();
    planes.into_par_iter().try_for_each(|(index, mut plane)| {
        let wavelength = request.wavelengths.center(index);
        let rows = wavelength_rows(request, wavelength, &angles_rad, &averages, &nodes, &count)?;
        for (row, values) in rows.iter().enumerate() {
            let (radius, variance) = (row / n_variances, row % n_variances);
            for (angle, pair) in values.iter().enumerate() {
                for polarization in 0..2 {
                    // f32 in files; the tables' own errors are a thousand times larger.
                    plane[[polarization, radius, variance, angle]] = pair[polarization] as f32;
                }
            }
        }
        Ok(())
    })?;
    Ok(described(request, theta_rad, values))
}

fn check(request: &TableRequest) -> Result<(), Error> {
    let ascending = |values: &[f64]| values.windows(2).all(|pair| pair[1] > pair[0]);
    let radii = &request.effective_radius_um;
    if radii.is_empty() || !ascending(radii) || radii.iter().any(|r| !(*r > 0.0 && r.is_finite())) {
        let expected = "ascending radii above 0 um";
        return Err(Error::Axis {
            axis: "effective radius",
            found: format!("{radii:?}"),
            expected,
        });
    }
    let variances = &request.effective_variance;
    let in_range = variances
        .iter()
        .all(|variance| (0.0..0.5).contains(variance));
    if variances.is_empty() || !ascending(variances) || !in_range {
        let (axis, found) = ("effective variance", format!("{variances:?}"));
        return Err(Error::Axis {
            axis,
            found,
            expected: "ascending values from 0 to below 0.5",
        });
    }
    let (low, high) = request.theta_range_rad;
    if !(low >= 0.0 && high > low && high <= PI + 1e-12) {
        let found = format!("{} to {} degrees", low.to_degrees(), high.to_degrees());
        return Err(Error::Axis {
            axis: "theta",
            found,
            expected: "a range within 0 to 180 degrees",
        });
    }
    if !(request.theta_tolerance > 0.0 && request.theta_tolerance <= 1.0) {
        let found = request.theta_tolerance.to_string();
        return Err(Error::Axis {
            axis: "tolerance",
            found,
            expected: "above 0, at most 1",
        });
    }
    if !(0.0..0.1).contains(&request.sun_disc_diameter_rad) {
        let found = format!("{} rad", request.sun_disc_diameter_rad);
        return Err(Error::Axis {
            axis: "sun disc",
            found,
            expected: "0 to 0.1 rad",
        });
    }
    let wave_theory = request.theory != Theory::Mie;
    let sound_orders =
        !request.orders.is_empty() && request.orders.iter().all(|p| (2..8).contains(p));
    if wave_theory && !sound_orders {
        return Err(Error::Orders {
            found: request.orders.clone(),
        });
    }
    Ok(())
}

/// Even angles that resolve the fringes of the largest drop and the sun's disc, and reach a disc
/// beyond the table.
fn fine_grid(request: &TableRequest) -> FineGrid {
    let largest = Meters::from(Micrometers(
        request.effective_radius_um.last().copied().unwrap_or(1.0),
    ));
    let shortest = Meters::from(request.wavelengths.center(0));
    let x = TAU * largest.0 / shortest.0;
    // Scale of the bow (h/x²)^(1/3) with h near 5; fringe period π scale/sqrt(ζ) at ζ = d/scale.
    let scale_rad = 1.7 * x.powf(-2.0 / 3.0);
    let fringe_rad = PI * scale_rad * (scale_rad / 0.105).sqrt();
    let mut step_rad = (fringe_rad / STEPS_PER_FRINGE).clamp(FINE_STEPS_RAD.0, FINE_STEPS_RAD.1);
    if request.sun_disc_diameter_rad > 0.0 {
        step_rad = step_rad.min(request.sun_disc_diameter_rad / STEPS_PER_DISC);
    }
    let margin_rad = 0.5 * request.sun_disc_diameter_rad + step_rad;
    let first_rad = (request.theta_range_rad.0 - margin_rad).max(0.0);
    let last_rad = (request.theta_range_rad.1 + margin_rad).min(PI);
    let n_steps = ((last_rad - first_rad) / step_rad).ceil().max(1.0);
    let n_steps = n_steps.min(MOST_ANGLES as f64);
    FineGrid {
        first_rad,
        step_rad: (last_rad - first_rad) / n_steps,
        n: n_steps as usize + 1,
    }
}

/// The angles of the table: those of the fine grid that linear interpolation needs, judged by the
/// smallest, a middle and the largest radius, the narrowest law, and three wavelengths, in Airy's
/// theory (rays alone for rays alone).
fn theta_axis(
    request: &TableRequest,
    fine: &FineGrid,
    angles_rad: &[f64],
) -> Result<Vec<f64>, Error> {
    let (low, high) = request.theta_range_rad;
    let n_steps = (((high - low) / fine.step_rad).ceil().max(1.0) as usize).min(MOST_ANGLES);
    let step_rad = (high - low) / n_steps as f64;
    let candidates: Vec<f64> = (0..=n_steps)
        .map(|index| (low + step_rad * index as f64).min(high))
        .collect();
    let averages = averages(request, fine, &candidates);
    let radii = &request.effective_radius_um;
    let mut probes = vec![radii[0], radii[radii.len() / 2], radii[radii.len() - 1]];
    probes.dedup();
    let n_wavelengths = request.wavelengths.len();
    let mut wavelengths = vec![0, n_wavelengths / 2, n_wavelengths - 1];
    wavelengths.dedup();
    let theory = match request.theory {
        Theory::Geometric => Theory::Geometric,
        Theory::AiryPublished | Theory::Airy | Theory::Debye { .. } | Theory::Mie => Theory::Airy,
    };
    let orders = if request.orders.is_empty() {
        vec![2, 3]
    } else {
        request.orders.clone()
    };
    let probe = TableRequest {
        theory,
        orders,
        ..request.clone()
    };
    let nodes = size_nodes(&probes, &request.effective_variance[..1])?;
    let curves: Vec<Vec<Vec<f64>>> = wavelengths
        .into_par_iter()
        .map(|index| {
            let wavelength = request.wavelengths.center(index);
            let rows = wavelength_rows(&probe, wavelength, angles_rad, &averages, &nodes, &|_| {})?;
            let natural = |row: Vec<[f64; 2]>| row.iter().map(|[s, p]| 0.5 * (s + p)).collect();
            Ok(rows.into_iter().map(natural).collect())
        })
        .collect::<Result<_, Error>>()?;
    let curves: Vec<Vec<f64>> = curves.into_iter().flatten().collect();
    let kept = needed_nodes(&candidates, &curves, request.theta_tolerance);
    Ok(kept.into_iter().map(|index| candidates[index]).collect())
}

fn averages(request: &TableRequest, fine: &FineGrid, theta_rad: &[f64]) -> Vec<AverageRow> {
    let radius_rad = 0.5 * request.sun_disc_diameter_rad;
    let row = |&theta: &f64| {
        if radius_rad > 0.0 {
            disc_row(fine, theta, radius_rad)
        } else {
            fine.row(theta)
        }
    };
    theta_rad.par_iter().map(row).collect()
}

/// All rows of the table at one wavelength: by row and angle, both polarisations in 1/sr.
fn wavelength_rows(
    request: &TableRequest,
    wavelength: Nanometers,
    angles_rad: &[f64],
    averages: &[AverageRow],
    nodes: &[SizeNode],
    count: &dyn Fn(usize),
) -> Result<Vec<Vec<[f64; 2]>>, Error> {
    let theory = DropTheory::new(Setting {
        theory: request.theory,
        orders: &request.orders,
        wavelength,
        index: water_refractive_index(wavelength, request.temperature_c),
        angles_rad,
        airy_table: request.airy_table,
    })?;
    let n_rows = nodes
        .iter()
        .flat_map(|node| &node.uses)
        .map(|(row, _)| row + 1)
        .max();
    let mut rows = vec![vec![[0.0; 2]; averages.len()]; n_rows.unwrap_or(0)];
    // Ascending radii, so that every sum has one order.
    for node in nodes {
        let drop = theory.drop(node.radius)?;
        let averaged: Vec<[f64; 2]> = averages.iter().map(|row| row.apply(&drop)).collect();
        for &(row, weight) in &node.uses {
            for (sum, value) in rows[row].iter_mut().zip(&averaged) {
                sum[0] += weight * value[0];
                sum[1] += weight * value[1];
            }
        }
        count(1);
    }
    Ok(rows)
}

fn described(request: &TableRequest, theta_rad: Vec<f64>, values: Array5<f32>) -> ScatteringTable {
    let orders = match request.theory {
        Theory::Mie => "all".to_owned(),
        Theory::Geometric | Theory::AiryPublished | Theory::Airy | Theory::Debye { .. } => {
            let names: Vec<String> = request.orders.iter().map(u32::to_string).collect();
            names.join(",")
        }
    };
    let holds_diffraction = match request.theory {
        Theory::Mie | Theory::Debye { .. } => theta_rad[0] < FORWARD_LOBE_RAD,
        Theory::Geometric | Theory::AiryPublished | Theory::Airy => false,
    };
    ScatteringTable {
        theory: request.theory.name().to_owned(),
        orders,
        wavelengths: request.wavelengths,
        theta_rad,
        effective_radius_um: request.effective_radius_um.clone(),
        effective_variance: request.effective_variance.clone(),
        values,
        sun_disc_diameter_rad: request.sun_disc_diameter_rad,
        split_theta_rad: split_theta_rad(request.temperature_c),
        forward_fraction_left_out: if holds_diffraction {
            0.0
        } else {
            DIFFRACTED_FRACTION
        },
        temperature_c: request.temperature_c,
    }
}

/// The middle of Alexander's band in green light.
fn split_theta_rad(temperature_c: f64) -> f64 {
    let index = water_refractive_index(SPLIT_WAVELENGTH, temperature_c);
    let theta_rad = |p| rainbow_ray(index, p).map_or(0.75 * PI, |ray| ray.theta_rad());
    0.5 * (theta_rad(2) + theta_rad(3))
}
