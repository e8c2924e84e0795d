//! Mesh files that lie: each is refused with a message, quickly and without a panic.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;

use niji_geometry::MeshDetail;
use niji_geometry::TriangleMesh;
use niji_geometry::files_beside_mesh;
use niji_geometry::read_mesh;
use serde_json::Value;
use serde_json::json;

/// Two tetrahedra of a sixth.
const VOLUME_M3: f64 = 1.0 / 3.0;

/// Corners and indices of a tetrahedron: 48 and 24 bytes.
fn tetrahedron() -> Vec<u8> {
    let corners = [
        [0.0_f32; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let indices = [0_u16, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let corners = corners.iter().flatten().flat_map(|it| it.to_le_bytes());
    corners
        .chain(indices.iter().flat_map(|it| it.to_le_bytes()))
        .collect()
}

/// Two of it, in a parent and its child.
fn description() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "children": [1]}, {"mesh": 0, "translation": [5.0, 0.0, 0.0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "buffers": [{"uri": "a.bin", "byteLength": 72}],
    })
}

fn read_in(folder: &Path, description: &Value) -> Result<TriangleMesh, String> {
    let path = folder.join("a.gltf");
    fs::write(&path, description.to_string()).unwrap();
    read_mesh(&path, MeshDetail::Normals).map_err(|error| error.to_string())
}

/// The description with another value at a place, read beside its buffer.
fn read_with(place: &str, value: &Value) -> Result<TriangleMesh, String> {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.bin"), tetrahedron()).unwrap();
    read_in(folder.path(), &with(place, value))
}

fn with(place: &str, value: &Value) -> Value {
    let mut found = description();
    let (parent, key) = place.rsplit_once('/').unwrap();
    match found.pointer_mut(parent).unwrap() {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
        map => map[key] = value.clone(),
    }
    found
}

#[test]
fn the_sound_file_is_read() {
    let mesh = read_with("/scene", &json!(0)).unwrap();
    assert_eq!((mesh.triangles().len(), mesh.vertices().len()), (8, 8));
    assert!((mesh.volume_m3() - VOLUME_M3).abs() < 1e-12);
    // A file without scenes shows all of its nodes, each once.
    let without = read_with("/scenes", &json!([])).unwrap();
    assert_eq!(without.vertices(), mesh.vertices());
}

#[test]
fn every_index_count_and_offset_that_leads_nowhere_is_refused() {
    let huge = [
        json!(4_294_967_295_u64),
        json!(u64::MAX),
        json!(-1),
        json!(1.5),
    ];
    for (place, too_large) in [
        ("/scene", 1),
        ("/scenes/0/nodes/0", 2),
        ("/nodes/0/mesh", 1),
        ("/nodes/0/children/0", 2),
        ("/meshes/0/primitives/0/indices", 2),
        ("/meshes/0/primitives/0/attributes/POSITION", 2),
        ("/accessors/0/bufferView", 2),
        ("/accessors/1/bufferView", 2),
        ("/bufferViews/0/buffer", 1),
        ("/bufferViews/1/buffer", 1),
        ("/accessors/0/count", 5),
        ("/accessors/1/count", 15),
        ("/accessors/0/byteOffset", 1),
        ("/accessors/1/byteOffset", 1),
        ("/bufferViews/0/byteOffset", 25),
        ("/bufferViews/0/byteLength", 47),
        ("/bufferViews/1/byteLength", 2),
        ("/bufferViews/1/byteLength", 25),
        ("/bufferViews/0/byteStride", 252),
        ("/bufferViews/0/byteStride", 0),
        ("/buffers/0/byteLength", 71),
        ("/buffers/0/byteLength", 73),
    ] {
        for value in huge.iter().chain([&json!(too_large)]) {
            assert!(read_with(place, value).is_err(), "{place} = {value}");
        }
    }
}

#[test]
fn damaged_kinds_are_refused_and_never_taken_for_absent() {
    for (place, value) in [
        ("/accessors/1/componentType", json!(5126)),
        ("/accessors/1/componentType", json!(null)),
        ("/accessors/1/type", json!("VEC3")),
        ("/accessors/0/componentType", json!(5123)),
        ("/accessors/0/type", json!("VEC2")),
        ("/accessors/0/bufferView", json!(null)),
        ("/accessors/1/bufferView", json!(null)),
        ("/accessors/1/count", json!(11)),
        ("/accessors/0/count", json!(3)),
        ("/meshes/0/primitives/0/mode", json!(5)),
        ("/meshes/0/primitives/0/attributes", json!({})),
        ("/nodes/0/matrix", json!([1.0])),
        (
            "/nodes",
            json!([{"children": [1], "scale": [1e200, 1, 1]}, {"mesh": 0, "scale": [1e200, 1, 1]}]),
        ),
        ("/nodes/0/rotation", json!([0.0, 0.0, 0.0, 0.0])),
        ("/asset/version", json!("1.0")),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"])),
        (
            "/accessors/0/sparse",
            json!({"count": 4_000_000_000_u64,
            "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}}),
        ),
        (
            "/accessors/0/sparse",
            json!({"count": 4,
            "indices": {"bufferView": 1, "byteOffset": 4, "componentType": 5125},
            "values": {"bufferView": 0}}),
        ),
    ] {
        assert!(read_with(place, &value).is_err(), "{place} = {value}");
    }
}

#[test]
fn sparse_corners_replace_others() {
    // Corners 0, 2, 1 become the first three: bodies that are mirrored.
    let sparse = json!({"count": 3, "indices": {"bufferView": 1, "componentType": 5123},
        "values": {"bufferView": 0}});
    let mesh = read_with("/accessors/0/sparse", &sparse).unwrap();
    assert!((mesh.volume_m3() + VOLUME_M3).abs() < 1e-12);
}

#[test]
fn a_scene_that_is_no_tree_is_refused_at_once() {
    let doubled: Vec<Value> = (1..=40)
        .map(|child| json!({"children": [child, child]}))
        .collect();
    let shared = [doubled, vec![json!({"mesh": 0})]].concat();
    for (place, value) in [
        ("/nodes/1/children", json!([1])),
        ("/nodes/1/children", json!([0])),
        ("/nodes/0/children", json!([1, 1])),
        ("/scenes/0/nodes", json!([0, 0])),
        ("/scenes/0/nodes", json!([0, 1])),
        ("/nodes", json!(shared)),
    ] {
        let message = read_with(place, &value).unwrap_err();
        assert!(message.contains("a node has one parent"), "{message}");
    }
}

#[test]
fn a_mesh_in_many_places_is_refused_before_it_fills_the_memory() {
    let places = 0..100_000;
    let mut many = with("/accessors/1/count", &json!(3_000_000));
    many["nodes"] = places.clone().map(|_| json!({"mesh": 0})).collect();
    many["scenes"][0]["nodes"] = places.collect();
    let folder = tempfile::tempdir().unwrap();
    let message = read_in(folder.path(), &many).unwrap_err();
    assert!(message.contains("100000000000 triangles"), "{message}");
}

#[test]
fn buffers_are_files_in_the_folder_of_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir_all(own.join("parts of it")).unwrap();
    for place in ["outside.bin", "own/parts of it/a.bin"] {
        fs::write(folder.path().join(place), tetrahedron()).unwrap();
    }
    let read = |uri: &str| read_in(&own, &with("/buffers/0/uri", &json!(uri)));
    assert!(read("parts%20of%20it/a.bin").is_ok());
    assert!(read("./parts of it/a.bin").is_ok());
    assert_eq!(files_beside_mesh(&own.join("a.gltf")).unwrap().len(), 1);
    let absolute = folder.path().join("outside.bin");
    let absolute = absolute.to_str().unwrap();
    for uri in [
        "../outside.bin",
        "%2e%2e/outside.bin",
        "parts of it/../../outside.bin",
        "..\\outside.bin",
        "/dev/zero",
        "file:///etc/passwd",
        "http://127.0.0.1/a.bin",
        "data:,abc",
        "data:application/octet-stream;base64,?",
        "parts of it",
        "missing.bin",
        "",
        absolute,
        &format!("file://{absolute}"),
    ] {
        assert!(read(uri).is_err(), "{uri}");
    }
}

#[cfg(unix)]
#[test]
fn links_lead_to_no_file_outside_the_folder() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    let outside = folder.path().join("outside.bin");
    fs::write(&outside, tetrahedron()).unwrap();
    symlink(&outside, own.join("link.bin")).unwrap();
    symlink("/dev/zero", own.join("zero.bin")).unwrap();
    symlink(folder.path(), own.join("up")).unwrap();
    for uri in ["link.bin", "zero.bin", "up/outside.bin"] {
        let message = read_in(&own, &with("/buffers/0/uri", &json!(uri))).unwrap_err();
        assert!(message.contains("in the folder of the mesh"), "{message}");
    }
}

#[test]
fn a_binary_file_cut_anywhere_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let json = with("/buffers/0", &json!({"byteLength": 72})).to_string();
    let chunk = |name: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes(), name, content].concat()
    };
    let chunks = [
        chunk(b"JSON", json.as_bytes()),
        chunk(b"BIN\0", &tetrahedron()),
    ]
    .concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    let bytes = [&b"glTF"[..], &[2, 0, 0, 0], &length, &chunks].concat();
    fs::write(&path, &bytes).unwrap();
    assert!((read_mesh(&path, MeshDetail::Normals).unwrap().volume_m3() - VOLUME_M3).abs() < 1e-12);
    for n_bytes in 0..bytes.len() {
        fs::write(&path, &bytes[..n_bytes]).unwrap();
        assert!(read_mesh(&path, MeshDetail::Normals).is_err(), "{n_bytes}");
    }
}

