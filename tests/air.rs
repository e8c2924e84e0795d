//! `niji eval air`, `niji eval sun` and `niji atmosphere --sky`: the air against formulas in print and
//! against a quadrature that shares nothing with the program.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use niji_exchange::SpectralImage;
use support::niji_ends_with;
use support::text;
use support::variant;

/// Optical depths against Simpson's rule; the worst is 2.3e-8.
const DEPTH_TOLERANCE: f64 = 1e-7;
/// In-scattering against nested Simpson's rule; the worst is 1.5e-8, with adaptive quadrature to 1e-6.
const IN_SCATTERING_TOLERANCE: f64 = 1e-6;

/// The rows of `niji eval air` by column.
struct Rows {
    header: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Rows {
    fn column(&self, name: &str) -> Vec<f64> {
        let place = self.header.iter().position(|column| column == name);
        let place = place.unwrap_or_else(|| panic!("no column {name} in {:?}", self.header));
        self.rows.iter().map(|row| row[place]).collect()
    }
}

fn eval(quantity: &str, arguments: &str) -> Rows {
    let all: Vec<&str> = ["eval", quantity]
        .into_iter()
        .chain(arguments.split_whitespace())
        .collect();
    let output = String::from_utf8(niji_ends_with(0, &all).stdout).unwrap();
    let mut lines = output.lines();
    let names = lines.next().expect("there is a header").split(',');
    let row = |line: &str| {
        line.split(',')
            .map(|field| field.parse().unwrap())
            .collect()
    };
    Rows {
        header: names.map(str::to_owned).collect(),
        rows: lines.map(row).collect(),
    }
}

fn air(arguments: &str) -> Rows {
    eval("air", arguments)
}

/// One exponential layer over one sphere, by Simpson's rule in the root of the distance.
struct Plain {
    radius_m: f64,
    top_m: f64,
    scale_height_m: f64,
    extinction_m1: f64,
}

impl Plain {
    const N_STEPS: usize = 600;

    fn height_m(&self, [h, mu]: [f64; 2], s: f64) -> f64 {
        let r = self.radius_m + h;
        (r * r + 2.0 * r * mu * s + s * s).sqrt() - self.radius_m
    }

    /// Distance to the top of the air from below.
    fn exit_m(&self, [h, mu]: [f64; 2]) -> f64 {
        let (r, top) = (self.radius_m + h, self.radius_m + self.top_m);
        // Rounding may put a point of the ray a hair above the top.
        (-r * mu + (r * r * (mu * mu - 1.0) + top * top).sqrt()).max(0.0)
    }

    fn density(&self, start: [f64; 2], s: f64) -> f64 {
        (-self.height_m(start, s) / self.scale_height_m).exp()
    }

    fn depth(&self, start: [f64; 2], length_m: f64) -> f64 {
        self.extinction_m1 * simpson(length_m.sqrt(), |t| 2.0 * t * self.density(start, t * t))
    }

