//! Whether a finished scattering table serves a scene: the same water, wavelengths and theory, and at least
//! the sizes, angles, orders and accuracy that the plan asks for. What it holds beyond that is no fault.

use std::fmt;

use niji_exchange::MovedBows;
use niji_exchange::RowUse;
use niji_exchange::ScatteringTable;
use niji_radiometry::Micrometers;
use niji_radiometry::WavelengthGrid;
use niji_scatter::DropMotion;
use niji_scatter::SizeRows;
use niji_scatter::Theory;
use niji_sizes::narrowest_variance;

use super::scattering_need::ScatteringNeed;

/// Rounding of numbers in files, relative; angles (rad) as they are.
const ROUNDOFF: f64 = 1e-5;

/// What a table has otherwise than a scene needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misfit {
    /// What it is about.
    what: &'static str,
    /// What the table has.
    found: String,
    /// What the scene needs.
    expected: String,
    /// Flag of `niji scatter`, or key of the scene, to change.
    key: String,
}

impl fmt::Display for Misfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what,
            found,
            expected,
            key,
        } = self;
        write!(f, "{what}: found {found}, expected {expected} ({key})")
    }
}

/// A misfit if `fits` does not hold.
fn unless(
    fits: bool,
    what: &'static str,
    [found, expected]: [String; 2],
    key: impl Into<String>,
) -> Option<Misfit> {
    (!fits).then(|| Misfit {
        what,
        found,
        expected,
        key: key.into(),
    })
}

impl ScatteringNeed {
    /// Why a table does not serve a picture of these wavelengths; nothing if it does.
    pub fn misfits(&self, table: &ScatteringTable, wavelengths: WavelengthGrid) -> Vec<Misfit> {
        let ours = [
            self.theory_misfit(table),
            self.orders_misfit(table),
            wavelengths_misfit(table.wavelengths, wavelengths),
            unless(
                table.water == self.water,
                "water",
                [table.water.to_string(), self.water.to_string()],
                "--temperature-c and --salinity-per-mille, or [water]",
            ),
            self.disc_misfit(table),
            unless(
                table.relative_error <= self.relative_error * (1.0 + ROUNDOFF),
                "error of interpolation",
                [
                    table.relative_error.to_string(),
                    format!("at most {}", self.relative_error),
                ],
                "--relative-error, or accuracy.table_relative_error",
            ),
            self.angles_misfit(table),
            self.radii_misfit(table),
            self.widths_misfit(table),
            self.motion
                .and_then(|motion| self.motion_misfit(motion, table, wavelengths)),
            unless(
                !self.phase_functions || table.phase_functions.is_some(),
                "light scattered more than once",
                ["no phase functions", "phase functions"].map(str::to_owned),
                "--phase-functions, or effects.multiple_scattering = \"off\"",
            ),
        ];
        ours.into_iter().flatten().collect()
    }

