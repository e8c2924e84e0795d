//! Theories of scattering by one drop, from the cheapest to the exact one.
//!
//! A new one is a variant of [`Theory`] with its description in `Theory::method`, here; the formulas of its bows in
//! `bow_light`, or of single drops in `drop_theory`; and a name on the command line.

use std::ops::RangeInclusive;

use niji_airy::AiryForm;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::bow_light::BowTheory;
use crate::drop_theory::MOVED_ORDERS;
use crate::drop_theory::Solution;

/// Orders of a table.
pub(crate) const ORDERS: RangeInclusive<u32> = 0..=7;

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

/// What a theory consists of. Everything that depends on the theory follows from it.
///
/// A theory has bows, the light of each order of all drops at once, or computes drops one after the other; with
/// both, single drops are the small ones and bows those of the large ones ([`crate::by_size`]).
pub(crate) struct Method {
    /// In files and on the command line.
    name: &'static str,
    /// Those that it has.
    orders: RangeInclusive<u32>,
    pub(crate) bows: Option<BowTheory>,
    pub(crate) drops: Option<SingleDrops>,
}

/// How drops are computed one after the other. Against 3 to 8 times as many sizes and twice as many angles, 0.25
/// to 0.83 mm at 550 nm, 118 to 145 degrees, rms and maximum in parts of the peak: exact solution 7e-4 and 2.6e-3
/// for v_e = 1/3, 1.6e-3 and 9e-3 for single sizes (what is left of the ripple); Debye orders 4e-4 and 2e-3.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingleDrops {
    pub(crate) solution: Solution,
    /// Steps of the angle across the sun's disc, at least and at most.
    pub(crate) steps_per_disc: [f64; 2],
    /// Grids of angles that large drops take in turn.
    pub(crate) n_shifts: usize,
}

const LORENZ_MIE: SingleDrops = SingleDrops {
    solution: Solution::LorenzMie,
    steps_per_disc: [24.0, 24.0],
    n_shifts: 16,
};
/// The largest have 2π/x to two steps, and the sun's disc leaves little of their ripple.
const SMALL_DROPS: SingleDrops = SingleDrops {
    steps_per_disc: [12.0, 24.0],
    n_shifts: 8,
    ..LORENZ_MIE
};
const DEBYE: SingleDrops = SingleDrops {
    solution: Solution::Debye,
    steps_per_disc: [16.0, 16.0],
    n_shifts: 4,
};

impl Theory {
    /// What [`Self::BySize`] makes small drops and large ones with.
    pub const SMALL_AND_LARGE: [Self; 2] = [Self::Mie, Self::Uniform];

    /// The only place that tells theories apart.
    pub(crate) fn method(self) -> Method {
        let method = |name, bows, drops| Method {
            name,
            orders: ORDERS,
            bows,
            drops,
        };
        let [airy, published] = [AiryForm::Absolute, AiryForm::Published].map(BowTheory::Airy);
        match self {
            Self::GeometricPublished => Method {
                orders: 2..=2,
                ..method("geometric-published", Some(BowTheory::Colors), None)
            },
            Self::Geometric => method("geometric", Some(BowTheory::Geometric), None),
            Self::AiryPublished => method("airy-published", Some(published), None),
            Self::Airy => method("airy", Some(airy), None),
            Self::Uniform => method("uniform", Some(BowTheory::Uniform), None),
            Self::Debye { max_order } => Method {
                orders: 0..=max_order,
                ..method("debye", None, Some(DEBYE))
            },
            Self::Mie => method("mie", None, Some(LORENZ_MIE)),
            Self::BySize => method("by-size", Some(BowTheory::Uniform), Some(SMALL_DROPS)),
        }
    }

    /// The name it has in files and on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.method().name
    }

    /// Does it need the table of Airy's integral?
    #[must_use]
    pub fn uses_airy_table(self) -> bool {
        self.method().bows.is_some_and(BowTheory::has_waves)
    }

    /// Has a table light of orders that nobody asked for, which cannot be taken out of it because orders
    /// interfere?
    #[must_use]
    pub fn holds_every_order(self) -> bool {
        let drops = self.method().drops;
        drops.is_some_and(|drops| drops.solution == Solution::LorenzMie)
    }

    /// Is it the same whatever orders are asked for?
    #[must_use]
    pub fn ignores_orders(self) -> bool {
        self.holds_every_order() && self.method().bows.is_none()
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
        self.method().drops.is_some()
    }

    /// The orders it has among `orders`.
    #[must_use]
    pub fn orders_among(self, orders: &[u32]) -> Vec<u32> {
        let has = self.method().orders;
        orders.iter().copied().filter(|p| has.contains(p)).collect()
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

    /// What its bows look like, those of the uniform theory where drops are exact.
    pub(crate) fn expected_bows(self) -> BowTheory {
        self.method().bows.unwrap_or(BowTheory::Uniform)
    }
}
