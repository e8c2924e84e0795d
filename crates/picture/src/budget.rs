//! A picture in the time that there is.
//!
//! s = (s_1 + (n - 1) (s_2 - s_1) + n a_1)/n_threads
//! `s` seconds that the tables of a scene take, `n` wavelengths, `s_1` and `s_2` seconds of one thread for one
//! wavelength of the drops' table and for two, `a_1` for one of the air's, measured. Tables are made wavelength by
//! wavelength.
//!
//! Tables get half of the time that is left, by the finest tolerance of some for which that is enough; the other half
//! goes into paths and rays ([`niji_render::Deadline`]).

use niji_radiometry::WavelengthGrid;
use niji_render::Clock;
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

/// Seconds that the tables of a planned scene take.
///
/// # Errors
/// As those of [`PlannedScene::scattering`] and [`PlannedScene::air`]; a system without another thread.
pub fn table_seconds(planned: &PlannedScene, clock: Clock) -> Result<f64, Error> {
    let n_threads = rayon::current_num_threads() as f64;
    let grid = planned.scene.spectrum;
    let alone = ThreadPoolBuilder::new().num_threads(1).build();
    let airy = planned.airy()?;
    let few = |n_wavelengths: usize| {
        let middle = grid.center(grid.len() / 2).0;
        let few = WavelengthGrid::new(middle, grid.step_nm(), n_wavelengths);
        few.map_err(Error::scene)
    };
    let of_air = || {
        let mut scene = planned.scene.clone();
        scene.spectrum = few(1)?;
        let start_s = clock();
        crate::air::table(&scene, planned.plan.scattering_orders(), &unwatched)?;
        Ok::<_, Error>(clock() - start_s)
    };
    let of_drops = |n_wavelengths: usize| {
        let start_s = clock();
        if let Some(need) = &planned.plan.scattering {
            crate::scattering::table(need, few(n_wavelengths)?, airy.as_ref(), &unwatched)?;
        }
        Ok::<_, Error>(clock() - start_s)
    };
    let seconds = || {
        let (one, two) = (of_drops(1)?, of_drops(grid.len().min(2))?);
        let n = grid.len() as f64;
        Ok(one + (n - 1.0) * (two - one).max(0.0) + n * of_air()?)
    };
    let of_one_thread: Result<f64, Error> = match alone {
        Ok(alone) => alone.install(seconds),
        // It takes as long then, or a little less.
        Err(_) => seconds(),
    };
    Ok(of_one_thread? / n_threads)
}
