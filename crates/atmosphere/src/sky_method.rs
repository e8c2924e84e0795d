//! Every method for the light of a sky, by name, with its error and its time.
//!
//! error = |radiance - reference| / max(reference, DARK * brightest), for each direction and
//! wavelength; `brightest` of the reference at that wavelength over all directions, DARK = 1e-3, so
//! that what is black beside the rest does not decide. Worst and root mean square are over all of
//! them. The reference is the adaptive quadrature at 1e-7, which the tests hold against an adaptive
//! quadrature that shares nothing with it.

use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;

use niji_exchange::AtmosphereTable;
use niji_radiometry::Radians;

use crate::in_scattering::InScattering;
use crate::in_scattering::SingleScattering;
use crate::sky_dome::SkyDome;
use crate::sky_view::SkyDirection;
use crate::sky_view::SkyObserver;

/// Light below this share of the brightest is dark: its error is relative to the share.
const DARK: f64 = 1e-3;

/// How the light of a sky is found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SkyMethod {
    /// Each direction by a ray of its own.
    Rays(InScattering),
    /// By a table of all directions, interpolated: for pictures.
    Dome {
        /// Relative error that is asked for.
        tolerance: f64,
    },
}

impl SkyMethod {
    /// The methods that are worth comparing, the published sum first.
    pub const ALL: [Self; 10] = [
        Self::Rays(InScattering::Midpoint { n_steps: 50 }),
        Self::Rays(InScattering::Midpoint { n_steps: 100 }),
        Self::Rays(InScattering::Nested {
            n_nodes: 12,
            n_sun_nodes: 8,
        }),
        Self::Rays(InScattering::Nested {
            n_nodes: 16,
            n_sun_nodes: 12,
        }),
        Self::Rays(InScattering::Quadrature { n_nodes: 8 }),
        Self::Rays(InScattering::Quadrature { n_nodes: 12 }),
        Self::Rays(InScattering::Quadrature { n_nodes: 16 }),
        Self::Rays(InScattering::STANDARD),
        Self::Dome { tolerance: 1e-3 },
        Self::STANDARD_DOME,
    ];

    /// The method against which the others are measured.
    pub const REFERENCE: Self = Self::Rays(InScattering::Adaptive { tolerance: 1e-7 });

    /// The table for pictures, to 1e-4.
    pub const STANDARD_DOME: Self = Self::Dome { tolerance: 1e-4 };

    /// Name of the method with its settings, as it stands in tables.
    pub fn label(self) -> String {
        match self {
            Self::Rays(InScattering::Midpoint { n_steps }) => {
                format!("midpoint {n_steps} x {n_steps}")
            }
            Self::Rays(InScattering::Nested {
                n_nodes,
                n_sun_nodes,
            }) => format!("gauss {n_nodes} x {n_sun_nodes}"),
            Self::Rays(InScattering::Quadrature { n_nodes }) => format!("gauss {n_nodes} x table"),
            Self::Rays(InScattering::Adaptive { tolerance }) => format!("adaptive {tolerance:e}"),
            Self::Dome { tolerance } => format!("dome {tolerance:e}"),
        }
    }
}

/// The sky of one observer, ready to be looked at.
#[derive(Debug, Clone)]
pub enum PreparedSky<'a> {
    /// Each direction by a ray of its own.
    Rays(Box<SingleScattering<'a>>, SkyObserver),
    /// By a table of all directions.
    Dome(Box<SkyDome>),
}

impl<'a> PreparedSky<'a> {
    /// Does what has to be done once for all directions.
    pub fn new(air: &'a AtmosphereTable, observer: SkyObserver, method: SkyMethod) -> Self {
        match method {
            SkyMethod::Rays(method) => {
                Self::Rays(Box::new(SingleScattering::new(air, method)), observer)
            }
            SkyMethod::Dome { tolerance } => {
                Self::Dome(Box::new(SkyDome::new(air, observer, tolerance)))
            }
        }
    }

    /// Writes the radiance that arrives from a direction, W m^-2 sr^-1 nm^-1, one value for each
    /// wavelength of the air.
    ///
    /// # Panics
    /// If `radiance` has another length.
    pub fn write_radiance(&self, direction: SkyDirection, radiance: &mut [f32]) {
        match self {
            Self::Rays(solver, observer) => {
                let found = solver.sky_radiance(&observer.ray(direction));
                assert_eq!(radiance.len(), found.len(), "one value for each wavelength");
                for (radiance, found) in radiance.iter_mut().zip(found) {
                    // f32: as in the pictures that are made of it.
                    *radiance = found as f32;
                }
            }
            Self::Dome(dome) => dome.write_radiance(direction, radiance),
        }
    }
}

