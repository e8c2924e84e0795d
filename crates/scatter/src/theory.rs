//! Theories of scattering by one drop, from the cheapest to the exact one.

use serde::Deserialize;
use serde::Serialize;

/// How a drop scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theory {
    /// Rays of geometric optics: no supernumeraries, no dependence on size.
    Geometric,
    /// Airy's theory as I = f² M², without the factor a λ: for comparison with publications.
    AiryPublished,
    /// Airy's theory, absolute.
    Airy,
    /// Debye orders of the exact solution, added without interference.
    Debye {
        /// Highest order that takes part.
        max_order: u32,
    },
    /// The exact solution of Lorenz and Mie.
    Mie,
}

impl Theory {
    /// The name it has in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Geometric => "geometric",
            Self::AiryPublished => "airy-published",
            Self::Airy => "airy",
            Self::Debye { .. } => "debye",
            Self::Mie => "mie",
        }
    }

    /// Does it need the table of Airy's integral?
    #[must_use]
    pub fn uses_airy_table(self) -> bool {
        match self {
            Self::AiryPublished | Self::Airy => true,
            Self::Geometric | Self::Debye { .. } | Self::Mie => false,
        }
    }
}
