//! A picture of ice.
//!
//! Every pixel draws its own paths from its own seed and adds them in their order, so that the bytes
//! do not depend on how pixels are shared between threads. Its error is the scatter of the means of
//! blocks of paths over the root of their number; since later blocks fill the gaps of earlier ones,
//! the true error is smaller, by a factor of 1 to 3.

use ndarray::Array2;
use ndarray::Array3;
use niji_geometry::PinholeCamera;
use niji_radiometry::Colorimetry;
use niji_radiometry::WavelengthGrid;
use rayon::prelude::*;

use crate::body::Body;
use crate::error::Error;
use crate::error::check_range;
use crate::ground::Ground;
use crate::ice::Ice;
use crate::levels::IceTransport;
use crate::levels::PathWavelengths;
use crate::light::Light;
use crate::mean_chord::mean_chord_light;
use crate::radiance_sum::CarriedWavelengths;
use crate::radiance_sum::RadianceSum;
use crate::sampler::Sampler;
use crate::sampler::pixel_seed;
use crate::transmittance_table::TransmittanceTable;
use crate::walk::World;
use crate::walk::glow;
use crate::walk::place_in_pixel;
use crate::walk::wavelength_number;

/// Share of the body's diagonal by which the ground lies below 0.
const GROUND_BELOW: f64 = 1e-6;
/// Blocks of a pixel without a tolerance; with one, fewer are never trusted.
const N_BLOCKS: u32 = 8;
/// Paths of a block where a tolerance decides how many there are.
const PATHS_PER_BLOCK: u32 = 16;

/// What a picture of ice is made from.
#[derive(Clone, Copy, Debug)]
pub struct IceRequest<'a> {
    /// The eye.
    pub camera: &'a PinholeCamera,
    /// Wavelength bins of all spectra.
    pub wavelengths: WavelengthGrid,
    /// The shape.
    pub body: &'a Body,
    /// What it is made of.
    pub ice: &'a Ice,
    /// Sun and sky.
    pub light: &'a Light,
    /// What is below.
    pub ground: Ground,
    /// How accurately.
    pub transport: IceTransport,
    /// Standard error of the luminance in cd/m² at which a pixel is done, before it has all its paths.
    pub tolerance_cd_m2: Option<f64>,
    /// Another seed is another noise.
    pub seed: u64,
}

/// A picture of ice.
#[derive(Clone, Debug, PartialEq)]
pub struct IcePicture {
    /// Radiance by wavelength, row and column: bin means, W m^-2 sr^-1 nm^-1.
    pub radiance: Array3<f32>,
    /// Standard error of the luminance, cd/m²; an overestimate by a factor of 1 to 3. 0 where there is a
    /// single block, which knows none.
    pub error: Array2<f32>,
    /// Distance to ice or ground along the ray through the middle of the pixel, m; 0 for the sky.
    pub depth: Array2<f32>,
    /// Paths drawn.
    pub n_paths: Array2<f32>,
}

/// Renders a picture; `progress` is told about finished pixels.
///
/// # Errors
/// Settings out of their ranges, or spectra on other wavelengths.
pub fn render_ice(
    request: &IceRequest,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<IcePicture, Error> {
    let world = checked_world(request)?;
    let table = TransmittanceTable::new(&request.ice.absorption_per_m);
    let renderer = Renderer {
        request,
        world: &world,
        table: &table,
        luminance: Colorimetry::new(&request.wavelengths),
        eye_winding: request.body.winding_at(request.camera.position()),
    };
    let (width, height) = (
        request.camera.width_px() as usize,
        request.camera.height_px() as usize,
    );
    let rows: Vec<Vec<Pixel>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let row = (0..width).map(|x| renderer.pixel(x, y)).collect();
            progress(width as u64);
            row
        })
        .collect();
    let plane = |value: &dyn Fn(&Pixel) -> f64| {
        // f32 is what the file holds.
        Array2::from_shape_fn((height, width), |(y, x)| value(&rows[y][x]) as f32)
    };
    Ok(IcePicture {
        radiance: Array3::from_shape_fn((request.wavelengths.len(), height, width), |(j, y, x)| {
            rows[y][x].radiance[j] as f32
        }),
        error: plane(&|pixel| pixel.error_cd_m2),
        depth: plane(&|pixel| pixel.depth_m),
        n_paths: plane(&|pixel| pixel.n_paths.into()),
    })
}

fn checked_world<'a>(request: &IceRequest<'a>) -> Result<World<'a>, Error> {
    let n_wavelengths = request.wavelengths.len();
    request.ice.check(n_wavelengths)?;
    request.light.check(n_wavelengths)?;
    request.ground.check()?;
    request.transport.check()?;
    if let Some(tolerance) = request.tolerance_cd_m2 {
        check_range("tolerance", tolerance, [0.0, f64::MAX], "0 or more")?;
    }
    let surface = request.ice.surface;
    let mut world = World {
        body: request.body,
        surfaces: request
            .wavelengths
            .centers()
            .map(|center| surface.at(center))
            .collect(),
        snow: request.ice.snow,
        bubbles: request.ice.bubbles,
        light: request.light,
        ground: request.ground,
        ground_y_m: -GROUND_BELOW * request.body.bounds().size().length(),
        glow: glow(request.light, &request.ground),
        mean_chord_light: None,
    };
    if let IceTransport::MeanChord { .. } = request.transport {
        if request.ice.bubbles.is_some() {
            return Err(Error::BubblesOnMeanChord);
        }
        let seed = pixel_seed(request.seed, u64::MAX);
        let light = mean_chord_light(&mut world, &request.ice.absorption_per_m, seed);
        world.mean_chord_light = Some(light);
    }
    Ok(world)
}

