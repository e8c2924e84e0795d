//! Our VDB reader against OpenVDB's own account of files that OpenVDB wrote, bit for bit.
//!
//! `tests/peers/vdb_matrix.cc` writes the files and describes the format of the accounts.

use std::path::Path;

use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::MetaValue;
use niji_vdb::Metadata;
use niji_vdb::SparseTree;
use niji_vdb::Tree;
use niji_vdb::Value;
use niji_vdb::VdbFile;

/// Compare every file of a folder with its account; gives the number of files.
///
/// # Panics
/// If anything differs.
pub fn compare_matrix(directory: &Path) -> usize {
    let entries = std::fs::read_dir(directory).expect("the folder of the matrix");
    let paths = entries.map(|entry| entry.expect("an entry of the folder").path());
    let accounts = paths.filter(|path| path.extension().is_some_and(|end| end == "txt"));
    let mut n_files = 0;
    for account in accounts {
        let text = std::fs::read_to_string(&account).expect("an account");
        let path = account.with_extension("vdb");
        let name = path.display();
        let file = VdbFile::read(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        compare_file(&file, &text, &name.to_string());
        n_files += 1;
    }
    n_files
}

fn compare_file(file: &VdbFile, account: &str, name: &str) {
    let lines = account.lines().collect::<Vec<_>>();
    let starts = (0..lines.len()).filter(|&line| lines[line].starts_with("grid "));
    let mut starts = starts.collect::<Vec<_>>();
    assert_eq!(file.grids.len(), starts.len(), "number of grids of {name}");
    starts.push(lines.len());
    compare_items(&file.metadata, &lines[..starts[0]], name);
    for (grid, bounds) in file.grids.iter().zip(starts.windows(2)) {
        let account = &lines[bounds[0]..bounds[1]];
        let name = format!("grid {:?} of {name}", grid.name);
        match &grid.tree {
            Tree::Float(tree) => compare_grid(grid, tree, account, &name),
            Tree::Double(tree) => compare_grid(grid, tree, account, &name),
            Tree::Vec3s(tree) => compare_grid(grid, tree, account, &name),
            Tree::Int32(tree) => compare_grid(grid, tree, account, &name),
            Tree::Bool(tree) => compare_grid(grid, tree, account, &name),
            other => panic!("a tree of another type in {name}: {other:?}"),
        }
    }
}

/// The text of a value's bits, as the account has it.
trait Bits: Value {
    const TYPE: &'static str;
    fn text(self) -> String;
}

impl Bits for f32 {
    const TYPE: &'static str = "float";
    fn text(self) -> String {
        format!("{:08x}", self.to_bits())
    }
}

impl Bits for f64 {
    const TYPE: &'static str = "double";
    fn text(self) -> String {
        format!("{:016x}", self.to_bits())
    }
}

impl Bits for [f32; 3] {
    const TYPE: &'static str = "vec3s";
    fn text(self) -> String {
        self.map(Bits::text).join(",")
    }
}

impl Bits for i32 {
    const TYPE: &'static str = "int32";
    fn text(self) -> String {
        format!("{self:08x}")
    }
}

impl Bits for bool {
    const TYPE: &'static str = "bool";
    fn text(self) -> String {
        format!("{:02x}", u8::from(self))
    }
}

fn compare_grid<T: Bits>(grid: &Grid, tree: &SparseTree<T>, account: &[&str], name: &str) {
    let (mut n_leaves, mut n_tiles) = (0, 0);
    compare_items(&grid.metadata, account, name);
    for line in account {
        let (keyword, rest) = line.split_once(' ').expect("a keyword and more");
        let words = rest.split(' ').collect::<Vec<_>>();
        match keyword {
            "grid" => {
                assert_eq!(words[0], T::TYPE, "type of {name}");
                assert_eq!(words[1], grid.class.replace(' ', "_"), "class of {name}");
                assert_eq!(words[2], tree.background.text(), "background of {name}");
            }
            "item" => {}
            "map" => compare_map(grid, &words, name),
            "active" => assert_eq!(words[0], tree.active_voxel_count().to_string(), "in {name}"),
            "leaf" => {
                n_leaves += 1;
                compare_leaf(tree, &words, name);
            }
            "tile" => {
                n_tiles += 1;
                compare_tile(tree, &words, name);
            }
            "probe" => {
                let voxel = voxel(&words);
                let found = (
                    u8::from(tree.is_active(voxel)).to_string(),
                    tree.get(voxel).text(),
                );
                let expected = (words[3].to_owned(), words[4].to_owned());
                assert_eq!(found, expected, "voxel {voxel:?} of {name}");
            }
            other => panic!("the keyword {other} in the account of {name}"),
        }
    }
    assert_eq!(tree.leaves().len(), n_leaves, "leaves of {name}");
    assert_eq!(tree.tiles().len(), n_tiles, "tiles of {name}");
}

fn voxel(words: &[&str]) -> [i32; 3] {
    [0, 1, 2].map(|axis| words[axis].parse().expect("a coordinate"))
}

fn compare_map(grid: &Grid, words: &[&str], name: &str) {
    let linear = grid.transform.linear();
    let rows = [
        linear.x_axis,
        linear.y_axis,
        linear.z_axis,
        grid.transform.translation(),
    ];
    for (row, expected) in rows.iter().zip(words.chunks(4)) {
        assert_eq!(
            row.to_array().map(Bits::text),
            expected[..3],
            "map of {name}"
        );
    }
}

fn compare_leaf<T: Bits>(tree: &SparseTree<T>, words: &[&str], name: &str) {
    let origin = voxel(words);
    let leaf = tree
        .leaf(origin)
        .unwrap_or_else(|| panic!("no leaf at {origin:?} in {name}"));
    assert_eq!(
        leaf.mask.map(|word| format!("{word:016x}")),
        words[3..11],
        "a mask of {name}"
    );
    assert_eq!(words.len() - 11, LEAF_VOXELS);
    for (value, expected) in leaf.values.iter().zip(&words[11..]) {
        assert_eq!(value.text(), *expected, "leaf {origin:?} of {name}");
    }
}

fn compare_tile<T: Bits>(tree: &SparseTree<T>, words: &[&str], name: &str) {
    let origin = voxel(words);
    let tile = tree.tiles().iter().find(|tile| tile.origin == origin);
    let tile = tile.unwrap_or_else(|| panic!("no tile at {origin:?} in {name}"));
    let found = [
        tile.level.dim().to_string(),
        u8::from(tile.active).to_string(),
        tile.value.text(),
    ];
    assert_eq!(found, words[3..6], "tile {origin:?} of {name}");
}

/// Items that OpenVDB keeps and we hold as fields of the grid or leave out.
const NOT_ITEMS: [&str; 3] = ["name", "class", "file_delayed_load"];

fn compare_items(items: &Metadata, account: &[&str], name: &str) {
    for line in account {
        let mut words = line.splitn(4, ' ');
        if !words
            .next()
            .is_some_and(|keyword| keyword == "item" || keyword == "file_item")
        {
            continue;
        }
        let [item, kind, expected] = [(); 3].map(|()| words.next().unwrap_or_default());
        if NOT_ITEMS.contains(&item) {
            continue;
        }
        let found = items
            .get(item)
            .unwrap_or_else(|| panic!("no item {item} in {name}"));
        assert_eq!(
            item_text(found),
            (kind.to_owned(), expected.to_owned()),
            "{item} of {name}"
        );
    }
}

/// Type and text of an item as OpenVDB prints it; its numbers in the matrix are short ones.
fn item_text(value: &MetaValue) -> (String, String) {
    let (kind, text) = match value {
        MetaValue::Bool(value) => ("bool", value.to_string()),
        MetaValue::Int32(value) => ("int32", value.to_string()),
        MetaValue::Int64(value) => ("int64", value.to_string()),
        MetaValue::Float(value) => ("float", value.to_string()),
        MetaValue::Double(value) => ("double", value.to_string()),
        MetaValue::String(value) => ("string", value.clone()),
        MetaValue::Vec3i(value) => ("vec3i", vector_text(value)),
        MetaValue::Vec3s(value) => ("vec3s", vector_text(value)),
        MetaValue::Vec3d(value) => ("vec3d", vector_text(value)),
        MetaValue::Unknown { type_name, bytes } if type_name == "vec2d" => {
            let number = |bytes: &[u8]| bytes.try_into().map(f64::from_le_bytes).expect("8 bytes");
            let numbers = bytes.chunks(8).map(number).collect::<Vec<_>>();
            ("vec2d", vector_text(&numbers))
        }
        other => panic!("an item of another type: {other:?}"),
    };
    (kind.to_owned(), text)
}

fn vector_text<T: ToString>(components: &[T]) -> String {
    let texts = components
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>();
    format!("[{}]", texts.join(", "))
}
