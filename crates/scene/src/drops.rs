//! The section `[drops]`: a shape with its keys, or a file.

use niji_droplets::Gradient;
use niji_droplets::RainShaft;
use niji_droplets::Shape;
use niji_droplets::Uniform;
use serde::Deserialize;
use serde::Serialize;

/// Where the drops are and how large they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drops {
    /// A box of the same drops everywhere.
    Uniform(Uniform),
    /// A box with a linear run of radius and number density.
    Gradient(Gradient),
    /// A shaft of rain below a cloud.
    RainShaft(RainShaft),
    /// A drop volume that exists already.
    File(DropFile),
}

/// A drop volume on disk.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DropFile {
    /// Path of the OpenVDB file, relative to the scene file.
    pub file: String,
}

impl Drops {
    /// The shape to lay out; `None` for a file.
    pub fn shape(&self) -> Option<Shape> {
        match self {
            Self::Uniform(shape) => Some(Shape::Uniform(*shape)),
            Self::Gradient(shape) => Some(Shape::Gradient(*shape)),
            Self::RainShaft(shape) => Some(Shape::RainShaft(*shape)),
            Self::File(_) => None,
        }
    }

    /// The file to read, relative to the scene file; `None` for a shape.
    pub fn file(&self) -> Option<&str> {
        match self {
            Self::Uniform(_) | Self::Gradient(_) | Self::RainShaft(_) => None,
            Self::File(drops) => Some(&drops.file),
        }
    }
}
