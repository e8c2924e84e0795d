//! One drop, five theories: comparing, drawing, exporting and evaluating them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::fs;
use std::path::Path;

use niji_exchange::SpectralImage;
use support::niji_ends_with;
use support::text;

fn printed(arguments: &str) -> String {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    String::from_utf8(niji_ends_with(0, &arguments).stdout).unwrap()
}

/// Rows of a CSV behind its header, as text.
fn rows(csv: &str) -> Vec<Vec<String>> {
    let row = |line: &str| line.split(',').map(str::to_owned).collect();
    csv.lines().skip(1).map(row).collect()
}

fn number(field: &str) -> f64 {
    field.parse().unwrap()
}

#[test]
fn comparing_theories_says_how_wrong_each_is_and_what_it_costs() {
    let csv = printed(
        "scatter --compare mie,geometric,airy,uniform --effective-radius-um 100 \
         --effective-variance 0.02 --theta-deg 134,146 --spectrum 450,100,3 -q",
    );
    let rows = rows(&csv);
    let names: Vec<&str> = rows.iter().map(|row| row[0].as_str()).collect();
    assert_eq!(names, ["geometric", "airy", "uniform", "mie"]);
    let error: Vec<f64> = rows.iter().map(|row| number(&row[1])).collect();
    // The better theory is nearer; the last is the reference.
    assert!(error[0] > 0.2 && error[0] > error[1] && error[1] > error[2] && error[3] == 0.0);
    assert!(error[2] < 0.02, "uniform {}", error[2]);
    assert!(rows.iter().all(|row| number(&row[6]) > 0.0), "seconds");
}

#[test]
fn a_fogbow_is_beyond_airy_and_the_program_says_so() {
    let arguments: Vec<&str> = "scatter --compare airy,mie --effective-radius-um 8 \
         --effective-variance 0.05 --spectrum 450,100,3"
        .split_whitespace()
        .collect();
    let output = niji_ends_with(0, &arguments);
    let messages = String::from_utf8(output.stderr).unwrap();
    assert!(messages.contains("airy: "), "{messages}");
    assert!(messages.contains("seen"), "{messages}");
}

#[test]
fn a_plot_names_its_curves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("curves.svg");
    printed(&format!(
        "scatter --theory uniform --effective-radius-um 50,500 --theta-deg 136,142 \
         --spectrum 450,100,3 --relative-error 0.05 --plot {} -q",
        text(&path)
    ));
    let svg = fs::read_to_string(&path).unwrap();
    assert!(svg.starts_with("<svg"));
    for radius_um in ["50.0", "500.0"] {
        for wavelength_nm in ["450", "550", "650"] {
            let label = format!("{radius_um} µm, {wavelength_nm} nm");
            assert!(svg.contains(&label), "{label}");
        }
    }
}

#[test]
fn an_exported_csv_holds_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("phase.csv");
    printed(&format!(
        "scatter --theory geometric --effective-radius-um 50 --theta-deg 150,160 \
         --spectrum 550,10,1 --sun-disc-deg 0 --orders 2 --export csv -o {} -q",
        text(&path)
    ));
    let csv = fs::read_to_string(&path).unwrap();
    for row in rows(&csv) {
        let evaluated = printed(&format!(
            "eval scatter --theory geometric --order 2 --radius-um 50 --wavelength-nm 550 \
             --angles-deg {}",
            row[0]
        ));
        let i1 = number(&rows(&evaluated)[0][1]);
        // |S1|² = π x² t.
        let x = std::f64::consts::TAU * 50.0 / 0.55;
        let expected = i1 / (std::f64::consts::PI * x * x);
        assert!((number(&row[4]) / expected - 1.0).abs() < 1e-4, "{row:?}");
    }
}