struct Renderer<'a> {
    request: &'a IceRequest<'a>,
    world: &'a World<'a>,
    table: &'a TransmittanceTable,
    luminance: Colorimetry,
    eye_winding: i32,
}

struct Pixel {
    radiance: Vec<f64>,
    error_cd_m2: f64,
    depth_m: f64,
    n_paths: u32,
}

impl Renderer<'_> {
    fn pixel(&self, x: usize, y: usize) -> Pixel {
        let n_wavelengths = self.request.wavelengths.len();
        let number = (y as u64) << 32 | x as u64;
        let seed = pixel_seed(self.request.seed, number);
        let mut sum = vec![0.0; n_wavelengths];
        let mut block = vec![0.0; n_wavelengths];
        let mut scratch = vec![0.0; n_wavelengths];
        let most = self.request.transport.paths_per_pixel();
        let per_block = match self.request.tolerance_cd_m2 {
            Some(_) => PATHS_PER_BLOCK.min(most),
            None => (most / N_BLOCKS).max(1),
        };
        let mut scatter = Scatter::default();
        let mut n_paths = 0;
        while n_paths < most {
            block.fill(0.0);
            let n_now = per_block.min(most - n_paths);
            for index in n_paths..n_paths + n_now {
                self.path([x, y], Sampler::new(seed, index), &mut block, &mut scratch);
            }
            n_paths += n_now;
            for (sum, value) in sum.iter_mut().zip(&block) {
                *sum += value;
            }
            // A last, shorter block would not scatter like the others.
            if n_now == per_block {
                scatter.add(self.luminance.xyz(&block)[1] / f64::from(n_now));
            }
            let is_done = |tolerance| scatter.n_blocks >= N_BLOCKS && scatter.error() <= tolerance;
            if self.request.tolerance_cd_m2.is_some_and(is_done) {
                break;
            }
        }
        for value in &mut sum {
            *value /= f64::from(n_paths);
        }
        Pixel {
            radiance: sum,
            error_cd_m2: scatter.error(),
            depth_m: self.depth_m(x, y),
            n_paths,
        }
    }

    fn path(
        &self,
        [x, y]: [usize; 2],
        sampler: Sampler,
        radiance: &mut [f64],
        scratch: &mut [f64],
    ) {
        let [across, down] = place_in_pixel(sampler);
        let ray = self.request.camera.ray(x as f64 + across, y as f64 + down);
        let mut sum = RadianceSum {
            table: self.table,
            light: self.request.light,
            carried: self.carried(sampler),
            radiance,
            scratch,
        };
        self.world.follow(ray, self.eye_winding, sampler, &mut sum);
    }

    fn carried(&self, sampler: Sampler) -> CarriedWavelengths {
        let count = match self.request.transport {
            IceTransport::MeanChord { .. } => return CarriedWavelengths::All,
            IceTransport::PathTraced { wavelengths, .. } => match wavelengths {
                PathWavelengths::All => return CarriedWavelengths::All,
                PathWavelengths::Four => 4,
                PathWavelengths::One => 1,
            },
        };
        let n_wavelengths = self.request.wavelengths.len();
        let count = count.min(n_wavelengths);
        CarriedWavelengths::Some {
            first: (wavelength_number(sampler) * n_wavelengths as f64) as usize,
            step: n_wavelengths / count,
            count,
        }
    }

    fn depth_m(&self, x: usize, y: usize) -> f64 {
        let ray = self.request.camera.ray(x as f64 + 0.5, y as f64 + 0.5);
        let below_m = ray.origin.y - self.world.ground_y_m;
        let ground_m = if ray.direction.y < 0.0 && below_m >= 0.0 {
            -below_m / ray.direction.y
        } else {
            f64::INFINITY
        };
        let ice_m = match self.eye_winding {
            0 => self
                .request
                .body
                .enter(&ray)
                .map(|crossing| crossing.distance_m),
            _ => Some(0.0),
        };
        let nearest_m = ground_m.min(ice_m.unwrap_or(f64::INFINITY));
        if nearest_m.is_finite() {
            nearest_m
        } else {
            0.0
        }
    }
}

/// Mean and scatter of the luminance of blocks (B. Welford, Technometrics 4, 419-420, 1962).
#[derive(Default)]
struct Scatter {
    n_blocks: u32,
    mean: f64,
    squares: f64,
}

impl Scatter {
    fn add(&mut self, value: f64) {
        self.n_blocks += 1;
        let from_mean = value - self.mean;
        self.mean += from_mean / f64::from(self.n_blocks);
        self.squares += from_mean * (value - self.mean);
    }

    /// Standard error of the mean; 0 for a single block, which knows none.
    fn error(&self) -> f64 {
        if self.n_blocks < 2 {
            return 0.0;
        }
        let n = f64::from(self.n_blocks);
        (self.squares / (n * (n - 1.0))).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_is_the_standard_error() {
        let mut scatter = Scatter::default();
        assert_eq!(scatter.error(), 0.0);
        for value in [1.0, 2.0, 3.0, 6.0] {
            scatter.add(value);
        }
        // Variance 14/3 of 4 values.
        assert!((scatter.error() - (14.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(scatter.mean, 3.0);
    }
}
