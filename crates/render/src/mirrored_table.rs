//! A scattering table as light from a streak of mirrored suns sees it: of one polarization, and on no finer
//! angles than the streak resolves.
//!
//! On even angles h apart the value at a node is the mean under its hat,
//! t_j = int hat_j(theta) t(theta) d theta / int hat_j d theta,  hat_j = max(0, 1 - |theta - theta_j|/h)
//! which, interpolated linearly again, is the table averaged over a kernel of the variance h²/3.

use ndarray::Array1;
use ndarray::ArrayView1;
use ndarray::Axis;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::ScatteringTable;

/// Of which light a table is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Polarization {
    /// Half the sum of both.
    Natural,
    /// Across the plane of scattering.
    Perpendicular,
    /// Along it.
    Parallel,
}

impl Polarization {
    /// Those that light is made of, across first.
    pub(crate) const BOTH: [Self; 2] = [Self::Perpendicular, Self::Parallel];
}

/// Places and weights of a mean over angles.
type Means = Vec<Vec<(usize, f64)>>;

/// The table of a polarization, in both places where it has one, on even angles `step_rad` apart; on its
/// own angles if that is 0.
pub(crate) fn mirrored_table(
    table: &ScatteringTable,
    polarization: Polarization,
    step_rad: f64,
) -> ScatteringTable {
    let even = even_angles(&table.theta_rad, step_rad);
    let angles_from = |own: &Vec<f64>| even.clone().unwrap_or_else(|| own.clone());
    let of_lane = |(s, p): (ArrayView1<f32>, ArrayView1<f32>), means: &Option<Means>| {
        let value = |angle: usize| match polarization {
            Polarization::Natural => 0.5 * (s[angle] + p[angle]),
            Polarization::Perpendicular => s[angle],
            Polarization::Parallel => p[angle],
        };
        match means {
            None => Array1::from_shape_fn(s.len(), value),
            Some(means) => means
                .iter()
                .map(|mean| {
                    let terms = mean.iter();
                    let terms = terms.map(|(angle, weight)| weight * f64::from(value(*angle)));
                    terms.sum::<f64>() as f32
                })
                .collect(),
        }
    };
    // All values on one's own angles, in their own shape but for the last axis.
    let turned = |source: ndarray::ArrayViewD<f32>, theta_rad: &[f64]| {
        let means = even.as_ref().map(|angles| hat_means(theta_rad, angles));
        let mut shape = source.raw_dim();
        shape[source.ndim() - 1] = even.as_ref().map_or(theta_rad.len(), Vec::len);
        let mut into = ndarray::ArrayD::zeros(shape);
        let (s, p) = (source.index_axis(Axis(0), 0), source.index_axis(Axis(0), 1));
        let (mut first, mut second) = into.view_mut().split_at(Axis(0), 1);
        let lanes = first.lanes_mut(Axis(source.ndim() - 1)).into_iter();
        let others = second.lanes_mut(Axis(source.ndim() - 1)).into_iter();
        let sources = s.lanes(Axis(s.ndim() - 1)).into_iter();
        let sources = sources.zip(p.lanes(Axis(p.ndim() - 1)));
        for ((mut lane, mut other), sources) in lanes.zip(others).zip(sources) {
            lane.assign(&of_lane(sources, &means));
            other.assign(&lane);
        }
        into
    };
    let same_axes = "an array has as many axes as its view";
    let order = |order: &MovedOrder| MovedOrder {
        order: order.order,
        shifts: order.shifts.clone(),
        values: turned(order.values.view().into_dyn(), &order.theta_rad)
            .into_dimensionality()
            .expect(same_axes),
        theta_rad: angles_from(&order.theta_rad),
    };
    let moved = table.moved.as_ref().map(|moved| MovedBows {
        drops: moved.drops.clone(),
        orders: moved.orders.iter().map(order).collect(),
    });
    ScatteringTable {
        theory: table.theory.clone(),
        orders: table.orders.clone(),
        wavelengths: table.wavelengths,
        theta_rad: angles_from(&table.theta_rad),
        effective_radius_um: table.effective_radius_um.clone(),
        effective_variance: table.effective_variance.clone(),
        values: turned(table.values.view().into_dyn(), &table.theta_rad)
            .into_dimensionality()
            .expect(same_axes),
        moved,
        row_use: table.row_use,
        relative_error: table.relative_error,
        sun_disc_diameter_rad: table.sun_disc_diameter_rad,
        split_theta_rad: table.split_theta_rad,
        forward_fraction_left_out: table.forward_fraction_left_out,
        water: table.water,
        phase_functions: None,
        interpolation_error: table.interpolation_error,
    }
}

