//! The photograph of a command: by its own name, or that of a scene.

use std::path::PathBuf;

use clap::Args;
use clap::builder::ArgPredicate;
use niji_picture::PlannedScene;

use crate::failure::Failure;
use crate::flags::Common;
use crate::scene_file;
use crate::stages::photo;

/// Where the photograph comes from.
#[derive(Clone, Debug, Args)]
pub(crate) struct PhotoSource {
    /// The scene whose section [photo] gives the photograph and what flags would say of it.
    #[arg(long, value_name = "TOML", conflicts_with = "photo")]
    scene: Option<PathBuf>,
    /// The photograph (PNG, JPEG, EXR).
    #[arg(
        required_unless_present = "scene",
        default_value_if("scene", ArgPredicate::IsPresent, ".")
    )]
    pub(crate) photo: PathBuf,
}

impl PhotoSource {
    /// The photograph of a scene.
    ///
    /// # Errors
    /// A scene without one.
    pub(crate) fn of_scene(planned: &PlannedScene) -> Result<Self, Failure> {
        Ok(Self {
            scene: None,
            photo: planned.folder.join(&photo::section(planned)?.picture),
        })
    }

    /// The command that `of_scene` makes of the scene, where one is named.
    ///
    /// # Errors
    /// A scene that is missing or wrong, and what `of_scene` reports.
    pub(crate) fn command<T>(
        &self,
        common: &Common,
        of_scene: impl FnOnce(&PlannedScene) -> Result<T, Failure>,
    ) -> Result<Option<T>, Failure> {
        let of_file = |scene: &PathBuf| of_scene(&scene_file::load(scene, common)?);
        self.scene.as_ref().map(of_file).transpose()
    }
}
