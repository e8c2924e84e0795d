//! Reading a file: its header, what stands in front of the voxels of each grid, then the voxels.
//!
//! A grid has a descriptor (unique name, type of its tree, name of the grid whose tree it shares,
//! three offsets), a compression word, metadata, a map, the topology of its tree and the values of
//! its leaves. The offsets are absolute and name the compression word, the leaves and the end; a
//! file that was written to a stream has none. Sources: OpenVDB, io/Archive.cc and
//! io/GridDescriptor.cc.

use std::collections::HashMap;
use std::io::Read;
use std::io::Seek;

use crate::Error;
use crate::Grid;
use crate::GridHeader;
use crate::Metadata;
use crate::Tree;
use crate::VdbFile;
use crate::VdbHeader;
use crate::decode::Decoder;
use crate::input::Input;
use crate::items;
use crate::maps;
use crate::read_tree::TreeReader;
use crate::source::Source;

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

const EXPECTED_TYPES: &str = "Tree_T_5_4_3 with T = float, double, half, vec3s, int32 or bool";

/// A file whose headers have been read.
pub(crate) struct Archive<R> {
    pub(crate) input: Input<R>,
    file_version: u32,
    /// Whether the offsets in the descriptors mean something.
    pub(crate) has_offsets: bool,
    metadata: Metadata,
    /// The grids in the order of the file.
    pub(crate) entries: Vec<Entry>,
}

/// A grid whose tree has not been read.
pub(crate) struct Entry {
    /// For the user.
    pub(crate) header: GridHeader,
    /// Where its parts stand in the file.
    pub(crate) places: Places,
    unique_name: String,
    /// Unique name of the grid whose tree it shares; empty if it has its own.
    parent: String,
    compression: u32,
    /// Why the map is not one that is read; told when the voxels are wanted.
    map_fault: Option<Error>,
    /// The tree, where it had to be decoded to find its end.
    tree: Option<Tree>,
}

/// Where the parts of a grid stand, in the order of the file.
pub(crate) struct Places {
    tree: u64,
    /// The leaves, as the file says.
    pub(crate) leaves: i64,
    /// The end of the grid, and the start of the next one.
    pub(crate) end: u64,
}

impl<R: Read + Seek> Archive<R> {
    /// Read the headers of a file of `length` bytes.
    pub(crate) fn open(source: R, length: u64) -> Result<Self, Error> {
        let mut input = Input::new(source, length);
        let (file_version, has_offsets) = file_head(&mut input)?;
        let metadata = items::read(&mut input)?;
        let n_grids = input.i32("the number of grids")?;
        if n_grids < 0 {
            return Err(input.damaged(format!("{n_grids} grids")));
        }
        let mut entries = Vec::new();
        for _ in 0..n_grids {
            // Twice, as the vector grows by doubling.
            input.charge(2 * size_of::<Entry>() as u64)?;
            entries.push(entry(&mut input, has_offsets)?);
        }
        Ok(Self {
            input,
            file_version,
            has_offsets,
            metadata,
            entries,
        })
    }

    /// Use no more memory than this.
    pub(crate) fn limit_memory(&mut self, most_bytes: u64) {
        self.input.limit_memory(most_bytes);
    }

    /// The headers alone.
    pub(crate) fn into_header(self) -> VdbHeader {
        VdbHeader {
            file_version: self.file_version,
            metadata: self.metadata,
            grids: self.entries.into_iter().map(|entry| entry.header).collect(),
        }
    }

    /// Read the grids that are wanted, and the trees that these share.
    pub(crate) fn grids(mut self, wanted: impl Fn(&GridHeader) -> bool) -> Result<VdbFile, Error> {
        let wanted = self
            .entries
            .iter()
            .map(|entry| wanted(&entry.header))
            .collect::<Vec<_>>();
        let parents = self.parents();
        let mut needed = wanted.clone();
        for place in (0..needed.len()).rev() {
            if let (true, Some(parent)) = (needed[place], parents[place]) {
                needed[parent] = true;
            }
        }
        let mut trees = Vec::<Option<Tree>>::new();
        for (place, entry) in self.entries.iter_mut().enumerate() {
            let parent = parents[place].and_then(|parent| trees[parent].as_ref());
            let tree = needed[place]
                .then(|| entry.tree(&mut self.input, parent, self.has_offsets))
                .transpose();
            trees.push(tree.map_err(|error| error.in_grid(&entry.header.name))?);
        }
        let chosen = self.entries.into_iter().zip(trees).zip(wanted);
        let grids = chosen.filter_map(|((entry, tree), wanted)| {
            let header = entry.header;
            let (tree, transform) = (tree.filter(|_| wanted)?, header.transform?);
            Some(Grid {
                name: header.name,
                class: header.class,
                metadata: header.metadata,
                transform,
                tree,
            })
        });
        Ok(VdbFile {
            metadata: self.metadata,
            grids: grids.collect(),
        })
    }

