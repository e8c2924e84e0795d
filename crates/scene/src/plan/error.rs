//! Why there is no plan.

use thiserror::Error;

use crate::error::SceneError;

/// Why there is no plan.
#[derive(Debug, Error)]
pub enum PlanError {
    /// A scene that was changed in code, as [`crate::Scene::check`] refuses it.
    #[error(transparent)]
    Scene(Box<SceneError>),
    /// The drops are in a file whose figures were not given, or which has no drops.
    #[error("the drop volume {file} holds no drops, or was not read")]
    NoDrops {
        /// The file, or the shape.
        file: String,
    },
    /// Drops that cannot be laid out.
    #[error("[drops]")]
    Drops(#[from] niji_droplets::Error),
    /// The camera of a scene that was not read from a file.
    #[error("camera")]
    Camera(#[from] niji_geometry::Error),
    /// The air of a scene that was not read from a file.
    #[error("air")]
    Air(#[from] niji_atmosphere::Error),
    /// Axes of the scattering table.
    #[error("scattering table")]
    Scatter(#[from] niji_scatter::Error),
    /// Sizes of the scattering table.
    #[error("scattering table")]
    Sizes(#[from] niji_sizes::Error),
}

impl From<SceneError> for PlanError {
    fn from(error: SceneError) -> Self {
        Self::Scene(Box::new(error))
    }
}
