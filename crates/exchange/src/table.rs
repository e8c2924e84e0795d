//! Tables with axes and units as EXR files.
//!
//! A part is a table over a column axis (the width of the image) and any number of row axes
//! flattened into its height, the last one fastest. Axes stand in the header as decimal text in full
//! precision:
//!
//! * `niji:quantity` what the channels hold, `niji:columns` and `niji:rows` the names of the axes
//! * `niji:axis.NAME` the comma separated values, `niji:unit.NAME` their unit

use std::io::Seek;
use std::io::Write;
use std::path::Path;

use ndarray::Array2;

use crate::attributes;
use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::checksum;
use crate::error::Error;
use crate::exr_read;
use crate::exr_write;
use crate::exr_write::Codec;
use crate::part::Part;
use crate::provenance::Provenance;

/// Name of the attribute that says what a table holds.
const QUANTITY: &str = "niji:quantity";
/// Name of the attribute that names the column axis.
const COLUMNS: &str = "niji:columns";
/// Name of the attribute that names the row axes.
const ROWS: &str = "niji:rows";
/// Start of the names of the attributes that hold the values of an axis.
const AXIS: &str = "niji:axis.";
/// Start of the names of the attributes that hold the unit of an axis.
const UNIT: &str = "niji:unit.";

/// An axis of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Its name, without commas.
    pub name: String,
    /// Its unit, `-` where it has none.
    pub unit: String,
    /// Ascending values.
    pub values: Vec<f64>,
}

/// A named channel of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its values by row and column.
    pub values: Array2<f32>,
}

/// One table of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TablePart {
    /// Name of the part.
    pub name: String,
    /// Axis along the width.
    pub column_axis: Axis,
    /// Axes flattened into the height, the last one fastest; none for a single row.
    pub row_axes: Vec<Axis>,
    /// The values; in the order of their names after reading.
    pub channels: Vec<Channel>,
    /// Everything else in the header.
    pub attributes: Attributes,
}

/// A file of tables.
#[derive(Clone, Debug, PartialEq)]
pub struct TableFile {
    /// What the tables hold.
    pub quantity: String,
    /// The tables, the main one first.
    pub parts: Vec<TablePart>,
    /// Where the file comes from.
    pub provenance: Provenance,
}

impl Axis {
    /// An axis.
    #[must_use]
    pub fn new(name: &str, unit: &str, values: Vec<f64>) -> Self {
        Self {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values,
        }
    }

    fn check(&self) -> Result<(), Error> {
        let problem = if self.name.is_empty() || self.name.contains(',') {
            "found a name that is empty or holds a comma".to_owned()
        } else if self.values.is_empty() {
            "found no values".to_owned()
        } else if let Some(value) = self.values.iter().find(|value| !value.is_finite()) {
            format!("found {value}")
        } else if let Some(at) = self.values.windows(2).position(|pair| pair[1] <= pair[0]) {
            format!("found {} after {}", self.values[at + 1], self.values[at])
        } else {
            return Ok(());
        };
        Err(Error::Axis {
            name: self.name.clone(),
            problem,
        })
    }
}

impl TablePart {
    /// A channel by its name.
    ///
    /// # Errors
    /// If the table has no such channel.
    pub fn channel(&self, name: &str) -> Result<&Array2<f32>, Error> {
        let mut channels = self.channels.iter();
        let channel = channels.find(|channel| channel.name == name);
        let channel = channel.ok_or_else(|| Error::missing("channel", name))?;
        Ok(&channel.values)
    }

    /// Takes a channel out of the table.
    pub(crate) fn take(&mut self, name: &str) -> Result<Array2<f32>, Error> {
        let mut channels = self.channels.iter();
        let index = channels.position(|channel| channel.name == name);
        let index = index.ok_or_else(|| Error::missing("channel", name))?;
        Ok(self.channels.swap_remove(index).values)
    }

