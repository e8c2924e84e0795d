//! Scenes from TOML and from JSON.

use std::collections::BTreeMap;

use crate::check::Check;
use crate::document;
use crate::error::SceneError;
use crate::scene::Scene;
use crate::scene_check;
use crate::sections::Sun;
use crate::sequence::Sequence;
use crate::sun_section::SunSection;

impl Scene {
    /// Reads a scene from TOML; every key must be known, of the right type and within its range.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and what would be right.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        let document = document::parse::<Scene<SunSection>>(text)?;
        Sequence::from_toml(text)?;
        let check = Check {
            lines: &document.lines,
        };
        let sun = document.value.sun.clone().placed(&check)?;
        let scene = document.value.with_sun(sun);
        scene_check::check(&scene, &document.lines)?;
        Ok(scene)
    }

    /// Reads a scene from the JSON that [`Scene::canonical_json`] writes.
    ///
    /// # Errors
    /// [`SceneError::Json`] if it is not that, and as [`Scene::from_toml`] for values out of range,
    /// with line 1.
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        let scene: Self = serde_json::from_str(text).map_err(|error| SceneError::Json {
            message: error.to_string(),
        })?;
        scene_check::check(&scene, &BTreeMap::new())?;
        Ok(scene)
    }
}

impl Scene<SunSection> {
    /// The same scene under a sun that has its place.
    fn with_sun(self, sun: Sun) -> Scene {
        Scene {
            sun,
            format: self.format,
            name: self.name,
            description: self.description,
            camera: self.camera,
            spectrum: self.spectrum,
            drops: self.drops,
            water: self.water,
            water_surface: self.water_surface,
            drop_motion: self.drop_motion,
            air: self.air,
            ground: self.ground,
            effects: self.effects,
            accuracy: self.accuracy,
            picture: self.picture,
            occluders: self.occluders,
            photo: self.photo,
            sequence: self.sequence,
        }
    }
}
