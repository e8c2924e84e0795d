//! Places on the axis of scattering angles of a scattering table.
//!
//! A table is interpolated linearly:
//! t(theta) = sum_n w_n t_n,  with weights w_n >= 0 that sum to 1,
//! or has the mean of that over the angles of a pixel. Between two nodes of an axis h apart it errs by
//! x (1 - x)/2 h² t'' at the fraction x of the way, and by the mean of this.
//!
//! Light from many directions has the mean over a Gaussian of angles, cut at four standard deviations and
//! integrated in pieces of half of one by two Gauss points: weights err by 1e-5.

/// Where a ray stands on the table's axis of angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayPlace {
    /// Scattering angle of the ray.
    pub(crate) theta_rad: f64,
    /// Scattering angles that its pixel spans; 0 for a point.
    pub(crate) width_rad: f64,
}

/// How far a Gaussian reaches, and the widest piece of it, in standard deviations.
const GAUSSIAN_REACH: f64 = 4.0;
const GAUSSIAN_PIECE: f64 = 0.5;

/// Offset of the two Gauss points of a piece from its middle, in units of its length.
const GAUSS_OFFSET: f64 = 0.288_675_134_594_812_9;

/// The angles of a table.
#[derive(Clone, Debug)]
pub(crate) struct AngleAxis {
    theta_rad: Vec<f64>,
}

/// A node of the angle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowTerm {
    pub(crate) node: usize,
    pub(crate) weight: f32,
    /// Part of the bend by which the rows between the node and the next angle lie off the straight line.
    pub(crate) bend_weight: f32,
}

impl AngleAxis {
    /// An axis through ascending nodes; at least one.
    pub(crate) fn new(theta_rad: &[f64]) -> Self {
        Self {
            theta_rad: theta_rad.to_vec(),
        }
    }

    /// The first and the last angle.
    pub(crate) fn theta_range_rad(&self) -> (f64, f64) {
        (self.theta_rad[0], self.theta_rad[self.theta_rad.len() - 1])
    }

    /// Set `terms` to those of the rows of a ray, the mean over the pixel. `near` is the node above the last
    /// ray, where the search for this one starts.
    pub(crate) fn set_terms(&self, place: &RayPlace, near: &mut usize, terms: &mut Vec<RowTerm>) {
        terms.clear();
        self.add_angles(place, near, terms);
    }

    /// Set `terms` to the mean of the linear interpolant over a Gaussian of angles; the ends of the axis hold
    /// beyond it.
    pub(crate) fn set_gaussian_terms(
        &self,
        (mean_rad, sd_rad): (f64, f64),
        near: &mut usize,
        terms: &mut Vec<RowTerm>,
    ) {
        let nodes = &self.theta_rad;
        let reach_rad = GAUSSIAN_REACH * sd_rad;
        if nodes.len() == 1 || reach_rad <= 1e-12 {
            let place = RayPlace {
                theta_rad: mean_rad,
                width_rad: 0.0,
            };
            return self.set_terms(&place, near, terms);
        }
        terms.clear();
        let (low, high) = (mean_rad - reach_rad, mean_rad + reach_rad);
        let first = node_above(nodes, low, near)
            .saturating_sub(1)
            .min(nodes.len() - 2);
        let inside = nodes[first + 1..].iter().take_while(|node| **node < high);
        let last = (first + 1 + inside.count()).min(nodes.len() - 1);
        let empty = |node: usize| RowTerm {
            node,
            weight: 0.0,
            bend_weight: 0.0,
        };
        terms.extend((first..=last).map(empty));
        let mut all = 0.0;
        for lower in first..last {
            // Beyond the ends of the axis the last step goes on, with its end's value.
            let from = if lower == 0 {
                low
            } else {
                nodes[lower].max(low)
            };
            let ends_here = lower + 2 == nodes.len();
            let to = if ends_here {
                high
            } else {
                nodes[lower + 1].min(high)
            };
            let n_pieces = ((to - from) / (GAUSSIAN_PIECE * sd_rad)).ceil().max(0.0);
            let length = (to - from) / n_pieces;
            let step = nodes[lower + 1] - nodes[lower];
            for piece in 0..n_pieces as usize {
                let middle = from + (piece as f64 + 0.5) * length;
                for offset in [-GAUSS_OFFSET, GAUSS_OFFSET] {
                    let theta_rad = middle + offset * length;
                    let off = (theta_rad - mean_rad) / sd_rad;
                    let share = length * (-0.5 * off * off).exp();
                    let fraction = ((theta_rad - nodes[lower]) / step).clamp(0.0, 1.0);
                    all += share;
                    let here = lower - first;
                    terms[here].weight += (share * (1.0 - fraction)) as f32;
                    terms[here].bend_weight += (share * 0.5 * fraction * (1.0 - fraction)) as f32;
                    terms[here + 1].weight += (share * fraction) as f32;
                }
            }
        }
        let scale = (1.0 / all) as f32;
        for term in terms {
            term.weight *= scale;
            term.bend_weight *= scale;
        }
    }

