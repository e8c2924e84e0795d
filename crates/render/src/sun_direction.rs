//! Directions towards the sun, as unit vectors.

use glam::DVec3;

use crate::error::Error;

/// How far the length of a unit vector may be from 1.
pub(crate) const UNIT_TOLERANCE: f64 = 1e-9;

/// A unit vector without NaN.
pub(crate) fn check_sun_direction(found: DVec3) -> Result<(), Error> {
    if (found.length() - 1.0).abs() < UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(Error::SunDirection {
            found: found.to_array(),
        })
    }
}
