//! The stage `drops`: a shape, or a density grid of another program, becomes a drop volume; several of
//! them, and volumes that exist already, become one.

use std::path::Path;
use std::path::PathBuf;

use niji_dropfield::DropVolume;
use niji_droplets::Shape;
use niji_scene::DropSource;
use niji_scene::DropSummary;
use niji_scene::Drops;
use niji_scene::FromVdb;
use niji_scene::canonical_json;
use niji_vdb::Compression;
use niji_vdb::Grid;
use niji_vdb::GridHeader;
use niji_vdb::LEVEL_SET;
use niji_vdb::Tree;
use niji_vdb::VdbFile;

use crate::failure::Failure;
use crate::output;
use crate::plan::quoted;
use crate::progress::Verbosity;
use crate::scene_file::with_causes;
use crate::stages::Done;
use crate::stages::Manner;
use crate::stages::Request;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "drops.vdb";

/// What a drop volume is made from: each part with what its modes are called before their own names,
/// nothing where it is the only one and has no name.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    parts: Vec<(String, Part)>,
}

/// Drops that are laid out together.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// A few numbers.
    Shape(Shape),
    /// A density grid; its path as the program opens it.
    Density(PathBuf, FromVdb),
    /// A drop volume that exists already.
    Volume(PathBuf),
}

impl Source {
    /// Several parts, each under a name.
    pub(crate) fn new(parts: Vec<(String, Part)>) -> Self {
        Self { parts }
    }

    /// A part by itself.
    pub(crate) fn only(part: Part) -> Self {
        Self::new(vec![(String::new(), part)])
    }

    /// What the drops of a scene are made from whose files lie in `folder`; `None` if the volume is
    /// there.
    pub(crate) fn of(drops: &Drops, folder: &Path) -> Option<Self> {
        if drops.file().is_some() {
            return None;
        }
        let populations = drops.populations().iter();
        let parts = populations.map(|it| Part::of(&it.source, folder));
        Some(Self::new(
            drops.mode_names().into_iter().zip(parts).collect(),
        ))
    }

    /// What a plan needs to know of the volume; files are read. What is found in one goes through
    /// `of_file`.
    ///
    /// # Errors
    /// As [`Source::volume`].
    pub(crate) fn summary(
        &self,
        of_file: impl Fn(DropSummary) -> DropSummary,
    ) -> Result<Option<DropSummary>, Failure> {
        let summary = |part: &Part| match part {
            Part::Shape(shape) => Ok(DropSummary::of_shape(shape)),
            Part::Density(..) | Part::Volume(_) => {
                Ok(DropSummary::of_volume(&part.volume()?).map(&of_file))
            }
        };
        let parts = self.parts.iter().map(|(_, part)| summary(part));
        let parts: Vec<Option<DropSummary>> = parts.collect::<Result<_, Failure>>()?;
        Ok(DropSummary::joined(parts.into_iter().flatten()))
    }

    /// The volume itself.
    ///
    /// # Errors
    /// A shape that cannot be; a file that is missing, damaged or has no such grid.
    fn volume(&self) -> Result<DropVolume, Failure> {
        let parts = self.parts.iter();
        let volumes = parts.map(|(name, part)| Ok((name.clone(), part.volume()?)));
        Ok(DropVolume::joined(
            volumes.collect::<Result<Vec<_>, Failure>>()?,
        ))
    }

    /// What the volume depends on besides its input files.
    fn settings(&self, compression: Compression) -> String {
        let is_zipped = compression == Compression::Zip;
        match self.parts.as_slice() {
            // A part by itself is told as before there were several.
            [(name, Part::Shape(shape))] if name.is_empty() => canonical_json(&(shape, is_zipped)),
            [(name, Part::Density(_, density))] if name.is_empty() => {
                canonical_json(&(&density.grid, density.import(), is_zipped))
            }
            parts => {
                let settings = parts.iter().map(|(name, part)| (name, part.settings()));
                canonical_json(&(settings.collect::<Vec<_>>(), is_zipped))
            }
        }
    }

    /// Roles of the input files with their paths.
    fn inputs(&self) -> Vec<(String, &Path)> {
        let files = self.parts.iter().filter_map(|(name, part)| {
            let (role, path) = part.file()?;
            Some((format!("{role} {name}").trim_end().to_owned(), path))
        });
        files.collect()
    }
}

impl Part {
    /// Drops of a scene whose files lie in `folder`.
    pub(crate) fn of(drops: &DropSource, folder: &Path) -> Self {
        match drops {
            DropSource::Shape(shape) => Self::Shape(*shape),
            DropSource::FromVdb(density) => {
                Self::Density(folder.join(&density.file), density.clone())
            }
            DropSource::File(drops) => Self::Volume(folder.join(&drops.file)),
        }
    }

