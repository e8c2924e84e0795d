//! The choice of levels: the cheapest that keep a tolerance, or the most accurate that fit a time.
//!
//! A level errs in proportion to the light that it is about. What was measured on a calibration scene
//! is carried to another by
//! e = k L,   k = e_c / L_c
//! `e` RMSE of luminance over the picture, `L` RMS of that light as the plan bounds it, both in gray
//! cards in the sun; `c` the calibration scene. That bounds lie above the light cancels as far as scenes
//! are alike. Light of drops: theories, their tables, the integral along the ray. What the drops' shadow,
//! the air, sky and orders of scattering contribute: the levels of these. All of it, times the root of a
//! pixel's width (edges fill that share of the squares): footprints. `k` of theories and tables depends
//! on the size of drops: interpolated in the logarithm of the smallest effective radius, held beyond the
//! calibrated sizes; of a table three times the error counts, as the renderer tells it. Otherwise the
//! largest `k` of any calibration scene counts, for an adaptive integral at least the error it is
//! allowed: how much of that it uses depends on how even the drops are.
//!
//! The errors of all decisions are added up as if they had one sign, and every combination of levels is
//! weighed: of those whose sum keeps within half of the tolerance (the other half is for effects left
//! out) the fastest is chosen; of those whose stages fit a time, the most accurate. A best level counts
//! as exact. Where nothing was measured, and where the scene names a level, it stays.

use std::fmt::Write as _;

use niji_render::AirPath;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use serde::Serialize;
use thiserror::Error;

use crate::accuracy::Accuracy;
use crate::accuracy::Levels;
use crate::choice_levels::Change;
use crate::choice_levels::DECISIONS;
use crate::choice_levels::Decision;
use crate::choice_transfer::carried_error;
use crate::effect::Effect;
use crate::effect::Switch;
use crate::measured::MeasuredLevels;
use crate::plan::Plan;
use crate::plan::SHARE_FOR_EFFECTS;
use crate::plan::Stage;
use crate::scene::Scene;

/// Share of a tolerance that is for levels; the rest is for effects left out.
pub const SHARE_FOR_LEVELS: f64 = 1.0 - SHARE_FOR_EFFECTS;

/// Share of what is for levels that is kept for the rays of a pixel, which the renderer adds where its
/// estimate asks for them.
const SHARE_FOR_RAYS: f64 = 0.5;

/// So that two digits of a number are no less than it is.
const ROUNDED_UP: f64 = 1.05;

/// What the levels are chosen for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// RMSE of luminance over the picture, relative to the reference luminance, that shall be kept.
    Tolerance(f64),
    /// Seconds that the run may take.
    Budget(f64),
}

/// What a choice is made from.
#[derive(Debug, Clone, Copy)]
pub struct ChoiceRequest<'a> {
    /// The scene; levels that its section `[accuracy]` names stay.
    pub scene: &'a Scene,
    /// Its plan at its preset.
    pub plan: &'a Plan,
    /// What levels cost and how they err.
    pub measured: &'a MeasuredLevels,
    /// What is asked for.
    pub goal: Goal,
}

/// How a level came to be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// By what was measured.
    Chosen,
    /// The scene names it.
    Named,
    /// Nothing was measured: the preset's.
    Unmeasured,
}

/// The level of one decision.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChosenLevel {
    /// Key in the section `[accuracy]`.
    pub decision: &'static str,
    /// The level in words.
    pub level: String,
    /// Who chose it.
    pub origin: Origin,
    /// Predicted RMSE of luminance, relative to the reference luminance; `None` if not measured.
    pub error: Option<f64>,
}

