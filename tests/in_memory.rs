//! The library makes in memory what `niji run` leaves as files, byte by byte.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Mutex;

use niji_exchange::FrameTime;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_exchange::content_hash;
use niji_photo::read_picture_provenance;
use niji_photo::write_png;
use niji_picture::Error;
use niji_picture::PictureParts;
use niji_picture::PictureSettings;
use niji_picture::PictureWork;
use niji_picture::PlanRequest;
use niji_picture::PlannedScene;
use niji_picture::SequenceChoice;
use niji_picture::SequenceRequest;
use niji_picture::SurfaceFiles;
use niji_picture::air;
use niji_picture::scattering;
use niji_picture::scene_from_toml;
use niji_picture::unwatched;
use niji_scatter::airy_to_file;
use niji_scene::Scene;
use niji_scene::Sequence;
use niji_scene::Stage;
use niji_vdb::Compression;
use support::niji_ends_with;
use support::repository;
use support::text;
use support::variant;

/// The files of a run, and what is known of those that a value was compared with.
struct Files<'a> {
    folder: &'a Path,
    hashes: BTreeMap<&'static str, String>,
}

impl Files<'_> {
    /// The file of a role, which is `NAME.EXT`, or `NAME.HASH.EXT` where frames share it.
    fn path(&self, name: &str) -> PathBuf {
        let exact = self.folder.join(name);
        if exact.is_file() {
            return exact;
        }
        let (stem, extension) = name.rsplit_once('.').unwrap();
        let is_it = |found: &str| {
            found.starts_with(&format!("{stem}.")) && found.ends_with(&format!(".{extension}"))
        };
        let entries = fs::read_dir(self.folder).unwrap().map(Result::unwrap);
        let mut files = entries.map(|entry| entry.path());
        files
            .find(|path| is_it(path.file_name().unwrap().to_str().unwrap()))
            .unwrap()
    }

    /// Compares what was written in memory with the file.
    fn compare(&mut self, role: &'static str, name: &str, written: &[u8]) {
        let path = self.path(name);
        let is_same = fs::read(&path).unwrap() == written;
        assert!(is_same, "{} has other bytes", path.display());
        self.hashes.insert(role, content_hash(&path).unwrap());
    }

    /// What a stage says of its file.
    fn provenance(&self, stage: &str, settings: String, inputs: &[&str]) -> Provenance {
        let hash = |role: &&str| ((*role).to_owned(), self.hashes[*role].clone());
        Provenance {
            tool: format!("niji {stage}"),
            version: env!("NIJI_VERSION").to_owned(),
            settings,
            inputs: inputs.iter().map(hash).collect(),
        }
    }
}

fn bytes<E: std::fmt::Debug>(write: impl FnOnce(&mut Cursor<Vec<u8>>) -> Result<(), E>) -> Vec<u8> {
    let mut to = Cursor::new(Vec::new());
    write(&mut to).unwrap();
    to.into_inner()
}

