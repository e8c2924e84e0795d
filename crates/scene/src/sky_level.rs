//! How finely the light of the sky is solved that the air scattered before.

use niji_atmosphere::ScatteringOrders;
use serde::Deserialize;
use serde::Serialize;

/// A level, coarse before fine: each errs by about half as much as the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SkyLevel {
    /// [`ScatteringOrders::DRAFT`].
    Draft,
    /// [`ScatteringOrders::QUICK`].
    Quick,
    /// [`ScatteringOrders::STANDARD`].
    Standard,
    /// [`ScatteringOrders::FINE`].
    Fine,
}

impl SkyLevel {
    /// The next coarser one.
    #[must_use]
    pub fn coarser(self) -> Option<Self> {
        match self {
            Self::Draft => None,
            Self::Quick => Some(Self::Draft),
            Self::Standard => Some(Self::Quick),
            Self::Fine => Some(Self::Standard),
        }
    }

    /// Its layers, directions and moments.
    #[must_use]
    pub fn orders(self) -> ScatteringOrders {
        match self {
            Self::Draft => ScatteringOrders::DRAFT,
            Self::Quick => ScatteringOrders::QUICK,
            Self::Standard => ScatteringOrders::STANDARD,
            Self::Fine => ScatteringOrders::FINE,
        }
    }
}
