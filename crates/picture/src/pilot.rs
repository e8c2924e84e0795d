//! What a plan cannot derive, measured in small pictures of the view of its own scene.
//!
//! Light that drops scatter more than once, light that the air scatters more than once, and what lies between the
//! nodes of the drops have no proved bound. They change slowly from place to place, so pictures of few pixels and
//! wavelengths tell them: whether an effect or a finer level is called for, and what the picture errs by without
//! it.

mod drop_spacing;
mod further_orders;
mod sky;
mod small_picture;
mod small_scene;

use serde::Deserialize;
use serde::Serialize;

pub(crate) use drop_spacing::drop_spacing;
pub(crate) use further_orders::further_orders;
pub(crate) use sky::SkySeen;
pub(crate) use sky::sky;
pub(crate) use small_picture::SmallPicture;
pub(crate) use small_scene::SmallScene;

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
    /// What the spacing of the drops' nodes errs by, where they are laid out from a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) drop_spacing: Option<SmallPicture>,
}