    /// For each instance the place of the last grid before it that has its parent's name.
    fn parents(&self) -> Vec<Option<usize>> {
        let mut places = HashMap::new();
        let entries = self.entries.iter().enumerate();
        entries
            .map(|(place, entry)| {
                let parent = places.get(entry.parent.as_str()).copied();
                places.insert(entry.unique_name.as_str(), place);
                parent.filter(|_| !entry.parent.is_empty())
            })
            .collect()
    }
}

/// Read the head of the file: its version, and whether the offsets mean something.
fn file_head(input: &mut impl Source) -> Result<(u32, bool), Error> {
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
    Ok((version, has_offsets == 1))
}

/// Read what stands in front of a tree, and go on to the next grid.
fn entry<R: Read + Seek>(input: &mut Input<R>, has_offsets: bool) -> Result<Entry, Error> {
    const WHAT: &str = "the descriptor of a grid";
    let unique_name = input.text(WHAT)?;
    let grid_type = input.text(WHAT)?;
    let parent = input.text(WHAT)?;
    let [start, leaves, end] = [input.i64(WHAT)?, input.i64(WHAT)?, input.i64(WHAT)?];
    let entry = Entry {
        header: GridHeader {
            name: plain_name(&unique_name).to_owned(),
            class: "unknown".to_owned(),
            grid_type,
            instance_of: (!parent.is_empty()).then(|| plain_name(&parent).to_owned()),
            metadata: Metadata::new(),
            transform: None,
        },
        places: Places {
            tree: 0,
            leaves,
            end: 0,
        },
        unique_name,
        parent,
        compression: 0,
        map_fault: None,
        tree: None,
    };
    let name = entry.header.name.clone();
    let offsets = has_offsets.then_some([start, end]);
    complete(entry, input, offsets).map_err(|error| error.in_grid(&name))
}

/// Read what stands between a descriptor and the next one: all but the tree, if the start and the
/// end of the grid are known.
fn complete<R: Read + Seek>(
    mut entry: Entry,
    input: &mut Input<R>,
    offsets: Option<[i64; 2]>,
) -> Result<Entry, Error> {
    if let Some([start, _]) = offsets {
        input.skip_to(start, "the start of a grid")?;
    }
    entry.compression = input.u32("the compression of a grid")?;
    entry.header.set_metadata(items::read(input)?);
    match maps::read(input) {
        Ok(transform) => entry.header.transform = Some(transform),
        Err(fault) if offsets.is_some() && fault.is_of_a_map() => entry.map_fault = Some(fault),
        Err(error) => return Err(error),
    }
    entry.places.tree = input.position();
    if let Some([_, end]) = offsets {
        input.skip_to(end, "the end of a grid")?;
    } else if entry.parent.is_empty() {
        entry.tree = Some(entry.own_tree(input, None)?);
    }
    entry.places.end = input.position();
    Ok(entry)
}

fn plain_name(unique_name: &str) -> &str {
    unique_name
        .split(NAME_SEPARATOR)
        .next()
        .unwrap_or(unique_name)
}

impl GridHeader {
    /// Keep metadata; two items have fields of their own.
    fn set_metadata(&mut self, mut metadata: Metadata) {
        if let Some(name) = metadata.get_str("name").filter(|name| !name.is_empty()) {
            name.clone_into(&mut self.name);
        }
        if let Some(class) = metadata.get_str("class") {
            class.clone_into(&mut self.class);
        }
        metadata.remove("name");
        metadata.remove("class");
        self.metadata = metadata;
    }
}

impl Entry {
    /// The tree: decoded already, a copy of an earlier grid's, or read now.
    fn tree<R: Read + Seek>(
        &mut self,
        input: &mut Input<R>,
        parent: Option<&Tree>,
        has_offsets: bool,
    ) -> Result<Tree, Error> {
        if let Some(fault) = self.map_fault.take() {
            return Err(fault);
        }
        if let Some(tree) = self.tree.take() {
            return Ok(tree);
        }
        if self.parent.is_empty() {
            input.seek(self.places.tree)?;
            let tree = self.own_tree(input, has_offsets.then_some(self.places.leaves))?;
            input.skip_to(self.places.end as i64, "the end of a grid")?;
            return Ok(tree);
        }
        let missing = || Error::MissingParent {
            parent: plain_name(&self.parent).to_owned(),
        };
        let parent = parent.ok_or_else(missing)?;
        input.charge(parent.memory())?;
        Ok(parent.clone())
    }

    /// Read the tree, which starts where the input stands.
    fn own_tree<R: Read + Seek>(
        &self,
        input: &mut Input<R>,
        leaves_position: Option<i64>,
    ) -> Result<Tree, Error> {
        let grid_type = self.header.grid_type.as_str();
        let (full_type, half) = match grid_type.strip_suffix(HALF_SUFFIX) {
            Some(full_type) => (full_type, true),
            None => (grid_type, false),
        };
        let reader = TreeReader {
            decoder: Decoder::new(self.compression, half),
            leaves_position,
        };
        match full_type {
            "Tree_float_5_4_3" => reader.read(input).map(Tree::Float),
            "Tree_double_5_4_3" => reader.read(input).map(Tree::Double),
            "Tree_half_5_4_3" => reader.read(input).map(Tree::Half),
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
}
