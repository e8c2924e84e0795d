//! Light that drops scatter more than once: what it adds.
//!
//! It has no proved bound, takes a table of all angles and paths through the drops, and changes slowly from place to
//! place. So where its estimate leaves open whether the tolerance calls for it, it is looked at by few paths. The
//! noise of these makes the light look like more than it is, never like less.

use niji_exchange::SpectralImage;
use niji_render::PictureLayer;

use super::SmallPicture;
use super::small_scene::SmallScene;

/// What it adds to a picture of all orders; `None` where there is no such light.
pub(crate) fn further_orders(small: &SmallScene, picture: &SpectralImage) -> Option<SmallPicture> {
    let luminance = small.over_white(picture, (PictureLayer::BowMultiple, "Y"))?;
    Some(SmallPicture::new(&small.planned.scene.camera, &luminance))
}