/// Levels chosen, with what they promise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// What was asked for.
    pub goal: Goal,
    /// Every decision that concerns the scene.
    pub levels: Vec<ChosenLevel>,
    /// Sum of the predicted errors.
    pub predicted_error: f64,
    /// Predicted time of all stages, s, without rays that the renderer adds; `None` where stages were
    /// not measured.
    pub predicted_seconds: Option<f64>,
    /// What the errors of a pixel that rays can better may take of the tolerance; `None` for a budget.
    pub for_rays: Option<f64>,
    /// The section `[accuracy]` that says all this.
    #[serde(skip)]
    pub accuracy: Accuracy,
}

impl Choice {
    /// The choice for people to read, a line for each decision.
    pub fn text(&self) -> String {
        let goal = match self.goal {
            Goal::Tolerance(tolerance) => format!("tolerance {tolerance}"),
            Goal::Budget(seconds) => format!("a budget of {seconds} s"),
        };
        let mut text = format!("levels for {goal}, with their predicted errors\n");
        for level in &self.levels {
            let error = level
                .error
                .map_or_else(|| "?".to_string(), |error| format!("{error:.1e}"));
            let origin = match level.origin {
                Origin::Chosen => "",
                Origin::Named => "  named, so it stays",
                Origin::Unmeasured => "  nothing measured: as in the preset",
            };
            let _ = writeln!(
                text,
                "  {:<21} {:<38} {error:>9}{origin}",
                level.decision, level.level
            );
        }
        let seconds = self
            .predicted_seconds
            .map_or_else(|| "?".to_string(), |seconds| format!("{seconds:.2}"));
        let _ = write!(
            text,
            "  predicted: error {:.1e}, time {seconds} s",
            self.predicted_error
        );
        let _ = match self.for_rays {
            Some(share) => writeln!(
                text,
                " and rays for pixels that err by more than {share:.1e}"
            ),
            None => writeln!(text),
        };
        if let Some(warning) = self.out_of_reach() {
            let _ = writeln!(text, "  {warning}");
        }
        text
    }

    /// Says that no levels are predicted to keep the tolerance, and which tolerance they would keep;
    /// `None` where they keep it, and for a budget.
    pub fn out_of_reach(&self) -> Option<String> {
        let Goal::Tolerance(tolerance) = self.goal else {
            return None;
        };
        let (error, allowed) = (self.predicted_error, SHARE_FOR_LEVELS * tolerance);
        if error <= allowed {
            return None;
        }
        let kept = ROUNDED_UP * self.least_tolerance();
        // No larger one can be asked for.
        let kept = if kept <= 1.0 {
            format!("; they keep a tolerance of {kept:.1e}")
        } else {
            String::new()
        };
        Some(format!(
            "the tolerance {tolerance:e} is out of reach: the most accurate levels are predicted to err by \
             {error:.1e}, expected at most {allowed:.1e}, half of it{kept}"
        ))
    }

    /// The tolerance that these levels keep: what the rays of a pixel err by shrinks with it.
    fn least_tolerance(&self) -> f64 {
        let shrinks =
            |it: &ChosenLevel| it.decision == PIXEL_FOOTPRINT && it.origin == Origin::Chosen;
        let share = if self.levels.iter().any(shrinks) {
            SHARE_FOR_LEVELS * (1.0 - SHARE_FOR_RAYS)
        } else {
            SHARE_FOR_LEVELS
        };
        let fixed = self.levels.iter().filter(|it| !shrinks(it));
        fixed.filter_map(|it| it.error).sum::<f64>() / share
    }
}

/// Why nothing can be chosen.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ChoiceError {
    /// The cheapest levels take longer than allowed.
    #[error(
        "the cheapest levels take an estimated {least_seconds:.2} s, expected at most {budget_s} s: \
         allow more time, a smaller picture or fewer wavelengths"
    )]
    OverBudget {
        /// Estimated time of the cheapest levels, s.
        least_seconds: f64,
        /// The time allowed, s.
        budget_s: f64,
    },
    /// No times were measured.
    #[error(
        "the calibration holds no times of the stages of this scene: make one with niji calibrate"
    )]
    NoTimes,
}