    /// Rayleigh light gathered over a rising ray, for a sun of irradiance 1.
    fn gathered(&self, start: [f64; 2], [mu_s, nu]: [f64; 2], length_m: f64) -> f64 {
        let phase = 3.0 / (16.0 * PI) * (1.0 + nu * nu);
        let per_t = |t: f64| {
            let s = t * t;
            let height_m = self.height_m(start, s);
            let to_sun = (self.radius_m + start[0]) * mu_s + s * nu;
            let above = [height_m, to_sun / (self.radius_m + height_m)];
            let tau = self.depth(start, s) + self.depth(above, self.exit_m(above));
            2.0 * t * self.density(start, s) * (-tau).exp()
        };
        phase * self.extinction_m1 * simpson(length_m.sqrt(), per_t)
    }
}

fn simpson(end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = Plain::N_STEPS;
    let step = end / n as f64;
    let inner = (1..n).map(|i| f(step * i as f64) * if i % 2 == 1 { 4.0 } else { 2.0 });
    step / 3.0 * (f(0.0) + inner.sum::<f64>() + f(end))
}

#[test]
fn the_constants_by_flags_agree_with_an_independent_quadrature() {
    let (n, molecules_m3, lambda_m) = (1.00028_f64, 2.6e25, 500e-9_f64);
    let plain = Plain {
        radius_m: 6.4e6,
        top_m: 80e3,
        scale_height_m: 7000.0,
        extinction_m1: 8.0 * PI.powi(3) * (n * n - 1.0).powi(2)
            / (3.0 * molecules_m3 * lambda_m.powi(4)),
    };
    for (height_m, view_deg, azimuth_deg, distance_m, sun_deg) in [
        (0.0, 0.0, 0.0, f64::INFINITY, 30.0),
        (0.0, 89.0, 180.0, f64::INFINITY, 80.0),
        (1500.0, 60.0, 75.0, 20e3, 85.0),
        (10.0, 90.0, 138.0, 1e3, 70.0),
    ] {
        let found = air(&format!(
            "--rayleigh nishita --refractive-index {n} --molecules-m3 {molecules_m3} \
             --rayleigh-scale-height-m 7000 --planet-radius-m 6.4e6 --top-height-m 8e4 \
             --wavelengths-nm 500 --height-m {height_m} --view-zenith-deg {view_deg} \
             --azimuth-deg {azimuth_deg} --distance-m {distance_m} --sun-zenith-deg {sun_deg}"
        ));
        let sines = |deg: f64| f64::to_radians(90.0 - deg).sin_cos();
        let ((mu, view), (mu_s, sun)) = (sines(view_deg), sines(sun_deg));
        let nu = mu * mu_s + view * sun * f64::to_radians(azimuth_deg).cos();
        let start = [height_m, mu];
        let length_m = plain.exit_m(start).min(distance_m);
        let depth = plain.depth(start, length_m);
        let radiance = plain.gathered(start, [mu_s, nu], length_m);
        let ratio = found.column("optical_depth")[0] / depth;
        assert!((ratio - 1.0).abs() < DEPTH_TOLERANCE, "{view_deg}: {ratio}");
        let ratio = found.column("transmittance")[0] / (-depth).exp();
        assert!((ratio - 1.0).abs() < DEPTH_TOLERANCE, "{view_deg}: {ratio}");
        let ratio = found.column("in_scattering")[0] / radiance;
        let error = (ratio - 1.0).abs();
        assert!(error < IN_SCATTERING_TOLERANCE, "{view_deg}: {ratio}");
        let to_sun = plain.depth([height_m, mu_s], plain.exit_m([height_m, mu_s]));
        let ratio = found.column("sun_optical_depth")[0] / to_sun;
        assert!((ratio - 1.0).abs() < DEPTH_TOLERANCE, "{sun_deg}: {ratio}");
    }
}

#[test]
fn all_methods_agree_on_a_sky_ray() {
    let with = |method: &str| {
        let ray = "--rayleigh nishita --wavelengths-nm 450 --view-zenith-deg 70 \
                   --sun-zenith-deg 75 --azimuth-deg 90 --method";
        air(&format!("{ray} {method}")).column("in_scattering")[0]
    };
    let exact = with("nested --samples 64 --sun-samples 64");
    for (method, tolerance) in [
        ("adaptive", 2e-5),
        ("quadrature", 2e-5),
        ("nested", 1e-6),
        ("midpoint --samples 400", 1e-3),
    ] {
        let ratio = with(method) / exact;
        assert!((ratio - 1.0).abs() < tolerance, "{method}: {ratio}");
    }
}

#[test]
fn the_low_sun_is_dimmed_and_reddened_as_published() {
    // Direct beam at sea level, papers' constants, exact sphere, at 450, 550 and 650 nm.
    let published = [
        (30.0, [0.635, 0.816, 0.901]),
        (10.0, [0.282, 0.567, 0.748]),
        (5.0, [0.099, 0.355, 0.588]),
        (2.0, [0.014, 0.148, 0.376]),
        (0.0, [0.0003, 0.027, 0.157]),
    ];
    for (elevation_deg, expected) in published {
        let found = air(&format!(
            "--rayleigh nishita --wavelengths-nm 450,550,650 --view-zenith-deg 0 \
             --sun-zenith-deg {}",
            90.0 - elevation_deg
        ));
        for (found, expected) in found.column("sun_transmittance").iter().zip(expected) {
            assert!((found - expected).abs() < 6e-4, "{elevation_deg}: {found}");
        }
    }
}

#[test]
fn vertical_optical_depths_are_the_published_ones() {
    let depths = |flags: &str| {
        let rays = "--view-zenith-deg 0 --sun-zenith-deg 0";
        air(&format!("{flags} {rays}")).column("optical_depth")
    };
    let nishita = depths("--rayleigh nishita --wavelengths-nm 450,550,650");
    for (found, expected) in nishita.iter().zip([0.2281, 0.1022, 0.0524]) {
        assert!((found - expected).abs() < 6e-5, "{found}");
    }
    // Bodhaine et al. (1999), eq. 30; 9e-6 of the column lie above the top of the air.
    let nm: Vec<f64> = (0..=30).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    let list: Vec<String> = nm.iter().map(f64::to_string).collect();
    let found = depths(&format!("--wavelengths-nm {}", list.join(",")));
    for (nm, found) in nm.iter().zip(found) {
        let l2 = (1e-3 * nm).powi(2);
        let fit = 0.0021520 * (1.0455996 - 341.29061 / l2 - 0.90230850 * l2)
            / (1.0 + 0.0027059889 / l2 - 85.968563 * l2);
        assert!((found / fit - 1.0).abs() < 1.1e-4, "{nm}: {}", found / fit);
    }
}

#[test]
fn constituents_add_up_and_leave_each_other_alone() {
    let parts = ["rayleigh", "ozone", "aerosol", "water-vapor", "oxygen"];
    let rays = "--wavelengths-nm 450,593,720,762 --view-zenith-deg 80 --sun-zenith-deg 75 \
                --distance-m 40000,inf";
    let of = |parts: &str| air(&format!("--constituents {parts} {rays}"));
    let all = of(&parts.join(","));
    for column in ["optical_depth", "sun_optical_depth"] {
        let mut sum = vec![0.0; all.rows.len()];
        for part in parts {
            for (sum, depth) in sum.iter_mut().zip(of(part).column(column)) {
                *sum += depth;
            }
        }
        for (sum, found) in sum.iter().zip(all.column(column)) {
            assert!(
                (sum / found - 1.0).abs() < 1e-12,
                "{column}: {sum}, {found}"
            );
        }
    }
    // Gases without lines at 450 nm change nothing there, to the last digit.
    let with = of("rayleigh,aerosol,water-vapor,oxygen");
    assert_eq!(with.rows[0], of("rayleigh,aerosol").rows[0]);
    for gas in ["ozone", "water-vapor", "oxygen"] {
        assert!(of(gas).column("in_scattering").iter().all(|&l| l == 0.0));
    }
}

#[test]
fn the_beam_through_vapor_and_oxygen_obeys_the_law_of_the_band() {
    // Bird and Riordan (1986), eqs. 8 and 11, for the length of the sun's path through each gas.
    for (gas, nm, coefficient, [strength, width], amount) in [
        ("water-vapor", 724.4, 2.5, [0.2385, 20.07], 2.0),
        ("oxygen", 762.5, 4.0, [1.41, 118.3], 1.0),
    ] {
        for sun_deg in [0.0, 60.0, 85.0] {
            let water = if gas == "oxygen" {
                ""
            } else {
                "--precipitable-water-cm 2"
            };
            let rows = air(&format!(
                "--constituents {gas} {water} --wavelengths-nm {nm} --bin-nm 0.001 \
                 --view-zenith-deg 0 --sun-zenith-deg {sun_deg}"
            ));
            // On the chord of one path, depths are in proportion to lengths.
            let mass = rows.column("sun_optical_depth")[0] / rows.column("optical_depth")[0];
            let x: f64 = coefficient * amount * mass;
            let law = (-strength * x / (1.0 + width * x).powf(0.45)).exp();
            let found = rows.column("sun_transmittance")[0];
            assert!(
                (found - law).abs() < 2e-4,
                "{gas} {sun_deg}: {found}, {law}"
            );
        }
    }
}

#[test]
fn rays_from_a_file_are_the_rays_of_the_flags() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("rays.csv");
    let rows = "# two rays\nsun_zenith_deg,height_m,view_zenith_deg,azimuth_deg,distance_m,note\n\
                60,2,45,90,inf,sky\n60,2,120,90,inf,ground\n";
    fs::write(&path, rows).unwrap();
    let from_file = air(&format!(
        "--rays-file {} --wavelengths-nm 550 --ground-albedo 0.3",
        text(&path)
    ));
    let from_flags = air(
        "--height-m 2 --view-zenith-deg 45,120 --azimuth-deg 90 --sun-zenith-deg 60 \
         --wavelengths-nm 550 --ground-albedo 0.3",
    );
    assert_eq!(from_file.rows, from_flags.rows);
    let (veil, all) = (
        from_file.column("in_scattering"),
        from_file.column("radiance"),
    );
    assert_eq!(veil[0], all[0], "the sky has no ground");
    // 0.3/pi times the cosine of 60 degrees times the beam through 0.2 of optical depth.
    assert!(
        (all[1] - veil[1] - 0.3 / PI * 0.5 * 0.82).abs() < 2e-3,
        "{}",
        all[1]
    );

