//! The scattering table that a picture needs, and no more.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::f64::consts::PI;

use niji_airy::AiryTable;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use niji_scatter::DropMotion;
use niji_scatter::SizeRows;
use niji_scatter::TableRequest;
use niji_scatter::Theory;
use niji_sizes::bin_step;
use niji_sizes::bins;
use niji_sizes::radius_axis;
use niji_sizes::variance_axis;
use serde::Deserialize;
use serde::Serialize;

use crate::effect::Effect;
use crate::scene::Scene;

use super::drop_summary::DropSummary;
use super::error::PlanError;
use super::facts::Situation;
use super::light_curves::LightCurves;
use super::light_curves::SUN_DISC_DIAMETER_RAD;
use super::theory_by_size::table_theory;

/// Beyond the angles in view, so that pixel footprints and rounding stay inside the table, degrees.
const ANGLE_MARGIN_DEG: f64 = 0.05;

/// The scattering table that a picture needs, and no more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScatteringNeed {
    /// How a drop scatters.
    pub theory: Theory,
    /// Orders that take part.
    pub orders: Vec<u32>,
    /// Smallest and largest scattering angle, rad.
    pub theta_range_rad: (f64, f64),
    /// Largest error of interpolation, relative to the peak of the bow.
    pub relative_error: f64,
    /// Effective radii, um.
    pub effective_radius_um: Vec<f64>,
    /// Effective variances.
    pub effective_variance: Vec<f64>,
    /// Smallest and largest single radii of all laws that have light, um; what is made does not depend on it.
    #[serde(default, skip_serializing_if = "is_untold")]
    pub support_um: (f64, f64),
    /// What the rows stand for.
    pub rows: SizeRows,
    /// How flattened drops move, where the light that flattening moves is kept apart; `None` for spheres.
    pub motion: Option<DropMotion>,
    /// Whether phase functions are needed beside, for light that drops scatter more than once.
    pub phase_functions: bool,
    /// Diameter of the sun's disc, rad; 0 for a point.
    pub sun_disc_diameter_rad: f64,
    /// What the drops are made of.
    #[serde(flatten)]
    pub water: Water,
}

/// Whether nothing is to be said of radii.
fn is_untold(range: &(f64, f64)) -> bool {
    *range == (0.0, 0.0)
}

impl ScatteringNeed {
    /// Rows of the table: a size each, of all light and of each order that moves.
    pub fn n_rows(&self) -> usize {
        let n_moved = || self.theory.moved_orders(&self.orders).len();
        let n_parts = self.motion.map_or(1, |_| 1 + n_moved());
        self.effective_radius_um.len() * self.effective_variance.len() * n_parts
    }

    /// The table as the stage takes it.
    pub fn request<'a>(
        &self,
        wavelengths: WavelengthGrid,
        airy_table: Option<&'a AiryTable>,
    ) -> TableRequest<'a> {
        TableRequest {
            theory: self.theory,
            orders: self.orders.clone(),
            theta_range_rad: self.theta_range_rad,
            tolerance: self.relative_error,
            wavelengths,
            effective_radius_um: self.effective_radius_um.clone(),
            effective_variance: self.effective_variance.clone(),
            rows: self.rows,
            motion: self.motion,
            sun_disc_diameter_rad: self.sun_disc_diameter_rad,
            water: self.water,
            airy_table,
        }
    }
}

