//! Light that drops diffract forward, by the pattern of a round hole as large as the drop.
//!
//! t = (x²/4π) (2 J1(u)/u)²,   u = 2 x sin(θ/2),   ∫ t dΩ = 1
//! E(u) = 1 − J0(u)² − J1(u)²  the part of it within θ;  far out E → 1 − 2/(π u) + cos(2 u)/(π u²)
//! `x` = 2π r/λ, `θ` scattering angle, `t` (dσ/dΩ)/(π r²) in 1/sr, alike for both polarizations. The mean
//! over a ring of θ is a difference of E over its solid angle, exactly, however many rings of the pattern
//! lie in it; E depends on x θ alone, so that one function of each size law serves all radii and
//! wavelengths of a table.
//! In the theories of bows orders 0 and 1 are rays, which leave this light out. The pattern is that of
//! small angles, and good where x is some hundred and more.
//! [BW99] M. Born and E. Wolf, Principles of Optics, 7th ed., Cambridge (1999), section 8.5.2.

use std::f64::consts::FRAC_2_PI;
use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::sync::LazyLock;

use niji_radiometry::Micrometers;
use niji_radiometry::Nanometers;
use niji_sizes::gamma_area_quadrature;

use crate::bow_light::Places;
use crate::bow_rows::Drops;
use crate::error::Error;
use crate::request::TableRequest;
use crate::rings::DiscAverage;
use crate::rings::Rings;
use niji_radiometry::size_parameter;

/// Nodes of a size law.
const N_SIZES: usize = 48;
/// Steps of u, those of one size, and where the expansion far out takes over.
const STEP: f64 = 0.02;
const STEP_OF_ONE: f64 = 0.25 * STEP;
const FAR: f64 = 60.0;
const FARTHEST: f64 = 600.0;

/// A table that starts at larger angles has next to nothing of this light, 2e-4/sr at most.
const ENDS_RAD: f64 = PI / 3.0;

/// Diffracted light at the angles of a table.
pub(crate) struct DiffractedLight {
    places: Places,
    disc: DiscAverage,
    /// By effective variance.
    laws: Vec<Diffraction>,
    one_size: Diffraction,
}

impl DiffractedLight {
    /// What a table has of it; `None` where its theory leaves it out, or its angles do.
    pub(crate) fn of_request(
        request: &TableRequest,
        theta_rad: &[f64],
    ) -> Result<Option<Self>, Error> {
        let is_in = request.holds_diffraction() && theta_rad[0] < ENDS_RAD;
        is_in.then(|| Self::new(request, theta_rad)).transpose()
    }

    fn new(request: &TableRequest, theta_rad: &[f64]) -> Result<Self, Error> {
        let places = Places::of_table(request, theta_rad);
        let radius_rad = request.disc_radius_rad();
        // The lobe of large drops lies within a ring.
        let row = |rings: &Rings, theta_rad: f64| rings.even_disc_row(theta_rad, radius_rad);
        let laws = request.variances_of_drops().map(Diffraction::new);
        Ok(Self {
            laws: laws.collect::<Result<_, _>>()?,
            one_size: Diffraction::new(0.0)?,
            disc: places.disc_average(theta_rad, row),
            places,
        })
    }

    pub(crate) fn light(&self, drops: Drops, wavelength: Nanometers) -> Vec<[f64; 2]> {
        let of_law = drops.variance_index.map(|index| &self.laws[index]);
        let law = of_law.unwrap_or(&self.one_size);
        let x = size_parameter(drops.radius, wavelength);
        let light = law.light(&self.places, x).into_iter();
        let both: Vec<[f64; 2]> = light.map(|light| [light; 2]).collect();
        self.disc.of_both(&both)
    }
}

/// E and t of a size law.
#[derive(Clone, Debug)]
pub(crate) struct Diffraction {
    /// Radii over the effective one, and weights.
    sizes: Vec<(f64, f64)>,
    /// E at even steps of u of the effective radius.
    encircled: Vec<f64>,
    /// ⟨1/r⟩ r_e.
    inverse: f64,
}

impl Diffraction {
    /// Of a gamma law of some effective variance.
    pub(crate) fn new(effective_variance: f64) -> Result<Self, Error> {
        let sizes = gamma_area_quadrature(Micrometers(1.0), effective_variance, N_SIZES)?;
        let smallest = sizes.first().map_or(1.0, |(radius, _)| radius.max(1e-2));
        let n = (FAR / smallest / STEP).ceil() as usize;
        let mean = |value: &dyn Fn(f64) -> f64| -> f64 {
            sizes
                .iter()
                .map(|(radius, weight)| weight * value(*radius))
                .sum()
        };
        // A law has up to 3e5 steps of 48 sizes.
        let within_one = |u: f64| between(&OF_ONE, u / STEP_OF_ONE).unwrap_or_else(|| far_out(u));
        let at = |index: usize| mean(&|radius| within_one(radius * STEP * index as f64));
        Ok(Self {
            encircled: (0..=n).map(at).collect(),
            inverse: mean(&|radius| radius.recip()),
            sizes,
        })
    }

    /// Light at every place, of drops whose effective radius has the size parameter `x`.
    pub(crate) fn light(&self, places: &Places, x: f64) -> Vec<f64> {
        match places {
            Places::Rings(rings) => {
                let edge = |index| {
                    let sine = (0.5 * rings.edge_rad(index)).sin();
                    // Solid angle and light within.
                    (TAU * 2.0 * sine * sine, self.within(2.0 * x * sine))
                };
                let mut inner = edge(0);
                let ring = |index: usize| {
                    let outer = edge(index + 1);
                    let mean = (outer.1 - inner.1) / (outer.0 - inner.0);
                    inner = outer;
                    mean
                };
                (0..rings.n).map(ring).collect()
            }
            Places::Angles(angles) => {
                let at = |theta: &f64| self.at(x, 2.0 * (0.5 * theta).sin());
                angles.iter().map(at).collect()
            }
        }
    }

