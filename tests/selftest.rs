//! The stability report of the program: what a machine can break holds on this one.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod support;

use std::collections::BTreeSet;

use support::niji;
use support::niji_ends_with;

#[test]
fn every_hard_case_holds() {
    let output = niji(&["selftest", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let cases = report["cases"].as_array().unwrap();
    let failed: Vec<_> = cases.iter().filter(|case| case["holds"] != true).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    assert_eq!(output.status.code(), Some(0));
    assert!(cases.len() >= 30, "{} cases", cases.len());
    let libraries: BTreeSet<_> = cases
        .iter()
        .map(|case| case["library"].as_str().unwrap())
        .collect();
    assert_eq!(libraries.len(), 4, "{libraries:?}");
}

#[test]
fn a_filter_that_leaves_nothing_is_a_usage_error() {
    let output = niji_ends_with(2, &["selftest", "--filter", "no such claim"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("no such claim"), "{message}");
}
