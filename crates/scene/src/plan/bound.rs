//! What a bound says, and how sure it is.

use std::fmt;

use crate::figures::brief;

/// A bound on the contribution of an effect.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bound {
    /// Largest change of luminance of any pixel, over that of display white.
    pub value: f64,
    /// RMS of that change over the picture; never above `value`.
    pub rms: f64,
    /// How sure it is.
    pub kind: BoundKind,
}

/// How sure a bound is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BoundKind {
    /// It follows from the equations that are rendered; the change is never larger.
    Proved,
    /// It follows from a simpler model of what is left out.
    Estimated,
    /// It is the difference of two coarse tables.
    TableDifference,
    /// It was measured on a small picture of the scene.
    Measured,
}

impl fmt::Display for Bound {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("<= {} {}", brief(self.value), self.kind.name());
        out.pad(&text)
    }
}

impl BoundKind {
    /// The kind in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Estimated => "estimated",
            Self::TableDifference => "table difference",
            Self::Measured => "measured",
        }
    }
}

/// The numbers that a bound is made of, at the part of the picture where it is largest.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BoundTerms {
    /// Scattering angles of rays there, degrees.
    pub theta_deg: (f64, f64),
    /// Nearest and farthest drops there, m.
    pub distance_m: Option<(f64, f64)>,
    /// Largest optical depth tau of the drops on a ray there, Q = 1.
    pub optical_depth: f64,
    /// Largest optical depth tau_s of the drops towards the sun, where it enters.
    pub sun_optical_depth: Option<f64>,
    /// Column c of drops that is seen, where it enters.
    pub column: Option<f64>,
    /// Light of a unit of that column, or of what shines, over display white.
    pub light: Option<f64>,
    /// Share of the light that is taken, where it enters.
    pub share: Option<f64>,
}
