//! `niji render`: the picture of a scene from the files of the other stages.

use std::path::PathBuf;

use clap::Args;
use niji_geometry::PixelRegion;
use niji_picture::PictureSettings;
use niji_picture::SurfaceFiles;

use crate::failure::Failure;
use crate::flags::Common;
use crate::scene_file;
use crate::sequence_file;
use crate::stages;
use crate::stages::render::Inputs;
use crate::stages::render::RenderStage;
use crate::stages::render::Target;
use crate::stages::tile::TileOfMany;
use crate::stages::tile::parse_region;
use crate::stages::tile::parse_tile;

/// Integrate along the view rays (EXR, PNG).
///
/// Writes the spectral image with its AOVs, *.layers.exr for compositors and a PNG preview beside it. A render
/// that was interrupted goes on where it was. The pixels of a tile are those of the whole picture;
/// `niji merge` puts tiles together.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji render --scene scene.toml --drops drops.vdb --table scatter.exr -o image.exr
  niji render --scene scene.toml --drops drops.vdb --table scatter.exr --tiles 3/16 -o tile.03.exr
  niji merge tile.*.exr -o image.exr")]
pub(crate) struct RenderCommand {
    /// The scene: camera, sun, effects and levels.
    #[arg(long, value_name = "TOML")]
    scene: PathBuf,
    /// The drop volume.
    #[arg(long, value_name = "VDB")]
    drops: PathBuf,
    /// The scattering table: the scene's own, or any of the same water, wavelengths and theory that holds at
    /// least its sizes, angles and orders.
    #[arg(long, value_name = "EXR")]
    table: Option<PathBuf>,
    /// The air.
    #[arg(long, value_name = "EXR")]
    air: Option<PathBuf>,
    /// Distances of surfaces that hide what is behind them (EXR, Z in metres along the ray, see
    /// `niji depth`) [default: those of the scene].
    #[arg(long, value_name = "EXR")]
    depth: Option<PathBuf>,
    /// A mesh that hides what is behind it (OBJ, glTF, STL; metres, y up, north −z), in the scene's own
    /// coordinates; may be given several times [default: those of the scene].
    #[arg(long, value_name = "FILE")]
    mesh: Vec<PathBuf>,
    /// Render only these pixels of the picture, counted from its top left one; negative in the
    /// overscan.
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_region, conflicts_with = "tiles")]
    #[arg(allow_hyphen_values = true)]
    region: Option<PixelRegion>,
    /// Render only the tile I of N, from 1: bands of rows from the top.
    #[arg(long, value_name = "I/N", value_parser = parse_tile)]
    tiles: Option<TileOfMany>,
    /// The spectral image to write.
    #[arg(short, long, value_name = "EXR")]
    output: PathBuf,
}

/// Runs the stage.
///
/// # Errors
/// As [`stages::render::make`]; a file that the scene's plan needs and that is not named.
pub(crate) fn execute(command: &RenderCommand, common: &Common) -> Result<(), Failure> {
    let planned = scene_file::load(&command.scene, common)?;
    sequence_file::refuse_shutter(&command.scene, &planned.scene)?;
    planned.check_light()?;
    let need = |(name, maker), is_needed: bool, given: &Option<PathBuf>| match (is_needed, given) {
        (true, None) => Err(Failure::Usage(format!(
            "this scene needs --{name}, a file that `niji {maker} --scene` writes"
        ))),
        (true, Some(path)) => Ok(Some(path.clone())),
        (false, _) => Ok(None),
    };
    let table = need(
        ("table", "scatter"),
        planned.plan.scattering.is_some(),
        &command.table,
    )?;
    if table.is_none() && command.table.is_some() {
        stages::given_table::warn_unused(common.verbosity());
    }
    let runs_air = planned.plan.runs(niji_scene::Stage::Atmosphere);
    let air = need(("air", "atmosphere"), runs_air, &command.air)?;
    let scene = &planned.scene;
    let surfaces = surfaces(command, SurfaceFiles::of_scene(scene, &planned.folder))?;
    if scene.photo.is_some() && surfaces.depth.is_none() {
        return Err(Failure::Usage(
            "this scene needs --depth, a file that `niji depth` writes".to_owned(),
        ));
    }
    stages::other_scene::warn(scene, air.as_deref(), common.verbosity());
    let inputs = Inputs {
        drops: &command.drops,
        table: table.as_deref(),
        air: air.as_deref(),
        surfaces: &surfaces,
    };
    let settings = PictureSettings::of(&planned);
    let target = Target {
        path: &command.output,
        region: region(command, settings.whole()?)?,
    };
    let stage = RenderStage {
        settings: &settings,
        inputs,
        target,
    };
    stages::render::make(stage, common.options())?;
    stages::accuracy::check(&planned, &command.output, common.goal())
}

/// The surfaces that are given, or those of the scene.
fn surfaces(command: &RenderCommand, of_scene: SurfaceFiles) -> Result<SurfaceFiles, Failure> {
    let surfaces = match &command.depth {
        Some(path) => of_scene.with_depth(path.clone()),
        None => of_scene,
    };
    if command.mesh.is_empty() {
        return Ok(surfaces);
    }
    Ok(surfaces.with_meshes(&command.mesh)?)
}

/// The part of a picture that is asked for.
fn region(command: &RenderCommand, whole: PixelRegion) -> Result<PixelRegion, Failure> {
    match (command.region, command.tiles) {
        (Some(region), _) if whole.contains(region) => Ok(region),
        (Some(region), _) => Err(Failure::Usage(format!(
            "the region {region} reaches beyond the picture, which is {whole}: x, y, width, height; \
             camera.overscan_px in the scene makes it larger"
        ))),
        (None, Some(tile)) => {
            let bands = whole.bands(tile.n_tiles);
            let bands = bands.map_err(|error| Failure::Usage(error.to_string()))?;
            Ok(bands[tile.number as usize - 1])
        }
        (None, None) => Ok(whole),
    }
}
