//! A film: a plume that grows from nothing, a sun that rises and a camera that moves, each frame beside the same frame
//! at a smaller tolerance with every effect on that may be left out.
//!
//! It is exposed so that its mean is two thirds of display white. A tolerance is over white: unexposed, a tenth of white,
//! light that drops scatter more than once is left out by the usual one, and means are up to 0.65 % off.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each test target uses its own part, and a test may panic"
)]

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use ndarray::Array2;
use niji_exchange::SpectralImage;
use niji_exchange::luminance;
use niji_picture::SequenceChoice;

use crate::plume::Plume;
use crate::support::niji_ends_with;
use crate::support::text;

/// A film to be made.
pub struct Film<'a> {
    /// What its volumes hold: a density with one size of drops, or drops of sizes that change.
    pub volumes: Volumes,
    /// Where it is made.
    pub folder: &'a Path,
    /// Its frames, from 1 on.
    pub n_frames: u32,
    /// Pixels of a frame.
    pub size_px: [usize; 2],
    /// Tolerance of the references.
    pub finest: f64,
}

/// What the volumes of a film hold.
#[derive(Clone, Copy, Debug)]
pub enum Volumes {
    Density,
    Drops,
}

/// A frame beside its reference, in parts of that but for the last.
#[derive(Clone, Copy, Debug)]
pub struct Beside {
    pub frame: u32,
    /// Mean luminance of the reference (cd/m2).
    pub mean_cd_m2: f64,
    /// How far the mean luminance is off.
    pub off: f64,
    /// How far its change since the frame before is.
    pub change_off: f64,
    /// The same pixel by pixel, RMS over display white.
    pub pixels_off: f64,
}

/// Effects that may be left out of these scenes.
const ALL_ON: &str = "[effects]
drop_extinction = \"on\"
drop_shadow = \"on\"
skylit_drops = \"on\"
multiple_scattering = \"on\"
sunlight_through_air = \"on\"
air_extinction = \"on\"
air_inscatter = \"on\"
sky = \"on\"
";

impl Volumes {
    pub fn name(self) -> &'static str {
        match self {
            Self::Density => "density",
            Self::Drops => "drops",
        }
    }

    /// The section of the scene.
    fn section(self) -> &'static str {
        match self {
            Self::Density => {
                "shape = \"from-vdb\"
file = \"density.####.vdb\"
density_means = \"optical-depth\"
scale = 1.5
effective_radius_um = 200.0
effective_variance = 0.1"
            }
            Self::Drops => "file = \"drops.####.vdb\"",
        }
    }
}

impl Film<'_> {
    /// Makes it and its references.
    pub fn beside_references(&self) -> Vec<Beside> {
        (1..=self.n_frames).for_each(|frame| self.write_volume(frame));
        let film = self.made();
        self.run(&film, "");
        let (reference, finest) = (self.place("reference"), self.finest);
        self.run(
            &reference,
            &format!("{ALL_ON}[accuracy]\ntolerance = {finest}\n"),
        );
        let white_cd_m2 = self.choice().plan.display_white_cd_m2;
        let mut before = None::<Array2<f64>>;
        let beside = |frame| {
            let expected = luminance_of(&reference, frame);
            let mean_cd_m2 = mean(&expected);
            let off = luminance_of(&film, frame) - expected;
            let change = &off - before.as_ref().unwrap_or(&off);
            let beside = Beside {
                frame,
                mean_cd_m2,
                off: mean(&off) / mean_cd_m2,
                change_off: mean(&change) / mean_cd_m2,
                pixels_off: mean(&change.mapv(|it| it * it)).sqrt() / white_cd_m2,
            };
            before = Some(off);
            beside
        };
        (1..=self.n_frames).map(beside).collect()
    }

    /// What was decided for it.
    pub fn choice(&self) -> SequenceChoice {
        let text = fs::read_to_string(self.made().join("choice.toml")).unwrap();
        toml::from_str(&text).unwrap()
    }

    /// The folder of its frames.
    pub fn made(&self) -> PathBuf {
        self.place("film")
    }

    fn place(&self, what: &str) -> PathBuf {
        self.folder.join(format!("{}.{what}", self.volumes.name()))
    }

    /// The volume of a frame.
    fn write_volume(&self, frame: u32) {
        let name = self.volumes.name();
        let path = self.folder.join(format!("{name}.{frame:04}.vdb"));
        let plume = Plume::at(frame, self.n_frames);
        match self.volumes {
            Volumes::Density => plume.write_density(&path),
            Volumes::Drops => plume.write_drops(&path, |at_m| {
                // A middle size at the ends and quarters of the film, which are looked at in any case, and four times
                // that or a quarter of it between.
                let turns = 2.0 * f64::from(frame - 1) / f64::from(self.n_frames - 1);
                let times = (2.0 * (std::f64::consts::TAU * turns).sin()).exp2();
                100.0 * times * (1.0 + 0.004 * at_m.y)
            }),
        }
    }

    /// Runs it with more text at the end of its scene.
    fn run(&self, out: &Path, more: &str) {
        let ([width_px, height_px], last) = (self.size_px, self.n_frames);
        let drops = self.volumes.section();
        let scene = format!(
            "format = 1
name = \"film\"
[sun]
elevation_deg = 12.0
azimuth_deg = 180.0
[camera]
position_m = [-20.0, 2.0, 0.0]
azimuth_deg = -6.0
elevation_deg = 14.0
horizontal_fov_deg = 64.0
width_px = {width_px}
height_px = {height_px}
[spectrum]
first_nm = 400.0
step_nm = 30.0
n_wavelengths = 11
[drops]
{drops}
[air]
constituents = [\"rayleigh\"]
[picture]
exposure_ev = 2.5
[sequence]
sun.elevation_deg = [[1, 12.0], [{last}, 22.0]]
camera.azimuth_deg = [[1, -6.0], [{last}, 6.0]]
camera.position_m = [[1, [-20.0, 2.0, 0.0]], [{last}, [20.0, 6.0, 10.0]]]
{more}"
        );
        let path = out.with_extension(format!(
            "{}.toml",
            out.extension().unwrap_or_default().display()
        ));
        fs::write(&path, scene).unwrap();
        let frames = format!("1-{last}");
        let flags = ["--frames", &frames, "--force", "-q"];
        niji_ends_with(
            0,
            &[&["run", text(&path), "-o", text(out)], &flags[..]].concat(),
        );
    }
}

/// Luminance of a frame (cd/m2).
fn luminance_of(out: &Path, frame: u32) -> Array2<f64> {
    let image = SpectralImage::read_spectral(&out.join(format!("image.{frame:04}.exr"))).unwrap();
    luminance(&image.radiance, &image.wavelengths)
}

fn mean(values: &Array2<f64>) -> f64 {
    values.sum() / values.len() as f64
}
