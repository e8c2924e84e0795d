//! `niji plan --measure`: what every effect of a scene changes, beside its bound.
//!
//! The picture is made small, with the same field of view and one ray through the middle of each
//! pixel and a few wide bins of wavelengths: once with the effects of the plan, then once for every
//! effect with that one forced on where it was off, and off where it was on. The change is the largest
//! of |Y - Y'| over all pixels in parts of the plan's display white, which is what a bound
//! bounds. Tables that an effect does not touch are made once; a change of time is that of the stages
//! that had to be run again. Bounds do not hold the errors of tables, so that tables are as fine as
//! their number of rows allows: changes below their error times the peak of the bow are those errors.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use niji_exchange::luminance;
use niji_render::PixelFootprint;
use niji_scene::Bound;
use niji_scene::Effect;
use niji_scene::EffectDecision;
use niji_scene::Occluders;
use niji_scene::Plan;
use niji_scene::ScatteringNeed;
use niji_scene::Scene;
use niji_scene::Switch;
use serde::Serialize;

use crate::failure::Failure;
use crate::progress;
use crate::progress::Verbosity;
use crate::stages;
use crate::stages::Done;
use crate::stages::seconds_of;
use crate::timed_run::rounded;
use crate::timed_run::run_once;
use crate::timed_run::temporary_folder;
use niji_picture::PlannedScene;

/// Pixels across the small picture.
const WIDTH_PX: u32 = 96;

/// Wavelengths of the small picture, at most.
const N_WAVELENGTHS: usize = 10;

/// Error of the tables where these have up to so many rows.
const FINE_TABLE: (f64, usize) = (5e-4, 4);

/// Error of the tables where these have more rows than that.
const COARSE_TABLE: (f64, usize) = (0.05, 400);

/// Wavelengths at most of the tables of round and flat drops that are compared, which are coarse in any
/// case: rows of flat drops of many sizes are thousands.
const N_WAVELENGTHS_FLAT: usize = 4;

/// Tables that pictures of one scene share where they need the same.
const SHARED: [&str; 4] = [
    stages::drops::FILE,
    stages::airy::FILE,
    stages::scatter::FILE,
    stages::atmosphere::FILE,
];

/// What the effects of a scene were measured to change.
#[derive(Debug, Serialize)]
pub(crate) struct MeasuredEffects {
    scene: String,
    width_px: u32,
    height_px: u32,
    /// Time of the small picture with the effects of the plan and of its tables (s).
    seconds: f64,
    effects: Vec<MeasuredEffect>,
}

/// A line of the table of all scenes.
#[derive(Debug, Serialize)]
pub(crate) struct EffectRow {
    scene: String,
    effect: Effect,
    /// `on` or `off`.
    decision: &'static str,
    bound: f64,
    /// `proved`, `estimated` or `table difference`.
    kind: &'static str,
    /// Change when the effect is switched over.
    measured: f64,
    /// The bound over it; `None` where nothing changes.
    ratio: Option<f64>,
    rms_bound: f64,
    rms_measured: f64,
    /// Time that the effect takes in the small picture, or would take (s).
    seconds: f64,
    date: String,
}

/// One effect, switched over.
#[derive(Debug, Serialize)]
struct MeasuredEffect {
    effect: Effect,
    /// Whether the plan has it.
    on: bool,
    bound: Bound,
    /// `None` where it cannot be switched over.
    measured: Option<Measured>,
}

/// What switching an effect over does.
#[derive(Debug, Clone, Copy, Serialize)]
struct Measured {
    /// Largest change of luminance over display white.
    change: f64,
    /// RMS of that change over the picture.
    rms: f64,
    /// Time that the effect takes (s): what is spent where it is forced on, saved where it is off.
    seconds: f64,
}

