//! Sunlight on the ground that an observer sees, as a table over the sun's height there.
//!
//! L = albedo/pi  mu_s  T_sun(lambda, mu_s)  E_sun(lambda)
//! `mu_s` cosine of the sun's zenith angle at the ground, `T_sun` mean over the part of the disc that
//! is up there. The ground that is seen from height h lies up to cos a = R/(R + h) around the
//! observer's foot, so mu_s runs over no more than cos(z_s +- a). Where the sun sets on the ground,
//! mu_s falls to 0 with an edge: so it is not tabulated but known, and only T_sun is interpolated.

use niji_exchange::AtmosphereTable;
use niji_exchange::Stencil;
use niji_geometry::Planet;

use crate::refined_axis::Lines;
use crate::refined_axis::Refinement;
use crate::sky_view::SkyObserver;
use crate::sun_beam::sun_transmittance;
use crate::sun_disc::SUN_RADIUS;

/// Intervals at the start, and most halvings of one of them.
const FIRST_INTERVALS: usize = 8;
const MAX_HALVINGS: usize = 8;

/// Share of the sun's light that reaches the ground.
#[derive(Debug, Clone)]
pub(crate) struct GroundSun {
    mu_s: Vec<f64>,
    /// One spectrum for each, over `brightest`.
    transmittance: Vec<Vec<f64>>,
    /// Most light on the ground, mu_s T_sun, by wavelength.
    brightest: Vec<f64>,
}

impl GroundSun {
    /// Tabulates what an observer can see; `None` where the sun is down everywhere on it.
    pub(crate) fn new(
        air: &AtmosphereTable,
        observer: SkyObserver,
        tolerance: f64,
    ) -> Option<Self> {
        let [low, high] = visible_sun_heights(air.planet_radius_m, observer);
        if high <= 0.0 {
            return None;
        }
        let n_wavelengths = air.wavelengths.len();
        let refinement = Refinement {
            tolerance,
            max_halvings: MAX_HALVINGS,
            n_channels: 1,
            n_wavelengths,
            brightest: &vec![0.0; n_wavelengths],
            // An observer below sea level stands on ground of his own height.
            line: |mu_s: f64| sun_transmittance(air, observer.height_m.min(0.0), mu_s, SUN_RADIUS),
            stencil: |axis: &[f64], x: f64| Stencil::<4>::new(axis, x).weighted_nodes().collect(),
        };
        let share = |i: usize| i as f64 / FIRST_INTERVALS as f64;
        let mut axis: Vec<f64> = (0..=FIRST_INTERVALS)
            .map(|i| low + (high - low) * share(i))
            .collect();
        // A foot at sea level sees one point of the ground.
        axis.dedup();
        let Lines { axis, mut lines } = refinement.refine(axis);
        let mut brightest = vec![f64::MIN_POSITIVE; n_wavelengths];
        for (mu_s, line) in axis.iter().zip(&lines) {
            for (brightest, share) in brightest.iter_mut().zip(line) {
                *brightest = brightest.max(mu_s * share);
            }
        }
        for line in &mut lines {
            for (share, brightest) in line.iter_mut().zip(&brightest) {
                *share /= brightest;
            }
        }
        Some(Self {
            mu_s: axis,
            transmittance: lines,
            brightest,
        })
    }

    /// What is tabulated of the ground: `reflected`, its answer to the sun in the zenith without
    /// air, under the most light it has. So it compares with the light of the air before it.
    pub(crate) fn brightest_ground(&self, mut reflected: Vec<f64>) -> Vec<f64> {
        for (reflected, brightest) in reflected.iter_mut().zip(&self.brightest) {
            *reflected *= brightest;
        }
        reflected
    }

    /// Adds to `radiance` what is left of the brightest ground under a sun of this height.
    pub(crate) fn add_reflected(&self, mu_s: f64, brightest: &[f32], radiance: &mut [f32]) {
        if mu_s <= 0.0 {
            return;
        }
        for (node, weight) in Stencil::<4>::new(&self.mu_s, mu_s).weighted_nodes() {
            // f32: as the spectra it is multiplied with.
            let weight = (mu_s * weight) as f32;
            let spectra = brightest.iter().zip(&self.transmittance[node]);
            for (radiance, (brightest, &share)) in radiance.iter_mut().zip(spectra) {
                *radiance += weight * share as f32 * brightest;
            }
        }
    }
}

/// Lowest and highest cosine of the sun's zenith angle on the ground that is seen, at least 0.
fn visible_sun_heights(planet_radius_m: f64, observer: SkyObserver) -> [f64; 2] {
    let planet = Planet {
        radius_m: planet_radius_m,
    };
    let zenith_rad = observer.cos_sun_zenith.clamp(-1.0, 1.0).acos();
    let around_rad = planet.horizon_dip(observer.height_m).0;
    let lowest = (zenith_rad + around_rad).min(std::f64::consts::PI).cos();
    let highest = (zenith_rad - around_rad).max(0.0).cos();
    [lowest.max(0.0), highest]
}
