//! A view ray through the air, with the sun as it is seen from it.
//!
//! Four numbers are enough on a sphere: height, the cosines mu of the view's and mu_s of the sun's
//! zenith angle at the observer, and nu, the cosine between them. After the distance s, with r as in
//! the geometry of rays:
//!   mu_s(s) = (r0 mu_s + s nu)/r
//! nu is also the cosine of the scattering angle: the sun's light travels along minus the sun's
//! direction, and leaves along minus the view's.
//! The planet's shadow is a cylinder, and so is that of a shell of height t above it. The ray meets
//! its wall where
//!   s^2 (1 - nu^2) + 2 r0 s (mu - mu_s nu) + [(h - t)(2R + h + t) - r0^2 mu_s^2] = 0,  behind the
//! planet.

use glam::DVec3;
use niji_geometry::Planet;

use crate::leg::RayPoint;

/// A view ray and the direction of the sun.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRay {
    /// Height of the observer, m.
    pub height_m: f64,
    /// Cosine of the zenith angle of the view.
    pub cos_zenith: f64,
    /// Length of the ray, m; may be infinite. The ground ends it in any case.
    pub length_m: f64,
    /// Cosine of the zenith angle of the sun at the observer.
    pub cos_sun_zenith: f64,
    /// Cosine between view and sun, and of the scattering angle.
    pub cos_scattering: f64,
}

impl ViewRay {
    /// The ray from a point of the world along a unit vector, with a unit vector towards the sun.
    pub fn new(
        planet: Planet,
        [position, direction, sun_direction]: [DVec3; 3],
        length_m: f64,
    ) -> Self {
        Self {
            height_m: planet.height_m(position),
            cos_zenith: planet.cos_zenith(position, direction),
            length_m,
            cos_sun_zenith: planet.cos_zenith(position, sun_direction),
            cos_scattering: direction.dot(sun_direction).clamp(-1.0, 1.0),
        }
    }

    /// The ray of an observer who looks `relative_azimuth_rad` away from the sun's azimuth.
    pub fn from_angles(
        height_m: f64,
        [view_elevation_rad, sun_elevation_rad, relative_azimuth_rad]: [f64; 3],
        length_m: f64,
    ) -> Self {
        let (sin_view, cos_view) = view_elevation_rad.sin_cos();
        let (sin_sun, cos_sun) = sun_elevation_rad.sin_cos();
        let nu = sin_view * sin_sun + cos_view * cos_sun * relative_azimuth_rad.cos();
        Self {
            height_m,
            cos_zenith: sin_view,
            length_m,
            cos_sun_zenith: sin_sun,
            cos_scattering: nu.clamp(-1.0, 1.0),
        }
    }

    pub(crate) fn start(&self) -> RayPoint {
        RayPoint {
            height_m: self.height_m,
            mu: self.cos_zenith,
        }
    }

    /// Height after a distance and cosine of the sun's zenith angle there.
    pub(crate) fn sun_at(&self, planet: Planet, distance_m: f64) -> [f64; 2] {
        let height_m = planet.height_along_ray(self.height_m, self.cos_zenith, distance_m);
        let r0 = planet.radius_m + self.height_m;
        let along_sun_m = r0 * self.cos_sun_zenith + distance_m * self.cos_scattering;
        [
            height_m,
            (along_sun_m / (planet.radius_m + height_m)).clamp(-1.0, 1.0),
        ]
    }

    /// The part of the ray that lies in the air: from where to where, m; `None` if there is none.
    pub(crate) fn in_air(&self, planet: Planet, top_height_m: f64) -> Option<[f64; 2]> {
        let (enter_m, leave_m) =
            planet.shell_chord(self.height_m, self.cos_zenith, top_height_m)?;
        let ground_m = planet.distance_to_ground(self.height_m, self.cos_zenith);
        // An observer below sea level looks at what stands around, not at a ground at distance 0.
        let ground_m = ground_m.filter(|&ground_m| ground_m > 0.0 || self.length_m.is_infinite());
        let end_m = leave_m
            .min(self.length_m)
            .min(ground_m.unwrap_or(f64::INFINITY));
        (end_m > enter_m).then_some([enter_m, end_m])
    }

    /// Whether the whole ray ends on the ground before its own length.
    pub fn ends_on_ground(&self, planet: Planet) -> bool {
        let ground_m = planet.distance_to_ground(self.height_m, self.cos_zenith);
        ground_m.is_some_and(|ground_m| ground_m <= self.length_m)
    }

    /// Distances at which the ray crosses the wall of the shadow of the planet up to a height: beyond,
    /// the sun's rays have their perigee above it.
    pub(crate) fn shadow_walls(&self, planet: Planet, shell_m: f64) -> Vec<f64> {
        let (nu, mu_s) = (self.cos_scattering, self.cos_sun_zenith);
        let r0 = planet.radius_m + self.height_m;
        let a = (1.0 - nu) * (1.0 + nu);
        let half_b = r0 * (self.cos_zenith - mu_s * nu);
        let above_shell_m2 =
            (self.height_m - shell_m) * (2.0 * planet.radius_m + self.height_m + shell_m);
        let c = above_shell_m2 - (r0 * mu_s).powi(2);
        let discriminant = half_b * half_b - a * c;
        if discriminant < 0.0 || a <= 0.0 {
            return Vec::new();
        }
        // The root without cancellation first, the other from the product c/a of both.
        let q = -(half_b + half_b.signum() * discriminant.sqrt());
        let roots = [q / a, if q.abs() > 0.0 { c / q } else { 0.0 }];
        let is_behind = |&s: &f64| s > 0.0 && r0 * mu_s + s * nu < 0.0;
        roots.into_iter().filter(is_behind).collect()
    }
}
