//! What a plan cannot derive, measured in small pictures of the view of its own scene.
//!
//! Light that drops scatter more than once, light that the air scatters more than once, what lies between the nodes of
//! the drops, and what moves while a shutter is open have no proved bound. Pictures of few pixels and wavelengths tell
//! them: whether an effect or a finer level is called for, and what the picture errs by without it.

mod drop_spacing;
mod further_orders;
pub(crate) mod motion;
mod sky;
mod small_picture;
mod small_scene;
mod table_error;

use niji_render::DropOrders;
use niji_scene::DropSpacing;
use niji_scene::DropsSeen;
use niji_scene::Effect;
use niji_scene::Foretold;
use niji_scene::Scene;
use serde::Deserialize;
use serde::Serialize;

use crate::drop_volume::LaidOut;
use crate::error::Error;
use crate::planned_scene::PlanRequest;

use drop_spacing::Asked;
use drop_spacing::Spacing;
pub(crate) use drop_spacing::SpacingSeen;
pub(crate) use sky::SkySeen;
pub(crate) use sky::sky;
pub(crate) use small_picture::SmallPicture;
use small_scene::SmallScene;

/// All that was measured for a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Seen {
    /// Light that drops scatter more than once, where bounds leave open whether it is on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) further_orders: Option<SmallPicture>,
    /// The level of the light that the air scatters more than once, and what it errs by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) sky: Option<SkySeen>,
    /// The spacing of the drops' nodes, and what it errs by, where they are laid out from a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drop_spacing: Option<SpacingSeen>,
    /// Luminance of which errors of the scattering table are parts, RMS over the picture over display white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) bright_drops: Option<f64>,
    /// What bounds say of the effects that the plan left out; `None` where there are none, and for a sequence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) left_out: Option<SmallPicture>,
}

impl Seen {
    /// How close the nodes of drops were seen to be needed.
    pub(crate) fn spacing(&self) -> DropSpacing {
        let seen = self.drop_spacing.as_ref();
        seen.map_or(DropSpacing::AsGiven, |it| it.level)
    }

    /// What a plan of the drops takes of it.
    pub(crate) fn of_drops(&self) -> DropsSeen {
        DropsSeen {
            further_orders: self.further_orders.as_ref().map(SmallPicture::bound),
            bright_drops: self.bright_drops,
        }
    }

    /// What is seen in any of two frames, in every place the more of it; of levels the finer one.
    pub(crate) fn or_more(self, other: &Self) -> Self {
        let more = |one: Option<SmallPicture>, other: &Option<SmallPicture>| match (one, other) {
            (Some(one), Some(other)) => Some(one.or_more(other)),
            (one, other) => one.or(other.clone()),
        };
        Self {
            further_orders: more(self.further_orders, &other.further_orders),
            drop_spacing: match (self.drop_spacing, &other.drop_spacing) {
                (Some(one), Some(other)) => Some(one.or_more(other)),
                (one, other) => one.or(other.clone()),
            },
            bright_drops: match (self.bright_drops, other.bright_drops) {
                (Some(one), Some(other)) => Some(one.max(other)),
                (one, other) => one.or(other),
            },
            sky: match (self.sky, &other.sky) {
                (Some(one), Some(other)) => Some(SkySeen {
                    level: one.level.max(other.level),
                    error: one.error.or_more(&other.error),
                }),
                (one, other) => one.or(other.clone()),
            },
            // What one frame leaves out another shows.
            left_out: None,
        }
    }
}

/// What is to be seen of the drops of a scene, but for what was seen `before`, at another tolerance; where there is no
/// time for more, that alone.
///
/// # Errors
/// As those of a picture; [`Error::Stopped`].
pub(crate) fn seen_of_drops(
    scene: &Scene,
    (foretold, request): (&Foretold, PlanRequest),
    (drops, before): (&LaidOut, Seen),
) -> Result<Seen, Error> {
    let open = small_scene::open(scene, (foretold, request.folder));
    let mut seen = Seen {
        further_orders: before.further_orders.filter(|_| open.further_orders),
        drop_spacing: before.drop_spacing.filter(|it| it.holds_for(scene)),
        bright_drops: before.bright_drops,
        sky: None,
        left_out: None,
    };
    let Some(open) = open.but_for(&seen).filter(|_| !request.is_hasty) else {
        return Ok(seen);
    };
    let spacing = open.drop_spacing.as_ref().map(Spacing::of).transpose()?;
    let others = spacing.iter().filter_map(Spacing::apart);
    let laid_out: Vec<&LaidOut> = std::iter::once(drops).chain(others).collect();
    let small = SmallScene::new(scene, (foretold, request), open.further_orders, &laid_out)?;
    let own = || drops.volume_of(|| small.planned.drops());
    let mut last = None;
    if small.planned.plan.is_on(Effect::MultipleScattering) {
        let orders = small.planned.plan.levels.drop_orders;
        let picture = small.picture(own()?, orders)?;
        seen.further_orders = further_orders::further_orders(&small, &picture);
        last = Some(picture);
    }
    if let Some(spacing) = &spacing {
        let picture = small.picture(own()?, DropOrders::SingleScattering)?;
        let asked = Asked {
            scene,
            foretold,
            request,
            drops,
        };
        seen.drop_spacing = Some(spacing.seen(asked, (&small, &picture))?);
        last = Some(picture);
    }
    seen.bright_drops = last.and_then(|it| table_error::bright_drops(&small, &it));
    Ok(seen)
}
