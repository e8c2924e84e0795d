//! The scattering angles of a table: as few as linear interpolation to a tolerance allows.
//!
//! Judged on every wavelength, because each has its bow elsewhere, on the smallest, the largest and
//! some radii between, and on the narrowest and the broadest law, by Airy's theory (rays alone for rays
//! alone) after the sun's disc.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use niji_airy::AiryForm;
use rayon::prelude::*;

use crate::axes::needed_nodes;
use crate::bow_light::BowTheory;
use crate::bow_rows::BowRows;
use crate::bow_rows::SizeRow;
use crate::error::Error;
use crate::request::TableRequest;
use crate::theory::Theory;

/// Candidates at most.
const MOST_ANGLES: usize = 40_000;
/// Radii that are judged, at most.
const N_RADII: usize = 7;
/// Without a disc: how far inside the primary bow fringes are resolved, 12 degrees.
const RESOLVED_RAD: f64 = 12.0 * PI / 180.0;

/// The angles of the table.
pub(crate) fn theta_axis(request: &TableRequest) -> Result<Vec<f64>, Error> {
    let candidates = candidates(request);
    let probe = probe(request);
    let rows = BowRows::new(&probe, bow_theory(probe.theory), &candidates)?;
    let sizes = rows.size_rows();
    let curves: Vec<Vec<Vec<f64>>> = (0..request.wavelengths.len())
        .into_par_iter()
        .map(|index| {
            let natural = |size: &SizeRow| {
                let row = rows.row(index, size);
                row.iter().map(|[s, p]| 0.5 * (s + p)).collect()
            };
            sizes.iter().map(natural).collect()
        })
        .collect();
    let curves: Vec<Vec<f64>> = curves.into_iter().flatten().collect();
    let kept = needed_nodes(&candidates, &curves, request.theta_tolerance);
    Ok(kept.into_iter().map(|index| candidates[index]).collect())
}

/// Even angles, close enough that linear interpolation between neighbours keeps the tolerance.
fn candidates(request: &TableRequest) -> Vec<f64> {
    let radius_rad = 0.5 * request.sun_disc_diameter_rad;
    let root = request.theta_tolerance.sqrt();
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
    (0..=n_steps)
        .map(|index| (low + (high - low) * index as f64 / n_steps as f64).min(high))
        .collect()
}

/// Narrowest fringe of the largest drop: of phase (4/3) ζ^(3/2), ζ = (x²/h)^(1/3) d with h near 5.
fn fringe_period_rad(request: &TableRequest) -> f64 {
    let largest_um = request.effective_radius_um.last().copied().unwrap_or(1.0);
    let x = TAU * 1e3 * largest_um / request.wavelengths.center(0).0;
    PI / (x * (RESOLVED_RAD / 5.0).sqrt())
}

/// The request with the few sizes that are judged.
fn probe<'a>(request: &TableRequest<'a>) -> TableRequest<'a> {
    let theory = match request.theory {
        Theory::GeometricPublished | Theory::Geometric => Theory::Geometric,
        Theory::AiryPublished
        | Theory::Airy
        | Theory::Uniform
        | Theory::Debye { .. }
        | Theory::Mie => Theory::Airy,
    };
    let orders = if request.orders.is_empty() {
        vec![2, 3]
    } else {
        request.orders.clone()
    };
    TableRequest {
        theory,
        orders,
        effective_radius_um: some_of(&request.effective_radius_um, N_RADII),
        effective_variance: some_of(&request.effective_variance, 2),
        ..request.clone()
    }
}

/// At most `n` values, the ends among them.
fn some_of(values: &[f64], n: usize) -> Vec<f64> {
    let last = values.len() - 1;
    let mut indices: Vec<usize> = (0..n).map(|index| index * last / (n - 1)).collect();
    indices.dedup();
    indices.into_iter().map(|index| values[index]).collect()
}

/// The bows of a theory; the exact theories have those of Airy's.
fn bow_theory(theory: Theory) -> BowTheory {
    match theory {
        Theory::GeometricPublished | Theory::Geometric => BowTheory::Geometric,
        Theory::AiryPublished
        | Theory::Airy
        | Theory::Uniform
        | Theory::Debye { .. }
        | Theory::Mie => BowTheory::Airy(AiryForm::Absolute),
    }
}