    fs::write(&path, "height_m,view_zenith_deg\n0,0\n").unwrap();
    niji_ends_with(3, &["eval", "air", "--rays-file", text(&path)]);
    fs::write(&path, rows.replace("60,2,45", "60,2,200")).unwrap();
    niji_ends_with(3, &["eval", "air", "--rays-file", text(&path)]);
}

#[test]
fn constants_of_absent_constituents_are_refused() {
    let rays = ["--view-zenith-deg", "0", "--sun-zenith-deg", "60"];
    for flags in [
        &["--ozone-dobson", "300"][..],
        &["--refractive-index", "1.0003"],
        &["--rayleigh", "nishita", "--pressure-hpa", "900"],
        &["--precipitable-water-cm", "1"],
        &["--king-factor", "0.9"],
        &["--method", "adaptive", "--samples", "4"],
        &["--wavelengths-nm", "200"],
        &["--constituents", "aerosol", "--visibility-km", "1000"],
        &["--scene", "scene.toml", "--ground-albedo", "0.2"],
    ] {
        niji_ends_with(2, &[&["eval", "air"], flags, &rays[..]].concat());
    }
}

#[test]
fn the_air_of_a_scene_is_evaluated_at_its_wavelengths() {
    let folder = tempfile::tempdir().unwrap();
    let scene = variant(
        "rain-cell-8-km.toml",
        folder.path(),
        &[(
            "air.constituents",
            "[\"rayleigh\", \"ozone\", \"water-vapor\"]",
        )],
    );
    let rays = "--view-zenith-deg 30 --sun-zenith-deg 60";
    let by_scene = air(&format!("--scene {} {rays}", text(&scene)));
    let by_flags = air(&format!(
        "--constituents rayleigh,ozone,water-vapor --ground-albedo 0.2 {rays}"
    ));
    assert_eq!(by_scene.rows.len(), 41);
    // The length of the ray is infinite.
    let finite = |row: &[f64]| row.iter().copied().filter(|x| x.is_finite()).collect();
    for (scene, flags) in by_scene.rows.iter().zip(&by_flags.rows) {
        let [scene, flags]: [Vec<f64>; 2] = [finite(scene), finite(flags)];
        for (scene, flags) in scene.iter().zip(&flags) {
            assert!(
                (scene - flags).abs() <= 1e-12 * flags.abs(),
                "{scene}, {flags}"
            );
        }
    }
}

