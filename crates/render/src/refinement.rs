//! More rays for the pixels whose estimated error is above a tolerance.
//!
//! A pixel is cut into 1, 2 x 2, 4 x 4, up to 16 x 16 parts, each seen along the ray through its middle
//! with the table's row averaged over the part, until its estimate holds. The footprint's estimate of
//! n x n rays is
//! e_n = max(|L_n - L_(n/2)|, e_(n/2) / 4),  e_(n/2) / 16 for turned parts and for strips that are all cut once
//! `L_n` luminance of the pixel: where luminance is smooth the difference is three times the error
//! that is left, at a step it is about as large; agreement by chance is not believed. Where a lattice of
//! sights finds an edge in the pixel, it is cut there (`footprint_cuts`), and e_1 is half of the step at least that
//! its neighbors show. Where it finds none, an edge beside the pixel is none of its errors: e_1 is that of the neighbors
//! which meet the same, and of a corner as large as a square of the lattice. Where 4 x 4 parts do not suffice there may
//! be an edge all the same: more parts are turned against the pixel, so that an edge along a row is met as well as any
//! other. Rays take a finer quadrature.
//! The tolerance is theirs alone: errors of a picture add up by their squares, so that a ray betters it by as much
//! whatever else errs in its pixel, the table, the air, light of further orders.
//!
//! Whether a pixel is refined depends on the pixel and its neighbors as they were before any was
//! refined, so not on tiles or threads.

use std::ops::Range;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering;

use ndarray::Array2;
use ndarray::Axis;
use rayon::prelude::*;

use crate::deadline::Deadline;
use crate::deadline::MoreRays;
use crate::error_parts::together;
use crate::footprint::offsets;
use crate::footprint::turned_offsets;
use crate::footprint_cuts::Met;
use crate::footprint_cuts::N_LOOKED_AT;
use crate::footprint_cuts::Part;
use crate::footprint_cuts::Strips;
use crate::footprint_cuts::alike;
use crate::footprint_error::Lines;
use crate::footprint_error::PixelLight;
use crate::footprint_error::half_step;
use crate::footprint_error::lines_through;
use crate::footprint_error::on_this_side;
use crate::levels::Integration;
use crate::levels::PixelFootprint;
use crate::march::March;
use crate::picture_layers::FOOTPRINT;
use crate::picture_layers::QUADRATURE;
use crate::picture_layers::Rendered;
use crate::picture_tiles::TileMut;
use crate::picture_tiles::of_rays;
use crate::ray_settings::RaySettings;
use crate::ray_tracer::RayTracer;
use crate::ray_tracer::Room;

/// Rays along a side of a pixel up to which its parts stand in line with it.
const MOST_SIDE_BY_SIDE: u32 = 4;

/// Most rays along a side of a pixel.
const MOST_ALONG: u32 = 16;

/// What twice as many places side by side leave of an estimate, and what is left where they stand 16 times as close
/// as before, or an edge cuts every strip once.
const SIDE_BY_SIDE: f64 = 1.0 / 4.0;
const CLOSE: f64 = 1.0 / 16.0;

/// The middle of a pixel.
const MIDDLE: (f64, f64) = (0.5, 0.5);

/// What a square of the lattice of sights covers of a pixel, of half a step: an edge can hide in it.
const UNSEEN: f64 = 2.0 / (N_LOOKED_AT * N_LOOKED_AT) as f64;

/// Relative error of the quadrature of rays that are added.
const FINE: f64 = 1e-6;

/// Pixels that get more rays as a trial, about, and the part of the time left that a trial is trusted with: it is
/// of few pixels, and the picture is written afterwards.
const N_TRIED: usize = 24;
const TRUSTED: f64 = 0.7;

/// The finest tolerance that there may be time for, as a power of two of the one asked for.
const FINEST_HALVINGS: i32 = -4;

/// A pixel by column and row of its tile.
struct PixelOfTile<'a, 't> {
    tile: &'a mut TileMut<'t>,
    x: usize,
    y: usize,
}

/// Parts of a pixel, each seen along the ray through its middle.
struct Parts<'a> {
    all: Vec<Part>,
    march: &'a March<'a>,
    /// Intervals along a side with the variance of a part.
    n_intervals: u32,
    /// The least part of the estimate for half as many rays along a side that these leave of it.
    least_left: f64,
}

/// Rows of a picture whose pixels may get more rays.
pub(crate) struct Refining<'a> {
    pub(crate) rows: Range<usize>,
    /// Light of their pixels and the neighbors of these.
    pub(crate) lights_around: &'a Array2<PixelLight>,
}

/// Which of the pixels that ask for it get more rays, and whether they keep them.
#[derive(Clone, Copy)]
enum Chosen {
    /// All of them.
    All,
    /// One in so many, as a trial of the time it takes.
    Trial { one_in: usize },
}

/// How a pixel is refined.
struct Finer<'a> {
    march: &'a March<'a>,
    tolerance_cd_m2: f64,
    /// The pixels around it.
    lines: Lines,
}

