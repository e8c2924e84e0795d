//! What an open shutter changes in a frame, and over how many instants the mean has to be.
//!
//! Small pictures at 5, 9, 17, 33 and 65 instants, of which the frame is one: with a table of all angles, without depth
//! images, which stand still, and without light that drops scatter more than once, which is no sharper than the bows.
//! Instants are enough where what lies between them, by the rule that judges the frames themselves, keeps its part of the
//! tolerance.

use std::collections::BTreeSet;
use std::f64::consts::PI;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
use niji_render::PictureLayer;
use niji_scene::Blur;
use niji_scene::Effect;
use niji_scene::Plan;
use niji_scene::Scene;
use niji_scene::Shutter;
use niji_scene::canonical_json;
use niji_scene::tolerance_for_motion;

use super::SmallPicture;
use super::small_scene::coarse;
use crate::error::Error;
use crate::kept_parts::KeptParts;
use crate::mean_of_instants::MOTION;
use crate::open_shutter::OpenShutter;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::planned_scene::PlanRequest;
use crate::planned_scene::PlannedScene;
use crate::planned_scene::drops_of;

/// Numbers of instants, one after the other.
const INSTANTS: [u32; 5] = [5, 9, 17, 33, 65];

/// A frame, and its scene so many frames later.
pub(crate) struct MovingFrame<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) beside: &'a dyn Fn(f64) -> Result<Scene, Error>,
    pub(crate) shutter: Shutter,
}

/// What the shutter of a frame changes, as a sequence was planned; `kept` has the parts of the frames before.
///
/// # Errors
/// As those of a picture; [`Error::Stopped`].
pub(crate) fn blur(
    moving: &MovingFrame,
    (plan, request): (&Plan, PlanRequest),
    kept: &mut KeptParts,
) -> Result<Blur, Error> {
    let on: BTreeSet<Effect> = plan.effects_on().collect();
    let small = |scene: &Scene| {
        let mut small = coarse(scene, (&on, plan.levels.theory), false);
        small.occluders = small.occluders.filter(|it| !it.meshes.is_empty());
        if let Some(occluders) = &mut small.occluders {
            occluders.depth = None;
        }
        small
    };
    let own = small(moving.scene);
    let mut ends = Vec::new();
    for after in moving.shutter.ends() {
        ends.push(small(&(moving.beside)(after)?));
    }
    if ends.iter().all(|end| *end == own) {
        return Ok(Blur::NONE);
    }
    let request_of_one = PlanRequest {
        is_frame: false,
        ..request
    };
    let summary = |scene: &Scene| {
        let drops = drops_of(scene, request_of_one)?;
        Ok::<_, Error>(drops.map(|drops| drops.summary))
    };
    let laid_out = ends.iter().filter(|end| end.drops.file().is_none());
    let at_ends = laid_out.map(summary);
    let at_ends = at_ends.collect::<Result<Vec<_>, Error>>()?;
    let drops = summary(&own)?;
    let drops = (drops.as_ref(), at_ends.iter().flatten());
    let mut planned = PlannedScene::of_switches(own, request.folder, drops)?;
    if let Some(need) = &mut planned.plan.scattering {
        need.theta_range_rad = (0.0, PI);
    }
    let named = moving.scene.accuracy.shutter_instants;
    let mut blur = Blur::NONE;
    for n_instants in INSTANTS {
        let places = moving.shutter.instants(n_instants).into_iter();
        let scenes = places.map(|after| Ok(small(&(moving.beside)(after)?)));
        let scenes = scenes.collect::<Result<Vec<Scene>, Error>>()?;
        planned.shutter = Some(OpenShutter::new(&planned, scenes));
        let [change, error] = change_and_error(&planned, request, kept)?;
        blur = Blur {
            change: change.bound(),
            n_instants,
        };
        let is_enough = error.bound().rms <= tolerance_for_motion(plan.tolerance);
        if is_enough || named.is_some() {
            break;
        }
    }
    Ok(blur)
}

/// What the mean of a small scene changes, and what is told of its error.
fn change_and_error(
    planned: &PlannedScene,
    request: PlanRequest,
    kept: &mut KeptParts,
) -> Result<[SmallPicture; 2], Error> {
    let watch = request.watch;
    let parts = kept.parts(
        planned,
        (&canonical_json(&planned.scene.drops), None),
        watch,
    )?;
    let settings = PictureSettings::of(planned);
    let n_instants = settings.shutter.as_ref().map_or(1, OpenShutter::n_instants);
    let white_cd_m2 = planned.plan.display_white_cd_m2;
    let whole = settings.whole()?;
    let light = |image: &SpectralImage| luminance(&image.radiance, &image.wavelengths);
    let mut own = Array2::zeros((0, 0));
    let work = PictureWork::new(settings, parts, watch)?;
    let mean = work.over_shutter(watch, |work, place| {
        let image = work.at_once(whole, watch)?;
        if place <= n_instants / 2 {
            own = light(&image);
        }
        Ok::<_, Error>(image)
    })?;
    let errors = mean
        .aovs
        .iter()
        .filter(|it| it.name == PictureLayer::Error.name());
    let mut channels = errors.flat_map(|it| &it.channels);
    let motion = channels.find(|(name, _)| name == MOTION);
    let motion = motion.map_or_else(|| own.map(|_| 0.0), |(_, it)| it.mapv(f64::from));
    let change = light(&mean) - own;
    let small = |it: Array2<f64>| {
        let over_white = it.mapv(|it| it.abs() / white_cd_m2);
        SmallPicture::new(&planned.scene.camera, &over_white)
    };
    Ok([change, motion].map(small))
}
