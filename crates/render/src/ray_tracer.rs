//! Rays for the pixels of a region.

use std::ops::Range;

use glam::DVec3;
use glam::Vec4;
use ndarray::Array2;
use ndarray::ArrayViewMut2;
use ndarray::Axis;
use niji_dropfield::Bricks;
use niji_geometry::PixelRegion;
use rayon::prelude::*;

use crate::air_error::AirError;
use crate::footprint::REACH_PX;
use crate::footprint::apron;
use crate::footprint::offsets;
use crate::footprint::rays_along;
use crate::footprint_error::Lines;
use crate::footprint_error::PixelLight;
use crate::footprint_error::footprint_error;
use crate::footprint_error::ray_steps;
use crate::frame::Frame;
use crate::levels::PixelFootprint;
use crate::picture_tiles::TileMut;
use crate::pixel::Pixel;
use crate::ray_lattice::RayLattice;
use crate::ray_light::RayLight;
use crate::scattering_angle::scattering_angle_slopes;
use crate::surfaces::Eye;
use crate::surfaces::Sight;
use crate::turned::turn;

/// What makes tiles.
pub(crate) struct RayTracer<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) eye: Eye<'a>,
    pub(crate) region: PixelRegion,
    pub(crate) footprint: PixelFootprint,
    /// Largest angle that a pixel spans.
    pub(crate) pixel_rad: f64,
    /// The most that a pixel without a ray of its own may miss [cd/m²]; 0 where each has one.
    pub(crate) most_missed_cd_m2: f64,
    /// All drops, which may look finer than pixels.
    pub(crate) drops: &'a [Bricks],
    pub(crate) xyz_weights: Vec<Vec4>,
    pub(crate) air_error: AirError,
}

/// A thread's room to work in.
pub(crate) struct Room {
    pub(crate) light: RayLight,
    pub(crate) pixel: Pixel,
    /// The same pixel by those around it, where it is compared with them.
    pub(crate) between: Pixel,
    /// Where the last ray of the pixel ends (m).
    pub(crate) surface_m: f64,
    /// Of the rays of a pixel on a lattice, row by row [cd/m²].
    luminances: Vec<f64>,
    /// Radiance of a tile's row, pixel by pixel: written plane by plane at its end.
    pub(crate) row: Vec<f32>,
}

impl Room {
    pub(crate) fn new(tracer: &RayTracer) -> Self {
        let n_wavelengths = tracer.frame.irradiance.len();
        let light = RayLight::new(&tracer.frame);
        Self {
            light,
            pixel: Pixel::dark(n_wavelengths),
            between: Pixel::dark(n_wavelengths),
            surface_m: f64::INFINITY,
            luminances: Vec::new(),
            row: Vec::new(),
        }
    }

    /// Darkness, and nothing known of the pixel before.
    pub(crate) fn begin_pixel(&mut self) {
        self.pixel.clear();
        self.light.begin_pixel();
    }
}

