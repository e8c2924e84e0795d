//! Light that drops scatter more than once: what it adds.
//!
//! It has no proved bound, takes a table of all angles and paths through the drops, and changes slowly from place to
//! place. So where its estimate leaves open whether the tolerance calls for it, it is looked at by few paths. The
//! noise of these makes the light look like more than it is, never like less.

use niji_render::PictureLayer;
use niji_scene::Effect;

use super::SmallPicture;
use super::small_scene::SmallScene;
use crate::error::Error;

/// What it adds; `None` where bounds settle it.
///
/// # Errors
/// As those of a picture.
pub(crate) fn further_orders(small: &SmallScene) -> Result<Option<SmallPicture>, Error> {
    let planned = &small.planned;
    if !planned.plan.is_on(Effect::MultipleScattering) {
        return Ok(None);
    }
    let image = small.picture(planned.drops()?, planned.plan.levels.drop_orders)?;
    let mut layers = image.aovs.iter();
    let layer = layers.find(|aov| aov.name == PictureLayer::BowMultiple.name());
    let mut channels = layer.iter().flat_map(|layer| &layer.channels);
    let luminance = channels.find(|(name, _)| name == "Y");
    Ok(luminance.map(|(_, luminance)| {
        let over_white = luminance.mapv(|it| f64::from(it) / small.display_white_cd_m2);
        SmallPicture::new(&planned.scene.camera, &over_white)
    }))
}
