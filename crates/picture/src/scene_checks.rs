//! Whether a planned scene can become a picture: its light, its files and its memory.

use std::fs;
use std::io;
use std::path::Path;

use niji_exchange::STRIP_BYTES;
use niji_render::ask_for_memory;
use niji_scene::Scene;
use niji_scene::Stage;
use niji_scene::with_frame;

use crate::error::Error;
use crate::planned_scene::PlannedScene;

/// Light below this part of a tolerance is none that an effect could show: an exposure is missing.
const SEEN_AT_ALL: f64 = 1e-3;

/// What a dark scene lacks where its plan warns of nothing.
const LIGHT_NEEDS: &str = "a bow needs drops in view at its angle and the sun above the horizon, a sky needs air; \
                           `niji plan` says what each effect contributes";

/// Refuses a scene without a file that it names.
///
/// # Errors
/// The file that is not there.
pub fn check_files(scene: &Scene, folder: &Path) -> Result<(), Error> {
    for file in scene.files() {
        let path = folder.join(file);
        let missing = |error: io::Error| {
            let is_of_frames = with_frame(file, 1) != file;
            let why = if is_of_frames {
                "# stands for the number of a frame: say which frames with --frames, as 1-240 or 12"
                    .to_owned()
            } else {
                format!("{error}: the scene names this file")
            };
            Error::file(&path, why)
        };
        fs::metadata(&path).map_err(missing)?;
    }
    Ok(())
}

impl PlannedScene {
    /// Refuses whatever would be refused later.
    ///
    /// # Errors
    /// As [`Self::check_light`], [`Self::check_inputs`] and [`Self::check_memory`].
    pub fn check(&self) -> Result<(), Error> {
        self.check_light()?;
        self.check_inputs()?;
        self.check_memory()
    }

    /// Refuses a scene without a table, or without a file that it names.
    ///
    /// # Errors
    /// A scattering table that cannot be made, for one because it is too large; a file that is not there.
    pub fn check_inputs(&self) -> Result<(), Error> {
        if let Some(error) = &self.plan.table_refused {
            return Err(Error::Scattering(error.clone()));
        }
        check_files(&self.scene, &self.folder)
    }

    /// Refuses a picture for which memory cannot be had, in the words of the renderer.
    ///
    /// # Errors
    /// [`niji_render::Error::Memory`].
    pub fn check_memory(&self) -> Result<(), Error> {
        let region = self.scene.camera.region().map_err(Error::scene)?;
        let mut stages = self.plan.stages.iter();
        let picture = stages.find(|planned| planned.stage == Stage::Render);
        // Its file at most, as numbers lie in memory.
        let of_all = picture.and_then(|planned| planned.estimate.file_bytes);
        let of_all = of_all.unwrap_or(0);
        let bytes = if self.plan.is_pictured_whole(&self.scene) {
            of_all
        } else {
            of_all.min(STRIP_BYTES as u64)
        };
        Ok(ask_for_memory((region.width_px, region.height_px), bytes)?)
    }

    /// Refuses a scene that sends no light at all.
    ///
    /// # Errors
    /// [`Error::Dark`].
    pub fn check_light(&self) -> Result<(), Error> {
        if !self.plan.is_dark() {
            return Ok(());
        }
        let effects = self.plan.effects.iter().filter(|it| it.is_left_out);
        let brightest = effects.max_by(|a, b| a.bound.value.total_cmp(&b.bound.value));
        let reason = match (brightest, self.plan.warnings.first()) {
            (Some(brightest), _) if brightest.bound.value > SEEN_AT_ALL * self.plan.tolerance => {
                format!(
                    "all of it is too faint to be seen, most of it {0}, {1:.2} % of display white at most: \
                     effects.{0} = \"on\" shows it, or a larger picture.exposure_ev, or a smaller accuracy.tolerance",
                    brightest.effect,
                    100.0 * brightest.bound.value
                )
            }
            (_, Some(warned)) => warned.clone(),
            (_, None) => LIGHT_NEEDS.to_owned(),
        };
        Err(Error::Dark {
            scene: self.scene.name.clone(),
            reason,
        })
    }
}
