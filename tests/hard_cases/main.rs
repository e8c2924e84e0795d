//! The hard cases that are the same on every machine: numbers at the ends of their range, directions on axes and
//! edges, impossible input. One list for each library: a claim, the error measured, the error allowed. Those that a
//! machine can break are tried by `niji selftest`.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod airy;
mod atmosphere;
mod dropfield;
mod droplets;
mod geometry;
#[path = "../../tools/selftest/hard_case.rs"]
#[allow(dead_code, reason = "the program uses the rest")]
mod hard_case;
mod ice;
mod photo;
mod picture;
mod radiometry;
mod render;
mod scatter;
mod scene;
#[path = "../../crates/render/tests/common/mod.rs"]
mod scenes;
mod sizes;

use hard_case::HardCase;

/// Runs the cases of a library, and says which do not hold.
fn try_all(cases: &[HardCase]) {
    let failed: Vec<String> = cases
        .iter()
        .map(|case| (case, case.run()))
        .filter(|(case, outcome)| !case.holds(outcome))
        .map(|(case, outcome)| {
            let (claim, measure, allowed) = (case.claim, case.measure, case.allowed);
            format!("{claim}: {outcome:?}, allowed {allowed} ({measure})")
        })
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn airy_stays_stable() {
    try_all(airy::CASES);
}

#[test]
fn atmosphere_stays_stable() {
    try_all(atmosphere::paths::CASES);
    try_all(atmosphere::light::CASES);
}

#[test]
fn dropfield_stays_stable() {
    try_all(dropfield::CASES);
}

#[test]
fn droplets_stays_stable() {
    try_all(droplets::CASES);
}

#[test]
fn geometry_stays_stable() {
    try_all(geometry::CASES);
}

#[test]
fn ice_stays_stable() {
    try_all(ice::CASES);
}

#[test]
fn photo_stays_stable() {
    try_all(photo::CASES);
}

#[test]
fn picture_stays_stable() {
    try_all(picture::CASES);
}

#[test]
fn radiometry_stays_stable() {
    try_all(radiometry::CASES);
}

#[test]
fn render_stays_stable() {
    try_all(render::CASES);
}

#[test]
fn scatter_stays_stable() {
    try_all(scatter::CASES);
}

#[test]
fn scene_stays_stable() {
    try_all(scene::CASES);
}

#[test]
fn sizes_stays_stable() {
    try_all(sizes::CASES);
}
