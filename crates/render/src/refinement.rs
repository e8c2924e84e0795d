//! More rays for the pixels whose estimated error is above a tolerance.
//!
//! A pixel is cut into 1, 2 x 2, 4 x 4, up to 16 x 16 parts, each seen along the ray through its middle
//! with the table's row averaged over the part, until its estimate holds. The footprint's estimate of
//! n x n rays is
//! e_n = max(|L_n - L_(n/2)|, e_(n/2) / 4),  e_(n/2) / 16 for turned parts
//! `L_n` luminance of the pixel: where luminance is smooth the difference is three times the error
//! that is left, at a step it is about as large; agreement by chance is not believed. Where 4 x 4 do
//! not suffice there is an edge: more parts are turned against the pixel, so that a horizon along a row
//! is met as well as any other. Rays take a finer quadrature. What rays cannot better, the errors of the
//! table and of the sun's depths, leaves them the rest of the tolerance, a quarter of it at least.
//!
//! Whether a pixel is refined depends on the pixel and its neighbors as they were before any was
//! refined, so not on tiles or threads.

use std::ops::Range;

use ndarray::Array2;
use ndarray::Axis;
use rayon::prelude::*;

use crate::error_parts::together;
use crate::footprint::offsets;
use crate::footprint::turned_offsets;
use crate::footprint_error::PixelLight;
use crate::footprint_error::cross;
use crate::levels::Integration;
use crate::levels::PixelFootprint;
use crate::march::March;
use crate::picture_layers::N_CAUSES;
use crate::picture_layers::Rendered;
use crate::picture_layers::TOTAL;
use crate::picture_tiles::TileMut;
use crate::ray_settings::RaySettings;
use crate::ray_tracer::RayTracer;
use crate::ray_tracer::Room;

/// Rays along a side of a pixel up to which its parts stand in line with it.
const MOST_SIDE_BY_SIDE: u32 = 4;

/// Most rays along a side of a pixel.
const MOST_ALONG: u32 = 16;

/// Relative error of the quadrature of rays that are added.
const FINE: f64 = 1e-6;

/// Part of the tolerance that is left to the rays whatever else errs.
const LEAST_SHARE: f64 = 0.25;

/// A pixel by column and row of its tile.
struct PixelOfTile<'a, 't> {
    tile: &'a mut TileMut<'t>,
    x: usize,
    y: usize,
}

/// Parts of a pixel, each seen along the ray through its middle.
struct Parts<'a, I> {
    /// Their middles, in pixels from the pixel's corner.
    places: I,
    march: &'a March<'a>,
    /// Intervals along a side with the variance of a part.
    n_intervals: u32,
}

/// How a pixel is refined.
struct Finer<'a> {
    march: &'a March<'a>,
    tolerance_cd_m2: f64,
    /// What the footprint's error would be if the pixel were prefiltered.
    missed_cd_m2: f64,
}