/// What was done for a pixel.
struct Bettered {
    /// What it still misses.
    missed_cd_m2: f64,
    /// Whether it got more rays.
    has_more_rays: bool,
}

impl RayTracer<'_> {
    /// Give the pixels of rows whose estimate exceeds a tolerance more rays; sums over the pixels of what that did
    /// [cd²/m⁴].
    pub(crate) fn refine(
        &self,
        picture: &mut Rendered,
        refining: &Refining,
        tolerance_cd_m2: f64,
    ) -> MoreRays {
        let rows = &refining.rows;
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|it| it * it).sum::<f64>();
        let seen = |picture: &Rendered| {
            let errors = picture.errors_of_rays(rows);
            let light = picture.luminance_of(rows, &self.xyz_weights);
            (light, squares(&mut errors.into_iter()))
        };
        let (light, error) = seen(picture);
        self.refine_some(picture, refining, (tolerance_cd_m2, Chosen::All));
        let (finer_light, finer_error) = seen(picture);
        MoreRays {
            change: squares(&mut (finer_light - light).into_iter()),
            error: error - finer_error,
        }
    }

    /// How many times the tolerance pixels may err by before they get more rays, so that there is time for those; less
    /// than 1 where there is time for more than is asked for.
    pub(crate) fn affordable(
        &self,
        picture: &mut Rendered,
        refining: &Refining,
        (tolerance_cd_m2, deadline): (f64, Deadline),
    ) -> f64 {
        let errors = picture.errors_of_rays(&refining.rows);
        let largest = errors.iter().copied().fold(0.0, f64::max);
        let n_halvings = (largest / tolerance_cd_m2).log2().ceil();
        let n_halvings = if n_halvings.is_finite() {
            n_halvings.max(f64::from(FINEST_HALVINGS)) as i32
        } else {
            0
        };
        let mut affordable = f64::from(n_halvings).exp2();
        for halvings in (FINEST_HALVINGS..n_halvings).rev() {
            let coarser = f64::from(halvings).exp2();
            let allowed_cd_m2 = coarser * tolerance_cd_m2;
            let n_pixels = errors.iter().filter(|it| **it > allowed_cd_m2).count();
            let one_in = (n_pixels / N_TRIED).max(1);
            let before_s = deadline.left_s();
            self.refine_some(picture, refining, (allowed_cd_m2, Chosen::Trial { one_in }));
            let left_s = deadline.left_s();
            if one_in as f64 * (before_s - left_s) > TRUSTED * left_s {
                break;
            }
            affordable = coarser;
        }
        affordable
    }

    fn refine_some(
        &self,
        picture: &mut Rendered,
        refining: &Refining,
        (tolerance_cd_m2, chosen): (f64, Chosen),
    ) {
        let lights_around = refining.lights_around;
        let march = fine_march(&self.frame.march);
        let n_asking = AtomicUsize::new(0);
        let is_chosen = || match chosen {
            Chosen::All => true,
            Chosen::Trial { one_in } => n_asking
                .fetch_add(1, Ordering::Relaxed)
                .is_multiple_of(one_in),
        };
        let tiles = picture.tiles_mut(&refining.rows).into_par_iter();
        tiles.with_max_len(1).for_each_init(
            || Room::new(self),
            |room, mut tile| {
                // A copy: pixels are put on the way.
                let errors = tile.errors().map_axis(Axis(0), |causes| of_rays(&causes));
                for ((y, x), error) in errors.indexed_iter() {
                    if *error > tolerance_cd_m2 && is_chosen() {
                        let (column, row) = tile.in_region((x, y));
                        let finer = Finer {
                            march: &march,
                            tolerance_cd_m2,
                            lines: lines_through(lights_around, column, row),
                        };
                        let mut pixel = PixelOfTile {
                            tile: &mut tile,
                            x,
                            y,
                        };
                        let bettered = self.finer_pixel(&mut pixel, &finer, room);
                        if let Chosen::All = chosen {
                            pixel.keep(room, &bettered);
                        }
                    }
                }
            },
        );
    }

    /// Leaves a pixel in the room where it gets more rays.
    fn finer_pixel(&self, pixel: &mut PixelOfTile, finer: &Finer, room: &mut Room) -> Bettered {
        let (x, y) = (pixel.x, pixel.y);
        let tile = &mut *pixel.tile;
        let place = self.place(tile.in_region((x, y)));
        let meets = |(dx, dy): (f64, f64)| {
            let sight = self.eye.sight(place.0 + dx, place.1 + dy)?;
            Some(Met::of(&sight, &self.frame))
        };
        let strips = Strips::across_edges(&meets);
        let errors = tile.errors();
        let [quadrature, footprint] =
            [QUADRATURE, FOOTPRINT].map(|cause| f64::from(errors[[cause, y, x]]));
        let prefiltered = |lines| self.missed(lines, PixelFootprint::Prefiltered);
        let mut missed = match (strips, self.footprint) {
            (Some(_), _) => prefiltered(&finer.lines).max(half_step(&finer.lines)),
            (None, PixelFootprint::Grid { .. }) => footprint,
            (None, _) => {
                let here = meets(MIDDLE);
                let is_alike = |[across, down]: [i32; 2]| {
                    let (x, y) = (MIDDLE.0 + f64::from(across), MIDDLE.1 + f64::from(down));
                    alike(here, meets((x, y)))
                };
                let lines = on_this_side(&finer.lines, is_alike);
                prefiltered(&lines).max(UNSEEN * half_step(&finer.lines))
            }
        };
        let is_one_ray = strips.is_none() && self.footprint == PixelFootprint::Prefiltered;
        let mut bettered = Bettered {
            missed_cd_m2: missed,
            has_more_rays: false,
        };
        if is_one_ray && together(&[missed, quadrature]) <= finer.tolerance_cd_m2 {
            return bettered;
        }
        let mut before = tile.luminance((x, y), &self.xyz_weights);
        for n in rays_to_try(strips, self.footprint) {
            let parts = match strips {
                Some(strips) => Parts::cut(n, strips.parts(n, &meets), finer.march),
                None => Parts::even(n, finer.march),
            };
            let least_left = parts.least_left;
            self.trace_parts(place, parts, room);
            let luminance = room.pixel.luminance();
            if n > 1 {
                missed = (luminance - before).abs().max(least_left * missed);
            }
            before = luminance;
            bettered = Bettered {
                missed_cd_m2: missed,
                has_more_rays: true,
            };
            if together(&[missed, room.pixel.errors.quadrature]) <= finer.tolerance_cd_m2 {
                break;
            }
        }
        bettered
    }

    /// Gather a ray for each part of a pixel, with its part of the pixel's scattering angles.
    fn trace_parts(&self, (x, y): (f64, f64), parts: Parts, room: &mut Room) {
        let middle = self.eye.camera.ray(x + 0.5, y + 0.5);
        let width_rad = middle.map_or(0.0, |ray| self.width_rad(ray.direction, (x, y)));
        let width_rad = width_rad / f64::from(parts.n_intervals);
        room.begin_pixel();
        for Part { place, share } in parts.all {
            match self.eye.sight(x + place.0, y + place.1) {
                None => room.pixel.transmittance += share,
                Some(sight) => {
                    let sight = (&sight, self.frame.range_m(&sight));
                    let settings = RaySettings {
                        march: parts.march,
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

impl PixelOfTile<'_, '_> {
    /// Puts what a room holds of it, where it got more rays, and what it misses.
    fn keep(self, room: &Room, bettered: &Bettered) {
        let Self { tile, x, y } = self;
        if bettered.has_more_rays {
            tile.put((x, y), &room.pixel);
            for (mut plane, value) in tile.radiance.outer_iter_mut().zip(&room.pixel.radiance) {
                plane[[y, x]] = *value;
            }
        }
        tile.put_missed((x, y), bettered.missed_cd_m2);
    }
}

impl<'a> Parts<'a> {
    /// n x n parts of a pixel without a cut. A few cover it side by side; what these do not show is an edge.
    fn even(n: u32, march: &'a March<'a>) -> Self {
        let share = 1.0 / f64::from(n * n);
        let part = |place| Part { place, share };
        if n <= MOST_SIDE_BY_SIDE {
            Self {
                all: offsets(n).map(part).collect(),
                march,
                n_intervals: n,
                least_left: SIDE_BY_SIDE,
            }
        } else {
            // Intervals between n² places along any side: the whole has the pixel's variance.
            Self {
                all: turned_offsets(n).map(part).collect(),
                march,
                n_intervals: n * n,
                least_left: CLOSE,
            }
        }
    }

    /// The parts of n strips that edges cut.
    fn cut(n: u32, strips: Vec<Vec<Part>>, march: &'a March<'a>) -> Self {
        let one_edge = |strip: &Vec<Part>| strip.len() == n as usize + 1;
        let least_left = if strips.iter().all(one_edge) {
            CLOSE
        } else {
            SIDE_BY_SIDE
        };
        Self {
            all: strips.into_iter().flatten().collect(),
            march,
            n_intervals: n,
            least_left,
        }
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

/// Numbers of rays along a side to try after those of a level. A pixel that is cut starts anew; the first rays of
/// one that was seen along one ray are one with the mean of the row.
fn rays_to_try(strips: Option<Strips>, level: PixelFootprint) -> impl Iterator<Item = u32> {
    let first = match (strips, level) {
        (Some(_), _) | (None, PixelFootprint::Center) => 1,
        (None, PixelFootprint::Prefiltered) => 2,
        (None, PixelFootprint::Grid { n }) => 2 * n,
    };
    std::iter::successors(Some(first), |n| Some(2 * n)).take_while(|n| *n <= MOST_ALONG)
}
