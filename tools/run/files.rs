//! Where the files of a run stand.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

use niji_exchange::Provenance;
use niji_geometry::PixelRegion;
use niji_scene::canonical_json;

use crate::failure::Failure;
use crate::stages;
use crate::stages::tile::TileOfMany;
use crate::stages::tile::TilesOfMany;
use crate::stages::tile::parse_tile;
use niji_picture::PlannedScene;

/// Digits of a hash in the name of a file: two needs of one sequence meet once in 2^32 pairs, and then
/// the second is refused, not mistaken.
const HASH_DIGITS: usize = 8;

/// The files of a run.
pub(crate) struct Files {
    /// The folder of all that the run makes.
    pub folder: PathBuf,
    /// The drop volume, which may be the scene's own.
    pub drops: PathBuf,
    /// The table of f(z).
    pub airy: PathBuf,
    /// The scattering table.
    pub table: PathBuf,
    /// Whether it is there already, and not made.
    pub is_table_given: bool,
    /// The air.
    pub air: PathBuf,
    /// The spectral image.
    pub image: PathBuf,
    /// The tiles of it that are made instead.
    pub tiles: Option<TilesOfMany>,
}

/// The spectral image of a run, or of a frame.
pub(crate) fn image(folder: &Path, frame: Option<u32>) -> PathBuf {
    let image = folder.join(stages::render::FILE);
    frame.map_or(image.clone(), |frame| named(&image, &format!("{frame:04}")))
}

/// The folder of an image's tiles: `tiles/image.0007` beside `image.0007.exr`.
fn tiles_folder(image: &Path) -> PathBuf {
    let folder = image.with_file_name("tiles");
    folder.join(image.file_stem().unwrap_or_default())
}

/// A tile of an image, `3of16.exr` in its folder.
pub(crate) fn tile(image: &Path, tile: TileOfMany) -> PathBuf {
    let TileOfMany { number, n_tiles } = tile;
    tiles_folder(image).join(format!("{number}of{n_tiles}.exr"))
}

/// The tiles that are there of an image, of however many.
pub(crate) fn tiles_of(image: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(tiles_folder(image)).into_iter().flatten();
    let is_tile = |path: &PathBuf| {
        let name = path.file_name().and_then(|it| it.to_str());
        let tile = name.and_then(|name| name.strip_suffix(".exr"));
        tile.is_some_and(|tile| parse_tile(&tile.replacen("of", "/", 1)).is_ok())
    };
    let paths = entries.flatten().map(|it| it.path());
    let mut tiles: Vec<PathBuf> = paths.filter(is_tile).collect();
    tiles.sort();
    tiles
}

impl Files {
    /// Those of a scene.
    #[must_use]
    pub(crate) fn of_scene(planned: &PlannedScene, folder: &Path) -> Self {
        let inside = |name: &str| folder.join(name);
        Self {
            folder: folder.to_owned(),
            drops: (planned.drop_file.clone()).unwrap_or_else(|| inside(stages::drops::FILE)),
            airy: inside(stages::airy::FILE),
            table: inside(stages::scatter::FILE),
            is_table_given: false,
            air: inside(stages::atmosphere::FILE),
            image: image(folder, None),
            tiles: None,
        }
    }

    /// With a finished scattering table, where one is given.
    #[must_use]
    pub(super) fn with_table(self, given: Option<PathBuf>) -> Self {
        Self {
            is_table_given: given.is_some(),
            table: given.unwrap_or(self.table),
            ..self
        }
    }

    /// With tiles in place of the image, where they are asked for.
    #[must_use]
    pub(super) fn with_tiles(self, tiles: Option<&TilesOfMany>) -> Self {
        Self {
            tiles: tiles.cloned(),
            ..self
        }
    }

    /// What a run ends with: the image, or the folder of its tiles.
    pub(super) fn picture(&self) -> PathBuf {
        let image = &self.image;
        self.tiles
            .as_ref()
            .map_or(image.clone(), |_| tiles_folder(image))
    }

    /// The pictures to be rendered, with their pixels: the image, or tiles of it.
    ///
    /// # Errors
    /// More tiles than rows.
    pub(super) fn targets(
        &self,
        whole: PixelRegion,
    ) -> Result<Vec<(PathBuf, PixelRegion)>, Failure> {
        let Some(TilesOfMany { numbers, n_tiles }) = &self.tiles else {
            return Ok(vec![(self.image.clone(), whole)]);
        };
        let n_tiles = *n_tiles;
        let bands = whole.bands(n_tiles);
        let bands = bands.map_err(|error| Failure::Usage(error.to_string()))?;
        let target = |number: u32| {
            let path = tile(&self.image, TileOfMany { number, n_tiles });
            (path, bands[number as usize - 1])
        };
        Ok(numbers.iter().map(target).collect())
    }

    /// Those of a frame of a sequence: frames that need the same drops, table or air share a file,
    /// because what it depends on is part of its name.
    pub(super) fn of_frame(planned: &PlannedScene, folder: &Path, frame: u32) -> Self {
        let scene = &planned.scene;
        let mut files = Self::of_scene(planned, folder);
        files.image = image(folder, Some(frame));
        if planned.drop_file.is_none() {
            files.drops = named(&files.drops, &hash(canonical_json(&scene.drops)));
        }
        if let Some(need) = &planned.plan.scattering {
            let settings = niji_picture::scattering::settings(need, scene.spectrum);
            files.table = named(&files.table, &hash(settings));
        }
        let orders = planned.plan.scattering_orders();
        files.air = named(
            &files.air,
            &hash(niji_picture::air::settings(scene, orders)),
        );
        files
    }
}

/// `image.exr` as `image.PART.exr`.
fn named(path: &Path, part: &str) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("{part}.{extension}"))
}

/// The start of the hash of some settings.
pub(crate) fn hash(settings: String) -> String {
    let mut hash = Provenance {
        settings,
        ..Provenance::default()
    }
    .request_hash();
    hash.truncate(HASH_DIGITS);
    hash
}
