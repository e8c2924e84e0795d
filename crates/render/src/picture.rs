//! The picture: rays for pixels, tiles in parallel.
//!
//! A pixel depends on nothing but the request, and every sum in it has a fixed order, so the bytes
//! do not depend on the number of threads, nor on the region that it is rendered in: what an error
//! estimate needs of neighbors is rendered around the region, too.

use std::ops::ControlFlow;
use std::ops::Range;

use glam::Vec4;
use ndarray::Array2;
use ndarray::s;
use niji_radiometry::Colorimetry;
use rayon::prelude::*;

use crate::air_error::AirError;
use crate::deadline::Afforded;
use crate::deadline::Deadline;
use crate::deadline::MoreRays;
use crate::deadline::Spent;
use crate::error::Error;
use crate::footprint::REACH_PX;
use crate::footprint_error::PixelLight;
use crate::footprint_error::lines_through;
use crate::frame::frame;
use crate::lit_drops::finest_voxel_m;
use crate::picture_layers::Rendered;
use crate::picture_tiles::tiles;
use crate::progress::Progress;
use crate::progress::tell;
use crate::ray_lattice::OF_TOLERANCE;
use crate::ray_lattice::RayLattice;
use crate::ray_tracer::RayTracer;
use crate::ray_tracer::Room;
use crate::refinement::Refining;
use crate::request::RenderRequest;

/// Rows of pixels whose nodes are made together.
const BAND: usize = 64;

/// Render a region of a picture; `progress` gets the number of pixels just finished, from any thread.
///
/// # Errors
/// If the inputs contradict each other or the request, see [`Error`]. A picture without light is not
/// an error: it is black.
pub fn render(request: &RenderRequest, progress: &(dyn Fn(u64) + Sync)) -> Result<Rendered, Error> {
    let progress = &|n_pixels| {
        progress(n_pixels);
        ControlFlow::Continue(())
    };
    let whole = &mut |_: &Rendered, _| u32::MAX;
    let rendered = render_in_steps(request, (progress, Deadline::NEVER), whole);
    rendered.map(|(picture, _)| picture)
}

/// Render a region of a picture from top to bottom, in steps of whole rows.
///
/// `next_rows` is asked before every step how many rows it takes (at least one is taken), and gets the picture
/// and the number of rows that are finished: what it keeps of them needs not be rendered again. The picture does not
/// depend on the steps; at the end of each, threads wait for each other.
///
/// A picture with a deadline is one step. The same request with what there was time for in it, and all paths of the
/// level, gives the same picture without one.
///
/// # Errors
/// As [`render`]; [`Error::Stopped`].
pub fn render_in_steps(
    request: &RenderRequest,
    (progress, deadline): (Progress, Deadline),
    next_rows: &mut dyn FnMut(&Rendered, u32) -> u32,
) -> Result<(Rendered, Spent), Error> {
    let has_end = deadline.end_s.is_finite();
    request.check()?;
    request.check_memory()?;
    let tracer = tracer(request, (progress, deadline))?;
    let height = request.region.height_px as usize;
    let n_pixels = request.region.n_pixels();
    let mut taken = Taken::dark(&tracer, request);
    let (mut traced, mut finished) = (0, 0);
    let mut coarser_rays = request.coarser_rays;
    let (mut more_rays_s, mut more_rays) = (0.0, MoreRays::default());
    while traced < height {
        let n_rows = if has_end {
            height
        } else {
            next_rows(&taken.picture, finished as u32).max(1) as usize
        };
        let step = traced..traced.saturating_add(n_rows).min(height);
        taken.trace(&tracer, &step, progress)?;
        traced = step.end;
        // The last rows wait for the neighbors below them.
        let known = if traced == height {
            height
        } else {
            traced.saturating_sub(REACH_PX as usize)
        };
        let rows = finished..known;
        taken.add_missed(&tracer, &rows);
        if let Some(tolerance_cd_m2) = request.tolerance_cd_m2 {
            let (picture, refining) = taken.refining(&rows);
            if has_end {
                coarser_rays = tracer.affordable(picture, &refining, (tolerance_cd_m2, deadline));
            }
            let start_s = (deadline.now_s)();
            let step = tracer.refine(picture, &refining, coarser_rays * tolerance_cd_m2);
            more_rays.change += step.change / n_pixels as f64;
            more_rays.error += step.error / n_pixels as f64;
            more_rays_s += (deadline.now_s)() - start_s;
        }
        tracer.frame.check_rows()?;
        finished = known;
    }
    let multiple = tracer.frame.multiple.as_ref();
    let spent = Spent {
        afforded: Afforded {
            coarser_rays,
            paths_per_node: multiple.map(|it| it.n_paths),
        },
        paths_s: multiple.map_or(0.0, |it| it.seconds),
        more_rays_s,
        more_rays,
    };
    Ok((taken.picture, spent))
}

