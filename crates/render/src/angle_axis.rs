//! Places on the axis of scattering angles of a scattering table.
//!
//! A table is interpolated linearly:
//! t(theta) = sum_n w_n t_n,  with weights w_n >= 0 that sum to 1,
//! or has the mean of that over the angles of a pixel. Between two nodes of an axis h apart it errs by
//! x (1 - x)/2 h² t'' at the fraction x of the way, and by the mean of this.

/// Where a ray stands on the table's axis of angles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayPlace {
    /// Scattering angle of the ray.
    pub(crate) theta_rad: f64,
    /// Scattering angles that its pixel spans; 0 for a point.
    pub(crate) width_rad: f64,
}

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
fn node_above(nodes: &[f64], value: f64, near: &mut usize) -> usize {
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
fn linear_place(nodes: &[f64], above: usize, value: f64) -> (usize, f32) {
    let lower = above.saturating_sub(1).min(nodes.len() - 2);
    let fraction = (value - nodes[lower]) / (nodes[lower + 1] - nodes[lower]);
    (lower, fraction.clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

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
