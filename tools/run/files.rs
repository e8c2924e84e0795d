//! Where the files of a run stand.

use std::path::Path;
use std::path::PathBuf;

use niji_exchange::Provenance;
use niji_scene::canonical_json;

use crate::stages;
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
            image: inside(stages::render::FILE),
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

    /// Those of a frame of a sequence: frames that need the same drops, table or air share a file,
    /// because what it depends on is part of its name.
    pub(super) fn of_frame(planned: &PlannedScene, folder: &Path, frame: u32) -> Self {
        let scene = &planned.scene;
        let mut files = Self::of_scene(planned, folder);
        files.image = named(&files.image, &format!("{frame:04}"));
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
