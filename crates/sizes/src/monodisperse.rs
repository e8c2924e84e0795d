//! Drops of a single size.
//!
//! n(r) = delta(r - a),   <r^k> = a^k,   v_e = 0

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::Error;
use crate::SizeMoments;
use crate::error::require_positive;

/// All drops have one radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Monodisperse {
    /// The radius a (um).
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius_um: f64,
}

impl Monodisperse {
    /// Check the radius.
    ///
    /// # Errors
    /// [`Error::Parameter`] if it is not a finite number above 0.
    pub fn validate(&self) -> Result<(), Error> {
        require_positive("radius_um", self.radius_um)
    }

    /// Moments per drop.
    pub fn moments(&self) -> SizeMoments {
        let a = self.radius_um;
        SizeMoments {
            mean_r_um: a,
            mean_r2_um2: a * a,
            mean_r3_um3: a.powi(3),
            effective_variance: 0.0,
        }
    }
}
