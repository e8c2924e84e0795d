//! A picture in the time that there is.
//!
//! s_table = (n (s_angles + s_rows) + s_pilots)/n_threads,   s_air = n s_1/n_threads
//! `s_table`, `s_air` seconds that the tables of a scene take, `n` wavelengths; the rest are seconds of one thread and
//! one wavelength, measured: the choice of angles, the rows, and small tables of one wavelength that a table is
//! compared with. Tables are made wavelength by wavelength, so that one of them tells what all of them take.
//!
//! Tables get half of the time that is left, by the finest tolerance of some for which that is enough; the other half
//! goes into paths and rays ([`niji_render::Deadline`]).

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::PoisonError;

use niji_radiometry::WavelengthGrid;
use niji_scene::Stage;
use rayon::ThreadPoolBuilder;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::planned_scene::PlannedScene;
use crate::watch::unwatched;

/// Tolerances that a budget chooses from, the coarsest first.
pub const TOLERANCES: [f64; 6] = [0.1, 0.03, 0.01, 0.003, 0.001, 0.0003];

/// What there was time for: with it the same picture is made again without a clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Afforded {
    /// The time that was asked for, seconds.
    pub budget_s: f64,
    /// The tolerance whose tables and effects it has.
    pub tolerance: f64,
    /// How many times larger than that asks for the error of a pixel is before it gets more rays.
    pub coarser_rays: f64,
    /// Paths of light of further orders for each direction, where there is such light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paths_per_node: Option<usize>,
}

impl From<Afforded> for niji_render::Afforded {
    fn from(afforded: Afforded) -> Self {
        Self {
            coarser_rays: afforded.coarser_rays,
            paths_per_node: afforded.paths_per_node,
        }
    }
}

/// Seconds on some clock.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// Seconds that the tables of a planned scene take.
///
/// # Errors
/// As those of [`PlannedScene::scattering`] and [`PlannedScene::air`]; a system without another thread.
pub fn table_seconds(planned: &PlannedScene, clock: Clock) -> Result<f64, Error> {
    let n_threads = rayon::current_num_threads() as f64;
    let grid = planned.scene.spectrum;
    let middle = grid.center(grid.len() / 2).0;
    let one = WavelengthGrid::new(middle, grid.step_nm(), 1).map_err(Error::scene)?;
    let n_wavelengths = grid.len() as f64;
    let alone = ThreadPoolBuilder::new().num_threads(1).build();
    let seconds = || {
        let mut scene = planned.scene.clone();
        scene.spectrum = one;
        let start_s = clock();
        crate::air::table(&scene, planned.plan.scattering_orders(), &unwatched)?;
        let of_air = n_wavelengths * (clock() - start_s);
        Ok(of_air + scattering_seconds(planned, (one, n_wavelengths), clock)?)
    };
    let of_one_thread: Result<f64, Error> = match alone {
        Ok(alone) => alone.install(seconds),
        // It takes as long then, or a little less.
        Err(_) => seconds(),
    };
    Ok(of_one_thread? / n_threads)
}

/// Those of its scattering table by one thread.
fn scattering_seconds(
    planned: &PlannedScene,
    (one, n_wavelengths): (WavelengthGrid, f64),
    clock: Clock,
) -> Result<f64, Error> {
    let Some(need) = &planned.plan.scattering else {
        return Ok(0.0);
    };
    let airy = planned.airy()?;
    // When small tables began, and when the rows did.
    let times_s = Mutex::new([None, None]);
    let watch = |_: Stage, part: f64| {
        let mut times_s = times_s.lock().unwrap_or_else(PoisonError::into_inner);
        times_s[0].get_or_insert_with(clock);
        if part <= 0.0 {
            times_s[1] = Some(clock());
        }
        ControlFlow::Continue(())
    };
    let start_s = clock();
    crate::scattering::table(need, one, airy.as_ref(), &watch)?;
    let end_s = clock();
    let [pilots_s, rows_s] = *times_s.lock().unwrap_or_else(PoisonError::into_inner);
    let pilots_s = pilots_s.unwrap_or(end_s);
    let rows_s = rows_s.unwrap_or(pilots_s);
    let of_each = (pilots_s - start_s) + (end_s - rows_s);
    Ok(n_wavelengths * of_each + (rows_s - pilots_s))
}
