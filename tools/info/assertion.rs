//! Conditions on the values of a file: `max(effective_radius) < 2e-3`.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use crate::failure::Failure;

/// Smallest, largest and mean value by name.
pub(super) type Ranges = BTreeMap<String, [f64; 3]>;

/// The figures of a range by the names they have in a condition.
const FIGURES: [&str; 3] = ["min", "max", "mean"];
/// Comparisons, the longer ones first so that `<=` is not read as `<`.
const COMPARISONS: [&str; 4] = ["<=", ">=", "<", ">"];

/// A condition.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assertion {
    figure: usize,
    name: String,
    comparison: &'static str,
    limit: f64,
}

impl FromStr for Assertion {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("found {text:?}, expected min|max|mean(NAME) <|<=|>|>= NUMBER");
        let found = COMPARISONS.into_iter().find_map(|comparison| {
            text.split_once(comparison)
                .map(|(left, right)| (comparison, left, right))
        });
        let (comparison, left, right) = found.ok_or_else(wrong)?;
        let limit: f64 = right.trim().parse().map_err(|_| wrong())?;
        let (figure, rest) = left.trim().split_once('(').ok_or_else(wrong)?;
        let name = rest.strip_suffix(')').ok_or_else(wrong)?.trim().to_owned();
        let figure = FIGURES
            .iter()
            .position(|known| *known == figure.trim())
            .ok_or_else(wrong)?;
        Ok(Self {
            figure,
            name,
            comparison,
            limit,
        })
    }
}

impl Assertion {
    pub(super) fn check(&self, ranges: &Ranges, path: &Path) -> Result<(), Failure> {
        let Some(range) = ranges.get(&self.name) else {
            let known: Vec<&str> = ranges.keys().map(String::as_str).take(12).collect();
            let message = format!(
                "found nothing called {:?}, there is {}",
                self.name,
                known.join(", ")
            );
            return Err(Failure::bad_input(path, message));
        };
        let value = range[self.figure];
        let holds = match self.comparison {
            "<" => value < self.limit,
            "<=" => value <= self.limit,
            ">" => value > self.limit,
            _ => value >= self.limit,
        };
        if holds {
            return Ok(());
        }
        let figure = FIGURES[self.figure];
        Err(Failure::ComparisonFailed(format!(
            "{}: {figure}({}) is {value:e}, expected {} {:e}",
            path.display(),
            self.name,
            self.comparison,
            self.limit
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_read_as_they_are_written() {
        let assertion: Assertion = " max( effective_radius )<=2e-3".parse().unwrap();
        assert_eq!(
            (assertion.figure, assertion.comparison, assertion.limit),
            (1, "<=", 2e-3)
        );
        assert_eq!(assertion.name, "effective_radius");
        for wrong in [
            "max(a)",
            "max a < 2",
            "top(a) < 2",
            "max(a) < b",
            "",
            "max(a < 2",
        ] {
            assert!(wrong.parse::<Assertion>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn conditions_hold_or_fail_with_the_code_for_comparisons() {
        let ranges = Ranges::from([("a".to_owned(), [0.0, 2.0, 1.0])]);
        let check = |text: &str| {
            text.parse::<Assertion>()
                .unwrap()
                .check(&ranges, Path::new("f"))
        };
        assert!(check("max(a) <= 2").is_ok());
        assert!(matches!(
            check("max(a) < 2"),
            Err(Failure::ComparisonFailed(_))
        ));
        assert!(check("mean(a) > 0.5").is_ok());
        assert!(matches!(check("min(b) > 0"), Err(Failure::BadInput { .. })));
    }
}
