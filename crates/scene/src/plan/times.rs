//! How long stages take: their work times rates that were measured.
//!
//! t = r(w) w F
//! `w` work of the stage, counted from the plan; `r` seconds for a unit of it, interpolated between
//! calibration scenes by their work (a small one shows what a stage costs at least); `F` time of the
//! levels over that of the standard ones, a factor for each decision.

use serde::Serialize;

use crate::accuracy::Levels;
use crate::accuracy::Preset;
use crate::choice_levels::DECISIONS;
use crate::choice_levels::Decision;
use crate::choice_transfer::carried;
use crate::measured::MeasuredLevel;
use crate::measured::MeasuredLevels;
use crate::scene::Scene;

use super::ScatteringNeed;
use super::Stage;
use super::facts::Situation;

/// What times and errors of a scene scale with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Work {
    /// Edge of a voxel of the drops (m).
    pub voxel_m: f64,
    /// Width of a pixel in the middle of the picture, degrees.
    pub pixel_deg: f64,
    /// Smallest effective radius of the drops (um).
    pub smallest_radius_um: f64,
    /// Nodes of the drop volume.
    nodes: f64,
    /// Lines of the scattering table, one for each radius and flattening, times radians: theories differ
    /// in what one takes.
    table_lines: f64,
    /// Spectra of the air's table.
    air_spectra: f64,
    /// Pixels of the picture, overscan included.
    pixels: f64,
}

impl Work {
    pub(super) fn new(scene: &Scene, situation: &Situation, need: Option<&ScatteringNeed>) -> Self {
        let overscan_px = 2 * scene.camera.overscan_px;
        let camera = &situation.camera;
        let [width, height] = [camera.width_px(), camera.height_px()].map(|px| px + overscan_px);
        let n_wavelengths = situation.grid.len() as f64;
        let drops = &situation.drops;
        Self {
            voxel_m: drops.voxel_m,
            pixel_deg: camera.pixel_angle().0.to_degrees(),
            smallest_radius_um: drops.effective_radius_um.0,
            nodes: drops.n_nodes as f64,
            table_lines: need.map_or(0.0, |need| table_lines(need, n_wavelengths)),
            air_spectra: scene
                .air
                .as_ref()
                .map_or(0.0, |air| air.constituents.len() as f64 * n_wavelengths),
            pixels: f64::from(width) * f64::from(height),
        }
    }

    /// The work of a stage; `None` where nobody counts it.
    pub fn of_stage(&self, stage: Stage) -> Option<f64> {
        match stage {
            Stage::Drops => Some(self.nodes),
            Stage::Airy => Some(1.0),
            Stage::Scatter => Some(self.table_lines),
            Stage::Atmosphere => Some(self.air_spectra),
            Stage::Render => Some(self.pixels),
            Stage::Depth | Stage::Sun | Stage::Check | Stage::Composite => None,
        }
    }

    /// Time of a stage at some levels, s; `None` where nothing was measured.
    pub fn seconds(&self, stage: Stage, levels: &Levels, measured: &MeasuredLevels) -> Option<f64> {
        let work = self.of_stage(stage)?;
        let rate = |row: &MeasuredLevel| {
            let work = row.work.filter(|work| *work > 0.0)?;
            Some((work, row.seconds? / work))
        };
        let rates = |level: &str| -> Vec<(f64, f64)> {
            let rows = measured.of_level(stage.name(), level);
            rows.filter_map(rate).collect()
        };
        // Some tables are measured level by level.
        let tables = DECISIONS
            .iter()
            .filter(|decision| decision.table == Some(stage));
        let mut of_levels = tables.map(|table| rates(&table.level_of(levels)));
        let rates = of_levels
            .find(|rates| !rates.is_empty())
            .unwrap_or_else(|| rates(TOTAL));
        let decisions = DECISIONS.iter().filter(|decision| decision.stage == stage);
        let factor: f64 = decisions
            .map(|decision| self.factor(decision, levels, measured))
            .product();
        Some(carried(&rates, work)? * work * factor)
    }

    /// Time of a decision's level over that of the standard preset's; 1 where it was not measured.
    fn factor(&self, decision: &Decision, levels: &Levels, measured: &MeasuredLevels) -> f64 {
        let standard = Preset::Standard.levels(self.voxel_m);
        let relative = |levels: &Levels| {
            let name = decision.measured_name(levels, self.voxel_m);
            let rows = measured.of_level(decision.key, &name);
            let times: Vec<f64> = rows.filter_map(|row| row.relative_time).collect();
            let n = times.len() as f64;
            (n > 0.0).then(|| (times.iter().map(|time| time.ln()).sum::<f64>() / n).exp())
        };
        match (relative(levels), relative(&standard)) {
            (Some(time), Some(standard)) if standard > 0.0 => time / standard,
            (Some(_) | None, _) => 1.0,
        }
    }
}

/// Level of the rows that hold the time of a whole stage.
const TOTAL: &str = "total";

/// Size laws of one radius share their drops, whose light takes longer than its averages.
fn table_lines(need: &ScatteringNeed, n_wavelengths: f64) -> f64 {
    let (low_rad, high_rad) = need.theta_range_rad;
    let rows = need.effective_radius_um.len() * need.flattening.len();
    rows as f64 * n_wavelengths * (high_rad - low_rad)
}