#[test]
fn a_lee_diagram_shows_the_primary_in_all_its_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lee.exr");
    printed(&format!(
        "lee --theory uniform --radius-um 50,1000 --bow-angle-deg 36,54 --size-px 12,91 \
         --orders 2,3 -o {} -q",
        text(&path)
    ));
    assert!(folder.path().join("lee.png").exists());
    let image = SpectralImage::read_spectral(&path).unwrap();
    assert_eq!(image.radiance.dim(), (41, 91, 12));
    for x in 0..12 {
        let brightest = (0..91)
            .max_by(|&a, &b| image.radiance[[18, a, x]].total_cmp(&image.radiance[[18, b, x]]))
            .unwrap();
        // Rows are 0.2 degrees apart from 54 on top.
        let bow_angle_deg = 54.0 - 0.2 * brightest as f64;
        assert!(
            (39.8..42.2).contains(&bow_angle_deg),
            "column {x}: {bow_angle_deg}"
        );
    }
}

#[test]
fn a_law_of_sizes_scatters_as_the_mean_of_its_drops() {
    let of = |theory: &str, variance: &str| {
        let csv = printed(&format!(
            "eval scatter --theory {theory} --order 2 --radius-um 200 --wavelength-nm 550 \
             --effective-variance {variance} --angles-deg 138.5,139,139.5,140,141"
        ));
        rows(&csv)
            .iter()
            .map(|row| number(&row[1]))
            .collect::<Vec<f64>>()
    };
    // Sizes blur the fringes: the uniform theory and the exact order agree better than single drops.
    for (uniform, debye) in of("uniform", "0.05").iter().zip(of("debye", "0.05")) {
        assert!(
            (uniform / debye - 1.0).abs() < 0.01,
            "{uniform} against {debye}"
        );
    }
    let single = of("debye", "0");
    assert!(
        single
            .iter()
            .zip(of("debye", "1e-12"))
            .all(|(a, b)| (a / b - 1.0).abs() < 1e-4)
    );
}

#[test]
fn the_mean_phase_function_has_a_mean_of_one() {
    let angles: Vec<String> = (0..=1800)
        .map(|step| format!("{}", f64::from(step) / 10.0))
        .collect();
    let csv = printed(&format!(
        "eval scatter --theory mie --radius-um 1 --wavelength-nm 550 --effective-variance 0.1 \
         --angles-deg {}",
        angles.join(",")
    ));
    assert!(csv.starts_with("angle_deg,i1,i2,p11,dop\n"));
    // Simpson's rule over the sphere.
    let step = std::f64::consts::PI / 1800.0;
    let mean: f64 = rows(&csv)
        .iter()
        .enumerate()
        .map(|(index, row)| {
            let weight = match index {
                0 | 1800 => 1.0,
                index if index % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * step / 3.0 * 0.5 * (step * index as f64).sin() * number(&row[3])
        })
        .sum();
    assert!((mean - 1.0).abs() < 1e-4, "{mean}");
}

#[test]
fn impossible_drops_and_angles_are_refused() {
    for arguments in [
        "eval scatter --theory mie --x 0 --index 1.33 --angles-deg 0",
        "eval scatter --theory mie --x nan --index 1.33 --angles-deg 0",
        "eval scatter --theory mie --x -5 --index 1.33 --angles-deg 0",
        "eval scatter --theory mie --x 10 --index 1.33-0.1i --angles-deg 0",
        "eval scatter --theory mie --x 10 --index 1.33 --angles-deg 181",
        "eval scatter --theory mie --x 10 --index 1.33 --angles-deg -1",
        "eval scatter --theory mie --radius-um 5 --wavelength-nm 550 --effective-variance 0.5 --efficiencies",
        "scatter --theory airy --effective-radius-um 100 --theta-deg 100,190 -o never.exr",
        "scatter --theory airy --effective-radius-um -100 -o never.exr",
        "scatter --theory airy --effective-radius-um 100 --orders 9 -o never.exr",
        "scatter --compare airy --effective-radius-um 8",
        "lee --radius-um 10,5 -o never.exr",
    ] {
        let list: Vec<&str> = arguments.split_whitespace().collect();
        let output = niji_ends_with(2, &list);
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains("error: "), "{arguments}: {message}");
        assert!(!Path::new("never.exr").exists());
    }
}
