//! `niji merge`: tiles become the picture that one run would have made.

use std::collections::BTreeMap;
use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use ndarray::Array2;
use ndarray::s;
use niji_exchange::Provenance;
use niji_exchange::SpectralImage;
use niji_geometry::PixelRegion;
use niji_scene::Picture;
use serde_json::Value;

use crate::checksums;
use crate::checksums::hash_once;
use crate::failure::Failure;
use crate::flags::Common;
use crate::frame_list::FrameList;
use crate::output;
use crate::run::files::image;
use crate::run::files::tiles_of;
use crate::stages;
use crate::stages::assembly::Assembly;
use crate::stages::assembly::Misfit;
use crate::stages::render::companions;
use crate::stages::render::write;
use crate::stages::stored_provenance;
use crate::stages::tile::Tile;

/// Most rows that are tried to find out how many tiles there should be.
const MAX_TILES: u32 = 1 << 16;

/// Put tiles of a picture together (EXR, PNG).
///
/// The files are those that `niji render` makes of the whole picture, byte for byte. Tiles may overlap
/// where they agree; one that is missing, of another picture or changed is named.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji merge tile.*.exr -o image.exr
  niji run sequence.toml -o out --frames 7-8 --tiles 1-4/4 && niji merge out --frames 7-8
  for i in 1 2 3 4; do
    niji render --scene scene.toml --drops drops.vdb --table scatter.exr --tiles $i/4 -o tile.$i.exr
  done && niji merge tile.[1-4].exr -o image.exr")]
pub(crate) struct MergeCommand {
    /// Tiles that `niji render --tiles` or `--region` made; *.layers.exr among them are left out. Or the folder of
    /// `niji run --tiles`, whose tiles become the image in it.
    #[arg(required = true, value_name = "TILE")]
    tiles: Vec<PathBuf>,
    /// The spectral image to write.
    #[arg(short, long, value_name = "EXR")]
    output: Option<PathBuf>,
    /// The frames to put together in the folder of a sequence.
    #[arg(long, value_name = "LIST", value_parser = FrameList::parse, conflicts_with = "output")]
    frames: Option<FrameList>,
}

/// A tile on disk.
struct TileFile<'a> {
    path: &'a Path,
    tile: Tile,
    /// Where the whole picture comes from.
    picture: Provenance,
}

/// Merges tiles, or those of each picture in the folder of a run.
///
/// # Errors
/// As [`merge`]; a folder without tiles, or tiles without a name for their picture.
pub(crate) fn execute(command: &MergeCommand, common: &Common) -> Result<(), Failure> {
    let (folder, frames) = match (&command.tiles[..], &command.output) {
        (tiles, Some(output)) => return merge(tiles, output, common),
        ([folder], None) if folder.is_dir() => (folder, &command.frames),
        (_, None) => {
            let message =
                "expected -o EXR for the picture of these tiles, or a folder of `niji run --tiles`";
            return Err(Failure::Usage(message.to_owned()));
        }
    };
    let numbers = frames.iter().flat_map(FrameList::iter).map(Some);
    let still = frames.is_none().then_some(None);
    for picture in numbers.chain(still) {
        let image = image(folder, picture);
        let tiles = tiles_of(&image);
        if tiles.is_empty() {
            let message = "found no tile of it, expected some that `niji run --tiles` made";
            return Err(Failure::bad_input(&image, message));
        }
        merge(&tiles, &image, common)?;
    }
    Ok(())
}

/// Merges tiles of one picture.
///
/// # Errors
/// A tile that is missing, damaged or not of this picture, or an output that exists.
fn merge(tiles: &[PathBuf], to: &Path, common: &Common) -> Result<(), Failure> {
    let is_plain = |path: &&PathBuf| path.to_string_lossy().ends_with(".layers.exr");
    let paths = tiles.iter().filter(|path| !is_plain(path));
    let files = paths.map(|path| TileFile::open(path));
    let files = files.collect::<Result<Vec<_>, _>>()?;
    let first = one_picture(&files)?;
    check_complete(&files, first.tile.whole)?;
    let options = common.options();
    let [plain, preview] = companions(to);
    let outputs: [&Path; 3] = [to, &plain, &preview];
    (outputs.iter()).try_for_each(|path| output::check_regular(path))?;
    let (request, tiles) = (first.picture.request_hash(), hash_of(&files)?);
    let fits = |path: &&Path| checksums::fits(path, &request, options.verifies);
    if outputs.iter().all(fits) && checksums::is_merged_from(to, &tiles) {
        stages::say_up_to_date("merge", to, options.verbosity);
        return Ok(());
    }
    stages::check_free_for(&first.picture, &outputs, options.existing)?;
    let shown = shown(&first.picture).ok_or_else(|| {
        let message = "its provenance does not say how the picture is shown, render it again";
        Failure::bad_input(first.path, message)
    })?;
    write(&merged(&files, first)?, &shown, to)?;
    // A run that asks for this picture finds it.
    (outputs.iter()).try_for_each(|path| checksums::note_merged(path, &request, Some(&tiles)))
}