/// Makes everything anew, compares it with the files of a run, and returns the image.
fn compare(planned: &PlannedScene, folder: &Path, image_name: &str) -> SpectralImage {
    let mut files = Files {
        folder,
        hashes: BTreeMap::new(),
    };
    let drops = planned.drops().unwrap();
    let settings = planned.drop_source.as_ref().unwrap().settings(false);
    let provenance = files.provenance("drops", settings, &[]);
    let vdb = drops.to_vdb(&provenance.to_text_items()).unwrap();
    let written = bytes(|to| vdb.write(to, Compression::None));
    files.compare("drops", "drops.vdb", &written);

    let airy = planned.airy().unwrap();
    if let Some(airy) = &airy {
        let file = airy_to_file(airy, files.provenance("airy", "{}".to_owned(), &[]));
        files.compare("airy", "airy.exr", &bytes(|to| file.write(to)));
    }
    let mut inputs = vec!["drops"];
    let table = planned.scattering(airy.as_ref(), &unwatched).unwrap();
    if let (Some(table), Some(need)) = (&table, &planned.plan.scattering) {
        let settings = scattering::settings(need, planned.scene.spectrum);
        let of_airy: &[&str] = if airy.is_some() { &["airy"] } else { &[] };
        let file = table.to_file(files.provenance("scatter", settings, of_airy));
        files.compare("table", "scatter.exr", &bytes(|to| file.write(to)));
        inputs.push("table");
    }
    let air = planned.air(&unwatched).unwrap();
    if let Some(air) = &air {
        let orders = planned.plan.scattering_orders();
        let settings = air::settings(&planned.scene, orders);
        let file = air.to_file(files.provenance("atmosphere", settings, &[]));
        files.compare("air", "atmosphere.exr", &bytes(|to| file.write(to)));
        inputs.push("air");
    }
    let mut surface_files = SurfaceFiles::of_scene(&planned.scene, &planned.folder);
    let depth_m = planned.photo_depth_m().unwrap();
    if depth_m.is_some() {
        let path = folder.join("depth.exr");
        files.hashes.insert("depth", content_hash(&path).unwrap());
        inputs.push("depth");
        surface_files = surface_files.with_depth(path);
    }
    let settings = PictureSettings::of(planned);
    let text = surface_files.settings(&settings);
    let parts = PictureParts {
        drops,
        table,
        air,
        surfaces: planned.surfaces(depth_m).unwrap(),
    };
    let whole = settings.whole().unwrap();
    let work = PictureWork::new(settings, parts, &unwatched).unwrap();
    let mut image = work.render(whole, &unwatched).unwrap();
    image.provenance = files.provenance("render", text, &inputs);
    files.compare("image", image_name, &bytes(|to| image.write_spectral(to)));
    image
}

fn request(folder: &Path) -> PlanRequest<'_> {
    PlanRequest {
        folder,
        ..PlanRequest::default()
    }
}

fn planned(text: &str, folder: &Path) -> PlannedScene {
    PlannedScene::new(scene_from_toml(text, folder).unwrap(), request(folder)).unwrap()
}

const SMALL: [(&str, &str); 2] = [("camera.width_px", "48"), ("camera.height_px", "32")];

#[test]
fn rain_in_air() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("rain-cell.toml", folder.path(), &SMALL);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let planned = planned(&fs::read_to_string(&scene).unwrap(), folder.path());
    let image = compare(&planned, &out, "image.exr");
    // In one call it is the same light.
    let at_once = planned.picture(&unwatched).unwrap();
    assert!(at_once.radiance == image.radiance && at_once.aovs == image.aovs);
}

#[test]
fn as_much_of_spectra_as_the_scene_keeps() {
    let folder = tempfile::tempdir().unwrap();
    for kept in ["\"half\"", "\"none\""] {
        let changes = [&SMALL[..], &[("picture.spectral", kept)]].concat();
        let scene = variant("paper-b-sun-20-inscatter.toml", folder.path(), &changes);
        let out = folder.path().join(kept.trim_matches('"'));
        niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
        let planned = planned(&fs::read_to_string(&scene).unwrap(), folder.path());
        let image = compare(&planned, &out, "image.exr");
        let at_once = planned.picture(&unwatched).unwrap();
        assert_eq!(at_once.spectra, image.spectra, "{kept}");
        assert!(at_once.radiance == image.radiance && at_once.aovs == image.aovs);
    }
}

#[test]
fn a_scene_without_light_has_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let no_light = [&SMALL[..], &[("camera.azimuth_deg", "180.0")]].concat();
    let scene = variant("paper-c-figure-3.toml", folder.path(), &no_light);
    let planned = planned(&fs::read_to_string(&scene).unwrap(), folder.path());
    let refused = planned.picture(&unwatched);
    assert!(matches!(refused, Err(Error::Dark { .. })));
    // So does the command line.
    let out = folder.path().join("out");
    niji_ends_with(4, &["run", text(&scene), "-o", text(&out), "-q"]);
}

#[test]
fn a_scene_that_was_changed_in_code_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let file = variant("paper-c-figure-3.toml", folder.path(), &SMALL);
    let scene = scene_from_toml(&fs::read_to_string(file).unwrap(), folder.path()).unwrap();
    for tolerance in [f64::NAN, -1.0] {
        let mut changed = scene.clone();
        changed.accuracy.tolerance = Some(tolerance);
        let refused = PlannedScene::new(changed, request(folder.path())).unwrap_err();
        let expected = format!("`accuracy.tolerance` is {tolerance}, expected 0.000001 to 1");
        assert_eq!(refused.to_string(), expected);
    }
}

