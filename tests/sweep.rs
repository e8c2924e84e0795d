//! `niji sweep`: a sweep of a small scene gives points that make sense, a plot and a page.

mod support;

use std::fs;
use std::path::Path;

use support::niji;
use support::niji_ends_with;
use support::variant;

/// A row of the table by the names of its columns.
type Row = Vec<(String, String)>;

fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).expect("the table is there");
    let header = reader.headers().expect("it has a header").clone();
    let record = |record: csv::StringRecord| {
        let pairs = header.iter().zip(record.iter());
        pairs
            .map(|(name, value)| (name.to_owned(), value.to_owned()))
            .collect()
    };
    reader
        .records()
        .map(|found| record(found.expect("rows fit the header")))
        .collect()
}

fn text<'a>(row: &'a Row, column: &str) -> &'a str {
    let found = row.iter().find(|(name, _)| name == column);
    &found.expect("the column is there").1
}

fn number(row: &Row, column: &str) -> f64 {
    text(row, column).parse().expect("the column holds numbers")
}

#[test]
fn a_sweep_measures_every_level_against_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant(
        "paper-c-figure-3.toml",
        folder.path(),
        &[
            ("camera.width_px", "48"),
            ("camera.height_px", "36"),
            ("drops.voxel_m", "25.0"),
            ("spectrum.first_nm", "450.0"),
            ("spectrum.step_nm", "100.0"),
            ("spectrum.n_wavelengths", "2"),
        ],
    );
    let out = folder.path().join("sweep");
    let arguments = [
        "sweep",
        scene.to_str().unwrap(),
        "-o",
        out.to_str().unwrap(),
        "-q",
    ];
    niji_ends_with(0, &arguments);
    let rows = rows(&out.join("sweep.csv"));
    let of = |decision: &str| -> Vec<&Row> {
        rows.iter()
            .filter(|row| text(row, "decision") == decision)
            .collect()
    };
    // The air is not there, all else is.
    for absent in ["air_path", "sky"] {
        assert!(of(absent).is_empty());
    }
    for (decision, n_levels) in [
        ("preset", 3),
        ("theory", 6),
        ("table_relative_error", 4),
        ("integration", 5),
        ("sun_path", 4),
        ("pixel_footprint", 4),
    ] {
        let levels = of(decision);
        assert_eq!(levels.len(), n_levels, "{decision}");
        // The best level is the first of its decision, and nearer to itself than any other.
        assert!(number(levels[0], "own_relative_rmse") == 0.0);
    }
    let presets = of("preset");
    let error = |row: &Row| number(row, "relative_rmse");
    assert_eq!(text(presets[0], "level"), "reference");
    assert!(error(presets[0]) == 0.0);
    assert!(error(presets[1]) > 0.0 && error(presets[2]) > error(presets[1]));
    // Rays have no supernumeraries; the eye sees that.
    let theories = of("theory");
    let geometric = theories
        .iter()
        .find(|row| text(row, "level") == "geometric")
        .unwrap();
    assert!(error(geometric) > 0.1 && number(geometric, "max_color_difference") > 5.0);
    // The front falls: what takes longer errs less.
    let mut front: Vec<(f64, f64)> = rows
        .iter()
        .filter(|row| text(row, "on_front") == "true")
        .map(|row| (number(row, "seconds"), error(row)))
        .collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(front.len() >= 2 && front.windows(2).all(|pair| pair[1].1 <= pair[0].1));
    let page = fs::read_to_string(out.join("sweep.html")).unwrap();
    assert!(page.contains("<svg") && page.matches("data:image/png").count() >= 6);
    // One file: nothing is fetched from elsewhere.
    assert!(!page.contains("src=\"http") && !page.contains("href=\"http"));
    assert!(!out.join("runs").exists(), "an ended sweep keeps no runs");
    assert_eq!(
        niji(&arguments).status.code(),
        Some(2),
        "an output that exists"
    );
}