#[test]
fn the_sun_stands_where_almanacs_have_it() {
    // Reda and Andreas (2003), their example: zenith 50.11, azimuth 194.34 degrees.
    let found = eval(
        "sun",
        "--date 2003-10-17T12:30:30 --utc-offset-h -7 --latitude-deg 39.742476 \
         --longitude-deg -105.1786",
    );
    assert!((found.column("elevation_deg")[0] - 39.888).abs() < 0.01);
    assert!((found.column("azimuth_deg")[0] - 194.340).abs() < 0.002);
    // Noon of an equinox at the equator: the sun in the zenith, half a degree at most beside it.
    let equinox = eval(
        "sun",
        "--date 2026-03-20T12:07:00 --latitude-deg 0 --longitude-deg 0",
    );
    assert!(equinox.column("elevation_deg")[0] > 89.5);
}

#[test]
fn a_scene_by_date_time_and_place_has_the_sun_of_the_almanac() {
    let folder = tempfile::tempdir().unwrap();
    let cell = fs::read_to_string(support::repository("data/scenes/rain-cell-8-km.toml")).unwrap();
    let start = cell.find("[sun]").unwrap();
    let end = start + cell[start..].find("\n[").unwrap();
    let with_sun = |sun: &str| {
        let path = folder.path().join("scene.toml");
        fs::write(
            &path,
            format!("{}[sun]\n{sun}{}", &cell[..start], &cell[end..]),
        )
        .unwrap();
        path
    };
    // Reda and Andreas (2003), their example: zenith 50.11, azimuth 194.34 degrees.
    let place = "latitude_deg = 39.742476\nlongitude_deg = -105.1786\n";
    for date_time in ["2003-10-17T12:30:30-07:00", "2003-10-17T19:30:30Z"] {
        let path = with_sun(&format!("date_time = \"{date_time}\"\n{place}"));
        let output = niji_ends_with(0, &["plan", text(&path)]).stdout;
        let plan = String::from_utf8(output).unwrap();
        assert!(
            plan.contains("\nsun 39.89 degrees high, azimuth 194.34\n"),
            "{plan}"
        );
        let output = niji_ends_with(0, &["plan", text(&path), "--json"]).stdout;
        let plan: serde_json::Value = serde_json::from_slice(&output).unwrap();
        let elevation_deg = plan["sun"]["elevation_deg"].as_f64().unwrap();
        assert!((elevation_deg - 39.888).abs() < 0.01, "{elevation_deg}");
    }
    let zoneless = with_sun(&format!("date_time = \"2003-10-17T12:30:30\"\n{place}"));
    let refused = niji_ends_with(3, &["plan", text(&zoneless)]).stderr;
    let refused = String::from_utf8(refused).unwrap();
    assert!(refused.contains("without a time zone"), "{refused}");
}

