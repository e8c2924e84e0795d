//! A ray through shells of air, as weights of the source at the shells that it crosses.
//!
//! L = integral of S(t) exp(-t) dt = sum over crossings of W_k S_k,  t optical depth from the start.
//! S is taken as linear in t between two crossings at optical depths t and t + d, so that the panel
//! adds  e^-t (1 - g)  to the weight of the near one and  e^-t (g - e^-d)  to that of the far one,
//!   g = (1 - e^-d)/d.
//! The weights add up to 1 - e^-tau whatever the thickness of a panel: no light is lost.
//! [OK87] Olson and Kunasz, J. Quant. Spectrosc. Radiat. Transfer 38, 325-336 (1987).

use niji_exchange::AtmosphereTable;
use niji_geometry::Planet;

use crate::leg::RayPoint;

/// Optical depth of a panel below which its weights are series.
const THIN: f64 = 1e-4;

/// One crossing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// The shell, or none at an end of the ray between two shells.
    pub(crate) shell: Option<usize>,
    pub(crate) distance_m: f64,
    /// The height there and the cosine of the zenith angle of the ray.
    pub(crate) point: RayPoint,
}

/// The crossings of a ray and their weights.
#[derive(Debug, Clone)]
pub(crate) struct ShellPath {
    pub(crate) crossings: Vec<Crossing>,
    /// `[crossing * n_wavelengths + wavelength]`
    pub(crate) weights: Vec<f32>,
    /// Distance to the ground and transmittance up to it, by wavelength.
    pub(crate) ground: Option<(f64, Vec<f32>)>,
}

impl ShellPath {
    /// The path of a ray from a point inside the air over a distance, which may be infinite.
    pub(crate) fn new(
        air: &AtmosphereTable,
        shells_m: &[f64],
        start: RayPoint,
        length_m: f64,
    ) -> Self {
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let mut crossings = all_crossings(planet, shells_m, start);
        let ground_m = planet.distance_to_ground(start.height_m, start.mu);
        if crossings
            .last()
            .is_some_and(|last| last.distance_m > length_m)
        {
            crossings.retain(|crossing| crossing.distance_m < length_m);
            crossings.push(Crossing {
                shell: None,
                distance_m: length_m,
                point: start.advanced(planet, length_m),
            });
        }
        let n_wavelengths = air.wavelengths.len();
        let mut weights = vec![0.0_f64; crossings.len() * n_wavelengths];
        let mut depths = vec![0.0_f64; n_wavelengths];
        let mut panel = vec![0.0_f64; n_wavelengths];
        for (far, pair) in (1..).zip(crossings.windows(2)) {
            panel_depths(air, pair, &mut panel);
            for (wavelength, (depth, d)) in depths.iter_mut().zip(&panel).enumerate() {
                let [near_share, far_share] = linear_shares(*d);
                let arriving = (-*depth).exp();
                weights[(far - 1) * n_wavelengths + wavelength] += arriving * near_share;
                weights[far * n_wavelengths + wavelength] += arriving * far_share;
                *depth += d;
            }
        }
        let to_ground = |distance_m: f64| {
            // f32: as the light that it dims.
            let transmittance = depths.iter().map(|depth| (-depth).exp() as f32);
            (distance_m, transmittance.collect())
        };
        Self {
            crossings,
            // f32: weights of light that is known to 1e-3.
            weights: weights.into_iter().map(|weight| weight as f32).collect(),
            ground: ground_m
                .filter(|&distance_m| distance_m <= length_m)
                .map(to_ground),
        }
    }
}

/// Optical depth between two crossings by wavelength.
fn panel_depths(air: &AtmosphereTable, pair: &[Crossing], depths: &mut [f64]) {
    depths.fill(0.0);
    let (near, length_m) = (pair[0].point, pair[1].distance_m - pair[0].distance_m);
    for (index, constituent) in air.constituents.iter().enumerate() {
        let equivalent_m = air.segment_length(index, near.height_m, near.mu, length_m);
        for (depth, extinction_m1) in depths.iter_mut().zip(&constituent.extinction_m1) {
            // Rounding of two equal lengths outside the layer.
            *depth += (extinction_m1 * equivalent_m).max(0.0);
        }
    }
}