/// A level that may be chosen.
struct Candidate {
    /// Puts it in place of the preset's; `None` for a level that is there already.
    change: Option<Change>,
    levels: Levels,
    origin: Origin,
    error: Option<f64>,
    /// Its time over that of the preset's level, by stage of the plan.
    factors: Vec<f64>,
}

/// A combination of levels, one candidate for each decision.
struct Combination {
    candidates: Vec<usize>,
    error: f64,
    seconds: f64,
}

/// Chooses levels. Pure: equal arguments give equal choices.
///
/// # Errors
/// A budget that the cheapest levels exceed, or one for stages whose times were not measured.
pub fn choose(request: &ChoiceRequest<'_>) -> Result<Choice, ChoiceError> {
    let concerned = DECISIONS
        .iter()
        .filter(|decision| decision.is_of_accuracy)
        .filter(|decision| decision.concerns(request.scene, request.plan));
    let decisions: Vec<(&Decision, Vec<Candidate>)> = concerned
        .map(|decision| (decision, candidates(decision, request)))
        .collect();
    let seconds = stage_seconds(request.plan, request.measured, &request.plan.levels);
    let combinations = combinations(&decisions, &seconds);
    let best = match request.goal {
        Goal::Tolerance(tolerance) => within_tolerance(combinations, SHARE_FOR_LEVELS * tolerance),
        Goal::Budget(_) if seconds.is_empty() => return Err(ChoiceError::NoTimes),
        Goal::Budget(budget_s) => within_budget(combinations, budget_s)?,
    };
    Ok(described(request, &decisions, &best))
}

/// Whether light that drops scatter more than once belongs into a picture that shall keep a tolerance.
/// Presets but the reference leave it out unasked; here it counts like every other effect, by the RMS of
/// its bound over the picture.
pub fn calls_for_multiple_scattering(scene: &Scene, plan: &Plan, tolerance: f64) -> bool {
    let effect = Effect::MultipleScattering;
    let mut needs = effect.needs().iter();
    let is_open = scene.effects.of(effect) == Switch::Auto
        && needs.all(|needed| scene.effects.of(*needed) != Switch::Off);
    let missed = plan.bound(effect).map_or(0.0, |bound| bound.rms);
    is_open && !plan.is_on(effect) && missed > SHARE_FOR_EFFECTS * tolerance
}

/// The levels of a decision that may be chosen.
fn candidates(decision: &Decision, request: &ChoiceRequest<'_>) -> Vec<Candidate> {
    let base = request.scene.accuracy;
    let voxel_m = request.plan.work.voxel_m;
    let candidate = |change: Option<Change>, origin: Origin| {
        let mut accuracy = base;
        if let Some(change) = change {
            change(&mut accuracy, voxel_m);
        }
        let levels = accuracy.levels(voxel_m);
        Candidate {
            change,
            levels,
            origin,
            error: carried_error(decision, &levels, request.plan, request.measured),
            factors: factors(request, &levels),
        }
    };
    if (decision.is_named)(&base) {
        return vec![candidate(None, Origin::Named)];
    }
    let changes = decision.levels_for(request.plan).into_iter();
    let mut found: Vec<Candidate> = changes
        .map(|change| candidate(Some(change), Origin::Chosen))
        .filter(|candidate| candidate.error.is_some())
        .collect();
    if decision.key == THEORY {
        keep_orders_apart(request.scene, &mut found);
    }
    if decision.key == AIR_PATH && request.plan.is_on(Effect::Sky) {
        // Its error is measured as that of the air in front of drops; a sky has no end of it.
        found.retain(|it| it.levels.air_path != AirPath::Constant);
    }
    if let Goal::Tolerance(tolerance) = request.goal {
        let share = SHARE_FOR_LEVELS * SHARE_FOR_RAYS * tolerance;
        leave_to_the_rays(decision, &mut found, share);
    }
    if found.is_empty() {
        found.push(candidate(None, Origin::Unmeasured));
    }
    found
}

