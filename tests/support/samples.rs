//! Sound files of every kind, small, made by code: what is mutated.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::AnyChannel;
use exr::prelude::AnyChannels;
use exr::prelude::Blocks;
use exr::prelude::Compression as Codec;
use exr::prelude::Encoding;
use exr::prelude::FlatSamples;
use exr::prelude::Image;
use exr::prelude::Layer;
use exr::prelude::LayerAttributes;
use exr::prelude::Layers;
use exr::prelude::LineOrder;
use exr::prelude::Vec2;
use exr::prelude::WritableImage;
use exr::prelude::f16;
use ndarray::Array2;
use ndarray::Array3;
use niji_exchange::Aov;
use niji_exchange::Attributes;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_exchange::Spectra;
use niji_exchange::SpectralImage;
use niji_photo::Frame;
use niji_photo::LinearPicture;
use niji_photo::PremultipliedPicture;
use niji_photo::write_labels;
use niji_photo::write_png;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::WavelengthGrid;
use niji_scene::Scene;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::VdbFile;

use super::exchange_files;
use super::photographs;
use super::vdb_files;

const WIDTH: usize = 16;
const HEIGHT: usize = 12;
const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TRIANGLES: [[u16; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

/// What a writer leaves in memory.
fn written<E: std::fmt::Debug>(
    write: impl FnOnce(&mut Cursor<Vec<u8>>) -> Result<(), E>,
) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    write(&mut bytes).unwrap();
    bytes.into_inner()
}

/// A density grid in each compression, and drops.
pub fn vdb() -> Vec<Vec<u8>> {
    let density = vdb_files::small_file();
    let leaf = |value: f32| {
        let mut leaf = Leaf::new([8, 16, 24], 0.0);
        for index in 0..100 {
            leaf.set(leaf.voxel(index), value * (1.0 + 1e-3 * index as f32));
        }
        FloatTree::from_leaves(0.0, vec![leaf]).unwrap()
    };
    let grid = |name, value| Grid::new(name, FOG_VOLUME, vdb_files::transform(), leaf(value));
    let drops = VdbFile::new(vec![
        grid("number_density", 200.0),
        grid("effective_radius", 5e-4),
        grid("effective_variance", 0.1),
    ]);
    vec![
        vdb_files::bytes(&density, Compression::Zip),
        vdb_files::bytes(&density, Compression::None),
        vdb_files::BLOSC.to_vec(),
        vdb_files::bytes(&drops, Compression::Zip),
    ]
}

/// A plain table, one of scattering, one of the air with its diffuse light.
pub fn tables() -> Vec<Vec<u8>> {
    let provenance = exchange_files::provenance;
    let plain = exchange_files::small_part("one");
    let plain = niji_exchange::TableFile {
        quantity: "test".to_owned(),
        parts: vec![plain],
        provenance: provenance(),
    };
    let scattering = exchange_files::scattering_table().to_file(provenance());
    let air = exchange_files::air::air_table().to_file(provenance());
    [plain, scattering, air]
        .iter()
        .map(exchange_files::bytes)
        .collect()
}

/// A spectral image, and the plain one beside it.
pub fn images() -> Vec<Vec<u8>> {
    let image = SpectralImage {
        wavelengths: WavelengthGrid::new(450.0, 100.0, 3).unwrap(),
        radiance: Array3::from_shape_fn((3, HEIGHT, WIDTH), |(l, y, x)| (l + x * y) as f32),
        spectra: Spectra::Full,
        windows: ImageWindows::whole(WIDTH, HEIGHT),
        aovs: vec![Aov {
            name: "depth".to_owned(),
            unit: "m".to_owned(),
            channels: vec![("Z".to_owned(), Array2::from_elem((HEIGHT, WIDTH), 9.0))],
        }],
        white_luminance_cd_m2: 1234.5,
        world_to_camera: Some([0.5; 16]),
        attributes: Attributes::new(),
        provenance: exchange_files::provenance(),
    };
    let kept = [Spectra::Full, Spectra::Half, Spectra::Left];
    let images = kept.map(|kept| image.clone().keeping(kept));
    let [full, half, colors] = images.map(|image| written(|bytes| image.write_spectral(bytes)));
    vec![
        full,
        half,
        colors,
        written(|bytes| image.write_layers(RgbPrimaries::Rec709, bytes)),
        plate(),
        other_plate(Codec::ZIP16, Blocks::ScanLines),
    ]
}

/// The plain picture that the program writes.
fn plate() -> Vec<u8> {
    let frame = Frame {
        primaries: RgbPrimaries::Rec709,
        windows: ImageWindows::whole(WIDTH, HEIGHT),
    };
    let picture = PremultipliedPicture {
        light: &light(),
        alpha: Some(&Array2::ones((HEIGHT, WIDTH))),
        frame,
    };
    written(|bytes| picture.write_exr(&Provenance::default(), bytes))
}

/// Plates of another program: every codec that it writes, in scan lines and in tiles.
pub fn plates() -> Vec<Vec<u8>> {
    let codecs = [
        Codec::Uncompressed,
        Codec::RLE,
        Codec::ZIP1,
        Codec::ZIP16,
        Codec::PIZ,
        Codec::PXR24,
        Codec::B44,
        Codec::B44A,
    ];
    let blocks = [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 8))];
    let others = codecs
        .into_iter()
        .flat_map(|codec| blocks.map(|blocks| other_plate(codec, blocks)));
    others.chain([plate()]).collect()
}

