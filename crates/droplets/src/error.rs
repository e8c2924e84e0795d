//! What can be wrong with a shape.

use std::ops::RangeInclusive;

use niji_dropfield::LARGEST_NUMBER_M3;

/// Every failure of this crate.
#[derive(Debug, thiserror::Error)]
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
    /// A size law that does not say how many drops there are.
    #[error("the {law} law needs number_density_m3")]
    NumberDensityMissing {
        /// Name of the law.
        law: &'static str,
    },
    /// A size law that says by itself how many drops there are.
    #[error("the {law} law gives the number density itself: leave number_density_m3 out")]
    NumberDensityFixed {
        /// Name of the law.
        law: &'static str,
    },
    /// Neither, both or only a part of two ways to say the same thing.
    #[error("found {found}, expected either {first} or {second}")]
    EitherOr {
        /// What was found.
        found: &'static str,
        /// The one way, a parameter.
        first: &'static str,
        /// The other way, a parameter or several.
        second: &'static str,
    },
    /// A size law with a wrong parameter.
    #[error("size law")]
    Size(#[from] niji_sizes::Error),
    /// The volume itself.
    #[error("drop volume")]
    Volume(#[from] niji_dropfield::Error),
}

/// Accept a finite number.
pub(crate) fn require_finite(parameter: &'static str, found: f64) -> Result<(), Error> {
    require(found.is_finite(), parameter, found, "a finite number")
}

/// Accept a finite number above zero.
pub(crate) fn require_positive(parameter: &'static str, found: f64) -> Result<(), Error> {
    require(
        found.is_finite() && found > 0.0,
        parameter,
        found,
        "a finite number above 0",
    )
}

/// Accept a finite number not below zero.
pub(crate) fn require_not_negative(parameter: &'static str, found: f64) -> Result<(), Error> {
    require(
        found.is_finite() && found >= 0.0,
        parameter,
        found,
        "a finite number not below 0",
    )
}

/// Accept a number of drops per cubic metre that a volume can hold.
pub(crate) fn require_number_density(parameter: &'static str, found: f64) -> Result<(), Error> {
    let expected = "0 to 1e15 drops per cubic metre";
    require_in(0.0..=LARGEST_NUMBER_M3.into(), parameter, found, expected)
}

/// Accept a number within a range.
pub(crate) fn require_in(
    range: RangeInclusive<f64>,
    parameter: &'static str,
    found: f64,
    expected: &'static str,
) -> Result<(), Error> {
    require(range.contains(&found), parameter, found, expected)
}

fn require(
    sound: bool,
    parameter: &'static str,
    found: f64,
    expected: &'static str,
) -> Result<(), Error> {
    if sound {
        Ok(())
    } else {
        Err(Error::Parameter {
            parameter,
            found,
            expected,
        })
    }
}
