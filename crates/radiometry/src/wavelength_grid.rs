//! Equal wavelength bins that touch each other.
//!
//! center_i = first + i step,  edges_i = center_i -+ step/2
//! All in nm. Spectral values on a grid are means over these bins, never point samples: the sun's
//! lines make a point at 400 nm 12 % wrong.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::units::Nanometers;

/// Where the embedded tables begin, nm.
const MIN_NM: f64 = 300.0;
/// Where the embedded tables end, nm.
const MAX_NM: f64 = 1000.0;
/// More bins than a step of 0.1 nm over the whole range.
const MAX_WAVELENGTHS: usize = 8192;
/// Rounding that an edge may have beyond the range, nm.
const EDGE_TOLERANCE_NM: f64 = 1e-9;

/// Equal, adjacent wavelength bins within 300 to 1000 nm.
///
/// ```
/// use niji_radiometry::{Nanometers, WavelengthGrid};
///
/// let grid = WavelengthGrid::new(400.0, 50.0, 7)?;
/// assert_eq!(grid.center(3), Nanometers(550.0));
/// assert_eq!(grid.edges(3), (Nanometers(525.0), Nanometers(575.0)));
/// # Ok::<(), niji_radiometry::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "Spectrum", into = "Spectrum")]
#[schemars(
    rename = "Spectrum",
    description = "The section `[spectrum]`: 380 to 780 nm by 10 nm where it is left out."
)]
pub struct WavelengthGrid {
    first_nm: f64,
    step_nm: f64,
    n_wavelengths: usize,
}

/// A grid as files have it, not yet checked.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Spectrum {
    /// Center of the first bin, nm.
    #[schemars(extend("exclusiveMinimum" = 300.0, "exclusiveMaximum" = 1000.0))]
    first_nm: f64,
    /// Width of a bin, nm.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 700.0))]
    step_nm: f64,
    /// Number of bins.
    #[schemars(range(min = 1, max = 8192))]
    n_wavelengths: usize,
}

impl TryFrom<Spectrum> for WavelengthGrid {
    type Error = Error;

    fn try_from(spectrum: Spectrum) -> Result<Self, Error> {
        Self::new(spectrum.first_nm, spectrum.step_nm, spectrum.n_wavelengths)
    }
}

impl From<WavelengthGrid> for Spectrum {
    fn from(grid: WavelengthGrid) -> Self {
        Self {
            first_nm: grid.first_nm,
            step_nm: grid.step_nm,
            n_wavelengths: grid.n_wavelengths,
        }
    }
}

impl WavelengthGrid {
    /// Bins of width `step_nm` around `first_nm`, `first_nm + step_nm`, and so on.
    ///
    /// # Errors
    /// If the step is no positive number, the number of bins is 0 or above 8192, or a bin reaches
    /// outside 300 to 1000 nm.
    pub fn new(first_nm: f64, step_nm: f64, n_wavelengths: usize) -> Result<Self, Error> {
        if !(step_nm > 0.0 && step_nm.is_finite()) {
            return Err(Error::GridStep { step_nm });
        }
        if n_wavelengths == 0 || n_wavelengths > MAX_WAVELENGTHS {
            return Err(Error::GridSize {
                n_wavelengths,
                max: MAX_WAVELENGTHS,
            });
        }
        let grid = Self {
            first_nm,
            step_nm,
            n_wavelengths,
        };
        let first_edge_nm = grid.edges(0).0.0;
        let last_edge_nm = grid.edges(n_wavelengths - 1).1.0;
        let is_inside = first_edge_nm >= MIN_NM - EDGE_TOLERANCE_NM
            && last_edge_nm <= MAX_NM + EDGE_TOLERANCE_NM;
        if !is_inside {
            return Err(Error::GridOutsideTables {
                first_edge_nm,
                last_edge_nm,
                min_nm: MIN_NM,
                max_nm: MAX_NM,
            });
        }
        Ok(grid)
    }

    /// The usual 41 wavelengths: 380 to 780 nm by 10 nm.
    pub fn visible() -> Self {
        Self {
            first_nm: 380.0,
            step_nm: 10.0,
            n_wavelengths: 41,
        }
    }

    /// The same band in as many bins at most.
    #[must_use]
    pub fn in_wider_bins(self, most: usize) -> Self {
        let n_wavelengths = self.n_wavelengths.min(most).max(1);
        let step_nm = self.step_nm * self.n_wavelengths as f64 / n_wavelengths as f64;
        Self {
            first_nm: self.first_nm + 0.5 * (step_nm - self.step_nm),
            step_nm,
            n_wavelengths,
        }
    }

    /// Center of the first bin, nm.
    pub fn first_nm(&self) -> f64 {
        self.first_nm
    }

    /// Width of a bin and distance between centers, nm.
    pub fn step_nm(&self) -> f64 {
        self.step_nm
    }

    /// Number of bins, at least 1.
    // A grid is never empty, so `is_empty` would be a constant.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.n_wavelengths
    }

    /// Center of bin `index`.
    pub fn center(&self, index: usize) -> Nanometers {
        Nanometers(self.first_nm + index as f64 * self.step_nm)
    }

    /// Lower and upper edge of bin `index`; the upper edge is the lower one of the next bin.
    pub fn edges(&self, index: usize) -> (Nanometers, Nanometers) {
        let edge = |i: f64| Nanometers(self.first_nm + (i - 0.5) * self.step_nm);
        (edge(index as f64), edge(index as f64 + 1.0))
    }

    /// Centers of all bins, in increasing order.
    pub fn centers(&self) -> impl ExactSizeIterator<Item = Nanometers> + use<> {
        let grid = *self;
        (0..grid.n_wavelengths).map(move |index| grid.center(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_visible_grid_has_41_bins_from_380_to_780_nm() {
        let grid = WavelengthGrid::visible();
        assert_eq!(grid, WavelengthGrid::new(380.0, 10.0, 41).unwrap());
        assert_eq!(grid.centers().len(), 41);
        assert_eq!(grid.center(0), Nanometers(380.0));
        assert_eq!(grid.center(40), Nanometers(780.0));
    }

    #[test]
    fn bins_touch_without_gap_or_overlap() {
        let grid = WavelengthGrid::new(400.3, 3.7, 80).unwrap();
        for index in 1..grid.len() {
            assert_eq!(grid.edges(index - 1).1, grid.edges(index).0);
        }
    }

    #[test]
    fn a_grid_may_fill_the_tables_and_not_more() {
        assert!(WavelengthGrid::new(305.0, 10.0, 70).is_ok());
        assert!(WavelengthGrid::new(300.0, 10.0, 70).is_err());
        assert!(WavelengthGrid::new(305.0, 10.0, 71).is_err());
        assert!(WavelengthGrid::new(300.05, 0.1, 7000).is_ok());
    }

    #[test]
    fn senseless_grids_are_errors() {
        assert!(matches!(
            WavelengthGrid::new(400.0, 0.0, 4),
            Err(Error::GridStep { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(400.0, f64::NAN, 4),
            Err(Error::GridStep { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(400.0, -5.0, 4),
            Err(Error::GridStep { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(400.0, 1.0, 0),
            Err(Error::GridSize { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(400.0, 1e-9, 1 << 40),
            Err(Error::GridSize { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(f64::NAN, 1.0, 4),
            Err(Error::GridOutsideTables { .. })
        ));
        assert!(matches!(
            WavelengthGrid::new(f64::INFINITY, 1.0, 4),
            Err(Error::GridOutsideTables { .. })
        ));
    }
}
