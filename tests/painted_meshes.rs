//! Lit meshes with their own base colors and textures: against the same mesh of one albedo, and files that lie.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use ndarray::Array2;
use ndarray::Array3;
use niji_photo::write_jpeg;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::unwatched;
use niji_radiometry::srgb_decode;
use niji_scene::Scene;

/// A meter above the ground; the only drops are behind the eye.
const SCENE: &str = r#"
format = 1
name = "painted"
[sun]
elevation_deg = 25.0
azimuth_deg = 150.0
[camera]
position_m = [0.0, 1.0, 0.0]
azimuth_deg = 0.0
elevation_deg = -60.0
horizontal_fov_deg = 5.0
width_px = 4
height_px = 3
[spectrum]
first_nm = 430.0
step_nm = 60.0
n_wavelengths = 5
[drops]
shape = "uniform"
box_min_m = [-50.0, 0.0, 200.0]
box_max_m = [50.0, 50.0, 300.0]
number_density_m3 = 1.0
law = { monodisperse = { radius_um = 500.0 } }
voxel_m = 50.0
[air]
constituents = ["rayleigh"]
[effects]
drop_shadow = "off"
"#;

/// North-west, north-east, south-west, south-east.
const SQUARES: [[u8; 3]; 4] = [
    [200, 60, 40],
    [30, 120, 210],
    [128, 128, 128],
    [250, 240, 90],
];

/// A square of 25 cm, a centimetre over the ground, in the middle of the view: half of it is a square of the board.
const CORNERS: [[f32; 3]; 4] = [
    [-0.125, 0.0078125, -0.4375],
    [0.125, 0.0078125, -0.4375],
    [0.125, 0.0078125, -0.6875],
    [-0.125, 0.0078125, -0.6875],
];
/// To the right and down, as glTF has them, 1.5 wide so that it repeats.
const UV: [[f32; 2]; 4] = [[2.0, 1.0], [3.0, 1.0], [3.0, 0.0], [2.0, 0.0]];

fn seen_in(folder: &Path, mesh: &str) -> Result<Array3<f32>, String> {
    let text = format!("{SCENE}[[occluders.meshes]]\n{mesh}\n");
    let request = PlanRequest {
        folder,
        ..PlanRequest::default()
    };
    let planned = PlannedScene::new(Scene::from_toml(&text).unwrap(), request);
    let image = planned.and_then(|it| it.picture(&unwatched));
    Ok(image.map_err(|error| error.to_string())?.radiance)
}

fn png(size: [u32; 2], rgb: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    let codes: Vec<u8> = (0..size[1])
        .flat_map(|y| (0..size[0]).map(move |x| (x, y)))
        .flat_map(|(x, y)| rgb(x, y))
        .collect();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&codes).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Two by two squares of 16 x 16 texels.
fn board() -> Vec<u8> {
    png([32, 32], |x, y| SQUARES[(2 * (y / 16) + x / 16) as usize])
}

const MTL: &str = "newmtl board\nKd 1 1 1\nmap_Kd board.png\n";

fn obj() -> String {
    let corners = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let uv = UV.map(|[u, v]| format!("vt {u} {}\n", 1.0 - v)).concat();
    format!("mtllib a.mtl\n{corners}{uv}usemtl board\nf 1/1 2/2 3/3 4/4\n")
}

/// The same with a material, and a picture behind corners and texture coordinates in its one buffer.
fn gltf(material: &str, picture: &[u8]) -> (String, Vec<u8>) {
    let numbers = CORNERS.iter().flatten().chain(UV.iter().flatten());
    let mut buffer: Vec<u8> = numbers.flat_map(|it| it.to_le_bytes()).collect();
    buffer.extend([0_u8, 1, 2, 0, 2, 3]);
    buffer.extend([0; 2]);
    buffer.extend(picture);
    let (n_picture, n) = (picture.len(), buffer.len());
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[
        {{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{material}}}],"textures":[{{"source":0}}],
        "images":[{{"bufferView":3,"mimeType":"image/png"}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
        {{"bufferView":2,"componentType":5121,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
        {{"buffer":0,"byteOffset":80,"byteLength":6}},{{"buffer":0,"byteOffset":88,"byteLength":{n_picture}}}],
        "buffers":[{{"byteLength":{n}}}]}}"#
    );
    (json, buffer)
}

fn glb((json, buffer): &(String, Vec<u8>)) -> Vec<u8> {
    let chunk = |name: &[u8], content: &[u8]| {
        [&(content.len() as u32).to_le_bytes(), name, content].concat()
    };
    let chunks = [chunk(b"JSON", json.as_bytes()), chunk(b"BIN\0", buffer)].concat();
    let length = (12 + chunks.len() as u32).to_le_bytes();
    [&b"glTF"[..], &[2, 0, 0, 0], &length, &chunks].concat()
}

