//! What theory by size comes to in a scene.
//!
//! A scene whose laws of size are all made by one theory takes that alone: rain the uniform one, fog that of
//! Lorenz and Mie. Where the sun is in view, diffracted light is added however large the drops are. No switch
//! of an effect decides on it: exact light of small drops keeps an order that is off (see `reasons`), and
//! switching that order on changes no other light.

use niji_radiometry::Micrometers;
use niji_radiometry::WavelengthGrid;
use niji_scatter::Theory;
use niji_scatter::theory_for_law;

use crate::accuracy::Levels;

use super::DropSummary;
use super::View;

/// Diffracted light is seen within it of the sun, degrees.
const CORONA_DEG: f64 = 15.0;

/// The levels with the theory that the drops in view are made with.
pub(super) fn in_scene(
    levels: Levels,
    (drops, view, wavelengths): (&DropSummary, &View, WavelengthGrid),
) -> Levels {
    if levels.theory != Theory::BySize {
        return levels;
    }
    let sees_sun = view
        .theta_deg
        .is_some_and(|(low_deg, _)| low_deg < CORONA_DEG);
    let theory = match of_all_laws(drops, wavelengths, levels.table_relative_error) {
        Theory::Uniform if sees_sun => Theory::BySize,
        theory => theory,
    };
    Levels { theory, ..levels }
}

/// The theory on which laws of all sizes agree: the smallest drops are as narrow as any, since a mixture with
/// larger ones, which is broader, has a larger radius.
fn of_all_laws(drops: &DropSummary, wavelengths: WavelengthGrid, tolerance: f64) -> Theory {
    let (radii, variances) = (drops.effective_radius_um, drops.effective_variance);
    let laws = [
        (radii.0, variances.0),
        ((radii.0 * radii.1).sqrt(), variances.1),
        (radii.1, variances.1),
    ]
    .into_iter()
    .map(|(radius_um, variance)| (Micrometers(radius_um), variance));
    // What is no law is said by those who make the table.
    let mut theories =
        laws.map(|law| theory_for_law(law, wavelengths, tolerance).unwrap_or(Theory::BySize));
    let first = theories.next().unwrap_or(Theory::BySize);
    if theories.all(|theory| theory == first) {
        first
    } else {
        Theory::BySize
    }
}