/// Two layers with colors of 16 bit and distances of 32.
fn other_plate(compression: Codec, blocks: Blocks) -> Vec<u8> {
    let layer = |name: &str| {
        let n_pixels = WIDTH * HEIGHT;
        let color = |index: usize| f16::from_f32(index as f32 / n_pixels as f32);
        let colors = ["B", "G", "R"].map(|name| {
            let samples = FlatSamples::F16((0..n_pixels).map(color).collect());
            AnyChannel::new(name, samples)
        });
        let distances = AnyChannel::new("Z", FlatSamples::F32(vec![12.5; n_pixels]));
        let encoding = Encoding {
            compression,
            blocks,
            line_order: LineOrder::Increasing,
        };
        let channels = colors.into_iter().chain([distances]).collect();
        let channels = AnyChannels::sort(channels);
        let attributes = LayerAttributes::named(name);
        Layer::new(Vec2(WIDTH, HEIGHT), attributes, encoding, channels)
    };
    let layers: Layers<AnyChannels<FlatSamples>> = [layer("one"), layer("two")].into();
    let image = Image::from_layers(
        exr::prelude::ImageAttributes::with_size((WIDTH, HEIGHT)),
        layers,
    );
    written(|bytes| image.write().non_parallel().to_buffered(bytes))
}

fn light() -> LinearPicture {
    let (height, width) = (HEIGHT as f32, WIDTH as f32);
    Array2::from_shape_fn((HEIGHT, WIDTH), |(y, x)| {
        [y as f32 / height, x as f32 / width, 0.5]
    })
}

/// A picture, and labels of layers.
pub fn png() -> Vec<Vec<u8>> {
    let labels = Array2::from_shape_fn((HEIGHT, WIDTH), |(y, x)| ((x + y) % 4) as u8);
    vec![
        written(|bytes| write_png(&light(), &exchange_files::provenance(), bytes)),
        written(|bytes| write_labels(&labels, 4, bytes)),
    ]
}

/// Pictures without and with the notes of a camera.
pub fn jpeg() -> Vec<Vec<u8>> {
    let noted = |orientation| photographs::jpeg_with(&photographs::exif(orientation), &light());
    vec![
        written(|bytes| niji_photo::write_jpeg(&light(), bytes)),
        noted(1),
        noted(6),
    ]
}

/// Corners and indices of the meshes.
pub fn buffer() -> Vec<u8> {
    let corners = CORNERS.iter().flatten().flat_map(|it| it.to_le_bytes());
    let indices = TRIANGLES.iter().flatten().flat_map(|it| it.to_le_bytes());
    corners.chain(indices).collect()
}

pub fn obj() -> Vec<u8> {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces =
        "vt 0 0\nvn 0 0 1\nusemtl a\nf 1/1 3 2\nf 1//1 2 4\nf -4 -1 -2\nf 2/1/1 3 4\nf 1 2 3 4\n";
    (corners + faces).into_bytes()
}

