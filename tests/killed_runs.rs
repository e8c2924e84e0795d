//! What is killed at any moment goes on to the same files; `cargo bench --bench killed_runs` kills more often.

#![cfg(unix)]

#[path = "support/killed.rs"]
mod killed;
mod support;

/// Kills of each job: some seconds in all.
const N_KILLS: u32 = 5;

#[test]
fn what_is_killed_at_any_moment_goes_on_to_the_same_files() {
    // A sweep takes too long to be done in a test.
    for job in killed::jobs().iter().filter(|job| job.name != "sweep") {
        let tally = job.kill(N_KILLS, 1);
        assert!(tally.done > 0, "{}", job.name);
    }
}
