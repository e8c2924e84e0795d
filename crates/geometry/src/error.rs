//! What can be wrong with a camera or a mesh.

use std::path::PathBuf;

use glam::DVec3;

use crate::pixel_region::PixelRegion;

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
    /// A region without pixels, or too far from the frame.
    #[error(
        "found the region {found} (x, y, width, height), expected at least one pixel and none \
         farther than 16777216 from the frame's corner"
    )]
    Region {
        /// The region asked for.
        found: PixelRegion,
    },
    /// No bands, or bands without rows.
    #[error("found {n_bands} tiles of {n_rows} rows, expected 1 to {n_rows}")]
    Bands {
        /// Bands asked for.
        n_bands: u32,
        /// Rows to be shared out.
        n_rows: u32,
    },
    /// A camera whose pictures bend straight lines where that will not do.
    #[error("found a fisheye or a panorama, expected a pinhole camera")]
    NotPinhole,
    /// The angles of a fisheye camera lie above 0 and up to 360 degrees.
    #[error("found a fisheye angle of {found_deg} degrees, expected more than 0 and at most 360")]
    FisheyeAngle {
        /// The field of view or image circle asked for, in degrees.
        found_deg: f64,
    },
    /// A panorama of all directions has square pixels.
    #[error(
        "found a panorama of {width_px} x {height_px} pixels, expected one twice as wide as high"
    )]
    PanoramaShape {
        /// Width asked for.
        width_px: u32,
        /// Height asked for.
        height_px: u32,
    },
    /// A lens or a sensor without a size.
    #[error("found a {name} of {found_mm} mm, expected more than 0")]
    LensLength {
        /// Which length.
        name: &'static str,
        /// The length asked for, in millimetres.
        found_mm: f64,
    },
    /// NaN or infinity in a position, an angle or a matrix.
    #[error("found a position, an angle or a matrix that is not of finite numbers")]
    NotFinite,
    /// A camera matrix for row vectors.
    #[error(
        "found a matrix with the position in its last row, expected it in the last column: \
         transpose it"
    )]
    MatrixIsTransposed,
    /// A camera matrix that does more than turn and move.
    #[error("found a matrix with the last row {found:?}, expected 0, 0, 0, 1")]
    MatrixIsProjective {
        /// The last row.
        found: [f64; 4],
    },
    /// A camera matrix that stretches or shears.
    #[error(
        "found a matrix with axes of lengths {lengths:?} or not at right angles, expected a \
         rotation: apply the camera's scale"
    )]
    MatrixScales {
        /// Lengths of its first three columns.
        lengths: [f64; 3],
    },
    /// A camera matrix that makes a left hand of a right one.
    #[error("found a matrix that mirrors, expected a rotation")]
    MatrixMirrors,
    /// A corner of a mesh with NaN or infinity.
    #[error("found a corner, number {index} from 0, that is not finite")]
    VertexNotFinite {
        /// Its number, from 0.
        index: usize,
    },
    /// A normal of a mesh with NaN or infinity.
    #[error("found a normal, of triangle {index} from 0, that is not finite")]
    NormalNotFinite {
        /// The number of its triangle, from 0.
        index: usize,
    },
    /// A texture coordinate of a mesh with NaN or infinity.
    #[error("found a texture coordinate, of triangle {index} from 0, that is not finite")]
    UvNotFinite {
        /// The number of its triangle, from 0.
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
    #[error("found a mesh without a triangle, expected at least one")]
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
    /// Heights of which no field is made.
    #[error("found {n_x} x {n_z} heights, expected at least 2 x 2 and one number for each")]
    HeightCount {
        /// From west to east.
        n_x: usize,
        /// From north to south.
        n_z: usize,
    },
    /// A height with NaN or infinity.
    #[error("found a height, column {x}, row {z}, that is not finite")]
    HeightNotFinite {
        /// Its column, from 0 in the west.
        x: usize,
        /// Its row, from 0 in the north.
        z: usize,
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