pub fn gltf(uri: Option<&str>) -> Vec<u8> {
    let uri = uri
        .map(|uri| format!("\"uri\":\"{uri}\","))
        .unwrap_or_default();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"scale":[1,2,3],"children":[1,2]}},{{"mesh":0,"translation":[5,0,0]}},
        {{"mesh":0,"rotation":[0,0,0,1]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":0,"TEXCOORD_0":2}},"indices":1,
        "material":0}}]}}],"materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[0.5,0.4,1,1],
        "baseColorTexture":{{"index":0}}}}}}],"textures":[{{"sampler":0,"source":0}}],
        "samplers":[{{"wrapS":33071}}],"images":[{{"bufferView":1}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"byteOffset":0,"componentType":5123,"count":12,"type":"SCALAR"}},
        {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC2"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48,"byteStride":12}},
        {{"buffer":0,"byteOffset":48,"byteLength":24}}],"buffers":[{{{uri}"byteLength":72}}]}}"#
    )
    .into_bytes()
}

pub fn glb(buffer: &[u8]) -> Vec<u8> {
    let chunk = |name: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes(), name, content].concat()
    };
    let chunks = [chunk(b"JSON", &gltf(None)), chunk(b"BIN\0", buffer)].concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [&b"glTF"[..], &[2, 0, 0, 0], &length, &chunks].concat()
}

pub fn stl() -> Vec<u8> {
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

pub fn stl_text() -> Vec<u8> {
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

/// Every scene that ships, but those of ice; the first changes from frame to frame.
pub fn scenes() -> Vec<Vec<u8>> {
    let mut scenes = shipped(false);
    let sequence = b"\n[sequence]\nsun.elevation_deg = [[1, 10.0], [240, 20.0]]\n";
    scenes[0].extend(sequence);
    scenes
}

/// Scenes of shapes that ship, as small pictures without the light of the air, so that they are planned soon.
pub fn small_scenes() -> Vec<Vec<u8>> {
    let small = |text: &Vec<u8>| {
        let mut scene: toml::Table = std::str::from_utf8(text).unwrap().parse().unwrap();
        let few = "width_px = 8\nheight_px = 6\n".parse::<toml::Table>();
        let plain = "[spectrum]\nfirst_nm = 450.0\nstep_nm = 100.0\nn_wavelengths = 2\n\
                     [effects]\nsky = \"off\"\nair_inscatter = \"off\"\n[accuracy]\npreset = \"draft\"\n";
        let is_small = ["photo", "occluders", "terrain"]
            .iter()
            .all(|key| !scene.contains_key(*key));
        let camera = scene.get_mut("camera")?.as_table_mut()?;
        let is_pinhole = !camera.contains_key("projection");
        camera.extend(few.unwrap());
        scene.extend(plain.parse::<toml::Table>().unwrap());
        (is_small && is_pinhole).then(|| scene.to_string().into_bytes())
    };
    shipped(false).iter().filter_map(small).collect()
}

/// Every scene of ice that ships.
pub fn ice_scenes() -> Vec<Vec<u8>> {
    shipped(true)
}

fn shipped(is_ice: bool) -> Vec<Vec<u8>> {
    // The fuzz targets are a workspace of their own inside this one.
    let parents = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    let mut folders = parents.map(|parent| parent.join("data/scenes"));
    let folder = folders.find(|folder| folder.is_dir()).unwrap();
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let mut files: Vec<_> = files.collect();
    files.sort();
    let texts = files.iter().map(|file| fs::read(file).unwrap());
    let names_ice = |text: &Vec<u8>| text.windows(5).any(|window| window == b"\n[ice");
    texts.filter(|text| names_ice(text) == is_ice).collect()
}

pub fn layers() -> Vec<Vec<u8>> {
    let layer = |distance_m| niji_photo::Layer {
        color: [0.2, 0.5, 1.0],
        share: 0.25,
        distance_m,
    };
    vec![niji_photo::layers_to_toml(&[layer(f64::INFINITY), layer(12.5)]).into_bytes()]
}

/// What `niji plan SCENE -o FILE` writes.
pub fn choices() -> Vec<Vec<u8>> {
    let choice = |scene: &Vec<u8>| {
        let text = std::str::from_utf8(scene).unwrap();
        let scene = Scene::from_toml(text).unwrap();
        let planned = PlannedScene::new(scene, PlanRequest::default()).unwrap();
        toml::to_string(&planned.choice).unwrap().into_bytes()
    };
    small_scenes().iter().take(1).map(choice).collect()
}