/// Variance of the kernel over which such a table is averaged that the table itself is not.
pub(crate) fn added_variance(theta_rad: &[f64], step_rad: f64) -> f64 {
    let angles = even_angles(theta_rad, step_rad);
    angles.map_or(0.0, |angles| (angles[1] - angles[0]).powi(2) / 3.0)
}

/// Even angles at most `step_rad` apart, where these are fewer than the table's.
fn even_angles(theta_rad: &[f64], step_rad: f64) -> Option<Vec<f64>> {
    let (first, last) = (*theta_rad.first()?, *theta_rad.last()?);
    let n_steps = ((last - first) / step_rad).ceil().max(1.0);
    let is_coarser = n_steps.is_finite() && n_steps + 1.0 < theta_rad.len() as f64;
    is_coarser.then(|| {
        let angle = |step: usize| first + (last - first) * step as f64 / n_steps;
        (0..=n_steps as usize).map(angle).collect()
    })
}

/// Weights of the table's angles in the mean under the hat of each new one.
fn hat_means(theta_rad: &[f64], angles: &[f64]) -> Means {
    let n = angles.len();
    let mean = |node: usize| {
        let at = angles[node];
        let (from, to) = (
            angles[node.saturating_sub(1)],
            angles[(node + 1).min(n - 1)],
        );
        let first = theta_rad.partition_point(|theta| *theta <= from);
        let inside = theta_rad[first..].iter().take_while(|theta| **theta < to);
        let mut ends: Vec<f64> = [from, at, to].into_iter().chain(inside.copied()).collect();
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut weights = vec![0.0; ends.len() + 2];
        let lowest = first.saturating_sub(1);
        for pair in ends.windows(2) {
            let middle = 0.5 * (pair[0] + pair[1]);
            let lower = theta_rad
                .partition_point(|theta| *theta <= middle)
                .clamp(1, theta_rad.len() - 1)
                - 1;
            let step = theta_rad[lower + 1] - theta_rad[lower];
            // Simpson's rule is exact for the product of two straight lines.
            for (theta, share) in [(pair[0], 1.0), (middle, 4.0), (pair[1], 1.0)] {
                let far = if theta < at { at - from } else { to - at };
                let hat = if far > 0.0 {
                    1.0 - (theta - at).abs() / far
                } else {
                    1.0
                };
                let fraction = (theta - theta_rad[lower]) / step;
                let share = share * (pair[1] - pair[0]) * hat;
                weights[lower - lowest] += share * (1.0 - fraction);
                weights[lower + 1 - lowest] += share * fraction;
            }
        }
        let all: f64 = weights.iter().sum();
        let weights = weights.into_iter().enumerate();
        let weights = weights.filter(|(_, weight)| *weight > 0.0);
        weights
            .map(|(offset, weight)| (lowest + offset, weight / all))
            .collect()
    };
    (0..n).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uneven() -> Vec<f64> {
        (0..200)
            .map(|step| 1.0 + 0.01 * f64::from(step) + 0.003 * f64::from(step % 2))
            .collect()
    }

    fn averaged(value: impl Fn(f64) -> f64, step_rad: f64) -> Vec<(f64, f64)> {
        let old = uneven();
        let angles = even_angles(&old, step_rad).expect("these are fewer");
        let means = hat_means(&old, &angles).into_iter();
        let means = means.map(|mean| mean.iter().map(|(angle, w)| w * value(old[*angle])).sum());
        angles.into_iter().zip(means).collect()
    }

    #[test]
    fn straight_lines_stay_as_they_are() {
        let found = averaged(|theta| 3.0 * theta - 1.0, 0.08);
        // The hats at the ends have one side.
        for (theta, value) in &found[1..found.len() - 1] {
            assert!((value - (3.0 * theta - 1.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_parabola_is_lifted_by_the_variance_of_a_hat() {
        let found = averaged(|theta| theta * theta, 0.08);
        let step = found[1].0 - found[0].0;
        for (theta, value) in &found[1..found.len() - 1] {
            let lifted = value - theta * theta;
            // The interpolant of the parabola itself lies up to 0.013²/4 above it.
            assert!((lifted - step * step / 6.0).abs() < 5e-5, "{lifted}");
        }
    }

    #[test]
    fn finer_angles_than_those_of_the_table_are_not_made() {
        assert!(even_angles(&uneven(), 0.001).is_none());
        assert!(even_angles(&uneven(), 0.0).is_none());
        assert!(even_angles(&[1.0], 0.1).is_none());
    }
}