    /// Drops by size are those of the theory that a plan takes for all of them, to the error of the table.
    fn theory_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let expected = self.theory.name();
        let by_size =
            table.theory == Theory::BySize.name() && Theory::SMALL_AND_LARGE.contains(&self.theory);
        unless(
            table.theory == expected || by_size,
            "theory",
            [table.theory.clone(), expected.to_owned()],
            format!("--theory {expected}, or accuracy.theory"),
        )
    }

    fn orders_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let is_in = |p: &u32| table.orders.split(',').any(|held| held == p.to_string());
        let holds = table.orders == "all" || self.theory.ignores_orders();
        let names: Vec<String> = self.orders.iter().map(u32::to_string).collect();
        let expected = names.join(",");
        unless(
            holds || self.orders.iter().all(is_in),
            "orders",
            [table.orders.clone(), format!("at least {expected}")],
            format!("--orders {expected}, or effects.higher_orders"),
        )
    }

    fn disc_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let [found, expected] = [table.sun_disc_diameter_rad, self.sun_disc_diameter_rad];
        let text = |rad: f64| format!("a diameter of {:.4} degrees", rad.to_degrees());
        unless(
            (found - expected).abs() <= ROUNDOFF * expected,
            "sun's disc",
            [text(found), text(expected)],
            "--sun-disc-deg, or effects.sun_disc",
        )
    }

    fn angles_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let angles = &table.theta_rad;
        let found = ends(angles);
        let (low, high) = self.theta_range_rad;
        let text =
            |(low, high): (f64, f64)| format!("{:.2},{:.2}", low.to_degrees(), high.to_degrees());
        let expected = text(self.theta_range_rad);
        unless(
            found.0 <= low + ROUNDOFF && found.1 >= high - ROUNDOFF,
            "scattering angles in degrees",
            [text(found), format!("at least {expected}")],
            "--theta-deg",
        )
    }

    /// Single sizes have to hold all of the laws, and laws the effective radii.
    fn radii_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let found = ends(&table.effective_radius_um);
        let single = table.row_use == RowUse::Sums;
        let expected = match (self.rows, single) {
            (_, true) => self.support_um,
            (SizeRows::Laws, false) => ends(&self.effective_radius_um),
            // The renderer knows what effective radii the drops have.
            (SizeRows::Bins { .. }, false) => return None,
        };
        let text = |(low, high): (f64, f64)| format!("{low:.4},{high:.4}");
        unless(
            found.0 <= expected.0 * (1.0 + ROUNDOFF) && found.1 >= expected.1 * (1.0 - ROUNDOFF),
            "radii in um",
            [text(found), format!("at least {}", text(expected))],
            if single {
                "--radii-um"
            } else {
                "--effective-radius-um"
            },
        )
    }

    /// Laws narrower than single sizes lie apart would show the bows of these.
    fn widths_misfit(&self, table: &ScatteringTable) -> Option<Misfit> {
        let (narrowest, widest) = match self.rows {
            SizeRows::Laws => ends(&self.effective_variance),
            SizeRows::Bins {
                narrowest_variance, ..
            } => (narrowest_variance, narrowest_variance),
        };
        let (found, key) = match table.row_use {
            RowUse::Sums => {
                let steps = table.effective_radius_um.windows(2);
                let step = steps
                    .map(|pair| (pair[1] / pair[0]).ln())
                    .fold(0.0, f64::max);
                let found = narrowest_variance(step, self.relative_error);
                let key = "a smaller --effective-variance beside --radii-um, or none";
                ((found, f64::INFINITY), key)
            }
            RowUse::Laws => (ends(&table.effective_variance), "--effective-variance"),
        };
        let is_held = found.0 <= narrowest * (1.0 + ROUNDOFF) + ROUNDOFF;
        unless(
            is_held && found.1 >= widest * (1.0 - ROUNDOFF),
            "effective variance of the narrowest law",
            [
                format!("{:.4}", found.0),
                format!("at most {narrowest:.4}, with all up to {widest:.4}"),
            ],
            key,
        )
    }

    /// Whether bows move, and as the scene's drops lie.
    fn motion_misfit(
        &self,
        motion: DropMotion,
        table: &ScatteringTable,
        wavelengths: WavelengthGrid,
    ) -> Option<Misfit> {
        let Some(moved) = &table.moved else {
            let own = self.request(wavelengths, None);
            return unless(
                !own.moves(),
                "drops",
                ["spheres", "flattened ones"].map(str::to_owned),
                "--flattened, or effects.drop_flattening = \"off\"",
            );
        };
        unless(
            moves_so(moved, motion, ends(&table.effective_radius_um).1),
            "motion of the drops",
            [
                "another".to_owned(),
                format!(
                    "tilts of {} degrees and axis ratios that vary by {}",
                    motion.tilt_sd_deg, motion.axis_ratio_sd
                ),
            ],
            "[drop_motion]; --scene makes a table of any motion",
        )
    }
}

/// Whether the largest drops lie as they do in a motion.
fn moves_so(moved: &MovedBows, motion: DropMotion, largest_um: f64) -> bool {
    let Some(found) = moved.drops.last() else {
        return true;
    };
    let expected = motion.drops(Micrometers(largest_um));
    [
        (found.eccentricity, expected.eccentricity),
        (found.eccentricity_sd, expected.eccentricity_sd),
        (found.mean_sin2, expected.mean_sin2),
        (found.mean_sin4, expected.mean_sin4),
    ]
    .into_iter()
    .all(|(found, expected)| (found - expected).abs() <= ROUNDOFF * expected.abs())
}

fn wavelengths_misfit(found: WavelengthGrid, expected: WavelengthGrid) -> Option<Misfit> {
    let text =
        |grid: WavelengthGrid| format!("{},{},{}", grid.first_nm(), grid.step_nm(), grid.len());
    unless(
        found == expected,
        "wavelengths",
        [text(found), text(expected)],
        format!("--spectrum {}, or [spectrum]", text(expected)),
    )
}

/// First and last of an axis; nothing is in an empty one.
fn ends(axis: &[f64]) -> (f64, f64) {
    let first = axis.first().copied().unwrap_or(f64::INFINITY);
    (first, axis.last().copied().unwrap_or(0.0))
}
