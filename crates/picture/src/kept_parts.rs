//! Parts of pictures that stay as they are while a scene is worked on: what a change does not touch is not made again.

use std::collections::VecDeque;

use niji_airy::AiryTable;
use niji_dropfield::DropVolume;
use niji_exchange::AtmosphereTable;
use niji_exchange::ScatteringTable;
use niji_render::Surfaces;
use niji_scene::Stage;
use niji_scene::canonical_json;

use crate::air;
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

/// Parts of the pictures before.
#[derive(Default)]
pub struct KeptParts {
    airy: Option<AiryTable>,
    drops: Kept<DropVolume>,
    tables: Kept<ScatteringTable>,
    airs: Kept<AtmosphereTable>,
    surfaces: Kept<Option<Surfaces>>,
}

impl KeptParts {
    /// The parts of a picture; `files` says what the files hold that its scene names. A scene with a photograph has
    /// parts of its own.
    ///
    /// # Errors
    /// As those of the parts; [`Error::Stopped`].
    pub fn parts(
        &mut self,
        planned: &PlannedScene,
        files: &str,
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
        let surfaces = canonical_json(&(&scene.occluders, &scene.terrain, scene.camera, files));
        Ok(PictureParts {
            drops: (self.drops).of(canonical_json(&(source, files)), || planned.drops())?,
            table: table.transpose()?,
            air: air.transpose()?,
            surfaces: (self.surfaces).of(surfaces, || planned.surfaces(None))?,
        })
    }
}
