//! What the few nodes of the air's light err by, measured on a few rays of the picture.
//!
//! e = 1.5 |L_n - L_2n| / L_2n
//! `L_n` luminance of air, sky and ground with the nodes of the level, `L_2n` with twice as many. These
//! err, too: at kinks of an ozone layer by up to half as much.
//!
//! The error hardly changes from pixel to pixel, but does with the elevation: the rays stand on 64 rows
//! and 16 columns of the whole frame, whatever region is rendered. A pixel has the largest error of the
//! four rays around it, times its own light of the air.

use ndarray::Array2;
use rayon::prelude::*;

use crate::painter::Brush;
use crate::painter::Painter;
use crate::ray_light::Manner;
use crate::ray_light::weighted_sum;

/// Columns and rows of rays.
const LATTICE: (u32, u32) = (16, 64);

/// How far errors exceed the difference from twice as many nodes, or parts among the drops, at kinks.
pub(crate) const DOUBT: f64 = 1.5;

/// Part of a tolerance that is left to the air.
const SHARE: f64 = 0.25;

/// No more nodes are taken from here on.
const MOST_NODES: usize = 40;

/// Relative errors of the air's light on a lattice of pixels.
pub(crate) struct AirError {
    /// Pixels from ray to ray.
    step_px: (u32, u32),
    /// By row and column.
    relative: Array2<f64>,
    /// The largest error (cd/m²).
    pub(crate) largest_cd_m2: f64,
}

impl AirError {
    /// None at all.
    pub(crate) fn none() -> Self {
        Self {
            step_px: (1, 1),
            relative: Array2::zeros((2, 2)),
            largest_cd_m2: 0.0,
        }
    }

    /// At a pixel of the frame, or the nearest of those to one beyond it.
    pub(crate) fn at(&self, (x_px, y_px): (f64, f64)) -> f64 {
        let cell = |at_px: f64, step_px: u32, n_rays: usize| {
            // Below 0 the cast ends at 0.
            ((at_px / f64::from(step_px)) as usize).min(n_rays - 2)
        };
        let (n_rows, n_columns) = self.relative.dim();
        let row = cell(y_px, self.step_px.1, n_rows);
        let column = cell(x_px, self.step_px.0, n_columns);
        let of_row =
            |row: usize| self.relative[[row, column]].max(self.relative[[row, column + 1]]);
        of_row(row).max(of_row(row + 1))
    }
}

impl Painter<'_> {
    /// Take more nodes of the air's light until it keeps to a part of a tolerance, or to their limit.
    pub(crate) fn refine_air(&mut self, tolerance_cd_m2: f64) {
        while self.air_error.largest_cd_m2 > SHARE * tolerance_cd_m2
            && self.frame.glow.n_nodes() < MOST_NODES
        {
            self.frame.glow = self.frame.glow.finer();
            self.air_error = self.measure_air();
        }
    }

    /// Measure the error of the air's light.
    pub(crate) fn measure_air(&self) -> AirError {
        let frame = &self.frame;
        if frame.air.is_none() || frame.glows == (false, false) {
            return AirError::none();
        }
        let camera = self.eye.camera;
        let step_px = (
            camera.width_px().div_ceil(LATTICE.0),
            camera.height_px().div_ceil(LATTICE.1),
        );
        let n_rows = camera.height_px().div_ceil(step_px.1) as usize + 1;
        let n_columns = camera.width_px().div_ceil(step_px.0) as usize + 1;
        let finer = frame.glow.finer();
        let errors: Vec<(f64, f64)> = (0..n_rows * n_columns)
            .into_par_iter()
            .map_init(
                || Brush::new(self),
                |brush, index| {
                    let x = (index % n_columns) as f64 * f64::from(step_px.0);
                    let y = (index / n_columns) as f64 * f64::from(step_px.1);
                    let Some(sight) = self.eye.sight(x + 0.5, y + 0.5) else {
                        return (0.0, 0.0);
                    };
                    let sight = (&sight, frame.range_m(&sight));
                    let mut luminance = |manner: Manner| {
                        frame.trace(sight, manner, &mut brush.light);
                        let light = &brush.light;
                        let parts = [&light.inscatter, &light.background];
                        parts
                            .map(|part| f64::from(weighted_sum(part, &self.xyz_weights).y))
                            .iter()
                            .sum::<f64>()
                    };
                    let manner = frame.manner(0.0);
                    let found = luminance(manner);
                    let expected = luminance(Manner {
                        glow: &finer,
                        ..manner
                    });
                    let error = DOUBT * (found - expected).abs();
                    (
                        error,
                        if expected > 0.0 {
                            error / expected
                        } else {
                            0.0
                        },
                    )
                },
            )
            .collect();
        AirError {
            step_px,
            relative: Array2::from_shape_fn((n_rows, n_columns), |(row, column)| {
                errors[row * n_columns + column].1
            }),
            largest_cd_m2: errors.iter().map(|(error, _)| *error).fold(0.0, f64::max),
        }
    }
}
