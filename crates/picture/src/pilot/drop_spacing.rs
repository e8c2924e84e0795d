//! What a picture errs by because drops are known at nodes only, where they are laid out from a shape.
//!
//! e(h) = |L(h) - L(2 h)| / 2
//! `L` luminance over display white, without what drops scatter more than once; `h` spacing of the nodes. A field
//! that is smooth over `h` errs by a third of the difference, an edge of drops by all of it at most. Where e(h) is
//! more than the tolerance leaves to it and the nodes are not too many, h/2 is taken, and looked at itself. What a
//! file of another program lacks between its nodes cannot be known.

use ndarray::Array2;
use niji_dropfield::DropVolume;
use niji_exchange::SpectralImage;
use niji_render::DropOrders;
use niji_scene::DropSpacing;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::tolerance_for_spacing;
use serde::Deserialize;
use serde::Serialize;

use super::SmallPicture;
use super::small_scene::OtherNodes;
use super::small_scene::SmallScene;
use crate::error::Error;

/// Part of the difference that is the error.
const OF_DIFFERENCE: f64 = 0.5;

/// Most nodes of which there may be eight times as many.
const MOST_NODES: u64 = 1_000_000;

/// A spacing and what it errs by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpacingSeen {
    pub(crate) level: DropSpacing,
    pub(crate) error: SmallPicture,
    /// RMS of what the spacing of the scene errs by.
    as_given: f64,
    /// Nodes at that spacing.
    n_nodes: u64,
}

impl SpacingSeen {
    /// That of two frames: the closer nodes, in every place the larger error.
    pub(crate) fn or_more(self, other: &Self) -> Self {
        Self {
            level: self.level.max(other.level),
            error: self.error.or_more(&other.error),
            as_given: self.as_given.max(other.as_given),
            n_nodes: self.n_nodes.max(other.n_nodes),
        }
    }

    /// Whether it is what the same drops ask for at the tolerance of a scene.
    pub(crate) fn holds_for(&self, scene: &Scene) -> bool {
        self.level == level(scene, self.as_given, self.n_nodes)
    }
}

/// The spacing for a scene whose own errs by so much.
fn level(scene: &Scene, as_given: f64, n_nodes: u64) -> DropSpacing {
    let accuracy = &scene.accuracy;
    let is_chosen = accuracy.drop_spacing.is_none() && accuracy.preset == Preset::Standard;
    let is_seen = as_given > tolerance_for_spacing(accuracy.tolerance());
    if is_chosen && is_seen && n_nodes <= MOST_NODES {
        DropSpacing::Halved
    } else {
        DropSpacing::AsGiven
    }
}

/// The spacing for a scene and what it errs by, from its picture without further orders and the nodes that are in it.
///
/// # Errors
/// As those of a picture.
pub(super) fn drop_spacing(
    small: &SmallScene,
    scene: &Scene,
    ((own, n_nodes), other): ((&SpectralImage, u64), &OtherNodes),
) -> Result<SpacingSeen, Error> {
    let seen =
        |image: &SpectralImage| niji_exchange::luminance(&image.radiance, &image.wavelengths);
    let luminance = |drops: DropVolume| -> Result<Array2<f64>, Error> {
        Ok(seen(&small.picture(drops, DropOrders::SingleScattering)?))
    };
    let error = |finer: &Array2<f64>, coarser: &Array2<f64>| {
        let over_white = OF_DIFFERENCE / small.display_white_cd_m2;
        let error = (finer - coarser).mapv(|it| over_white * it.abs());
        SmallPicture::new(&small.planned.scene.camera, &error)
    };
    let own = seen(own);
    let of_own = error(&own, &luminance(other.apart.volume()?)?);
    let as_given = of_own.bound().rms;
    let level = level(scene, as_given, n_nodes);
    let error = match level {
        DropSpacing::AsGiven => of_own,
        DropSpacing::Halved => error(&luminance(other.closer.volume()?)?, &own),
    };
    Ok(SpacingSeen {
        level,
        error,
        as_given,
        n_nodes,
    })
}
