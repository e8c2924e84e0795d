//! The readers of all files that the program takes: one definition for the tests, the benchmark and libFuzzer.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use glam::DVec3;
use niji_dropfield::DensityImport;
use niji_dropfield::DensityMeans;
use niji_dropfield::DropVolume;
use niji_dropfield::EffectiveRadius;
use niji_exchange::AtmosphereTable;
use niji_exchange::Held;
use niji_exchange::Preview;
use niji_exchange::Provenance;
use niji_exchange::ScatteringTable;
use niji_exchange::SpectralImage;
use niji_exchange::StripReader;
use niji_exchange::TableFile;
use niji_exchange::contents;
use niji_exchange::read_plain;
use niji_exchange::read_provenance;
use niji_geometry::HeightField;
use niji_geometry::HeightMap;
use niji_geometry::MeshBvh;
use niji_geometry::MeshDetail;
use niji_geometry::Ray;
use niji_geometry::files_beside_mesh;
use niji_geometry::read_mesh;
use niji_geometry::read_painted_mesh;
use niji_photo::Photograph;
use niji_photo::Plate;
use niji_photo::read_depth_map;
use niji_photo::read_depth_values;
use niji_photo::read_labels;
use niji_photo::read_layer_distances;
use niji_photo::read_picture_provenance;
use niji_picture::Choice;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_scene::IceScene;
use niji_scene::Scene;
use niji_scene::SceneError;
use niji_scene::Sequence;
use niji_scene::SunPosition;
use niji_vdb::Compression;
use niji_vdb::VdbFile;
use niji_vdb::VdbHeader;

use super::Reader;
use super::samples;

/// The readers, each with sound files of its kind.
pub fn readers() -> Vec<Reader> {
    let alone = |file, samples, read| Reader {
        file,
        cost: 1,
        beside: Vec::new(),
        samples,
        read,
    };
    let buffer = samples::buffer();
    vec![
        alone("a.vdb", samples::vdb(), vdb),
        alone("table.exr", samples::tables(), table),
        alone("image.exr", samples::images(), table),
        alone("plate.exr", samples::plates(), plate),
        alone("a.png", samples::png(), photograph),
        alone("a.jpg", samples::jpeg(), photograph),
        alone("a.obj", vec![samples::obj()], mesh),
        Reader {
            beside: vec![("a.bin", buffer.clone())],
            ..alone("a.gltf", vec![samples::gltf(Some("a.bin"))], mesh)
        },
        alone("a.glb", vec![samples::glb(&buffer)], mesh),
        alone("a.stl", vec![samples::stl(), samples::stl_text()], mesh),
        alone("scene.toml", samples::scenes(), scene),
        Reader {
            cost: 20,
            ..alone("plan.toml", samples::small_scenes(), planned)
        },
        alone("ice.toml", samples::ice_scenes(), ice_scene),
        alone("layers.toml", samples::layers(), layers),
        alone("choice.toml", samples::choices(), choice),
    ]
}

/// What is read is written, and the same when it is read again.
fn vdb(path: &Path) -> bool {
    let header = VdbHeader::read(path);
    let Ok(file) = VdbFile::read(path) else {
        return false;
    };
    assert!(header.is_ok(), "a file without a header was read");
    // NaN is not equal to itself: the written bytes are compared, not the values.
    let written = |file: &VdbFile| {
        let mut bytes = Cursor::new(Vec::new());
        let outcome = file.write(&mut bytes, Compression::None);
        outcome.map(|()| bytes.into_inner())
    };
    if let Ok(bytes) = written(&file) {
        let again = VdbFile::parse(&bytes).expect("what was written is read");
        assert!(bytes == written(&again).unwrap(), "the voxels have changed");
    }
    let number = (DensityMeans::Number, 1.0);
    let import = DensityImport::in_metres(number, EffectiveRadius::Um(500.0), 0.1);
    let drops = [
        DropVolume::from_vdb(&file),
        DropVolume::from_density(&file, "density", &import),
    ];
    for volume in drops.iter().flatten() {
        let _ = volume.summary();
    }
    true
}

