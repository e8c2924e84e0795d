//! Drop volumes: of a shape, of a density grid of another program, of a file; several of them as one.

use std::path::Path;
use std::path::PathBuf;

use niji_dropfield::DropVolume;
use niji_droplets::Shape;
use niji_radiometry::memory_limit;
use niji_scene::DropSource;
use niji_scene::DropSummary;
use niji_scene::FromVdb;
use niji_scene::Scene;
use niji_scene::canonical_json;
use niji_vdb::Grid;
use niji_vdb::GridHeader;
use niji_vdb::LEVEL_SET;
use niji_vdb::Tree;
use niji_vdb::VdbFile;

use crate::error::Error;
use crate::error::with_causes;

/// What a drop volume is made from: each part with what its modes are called before their own names,
/// nothing where it is the only one and has no name.
#[derive(Clone, Debug)]
pub struct VolumeSource {
    parts: Vec<(String, VolumePart)>,
}

/// Nodes up to which a volume that was laid out for a plan is kept for the small pictures of it.
const MOST_NODES_KEPT: u64 = 4_000_000;

/// What a plan knows of drops.
#[derive(Clone, Debug)]
pub(crate) struct LaidOut {
    /// Their figures.
    pub(crate) summary: DropSummary,
    /// They themselves, where they are there already.
    pub(crate) volume: Option<DropVolume>,
}

impl LaidOut {
    /// The drops, of this source where they are not there.
    ///
    /// # Errors
    /// As [`VolumeSource::volume`].
    pub(crate) fn volume_of(
        &self,
        source: impl FnOnce() -> Result<DropVolume, Error>,
    ) -> Result<DropVolume, Error> {
        self.volume.clone().map_or_else(source, Ok)
    }
}

/// Drops that are laid out together.
#[derive(Clone, Debug)]
pub enum VolumePart {
    /// A few numbers.
    Shape(Shape),
    /// A density grid; its path as the program opens it.
    Density(PathBuf, FromVdb),
    /// A drop volume that exists already.
    Volume(PathBuf),
}

impl VolumeSource {
    /// Several parts, each under a name.
    pub fn new(parts: Vec<(String, VolumePart)>) -> Self {
        Self { parts }
    }

    /// A part by itself.
    pub fn only(part: VolumePart) -> Self {
        Self::new(vec![(String::new(), part)])
    }

    /// What the drops of a scene are made from whose files lie in `folder`, with the nodes of shapes as far apart as
    /// the scene is seen to need; `None` if the volume is there.
    pub fn of(scene: &Scene, folder: &Path) -> Option<Self> {
        let drops = &scene.drops;
        if drops.file().is_some() {
            return None;
        }
        let populations = drops.populations().iter();
        let parts = populations.map(|it| VolumePart::of(&it.source, folder));
        let source = Self::new(drops.mode_names().into_iter().zip(parts).collect());
        let times = scene.accuracy.drop_spacing.unwrap_or_default().times();
        Some(source.with_nodes_apart(times))
    }

    /// The same with the nodes of its shapes so many times as far apart.
    pub(crate) fn with_nodes_apart(&self, times: f64) -> Self {
        let apart = |part: &VolumePart| match part {
            VolumePart::Shape(shape) => {
                VolumePart::Shape(shape.with_voxel_m(times * shape.voxel_m()))
            }
            file => file.clone(),
        };
        let parts = self.parts.iter();
        let parts = parts.map(|(name, part)| (name.clone(), apart(part)));
        Self::new(parts.collect())
    }

    /// Whether any of it is a shape.
    pub(crate) fn has_shapes(&self) -> bool {
        let mut parts = self.parts.iter();
        parts.any(|(_, part)| matches!(part, VolumePart::Shape(_)))
    }

    /// What a plan needs to know of the volume, and the volume where that has to be there for it and is not large; files
    /// are read. What is found in one whose sizes are its own goes through `of_file`. `None` where there are no drops.
    ///
    /// # Errors
    /// As [`VolumeSource::volume`].
    pub(crate) fn laid_out(
        &self,
        of_file: impl Fn(DropSummary) -> DropSummary,
    ) -> Result<Option<LaidOut>, Error> {
        let laid_out = |part: &VolumePart| {
            if let VolumePart::Shape(shape) = part {
                return Ok::<_, Error>(DropSummary::laid_out(shape).unwrap_or_default());
            }
            let volume = part.volume()?;
            let found = DropSummary::of_volume(&volume);
            let found = match part {
                VolumePart::Volume(_) => found.map(&of_file),
                VolumePart::Shape(_) | VolumePart::Density(..) => found,
            };
            Ok((found, Some(volume)))
        };
        let (mut summaries, mut volumes) = (Vec::new(), Vec::new());
        for (name, part) in &self.parts {
            let (summary, volume) = laid_out(part)?;
            summaries.extend(summary);
            volumes.extend(volume.map(|it| (name.clone(), it)));
        }
        let is_whole = volumes.len() == self.parts.len();
        let with_volume = |summary: DropSummary| LaidOut {
            volume: (is_whole && summary.n_nodes <= MOST_NODES_KEPT)
                .then(|| DropVolume::joined(volumes)),
            summary,
        };
        Ok(DropSummary::joined(summaries).map(with_volume))
    }