/// Error and time of one method.
#[derive(Debug, Clone, PartialEq)]
pub struct SkyMethodCost {
    /// The method.
    pub method: SkyMethod,
    /// Time for what is done once for a sky, s.
    pub setup_s: f64,
    /// Time for a direction after that, s.
    pub direction_s: f64,
    /// Largest error relative to the reference, or where that is dark to a share of its largest value.
    pub worst_error: f64,
    /// Root mean square of this error.
    pub rms_error: f64,
}

impl SkyMethodCost {
    /// Time for a picture of so many directions, s.
    pub fn picture_s(&self, n_directions: usize) -> f64 {
        self.setup_s + self.direction_s * n_directions as f64
    }
}

/// The sky of an observer by the reference, which other methods are measured against.
#[derive(Debug, Clone)]
pub struct ReferenceSky<'a> {
    air: &'a AtmosphereTable,
    observer: SkyObserver,
    directions: &'a [SkyDirection],
    radiance: Vec<f32>,
}

impl<'a> ReferenceSky<'a> {
    /// Looks in every direction by [`SkyMethod::REFERENCE`].
    pub fn new(
        air: &'a AtmosphereTable,
        observer: SkyObserver,
        directions: &'a [SkyDirection],
    ) -> Self {
        let sky = PreparedSky::new(air, observer, SkyMethod::REFERENCE);
        Self {
            air,
            observer,
            directions,
            radiance: radiances(&sky, air.wavelengths.len(), directions),
        }
    }

    /// Radiance from every direction, W m^-2 sr^-1 nm^-1: rows of wavelengths.
    pub fn radiance(&self) -> &[f32] {
        &self.radiance
    }

    /// Error and time of a method for the same sky.
    ///
    /// `seconds` runs what it is given once or several times, and says how long one run takes: a
    /// library does not ask for the time itself.
    pub fn cost(
        &self,
        method: SkyMethod,
        seconds: &mut dyn FnMut(&mut dyn FnMut()) -> f64,
    ) -> SkyMethodCost {
        let n_wavelengths = self.air.wavelengths.len();
        let mut sky = PreparedSky::new(self.air, self.observer, method);
        let setup_s = seconds(&mut || sky = PreparedSky::new(self.air, self.observer, method));
        let mut found = Vec::new();
        let all_s = seconds(&mut || found = radiances(&sky, n_wavelengths, self.directions));
        let (worst_error, rms_error) = errors(&found, &self.radiance, n_wavelengths);
        SkyMethodCost {
            method,
            setup_s,
            direction_s: all_s / self.directions.len().max(1) as f64,
            worst_error,
            rms_error,
        }
    }
}

fn radiances(sky: &PreparedSky, n_wavelengths: usize, directions: &[SkyDirection]) -> Vec<f32> {
    let mut radiances = vec![0.0; directions.len() * n_wavelengths];
    for (row, &direction) in radiances.chunks_mut(n_wavelengths.max(1)).zip(directions) {
        sky.write_radiance(direction, row);
    }
    radiances
}

/// Worst and root mean square error of rows of wavelengths.
fn errors(found: &[f32], reference: &[f32], n_wavelengths: usize) -> (f64, f64) {
    let mut dark = vec![0.0_f64; n_wavelengths];
    for row in reference.chunks(n_wavelengths.max(1)) {
        for (dark, &light) in dark.iter_mut().zip(row) {
            *dark = dark.max(DARK * f64::from(light));
        }
    }
    let (mut worst, mut squares) = (0.0_f64, 0.0);
    for (i, (&found, &exact)) in found.iter().zip(reference).enumerate() {
        let scale = f64::from(exact).max(dark[i % n_wavelengths]);
        // Where all is black, whatever is found is wrong.
        let error = (f64::from(found) - f64::from(exact)).abs() / scale.max(f64::MIN_POSITIVE);
        worst = worst.max(error);
        squares += error * error;
    }
    (worst, (squares / reference.len().max(1) as f64).sqrt())
}

/// Directions spread over the sky: `n` elevations, denser at the horizon, by `n` azimuths.
///
/// Elevations run quadratically from `lowest` to the zenith; directions lie between, not on, the
/// ends.
pub fn spread_directions(lowest: Radians, n: usize) -> Vec<SkyDirection> {
    let share = |i: usize| (i as f64 + 0.5) / n as f64;
    let direction = |elevation: usize, azimuth: usize| {
        let rise = (FRAC_PI_2 - lowest.0) * share(elevation).powi(2);
        SkyDirection::from_elevation(Radians(lowest.0 + rise), Radians(PI * share(azimuth)))
    };
    (0..n)
        .flat_map(|elevation| (0..n).map(move |azimuth| direction(elevation, azimuth)))
        .collect()
}
