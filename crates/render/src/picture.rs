//! The picture: rays for pixels, rows in parallel.
//!
//! A pixel depends on nothing but the request, and every sum in it has a fixed order, so the bytes
//! do not depend on the number of threads.

use glam::Vec4;
use ndarray::Array2;
use ndarray::Array3;
use ndarray::ArrayViewMut1;
use ndarray::ArrayViewMut2;
use ndarray::Axis;
use niji_geometry::Ray;
use niji_radiometry::Colorimetry;
use rayon::prelude::*;

use crate::error::Error;
use crate::footprint::offsets;
use crate::footprint::rays_along;
use crate::frame::Frame;
use crate::frame::frame;
use crate::levels::PixelFootprint;
use crate::ray_light::RayLight;
use crate::ray_light::weighted_sum;
use crate::request::RenderRequest;
use crate::scattering_angle::scattering_angle_rad;
use crate::surfaces::Eye;

/// A rendered picture, all arrays by row and column of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// Spectral radiance by wavelength, row and column, bin means [W m^-2 sr^-1 nm^-1].
    pub radiance: Array3<f32>,
    /// Light of the drops on the primary side of the split: CIE X, Y, Z [cd/m²].
    pub bow_primary: Array3<f32>,
    /// Light of the drops on the secondary side of the split: CIE X, Y, Z [cd/m²].
    pub bow_secondary: Array3<f32>,
    /// Light of the air from the eye to the far side of the drops: CIE X, Y, Z [cd/m²].
    pub inscatter: Array3<f32>,
    /// Light of the surroundings that the drops scatter to the eye: CIE X, Y, Z [cd/m²]; `None`
    /// where that effect is off.
    pub skylit: Option<Array3<f32>>,
    /// What the drops let pass of the light behind them, without diffraction (Q = 1).
    pub transmittance: Array2<f32>,
    /// Optical depth of the drops towards the sun at Q = 1, mean over the light of the drops; 0
    /// where there is none.
    pub tau_sun: Array2<f32>,
    /// Mean distance from the eye of the light of the drops (m); 0 where there is none.
    pub depth: Array2<f32>,
    /// Distance of the surface that ends the ray through the middle of the pixel (m), infinite for
    /// the sky; `None` where no surfaces are given.
    pub surface: Option<Array2<f32>>,
    /// Estimated absolute error of luminance [cd/m²]: quadrature on the ray, interpolation between
    /// the table's sizes, and what the pixel's footprint misses.
    pub error: Array2<f32>,
}

/// Render a picture; `progress` gets the number of pixels just finished, from any thread.
///
/// # Errors
/// If the inputs contradict each other or the request, see [`Error`]. A picture without light is not
/// an error: it is black.
pub fn render(request: &RenderRequest, progress: &(dyn Fn(u64) + Sync)) -> Result<Rendered, Error> {
    request.check()?;
    let colorimetry = Colorimetry::new(&request.wavelengths);
    let frame = frame(request, &colorimetry)?;
    let to_vector = |[x, y, z]: &[f64; 3]| Vec4::new(*x as f32, *y as f32, *z as f32, 0.0);
    let painter = Painter {
        frame,
        eye: request.eye(),
        footprint: request.levels.pixel_footprint,
        xyz_weights: colorimetry.weights().iter().map(to_vector).collect(),
    };
    let (width, height) = (
        request.camera.width_px() as usize,
        request.camera.height_px() as usize,
    );
    let mut picture = Rendered::dark(request.wavelengths.len(), height, width);
    picture.skylit = (painter.frame.surround.is_some()).then(|| Array3::zeros((3, height, width)));
    picture.surface = request.surfaces.map(|_| painter.surface(height, width));
    picture
        .rows_mut()
        .into_par_iter()
        .enumerate()
        .with_max_len(1)
        .for_each_init(
            || Brush::new(&painter),
            |brush, (y, row)| {
                painter.paint_row(y, row, brush);
                progress(width as u64);
            },
        );
    picture.add_footprint_error(request.levels.pixel_footprint);
    Ok(picture)
}

/// One row of every array.
struct RowMut<'a> {
    radiance: ArrayViewMut2<'a, f32>,
    bow_primary: ArrayViewMut2<'a, f32>,
    bow_secondary: ArrayViewMut2<'a, f32>,
    inscatter: ArrayViewMut2<'a, f32>,
    skylit: Option<ArrayViewMut2<'a, f32>>,
    transmittance: ArrayViewMut1<'a, f32>,
    tau_sun: ArrayViewMut1<'a, f32>,
    depth: ArrayViewMut1<'a, f32>,
    error: ArrayViewMut1<'a, f32>,
}