/// Shares of the source at the near and at the far end of a panel of optical depth d.
fn linear_shares(d: f64) -> [f64; 2] {
    if d < THIN {
        return [
            d * (0.5 - d * (1.0 / 6.0 - d / 24.0)),
            d * (0.5 - d * (1.0 / 3.0 - d / 8.0)),
        ];
    }
    let g = -(-d).exp_m1() / d;
    [1.0 - g, g - (-d).exp()]
}

/// Where a ray crosses shells, its start included, up to the ground or the top.
fn all_crossings(planet: Planet, shells_m: &[f64], start: RayPoint) -> Vec<Crossing> {
    let here = shells_m.iter().position(|&shell_m| {
        // Compared with what was stored: a ray starts at a node itself.
        (shell_m - start.height_m).abs() <= 0.0
    });
    let mut found = vec![(here, 0.0)];
    let n_below = shells_m.partition_point(|&shell_m| shell_m < start.height_m);
    let first_above = shells_m.partition_point(|&shell_m| shell_m <= start.height_m);
    let chord = |shell: usize| planet.shell_chord(start.height_m, start.mu, shells_m[shell]);
    let ground_m = planet.distance_to_ground(start.height_m, start.mu);
    let mut lowest = first_above;
    if let Some(ground_m) = ground_m {
        for shell in (1..n_below).rev() {
            found.extend(chord(shell).map(|(enter_m, _)| (Some(shell), enter_m)));
        }
        if ground_m > 0.0 {
            found.push((Some(0), ground_m));
        }
        lowest = shells_m.len();
    } else if start.mu < 0.0 {
        lowest = here.unwrap_or(first_above);
        for shell in (0..n_below).rev() {
            let Some((enter_m, _)) = chord(shell) else {
                break;
            };
            found.push((Some(shell), enter_m));
            lowest = shell;
        }
    }
    for shell in lowest..shells_m.len() {
        found.extend(chord(shell).map(|(_, leave_m)| (Some(shell), leave_m)));
    }
    let crossing = |(shell, distance_m): (Option<usize>, f64)| {
        let point = start.advanced(planet, distance_m);
        Crossing {
            shell,
            distance_m,
            point,
        }
    };
    found.into_iter().map(crossing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_panel_add_up_to_what_it_absorbs() {
        for d in [1e-12, 1e-6, 9.99e-5, 1.01e-4, 0.1, 1.0, 30.0, 1e4_f64] {
            let [near, far] = linear_shares(d);
            let whole = -(-d).exp_m1();
            assert!((near + far - whole).abs() < 1e-12 * whole, "{d}");
            assert!(near >= far && far >= 0.0);
        }
    }

    #[test]
    fn a_level_ray_between_shells_sees_only_the_shells_above() {
        let planet = niji_geometry::EARTH;
        let start = RayPoint {
            height_m: 500.0,
            mu: 0.0,
        };
        let found = all_crossings(planet, &[0.0, 1e3, 1e4], start);
        let shells: Vec<_> = found.iter().map(|crossing| crossing.shell).collect();
        assert_eq!(shells, [None, Some(1), Some(2)]);
    }

    #[test]
    fn a_ray_over_the_horizon_crosses_its_shells_twice() {
        let planet = niji_geometry::EARTH;
        let start = RayPoint {
            height_m: 1e4,
            mu: -0.03,
        };
        let found = all_crossings(planet, &[0.0, 6e3, 8e3, 1e4, 2e4], start);
        let shells: Vec<_> = found.iter().filter_map(|crossing| crossing.shell).collect();
        assert_eq!(shells, [3, 2, 2, 3, 4]);
        let rises = found
            .windows(2)
            .all(|pair| pair[0].distance_m <= pair[1].distance_m);
        assert!(rises);
    }
}