#[test]
fn a_frame_of_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("garden-fountain.toml", folder.path(), &SMALL);
    let sequence = "\n[sequence]\nsun.elevation_deg = [[1, 29.5], [5, 30.5]]\n";
    let scene_text = fs::read_to_string(&scene).unwrap() + sequence;
    fs::write(&scene, &scene_text).unwrap();
    let out = folder.path().join("out");
    let flags = ["-q", "--frames", "3"];
    niji_ends_with(
        0,
        &[&["run", text(&scene), "-o", text(&out)], &flags[..]].concat(),
    );
    let sequence = Sequence::from_toml(&scene_text).unwrap().unwrap();
    let scene = |frame| scene_from_toml(&sequence.scene_text(frame), folder.path()).unwrap();
    let frames: Vec<(u32, Scene)> = (1..=5).map(|frame| (frame, scene(frame))).collect();
    let sequence_request = SequenceRequest {
        plan: request(folder.path()),
        settings: &sequence.settings(),
        frames: &frames,
        shutter: sequence.shutter,
        beside: &|frame, after| {
            scene_from_toml(&sequence.scene_text_beside(frame, after), folder.path())
        },
    };
    let mut choice = sequence_request.decide(&frames).unwrap();
    let written = fs::read_to_string(out.join("choice.toml")).unwrap();
    let written: SequenceChoice = toml::from_str(&written).unwrap();
    choice.request.clone_from(&written.request);
    choice.version.clone_from(&written.version);
    assert_eq!(choice, written);
    let time = FrameTime {
        frame: 3,
        frames_per_second: 24.0,
    };
    let planned = PlannedScene::of_frame((scene(3), time, Vec::new()), folder.path(), &choice);
    compare(&planned, &out, "image.0003.exr");
}

#[test]
fn a_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let shipped = repository("data/scenes/photo-pavilion-rain.toml");
    let photos = repository("data/photos");
    let scene_text = fs::read_to_string(shipped).unwrap();
    // Its sun follows from picks.
    let scene_text = scene_text
        .replace("../photos", text(&photos))
        .replace("width_px = 640", "width_px = 96")
        .replace("height_px = 427", "height_px = 64");
    let scene = folder.path().join("photo.toml");
    fs::write(&scene, &scene_text).unwrap();
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let planned = planned(&scene_text, folder.path());
    let image = compare(&planned, &out, "image.exr");
    let depth_m = planned.photo_depth_m().unwrap();
    let composite = planned.composite(&image, depth_m).unwrap().unwrap();
    let file = out.join("composite.png");
    let provenance = read_picture_provenance(&file).unwrap().unwrap();
    let shown = composite.background.shown(&composite.bow.picture, 0.0);
    let written = bytes(|to| write_png(&shown, &provenance, to));
    assert!(fs::read(&file).unwrap() == written);
}

#[test]
fn whoever_watches_hears_of_each_stage_and_may_stop_it() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant("rain-cell.toml", folder.path(), &SMALL);
    let planned = planned(&fs::read_to_string(&scene).unwrap(), folder.path());
    // The largest part of a stage that is heard of, if it is stopped then or not.
    let heard = |stage: Stage, then: ControlFlow<()>| {
        let largest = Mutex::new(None::<f64>);
        let picture = planned.picture(&|of, part| {
            if of != stage {
                return ControlFlow::Continue(());
            }
            let mut largest = largest.lock().unwrap();
            *largest = Some(largest.map_or(part, |largest| largest.max(part)));
            then
        });
        (picture.err(), largest.into_inner().unwrap().unwrap())
    };
    for stage in [Stage::Scatter, Stage::Atmosphere, Stage::Render] {
        let (none, part) = heard(stage, ControlFlow::Continue(()));
        assert!(
            none.is_none() && (part - 1.0).abs() < 1e-12,
            "{stage:?}: {part}"
        );
    }
    for stage in [Stage::Scatter, Stage::Atmosphere, Stage::Render] {
        let (stopped, part) = heard(stage, ControlFlow::Break(()));
        assert!(matches!(stopped, Some(Error::Stopped)), "{stage:?}");
        assert!(part < 1.0, "{stage:?}: {part}");
    }
}
