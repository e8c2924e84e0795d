//! Reading: the archive, its grids, their maps and metadata.

use glam::DMat3;
use glam::DVec3;

use crate::Error;
use crate::Grid;
use crate::MetaValue;
use crate::Metadata;
use crate::SparseTree;
use crate::Transform;
use crate::Tree;
use crate::Value;
use crate::VdbFile;
use crate::cursor::Cursor;
use crate::read_tree::TreeReader;
use crate::value::sealed::Bytes;

/// The first eight bytes of a VDB file.
pub(crate) const MAGIC: u64 = 0x5644_4220;
/// Oldest file version that is read: before it nodes were stored in another way.
const OLDEST: u32 = 222;
/// Newest file version that is read.
const NEWEST: u32 = 225;
/// Length of the UUID in the header.
const N_UUID: usize = 36;
/// Suffix of the type of a grid whose reals are stored in 16 bits.
const HALF_SUFFIX: &str = "_HalfFloat";
/// Character between a name and the number that makes it unique.
const NAME_SEPARATOR: char = '\u{1e}';

struct Descriptor {
    unique_name: String,
    grid_type: String,
    instance_parent: String,
}

pub(crate) fn parse(bytes: &[u8]) -> Result<VdbFile, Error> {
    let mut cursor = Cursor::new(bytes);
    let found = cursor.u64("the magic number")?;
    if found != MAGIC {
        return Err(Error::NotVdb { found, expected: MAGIC });
    }
    let version = cursor.u32("the file version")?;
    if !(OLDEST..=NEWEST).contains(&version) {
        return Err(Error::Version { found: version, oldest: OLDEST, newest: NEWEST });
    }
    cursor.take(8, "the library version")?;
    let has_offsets = cursor.u8("the offset flag")? != 0;
    cursor.take(N_UUID, "the UUID")?;
    let metadata = read_metadata(&mut cursor)?;
    let n_grids = cursor.i32("the number of grids")?;
    let mut file = VdbFile { metadata, grids: Vec::new() };
    let mut unique_names = Vec::new();
    for _ in 0..n_grids {
        let descriptor = Descriptor {
            unique_name: cursor.string("a grid name")?,
            grid_type: cursor.string("a grid type")?,
            instance_parent: cursor.string("an instance parent")?,
        };
        if has_offsets {
            let position = cursor.i64("a grid offset")?;
            cursor.take(8, "a block offset")?;
            let end = cursor.i64("an end offset")?;
            cursor.seek(position, "a grid")?;
            let grid = read_grid(&mut cursor, &descriptor, &file, &unique_names);
            file.grids.push(grid.map_err(|error| error.in_grid(name(&descriptor)))?);
            cursor.seek(end, "the end of a grid")?;
        } else {
            let grid = read_grid(&mut cursor, &descriptor, &file, &unique_names);
            file.grids.push(grid.map_err(|error| error.in_grid(name(&descriptor)))?);
        }
        unique_names.push(descriptor.unique_name);
    }
    Ok(file)
}

fn name(descriptor: &Descriptor) -> &str {
    descriptor.unique_name.split(NAME_SEPARATOR).next().unwrap_or_default()
}

fn read_grid(
    cursor: &mut Cursor,
    descriptor: &Descriptor,
    file: &VdbFile,
    unique_names: &[String],
) -> Result<Grid, Error> {
    let compression = cursor.u32("the compression flags")?;
    let metadata = read_metadata(cursor)?;
    let transform = read_transform(cursor)?;
    let tree = if descriptor.instance_parent.is_empty() {
        read_tree(cursor, &descriptor.grid_type, compression)?
    } else {
        let parent = &descriptor.instance_parent;
        let index = unique_names.iter().position(|name| name == parent);
        let missing = || cursor.damaged(format!("an instance of {parent:?}, which does not precede it"));
        file.grids[index.ok_or_else(missing)?].tree.clone()
    };
    let class = metadata.get_str("class").unwrap_or("unknown").to_owned();
    Ok(Grid { name: name(descriptor).to_owned(), class, metadata, transform, tree })
}

