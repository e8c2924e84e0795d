//! What can be wrong with a sphere or an angle.

/// A sphere or an angle that cannot be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The size parameter is not a number in the range that the recurrences hold.
    #[error("size parameter {found} found, expected {min} to {max}")]
    SizeParameter {
        /// The size parameter x that was found.
        found: f64,
        /// The smallest that is computed.
        min: f64,
        /// The largest that is computed.
        max: f64,
    },
    /// The refractive index is not that of a passive medium, or too large.
    #[error(
        "refractive index {n} + {k}i found, expected a real part above 0, an imaginary part of at \
         least 0 and a modulus of at most {max}"
    )]
    RefractiveIndex {
        /// The real part that was found.
        n: f64,
        /// The imaginary part that was found.
        k: f64,
        /// The largest modulus that is computed.
        max: f64,
    },
    /// A scattering angle is not between 0 and 180 degrees.
    #[error("scattering angle number {index} is {found_deg} degrees, expected 0 to 180")]
    Angle {
        /// Index of the angle, from 0.
        index: usize,
        /// The angle that was found, degrees.
        found_deg: f64,
    },
}
