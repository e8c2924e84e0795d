//! The table of Airy's integral as a file: one row over z with the channels `f` and `dfdz`.

use ndarray::Array2;
use niji_airy::AiryTable;
use niji_exchange::Attributes;
use niji_exchange::Axis;
use niji_exchange::Channel;
use niji_exchange::Provenance;
use niji_exchange::TableFile;
use niji_exchange::TablePart;

use crate::error::Error;

/// What the file says it holds.
const QUANTITY: &str = "airy";

/// The table as a file. f32 keeps seven digits of every value, small ones in the dark included.
#[must_use]
pub fn airy_to_file(table: &AiryTable, provenance: Provenance) -> TableFile {
    let channel = |name: &str, values: &[f64]| Channel {
        name: name.to_owned(),
        values: Array2::from_shape_fn((1, values.len()), |(_, index)| values[index] as f32),
    };
    let part = TablePart {
        name: QUANTITY.to_owned(),
        column_axis: Axis::new("z", "-", table.z.clone()),
        row_axes: Vec::new(),
        channels: vec![channel("f", &table.f), channel("dfdz", &table.dfdz)],
        attributes: Attributes::new(),
    };
    TableFile {
        quantity: QUANTITY.to_owned(),
        parts: vec![part],
        provenance,
    }
}

/// Reads the table from a file.
///
/// # Errors
/// A table of another quantity, or nodes that the look-up does not know.
pub fn airy_from_file(file: &TableFile) -> Result<AiryTable, Error> {
    let wrong = |error: &dyn std::fmt::Display| Error::AiryTable(error.to_string());
    file.expect_quantity(QUANTITY)
        .map_err(|error| wrong(&error))?;
    let part = file.part(QUANTITY).map_err(|error| wrong(&error))?;
    let column = |name| -> Result<Vec<f64>, Error> {
        let values = part.channel(name).map_err(|error| wrong(&error))?;
        Ok(values.iter().map(|&value| f64::from(value)).collect())
    };
    AiryTable::from_nodes(
        part.column_axis.values.clone(),
        column("f")?,
        column("dfdz")?,
    )
    .map_err(|error| wrong(&error))
}
