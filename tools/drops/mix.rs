//! `niji drops mix`: drop volumes become one, in which the drops of all are there together.

use std::ffi::OsStr;
use std::path::Path;
use std::path::PathBuf;

use clap::Args;
use niji_scene::DropFile;
use niji_scene::DropSource;
use niji_scene::Population;

use crate::failure::Failure;
use niji_picture::VolumePart;
use niji_picture::VolumeSource;

/// Drop volumes that exist already, together as one.
///
/// The modes of each stand behind its name in the new volume: NAME_number_density and so on. Where no
/// NAME= is given, it is that of the file.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  niji drops mix drizzle=small.vdb shower.vdb -o rain.vdb")]
pub(super) struct MixCommand {
    /// The volumes, each with a name before its modes.
    #[arg(required = true, value_name = "[NAME=]VDB")]
    volumes: Vec<String>,
}

impl MixCommand {
    /// What is to be made.
    ///
    /// # Errors
    /// A name that no grid should have.
    pub(super) fn source(&self) -> Result<VolumeSource, Failure> {
        let parts = self.volumes.iter().map(|text| named(text));
        Ok(VolumeSource::new(parts.collect::<Result<_, _>>()?))
    }
}

/// A volume with its name, as `NAME=VDB` or `VDB`.
fn named(text: &str) -> Result<(String, VolumePart), Failure> {
    let is_name = |part: &str| !part.contains(std::path::is_separator);
    let given = text.split_once('=').filter(|(name, _)| is_name(name));
    let of_file = || Path::new(text).file_stem().and_then(OsStr::to_str);
    let (name, path) = given.unwrap_or_else(|| (of_file().unwrap_or_default(), text));
    let population = Population {
        name: Some(name.to_owned()),
        source: DropSource::File(DropFile {
            file: path.to_owned(),
        }),
    };
    match population.name_fault() {
        None => Ok((name.to_owned(), VolumePart::Volume(PathBuf::from(path)))),
        Some(expected) => Err(Failure::Usage(format!(
            "the name of the drops of {path} is {name:?}, expected {expected}: say it as NAME={path}"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(text: &str) -> Option<String> {
        named(text).ok().map(|(name, _)| name)
    }

    #[test]
    fn volumes_are_called_as_is_said_or_as_their_files() {
        for (text, expected) in [
            ("a=b.vdb", Some("a")),
            ("runs/fine.vdb", Some("fine")),
            ("runs=2/fine.vdb", Some("runs")),
            ("runs/r=2/fine.vdb", Some("fine")),
            ("a=runs/r=2.vdb", Some("a")),
            ("drops.0001.vdb", None),
            ("=b.vdb", None),
            ("number=b.vdb", None),
            ("", None),
        ] {
            assert_eq!(name(text).as_deref(), expected, "{text}");
        }
    }
}
