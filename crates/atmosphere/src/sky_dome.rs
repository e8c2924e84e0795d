//! The sky of one observer as a table: single scattering for many directions at once.
//!
//! L(lambda, mu, phi) = sum over j of  P_j(lambda, theta) S_j(lambda, mu, phi)  +  ground
//! S_j = E_sun beta_j G_j, the radiance of constituent j but for its phase function, is smooth in the
//! direction (see `gathered`), so a few thousand rays hold a whole sky; the phase function, which is
//! not, is looked up by its own angle. What the ground gives back is its reflectance dimmed by the air
//! before it, tabulated beside them, times the sunlight that arrives there (`ground_sun`). Sky and ground are tables of their own, because light jumps at
//! the horizon; seen from above the air, the sky is the ring from the horizon to the top of the air.
//!
//! The tolerance is relative to the light in the same direction, or to a thousandth of the brightest
//! where it is darker. At 1e-4 the worst of 1600 directions errs by 1e-5 under a high sun and by up to
//! 7e-5 from sunset to -4 degrees, in thick haze by 3e-4 where it lets through a ten-thousandth of the
//! brightest, at -8 degrees by 2e-4; right at the edge of the planet's shadow, which is not smooth, by
//! more. A sky of 640 x 480 directions and 41 wavelengths takes 0.25 s on one thread under a high sun,
//! 0.33 s at sunset and 0.46 s at -4 degrees, of which 0.17 s for looking up (2026-11-21; the published
//! sum of 50 x 50 steps takes 90 s).

use std::f64::consts::TAU;

use niji_exchange::AirConstituent;
use niji_exchange::AtmosphereTable;
use niji_exchange::Stencil;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use crate::angle_table::AngleTable;
use crate::angle_table::Band;
use crate::angle_table::Spectra;
use crate::angle_table::tabulate;
use crate::gathered::scatters;
use crate::ground_sun::GroundSun;
use crate::in_scattering::InScattering;
use crate::in_scattering::SingleScattering;
use crate::sky::reflected_by_ground;
use crate::sky_view::SkyDirection;
use crate::sky_view::SkyObserver;

/// By how much cosines at the horizon are moved off it, so that rounding decides nothing.
const BESIDE_HORIZON: f64 = 1e-12;

/// The sky of one observer.
#[derive(Debug, Clone)]
pub struct SkyDome {
    observer: SkyObserver,
    planet: Planet,
    /// Above the horizon, up to this cosine of the zenith angle.
    sky_end: f64,
    sky: Option<AngleTable<4>>,
    ground: Option<AngleTable<4>>,
    n_rays: usize,
    /// Where the ground gives light back.
    ground_sun: Option<GroundSun>,
    lobes: Vec<Lobe>,
    n_wavelengths: usize,
}

impl SkyDome {
    /// Tabulates the sky of an observer to a relative error of `tolerance`, 1e-4 for instance.
    pub fn new(air: &AtmosphereTable, observer: SkyObserver, tolerance: f64) -> Self {
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        let horizon = horizon_cosine(planet, observer.height_m, 0.0);
        let sky_end = if observer.height_m < air.top_height_m {
            1.0
        } else {
            horizon_cosine(planet, observer.height_m, air.top_height_m)
        };
        let has_albedo = air.ground_albedo.iter().any(|&albedo| albedo > 0.0);
        let ground_sun = if has_albedo {
            GroundSun::new(air, observer, tolerance)
        } else {
            None
        };
        let mut sources = Sources::new(air, observer, tolerance);
        let (sky, n_sky_rays) = sources.table(Band::Sky([horizon + BESIDE_HORIZON, sky_end]));
        if let Some(sky) = &sky {
            sources.brightest = sky.brightest().to_vec();
        }
        sources.ground_sun = ground_sun.as_ref();
        let (ground, n_ground_rays) = sources.table(Band::Ground {
            horizon: horizon - BESIDE_HORIZON,
        });
        Self {
            observer,
            planet,
            sky_end,
            sky,
            ground,
            n_rays: n_sky_rays + n_ground_rays,
            lobes: sources.scatterers.into_iter().map(Lobe::new).collect(),
            ground_sun,
            n_wavelengths: air.wavelengths.len(),
        }
    }

    /// Writes the radiance that arrives from a direction, W m^-2 sr^-1 nm^-1, one value for each
    /// wavelength of the air.
    ///
    /// The sun's own disc is not included. f32: interpolation errs by more.
    ///
    /// # Panics
    /// If `radiance` has another length.
    pub fn write_radiance(&self, direction: SkyDirection, radiance: &mut [f32]) {
        let n_wavelengths = self.n_wavelengths;
        assert_eq!(
            radiance.len(),
            n_wavelengths,
            "one value for each wavelength"
        );
        radiance.fill(0.0);
        let mu = direction.cos_zenith;
        let ground_m = self.planet.distance_to_ground(self.observer.height_m, mu);
        let table = match ground_m {
            Some(_) => &self.ground,
            None if mu <= self.sky_end => &self.sky,
            // Above the ring of air, or no direction at all.
            None => return,
        };
        let Some(table) = table else {
            return;
        };
        let mut sources = vec![0.0; table.n_values()];
        table.look_up(mu, folded(direction.relative_azimuth.0), &mut sources);
        let (scattered, reflected) = sources.split_at(self.lobes.len() * n_wavelengths);
        let theta_rad = self.observer.cos_scattering(direction).acos();
        for (lobe, source) in self.lobes.iter().zip(scattered.chunks(n_wavelengths)) {
            lobe.add_scattered(theta_rad, source, radiance);
        }
        if let (Some(ground_m), Some(ground_sun)) = (ground_m, &self.ground_sun) {
            let [_, mu_s] = self.observer.ray(direction).sun_at(self.planet, ground_m);
            ground_sun.add_reflected(mu_s, reflected, radiance);
        }
    }

