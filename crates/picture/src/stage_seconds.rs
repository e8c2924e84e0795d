//! How long the stages of a scene will take on this machine, by parts of them.
//!
//! s = (s_1 + (n - 1) (s_3 - s_1)/2)/n_threads
//! `n` wavelengths, `s_1` and `s_3` seconds of one thread for one wavelength of a table and for three, tables being made
//! wavelength by wavelength: that of the drops, and that of the air where only both are asked for. Drops, the whole air
//! and their light are made; a few strips of pixels are followed, through a table of one wavelength that stands for
//! all ([`niji_render::foretold_seconds`]).

use ndarray::Array4;
use ndarray::Array5;
use niji_airy::AiryTable;
use niji_exchange::MovedBows;
use niji_exchange::MovedOrder;
use niji_exchange::ScatteringTable;
use niji_radiometry::WavelengthGrid;
use niji_render::Clock;
use niji_render::foretold_seconds;
use niji_scene::Stage;
use rayon::ThreadPoolBuilder;

use crate::error::Error;
use crate::picture::PictureParts;
use crate::picture::PictureSettings;
use crate::picture::PictureWork;
use crate::planned_scene::PlannedScene;
use crate::watch::unwatched;

/// Bytes of a stage's file that are written in a second.
pub const WRITTEN_BYTES_PER_S: f64 = 1e8;

/// Wavelengths beside one whose table is made to see what each takes.
const SOME: usize = 3;

/// Seconds that both tables of a planned scene take.
///
/// # Errors
/// As those of [`PlannedScene::scattering`] and [`PlannedScene::air`].
pub fn table_seconds(planned: &PlannedScene, clock: Clock) -> Result<f64, Error> {
    let airy = planned.airy()?;
    let (of_drops_s, _) = scattering_seconds((planned, airy.as_ref()), clock)?;
    let of_air = |few: WavelengthGrid| {
        let mut scene = planned.scene.clone();
        scene.spectrum = few;
        crate::air::table(&scene, planned.plan.scattering_orders(), &unwatched)
    };
    let (of_air_s, _) = seconds_of_all((planned.scene.spectrum, clock), of_air)?;
    Ok(of_drops_s + of_air_s)
}

/// Seconds that each stage of a planned scene takes, its file written; none of those that set a bow into a photograph. A
/// part of each is measured, so no two answers are the same.
///
/// # Errors
/// As those of [`PlannedScene::picture`].
pub fn stage_seconds(planned: &PlannedScene, clock: Clock) -> Result<Vec<(Stage, f64)>, Error> {
    let (drops_s, drops) = timed(clock, || planned.drops())?;
    let (depth_s, depth_m) = timed(clock, || planned.photo_depth_m())?;
    let (airy_s, airy) = timed(clock, || planned.airy())?;
    let (scatter_s, table) = scattering_seconds((planned, airy.as_ref()), clock)?;
    let (air_s, air) = timed(clock, || planned.air(&unwatched))?;
    let settings = PictureSettings::of(planned);
    let (whole, n_pictures) = (settings.whole()?, settings.n_pictures());
    let parts = PictureParts {
        drops,
        table: table.map(|table| for_all(table, planned.scene.spectrum)),
        air,
        surfaces: planned.surfaces(depth_m)?,
    };
    let (lit_s, work) = timed(clock, || PictureWork::new(settings, parts, &unwatched))?;
    let rays_s = foretold_seconds(&work.request(whole), clock)?;
    let seconds = planned.plan.stages.iter().filter_map(|it| {
        let seconds = match it.stage {
            Stage::Depth => depth_s,
            Stage::Drops => drops_s,
            Stage::Airy => airy_s,
            Stage::Scatter => scatter_s,
            Stage::Atmosphere => air_s,
            Stage::Render => n_pictures as f64 * (lit_s + rays_s),
            Stage::Sun | Stage::Check | Stage::Composite => return None,
        };
        let bytes = it.estimate.file_bytes.unwrap_or(0);
        Some((it.stage, seconds + bytes as f64 / WRITTEN_BYTES_PER_S))
    });
    Ok(seconds.collect())
}

/// Seconds that the scattering table takes, and the table of a wavelength of it.
fn scattering_seconds(
    (planned, airy): (&PlannedScene, Option<&AiryTable>),
    clock: Clock,
) -> Result<(f64, Option<ScatteringTable>), Error> {
    let Some(need) = &planned.plan.scattering else {
        return Ok((0.0, None));
    };
    let of = |few: WavelengthGrid| crate::scattering::table(need, few, airy, &unwatched);
    let (seconds, table) = seconds_of_all((planned.scene.spectrum, clock), of)?;
    Ok((seconds, Some(table)))
}

/// Seconds that a table of all wavelengths takes, and the table of one.
fn seconds_of_all<T: Send>(
    (spectrum, clock): (WavelengthGrid, Clock),
    make: impl Fn(WavelengthGrid) -> Result<T, Error> + Sync,
) -> Result<(f64, T), Error> {
    let of = |n_wavelengths: usize| {
        let few = middle_of(spectrum, n_wavelengths)?;
        of_one_thread(clock, || make(few))
    };
    let n = spectrum.len();
    // Of two a clock that is off by a tenth would tell half of a wavelength's time, where most is shared.
    let n_more = SOME.min(n);
    let ((one_s, table), (more_s, _)) = (of(1)?, of(n_more)?);
    let each_s = (more_s - one_s).max(0.0) / (n_more - 1).max(1) as f64;
    Ok((one_s + (n as f64 - 1.0) * each_s, table))
}

