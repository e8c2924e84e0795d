//! The sun mirrored by waves: a streak of suns, each with the light of the facets that make it.
//!
//! Facets of slopes z along two axes, Gaussian of standard deviation sigma each, mirror the sun from
//! t = 2 (w . n) n - w,   u = -t
//! and give a drop above the water, over the sun's irradiance on a surface that faces it,
//! dE/E = R(w . n) (w . n)/(n_y t_y) G p(z) d²z,   G = 1/(1 + L(w) + L(t))
//! `w` unit vector towards the sun, `n` normal of the facet, `t` the way of the light after it, `u` the
//! mirrored sun, `R` reflectance, `p` density of slopes, `G` share of the facet that hills in front leave
//! (Smith), without which waves would send more light to the horizon than there is. In still water it is R.
//! 1/(1 + L) = (3.535 a + 2.181 a²)/(1 + 2.276 a + 2.577 a²) for a < 1.6, else 1,  a = tan(elevation)/(2^½ sigma)
//! [W07] Walter, Marschner, Li and Torrance, Proc. EGSR, 195-206 (2007).
//! [H14] Heitz, J. Comput. Graph. Tech. 3, 48-107 (2014), eq. 99: hills of one height.
//!
//! To first order a tilt turns the mirrored sun by twice itself in the plane of the sun, and by twice itself
//! times the sine of the sun's elevation across: the streak has the standard deviations 2 sigma and
//! 2 sigma sin(elevation). From one view ray it is seen as a spread of scattering angles, of which mean and
//! standard deviation are kept; the table is then averaged over a Gaussian.
//!
//! Light polarized along `a` = w x u is mirrored with R_s. At a drop the plane of scattering has the normal
//! N = u x d, `d` the view ray, at an angle alpha to it: of natural light E
//! E_s = E/2 [(R_s + R_p)/2 + (R_s - R_p)/2 cos 2 alpha],  E_p with a minus sign
//! across and along the plane of scattering. At the top of a bow alpha is 0.

use glam::DVec2;
use glam::DVec3;
use niji_radiometry::WavelengthGrid;

use crate::scattering_angle::scattering_angle_rad;
use crate::water_reflectance::water_reflectance;
use crate::water_surface::WaterSurface;
use crate::water_surface::mirrored;

/// Facets stand at these slopes apart, in standard deviations: the trapezoidal rule errs by
/// 2 exp(-2 pi²/0.75²) of a Gaussian.
const STEP: f64 = 0.75;
/// Steepest facets, in steps; beyond 3.75 standard deviations lie 2e-4.
const N_STEPS: i32 = 5;
/// Suns of less than this part of all light are left out.
const FAINT: f64 = 1e-4;

/// A mirrored sun.
#[derive(Clone, Copy, Debug)]
struct FacetSun {
    /// Towards it.
    direction: DVec3,
    /// Unit vector along which its light is polarized.
    across: DVec3,
    /// Irradiance over the sun's at the middle wavelength, (R_s + R_p)/2 and (R_s - R_p)/2 times the rest.
    natural: f64,
    polarized: f64,
}

/// The mirrored suns of a picture.
#[derive(Clone, Debug)]
pub(crate) struct SunStreak {
    suns: Vec<FacetSun>,
    /// Irradiance over the sun's by wavelength.
    pub(crate) natural: Vec<f32>,
    /// How much of it is polarized across the planes of incidence rather than along.
    pub(crate) polarized: Vec<f32>,
}

/// The streak along a view ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SeenStreak {
    /// Mean of the scattering angle.
    pub(crate) theta_rad: f64,
    /// Its standard deviation.
    pub(crate) sd_rad: f64,
    /// Mean of cos 2 alpha.
    pub(crate) cos_2_alpha: f64,
}

