//! The levels of a scene: those of its preset, or such that its tolerance is kept.
//!
//! a = T/2,   a_table = a_integral = a_orders = a/sqrt(6),   a_rays = a/sqrt(2),   a^2 = sum of their squares
//! e_table = 0.005 / 2^n <= a_table / (2 B)
//! `T` tolerance: RMS of luminance over the picture, over display white; `a` the half of it that is
//! for levels, the other being for effects left out; `B` light of which the table's relative error `e_table` is a part.
//! The parts are those of the renderer's estimate, which adds up their squares too. Beside them light that the air scatters more than once, which is no light of drops,
//! may be off by a_rays, and so may what lies between the nodes of drops, and between the instants of a shutter.
//!
//! The preset `standard` is its tolerance. A level whose setting is an error gets its part: the table's
//! relative error, but no more than half of the tolerance within 0.005 and 0.02, that of an adaptive integral, the
//! noise of light of further orders below which no more paths are followed, and the error of a pixel for which the
//! renderer adds rays. Relative errors are of the light of drops: pictures are exposed so that it is seldom brighter
//! than a gray card, 0.18 of display white. Where a small picture told how much less a table's errors are seen than
//! that, `e_table` is as much larger, up to that of the preset `standard`; theory is judged up to
//! that of `draft`. Of theories drops of each size take the cheapest that keeps the table's
//! error. All other levels are those of `standard`, of `reference` where the table of `standard` errs by more than `a`,
//! and of `draft` for a rough picture, of a tolerance of 0.1 or more, whose table may err by 0.05.
//!
//! Paths of light of further orders go beyond those of the level where its error would else be more than the parts of
//! all others leave of `T`. Where none are followed, the rays of a pixel have that too.
//!
//! Nothing is foretold: the estimate that the renderer makes with the picture is the judge. What a scene
//! names stays.

use niji_render::Integration;
use niji_render::PixelFootprint;
use niji_render::SkyModel;
use niji_scatter::Theory;

use crate::accuracy::Levels;
use crate::accuracy::Preset;
use crate::effect::Effect;
use crate::effect::Role;
use crate::effect_switches::Switch;
use crate::plan::SHARE_FOR_EFFECTS;
use crate::scene::Scene;
use crate::sky_level::SkyLevel;

/// Part of a tolerance that is for levels; the rest is for effects left out.
pub const SHARE_FOR_LEVELS: f64 = 1.0 - SHARE_FOR_EFFECTS;

/// Smallest tolerance: numbers of a picture have 24 bits, and a pixel is a sum of some.
pub const LEAST_TOLERANCE: f64 = 1e-6;

/// Parts of what is for levels: of the table, of an adaptive integral, of light of further orders, of the rays of a
/// pixel.
const OF_TABLE: f64 = 0.408_248_290_463_863;
const OF_INTEGRAL: f64 = OF_TABLE;
const OF_ORDERS: f64 = OF_TABLE;
const OF_RAYS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Part of its error that a table gets: steps of angles are halved until they keep it, so that they may err by as
/// little as a quarter of it in the small picture, and by all of it in the picture. Errors are halves, quarters ... of
/// that of the preset `standard`, so that scenes that are alike have the same table.
const OF_STEPS: f64 = 0.5;

/// Part of a table's error by which drops are judged whose theory it may take: it errs by as much for all that count,
/// and wholly for those that have less than twice as much of the light, which do not.
const OF_THEORY: f64 = 1.0 / 3.0;

/// Parts of the light that air scatters more than once, which is no light of drops, of what lies between the nodes of
/// drops, and of what lies between the instants of a shutter.
const OF_SPACING: f64 = std::f64::consts::FRAC_1_SQRT_2;
const OF_SKY: f64 = std::f64::consts::FRAC_1_SQRT_2;
const OF_MOTION: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Parts of what effects left out leave of a tolerance, where that is more: of the light that air scatters more than
/// once, and of that together with light of further orders of drops. 0.8² and the squares of all other parts are 0.97.
const SKY_OF_REST: f64 = 0.5;
const SCATTERED_OF_REST: f64 = 0.8;

