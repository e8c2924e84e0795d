//! The stage `airy`: Airy's integral becomes a table.

use std::path::Path;

use niji_airy::AiryTable;
use niji_exchange::TableFile;
use niji_scatter::airy_from_file;
use niji_scatter::airy_to_file;

use crate::failure::Failure;
use crate::output;
use crate::stages::Done;
use crate::stages::Request;
use crate::stages::StageOptions;
use crate::stages::perform;

/// Name of the file in the folder of a run.
pub(crate) const FILE: &str = "airy.exr";

/// Writes the table of f(z).
///
/// # Errors
/// An output that exists, or a file that cannot be written.
pub(crate) fn make(to: &Path, options: StageOptions) -> Result<Done, Failure> {
    let settings = "{}".to_owned();
    let request = Request {
        stage: "airy",
        settings,
        inputs: Vec::new(),
        outputs: vec![to],
    };
    perform(&request, options, |provenance| {
        let file = airy_to_file(&AiryTable::compute(), provenance);
        output::write_file(to, |writer| file.write(writer))
    })
}

/// Reads a table of f(z).
///
/// # Errors
/// A missing or damaged file, or one that holds something else.
pub(crate) fn read(path: &Path) -> Result<AiryTable, Failure> {
    let file = TableFile::read(path).map_err(|error| Failure::bad_input(path, error))?;
    airy_from_file(&file).map_err(|error| Failure::bad_input(path, error))
}
