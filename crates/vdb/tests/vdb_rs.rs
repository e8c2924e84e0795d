//! An independent reader, the crate vdb-rs, finds in our files what we put there.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use std::collections::HashMap;
use std::io::Cursor;

use common::bytes;
use common::small_file;
use common::transform;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::Tile;
use niji_vdb::TileLevel;
use niji_vdb::VdbFile;
use vdb_rs::VdbReader;

/// Active voxels and tiles of a grid as vdb-rs finds them: lowest voxel, edge length, bits.
fn found(bytes: &[u8], grid: &str) -> HashMap<[i32; 3], (i32, u32)> {
    let mut reader = VdbReader::new(Cursor::new(bytes)).unwrap();
    let grid = reader.read_grid::<f32>(grid).unwrap();
    let places = grid.iter().map(|(place, value, level)| {
        let origin = [place.x, place.y, place.z].map(|axis| axis as i32);
        (origin, (level.scale() as i32, value.to_bits()))
    });
    places.collect()
}

fn expected(tree: &FloatTree) -> HashMap<[i32; 3], (i32, u32)> {
    let mut expected = HashMap::new();
    for leaf in tree.leaves() {
        for (index, value) in leaf.active() {
            expected.insert(leaf.voxel(index), (1, value.to_bits()));
        }
    }
    for tile in tree.tiles().iter().filter(|tile| tile.active) {
        expected.insert(tile.origin, (tile.level.dim(), tile.value.to_bits()));
    }
    expected
}

/// Around the origin, and so under eight entries of the root; one leaf of noise, one all alike.
fn cloud() -> FloatTree {
    let origins = [
        [0; 3],
        [-8, 0, 0],
        [0, -8, 16],
        [-4096, 4088, -8],
        [80, 8, -8],
    ];
    let leaf = |(place, origin): (usize, [i32; 3])| {
        let mut leaf = Leaf::new(origin, 0.0);
        for index in (0..LEAF_VOXELS).filter(|index| place == 0 || index * index % 7 == place) {
            let noise = (index as f32 * 12.9898).sin();
            leaf.set(leaf.voxel(index), if place == 1 { 3.5 } else { noise });
        }
        leaf
    };
    let leaves = origins.into_iter().enumerate().map(leaf).collect();
    let tile = |origin, level| Tile {
        origin,
        level,
        active: true,
        value: 2.5,
    };
    let tiles = vec![
        tile([8, 0, 64], TileLevel::Leaf),
        tile([128, 0, 0], TileLevel::Lower),
    ];
    FloatTree::from_parts(0.0, leaves, tiles).unwrap()
}

#[test]
fn vdb_rs_reads_the_same_values_from_every_grid() {
    let mut file = small_file();
    file.grids
        .push(Grid::new("radius", FOG_VOLUME, transform(), cloud()));
    file.grids.push(Grid::new(
        "empty",
        FOG_VOLUME,
        transform(),
        FloatTree::new(0.0),
    ));
    for compression in [Compression::None, Compression::Zip] {
        let bytes = bytes(&file, compression);
        for grid in &file.grids {
            let tree = grid.tree.as_float().unwrap();
            assert_eq!(found(&bytes, &grid.name), expected(tree), "{}", grid.name);
        }
    }
}

#[test]
fn vdb_rs_reads_the_same_header_items_and_transform() {
    let file = small_file();
    let bytes = bytes(&file, Compression::Zip);
    let mut reader = VdbReader::new(Cursor::new(&bytes)).unwrap();
    assert_eq!(reader.available_grids(), ["density"]);
    let grid = reader.read_grid::<f32>("density").unwrap();
    assert_eq!(grid.descriptor.voxel_count().unwrap(), 512 + 256 + 1);
    assert_eq!(grid.descriptor.aabb_min().unwrap().to_array(), [8, 16, 24]);
    assert_eq!(grid.descriptor.aabb_max().unwrap().to_array(), [23, 72, 31]);
    let unit = &grid.descriptor.meta_data.0["unit"];
    assert_eq!(*unit, vdb_rs::MetadataValue::String("1/m".to_owned()));
    let text = format!("{:?}", grid.transform);
    for number in ["0.1, 0.1, 0.1", "-20.5, 0.05, 10000.0"] {
        assert!(text.contains(number), "{text}");
    }
}

#[test]
fn vdb_rs_reads_a_file_of_no_grids() {
    let bytes = bytes(&VdbFile::default(), Compression::None);
    assert!(
        VdbReader::new(Cursor::new(&bytes))
            .unwrap()
            .available_grids()
            .is_empty()
    );
}
