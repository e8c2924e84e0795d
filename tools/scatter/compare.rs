//! `niji scatter --compare`: which theory is good enough for drops of one size.

use std::time::Instant;

use niji_scatter::Theory;
use serde::Serialize;

use super::ScatterCommand;
use super::of_flags;
use super::plot;
use crate::bow_curves::BowCurves;
use crate::failure::Failure;
use crate::flags::Common;
use crate::output;
use crate::stages;

/// Angles between which bows are compared unless others are asked for.
const BOW_ANGLES_DEG: &str = "120,160";
/// All orders there are: the exact solution has them too.
const ALL_ORDERS: &str = "0,1,2,3,4,5,6,7";
/// Step of the angles at which theories are compared.
const STEP_DEG: f64 = 0.02;
/// CIEDE2000 from which on a difference is seen side by side, and at a glance.
const SEEN: f64 = 1.0;
const STRIKING: f64 = 5.0;

/// One theory against the reference.
#[derive(Debug, Serialize)]
struct Row {
    theory: &'static str,
    relative_rmse: f64,
    max_over_peak: f64,
    mean_color_difference: f64,
    max_color_difference: f64,
    peak_shift_deg: f64,
    seconds: f64,
}

pub(super) fn execute(command: &ScatterCommand, common: &Common) -> Result<(), Failure> {
    let mut names = command.compare.clone();
    // From the cheapest to the exact one, as the enum lists them.
    names.sort_by_key(|name| *name as u8);
    names.dedup();
    if names.len() < 2 {
        return Err(Failure::Usage(
            "--compare needs two theories or more, as airy,uniform,mie".to_owned(),
        ));
    }
    let flags = ScatterCommand {
        orders: Some(
            command
                .orders
                .clone()
                .unwrap_or_else(|| ALL_ORDERS.to_owned()),
        ),
        theta_deg: Some(
            command
                .theta_deg
                .clone()
                .unwrap_or_else(|| BOW_ANGLES_DEG.to_owned()),
        ),
        ..command.clone()
    };
    let (mut need, wavelengths) = of_flags(&flags)?;
    if need.effective_radius_um.len() * need.effective_variance.len() > 1 {
        return Err(Failure::Usage(
            "--compare takes one --effective-radius-um and one --effective-variance".to_owned(),
        ));
    }
    let angles = BowCurves::even_angles(need.theta_range_rad, STEP_DEG.to_radians());
    let mut light = Vec::new();
    let mut seconds = Vec::new();
    for name in names {
        need.theory = Theory::from(name);
        let start = Instant::now();
        let airy = command.airy.as_deref();
        let table = stages::scatter::computed(&need, wavelengths, airy, common.verbosity())?;
        seconds.push(start.elapsed().as_secs_f64());
        let curves = BowCurves::of(&table, [0, 0], angles.clone());
        light.push((need.theory.name().to_owned(), need.theory.name(), curves));
    }
    let Some((_, reference_name, reference)) = light.last() else {
        return Ok(());
    };
    let rows: Vec<Row> = light
        .iter()
        .zip(&seconds)
        .map(|((_, theory, curves), &seconds)| {
            let distance = curves.distance(reference);
            Row {
                theory,
                relative_rmse: distance.relative_rmse,
                max_over_peak: distance.max_over_peak,
                mean_color_difference: distance.mean_color_difference,
                max_color_difference: distance.max_color_difference,
                peak_shift_deg: distance.peak_shift_deg,
                seconds,
            }
        })
        .collect();
    print(&rows, common)?;
    for row in &rows[..rows.len() - 1] {
        common.verbosity().say(verdict(row, reference_name));
    }
    match &command.plot {
        Some(path) => {
            let title = format!(
                "effective radius {} µm, effective variance {}",
                need.effective_radius_um[0], need.effective_variance[0]
            );
            let curves: Vec<(String, BowCurves)> = light
                .into_iter()
                .map(|(label, _, curves)| (label, curves))
                .collect();
            plot::of_theories(title, &curves).write_svg(path)
        }
        None => Ok(()),
    }
}

fn print(rows: &[Row], common: &Common) -> Result<(), Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::Failed(error.to_string());
    if common.json {
        let json = serde_json::to_string_pretty(rows).map_err(|error| failed(&error))?;
        return output::print(&(json + "\n"));
    }
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.serialize(row).map_err(|error| failed(&error))?;
    }
    let csv = csv.into_inner().map_err(|error| failed(&error))?;
    output::print(&String::from_utf8_lossy(&csv))
}

/// One line for people.
fn verdict(row: &Row, reference: &str) -> String {
    let seen = if row.max_color_difference < SEEN {
        "nobody sees the difference"
    } else if row.mean_color_difference < SEEN {
        "seen in places, side by side"
    } else if row.mean_color_difference < STRIKING {
        "seen side by side"
    } else {
        "seen at a glance"
    };
    format!(
        "{}: {:.1} % from {reference} in spectra, color difference {:.1} (at most {:.1}): {seen}",
        row.theory,
        100.0 * row.relative_rmse,
        row.mean_color_difference,
        row.max_color_difference
    )
}
