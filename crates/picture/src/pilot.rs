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

use niji_scene::DropSpacing;
use niji_scene::Foretold;
use niji_scene::Scene;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::planned_scene::PlanRequest;

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
}

impl Seen {
    /// How close the nodes of drops were seen to be needed.
    pub(crate) fn spacing(&self) -> DropSpacing {
        let seen = self.drop_spacing.as_ref();
        seen.map_or(DropSpacing::AsGiven, |it| it.level)
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
            sky: match (self.sky, &other.sky) {
                (Some(one), Some(other)) => Some(SkySeen {
                    level: one.level.max(other.level),
                    error: one.error.or_more(&other.error),
                }),
                (one, other) => one.or(other.clone()),
            },
        }
    }
}

/// What is to be seen of the drops of a scene, but for what was seen `before`, at another tolerance.
///
/// # Errors
/// As those of a picture; [`Error::Stopped`].
pub(crate) fn seen_of_drops(
    scene: &Scene,
    (foretold, request): (&Foretold, PlanRequest),
    before: Seen,
) -> Result<Seen, Error> {
    let open = small_scene::open(scene, (foretold, request.folder));
    let mut seen = Seen {
        further_orders: before.further_orders.filter(|_| open.further_orders),
        drop_spacing: before.drop_spacing.filter(|it| it.holds_for(scene)),
        sky: None,
    };
    let open = open.but_for(&seen);
    if let Some(small) = SmallScene::new(scene, (foretold, request), open)? {
        seen.further_orders = seen
            .further_orders
            .or(further_orders::further_orders(&small)?);
        seen.drop_spacing = seen
            .drop_spacing
            .or(drop_spacing::drop_spacing(&small, scene)?);
    }
    Ok(seen)
}
