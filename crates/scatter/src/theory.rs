//! Theories of scattering by one drop, from the cheapest to the exact one.

use niji_airy::AiryForm;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::bow_light::BowTheory;

/// Primary and secondary bow.
pub(crate) const MOVED_ORDERS: [u32; 2] = [2, 3];

/// How a drop scatters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Theory {
    /// Color by angle: 40 to 43 degrees of the bow mapped to the spectrum, as published.
    GeometricPublished,
    /// Rays of geometric optics: no supernumeraries, no dependence on size.
    Geometric,
    /// Airy's theory as I = f² M², without the factor a λ: for comparison with publications.
    AiryPublished,
    /// Airy's theory, absolute.
    Airy,
    /// The uniform approximation of Chester, Friedman and Ursell.
    Uniform,
    /// Debye orders of the exact solution, added without interference.
    Debye {
        /// Highest order that takes part.
        #[schemars(range(min = 2, max = 7))]
        max_order: u32,
    },
    /// The exact solution of Lorenz and Mie.
    Mie,
    /// The exact solution for small drops and the uniform approximation for large ones, as the tolerance
    /// asks for.
    BySize,
}

impl Theory {
    /// The name it has in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::GeometricPublished => "geometric-published",
            Self::Geometric => "geometric",
            Self::AiryPublished => "airy-published",
            Self::Airy => "airy",
            Self::Uniform => "uniform",
            Self::Debye { .. } => "debye",
            Self::Mie => "mie",
            Self::BySize => "by-size",
        }
    }

    /// Does it need the table of Airy's integral?
    #[must_use]
    pub fn uses_airy_table(self) -> bool {
        match self {
            Self::AiryPublished | Self::Airy | Self::Uniform | Self::BySize => true,
            Self::GeometricPublished | Self::Geometric | Self::Debye { .. } | Self::Mie => false,
        }
    }

    /// Has a table light of orders that nobody asked for, which cannot be taken out of it?
    #[must_use]
    pub fn holds_every_order(self) -> bool {
        match self {
            Self::Mie | Self::BySize => true,
            Self::GeometricPublished
            | Self::Geometric
            | Self::AiryPublished
            | Self::Airy
            | Self::Uniform
            | Self::Debye { .. } => false,
        }
    }

    /// Is it the same whatever orders are asked for?
    #[must_use]
    pub fn ignores_orders(self) -> bool {
        self.holds_every_order() && self.bow_theory().is_none()
    }

    /// Largest step of ln r between single sizes that are summed to laws, for an error of the bow's peak: 5.3 %
    /// at 0.5 % where small drops are exact, any otherwise. Sums over steps echo waves of the radius whose
    /// period is a step: at 10 % the glory of a law of 5 µm is off by 0.9 % of the peak (rms), at 5.3 % by 0.4.
    pub fn widest_bin(self, tolerance: f64) -> f64 {
        if self.is_exact() {
            0.053 * (tolerance / 5e-3).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// Are drops made of partial waves, small ones at least, so that there are diffraction and glory?
    #[must_use]
    pub fn is_exact(self) -> bool {
        match self {
            Self::Debye { .. } | Self::Mie | Self::BySize => true,
            Self::GeometricPublished
            | Self::Geometric
            | Self::AiryPublished
            | Self::Airy
            | Self::Uniform => false,
        }
    }

    /// The orders it has among `orders`.
    #[must_use]
    pub fn orders_among(self, orders: &[u32]) -> Vec<u32> {
        let is_in = |p: &u32| match self {
            Self::Debye { max_order } => *p <= max_order,
            Self::GeometricPublished => *p == 2,
            Self::Geometric
            | Self::AiryPublished
            | Self::Airy
            | Self::Uniform
            | Self::Mie
            | Self::BySize => true,
        };
        orders.iter().copied().filter(is_in).collect()
    }

    /// The orders whose light a table of flattened drops keeps apart: both bows, which the exact solution
    /// has whatever is asked for. Bows of higher orders are too faint to be seen where drops are large,
    /// and stay.
    #[must_use]
    pub fn moved_orders(self, orders: &[u32]) -> Vec<u32> {
        let orders = self.orders_among(orders);
        let is_in = |p: &u32| self.ignores_orders() || orders.contains(p);
        MOVED_ORDERS.into_iter().filter(is_in).collect()
    }

    /// The theory of its bows; `None` where all drops are computed one after the other.
    pub(crate) fn bow_theory(self) -> Option<BowTheory> {
        match self {
            Self::GeometricPublished => Some(BowTheory::Colors),
            Self::Geometric => Some(BowTheory::Geometric),
            Self::AiryPublished => Some(BowTheory::Airy(AiryForm::Published)),
            Self::Airy => Some(BowTheory::Airy(AiryForm::Absolute)),
            Self::Uniform | Self::BySize => Some(BowTheory::Uniform),
            Self::Debye { .. } | Self::Mie => None,
        }
    }
}
