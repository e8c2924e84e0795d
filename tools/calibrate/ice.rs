//! Error against time of the levels of light through ice.
//!
//! Cubes of 0.1 m and 50 m as the shipped scenes show them, in 96 x 72 pixels, with the published
//! surface and with a rough dielectric. `relative_rmse` is the RMSE of spectral radiance over the RMS
//! of a reference of the same surface with 4096 paths a pixel, each of all wavelengths: what dispersion
//! adds to a rough dielectric is not in it. The last rows are the cube of 50 m at 640 x 480: their
//! error is the RMSE between two seeds over the root of 2, noise alone.

use std::time::Instant;

use niji_ice::IcePicture;
use niji_ice::IceSurface;
use niji_ice::IceTransport;
use niji_ice::PathWavelengths;
use niji_scene::IceScene;
use serde::Serialize;

use crate::failure::Failure;
use crate::ice::World;
use crate::progress;
use crate::progress::Verbosity;
use crate::timed_run::relative_rmse;
use crate::timed_run::rounded;

const SCENES: [&str; 2] = [
    include_str!("../../data/scenes/ice-cube-0.1-m.toml"),
    include_str!("../../data/scenes/ice-cube-50-m.toml"),
];
const SURFACES: [(&str, IceSurface); 2] = [
    ("diffuse", IceSurface::PUBLISHED),
    (
        "rough-dielectric 0.2",
        IceSurface::RoughDielectric { roughness: 0.2 },
    ),
];
/// Size of the small pictures.
const SMALL_PX: [u32; 2] = [96, 72];
const REFERENCE: IceTransport = IceTransport::PathTraced {
    paths_per_pixel: 4096,
    wavelengths: PathWavelengths::All,
};
/// Paths through a pixel of the levels.
const N_PATHS: [u32; 3] = [16, 64, 256];
/// Paths through a pixel of the large picture.
const N_PATHS_LARGE: [u32; 2] = [64, 128];
/// The seed of references, another than that of any level.
const REFERENCE_SEED: u64 = 1 << 40;

/// One level.
#[derive(Debug, Serialize)]
pub(super) struct IceRow {
    scene: String,
    surface: &'static str,
    width_px: u32,
    height_px: u32,
    level: &'static str,
    paths_per_pixel: u32,
    relative_rmse: f64,
    seconds: f64,
    date: String,
}

/// Measures all levels.
pub(super) fn rows(date: &str, verbosity: Verbosity) -> Result<Vec<IceRow>, Failure> {
    let n_steps = SCENES.len() * SURFACES.len() + 1;
    let bar = progress::bar("calibrate", n_steps as u64, verbosity);
    let mut rows = Vec::new();
    for text in SCENES {
        for surface in SURFACES {
            rows.extend(levels(text, surface, date)?);
            bar.inc(1);
        }
    }
    rows.extend(large_picture(date)?);
    bar.finish_and_clear();
    Ok(rows)
}

fn levels(
    text: &str,
    (surface_name, surface): (&'static str, IceSurface),
    date: &str,
) -> Result<Vec<IceRow>, Failure> {
    let mut scene = read(text)?;
    [scene.camera.width_px, scene.camera.height_px] = SMALL_PX;
    scene.ice.surface = surface;
    let world = World::new(&scene, None)?;
    let (reference, _) = draw(&scene, &world, REFERENCE, REFERENCE_SEED)?;
    let mut rows = Vec::new();
    for paths_per_pixel in N_PATHS {
        for (level, transport) in levels_of(paths_per_pixel) {
            let (picture, seconds) = draw(&scene, &world, transport, 0)?;
            rows.push(IceRow {
                surface: surface_name,
                relative_rmse: rounded(relative_rmse(&picture.radiance, &reference.radiance)),
                paths_per_pixel,
                ..row(&scene, level, seconds, date)
            });
        }
    }
    Ok(rows)
}

fn large_picture(date: &str) -> Result<Vec<IceRow>, Failure> {
    let scene = read(SCENES[1])?;
    let world = World::new(&scene, None)?;
    let mut rows = Vec::new();
    for paths_per_pixel in N_PATHS_LARGE {
        let [_, _, _, (level, transport)] = levels_of(paths_per_pixel);
        let (picture, seconds) = draw(&scene, &world, transport, 0)?;
        let (other, _) = draw(&scene, &world, transport, REFERENCE_SEED)?;
        let noise = relative_rmse(&picture.radiance, &other.radiance) / 2.0_f64.sqrt();
        rows.push(IceRow {
            relative_rmse: rounded(noise),
            paths_per_pixel,
            ..row(&scene, level, seconds, date)
        });
    }
    Ok(rows)
}

fn levels_of(paths_per_pixel: u32) -> [(&'static str, IceTransport); 4] {
    let traced = |wavelengths| IceTransport::PathTraced {
        paths_per_pixel,
        wavelengths,
    };
    [
        ("mean-chord", IceTransport::MeanChord { paths_per_pixel }),
        ("path-traced one", traced(PathWavelengths::One)),
        ("path-traced four", traced(PathWavelengths::Four)),
        ("path-traced all", traced(PathWavelengths::All)),
    ]
}

fn read(text: &str) -> Result<IceScene, Failure> {
    IceScene::from_toml(text).map_err(|error| Failure::Failed(error.to_string()))
}

/// A picture and the time it took.
fn draw(
    scene: &IceScene,
    world: &World,
    transport: IceTransport,
    seed: u64,
) -> Result<(IcePicture, f64), Failure> {
    let mut accuracy = scene.accuracy;
    accuracy.transport = transport;
    accuracy.seed = seed;
    let start = Instant::now();
    let picture = world.render(accuracy, None, &|_| ())?;
    Ok((picture, start.elapsed().as_secs_f64()))
}

fn row(scene: &IceScene, level: &'static str, seconds: f64, date: &str) -> IceRow {
    IceRow {
        scene: scene.name.clone(),
        surface: SURFACES[0].0,
        width_px: scene.camera.width_px,
        height_px: scene.camera.height_px,
        level,
        paths_per_pixel: 0,
        relative_rmse: 0.0,
        seconds: rounded(seconds),
        date: date.to_owned(),
    }
}
