//! Theories by the name they have on the command line.

use clap::ValueEnum;
use niji_scatter::Theory;

/// Orders that the Debye series takes unless a scene says otherwise.
const DEBYE_MAX_ORDER: u32 = 7;

/// The theories of scattering by one drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TheoryName {
    /// Bow angles of 40 to 43 degrees mapped to the spectrum.
    GeometricPublished,
    /// Rays: cheapest, no supernumeraries.
    Geometric,
    /// Airy as I = f^2 M^2, without the factor a lambda.
    AiryPublished,
    /// Airy, absolute.
    Airy,
    /// Chester, Friedman and Ursell: cheap as Airy, several times nearer to the exact order.
    Uniform,
    /// Lorenz-Mie for small drops, uniform for large ones, as --relative-error asks for.
    BySize,
    /// Debye orders without interference, exact each.
    Debye,
    /// Lorenz-Mie, exact.
    Mie,
}

impl From<TheoryName> for Theory {
    fn from(name: TheoryName) -> Self {
        match name {
            TheoryName::GeometricPublished => Self::GeometricPublished,
            TheoryName::Geometric => Self::Geometric,
            TheoryName::AiryPublished => Self::AiryPublished,
            TheoryName::Airy => Self::Airy,
            TheoryName::Uniform => Self::Uniform,
            TheoryName::BySize => Self::BySize,
            TheoryName::Debye => Self::Debye {
                max_order: DEBYE_MAX_ORDER,
            },
            TheoryName::Mie => Self::Mie,
        }
    }
}
