//! Reading a file: its header, then grid after grid.
//!
//! A grid has a descriptor (unique name, type of its tree, name of the grid whose tree it shares,
//! three offsets), a compression word, metadata, a map, the topology of its tree and the values of
//! its leaves. Sources: OpenVDB, io/Archive.cc and io/GridDescriptor.cc.

use std::collections::HashMap;
use std::io::Read;

use crate::Error;
use crate::Grid;
use crate::Metadata;
use crate::Transform;
use crate::Tree;
use crate::VdbFile;
use crate::decode::Decoder;
use crate::input::Input;
use crate::items;
use crate::maps;
use crate::read_tree::TreeReader;

/// ` BDV` and four zeros.
pub(crate) const MAGIC: u64 = 0x5644_4220;

/// The oldest version with value blocks that begin with a code.
const OLDEST_VERSION: u32 = 222;

/// The newest version there is (OpenVDB 13).
const NEWEST_VERSION: u32 = 225;

/// Length of the UUID in characters.
pub(crate) const UUID_LENGTH: usize = 36;

/// Ends the type of a grid whose reals are stored as halves.
const HALF_SUFFIX: &str = "_HalfFloat";

/// Between the name of a grid and the number that makes it unique.
pub(crate) const NAME_SEPARATOR: char = '\u{1e}';

const EXPECTED_TYPES: &str = "Tree_T_5_4_3 with T = float, double, vec3s, int32 or bool";

/// What stands in front of a grid.
struct Descriptor {
    unique_name: String,
    grid_type: String,
    parent: String,
    grid_position: i64,
    leaves_position: i64,
    end_position: i64,
}

/// A grid without its tree.
struct Head {
    metadata: Metadata,
    transform: Transform,
}

/// Read a file of `length` bytes.
pub(crate) fn file<R: Read>(source: R, length: u64) -> Result<VdbFile, Error> {
    let mut input = Input::new(source, length);
    let has_offsets = header(&mut input)?;
    let metadata = items::read(&mut input)?;
    let n_grids = input.i32("the number of grids")?;
    if n_grids < 0 {
        return Err(input.damaged(format!("{n_grids} grids")));
    }
    let mut grids = Vec::new();
    let mut places = HashMap::new();
    for place in 0..n_grids as usize {
        let descriptor = descriptor(&mut input)?;
        let read = grid(&mut input, &descriptor, has_offsets, |parent| {
            places
                .get(parent)
                .and_then(|&place: &usize| grids.get(place))
        });
        let name = plain_name(&descriptor.unique_name);
        grids.push(read.map_err(|error| error.in_grid(name))?);
        places.insert(descriptor.unique_name, place);
    }
    Ok(VdbFile { metadata, grids })
}

/// Read the header; says whether the offsets in the descriptors mean something.
fn header<R: Read>(input: &mut Input<R>) -> Result<bool, Error> {
    let found = input.array("the magic number").map(u64::from_le_bytes)?;
    if found != MAGIC {
        return Err(Error::NotVdb {
            found,
            expected: MAGIC,
        });
    }
    let version = input.u32("the file version")?;
    if !(OLDEST_VERSION..=NEWEST_VERSION).contains(&version) {
        let (oldest, newest) = (OLDEST_VERSION, NEWEST_VERSION);
        return Err(Error::Version {
            found: version,
            oldest,
            newest,
        });
    }
    input.bytes(8, "the library version")?;
    let has_offsets = input.u8("the header")?;
    if has_offsets > 1 {
        return Err(input.damaged(format!(
            "{has_offsets} where 0 or 1 says if there are offsets"
        )));
    }
    input.bytes(UUID_LENGTH, "the UUID")?;
    Ok(has_offsets == 1)
}

fn descriptor<R: Read>(input: &mut Input<R>) -> Result<Descriptor, Error> {
    const WHAT: &str = "the descriptor of a grid";
    Ok(Descriptor {
        unique_name: input.text(WHAT)?,
        grid_type: input.text(WHAT)?,
        parent: input.text(WHAT)?,
        grid_position: input.i64(WHAT)?,
        leaves_position: input.i64(WHAT)?,
        end_position: input.i64(WHAT)?,
    })
}

fn plain_name(unique_name: &str) -> &str {
    unique_name
        .split(NAME_SEPARATOR)
        .next()
        .unwrap_or(unique_name)
}

fn grid<'a, R: Read>(
    input: &mut Input<R>,
    descriptor: &Descriptor,
    has_offsets: bool,
    earlier: impl Fn(&str) -> Option<&'a Grid>,
) -> Result<Grid, Error> {
    if has_offsets {
        input.skip_to(descriptor.grid_position, "the start of a grid")?;
    }
    let compression = input.u32("the compression of a grid")?;
    let mut head = Head {
        metadata: items::read(input)?,
        transform: maps::read(input)?,
    };
    let tree = if descriptor.parent.is_empty() {
        let leaves_position = has_offsets.then_some(descriptor.leaves_position);
        tree(input, &descriptor.grid_type, compression, leaves_position)?
    } else {
        let parent = earlier(&descriptor.parent);
        let missing = || Error::MissingParent {
            parent: plain_name(&descriptor.parent).to_owned(),
        };
        instance(input, &parent.ok_or_else(missing)?.tree)?
    };
    if has_offsets {
        input.skip_to(descriptor.end_position, "the end of a grid")?;
    }
    let named = head
        .metadata
        .get_str("name")
        .filter(|name| !name.is_empty());
    let name = named
        .unwrap_or(plain_name(&descriptor.unique_name))
        .to_owned();
    let class = head
        .metadata
        .get_str("class")
        .unwrap_or("unknown")
        .to_owned();
    head.metadata.remove("name");
    head.metadata.remove("class");
    Ok(Grid {
        name,
        class,
        metadata: head.metadata,
        transform: head.transform,
        tree,
    })
}

/// A copy of the tree of an earlier grid.
fn instance<R: Read>(input: &mut Input<R>, parent: &Tree) -> Result<Tree, Error> {
    input.charge(match parent {
        Tree::Float(tree) => tree.memory(),
        Tree::Double(tree) => tree.memory(),
        Tree::Vec3s(tree) => tree.memory(),
        Tree::Int32(tree) => tree.memory(),
        Tree::Bool(tree) => tree.memory(),
    })?;
    Ok(parent.clone())
}

fn tree<R: Read>(
    input: &mut Input<R>,
    grid_type: &str,
    compression: u32,
    leaves_position: Option<i64>,
) -> Result<Tree, Error> {
    let (full_type, half) = match grid_type.strip_suffix(HALF_SUFFIX) {
        Some(full_type) => (full_type, true),
        None => (grid_type, false),
    };
    let reader = TreeReader {
        decoder: Decoder::new(compression, half),
        leaves_position,
    };
    match full_type {
        "Tree_float_5_4_3" => reader.read(input).map(Tree::Float),
        "Tree_double_5_4_3" => reader.read(input).map(Tree::Double),
        "Tree_vec3s_5_4_3" => reader.read(input).map(Tree::Vec3s),
        "Tree_int32_5_4_3" => reader.read(input).map(Tree::Int32),
        "Tree_bool_5_4_3" => reader.read(input).map(Tree::Bool),
        _ => Err(Error::Unsupported {
            what: "grid type",
            found: grid_type.to_owned(),
            expected: EXPECTED_TYPES,
        }),
    }
}