/// Wavelengths in the middle of others.
fn middle_of(grid: WavelengthGrid, n_wavelengths: usize) -> Result<WavelengthGrid, Error> {
    let middle = grid.center(grid.len() / 2).0;
    WavelengthGrid::new(middle, grid.step_nm(), n_wavelengths).map_err(Error::scene)
}

/// What one thread makes, and seconds that it would have taken all of them.
fn of_one_thread<T: Send>(
    clock: Clock,
    make: impl FnOnce() -> Result<T, Error> + Send,
) -> Result<(f64, T), Error> {
    let n_threads = rayon::current_num_threads() as f64;
    let (seconds, made) = match ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(alone) => alone.install(|| timed(clock, make))?,
        // It takes as long then, or a little less.
        Err(_) => timed(clock, make)?,
    };
    Ok((seconds / n_threads, made))
}

/// What is made, and seconds that it took.
fn timed<T>(clock: Clock, make: impl FnOnce() -> Result<T, Error>) -> Result<(f64, T), Error> {
    let start_s = clock();
    let made = make()?;
    Ok((clock() - start_s, made))
}

/// A table of one wavelength as that of many.
fn for_all(table: ScatteringTable, wavelengths: WavelengthGrid) -> ScatteringTable {
    let n = wavelengths.len();
    let (n_polarisations, n_radii, n_variances, _, n_angles) = table.values.dim();
    let values = Array5::from_shape_fn(
        (n_polarisations, n_radii, n_variances, n, n_angles),
        |(s, radius, variance, _, theta)| table.values[[s, radius, variance, 0, theta]],
    );
    let of_order = |order: MovedOrder| {
        let (n_polarisations, n_radii, _, n_angles) = order.values.dim();
        let values = Array4::from_shape_fn(
            (n_polarisations, n_radii, n, n_angles),
            |(s, radius, _, theta)| order.values[[s, radius, 0, theta]],
        );
        let shifts = order.shifts.iter().cycle().take(n).copied().collect();
        MovedOrder {
            shifts,
            values,
            ..order
        }
    };
    ScatteringTable {
        wavelengths,
        values,
        moved: table.moved.map(|moved| MovedBows {
            orders: moved.orders.into_iter().map(of_order).collect(),
            ..moved
        }),
        phase_functions: (table.phase_functions)
            .map(|phase_functions| Box::new(for_all(*phase_functions, wavelengths))),
        ..table
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ndarray::Axis;

    use super::*;
    use crate::picked_sun::scene_from_toml;
    use crate::planned_scene::PlanRequest;

    fn planned() -> PlannedScene {
        let text = include_str!("../../../data/scenes/rain-5-mm-h-flattened.toml");
        let mut scene = scene_from_toml(text, Path::new("")).unwrap();
        scene.camera = scene.camera.no_wider_than(12);
        scene.spectrum = scene.spectrum.in_wider_bins(4);
        scene.accuracy.table_relative_error = Some(0.05);
        let request = PlanRequest {
            is_hasty: true,
            ..PlanRequest::default()
        };
        PlannedScene::new(scene, request).unwrap()
    }

    #[test]
    fn what_wavelengths_share_is_counted_once() {
        use std::sync::atomic::AtomicU64;
        use std::sync::atomic::Ordering::Relaxed;
        // A clock that goes on by 10 s for what they share, and by 2 s for each.
        let now = AtomicU64::new(0);
        let clock = || now.load(Relaxed) as f64;
        let make = |few: WavelengthGrid| Ok(now.fetch_add(10 + 2 * few.len() as u64, Relaxed));
        let n_threads = rayon::current_num_threads() as f64;
        for n in [1, 2, 3, 41] {
            let spectrum = WavelengthGrid::new(400.0, 5.0, n).unwrap();
            let (seconds, _) = seconds_of_all((spectrum, &clock), make).unwrap();
            let expected = (10.0 + 2.0 * n as f64) / n_threads;
            assert!(
                (seconds - expected).abs() < 1e-9,
                "{n}: {seconds} {expected}"
            );
        }
    }

    #[test]
    fn the_table_of_a_wavelength_stands_for_all_in_every_part_of_it() {
        let planned = planned();
        let need = planned.plan.scattering.as_ref().unwrap();
        let grid = planned.scene.spectrum;
        let one = middle_of(grid, 1).unwrap();
        let one = crate::scattering::table(need, one, None, &unwatched).unwrap();
        let all = for_all(one.clone(), grid);
        let real = crate::scattering::table(need, grid, None, &unwatched).unwrap();
        // Each wavelength asks for angles of its own.
        let but_angles = |shape: &[usize]| shape[..shape.len() - 1].to_vec();
        assert_eq!(
            but_angles(all.values.shape()),
            but_angles(real.values.shape())
        );
        let moved = |table: &ScatteringTable| {
            let orders = table.moved.as_ref().unwrap().orders.iter();
            let sizes = orders.map(|it| (it.order, it.shifts.len(), but_angles(it.values.shape())));
            sizes.collect::<Vec<_>>()
        };
        assert_eq!(moved(&all), moved(&real));
        for wavelength in 0..grid.len() {
            let of =
                |table: &ScatteringTable, index| table.values.index_axis(Axis(3), index).to_owned();
            assert_eq!(of(&all, wavelength), of(&one, 0));
        }
    }
}
