//! How much light errors of the scattering table are parts of.
//!
//! B^2 = (e_angles/e_table)^2 + L^2
//! `e_angles` what a small picture errs by between the angles of its table, RMS of luminance over display white;
//! `e_table` relative error of that table; `L` luminance of the sunlit drops, RMS over display white. Between two angles
//! a curve errs by its bend, of which a table holds no more than its error over its peak, so that e_angles is in
//! proportion to e_table: how bright a bow is, how wide, how much of the frame it takes and how many sizes blur it is
//! in it. Theory and steps of sizes err by parts of the light itself.

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_render::PictureLayer;

use super::SmallPicture;
use super::small_scene::SmallScene;
use super::small_scene::TABLE_ERROR;

/// B of a scene by its picture; `None` where that does not tell its errors.
pub(super) fn bright_drops(small: &SmallScene, picture: &SpectralImage) -> Option<f64> {
    let seen = |layer, channel| small.over_white(picture, (layer, channel));
    let of_angles = seen(PictureLayer::Error, "angles")? / TABLE_ERROR;
    let bows = [PictureLayer::BowPrimary, PictureLayer::BowSecondary];
    let light = bows.into_iter().filter_map(|bow| seen(bow, "Y"));
    let light = light.reduce(|one, other| one + other)?;
    let rms = |values: &Array2<f64>| {
        SmallPicture::new(&small.planned.scene.camera, values)
            .bound()
            .rms
    };
    Some(rms(&of_angles).hypot(rms(&light)))
}
