//! Linear maps in a file: a name and the numbers of that kind of map.
//!
//! Scale maps hold the scale, its absolute value, 1/s, 1/s² and 1/(2 s), each a vector; only the
//! scale is information. An affine map holds a 4x4 matrix by rows, for row vectors on its left.
//! Source: OpenVDB, math/Maps.h.

use glam::DMat3;
use glam::DVec3;

use crate::Error;
use crate::Transform;
use crate::output::push_text;
use crate::source::Source;

const MAP: &str = "a map";

/// Vectors of a scale map that follow from the scale.
const N_DERIVED: usize = 4;

/// The last column of an affine matrix.
const AFFINE_COLUMN: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Read the name and the body of a map.
pub(crate) fn read(input: &mut impl Source) -> Result<Transform, Error> {
    let name = input.text(MAP)?;
    match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => scale(input, DVec3::ZERO),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let translation = DVec3::from(input.f64s(MAP)?);
            scale(input, translation)
        }
        "TranslationMap" => Transform::affine(DMat3::IDENTITY, DVec3::from(input.f64s(MAP)?)),
        "AffineMap" | "UnitaryMap" => affine(input),
        _ => Err(Error::Unsupported {
            what: "map",
            found: name,
            expected: "a linear map (scale, translation, affine or unitary): resample the frustum of a camera to a box first \
                       (VDB Resample in Houdini)",
        }),
    }
}

fn scale(input: &mut impl Source, translation: DVec3) -> Result<Transform, Error> {
    let scale = DVec3::from(input.f64s(MAP)?);
    for _ in 0..N_DERIVED {
        input.f64s::<3>(MAP)?;
    }
    Transform::affine(DMat3::from_diagonal(scale), translation)
}

fn affine(input: &mut impl Source) -> Result<Transform, Error> {
    let mut rows = [DVec3::ZERO; 4];
    for (row, affine) in rows.iter_mut().zip(AFFINE_COLUMN) {
        let [x, y, z, last] = input.f64s(MAP)?;
        // Compared exactly: every affine matrix is stored with these very numbers.
        if last != affine {
            return Err(input.damaged(format!(
                "an affine matrix with {last} where {affine} must be"
            )));
        }
        *row = DVec3::new(x, y, z);
    }
    let [x, y, z, translation] = rows;
    Transform::affine(DMat3::from_cols(x, y, z), translation)
}

/// Append the simplest map that holds a transform.
pub(crate) fn push(bytes: &mut Vec<u8>, transform: &Transform) {
    let translation = transform.translation();
    let Some(scale) = transform.diagonal() else {
        return push_affine(bytes, transform);
    };
    let uniform = scale == DVec3::splat(scale.x);
    // Compared exactly: a translation that is stored as zero is none.
    let moved = translation != DVec3::ZERO;
    push_text(
        bytes,
        match (uniform, moved) {
            (true, false) => "UniformScaleMap",
            (true, true) => "UniformScaleTranslateMap",
            (false, false) => "ScaleMap",
            (false, true) => "ScaleTranslateMap",
        },
    );
    if moved {
        push_vector(bytes, translation);
    }
    let inverse = 1.0 / scale;
    for vector in [
        scale,
        scale.abs(),
        inverse,
        inverse * inverse,
        0.5 * inverse,
    ] {
        push_vector(bytes, vector);
    }
}

fn push_affine(bytes: &mut Vec<u8>, transform: &Transform) {
    push_text(bytes, "AffineMap");
    let linear = transform.linear();
    let rows = [
        linear.x_axis,
        linear.y_axis,
        linear.z_axis,
        transform.translation(),
    ];
    for (row, last) in rows.into_iter().zip(AFFINE_COLUMN) {
        push_vector(bytes, row);
        bytes.extend_from_slice(&last.to_le_bytes());
    }
}

fn push_vector(bytes: &mut Vec<u8>, vector: DVec3) {
    for component in vector.to_array() {
        bytes.extend_from_slice(&component.to_le_bytes());
    }
}
