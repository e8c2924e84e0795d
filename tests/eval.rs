//! `niji eval` and `niji info`: values that scripts rely on.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use support::niji_ends_with;
use support::text;

/// The rows of a CSV behind its header.
fn table(arguments: &[&str]) -> (String, Vec<Vec<f64>>) {
    let output = String::from_utf8(niji_ends_with(0, arguments).stdout).unwrap();
    let mut lines = output.lines();
    let header = lines.next().expect("there is a header").to_owned();
    let row = |line: &str| {
        line.split(',')
            .map(|field| field.parse().unwrap())
            .collect()
    };
    (header, lines.map(row).collect())
}

#[test]
fn airys_integral_is_printed_in_full_precision() {
    let (header, rows) = table(&["eval", "airy", "--z=-30,0,1.5,1000"]);
    assert_eq!(header, "z,f,dfdz");
    // mpmath, 40 digits.
    for (row, f) in rows
        .iter()
        .zip([1.6415483158550334e-44, 0.6652713699882223])
    {
        assert!((row[1] / f - 1.0).abs() < 1e-12);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("z.txt");
    std::fs::write(&path, "-30, 0\n1.5\t1000\n").unwrap();
    assert_eq!(table(&["eval", "airy", "--z-file", text(&path)]).1, rows);
}

#[test]
fn mie_efficiencies_and_amplitudes_are_the_published_ones() {
    let sphere = [
        "eval", "scatter", "--theory", "mie", "--x", "1000", "--index", "1.333+0i",
    ];
    let (header, rows) = table(&[&sphere[..], &["--efficiencies"]].concat());
    assert_eq!(header, "q_ext,q_sca,g");
    // 40 digits; a downward recurrence started 16 terms above |mx| gives 2.0197.
    assert!((rows[0][0] - 2.0228114332201634).abs() < 1e-11);
    let (header, rows) = table(&[&sphere[..], &["--angles-deg", "0,180"]].concat());
    assert_eq!(header, "angle_deg,s1_re,s1_im,s2_re,s2_im,p11,dop");
    assert!(
        (4.0 * rows[0][1] / 1e6 - 2.0228114332201634).abs() < 1e-9,
        "optical theorem"
    );
    assert!(
        (rows[1][1] + rows[1][3]).abs() < 1e-6 * rows[1][1].abs(),
        "S1 = -S2 backwards"
    );
}

#[test]
fn orders_agree_between_theories_near_the_bow() {
    let drop = [
        "--radius-um",
        "500",
        "--wavelength-nm",
        "650",
        "--order",
        "2",
    ];
    let angles = ["--angles-deg", "137.95,138.0,138.05"];
    let of = |theory| {
        let (header, rows) =
            table(&[&["eval", "scatter", "--theory", theory][..], &drop, &angles].concat());
        assert_eq!(header, "angle_deg,i1,i2");
        rows.iter().map(|row| row[1]).sum::<f64>()
    };
    let ratio = of("airy") / of("debye");
    assert!((ratio - 1.0).abs() < 0.05, "Airy over Debye {ratio}");
}

#[test]
fn what_a_theory_does_not_know_is_refused() {
    let refused = |line: &str| {
        let output = niji_ends_with(2, &line.split(' ').collect::<Vec<_>>());
        String::from_utf8(output.stderr).unwrap()
    };
    let absorbing = "--order 2 --x 500 --index 1.333+0.01i --angles-deg 140";
    for theory in ["airy", "uniform", "geometric"] {
        let said = refused(&format!("eval scatter --theory {theory} {absorbing}"));
        assert!(
            said.contains("k = 0.01") && said.contains("debye"),
            "{said}"
        );
    }
    for theory in ["debye", "airy"] {
        let of_all = "--order 2 --x 100 --index 1.333 --efficiencies";
        let said = refused(&format!("eval scatter --theory {theory} {of_all}"));
        assert!(said.contains("--theory mie"), "{said}");
    }
}

#[test]
fn marshall_palmer_rain_amounts_to_the_closed_forms() {
    let law = [
        "eval",
        "sizes",
        "--law",
        "marshall-palmer",
        "--rain-rate-mm-h",
        "5",
    ];
    let (header, rows) = table(&law);
    assert_eq!(
        header,
        "number_density_m3,lwc_g_m3,extinction_m1,effective_radius_m,effective_variance"
    );
    // N0/Lambda, pi rho N0/Lambda^4, pi N0/Lambda^3, 3/(2 Lambda), 1/3.
    for (found, expected) in rows[0]
        .iter()
        .zip([2736.0, 0.344, 1.005e-3, 0.513e-3, 1.0 / 3.0])
    {
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} against {expected}"
        );
    }
    let (_, cut) = table(&[&law[..], &["--d-min-mm", "0.1", "--d-max-mm", "6"]].concat());
    for (found, expected) in [
        (cut[0][0], 2042.0),
        (cut[0][2], 1.0018e-3),
        (cut[0][4], 0.3294),
    ] {
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "{found} against {expected}"
        );
    }
}

