//! How finely light that the air scatters more than once is solved, and what the picture errs by for it.
//!
//! e(coarse) = M |L(coarse) - L(fine)|,   e(fine) = e(coarse) / 2,   e(finer) = e(fine) / 2
//! `L` luminance of sky and ground without drops, over display white; `coarse` and `fine` two levels that follow each
//! other; `M` margin. From each level to the next the error falls to about a half. The finest level takes longer than
//! many pictures: it is looked at only where too much is foretold of it. What the draft level differs by says little of
//! finer ones: with the sun 5 degrees high in haze it is as much as the next level still errs by, in clear air ten times
//! as much.
//!
//! Drops and surfaces are left out: what they hide errs no more than what is seen, and what drops take from the
//! sky behind them they give back from their surroundings, which are of the same light.

use ndarray::Array2;
use niji_atmosphere::Suns;
use niji_render::LitDrops;
use niji_render::PixelFootprint;
use niji_render::RenderEffects;
use niji_render::RenderLevels;
use niji_render::RenderRequest;
use niji_render::Toggle;
use niji_render::render;
use niji_scene::Effect;
use niji_scene::Plan;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::SkyLevel;
use niji_scene::tolerance_for_sky;
use serde::Deserialize;
use serde::Serialize;

use super::SmallPicture;
use super::small_picture::smaller;
use crate::air::AirRequest;
use crate::error::Error;
use crate::planned_scene::PlanRequest;
use crate::watch::Watch;

/// What the difference of two levels is multiplied by: the finer one errs too, by a third of what the coarser one does.
const MARGIN: f64 = 1.5;

/// What the error falls to from a level to the next.
const HALF: f64 = 0.5;

/// The effects of sky and ground alone.
const SKY_ONLY: RenderEffects = RenderEffects {
    primary_bow: Toggle::Off,
    secondary_bow: Toggle::Off,
    sky: Toggle::On,
    ..RenderEffects::BOWS_ONLY
};

/// A level and what it errs by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SkySeen {
    pub(crate) level: SkyLevel,
    pub(crate) error: SmallPicture,
}

impl SkySeen {
    /// The coarsest level that errs by no more than is allowed, from one on, by what this one errs by.
    fn coarsest(mut self, first: SkyLevel, allowed: f64) -> Self {
        while let Some(level) = self.level.coarser().filter(|it| *it >= first) {
            let error = self.error.clone().times((1.0 / HALF) as f32);
            if error.bound().rms > allowed {
                break;
            }
            self = Self { level, error };
        }
        self
    }
}

/// The coarsest level that keeps the tolerance, from that of the plan on; that of the plan where a preset names its
/// levels; at another tolerance by what was seen `before`, where that is good enough. `None` where no light of the sky is
/// seen that the air scattered before, and where there is no time to look.
///
/// # Errors
/// Parameters of the air that are out of range; [`Error::Stopped`].
pub(crate) fn sky(
    scene: &Scene,
    plan: &Plan,
    (request, before): (PlanRequest, Option<SkySeen>),
) -> Result<Option<SkySeen>, Error> {
    let Some(first) = plan.sky_level.filter(|_| plan.is_on(Effect::Sky)) else {
        return Ok(None);
    };
    let watch = request.watch;
    let is_chosen = scene.accuracy.preset == Preset::Standard;
    let allowed = tolerance_for_sky(plan.tolerance, plan.left_out);
    let before = before.map(|it| {
        if is_chosen {
            it.coarsest(first, allowed)
        } else {
            it
        }
    });
    let holds = |it: &SkySeen| it.level >= first && it.error.bound().rms <= allowed;
    let before = before.filter(|it| request.is_hasty || holds(it));
    if before.is_some() || request.is_hasty {
        return Ok(before);
    }
    let small = smaller(scene);
    let levels = RenderLevels {
        pixel_footprint: PixelFootprint::Center,
        ..plan.levels.render_levels()
    };
    let seen = |level| luminance(&small, (levels, level), watch);
    // By how many levels it is finer than the coarser of the two that were compared.
    let error = |difference: &Array2<f64>, n_finer: i32| {
        let part = MARGIN * HALF.powi(n_finer) / plan.display_white_cd_m2;
        SmallPicture::new(&small.camera, &difference.mapv(|it| part * it.abs()))
    };
    let quick = seen(SkyLevel::Quick)?;
    if first == SkyLevel::Draft {
        let error = error(&(&quick - &seen(first)?), 0);
        return Ok(Some(SkySeen {
            level: first,
            error,
        }));
    }
    let standard = seen(SkyLevel::Standard)?;
    let to_standard = &standard - &quick;
    let levels = [SkyLevel::Quick, SkyLevel::Standard, SkyLevel::Fine];
    for (level, n_finer) in levels.into_iter().zip(0..) {
        let error = error(&to_standard, n_finer);
        if level >= first && (!is_chosen || error.bound().rms <= allowed) {
            return Ok(Some(SkySeen { level, error }));
        }
    }
    let to_fine = seen(SkyLevel::Fine)? - standard;
    Ok(Some(SkySeen {
        level: SkyLevel::Fine,
        error: error(&to_fine, 1),
    }))
}

/// Luminance of every pixel of a scene without drops [cd/m²].
fn luminance(
    scene: &Scene,
    (levels, level): (RenderLevels, SkyLevel),
    watch: Watch,
) -> Result<Array2<f64>, Error> {
    let camera = scene.camera.camera().map_err(Error::scene)?;
    let suns = Suns::seen_from(camera.position(), scene.sun.direction());
    let air = AirRequest::of(scene, Some(level.orders()));
    let air = air.map(|air| AirRequest { suns, ..air }.table(watch));
    let air = air.transpose()?;
    let picture = render(
        &RenderRequest {
            camera: &camera,
            region: scene.camera.region().map_err(Error::scene)?,
            sun_direction: scene.sun.direction(),
            wavelengths: scene.spectrum,
            sun_irradiance: &scene.sun.irradiance(&scene.spectrum),
            drops: &LitDrops::none(),
            table: None,
            air: air.as_ref(),
            surfaces: None,
            water: None,
            effects: SKY_ONLY,
            levels,
            tolerance_cd_m2: None,
            orders_error_cd_m2: None,
            coarser_rays: 1.0,
        },
        &|_| {},
    )?;
    Ok(niji_exchange::luminance(&picture.radiance, &scene.spectrum))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_level_errs_by_tells_which_coarser_one_is_enough() {
        let luminance = vec![vec![0.001; 2]; 2];
        let fine = SkySeen {
            level: SkyLevel::Fine,
            error: SmallPicture {
                first_px: [0.0; 2],
                frame_px: [2.0; 2],
                luminance,
            },
        };
        for (first, allowed, level, expected) in [
            (SkyLevel::Quick, 1.0, SkyLevel::Quick, 0.004),
            (SkyLevel::Quick, 0.0039, SkyLevel::Standard, 0.002),
            (SkyLevel::Standard, 1.0, SkyLevel::Standard, 0.002),
            (SkyLevel::Quick, 0.0019, SkyLevel::Fine, 0.001),
            (SkyLevel::Fine, 1.0, SkyLevel::Fine, 0.001),
        ] {
            let found = fine.clone().coarsest(first, allowed);
            assert_eq!(found.level, level, "{first:?} {allowed}");
            assert!((found.error.bound().rms / expected - 1.0).abs() < 1e-6);
        }
    }
}
