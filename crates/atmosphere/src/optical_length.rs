//! Equivalent length of a ray through one constituent of the air, to its top.
//!
//! L = integral rho(h(s)) ds,  optical depth = extinction * L
//! by four methods of different price. The errors stated are the worst against converged quadrature
//! over zenith angles from 0 to 90 degrees at sea level, Rayleigh air 100 km high; the tests in
//! tests/columns.rs hold them. Price of one column in density samples (one exponential each): the
//! number of nodes or steps; Chapman's form costs two, the table about four.

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::DensityLaw;
use niji_geometry::Planet;

use crate::chapman::chapman_erfcx;
use crate::gauss_legendre::Rule;
use crate::leg::RayPoint;
use crate::leg::crossings;
use crate::leg::legs;

/// How an equivalent length is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OpticalLength {
    /// Equal steps, the density taken in their middle: the published sum. With 50 steps the error is
    /// 2.6e-3, and falls with the square of their number.
    Midpoint {
        /// Number of steps, at least 1.
        n_steps: usize,
    },
    /// Gauss-Legendre quadrature with s = D u^2 on every leg that rises or falls. With 16 nodes the
    /// error is below 1e-7.
    GaussLegendre {
        /// Number of nodes on every leg, at least 1.
        n_nodes: usize,
    },
    /// Chapman's function by one scaled complementary error function, for single exponential layers
    /// of unlimited height; others fall back on the table. Error 1.3e-3.
    Chapman,
    /// The table of reaches. Error below 1e-6 up to nine tenths of a constituent's height, and 3e-5
    /// in the last tenth.
    Table,
}

/// Equivalent length to the top of the air, m; infinite for a ray that ends on the ground.
///
/// # Panics
/// If there is no constituent of that index.
pub fn optical_length_m(
    air: &AtmosphereTable,
    constituent_index: usize,
    method: OpticalLength,
    [height_m, cos_zenith]: [f64; 2],
) -> f64 {
    let planet = Planet {
        radius_m: air.planet_radius_m,
    };
    if planet.hits_ground(height_m, cos_zenith) {
        return f64::INFINITY;
    }
    let constituent = &air.constituents[constituent_index];
    let start = RayPoint {
        height_m,
        mu: cos_zenith,
    };
    match method {
        OpticalLength::Midpoint { n_steps } => {
            length_by_midpoints(constituent, planet, n_steps, start)
        }
        OpticalLength::GaussLegendre { n_nodes } => {
            length_by_rule(constituent, planet, &Rule::new(n_nodes), start)
        }
        OpticalLength::Chapman => match scale_height_m(constituent) {
            Some(scale_height_m) => length_by_chapman(constituent, planet, scale_height_m, start),
            None => air.column_at(constituent_index, height_m, cos_zenith),
        },
        OpticalLength::Table => air.column_at(constituent_index, height_m, cos_zenith),
    }
}

/// The part of a ray below the top of a constituent.
fn chord(air: &AirConstituent, planet: Planet, start: RayPoint) -> Option<[f64; 2]> {
    let top_m = air.height_m[air.height_m.len() - 1];
    let (enter_m, leave_m) = planet.shell_chord(start.height_m, start.mu, top_m)?;
    Some([enter_m, leave_m])
}

/// The published sum over equal steps.
pub(crate) fn length_by_midpoints(
    air: &AirConstituent,
    planet: Planet,
    n_steps: usize,
    start: RayPoint,
) -> f64 {
    let Some([enter_m, leave_m]) = chord(air, planet, start) else {
        return 0.0;
    };
    let n_steps = n_steps.max(1);
    let step_m = (leave_m - enter_m) / n_steps as f64;
    let density = |i: usize| {
        let distance_m = enter_m + (i as f64 + 0.5) * step_m;
        air.density_at(planet.height_along_ray(start.height_m, start.mu, distance_m))
    };
    (0..n_steps).map(density).sum::<f64>() * step_m
}

/// Quadrature on legs, cut also where the profile has a kink.
pub(crate) fn length_by_rule(
    air: &AirConstituent,
    planet: Planet,
    rule: &Rule,
    start: RayPoint,
) -> f64 {
    let Some(ends_m) = chord(air, planet, start) else {
        return 0.0;
    };
    // The middle node of a plain exponential profile is no kink, and its density needs no search among nodes.
    let scale_m = scale_height_m(air);
    let kinks = scale_m.map_or(air.height_m.as_slice(), |_| &[]);
    let density = |height_m: f64| match scale_m {
        Some(scale_m) => air.density[0] * ((air.height_m[0] - height_m).min(0.0) / scale_m).exp(),
        None => air.density_at(height_m),
    };
    let breaks_m = crossings(planet, start, kinks);
    let leg_length = |leg: crate::leg::Leg| {
        rule.integrate(0.0, 1.0, |u| {
            let height_m = planet.height_along_ray(start.height_m, start.mu, leg.distance_m(u));
            leg.stretch_m(u) * density(height_m)
        })
    };
    legs(planet, start, ends_m, &breaks_m)
        .into_iter()
        .map(leg_length)
        .sum()
}

/// Chapman's function; downwards by way of the perigee.
fn length_by_chapman(air: &AirConstituent, planet: Planet, scale_m: f64, start: RayPoint) -> f64 {
    let rising = |height_m: f64, mu: f64| {
        let density = (-height_m / scale_m).exp() * air.density_at(0.0);
        density * scale_m * chapman_erfcx((planet.radius_m + height_m) / scale_m, mu)
    };
    if start.mu >= 0.0 {
        return rising(start.height_m, start.mu);
    }
    let perigee_m = planet.perigee_height(start.height_m, start.mu);
    2.0 * rising(perigee_m, 0.0) - rising(start.height_m, -start.mu)
}

/// Scale height of a profile that is one exponential throughout.
pub(crate) fn scale_height_m(air: &AirConstituent) -> Option<f64> {
    match air.law {
        DensityLaw::Linear => return None,
        DensityLaw::Exponential => {}
    }
    let last = air.height_m.len() - 1;
    let scale_m =
        (air.height_m[last] - air.height_m[0]) / (air.density[0] / air.density[last]).ln();
    let first = (air.height_m[0], air.density[0]);
    let fits = |(&height_m, &density): (&f64, &f64)| {
        let expected = first.1 * ((first.0 - height_m) / scale_m).exp();
        // f32 in files rounds densities to 6e-8.
        (density / expected - 1.0).abs() < 1e-6
    };
    let is_single = air.height_m.iter().zip(&air.density).all(fits);
    (is_single && scale_m > 0.0 && scale_m.is_finite()).then_some(scale_m)
}
