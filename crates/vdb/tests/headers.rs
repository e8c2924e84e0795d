//! Headers are read without the voxels, and grids one by one.

#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

mod common;

use std::io::Write;

use common::BLOSC;
use common::bytes;
use common::replaced;
use common::small_file;
use common::small_tree;
use common::stream_with_instances;
use common::transform;
use niji_vdb::Compression;
use niji_vdb::Grid;
use niji_vdb::SparseTree;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

/// A file on disc that goes away with its handle.
struct OnDisc(std::path::PathBuf);

impl OnDisc {
    fn new(name: &str, bytes: &[u8]) -> Self {
        let path = std::env::temp_dir().join(format!("niji-{}-{name}", std::process::id()));
        let mut file = std::fs::File::create(&path).unwrap();
        file.write_all(bytes).unwrap();
        Self(path)
    }
}

impl Drop for OnDisc {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn two_grids() -> VdbFile {
    let mut file = small_file();
    let count = SparseTree::<i32>::new(7);
    file.grids
        .push(Grid::new("count", "unknown", transform(), count));
    file
}

#[test]
fn headers_are_those_of_the_grids() {
    for compression in [Compression::None, Compression::Zip] {
        let bytes = bytes(&two_grids(), compression);
        let (header, file) = (
            VdbHeader::parse(&bytes).unwrap(),
            VdbFile::parse(&bytes).unwrap(),
        );
        assert_eq!(header.file_version, 224);
        assert_eq!(header.metadata, file.metadata);
        assert_eq!(header.grids.len(), 2);
        for (header, grid) in header.grids.iter().zip(&file.grids) {
            assert_eq!(header.name, grid.name);
            assert_eq!(header.class, grid.class);
            assert_eq!(header.metadata, grid.metadata);
            assert_eq!(header.transform, Some(grid.transform));
            assert_eq!(header.instance_of, None);
        }
        assert_eq!(
            header.grid("density").unwrap().grid_type,
            "Tree_float_5_4_3"
        );
        assert_eq!(header.grid("count").unwrap().grid_type, "Tree_int32_5_4_3");
        assert_eq!(header.grid("dense"), None);
    }
}

#[test]
fn headers_cost_no_voxels() {
    // All voxels are spoiled; the headers do not notice.
    let mut spoiled = BLOSC.to_vec();
    let end = spoiled.len() - 1;
    spoiled[end - 17_000..end].fill(0xff);
    assert!(VdbFile::parse(&spoiled).is_err());
    let path = OnDisc::new("spoiled.vdb", &spoiled);
    let header = VdbHeader::read(&path.0).unwrap();
    assert_eq!(header.grids[0].name, "ball");
    assert_eq!(header, VdbHeader::parse(BLOSC).unwrap());
}

#[test]
fn a_grid_is_read_without_the_others() {
    let original = bytes(&two_grids(), Compression::Zip);
    // Of a type that is not read, at the same length of its name.
    let points = replaced(&original, b"Tree_int32_5_4_3", b"Tree_ptdta_5_4_3");
    let path = OnDisc::new("points.vdb", &points);
    let error = VdbFile::read(&path.0).unwrap_err().to_string();
    assert!(error.starts_with("grid `count`: grid type"), "{error}");
    let file = VdbFile::read_grids(&path.0, |grid| grid.name == "density").unwrap();
    assert_eq!(file.grids.len(), 1);
    assert_eq!(file.grids[0].tree, small_tree().into());
    let none = VdbFile::read_grids(&path.0, |_| false).unwrap();
    assert_eq!((none.grids.len(), none.metadata.len()), (0, 1));
}

#[test]
fn maps_that_are_not_linear_hinder_only_those_who_want_the_grid() {
    let original = bytes(&two_grids(), Compression::None);
    let frustum = replaced(
        &original,
        b"UniformScaleTranslateMap",
        b"NonlinearFrustumMapAbcde",
    );
    let header = VdbHeader::parse(&frustum).unwrap();
    assert_eq!(header.grids[0].transform, None);
    assert_eq!(header.grids[1].transform, Some(transform()));
    let path = OnDisc::new("frustum.vdb", &frustum);
    let file = VdbFile::read_grids(&path.0, |grid| grid.name == "count").unwrap();
    assert_eq!(file.grids.len(), 1);
    assert!(VdbFile::read(&path.0).is_err());
}

#[test]
fn an_instance_brings_the_tree_that_it_shares() {
    for compression in [Compression::None, Compression::Zip] {
        let stream = stream_with_instances(&bytes(&small_file(), compression), 2, "density");
        let header = VdbHeader::parse(&stream).unwrap();
        assert_eq!(header.grids[2].instance_of.as_deref(), Some("density"));
        let path = OnDisc::new(&format!("instances-{compression:?}.vdb"), &stream);
        let file = VdbFile::read_grids(&path.0, |grid| grid.instance_of.is_some()).unwrap();
        assert_eq!(file.grids.len(), 2);
        assert_eq!(file.grids[1].tree, small_tree().into());
    }
}

#[test]
fn one_thread_and_many_read_the_same_volume() {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.unwrap();
    for original in [
        BLOSC.to_vec(),
        bytes(&two_grids(), Compression::Zip),
        bytes(&two_grids(), Compression::None),
    ] {
        let parse = || VdbFile::parse(&original).unwrap();
        assert_eq!(one.install(parse), parse());
    }
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let path = std::path::Path::new("no such file.vdb");
    let error = VdbHeader::read(path).unwrap_err().to_string();
    assert!(error.starts_with("cannot read no such file.vdb"), "{error}");
}
