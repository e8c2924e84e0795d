//! The table at the end of a run: what each level of accuracy costs, and what its neighbors would.

use niji_scene::MeasuredLevel;
use niji_scene::Plan;
use niji_scene::Stage;

use crate::scene_file::Planned;
use crate::stages::Done;
use crate::stages::accuracy::Reached;

/// Decisions that cost nothing in a vacuum.
const AIR_KEYS: [&str; 2] = ["air_path", "sky"];

/// Prints times of stages, levels with their price, the effects that are off, and how accurate the
/// picture is.
pub(super) fn print(planned: &Planned, done: &[Done], reached: Option<&Reached>) {
    eprintln!("\n{:<11} {:>9}", "stage", "time");
    for stage in done {
        let note = if stage.up_to_date { "  up to date" } else { "" };
        eprintln!("{:<11} {:>7.2} s{note}", stage.stage, stage.seconds);
    }
    print_levels(planned);
    print_effects_off(&planned.plan);
    if let Some(choice) = &planned.choice {
        eprint!("{}", choice.text());
    }
    if let Some(reached) = reached {
        eprintln!("{}", reached.text());
    }
}

/// The levels, each with its neighbors in cost.
fn print_levels(planned: &Planned) {
    let (plan, measured) = (&planned.plan, &planned.measured);
    eprintln!(
        "\n{:<21} {:<34} {:>9} {:>7}  {:<40} next dearer",
        "accuracy", "level", "error", "time", "next cheaper"
    );
    let in_air = plan.runs(Stage::Atmosphere);
    let kept = plan.levels.measured_names(plan.work.voxel_m);
    for ((key, level), (_, kept)) in plan.levels.named().into_iter().zip(kept) {
        if !in_air && AIR_KEYS.contains(&key.as_str()) {
            continue;
        }
        let here = measured.find(&key, &kept, &plan.scene);
        let cheaper = measured.next_cheaper(&key, &kept, &plan.scene);
        let dearer = measured.next_dearer(&key, &kept, &plan.scene);
        eprintln!(
            "{key:<21} {level:<34} {:>9} {:>7}  {:<40} {}",
            error(here),
            time(here),
            neighbor(cheaper),
            neighbor(dearer)
        );
    }
    eprintln!(
        "error: relative RMSE of radiance against the best level of that row, or a finer one, on the \
         calibration scene; time: over the standard level; ? not measured (niji calibrate)"
    );
}

fn print_effects_off(plan: &Plan) {
    let off: Vec<String> = plan
        .effects
        .iter()
        .filter(|decision| !decision.on)
        .map(|decision| {
            let bound = decision.bound;
            let kind = bound.kind.name();
            format!("{} (<= {:.1e} {kind})", decision.effect, bound.value)
        })
        .collect();
    let off = if off.is_empty() {
        "nothing".to_owned()
    } else {
        off.join(", ")
    };
    eprintln!("off: {off}");
}

fn error(level: Option<&MeasuredLevel>) -> String {
    let error = level.and_then(|level| level.error);
    error.map_or_else(|| "?".to_owned(), |error| format!("{error:.1e}"))
}

fn time(level: Option<&MeasuredLevel>) -> String {
    let time = level.and_then(|level| level.relative_time);
    time.map_or_else(|| "?".to_owned(), |time| format!("x {time:.2}"))
}

fn neighbor(level: Option<&MeasuredLevel>) -> String {
    let Some(found) = level else {
        return "-".to_owned();
    };
    format!("{}: {}, {}", found.level, error(level), time(level))
}
