//! A ray through the air, as a lookup sees it: its planet, height and zenith angle.
//!
//! x(t) = sqrt((r0 mu)^2 + (t - h0)(2R + t + h0))   [m]
//! is the distance along the line from its perigee to where it crosses the shell of height t;
//! `h0` height of the start, `r0 = R + h0`, `mu` cosine of the zenith angle. All else about rays
//! around a sphere is [`niji_geometry::Planet`]'s.

use niji_geometry::Planet;

/// One ray from one point: height of its start and cosine of its zenith angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayStart {
    pub(super) planet: Planet,
    pub(super) height_m: f64,
    pub(super) mu: f64,
}

impl RayStart {
    /// Distance of the start from the planet's center, m.
    pub(super) fn radius_m(self) -> f64 {
        self.planet.radius_m + self.height_m
    }

    /// Height after a distance.
    pub(super) fn height_after_m(self, distance_m: f64) -> f64 {
        self.planet
            .height_along_ray(self.height_m, self.mu, distance_m)
    }

    /// The same ray seen from a point farther along.
    pub(super) fn advanced(self, distance_m: f64) -> Self {
        Self {
            height_m: self.height_after_m(distance_m),
            mu: self
                .planet
                .cos_zenith_along_ray(self.height_m, self.mu, distance_m),
            ..self
        }
    }

    /// The ray into the opposite direction.
    pub(super) fn reversed(self) -> Self {
        Self {
            mu: -self.mu,
            ..self
        }
    }

    /// The lowest point of the whole line, where it is level.
    pub(super) fn perigee(self) -> Self {
        Self {
            height_m: self.planet.perigee_height(self.height_m, self.mu),
            mu: 0.0,
            ..self
        }
    }

    /// The rising line seen from where it crosses a shell that it reaches.
    pub(super) fn rising_at(self, shell_height_m: f64) -> Self {
        let radius_m = self.planet.radius_m + shell_height_m;
        Self {
            height_m: shell_height_m,
            mu: (self.perigee_distance_m(shell_height_m) / radius_m).min(1.0),
            ..self
        }
    }

    /// Distance from the perigee of the line to where it crosses a height; 0 below the perigee.
    fn perigee_distance_m(self, shell_height_m: f64) -> f64 {
        let (h, t) = (self.height_m, shell_height_m);
        let b = self.radius_m() * self.mu;
        let c = (t - h) * (2.0 * self.planet.radius_m + t + h);
        safe_sqrt(b * b + c)
    }

    /// Distance along a line that rises through both heights, without the difference of two
    /// distances where they are close: (t - h)(2R + t + h)/(x_t + x_h).
    pub(super) fn rising_distance_m(self, low_m: f64, high_m: f64) -> f64 {
        let (low_x, high_x) = (
            self.perigee_distance_m(low_m),
            self.perigee_distance_m(high_m),
        );
        let difference_of_squares =
            (high_m - low_m) * (2.0 * self.planet.radius_m + high_m + low_m);
        if high_x > 0.0 {
            difference_of_squares / (high_x + low_x)
        } else {
            0.0
        }
    }
}

/// The root of a number that only rounding can make negative.
pub(super) fn safe_sqrt(square: f64) -> f64 {
    if square > 0.0 { square.sqrt() } else { 0.0 }
}