/// The table that the drops in view need; `None` if no light of theirs is wanted.
pub(super) fn scattering_need(
    scene: &Scene,
    (situation, curves): (&Situation, &LightCurves<'_>),
    on: &BTreeSet<Effect>,
) -> Result<Option<ScatteringNeed>, PlanError> {
    let bows = [(Effect::PrimaryBow, 2), (Effect::SecondaryBow, 3)];
    let bows = bows.into_iter().filter(|(bow, _)| on.contains(bow));
    let mut orders: Vec<u32> = bows.map(|(_, order)| order).collect();
    let Some(mut theta_range_rad) = angles_needed(situation, on, &orders) else {
        return Ok(None);
    };
    if on.contains(&Effect::HigherOrders) {
        orders.extend(curves.higher_orders());
        orders.sort_unstable();
    }
    let levels = &situation.levels;
    let drops = if on.contains(&Effect::SizeSpread) {
        Cow::Borrowed(&situation.drops)
    } else {
        Cow::Owned(situation.drops.clone().without_spread())
    };
    let with_disc = on.contains(&Effect::SunDisc);
    let error = levels.table_relative_error;
    let theory = table_theory(levels.theory, on);
    // A table of orders that the theory lacks is refused, and says why.
    let held = theory.orders_among(&orders);
    if !held.is_empty() {
        orders = held;
    }
    let is_flat = on.contains(&Effect::DropFlattening) && situation.rise.is_some();
    let motion = is_flat.then_some(scene.drop_motion);
    let sizes = table_sizes(&drops, (theory, error), is_flat)?;
    if is_flat {
        let reach_rad = situation
            .flat_drops(scene)
            .farthest_rad((drops.effective_radius_um.1, drops.effective_variance.1));
        let (low_rad, high_rad) = theta_range_rad;
        theta_range_rad = (
            (low_rad - reach_rad).max(0.0),
            (high_rad + reach_rad).min(PI),
        );
    }
    Ok(Some(ScatteringNeed {
        theory,
        orders,
        theta_range_rad,
        relative_error: error,
        effective_radius_um: sizes.radius_um,
        effective_variance: sizes.variance,
        support_um: drops.laws.support_um()?,
        rows: sizes.rows,
        motion,
        phase_functions: on.contains(&Effect::MultipleScattering),
        sun_disc_diameter_rad: if with_disc {
            SUN_DISC_DIAMETER_RAD
        } else {
            0.0
        },
        water: scene.water(),
    }))
}

/// Scattering angles of the light that is wanted; `None` if there is none.
fn angles_needed(situation: &Situation, on: &BTreeSet<Effect>, bows: &[u32]) -> Option<(f64, f64)> {
    let both_sides = on.contains(&Effect::HigherOrders);
    if bows.is_empty() && !both_sides {
        return None;
    }
    let (low_deg, high_deg) = situation.view.theta_deg?;
    let mut seen_rad = (low_deg.to_radians(), high_deg.to_radians());
    if on.contains(&Effect::ReflectionBow)
        && let Some((low, high)) = situation.mirrored.as_ref().and_then(|sun| sun.theta_rad)
    {
        seen_rad = (seen_rad.0.min(low), seen_rad.1.max(high));
    }
    let margin_rad = ANGLE_MARGIN_DEG.to_radians() + situation.camera.pixel_angle().0;
    let mut low_rad = (seen_rad.0 - margin_rad).max(0.0);
    let mut high_rad = (seen_rad.1 + margin_rad).min(PI);
    // The renderer leaves out the side of a bow that is off; its split lies between both bows.
    let (primary_rad, secondary_rad) = situation.bows_rad;
    if bows == [2] && !both_sides {
        low_rad = low_rad.max(secondary_rad);
    } else if bows == [3] && !both_sides {
        high_rad = high_rad.min(primary_rad);
    }
    (low_rad < high_rad).then_some((low_rad, high_rad))
}

/// Sizes of a table and what its rows stand for.
struct TableSizes {
    radius_um: Vec<f64>,
    variance: Vec<f64>,
    rows: SizeRows,
}

/// The sizes that drops need: their laws, or, where these are more or drops are flattened, the single sizes of
/// which they are sums.
fn table_sizes(
    drops: &DropSummary,
    (theory, error): (Theory, f64),
    is_flat: bool,
) -> Result<TableSizes, PlanError> {
    let (radii_um, variances) = (drops.effective_radius_um, drops.effective_variance);
    let laws = TableSizes {
        radius_um: radius_axis(radii_um, variances.0, error)?,
        variance: variance_axis(variances)?,
        rows: SizeRows::Laws,
    };
    let narrowest_variance = drops.laws.narrowest_variance(error);
    let step = bin_step(narrowest_variance, error).map(|step| step.min(theory.widest_bin(error)));
    let rows = SizeRows::Bins {
        ln_step: step.unwrap_or(0.0),
        narrowest_variance,
    };
    let (radius_um, rows) = match step {
        Some(ln_step) => (bins(drops.laws.support_um()?, ln_step), rows),
        // One size everywhere is a law, as are all where their spread is left out.
        None if variances.1 <= 0.0 => (laws.radius_um.clone(), SizeRows::Laws),
        None => (radius_axis(drops.laws.support_um()?, 0.0, error)?, rows),
    };
    if !is_flat && laws.radius_um.len() * laws.variance.len() <= radius_um.len() {
        return Ok(laws);
    }
    Ok(TableSizes {
        radius_um,
        variance: vec![0.0],
        rows,
    })
}