    /// A number of the header.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn number(&self, name: &str) -> Result<f64, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Number(number)) => Ok(*number),
            Some(AttributeValue::Text(_)) | None => Err(self.no_attribute(name, "number")),
        }
    }

    /// A text of the header.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn text(&self, name: &str) -> Result<&str, Error> {
        match self.attributes.get(name) {
            Some(AttributeValue::Text(text)) => Ok(text),
            Some(AttributeValue::Number(_)) | None => Err(self.no_attribute(name, "text")),
        }
    }

    /// The row axis `name`.
    ///
    /// # Errors
    /// If the table has no such axis.
    pub fn row_axis(&self, name: &str) -> Result<&Axis, Error> {
        let mut axes = self.row_axes.iter();
        let axis = axes.find(|axis| axis.name == name);
        axis.ok_or_else(|| Error::missing("axis", name))
    }

    /// Refuses a table whose axes are others than these, given as name and unit: the column axis
    /// first, then the row axes from the slowest to the fastest.
    ///
    /// # Errors
    /// If an axis is missing, stands elsewhere, is in another unit, or is one too many.
    pub fn expect_axes(&self, expected: &[(&'static str, &'static str)]) -> Result<(), Error> {
        let axes: Vec<&Axis> = [&self.column_axis]
            .into_iter()
            .chain(&self.row_axes)
            .collect();
        for (index, &(name, unit)) in expected.iter().enumerate() {
            let axis = axes.get(index).filter(|axis| axis.name == name);
            let axis = axis.ok_or_else(|| Error::missing("axis", name))?;
            if axis.unit != unit {
                let (axis, found) = (name.to_owned(), axis.unit.clone());
                return Err(Error::Unit {
                    axis,
                    found,
                    expected: unit,
                });
            }
        }
        if axes.len() == expected.len() {
            return Ok(());
        }
        let what = format!("axes in part {:?}", self.name);
        Err(Error::Shape {
            what,
            found: axes.len(),
            expected: expected.len(),
        })
    }

    fn no_attribute(&self, name: &str, kind: &'static str) -> Error {
        Error::Attribute {
            part: self.name.clone(),
            name: name.to_owned(),
            kind,
        }
    }

    fn check(&self) -> Result<(), Error> {
        let axes: Vec<&Axis> = self.row_axes.iter().chain([&self.column_axis]).collect();
        for (index, axis) in axes.iter().enumerate() {
            axis.check()?;
            if axes[..index]
                .iter()
                .any(|earlier| earlier.name == axis.name)
            {
                return Err(Error::Duplicate {
                    kind: "axis",
                    name: axis.name.clone(),
                });
            }
        }
        // A header may name axes whose product is beyond any number.
        let lengths = self.row_axes.iter().map(|axis| axis.values.len());
        let n_rows = lengths.fold(1, usize::saturating_mul);
        for channel in &self.channels {
            let (found_rows, found_columns) = channel.values.dim();
            let what = |kind| {
                format!(
                    "{kind} in channel {:?} of part {:?}",
                    channel.name, self.name
                )
            };
            if found_rows != n_rows {
                return Err(Error::Shape {
                    what: what("rows"),
                    found: found_rows,
                    expected: n_rows,
                });
            }
            let expected = self.column_axis.values.len();
            if found_columns != expected {
                return Err(Error::Shape {
                    what: what("columns"),
                    found: found_columns,
                    expected,
                });
            }
        }
        Ok(())
    }
}

impl TableFile {
    /// Writes the tables.
    ///
    /// # Errors
    /// An axis that is not ascending, a channel whose size is not that of its axes, a value that is
    /// not finite, or a writer that fails.
    pub fn write(&self, writer: impl Write + Seek) -> Result<(), Error> {
        let mut parts = Vec::with_capacity(self.parts.len());
        for table in &self.parts {
            table.check()?;
            let channels = table
                .channels
                .iter()
                .map(|c| (c.name.clone(), c.values.view().into()));
            let mut part = Part::new(&table.name, channels.collect());
            part.attributes = table.attributes.clone();
            self.describe(table, &mut part.attributes);
            parts.push(part);
        }
        exr_write::write(&parts, Codec::None, writer)
    }

