//! Straight rays around a sphere, written from heights: what a lookup needs of them.
//!
//! From height h0 with cosine mu of the zenith angle, r0 = R + h0, after the distance s:
//!   rise = s (2 r0 mu + s),  r = sqrt(r0^2 + rise),  h = h0 + rise/(r + r0),  mu' = (r0 mu + s)/r
//! Radii are never subtracted: heights would lose nine digits.

/// One ray from one point: height of its start and cosine of its zenith angle.
#[derive(Clone, Copy, Debug)]
pub(super) struct RayStart {
    pub(super) radius_m: f64,
    pub(super) height_m: f64,
    pub(super) mu: f64,
}

impl RayStart {
    /// The same ray seen from a point farther along.
    pub(super) fn advanced(self, distance_m: f64) -> Self {
        let r0 = self.radius_m + self.height_m;
        let rise = distance_m * (2.0 * r0 * self.mu + distance_m);
        let r = safe_sqrt(r0 * r0 + rise).max(f64::MIN_POSITIVE);
        Self {
            radius_m: self.radius_m,
            height_m: self.height_m + rise / (r + r0),
            mu: ((r0 * self.mu + distance_m) / r).clamp(-1.0, 1.0),
        }
    }

    /// The ray into the opposite direction.
    pub(super) fn reversed(self) -> Self {
        Self {
            mu: -self.mu,
            ..self
        }
    }

    /// Height of the lowest point of the whole line.
    pub(super) fn perigee_height_m(self) -> f64 {
        let sin_zenith = safe_sqrt((1.0 - self.mu) * (1.0 + self.mu));
        let r0 = self.radius_m + self.height_m;
        self.height_m - r0 * self.mu * self.mu / (1.0 + sin_zenith)
    }

    /// Cosine of the zenith angle, not negative, where the line crosses a shell that it reaches:
    /// r mu' = sqrt(r0^2 mu^2 + (t - h0)(2R + t + h0)).
    pub(super) fn rising_mu_at(self, shell_height_m: f64) -> f64 {
        let (h, t) = (self.height_m, shell_height_m);
        let b = (self.radius_m + h) * self.mu;
        let c = (t - h) * (2.0 * self.radius_m + t + h);
        (safe_sqrt(b * b + c) / (self.radius_m + t)).min(1.0)
    }
}

/// The root of a number that only rounding can make negative.
pub(super) fn safe_sqrt(square: f64) -> f64 {
    if square > 0.0 { square.sqrt() } else { 0.0 }
}
