//! The angles of a table: as few nodes as linear interpolation to a tolerance allows.

use std::ops::Range;

use niji_exchange::stretch_of;

/// The angles of each stretch, ascending. Each is judged by its own peak: forwards drops send up to a million times the
/// light of a bow.
pub(crate) fn stretches(theta_rad: &[f64]) -> impl Iterator<Item = Range<usize>> {
    let is_one = |a: &f64, b: &f64| stretch_of(*a) == stretch_of(*b);
    theta_rad.chunk_by(is_one).scan(0, |end, angles| {
        let start = *end;
        *end += angles.len();
        Some(start..*end)
    })
}

/// How near linear interpolation between angles comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearness<'a> {
    /// In parts of the maximum in the same stretch of angles.
    pub(crate) tolerance: f64,
    /// Whose maximum that is, curve by curve: all light where a curve is one order of it.
    pub(crate) of: &'a [Vec<f64>],
    /// Widest step between angles, where candidates lie closer, rad.
    pub(crate) widest_step_rad: f64,
}

/// Indices of the angles that linear interpolation of every curve needs to come so near.
pub(crate) fn needed_angles(
    theta_rad: &[f64],
    curves: &[Vec<f64>],
    nearness: Nearness,
) -> Vec<usize> {
    let mut nodes = Vec::new();
    for stretch in stretches(theta_rad) {
        // The step to the next one belongs to it.
        let reach = stretch.start..(stretch.end + 1).min(theta_rad.len());
        let limit = |all: &Vec<f64>| {
            let peak = all[reach.clone()]
                .iter()
                .fold(0.0_f64, |peak, &value| peak.max(value));
            nearness.tolerance * peak
        };
        let of_stretch: Vec<(&[f64], f64)> = curves
            .iter()
            .zip(nearness.of)
            .map(|(curve, all)| (&curve[reach.clone()], limit(all)))
            .collect();
        let positions = &theta_rad[reach.clone()];
        let needed = needed_nodes(positions, &of_stretch, nearness.widest_step_rad);
        nodes.extend(needed.into_iter().map(|index| reach.start + index));
    }
    nodes.dedup();
    nodes
}

/// Indices of the nodes that linear interpolation of every curve needs to stay within its limit: intervals are
/// halved until every candidate between their ends fits.
fn needed_nodes(positions: &[f64], curves: &[(&[f64], f64)], widest_step_rad: f64) -> Vec<usize> {
    let fits = |first: usize, last: usize| {
        let width = positions[last] - positions[first];
        width <= widest_step_rad
            && curves.iter().all(|(curve, limit)| {
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
            let curves = [light(forwards)[range.clone()].to_vec()];
            let nearness = Nearness {
                tolerance: 1e-2,
                of: &curves,
                widest_step_rad: f64::INFINITY,
            };
            needed_angles(&theta_rad[range], &curves, nearness)
        };
        let behind = stretches(&theta_rad).last().unwrap();
        let all = 0..theta_rad.len();
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
    fn every_stretch_is_as_near_in_parts_of_its_own_peak() {
        let theta_rad: Vec<f64> = (0..=4000).map(|step| 7.5e-4 * f64::from(step)).collect();
        let fall = |theta: f64| 1.0 / (1e-2 + theta).powi(3);
        let curves = [theta_rad.iter().map(|theta| fall(*theta)).collect()];
        let nearness = Nearness {
            tolerance: 1e-2,
            of: &curves,
            widest_step_rad: f64::INFINITY,
        };
        let nodes = needed_angles(&theta_rad, &curves, nearness);
        for pair in nodes.windows(2) {
            let [low, high] = [theta_rad[pair[0]], theta_rad[pair[1]]];
            for theta in &theta_rad[pair[0]..pair[1]] {
                let part = (theta - low) / (high - low);
                let line = fall(low) * (1.0 - part) + fall(high) * part;
                // A stretch begins at half of where it ends, or at 0.
                let peak = fall(if *theta < 0.01 { 0.0 } else { 0.5 * theta });
                assert!((line - fall(*theta)).abs() < 1e-2 * peak, "{theta}");
            }
        }
        assert!(nodes.len() < 150, "{}", nodes.len());
    }

    #[test]
    fn the_nodes_kept_interpolate_within_the_tolerance() {
        let positions: Vec<f64> = (0..=2000).map(|i| 0.01 * f64::from(i)).collect();
        let curve: Vec<f64> = positions
            .iter()
            .map(|x| (-(x - 6.0).powi(2)).exp())
            .collect();
        let nodes = needed_nodes(&positions, &[(&curve, 1e-3)], f64::INFINITY);
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
