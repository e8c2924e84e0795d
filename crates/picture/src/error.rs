//! Why a picture cannot be made.

use std::path::Path;
use std::path::PathBuf;

/// Why a picture cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that the scene names is missing, damaged or holds values that cannot be.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What was found and what was expected.
        message: String,
    },
    /// A VDB file that holds no drops of ours.
    #[error("{}: no drops in it: expected a grid {expected}, found {}", path.display(), listed(found))]
    NoDrops {
        /// The file.
        path: PathBuf,
        /// The grid that drops have.
        expected: String,
        /// The grids that are there.
        found: Vec<String>,
        /// Those of them that may be densities.
        densities: Vec<String>,
    },
    /// Drops that physics does not allow.
    #[error("{}", with_causes(.0))]
    Drops(#[source] niji_droplets::Error),
    /// A scene that is wrong, as it was read or as it was changed in code.
    #[error(transparent)]
    SceneFile(#[from] niji_scene::SceneError),
    /// Picks in a photograph that no sun explains.
    #[error("{0}")]
    NoSun(String),
    /// A scene that cannot be planned.
    #[error("{}", with_causes(.0))]
    Plan(#[from] niji_scene::PlanError),
    /// A frame of a sequence that is wrong.
    #[error("frame {0}: {1}")]
    Frame(u32, #[source] Box<Error>),
    /// A sequence of which no frame that was looked at has drops.
    #[error("found no drops in any of the frames {0:?}, expected some")]
    NoFrameWithDrops(Vec<u32>),
    /// A scattering table that cannot be made.
    #[error(transparent)]
    Scattering(niji_scatter::Error),
    /// Air that cannot be.
    #[error(transparent)]
    Air(#[from] niji_atmosphere::Error),
    /// A camera or a spectrum that cannot be: of a scene built in code, never of one that was read.
    #[error("{0}")]
    Scene(String),
    /// More meshes than a picture may have.
    #[error("found {found} meshes, expected {most} at most: join some")]
    TooManyMeshes {
        /// How many.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// Drops for which there is no room.
    #[error("{}", with_causes(.0))]
    Volume(#[from] niji_dropfield::Error),
    /// Drops that cannot be lit.
    #[error("{0}")]
    Light(#[source] niji_render::Error),
    /// A picture that cannot be rendered, its parts contradicting each other for one.
    #[error(transparent)]
    Render(niji_render::Error),
    /// No effect that is on sends any light into the picture.
    #[error("{scene}: no effect that is on sends any light into the picture: {reason}")]
    Dark {
        /// Name of the scene.
        scene: String,
        /// What the plan warns of, or what light needs.
        reason: String,
    },
    /// A camera below the land.
    #[error(
        "the camera is below the terrain: found camera.position_m[1] = {found_m:.2}, expected more than {ground_m:.2} there"
    )]
    CameraInTerrain {
        /// Height of the camera (m).
        found_m: f64,
        /// Height of the land there (m).
        ground_m: f64,
    },
    /// A photograph into which no bow can be set.
    #[error(transparent)]
    Photo(#[from] niji_photo::Error),
    /// A rendered region that is not to be set into a picture of another size.
    #[error(
        "found a part of a frame of another size, expected the whole frame or the size of the picture"
    )]
    PartOfFrame,
    /// Whoever watched stopped it.
    #[error("stopped")]
    Stopped,
}

impl From<niji_scatter::Error> for Error {
    fn from(error: niji_scatter::Error) -> Self {
        match error {
            niji_scatter::Error::Stopped => Self::Stopped,
            error => Self::Scattering(error),
        }
    }
}

impl From<niji_render::Error> for Error {
    fn from(error: niji_render::Error) -> Self {
        match error {
            niji_render::Error::Stopped => Self::Stopped,
            error => Self::Render(error),
        }
    }
}

impl Error {
    /// A file that is missing, damaged or holds values that cannot be.
    pub(crate) fn file(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::File {
            path: path.to_owned(),
            message: without_path(path, &error.to_string()),
        }
    }

    pub(crate) fn scene(error: impl std::fmt::Display) -> Self {
        Self::Scene(error.to_string())
    }
}

/// A message about a file without its path at the beginning: libraries name it themselves where they open the
/// file, and it is to be said once.
pub fn without_path(path: &Path, message: &str) -> String {
    let path = path.display();
    let named = [format!("{path}: "), format!("cannot read {path}: ")];
    let unnamed = named.iter().find_map(|name| message.strip_prefix(&**name));
    unnamed.unwrap_or(message).to_owned()
}

/// An error and its causes in one line.
pub fn with_causes(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += ": ";
        text += &error.to_string();
        cause = error.source();
    }
    text
}

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
