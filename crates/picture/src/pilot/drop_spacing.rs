//! What a picture errs by because drops are known at nodes only, where they are laid out from a shape.
//!
//! e(h) = |L(h) - L(2 h)| / 2
//! `L` luminance over display white, without what drops scatter more than once; `h` spacing of the nodes. A field
//! that is smooth over `h` errs by a third of the difference, an edge of drops by all of it at most. Where e(h) is
//! more than the tolerance leaves to it and the nodes are not too many, h/2 is taken, and only then laid out and looked
//! at itself. What a file of another program lacks between its nodes cannot be known.

use niji_dropfield::DropVolume;
use niji_exchange::SpectralImage;
use niji_render::DropOrders;
use niji_scene::DropSpacing;
use niji_scene::Foretold;
use niji_scene::Preset;
use niji_scene::Scene;
use niji_scene::tolerance_for_spacing;
use serde::Deserialize;
use serde::Serialize;

use super::SmallPicture;
use super::small_scene::SmallScene;
use crate::drop_volume::LaidOut;
use crate::drop_volume::VolumeSource;
use crate::error::Error;
use crate::planned_scene::PlanRequest;

/// Part of the difference that is the error.
const OF_DIFFERENCE: f64 = 0.5;

/// How many times as far apart nodes are laid out for comparisons.
const APART: f64 = 2.0;
const CLOSER: f64 = 0.5;

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

/// Drops that are laid out from shapes, and the same with nodes twice as far apart.
pub(super) struct Spacing<'a> {
    shapes: &'a VolumeSource,
    apart: OtherNodes,
}

/// Drops with other nodes than their own.
struct OtherNodes {
    source: VolumeSource,
    /// `None` where their voxels are too large for any.
    laid_out: Option<LaidOut>,
}

/// Whose spacing is asked for.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) scene: &'a Scene,
    pub(super) foretold: &'a Foretold<'a>,
    pub(super) request: PlanRequest<'a>,
    /// Its drops.
    pub(super) drops: &'a LaidOut,
}

impl OtherNodes {
    /// The shapes with nodes so many times as far apart.
    fn of(shapes: &VolumeSource, times: f64) -> Result<Self, Error> {
        let source = shapes.with_nodes_apart(times);
        let laid_out = source.laid_out(|drops| drops)?;
        Ok(Self { source, laid_out })
    }

    fn volume(&self) -> Result<DropVolume, Error> {
        let volume = || self.source.volume();
        match &self.laid_out {
            Some(drops) => drops.volume_of(volume),
            None => volume(),
        }
    }
}

impl<'a> Spacing<'a> {
    /// Of shapes.
    ///
    /// # Errors
    /// A shape that cannot be; a file that is missing or damaged.
    pub(super) fn of(shapes: &'a VolumeSource) -> Result<Self, Error> {
        let apart = OtherNodes::of(shapes, APART)?;
        Ok(Self { shapes, apart })
    }

    /// The drops whose nodes lie twice as far apart.
    pub(super) fn apart(&self) -> Option<&LaidOut> {
        self.apart.laid_out.as_ref()
    }

    /// The spacing and what it errs by, from a small scene and its picture without further orders.
    ///
    /// # Errors
    /// As those of a picture.
    pub(super) fn seen(
        &self,
        asked: Asked,
        (small, picture): (&SmallScene, &SpectralImage),
    ) -> Result<SpacingSeen, Error> {
        let of_own = error(small, picture, &single(small, self.apart.volume()?)?);
        let (as_given, n_nodes) = (of_own.bound().rms, asked.drops.summary.n_nodes);
        let level = level(asked.scene, as_given, n_nodes);
        let error = match level {
            DropSpacing::AsGiven => of_own,
            DropSpacing::Halved => self.of_closer(asked)?,
        };
        Ok(SpacingSeen {
            level,
            error,
            as_given,
            n_nodes,
        })
    }

    /// What nodes twice as close as the scene's err by.
    fn of_closer(&self, asked: Asked) -> Result<SmallPicture, Error> {
        let Asked {
            scene,
            foretold,
            request,
            drops,
        } = asked;
        let closer = OtherNodes::of(self.shapes, CLOSER)?;
        let others = closer.laid_out.iter();
        let drops_of_both: Vec<&LaidOut> = std::iter::once(drops).chain(others).collect();
        let small = SmallScene::new(scene, (foretold, request), false, &drops_of_both)?;
        let own = single(&small, drops.volume_of(|| small.planned.drops())?)?;
        let closer = single(&small, closer.volume()?)?;
        Ok(error(&small, &own, &closer))
    }
}

/// A picture without light of further orders.
fn single(small: &SmallScene, drops: DropVolume) -> Result<SpectralImage, Error> {
    small.picture(drops, DropOrders::SingleScattering)
}

/// e of two pictures.
fn error(small: &SmallScene, one: &SpectralImage, other: &SpectralImage) -> SmallPicture {
    let [one, other] =
        [one, other].map(|it| niji_exchange::luminance(&it.radiance, &it.wavelengths));
    let over_white = OF_DIFFERENCE / small.display_white_cd_m2;
    let error = (one - other).mapv(|it| over_white * it.abs());
    SmallPicture::new(&small.planned.scene.camera, &error)
}
