//! The axes of a table: as few nodes as linear interpolation to a tolerance allows.
//!
//! The laws below are measured, not derived: for theories of bows and Debye orders the error half way
//! between radii is a fifth to a hundredth of the tolerance from 5 µm to 3 mm, and the exact solution
//! keeps it from v_e = 0.05 on. [`crate::adaptive_table`] begins with them and halves what misses the
//! tolerance. Rows of single sizes of the exact solution cannot be halved into it: what their cells leave
//! of the ripple differs from node to node by 0.025 rms of the peak at 20 µm, 0.005 at 0.1 mm and 0.001
//! at 0.4 mm radius.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

use crate::error::Error;

/// Steps of the effective radius for each factor e at which a single size is interpolated half way
/// between two nodes to 0.45 % of the bow's peak (rms over 136 to 145 degrees and 10 µm to 1.5 mm,
/// after the sun's disc).
const STEPS_PER_EFOLD: f64 = 46.0;
/// The error at these steps; it falls with the square of the step.
const ERROR_AT_STEPS: f64 = 4.5e-3;
/// Effective variance from which on the bow changes so slowly with the radius that a quarter of the
/// nodes is enough.
const BROAD_VARIANCE: f64 = 0.04;
/// Nodes of the effective variance. Half way between them the uniform theory is off by at most 1.2e-3
/// rms of the peak, measured for 20, 50, 150 and 500 µm radius.
const VARIANCES: [f64; 13] = [
    0.0,
    0.002,
    0.005,
    0.01,
    0.02,
    0.033,
    0.05,
    0.07,
    0.1,
    0.14,
    0.2,
    0.26,
    1.0 / 3.0,
];

/// Effective radii from `min_um` to `max_um`, even in their logarithm.
///
/// # Errors
/// If the range is empty or not positive, or the tolerance not within 1e-5 to 1.
pub fn radius_axis(
    (min_um, max_um): (f64, f64),
    smallest_variance: f64,
    tolerance: f64,
) -> Result<Vec<f64>, Error> {
    let found = || format!("{min_um} to {max_um} um");
    if !(min_um > 0.0 && max_um >= min_um && max_um.is_finite()) {
        let expected = "an ascending range above 0";
        return Err(Error::Axis {
            axis: "effective radius",
            found: found(),
            expected,
        });
    }
    if !(1e-5..=1.0).contains(&tolerance) {
        let expected = "1e-5 to 1";
        return Err(Error::Axis {
            axis: "tolerance",
            found: tolerance.to_string(),
            expected,
        });
    }
    let efolds = (max_um / min_um).ln();
    if efolds < 1e-6 {
        return Ok(vec![min_um]);
    }
    let density = STEPS_PER_EFOLD * (ERROR_AT_STEPS / tolerance).sqrt();
    let density = if smallest_variance >= BROAD_VARIANCE {
        0.25 * density
    } else {
        density
    };
    let n_steps = (efolds * density).ceil().max(1.0) as usize;
    let step = efolds / n_steps as f64;
    let mut axis: Vec<f64> = (0..=n_steps)
        .map(|i| min_um * (step * i as f64).exp())
        .collect();
    axis[n_steps] = max_um;
    Ok(axis)
}

/// Effective variances from `min` to `max`.
///
/// # Errors
/// If the range is empty or not within 0 to below 1/2.
pub fn variance_axis((min, max): (f64, f64)) -> Result<Vec<f64>, Error> {
    if !(min >= 0.0 && max >= min && max < 0.5) {
        let (found, expected) = (
            format!("{min} to {max}"),
            "an ascending range from 0 to below 0.5",
        );
        return Err(Error::Axis {
            axis: "effective variance",
            found,
            expected,
        });
    }
    let inside = VARIANCES
        .into_iter()
        .filter(|&variance| variance > min && variance < max);
    let mut axis: Vec<f64> = [min].into_iter().chain(inside).collect();
    if max > min {
        axis.push(max);
    }
    Ok(axis)
}

/// The angles on either side of 90 degrees. Each is judged by its own peak: forwards drops send up to a
/// hundred times the light of a bow.
pub(crate) fn sides(theta_rad: &[f64]) -> [Range<usize>; 2] {
    let behind = theta_rad.partition_point(|theta| *theta < FRAC_PI_2);
    [0..behind, behind..theta_rad.len()]
}

/// Indices of the angles that linear interpolation of every curve needs to stay within `tolerance`
/// times that curve's maximum on the same side.
pub(crate) fn needed_angles(theta_rad: &[f64], curves: &[Vec<f64>], tolerance: f64) -> Vec<usize> {
    let mut nodes = Vec::new();
    for side in sides(theta_rad) {
        if side.is_empty() {
            continue;
        }
        // The step across 90 degrees belongs to the side in front.
        let reach = side.start..(side.end + 1).min(theta_rad.len());
        let of_side: Vec<&[f64]> = curves.iter().map(|curve| &curve[reach.clone()]).collect();
        let needed = needed_nodes(&theta_rad[reach.clone()], &of_side, tolerance);
        nodes.extend(needed.into_iter().map(|index| reach.start + index));
    }
    nodes.dedup();
    nodes
}

