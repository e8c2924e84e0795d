//! What a picture errs by because drops are known at nodes only, where they are laid out from a shape.
//!
//! e = |L(h) - L(2 h)| / 2
//! `L` luminance over display white, without what drops scatter more than once; `h` spacing of the nodes. A field
//! that is smooth over `h` errs by a third of the difference, an edge of drops by all of it at most. What a file of
//! another program lacks between its nodes cannot be known.

use ndarray::Array2;
use niji_dropfield::DropVolume;
use niji_exchange::luminance;
use niji_render::DropOrders;

use super::SmallPicture;
use super::small_scene::SmallScene;
use crate::error::Error;

/// Part of the difference that is the error.
const OF_DIFFERENCE: f64 = 0.5;

/// What the spacing changes; `None` where drops have no shape or send no light.
///
/// # Errors
/// As those of a picture.
pub(crate) fn drop_spacing(small: &SmallScene) -> Result<Option<SmallPicture>, Error> {
    let Some(apart) = &small.apart else {
        return Ok(None);
    };
    let seen = |drops: DropVolume| -> Result<Array2<f64>, Error> {
        let image = small.picture(drops, DropOrders::SingleScattering)?;
        Ok(luminance(&image.radiance, &image.wavelengths))
    };
    let difference = seen(small.planned.drops()?)? - seen(apart.volume()?)?;
    let over_white = OF_DIFFERENCE / small.display_white_cd_m2;
    let error = difference.mapv(|it| over_white * it.abs());
    Ok(Some(SmallPicture::new(&small.planned.scene.camera, &error)))
}