impl Rendered {
    /// A black picture of nothing. Zeroed memory is not touched until a row is written.
    fn dark(n_wavelengths: usize, height: usize, width: usize) -> Self {
        let xyz = || Array3::zeros((3, height, width));
        let plane = || Array2::zeros((height, width));
        Self {
            radiance: Array3::zeros((n_wavelengths, height, width)),
            bow_primary: xyz(),
            bow_secondary: xyz(),
            inscatter: xyz(),
            skylit: None,
            transmittance: plane(),
            tau_sun: plane(),
            depth: plane(),
            surface: None,
            error: plane(),
        }
    }

    fn rows_mut(&mut self) -> Vec<RowMut<'_>> {
        let mut radiance = self.radiance.axis_iter_mut(Axis(1));
        let mut bow_primary = self.bow_primary.axis_iter_mut(Axis(1));
        let mut bow_secondary = self.bow_secondary.axis_iter_mut(Axis(1));
        let mut inscatter = self.inscatter.axis_iter_mut(Axis(1));
        let mut skylit = self
            .skylit
            .as_mut()
            .map(|planes| planes.axis_iter_mut(Axis(1)));
        let mut transmittance = self.transmittance.outer_iter_mut();
        let mut tau_sun = self.tau_sun.outer_iter_mut();
        let mut depth = self.depth.outer_iter_mut();
        let mut error = self.error.outer_iter_mut();
        std::iter::from_fn(|| {
            Some(RowMut {
                radiance: radiance.next()?,
                bow_primary: bow_primary.next()?,
                bow_secondary: bow_secondary.next()?,
                inscatter: inscatter.next()?,
                skylit: match &mut skylit {
                    Some(rows) => Some(rows.next()?),
                    None => None,
                },
                transmittance: transmittance.next()?,
                tau_sun: tau_sun.next()?,
                depth: depth.next()?,
                error: error.next()?,
            })
        })
        .collect()
    }

    /// The mean of a function over a pixel exceeds its value in the middle by a 24th of its
    /// Laplacian; n x n rays leave 1/n² of it, and prefiltering leaves none.
    fn add_footprint_error(&mut self, footprint: PixelFootprint) {
        let share = match footprint {
            PixelFootprint::Center => 1.0,
            PixelFootprint::Prefiltered => return,
            PixelFootprint::Grid { n } => 1.0 / (n * n) as f32,
        };
        let luminance =
            &self.bow_primary.index_axis(Axis(0), 1) + &self.bow_secondary.index_axis(Axis(0), 1);
        let (height, width) = luminance.dim();
        for ((y, x), error) in self.error.indexed_iter_mut() {
            let here = luminance[[y, x]];
            let mut laplacian = 0.0;
            if x > 0 && x + 1 < width {
                laplacian += luminance[[y, x - 1]] - 2.0 * here + luminance[[y, x + 1]];
            }
            if y > 0 && y + 1 < height {
                laplacian += luminance[[y - 1, x]] - 2.0 * here + luminance[[y + 1, x]];
            }
            *error += share * laplacian.abs() / 24.0;
        }
    }
}

/// What paints rows.
struct Painter<'a> {
    frame: Frame<'a>,
    eye: Eye<'a>,
    footprint: PixelFootprint,
    xyz_weights: Vec<Vec4>,
}

/// A thread's room to work in.
struct Brush {
    light: RayLight,
    pixel: Pixel,
    /// Radiance of a row, pixel by pixel: written plane by plane at its end.
    row: Vec<f32>,
}

/// Sums over the rays of a pixel.
struct Pixel {
    radiance: Vec<f32>,
    bow_primary: Vec4,
    bow_secondary: Vec4,
    inscatter: Vec4,
    skylit: Vec4,
    transmittance: f64,
    light: f64,
    light_m: f64,
    light_tau_sun: f64,
    error_cd_m2: f64,
}

impl Brush {
    fn new(painter: &Painter) -> Self {
        let n_wavelengths = painter.frame.irradiance.len();
        let width = painter.eye.camera.width_px() as usize;
        let light = RayLight::new(&painter.frame);
        Self {
            light,
            pixel: Pixel::dark(n_wavelengths),
            row: vec![0.0; width * n_wavelengths],
        }
    }
}

impl Pixel {
    fn dark(n_wavelengths: usize) -> Self {
        Self {
            radiance: vec![0.0; n_wavelengths],
            bow_primary: Vec4::ZERO,
            bow_secondary: Vec4::ZERO,
            inscatter: Vec4::ZERO,
            skylit: Vec4::ZERO,
            transmittance: 0.0,
            light: 0.0,
            light_m: 0.0,
            light_tau_sun: 0.0,
            error_cd_m2: 0.0,
        }
    }

    /// Darkness again, in the same memory.
    fn clear(&mut self) {
        let mut radiance = std::mem::take(&mut self.radiance);
        radiance.fill(0.0);
        *self = Self {
            radiance,
            ..Self::dark(0)
        };
    }

