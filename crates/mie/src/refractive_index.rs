//! The refractive index of a sphere relative to its surroundings.

use num_complex::Complex64;

use crate::error::Error;

/// The largest modulus that is computed; the recurrences take |m| x steps.
const MAX_MODULUS: f64 = 100.0;

/// n + ik, relative to the surroundings, with k >= 0 where the sphere absorbs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefractiveIndex {
    /// Real part; 1.333 for water in green light.
    pub n: f64,
    /// Imaginary part, 0 without absorption.
    pub k: f64,
}

impl RefractiveIndex {
    pub(crate) fn checked(self) -> Result<Complex64, Error> {
        let Self { n, k } = self;
        let m = Complex64::new(n, k);
        if n > 0.0 && k >= 0.0 && m.norm() <= MAX_MODULUS {
            Ok(m)
        } else {
            Err(Error::RefractiveIndex {
                n,
                k,
                max: MAX_MODULUS,
            })
        }
    }
}

impl From<f64> for RefractiveIndex {
    /// An index without absorption.
    fn from(n: f64) -> Self {
        Self { n, k: 0.0 }
    }
}
