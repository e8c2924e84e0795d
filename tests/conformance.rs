//! Conformance with independent readers and writers: OpenVDB, vdb-rs, OpenEXR, OpenImageIO,
//! colour-science and Mitsuba. Runs by name only, because it needs their packages; `.ci/run` installs them.
//!
//! `NIJI_CONFORMANCE_PYTHON` is the Python that has the PyPI packages (default `python3`); OpenVDB's
//! module belongs to the system's `/usr/bin/python3`.

#![allow(clippy::unwrap_used, unreachable_pub, reason = "a test may panic")]

mod support;
#[path = "conformance/vdb.rs"]
mod vdb;
#[path = "conformance/vdb_expected.rs"]
mod vdb_expected;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::Command;

use glam::DVec3;
use niji_dropfield::AreaMoments;
use niji_dropfield::DropVolume;
use niji_vdb::Compression;
use niji_vdb::VdbFile;
use support::niji_ends_with;
use support::repository;
use support::text;
use support::variant;

/// Debian's Python, which sees Debian's OpenVDB module.
const SYSTEM_PYTHON: &str = "/usr/bin/python3";
/// The fewest files that the matrix of OpenVDB's own files may have.
const FEWEST_MATRIX_FILES: usize = 20;

fn python() -> String {
    std::env::var("NIJI_CONFORMANCE_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

fn run(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output();
    let output = output.unwrap_or_else(|error| panic!("{program}: {error}"));
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(
        output.status.success(),
        "{program} {}\n{out}{err}",
        arguments.join(" ")
    );
    out
}

fn check_with_openvdb(path: &Path) {
    let file = VdbFile::read(path).expect("we read our own file");
    let expected = path.with_extension("json");
    std::fs::write(&expected, vdb_expected::expected(&file).to_string()).unwrap();
    let script = repository("tests/conformance/check_vdb.py");
    run(SYSTEM_PYTHON, &[text(&script), text(path), text(&expected)]);
}

#[test]
fn openvdb_reads_every_kind_of_file_that_we_write() {
    let folder = tempfile::tempdir().unwrap();
    for (name, file) in vdb_expected::samples() {
        for (compression, suffix) in [(Compression::None, "none"), (Compression::Zip, "zip")] {
            let path = folder.path().join(format!("{name}-{suffix}.vdb"));
            file.write(File::create(&path).unwrap(), compression)
                .unwrap();
            check_with_openvdb(&path);
        }
    }
}

#[test]
fn we_read_every_kind_of_file_that_openvdb_writes() {
    let folder = tempfile::tempdir().unwrap();
    let script = repository("tests/conformance/make_vdb_matrix.py");
    run(SYSTEM_PYTHON, &[text(&script), text(folder.path())]);
    let n_files = vdb::compare_matrix(folder.path());
    assert!(
        n_files >= FEWEST_MATRIX_FILES,
        "only {n_files} files in the matrix"
    );
}

#[test]
fn the_drop_volumes_of_scenes_are_read_by_openvdb_and_vdb_rs() {
    for (name, voxel_m) in [
        ("paper-c-figure-6.toml", "10.0"),
        ("paper-c-figure-3.toml", "10.0"),
        ("rain-shaft-5-mm-h.toml", "100.0"),
        ("rain-cell.toml", "150.0"),
        ("fog-bank-fogbow.toml", "10.0"),
        ("sea-spray.toml", "8.0"),
        ("garden-fountain.toml", "0.3"),
        ("waterfall-gorge.toml", "4.0"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let scene = variant(name, folder.path(), &[("drops.voxel_m", voxel_m)]);
        for flags in [&[][..], &["--zip"]] {
            let path = folder.path().join(format!("drops{}.vdb", flags.len()));
            let arguments = ["drops", "--scene", text(&scene), "-o", text(&path), "-q"];
            niji_ends_with(0, &[&arguments[..], flags].concat());
            check_with_openvdb(&path);
            check_with_vdb_rs(&path);
        }
    }
}

#[test]
fn clouds_on_foreign_lattices_of_openvdb_keep_their_water_and_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let script = repository("tests/conformance/make_foreign_vdb.py");
    let told = run(SYSTEM_PYTHON, &[text(&script), text(folder.path())]);
    let from_vdb = |name: &str, code, flags: &[&str]| {
        let file = folder.path().join(name).with_extension("vdb");
        let drops = folder.path().join("drops.vdb");
        let common = [
            "drops",
            "from-vdb",
            text(&file),
            "--density-means",
            "water",
            "--scale",
            "0.7",
            "-o",
            text(&drops),
            "--force",
            "-q",
        ];
        let ended = niji_ends_with(code, &[&common, flags].concat());
        (String::from_utf8(ended.stderr).unwrap(), drops)
    };
    let mut n_files = 0;
    for line in told.lines() {
        let told: serde_json::Value = serde_json::from_str(line).unwrap();
        let [name, integral, centre] = ["name", "integral", "centre"].map(|key| &told[key]);
        let name = name.as_str().unwrap();
        let centre: Vec<f64> = serde_json::from_value(centre.clone()).unwrap();
        // In units of the file, and in centimetres with z up.
        for (flags, metres) in [
            (&[][..], 1.0),
            (&["--up", "z", "--units-per-m", "100"][..], 0.01),
        ] {
            let radius = ["--effective-radius-um", "6 + temperature/50"];
            let (_, drops) = from_vdb(name, 0, &[&radius[..], flags].concat());
            check_with_openvdb(&drops);
            let volume = DropVolume::from_vdb(&VdbFile::read(&drops).unwrap()).unwrap();
            let mode = &volume.modes[0];
            let expected = 0.7 * integral.as_f64().unwrap() * metres * metres * metres;
            // f32 numbers and sizes; worst found 5e-8.
            let error = mode.total_water_g() / expected - 1.0;
            assert!(error.abs() < 1e-6, "{name} {flags:?} {error}");
            let in_file = |it: DVec3| {
                if flags.is_empty() {
                    it
                } else {
                    DVec3::new(it.x, -it.z, it.y) / metres
                }
            };
            let (mut sum, mut place) = (0.0, DVec3::ZERO);
            for (node, drops) in mode.nodes() {
                let at = in_file(mode.node_position(node));
                let water = f64::from(AreaMoments::from_drops(&drops).m3);
                (sum, place) = (sum + water, place + water * at);
                let radius_um = 1e6 * f64::from(drops.effective_radius_m);
                let expected_um = 6.0 + (100.0 + 2.0 * at.x) / 50.0;
                assert!(
                    (radius_um / expected_um - 1.0).abs() < 0.01,
                    "{name} {node:?}"
                );
            }
            let off = place / sum - DVec3::from_slice(&centre);
            assert!(
                off.length() < 0.02 * mode.voxel_m() / metres,
                "{name} {off}"
            );
        }
        n_files += 1;
    }
    assert_eq!(n_files, 3);
    let (said, _) = from_vdb("frustum", 3, &["--effective-radius-um", "10"]);
    assert!(
        said.contains("frustum") && said.contains("resample"),
        "{said}"
    );
}

fn check_with_vdb_rs(path: &Path) {
    let ours = VdbFile::read(path).unwrap();
    let stream = BufReader::new(File::open(path).unwrap());
    let mut reader = vdb_rs::VdbReader::new(stream).expect("vdb-rs opens the file");
    for grid in &ours.grids {
        let tree = grid.tree.as_float().expect("drop volumes hold floats");
        let theirs = reader
            .read_grid::<f32>(&grid.name)
            .expect("vdb-rs reads the grid");
        let mut n_voxels = 0;
        for (position, value, _) in theirs.iter() {
            let voxel = [position.x, position.y, position.z].map(|axis| axis as i32);
            assert_eq!(
                tree.get(voxel).to_bits(),
                value.to_bits(),
                "{} {voxel:?}",
                grid.name
            );
            n_voxels += 1;
        }
        assert_eq!(n_voxels, tree.active_voxel_count(), "{}", grid.name);
    }
}

#[test]
fn openexr_openimageio_and_colour_science_read_every_file_of_a_run() {
    let folder = tempfile::tempdir().unwrap();
    let small = [("camera.width_px", "96"), ("camera.height_px", "72")];
    let scene = variant("paper-b-sun-20-inscatter.toml", folder.path(), &small);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let path = |name: &str| out.join(name);
    let check_exr = repository("tests/conformance/check_exr.py");
    for name in [
        "airy.exr",
        "scatter.exr",
        "atmosphere.exr",
        "image.exr",
        "image.layers.exr",
    ] {
        run(&python(), &[text(&check_exr), text(&path(name))]);
    }
    let check_image = repository("tests/conformance/check_image.py");
    run(&python(), &[text(&check_image), text(&path("image.exr"))]);
    let check_layers = repository("tests/conformance/check_layers.py");
    let (layers, spectral) = (path("image.layers.exr"), path("image.exr"));
    run(
        &python(),
        &[text(&check_layers), text(&layers), text(&spectral)],
    );
    let acescg = [&small[..], &[("picture.primaries", "\"acescg\"")]].concat();
    let scene = variant("paper-b-sun-20-inscatter.toml", folder.path(), &acescg);
    let wide = folder.path().join("acescg");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&wide), "-q"]);
    let check_acescg = repository("tests/conformance/check_acescg.py");
    let pair = [path("image.layers.exr"), wide.join("image.layers.exr")];
    run(
        &python(),
        &[text(&check_acescg), text(&pair[0]), text(&pair[1])],
    );
    let example = repository("examples/read_table.py");
    let printed = run(&python(), &[text(&example), text(&path("scatter.exr"))]);
    assert!(printed.contains("theta"), "{printed}");
}

