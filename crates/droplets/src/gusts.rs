//! What turbulence does to a shape that may have none.

use niji_dropfield::DropMode;

use crate::Error;
use crate::Turbulence;

/// Check the parameters of the gusts, if there are any.
pub(crate) fn check(gusts: Option<Turbulence>) -> Result<(), Error> {
    gusts.map_or(Ok(()), |turbulence| turbulence.validate())
}

/// A mode stirred by its gusts; the same mode without gusts.
pub(crate) fn stir(gusts: Option<Turbulence>, mode: DropMode) -> Result<DropMode, Error> {
    match gusts {
        Some(turbulence) => turbulence.stir(mode),
        None => Ok(mode),
    }
}

/// Largest factor by which gusts raise a number density.
pub(crate) fn max_factor(gusts: Option<Turbulence>) -> f64 {
    gusts.map_or(1.0, |turbulence| turbulence.max_factor())
}
