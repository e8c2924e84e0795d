//! What `niji photo` makes of a photograph whose sky is known.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each target uses its own part, and may panic"
)]

use std::path::Path;

use niji_exchange::SpectralImage;
use niji_geometry::Camera;
use niji_photo::Photograph;
use niji_scene::Scene;

use crate::pavilion::Changed;
use crate::pavilion::changed;
use crate::support::niji_ends_with;
use crate::support::repository;
use crate::support::text;

/// Runs `niji photo` on a photograph and tells what it said.
pub fn photo(code: i32, photograph: &Path, out: &Path, flags: &[&str]) -> String {
    let fixed = [
        "photo",
        text(photograph),
        "-o",
        text(out),
        "--accuracy",
        "draft",
    ];
    let output = niji_ends_with(code, &[&fixed[..], flags].concat());
    String::from_utf8(output.stderr).unwrap()
}

/// Angle between a point of the photograph and the brightest of the rendered bow straight above or below it.
pub fn off_deg(out: &Path, [x, y]: [f64; 2]) -> f64 {
    let scene = std::fs::read_to_string(out.join("photo.toml")).unwrap();
    let camera: Camera = Scene::from_toml(&scene).unwrap().camera.camera().unwrap();
    let image = SpectralImage::read_spectral(&out.join("image.exr")).unwrap();
    let bow = image
        .aovs
        .iter()
        .find(|aov| aov.name == "bow_primary")
        .unwrap();
    let luminance = &bow.channels[1].1;
    let column = luminance.column(x as usize);
    let brightest = column
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.total_cmp(b.1))
        .unwrap();
    assert!(*brightest.1 > 0.0, "there is a bow");
    let view = |y: f64| camera.ray(x, y).unwrap().direction;
    let off = view(brightest.0 as f64 + 0.5).angle_between(view(y));
    off.to_degrees()
}

/// Pixels of a kind, and those of them where a composite is another than the photograph.
#[derive(Clone, Copy, Debug, Default)]
pub struct Painted {
    pub n_painted: usize,
    pub n: usize,
}

impl Painted {
    pub fn part(self) -> f64 {
        self.n_painted as f64 / self.n as f64
    }
}

/// What is painted of the foreground beyond the soft edge of two pixels, and of the sky.
pub fn painted(
    photograph: &Photograph,
    out: &Path,
    is_sky: impl Fn(usize, usize) -> bool,
) -> [Painted; 2] {
    let composite = Photograph::read(&out.join("composite.png")).unwrap();
    let (height, width) = photograph.light.dim();
    let mut kinds = [Painted::default(); 2];
    for y in 2..height - 2 {
        for x in 2..width - 2 {
            let near = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| (y, x)));
            let n_sky = near.filter(|(y, x)| is_sky(*y, *x)).count();
            let kind = match n_sky {
                0 => &mut kinds[0],
                25 => &mut kinds[1],
                _ => continue,
            };
            let is_painted = composite.light[[y, x]] != photograph.light[[y, x]];
            kind.n_painted += usize::from(is_painted);
            kind.n += 1;
        }
    }
    kinds
}

/// The shipped photograph cropped, turned and darkened; what lies before `n_layers` of its layers is no sky: 1, the sky
/// itself, 25, far shore and lake too, which go over into it without an edge.
pub fn pavilion_changed(n_layers: u8) -> [Changed; 3] {
    let photograph = Photograph::read(&repository("data/photos/pavilion.jpg")).unwrap();
    let labels = niji_photo::read_labels(&repository("data/photos/pavilion.labels.png"), 29);
    let is_sky = |label| f32::from(u8::from(label < n_layers));
    changed(&photograph.light, &labels.unwrap().mapv(is_sky))
}