/// A panorama of a clear sky under a sun in the south, and its planes.
fn sky(folder: &Path, sun_deg: f64, more: &[&str]) -> SpectralImage {
    let elevation = format!("{sun_deg:.1}");
    let scene = variant(
        "rain-cell-8-km.toml",
        folder,
        &[
            ("sun.elevation_deg", elevation.as_str()),
            ("air.constituents", "[\"rayleigh\", \"ozone\"]"),
        ],
    );
    let to = folder.join(format!("sky-{}.exr", more.len()));
    let common = ["atmosphere", "--scene", text(&scene), "--sky", text(&to)];
    niji_ends_with(
        0,
        &[&common[..], &["--width-px", "64", "--force"], more].concat(),
    );
    assert!(to.with_extension("png").is_file());
    SpectralImage::read_spectral(&to).unwrap()
}

#[test]
fn clear_skies_from_twilight_to_noon_are_finite_blue_and_symmetric() {
    let folder = tempfile::tempdir().unwrap();
    let mut before = 0.0;
    for sun_deg in [-4.0, 0.0, 5.0, 20.0, 60.0] {
        let image = sky(folder.path(), sun_deg, &[]);
        let (planes, height, width) = image.radiance.dim();
        assert_eq!((planes, height, width), (41, 32, 64));
        assert!(image.radiance.iter().all(|l| l.is_finite() && *l >= 0.0));
        let zenith = |plane: usize| f64::from(image.radiance[[plane, 0, 0]]);
        // 450, 550 and 650 nm.
        let [blue, green, red] = [7, 17, 27].map(zenith);
        assert!(green > before, "sun {sun_deg}: {green}");
        before = green;
        if sun_deg >= 20.0 {
            assert!(
                blue > 1.3 * green && green > 1.3 * red,
                "{blue} {green} {red}"
            );
        }
        // The sun stands in the south: east and west are mirrored.
        for row in 0..height {
            let [east, west] = [40, 23].map(|column| image.radiance[[17, row, column]]);
            assert!(
                (east - west).abs() <= 1e-5 * east,
                "{sun_deg}, {row}: {east}, {west}"
            );
        }
        // Where the sun has set, in the south, at the edges of the picture, the horizon glows.
        if sun_deg <= 0.0 {
            let row = height / 2 - 1;
            let [south, north] = [0, width / 2].map(|c| image.radiance[[27, row, c]]);
            assert!(south > 1.5 * north, "sun {sun_deg}: {south}, {north}");
        }
    }
}