/// The decision between theories.
const THEORY: &str = "theory";

/// The decision between ways to find the air's optical depths.
const AIR_PATH: &str = "air_path";

/// The exact theory of a scene: Lorenz-Mie, or, because that holds all orders at once, the Debye series
/// where the scene leaves one of them out.
pub fn exact_theory(scene: &Scene) -> Theory {
    let orders = [
        Effect::PrimaryBow,
        Effect::SecondaryBow,
        Effect::HigherOrders,
    ];
    let is_off = |order: &Effect| scene.effects.of(*order) == Switch::Off;
    if orders.iter().any(is_off) {
        Theory::Debye { max_order: 7 }
    } else {
        Theory::Mie
    }
}

/// Leaves Lorenz-Mie out where its light is not the scene's; the theory that is exact then errs by
/// nothing.
fn keep_orders_apart(scene: &Scene, candidates: &mut Vec<Candidate>) {
    let exact = exact_theory(scene);
    candidates.retain(|it| it.levels.theory != Theory::Mie || exact == Theory::Mie);
    for candidate in candidates {
        if candidate.levels.theory == exact {
            candidate.error = Some(0.0);
        }
    }
}

/// With a tolerance the renderer gives the pixels that miss it more rays, so that no picture needs them
/// everywhere: of the footprints those of one ray are candidates, and the best of them errs by no more
/// than the rays' share.
fn leave_to_the_rays(decision: &Decision, candidates: &mut Vec<Candidate>, share: f64) {
    if decision.key != PIXEL_FOOTPRINT {
        return;
    }
    candidates.retain(|candidate| is_one_ray(candidate.levels.pixel_footprint));
    if let Some(error) = candidates.last_mut().and_then(|best| best.error.as_mut()) {
        *error = error.min(share);
    }
}

/// The decision of which the renderer does the rest by itself.
const PIXEL_FOOTPRINT: &str = "pixel_footprint";

fn is_one_ray(footprint: PixelFootprint) -> bool {
    match footprint {
        PixelFootprint::Center | PixelFootprint::Prefiltered => true,
        PixelFootprint::Grid { .. } => false,
    }
}

/// Times of the stages at some levels, in the order of the plan, s; empty if any was not measured.
fn stage_seconds(plan: &Plan, measured: &MeasuredLevels, levels: &Levels) -> Vec<f64> {
    let seconds = |stage: Stage| plan.work.seconds(stage, levels, measured);
    let stages = plan.stages.iter().map(|planned| planned.stage);
    stages
        .filter(|stage| TIMED.contains(stage))
        .map(seconds)
        .collect::<Option<Vec<f64>>>()
        .unwrap_or_default()
}

/// The stages whose time depends on levels or on the size of the scene.
const TIMED: [Stage; 5] = [
    Stage::Drops,
    Stage::Airy,
    Stage::Scatter,
    Stage::Atmosphere,
    Stage::Render,
];

/// Time of the stages at some levels over that at the plan's.
fn factors(request: &ChoiceRequest<'_>, levels: &Levels) -> Vec<f64> {
    let times = |levels: &Levels| stage_seconds(request.plan, request.measured, levels);
    let (changed, base) = (times(levels), times(&request.plan.levels));
    let ratio = |(changed, base): (&f64, &f64)| changed / base.max(f64::MIN_POSITIVE);
    changed.iter().zip(&base).map(ratio).collect()
}

/// Every combination of candidates.
fn combinations(decisions: &[(&Decision, Vec<Candidate>)], seconds: &[f64]) -> Vec<Combination> {
    let n_combinations = decisions.iter().map(|(_, levels)| levels.len()).product();
    let mut found = Vec::with_capacity(n_combinations);
    for number in 0..n_combinations {
        let mut rest = number;
        let (mut candidates, mut error) = (Vec::with_capacity(decisions.len()), 0.0);
        let mut seconds = seconds.to_vec();
        for (_, levels) in decisions {
            let index = rest % levels.len();
            rest /= levels.len();
            candidates.push(index);
            error += levels[index].error.unwrap_or(0.0);
            for (seconds, factor) in seconds.iter_mut().zip(&levels[index].factors) {
                *seconds *= factor;
            }
        }
        found.push(Combination {
            candidates,
            error,
            seconds: seconds.iter().sum(),
        });
    }
    found
}

