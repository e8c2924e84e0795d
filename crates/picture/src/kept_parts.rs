//! Parts of pictures that stay as they are while a scene is worked on: what a change does not touch is not made again.

use std::collections::VecDeque;
use std::sync::Arc;

use ndarray::Array2;
use niji_airy::AiryTable;
use niji_dropfield::DropVolume;
use niji_exchange::AtmosphereTable;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_photo::LinearPicture;
use niji_render::Surfaces;
use niji_scene::Camera;
use niji_scene::Photo;
use niji_scene::Scene;
use niji_scene::Stage;
use niji_scene::canonical_json;

use crate::air;
use crate::background::Background;
use crate::error::Error;
use crate::picture::PictureParts;
use crate::planned_scene::PlannedScene;
use crate::scattering;
use crate::watch::Watch;

/// Parts of a kind that are kept: those of a first look, of a finer one, and of the picture.
const N_KEPT: usize = 3;

/// The newest parts of a kind by what they depend on, the newest first.
struct Kept<T>(VecDeque<(String, T)>);

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T: Clone> Kept<T> {
    /// The part that depends on `key`, made where there is none.
    fn of(&mut self, key: String, make: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
        let is_known = self.0.iter().position(|(known, _)| *known == key);
        let (key, part) = match is_known.and_then(|index| self.0.remove(index)) {
            Some(known) => known,
            None => (key, make()?),
        };
        self.0.push_front((key, part.clone()));
        self.0.truncate(N_KEPT);
        Ok(part)
    }
}

/// The photograph of a scene, as it is looked at.
pub struct Photographed {
    /// Distances of its surfaces, m.
    depth_m: Option<Array2<f32>>,
    /// With about as many pixels as its scene's picture.
    background: Background,
}

impl Photographed {
    fn of(planned: &PlannedScene, width_px: u32) -> Result<Option<Self>, Error> {
        let Some(section) = &planned.scene.photo else {
            return Ok(None);
        };
        let mut background = Background::read(&planned.folder.join(&section.picture), None, None)?;
        let depth_m = planned.photo_depth_m()?;
        if let Some(depth_m) = &depth_m {
            background.set_surfaces(depth_m.clone())?;
        }
        let n = background.light.ncols() / (width_px as usize).max(1);
        Ok(Some(Self {
            depth_m,
            background: background.in_squares(n),
        }))
    }

    /// It with the bow of an image, as a display shows it: linear Rec.709, 1 is white.
    ///
    /// # Errors
    /// As [`Background::with_bow`].
    pub fn shown(&self, image: &SpectralImage, section: &Photo) -> Result<LinearPicture, Error> {
        let bow = self.background.with_bow(image, section.into())?;
        Ok(self.background.shown(&bow.picture, 0.0))
    }
}

/// The files of the photograph of a scene.
pub(crate) fn photograph_of(scene: &Scene) -> Option<[Option<&str>; 3]> {
    let photo = scene.photo.as_ref()?;
    let [layers, labels] = [&photo.layers, &photo.labels].map(Option::as_deref);
    Some([Some(photo.picture.as_str()), layers, labels])
}

/// Parts of the pictures before.
#[derive(Default)]
pub struct KeptParts {
    photographs: Kept<Option<Arc<Photographed>>>,
    airy: Option<AiryTable>,
    drops: Kept<DropVolume>,
    tables: Kept<ScatteringTable>,
    airs: Kept<AtmosphereTable>,
    surfaces: Kept<Option<Surfaces>>,
}

impl KeptParts {
    /// The photograph of a scene, for a picture so many pixels wide; `files` as below.
    ///
    /// # Errors
    /// A photograph, layers or a map that are missing or damaged.
    pub fn photograph(
        &mut self,
        planned: &PlannedScene,
        (files, width_px): (&str, u32),
    ) -> Result<Option<Arc<Photographed>>, Error> {
        let scene = &planned.scene;
        let camera = Camera {
            width_px: 0,
            height_px: 0,
            ..scene.camera
        };
        let surfaces = (photograph_of(scene), &scene.occluders);
        let key = canonical_json(&(surfaces, camera, files, width_px));
        self.photographs.of(key, || {
            Ok(Photographed::of(planned, width_px)?.map(Arc::new))
        })
    }

    /// The parts of a picture, before a photograph or none; `files` says what the files hold that its scene names.
    ///
    /// # Errors
    /// As those of the parts; [`Error::Stopped`].
    pub fn parts(
        &mut self,
        planned: &PlannedScene,
        (files, photograph): (&str, Option<&Photographed>),
        watch: Watch,
    ) -> Result<PictureParts, Error> {
        let PlannedScene { scene, plan, .. } = planned;
        if self.airy.is_none() {
            self.airy = planned.airy()?;
        }
        let airy = self.airy.as_ref().filter(|_| plan.runs(Stage::Airy));
        let source = planned.drop_source.as_ref().map(|it| it.settings(false));
        let table = plan.scattering.as_ref().map(|need| {
            let key = scattering::settings(need, scene.spectrum);
            let make = || scattering::table(need, scene.spectrum, airy, watch);
            self.tables.of(key, make)
        });
        let has_air = plan.runs(Stage::Atmosphere) && scene.air.is_some();
        let air = has_air.then(|| {
            let key = air::settings(scene, plan.scattering_orders());
            let make = || {
                let table = planned.air(watch)?;
                table.ok_or_else(|| Error::scene("found no air"))
            };
            self.airs.of(key, make)
        });
        let solids = (&scene.occluders, &scene.terrain, photograph_of(scene));
        let surfaces = canonical_json(&(solids, scene.camera, files));
        let depth_m = || photograph.and_then(|it| it.depth_m.clone());
        Ok(PictureParts {
            drops: (self.drops).of(canonical_json(&(source, files)), || planned.drops())?,
            table: table.transpose()?,
            air: air.transpose()?,
            surfaces: (self.surfaces).of(surfaces, || planned.surfaces(depth_m()))?,
        })
    }
}
