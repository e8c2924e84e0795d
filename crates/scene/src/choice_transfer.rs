//! What an error that was measured on one scene is on another.
//!
//! e = k L,   k = e_c / L_c   (see [`crate::choose`])

use niji_render::Integration;

use crate::accuracy::Levels;
use crate::choice_levels::Decision;
use crate::choice_levels::LIGHT_OF_DROPS;
use crate::effect::Effect;
use crate::measured::MeasuredLevel;
use crate::measured::MeasuredLevels;
use crate::plan::BoundKind;
use crate::plan::Plan;

/// Decisions whose error depends on the size of the drops.
const BY_SIZE: [&str; 2] = ["theory", TABLE];
/// The decision between tables.
const TABLE: &str = "table_relative_error";
/// Times a table's error that the renderer's estimate tells, where rows bend evenly between two angles: it
/// is the estimate that has to keep a tolerance.
const TOLD_OVER_TABLE: f64 = 3.0;
/// The decision whose level may be a tolerance.
const INTEGRATION: &str = "integration";
/// The decision whose error depends on the width of a pixel.
const BY_PIXEL: &str = "pixel_footprint";

/// Ratios below it are as good as none, and have a logarithm.
const LEAST_RATIO: f64 = 1e-12;

/// RMS over the picture of the light that a decision is about, as a plan bounds it, in gray cards in
/// the sun; for footprints times the root of a pixel's width in degrees.
pub fn light_of(decision: &Decision, plan: &Plan) -> f64 {
    let on = decision.about.iter().filter(|effect| plan.is_on(**effect));
    let rms = on.filter_map(|effect| light_rms(*effect, plan));
    let light = rms.fold(0.0, |sum, rms| sum + rms * rms).sqrt();
    if decision.key == BY_PIXEL {
        light * plan.work.pixel_deg.sqrt()
    } else {
        light
    }
}

/// RMS of an effect's light. To leave out an order that the table holds in any case, with all others,
/// changes no more than the table errs: that share of the light of all orders is its bound.
fn light_rms(effect: Effect, plan: &Plan) -> Option<f64> {
    let bound = plan.bound(effect)?;
    let is_in_any_case =
        LIGHT_OF_DROPS.contains(&effect) && bound.kind == BoundKind::TableDifference;
    let share = if is_in_any_case {
        plan.levels.table_relative_error
    } else {
        1.0
    };
    Some(bound.rms / share)
}

/// RMSE of luminance that a level costs, in gray cards in the sun; `None` where it was not measured.
pub(crate) fn carried_error(
    decision: &Decision,
    levels: &Levels,
    plan: &Plan,
    measured: &MeasuredLevels,
) -> Option<f64> {
    let name = decision.measured_name(levels, plan.work.voxel_m);
    let ratio = |row: &MeasuredLevel| {
        let light = row.light.filter(|light| *light > 0.0)?;
        Some((row.radius_um?, row.luminance_error? / light))
    };
    let ratios: Vec<(f64, f64)> = measured
        .of_level(decision.key, &name)
        .filter_map(ratio)
        .collect();
    let ratio = if BY_SIZE.contains(&decision.key) {
        let told = if decision.key == TABLE {
            TOLD_OVER_TABLE
        } else {
            1.0
        };
        carried(&ratios, plan.work.smallest_radius_um).map(|ratio| told * ratio)
    } else {
        let worst = ratios.iter().map(|(_, ratio)| *ratio).reduce(f64::max);
        worst.map(|ratio| ratio.max(allowed_error(decision, levels)))
    };
    Some(ratio? * light_of(decision, plan))
}

/// What an adaptive integral may err by, however even the drops were on which it was measured.
fn allowed_error(decision: &Decision, levels: &Levels) -> f64 {
    match levels.integration {
        Integration::Adaptive { relative_error } if decision.key == INTEGRATION => relative_error,
        Integration::Adaptive { .. } | Integration::CellExact | Integration::FixedStep { .. } => {
            0.0
        }
    }
}

/// The ratio at a place between those where it was measured: linear in the logarithms of both, constant
/// beyond the outermost, of several at one place the largest. `None` where nothing was measured.
pub(crate) fn carried(measured: &[(f64, f64)], place: f64) -> Option<f64> {
    let mut points = measured.to_vec();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    points.dedup_by(|after, before| after.0 <= before.0 * SAME_PLACE);
    let above = points.partition_point(|point| point.0 < place);
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return None;
    };
    if above == 0 {
        return Some(first.1);
    }
    let Some(high) = points.get(above) else {
        return Some(last.1);
    };
    let low = points[above - 1];
    let part = (place / low.0).ln() / (high.0 / low.0).ln();
    if low.1.max(high.1) <= LEAST_RATIO {
        return Some(low.1.max(high.1));
    }
    let [a, b] = [low.1, high.1].map(|ratio| ratio.max(LEAST_RATIO).ln());
    Some((a + part * (b - a)).exp())
}

/// Places nearer than one percent are one.
const SAME_PLACE: f64 = 1.01;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_between_two_sizes_are_their_geometric_mean() {
        let measured = [(1000.0, 0.01), (10.0, 1.0)];
        let at = |place| carried(&measured, place).unwrap();
        assert!((at(100.0) - 0.1).abs() < 1e-12);
        assert_eq!((at(1.0), at(1e5)), (1.0, 0.01));
        assert_eq!(carried(&[], 100.0), None);
    }

    #[test]
    fn of_two_measurements_at_one_size_the_worse_counts() {
        let measured = [(100.0, 0.1), (100.0, 0.3), (200.0, 0.3)];
        assert!((carried(&measured, 100.0).unwrap() - 0.3).abs() < 1e-12);
        assert!((carried(&measured, 150.0).unwrap() - 0.3).abs() < 1e-12);
    }
}
