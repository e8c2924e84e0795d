//! Differences of many values, summed up.

use std::fmt::Write as _;

use serde_json::Value;
use serde_json::json;

use crate::failure::Failure;

/// How the values of a group of channels, or of a grid, differ from those of the reference.
pub(super) struct Measure {
    name: String,
    n: u64,
    reference_squares: f64,
    squares: f64,
    sum: f64,
    largest: f64,
    place: String,
}

impl Measure {
    pub(super) fn new(name: String) -> Self {
        Self {
            name,
            n: 0,
            reference_squares: 0.0,
            squares: 0.0,
            sum: 0.0,
            largest: 0.0,
            place: String::new(),
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Takes a pair of values; `place` says where, should it be the worst.
    pub(super) fn add(&mut self, reference: f64, found: f64, place: impl FnOnce() -> String) {
        let off = found - reference;
        self.n += 1;
        self.reference_squares += reference * reference;
        self.squares += off * off;
        self.sum += off;
        if off.abs() > self.largest {
            self.largest = off.abs();
            self.place = place();
        }
    }

    fn rmse(&self) -> f64 {
        (self.squares / self.n.max(1) as f64).sqrt()
    }

    /// RMSE over the RMS of the reference; infinite where that is 0 and something differs.
    fn relative_rmse(&self) -> f64 {
        if self.squares > 0.0 {
            (self.squares / self.reference_squares).sqrt()
        } else {
            0.0
        }
    }

    fn bias(&self) -> f64 {
        self.sum / self.n.max(1) as f64
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "name": self.name,
            "values": self.n,
            "relative_rmse": self.relative_rmse(),
            "rmse": self.rmse(),
            "bias": self.bias(),
            "largest_difference": self.largest,
            "largest_at": self.place,
        })
    }

    /// Checks the thresholds that were given.
    ///
    /// # Errors
    /// [`Failure::ComparisonFailed`] with the threshold that does not hold.
    pub(super) fn check(
        &self,
        max_relative_rmse: Option<f64>,
        max_difference: Option<f64>,
    ) -> Result<(), Failure> {
        let relative_rmse = self.relative_rmse();
        if let Some(limit) = max_relative_rmse
            && relative_rmse > limit
        {
            return Err(Failure::ComparisonFailed(format!(
                "{}: relative RMSE {relative_rmse:.4e}, expected at most {limit:e}",
                self.name
            )));
        }
        if let Some(limit) = max_difference
            && self.largest > limit
        {
            return Err(Failure::ComparisonFailed(format!(
                "{}: difference {:.4e} at {}, expected at most {limit:e}",
                self.name, self.largest, self.place
            )));
        }
        Ok(())
    }
}

/// The measures for people.
pub(super) fn table(measures: &[Measure]) -> String {
    let width = measures.iter().map(|measure| measure.name.len()).max();
    let width = width.unwrap_or(0);
    let mut text = format!(
        "{:width$}  {:>13}  {:>10}  {:>10}  {:>10}\n",
        "", "relative RMSE", "RMSE", "bias", "largest"
    );
    for measure in measures {
        let _ = writeln!(
            text,
            "{:width$}  {:>13.3e}  {:>10.3e}  {:>10.2e}  {:>10.3e}  {}",
            measure.name,
            measure.relative_rmse(),
            measure.rmse(),
            measure.bias(),
            measure.largest,
            measure.place
        );
    }
    text
}

/// Things of one name in both files; anything else fails.
///
/// # Errors
/// [`Failure::ComparisonFailed`] that names what only one of the files has.
pub(super) fn same_names(
    kind: &str,
    reference: &[String],
    found: &[String],
) -> Result<(), Failure> {
    let only_in = |these: &[String], others: &[String]| -> Vec<String> {
        let is_alone = |name: &&String| !others.contains(name);
        these.iter().filter(is_alone).cloned().collect()
    };
    let (missing, extra) = (only_in(reference, found), only_in(found, reference));
    if missing.is_empty() && extra.is_empty() {
        return Ok(());
    }
    let sides = [("reference", missing), ("other", extra)];
    let differing = sides.iter().filter(|(_, names)| !names.is_empty());
    let differing: Vec<String> = differing
        .map(|(side, names)| format!("only the {side} has {}", names.join(", ")))
        .collect();
    Err(Failure::ComparisonFailed(format!(
        "the files have different {kind}: {}",
        differing.join(", ")
    )))
}

#[cfg(test)]
mod tests {
    use super::same_names;

    #[test]
    fn only_the_file_that_has_more_is_told() {
        let names =
            |names: &[&str]| -> Vec<String> { names.iter().map(ToString::to_string).collect() };
        let (both, one) = (names(&["spectral", "error"]), names(&["error"]));
        assert!(same_names("parts", &both, &both).is_ok());
        let message = |reference: &[String], found: &[String]| {
            same_names("parts", reference, found)
                .unwrap_err()
                .to_string()
        };
        let found = message(&both, &one);
        assert!(
            found.ends_with("parts: only the reference has spectral"),
            "{found}"
        );
        let found = message(&one, &both);
        assert!(
            found.ends_with("parts: only the other has spectral"),
            "{found}"
        );
    }
}
