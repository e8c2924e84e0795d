//! Scenes from TOML and from JSON.

use std::collections::BTreeMap;

use crate::check::Check;
use crate::document;
use crate::error::SceneError;
use crate::moment::SunPosition;
use crate::photo::PickedSun;
use crate::scene::Scene;
use crate::scene_check;
use crate::sections::Body;
use crate::sections::Sun;
use crate::sequence::Sequence;
use crate::sun_section::SunSection;

/// Where the sun stands while picks have not told it yet.
const UNTOLD: Sun = Sun {
    body: Body::Sun,
    phase_angle_deg: None,
    elevation_deg: 0.0,
    azimuth_deg: 0.0,
};

impl Scene {
    /// Reads a scene from TOML; every key must be known, of the right type and within its range.
    ///
    /// # Errors
    /// The first thing that is wrong, with its line and what would be right; a scene without `[sun]`.
    pub fn from_toml(text: &str) -> Result<Self, SceneError> {
        Self::from_toml_with_picks(text, |_| Err(missing_sun()))
    }

    /// As [`Scene::from_toml`], of a scene whose sun may follow from picks in its photograph: where `[sun]`
    /// is left out, `solve` says where the sun of the scene stands. What `solve` sees is checked but for that.
    ///
    /// # Errors
    /// As [`Scene::from_toml`], and what `solve` reports.
    pub fn from_toml_with_picks<E: From<SceneError>>(
        text: &str,
        solve: impl FnOnce(&Self) -> Result<PickedSun, E>,
    ) -> Result<Self, E> {
        let document = document::parse::<Scene<Option<SunSection>>>(text)?;
        Sequence::from_toml(text)?;
        let check = Check {
            lines: &document.lines,
        };
        let section = document.value.sun.clone();
        let sun = section.map(|sun| sun.placed(&check)).transpose()?;
        let mut scene = document.value.with_sun(sun.unwrap_or(UNTOLD));
        let has_picks = (scene.photo.iter()).any(|photo| !photo.picks_px.is_empty());
        if sun.is_none() && !has_picks {
            return Err(missing_sun().into());
        }
        scene_check::check(&scene, &document.lines)?;
        if sun.is_none() {
            let sun = solve(&scene)?;
            let SunPosition {
                elevation_deg,
                azimuth_deg,
            } = sun.position;
            scene.sun.elevation_deg = elevation_deg;
            scene.sun.azimuth_deg = azimuth_deg;
            if let Some(photo) = &mut scene.photo {
                photo.misfit = sun.misfit();
            }
            scene_check::check(&scene, &document.lines)?;
        }
        Ok(scene)
    }

    /// Reads a scene from the JSON that [`Scene::canonical_json`] writes.
    ///
    /// # Errors
    /// [`SceneError::Json`] if it is not that, and as [`Scene::check`].
    pub fn from_json(text: &str) -> Result<Self, SceneError> {
        let scene: Self = serde_json::from_str(text).map_err(|error| SceneError::Json {
            message: error.to_string(),
        })?;
        scene.check()?;
        Ok(scene)
    }

    /// Refuses a scene that was changed in code as one that is read: values out of their ranges, NaN among them, and
    /// parts that contradict each other. Every scene that is read was checked.
    ///
    /// ```
    /// use niji_scene::{Scene, SceneError};
    ///
    /// let text = include_str!("../../../data/scenes/garden-fountain.toml");
    /// let mut scene = Scene::from_toml(text)?;
    /// scene.accuracy.tolerance = Some(f64::NAN);
    /// let error = scene.check().unwrap_err();
    /// assert_eq!(error.to_string(), "`accuracy.tolerance` is NaN, expected 0.000001 to 1");
    /// # Ok::<(), SceneError>(())
    /// ```
    ///
    /// # Errors
    /// The first thing that is wrong, by its key and with what would be right; without a line.
    pub fn check(&self) -> Result<(), SceneError> {
        scene_check::check(self, &BTreeMap::new())
    }
}

fn missing_sun() -> SceneError {
    SceneError::MissingKey {
        line: 1,
        section: document::section_of(""),
        key: "sun".to_owned(),
        other: None,
        also: Vec::new(),
    }
}

impl<S> Scene<S> {
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
            terrain: self.terrain,
            photo: self.photo,
            sequence: self.sequence,
        }
    }
}
