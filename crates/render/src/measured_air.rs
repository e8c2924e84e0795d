//! What the few nodes of the air err by, measured on a few rays of the picture.
//!
//! e = 1.5 |L_n - L_2n| / L_2n
//! `L_n` luminance of air, sky and ground, or of the bows that air dims, with the nodes of the level for
//! the air's light and for the ways through the air, `L_2n` with twice as many of both. These err, too: at
//! kinks of an ozone layer by up to half as much.
//!
//! The error hardly changes from pixel to pixel, but does with the elevation: the rays stand on 64 rows
//! and 16 columns of the whole frame, whatever region is rendered. A pixel has the largest error of the
//! four rays around it, times its own light of the air. Drops may stand between those rays: a bow has the
//! largest error of all.

use ndarray::Array2;
use rayon::prelude::*;

use crate::air::Air;
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
    /// Take more nodes of the air until its error keeps to a part of a tolerance, or to their limit.
    pub(crate) fn refine_air(&mut self, tolerance_cd_m2: f64) {
        while self.air_error.largest_cd_m2 > SHARE * tolerance_cd_m2
            && self.frame.glow.n_nodes() < MOST_NODES
        {
            self.frame.refine_air();
            self.air_error = self.measure_air();
        }
    }

    /// Measure the error of the air's nodes.
    pub(crate) fn measure_air(&self) -> AirError {
        let frame = &self.frame;
        let Some(finer_air) = frame.air.as_ref().map(Air::finer) else {
            return AirError::none();
        };
        let camera = self.eye.camera;
        let step_px = (
            camera.width_px().div_ceil(LATTICE.0),
            camera.height_px().div_ceil(LATTICE.1),
        );
        let n_rows = camera.height_px().div_ceil(step_px.1) as usize + 1;
        let n_columns = camera.width_px().div_ceil(step_px.0) as usize + 1;
        let finer_glow = frame.glow.finer();
        let lights: Vec<[MeasuredLight; 2]> = (0..n_rows * n_columns)
            .into_par_iter()
            .map_init(
                || Room::new(self),
                |room, index| {
                    let x = (index % n_columns) as f64 * f64::from(step_px.0);
                    let y = (index / n_columns) as f64 * f64::from(step_px.1);
                    let Some(sight) = self.eye.sight(x + 0.5, y + 0.5) else {
                        return Default::default();
                    };
                    room.light.begin_pixel();
                    let sight = (&sight, frame.range_m(&sight));
                    let mut light = |settings: RaySettings| {
                        frame.trace(sight, settings, &mut room.light);
                        let light = &room.light;
                        let luminance =
                            |part: &[f32]| f64::from(weighted_sum(part, &self.xyz_weights).y);
                        [
                            light.beside().into_iter().map(luminance).sum(),
                            luminance(&light.bow),
                        ]
                    };
                    let settings = frame.settings(0.0);
                    let found = light(settings);
                    let expected = light(RaySettings {
                        air: Some(&finer_air),
                        glow: &finer_glow,
                        ..settings
                    });
                    [0, 1].map(|part| MeasuredLight {
                        error_cd_m2: DOUBT * (found[part] - expected[part]).abs(),
                        luminance_cd_m2: expected[part],
                    })
                },
            )
            .collect();
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let all = || lights.iter();
        AirError {
            step_px,
            relative: Array2::from_shape_fn((n_rows, n_columns), |(row, column)| {
                lights[row * n_columns + column][0].relative_error()
            }),
            relative_of_bows: largest(&mut all().map(|[_, bows]| bows.relative_error())),
            largest_cd_m2: largest(
                &mut all().map(|[air, bows]| air.error_cd_m2 + bows.error_cd_m2),
            ),
        }
    }
}

/// Light of a ray and what it errs by.
#[derive(Clone, Copy, Default)]
struct MeasuredLight {
    error_cd_m2: f64,
    luminance_cd_m2: f64,
}

impl MeasuredLight {
    fn relative_error(&self) -> f64 {
        if self.luminance_cd_m2 > 0.0 {
            self.error_cd_m2 / self.luminance_cd_m2
        } else {
            0.0
        }
    }
}
