//! The antisolar point that fits picked pixels best.
//!
//! S = sum_i ((a_i − theta − o_i)/sigma_i)² + ((theta − theta_0)/tau)²  ->  minimum
//! `a_i` angle between pick i and the antisolar point, `theta` the bow angle, `o_i` by how much the
//! pick's color edge lies outside the others, `sigma_i` the noise of the pick across the bow: pixels
//! of noise times the change of `a_i` with the pixel. `theta_0`, `tau` the soft prior on the bow
//! angle, left out where there is none. Gauss-Newton with Levenberg's damping on two tangent
//! directions and theta; the covariance is the inverse of the undamped normal matrix.
//! [NW06] J. Nocedal, S. J. Wright, Numerical Optimization, 2nd ed., ch. 10 (2006).

use glam::DMat3;
use glam::DVec3;
use niji_geometry::PinholeCamera;
use niji_radiometry::Radians;

use crate::circle_through_picks::angle_between;

/// Most steps; from the starts used here the worst case found takes 40.
const MOST_STEPS: usize = 200;
/// Times that weights are renewed: the last one moves good fits by less than 1e-9 radians.
const N_ROUNDS: usize = 4;
/// Steps shorter than this end the search, radians.
const STEP_END_RAD: f64 = 1e-13;
/// Damping at the start and its factor after a good or bad step.
const FIRST_DAMPING: f64 = 1e-3;
const DAMPING_FACTOR: f64 = 8.0;
/// Damping at which no step helps any more.
const LAST_DAMPING: f64 = 1e12;
/// Errors of the direction above this are none: the picks do not determine it.
const LARGEST_ERROR_RAD: f64 = 1.0;
/// A normal matrix is singular when its determinant is this small a part of its diagonal's product.
const SINGULAR: f64 = 1e-20;

/// What is known of the bow angle in advance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BowAnglePrior {
    /// Its expected value.
    pub angle: Radians,
    /// Its standard error.
    pub standard_error: Radians,
}

/// Picked pixels and what is known about them.
#[derive(Clone, Copy, Debug)]
pub struct FitRequest<'a> {
    /// The camera that took the picture.
    pub camera: &'a PinholeCamera,
    /// Picked points, pixels from the top left corner of the picture.
    pub picks_px: &'a [[f64; 2]],
    /// Angle by which each pick's edge lies outside the bow angle that is sought, radians.
    pub offsets_rad: &'a [f64],
    /// Standard error of a pick along each axis, pixels.
    pub noise_px: f64,
    /// The bow angle, where it is known.
    pub prior: Option<BowAnglePrior>,
}

/// An antisolar point that fits better than any nearby.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BowFit {
    /// Unit vector to the antisolar point.
    pub antisolar: DVec3,
    /// The bow angle.
    pub bow_angle: Radians,
    /// The sum S of squares.
    pub misfit: f64,
    /// Root of the mean square of a_i − theta − o_i.
    pub residual: Radians,
    /// How well it is known; `None` where the picks do not determine it.
    pub errors: Option<FitErrors>,
}

/// Standard errors of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitErrors {
    /// Across: along the horizon, as an angle on the sky.
    pub across: Radians,
    /// Up: in elevation.
    pub up: Radians,
    /// Correlation of both: across to the right as seen from inside the sphere.
    pub correlation: f64,
    /// Of the bow angle.
    pub bow_angle: Radians,
}

impl FitErrors {
    /// Root of the summed squares across and up.
    #[must_use]
    pub fn direction(&self) -> Radians {
        Radians(self.across.0.hypot(self.up.0))
    }
}

/// The state of the search.
#[derive(Clone, Copy)]
struct State {
    antisolar: DVec3,
    theta_rad: f64,
}

/// Normal equations in the frame (across, up, theta).
struct Normal {
    matrix: DMat3,
    gradient: DVec3,
    misfit: f64,
}

/// Descends from a start to the nearest fit.
///
/// Weights are held while a fit descends and renewed from its end: weights that follow every step
/// are no sum of squares, and bad fits would not settle.
#[must_use]
pub(crate) fn fit_bow(request: &FitRequest, start: DVec3) -> BowFit {
    let mut state = State {
        antisolar: start.normalize(),
        theta_rad: 0.0,
    };
    state.theta_rad = start_theta(request, state.antisolar);
    for _ in 0..N_ROUNDS {
        state = descend(request, &weights(request, state.antisolar), state);
    }
    let normal = normal_equations(request, &weights(request, state.antisolar), state);
    BowFit {
        antisolar: state.antisolar,
        bow_angle: Radians(state.theta_rad),
        misfit: normal.misfit,
        residual: Radians(residual_rad(request, state)),
        errors: errors(&normal.matrix),
    }
}

fn descend(request: &FitRequest, weights: &[f64], mut state: State) -> State {
    let mut normal = normal_equations(request, weights, state);
    let mut damping = FIRST_DAMPING;
    for _ in 0..MOST_STEPS {
        let step = damped_step(&normal, damping);
        let next = moved(state, step);
        let next_normal = normal_equations(request, weights, next);
        if next_normal.misfit <= normal.misfit {
            (state, normal) = (next, next_normal);
            damping = (damping / DAMPING_FACTOR).max(f64::MIN_POSITIVE);
            if step.length() < STEP_END_RAD {
                break;
            }
        } else {
            damping *= DAMPING_FACTOR;
            if damping > LAST_DAMPING || step.length() < STEP_END_RAD {
                break;
            }
        }
    }
    state
}

