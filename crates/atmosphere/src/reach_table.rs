//! The table of reaches of a constituent: how far it is to the top of the air, measured in air of the
//! density at the start.
//!
//! reach(h, mu) = integral to the top of rho ds / rho(h)
//! Computed by Gauss-Legendre quadrature in u, s = D u^2, tabulated on axes on which cubic
//! interpolation of 1/reach in mu and of reach in h is good to 1e-6: mu = a quadratic series that is
//! dense at the horizontal, where the scale is sqrt(2 H/R) = 0.05 for air and 0.02 for haze; heights a
//! quadratic series that is dense below the top, where the reach falls to 0 like a square root.

use ndarray::Array2;
use niji_exchange::AirConstituent;
use niji_exchange::DensityLaw;
use niji_geometry::Planet;
use rayon::iter::IntoParallelIterator;
use rayon::iter::ParallelIterator;

use crate::gauss_legendre::Rule;
use crate::leg::RayPoint;
use crate::optical_length::length_by_rule;
use crate::optical_length::scale_height_m;

/// Heights of the table.
const N_HEIGHTS: usize = 108;
/// Cosines of the table.
const N_MU: usize = 144;
/// Nodes of the quadrature: what a single exponential needs for 1e-14, and twice as many for others.
const N_NODES: usize = 24;

/// Fills the table of reaches of a constituent with an exponential profile; others need none.
pub(crate) fn fill_reaches(air: &mut AirConstituent, planet_radius_m: f64) {
    match air.law {
        DensityLaw::Linear => return,
        DensityLaw::Exponential => {}
    }
    let (bottom_m, top_m) = (air.height_m[0], air.height_m[air.height_m.len() - 1]);
    let heights_m = heights(bottom_m, top_m);
    let cosines: Vec<f64> = (0..N_MU)
        .map(|j| (j as f64 / (N_MU - 1) as f64).powi(2))
        .collect();
    let planet = Planet {
        radius_m: planet_radius_m,
    };
    let profile = &*air;
    let rule = Rule::new(match scale_height_m(profile) {
        Some(_) => N_NODES,
        None => 2 * N_NODES,
    });
    let row = |i: usize| -> Vec<f64> {
        let height_m = heights_m[i];
        let reach = |&mu: &f64| {
            if i + 1 == N_HEIGHTS {
                return 0.0;
            }
            let start = RayPoint { height_m, mu };
            length_by_rule(profile, planet, &rule, start) / profile.density_at(height_m)
        };
        cosines.iter().map(reach).collect()
    };
    // Rows are computed side by side and gathered in order.
    let rows: Vec<Vec<f64>> = (0..N_HEIGHTS).into_par_iter().map(row).collect();
    air.reach_m = Array2::from_shape_fn((N_HEIGHTS, N_MU), |(i, j)| rows[i][j]);
    air.reach_height_m = heights_m;
    air.reach_mu = cosines;
}

/// Heights from bottom to top, quadratically dense below the top.
fn heights(bottom_m: f64, top_m: f64) -> Vec<f64> {
    let last = (N_HEIGHTS - 1) as f64;
    let height = |i: usize| {
        if i == 0 {
            return bottom_m;
        }
        let from_top = (N_HEIGHTS - 1 - i) as f64 / last;
        top_m - (top_m - bottom_m) * from_top * from_top
    };
    (0..N_HEIGHTS).map(height).collect()
}