impl RayTracer<'_> {
    /// Outer corner top left of a pixel of the region, in pixels of the frame.
    pub(crate) fn place(&self, (column, row): (usize, usize)) -> (f64, f64) {
        let x = f64::from(self.region.x_px) + column as f64;
        let y = f64::from(self.region.y_px) + row as f64;
        (x, y)
    }

    /// Look at the pixels around a picture that stand in some rows of the frame, which reach no farther beyond the
    /// tracer's region than the light that is kept.
    pub(crate) fn trace_around(
        &self,
        picture: PixelRegion,
        rows: &Range<i32>,
        lights_around: &mut Array2<PixelLight>,
    ) {
        let reach = REACH_PX as i32;
        for strip in apron(picture) {
            let strip = PixelRegion {
                y_px: rows.start,
                height_px: (rows.end - rows.start).unsigned_abs(),
                ..strip
            }
            .intersection(strip);
            let Some(strip) = strip else {
                continue;
            };
            let width = u64::from(strip.width_px);
            let mut lattice = RayLattice::over(self, strip);
            lattice.reach(self, &(strip.y_px..strip.y_px + strip.height_px as i32));
            let seen: Vec<PixelLight> = (0..strip.n_pixels())
                .into_par_iter()
                .map_init(
                    || Room::new(self),
                    |room, index| {
                        let x_px = strip.x_px + (index % width) as i32;
                        let y_px = strip.y_px + (index / width) as i32;
                        lattice.pixel(self, (x_px, y_px), room);
                        let place = (f64::from(x_px), f64::from(y_px));
                        room.pixel.seen_light(self.whole_surface_m(place, room))
                    },
                )
                .collect();
            let first_row = (strip.y_px - self.region.y_px + reach) as usize;
            let first_column = (strip.x_px - self.region.x_px + reach) as usize;
            for (index, seen_light) in (0..).zip(seen) {
                let (row, column) = ((index / width) as usize, (index % width) as usize);
                lights_around[[first_row + row, first_column + column]] = seen_light;
            }
        }
    }

    pub(crate) fn trace_tile(
        &self,
        lattice: &RayLattice,
        mut tile: TileMut,
        mut lights_around: ArrayViewMut2<PixelLight>,
        room: &mut Room,
    ) {
        let n_wavelengths = self.frame.irradiance.len();
        let (_, height, width) = tile.radiance.dim();
        for y in 0..height {
            room.row.clear();
            let mut any_light = false;
            for x in 0..width {
                let place = self.place(tile.in_region((x, y)));
                let in_frame = (place.0 as i32, place.1 as i32);
                any_light |= lattice.pixel(self, in_frame, room);
                room.pixel.add_air_error(&self.air_error, place);
                room.row.extend_from_slice(&room.pixel.radiance);
                tile.put((x, y), &room.pixel);
                tile.put_surface((x, y), || self.middle_surface_m(place, room));
                lights_around[[y, x]] = (room.pixel).seen_light(self.whole_surface_m(place, room));
            }
            // Planes of a black row keep their untouched zeros.
            if any_light {
                let mut row = tile.radiance.index_axis_mut(Axis(1), y);
                let planes = row.outer_iter_mut();
                let planes = planes.map(|plane| plane.into_slice().expect("rows are whole"));
                turn(&room.row, n_wavelengths, planes);
            }
        }
    }

    /// Gather the rays of a pixel; false if all of them were black at a glance.
    pub(crate) fn trace_pixel(&self, x: f64, y: f64, room: &mut Room) -> bool {
        let n = rays_along(self.footprint);
        let share = 1.0 / f64::from(n * n);
        room.begin_pixel();
        room.luminances.clear();
        let mut any_light = false;
        for (dx, dy) in offsets(n) {
            let before = room.pixel.luminance();
            let sight = self.eye.sight(x + dx, y + dy);
            any_light |= self.add_sight(sight, (x, y), share, room);
            let added = room.pixel.luminance() - before;
            room.luminances.push(added / share);
        }
        room.pixel.ray_steps = ray_steps(&room.luminances, n as usize);
        any_light
    }

    /// The same for a pixel of a single ray, whose sight is known.
    pub(crate) fn trace_sight(
        &self,
        sight: Option<Sight>,
        place: (f64, f64),
        room: &mut Room,
    ) -> bool {
        room.begin_pixel();
        self.add_sight(sight, place, 1.0, room)
    }

    /// Add a ray to a pixel, by its sight; false if it is black at a glance.
    fn add_sight(
        &self,
        sight: Option<Sight>,
        place: (f64, f64),
        share: f64,
        room: &mut Room,
    ) -> bool {
        // Outside the image circle of a fisheye there is nothing.
        let glows = self.frame.glows_without_drops();
        room.surface_m = sight
            .as_ref()
            .map_or(f64::INFINITY, |sight| sight.surface_m);
        let drops_m = sight.as_ref().and_then(|sight| self.frame.range_m(sight));
        let shines = |sight: &Sight| {
            glows || drops_m.is_some() || sight.foot.is_some() || self.frame.lights(sight)
        };
        let Some(sight) = sight.filter(shines) else {
            room.pixel.transmittance += share;
            return false;
        };
        let width_rad = match self.footprint {
            // Its one ray goes through the middle.
            PixelFootprint::Prefiltered => self.width_rad(sight.ray.direction, place),
            PixelFootprint::Center | PixelFootprint::Grid { .. } => 0.0,
        };
        let settings = self.frame.settings(width_rad);
        self.frame
            .trace((&sight, drops_m), settings, &mut room.light);
        room.pixel.add(&room.light, share, &self.xyz_weights);
        true
    }

    /// Estimated error of luminance [cd/m²] of a pixel because of its footprint.
    pub(crate) fn missed(&self, lines: &Lines, footprint: PixelFootprint) -> f64 {
        footprint_error(lines, footprint, self.pixel_rad)
    }

    /// Distance of the surface of a whole pixel that was just traced (m); 0 where it may have several.
    fn whole_surface_m(&self, place: (f64, f64), room: &Room) -> f32 {
        if self.eye.sees_whole_pixels() && rays_along(self.footprint) == 1 {
            self.middle_surface_m(place, room) as f32
        } else {
            0.0
        }
    }

    /// Where the ray through the middle of a pixel ends that was just traced (m). A single ray went
    /// there: a mesh is not asked twice.
    fn middle_surface_m(&self, (x, y): (f64, f64), room: &Room) -> f64 {
        if rays_along(self.footprint) == 1 {
            return room.surface_m;
        }
        let sight = self.eye.sight(x + 0.5, y + 0.5);
        sight.map_or(f64::INFINITY, |sight| sight.surface_m)
    }

    /// Width of the interval of scattering angles with the variance of the square of a pixel whose
    /// middle lies in a direction: a square of side 1 has variance 1/12 along any direction, as has an
    /// interval of length 1.
    pub(crate) fn width_rad(&self, middle: DVec3, (x, y): (f64, f64)) -> f64 {
        let Some(slopes) = self.eye.camera.direction_slopes(x + 0.5, y + 0.5) else {
            return 0.0;
        };
        let [across, down] = scattering_angle_slopes(middle, self.frame.sun_direction, slopes);
        // No hypot: its care for ends of the exponent range takes longer than the slopes.
        (across * across + down * down).sqrt()
    }
}
