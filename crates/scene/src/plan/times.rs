//! How long stages take: their work times rates that were measured.
//!
//! t = r(w) w F
//! `w` work of the stage, counted from the plan; `r` seconds for a unit of it, interpolated between
//! calibration scenes by their work (a small one shows what a stage costs at least); `F` time of the
//! levels over that of the standard ones, a factor for each decision.
//!
//! What is counted, in units whose rates calibration measures:
//! * drops: nodes, each as many as its shape takes over a node of even rain;
//! * table: lines, a wavelength times a radian of one radius and flattening; further radii share what
//!   the first looks up, flattenings less of it; every number of the rows beyond the first; and what
//!   any table takes;
//! * picture: pixels, with a share for each wavelength and for light of the air, whose nodes know no
//!   wavelength; the numbers of the table beyond its first row, which the renderer lays out; the paths of
//!   light of further orders; and what any picture takes. The length of rays in drops is not counted.
//!
//! The shares were measured in November 2026 on 31 shipped scenes, as draft and as standard: pictures were
//! foretold at 0.54 to 1.6 times what they took, tables that take more than a tenth of a second at 0.41 to
//! 3.8 times (those of Lorenz-Mie too slow), whole runs within a factor of 2 but for 4 of 62.

use std::collections::BTreeSet;

use niji_droplets::Shape;
use niji_render::DropOrders;
use serde::Serialize;

use crate::accuracy::Levels;
use crate::accuracy::Preset;
use crate::choice_levels::DECISIONS;
use crate::choice_levels::Decision;
use crate::choice_transfer::carried;
use crate::drops::Drops;
use crate::effect::Effect;
use crate::measured::MeasuredLevel;
use crate::measured::MeasuredLevels;
use crate::scene::Scene;

use super::ScatteringNeed;
use super::Stage;
use super::facts::Situation;

/// Lines that a further radius of a table takes over those of the first, and what all take for the
/// orders that move.
const FURTHER_RADIUS: f64 = 0.06;
const MOVED_ORDERS: f64 = 2.0;

/// Lines that a number of the rows beyond the first takes to be averaged.
const LINES_PER_NUMBER: f64 = 1.5e-5;

/// Lines that any table takes.
const LINES_OF_TABLE: f64 = 8.0;

/// Pixels of 41 wavelengths in a vacuum that a pixel takes without any wavelength, and for each.
const PIXEL: f64 = 0.36;
const PIXEL_PER_WAVELENGTH: f64 = 0.64 / 41.0;

/// The same of the light of air on its view ray, and for each constituent.
const GLOW: f64 = 0.55;
const GLOW_PER_CONSTITUENT: f64 = 0.45;

/// Pixels that any picture takes.
const PIXELS_OF_PICTURE: f64 = 1e4;

/// Pixels that take as long as a number of the table takes to be laid out, and as a path of light of
/// further orders does: that at one wavelength, and so many times it at each.
const PIXELS_PER_NUMBER: f64 = 0.0115;
const PIXELS_PER_PATH: (f64, f64) = (0.107, 1.0 / 57.0);

/// Parts of the light on a view ray from which paths start.
const PARTS_OF_RAY: f64 = 4.0;

/// Time of what a photograph is judged and composed by, for a pixel (s).
const DEPTH_SECONDS: f64 = 1e-7;
const CHECK_SECONDS: f64 = 4e-6;
const COMPOSITE_SECONDS: f64 = 4e-6;

/// Time of the sun by picks (s).
const SUN_SECONDS: f64 = 1e-3;

/// What times and errors of a scene scale with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Work {
    /// Edge of a voxel of the drops (m).
    pub voxel_m: f64,
    /// Width of a pixel in the middle of the picture, degrees.
    pub pixel_deg: f64,
    /// Smallest effective radius of the drops (um).
    pub smallest_radius_um: f64,
    /// Nodes of the drop volume, as many as its shape takes over even rain.
    nodes: f64,
    /// Lines of the scattering table: theories differ in what one takes.
    table_lines: f64,
    /// Numbers of the scattering table beyond those of its first row.
    further_numbers: f64,
    /// Wavelengths of the scene.
    n_wavelengths: f64,
    /// Spectra of the air's table.
    air_spectra: f64,
    /// Pixels of the picture, overscan included.
    pixels: f64,
    /// Whether air sends light along view rays.
    air_glows: bool,
    /// Whether light of further orders is followed, whatever the levels say of how.
    follows_orders: bool,
}

impl Work {
    /// Counts the work of a scene; `need` is its scattering table with its number of angles.
    pub(super) fn new(
        scene: &Scene,
        situation: &Situation,
        (need, on): (Option<(&ScatteringNeed, usize)>, &BTreeSet<Effect>),
    ) -> Self {
        let overscan_px = 2 * scene.camera.overscan_px;
        let camera = &situation.camera;
        let [width, height] = [camera.width_px(), camera.height_px()].map(|px| px + overscan_px);
        let n_wavelengths = situation.grid.len() as f64;
        let drops = &situation.drops;
        Self {
            voxel_m: drops.voxel_m,
            pixel_deg: camera.pixel_angle().0.to_degrees(),
            smallest_radius_um: drops.effective_radius_um.0,
            nodes: nodes_of_even_rain(drops.n_nodes as f64, &scene.drops),
            table_lines: need.map_or(0.0, |(need, _)| n_wavelengths * lines_of_wavelength(need)),
            further_numbers: need.map_or(0.0, |(need, n_angles)| {
                2.0 * n_wavelengths * n_angles as f64 * (need.n_rows() as f64 - 1.0)
            }),
            n_wavelengths,
            air_spectra: scene
                .air
                .as_ref()
                .map_or(0.0, |air| air.constituents.len() as f64 * n_wavelengths),
            pixels: f64::from(width) * f64::from(height),
            air_glows: [Effect::AirInscatter, Effect::Sky]
                .iter()
                .any(|effect| on.contains(effect)),
            follows_orders: on.contains(&Effect::MultipleScattering) && need.is_some(),
        }
    }