impl RayTracer<'_> {
    /// Give the pixels of rows whose estimate exceeds a tolerance more rays.
    pub(crate) fn refine(
        &self,
        picture: &mut Rendered,
        rows: Range<usize>,
        lights_around: &Array2<PixelLight>,
        tolerance_cd_m2: f64,
    ) {
        let march = fine_march(&self.frame.march);
        let tiles = picture.tiles_mut(&rows).into_par_iter();
        tiles.with_max_len(1).for_each_init(
            || Room::new(self),
            |room, mut tile| {
                // A copy: pixels are put on the way.
                let errors = tile.errors().index_axis(Axis(0), TOTAL).to_owned();
                for ((y, x), error) in errors.indexed_iter() {
                    if f64::from(*error) > tolerance_cd_m2 {
                        let (column, row) = tile.in_region((x, y));
                        let cross = cross(lights_around, column, row);
                        let finer = Finer {
                            march: &march,
                            tolerance_cd_m2,
                            missed_cd_m2: self.missed(&cross, PixelFootprint::Prefiltered),
                        };
                        let pixel = PixelOfTile {
                            tile: &mut tile,
                            x,
                            y,
                        };
                        self.refine_pixel(pixel, &finer, room);
                    }
                }
            },
        );
    }

    fn refine_pixel(&self, pixel: PixelOfTile, finer: &Finer, room: &mut Room) {
        let PixelOfTile { tile, x, y } = pixel;
        let errors = tile.errors();
        let parts: [f64; N_CAUSES] =
            std::array::from_fn(|cause| f64::from(errors[[1 + cause, y, x]]));
        let [quadrature, fixed @ .., footprint] = &parts;
        let of_rays = together(&[*quadrature, *footprint]);
        if of_rays <= allowance(finer.tolerance_cd_m2, together(fixed)) {
            // What errs here is nothing that rays can better.
            return;
        }
        let mut missed = match self.footprint {
            PixelFootprint::Center | PixelFootprint::Prefiltered => finer.missed_cd_m2,
            PixelFootprint::Grid { .. } => *footprint,
        };
        let mut before = tile.luminance((x, y), &self.xyz_weights);
        let mut is_refined = false;
        let place = self.place(tile.in_region((x, y)));
        for n in rays_to_try(self.footprint) {
            self.trace_parts(place, (n, finer.march), room);
            is_refined = true;
            let luminance = room.pixel.luminance();
            if n > 1 {
                missed = estimate_after(missed, before, luminance, n);
            }
            before = luminance;
            if missed <= allowance(finer.tolerance_cd_m2, room.pixel.errors.together()) {
                break;
            }
        }
        if is_refined {
            tile.put((x, y), &room.pixel);
            tile.put_missed((x, y), missed);
            for (mut plane, value) in tile.radiance.outer_iter_mut().zip(&room.pixel.radiance) {
                plane[[y, x]] = *value;
            }
        }
    }

    /// Gather n x n rays of a pixel, each with its part of the pixel's scattering angles. A few parts
    /// cover the pixel side by side; what these do not show is an edge.
    fn trace_parts(&self, place: (f64, f64), (n, march): (u32, &March), room: &mut Room) {
        if n <= MOST_SIDE_BY_SIDE {
            let parts = Parts {
                places: offsets(n),
                march,
                n_intervals: n,
            };
            self.trace_places(place, parts, room);
        } else {
            // Intervals between n² places along any side: the whole has the pixel's variance.
            let parts = Parts {
                places: turned_offsets(n),
                march,
                n_intervals: n * n,
            };
            self.trace_places(place, parts, room);
        }
    }

    /// Gather rays of a pixel.
    fn trace_places(
        &self,
        (x, y): (f64, f64),
        parts: Parts<'_, impl Iterator<Item = (f64, f64)> + Clone>,
        room: &mut Room,
    ) {
        let Parts {
            places,
            march,
            n_intervals,
        } = parts;
        let share = 1.0 / places.clone().count() as f64;
        let middle = self.eye.camera.ray(x + 0.5, y + 0.5);
        let width_rad = middle.map_or(0.0, |ray| self.width_rad(ray.direction, (x, y)));
        let width_rad = width_rad / f64::from(n_intervals);
        room.pixel.clear();
        for (dx, dy) in places {
            match self.eye.sight(x + dx, y + dy) {
                None => room.pixel.transmittance += share,
                Some(sight) => {
                    let sight = (&sight, self.frame.range_m(&sight));
                    let settings = RaySettings {
                        march,
                        ..self.frame.settings(width_rad)
                    };
                    self.frame.trace(sight, settings, &mut room.light);
                    room.pixel.add(&room.light, share, &self.xyz_weights);
                }
            }
        }
        room.pixel.add_air_error(&self.air_error, (x, y));
    }
}

/// The march of added rays.
fn fine_march<'a>(march: &March<'a>) -> March<'a> {
    let integration = Integration::Adaptive {
        relative_error: FINE,
    };
    March {
        rule: march.rule.at(integration),
        integration,
        ..*march
    }
}

/// Numbers of rays along a side to try after those of a level. The first rays of a pixel that was seen
/// along one ray are one with the mean of the row.
fn rays_to_try(level: PixelFootprint) -> impl Iterator<Item = u32> {
    let first = match level {
        PixelFootprint::Center => 1,
        PixelFootprint::Prefiltered => 2,
        PixelFootprint::Grid { n } => 2 * n,
    };
    std::iter::successors(Some(first), |n| Some(2 * n)).take_while(|n| *n <= MOST_ALONG)
}

/// The estimate of a footprint with n x n rays, twice as many along a side as that before. Turned places
/// stand 16 times as close as those side by side before them.
fn estimate_after(before: f64, luminance_before: f64, luminance: f64, n: u32) -> f64 {
    let least = if n <= MOST_SIDE_BY_SIDE {
        1.0 / 4.0
    } else {
        1.0 / 16.0
    };
    (luminance - luminance_before).abs().max(least * before)
}

/// What rays may err, where the rest errs by `fixed`.
fn allowance(tolerance: f64, fixed: f64) -> f64 {
    let square = tolerance * tolerance - fixed * fixed;
    square.max(0.0).sqrt().max(LEAST_SHARE * tolerance)
}
