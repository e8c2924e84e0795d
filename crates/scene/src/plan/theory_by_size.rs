//! What theory by size comes to in a scene.
//!
//! A scene whose light is made by one theory, to the tolerance over that of each mode, takes that alone: rain the
//! uniform one, fog that of Lorenz and Mie. Where the sun is in view, diffracted light is added however large the
//! drops are, and where the antisolar point is, small drops that are more than next to none have their glory. No
//! switch of an effect decides on it: exact light of small drops keeps an order that is off (see `reasons`), and
//! switching that order on changes no other light.

use std::collections::BTreeSet;

use niji_dropfield::LawShare;
use niji_radiometry::Micrometers;
use niji_radiometry::WavelengthGrid;
use niji_scatter::GLORY_LARGEST_UM;
use niji_scatter::GLORY_START_RAD;
use niji_scatter::SizeLaw;
use niji_scatter::Theory;
use niji_scatter::theory_for_laws;

use crate::accuracy::Levels;
use crate::accuracy::Preset;
use crate::effect::Effect;

use super::decided::View;
use super::drop_summary::DropSummary;

/// Diffracted light is seen within it of the sun, degrees.
const CORONA_DEG: f64 = 15.0;

/// The levels with the theory that the drops in view are made with, to a relative error.
pub(super) fn in_scene(
    levels: Levels,
    (drops, view, wavelengths): (&DropSummary, &View, WavelengthGrid),
    tolerance: f64,
) -> Levels {
    if levels.theory != Theory::BySize {
        return levels;
    }
    let sees_rings = view.theta_deg.is_some_and(|(low_deg, high_deg)| {
        let have_glory = drops.laws.smallest_radius_um(tolerance) < GLORY_LARGEST_UM;
        low_deg < CORONA_DEG || have_glory && high_deg.to_radians() > GLORY_START_RAD
    });
    let theory = match of_all_modes(drops, wavelengths, tolerance) {
        Theory::Uniform if sees_rings => Theory::BySize,
        theory => theory,
    };
    Levels { theory, ..levels }
}

/// The levels with exact light alone where a picture of 1 % has that: a law of both theories takes longer.
pub(super) fn exact_where_quicker(
    levels: Levels,
    (drops, wavelengths): (&DropSummary, WavelengthGrid),
) -> Levels {
    let of_standard = Preset::Standard.levels(1.0).table_relative_error;
    let is_mixed = levels.theory == Theory::BySize;
    if is_mixed && of_all_modes(drops, wavelengths, of_standard) == Theory::Mie {
        let theory = Theory::Mie;
        return Levels { theory, ..levels };
    }
    levels
}

/// The theory on which the light of all modes agrees.
fn of_all_modes(drops: &DropSummary, wavelengths: WavelengthGrid, tolerance: f64) -> Theory {
    // At a part of the way from an entry's smallest radius to its largest. The smallest drops are as narrow as
    // any, since a mixture with larger ones, which is broader, has a larger radius.
    let law_at = |law: &LawShare, part: f64| {
        let (low_um, high_um) = law.effective_radius_um;
        let (narrow, broad) = law.effective_variance;
        SizeLaw {
            radius: Micrometers(low_um.powf(1.0 - part) * high_um.powf(part)),
            variance: if part > 0.0 { broad } else { narrow },
            share: law.share,
        }
    };
    let of_mode = |laws: &[LawShare]| {
        let theory = |part: f64| {
            let laws = laws.iter().map(|law| law_at(law, part));
            // What is no law is said by those who make the table.
            theory_for_laws(laws, wavelengths, tolerance).unwrap_or(Theory::BySize)
        };
        agreed([0.0, 0.5, 1.0].map(theory))
    };
    agreed(drops.laws.modes().iter().map(|laws| of_mode(laws)))
}

fn agreed(theories: impl IntoIterator<Item = Theory>) -> Theory {
    let mut theories = theories.into_iter();
    let first = theories.next().unwrap_or(Theory::BySize);
    if theories.all(|theory| theory == first) {
        first
    } else {
        Theory::BySize
    }
}

/// The theory of the table: without interference all are rays.
pub(super) fn table_theory(theory: Theory, on: &BTreeSet<Effect>) -> Theory {
    if on.contains(&Effect::Supernumeraries) {
        theory
    } else {
        Theory::Geometric
    }
}