impl SunStreak {
    /// The suns that water shows to drops; `None` if the sun is not above the horizon.
    pub(crate) fn new(
        surface: &WaterSurface,
        sun_direction: DVec3,
        wavelengths: &WavelengthGrid,
    ) -> Option<Self> {
        if sun_direction.y <= 0.0 {
            return None;
        }
        let n = wavelengths.len();
        let index = |bin: usize| surface.water.refractive_index(wavelengths.center(bin));
        let indices: Vec<f64> = (0..n).map(index).collect();
        let (mut natural, mut polarized) = (vec![0.0; n], vec![0.0; n]);
        let facets = facets(surface.slope, sun_direction);
        let mut suns = Vec::with_capacity(facets.len());
        for facet in facets {
            for (bin, index) in indices.iter().enumerate() {
                let [s, p] = water_reflectance(*index, facet.cos_incidence);
                natural[bin] += facet.weight * 0.5 * (s + p);
                polarized[bin] += facet.weight * 0.5 * (s - p);
            }
            let [s, p] = water_reflectance(indices[n / 2], facet.cos_incidence);
            suns.push(FacetSun {
                direction: facet.mirrored,
                across: sun_direction.cross(facet.mirrored).normalize_or(DVec3::X),
                natural: facet.weight * 0.5 * (s + p),
                polarized: facet.weight * 0.5 * (s - p),
            });
        }
        let to_f32 = |values: Vec<f64>| values.into_iter().map(|value| value as f32).collect();
        Some(Self {
            suns,
            natural: to_f32(natural),
            polarized: to_f32(polarized),
        })
    }

    /// The streak along a view ray.
    pub(crate) fn seen(&self, view_direction: DVec3) -> SeenStreak {
        // Around the first angle: squares of angles would leave few digits.
        let first_rad = scattering_angle_rad(view_direction, self.suns[0].direction);
        let (mut weight, mut sum, mut squares) = (0.0, 0.0, 0.0);
        let (mut polarized, mut turned) = (0.0, 0.0);
        for sun in &self.suns {
            let off_rad = scattering_angle_rad(view_direction, sun.direction) - first_rad;
            weight += sun.natural;
            sum += sun.natural * off_rad;
            squares += sun.natural * off_rad * off_rad;
            let normal = sun.direction.cross(view_direction);
            polarized += sun.polarized;
            turned += sun.polarized * cos_2_between(sun.across, normal);
        }
        let mean_rad = sum / weight;
        SeenStreak {
            theta_rad: first_rad + mean_rad,
            sd_rad: (squares / weight - mean_rad * mean_rad).max(0.0).sqrt(),
            cos_2_alpha: if polarized > 0.0 {
                turned / polarized
            } else {
                0.0
            },
        }
    }

    /// The smallest standard deviation of scattering angles along any view ray, to first order.
    pub(crate) fn narrowest_rad(surface: &WaterSurface, sun_direction: DVec3) -> f64 {
        2.0 * surface.slope * sun_direction.y
    }
}

/// 2 (a . b)²/b² - 1 of a unit vector and another one: cosine of twice the angle between them; 0, the mean
/// over all turns, where the other has no direction.
pub(crate) fn cos_2_between(unit: DVec3, other: DVec3) -> f64 {
    let length_squared = other.length_squared();
    if length_squared > 1e-18 {
        2.0 * unit.dot(other).powi(2) / length_squared - 1.0
    } else {
        0.0
    }
}

/// What facets of one slope do.
#[derive(Clone, Copy, Debug)]
struct Facet {
    /// Towards the sun in them.
    mirrored: DVec3,
    /// w . n.
    cos_incidence: f64,
    /// Irradiance over the sun's if they reflected all light.
    weight: f64,
}

