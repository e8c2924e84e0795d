//! The table of phase functions beside a table of what is seen.
//!
//! Light that drops scatter more than once comes from all directions, by every way through a drop, and each time
//! blurs what was sharp before by tens of degrees: it needs all angles and orders, but neither fringes nor
//! many sizes. So what waves do to large drops is left out, and the light is averaged over a disc twice as wide as
//! the step of its angles, which holds all of it in sums over them. Radii are even in ln r, of single sizes each a
//! mean up to its neighbors.

use std::f64::consts::PI;

use niji_exchange::ScatteringTable;

use crate::builder::described;
use crate::builder::values_at;
use crate::error::Error;
use crate::progress::Progress;
use crate::request::SizeRows;
use crate::request::TableRequest;
use crate::theory::ORDERS;
use crate::theory::Theory;
use crate::theta_axis::TableAngles;

/// Its angles, half a degree apart.
pub const N_PHASE_ANGLES: usize = 361;
const STEP_RAD: f64 = PI / (N_PHASE_ANGLES - 1) as f64;

/// What it leaves to the cheaper theory, in parts of what the table of what is seen does, and at most.
const COARSER: f64 = 10.0;
const COARSEST: f64 = 0.1;

/// Radii at most.
const MOST_RADII: usize = 24;

/// Makes the table of phase functions of [`TableRequest::of_phase_functions`].
///
/// # Errors
/// As [`crate::scattering_table`].
pub fn phase_functions(
    request: &TableRequest,
    progress: Progress,
) -> Result<ScatteringTable, Error> {
    request.check()?;
    let request = request.of_phase_functions();
    let angles = TableAngles {
        theta_rad: (0..N_PHASE_ANGLES)
            .map(|index| index as f64 * STEP_RAD)
            .collect(),
        of_orders: Vec::new(),
    };
    let values = values_at(&request, &angles, None, progress)?;
    Ok(described(&request, angles.theta_rad, values))
}

impl TableRequest<'_> {
    /// The same drops, as spheres, at all angles and with all orders, of few radii.
    #[must_use]
    pub fn of_phase_functions(&self) -> Self {
        let theory = match self.theory {
            // Its fringes are narrower than the disc, or spread over less than a few degrees.
            Theory::Uniform | Theory::Airy => Theory::Geometric,
            theory => theory,
        };
        let radii = &self.effective_radius_um;
        let (first, last) = (radii[0], radii[radii.len() - 1]);
        let most = if theory == Theory::Geometric {
            // The same for all.
            2
        } else {
            MOST_RADII
        };
        let n_steps = radii.len().min(most) - 1;
        let ln_step = (last / first).ln() / n_steps.max(1) as f64;
        let inner = (1..n_steps).map(|index| first * (index as f64 * ln_step).exp());
        let mut effective_radius_um = vec![first];
        effective_radius_um.extend(inner);
        if n_steps > 0 {
            effective_radius_um.push(last);
        }
        Self {
            theory,
            orders: theory.orders_among(&ORDERS.collect::<Vec<u32>>()),
            theta_range_rad: (0.0, PI),
            tolerance: (COARSER * self.tolerance).min(COARSEST),
            effective_radius_um,
            rows: match self.rows {
                SizeRows::Bins {
                    narrowest_variance, ..
                } if n_steps > 0 => SizeRows::Bins {
                    ln_step: ln_step.min(1.0),
                    narrowest_variance,
                },
                rows => rows,
            },
            motion: None,
            sun_disc_diameter_rad: 2.0 * STEP_RAD,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use niji_radiometry::Water;
    use niji_radiometry::WavelengthGrid;

    use crate::builder::scattering_table;
    use crate::progress::unwatched;

    use super::*;

    fn request(theory: Theory, effective_radius_um: Vec<f64>) -> TableRequest<'static> {
        TableRequest {
            theory,
            orders: vec![2, 3],
            theta_range_rad: (2.3, 2.5),
            tolerance: 5e-3,
            wavelengths: WavelengthGrid::new(450.0, 200.0, 2).unwrap(),
            effective_radius_um,
            effective_variance: vec![0.1],
            rows: SizeRows::Laws,
            motion: None,
            sun_disc_diameter_rad: 0.0093,
            water: Water::pure(15.0),
            airy_table: None,
        }
    }

    /// ∫ t dω and ∫ t cos θ dω of natural light of the first size and wavelength, beyond 5 degrees: within, the
    /// lobe of diffraction is cut by the renderer.
    fn moments(table: &ScatteringTable) -> [f64; 2] {
        let light = |angle: usize| {
            let of = |j| f64::from(table.values[[j, 0, 0, 0, angle]]);
            0.5 * (of(0) + of(1))
        };
        let mut sums = [0.0; 2];
        for (index, pair) in table.theta_rad.windows(2).enumerate() {
            // Simpson's rule of the straight line between both angles.
            let middle = 0.5 * (pair[0] + pair[1]);
            if middle < PI / 36.0 {
                continue;
            }
            for (theta, value, weight) in [
                (pair[0], light(index), 1.0),
                (middle, 0.5 * (light(index) + light(index + 1)), 4.0),
                (pair[1], light(index + 1), 1.0),
            ] {
                let part = 2.0 * PI * value * theta.sin() * weight * (pair[1] - pair[0]) / 6.0;
                sums[0] += part;
                sums[1] += part * theta.cos();
            }
        }
        sums
    }

    #[test]
    fn all_light_is_there_and_goes_where_a_fine_table_has_it() {
        for (theory, radius_um) in [(Theory::Uniform, 500.0), (Theory::Mie, 5.0)] {
            let seen = request(theory, vec![radius_um]);
            let coarse = phase_functions(&seen, &unwatched).unwrap();
            let fine = TableRequest {
                theory,
                tolerance: 1e-3,
                ..seen.of_phase_functions()
            };
            let fine = scattering_table(&fine, &unwatched).unwrap();
            let ([all, forward], [of_fine, forward_of_fine]) = (moments(&coarse), moments(&fine));
            let off = [all - of_fine, forward - forward_of_fine];
            assert!(
                off.iter().all(|off| off.abs() < 1e-2 * of_fine),
                "{theory:?} {off:?}"
            );
        }
    }

    #[test]
    fn radii_are_few_and_even_with_both_ends() {
        let radii: Vec<f64> = (0..100).map(|n| 10.0 * 1.05_f64.powi(n)).collect();
        let last = radii[99];
        let few = request(Theory::BySize, radii)
            .of_phase_functions()
            .effective_radius_um;
        assert_eq!((few.len(), few[0], few[23]), (24, 10.0, last));
        let step = |pair: &[f64]| pair[1] / pair[0];
        let first = step(&few[..2]);
        assert!(
            few.windows(2)
                .all(|pair| (step(pair) / first - 1.0).abs() < 1e-9)
        );
        for radii in [vec![7.0], vec![7.0, 9.0]] {
            let kept = request(Theory::Uniform, radii.clone()).of_phase_functions();
            assert_eq!(kept.effective_radius_um, radii);
        }
    }
}
