//! Sunlight that the air scatters twice or more often, and what the ground sends back into the air.
//!
//! Successive orders of scattering on the sphere. The diffuse light at height h under a sun at
//! zenith angle z is kept as moments of its radiance over directions,
//!   X_lm(h, z) = integral of L(mu, phi) Y_lm(mu) cos(m phi) domega   per unit irradiance by the sun,
//! because each constituent's source follows from them (see [`DiffuseLight`]), exactly where its
//! phase function has no more moments p_l: Rayleigh's has three. The first order is gathered from
//! the direct beam (`beam`), each further one along rays through spherical shells from the source of
//! the order before (`gathering`). Each scattering multiplies moments of degree l by p_l, so that
//! later orders need fewer azimuths. The ground reflects diffusely. The orders that are left out
//! follow a geometric series (`series`). `X` varies slowly with height, where `J` falls over decades.
//! Left out: polarization (5 % of the radiance of a blue sky) and refraction.
//! [LHT] Lenoble, Herman, Deuze, Lafrance, Santer and Tanre, J. Quant. Spectrosc. Radiat. Transfer
//! 107, 479-507 (2007): successive orders.  [B17] Bruneton, IEEE TVCG 23, 2641-2655 (2017).

mod beam;
mod diffuse_sky;
mod gathering;
mod light;
mod medium;
mod series;
mod shell_path;
mod shells;
mod sun_axis;

use std::convert::Infallible;

use glam::DVec3;
use niji_exchange::AtmosphereTable;
use niji_exchange::DiffuseLight;
use niji_geometry::EARTH;
use niji_geometry::Planet;
use niji_radiometry::Radians;

use self::beam::Beam;
pub use self::diffuse_sky::DiffuseSky;
use self::gathering::Directions;
use self::light::Light;
use self::medium::Medium;
use self::series::Series;
use self::shells::shells_m;
use self::sun_axis::SunAxis;

/// Most orders that are computed one by one; a fog of an optical depth of 10 that takes nothing needs 150.
const MAX_ORDERS: usize = 300;

/// For which zenith angles of the sun light is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Suns {
    /// All.
    All,
    /// Those of places in the air that are seen from a height where the sun has a zenith angle. Elsewhere it is dark, or
    /// as at the last of them.
    SeenFrom {
        /// Over the ground (m).
        height_m: f64,
        /// There.
        sun_zenith: Radians,
    },
}

impl Suns {
    /// Those that are seen from a point, with the sun in a direction there.
    pub fn seen_from(eye: DVec3, sun_direction: DVec3) -> Self {
        Self::SeenFrom {
            height_m: EARTH.height_m(eye),
            sun_zenith: Radians(EARTH.cos_zenith(eye, sun_direction).acos()),
        }
    }

    /// Those of an axis, and of places whose light gets there by so many ways through the air.
    fn of(self, axis: SunAxis, air: &AtmosphereTable, n_ways: f64) -> SunAxis {
        let Self::SeenFrom {
            height_m,
            sun_zenith,
        } = self
        else {
            return axis;
        };
        let planet = Planet {
            radius_m: air.planet_radius_m,
        };
        // The way along the horizon to the top of the air, over which the vertical turns by as much.
        let way = planet.horizon_dip(air.top_height_m).0;
        let seen = planet.horizon_dip(height_m).0 + way;
        axis.around(sun_zenith, Radians(seen + n_ways * way))
    }
}

/// How finely the light of higher orders is solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatteringOrders {
    /// Layers of air, at least 1; thin where the air is dense.
    pub n_layers: usize,
    /// Directions in each of the two hemispheres above and below the horizon, at least 1.
    pub n_zeniths: usize,
    /// Largest degree of the moments, 1 to 32.
    pub max_degree: usize,
    /// Error of the sum of all orders at which no further one is computed.
    pub tolerance: f64,
}

impl ScatteringOrders {
    /// For looking: all light of a clear sky within 4 %, of a hazy one within 7 % of the finest level
    /// (sun from 2 degrees up, November 2026).
    pub const DRAFT: Self = Self {
        n_layers: 10,
        n_zeniths: 4,
        max_degree: 4,
        tolerance: 1e-2,
    };
    /// For pictures: all light of a clear sky within 0.2 %, of one in rural haze within 3 % of the finest
    /// level, which is 0.02 and 0.25 % of display white RMS over the sky (sun at 2 to 60
    /// degrees, November 2026). 41 wavelengths take 0.34 s of one core in clear air and 1 s in haze.
    pub const QUICK: Self = Self {
        n_layers: 14,
        n_zeniths: 5,
        max_degree: 6,
        tolerance: 5e-3,
    };
    /// An accurate level: all light of a sky within 2 % of discrete ordinates, in clear air within
    /// 0.1 % (sun to 60, view to 75 degrees from the zenith, molecules with and without rural or
    /// maritime haze of 10 km of visibility or more, 450 and 650 nm, albedo 0 to 0.8), and within 1 %
    /// of the finest level with the sun from 2 degrees up (November 2026). 41 wavelengths take 1 s of one
    /// core in clear air and 3.5 s in haze.
    pub const STANDARD: Self = Self {
        n_layers: 24,
        n_zeniths: 8,
        max_degree: 9,
        tolerance: 2e-3,
    };
    /// The most accurate level.
    pub const FINE: Self = Self {
        n_layers: 40,
        n_zeniths: 12,
        max_degree: 12,
        tolerance: 1e-4,
    };
}

