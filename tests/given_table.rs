//! One scattering table for any scene of its water, wavelengths and theory; refused, with the key to change,
//! where it does not serve.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::path::Path;
use std::path::PathBuf;

use niji_exchange::SpectralImage;

use support::niji_ends_with;
use support::run_scene;
use support::text;
use support::variant;

/// Small pictures of few wavelengths.
const SMALL: [(&str, &str); 5] = [
    ("camera.width_px", "96"),
    ("camera.height_px", "64"),
    ("spectrum.first_nm", "450.0"),
    ("spectrum.step_nm", "50.0"),
    ("spectrum.n_wavelengths", "4"),
];

/// The same wavelengths as flags, and the water and orders of a scene that says nothing of them.
const FLAGS: &str = "--spectrum 450,50,4 --temperature-c 15 --orders 0,2,3,6,7 --relative-error 0.005 \
     --phase-functions";

/// RMS of a picture from one table for all against that from its own, over the brightest value of any
/// wavelength; measured below 0.1 %.
const LARGEST_RMS: f64 = 5e-3;

/// Writes a table by flags.
fn table(folder: &Path, name: &str, flags: &str) -> PathBuf {
    let path = folder.join(name);
    let flags = format!("scatter -q {flags}");
    let mut arguments: Vec<&str> = flags.split_whitespace().collect();
    arguments.extend(["-o", text(&path)]);
    niji_ends_with(0, &arguments);
    path
}

/// A shipped scene, small, with other changes.
fn small(name: &str, folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    variant(name, folder, &[&SMALL[..], changes].concat())
}

/// What a run with a given table says and how it ends.
fn run(code: i32, scene: &Path, table: &Path, to: &Path) -> String {
    let arguments = ["run", text(scene), "--table", text(table), "-o", text(to)];
    String::from_utf8(niji_ends_with(code, &arguments).stderr).unwrap()
}

fn image(folder: &Path) -> SpectralImage {
    SpectralImage::read_spectral(&folder.join("image.exr")).unwrap()
}

/// RMS of the difference over the largest value.
fn rms_over_peak(own: &SpectralImage, given: &SpectralImage) -> f64 {
    let pairs = own.radiance.iter().zip(&given.radiance);
    let squares: f64 = pairs
        .map(|(own, given)| f64::from(given - own).powi(2))
        .sum();
    let peak = own.radiance.iter().fold(0.0_f32, |peak, it| peak.max(*it));
    (squares / own.radiance.len() as f64).sqrt() / f64::from(peak)
}

#[test]
fn one_table_serves_fog_spray_and_rain() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "--theory by-size --radii-um 1,4000 --effective-variance 0.05 --flattened \
                 --theta-deg 50,180";
    let table = table(folder.path(), "any.exr", &format!("{flags} {FLAGS}"));
    let scenes = [
        ("rain-cell", "120.0"),
        ("waterfall-gorge", "5.0"),
        ("fog-bank-fogbow", "10.0"),
    ];
    for (name, voxel_m) in scenes {
        let inside = |part: &str| folder.path().join(format!("{name}-{part}"));
        let scene = small(
            &format!("{name}.toml"),
            folder.path(),
            &[("drops.voxel_m", voxel_m)],
        );
        let (_, own) = run_scene(&scene, &inside("own"));
        run(0, &scene, &table, &inside("given"));
        assert!(!inside("given").join("scatter.exr").exists());
        let rms = rms_over_peak(&own, &image(&inside("given")));
        // Not the scene's own table by mistake.
        assert!(rms > 0.0 && rms < LARGEST_RMS, "{name}: {rms:e}");
        // Nor is the picture's error told by what the table holds of other drops and angles.
        let told = |folder: &Path| -> f64 {
            let image = image(folder);
            let error = image.aovs.iter().find(|aov| aov.name == "error").unwrap();
            let (_, plane) = error.channels.iter().find(|(it, _)| it == "Y").unwrap();
            plane.iter().map(|it| f64::from(*it)).sum()
        };
        let [of_own, of_given] = ["own", "given"].map(|part| told(&inside(part)));
        assert!(of_given < 5.0 * of_own, "{name}: {of_own} {of_given}");
        // The stage by itself gives the same bytes.
        let alone = inside("alone.exr");
        let drops = inside("own").join("drops.vdb");
        let air = inside("own").join("atmosphere.exr");
        let inputs = [
            ("--scene", &scene),
            ("--drops", &drops),
            ("--table", &table),
        ];
        let mut arguments = vec!["render", "-q", "--air", text(&air), "-o", text(&alone)];
        arguments.extend(inputs.iter().flat_map(|(flag, path)| [*flag, text(path)]));
        niji_ends_with(0, &arguments);
        assert_eq!(
            std::fs::read(&alone).unwrap(),
            std::fs::read(inside("given").join("image.exr")).unwrap()
        );
    }
}