fn table(path: &Path) -> bool {
    let _ = read_provenance(path);
    let _ = contents(path);
    let _ = Preview::of_plain_image(path, 0.0, Provenance::default());
    if let Ok((rows, _)) = StripReader::open(path, Held::All) {
        let _ = rows.map(|it| it.is_ok()).filter(|is_ok| *is_ok).count();
    }
    let is_image = read_plain(path).is_ok() | SpectralImage::read_picture(path).is_ok();
    let Ok(file) = TableFile::read(path) else {
        return is_image;
    };
    let _ = AtmosphereTable::from_file(&file);
    let _ = ScatteringTable::from_file(file);
    true
}

fn plate(path: &Path) -> bool {
    Plate::read(path, None).is_ok() | read_depth_map(path).is_ok() | photograph(path)
}

fn photograph(path: &Path) -> bool {
    let _ = read_labels(path, 4);
    let _ = read_picture_provenance(path);
    Photograph::read(path).is_ok() | heights(path)
}

/// Values of a map are distances, or heights of which a field is made or refused.
fn heights(path: &Path) -> bool {
    let Ok(values) = read_depth_values(path) else {
        return false;
    };
    let (n_z, n_x) = values.dim();
    let field = HeightField::new(HeightMap {
        size: (n_x, n_z),
        height_m: values.into_iter().collect(),
        spacing_m: 1.0,
        corner: DVec3::ZERO,
    });
    let _ = field.map(|field| {
        let origin = DVec3::new(1.5, 1e9, 1.5);
        field.nearest(
            &Ray {
                origin,
                direction: DVec3::NEG_Y,
            },
            0.0,
        )
    });
    true
}

fn mesh(path: &Path) -> bool {
    let _ = files_beside_mesh(path);
    let lit = read_mesh(path, MeshDetail::Normals).map(MeshBvh::new);
    // What is wrong with normals is nothing to a black mesh.
    let painted = read_painted_mesh(path);
    read_mesh(path, MeshDetail::Shape).is_ok() | lit.is_ok() | painted.is_ok()
}

/// A scene survives its canonical JSON.
fn scene(path: &Path) -> bool {
    let text = text(path);
    if let Ok(Some(sequence)) = Sequence::from_toml(&text) {
        let _ = Scene::from_toml(&sequence.scene_text(7));
    }
    // A sun that follows from picks in a photograph stands in the south.
    let sun = SunPosition {
        elevation_deg: 20.0,
        azimuth_deg: 180.0,
    };
    let Ok(scene) = Scene::from_toml_with_picks(&text, |_| Ok::<_, SceneError>(sun.into())) else {
        return false;
    };
    let json = scene.canonical_json();
    let again = Scene::from_json(&json).expect("a scene's own JSON is a scene");
    assert_eq!(json, again.canonical_json());
    true
}

/// A scene is planned, or refused; what was decided survives its file.
fn planned(path: &Path) -> bool {
    let request = PlanRequest {
        folder: path.parent().unwrap_or(path),
        ..PlanRequest::default()
    };
    let scene = Scene::from_toml(&text(path));
    let Ok(Ok(planned)) = scene.map(|scene| PlannedScene::new(scene, request)) else {
        return false;
    };
    let choice = toml::to_string(&planned.choice).expect("a choice is TOML");
    let again: Choice = toml::from_str(&choice).expect("its own TOML is a choice");
    assert_eq!(toml::to_string(&again).expect("as before"), choice);
    true
}

fn ice_scene(path: &Path) -> bool {
    IceScene::from_toml(&text(path)).is_ok()
}

fn layers(path: &Path) -> bool {
    read_layer_distances(path).is_ok()
}

fn choice(path: &Path) -> bool {
    toml::from_str::<Choice>(&text(path)).is_ok()
}

fn text(path: &Path) -> String {
    String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned()
}
