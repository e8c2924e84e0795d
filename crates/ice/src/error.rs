//! What can be wrong with ice or its light.

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting out of its range.
    #[error("`{parameter}` is {found}, expected {expected}")]
    Parameter {
        /// Its name, as in scene files.
        parameter: &'static str,
        /// The value.
        found: f64,
        /// The range.
        expected: &'static str,
    },
    /// A spectrum on other wavelengths than the rest.
    #[error("found {found} values of {what}, expected one for each of {expected} wavelengths")]
    Spectrum {
        /// Which spectrum.
        what: &'static str,
        /// Its values.
        found: usize,
        /// The wavelengths.
        expected: usize,
    },
    /// A spectrum with a value that cannot be.
    #[error("found {found} in {what}, expected finite values of 0 or more")]
    BadSpectrum {
        /// Which spectrum.
        what: &'static str,
        /// The value.
        found: f64,
    },
    /// The mean chord is that of straight lines, which bubbles bend.
    #[error("found bubbles with the transport level mean-chord, expected a path-traced level")]
    BubblesOnMeanChord,
    /// A surface that encloses no body.
    #[error(transparent)]
    Geometry(#[from] niji_geometry::Error),
}

/// Refuses a setting out of `low..=high`, and NaN.
pub(crate) fn check_range(
    parameter: &'static str,
    found: f64,
    [low, high]: [f64; 2],
    expected: &'static str,
) -> Result<(), Error> {
    if (low..=high).contains(&found) {
        return Ok(());
    }
    Err(Error::Parameter {
        parameter,
        found,
        expected,
    })
}
