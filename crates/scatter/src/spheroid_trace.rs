//! Rays through a spheroid in three dimensions, by numbers alone: what the tests hold shifts against.
//!
//! Light travels along +x, enters at a positive y and is seen in the plane z = 0, where the scattering
//! angle has an extreme along the plane. Shares no line with [`crate::spheroid_ray`].

use niji_airy::rainbow_ray;
use niji_exchange::BowShift;

type Vector = [f64; 3];

/// Index, order and axis ratio.
#[derive(Clone, Copy)]
pub(crate) struct TracedDrop {
    pub(crate) index: f64,
    pub(crate) order: u32,
    pub(crate) axis_ratio: f64,
}

/// Where one looks around the bow: height of the sun, and clock angle from its top.
#[derive(Clone, Copy)]
pub(crate) struct View {
    pub(crate) sun_deg: f64,
    pub(crate) clock_deg: f64,
}

impl View {
    /// Components of the vertical along the light, along the way it is turned, and across.
    pub(crate) fn upright(self) -> Vector {
        let (height, clock) = (self.sun_deg.to_radians(), self.clock_deg.to_radians());
        [
            -height.sin(),
            -height.cos() * clock.cos(),
            height.cos() * clock.sin(),
        ]
    }
}

/// T² and B² of an axis with components as [`View::upright`] gives them, at a scattering angle.
pub(crate) fn squares(axis: Vector, theta_rad: f64) -> [f64; 2] {
    let (sine, cosine) = (0.5 * theta_rad).sin_cos();
    let t = axis[0] * cosine + axis[1] * sine;
    let b = axis[1] * cosine - axis[0] * sine;
    [t * t, b * b]
}

/// θ of the bow where θ = θ_R + Δθ of the direction itself.
pub(crate) fn predicted_theta_rad(shift: &BowShift, drop: TracedDrop, axis: Vector) -> f64 {
    let start = rainbow_ray(drop.index, drop.order).unwrap().theta_rad();
    let e = (1.0 - drop.axis_ratio) / (1.0 + drop.axis_ratio);
    let step = |theta: f64, _| {
        let [t2, b2] = squares(axis, theta);
        start + shift.shift_rad(e, t2, b2)
    };
    (0..60).fold(start, step)
}

impl TracedDrop {
    /// θ of the bow in the plane of the light and the way it is turned.
    pub(crate) fn theta_rad(self, axis: Vector) -> f64 {
        let ray = rainbow_ray(self.index, self.order).unwrap();
        // Seen from the light that enters at positive y.
        let side = -ray.deviation_rad.sin().signum();
        let axis = [axis[0], side * axis[1], axis[2]];
        let kappa = self.axis_ratio.powi(-2) - 1.0;
        // The shadow's edge along y.
        let limb = {
            let [x, y, _] = axis;
            let across = kappa * x * y;
            (1.0 + kappa * y * y - across * across / (1.0 + kappa * x * x))
                .sqrt()
                .recip()
        };
        let theta = |incidence: f64| {
            let u = self.in_plane(axis, limb * incidence.sin());
            u[1].abs().atan2(u[0])
        };
        // The bow is where the bright side begins; some light beyond it meets no drop at all.
        let beyond = |incidence: &f64| ray.bright_side() * theta(*incidence);
        let near = (-25..25).map(|step| ray.incidence_rad + 0.01 * f64::from(step));
        let lit = near.filter(|incidence| beyond(incidence).is_finite());
        let start = lit.min_by(|one, other| beyond(one).total_cmp(&beyond(other)));
        let mut incidence = start.unwrap();
        let h = 2e-4;
        for _ in 0..60 {
            let [below, at, above] = [-h, 0.0, h].map(|h| theta(incidence + h));
            let step = 0.5 * h * (above - below) / (above - 2.0 * at + below);
            incidence -= step.clamp(-0.02, 0.02);
            if step.abs() < 1e-9 {
                break;
            }
        }
        theta(incidence)
    }

    /// The direction of light that enters at `b` in the plane and beside it where it leaves in the plane.
    fn in_plane(self, axis: Vector, b: f64) -> Vector {
        let (mut old, mut c) = (0.0, 1e-4);
        let mut off = self.direction(axis, [b, old])[2];
        for _ in 0..30 {
            let u = self.direction(axis, [b, c]);
            if u[2].abs() < 1e-15 || (u[2] - off).abs() < 1e-17 {
                return u;
            }
            let next = c - u[2] * (c - old) / (u[2] - off);
            (old, off, c) = (c, u[2], next);
        }
        self.direction(axis, [b, c])
    }

    fn direction(self, axis: Vector, [b, c]: [f64; 2]) -> Vector {
        let kappa = self.axis_ratio.powi(-2) - 1.0;
        let form = |u: Vector, v: Vector| dot(u, v) + kappa * dot(u, axis) * dot(v, axis);
        let mut u = [1.0, 0.0, 0.0];
        let mut x = [-3.0, b, c];
        for surface in 0..=self.order {
            let (a, half, rest) = (form(u, u), form(x, u), form(x, x) - 1.0);
            let root = (half * half - a * rest).sqrt();
            let sign = if surface == 0 { -1.0 } else { 1.0 };
            x = moved(x, u, (sign * root - half) / a);
            let gradient = moved(x, axis, kappa * dot(x, axis));
            let size = dot(gradient, gradient).sqrt();
            let normal = gradient.map(|g| g / size);
            let along = dot(u, normal);
            u = if surface == 0 || surface == self.order {
                let ratio = if surface == 0 {
                    self.index.recip()
                } else {
                    self.index
                };
                let root = (1.0 - ratio * ratio * (1.0 - along * along)).sqrt();
                moved(
                    u.map(|u| ratio * u),
                    normal,
                    along.signum() * root - ratio * along,
                )
            } else {
                moved(u, normal, -2.0 * along)
            };
        }
        u
    }
}

fn dot(u: Vector, v: Vector) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn moved(x: Vector, u: Vector, length: f64) -> Vector {
    [0, 1, 2].map(|j| x[j] + length * u[j])
}
