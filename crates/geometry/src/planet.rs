//! Rays around a spherical planet, written from heights.
//!
//! A ray starts at height h0 with cosine mu of its zenith angle; r0 = R + h0. At distance s
//!   r = sqrt(r0^2 + s (2 r0 mu + s)),  h(s) = h0 + s (2 r0 mu + s)/(r + r0)
//! It crosses the shell of height t at  -b -+ d,  b = r0 mu,  d = sqrt(b^2 + C),
//!   C = (t - h0)(2R + t + h0);  its perigee is at  h0 - r0 mu^2/(1 + sqrt(1 - mu^2))
//! All lengths in metres. Subtracting two radii instead loses nine decimal digits of a height of a
//! few metres, in f32 the height itself: every difference of radii here is factored by hand.
//! Refraction is not included. In the world frame the center lies at (0, -R, 0), so that y = 0 is
//! the tangent plane at sea level.

use glam::DVec3;
use niji_radiometry::Radians;

/// A spherical planet whose surface touches the plane y = 0 at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Planet {
    /// Radius at sea level, m.
    pub radius_m: f64,
}

/// The mean Earth, 6371 km.
pub const EARTH: Planet = Planet {
    radius_m: 6_371_000.0,
};

/// Rounding of the squared distance to where a ray touches the ground, of heights and cosines that were
/// computed along it: the ground is lower by less than a millionth of a millimetre after 1000 km.
const TOUCHING: f64 = 16.0 * f64::EPSILON;

impl Planet {
    /// Height of a point of the world above sea level, m.
    #[must_use]
    pub fn height_m(&self, point: DVec3) -> f64 {
        let r = DVec3::new(point.x, point.y + self.radius_m, point.z).length();
        let r2_minus_radius2 =
            point.x * point.x + point.z * point.z + point.y * (point.y + 2.0 * self.radius_m);
        r2_minus_radius2 / (r + self.radius_m)
    }

    /// Unit vector away from the center; straight up along y at the center itself.
    #[must_use]
    pub fn zenith(&self, point: DVec3) -> DVec3 {
        DVec3::new(point.x, point.y + self.radius_m, point.z).normalize_or(DVec3::Y)
    }

    /// Cosine of the zenith angle of `direction` (a unit vector) at a point of the world.
    #[must_use]
    pub fn cos_zenith(&self, point: DVec3, direction: DVec3) -> f64 {
        clamp_cosine(self.zenith(point).dot(direction))
    }

    /// Height above sea level after `distance_m` along a ray that starts at `height_m`, m.
    #[must_use]
    pub fn height_along_ray(&self, height_m: f64, cos_zenith: f64, distance_m: f64) -> f64 {
        let r0 = self.radius_m + height_m;
        let rise = distance_m * (2.0 * r0 * cos_zenith + distance_m);
        let r = safe_sqrt(r0 * r0 + rise);
        height_m + rise / (r + r0)
    }

    /// Cosine of the zenith angle of the ray itself after `distance_m`.
    #[must_use]
    pub fn cos_zenith_along_ray(&self, height_m: f64, cos_zenith: f64, distance_m: f64) -> f64 {
        let r0 = self.radius_m + height_m;
        let r = safe_sqrt(r0 * r0 + distance_m * (2.0 * r0 * cos_zenith + distance_m));
        if r > 0.0 {
            clamp_cosine((r0 * cos_zenith + distance_m) / r)
        } else {
            1.0
        }
    }

    /// Distance to the first crossing of the shell of height `shell_height_m`, from either side.
    ///
    /// A ray that starts on the shell crosses it at 0.
    #[must_use]
    pub fn distance_to_shell(
        &self,
        height_m: f64,
        cos_zenith: f64,
        shell_height_m: f64,
    ) -> Option<f64> {
        let (enter_m, leave_m) = self.shell_chord(height_m, cos_zenith, shell_height_m)?;
        Some(if height_m < shell_height_m {
            leave_m
        } else {
            enter_m
        })
    }