    /// E of the law.
    fn within(&self, u: f64) -> f64 {
        // Sizes leave nothing of the waves there.
        between(&self.encircled, u / STEP).unwrap_or_else(|| 1.0 - FRAC_2_PI * self.inverse / u)
    }

    /// t of the law at u over x.
    fn at(&self, x: f64, u_over_x: f64) -> f64 {
        let of_size = |(radius, weight): &(f64, f64)| {
            let x = x * radius;
            let u = x * u_over_x;
            let amplitude = if u < 1e-6 { 1.0 } else { 2.0 * libm::j1(u) / u };
            weight * x * x / (4.0 * PI) * amplitude * amplitude
        };
        self.sizes.iter().map(of_size).sum()
    }
}

/// E of one size at even steps, up to where the expansion takes over.
static OF_ONE: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let steps = 0..=(FAR / STEP_OF_ONE) as usize;
    steps.map(|it| encircled(STEP_OF_ONE * it as f64)).collect()
});

/// E(u).
fn encircled(u: f64) -> f64 {
    1.0 - libm::j0(u).powi(2) - libm::j1(u).powi(2)
}

/// The same far out; farthest without the waves, of which sizes leave nothing.
fn far_out(u: f64) -> f64 {
    let wave = if u < FARTHEST {
        (2.0 * u).cos() / (PI * u * u)
    } else {
        0.0
    };
    1.0 - FRAC_2_PI / u + wave
}

/// The value at a place among others, counted in them; `None` beyond the last.
fn between(values: &[f64], place: f64) -> Option<f64> {
    let lower = place as usize;
    let upper = values.get(lower + 1)?;
    let part = place - lower as f64;
    Some(values[lower] * (1.0 - part) + upper * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rings() -> Rings {
        Rings::over((0.0, PI), 5e-4, 1e-3)
    }

    #[test]
    fn the_first_dark_ring_holds_the_published_share() {
        // BW99, section 8.5.2: dark rings at 1.220 and 2.233 π with 0.838 and 0.910 of the light within.
        for (u, expected) in [(1.220 * PI, 0.838), (2.233 * PI, 0.910)] {
            assert!((encircled(u) - expected).abs() < 5e-4, "{}", encircled(u));
            assert!(libm::j1(u).abs() < 1e-3);
        }
    }

    #[test]
    fn far_out_the_expansion_takes_over() {
        for u in [FAR, 61.7, 300.0, 599.0] {
            let off = (far_out(u) - encircled(u)).abs();
            assert!(off < u.powi(-3), "{u}: {off}");
        }
        assert!((far_out(4321.0) - encircled(4321.0)).abs() < 2e-8);
    }

    #[test]
    fn a_law_is_the_sum_over_its_sizes() {
        for variance in [0.0, 1e-4, 0.1, 0.3] {
            let law = Diffraction::new(variance).unwrap();
            let literal = |u: f64| -> f64 {
                let terms = law.sizes.iter();
                terms
                    .map(|(radius, weight)| weight * encircled(radius * u))
                    .sum()
            };
            for u in [0.2, 0.5, 3.8, 7.07, 25.3, 45.0, 130.0] {
                let ring = |of: &dyn Fn(f64) -> f64| of(1.2 * u) - of(u);
                let [found, expected] = [ring(&|u| law.within(u)), ring(&literal)];
                assert!(
                    (found / expected - 1.0).abs() < 0.01,
                    "{variance} {u}: {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn all_of_it_is_one_geometric_cross_section() {
        let rings = rings();
        for (x, variance) in [(300.0, 0.0), (3000.0, 0.1), (50_000.0, 1.0 / 3.0)] {
            let light = Diffraction::new(variance)
                .unwrap()
                .light(&Places::Rings(rings), x);
            let cosine = |index| rings.edge_rad(index).cos();
            let ring =
                |(index, light): (usize, &f64)| TAU * (cosine(index) - cosine(index + 1)) * light;
            let total: f64 = light.iter().enumerate().map(ring).sum();
            // What is left behind the drop: 1/(π x).
            assert!((total - 1.0).abs() < 1.0 / x, "x = {x}: {total}");
        }
    }

    #[test]
    fn means_over_rings_are_those_of_the_pattern_and_forward_it_is_x_squared_over_4_pi() {
        let x = 400.0;
        let law = Diffraction::new(0.0).unwrap();
        let rings = rings();
        let means = law.light(&Places::Rings(rings), x);
        for ring in [0, 1, 7, 30, 31, 100] {
            let n = 200;
            let angle = |part: f64| {
                rings.edge_rad(ring) + (rings.edge_rad(ring + 1) - rings.edge_rad(ring)) * part
            };
            let angles: Vec<f64> = (0..n)
                .map(|i| angle((f64::from(i) + 0.5) / 200.0))
                .collect();
            let light = law.light(&Places::Angles(angles.clone()), x);
            let of_sky: f64 = angles.iter().map(|theta| theta.sin()).sum();
            let sum: f64 = light
                .iter()
                .zip(&angles)
                .map(|(t, theta)| t * theta.sin())
                .sum();
            let (expected, peak) = (sum / of_sky, x * x / (4.0 * PI));
            // Measured worst 1.2e-5 of the peak: E is linear between its nodes.
            assert!((means[ring] - expected).abs() < 3e-5 * peak, "{ring}");
        }
        let forward = law.light(&Places::Angles(vec![0.0]), x)[0];
        assert!((forward / (x * x / (4.0 * PI)) - 1.0).abs() < 1e-12);
    }
}