    /// The work of a stage at some levels; `None` where nobody counts it.
    pub fn of_stage(&self, stage: Stage, levels: &Levels) -> Option<f64> {
        match stage {
            Stage::Drops => Some(self.nodes),
            Stage::Airy => Some(1.0),
            Stage::Scatter => {
                let of_numbers = LINES_PER_NUMBER * self.further_numbers;
                Some(LINES_OF_TABLE + self.table_lines + of_numbers)
            }
            Stage::Atmosphere => Some(self.air_spectra),
            Stage::Render => {
                let laid_out = PIXELS_PER_NUMBER * self.further_numbers;
                let pixels = self.pixels * self.pixels_of_pixel();
                let paths = self.pixels_of_paths(levels.drop_orders);
                Some(PIXELS_OF_PICTURE + pixels + laid_out + paths)
            }
            Stage::Depth | Stage::Sun | Stage::Check | Stage::Composite => None,
        }
    }

    /// Pixels of 41 wavelengths in a vacuum that take as long as one of the picture.
    fn pixels_of_pixel(&self) -> f64 {
        let n_constituents = self.air_spectra / self.n_wavelengths;
        let glow = if self.air_glows {
            GLOW + GLOW_PER_CONSTITUENT * n_constituents
        } else {
            0.0
        };
        PIXEL + PIXEL_PER_WAVELENGTH * self.n_wavelengths + glow
    }

    /// Pixels that take as long as the paths of light of further orders.
    fn pixels_of_paths(&self, orders: DropOrders) -> f64 {
        match orders {
            DropOrders::MultipleScattering { .. } if self.follows_orders => {
                let (alone, by_wavelength) = PIXELS_PER_PATH;
                let of_path = alone * (1.0 + by_wavelength * self.n_wavelengths);
                PARTS_OF_RAY * orders.n_paths() as f64 * of_path
            }
            DropOrders::SingleScattering | DropOrders::MultipleScattering { .. } => 0.0,
        }
    }

    /// Time of a stage of a photograph, which no level changes, s.
    fn of_photo(&self, stage: Stage) -> Option<f64> {
        match stage {
            Stage::Depth => Some(DEPTH_SECONDS * self.pixels),
            Stage::Sun => Some(SUN_SECONDS),
            Stage::Check => Some(CHECK_SECONDS * self.pixels),
            Stage::Composite => Some(COMPOSITE_SECONDS * self.pixels),
            Stage::Drops | Stage::Airy | Stage::Scatter | Stage::Atmosphere | Stage::Render => None,
        }
    }

    /// Time of a stage at some levels, s; `None` where nothing was measured.
    pub fn seconds(&self, stage: Stage, levels: &Levels, measured: &MeasuredLevels) -> Option<f64> {
        let Some(work) = self.of_stage(stage, levels) else {
            return self.of_photo(stage);
        };
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
        // Paths are counted.
        let decisions = DECISIONS
            .iter()
            .filter(|decision| decision.stage == stage && decision.key != DROP_ORDERS);
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

/// The decision whose levels are counted, not measured as a factor.
const DROP_ORDERS: &str = "drop_orders";

/// Lines of one wavelength. Size laws of one radius share their drops, whose light takes longer than
/// its averages.
fn lines_of_wavelength(need: &ScatteringNeed) -> f64 {
    let (low_rad, high_rad) = need.theta_range_rad;
    let further = |nodes: &[f64], share: f64| 1.0 + share * (nodes.len() as f64 - 1.0);
    (high_rad - low_rad)
        * further(&need.effective_radius_um, FURTHER_RADIUS)
        * need.motion.map_or(1.0, |_| MOVED_ORDERS)
}

/// Nodes of even rain that take as long as those of drops: a fountain's drops are followed, the laws of
/// spray are evaluated at every node. Of several populations all nodes count as the slowest.
fn nodes_of_even_rain(nodes: f64, drops: &Drops) -> f64 {
    let shapes = drops.populations().iter().map(|it| it.source.shape());
    let rates = shapes.map(|shape| match shape {
        Some(Shape::Fountain(_)) => (1.0, 2e6),
        Some(Shape::SeaSpray(_)) => (12.0, 0.0),
        Some(Shape::Waterfall(_)) => (5.0, 0.0),
        Some(
            Shape::Uniform(_)
            | Shape::Gradient(_)
            | Shape::RainShaft(_)
            | Shape::FogBank(_)
            | Shape::RainCell(_),
        )
        | None => (1.0, 0.0),
    });
    let (slowest, followed) = rates.fold((1.0_f64, 0.0), |(a, b), (rate, more)| {
        (a.max(rate), b + more)
    });
    slowest * nodes + followed
}