    /// As [`Source::volume`].
    fn volume(&self) -> Result<DropVolume, Failure> {
        match self {
            Self::Shape(shape) => {
                let volume = shape.volume();
                volume.map_err(|error| Failure::Impossible(with_causes(&error)))
            }
            Self::Density(path, density) => {
                let file = VdbFile::read(path).map_err(|error| bad_vdb(path, &error))?;
                let volume = DropVolume::from_density(&file, &density.grid, &density.import());
                volume.map_err(|error| Failure::bad_input(path, with_causes(&error)))
            }
            Self::Volume(path) => read(path),
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

/// Writes a drop volume and says what is in it.
///
/// # Errors
/// As [`Source::volume`]; an output that exists, or a file that cannot be written.
pub(crate) fn make(
    source: &Source,
    compression: Compression,
    to: &Path,
    manner: Manner,
) -> Result<Done, Failure> {
    let inputs = source.inputs();
    let request = Request {
        stage: "drops",
        settings: source.settings(compression),
        inputs: inputs
            .iter()
            .map(|(role, path)| (role.as_str(), *path))
            .collect(),
        outputs: vec![to],
    };
    perform(&request, manner, |provenance| {
        let volume = source.volume()?;
        let file = volume.to_vdb(&provenance.to_text_items());
        let file = file.map_err(|error| match error {
            niji_dropfield::Error::BadModeName { .. } => Failure::Usage(error.to_string()),
            _ => Failure::Failed(error.to_string()),
        })?;
        output::write_file(to, |writer| file.write(writer, compression))?;
        if manner.verbosity > Verbosity::Quiet {
            print_summary(volume);
        }
        Ok(())
    })
}

/// Reads a drop volume.
///
/// # Errors
/// A missing or damaged file, or one that holds no drops of ours; then the message says how to make
/// some of what it holds.
pub(crate) fn read(path: &Path) -> Result<DropVolume, Failure> {
    let is_read = |grid: &GridHeader| DropVolume::reads_grid(&grid.name);
    let file = VdbFile::read_grids(path, is_read).map_err(|error| bad_vdb(path, &error))?;
    DropVolume::from_vdb(&file).map_err(|error| match error {
        niji_dropfield::Error::MissingGrid { ref expected, .. } => no_drops(path, expected),
        _ => Failure::bad_input(path, with_causes(&error)),
    })
}

/// What a file holds instead of drops, and the command that makes drops of it.
fn no_drops(path: &Path, expected: &str) -> Failure {
    let file = match VdbFile::read(path) {
        Ok(file) => file,
        Err(error) => return bad_vdb(path, &error),
    };
    let names: Vec<&str> = file.grids.iter().map(|grid| grid.name.as_str()).collect();
    let scalar: Vec<&str> = file
        .grids
        .iter()
        .filter(|grid| is_density(grid))
        .map(name)
        .collect();
    let choice = match scalar[..] {
        [only] => only,
        _ if scalar.contains(&"density") => "density",
        _ => "NAME",
    };
    let message = format!(
        "no drops in it: expected a grid {expected}, found {}; to make drops of a density grid: \
         niji drops from-vdb {} --grid {} --density-means optical-depth --scale 1 \
         --effective-radius-um 100 -o drops.vdb",
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        },
        quoted(path),
        quoted(Path::new(choice))
    );
    Failure::bad_input(path, message)
}

fn name(grid: &Grid) -> &str {
    &grid.name
}

/// One number a voxel that is no distance.
fn is_density(grid: &Grid) -> bool {
    grid.class != LEVEL_SET && !matches!(grid.tree, Tree::Vec3s(_))
}

/// A VDB file that cannot be read, with the causes in one line.
pub(crate) fn bad_vdb(path: &Path, error: &niji_vdb::Error) -> Failure {
    let mut message = String::new();
    let mut cause: Option<&dyn std::error::Error> = Some(error);
    while let Some(error) = cause {
        if !message.is_empty() {
            message += ": ";
        }
        message += &error.to_string();
        cause = error.source();
    }
    let named = format!("cannot read {}: ", path.display());
    Failure::bad_input(path, message.strip_prefix(&named).unwrap_or(&message))
}

/// Says on standard error how much water and how much extinction there is, and what is unnatural.
fn print_summary(volume: DropVolume) {
    let whole = volume.summary();
    let modes = if volume.modes.len() > 1 {
        volume.modes
    } else {
        Vec::new()
    };
    let (r_low, r_high) = whole.effective_radius_um;
    let [tau_x, tau_y, tau_z] = whole.optical_depth_q1;
    eprintln!(
        "      drops  {} nodes, effective radius {r_low:.4} to {r_high:.4} um",
        whole.n_nodes
    );
    eprintln!(
        "             liquid water {:.3e} g/m3 mean, {:.3e} max; extinction (Q = 2) {:.3e} 1/m max",
        whole.mean_liquid_water_g_m3,
        whole.max_liquid_water_g_m3,
        2.0 * whole.max_extinction_m1_q1
    );
    eprintln!(
        "             optical depth (Q = 2) across x, y, z: {:.3}, {:.3}, {:.3}",
        2.0 * tau_x,
        2.0 * tau_y,
        2.0 * tau_z
    );
    for mode in modes {
        let name = mode.name.clone();
        let mode = DropVolume { modes: vec![mode] }.summary();
        let (r_low, r_high) = mode.effective_radius_um;
        let deepest = mode.optical_depth_q1.into_iter().fold(0.0, f64::max);
        eprintln!(
            "             {name}: {} nodes, {:.3e} g of water, effective radius {r_low:.4} to \
             {r_high:.4} um, optical depth (Q = 2) up to {:.3}",
            mode.n_nodes,
            mode.total_water_g,
            2.0 * deepest
        );
    }
    for warning in &whole.warnings {
        eprintln!("    warning  {warning}");
    }
}
