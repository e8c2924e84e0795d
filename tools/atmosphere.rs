//! `niji atmosphere`: the air of a scene, and its sky.

use std::path::PathBuf;

use clap::Args;

use crate::failure::Failure;
use crate::flags::Common;
use crate::scene_file;
use crate::stages;
use crate::stages::sky::Panorama;
use niji_picture::PlannedScene;

/// Widest panorama, pixels.
const MAX_WIDTH_PX: usize = 32_768;
/// Heights that an eye may have, m: down to the Dead Sea, up to the moon.
const HEIGHTS_M: std::ops::RangeInclusive<f64> = -1000.0..=4e8;

/// Tabulate the air (EXR), or write a panorama of its sky (EXR, PNG).
///
/// The table holds density profiles, lengths to the top of the air, phase functions, sunlight and
/// ground albedo. The panorama is equirectangular: north in the middle, east to its right, the
/// zenith on top; the sun's disc left out. Both hold light that is scattered more than once unless the
/// scene's level of `sky` is single-scattering; the table only where the scene's plan shows it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji atmosphere --scene data/scenes/paper-b-sun-10-inscatter.toml -o atmosphere.exr
  niji atmosphere --scene data/scenes/paper-b-sun-10-inscatter.toml --sky sky.exr --width-px 640
  niji atmosphere --scene data/scenes/clear-sky.toml --sky dusk.exr \\
      --sun-elevation-deg -4 --exposure-ev 9")]
pub(crate) struct AtmosphereCommand {
    /// The scene whose section [air] is meant.
    #[arg(long, value_name = "TOML")]
    scene: PathBuf,
    /// The table to write.
    #[arg(short, long, value_name = "EXR", required_unless_present = "sky")]
    output: Option<PathBuf>,
    /// The panorama to write; a preview *.png stands beside it.
    #[arg(long, value_name = "EXR")]
    sky: Option<PathBuf>,
    /// Width of the panorama, twice its height.
    #[arg(long, value_name = "PX", default_value_t = 640, requires = "sky")]
    width_px: usize,
    /// Height of the eye above sea level [default: that of the scene's camera].
    #[arg(
        long,
        value_name = "M",
        requires = "sky",
        allow_negative_numbers = true
    )]
    height_m: Option<f64>,
    /// Elevation of the sun [default: that of the scene].
    #[arg(
        long,
        value_name = "DEG",
        requires = "sky",
        allow_negative_numbers = true
    )]
    sun_elevation_deg: Option<f64>,
    /// Exposure of the preview in stops [default: that of the scene].
    #[arg(
        long,
        value_name = "EV",
        requires = "sky",
        allow_negative_numbers = true
    )]
    exposure_ev: Option<f64>,
}

/// Runs the stages that were asked for.
///
/// # Errors
/// As [`stages::atmosphere::make`] and [`stages::sky::make`]; a size or height out of range.
pub(crate) fn execute(command: &AtmosphereCommand, common: &Common) -> Result<(), Failure> {
    if let Some(table) = &command.output {
        let PlannedScene { scene, plan, .. } = scene_file::load(&command.scene, common)?;
        let orders = plan.scattering_orders();
        stages::atmosphere::make((&scene, orders), table, common.options())?;
    }
    let Some(sky) = &command.sky else {
        return Ok(());
    };
    let mut scene = scene_file::read(&command.scene, common)?;
    let width_px = command.width_px;
    if !(2..=MAX_WIDTH_PX).contains(&width_px) || !width_px.is_multiple_of(2) {
        return Err(Failure::Usage(format!(
            "found a width of {width_px} pixels, expected an even number from 2 to {MAX_WIDTH_PX}"
        )));
    }
    let height_m = command.height_m.unwrap_or(scene.camera.position_m[1]);
    if !HEIGHTS_M.contains(&height_m) {
        return Err(Failure::Usage(format!(
            "found a height of {height_m} m, expected {} to {}",
            HEIGHTS_M.start(),
            HEIGHTS_M.end()
        )));
    }
    let sun_elevation_deg = command.sun_elevation_deg.unwrap_or(scene.sun.elevation_deg);
    if !(-90.0..=90.0).contains(&sun_elevation_deg) {
        return Err(Failure::Usage(format!(
            "found a sun at {sun_elevation_deg} degrees, expected -90 to 90"
        )));
    }
    scene.sun.elevation_deg = sun_elevation_deg;
    scene.picture.exposure_ev = command.exposure_ev.unwrap_or(scene.picture.exposure_ev);
    let panorama = Panorama { width_px, height_m };
    stages::sky::make(&scene, panorama, sky, common.options()).map(|_| ())
}
