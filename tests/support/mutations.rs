//! Files made by code, mutated, and read by the readers of the program.
//!
//! A reader may refuse a file or take it; it may not panic, abort, or go on for long. Same seed, same files.

#![allow(dead_code, unreachable_pub, reason = "each target uses its part")]
#![allow(clippy::unwrap_used, reason = "samples are sound")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::panic::AssertUnwindSafe;
use std::panic::catch_unwind;
use std::path::Path;
use std::path::PathBuf;
use std::time::Duration;
use std::time::Instant;

use ndarray::Array2;
use niji_dropfield::DropVolume;
use niji_exchange::Attributes;
use niji_exchange::Axis;
use niji_exchange::Channel;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::TableFile;
use niji_exchange::TablePart;
use niji_exchange::contents;
use niji_exchange::read_provenance;
use niji_geometry::MeshBvh;
use niji_geometry::mesh_buffers;
use niji_geometry::read_mesh;
use niji_photo::Frame;
use niji_photo::Photograph;
use niji_photo::Plate;
use niji_photo::PremultipliedPicture;
use niji_photo::read_depth_values;
use niji_photo::read_labels;
use niji_photo::read_picture_provenance;
use niji_radiometry::RgbPrimaries;
use niji_scene::Scene;
use niji_vdb::Compression;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

#[path = "../../crates/vdb/tests/common/mod.rs"]
mod vdb_files;

use vdb_files::Random;

/// Numbers where sizes and indices break.
const EDGES: [u64; 9] = [
    0,
    1,
    0x7f,
    0xff,
    0xffff,
    0x7fff_ffff,
    0xffff_ffff,
    i64::MAX as u64,
    u64::MAX,
];

/// A kind of file, and what reads it.
pub struct Reader {
    /// Its name on disk.
    pub file: &'static str,
    /// Files beside it that are not mutated.
    beside: Vec<(&'static str, Vec<u8>)>,
    samples: Vec<Vec<u8>>,
    read: fn(&Path),
}

/// What a reader did with a mutated file.
pub struct Tried {
    /// How long it took.
    pub time: Duration,
    /// Whether it panicked.
    pub is_broken: bool,
}

impl Reader {
    /// Reads the file of this seed in a folder, where it stays.
    pub fn try_seed(&self, seed: u64, folder: &Path) -> Tried {
        let mut random = Random(seed);
        let mut bytes = self.samples[random.below(self.samples.len())].clone();
        for _ in 0..=random.below(4) {
            mutate(&mut bytes, &mut random);
        }
        let path = folder.join(self.file);
        for (name, content) in &self.beside {
            fs::write(folder.join(name), content).unwrap();
        }
        fs::write(&path, bytes).unwrap();
        let start = Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| (self.read)(&path)));
        Tried {
            time: start.elapsed(),
            is_broken: outcome.is_err(),
        }
    }

    /// Where the file of a seed is kept for whoever mends its reader.
    pub fn place(&self, folder: &Path) -> PathBuf {
        folder.join(self.file)
    }
}

/// One change: of a bit, a byte, a binary number, a number in digits; a piece cut out, doubled or cut off.
fn mutate(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    let at = random.below(bytes.len());
    let end = (at + 1 + random.below(32)).min(bytes.len());
    let edge = EDGES[random.below(EDGES.len())];
    match random.below(8) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = random.next() as u8,
        2 | 3 => {
            let edge = if random.below(2) == 0 {
                edge.to_le_bytes()
            } else {
                edge.to_be_bytes()
            };
            let n_bytes = (1 << random.below(4)).min(bytes.len() - at);
            let first = if edge[0] == 0 { 8 - n_bytes } else { 0 };
            bytes[at..at + n_bytes].copy_from_slice(&edge[first..first + n_bytes]);
        }
        4 => {
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = bytes[at..].iter().position(is_digit) else {
                return;
            };
            let start = at + start;
            let n_digits = bytes[start..]
                .iter()
                .take_while(|byte| is_digit(byte))
                .count();
            let texts = ["-1", "1e999", "1e-999", "nan", "2.5", "-0", "4294967296"];
            let number = match random.below(2 * texts.len()) {
                index if index < texts.len() => texts[index].to_owned(),
                _ => edge.to_string(),
            };
            bytes.splice(start..start + n_digits, number.into_bytes());
        }
        5 => drop(bytes.drain(at..end)),
        6 => {
            let piece = bytes[at..end].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
        _ if random.below(4) == 0 => bytes.truncate(at),
        _ => bytes[at..end].fill(random.next() as u8),
    }
}

