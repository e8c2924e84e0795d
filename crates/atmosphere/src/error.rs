//! What can be wrong with a description of air.

/// Air that cannot exist, or a grid that cannot be tabulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A number that must be positive is not.
    #[error("{what} of {value} {unit} found, expected a positive number")]
    NotPositive {
        /// What the number is.
        what: &'static str,
        /// The number found.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A number outside its range.
    #[error("{what} of {value} found, expected {least} to {most}")]
    OutOfRange {
        /// What the number is.
        what: &'static str,
        /// The number found.
        value: f64,
        /// Smallest allowed.
        least: f64,
        /// Largest allowed.
        most: f64,
    },
    /// Two constituents share a name.
    #[error("two constituents named {name:?} found, expected each name once")]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// A name that cannot stand in a file.
    #[error("constituent named {name:?} found, expected a name without commas")]
    Name {
        /// The name.
        name: String,
    },
    /// A density profile that does not rise in height or has a density no air can have.
    #[error("density profile: {problem}")]
    Profile {
        /// What is wrong.
        problem: String,
    },
    /// The visibility leaves no room for an aerosol: clean air is already as dim.
    #[error(
        "visibility of {visibility_m} m found, expected less than {clean_air_m:.0} m: that far is \
         seen in air without any aerosol"
    )]
    TooClear {
        /// The visibility found, m.
        visibility_m: f64,
        /// Visibility in air without aerosol, m.
        clean_air_m: f64,
    },
    /// Multiple scattering is wanted from a table without it.
    #[error(
        "found no diffuse light in the atmosphere table, or none that fits its air, expected a table \
         made with multiple scattering"
    )]
    NoDiffuseLight,
}

/// `value`, if it is a positive number.
pub(crate) fn positive(what: &'static str, value: f64, unit: &'static str) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Error::NotPositive { what, value, unit })
}

/// `value`, if it lies within `least` to `most`.
pub(crate) fn within(
    what: &'static str,
    value: f64,
    [least, most]: [f64; 2],
) -> Result<f64, Error> {
    if value >= least && value <= most {
        return Ok(value);
    }
    Err(Error::OutOfRange {
        what,
        value,
        least,
        most,
    })
}