    /// Distances between which a ray is below `shell_height_m`, both at least 0.
    ///
    /// This clips a view ray to the air, wherever its observer is: (0, exit) from inside, (entry,
    /// exit) from above, `None` where the ray passes over the shell or leads away from it.
    #[must_use]
    pub fn shell_chord(
        &self,
        height_m: f64,
        cos_zenith: f64,
        shell_height_m: f64,
    ) -> Option<(f64, f64)> {
        let (h, t) = (height_m, shell_height_m);
        let b = (self.radius_m + h) * cos_zenith;
        let c = (t - h) * (2.0 * self.radius_m + t + h);
        let d2 = b * b + c;
        // Also where a number is NaN.
        if d2.is_nan() || d2 < 0.0 {
            return None;
        }
        let d = d2.sqrt();
        // The root without cancellation; the other follows from the product -c of both.
        if b >= 0.0 {
            let sum = b + d;
            let leave_m = if sum > 0.0 { c / sum } else { 0.0 };
            return (leave_m >= 0.0).then_some((0.0, leave_m));
        }
        let leave_m = d - b;
        Some(((-c / leave_m).max(0.0), leave_m))
    }

    /// Height of the lowest point of the whole line that a ray lies on, m.
    ///
    /// A ray reaches it only if it leads downwards; otherwise it lies behind the observer.
    #[must_use]
    pub fn perigee_height(&self, height_m: f64, cos_zenith: f64) -> f64 {
        let mu2 = cos_zenith * cos_zenith;
        let sin_zenith = safe_sqrt((1.0 - cos_zenith) * (1.0 + cos_zenith));
        height_m - (self.radius_m + height_m) * mu2 / (1.0 + sin_zenith)
    }

    /// Whether a ray ends on the ground: it leads downwards and dips below sea level.
    ///
    /// An observer at or below sea level stands on the ground: only what leads downwards ends on
    /// it.
    #[must_use]
    pub fn hits_ground(&self, height_m: f64, cos_zenith: f64) -> bool {
        self.distance_to_ground(height_m, cos_zenith).is_some()
    }

    /// Distance to sea level along a ray; `None` if it passes over the horizon.
    ///
    /// 0 for an observer at or below sea level who looks downwards. A ray that touches the ground to
    /// rounding passes over it.
    #[must_use]
    pub fn distance_to_ground(&self, height_m: f64, cos_zenith: f64) -> Option<f64> {
        // Also where the cosine is NaN.
        if cos_zenith.is_nan() || cos_zenith >= 0.0 {
            return None;
        }
        if height_m <= 0.0 {
            return Some(0.0);
        }
        let b = (self.radius_m + height_m) * cos_zenith;
        let above_m2 = height_m * (2.0 * self.radius_m + height_m);
        if b * b - above_m2 <= TOUCHING * above_m2 {
            return None;
        }
        self.distance_to_shell(height_m, cos_zenith, 0.0)
    }

    /// Angle by which the horizon lies below the horizontal: tan = sqrt(h (2R + h))/R.
    ///
    /// 0 for an observer at or below sea level.
    ///
    /// ```
    /// use niji_geometry::EARTH;
    ///
    /// // From 2 m the horizon lies 2.7 minutes of arc low and 5 km away.
    /// let dip = EARTH.horizon_dip(2.0);
    /// assert!((60.0 * dip.to_degrees() - 2.72).abs() < 0.01);
    /// assert!((EARTH.radius_m * dip.0 - 5048.0).abs() < 5.0);
    /// ```
    #[must_use]
    pub fn horizon_dip(&self, height_m: f64) -> Radians {
        let tangent_m = safe_sqrt(height_m * (2.0 * self.radius_m + height_m));
        let is_above = height_m > 0.0;
        Radians(if is_above {
            tangent_m.atan2(self.radius_m)
        } else {
            0.0
        })
    }
}

/// Keeps a cosine that rounding pushed over the edge within -1..1.
fn clamp_cosine(cosine: f64) -> f64 {
    cosine.clamp(-1.0, 1.0)
}

/// The root of a number that only rounding can make negative.
fn safe_sqrt(square: f64) -> f64 {
    if square < 0.0 { 0.0 } else { square.sqrt() }
}

#[cfg(test)]
#[path = "planet_tests.rs"]
mod tests;
