//! Stretches of a ray in air so deep that it hides within a few of them what lies behind: fog.
//!
//! s = D/2 (0, 3^-k, …, 1/3, 1) from either end of a stretch of length D, 3^-k so small that the air in the first
//! piece has an optical depth of 1/2 at most
//! The nodes of a whole stretch would all lie behind the fog, where nothing is seen, and so would twice as many: a
//! fog of 10 m of visibility was black, without an error. Each piece has as many nodes as a long stretch. Pieces
//! behind an optical depth of 300, at whichever wavelength it is largest, send nothing.

use crate::air::Air;
use crate::air_glow::SHORT_M;
use crate::gauss_nodes::AirRay;
use crate::gauss_nodes::AirStretch;

/// Optical depths that the nodes of a stretch see through: of a short one, which has a single node, of another, and
/// of the dense end of a crowded one. Light from such air errs by 0.3, 0.2 and 0.1 %.
const SEEN_BY_ONE: f64 = 0.25;
const SEEN_BY_FEW: f64 = 3.0;
const SEEN_BY_CROWD: f64 = 4.0;

/// The dense end: this part of a stretch with crowded nodes.
const DENSE_END: f64 = 0.02;

/// Largest optical depth of the pieces at both ends.
const FIRST_DEPTH: f64 = 0.5;

/// Ratio of the ends of a piece.
const RATIO: f64 = 3.0;

/// Most pieces from one end: from 1000 km to a millimetre.
const MOST_PIECES: i32 = 20;

/// Nothing is seen through so much air.
const HIDDEN_DEPTH: f64 = 300.0;

/// The stretches of a range of a ray, cut where the air is deep.
pub(crate) fn stretches(
    air: &Air,
    ray: AirRay,
    range_m: (f64, f64),
) -> impl Iterator<Item = AirStretch> {
    let whole = AirStretch::of_range(air.planet(), ray, range_m);
    whole.flat_map(move |stretch| {
        let depth = |distance_m: f64| air.largest_depth(&air.through(ray, distance_m));
        let (seen, pieces) = if is_deep(&stretch, air, &depth) {
            (None, pieces(&stretch, &depth))
        } else {
            (Some(stretch), Vec::new())
        };
        seen.into_iter().chain(pieces)
    })
}

/// Whether the air hides what lies between the nodes of a stretch.
fn is_deep(stretch: &AirStretch, air: &Air, depth: &impl Fn(f64) -> f64) -> bool {
    let (from_m, to_m) = (stretch.from_m, stretch.to_m);
    if !stretch.is_crowded() {
        let is_short = stretch.length_m() < SHORT_M;
        let seen = if is_short { SEEN_BY_ONE } else { SEEN_BY_FEW };
        return !air.is_thinner(stretch.length_m(), seen) && depth(to_m) - depth(from_m) > seen;
    }
    let end_m = DENSE_END * stretch.length_m();
    if air.is_thinner(end_m, SEEN_BY_CROWD) {
        return false;
    }
    let at_start = depth(from_m + end_m) - depth(from_m);
    let at_end = depth(to_m) - depth(to_m - end_m);
    at_start.max(at_end) > SEEN_BY_CROWD
}

/// The pieces of a stretch that are seen.
fn pieces(stretch: &AirStretch, depth: &impl Fn(f64) -> f64) -> Vec<AirStretch> {
    let (from_m, to_m) = (stretch.from_m, stretch.to_m);
    let half_m = 0.5 * stretch.length_m();
    let off_m = |k: i32| half_m * RATIO.powi(-k);
    let n_pieces = |is_thin: &dyn Fn(f64) -> bool| {
        let thin = (0..MOST_PIECES).find(|k| is_thin(off_m(*k)));
        thin.unwrap_or(MOST_PIECES)
    };
    let (at_start, at_end) = (depth(from_m), depth(to_m));
    let n_from_start = n_pieces(&|off_m| depth(from_m + off_m) - at_start <= FIRST_DEPTH);
    let n_from_end = n_pieces(&|off_m| at_end - depth(to_m - off_m) <= FIRST_DEPTH);
    let from_start = (0..=n_from_start).rev().map(|k| from_m + off_m(k));
    let from_end = (1..=n_from_end).map(|k| to_m - off_m(k));
    let mut ends_m = vec![from_m];
    ends_m.extend(from_start.chain(from_end));
    ends_m.push(to_m);
    let pairs = ends_m.windows(2).filter(|ends_m| ends_m[1] > ends_m[0]);
    let seen = pairs.take_while(|ends_m| depth(ends_m[0]) < HIDDEN_DEPTH);
    seen.map(|ends_m| AirStretch::deep(ends_m[0], ends_m[1]))
        .collect()
}
