//! The facets of waves that a view ray sees, and what they mirror into it.
//!
//! m = d - 2 (d . n) n,   W(z) d²z = p(z) max(v . n, 0)/n_up d²z / int p max(v . n, 0)/n_up d²z
//! `d` direction of the ray, `v` = -d, `n` normal of the facets of slope z, `p` Gaussian of standard deviation sigma along
//! two axes, `W` share of those facets among all that are seen. Hills in front hide as much of each slope (Smith).
//! \[H14\] Heitz, J. Comput. Graph. Tech. 3, 48-107 (2014), eq. 16.
//!
//! Slopes t towards the eye are seen the better, v . n/n_up = v_up + t v_level: of them five even strata are taken, each by
//! the mean slope in it, for which the light is followed. What slopes vary by in a stratum, and across the view, spreads
//! scattering angles around that of the mean. Light that goes down from a facet is followed as if the water sent it up
//! again without loss.

use glam::DVec3;

/// Strata of the slopes that are seen, and the most facets that a ray sees.
pub(crate) const N_STRATA: usize = 5;

/// Pieces of the distribution of slopes, up to so many standard deviations.
const N_PIECES: usize = 40;
const REACH: f64 = 4.0;

/// Facets that are seen, of about one slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Facet {
    /// Share of what is seen of the water.
    pub(crate) share: f64,
    /// Unit vector into which the ray goes on.
    pub(crate) direction: DVec3,
    /// v . n.
    pub(crate) cos_incidence: f64,
    /// Unit vector across the plane of incidence.
    pub(crate) across: DVec3,
    /// The same ray from facets one standard deviation off: within the stratum, and across the view.
    pub(crate) beside: [DVec3; 2],
}

/// Mean and variance of the slopes of a stratum, and its share.
#[derive(Clone, Copy, Debug, Default)]
struct Stratum {
    share: f64,
    sum: f64,
    squares: f64,
}

/// The facets of a slope that a ray sees on water with an upward direction.
pub(crate) fn facets_seen(slope: f64, direction: DVec3, up: DVec3) -> Vec<Facet> {
    let view = -direction;
    let rise = view.dot(up).max(0.0);
    let level = (view - rise * up).normalize_or(up.any_orthonormal_vector());
    let across = up.cross(level);
    let goes_on = |along: f64, aside: f64| {
        let normal = (up + along * level + aside * across).normalize();
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        let down = mirrored.dot(up).min(0.0);
        (mirrored - 2.0 * down * up, view.dot(normal), normal)
    };
    let facet = |share: f64, mean: f64, sd: f64| {
        let (direction, cos_incidence, normal) = goes_on(mean, 0.0);
        Facet {
            share,
            direction,
            cos_incidence: cos_incidence.clamp(0.0, 1.0),
            across: normal.cross(view).normalize_or(across),
            beside: [goes_on(mean + sd, 0.0).0, goes_on(mean, slope).0],
        }
    };
    if slope <= 0.0 {
        return vec![facet(1.0, 0.0, 0.0)];
    }
    let run = (1.0 - rise * rise).max(0.0).sqrt();
    let strata = strata(slope, (rise, run)).into_iter();
    let strata = strata.filter(|stratum| stratum.share > 0.0);
    strata
        .map(
            |Stratum {
                 share,
                 sum,
                 squares,
             }| {
                let mean = sum / share;
                facet(share, mean, (squares / share - mean * mean).max(0.0).sqrt())
            },
        )
        .collect()
}