/// The facets of Gaussian slopes.
fn facets(slope: f64, sun_direction: DVec3) -> Vec<Facet> {
    if slope <= 0.0 {
        return vec![Facet {
            mirrored: mirrored(sun_direction),
            cos_incidence: sun_direction.y,
            weight: 1.0,
        }];
    }
    let along = sun_direction.with_y(0.0).normalize_or(DVec3::X);
    let across = DVec3::Y.cross(along);
    let steps = -N_STEPS..=N_STEPS;
    let places = steps
        .clone()
        .flat_map(|a| steps.clone().map(move |b| (a, b)));
    let places = places.map(|(a, b)| STEP * DVec2::new(f64::from(a), f64::from(b)));
    let density = |place: &DVec2| (-0.5 * place.length_squared()).exp();
    let all: f64 = places.clone().map(|place| density(&place)).sum();
    let mut facets: Vec<Facet> = places
        .filter_map(|place| {
            let slopes = slope * place;
            let normal = (DVec3::Y - along * slopes.x - across * slopes.y).normalize();
            facet((slope, sun_direction), normal, density(&place) / all)
        })
        .collect();
    let light = |facets: &[Facet]| facets.iter().map(|facet| facet.weight).sum::<f64>();
    let all = light(&facets);
    facets.retain(|facet| facet.weight > FAINT * all);
    let kept = light(&facets);
    for facet in &mut facets {
        facet.weight *= all / kept;
    }
    facets
}

/// The facets of a normal, a share of all waves of a slope; `None` if they send no light upwards.
fn facet((slope, sun_direction): (f64, DVec3), normal: DVec3, share: f64) -> Option<Facet> {
    let cos_incidence = sun_direction.dot(normal);
    let way = 2.0 * cos_incidence * normal - sun_direction;
    if cos_incidence <= 0.0 || way.y <= 0.0 {
        return None;
    }
    let hidden = |direction: DVec3| smith_lambda(slope, direction.y);
    let seen = 1.0 / (1.0 + hidden(sun_direction) + hidden(way));
    Some(Facet {
        mirrored: -way,
        cos_incidence,
        weight: share * seen * cos_incidence / (normal.y * way.y),
    })
}

/// L of a direction by the sine of its elevation (W07, section 5.2).
pub(crate) fn smith_lambda(slope: f64, sine: f64) -> f64 {
    let tangent = sine / (1.0 - sine * sine).max(0.0).sqrt();
    let a = tangent / (std::f64::consts::SQRT_2 * slope);
    if a >= 1.6 {
        return 0.0;
    }
    let seen = (3.535 + 2.181 * a) * a / (1.0 + (2.276 + 2.577 * a) * a);
    1.0 / seen.max(f64::MIN_POSITIVE) - 1.0
}

#[cfg(test)]
mod tests {
    use niji_radiometry::Water;

    use super::*;

    fn surface(slope: f64) -> WaterSurface {
        WaterSurface {
            height_m: 0.0,
            extent_m: [DVec2::NEG_INFINITY, DVec2::INFINITY],
            slope,
            water: Water::pure(15.0),
        }
    }

    fn sun(elevation_deg: f64) -> DVec3 {
        let (sine, cosine) = elevation_deg.to_radians().sin_cos();
        DVec3::new(0.0, sine, cosine)
    }

    fn streak(slope: f64, elevation_deg: f64) -> SunStreak {
        let wavelengths = WavelengthGrid::new(500.0, 50.0, 3).unwrap();
        let streak = SunStreak::new(&surface(slope), sun(elevation_deg), &wavelengths);
        streak.expect("the sun is up")
    }

    /// A view `bow_deg` from the point opposite the sun in still water, `clock_deg` from the top.
    fn view(elevation_deg: f64, bow_deg: f64, clock_deg: f64) -> DVec3 {
        let axis = -mirrored(sun(elevation_deg));
        let right = axis.cross(DVec3::Y).normalize();
        let up = right.cross(axis);
        let (bow, clock) = (bow_deg.to_radians(), clock_deg.to_radians());
        axis * bow.cos() + (right * clock.sin() + up * clock.cos()) * bow.sin()
    }

