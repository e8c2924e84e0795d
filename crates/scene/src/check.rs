//! What checks of any part of a scene share: lines of keys, and refusals of numbers out of range.

use std::collections::BTreeMap;

use crate::error::SceneError;

/// Farthest that anything may be from the origin, metres; f64 still resolves a nanometre there.
const MAX_COORDINATE_M: f64 = 1e7;

/// Angles that turn, degrees: ten turns either way, for a sequence that goes on turning.
pub(crate) const TURNS_DEG: (f64, f64) = (-3600.0, 3600.0);

/// Where the keys of a document stand; nowhere for a scene that was not read.
pub(crate) struct Check<'a> {
    pub(crate) lines: &'a BTreeMap<String, usize>,
}

impl Check<'_> {
    /// Line of a key; of its section, or the first, where the key was left out. 0 where there are no lines.
    pub(crate) fn line(&self, key: &str) -> usize {
        if self.lines.is_empty() {
            return 0;
        }
        let section = key.split('.').next().unwrap_or(key);
        self.lines
            .get(key)
            .or_else(|| self.lines.get(section))
            .copied()
            .unwrap_or(1)
    }

    pub(crate) fn out_of_range(&self, key: &str, found: String, expected: &str) -> SceneError {
        let expected = expected.to_string();
        SceneError::OutOfRange {
            line: self.line(key),
            key: key.to_string(),
            found,
            expected,
        }
    }

    pub(crate) fn refused(&self, key: &str, reason: &dyn std::fmt::Display) -> SceneError {
        SceneError::Refused {
            line: self.line(key),
            key: key.to_string(),
            reason: reason.to_string(),
        }
    }

    pub(crate) fn number(
        &self,
        key: &str,
        found: f64,
        (low, high): (f64, f64),
    ) -> Result<(), SceneError> {
        if (low..=high).contains(&found) {
            return Ok(());
        }
        Err(self.out_of_range(key, found.to_string(), &format!("{low} to {high}")))
    }

    /// A place along an axis, in metres.
    pub(crate) fn coordinate(&self, key: &str, found: f64) -> Result<(), SceneError> {
        self.number(key, found, (-MAX_COORDINATE_M, MAX_COORDINATE_M))
    }

    pub(crate) fn positive(&self, key: &str, found: f64) -> Result<(), SceneError> {
        if found > 0.0 && found <= MAX_COORDINATE_M {
            return Ok(());
        }
        let expected = format!("above 0 and at most {MAX_COORDINATE_M}");
        Err(self.out_of_range(key, found.to_string(), &expected))
    }

    pub(crate) fn count<T: PartialOrd + ToString>(
        &self,
        key: &str,
        found: &T,
        (low, high): (T, T),
    ) -> Result<(), SceneError> {
        if *found >= low && *found <= high {
            return Ok(());
        }
        let expected = format!("{} to {}", low.to_string(), high.to_string());
        Err(self.out_of_range(key, found.to_string(), &expected))
    }
}