fn read_tree(cursor: &mut Cursor, grid_type: &str, compression: u32) -> Result<Tree, Error> {
    let is_half = grid_type.ends_with(HALF_SUFFIX);
    let plain = grid_type.strip_suffix(HALF_SUFFIX).unwrap_or(grid_type);
    let reader = TreeReader { compression, is_half };
    match plain {
        "Tree_float_5_4_3" => Ok(Tree::Float(typed(cursor, reader)?)),
        "Tree_double_5_4_3" => Ok(Tree::Double(typed(cursor, reader)?)),
        "Tree_vec3s_5_4_3" => Ok(Tree::Vec3s(typed(cursor, reader)?)),
        "Tree_int32_5_4_3" => Ok(Tree::Int32(typed(cursor, reader)?)),
        "Tree_bool_5_4_3" => Ok(Tree::Bool(typed(cursor, reader)?)),
        _ => Err(Error::Unsupported {
            what: "grid type",
            found: grid_type.to_owned(),
            expected: "Tree_T_5_4_3 with T = float, double, vec3s, int32 or bool",
        }),
    }
}

fn typed<T: Value + Bytes>(
    cursor: &mut Cursor,
    reader: TreeReader,
) -> Result<SparseTree<T>, Error> {
    reader.read(cursor)
}

fn read_metadata(cursor: &mut Cursor) -> Result<Metadata, Error> {
    let mut metadata = Metadata::new();
    let n_items = cursor.u32("the number of metadata items")?;
    for _ in 0..n_items {
        let name = cursor.string("a metadata name")?;
        let type_name = cursor.string("a metadata type")?;
        let n_bytes = cursor.u32("the size of a metadata item")? as usize;
        let bytes = cursor.take(n_bytes, "a metadata item")?;
        metadata.insert(name, meta_value(type_name, bytes));
    }
    Ok(metadata)
}

fn meta_value(type_name: String, bytes: &[u8]) -> MetaValue {
    let mut cursor = Cursor::new(bytes);
    let what = "a metadata value";
    let value = match (type_name.as_str(), bytes.len()) {
        ("bool", 1) => Some(MetaValue::Bool(bytes[0] != 0)),
        ("int32", 4) => cursor.i32(what).ok().map(MetaValue::Int32),
        ("int64", 8) => cursor.i64(what).ok().map(MetaValue::Int64),
        ("float", 4) => Some(MetaValue::Float(f32::decode(bytes))),
        ("double", 8) => cursor.f64(what).ok().map(MetaValue::Double),
        ("string", _) => Some(MetaValue::String(String::from_utf8_lossy(bytes).into_owned())),
        ("vec3i", 12) => Some(MetaValue::Vec3i([0, 4, 8].map(|at| i32::decode(&bytes[at..])))),
        ("vec3s", 12) => Some(MetaValue::Vec3s(<[f32; 3]>::decode(bytes))),
        ("vec3d", 24) => Some(MetaValue::Vec3d([0, 8, 16].map(|at| f64::decode(&bytes[at..])))),
        _ => None,
    };
    value.unwrap_or_else(|| MetaValue::Unknown { type_name, bytes: bytes.to_vec() })
}

fn read_transform(cursor: &mut Cursor) -> Result<Transform, Error> {
    let name = cursor.string("the name of a map")?;
    match name.as_str() {
        "UniformScaleMap" | "ScaleMap" => {
            let scale = vec3d(cursor)?;
            cursor.take(4 * 24, "a map")?;
            Transform::affine(DMat3::from_diagonal(scale), DVec3::ZERO)
        }
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let (translation, scale) = (vec3d(cursor)?, vec3d(cursor)?);
            cursor.take(4 * 24, "a map")?;
            Transform::affine(DMat3::from_diagonal(scale), translation)
        }
        "TranslationMap" => Transform::affine(DMat3::IDENTITY, vec3d(cursor)?),
        "AffineMap" | "UnitaryMap" => {
            let mut rows = [[0.0; 4]; 4];
            for value in rows.iter_mut().flatten() {
                *value = cursor.f64("a map")?;
            }
            // OpenVDB multiplies row vectors: the rows are the steps of a voxel along each axis.
            let [x, y, z, translation] = rows.map(|row| DVec3::new(row[0], row[1], row[2]));
            Transform::affine(DMat3::from_cols(x, y, z), translation)
        }
        _ => Err(Error::Unsupported {
            what: "map",
            found: name,
            expected: "a linear one: scale, translation, affine or unitary",
        }),
    }
}

fn vec3d(cursor: &mut Cursor) -> Result<DVec3, Error> {
    Ok(DVec3::new(cursor.f64("a map")?, cursor.f64("a map")?, cursor.f64("a map")?))
}
