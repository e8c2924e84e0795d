//! The levels of accuracy of the ray integral: one enum for each decision.
//!
//! Errors below are relative RMSE of radiance against `Adaptive` at 1e-10, on a gradient of drop size
//! and density over 64^3 nodes and on a homogeneous box, 640 x 480 rays, shadows on, the same table
//! and sun volume on both sides (`cargo bench -p niji-render`, November 2026).

use niji_geometry::Aabb;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::sun_sweep::fitting_voxel_m;

/// How the integral along a view ray through the drops is taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Integration {
    /// The literal sum of equal steps with the midpoint rule, the published form:
    /// L = dt sum_i I(a(x_i), theta) rho(x_i). The last step ends at the face of the volume.
    /// Steps of 3 m, a voxel of the gradient: 9e-4 and 6e-5.
    FixedStep {
        /// Length of a step in metres.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        step_m: f64,
    },
    /// Cell by cell, exact for the interpolated moments: the optical depth of a cell is the integral
    /// of its cubic, the light of a cell that is not shadowed is `-expm1(-dtau)` whatever its
    /// thickness, and two Gauss points a piece carry sizes and shadow. Cells in which optical depth
    /// or drop size change fast are cut into pieces; of those in which next to nothing changes, one
    /// point carries as many as keep to a millionth. 6e-6 and 1e-6, the first at nodes of the table.
    CellExact,
    /// As [`Integration::CellExact`], with the number of Gauss points, pieces and cells that one point
    /// carries taken from the error terms of the rules, so that each keeps to `relative_error`; and by
    /// cells up to 8 voxels wide where the drops are so even that these do. At 1e-4: 4e-6 and 7e-6; at
    /// 1e-2: 1.5e-3 and 7e-6.
    Adaptive {
        /// Largest relative error of the light of a piece, 1e-12..1.
        #[schemars(range(min = 1e-12, max = 1.0))]
        relative_error: f64,
    },
}

/// Which part of the extinction of drops is taken out of the picture, sigma = Q pi M2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DropExtinctionModel {
    /// Q = 1: half of a large drop's extinction is diffraction into a lobe narrower than the bow,
    /// and that light does not leave the picture.
    WithoutDiffraction,
    /// Q = 2: the whole extinction, for strict first order and for comparison with other programs.
    Full,
}

impl DropExtinctionModel {
    /// Extinction efficiency Q of a drop that is large against the wavelength.
    pub fn efficiency(self) -> f64 {
        match self {
            Self::WithoutDiffraction => 1.0,
            Self::Full => 2.0,
        }
    }
}

/// How the optical depth of the drops towards the sun is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum SunPath {
    /// Drops cast no shadow on drops.
    Ignore,
    /// A volume of optical depth, swept layer by layer away from the sun; the cost of a node does
    /// not depend on the depth of the volume, and shadows stay as sharp as they were cast. Light of a
    /// slab of optical depth 1 over 64 voxels: error 3e-5 with the sun 30 degrees from the zenith, 9e-4
    /// at 80; it falls with the square of the voxel.
    Volume {
        /// Distance of the nodes in metres.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        voxel_m: f64,
    },
    /// A march from every node of the drops to the sun, with the midpoint rule.
    March {
        /// Length of a step in metres.
        #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e7))]
        step_m: f64,
    },
}

impl SunPath {
    /// The level with a voxel that is large enough for a box of drops; itself where it fits.
    #[must_use]
    pub fn fitting(self, bounds: Aabb) -> Self {
        match self {
            Self::Volume { voxel_m } => Self::Volume {
                voxel_m: fitting_voxel_m(bounds.max - bounds.min, voxel_m),
            },
            Self::Ignore | Self::March { .. } => self,
        }
    }
}

/// How much air lies on a path, and at how many places of it its light is computed: ten, or three quarters of
/// the nodes of the quadrature.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum AirPath {
    /// The density at the eye along every view ray, and the eye's own way to the sun for all points:
    /// for scenes that are small against the scale height of the air.
    Constant,
    /// Equal steps with the midpoint rule, the published form.
    Midpoint {
        /// Steps on each path.
        #[schemars(range(min = 1, max = 1_000_000))]
        n_steps: usize,
    },
    /// Gauss-Legendre nodes, on the way to the sun after the substitution s = D u^2.
    Quadrature {
        /// Nodes on each path.
        #[schemars(range(min = 1, max = 256))]
        n_nodes: usize,
    },
    /// Columns and profiles that were integrated when the air table was made.
    Table,
}

impl AirPath {
    /// The same with twice as many places on each path, where their number is a choice.
    pub(crate) fn finer(self) -> Self {
        match self {
            Self::Midpoint { n_steps } => Self::Midpoint {
                n_steps: 2 * n_steps,
            },
            Self::Quadrature { n_nodes } => Self::Quadrature {
                n_nodes: 2 * n_nodes,
            },
            Self::Constant | Self::Table => self,
        }
    }
}

/// What shines behind the drops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SkyModel {
    /// Black.
    None,
    /// Sunlight scattered once by the air, and the ground in direct sunlight. A clear sky misses 8 to
    /// 60 % of its light, a hazy one far more.
    SingleScattering,
    /// Besides, light that air and ground scattered before, behind the drops and in front of them,
    /// and skylight on the ground: from an air table that holds it. Within 2 % of all light.
    MultipleScattering,
}

/// How often light is scattered by drops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum DropOrders {
    /// Once.
    SingleScattering,
    /// Any number of times: the first order as before, and light that was scattered before, by paths
    /// on two lattices of view directions, a coarse one with many and one four times as fine with few.
    MultipleScattering {
        /// Directions along both sides of the coarse lattice, 2 to 128.
        #[schemars(range(min = 2, max = 128))]
        nodes_across: usize,
        /// Paths from each direction of it and each quarter of the light seen there, 2 to 2^20.
        #[schemars(range(min = 2, max = 1_048_576))]
        paths_per_node: usize,
    },
}

/// What of a pixel is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum PixelFootprint {
    /// The ray through its center.
    Center,
    /// The ray through its center, with the scattering table averaged over the angle that the pixel
    /// spans: no aliasing of supernumeraries for a few more table entries a ray.
    Prefiltered,
    /// n x n rays.
    Grid {
        /// Rays along a side of the pixel.
        #[schemars(range(min = 1, max = 64))]
        n: u32,
    },
}

/// One level for each stage of the integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderLevels {
    /// The integral along the view ray.
    pub integration: Integration,
    /// Extinction of drops on the view path and on the sun's.
    pub drop_extinction_model: DropExtinctionModel,
    /// Light scattered by more than one drop.
    pub drop_orders: DropOrders,
    /// Air on the sun's path and on the view path.
    pub air_path: AirPath,
    /// What shines behind the drops.
    pub sky_model: SkyModel,
    /// What of a pixel is seen.
    pub pixel_footprint: PixelFootprint,
}
