//! The levels that keep a tolerance, by nothing but what levels say of their own errors.
//!
//! a = T/2,   a_table = a_integral = a/2,   a_rays = a/sqrt(2),   a^2 = sum of their squares
//! `T` tolerance: RMS of luminance over the picture in gray cards in the sun; `a` the half of it that is
//! for levels, the other being for effects left out. The parts are those of the renderer's estimate,
//! which adds up their squares too.
//!
//! A level whose setting is an error gets its part: the table's relative error, but no more than a draft's,
//! that of an adaptive integral, and the error of a pixel for which the renderer adds rays. Both
//! relative errors are of light that is seldom brighter than a gray card in the sun.
//! All other levels are a preset's: of `standard` and `reference` the first whose own table errs by no
//! more than `a`, which is `standard` down to T = 0.01. A draft leaves out light of the sky that is
//! seen at any tolerance.
//!
//! Nothing is foretold: the estimate that the renderer makes with the picture is the judge. What a scene
//! names stays.

use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SunPath;
use niji_scatter::Theory;

use crate::accuracy::Accuracy;
use crate::accuracy::Preset;
use crate::accuracy::exact_theory;
use crate::effect::Effect;
use crate::effect_switches::Switch;
use crate::plan::Plan;
use crate::plan::SHARE_FOR_EFFECTS;
use crate::scene::Scene;

/// Part of a tolerance that is for levels; the rest is for effects left out.
pub const SHARE_FOR_LEVELS: f64 = 1.0 - SHARE_FOR_EFFECTS;

/// Parts of what is for levels: of the table, of an adaptive integral, of the rays of a pixel.
const OF_TABLE: f64 = 0.5;
const OF_INTEGRAL: f64 = 0.5;
const OF_RAYS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Smallest errors that a table and an integral may be asked for.
const LEAST_TABLE_ERROR: f64 = 1e-6;
const LEAST_INTEGRAL_ERROR: f64 = 1e-12;

/// What is asked of a picture, beside what its scene says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// A preset in place of the scene's.
    pub preset: Option<Preset>,
    /// A tolerance that the picture has to keep, in place of the scene's: levels follow from it, unless
    /// the preset is asked for too.
    pub tolerance: Option<f64>,
}

impl Goal {
    /// The scene that is asked for.
    #[must_use]
    pub fn of(self, mut scene: Scene) -> Scene {
        if let Some(tolerance) = self.tolerance {
            scene.accuracy.tolerance = tolerance;
        }
        match (self.preset, self.tolerance) {
            (Some(preset), _) => scene.accuracy.preset = preset,
            (None, Some(tolerance)) => scene.accuracy = levels_for_tolerance(&scene, tolerance),
            (None, None) => (),
        }
        scene
    }
}

/// The accuracy that keeps a tolerance, with all that the scene names as it is.
pub fn levels_for_tolerance(scene: &Scene, tolerance: f64) -> Accuracy {
    let (named, allowed) = (scene.accuracy, SHARE_FOR_LEVELS * tolerance);
    let table_error = |preset: Preset| preset.levels(1.0).table_relative_error;
    let preset = if table_error(Preset::Standard) <= allowed {
        Preset::Standard
    } else {
        Preset::Reference
    };
    let of_table = (OF_TABLE * allowed).clamp(LEAST_TABLE_ERROR, table_error(Preset::Draft));
    let of_integral = Integration::Adaptive {
        relative_error: (OF_INTEGRAL * allowed).max(LEAST_INTEGRAL_ERROR),
    };
    let theory: Option<Theory> = match preset {
        Preset::Reference => Some(exact_theory(&scene.effects)),
        Preset::Draft | Preset::Standard => None,
    };
    Accuracy {
        preset,
        theory: named.theory.or(theory),
        table_relative_error: named.table_relative_error.or(Some(of_table)),
        integration: named.integration.or(Some(of_integral)),
        // The renderer adds rays where one is too few.
        pixel_footprint: (named.pixel_footprint).or(Some(PixelFootprint::Prefiltered)),
        ..named
    }
}

/// What a pixel may err by before it gets more rays, in gray cards in the sun.
pub fn tolerance_for_rays(tolerance: f64) -> f64 {
    OF_RAYS * SHARE_FOR_LEVELS * tolerance
}

/// Whether light that drops scatter more than once belongs into a picture that shall keep a tolerance.
/// Presets but the reference leave it out unasked; here it counts like every other effect, by the RMS of
/// its bound over the picture.
pub fn calls_for_multiple_scattering(scene: &Scene, plan: &Plan, tolerance: f64) -> bool {
    let effect = Effect::MultipleScattering;
    let mut needs = effect.needs().iter();
    let is_open = scene.effects.of(effect) == Switch::Auto
        && scene.accuracy.sun_path != Some(SunPath::Ignore)
        && needs.all(|needed| scene.effects.of(*needed) != Switch::Off);
    let missed = plan.bound(effect).map_or(0.0, |bound| bound.rms);
    is_open && !plan.is_on(effect) && missed > SHARE_FOR_EFFECTS * tolerance
}