#[test]
fn spheres_take_a_table_for_flattened_drops_as_one_for_spheres() {
    let folder = tempfile::tempdir().unwrap();
    let off = [("effects.drop_flattening", "\"off\"")];
    let scene = small("rain-cell.toml", folder.path(), &off);
    let flags = format!("--theory uniform --radii-um 5,4000 --effective-variance 0.3 {FLAGS}");
    let flat = table(folder.path(), "flat.exr", &format!("{flags} --flattened"));
    let spheres = table(folder.path(), "spheres.exr", &flags);
    let [flat, spheres] = [flat, spheres].map(|table| {
        let to = table.with_extension("out");
        run(0, &scene, &table, &to);
        image(&to)
    });
    // The flat one has the angles of its orders too; both err by up to 5e-3. Measured 3.2e-5.
    let rms = rms_over_peak(&spheres, &flat);
    assert!(rms < 1e-4, "{rms:e}");
}

#[test]
fn a_table_that_does_not_serve_is_refused_with_the_key_to_change() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small("twinned-bow.toml", folder.path(), &[]);
    let sound = "--theory uniform --radii-um 20,1000 --effective-variance 0.003 --flattened";
    let sound = format!("{sound} --theta-deg 90,180 {FLAGS}");
    let refused = |name: &str, flags: &str, words: &[&str]| {
        let table = table(folder.path(), &format!("{name}.exr"), flags);
        let to = folder.path().join(name);
        let found = run(3, &scene, &table, &to);
        for word in words.iter().chain(&["found", "expected"]) {
            assert!(found.contains(word), "{word} in {found}");
        }
        // At once: nothing was made.
        assert!(!to.exists(), "{name}");
    };
    let with = |from: &str, to: &str| {
        assert!(sound.contains(from), "{from}");
        sound.replace(from, to)
    };
    refused(
        "water",
        &with("--temperature-c 15", "--temperature-c 60"),
        &["water", "60", "15", "--temperature-c", "[water]"],
    );
    refused(
        "salt",
        &format!("{sound} --salinity-per-mille 35"),
        &["water", "35 per mille", "--salinity-per-mille", "[water]"],
    );
    refused(
        "wavelengths",
        &with("450,50,4", "450,50,3"),
        &["450,50,3", "--spectrum 450,50,4", "[spectrum]"],
    );
    refused(
        "radii",
        &with("20,1000", "200,1000"),
        &["radii", "--radii-um"],
    );
    refused(
        "widths",
        &with("0.003", "0.1"),
        &["narrowest law", "0.0030", "--effective-variance"],
    );
    refused(
        "spheres",
        &with("--flattened", ""),
        &["spheres", "--flattened", "effects.drop_flattening"],
    );
    refused(
        "theory",
        &with("uniform", "geometric"),
        &["geometric", "--theory uniform", "accuracy.theory"],
    );
    refused(
        "orders",
        &with("0,2,3,6,7", "2,3"),
        &["orders", "--orders 0,2,3,6,7", "effects.higher_orders"],
    );
    refused("angles", &with("90,180", "130,180"), &["--theta-deg"]);
    refused(
        "disc",
        &format!("{sound} --sun-disc-deg 0"),
        &["0.5330", "--sun-disc-deg", "effects.sun_disc"],
    );
    refused(
        "error",
        &with("0.005", "0.02"),
        &["0.02", "--relative-error", "accuracy.table_relative_error"],
    );
    let sound = table(folder.path(), "sound.exr", &sound);
    run(0, &scene, &sound, &folder.path().join("sound"));
    // Drops that lie otherwise.
    let motion = [("drop_motion.tilt_sd_deg", "12.0")];
    let scene = small("twinned-bow.toml", folder.path(), &motion);
    let found = run(3, &scene, &sound, &folder.path().join("tilted"));
    assert!(
        found.contains("[drop_motion]") && found.contains("12 degrees"),
        "{found}"
    );
}

#[test]
fn a_table_that_nothing_needs_is_not_taken_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let scene = small("clear-sky.toml", folder.path(), &[]);
    let none = folder.path().join("none.exr");
    let found = run(0, &scene, &none, &folder.path().join("out"));
    assert!(found.contains("--table is not used"), "{found}");
}