#[test]
fn openexr_knows_when_a_frame_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let small = [("camera.width_px", "24"), ("camera.height_px", "18")];
    let scene = variant("paper-c-figure-6.toml", folder.path(), &small);
    let still = std::fs::read_to_string(&scene).unwrap();
    let check = repository("tests/conformance/check_time.py");
    for (rate, frame, fraction, code) in [
        ("24", "1447", "24/1", "00:01:00:07"),
        ("29.97", "108000", "30000/1001", "01:00:00:00"),
    ] {
        let sequence = format!(
            "{still}\n[sequence]\nframes_per_second = {rate}\nsun.elevation_deg = [[1, 10.0], [2, 11.0]]\n"
        );
        std::fs::write(&scene, sequence).unwrap();
        let out = folder.path().join(rate);
        let run = [
            "run",
            text(&scene),
            "-o",
            text(&out),
            "--frames",
            frame,
            "-q",
        ];
        niji_ends_with(0, &run);
        for end in ["exr", "layers.exr"] {
            let path = out.join(format!("image.{frame:0>4}.{end}"));
            self::run(&python(), &[text(&check), text(&path), fraction, code]);
            let check_exr = repository("tests/conformance/check_exr.py");
            self::run(&python(), &[text(&check_exr), text(&path)]);
        }
    }
}

