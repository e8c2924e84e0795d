//! Whatever changes between two runs, the second leaves what a fresh run makes, and calls nothing else up to date.
//!
//! Times of modification are set back after each change: they prove nothing.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../../build.rs"]
#[allow(dead_code, reason = "the program is built already")]
mod build;
mod inputs;
mod outputs;
mod program;
#[path = "../support/mod.rs"]
mod support;
mod world;