/// What follows the rays of a picture.
pub(crate) fn tracer<'a>(
    request: &RenderRequest<'a>,
    (progress, deadline): (Progress, Deadline),
) -> Result<RayTracer<'a>, Error> {
    let colorimetry = Colorimetry::new(&request.wavelengths);
    let frame = frame(request, &colorimetry, (progress, deadline))?;
    let to_vector = |[x, y, z]: &[f64; 3]| Vec4::new(*x as f32, *y as f32, *z as f32, 0.0);
    let mut tracer = RayTracer {
        frame,
        eye: request.eye(),
        region: request.region,
        footprint: request.levels.pixel_footprint,
        pixel_rad: request.camera.pixel_angle().0,
        most_missed_cd_m2: OF_TOLERANCE * request.tolerance_cd_m2.unwrap_or_default(),
        voxel_m: finest_voxel_m(request.drops.bricks()),
        xyz_weights: colorimetry.weights().iter().map(to_vector).collect(),
        air_error: AirError::none(),
    };
    tracer.air_error = tracer.measure_air();
    if let Some(tolerance_cd_m2) = request.tolerance_cd_m2 {
        tracer.refine_air(tolerance_cd_m2);
    }
    Ok(tracer)
}

/// A picture while its rays are followed.
pub(crate) struct Taken {
    picture: Rendered,
    /// Light of its pixels and of those around it.
    lights_around: Array2<PixelLight>,
    lattice: RayLattice,
}

impl Taken {
    /// A black one of the tracer's region; what stands around it is seen.
    pub(crate) fn dark(tracer: &RayTracer, request: &RenderRequest) -> Self {
        let region = tracer.region;
        let [width, height] = [region.width_px, region.height_px].map(|it| it as usize);
        let reach = REACH_PX as usize;
        let mut lights_around = Array2::default((height + 2 * reach, width + 2 * reach));
        tracer.trace_around(&mut lights_around);
        Self {
            picture: Rendered::dark([request.wavelengths.len(), height, width], request.layers()),
            lights_around,
            lattice: RayLattice::over(tracer, region),
        }
    }

    /// Follow rays for the pixels of some rows.
    ///
    /// # Errors
    /// [`Error::Stopped`].
    pub(crate) fn trace(
        &mut self,
        tracer: &RayTracer,
        rows: &Range<usize>,
        progress: Progress,
    ) -> Result<(), Error> {
        let reach = REACH_PX as usize;
        let (height, width) = self.lights_around.dim();
        for from in rows.clone().step_by(BAND) {
            let band = from..rows.end.min(from + BAND);
            let in_frame = |row: usize| tracer.region.y_px.saturating_add(row as i32);
            self.lattice
                .reach(tracer, &(in_frame(band.start)..in_frame(band.end)));
            let inner = s![reach..height - reach, reach..width - reach];
            let inner = self.lights_around.slice_mut(inner);
            let pictured = self.picture.tiles_mut(&band).into_iter();
            let lattice = &self.lattice;
            pictured
                .zip(tiles(inner, &band))
                .collect::<Vec<_>>()
                .into_par_iter()
                .with_max_len(1)
                .try_for_each_init(
                    || Room::new(tracer),
                    |room, (tile, lights_around)| {
                        let n_pixels = lights_around.len() as u64;
                        tracer.trace_tile(lattice, tile, lights_around, room);
                        tell(progress, n_pixels)
                    },
                )?;
        }
        Ok(())
    }

    /// Forget what pixels follow from, as if no ray had been followed.
    pub(crate) fn forget_nodes(&mut self, tracer: &RayTracer) {
        self.lattice = RayLattice::over(tracer, tracer.region);
    }

    /// Add to the error of rows what their footprint misses, once the neighbors of these are followed.
    pub(crate) fn add_missed(&mut self, tracer: &RayTracer, rows: &Range<usize>) {
        let lights_around = &self.lights_around;
        self.picture.add_missed(rows.clone(), &|x, y| {
            tracer.missed(&lines_through(lights_around, x, y), tracer.footprint)
        });
    }

    /// The picture, and what its rows need to get more rays.
    pub(crate) fn refining(&mut self, rows: &Range<usize>) -> (&mut Rendered, Refining<'_>) {
        let refining = Refining {
            rows: rows.clone(),
            lights_around: &self.lights_around,
        };
        (&mut self.picture, refining)
    }
}