fn start_theta(request: &FitRequest, antisolar: DVec3) -> f64 {
    if let Some(prior) = request.prior {
        return prior.angle.0;
    }
    let angles = request.picks_px.iter().zip(request.offsets_rad);
    let sum: f64 = angles
        .map(|(pick, offset)| angle_between(direction(request.camera, *pick), antisolar) - offset)
        .sum();
    sum / request.picks_px.len() as f64
}

fn direction(camera: &PinholeCamera, [x_px, y_px]: [f64; 2]) -> DVec3 {
    camera.ray(x_px, y_px).direction
}

/// Unit vectors across (to the right) and up at a direction; at the zenith any pair.
pub(crate) fn across_and_up(direction: DVec3) -> (DVec3, DVec3) {
    let across = direction.cross(DVec3::Y);
    let across = if across.length() > 1e-9 {
        across.normalize()
    } else {
        DVec3::X
    };
    (across, across.cross(direction))
}

/// Standard error of the angle between a pick and the antisolar point.
fn pick_noise_rad(request: &FitRequest, [x_px, y_px]: [f64; 2], antisolar: DVec3) -> f64 {
    let angle = |x_px, y_px| angle_between(direction(request.camera, [x_px, y_px]), antisolar);
    let by_x = angle(x_px + 0.5, y_px) - angle(x_px - 0.5, y_px);
    let by_y = angle(x_px, y_px + 0.5) - angle(x_px, y_px - 0.5);
    // Where a pick lies on the antisolar point itself its angle has no slope.
    request.noise_px * by_x.hypot(by_y).max(0.5 * request.camera.pixel_angle().0)
}

fn weights(request: &FitRequest, antisolar: DVec3) -> Vec<f64> {
    let picks = request.picks_px.iter();
    picks
        .map(|pick| pick_noise_rad(request, *pick, antisolar).powi(-2))
        .collect()
}

fn normal_equations(request: &FitRequest, weights: &[f64], state: State) -> Normal {
    let (across, up) = across_and_up(state.antisolar);
    let mut normal = Normal {
        matrix: DMat3::ZERO,
        gradient: DVec3::ZERO,
        misfit: 0.0,
    };
    let mut add = |row: DVec3, residual: f64, weight: f64| {
        normal.matrix += weight * DMat3::from_cols(row.x * row, row.y * row, row.z * row);
        normal.gradient += weight * residual * row;
        normal.misfit += weight * residual * residual;
    };
    let picks = request.picks_px.iter().zip(request.offsets_rad);
    for ((pick, offset), weight) in picks.zip(weights) {
        let view = direction(request.camera, *pick);
        let angle = angle_between(view, state.antisolar);
        let sine = angle.sin().max(1e-9);
        let row = DVec3::new(-view.dot(across) / sine, -view.dot(up) / sine, -1.0);
        add(row, angle - state.theta_rad - offset, *weight);
    }
    if let Some(prior) = request.prior {
        let residual = state.theta_rad - prior.angle.0;
        add(DVec3::Z, residual, prior.standard_error.0.powi(-2));
    }
    normal
}

/// Levenberg's step: the diagonal is raised by a part of itself.
fn damped_step(normal: &Normal, damping: f64) -> DVec3 {
    let matrix = normal.matrix;
    let diagonal = DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z);
    let raised = matrix + DMat3::from_diagonal(damping * diagonal.max(DVec3::splat(1e-12)));
    let step = -(raised.inverse() * normal.gradient);
    // Longer steps leave the region where the tangent plane stands for the sphere.
    if step.is_finite() {
        step.clamp_length_max(0.5)
    } else {
        DVec3::ZERO
    }
}

fn moved(state: State, step: DVec3) -> State {
    let (across, up) = across_and_up(state.antisolar);
    State {
        antisolar: (state.antisolar + step.x * across + step.y * up).normalize(),
        theta_rad: state.theta_rad + step.z,
    }
}

fn residual_rad(request: &FitRequest, state: State) -> f64 {
    let residuals = request.picks_px.iter().zip(request.offsets_rad);
    let squares: f64 = residuals
        .map(|(pick, offset)| {
            let angle = angle_between(direction(request.camera, *pick), state.antisolar);
            (angle - state.theta_rad - offset).powi(2)
        })
        .sum();
    (squares / request.picks_px.len() as f64).sqrt()
}

fn errors(matrix: &DMat3) -> Option<FitErrors> {
    let diagonal = matrix.x_axis.x * matrix.y_axis.y * matrix.z_axis.z;
    let determinant = matrix.determinant();
    // Also false for NaN.
    let is_sound = determinant > SINGULAR * diagonal;
    if !is_sound {
        return None;
    }
    let covariance = matrix.inverse();
    let across = covariance.x_axis.x.max(0.0).sqrt();
    let up = covariance.y_axis.y.max(0.0).sqrt();
    // False for NaN too.
    let is_known = across.hypot(up) < LARGEST_ERROR_RAD;
    is_known.then(|| FitErrors {
        across: Radians(across),
        up: Radians(up),
        correlation: (covariance.x_axis.y / (across * up)).clamp(-1.0, 1.0),
        bow_angle: Radians(covariance.z_axis.z.max(0.0).sqrt()),
    })
}