const TEXTURED: &str = r#"{"baseColorTexture":{"index":0}}"#;

/// A folder with the board as an OBJ and as a GLB.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("a.obj", obj().as_bytes());
    write("a.mtl", MTL.as_bytes());
    write("board.png", &board());
    write("a.glb", &glb(&gltf(TEXTURED, &board())));
    folder
}

fn painted(name: &str) -> String {
    format!("file = \"{name}\"\nalbedo = \"materials\"")
}

/// Its linear color as a scene names it.
fn albedo(codes: [u8; 3]) -> String {
    let linear = codes.map(|code| srgb_decode(f64::from(code) / 255.0) as f32);
    format!("albedo = {:?}", linear.map(f64::from))
}

#[test]
fn a_square_of_a_texture_is_lit_as_the_mesh_of_its_color() {
    let folder = folder();
    let found = seen_in(folder.path(), &painted("a.obj")).unwrap();
    for (codes, (y, x)) in SQUARES.into_iter().zip([(0, 0), (0, 3), (2, 0), (2, 3)]) {
        let plain = format!("file = \"a.obj\"\n{}", albedo(codes));
        let plain = seen_in(folder.path(), &plain).unwrap();
        for wavelength in 0..5 {
            let (found, plain) = (found[[wavelength, y, x]], plain[[wavelength, y, x]]);
            // Measured 1.2e-6: beside an edge of squares a pixel has more rays.
            assert!(plain > 0.0);
            assert!(
                (found / plain - 1.0).abs() < 5e-6,
                "{codes:?}: {found} {plain}"
            );
        }
    }
    // Between two squares there is light of both.
    let between = found[[0, 0, 1]];
    let (west, east) = (found[[0, 0, 0]], found[[0, 0, 3]]);
    assert!(between >= west.min(east) * 0.999 && between <= west.max(east) * 1.001);
}

#[test]
fn the_same_model_as_obj_glb_and_gltf_gives_the_same_picture() {
    let folder = folder();
    let in_obj = seen_in(folder.path(), &painted("a.obj")).unwrap();
    assert_eq!(in_obj, seen_in(folder.path(), &painted("a.glb")).unwrap());
    // Buffer and picture as data and as a file beside.
    let (json, buffer) = gltf(TEXTURED, &board());
    let data = format!(
        "\"uri\":\"data:;base64,{}\",\"byteLength\"",
        BASE64.encode(&buffer)
    );
    let json = json.replace(
        "\"buffers\":[{\"byteLength\"",
        &format!("\"buffers\":[{{{data}"),
    );
    let picture = format!("data:image/png;base64,{}", BASE64.encode(board()));
    for uri in ["board.png", &picture] {
        let json = json.replace(
            "\"bufferView\":3,\"mimeType\"",
            &format!("\"uri\":\"{uri}\",\"mimeType\""),
        );
        fs::write(folder.path().join("b.gltf"), json).unwrap();
        assert_eq!(in_obj, seen_in(folder.path(), &painted("b.gltf")).unwrap());
    }
}