    /// Random facets, evenly spread (Roberts' sequence through the inverse of Box and Muller), each with its
    /// mirrored sun and its share of the light if it reflected all.
    fn random_facets(slope: f64, elevation_deg: f64) -> Vec<(DVec3, f64)> {
        let n = 40_000;
        let facet = |index: usize| {
            let place = index as f64 + 0.5;
            let radius = (-2.0 * ((place * 0.754_877_666_2).fract()).ln()).sqrt();
            let (sine, cosine) =
                (std::f64::consts::TAU * (place * 0.569_840_290_9).fract()).sin_cos();
            let slopes = slope * radius * DVec2::new(cosine, sine);
            let normal = DVec3::new(-slopes.x, 1.0, -slopes.y).normalize();
            let (w, share) = (sun(elevation_deg), 1.0 / n as f64);
            // Without the hills in front, which the suns below stand too high for.
            let way = 2.0 * w.dot(normal) * normal - w;
            let weight = share * w.dot(normal) / (normal.y * way.y);
            (-way, weight)
        };
        (0..n).map(facet).collect()
    }

    #[test]
    fn the_streak_is_twice_the_slope_high_and_that_times_the_sine_wide() {
        for (elevation_deg, slope) in [(20.0, 0.01), (40.0, 0.02), (10.0, 0.005)] {
            let streak = streak(slope, elevation_deg);
            for (clock_deg, expected) in [
                (0.0, 2.0 * slope),
                (90.0, 2.0 * slope * sun(elevation_deg).y),
                (180.0, 2.0 * slope),
            ] {
                let seen = streak.seen(view(elevation_deg, 42.0, clock_deg));
                // Fresnel's weights and second orders.
                let off = seen.sd_rad / expected - 1.0;
                assert!(off.abs() < 0.05, "{elevation_deg} {clock_deg} {off}");
            }
        }
    }

    #[test]
    fn random_facets_make_the_same_streak() {
        for (elevation_deg, slope) in [(25.0, 0.0387), (40.0, 0.0387), (12.0, 0.01)] {
            let streak = streak(slope, elevation_deg);
            let facets = random_facets(slope, elevation_deg);
            for clock_deg in [0.0, 30.0, 60.0, 90.0] {
                let direction = view(elevation_deg, 42.0, clock_deg);
                let (mut all, mut sum, mut squares) = (0.0, 0.0, 0.0);
                for (towards, weight) in &facets {
                    let cos_incidence = (0.5 * (1.0 - sun(elevation_deg).dot(*towards))).sqrt();
                    let [s, p] = water_reflectance(1.3355, cos_incidence);
                    let weight = weight * 0.5 * (s + p);
                    let theta = scattering_angle_rad(direction, *towards);
                    (all, sum) = (all + weight, sum + weight * theta);
                    squares += weight * theta * theta;
                }
                let mean = sum / all;
                let sd = (squares / all - mean * mean).sqrt();
                let seen = streak.seen(direction);
                // The suns at 3.75 standard deviations are the last.
                assert!((seen.theta_rad - mean).abs() < 0.01 * sd, "{clock_deg}");
                assert!((seen.sd_rad / sd - 1.0).abs() < 0.02, "{clock_deg}");
                let natural = f64::from(streak.natural[1]);
                assert!((natural / all - 1.0).abs() < 0.01, "{natural} {all}");
            }
        }
    }

    #[test]
    fn waves_send_up_what_falls_on_them_and_never_more() {
        for (elevation_deg, slope, least) in [
            (40.0, 0.0387, 0.999),
            (20.0, 0.0387, 0.999),
            (3.0, 0.0387, 0.6),
            (0.1, 0.1, 0.1),
        ] {
            let facets = facets(slope, sun(elevation_deg));
            let upwards: f64 = facets.iter().map(|it| -it.mirrored.y * it.weight).sum();
            let share = upwards / sun(elevation_deg).y;
            assert!(share < 1.01 && share > least, "{elevation_deg} {share}");
        }
    }