#[test]
fn openexr_and_openimageio_read_the_windows_of_overscan_and_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let small = [
        ("camera.width_px", "48"),
        ("camera.height_px", "36"),
        ("camera.overscan_px", "5"),
    ];
    let scene = variant("paper-c-figure-6.toml", folder.path(), &small);
    let out = folder.path().join("out");
    niji_ends_with(0, &["run", text(&scene), "-o", text(&out), "-q"]);
    let (drops, table) = (out.join("drops.vdb"), out.join("scatter.exr"));
    let tile = out.join("tile.exr");
    let inputs = ["--drops", text(&drops), "--table", text(&table)];
    let render = [
        "render",
        "--scene",
        text(&scene),
        "-q",
        "--region",
        "-5,7,30,12",
    ];
    niji_ends_with(0, &[&render[..], &inputs, &["-o", text(&tile)]].concat());
    let check = repository("tests/conformance/check_windows.py");
    for (name, data) in [
        ("image.exr", "-5,-5,58,46"),
        ("image.layers.exr", "-5,-5,58,46"),
        ("tile.exr", "-5,7,30,12"),
        ("tile.layers.exr", "-5,7,30,12"),
    ] {
        let path = out.join(name);
        run(&python(), &[text(&check), text(&path), data, "0,0,48,36"]);
        let check_exr = repository("tests/conformance/check_exr.py");
        run(&python(), &[text(&check_exr), text(&path)]);
    }
}

#[test]
fn mitsuba_scatters_what_an_exported_table_says() {
    let folder = tempfile::tempdir().unwrap();
    let export = |format: &str| {
        let path = folder.path().join(format);
        let flags = "scatter --theory uniform --effective-radius-um 100 --effective-variance 0.05 \
                     --theta-deg 100,180 --spectrum 450,100,3 --export";
        let mut arguments: Vec<&str> = flags.split_whitespace().collect();
        arguments.extend([format, "-o", text(&path), "-q"]);
        niji_ends_with(0, &arguments);
        path
    };
    let (phases, table) = (export("mitsuba"), export("csv"));
    let script = repository("tests/conformance/check_mitsuba.py");
    let printed = run(&python(), &[text(&script), text(&phases), text(&table)]);
    assert!(printed.contains("3 phase functions"), "{printed}");
}