    fn describe(&self, table: &TablePart, header: &mut Attributes) {
        let mut texts = self.provenance.to_text_items();
        let rows: Vec<&str> = table
            .row_axes
            .iter()
            .map(|axis| axis.name.as_str())
            .collect();
        texts.push((QUANTITY.to_owned(), self.quantity.clone()));
        texts.push((COLUMNS.to_owned(), table.column_axis.name.clone()));
        texts.push((ROWS.to_owned(), rows.join(",")));
        for axis in table.row_axes.iter().chain([&table.column_axis]) {
            // The shortest decimal that reads back as the same number.
            let values: Vec<String> = axis.values.iter().map(f64::to_string).collect();
            texts.push((format!("{AXIS}{}", axis.name), values.join(",")));
            texts.push((format!("{UNIT}{}", axis.name), axis.unit.clone()));
        }
        attributes::insert_texts(header, texts);
    }

    /// Reads a file of tables.
    ///
    /// # Errors
    /// A missing, truncated or damaged file, one that holds no tables of ours, one whose axes and
    /// sizes disagree, or one with values that are not finite.
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_parts(exr_read::read_parts(path)?)
    }

    fn from_parts(parts: Vec<Part>) -> Result<Self, Error> {
        let Some(first) = parts.first() else {
            return Err(Error::missing("part", "table"));
        };
        let quantity = first.text(QUANTITY)?.to_owned();
        let provenance =
            Provenance::from_text_items(attributes::texts(&first.attributes)).unwrap_or_default();
        let parts = parts
            .into_iter()
            .map(table_part)
            .collect::<Result<_, _>>()?;
        Ok(Self {
            quantity,
            parts,
            provenance,
        })
    }

    /// Refuses a file that holds something else.
    ///
    /// # Errors
    /// If the quantity is not `expected`.
    pub fn expect_quantity(&self, expected: &'static str) -> Result<(), Error> {
        if self.quantity == expected {
            return Ok(());
        }
        Err(Error::Quantity {
            found: self.quantity.clone(),
            expected,
        })
    }

    /// A part by its name.
    ///
    /// # Errors
    /// If the file has no such part.
    pub fn part(&self, name: &str) -> Result<&TablePart, Error> {
        let mut parts = self.parts.iter();
        let part = parts.find(|part| part.name == name);
        part.ok_or_else(|| Error::missing("part", name))
    }

    /// A part by its name, and the others.
    pub(crate) fn into_part(mut self, name: &str) -> Result<(TablePart, Vec<TablePart>), Error> {
        let index = self.parts.iter().position(|part| part.name == name);
        let index = index.ok_or_else(|| Error::missing("part", name))?;
        let part = self.parts.remove(index);
        Ok((part, self.parts))
    }
}

fn table_part(mut part: Part) -> Result<TablePart, Error> {
    let column_axis = axis(&part, part.text(COLUMNS)?)?;
    let names = part.text(ROWS)?.split(',').filter(|name| !name.is_empty());
    let row_axes = names
        .map(|name| axis(&part, name))
        .collect::<Result<_, _>>()?;
    part.attributes.retain(|name, _| !describes(name));
    let channels = part.channels.into_iter();
    let channels = channels.map(|(name, values)| Channel {
        name,
        values: values.into_owned(),
    });
    let table = TablePart {
        name: part.name,
        column_axis,
        row_axes,
        channels: channels.collect(),
        attributes: part.attributes,
    };
    table.check()?;
    Ok(table)
}

/// Whether an attribute is one that every table has.
fn describes(name: &str) -> bool {
    [QUANTITY, COLUMNS, ROWS, checksum::NAME].contains(&name)
        || name.starts_with(AXIS)
        || name.starts_with(UNIT)
        || Provenance::owns(name)
}

fn axis(part: &Part, name: &str) -> Result<Axis, Error> {
    let text = part.text(&format!("{AXIS}{name}"))?;
    let unit = part.text(&format!("{UNIT}{name}"))?.to_owned();
    let values = text.split(',').map(|entry| {
        entry.parse::<f64>().map_err(|_| {
            let problem = format!("found {entry:?}");
            Error::Axis {
                name: name.to_owned(),
                problem,
            }
        })
    });
    Ok(Axis {
        name: name.to_owned(),
        unit,
        values: values.collect::<Result<_, _>>()?,
    })
}
