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
use niji_geometry::PixelRegion;
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
    let rendered = render_in_steps(request, (progress, Deadline::NEVER), u32::MAX);
    rendered.map(|(picture, _)| picture)
}

/// Render a region of a picture in steps of so many rows, as [`render_in_strips`] does, into memory.
///
/// # Errors
/// As [`render_in_strips`].
pub fn render_in_steps(
    request: &RenderRequest,
    watch: (Progress, Deadline),
    n_rows: u32,
) -> Result<(Rendered, Spent), Error> {
    request.check()?;
    let region = request.region;
    request.check_memory(region.height_px)?;
    let mut picture: Option<Rendered> = None;
    let mut take = |strip: PixelRegion, rows: Rendered| {
        if strip == region {
            picture = Some(rows);
        } else {
            let picture = picture.get_or_insert_with(|| rows.dark_of_height(region.height_px));
            picture.put_rows(strip.y_px.abs_diff(region.y_px) as usize, &rows);
        }
        ControlFlow::Continue(())
    };
    let spent = checked_strips(request, watch, n_rows, &mut take)?;
    // A region that was checked has rows.
    let picture = picture.unwrap_or_else(|| request.no_rows());
    Ok((picture, spent))
}

/// Render a region of a picture from the top in steps of so many rows, at least one: `take` gets finished rows and where
/// they lie, and may stop it. No more of the picture than a step is in memory. It does not depend on the steps; at the
/// end of each, threads wait for each other.
///
/// A picture with a deadline is one step. The same request with what there was time for in it, and all paths of the
/// level, gives the same picture without one.
///
/// # Errors
/// As [`render`]; [`Error::Stopped`].
pub fn render_in_strips(
    request: &RenderRequest,
    watch: (Progress, Deadline),
    n_rows: u32,
    take: &mut dyn FnMut(PixelRegion, Rendered) -> ControlFlow<()>,
) -> Result<Spent, Error> {
    request.check()?;
    request.check_memory(rows_of_step(watch.1, n_rows).min(request.region.height_px))?;
    checked_strips(request, watch, n_rows, take)
}

fn rows_of_step(deadline: Deadline, n_rows: u32) -> u32 {
    if deadline.end_s.is_finite() {
        u32::MAX
    } else {
        n_rows.max(1)
    }
}

/// As [`render_in_strips`], of a request that was checked and has its memory.
fn checked_strips(
    request: &RenderRequest,
    (progress, deadline): (Progress, Deadline),
    n_rows: u32,
    take: &mut dyn FnMut(PixelRegion, Rendered) -> ControlFlow<()>,
) -> Result<Spent, Error> {
    let has_end = deadline.end_s.is_finite();
    let whole = request.region;
    let n_rows = rows_of_step(deadline, n_rows);
    let mut tracer = tracer(request, (progress, deadline))?;
    let height = whole.height_px as usize;
    let n_pixels = whole.n_pixels();
    let (mut taken, mut traced, mut finished): (Option<Taken>, _, _) = (None, 0, 0);
    let mut coarser_rays = request.coarser_rays;
    let (mut more_rays_s, mut more_rays) = (0.0, MoreRays::default());
    while traced < height {
        let end = traced.saturating_add(n_rows as usize).min(height);
        tracer.region = rows_of(whole, finished..end);
        let strip = Taken::below(taken.take(), &tracer, (request, traced - finished));
        let strip = taken.insert(strip);
        strip.trace(&tracer, &(traced - finished..end - finished), progress)?;
        traced = end;
        // The last rows wait for the neighbors below them.
        let known = if traced == height {
            height
        } else {
            traced.saturating_sub(REACH_PX as usize).max(finished)
        };
        let rows = 0..known - finished;
        strip.add_missed(&tracer, &rows);
        if let Some(tolerance_cd_m2) = request.tolerance_cd_m2 {
            let (picture, refining) = strip.refining(&rows);
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
        if !rows.is_empty() && take(rows_of(whole, finished..known), strip.give(rows)).is_break() {
            return Err(Error::Stopped);
        }
        finished = known;
    }
    let multiple = tracer.frame.multiple.as_ref();
    Ok(Spent {
        afforded: Afforded {
            coarser_rays,
            paths_per_node: multiple.map(|it| it.n_paths),
        },
        further_orders_s: tracer.frame.further_orders_s,
        more_rays_s,
        more_rays,
    })
}

/// Some rows of a region.
fn rows_of(region: PixelRegion, rows: Range<usize>) -> PixelRegion {
    PixelRegion {
        y_px: region.y_px.saturating_add(rows.start as i32),
        height_px: rows.len() as u32,
        ..region
    }
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
        drops: request.drops.bricks(),
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
        let whole = RenderRequest {
            region: tracer.region,
            ..*request
        };
        Self::below(None, tracer, (&whole, 0))
    }

    /// A black one of the tracer's region, which are rows of the request's: those that follow on the ones above, with as
    /// many of these. What stands beside them is seen, above the first and below the last, too.
    fn below(
        above: Option<Self>,
        tracer: &RayTracer,
        (request, n_kept): (&RenderRequest, usize),
    ) -> Self {
        let (region, whole) = (tracer.region, request.region);
        let [width, height] = [region.width_px, region.height_px].map(|it| it as usize);
        let reach = REACH_PX as usize;
        let size = [request.wavelengths.len(), height, width];
        let mut taken = Self {
            picture: Rendered::dark(size, request.layers()),
            lights_around: Array2::default((height + 2 * reach, width + 2 * reach)),
            lattice: RayLattice::over(tracer, whole),
        };
        let mut new_rows = region.y_px.saturating_add(n_kept as i32)..region.bottom() as i32;
        if let Some(above) = above {
            // Light is known two rows higher.
            let first = above.lights_around.nrows() - reach - n_kept - reach;
            let known = above.lights_around.slice(s![first.., ..]);
            let kept = known.slice(s![..n_kept + reach, ..]);
            (taken.lights_around.slice_mut(s![..n_kept + reach, ..])).assign(&kept);
            let n_above = above.picture.radiance.dim().1;
            taken
                .picture
                .put_rows(0, &above.picture.rows(n_above - n_kept..n_above));
            taken.lattice = above.lattice;
        } else {
            new_rows.start -= reach as i32;
        }
        if region.bottom() == whole.bottom() {
            new_rows.end += reach as i32;
        }
        tracer.trace_around(whole, &new_rows, &mut taken.lights_around);
        taken
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

    /// Finished rows from the top.
    fn give(&mut self, rows: Range<usize>) -> Rendered {
        if rows.len() == self.picture.radiance.dim().1 {
            let none = self.picture.dark_of_height(0);
            return std::mem::replace(&mut self.picture, none);
        }
        self.picture.rows(rows)
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
