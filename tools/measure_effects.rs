//! `niji plan --measure`: what every effect of a scene changes, beside its bound.
//!
//! The picture is made small, with the same field of view and one ray through the middle of each
//! pixel and a few wide bins of wavelengths: once with the effects of the plan, then once for every
//! effect with that one forced on where it was off, and off where it was on. The change is the largest of |Y - Y'| over all pixels in parts
//! of the plan's reference luminance, which is what a bound bounds. Tables that an effect does not
//! touch are made once; a change of time is that of the stages that had to be run again.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use niji_render::PixelFootprint;
use niji_scene::Bound;
use niji_scene::Effect;
use niji_scene::EffectDecision;
use niji_scene::Occluders;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Switch;
use serde::Serialize;

use crate::failure::Failure;
use crate::progress;
use crate::progress::Verbosity;
use crate::scene_file;
use crate::scene_file::Planned;
use crate::stages;
use crate::stages::Done;
use crate::timed_run::luminance;
use crate::timed_run::run_once;
use crate::timed_run::temporary_folder;

/// Pixels across the small picture.
const WIDTH_PX: u32 = 96;

/// Wavelengths of the small picture, at most.
const N_WAVELENGTHS: usize = 10;

/// Error of the tables of round and flat drops that are compared.
const COARSE_TABLE: f64 = 0.05;

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
    /// Largest change of luminance over the reference luminance.
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
pub(crate) fn measure(planned: &Planned, verbosity: Verbosity) -> Result<MeasuredEffects, Failure> {
    let small = small(&planned.scene, &planned.plan);
    let folder = temporary_folder()?;
    let bar = progress::bar("measure", 1 + Effect::ALL.len() as u64, verbosity);
    let base = Run::of(&small, &planned.file, folder.path())?;
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
                let base = Run::of(scene, &planned.file, folder.path())?;
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
        seconds: base.done.iter().map(|done| done.seconds).sum(),
        effects,
    })
}

/// The scene in a small picture of few wavelengths and without a photograph, with the effects of a plan
/// spelt out.
fn small(scene: &Scene, plan: &Plan) -> Scene {
    let mut small = plan.settled(scene);
    let camera = &mut small.camera;
    let scale = f64::from(WIDTH_PX.min(camera.width_px)) / f64::from(camera.width_px);
    let scaled = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
    [camera.width_px, camera.height_px] = [scaled(camera.width_px), scaled(camera.height_px)];
    camera.overscan_px = scaled(camera.overscan_px) * u32::from(camera.overscan_px > 0);
    let spectrum = &mut small.spectrum;
    let n_wavelengths = spectrum.n_wavelengths.min(N_WAVELENGTHS);
    let step_nm = spectrum.step_nm * spectrum.n_wavelengths as f64 / n_wavelengths as f64;
    // The same band in wider bins.
    spectrum.first_nm += 0.5 * (step_nm - spectrum.step_nm);
    (spectrum.step_nm, spectrum.n_wavelengths) = (step_nm, n_wavelengths);
    small.accuracy.pixel_footprint = Some(PixelFootprint::Center);
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
    let is_large = decision.bound.value > COARSE_TABLE;
    if decision.effect == Effect::DropFlattening && is_large {
        let levels = base.accuracy.levels(1.0);
        base.accuracy.table_relative_error = Some(levels.table_relative_error.max(COARSE_TABLE));
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
    fn of(scene: &Scene, file: &Path, folder: &'a Path) -> Result<Self, Failure> {
        let planned = scene_file::planned(scene.clone(), file)?;
        let (done, image) = run_once(&planned, folder)?;
        Ok(Self {
            folder,
            done,
            luminance: luminance(&image),
        })
    }

    /// What another scene changes, made with the tables of this one where they fit.
    fn measured(
        &self,
        scene: &Scene,
        planned: &Planned,
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
        let other = Run::of(scene, &planned.file, folder.path())?;
        let seconds = other.seconds_with(&self.done) - self.seconds_with(&[]);
        let reference = planned.plan.reference_luminance_cd_m2;
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
    /// A table for people to read.
    pub(crate) fn text(&self) -> String {
        let mut text = format!(
            "{}: {} x {} pixels, center rays, {:.2} s with all tables\n\
             changes in gray cards in the sun; time is what the effect takes\n\n\
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
    fn line(&self) -> String {
        let number = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1e}"))
        };
        let ratio = self.measured.map(|measured| {
            let ratio = self.bound.value / measured.change;
            if ratio.is_finite() {
                format!("{ratio:.1}")
            } else {
                "-".to_owned()
            }
        });
        format!(
            "{:<21} {:<4} {:>8}  {:<16} {:>9} {:>8} {:>9} {:>9} {:>8}",
            self.effect,
            if self.on { "on" } else { "off" },
            number(Some(self.bound.value)),
            self.bound.kind.name(),
            number(self.measured.map(|measured| measured.change)),
            ratio.unwrap_or_else(|| "-".to_owned()),
            number(Some(self.bound.rms)),
            number(self.measured.map(|measured| measured.rms)),
            self.measured.map_or_else(
                || "-".to_owned(),
                |measured| format!("{:.2} s", measured.seconds)
            ),
        )
    }
}