/// Measures every effect of a scene that was planned.
///
/// # Errors
/// Whatever a stage reports.
pub(crate) fn measure(
    planned: &PlannedScene,
    verbosity: Verbosity,
) -> Result<MeasuredEffects, Failure> {
    let small = small(&planned.scene, &planned.plan);
    let folder = temporary_folder()?;
    let bar = progress::bar("measure", 1 + Effect::ALL.len() as u64, verbosity);
    let base = Run::of(&planned.replanned(small.clone())?, folder.path())?;
    bar.inc(1);
    let mut effects = Vec::new();
    for decision in &planned.plan.effects {
        let EffectDecision {
            effect, on, bound, ..
        } = *decision;
        let other_base = other_base(&small, decision);
        let scene = other_base.as_ref().unwrap_or(&small);
        let measured = match (planned.plan.switched(scene, effect), &other_base) {
            (None, _) => None,
            (Some(switched), None) => Some(base.measured(&switched, planned, on)?),
            (Some(switched), Some(scene)) => {
                let folder = temporary_folder()?;
                let base = Run::of(&planned.replanned(scene.clone())?, folder.path())?;
                Some(base.measured(&switched, planned, on)?)
            }
        };
        effects.push(MeasuredEffect {
            effect,
            on,
            bound,
            measured,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(MeasuredEffects {
        scene: small.name,
        width_px: small.camera.width_px,
        height_px: small.camera.height_px,
        seconds: seconds_of(&base.done),
        effects,
    })
}

/// The scene in a small picture of few wavelengths and without a photograph, with the effects of a plan
/// spelt out, and its theory: that by size depends on the error of tables, which is another here.
fn small(scene: &Scene, plan: &Plan) -> Scene {
    let mut small = plan.settled(scene);
    small.camera = small.camera.no_wider_than(WIDTH_PX);
    small.spectrum = small.spectrum.in_wider_bins(N_WAVELENGTHS);
    small.accuracy.pixel_footprint = Some(PixelFootprint::Center);
    small.accuracy.theory = Some(plan.levels.theory);
    let ((fine, few), (coarse, many)) = (FINE_TABLE, COARSE_TABLE);
    let (n_rows, own) = (
        plan.scattering.as_ref().map_or(0, ScatteringNeed::n_rows),
        plan.levels.table_relative_error,
    );
    small.accuracy.table_relative_error = Some(match n_rows {
        n if n <= few => own.min(fine),
        n if n <= many => own,
        _ => own.max(coarse),
    });
    // Distances are given by pixel, and hide drops: without them as much is seen, or more.
    small.photo = None;
    if let Some(occluders) = &mut small.occluders {
        occluders.depth = None;
    }
    let has_meshes = |occluders: &Occluders| !occluders.meshes.is_empty();
    small.occluders = small.occluders.filter(has_meshes);
    small
}

/// The scene that an effect is compared with where it is not that of the plan: with all that the effect
/// cannot do without, whose own change is not the effect's, and with tables that are coarse enough for
/// flat drops of many sizes where these change more than coarse tables do.
fn other_base(scene: &Scene, decision: &EffectDecision) -> Option<Scene> {
    let mut base = scene.clone();
    for needed in decision.effect.needs() {
        base.effects.set(*needed, Switch::On);
    }
    let (coarse, _) = COARSE_TABLE;
    if decision.effect == Effect::DropFlattening && decision.bound.value > coarse {
        let levels = base.levels(1.0);
        base.accuracy.table_relative_error = Some(levels.table_relative_error.max(coarse));
        base.spectrum = base.spectrum.in_wider_bins(N_WAVELENGTHS_FLAT);
    }
    (base != *scene).then_some(base)
}

/// A small picture and its tables.
struct Run<'a> {
    folder: &'a Path,
    done: Vec<Done>,
    /// Luminance of every pixel (cd/m²).
    luminance: Vec<f64>,
}

impl<'a> Run<'a> {
    /// Runs a scene in a folder whose tables are kept where they fit.
    fn of(planned: &PlannedScene, folder: &'a Path) -> Result<Self, Failure> {
        let (done, image) = run_once(planned, folder)?;
        Ok(Self {
            folder,
            done,
            luminance: luminance(&image.radiance, &image.wavelengths)
                .into_iter()
                .collect(),
        })
    }

    /// What another scene changes, made with the tables of this one where they fit.
    fn measured(
        &self,
        scene: &Scene,
        planned: &PlannedScene,
        was_on: bool,
    ) -> Result<Measured, Failure> {
        let failed = |error: std::io::Error| Failure::Failed(error.to_string());
        let folder = temporary_folder()?;
        for name in SHARED {
            let (from, to) = (self.folder.join(name), folder.path().join(name));
            if from.exists() {
                fs::copy(from, to).map_err(failed)?;
            }
        }
        let other = Run::of(&planned.replanned(scene.clone())?, folder.path())?;
        let seconds = other.seconds_with(&self.done) - self.seconds_with(&[]);
        let reference = planned.plan.display_white_cd_m2;
        let pairs = self.luminance.iter().zip(&other.luminance);
        let changes = pairs.map(|(one, other)| (one - other).abs() / reference);
        let (change, squares) = changes.fold((0.0_f64, 0.0), |(largest, squares), change| {
            (largest.max(change), squares + change * change)
        });
        Ok(Measured {
            change,
            rms: (squares / self.luminance.len().max(1) as f64).sqrt(),
            seconds: if was_on { -seconds } else { seconds },
        })
    }

    /// Time of all stages from nothing; what was up to date counts as it did when it was made.
    fn seconds_with(&self, made: &[Done]) -> f64 {
        let seconds = |done: &Done| {
            let first = made.iter().find(|first| first.stage == done.stage);
            match first {
                Some(first) if done.up_to_date => first.seconds,
                Some(_) | None => done.seconds,
            }
        };
        self.done.iter().map(seconds).sum()
    }
}

impl MeasuredEffects {
    /// Lines of the table of all scenes, for the effects that can be switched over.
    pub(crate) fn rows(&self, date: &str) -> Vec<EffectRow> {
        let rows = self.effects.iter();
        rows.filter_map(|effect| effect.row(&self.scene, date))
            .collect()
    }

    /// A table for people to read.
    pub(crate) fn text(&self) -> String {
        let mut text = format!(
            "{}: {} x {} pixels, center rays, {:.2} s with all tables\n\
             changes over display white; time is what the effect takes\n\n\
             {:<21} {:<4} {:>8}  {:<16} {:>9} {:>8} {:>9} {:>9} {:>8}\n",
            self.scene,
            self.width_px,
            self.height_px,
            self.seconds,
            "effect",
            "plan",
            "bound",
            "kind",
            "measured",
            "ratio",
            "rms bound",
            "measured",
            "time"
        );
        for effect in &self.effects {
            let _ = writeln!(text, "{}", effect.line());
        }
        text
    }
}

impl MeasuredEffect {
    /// `None` where it cannot be switched over.
    fn row(&self, scene: &str, date: &str) -> Option<EffectRow> {
        let measured = self.measured?;
        let (bound, change) = (rounded(self.bound.value), rounded(measured.change));
        Some(EffectRow {
            scene: scene.to_owned(),
            effect: self.effect,
            decision: if self.on { "on" } else { "off" },
            bound,
            kind: self.bound.kind.name(),
            measured: change,
            ratio: (change > 0.0).then(|| rounded(bound / change)),
            rms_bound: rounded(self.bound.rms),
            rms_measured: rounded(measured.rms),
            seconds: rounded(measured.seconds),
            date: date.to_owned(),
        })
    }

    fn line(&self) -> String {
        let number = |value: f64| format!("{value:.1e}");
        let found = |text: &dyn Fn(&Measured) -> String| {
            (self.measured.as_ref()).map_or_else(|| "-".to_owned(), text)
        };
        let ratio = |measured: &Measured| {
            let ratio = self.bound.value / measured.change;
            if ratio.is_finite() {
                format!("{ratio:.1}")
            } else {
                "-".to_owned()
            }
        };
        format!(
            "{:<21} {:<4} {:>8}  {:<16} {:>9} {:>8} {:>9} {:>9} {:>8}",
            self.effect,
            if self.on { "on" } else { "off" },
            number(self.bound.value),
            self.bound.kind.name(),
            found(&|measured| number(measured.change)),
            found(&ratio),
            number(self.bound.rms),
            found(&|measured| number(measured.rms)),
            found(&|measured| format!("{:.2} s", measured.seconds)),
        )
    }
}
