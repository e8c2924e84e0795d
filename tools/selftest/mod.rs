//! `niji selftest`: what a machine can break, with the error measured and the error allowed.
//!
//! Files that are read and written, and sums in the vectors of this very processor, drop by drop and ray by ray.
//! One file for each library; `tests/selftest.rs` runs the program. The hard cases of all other libraries, which are
//! the same on every machine, stand in `tests/hard_cases`.

mod exchange;
mod hard_case;
mod mie;
mod render;
mod vdb;

use std::fmt::Write as _;

use clap::Args;
use rayon::prelude::*;
use serde_json::Value;
use serde_json::json;

use crate::failure::Failure;
use crate::flags::Common;
use crate::output;

use hard_case::HardCase;
use hard_case::Outcome;

/// Try what a machine can break: measured error beside allowed error.
///
/// Files, damaged ones too, exact drops at the ends of their range, and rays on axes, faces and edges.
/// A case that fails, gives NaN or panics ends the program with exit code 6 after all have run.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  niji selftest
  niji selftest --filter mie
  niji selftest --json > stability.json")]
pub(crate) struct SelftestCommand {
    /// Only cases with this text in the name of their library or in their claim.
    #[arg(
        long,
        value_name = "TEXT",
        default_value = "",
        hide_default_value = true
    )]
    filter: String,
}

/// The lists, from the lowest library to the highest.
const LIBRARIES: [(&str, &[HardCase]); 5] = [
    ("vdb", vdb::CASES),
    ("exchange", exchange::CASES),
    ("mie", mie::CASES),
    ("render", render::rays::CASES),
    ("render", render::pictures::CASES),
];

/// A case that was run.
struct Line {
    library: &'static str,
    case: &'static HardCase,
    outcome: Outcome,
}

impl Line {
    fn holds(&self) -> bool {
        self.case.holds(&self.outcome)
    }
}

/// Runs the cases and prints what came of them.
///
/// # Errors
/// [`Failure::ComparisonFailed`] if a case does not hold, [`Failure::Usage`] if the filter leaves none.
pub(crate) fn execute(command: &SelftestCommand, common: &Common) -> Result<(), Failure> {
    // The words of a panic stand in the report.
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let lines = run(&LIBRARIES, &command.filter);
    std::panic::set_hook(hook);
    if lines.is_empty() {
        let message = format!("no hard case has \"{}\" in its name", command.filter);
        return Err(Failure::Usage(message));
    }
    if common.json {
        output::print(&format!("{:#}\n", to_json(&lines)))?;
    } else if !common.quiet {
        output::print(&to_text(&lines))?;
    }
    let n_failed = lines.iter().filter(|line| !line.holds()).count();
    if n_failed == 0 {
        return Ok(());
    }
    let message = format!("{n_failed} of {} hard cases failed", lines.len());
    Err(Failure::ComparisonFailed(message))
}

/// The outcomes in the order of the lists, whichever case ends first.
fn run(libraries: &[(&'static str, &'static [HardCase])], filter: &str) -> Vec<Line> {
    let cases: Vec<_> = libraries
        .iter()
        .flat_map(|(library, cases)| cases.iter().map(move |case| (*library, case)))
        .filter(|(library, case)| library.contains(filter) || case.claim.contains(filter))
        .collect();
    cases
        .into_par_iter()
        .map(|(library, case)| Line {
            library,
            case,
            outcome: case.run(),
        })
        .collect()
}

fn to_text(lines: &[Line]) -> String {
    let widths = lines.iter().map(|line| line.case.claim.len());
    let width = widths.max().unwrap_or_default();
    let mut text = String::new();
    let mut library = "";
    for line in lines {
        if line.library != library {
            library = line.library;
            let head = library.to_uppercase();
            let _ = writeln!(text, "\n{head:<width$}  {:>9} {:>9}", "measured", "allowed");
        }
        let verdict = if line.holds() { "ok" } else { "FAILED" };
        let measured = match &line.outcome {
            Outcome::Measured(error) => number(*error),
            Outcome::Panicked(_) => "panic".to_owned(),
        };
        let (claim, allowed) = (line.case.claim, number(line.case.allowed));
        let _ = writeln!(
            text,
            "{claim:<width$}  {measured:>9} {allowed:>9}  {verdict}"
        );
        let _ = writeln!(text, "    {}", line.case.measure);
        if let Outcome::Panicked(words) = &line.outcome {
            let _ = writeln!(text, "    panicked: {words}");
        }
    }
    let n_held = lines.iter().filter(|line| line.holds()).count();
    let _ = writeln!(text, "\n{n_held} of {} hard cases hold", lines.len());
    text
}

