//! The flight of one drop through wind, from the nozzle until it falls into the basin.
//!
//! Exponential integrator of second order for dv/dt = (w - v)/tau + g:
//! v' = V + (v - V) e^(-h/tau),   x' = x + V h + (v - V) tau (1 - e^(-h/tau)),   V = w + g tau
//! `x` place, `v` velocity, `h` step, `V` the velocity at which drag carries the weight, and tau (see
//! `drag`) at the middle of the step, predicted by half a step with tau at its beginning. Both are
//! exact for constant tau, so that a step may be many times tau: a drop of 0.02 mm then moves with
//! the wind and sinks at its terminal speed, where an explicit method is unstable for h > 2 tau
//! (2.5 ms). Where tau depends on the speed, V is what a fixed-point iteration of u = g tau(u) gives,
//! which converges as |d ln tau/d ln u| < 1 below Newton's range; drops in Newton's range have tau of
//! a second, far longer than any step here.
//! [HO10] Hochbruck and Ostermann, Acta Numerica 19, 209-286 (2010).

use glam::DVec3;

use crate::drag::GRAVITY_M_S2;
use crate::drag::response_time_s;

/// A step takes this part of the time since the start, and of the response time there besides: a
/// flight takes some 20 (4 mm) to 120 (0.02 mm) steps, however long it drifts. Apex, range and time
/// of drops of 0.02..4 mm are within 0.15 % of those of steps a tenth as long.
const GROWTH: f64 = 0.06;

/// Steps after which a drop is given up: e^58 times its response time.
const MAX_STEPS: usize = 1000;

/// A drop at the nozzle, and the air.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Launch {
    /// Radius of the drop (m).
    pub(crate) radius_m: f64,
    /// Where it starts (m).
    pub(crate) position: DVec3,
    /// Velocity with which it starts (m/s).
    pub(crate) velocity: DVec3,
    /// Wind (m/s).
    pub(crate) wind: DVec3,
    /// Height at which it is lost (m).
    pub(crate) basin_y_m: f64,
}

/// Place (m) and velocity (m/s).
type State = (DVec3, DVec3);

/// A step of a flight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    /// Place and velocity at the beginning.
    pub(crate) start: State,
    /// Place and velocity at the end.
    pub(crate) end: State,
    /// How long it took (s).
    pub(crate) time_s: f64,
}

impl Launch {
    /// Follow the drop step by step into the basin.
    pub(crate) fn fly(&self, mut visit: impl FnMut(&Step)) {
        let rise_s = self.velocity.length() / GRAVITY_M_S2;
        let response_s = response_time_s(self.radius_m, (self.velocity - self.wind).length());
        let first_s = response_s.min(rise_s);
        let mut now_s = 0.0;
        let mut start = (self.position, self.velocity);
        for _ in 0..MAX_STEPS {
            let time_s = GROWTH * (now_s + first_s);
            let step = self.step(start, time_s);
            // Said so that a place that is not a number ends the flight.
            let flies = step.end.0.y > self.basin_y_m;
            if !flies {
                let share = step.first_time_at(self.basin_y_m);
                visit(&self.step(start, share * time_s));
                return;
            }
            visit(&step);
            start = step.end;
            now_s += time_s;
        }
    }

    /// A step of `h` seconds.
    fn step(&self, start: State, h: f64) -> Step {
        let (x, v) = start;
        let gravity = DVec3::new(0.0, -GRAVITY_M_S2, 0.0);
        let start_tau = response_time_s(self.radius_m, (v - self.wind).length());
        let start_drift = self.wind + gravity * start_tau;
        let predicted = start_drift + (v - start_drift) * (-0.5 * h / start_tau).exp();

        let tau = response_time_s(self.radius_m, (predicted - self.wind).length());
        let drift = self.wind + gravity * tau;
        // 1 - e^(-h/tau) without cancellation.
        let relaxed = -(-h / tau).exp_m1();
        let end = x + drift * h + (v - drift) * (tau * relaxed);
        let velocity = drift + (v - drift) * (1.0 - relaxed);
        Step {
            start,
            end: (end, velocity),
            time_s: h,
        }
    }
}

impl Step {
    /// Place at a share 0..=1 of the time, by the cubic that has the places and velocities of both
    /// ends (Hermite's).
    pub(crate) fn place(&self, share: f64) -> DVec3 {
        let ((x0, v0), (x1, v1)) = (self.start, self.end);
        let (t, rest) = (share, 1.0 - share);
        let bend = (v0 * rest - v1 * t) * self.time_s + (x1 - x0) * (t - rest);
        x0 * rest + x1 * t + bend * (t * rest)
    }

    /// Share of the time after which the path, which ends below it, comes down to a height.
    fn first_time_at(&self, y_m: f64) -> f64 {
        let (mut above, mut below) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (above + below);
            if self.place(middle).y > y_m {
                above = middle;
            } else {
                below = middle;
            }
        }
        above
    }
}

#[cfg(test)]
#[path = "fountain_flight_tests.rs"]
mod tests;
