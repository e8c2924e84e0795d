//! Rays cut into legs on which the height only rises or only falls.
//!
//! On a leg of length D the distance from its low end is  s = D u^2,  u in 0..1.
//! Density is stationary in height where a ray is level and falls exponentially above: in u both are
//! smooth, and Gauss-Legendre quadrature converges like an exponential; in s it would not.

use niji_geometry::Planet;

/// A point of a ray: its height and the cosine of the zenith angle there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RayPoint {
    pub(crate) height_m: f64,
    pub(crate) mu: f64,
}

impl RayPoint {
    /// The point farther along.
    pub(crate) fn advanced(self, planet: Planet, distance_m: f64) -> Self {
        Self {
            height_m: planet.height_along_ray(self.height_m, self.mu, distance_m),
            mu: planet.cos_zenith_along_ray(self.height_m, self.mu, distance_m),
        }
    }
}

/// A piece of a ray, from `near_m` to `far_m` along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Leg {
    pub(crate) near_m: f64,
    pub(crate) far_m: f64,
    /// Whether the height rises along the ray.
    pub(crate) rises: bool,
}

impl Leg {
    pub(crate) fn length_m(self) -> f64 {
        self.far_m - self.near_m
    }

    /// Distance along the ray at u.
    pub(crate) fn distance_m(self, u: f64) -> f64 {
        let from_low_m = self.length_m() * u * u;
        if self.rises {
            self.near_m + from_low_m
        } else {
            self.far_m - from_low_m
        }
    }

    /// Length of ray per u.
    pub(crate) fn stretch_m(self, u: f64) -> f64 {
        2.0 * self.length_m() * u
    }
}

/// Cuts `from_m..to_m` of a ray at its perigee and at the distances `breaks_m`.
pub(crate) fn legs(
    planet: Planet,
    start: RayPoint,
    [from_m, to_m]: [f64; 2],
    breaks_m: &[f64],
) -> Vec<Leg> {
    let perigee_m = -(planet.radius_m + start.height_m) * start.mu;
    let mut cuts_m: Vec<f64> = breaks_m.iter().copied().chain([perigee_m]).collect();
    cuts_m.retain(|&cut_m| cut_m > from_m && cut_m < to_m);
    cuts_m.sort_by(f64::total_cmp);
    let mut near_m = from_m;
    let mut legs = Vec::with_capacity(cuts_m.len() + 1);
    for far_m in cuts_m.into_iter().chain([to_m]) {
        if far_m > near_m {
            legs.push(Leg {
                near_m,
                far_m,
                rises: near_m >= perigee_m,
            });
            near_m = far_m;
        }
    }
    legs
}

/// Distances at which a ray crosses the given heights, both ways.
pub(crate) fn crossings(planet: Planet, start: RayPoint, heights_m: &[f64]) -> Vec<f64> {
    let chord = |&height_m: &f64| planet.shell_chord(start.height_m, start.mu, height_m);
    heights_m
        .iter()
        .filter_map(chord)
        .flat_map(|(enter_m, leave_m)| [enter_m, leave_m])
        .collect()
}
