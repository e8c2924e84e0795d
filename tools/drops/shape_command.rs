//! A subcommand for each shape, and one for density grids, with flags from their own fields.

use std::path::Path;

use clap::ArgMatches;
use clap::Command;
use clap::FromArgMatches;
use clap::Subcommand;
use clap::error::ErrorKind;
use niji_droplets::Shape;
use niji_scene::DropSource;
use niji_scene::FromVdb;
use serde_json::json;

use crate::drops::shape_examples;
use crate::failure::Failure;
use crate::schema_flags;
use crate::schema_flags::Flags;
use crate::schema_flags::Variant;
use niji_picture::VolumePart;
use niji_picture::VolumeSource;
use niji_picture::with_causes;

/// A shape and its flags, as they were given.
#[derive(Clone, Debug)]
pub(super) struct ShapeCommand {
    name: String,
    flags: Flags,
    matches: ArgMatches,
}

impl ShapeCommand {
    /// What is to be made, checked.
    ///
    /// # Errors
    /// A flag that is missing, belongs to another variant or is out of range.
    pub(super) fn source(&self) -> Result<VolumeSource, Failure> {
        let value = self.flags.value(&self.matches)?;
        let drops: DropSource = schema_flags::read(json!({ &self.name: value }))?;
        let checked = match &drops {
            DropSource::Shape(shape) => shape.validate(),
            DropSource::FromVdb(density) => density.validate().map_err(Into::into),
            DropSource::File(_) => Ok(()),
        };
        checked.map_err(|error| self.refused(&error))?;
        Ok(VolumeSource::only(VolumePart::of(&drops, Path::new(""))))
    }

    /// What a library says of a parameter, of the flag instead.
    fn refused(&self, error: &niji_droplets::Error) -> Failure {
        // The parts of a shape say themselves which parameter is wrong.
        let message = match error {
            niji_droplets::Error::Size(size) => size.to_string(),
            niji_droplets::Error::Volume(volume) => with_causes(volume),
            _ => with_causes(error),
        };
        Failure::Usage(self.flags.name_flags(&message))
    }
}

/// All shapes and density grids.
fn sources() -> Vec<Variant> {
    let density = Variant {
        name: "from-vdb".to_owned(),
        about: "A density grid that another program made".to_owned(),
        flags: Flags::of::<FromVdb>(),
    };
    let mut sources = schema_flags::variants::<Shape>();
    sources.push(density);
    sources
}

/// Their names.
pub(super) fn names() -> String {
    let names = sources().into_iter().map(|source| source.name);
    names.collect::<Vec<_>>().join(", ")
}

fn command(source: Variant) -> Command {
    let examples = shape_examples::of(&source.name);
    Command::new(source.name)
        .about(source.about)
        .after_help(examples)
        .args(source.flags.arguments())
}

impl Subcommand for ShapeCommand {
    fn augment_subcommands(program: Command) -> Command {
        program.subcommands(sources().into_iter().map(command))
    }

    fn augment_subcommands_for_update(program: Command) -> Command {
        Self::augment_subcommands(program)
    }

    fn has_subcommand(name: &str) -> bool {
        sources().iter().any(|source| source.name == name)
    }
}

impl FromArgMatches for ShapeCommand {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let missing = || clap::Error::raw(ErrorKind::MissingSubcommand, "expected a shape\n");
        let (name, matches) = matches.subcommand().ok_or_else(missing)?;
        let mut sources = sources().into_iter();
        let source = sources.find(|source| source.name == name);
        let source = source.ok_or_else(missing)?;
        Ok(Self {
            name: source.name,
            flags: source.flags,
            matches: matches.clone(),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