/// Smallest errors that a table and an integral may be asked for.
const LEAST_TABLE_ERROR: f64 = 1e-4;
const LEAST_INTEGRAL_ERROR: f64 = 1e-12;

/// Tolerance from which on a picture is rough: a tenth of white is what short times get. Below, tables that err by more
/// than those of `draft` show their steps in a sky.
const ROUGH_TOLERANCE: f64 = 0.1;

/// Largest errors that tables and integrals of rough pictures are asked for.
const ROUGH_ERROR: f64 = 0.05;

/// Luminance of drops that are bright, over display white: that of a gray card.
pub const BRIGHT_DROPS: f64 = 0.18;

/// What a scattering table may err by, relative to its peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableErrors {
    /// Between its sizes and angles.
    pub table: f64,
    /// By its theory.
    pub theory: f64,
}

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
        let accuracy = &mut scene.accuracy;
        accuracy.tolerance = self.tolerance.or(accuracy.tolerance);
        accuracy.preset = match (self.preset, self.tolerance) {
            (Some(preset), _) => preset,
            (None, Some(_)) => Preset::Standard,
            (None, None) => accuracy.preset,
        };
        scene
    }
}

impl Scene {
    /// The level of every stage for drops on a lattice of `voxel_m`.
    #[must_use]
    pub fn levels(&self, voxel_m: f64) -> Levels {
        let levels = match self.accuracy.preset {
            Preset::Standard => self.levels_for_tolerance(voxel_m),
            preset @ (Preset::Draft | Preset::Reference) => preset.levels(voxel_m),
        };
        self.accuracy.named_over(levels)
    }

    /// How finely light that the air scattered before is solved where nobody measured what its tolerance asks
    /// for; `None` where the model of the sky or the effects do not ask for it.
    #[must_use]
    pub fn sky_level(&self) -> Option<SkyLevel> {
        let lit = self.albedos().next().map(|_| Effect::LitSurfaces);
        let mut lights = Effect::of_role(Role::AirLight).chain(lit);
        let is_seen = lights.any(|it| self.effects.of(it) != Switch::Off);
        self.sky_level_where_seen().filter(|_| is_seen)
    }

    /// The same wherever it is seen; `None` where the model of the sky is one order.
    pub(crate) fn sky_level_where_seen(&self) -> Option<SkyLevel> {
        let preset = self.accuracy.preset;
        let sky = self.accuracy.sky.unwrap_or(preset.levels(1.0).sky);
        match (sky, preset) {
            (SkyModel::None | SkyModel::SingleScattering, _) => None,
            (SkyModel::MultipleScattering, Preset::Draft) => Some(SkyLevel::Draft),
            (SkyModel::MultipleScattering, Preset::Standard) => Some(SkyLevel::Quick),
            (SkyModel::MultipleScattering, Preset::Reference) => Some(SkyLevel::Standard),
        }
    }

    /// Relative error of the light of drops that is for levels.
    fn relative_error(&self) -> f64 {
        SHARE_FOR_LEVELS * self.accuracy.tolerance() / BRIGHT_DROPS
    }

    fn is_rough(&self) -> bool {
        self.accuracy.tolerance() >= ROUGH_TOLERANCE
    }

    /// The preset whose levels are taken where they have no error for a setting.
    fn preset_kept(&self) -> Preset {
        let of_standard = Preset::Standard.levels(1.0).table_relative_error;
        match self.accuracy.preset {
            Preset::Standard if of_standard > self.relative_error() => Preset::Reference,
            Preset::Standard if self.is_rough() => Preset::Draft,
            preset => preset,
        }
    }