/// Hash of what stands in tiles, in any order.
fn hash_of(files: &[TileFile]) -> Result<String, Failure> {
    let hashes = files.iter().map(|file| {
        let hash = hash_once(file.path);
        hash.map_err(|error| Failure::bad_input(file.path, error))
    });
    let mut hashes = hashes.collect::<Result<Vec<_>, _>>()?;
    hashes.sort();
    let all = Provenance {
        settings: hashes.concat(),
        ..Provenance::default()
    };
    Ok(all.request_hash())
}

impl<'a> TileFile<'a> {
    fn open(path: &'a Path) -> Result<Self, Failure> {
        if !path.is_file() {
            return Err(Failure::bad_input(path, "found no such file"));
        }
        let stored = stored_provenance(path).filter(|stored| stored.tool == "niji render");
        let Some(provenance) = stored else {
            let message = "found no provenance of niji render, expected a tile that it made";
            return Err(Failure::bad_input(path, message));
        };
        let (tile, picture) = match Tile::of(&provenance) {
            Some(known) => known,
            // A single tile is the whole picture.
            None => (whole(path)?, provenance),
        };
        Ok(Self {
            path,
            tile,
            picture,
        })
    }
}

fn whole(path: &Path) -> Result<Tile, Failure> {
    let image = SpectralImage::read_picture(path);
    let image = image.map_err(|error| Failure::bad_input(path, error))?;
    Ok(Tile {
        region: image.windows.data,
        whole: image.windows.data,
    })
}

/// The first tile of the picture that most tiles belong to; all must.
fn one_picture<'f, 'p>(files: &'f [TileFile<'p>]) -> Result<&'f TileFile<'p>, Failure> {
    let mut by_hash: BTreeMap<String, Vec<&TileFile>> = BTreeMap::new();
    for file in files {
        let hash = file.picture.request_hash();
        by_hash.entry(hash).or_default().push(file);
    }
    // Of equally many, the picture of the first tile.
    let most = files.iter().rev().max_by_key(|file| {
        let alike = by_hash.get(&file.picture.request_hash());
        alike.map_or(0, Vec::len)
    });
    let Some(most) = most else {
        let message = "found only *.layers.exr, expected the spectral images of tiles";
        return Err(Failure::Usage(message.to_owned()));
    };
    let foreign = files.iter().find(|file| {
        file.picture.request_hash() != most.picture.request_hash()
            || file.tile.whole != most.tile.whole
    });
    match foreign {
        None => Ok(most),
        Some(foreign) => {
            let reason = difference(&foreign.picture, &most.picture);
            let message = format!(
                "it is a tile of another picture than {}: {reason}; render it again as the others",
                most.path.display()
            );
            Err(Failure::bad_input(foreign.path, message))
        }
    }
}

/// What is not the same in two pictures, in words.
fn difference(found: &Provenance, expected: &Provenance) -> String {
    if found.version != expected.version {
        let (found, expected) = (&found.version, &expected.version);
        return format!("made by version {found}, the others by {expected}");
    }
    for (role, hash) in &expected.inputs {
        if found.inputs.get(role) != Some(hash) {
            return format!("made from another file --{role}");
        }
    }
    if let Some(role) = found
        .inputs
        .keys()
        .find(|role| !expected.inputs.contains_key(*role))
    {
        return format!("made with --{role}, the others without");
    }
    let values = |provenance: &Provenance| serde_json::from_str::<Value>(&provenance.settings);
    match (values(found), values(expected)) {
        (Ok(found), Ok(expected)) => {
            first_difference("", &found, &expected).unwrap_or_else(|| "another frame".to_owned())
        }
        (_, _) => "other settings".to_owned(),
    }
}

/// The first setting that is not the same, with both values.
fn first_difference(name: &str, found: &Value, expected: &Value) -> Option<String> {
    if let (Value::Object(found), Value::Object(expected)) = (found, expected) {
        let keys = expected.keys().chain(found.keys());
        return keys.into_iter().find_map(|key| {
            let name = if name.is_empty() {
                key.clone()
            } else {
                format!("{name}.{key}")
            };
            let value =
                |map: &serde_json::Map<String, Value>| map.get(key).cloned().unwrap_or(Value::Null);
            first_difference(&name, &value(found), &value(expected))
        });
    }
    (found != expected).then(|| format!("{name} is {found}, of the others {expected}"))
}

/// How the preview of a picture is shown.
fn shown(picture: &Provenance) -> Option<Picture> {
    let settings: Value = serde_json::from_str(&picture.settings).ok()?;
    // Of depth along the axis the settings are the first of a pair.
    let shown = settings
        .get("picture")
        .or_else(|| settings.get(0)?.get("picture"));
    serde_json::from_value(shown?.clone()).ok()
}

