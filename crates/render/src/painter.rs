//! Rays for the pixels of a region.

use glam::DVec3;
use glam::Vec4;
use ndarray::Array2;
use ndarray::ArrayViewMut2;
use ndarray::Axis;
use niji_geometry::PixelRegion;
use rayon::prelude::*;

use crate::air_error::AirError;
use crate::footprint::apron;
use crate::footprint::offsets;
use crate::footprint::rays_along;
use crate::footprint_error::Glimpse;
use crate::footprint_error::REACH_PX;
use crate::footprint_error::footprint_error;
use crate::frame::Frame;
use crate::levels::PixelFootprint;
use crate::picture_tiles::TileMut;
use crate::pixel::Pixel;
use crate::ray_light::RayLight;
use crate::scattering_angle::scattering_angle_slopes;
use crate::surfaces::Eye;
use crate::turned::turn;

/// What paints tiles.
pub(crate) struct Painter<'a> {
    pub(crate) frame: Frame<'a>,
    pub(crate) eye: Eye<'a>,
    pub(crate) region: PixelRegion,
    pub(crate) footprint: PixelFootprint,
    /// Largest angle that a pixel spans.
    pub(crate) pixel_rad: f64,
    pub(crate) xyz_weights: Vec<Vec4>,
    pub(crate) air_error: AirError,
}

/// A thread's room to work in.
pub(crate) struct Brush {
    pub(crate) light: RayLight,
    pub(crate) pixel: Pixel,
    /// Where the last ray of the pixel ends (m).
    surface_m: f64,
    /// Radiance of a tile's row, pixel by pixel: written plane by plane at its end.
    pub(crate) row: Vec<f32>,
}

impl Brush {
    pub(crate) fn new(painter: &Painter) -> Self {
        let n_wavelengths = painter.frame.irradiance.len();
        let light = RayLight::new(&painter.frame);
        Self {
            light,
            pixel: Pixel::dark(n_wavelengths),
            surface_m: f64::INFINITY,
            row: Vec::new(),
        }
    }
}

impl Painter<'_> {
    /// Outer corner top left of a pixel of the region, in pixels of the frame.
    pub(crate) fn place(&self, (column, row): (usize, usize)) -> (f64, f64) {
        let x = f64::from(self.region.x_px) + column as f64;
        let y = f64::from(self.region.y_px) + row as f64;
        (x, y)
    }

    /// Look at the pixels around the region, whose own glimpses are there.
    pub(crate) fn glimpse_around(&self, glimpses: &mut Array2<Glimpse>) {
        let reach = REACH_PX as i32;
        for strip in apron(self.region) {
            let width = u64::from(strip.width_px);
            let seen: Vec<Glimpse> = (0..strip.n_pixels())
                .into_par_iter()
                .map_init(
                    || Brush::new(self),
                    |brush, index| {
                        let x = f64::from(strip.x_px) + (index % width) as f64;
                        let y = f64::from(strip.y_px) + (index / width) as f64;
                        self.trace_pixel(x, y, brush);
                        brush.pixel.glimpse()
                    },
                )
                .collect();
            let first_row = (strip.y_px - self.region.y_px + reach) as usize;
            let first_column = (strip.x_px - self.region.x_px + reach) as usize;
            for (index, glimpse) in (0..).zip(seen) {
                let (row, column) = ((index / width) as usize, (index % width) as usize);
                glimpses[[first_row + row, first_column + column]] = glimpse;
            }
        }
    }

    pub(crate) fn paint_tile(
        &self,
        mut tile: TileMut,
        mut glimpses: ArrayViewMut2<Glimpse>,
        brush: &mut Brush,
    ) {
        let n_wavelengths = self.frame.irradiance.len();
        let (_, height, width) = tile.radiance.dim();
        for y in 0..height {
            brush.row.clear();
            let mut any_light = false;
            for x in 0..width {
                let place = self.place(tile.in_region((x, y)));
                any_light |= self.trace_pixel(place.0, place.1, brush);
                brush.pixel.add_air_error(self.air_error.at(place));
                brush.row.extend_from_slice(&brush.pixel.radiance);
                tile.put((x, y), &brush.pixel);
                tile.put_surface((x, y), || self.middle_surface_m(place, brush));
                glimpses[[y, x]] = brush.pixel.glimpse();
            }
            // Planes of a black row keep their untouched zeros.
            if any_light {
                let mut row = tile.radiance.index_axis_mut(Axis(1), y);
                let planes = row.outer_iter_mut();
                let planes = planes.map(|plane| plane.into_slice().expect("rows are whole"));
                turn(&brush.row, n_wavelengths, planes);
            }
        }
    }

    /// Gather the rays of a pixel; false if all of them were black at a glance.
    pub(crate) fn trace_pixel(&self, x: f64, y: f64, brush: &mut Brush) -> bool {
        let n = rays_along(self.footprint);
        let share = 1.0 / f64::from(n * n);
        brush.pixel.clear();
        let mut any_light = false;
        for (dx, dy) in offsets(n) {
            // Outside the image circle of a fisheye there is nothing.
            let glows = self.frame.glows_without_drops();
            let sight = self.eye.sight(x + dx, y + dy);
            brush.surface_m = sight
                .as_ref()
                .map_or(f64::INFINITY, |sight| sight.surface_m);
            let drops_m = sight.as_ref().and_then(|sight| self.frame.range_m(sight));
            let Some(sight) = sight.filter(|_| glows || drops_m.is_some()) else {
                brush.pixel.transmittance += share;
                continue;
            };
            any_light = true;
            let width_rad = match self.footprint {
                // Its one ray goes through the middle.
                PixelFootprint::Prefiltered => self.width_rad(sight.ray.direction, (x, y)),
                PixelFootprint::Center | PixelFootprint::Grid { .. } => 0.0,
            };
            let manner = self.frame.manner(width_rad);
            self.frame
                .trace((&sight, drops_m), manner, &mut brush.light);
            brush.pixel.add(&brush.light, share, &self.xyz_weights);
        }
        any_light
    }

    /// Estimated error of luminance [cd/m²] of a pixel because of its footprint.
    pub(crate) fn missed(&self, cross: &[[Glimpse; 5]; 2], footprint: PixelFootprint) -> f64 {
        footprint_error(cross, footprint, self.pixel_rad)
    }

    /// Where the ray through the middle of a pixel ends that was just traced (m). A single ray went
    /// there: a mesh is not asked twice.
    fn middle_surface_m(&self, (x, y): (f64, f64), brush: &Brush) -> f64 {
        if rays_along(self.footprint) == 1 {
            return brush.surface_m;
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
