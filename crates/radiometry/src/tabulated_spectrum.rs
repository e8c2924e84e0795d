//! Spectra given by a table, linear in between and constant outside.
//!
//! The mean over a bin is the exact integral of the broken line, divided by the width: nothing is
//! lost between samples, however wide the bin is.

use crate::error::Error;
use crate::piecewise_linear::PiecewiseLinear;
use crate::units::Nanometers;
use crate::wavelength_grid::WavelengthGrid;

/// A broken line over wavelength.
///
/// ```
/// use niji_radiometry::{Nanometers, TabulatedSpectrum};
///
/// let table = "# grass\nwavelength_nm,albedo\n400,0.02\n500,0.06\n600,0.10\n";
/// let albedo = TabulatedSpectrum::from_csv(table, "albedo")?;
/// assert!((albedo.at(Nanometers(450.0)) - 0.04).abs() < 1e-15);
/// assert!((albedo.bin_mean(Nanometers(450.0), Nanometers(550.0)) - 0.06).abs() < 1e-15);
/// # Ok::<(), niji_radiometry::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedSpectrum {
    line: PiecewiseLinear,
}

impl TabulatedSpectrum {
    /// The broken line through (wavelength in nm, value).
    ///
    /// # Errors
    /// If there are fewer than two points, one is not finite, or wavelengths do not increase.
    pub fn from_points(points: &[(f64, f64)]) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::TooFewPoints {
                n_points: points.len(),
            });
        }
        let mut before_nm = f64::NEG_INFINITY;
        for (index, &(wavelength_nm, value)) in points.iter().enumerate() {
            let is_good =
                wavelength_nm > before_nm && wavelength_nm.is_finite() && value.is_finite();
            if !is_good {
                return Err(Error::BadPoint {
                    index,
                    wavelength_nm,
                    value,
                });
            }
            before_nm = wavelength_nm;
        }
        Ok(Self {
            line: PiecewiseLinear::new(points.to_vec()),
        })
    }

    /// Column `column` of a CSV table against its column `wavelength_nm`.
    ///
    /// Lines that begin with `#` are comments; the first other line names the columns.
    ///
    /// # Errors
    /// If a column is missing, a cell is no number, or the points are not those of a spectrum.
    pub fn from_csv(text: &str, column: &str) -> Result<Self, Error> {
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let headers = reader.headers().map_err(|error| bad_csv(&error))?.clone();
        let wavelength_index = column_index(&headers, "wavelength_nm")?;
        let value_index = column_index(&headers, column)?;
        let mut points = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| bad_csv(&error))?;
            let wavelength_nm = number(&record, &headers, wavelength_index)?;
            points.push((wavelength_nm, number(&record, &headers, value_index)?));
        }
        Self::from_points(&points)
    }

    /// The value at one wavelength; outside the table that of its nearest end.
    pub fn at(&self, wavelength: Nanometers) -> f64 {
        self.line.at(wavelength.0)
    }

    /// The mean between two wavelengths, exact for the broken line.
    pub fn bin_mean(&self, lo: Nanometers, hi: Nanometers) -> f64 {
        self.line.mean(lo.0, hi.0)
    }

    /// The means over the bins of a grid.
    pub fn on(&self, grid: &WavelengthGrid) -> Vec<f64> {
        let edges = (0..grid.len()).map(|index| grid.edges(index));
        edges.map(|(lo, hi)| self.bin_mean(lo, hi)).collect()
    }

    /// The points of the broken line: (wavelength in nm, value), at least two.
    pub fn points(&self) -> &[(f64, f64)] {
        self.line.nodes()
    }
}

fn bad_csv(error: &csv::Error) -> Error {
    Error::BadCsv {
        message: error.to_string(),
    }
}

fn column_index(headers: &csv::StringRecord, column: &str) -> Result<usize, Error> {
    headers
        .iter()
        .position(|name| name == column)
        .ok_or_else(|| Error::MissingColumn {
            column: column.to_owned(),
            found: headers.iter().collect::<Vec<_>>().join(", "),
        })
}

fn number(
    record: &csv::StringRecord,
    headers: &csv::StringRecord,
    index: usize,
) -> Result<f64, Error> {
    let text = record.get(index).unwrap_or_default();
    text.parse().map_err(|_| Error::BadNumber {
        line: record.position().map_or(0, csv::Position::line),
        column: headers.get(index).unwrap_or_default().to_owned(),
        text: text.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TENT: [(f64, f64); 3] = [(400.0, 0.0), (500.0, 1.0), (600.0, 0.0)];

    fn tent_mean(lo: f64, hi: f64) -> f64 {
        let tent = TabulatedSpectrum::from_points(&TENT).unwrap();
        tent.bin_mean(Nanometers(lo), Nanometers(hi))
    }

    #[test]
    fn bin_means_are_exact_whatever_the_bin_cuts() {
        // By hand: areas of triangles and trapezoids under the tent.
        for (lo, hi, mean) in [
            (400.0, 600.0, 0.5),
            (450.0, 550.0, 0.75),
            (410.0, 420.0, 0.15),
            (300.0, 700.0, 0.25),
            (100.0, 300.0, 0.0),
            (490.0, 500.0, 0.95),
            (500.0, 510.0, 0.95),
        ] {
            assert!(
                (tent_mean(lo, hi) - mean).abs() <= 1e-15,
                "{lo}..{hi}: {}",
                tent_mean(lo, hi)
            );
        }
    }

    #[test]
    fn a_bin_of_no_width_is_a_point_and_a_reversed_bin_the_same_bin() {
        assert!((tent_mean(430.0, 430.0) - 0.3).abs() <= 1e-15);
        assert!((tent_mean(550.0, 450.0) - 0.75).abs() <= 1e-15);
    }

    #[test]
    fn adjacent_bins_add_up_to_the_whole() {
        let parts: f64 = (0..7)
            .map(|i| tent_mean(390.0 + 31.0 * f64::from(i), 421.0 + 31.0 * f64::from(i)))
            .sum();
        assert!((parts * 31.0 - tent_mean(390.0, 607.0) * 217.0).abs() <= 1e-12);
    }

    #[test]
    fn damaged_tables_are_errors_that_name_the_place() {
        let parse = |text: &str| TabulatedSpectrum::from_csv(text, "value").unwrap_err();
        let missing = parse("wavelength_nm,k\n400,1\n500,2\n");
        assert_eq!(
            missing.to_string(),
            "no column `value` in a table with the columns wavelength_nm, k"
        );
        let bad = parse("# note\nwavelength_nm,value\n400,1\n500,two\n");
        assert_eq!(
            bad.to_string(),
            "`two` found in column `value` on line 4, expected a number"
        );
        assert!(matches!(
            parse("wavelength_nm,value\n400,1\n"),
            Error::TooFewPoints { .. }
        ));
        assert!(matches!(
            parse("wavelength_nm,value\n500,1\n400,2\n"),
            Error::BadPoint { index: 1, .. }
        ));
        assert!(matches!(
            parse("wavelength_nm,value\n400,1\n500,NaN\n"),
            Error::BadPoint { index: 1, .. }
        ));
        assert!(matches!(
            parse("wavelength_nm,value\n400,1\n500\n"),
            Error::BadCsv { .. }
        ));
        assert!(matches!(parse(""), Error::MissingColumn { .. }));
    }
}