/// An air with the light of higher orders in its table.
pub fn with_diffuse_light(air: AtmosphereTable, level: ScatteringOrders) -> AtmosphereTable {
    with_diffuse_light_of(air, level, Suns::All)
}

/// The same for some suns.
pub fn with_diffuse_light_of(
    air: AtmosphereTable,
    level: ScatteringOrders,
    suns: Suns,
) -> AtmosphereTable {
    let diffuse = Some(solved(&air, level, suns));
    AtmosphereTable { diffuse, ..air }
}

/// Solves the light of higher orders in an air.
pub fn diffuse_light(air: &AtmosphereTable, level: ScatteringOrders) -> DiffuseLight {
    solved(air, level, Suns::All)
}

fn solved(air: &AtmosphereTable, level: ScatteringOrders, suns: Suns) -> DiffuseLight {
    let go_on = |_| Ok::<_, Infallible>(());
    diffuse_light_while(go_on, air, level, suns).unwrap_or_else(|never| match never {})
}

/// The light of higher orders for some suns, unless `go_on` refuses, which is asked before each layer of each order and
/// told the part that is done, 0 to 1, by how near the error of the orders so far is to the tolerance.
///
/// # Errors
/// What `go_on` says.
pub fn diffuse_light_while<E: Send>(
    go_on: impl Fn(f64) -> Result<(), E> + Sync,
    air: &AtmosphereTable,
    level: ScatteringOrders,
    suns: Suns,
) -> Result<DiffuseLight, E> {
    let shells_m = shells_m(air, level.n_layers.max(1));
    let medium = Medium::new(air, level.max_degree);
    let axis = suns.of(SunAxis::new(1), air, 0.0);
    let beam_axis = suns.of(SunAxis::new(beam::AXIS_CUTS), air, 2.0);
    let ratios = medium.at_shells(air, &shells_m);
    let beam = Beam::new(air, &medium, &shells_m, beam_axis);
    let mut last = beam.gather(&axis, level.n_zeniths, || go_on(0.0))?;
    let mut sum = last.clone();
    let mut series = Series::new(axis.len(), air.wavelengths.len());
    if last.is_dark() {
        go_on(1.0)?;
        return Ok(table(&medium, shells_m, &axis, sum));
    }
    let directions = Directions::new(air, &shells_m, level.n_zeniths);
    let mut approach = Approach::new(level.tolerance);
    for azimuth_order in medium.azimuth_orders(&ratios) {
        let source = last.to_source(air, &ratios, azimuth_order);
        let next = directions.gather(&source, &axis, || go_on(approach.part))?;
        sum.add(&next);
        let error = series.follow(&last, &next, &sum);
        last = next;
        if error <= level.tolerance {
            break;
        }
        approach.follow(error);
    }
    series.add_tail(&last, &mut sum);
    go_on(1.0)?;
    Ok(table(&medium, shells_m, &axis, sum))
}

/// How near a series of orders has come to its tolerance.
struct Approach {
    tolerance: f64,
    /// That of the first ratio has no ratio before it to be compared with.
    n_errors: usize,
    second_error: f64,
    /// Of the way, 0 to 1: errors fall by about the same factor from order to order.
    part: f64,
}

impl Approach {
    fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            n_errors: 0,
            second_error: 0.0,
            part: 0.0,
        }
    }

    fn follow(&mut self, error: f64) {
        self.n_errors += 1;
        if self.n_errors <= 2 {
            self.second_error = error;
            return;
        }
        let part = (self.second_error / error).ln() / (self.second_error / self.tolerance).ln();
        // Errors may grow for an order.
        self.part = self.part.max(part.min(1.0));
    }
}

fn table(medium: &Medium, height_m: Vec<f64>, axis: &SunAxis, sum: Light) -> DiffuseLight {
    let phase_moments = medium.phase_moments();
    debug_assert_eq!(sum.n_wavelengths, medium.n_wavelengths);
    DiffuseLight {
        height_m,
        sun_zenith_rad: axis.zenith_rad().to_vec(),
        max_degree: medium.max_degree,
        moments: sum.moments,
        on_ground: sum.on_ground,
        phase_moments,
    }
}
