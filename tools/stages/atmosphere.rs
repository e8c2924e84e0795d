//! The stage `atmosphere`: the section `[air]` of a scene becomes a table.

use std::path::Path;

use niji_atmosphere::ScatteringOrders;
use niji_exchange::AtmosphereTable;
use niji_exchange::TableFile;
use niji_picture::air;
use niji_picture::unwatched;
use niji_scene::Scene;

use crate::failure::Failure;
use crate::output;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "atmosphere.exr";

/// Writes the table of a scene's air.
///
/// # Errors
/// A scene in a vacuum, an output that exists, or a file that cannot be written.
pub(crate) fn make(
    (scene, orders): (&Scene, Option<ScatteringOrders>),
    to: &Path,
    options: StageOptions,
) -> Result<Done, Failure> {
    let request = Request {
        stage: "atmosphere",
        settings: air::settings(scene, orders),
        inputs: Vec::new(),
        outputs: vec![to],
    };
    perform(&request, options, |provenance| {
        let vacuum =
            || Failure::Usage("the scene has no section [air]: it lies in a vacuum".to_owned());
        let file = air::table(scene, orders, &unwatched)?
            .ok_or_else(vacuum)?
            .to_file(provenance);
        output::write_file(to, |writer| file.write(writer))
    })
}

/// Reads a table of the air.
///
/// # Errors
/// A missing or damaged file, or one that holds something else.
pub(crate) fn read(path: &Path) -> Result<AtmosphereTable, Failure> {
    let file = TableFile::read(path).map_err(|error| Failure::bad_input(path, error))?;
    AtmosphereTable::from_file(&file).map_err(|error| Failure::bad_input(path, error))
}
