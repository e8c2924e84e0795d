//! The drops of a scene as a small picture shows them: by few pixels and wavelengths, from a coarse table.

use std::collections::BTreeSet;
use std::path::Path;

use ndarray::Array2;
use niji_dropfield::DropVolume;
use niji_exchange::AtmosphereTable;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Bound;
use niji_scene::Effect;
use niji_scene::Foretold;
use niji_scene::Preset;
use niji_scene::SHARE_FOR_EFFECTS;
use niji_scene::Scene;
use niji_scene::Spectral;
use niji_scene::Switch;

use super::Seen;
use super::small_picture::smaller;
use crate::drop_volume::LaidOut;
use crate::drop_volume::VolumeSource;
use crate::error::Error;
use crate::picture::PictureParts;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::planned_scene::PlanRequest;
use crate::planned_scene::PlannedScene;
use crate::watch::Watch;

/// Relative error of its table: only differences and small parts of its light count.
pub(super) const TABLE_ERROR: f64 = 0.1;

/// Paths of a quarter of the light in each direction, and directions along a side.
const ORDERS: DropOrders = DropOrders::MultipleScattering {
    nodes_across: 6,
    paths_per_node: 512,
};

/// An estimate of light of further orders below this part of what may be left out needs no look: it is exceeded by
/// less.
const SURE: f64 = 0.1;

/// The light of drops.
const BOWS: [Effect; 3] = [
    Effect::PrimaryBow,
    Effect::SecondaryBow,
    Effect::HigherOrders,
];

/// A small scene, planned, with its table and air.
pub(crate) struct SmallScene<'a> {
    pub(super) planned: PlannedScene,
    table: Option<ScatteringTable>,
    air: Option<AtmosphereTable>,
    pub(super) display_white_cd_m2: f64,
    watch: Watch<'a>,
}

/// What bounds leave open.
pub(super) struct Open {
    /// Whether light of further orders is on.
    pub(super) further_orders: bool,
    /// What lies between the nodes of drops that are laid out from a shape and send light: what they are made from.
    pub(super) drop_spacing: Option<VolumeSource>,
}

impl Open {
    /// What is still open once something was seen; `None` where nothing is.
    pub(super) fn but_for(self, seen: &Seen) -> Option<Self> {
        let open = Self {
            further_orders: self.further_orders && seen.further_orders.is_none(),
            drop_spacing: self.drop_spacing.filter(|_| seen.drop_spacing.is_none()),
        };
        (open.further_orders || open.drop_spacing.is_some()).then_some(open)
    }
}

/// What bounds leave open of a scene.
pub(super) fn open(scene: &Scene, (foretold, folder): (&Foretold, &Path)) -> Open {
    let allowed = SHARE_FOR_EFFECTS * scene.accuracy.tolerance();
    let is_open = |estimate: Bound| estimate.rms > SURE * allowed;
    let is_lit = BOWS.iter().any(|bow| foretold.on.contains(bow));
    let source = VolumeSource::of(scene, folder);
    Open {
        further_orders: foretold.further_orders.is_some_and(is_open),
        drop_spacing: source.filter(|it| is_lit && it.has_shapes()),
    }
}

/// A scene by few pixels and wavelengths, with the effects that are on, and with light of further orders where that is
/// open.
pub(super) fn coarse(
    scene: &Scene,
    (on, theory): (&BTreeSet<Effect>, Theory),
    is_open: bool,
) -> Scene {
    let mut scene = smaller(scene);
    scene.accuracy = Accuracy {
        preset: Preset::Draft,
        theory: Some(match theory {
            // Fringes are no matter here.
            Theory::Uniform => Theory::Geometric,
            theory => theory,
        }),
        table_relative_error: Some(TABLE_ERROR),
        integration: Some(Integration::CellExact),
        pixel_footprint: Some(PixelFootprint::Center),
        drop_orders: Some(ORDERS),
        drop_spacing: scene.accuracy.drop_spacing,
        ..Accuracy::default()
    };
    for effect in Effect::ALL {
        let is_on = match effect {
            Effect::MultipleScattering => is_open,
            // Cheap as well, and of the light of further orders.
            Effect::SizeSpread | Effect::SunDisc | Effect::Supernumeraries => true,
            _ => {
                let is_needed = Effect::MultipleScattering.needs().contains(&effect);
                on.contains(&effect) || is_open && is_needed
            }
        };
        let switch = if is_on { Switch::On } else { Switch::Off };
        scene.effects.set(effect, switch);
    }
    scene
}

impl<'a> SmallScene<'a> {
    /// With the effects that are on, and light of further orders where it is open, of drops and others that it is
    /// compared with.
    ///
    /// # Errors
    /// A scene that cannot be planned.
    pub(super) fn new(
        scene: &Scene,
        (foretold, request): (&Foretold, PlanRequest<'a>),
        has_further_orders: bool,
        drops: &[&LaidOut],
    ) -> Result<Self, Error> {
        let scene = coarse(
            scene,
            (foretold.on, foretold.levels.theory),
            has_further_orders,
        );
        let mut summaries = drops.iter().map(|it| &it.summary);
        let drops = (summaries.next(), summaries);
        let planned = PlannedScene::of_switches(scene, request.folder, drops)?;
        let watch = request.watch;
        Ok(Self {
            table: planned.scattering(planned.airy()?.as_ref(), watch)?,
            air: planned.air(watch)?,
            planned,
            display_white_cd_m2: foretold.display_white_cd_m2,
            watch,
        })
    }

    /// Its picture of some drops by some orders. What hides drops is left out: it makes their light no brighter.
    pub(super) fn picture(
        &self,
        drops: DropVolume,
        orders: DropOrders,
    ) -> Result<SpectralImage, Error> {
        let parts = PictureParts {
            drops,
            table: self.table.clone(),
            air: self.air.clone(),
            surfaces: None,
        };
        let mut settings = PictureSettings::of(&self.planned);
        settings.levels.drop_orders = orders;
        // It is measured, never shown.
        settings.picture.spectral = Spectral::Full;
        let whole = settings.whole()?;
        PictureWork::new(settings, parts, self.watch)?.render(whole, self.watch)
    }

    /// A channel of a layer of its picture over display white; `None` where the picture lacks it.
    pub(super) fn over_white(
        &self,
        picture: &SpectralImage,
        (layer, channel): (PictureLayer, &str),
    ) -> Option<Array2<f64>> {
        let layer = picture.aovs.iter().find(|it| it.name == layer.name())?;
        let mut channels = layer.channels.iter();
        let (_, values) = channels.find(|(name, _)| name == channel)?;
        Some(values.mapv(|it| f64::from(it) / self.display_white_cd_m2))
    }
}