    /// Add a ray that stands for `share` of the pixel.
    fn add(&mut self, light: &RayLight, share: f64, xyz_weights: &[Vec4]) {
        let share_f32 = share as f32;
        for (sum, bow) in self.radiance.iter_mut().zip(&light.bow) {
            *sum += share_f32 * bow;
        }
        if light.glows {
            let glow = light.inscatter.iter().zip(&light.background);
            for (sum, (inscatter, background)) in self.radiance.iter_mut().zip(glow) {
                *sum += share_f32 * (inscatter + background);
            }
            self.inscatter += share_f32 * weighted_sum(&light.inscatter, xyz_weights);
            self.skylit += share_f32 * weighted_sum(&light.skylit, xyz_weights);
        }
        if light.light > 0.0 {
            let bow = share_f32 * weighted_sum(&light.bow, xyz_weights);
            if light.is_primary {
                self.bow_primary += bow;
            } else {
                self.bow_secondary += bow;
            }
        }
        self.transmittance += share * light.transmittance;
        self.light += share * light.light;
        self.light_m += share * light.light_m;
        self.light_tau_sun += share * light.light_tau_sun;
        self.error_cd_m2 += share * light.error_cd_m2;
    }
}

impl Painter<'_> {
    /// Where the rays through the middles of pixels end.
    fn surface(&self, height: usize, width: usize) -> Array2<f32> {
        Array2::from_shape_fn((height, width), |(y, x)| {
            // f32: what the map held.
            self.eye.sight(x as f64 + 0.5, y as f64 + 0.5).surface_m as f32
        })
    }

    fn paint_row(&self, y: usize, mut row: RowMut, brush: &mut Brush) {
        let n_wavelengths = self.frame.irradiance.len();
        let mut any_light = false;
        for x in 0..row.depth.len() {
            let lit = self.trace_pixel(x as f64, y as f64, brush);
            any_light |= lit;
            let place = &mut brush.row[x * n_wavelengths..(x + 1) * n_wavelengths];
            place.copy_from_slice(&brush.pixel.radiance);
            row.put(x, &brush.pixel);
        }
        // Planes of a black row keep their untouched zeros.
        if any_light {
            for (wavelength, mut plane) in row.radiance.outer_iter_mut().enumerate() {
                let values = brush.row.iter().skip(wavelength).step_by(n_wavelengths);
                for (to, from) in plane.iter_mut().zip(values) {
                    *to = *from;
                }
            }
        }
    }

    /// Gather the rays of a pixel; false if all of them were black at a glance.
    fn trace_pixel(&self, x: f64, y: f64, brush: &mut Brush) -> bool {
        let n = rays_along(self.footprint);
        let share = 1.0 / f64::from(n * n);
        brush.pixel.clear();
        let mut any_light = false;
        for (dx, dy) in offsets(n) {
            let sight = self.eye.sight(x + dx, y + dy);
            if self.frame.range_m(&sight).is_none() && !self.frame.glows_without_drops() {
                brush.pixel.transmittance += share;
                continue;
            }
            any_light = true;
            let width_rad = match self.footprint {
                PixelFootprint::Prefiltered => self.width_rad(x, y),
                PixelFootprint::Center | PixelFootprint::Grid { .. } => 0.0,
            };
            self.frame.trace(&sight, width_rad, &mut brush.light);
            brush.pixel.add(&brush.light, share, &self.xyz_weights);
        }
        any_light
    }

    /// Width of the interval of scattering angles with the variance of the pixel's square: a square
    /// of side 1 has variance 1/12 along any direction, as has an interval of length 1.
    fn width_rad(&self, x: f64, y: f64) -> f64 {
        let theta = |x: f64, y: f64| -> f64 {
            let ray: Ray = self.eye.camera.ray(x, y);
            scattering_angle_rad(ray.direction, self.frame.sun_direction)
        };
        let across = theta(x + 1.0, y + 0.5) - theta(x, y + 0.5);
        let down = theta(x + 0.5, y + 1.0) - theta(x + 0.5, y);
        across.hypot(down)
    }
}

impl RowMut<'_> {
    /// Everything of a pixel but its spectrum.
    fn put(&mut self, x: usize, pixel: &Pixel) {
        for (plane, xyz) in [
            (&mut self.bow_primary, pixel.bow_primary),
            (&mut self.bow_secondary, pixel.bow_secondary),
            (&mut self.inscatter, pixel.inscatter),
        ] {
            put_xyz(plane, x, xyz);
        }
        if let Some(plane) = &mut self.skylit {
            put_xyz(plane, x, pixel.skylit);
        }
        self.transmittance[x] = pixel.transmittance as f32;
        if pixel.light > 0.0 {
            self.tau_sun[x] = (pixel.light_tau_sun / pixel.light) as f32;
            self.depth[x] = (pixel.light_m / pixel.light) as f32;
        }
        self.error[x] = pixel.error_cd_m2 as f32;
    }
}

fn put_xyz(plane: &mut ArrayViewMut2<f32>, x: usize, xyz: Vec4) {
    for channel in 0..3 {
        plane[[channel, x]] = xyz[channel];
    }
}