    /// Number of rays that the table was made of.
    pub fn n_rays(&self) -> usize {
        self.n_rays
    }
}

/// What is tabulated: the sources of one observer's sky.
struct Sources<'a> {
    solver: SingleScattering<'a>,
    observer: SkyObserver,
    tolerance: f64,
    scatterers: Vec<&'a AirConstituent>,
    /// For rays that end on ground that is lit.
    ground_sun: Option<&'a GroundSun>,
    /// Brightest light found so far, by wavelength.
    brightest: Vec<f64>,
}

impl<'a> Sources<'a> {
    /// The sources above the horizon.
    fn new(air: &'a AtmosphereTable, observer: SkyObserver, tolerance: f64) -> Self {
        let method = InScattering::Adaptive { tolerance };
        let scatterers = air.constituents.iter().filter(|air| scatters(air));
        Self {
            solver: SingleScattering::new(air, method),
            observer,
            tolerance,
            scatterers: scatterers.collect(),
            ground_sun: None,
            brightest: vec![0.0; air.wavelengths.len()],
        }
    }

    /// The table of a part of the sphere, if it has any channel, and the number of rays behind it.
    fn table(&self, band: Band) -> (Option<AngleTable<4>>, usize) {
        let spectra = Spectra {
            n_channels: self.scatterers.len() + usize::from(self.ground_sun.is_some()),
            n_wavelengths: self.brightest.len(),
            brightest: self.brightest.clone(),
            at: |cos_zenith: f64, azimuth_rad: f64| {
                self.at(SkyDirection {
                    cos_zenith,
                    relative_azimuth: Radians(azimuth_rad),
                })
            },
        };
        if spectra.n_channels == 0 {
            return (None, 0);
        }
        let (table, n_rays) = tabulate(band, &spectra, self.tolerance);
        (Some(table), n_rays)
    }

    /// E_sun beta_j G_j for every constituent that scatters, and what the ground gives back.
    fn at(&self, direction: SkyDirection) -> Vec<f64> {
        let ray = self.observer.ray(direction);
        let directed = self.solver.directed_scattering(&ray);
        let gathered = self.solver.gather(&ray, &directed);
        let air = self.solver.air();
        let mut sources = Vec::new();
        for (constituent, lengths_m) in air.constituents.iter().zip(&gathered.lengths_m) {
            let spectra = lengths_m
                .iter()
                .zip(&constituent.scattering_m1)
                .zip(&air.sun_irradiance);
            sources.extend(spectra.map(|((length_m, beta), sun)| sun * beta * length_m));
        }
        if let Some(ground_sun) = self.ground_sun {
            let reflected = reflected_by_ground(air, &gathered.transmittance());
            sources.extend(ground_sun.brightest_ground(reflected));
        }
        sources
    }
}

/// Phase function of a constituent by angle, all wavelengths side by side.
#[derive(Debug, Clone)]
struct Lobe {
    angle_rad: Vec<f64>,
    /// `[angle, wavelength]`, 1/sr
    phase_sr1: Vec<f32>,
}

impl Lobe {
    fn new(air: &AirConstituent) -> Self {
        let by_angle = air.phase_sr1.t();
        Self {
            angle_rad: air.phase_angle_rad.clone(),
            // f32, like the file of the air.
            phase_sr1: by_angle.iter().map(|&phase| phase as f32).collect(),
        }
    }

    /// Adds `source` times the phase function to `radiance`.
    fn add_scattered(&self, theta_rad: f64, source: &[f32], radiance: &mut [f32]) {
        let n_wavelengths = source.len();
        for (node, weight) in Stencil::<4>::new(&self.angle_rad, theta_rad).weighted_nodes() {
            let phase_sr1 = &self.phase_sr1[node * n_wavelengths..(node + 1) * n_wavelengths];
            let weight = weight as f32;
            for ((radiance, source), phase) in radiance.iter_mut().zip(source).zip(phase_sr1) {
                *radiance += weight * phase * source;
            }
        }
    }
}

/// Cosine of the zenith angle at which a shell below the observer is touched, 0 if he stands on it
/// or below.
fn horizon_cosine(planet: Planet, height_m: f64, shell_m: f64) -> f64 {
    let above_m = (height_m - shell_m).max(0.0);
    let both_m = 2.0 * planet.radius_m + height_m + shell_m;
    -((above_m * both_m).sqrt() / (planet.radius_m + height_m))
}

/// An azimuth as the angle to the sun's, 0 to pi.
fn folded(azimuth_rad: f64) -> f64 {
    let turned = azimuth_rad.rem_euclid(TAU);
    turned.min(TAU - turned)
}