#[test]
fn a_panorama_of_another_sun_is_that_of_a_scene_with_that_sun() {
    let folder = tempfile::tempdir().unwrap();
    let of_scene = sky(folder.path(), -4.0, &[]).radiance;
    let of_flag = sky(folder.path(), 60.0, &["--sun-elevation-deg", "-4"]).radiance;
    assert_eq!(of_scene, of_flag);
    let scene = support::repository("data/scenes/clear-sky.toml");
    let to = folder.path().join("clear.exr");
    let common = ["atmosphere", "--scene", text(&scene), "--sky", text(&to)];
    for wrong in ["--sun-elevation-deg=91", "--sun-elevation-deg=nan"] {
        niji_ends_with(2, &[&common[..], &[wrong]].concat());
    }
    niji_ends_with(0, &[&common[..], &["--width-px", "32"]].concat());
}

#[test]
fn a_panorama_does_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    sky(folder.path(), 5.0, &["--threads", "1"]);
    let one = fs::read(folder.path().join("sky-2.exr")).unwrap();
    sky(folder.path(), 5.0, &["--threads", "3"]);
    let three = fs::read(folder.path().join("sky-2.exr")).unwrap();
    assert_eq!(one, three);
}

#[test]
fn a_sky_needs_air_and_an_even_width() {
    let folder = tempfile::tempdir().unwrap();
    let to = folder.path().join("sky.exr");
    let cell = support::repository("data/scenes/rain-cell-8-km.toml");
    let refused = |scene: &Path, width: &str| {
        let common = ["atmosphere", "--scene", text(scene), "--sky", text(&to)];
        niji_ends_with(2, &[&common[..], &["--width-px", width]].concat());
        assert!(!to.exists());
    };
    refused(&cell, "63");
    refused(&cell, "0");
    let vacuum = folder.path().join("vacuum.toml");
    let air = "[air]\nconstituents = [\"rayleigh\"]\n";
    let with_air = fs::read_to_string(&cell).unwrap();
    assert!(with_air.contains(air));
    fs::write(&vacuum, with_air.replace(air, "")).unwrap();
    refused(&vacuum, "64");
}