    /// The mean of the linear interpolant over the angles of a pixel, which end where the rows end;
    /// its value where they are too few for a mean.
    fn add_angles(&self, place: &RayPlace, near: &mut usize, terms: &mut Vec<RowTerm>) {
        let nodes = &self.theta_rad;
        let low = (place.theta_rad - 0.5 * place.width_rad).max(nodes[0]);
        let high = (place.theta_rad + 0.5 * place.width_rad).min(nodes[nodes.len() - 1]);
        let node = |node: usize, weight: f32| RowTerm {
            node,
            weight,
            bend_weight: 0.0,
        };
        if nodes.len() == 1 {
            terms.push(node(0, 1.0));
            return;
        }
        // Too narrow for a mean in f64.
        if high - low <= 1e-12 {
            let above = node_above(nodes, place.theta_rad, near);
            let (lower, fraction) = linear_place(nodes, above, place.theta_rad);
            terms.push(RowTerm {
                bend_weight: bend_weight_at(fraction),
                ..node(lower, 1.0 - fraction)
            });
            terms.push(node(lower + 1, fraction));
            return;
        }
        let first = node_above(nodes, low, near).saturating_sub(1);
        let inside = nodes[first..].iter().take_while(|node| **node < high);
        let end = (first + inside.count() + 1).min(nodes.len());
        terms.extend((first..end).map(|index| node(index, 0.0)));
        for lower in first..end - 1 {
            let step = nodes[lower + 1] - nodes[lower];
            let from = ((low - nodes[lower]) / step).clamp(0.0, 1.0);
            let to = ((high - nodes[lower]) / step).clamp(0.0, 1.0);
            let share = step / (high - low);
            // Integrals of the two hat functions of a step over its covered part, and of x (1 - x)/2.
            let upper_part = 0.5 * (to * to - from * from) * share;
            let lower_part = (to - from) * share - upper_part;
            let bend_part = 0.5 * upper_part - (to.powi(3) - from.powi(3)) * share / 6.0;
            terms[lower - first].weight += lower_part as f32;
            terms[lower - first].bend_weight = bend_part as f32;
            terms[lower - first + 1].weight += upper_part as f32;
        }
    }
}

/// x (1 - x)/2.
fn bend_weight_at(fraction: f32) -> f32 {
    0.5 * fraction * (1.0 - fraction)
}

/// The first node above a value, from `near` on: neighboring rays lie between the same nodes.
pub(crate) fn node_above(nodes: &[f64], value: f64, near: &mut usize) -> usize {
    // The last ray may have asked other rows.
    let mut above = (*near).min(nodes.len());
    while above < nodes.len() && nodes[above] <= value {
        above += 1;
    }
    while above > 0 && nodes[above - 1] > value {
        above -= 1;
    }
    *near = above;
    above
}

/// Lower node and fraction above it on an axis of at least two, with the first node above the value;
/// the ends hold beyond it.
pub(crate) fn linear_place(nodes: &[f64], above: usize, value: f64) -> (usize, f32) {
    let lower = above.saturating_sub(1).min(nodes.len() - 2);
    let fraction = (value - nodes[lower]) / (nodes[lower + 1] - nodes[lower]);
    (lower, fraction.clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Gaussian over uneven nodes, in sums of powers of the angle.
    fn powers(axis: &AngleAxis, gaussian: (f64, f64)) -> [f64; 3] {
        let mut terms = Vec::new();
        axis.set_gaussian_terms(gaussian, &mut 0, &mut terms);
        let of_power = |power: i32| {
            let value = |node: usize| axis.theta_rad[node].powi(power);
            let terms = terms.iter();
            terms
                .map(|term| f64::from(term.weight) * value(term.node))
                .sum()
        };
        [0, 1, 2].map(of_power)
    }

    #[test]
    fn a_gaussian_has_its_mean_and_its_variance() {
        let nodes: Vec<f64> = (0..400)
            .map(|step| 0.005 * f64::from(step) + 0.001 * f64::from(step % 3))
            .collect();
        let axis = AngleAxis::new(&nodes);
        for sd_rad in [0.003, 0.01, 0.05, 0.2] {
            let [all, mean, square] = powers(&axis, (1.0, sd_rad));
            assert!((all - 1.0).abs() < 1e-5 && (mean - 1.0).abs() < 2e-5);
            // Four standard deviations lack 1e-3 of the variance; steps of h add h²/6.
            let variance = square - mean * mean;
            let expected = sd_rad * sd_rad;
            assert!((variance - expected).abs() < 2e-3 * expected + 0.006_f64.powi(2) / 6.0);
        }
    }

    #[test]
    fn a_gaussian_that_narrows_becomes_a_point_and_beyond_the_axis_its_end() {
        let axis = AngleAxis::new(&[1.0, 1.5, 1.6, 2.0]);
        for sd_rad in [0.0, 1e-9, 1e-4] {
            let [all, mean, _] = powers(&axis, (1.55, sd_rad));
            assert!((all - 1.0).abs() < 1e-6 && (mean - 1.55).abs() < 1e-6);
        }
        for (mean_rad, end) in [(0.5, 1.0), (2.5, 2.0)] {
            let [all, mean, _] = powers(&axis, (mean_rad, 0.1));
            assert!((all - 1.0).abs() < 1e-6 && (mean - end).abs() < 1e-6);
        }
    }

    #[test]
    fn the_node_above_a_value_does_not_depend_on_where_the_search_starts() {
        let nodes = [1.0, 2.0, 2.5, 4.0];
        for value in [0.0, 1.0, 1.5, 2.0, 2.4, 2.5, 3.0, 4.0, 5.0] {
            let expected = nodes.partition_point(|node| *node <= value);
            for start in 0..10 {
                let mut near = start;
                assert_eq!(node_above(&nodes, value, &mut near), expected);
                assert_eq!(near, expected);
            }
        }
    }
}
