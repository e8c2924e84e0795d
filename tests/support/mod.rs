//! What the end-to-end tests share: running the program, shrinking scenes, measuring bows.

#![allow(
    dead_code,
    unreachable_pub,
    reason = "each test target uses its own part"
)]

use std::fs;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;
use std::process::Output;

use ndarray::Array2;
use ndarray::Axis;
use niji_exchange::SpectralImage;
use niji_geometry::Camera;
use niji_scene::Scene;

/// A picture of a tenth of a second.
pub const TINY: &str = r#"
format = 1
name = "tiny"
[sun]
elevation_deg = 20.0
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 10.0
horizontal_fov_deg = 90.0
width_px = 16
height_px = 12
[spectrum]
first_nm = 450.0
step_nm = 100.0
n_wavelengths = 3
[drops]
shape = "uniform"
box_min_m = [-600.0, 0.0, -1200.0]
box_max_m = [600.0, 1000.0, -300.0]
number_density_m3 = 300.0
law = { monodisperse = { radius_um = 500.0 } }
voxel_m = 100.0
[effects]
sky = "off"
air_inscatter = "off"
air_extinction = "off"
sunlight_through_air = "off"
drop_flattening = "off"
[accuracy]
preset = "draft"
"#;

/// Runs the program and returns what it printed.
pub fn niji(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_niji"))
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// Runs the program and panics with its messages unless it ends with `code`.
pub fn niji_ends_with(code: i32, arguments: &[&str]) -> Output {
    let output = niji(arguments);
    assert_eq!(
        output.status.code(),
        Some(code),
        "niji {}\n{}{}",
        arguments.join(" "),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
    output
}

/// A path inside the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Writes a copy of a shipped scene with other values: `("camera.width_px", "160")`.
pub fn variant(name: &str, folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let text = fs::read_to_string(repository("data/scenes").join(name)).expect("the scene ships");
    let mut scene: toml::Table = text.parse().expect("shipped scenes are TOML");
    for (path, value) in changes {
        let document: toml::Table = format!("v = {value}").parse().expect("the value is TOML");
        let mut table = &mut scene;
        let mut keys: Vec<&str> = path.split('.').collect();
        let last = keys.pop().expect("the path is not empty");
        for key in keys {
            let entry = table
                .entry(key)
                .or_insert_with(|| toml::Table::new().into());
            table = entry
                .as_table_mut()
                .expect("the path leads through sections");
        }
        table.insert(last.to_owned(), document["v"].clone());
    }
    let path = folder.join(name);
    fs::write(&path, scene.to_string()).expect("the folder can be written");
    path
}

/// `path` as text for the command line.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("temporary folders have UTF-8 names")
}

/// Radiance at one wavelength against the bow angle: the mean of all pixels in each step.
pub struct Profile {
    /// Width of a step in degrees.
    pub step_deg: f64,
    /// Mean radiance; NaN where no pixel lies.
    pub values: Vec<f64>,
}

impl Profile {
    /// Bow angle in the middle of a step.
    pub fn angle_deg(&self, index: usize) -> f64 {
        (index as f64 + 0.5) * self.step_deg
    }

    /// Mean over a range of bow angles.
    pub fn mean(&self, from_deg: f64, to_deg: f64) -> f64 {
        let inside: Vec<f64> = (0..self.values.len())
            .filter(|&index| (from_deg..to_deg).contains(&self.angle_deg(index)))
            .map(|index| self.values[index])
            .filter(|value| value.is_finite())
            .collect();
        inside.iter().sum::<f64>() / inside.len() as f64
    }

    /// Angle of the largest value within a range, refined by the parabola through three points.
    pub fn peak_deg(&self, from_deg: f64, to_deg: f64) -> f64 {
        let inside = |index: &usize| (from_deg..to_deg).contains(&self.angle_deg(*index));
        let best = (1..self.values.len() - 1)
            .filter(inside)
            .filter(|&index| self.values[index].is_finite())
            .max_by(|&a, &b| self.values[a].total_cmp(&self.values[b]))
            .expect("the range holds pixels");
        let [left, mid, right] = [best - 1, best, best + 1].map(|index| self.values[index]);
        let curvature = left - 2.0 * mid + right;
        let shift = if curvature < 0.0 {
            0.5 * (left - right) / curvature
        } else {
            0.0
        };
        self.angle_deg(best) + shift * self.step_deg
    }

    /// Local maxima within a range that stand above both neighbors two steps away.
    pub fn maxima_deg(&self, from_deg: f64, to_deg: f64) -> Vec<f64> {
        (2..self.values.len() - 2)
            .filter(|&index| (from_deg..to_deg).contains(&self.angle_deg(index)))
            .filter(|&index| {
                let here = self.values[index];
                here > self.values[index - 1]
                    && here >= self.values[index + 1]
                    && here > 1.002 * self.values[index - 2]
                    && here > 1.002 * self.values[index + 2]
            })
            .map(|index| self.angle_deg(index))
            .collect()
    }
}

/// The profile of the spectral image around the antisolar point, over the pixels that `keep` (by
/// column and row) lets through.
pub fn profile(
    image: &SpectralImage,
    scene: &Scene,
    wavelength_nm: f64,
    keep: impl Fn(usize, usize) -> bool,
) -> Profile {
    let wavelength = (0..image.wavelengths.len())
        .find(|&index| (image.wavelengths.center(index).0 - wavelength_nm).abs() < 1e-6)
        .expect("the wavelength is in the grid");
    let radiance = image.radiance.index_axis(Axis(0), wavelength);
    profile_of(&radiance.mapv(f64::from), scene, keep)
}

/// The same of any picture by row and column.
pub fn profile_of(
    picture: &Array2<f64>,
    scene: &Scene,
    keep: impl Fn(usize, usize) -> bool,
) -> Profile {
    let camera: Camera = scene.camera.camera().expect("shipped scenes have a camera");
    let antisolar = -scene.sun.direction();
    let step_deg = 0.1;
    let mut sum = vec![0.0; 900];
    let mut count = vec![0.0; 900];
    for ((y, x), value) in picture.indexed_iter() {
        if !keep(x, y) {
            continue;
        }
        let Some(ray) = camera.ray(x as f64 + 0.5, y as f64 + 0.5) else {
            continue;
        };
        let angle_deg = ray.direction.angle_between(antisolar).to_degrees();
        let index = (angle_deg / step_deg) as usize;
        if index < sum.len() {
            sum[index] += value;
            count[index] += 1.0;
        }
    }
    let values = sum
        .iter()
        .zip(&count)
        .map(|(sum, count)| sum / count)
        .collect();
    Profile { step_deg, values }
}

/// Runs a scene into `folder` and reads the spectral image back.
pub fn run_scene(scene: &Path, folder: &Path) -> (Scene, SpectralImage) {
    niji_ends_with(0, &["run", text(scene), "-o", text(folder), "-q"]);
    let scene_text = fs::read_to_string(scene).expect("the scene was written");
    let scene = Scene::from_toml(&scene_text).expect("the scene is sound");
    let image = SpectralImage::read_spectral(&folder.join("image.exr")).expect("the image reads");
    (scene, image)
}
