//! Error against time of the theories of one drop.
//!
//! For each radius and bow two questions, both after the sun's disc, at three wavelengths:
//! against `debye`: how exactly is this order of light known? Only that order, drops of one size.
//! against `mie`: how exactly is what one sees known? All orders, sizes with an effective variance of
//! 0.01, without which the interference of the orders would be a ripple that no sky shows.

use std::time::Instant;

use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::SizeRows;
use niji_scatter::Theory;
use niji_scene::ScatteringNeed;
use serde::Serialize;

use crate::bow_curves::BowCurves;
use crate::failure::Failure;
use crate::progress;
use crate::progress::Verbosity;
use crate::stages;
use crate::timed_run::N_REPEATS;
use crate::timed_run::rounded;

/// From haze-like fog to large rain.
const RADII_UM: [f64; 5] = [10.0, 50.0, 100.0, 500.0, 1000.0];
/// Debye orders with the angles in which their bows lie for all these radii.
const BOWS: [(&str, u32, (f64, f64)); 2] = [
    ("primary", 2, (134.0, 148.0)),
    ("secondary", 3, (116.0, 133.0)),
];
/// Effective variance of the sizes that are compared with the full solution.
const EFFECTIVE_VARIANCE: f64 = 0.01;
/// Diameter of the sun's disc.
const SUN_DISC_DEG: f64 = 0.533;
/// Interpolation error of the tables, over the peak: below the errors to be measured.
const TABLE_ERROR: f64 = 1e-4;
/// Step of the angles at which theories are compared.
const STEP_DEG: f64 = 0.01;
/// The exact series for these bows has as many orders.
const MAX_ORDER: u32 = 7;

/// One theory for one radius and bow.
#[derive(Debug, Serialize)]
pub(super) struct TheoryRow {
    radius_um: f64,
    bow: &'static str,
    reference: &'static str,
    theory: &'static str,
    relative_rmse: f64,
    max_over_peak: f64,
    peak_shift_deg: f64,
    mean_color_difference: f64,
    milliseconds: f64,
    date: String,
}

/// Measures all theories.
pub(super) fn rows(date: &str, verbosity: Verbosity) -> Result<Vec<TheoryRow>, Failure> {
    let bar = progress::bar(
        "calibrate",
        2 * (RADII_UM.len() * BOWS.len()) as u64,
        verbosity,
    );
    let mut rows = Vec::new();
    for radius_um in RADII_UM {
        for (bow, order, theta_deg) in BOWS {
            let need = |theory, orders: &[u32], effective_variance| ScatteringNeed {
                theory,
                orders: orders.to_vec(),
                theta_range_rad: (theta_deg.0.to_radians(), theta_deg.1.to_radians()),
                relative_error: TABLE_ERROR,
                effective_radius_um: vec![radius_um],
                effective_variance: vec![effective_variance],
                support_um: (radius_um, radius_um),
                rows: SizeRows::Laws,
                motion: None,
                phase_functions: false,
                sun_disc_diameter_rad: f64::to_radians(SUN_DISC_DEG),
                water: Water::pure(20.0),
            };
            let debye = Theory::Debye {
                max_order: MAX_ORDER,
            };
            let all: Vec<u32> = (0..=MAX_ORDER).collect();
            let cases = [
                (
                    vec![order],
                    0.0,
                    vec![debye, Theory::Uniform, Theory::Airy, Theory::Geometric],
                ),
                (
                    all,
                    EFFECTIVE_VARIANCE,
                    vec![
                        Theory::Mie,
                        debye,
                        Theory::Uniform,
                        Theory::Airy,
                        Theory::Geometric,
                    ],
                ),
            ];
            for (orders, variance, theories) in cases {
                let mut reference: Option<(&'static str, BowCurves)> = None;
                for theory in theories {
                    let (light, milliseconds) = measured(&need(theory, &orders, variance))?;
                    let (reference_name, exact) =
                        reference.get_or_insert_with(|| (theory.name(), light.clone()));
                    let distance = light.distance(exact);
                    rows.push(TheoryRow {
                        radius_um,
                        bow,
                        reference: reference_name,
                        theory: theory.name(),
                        relative_rmse: rounded(distance.relative_rmse),
                        max_over_peak: rounded(distance.max_over_peak),
                        peak_shift_deg: rounded(distance.peak_shift_deg),
                        mean_color_difference: rounded(distance.mean_color_difference),
                        milliseconds: rounded(milliseconds),
                        date: date.to_owned(),
                    });
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// The light and the shortest of repeated times of its table.
fn measured(need: &ScatteringNeed) -> Result<(BowCurves, f64), Failure> {
    let wavelengths =
        WavelengthGrid::new(450.0, 100.0, 3).map_err(|error| Failure::Failed(error.to_string()))?;
    let mut fastest = f64::INFINITY;
    let mut light = None;
    for _ in 0..N_REPEATS {
        let start = Instant::now();
        let table = stages::scatter::computed(need, wavelengths, None, Verbosity::Quiet)?;
        fastest = fastest.min(1e3 * start.elapsed().as_secs_f64());
        let angles = BowCurves::even_angles(need.theta_range_rad, f64::to_radians(STEP_DEG));
        light = Some(BowCurves::of(&table, [0, 0], angles));
    }
    let light = light.ok_or_else(|| Failure::Failed("nothing was measured".to_owned()))?;
    Ok((light, fastest))
}
