//! What can be wrong with a wavelength grid, a tabulated spectrum or water.

use crate::water::Water;

/// Bad input to a wavelength grid, a tabulated spectrum or water.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The bins reach outside the range of the embedded tables.
    #[error(
        "wavelength bins from {first_edge_nm} nm to {last_edge_nm} nm found, expected them within \
         {min_nm} nm to {max_nm} nm"
    )]
    GridOutsideTables {
        /// Lower edge of the first bin, nm.
        first_edge_nm: f64,
        /// Upper edge of the last bin, nm.
        last_edge_nm: f64,
        /// Lower end of the tables, nm.
        min_nm: f64,
        /// Upper end of the tables, nm.
        max_nm: f64,
    },
    /// The step between wavelengths is no positive number.
    #[error("wavelength step of {step_nm} nm found, expected a positive number")]
    GridStep {
        /// The step that was found, nm.
        step_nm: f64,
    },
    /// The number of wavelengths is zero or absurd.
    #[error("{n_wavelengths} wavelengths found, expected 1 to {max}")]
    GridSize {
        /// The number that was found.
        n_wavelengths: usize,
        /// The largest number allowed.
        max: usize,
    },
    /// A spectrum has too few points to interpolate.
    #[error("a spectrum of {n_points} points found, expected at least 2")]
    TooFewPoints {
        /// The number that was found.
        n_points: usize,
    },
    /// A point of a spectrum is not finite or its wavelength does not increase.
    #[error(
        "point {index} of a spectrum is ({wavelength_nm} nm, {value}), expected finite numbers and \
         increasing wavelengths"
    )]
    BadPoint {
        /// Index of the point, from 0.
        index: usize,
        /// Wavelength found, nm.
        wavelength_nm: f64,
        /// Value found.
        value: f64,
    },
    /// A column is missing from a CSV table.
    #[error("no column `{column}` in a table with the columns {found}")]
    MissingColumn {
        /// The column that was asked for.
        column: String,
        /// The columns that are there.
        found: String,
    },
    /// A cell of a CSV table is no number.
    #[error("`{text}` found in column `{column}` on line {line}, expected a number")]
    BadNumber {
        /// Line of the text, from 1.
        line: u64,
        /// Name of the column.
        column: String,
        /// What the cell holds.
        text: String,
    },
    /// Water of which nobody measured the index.
    #[error(
        "found water at {found}, expected -20 to 100 degrees Celsius without salt, 0 to 30 degrees \
         Celsius with 0 to 40 per mille"
    )]
    Water {
        /// The water that was found.
        found: Water,
    },
    /// The text is not a CSV table.
    #[error("damaged CSV table: {message}")]
    BadCsv {
        /// What the CSV reader found.
        message: String,
    },
}