#[test]
fn obj_indices_that_no_corner_has_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let read = |lines: &str| {
        let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";
        fs::write(&path, format!("{corners}{lines}\n")).unwrap();
        read_mesh(&path, MeshDetail::Normals)
    };
    for face in [
        "f 1 2 3",
        "f 1//1 2//-1 3//1",
        "f -3 -2 \\\n-1",
        "f 1 2 3 # f 9",
    ] {
        assert!(read(face).is_ok(), "{face}");
    }
    for index in [
        "0",
        "4",
        "-4",
        "9223372036854775807",
        "-9223372036854775808",
        "1e3",
        "1.0",
    ] {
        for corner in [
            index.to_owned(),
            format!("3//{index}"),
            format!("3/{index}"),
        ] {
            let face = format!("f 1 2 {corner}");
            assert!(read(&face).is_err(), "{face}");
        }
    }
    // Normals of any length, and none.
    assert!(read("vn 0 0 0\nvn 0 0 9e30\nf 1//2 2//3 3//1").is_ok());
    for lines in [
        "f 1",
        "f",
        "f 1 2",
        "f 1 2 /1",
        "v 1 2",
        "v 1 2 x",
        "v 1 2 nan\nf 1 2 3",
        "vn 1 2\nf 1 2 3",
        "vn 0 0 nan\nf 1//2 2//2 3//2",
    ] {
        assert!(read(lines).is_err(), "{lines}");
    }
}

#[test]
fn an_stl_count_beyond_its_file_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    let header = [&[0; 80][..], &u32::MAX.to_le_bytes(), &[0; 50]].concat();
    fs::write(&path, header).unwrap();
    assert!(read_mesh(&path, MeshDetail::Normals).is_err());
}