/// The readers of all files that the program takes.
pub fn readers() -> Vec<Reader> {
    let mesh = |file, samples, beside| Reader {
        file,
        beside,
        samples,
        read: |path| {
            let _ = mesh_buffers(path);
            let _ = read_mesh(path).map(MeshBvh::new);
        },
    };
    let picture = |file, sample| Reader {
        file,
        beside: Vec::new(),
        samples: vec![sample],
        read: |path| {
            let _ = Photograph::read(path);
            let _ = read_labels(path, 4);
            let _ = read_depth_values(path);
            let _ = read_picture_provenance(path);
        },
    };
    let buffer = [corner_bytes(), index_bytes()].concat();
    let small = vdb_files::small_file();
    vec![
        Reader {
            file: "a.vdb",
            beside: Vec::new(),
            samples: vec![
                vdb_files::bytes(&small, Compression::Zip),
                vdb_files::bytes(&small, Compression::None),
                vdb_files::BLOSC.to_vec(),
            ],
            read: |path| {
                let _ = VdbHeader::read(path);
                let _ = VdbFile::read(path).map(|file| {
                    let _ = DropVolume::from_vdb(&file).map(|volume| volume.summary());
                });
            },
        },
        Reader {
            file: "table.exr",
            beside: Vec::new(),
            samples: vec![table()],
            read: |path| {
                let _ = read_provenance(path);
                let _ = TableFile::read(path);
                let _ = contents(path);
            },
        },
        Reader {
            file: "plate.exr",
            beside: Vec::new(),
            samples: vec![plate()],
            read: |path| {
                let _ = Plate::read(path, None);
                let _ = Photograph::read(path);
                let _ = read_depth_values(path);
                let _ = read_picture_provenance(path);
            },
        },
        picture("a.png", png()),
        picture("a.jpg", jpeg()),
        mesh("a.obj", vec![obj()], Vec::new()),
        mesh(
            "a.gltf",
            vec![gltf(Some("a.bin"))],
            vec![("a.bin", buffer.clone())],
        ),
        mesh("a.glb", vec![glb(&buffer)], Vec::new()),
        mesh("a.stl", vec![stl(), stl_text()], Vec::new()),
        Reader {
            file: "scene.toml",
            beside: Vec::new(),
            samples: scenes(),
            read: |path| {
                let text = fs::read(path).unwrap();
                let _ = Scene::from_toml(&String::from_utf8_lossy(&text));
            },
        },
    ]
}

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn corner_bytes() -> Vec<u8> {
    CORNERS
        .iter()
        .flatten()
        .flat_map(|it| it.to_le_bytes())
        .collect()
}

fn index_bytes() -> Vec<u8> {
    TRIANGLES
        .iter()
        .flatten()
        .flat_map(|it| it.to_le_bytes())
        .collect()
}

fn obj() -> Vec<u8> {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces = "vt 0 0\nvn 0 0 1\nf 1/1 3 2\nf 1//1 2 4\nf -4 -1 -2\nf 2/1/1 3 4\nf 1 2 3 4\n";
    (corners + faces).into_bytes()
}

fn gltf(uri: Option<&str>) -> Vec<u8> {
    let uri = uri
        .map(|uri| format!("\"uri\":\"{uri}\","))
        .unwrap_or_default();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"scale":[1,2,3],"children":[1,2]}},{{"mesh":0,"translation":[5,0,0]}},
        {{"mesh":0,"rotation":[0,0,0,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"byteOffset":0,"componentType":5123,"count":12,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48,"byteStride":12}},
        {{"buffer":0,"byteOffset":48,"byteLength":24}}],"buffers":[{{{uri}"byteLength":72}}]}}"#
    )
    .into_bytes()
}

fn glb(buffer: &[u8]) -> Vec<u8> {
    let chunk = |name: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes(), name, content].concat()
    };
    let chunks = [chunk(b"JSON", &gltf(None)), chunk(b"BIN\0", buffer)].concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [&b"glTF"[..], &[2, 0, 0, 0], &length, &chunks].concat()
}

fn stl() -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((TRIANGLES.len() as u32).to_le_bytes());
    for triangle in TRIANGLES {
        let corners = triangle.map(|index| CORNERS[usize::from(index)]);
        let numbers = [[0.0; 3]].into_iter().chain(corners).flatten();
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0, 0]);
    }
    bytes
}

fn stl_text() -> Vec<u8> {
    let facet = |triangle: [u16; 3]| {
        let corners = triangle.map(|index| {
            let [x, y, z] = CORNERS[usize::from(index)];
            format!("   vertex {x} {y} {z}\n")
        });
        let corners = corners.concat();
        format!(" facet normal 0 0 1\n  outer loop\n{corners}  endloop\n endfacet\n")
    };
    format!("solid a\n{}endsolid a\n", TRIANGLES.map(facet).concat()).into_bytes()
}

fn table() -> Vec<u8> {
    let part = TablePart {
        name: "one".to_owned(),
        column_axis: Axis::new("z", "-", (0..20).map(f64::from).collect()),
        row_axes: vec![Axis::new("h", "m", (0..8).map(f64::from).collect())],
        channels: vec![Channel {
            name: "a".to_owned(),
            values: Array2::from_shape_fn((8, 20), |(y, x)| (y * x) as f32),
        }],
        attributes: Attributes::new(),
    };
    let file = TableFile {
        quantity: "test".to_owned(),
        parts: vec![part],
        provenance: Provenance {
            tool: "niji test".to_owned(),
            version: "0".to_owned(),
            settings: "{}".to_owned(),
            inputs: BTreeMap::new(),
        },
    };
    let mut bytes = Cursor::new(Vec::new());
    file.write(&mut bytes).unwrap();
    bytes.into_inner()
}

fn light() -> Array2<[f32; 3]> {
    Array2::from_shape_fn((12, 16), |(y, x)| [y as f32 / 12.0, x as f32 / 16.0, 0.5])
}

fn plate() -> Vec<u8> {
    let frame = Frame {
        primaries: RgbPrimaries::Rec709,
        windows: ImageWindows::whole(16, 12),
    };
    let picture = PremultipliedPicture {
        light: &light(),
        alpha: Some(&Array2::ones((12, 16))),
        frame,
    };
    let mut bytes = Cursor::new(Vec::new());
    picture
        .write_exr(&Provenance::default(), &mut bytes)
        .unwrap();
    bytes.into_inner()
}

fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    niji_photo::write_png(&light(), &Provenance::default(), &mut bytes).unwrap();
    bytes
}

fn jpeg() -> Vec<u8> {
    let mut bytes = Vec::new();
    niji_photo::write_jpeg(&light(), &mut bytes).unwrap();
    bytes
}

fn scenes() -> Vec<Vec<u8>> {
    let texts = [
        include_str!("../../data/scenes/garden-fountain.toml"),
        include_str!("../../data/scenes/fog-to-rain.toml"),
        include_str!("../../data/scenes/reflection-bow.toml"),
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}