    #[test]
    fn waves_that_settle_leave_the_sun_in_still_water() {
        for elevation_deg in [1.0, 10.0, 60.0, 90.0] {
            let still = streak(0.0, elevation_deg);
            let [s, p] = water_reflectance(
                Water::pure(15.0).refractive_index(niji_radiometry::Nanometers(550.0)),
                sun(elevation_deg).y,
            );
            assert!((f64::from(still.natural[1]) - 0.5 * (s + p)).abs() < 1e-6);
            let settled = streak(1e-5, elevation_deg);
            for clock_deg in [0.0, 50.0, 90.0] {
                let direction = view(elevation_deg.min(80.0), 42.0, clock_deg);
                let [a, b] = [&still, &settled].map(|streak| streak.seen(direction));
                assert_eq!(a.sd_rad, 0.0);
                assert!(b.sd_rad < 3e-5 && (a.theta_rad - b.theta_rad).abs() < 1e-6);
                assert!((a.cos_2_alpha - b.cos_2_alpha).abs() < 1e-3 || elevation_deg > 80.0);
            }
            let off = settled.natural[1] / still.natural[1] - 1.0;
            assert!(off.abs() < 1e-3, "{off}");
        }
    }

    #[test]
    fn polarization_turns_with_the_clock_angle() {
        let still = streak(0.0, 10.0);
        for clock_deg in [0.0, 30.0, 45.0, 90.0, 135.0, 180.0_f64] {
            let seen = still.seen(view(10.0, 42.0, clock_deg));
            let expected = (2.0 * clock_deg.to_radians()).cos();
            assert!((seen.cos_2_alpha - expected).abs() < 1e-12, "{clock_deg}");
            assert!((seen.theta_rad - 138_f64.to_radians()).abs() < 1e-12);
        }
        // Opposite the mirrored sun no plane of scattering is another's better.
        assert_eq!(still.seen(-mirrored(sun(10.0))).cos_2_alpha, 0.0);
    }

    #[test]
    fn a_sun_on_or_below_the_horizon_has_no_image() {
        let wavelengths = WavelengthGrid::new(500.0, 50.0, 3).unwrap();
        for elevation_deg in [0.0, -5.0] {
            let streak = SunStreak::new(&surface(0.02), sun(elevation_deg), &wavelengths);
            assert!(streak.is_none());
        }
        // Just above it all is finite, waves or not.
        for slope in [0.0, 0.04, 0.3] {
            let streak = streak(slope, 1e-6);
            let seen = streak.seen(view(0.0, 42.0, 20.0));
            assert!(seen.theta_rad.is_finite() && seen.sd_rad.is_finite());
            assert!(streak.natural[0] > 0.0 && streak.natural[0] <= 1.0);
        }
    }

    #[test]
    fn a_gaussian_stands_for_the_streak_as_a_bow_sees_it() {
        // A bow 1 degree wide at 138 degrees, against the sum over all facets.
        let bow = |theta: f64| (-0.5 * ((theta.to_degrees() - 138.0) / 0.5).powi(2)).exp();
        let worst = |elevation_deg: f64, slope: f64| {
            let streak = streak(slope, elevation_deg);
            let mut worst = 0.0_f64;
            for clock_deg in [0.0, 45.0, 70.0, 90.0] {
                let (mut peak, mut off) = (0.0_f64, 0.0_f64);
                for bow_deg in (0..60).map(|step| 36.0 + 0.2 * f64::from(step)) {
                    let direction = view(elevation_deg, bow_deg, clock_deg);
                    let seen = streak.seen(direction);
                    let of_suns = |value: &dyn Fn(&FacetSun) -> f64| -> f64 {
                        streak.suns.iter().map(value).sum()
                    };
                    let exact = of_suns(&|sun| {
                        sun.natural * bow(scattering_angle_rad(direction, sun.direction))
                    }) / of_suns(&|sun| sun.natural);
                    // The mean of a Gaussian bow over a Gaussian.
                    let sd_deg = seen.sd_rad.to_degrees().hypot(0.5);
                    let off_deg = (seen.theta_rad.to_degrees() - 138.0) / sd_deg;
                    let found = 0.5 / sd_deg * (-0.5 * off_deg * off_deg).exp();
                    (peak, off) = (peak.max(exact), off.max((found - exact).abs()));
                }
                worst = worst.max(off / peak);
            }
            worst
        };
        for (elevation_deg, slope, allowed) in [(10.0, 0.005, 0.02), (20.0, 0.01, 0.02)] {
            let worst = worst(elevation_deg, slope);
            assert!(worst < allowed, "{elevation_deg} {slope} {worst}");
        }
    }
}