    /// Relative errors of the scattering table where they are seen as parts of so much light, RMS over the picture
    /// over display white; `None` where the scene or its preset names them.
    #[must_use]
    pub fn table_errors(&self, bright_drops: f64) -> Option<TableErrors> {
        let accuracy = &self.accuracy;
        if accuracy.preset != Preset::Standard || accuracy.table_relative_error.is_some() {
            return None;
        }
        let own = self.levels_for_tolerance(1.0).table_relative_error;
        let [standard, draft] =
            [Preset::Standard, Preset::Draft].map(|preset| preset.levels(1.0).table_relative_error);
        let seen = OF_TABLE * SHARE_FOR_LEVELS * accuracy.tolerance() / bright_drops;
        let n_halved = (standard / (OF_STEPS * seen)).log2().ceil();
        let halved = standard * (-n_halved.max(0.0)).exp2();
        Some(TableErrors {
            table: halved.max(own),
            theory: (OF_THEORY * seen).clamp(own, draft.max(own)),
        })
    }

    fn levels_for_tolerance(&self, voxel_m: f64) -> Levels {
        let allowed = self.relative_error();
        let [least, draft] = [Preset::Standard, Preset::Draft]
            .map(|preset| preset.levels(voxel_m).table_relative_error);
        let most = if self.is_rough() {
            ROUGH_ERROR
        } else {
            (0.5 * self.accuracy.tolerance()).clamp(least, draft)
        };
        Levels {
            theory: Theory::BySize,
            table_relative_error: (OF_TABLE * allowed).clamp(LEAST_TABLE_ERROR, most),
            integration: Integration::Adaptive {
                relative_error: (OF_INTEGRAL * allowed).clamp(LEAST_INTEGRAL_ERROR, most),
            },
            // The renderer adds rays where one is too few.
            pixel_footprint: PixelFootprint::Prefiltered,
            ..self.preset_kept().levels(voxel_m)
        }
    }
}

/// RMS error that light of further orders may have where so much is left out and light that the air scatters more than
/// once errs by so much, all over display white: what leaves their parts to all other errors.
pub fn most_error_of_orders(tolerance: f64, left_out: f64, error_of_sky: f64) -> f64 {
    let rest = rest_of_scattered((tolerance, left_out), error_of_sky);
    rest.max(OF_ORDERS * SHARE_FOR_LEVELS * tolerance)
}

/// What a pixel may err by before it gets more rays where no light of further orders is followed, over display white:
/// what those leave it, where that is more than its part.
pub fn most_error_of_rays(tolerance: f64, left_out: f64, error_of_sky: f64) -> f64 {
    let rest = rest_of_scattered((tolerance, left_out), error_of_sky);
    rest.max(tolerance_for_rays(tolerance))
}

/// What effects left out and the light that the air scatters more than once leave of a tolerance to light of further
/// orders of drops.
fn rest_of_scattered((tolerance, left_out): (f64, f64), error_of_sky: f64) -> f64 {
    let both = SCATTERED_OF_REST * (tolerance - left_out);
    (both * both.abs() - error_of_sky.powi(2)).max(0.0).sqrt()
}

/// RMS that light which the air scatters more than once may be off by where so much is left out, over display white.
pub fn tolerance_for_sky(tolerance: f64, left_out: f64) -> f64 {
    (SKY_OF_REST * (tolerance - left_out)).max(OF_SKY * SHARE_FOR_LEVELS * tolerance)
}

/// RMS that the spacing of the drops' nodes may change, over display white.
pub fn tolerance_for_spacing(tolerance: f64) -> f64 {
    OF_SPACING * SHARE_FOR_LEVELS * tolerance
}

/// RMS that a frame may be off by for what lies between the instants of its shutter, over display white.
pub fn tolerance_for_motion(tolerance: f64) -> f64 {
    OF_MOTION * SHARE_FOR_LEVELS * tolerance
}

/// What a pixel may err by before it gets more rays, over display white.
pub fn tolerance_for_rays(tolerance: f64) -> f64 {
    OF_RAYS * SHARE_FOR_LEVELS * tolerance
}
