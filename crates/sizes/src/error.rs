//! What can be wrong with a size law.

/// Every failure of this crate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter outside its range.
    #[error("{parameter} = {found}, expected {expected}")]
    Parameter {
        /// Name of the parameter, with its unit.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// A range outside what is possible.
    #[error("{parameter}: found {min} to {max}, expected {expected}")]
    Range {
        /// Name of the range, with its unit.
        parameter: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
        /// What would have been right.
        expected: &'static str,
    },
    /// A range whose ends are not in ascending order.
    #[error("{parameter}: the upper end {max} is not above the lower end {min}")]
    EmptyRange {
        /// Name of the range, with its unit.
        parameter: &'static str,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// A Rosin-Rammler law with infinitely many drops.
    #[error(
        "spread = {spread} has infinitely many small drops: expected d_min_mm, or a spread above 3"
    )]
    NumberDiverges {
        /// The spread n.
        spread: f64,
    },
    /// A Rosin-Rammler law whose drops have infinite area, hence infinite extinction.
    #[error("spread = {spread} has infinite extinction: expected d_min_mm, or a spread above 3")]
    AreaDiverges {
        /// The spread n.
        spread: f64,
    },
}

/// Accept a finite number above zero.
pub(crate) fn require_positive(parameter: &'static str, found: f64) -> Result<(), Error> {
    if found.is_finite() && found > 0.0 {
        return Ok(());
    }
    Err(Error::Parameter {
        parameter,
        found,
        expected: "a finite number above 0",
    })
}

/// Accept a finite number not below zero.
pub(crate) fn require_not_negative(parameter: &'static str, found: f64) -> Result<(), Error> {
    if found.is_finite() && found >= 0.0 {
        return Ok(());
    }
    Err(Error::Parameter {
        parameter,
        found,
        expected: "a finite number not below 0",
    })
}
