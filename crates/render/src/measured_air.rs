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

use crate::air_error::AirError;
use crate::air_glow::DOUBT;
use crate::ray_settings::RaySettings;
use crate::ray_tracer::RayTracer;
use crate::ray_tracer::Room;
use crate::spectra::weighted_sum;

/// Columns and rows of rays.
const LATTICE: (u32, u32) = (16, 64);

/// Part of a tolerance that is left to the air.
const SHARE: f64 = 0.25;

/// No more nodes are taken from here on.
const MOST_NODES: usize = 40;

impl RayTracer<'_> {
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
                || Room::new(self),
                |room, index| {
                    let x = (index % n_columns) as f64 * f64::from(step_px.0);
                    let y = (index / n_columns) as f64 * f64::from(step_px.1);
                    let Some(sight) = self.eye.sight(x + 0.5, y + 0.5) else {
                        return (0.0, 0.0);
                    };
                    let sight = (&sight, frame.range_m(&sight));
                    let mut luminance = |settings: RaySettings| {
                        frame.trace(sight, settings, &mut room.light);
                        let light = &room.light;
                        let parts = [&light.inscatter, &light.background];
                        parts
                            .map(|part| f64::from(weighted_sum(part, &self.xyz_weights).y))
                            .iter()
                            .sum::<f64>()
                    };
                    let settings = frame.settings(0.0);
                    let found = luminance(settings);
                    let expected = luminance(RaySettings {
                        glow: &finer,
                        ..settings
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