#[test]
fn factors_multiply_linear_light_and_code_values_are_those_of_the_standard() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let close = |a: &Array3<f32>, b: &Array3<f32>| {
        a.iter()
            .zip(b)
            .all(|(a, b)| *b > 0.0 && (a / b - 1.0).abs() < 1e-6)
    };
    // IEC 61966-2-1: 128 of 255 is 0.21586050; alpha is no part of it.
    let gray = png([8, 8], |_, _| [128; 3]);
    let plain = seen_in(folder.path(), "file = \"a.obj\"\nalbedo = 0.10793025").unwrap();
    let halved = r#"{"baseColorFactor":[0.5,0.5,0.5,0.25],"baseColorTexture":{"index":0}}"#;
    write("b.glb", &glb(&gltf(halved, &gray)));
    assert!(close(
        &seen_in(folder.path(), &painted("b.glb")).unwrap(),
        &plain
    ));
    let mut jpeg = Vec::new();
    write_jpeg(&Array2::from_elem((16, 16), [0.2158605; 3]), &mut jpeg).unwrap();
    write("b.glb", &glb(&gltf(halved, &jpeg)));
    assert!(close(
        &seen_in(folder.path(), &painted("b.glb")).unwrap(),
        &plain
    ));
    write("a.mtl", b"newmtl board\nKd 0.5 0.5 0.5\nmap_Kd gray.png\n");
    write("gray.png", &gray);
    assert!(close(
        &seen_in(folder.path(), &painted("a.obj")).unwrap(),
        &plain
    ));
    // A color alone is linear, to the last bit that of an albedo.
    let plain = seen_in(folder.path(), "file = \"a.obj\"\nalbedo = [0.3, 0.5, 0.1]").unwrap();
    write("a.mtl", b"newmtl board\nKd 0.3 0.5 0.1\n");
    assert_eq!(seen_in(folder.path(), &painted("a.obj")).unwrap(), plain);
    write(
        "b.glb",
        &glb(&gltf(r#"{"baseColorFactor":[0.3,0.5,0.1,1]}"#, &[])),
    );
    assert_eq!(seen_in(folder.path(), &painted("b.glb")).unwrap(), plain);
}

#[test]
fn what_is_wrong_with_materials_names_the_mesh_the_texture_and_the_key() {
    let folder = folder();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let refused = |name: &str| seen_in(folder.path(), &painted(name)).unwrap_err();
    for (mtl, words) in [
        ("newmtl other\n", "no material \"board\""),
        ("newmtl board\nmap_Kd lost.png\n", "lost.png"),
        ("newmtl board\nmap_Kd ../board.png\n", "../board.png"),
        ("newmtl board\nmap_Kd a.mtl\n", "texture \"a.mtl\""),
        ("newmtl board\nmap_Kd cut.png\n", "texture \"cut.png\""),
        ("newmtl board\nmap_Kd vast.png\n", "texture \"vast.png\""),
        (
            "newmtl board\nmap_Kd -s 2 2 2 board.png\n",
            "without options",
        ),
        ("newmtl board\nKd 0.2 0.3\n", "line 2"),
        ("newmtl board\nKd 0.2 0.3 nan\n", "0 to 1"),
        ("newmtl board\nKd spectral a.rfl\n", "red, green and blue"),
    ] {
        write("a.mtl", mtl.as_bytes());
        write("cut.png", &board()[..60]);
        // A header that promises 2^30 pixels in a few bytes.
        let mut vast = board();
        vast[16..24].copy_from_slice(&[0, 0, 128, 0, 0, 0, 128, 0]);
        write("vast.png", &vast);
        let message = refused("a.obj");
        for word in ["a.obj", "albedo = \"materials\"", words] {
            assert!(message.contains(word), "{mtl}: {message}");
        }
        // Nothing of it matters to a mesh of one albedo.
        assert!(seen_in(folder.path(), "file = \"a.obj\"\nalbedo = 0.2").is_ok());
    }
    write("a.mtl", MTL.as_bytes());
    for (from, to) in [
        ("mtllib a.mtl", "mtllib lost.mtl"),
        ("usemtl board", ""),
        ("f 1/1 2/2 3/3 4/4", "f 1 2 3 4"),
        ("vt 2 0\n", "vt nan 0\n"),
        ("vt 2 0\n", "vt\n"),
        ("4/4", "4/5"),
    ] {
        write("b.obj", obj().replace(from, to).as_bytes());
        let message = refused("b.obj");
        assert!(
            message.contains("b.obj") && message.contains("materials"),
            "{to}: {message}"
        );
    }
    let (json, buffer) = gltf(TEXTURED, &board());
    let moved = r#""baseColorTexture":{"extensions":{"KHR_texture_transform":{}},"#;
    for (from, to) in [
        ("\"material\":0", "\"material\":1"),
        ("{\"index\":0}", "{\"index\":1}"),
        ("{\"index\":0}", "{\"index\":0,\"texCoord\":1}"),
        ("\"baseColorTexture\":{", moved),
        ("{\"source\":0}", "{\"source\":1}"),
        ("{\"source\":0}", "{}"),
        ("{\"source\":0}", "{\"source\":0,\"sampler\":0}"),
        ("\"bufferView\":3", "\"bufferView\":9"),
        ("\"bufferView\":3,", ""),
        ("\"byteOffset\":88", "\"byteOffset\":89"),
        ("\"byteOffset\":88", "\"byteOffset\":99999"),
        ("\"bufferView\":3", "\"uri\":\"/dev/zero\""),
        (",\"TEXCOORD_0\":1", ""),
        ("\"TEXCOORD_0\":1", "\"TEXCOORD_0\":0"),
        (
            "\"count\":4,\"type\":\"VEC2\"",
            "\"count\":3,\"type\":\"VEC2\"",
        ),
        (
            "\"baseColorTexture\"",
            "\"baseColorFactor\":[2,0,0,1],\"baseColorTexture\"",
        ),
        ("\"materials\":[", "\"matter\":["),
    ] {
        assert!(json.contains(from), "{from}");
        write("b.glb", &glb(&(json.replace(from, to), buffer.clone())));
        let message = refused("b.glb");
        assert!(
            message.contains("b.glb") && message.contains("materials"),
            "{to}: {message}"
        );
    }
    let mut nan = buffer.clone();
    nan[48..52].copy_from_slice(&f32::NAN.to_le_bytes());
    write("b.glb", &glb(&(json, nan)));
    assert!(refused("b.glb").contains("texture coordinate"));
}
