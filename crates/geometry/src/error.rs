//! What can be wrong with a camera or a mesh.

use std::path::PathBuf;

use glam::DVec3;

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The field of view of a pinhole camera lies strictly between 0 and 180 degrees.
    #[error("found a field of view of {found_deg} degrees, expected more than 0 and less than 180")]
    FieldOfView {
        /// The field of view asked for, in degrees.
        found_deg: f64,
    },
    /// A picture needs pixels.
    #[error("found a picture of {width_px} x {height_px} pixels, expected at least 1 x 1")]
    EmptyPicture {
        /// Width asked for.
        width_px: u32,
        /// Height asked for.
        height_px: u32,
    },
    /// NaN or infinity in a position or an angle.
    #[error("found a position or an angle that is not a finite number")]
    NotFinite,
    /// A corner of a mesh with NaN or infinity.
    #[error("found a corner, number {index} from 0, that is not finite")]
    VertexNotFinite {
        /// Its number, from 0.
        index: usize,
    },
    /// A triangle that names a corner which is not there.
    #[error("found a triangle with corner {index}, expected less than {n_vertices}")]
    VertexIndex {
        /// The number of the corner.
        index: u32,
        /// How many there are.
        n_vertices: usize,
    },
    /// No triangle, or none with three different corners.
    #[error("found a mesh without a triangle, expected a closed surface")]
    EmptyMesh,
    /// A surface with a hole, or with triangles that contradict each other about what is outside.
    #[error(
        "found {n_edges} edges without a partner that runs the other way, the first from {from} to \
         {to}: expected a closed surface whose triangles run alike"
    )]
    OpenMesh {
        /// Edges without a partner.
        n_edges: usize,
        /// Where the first of them begins, m.
        from: DVec3,
        /// Where it ends, m.
        to: DVec3,
    },
    /// A closed surface that encloses nothing.
    #[error("found a closed surface that encloses no volume")]
    FlatMesh,
    /// A file whose name does not say how to read it.
    #[error("{}: expected a mesh named *.obj, *.gltf, *.glb or *.stl", path.display())]
    MeshFormat {
        /// The file.
        path: PathBuf,
    },
    /// A mesh file that is missing or damaged.
    #[error("{}: {message}", path.display())]
    MeshFile {
        /// The file.
        path: PathBuf,
        /// What its reader says.
        message: String,
    },
}