    /// Whether some of its water is thrown, of which there may be more than the air holds.
    pub fn is_thrown(&self) -> bool {
        let mut parts = self.parts.iter();
        parts.any(|(_, part)| matches!(part, VolumePart::Shape(shape) if shape.is_thrown()))
    }

    /// The volume itself.
    ///
    /// # Errors
    /// A shape that cannot be; a file that is missing, damaged or has no such grid.
    pub fn volume(&self) -> Result<DropVolume, Error> {
        let parts = self.parts.iter();
        let volumes = parts.map(|(name, part)| Ok((name.clone(), part.volume()?)));
        Ok(DropVolume::joined(
            volumes.collect::<Result<Vec<_>, Error>>()?,
        ))
    }

    /// What the file of the volume, zipped or not, depends on besides its input files, as JSON.
    pub fn settings(&self, is_zipped: bool) -> String {
        match self.parts.as_slice() {
            // A part by itself is told as before there were several.
            [(name, VolumePart::Shape(shape))] if name.is_empty() => {
                canonical_json(&(shape, is_zipped))
            }
            [(name, VolumePart::Density(_, density))] if name.is_empty() => {
                canonical_json(&(&density.grid, density.import(), is_zipped))
            }
            parts => {
                let settings = parts.iter().map(|(name, part)| (name, part.settings()));
                canonical_json(&(settings.collect::<Vec<_>>(), is_zipped))
            }
        }
    }

    /// Roles of the input files with their paths.
    pub fn inputs(&self) -> Vec<(String, &Path)> {
        let files = self.parts.iter().filter_map(|(name, part)| {
            let (role, path) = part.file()?;
            Some((format!("{role} {name}").trim_end().to_owned(), path))
        });
        files.collect()
    }
}

impl VolumePart {
    /// Drops of a scene whose files lie in `folder`.
    pub fn of(drops: &DropSource, folder: &Path) -> Self {
        match drops {
            DropSource::Shape(shape) => Self::Shape(*shape),
            DropSource::FromVdb(density) => {
                Self::Density(folder.join(&density.file), density.clone())
            }
            DropSource::File(drops) => Self::Volume(folder.join(&drops.file)),
        }
    }

    /// Its drops.
    ///
    /// # Errors
    /// As [`VolumeSource::volume`].
    pub fn volume(&self) -> Result<DropVolume, Error> {
        match self {
            Self::Shape(shape) => shape.volume().map_err(Error::Drops),
            Self::Density(path, density) => {
                let file = read_vdb(path, |_| true)?;
                let volume = DropVolume::from_density(&file, &density.grid, &density.import());
                volume.map_err(|error| Error::file(path, with_causes(&error)))
            }
            Self::Volume(path) => read_drops(path),
        }
    }

    /// The role of its input file, and its path.
    fn file(&self) -> Option<(&'static str, &Path)> {
        match self {
            Self::Shape(_) => None,
            Self::Density(path, _) => Some(("density", path)),
            Self::Volume(path) => Some(("drops", path)),
        }
    }

    /// What it depends on besides its input file.
    fn settings(&self) -> String {
        match self {
            Self::Shape(shape) => canonical_json(shape),
            Self::Density(_, density) => canonical_json(&(&density.grid, density.import())),
            Self::Volume(_) => String::new(),
        }
    }
}

/// Reads a drop volume.
///
/// # Errors
/// A missing or damaged file, or one that holds no drops of ours; then the message says how to make
/// some of what it holds.
pub fn read_drops(path: &Path) -> Result<DropVolume, Error> {
    let is_read = |grid: &GridHeader| DropVolume::reads_grid(&grid.name);
    let file = read_vdb(path, is_read)?;
    DropVolume::from_vdb(&file).map_err(|error| match error {
        niji_dropfield::Error::MissingGrid { ref expected, .. } => no_drops(path, expected),
        _ => Error::file(path, with_causes(&error)),
    })
}

/// What a file holds instead of drops.
fn no_drops(path: &Path, expected: &str) -> Error {
    let file = match read_vdb(path, |_| true) {
        Ok(file) => file,
        Err(error) => return error,
    };
    let name = |grid: &Grid| grid.name.clone();
    let densities = file.grids.iter().filter(|grid| is_density(grid));
    Error::NoDrops {
        path: path.to_owned(),
        expected: expected.to_owned(),
        densities: densities.map(name).collect(),
        found: file.grids.iter().map(name).collect(),
    }
}

/// One number a voxel that is no distance.
fn is_density(grid: &Grid) -> bool {
    grid.class != LEVEL_SET && !matches!(grid.tree, Tree::Vec3s(_))
}

/// Reads the grids of a VDB file that are wanted, in as much memory as the content of a file may take.
///
/// # Errors
/// A missing or damaged file, or one that needs more memory.
pub fn read_vdb(path: &Path, wanted: impl Fn(&GridHeader) -> bool) -> Result<VdbFile, Error> {
    let most_bytes = u64::try_from(memory_limit().0).unwrap_or(u64::MAX);
    let file = VdbFile::read_within(path, most_bytes, wanted);
    file.map_err(|error| Error::file(path, with_causes(&error)))
}
