//! A hard case: a claim about a library, the error measured on it, and the error allowed.

use std::panic::catch_unwind;

/// One claim about a library where such code usually breaks.
pub(crate) struct HardCase {
    /// What must hold, in words.
    pub(crate) claim: &'static str,
    /// What the error is, with its unit.
    pub(crate) measure: &'static str,
    /// The largest error with which the claim still holds.
    pub(crate) allowed: f64,
    /// Measures the error. NaN and a panic are failures of this case, not of the program.
    pub(crate) error: fn() -> f64,
}

/// What came of a hard case.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outcome {
    /// The error that was measured.
    Measured(f64),
    /// The words with which the case panicked.
    Panicked(String),
}

impl HardCase {
    /// Measures the error.
    pub(crate) fn run(&self) -> Outcome {
        match catch_unwind(self.error) {
            Ok(error) => Outcome::Measured(error),
            Err(payload) => {
                let text = payload.downcast_ref::<String>().map(String::as_str);
                let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
                Outcome::Panicked(text.unwrap_or("without words").to_owned())
            }
        }
    }

    /// Whether the claim holds with this outcome; NaN is larger than any error.
    pub(crate) fn holds(&self, outcome: &Outcome) -> bool {
        match outcome {
            Outcome::Measured(error) => *error <= self.allowed,
            Outcome::Panicked(_) => false,
        }
    }
}

/// The largest error, NaN if one is; 0 of none.
pub(crate) fn worst(errors: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |worst: f64, error: f64| {
        if error > worst || error.is_nan() {
            error
        } else {
            worst
        }
    };
    errors.into_iter().fold(0.0, larger)
}

/// Relative difference.
pub(crate) fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// How many of the conditions do not hold.
pub(crate) fn violations(conditions: impl IntoIterator<Item = bool>) -> f64 {
    conditions.into_iter().filter(|holds| !holds).count() as f64
}

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): damage that is the same everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// A number from 0 to below `limit`.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % limit as u64) as usize
    }
}