/// The fastest that keeps to an error; if none does, the most accurate.
fn within_tolerance(combinations: Vec<Combination>, allowed: f64) -> Combination {
    let keeps = |combination: &Combination| combination.error <= allowed;
    let order = |a: &Combination, b: &Combination| match (keeps(a), keeps(b)) {
        (true, true) => (a.seconds, a.error).partial_cmp(&(b.seconds, b.error)),
        (true, false) => Some(std::cmp::Ordering::Less),
        (false, true) => Some(std::cmp::Ordering::Greater),
        (false, false) => (a.error, a.seconds).partial_cmp(&(b.error, b.seconds)),
    };
    first(combinations, order)
}

/// The most accurate that fits a time.
fn within_budget(
    combinations: Vec<Combination>,
    budget_s: f64,
) -> Result<Combination, ChoiceError> {
    let times = combinations.iter().map(|combination| combination.seconds);
    let least_seconds = times.fold(f64::INFINITY, f64::min);
    if least_seconds > budget_s {
        return Err(ChoiceError::OverBudget {
            least_seconds,
            budget_s,
        });
    }
    let fitting = combinations.into_iter().filter(|it| it.seconds <= budget_s);
    Ok(first(fitting.collect(), |a, b| {
        (a.error, a.seconds).partial_cmp(&(b.error, b.seconds))
    }))
}

/// The first in an order, of equals that which comes first; no levels at all where there is nothing to
/// choose from.
fn first(
    combinations: Vec<Combination>,
    order: impl Fn(&Combination, &Combination) -> Option<std::cmp::Ordering>,
) -> Combination {
    let order = |a: &Combination, b: &Combination| order(a, b).unwrap_or(std::cmp::Ordering::Equal);
    let nothing = Combination {
        candidates: Vec::new(),
        error: 0.0,
        seconds: 0.0,
    };
    combinations.into_iter().min_by(order).unwrap_or(nothing)
}

fn described(
    request: &ChoiceRequest<'_>,
    decisions: &[(&Decision, Vec<Candidate>)],
    best: &Combination,
) -> Choice {
    let voxel_m = request.plan.work.voxel_m;
    let mut accuracy = request.scene.accuracy;
    let mut levels = Vec::with_capacity(decisions.len());
    for ((decision, candidates), index) in decisions.iter().zip(&best.candidates) {
        let candidate = &candidates[*index];
        if let Some(change) = candidate.change {
            change(&mut accuracy, voxel_m);
        }
        levels.push(ChosenLevel {
            decision: decision.key,
            level: decision.level_of(&candidate.levels),
            origin: candidate.origin,
            error: candidate.error,
        });
    }
    let has_times = !stage_seconds(request.plan, request.measured, &request.plan.levels).is_empty();
    Choice {
        goal: request.goal,
        predicted_error: best.error,
        predicted_seconds: has_times.then_some(best.seconds),
        for_rays: match request.goal {
            Goal::Tolerance(tolerance) => Some(for_rays(&levels, SHARE_FOR_LEVELS * tolerance)),
            Goal::Budget(_) => None,
        },
        levels,
        accuracy,
    }
}

/// What the other errors leave of what is for levels, and the rays' share at least.
fn for_rays(levels: &[ChosenLevel], allowed: f64) -> f64 {
    let others = levels
        .iter()
        .filter(|level| level.decision != PIXEL_FOOTPRINT);
    let taken: f64 = others.filter_map(|level| level.error).sum();
    (allowed - taken).max(SHARE_FOR_RAYS * allowed)
}