/// Names what no tile covers.
fn check_complete(files: &[TileFile], whole: PixelRegion) -> Result<(), Failure> {
    let size = (whole.height_px as usize, whole.width_px as usize);
    let mut covered = Array2::from_elem(size, false);
    for file in files {
        let region = file.tile.region;
        if !whole.contains(region) {
            let message = format!("it is {region}, outside of the picture {whole}");
            return Err(Failure::bad_input(file.path, message));
        }
        let row = region.y_px.abs_diff(whole.y_px) as usize;
        let column = region.x_px.abs_diff(whole.x_px) as usize;
        let rows = row..row + region.height_px as usize;
        let columns = column..column + region.width_px as usize;
        covered.slice_mut(s![rows, columns]).fill(true);
    }
    let Some(gap) = first_gap(&covered, whole) else {
        return Ok(());
    };
    let missing = missing_tiles(files, whole);
    let what = if missing.is_empty() {
        format!(
            "the pixels {gap} (x, y, width, height) are missing: render them with the command of \
             the other tiles and --region {gap}"
        )
    } else {
        let flags = missing.iter().map(|tile| format!("--tiles {tile}"));
        format!(
            "{} missing: render with the command of the other tiles and {}",
            if missing.len() == 1 {
                "a tile is".to_owned()
            } else {
                format!("{} tiles are", missing.len())
            },
            flags.collect::<Vec<_>>().join(", ")
        )
    };
    let parts = files.iter().map(|file| file.path.display().to_string());
    let found = parts.collect::<Vec<_>>().join(", ");
    Err(Failure::Usage(format!("{what} (found {found})")))
}

/// The first rectangle without a tile, from the top.
fn first_gap(covered: &Array2<bool>, whole: PixelRegion) -> Option<PixelRegion> {
    let ((row, column), _) = covered.indexed_iter().find(|(_, covered)| !**covered)?;
    let (n_rows, n_columns) = covered.dim();
    let right = (column..n_columns)
        .find(|x| covered[[row, *x]])
        .unwrap_or(n_columns);
    let is_free = |y: &usize| (column..right).all(|x| !covered[[*y, x]]);
    let n_free = (row..n_rows).take_while(is_free).count();
    Some(PixelRegion {
        x_px: whole.x_px + column as i32,
        y_px: whole.y_px + row as i32,
        width_px: (right - column) as u32,
        height_px: n_free as u32,
    })
}

/// The tiles `I/N` that are missing, if all that are there are bands of one number.
fn missing_tiles(files: &[TileFile], whole: PixelRegion) -> Vec<String> {
    let regions: Vec<PixelRegion> = files.iter().map(|file| file.tile.region).collect();
    // Bands differ by a row at most, so their number is known nearly.
    let rows = regions
        .iter()
        .map(|region| region.height_px)
        .min()
        .unwrap_or(1);
    let fewest = (whole.height_px / (rows + 1)).max(1);
    let most = whole
        .height_px
        .div_ceil(rows.max(2) - 1)
        .min(whole.height_px);
    for n_tiles in fewest..=most.min(MAX_TILES) {
        let Ok(bands) = whole.bands(n_tiles) else {
            continue;
        };
        if regions.iter().all(|region| bands.contains(region)) {
            let missing = (1..).zip(bands).filter(|(_, band)| !regions.contains(band));
            return missing
                .map(|(number, _)| format!("{number}/{n_tiles}"))
                .collect();
        }
    }
    Vec::new()
}

/// Reads the tiles one after the other.
fn merged(files: &[TileFile], first: &TileFile) -> Result<SpectralImage, Failure> {
    let mut assembly: Option<Assembly> = None;
    for file in files {
        let part = SpectralImage::read_picture(file.path);
        let part = part.map_err(|error| Failure::bad_input(file.path, error))?;
        if part.windows.data != file.tile.region {
            let message = format!(
                "its pixels lie at {}, its provenance says {}: it was edited, render it again",
                part.windows.data, file.tile.region
            );
            return Err(Failure::bad_input(file.path, message));
        }
        let (whole, picture) = (first.tile.whole, &first.picture);
        let assembly = assembly.get_or_insert_with(|| Assembly::new(&part, whole, picture.clone()));
        assembly.add(&part).map_err(|misfit| {
            let message = match misfit {
                Misfit::Kind(what) => format!("found other {what} than in the tiles before it"),
                Misfit::Overlap { x_px, y_px } => format!(
                    "pixel ({x_px}, {y_px}) differs from a tile that overlaps it: one of them was \
                     edited or made by another build, render both again"
                ),
            };
            Failure::bad_input(file.path, message)
        })?;
    }
    let assembly = assembly.ok_or_else(|| Failure::Usage("found no tile".to_owned()))?;
    Ok(assembly.finish())
}
