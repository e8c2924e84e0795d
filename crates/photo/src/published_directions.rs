//! The published search for sun directions that put a bow through three pixels.
//!
//! d = 180 degrees − angle(v_e, v_s),   40 degrees <= d <= 43 degrees at every picked pixel
//! `v_e` unit vector from the eye through the pixel, `v_s` unit vector to the sun: every direction on
//! an even grid is tried (a Fibonacci spiral, one point for each step x step of solid angle), and
//! connected ones are gathered into examples from which the user chooses. The level that reproduces
//! the published method; [`crate::sun_from_picks`] is the accurate one.

use std::f64::consts::PI;
use std::f64::consts::TAU;

use glam::DVec3;
use niji_radiometry::Radians;

use crate::circle_through_picks::angle_between;
use crate::error::Error;

/// The published range of d, degrees.
const RANGE_DEG: (f64, f64) = (40.0, 43.0);
/// Finest step that is tried, degrees: four million directions.
const FINEST_DEG: f64 = 0.1;
/// Neighbours on the spiral are closer than this many steps.
const NEIGHBOR_STEPS: f64 = 1.9;

/// A connected set of sun directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionExample {
    /// The mean of its directions, towards the sun.
    pub sun: DVec3,
    /// Number of directions found in it.
    pub n_directions: usize,
    /// Largest distance of one of them from the mean.
    pub spread: Radians,
}

/// All examples above the horizon, the largest first.
///
/// # Errors
/// A step outside 0.1 to 10 degrees, or fewer than three picks.
pub fn published_directions(
    picks: &[DVec3],
    step: Radians,
) -> Result<Vec<DirectionExample>, Error> {
    let step_deg = step.to_degrees();
    if !(FINEST_DEG..=10.0).contains(&step_deg) {
        return Err(Error::Range {
            what: "the step of the search in degrees",
            found: step_deg,
            expected: "0.1 to 10",
        });
    }
    if picks.len() < 3 {
        return Err(Error::TooFewPicks {
            found: picks.len(),
            expected: 3,
        });
    }
    let (low, high) = (RANGE_DEG.0.to_radians(), RANGE_DEG.1.to_radians());
    let n_directions = (4.0 * PI / (step.0 * step.0)).ceil() as usize;
    let found: Vec<DVec3> = (0..n_directions)
        .map(|index| spiral_point(index, n_directions))
        .filter(|sun| sun.y >= 0.0)
        .filter(|sun| {
            let in_range = |view: &DVec3| {
                let d = angle_between(*view, -*sun);
                d >= low && d <= high
            };
            picks.iter().all(in_range)
        })
        .collect();
    let mut examples = gather(&found, NEIGHBOR_STEPS * step.0);
    examples.sort_by_key(|example| std::cmp::Reverse(example.n_directions));
    Ok(examples)
}

fn spiral_point(index: usize, n_points: usize) -> DVec3 {
    let golden = 0.5 + 0.5 * 5.0_f64.sqrt();
    let y = 1.0 - (2.0 * index as f64 + 1.0) / n_points as f64;
    let (sin, cos) = (TAU * (index as f64 / golden).fract()).sin_cos();
    let radius = (1.0 - y * y).max(0.0).sqrt();
    DVec3::new(radius * cos, y, radius * sin)
}

/// Connected sets: a direction joins the set of any closer than `reach`.
fn gather(found: &[DVec3], reach_rad: f64) -> Vec<DirectionExample> {
    let mut is_taken = vec![false; found.len()];
    let mut examples = Vec::new();
    for first in 0..found.len() {
        if is_taken[first] {
            continue;
        }
        is_taken[first] = true;
        let mut members = vec![first];
        let mut next = 0;
        while let Some(&member) = members.get(next) {
            next += 1;
            for (other, taken) in is_taken.iter_mut().enumerate() {
                if !*taken && found[other].distance(found[member]) < reach_rad {
                    *taken = true;
                    members.push(other);
                }
            }
        }
        let sum: DVec3 = members.iter().map(|member| found[*member]).sum();
        let sun = sum.normalize();
        let distances = members.iter().map(|m| angle_between(sun, found[*m]));
        examples.push(DirectionExample {
            sun,
            n_directions: members.len(),
            spread: Radians(distances.fold(0.0, f64::max)),
        });
    }
    examples
}