/// Indices of the nodes that linear interpolation of every curve needs to stay within `tolerance`
/// times that curve's maximum: intervals are halved until every candidate between their ends fits.
fn needed_nodes(positions: &[f64], curves: &[&[f64]], tolerance: f64) -> Vec<usize> {
    let limits: Vec<f64> = curves
        .iter()
        .map(|curve| tolerance * curve.iter().fold(0.0_f64, |peak, &value| peak.max(value)))
        .collect();
    let fits = |first: usize, last: usize| {
        let width = positions[last] - positions[first];
        curves.iter().zip(&limits).all(|(curve, limit)| {
            (first + 1..last).all(|index| {
                let part = (positions[index] - positions[first]) / width;
                let line = curve[first] * (1.0 - part) + curve[last] * part;
                (curve[index] - line).abs() <= *limit
            })
        })
    };
    let mut nodes = vec![0];
    let mut open = vec![(0, positions.len() - 1)];
    while let Some((first, last)) = open.pop() {
        if last - first <= 1 || fits(first, last) {
            nodes.push(last);
        } else {
            let middle = usize::midpoint(first, last);
            open.push((middle, last));
            open.push((first, middle));
        }
    }
    nodes.dedup();
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_forwards_does_not_take_angles_from_a_bow() {
        let theta_rad: Vec<f64> = (0..=1000).map(|step| 0.003 * f64::from(step)).collect();
        let light = |forwards: f64| {
            let at = |theta: &f64| {
                forwards * (-theta * theta).exp() + (-(100.0 * (theta - 2.4).powi(2))).exp()
            };
            theta_rad.iter().map(at).collect::<Vec<f64>>()
        };
        let nodes = |forwards: f64, range: Range<usize>| {
            let curve = light(forwards)[range.clone()].to_vec();
            needed_angles(&theta_rad[range], &[curve], 1e-2)
        };
        let [behind, all] = [sides(&theta_rad)[1].clone(), 0..theta_rad.len()];
        let bow = nodes(100.0, behind.clone());
        let of_all = nodes(100.0, all);
        let found = of_all.iter().filter(|index| **index >= behind.start);
        let found: Vec<usize> = found.map(|index| index - behind.start).collect();
        assert_eq!(found, bow);
        assert!(bow.len() > 10, "{bow:?}");
        assert!(of_all.windows(2).all(|pair| pair[0] < pair[1]) && of_all[0] == 0);
        // A range on one side, and one that ends with the first angle behind.
        for range in [0..behind.start, 0..behind.start + 1, 700..701] {
            let nodes = nodes(1.0, range.clone());
            assert_eq!(nodes.last(), Some(&(range.len() - 1)));
        }
    }

    #[test]
    fn axes_hold_their_ends_and_ascend() {
        let radii = radius_axis((10.0, 1500.0), 0.0, 2e-3).unwrap();
        assert_eq!((radii[0], radii[radii.len() - 1]), (10.0, 1500.0));
        assert!(radii.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(radius_axis((100.0, 100.0), 0.0, 2e-3).unwrap(), [100.0]);
        assert_eq!(variance_axis((0.0, 0.0)).unwrap(), [0.0]);
        assert_eq!(variance_axis((0.0, 0.005)).unwrap(), [0.0, 0.002, 0.005]);
        assert_eq!(variance_axis((1.0 / 3.0, 1.0 / 3.0)).unwrap(), [1.0 / 3.0]);
    }

    #[test]
    fn impossible_ranges_are_refused() {
        for range in [
            (0.0, 1.0),
            (-1.0, 2.0),
            (5.0, 4.0),
            (f64::NAN, 1.0),
            (1.0, f64::INFINITY),
        ] {
            assert!(radius_axis(range, 0.0, 1e-3).is_err());
        }
        assert!(radius_axis((1.0, 2.0), 0.0, 0.0).is_err());
        for range in [(-0.1, 0.2), (0.0, 0.5), (0.3, 0.2), (f64::NAN, 0.1)] {
            assert!(variance_axis(range).is_err());
        }
    }

    #[test]
    fn the_nodes_kept_interpolate_within_the_tolerance() {
        let positions: Vec<f64> = (0..=2000).map(|i| 0.01 * f64::from(i)).collect();
        let curve: Vec<f64> = positions
            .iter()
            .map(|x| (-(x - 6.0).powi(2)).exp())
            .collect();
        let nodes = needed_nodes(&positions, &[&curve], 1e-3);
        assert!(nodes.len() < 150, "{} nodes", nodes.len());
        assert_eq!((nodes[0], nodes[nodes.len() - 1]), (0, 2000));
        for pair in nodes.windows(2) {
            for index in pair[0]..=pair[1] {
                let part = (index - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
                let line = curve[pair[0]] * (1.0 - part) + curve[pair[1]] * part;
                assert!((line - curve[index]).abs() < 1.001e-3);
            }
        }
    }
}
