//! The section `[drops]`: a shape with its keys, a density grid of another program, or a file; or,
//! as `[[drops]]`, several of them in one air.

mod names;
mod populations;

use std::fmt;

use niji_dropfield::DensityImport;
use niji_dropfield::DensityMeans;
use niji_dropfield::EffectiveRadius;
use niji_droplets::Shape;
use niji_geometry::Up;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Deserializer;
use serde::Serialize;
use serde::de::DeserializeSeed;
use serde::de::EnumAccess;
use serde::de::IntoDeserializer;
use serde::de::VariantAccess;
use serde::de::Visitor;
use serde::de::value::EnumAccessDeserializer;

pub(crate) use populations::DROPS;
pub use populations::Drops;
pub use populations::Population;

/// Name of [`FromVdb`] among the shapes.
pub(crate) const FROM_VDB: &str = "from-vdb";

/// Name of [`DropFile`]; scene files say it by the key `file` alone.
pub(crate) const FILE: &str = "file";

/// Where drops are and how large they are.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum DropSource {
    /// A density grid that another program made.
    FromVdb(FromVdb),
    /// A drop volume that exists already.
    File(DropFile),
    /// A shape, by its own name.
    #[serde(untagged)]
    Shape(Shape),
}

/// Drops of one size law from a density grid that another program made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FromVdb {
    /// Path of the OpenVDB file; in a scene, relative to the scene file.
    #[schemars(length(min = 1))]
    pub file: String,
    /// Name of the grid.
    #[serde(default = "usual_grid")]
    pub grid: String,
    /// What the numbers of the grid mean.
    pub density_means: DensityMeans,
    /// Factor on the numbers; for optical-depth, the optical depth itself.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub scale: f64,
    /// Effective radius of the drops (um): a number, or a formula of grids, as in `6 + 0.5*sqrt(age)`, voxel by voxel.
    pub effective_radius_um: EffectiveRadius,
    /// Effective variance of all drops, 0..1/2.
    #[serde(default)]
    #[schemars(extend("minimum" = 0.0, "exclusiveMaximum" = 0.5))]
    pub effective_variance: f64,
    /// Which axis points up in the file.
    #[serde(default)]
    pub up: Up,
    /// How many units of the file make a metre: 100 for one in centimetres.
    #[serde(default = "metres")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub units_per_m: f64,
    /// Edge of the voxels of the drops (m), at most eight of the shortest steps of the grid, which it is where left out.
    #[serde(default)]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub voxel_m: Option<f64>,
}

fn metres() -> f64 {
    1.0
}

/// The name that Blender, Houdini and `OpenVDB`'s own tools give to the density of smoke.
fn usual_grid() -> String {
    "density".to_string()
}

/// A drop volume on disk.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DropFile {
    /// Path of the OpenVDB file, relative to the scene file.
    #[schemars(length(min = 1))]
    pub file: String,
}

impl DropSource {
    /// The shape to lay out; `None` if the drops come from a file.
    pub fn shape(&self) -> Option<Shape> {
        match self {
            Self::Shape(shape) => Some(*shape),
            Self::FromVdb(_) | Self::File(_) => None,
        }
    }

    /// The name by which scene files and the program call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Shape(shape) => shape.name(),
            Self::FromVdb(_) => FROM_VDB,
            Self::File(_) => FILE,
        }
    }
}

impl FromVdb {
    /// Checks its keys, as a whole.
    ///
    /// # Errors
    /// The first that is out of its range, by name.
    pub fn validate(&self) -> Result<(), niji_dropfield::Error> {
        if !(self.units_per_m.is_finite() && self.units_per_m > 0.0) {
            return Err(niji_dropfield::Error::BadSetting {
                parameter: "units_per_m",
                found: self.units_per_m,
                expected: "a finite number above 0",
            });
        }
        self.import().validate()
    }

    /// How the grid becomes drops.
    pub fn import(&self) -> DensityImport {
        DensityImport {
            density_means: self.density_means,
            scale: self.scale,
            effective_radius_um: self.effective_radius_um.clone(),
            effective_variance: self.effective_variance,
            to_metres: (self.up.to_y_up() * (1.0 / self.units_per_m)).to_cols_array_2d(),
            voxel_m: self.voxel_m,
        }
    }
}

/// By hand, so that shapes keep their own names beside `from-vdb` and `file`: serde's untagged
/// variants buffer their content and lose the line of what is wrong in it.
impl<'de> Deserialize<'de> for DropSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_enum("DropSource", names::all(), SourceVisitor)
    }
}

struct SourceVisitor;

impl<'de> Visitor<'de> for SourceVisitor {
    type Value = DropSource;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a shape or a file")
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<DropSource, A::Error> {
        let (name, content) = data.variant::<String>()?;
        match name.as_str() {
            FROM_VDB => content.newtype_variant().map(DropSource::FromVdb),
            FILE => content.newtype_variant().map(DropSource::File),
            _ => {
                let shape = EnumAccessDeserializer::new(NamedContent { name, content });
                Shape::deserialize(shape).map(DropSource::Shape)
            }
        }
    }
}

/// A variant whose name was read already.
struct NamedContent<C> {
    name: String,
    content: C,
}

impl<'de, C: VariantAccess<'de>> EnumAccess<'de> for NamedContent<C> {
    type Error = C::Error;
    type Variant = C;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, C), C::Error> {
        Ok((
            seed.deserialize(self.name.into_deserializer())?,
            self.content,
        ))
    }
}