#[test]
fn indices_are_those_of_iapws_in_air() {
    let (header, rows) = table(&[
        "eval",
        "index",
        "--material",
        "water",
        "--wavelengths-nm",
        "400,550,700",
    ]);
    assert_eq!(header, "wavelength_nm,n,k");
    // IAPWS R9-97 at 20 C in vacuum 1.343557, 1.334680, 1.330517, over n of air.
    for (row, vacuum) in rows.iter().zip([1.343557, 1.334680, 1.330517]) {
        assert!((row[1] - vacuum / 1.000277).abs() < 1e-5, "{}", row[1]);
    }
    let (_, ice) = table(&[
        "eval",
        "index",
        "--material",
        "ice",
        "--wavelengths-nm",
        "400",
    ]);
    assert!(
        (ice[0][2] / 2.365e-11 - 1.0).abs() < 1e-3,
        "the table of 2008, not of 1984"
    );
}

#[test]
fn info_describes_and_asserts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drops.vdb");
    let arguments = [
        "drops",
        "uniform",
        "--box-min-m=-8,0,-8",
        "--box-max-m",
        "8,16,8",
        "--voxel-m",
        "1",
        "--law",
        "monodisperse",
        "--radius-um",
        "100",
        "--number-density-m3",
        "1000",
        "-o",
        text(&path),
    ];
    let printed = niji_ends_with(0, &arguments);
    let printed = String::from_utf8(printed.stderr).unwrap();
    assert!(
        printed.contains("liquid water") && printed.contains("optical depth"),
        "{printed}"
    );
    let json = niji_ends_with(0, &["info", text(&path), "--json"]).stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    let names: Vec<&str> = json["grids"]
        .as_array()
        .unwrap()
        .iter()
        .map(|grid| grid["name"].as_str().unwrap())
        .collect();
    assert!(
        names.contains(&"number_density") && names.contains(&"effective_radius"),
        "{names:?}"
    );
    niji_ends_with(
        0,
        &[
            "info",
            text(&path),
            "-q",
            "--assert",
            "max(effective_radius) < 2e-4",
        ],
    );
    niji_ends_with(
        6,
        &[
            "info",
            text(&path),
            "-q",
            "--assert",
            "max(effective_radius) < 5e-5",
        ],
    );
    niji_ends_with(
        3,
        &["info", text(&path), "-q", "--assert", "max(nothing) < 1"],
    );
    let preview = folder.path().join("drops.png");
    niji_ends_with(0, &["info", text(&path), "-q", "--preview", text(&preview)]);
    let png = std::fs::read(&preview).unwrap();
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    // Width and height: six views side by side, a row for each of the grids.
    let edge = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert!(edge(16) > 6 * 300 && edge(20) > names.len() as u32 * 300);
    niji_ends_with(2, &["info", text(&path), "-q", "--preview", text(&preview)]);
}