/// The slopes that a ray of this rise and run sees.
fn strata(slope: f64, (rise, run): (f64, f64)) -> [Stratum; N_STRATA] {
    let reach = REACH * slope;
    let first = if run > 0.0 { -rise / run } else { -reach };
    let first = first.max(-reach);
    let step = (reach - first) / N_PIECES as f64;
    let at = |piece: usize| first + (piece as f64 + 0.5) * step;
    let density = |t: f64| (-0.5 * (t / slope).powi(2)).exp() * (rise + t * run).max(0.0);
    let all: f64 = (0..N_PIECES).map(|piece| density(at(piece))).sum();
    let mut strata = [Stratum::default(); N_STRATA];
    let mut before = 0.0_f64;
    for piece in 0..N_PIECES {
        let (t, share) = (at(piece), density(at(piece)) / all);
        for (index, stratum) in strata.iter_mut().enumerate() {
            let [from, to] = [index, index + 1].map(|end| end as f64 / N_STRATA as f64);
            let to = if index + 1 == N_STRATA { 2.0 } else { to };
            let low = before.max(from);
            let part = (before + share).min(to) - low;
            if part > 0.0 {
                // Where in the piece the part lies: none jumps from stratum to stratum as the view moves.
                let t = t + step * ((low + 0.5 * part - before) / share - 0.5);
                stratum.share += part;
                stratum.sum += part * t;
                stratum.squares += part * t * t;
            }
        }
        before += share;
    }
    strata
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ray that comes down at an elevation.
    fn down(elevation_deg: f64) -> DVec3 {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        DVec3::new(0.0, -sin, -cos)
    }

    #[test]
    fn still_water_sends_a_ray_up_as_steep_as_it_comes_down() {
        for elevation_deg in [1e-6, 3.0, 50.0, 90.0] {
            let facets = facets_seen(0.0, down(elevation_deg), DVec3::Y);
            let [facet] = facets[..] else { panic!() };
            let expected = down(elevation_deg) * DVec3::new(1.0, -1.0, 1.0);
            assert!((facet.direction - expected).length() < 1e-15);
            assert!((facet.cos_incidence - expected.y).abs() < 1e-15);
            assert_eq!(facet.share, 1.0);
            assert_eq!(facet.beside, [facet.direction; 2]);
        }
    }

    #[test]
    fn strata_have_the_moments_of_the_slopes_that_are_seen() {
        for (slope, elevation_deg) in [(0.04, 40.0), (0.04, 3.0), (0.1, 0.5), (0.2, 0.0_f64)] {
            let (rise, run) = elevation_deg.to_radians().sin_cos();
            let strata = strata(slope, (rise, run));
            let n = 200_000;
            let (mut all, mut sum, mut squares) = (0.0, 0.0, 0.0);
            for index in 0..n {
                let t = slope * (-6.0 + 12.0 * (f64::from(index) + 0.5) / f64::from(n));
                let seen = (-0.5 * (t / slope).powi(2)).exp() * (rise + t * run).max(0.0);
                (all, sum, squares) = (all + seen, sum + seen * t, squares + seen * t * t);
            }
            let total = |value: fn(&Stratum) -> f64| strata.iter().map(value).sum::<f64>();
            assert!((total(|it| it.share) - 1.0).abs() < 1e-12);
            // Forty pieces; the slopes beyond four standard deviations.
            assert!((total(|it| it.sum) - sum / all).abs() < 2e-3 * slope);
            let off = total(|it| it.squares) * all / squares - 1.0;
            assert!(off.abs() < 4e-3, "{slope} {elevation_deg} {off}");
        }
    }

    #[test]
    fn waves_that_settle_show_what_still_water_does() {
        for elevation_deg in [0.5, 10.0, 80.0] {
            let still = facets_seen(0.0, down(elevation_deg), DVec3::Y)[0];
            for facet in facets_seen(1e-7, down(elevation_deg), DVec3::Y) {
                assert!((facet.direction - still.direction).length() < 1e-6);
                assert!((facet.cos_incidence - still.cos_incidence).abs() < 1e-6);
                assert!((facet.across - still.across).length() < 1e-12);
            }
        }
    }

    #[test]
    fn no_ray_goes_on_below_the_water_however_flat_it_comes() {
        for slope in [1e-3, 0.05, 0.35] {
            for elevation_deg in [0.0, 0.01, 2.0, 89.999] {
                let facets = facets_seen(slope, down(elevation_deg), DVec3::Y);
                let all: f64 = facets.iter().map(|it| it.share).sum();
                assert!((all - 1.0).abs() < 1e-12);
                for facet in facets {
                    assert!(facet.direction.y >= 0.0 && facet.direction.is_finite());
                    assert!((0.0..=1.0).contains(&facet.cos_incidence));
                }
            }
        }
    }
}
