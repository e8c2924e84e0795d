//! What an effect changes in this picture, measured on a small one of the same view.
//!
//! Light that drops scatter more than once has no proved bound, takes a table of all angles and paths through the
//! drops, and changes slowly from place to place. So where its estimate leaves open whether the tolerance calls
//! for it, it is looked at: in a picture of few pixels and wavelengths, from a coarse table of spheres, by few
//! paths. The noise of these makes the light look like more than it is, never like less.

use std::path::Path;

use ndarray::ArrayView1;
use niji_render::DropOrders;
use niji_render::Integration;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_scatter::Theory;
use niji_scene::Accuracy;
use niji_scene::Bound;
use niji_scene::BoundKind;
use niji_scene::Effect;
use niji_scene::Foretold;
use niji_scene::Preset;
use niji_scene::SHARE_FOR_EFFECTS;
use niji_scene::Scene;
use niji_scene::Switch;

use crate::error::Error;
use crate::left_out::SmallPicture;
use crate::picture::PictureParts;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::planned_scene::PlanRequest;
use crate::planned_scene::PlannedScene;
use crate::watch::unwatched;

/// Columns of the small picture, and its wavelengths.
const WIDTH_PX: u32 = 24;
const N_WAVELENGTHS: usize = 3;

/// Relative error of its table: of its light a tenth is enough to know.
const TABLE_ERROR: f64 = 0.1;

/// Paths of a quarter of the light in each direction, and directions along a side.
const ORDERS: DropOrders = DropOrders::MultipleScattering {
    nodes_across: 6,
    paths_per_node: 512,
};

/// An estimate below this part of what may be left out needs no look: it is exceeded by less.
const SURE: f64 = 0.1;

/// Light of further orders in a small picture, where bounds leave open whether it is on.
///
/// # Errors
/// As those of a picture.
pub(crate) fn further_orders(
    scene: &Scene,
    foretold: &Foretold,
    folder: &Path,
) -> Result<Option<SmallPicture>, Error> {
    let allowed = SHARE_FOR_EFFECTS * scene.accuracy.tolerance();
    let is_open = |estimate: Bound| estimate.rms > SURE * allowed;
    if !foretold.further_orders.is_some_and(is_open) {
        return Ok(None);
    }
    let mut scene = scene.clone();
    scene.camera = scene.camera.no_wider_than(WIDTH_PX);
    scene.spectrum = scene.spectrum.in_wider_bins(N_WAVELENGTHS);
    scene.accuracy = Accuracy {
        preset: Preset::Draft,
        theory: Some(match foretold.levels.theory {
            // Fringes are no matter here.
            Theory::Uniform => Theory::Geometric,
            theory => theory,
        }),
        table_relative_error: Some(TABLE_ERROR),
        integration: Some(Integration::CellExact),
        pixel_footprint: Some(PixelFootprint::Center),
        drop_orders: Some(ORDERS),
        ..Accuracy::default()
    };
    for effect in Effect::ALL {
        let is_on = match effect {
            Effect::SunlightThroughAir | Effect::AirExtinction => foretold.on.contains(&effect),
            Effect::MultipleScattering
            | Effect::SizeSpread
            | Effect::SunDisc
            | Effect::Supernumeraries => true,
            _ => Effect::MultipleScattering.needs().contains(&effect),
        };
        let switch = if is_on { Switch::On } else { Switch::Off };
        scene.effects.set(effect, switch);
    }
    let request = PlanRequest {
        folder,
        ..PlanRequest::default()
    };
    let small = PlannedScene::new(scene, request)?;
    let parts = PictureParts {
        drops: small.drops()?,
        table: small.scattering(small.airy()?.as_ref(), &unwatched)?,
        air: small.air(&unwatched)?,
        // What hides drops makes their light no brighter.
        surfaces: None,
    };
    let settings = PictureSettings::of(&small);
    let whole = settings.whole()?;
    let image = PictureWork::new(settings, parts, &unwatched)?.render(whole, &unwatched)?;
    let mut layers = image.aovs.iter();
    let layer = layers.find(|aov| aov.name == PictureLayer::BowMultiple.name());
    let mut channels = layer.iter().flat_map(|layer| &layer.channels);
    let luminance = channels.find(|(name, _)| name == "Y");
    let over_white = |row: ArrayView1<f32>| {
        let over_white = row
            .iter()
            .map(|it| f64::from(*it) / foretold.display_white_cd_m2);
        over_white.map(|it| it as f32).collect()
    };
    Ok(luminance.map(|(_, luminance)| SmallPicture {
        first_px: [whole.x_px, whole.y_px],
        frame_px: [small.scene.camera.width_px, small.scene.camera.height_px],
        luminance: luminance.rows().into_iter().map(over_white).collect(),
    }))
}

impl SmallPicture {
    /// What it shows at most and in the RMS.
    pub(crate) fn bound(&self) -> Bound {
        let parts = || self.luminance.iter().flatten().map(|it| f64::from(*it));
        let squares: f64 = parts().map(|part| part * part).sum();
        Bound {
            value: parts().map(f64::abs).fold(0.0, f64::max),
            rms: (squares / parts().count().max(1) as f64).sqrt(),
            kind: BoundKind::Measured,
        }
    }
}
