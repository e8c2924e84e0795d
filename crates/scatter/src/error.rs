//! What can be wrong with a request for a scattering table.

use niji_radiometry::Bytes;

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// An axis that is empty, not ascending or outside its range.
    #[error("{axis}: found {found}, expected {expected}")]
    Axis {
        /// Name of the axis.
        axis: &'static str,
        /// What was found.
        found: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A parameter of the drops' motion outside its range.
    #[error("{parameter} = {found}, expected {expected}")]
    Parameter {
        /// Name of the parameter, with its unit.
        parameter: &'static str,
        /// What was found.
        found: f64,
        /// What was expected.
        expected: &'static str,
    },
    /// No order that takes part, one twice or one beyond 7.
    #[error(
        "found orders {found:?}, expected some of 0 to 7, 2 primary and 3 secondary bow, each once"
    )]
    Orders {
        /// The orders asked for.
        found: Vec<u32>,
    },
    /// A table larger than any renderer should hold.
    #[error(
        "found a table of {needed} ({radii} radii x {variances} variances x {wavelengths} \
         wavelengths x {angles} angles, and what moves of flattened drops), expected at most \
         {most}: allow a larger error (table_relative_error in [accuracy], --relative-error), \
         fewer wavelengths ([spectrum], --spectrum), a narrower range of sizes ([drops], \
         --effective-radius-um, --effective-variance) or spheres (drop_flattening = \"off\" in \
         [effects], without --flattened)"
    )]
    TooLarge {
        /// Size of the table.
        needed: Bytes,
        /// Largest size allowed.
        most: Bytes,
        /// Effective radii.
        radii: usize,
        /// Effective variances.
        variances: usize,
        /// Wavelengths.
        wavelengths: usize,
        /// Scattering angles.
        angles: usize,
    },
    /// Water of which nobody measured the index.
    #[error(transparent)]
    Water(niji_radiometry::Error),
    /// A drop that the exact theory refuses.
    #[error("{0}")]
    Drop(String),
    /// A table of Airy's integral that is none.
    #[error("{0}")]
    AiryTable(String),
    /// Whoever watched stopped it.
    #[error("stopped")]
    Stopped,
}

impl From<niji_sizes::Error> for Error {
    fn from(error: niji_sizes::Error) -> Self {
        Self::Drop(error.to_string())
    }
}

impl From<niji_mie::Error> for Error {
    fn from(error: niji_mie::Error) -> Self {
        Self::Drop(error.to_string())
    }
}