/// Two digits are enough of an error.
fn number(error: f64) -> String {
    // Against the value that cases return for "none at all".
    if error == 0.0 {
        "0".to_owned()
    } else if (0.001..10_000.0).contains(&error.abs()) {
        let decimals = (1 - error.abs().log10().floor() as i32).max(0) as usize;
        format!("{error:.decimals$}")
    } else {
        format!("{error:.1e}")
    }
}

fn to_json(lines: &[Line]) -> Value {
    let cases: Vec<Value> = lines
        .iter()
        .map(|line| {
            let (measured, panicked) = match &line.outcome {
                // JSON has no NaN: it becomes null.
                Outcome::Measured(error) => (json!(error), Value::Null),
                Outcome::Panicked(words) => (Value::Null, json!(words)),
            };
            json!({
                "library": line.library,
                "claim": line.case.claim,
                "measure": line.case.measure,
                "measured": measured,
                "allowed": line.case.allowed,
                "holds": line.holds(),
                "panicked": panicked,
            })
        })
        .collect();
    let n_failed = lines.iter().filter(|line| !line.holds()).count();
    json!({ "n_cases": lines.len(), "n_failed": n_failed, "cases": cases })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD_AND_BAD: &[HardCase] = &[
        HardCase {
            claim: "what is within its bound holds",
            measure: "metres",
            allowed: 1e-9,
            error: || 1e-9,
        },
        HardCase {
            claim: "what is beyond its bound fails",
            measure: "metres",
            allowed: 1e-9,
            error: || 2e-9,
        },
        HardCase {
            claim: "NaN fails",
            measure: "metres",
            allowed: f64::INFINITY,
            error: || f64::NAN,
        },
        HardCase {
            claim: "a panic fails",
            measure: "metres",
            allowed: f64::INFINITY,
            error: || panic!("at voxel {}", 7),
        },
    ];

    #[test]
    fn only_a_number_within_its_bound_holds() {
        let lines = run(&[("test", GOOD_AND_BAD)], "");
        let held: Vec<bool> = lines.iter().map(Line::holds).collect();
        assert_eq!(held, [true, false, false, false]);
        assert_eq!(lines[3].outcome, Outcome::Panicked("at voxel 7".to_owned()));
    }

    #[test]
    fn the_report_names_every_failure() {
        let lines = run(&[("test", GOOD_AND_BAD)], "");
        let text = to_text(&lines);
        assert_eq!(text.matches("FAILED").count(), 3);
        assert!(text.contains("panicked: at voxel 7"), "{text}");
        assert!(text.contains("1 of 4 hard cases hold"), "{text}");
        let json = to_json(&lines);
        assert_eq!(json["n_failed"], 3);
        assert!(json["cases"][2]["measured"].is_null());
    }

    #[test]
    fn a_filter_takes_claims_and_libraries() {
        let lists = [("one", GOOD_AND_BAD), ("two", GOOD_AND_BAD)];
        assert_eq!(run(&lists, "two").len(), 4);
        assert_eq!(run(&lists, "bound").len(), 4);
        assert_eq!(run(&lists, "three").len(), 0);
    }

    #[test]
    fn no_claim_is_made_twice() {
        let claims = LIBRARIES.iter().flat_map(|(_, cases)| *cases);
        let claims: Vec<&str> = claims.map(|case| case.claim).collect();
        let distinct: std::collections::BTreeSet<_> = claims.iter().collect();
        assert_eq!(distinct.len(), claims.len());
    }
}
