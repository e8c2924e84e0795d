//! Parts of a pixel that edges cut: the horizon, edges of surfaces and of their shadows, of the
//! drops' box and of the image circle.
//!
//! L = sum_k sum_j (b_kj - a_kj)/n L(x_k, (a_kj + b_kj)/2)
//! `n` strips, x_k = (k + 1/2)/n their middles, `a_kj` and `b_kj` ends of the parts of a strip: n cells, of which
//! each whose ends meet different things is cut where that changes, by halving. What a ray meets is
//! geometry and costs next to nothing beside its light. The sum is exact for a straight edge through all strips in
//! light that is linear on both sides of it; an edge that ends in a strip errs by 1/(8 n²) of its step. Strips run
//! across most edges. An edge within a cell whose ends meet the same is not seen.

use crate::frame::Frame;
use crate::surface_light::Spot;
use crate::surface_light::SurfaceLight;
use crate::surfaces::Sight;
use crate::wave_facets::N_STRATA;

/// Cells along a side of the lattice on which edges are looked for.
pub(crate) const N_LOOKED_AT: u32 = 8;

/// Halvings of a cell that is cut.
const N_HALVINGS: u32 = 12;

/// Most cuts of a cell.
const MOST_CUTS: u32 = 3;

/// What lies on a pixel's border is looked at this far inside of it: beyond begins the next pixel of a map.
const INSET: f64 = 1e-6;

/// Distances of surfaces that differ by more than this part of the nearer have an edge between them.
const JUMP: f64 = 0.1;

/// A part of a pixel, which the ray through a place stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// The place, in pixels from the pixel's corner.
    pub(crate) place: (f64, f64),
    /// Its share of the pixel's area.
    pub(crate) share: f64,
}

/// What ends a view ray.
#[derive(Clone, Copy, Debug)]
enum End {
    Sky,
    Ground { is_sunlit: bool },
    Surface { distance_m: f64, lit: Option<Lit> },
    Water { shows_sun: bool },
}

/// What a lit surface is told from another by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Lit {
    solid: usize,
    is_sunlit: bool,
}

/// What a view ray meets on its way to an end.
#[derive(Clone, Copy, Debug)]
struct Way {
    end: End,
    drops: bool,
}

/// What a view ray meets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    way: Way,
    /// In water at its end, by facet.
    in_water: [Option<Way>; N_STRATA],
}

impl Met {
    /// What a sight in a frame meets.
    pub(crate) fn of(sight: &Sight, frame: &Frame) -> Self {
        // Waves mirror no edges.
        let in_water = if frame.has_still_water() {
            frame.sights_in_water(sight)
        } else {
            Vec::new()
        };
        Self::with_water(sight, &in_water, frame)
    }

    /// What a sight meets that ends where light is as smooth as in the sky or in drops: at no surface, and no ground on
    /// which the shadows of surfaces may lie, nor in still water that mirrors such places.
    pub(crate) fn in_the_open(sight: &Sight, in_water: &[Sight], frame: &Frame) -> Option<Self> {
        let lit = frame.lit.as_ref();
        let has_shadows = lit.is_some_and(SurfaceLight::has_shadows_of_surfaces);
        let may_be_shaded = |sight: &Sight| has_shadows && frame.ground_m(&sight.ray).is_some();
        let is_open = |sight: &Sight| sight.surface_m.is_infinite() && !may_be_shaded(sight);
        let ends_openly = match sight.foot {
            // Waves blur what they mirror.
            Some(_) => !frame.has_still_water() || in_water.iter().all(is_open),
            None => is_open(sight),
        };
        ends_openly.then(|| Self::with_water(sight, in_water, frame))
    }

    /// Whether it is water in which the sun is seen.
    pub(crate) fn shows_sun(self) -> bool {
        matches!(self.way.end, End::Water { shows_sun: true })
    }

    fn with_water(sight: &Sight, in_water: &[Sight], frame: &Frame) -> Self {
        let way = |sight: &Sight| Way {
            end: End::of(sight, frame),
            drops: frame.range_m(sight).is_some(),
        };
        Self {
            way: way(sight),
            in_water: std::array::from_fn(|facet| in_water.get(facet).map(way)),
        }
    }

    fn is_like(&self, other: &Self) -> bool {
        let are_alike = |a: Option<Way>, b: Option<Way>| match (a, b) {
            (Some(a), Some(b)) => a.is_like(b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let mut facets = self.in_water.into_iter().zip(other.in_water);
        self.way.is_like(other.way) && facets.all(|(a, b)| are_alike(a, b))
    }
}

impl Way {
    fn is_like(self, other: Self) -> bool {
        self.drops == other.drops && self.end.is_like(other.end)
    }
}

impl End {
    /// Of a sight in a frame.
    fn of(sight: &Sight, frame: &Frame) -> Self {
        let ground_m = frame.ground_m(&sight.ray);
        let distance_m = sight.surface_m;
        match ground_m {
            _ if sight.foot.is_some() => Self::Water {
                shows_sun: frame.shows_sun(sight),
            },
            Some(ground_m) if ground_m < distance_m => {
                let lit = frame.lit.as_ref();
                let is_sunlit = lit.is_none_or(|lit| !lit.is_ground_shaded(sight.ray.at(ground_m)));
                Self::Ground { is_sunlit }
            }
            None if distance_m.is_infinite() => Self::Sky,
            Some(_) | None => {
                let lit = frame.lit.as_ref().zip(Spot::of(sight));
                let lit = lit.map(|(light, spot)| Lit {
                    solid: spot.face.solid,
                    is_sunlit: !light.is_shaded(&spot),
                });
                Self::Surface { distance_m, lit }
            }
        }
    }

    fn is_like(self, other: Self) -> bool {
        match (self, other) {
            (Self::Sky, Self::Sky) => true,
            (Self::Water { shows_sun: a }, Self::Water { shows_sun: b })
            | (Self::Ground { is_sunlit: a }, Self::Ground { is_sunlit: b }) => a == b,
            (
                Self::Surface { distance_m: a, lit },
                Self::Surface {
                    distance_m: b,
                    lit: other,
                },
            ) => lit == other && is_one_surface(a, b),
            _ => false,
        }
    }
}

/// Whether distances (m) that lie beside each other are of one surface, or of none.
pub(crate) fn is_one_surface(a_m: f64, b_m: f64) -> bool {
    a_m.total_cmp(&b_m).is_eq() || (a_m - b_m).abs() <= JUMP * a_m.min(b_m)
}

/// What the rays through the places of a pixel meet; nothing where the camera sees nothing.
pub(crate) type Meets<'a> = dyn Fn((f64, f64)) -> Option<Met> + 'a;

/// A place along a strip, and what is met there.
type Node = (f64, Option<Met>);

/// Which way strips run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Strips {
    Across,
    Down,
}

impl Strips {
    /// Strips across most edges of a pixel; `None` where none is found.
    pub(crate) fn across_edges(meets: &Meets) -> Option<Self> {
        let mut lattices = [N_LOOKED_AT / 2, N_LOOKED_AT].into_iter();
        lattices.find_map(|n_cells| Self::across_edges_of(n_cells, meets))
    }

    /// The same on a lattice of so many cells along a side.
    fn across_edges_of(n_cells: u32, meets: &Meets) -> Option<Self> {
        let along = |index| share(index, n_cells);
        let row = |y| (0..=n_cells).map(move |x| Self::Across.place(along(y), along(x)));
        let met: Vec<Vec<_>> = (0..=n_cells).map(|y| row(y).map(meets).collect()).collect();
        let is_change = |a: (usize, usize), b: (usize, usize)| !alike(met[a.0][a.1], met[b.0][b.1]);
        let (mut across, mut down) = (0, 0);
        for line in 0..met.len() {
            for node in 1..met.len() {
                across += usize::from(is_change((line, node - 1), (line, node)));
                down += usize::from(is_change((node - 1, line), (node, line)));
            }
        }
        match (across, down) {
            (0, 0) => None,
            _ if across > down => Some(Self::Across),
            _ => Some(Self::Down),
        }
    }

    /// The parts of n strips of n cells, strip by strip.
    pub(crate) fn parts(self, n: u32, meets: &Meets) -> Vec<Vec<Part>> {
        let of_strip = |strip: u32| {
            let beside = (f64::from(strip) + 0.5) / f64::from(n);
            let at = |along| meets(self.place(beside, along));
            let ends = (0..=n).map(|end| (share(end, n), at(share(end, n))));
            let ends: Vec<_> = ends.collect();
            let mut borders = vec![0.0];
            for cell in ends.windows(2) {
                let (mut first, last) = (cell[0], cell[1]);
                for _ in 0..MOST_CUTS {
                    if alike(first.1, last.1) {
                        break;
                    }
                    let before = first;
                    first = change(before, last, &at);
                    borders.push(first.0);
                }
                borders.push(last.0);
            }
            let parts = borders.windows(2).map(|part| Part {
                place: self.place(beside, 0.5 * (part[0] + part[1])),
                share: (part[1] - part[0]) / f64::from(n),
            });
            parts.collect()
        };
        (0..n).map(of_strip).collect()
    }

    /// A place by the distances from where strips lie side by side and from their ends.
    fn place(self, beside: f64, along: f64) -> (f64, f64) {
        let along = along.clamp(INSET, 1.0 - INSET);
        let beside = beside.clamp(INSET, 1.0 - INSET);
        match self {
            Self::Across => (along, beside),
            Self::Down => (beside, along),
        }
    }
}

fn share(index: u32, n: u32) -> f64 {
    f64::from(index) / f64::from(n)
}

/// Whether rays meet the same.
pub(crate) fn alike(a: Option<Met>, b: Option<Met>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => a.is_like(&b),
        (None, None) => true,
        _ => false,
    }
}

/// Where between two places along a strip what is met changes first, and to what.
fn change(first: Node, last: Node, at: &dyn Fn(f64) -> Option<Met>) -> Node {
    let (mut low, mut high) = (first.0, last);
    for _ in 0..N_HALVINGS {
        let middle = 0.5 * (low + high.0);
        let met = at(middle);
        if alike(first.1, met) {
            low = middle;
        } else {
            high = (middle, met);
        }
    }
    (0.5 * (low + high.0), high.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SKY: Met = met(End::Sky);
    const GROUND: Met = met(End::Ground { is_sunlit: true });

    /// Where there are no drops.
    const fn met(end: End) -> Met {
        Met {
            way: Way { end, drops: false },
            in_water: [None; N_STRATA],
        }
    }

    /// Below a line through a place, turned by an angle from the horizontal, lies the ground.
    fn below(place: (f64, f64), turn_rad: f64) -> impl Fn((f64, f64)) -> Option<Met> {
        move |(x, y)| {
            let down = (y - place.1) * turn_rad.cos() + (x - place.0) * turn_rad.sin();
            Some(if down > 0.0 { GROUND } else { SKY })
        }
    }

    /// The area that is seen below, by parts and by a lattice of places.
    fn areas(n: u32, meets: &Meets) -> (f64, f64) {
        let is_ground = |place| {
            matches!(
                meets(place),
                Some(Met {
                    way: Way {
                        end: End::Ground { .. },
                        ..
                    },
                    ..
                })
            )
        };
        let parts =
            Strips::across_edges(meets).map_or(Vec::new(), |it| it.parts(n, meets).concat());
        let all: f64 = parts.iter().map(|part| part.share).sum();
        assert!(parts.is_empty() || (all - 1.0).abs() < 1e-12, "{all}");
        let seen = parts.iter().filter(|part| is_ground(part.place));
        let many = 1000;
        let middle = |index: u32| (f64::from(index) + 0.5) / f64::from(many);
        let places = (0..many * many).map(|index| (middle(index % many), middle(index / many)));
        let n_ground = places.filter(|place| is_ground(*place)).count();
        (
            seen.map(|part| part.share).sum(),
            n_ground as f64 / f64::from(many * many),
        )
    }

    #[test]
    fn a_straight_edge_through_opposite_sides_has_its_area_with_two_strips() {
        for turn_deg in [0.0, 5.0, 20.0, -20.0, 70.0, 90.0, 110.0, 180.0] {
            let meets = below((0.51, 0.43), f64::to_radians(turn_deg));
            let (found, expected) = areas(2, &meets);
            // What the lattice errs by.
            assert!(
                (found - expected).abs() < 1e-3,
                "{turn_deg}: {found} {expected}"
            );
        }
    }

    #[test]
    fn an_edge_through_corners_errs_with_the_square_of_the_strips() {
        for turn_deg in [30.0, 45.0, -50.0, 100.0, 135.0, 200.0] {
            for place in [(0.0, 0.0), (0.2, 0.3), (0.9, 0.35), (1.0, 0.0)] {
                let meets = below(place, f64::to_radians(turn_deg));
                for n in [1, 2, 4, 8] {
                    let (found, expected) = areas(n, &meets);
                    let most = 0.25 / f64::from(n * n) + 1e-3;
                    let error = (found - expected).abs();
                    let seen = found > 0.0 || expected < 0.05;
                    assert!(!seen || error < most, "{turn_deg} {place:?} {n}: {error}");
                }
            }
        }
    }

    #[test]
    fn an_edge_on_the_border_cuts_nothing() {
        for (place, turn_deg) in [((0.0, 0.0), 0.0), ((0.0, 1.0), 0.0), ((1.0, 0.0), 90.0)] {
            let meets = below(place, f64::to_radians(turn_deg));
            assert_eq!(Strips::across_edges(&meets), None, "{place:?}");
        }
    }

    #[test]
    fn a_mast_within_a_pixel_has_its_width() {
        let mast = |distance_m| {
            met(End::Surface {
                distance_m,
                lit: None,
            })
        };
        let meets = |(x, _): (f64, f64)| {
            let is_mast = (0.37..0.62).contains(&x);
            Some(if is_mast { mast(20.0) } else { mast(30.0) })
        };
        let strips = Strips::across_edges(&meets).unwrap();
        assert_eq!(strips, Strips::Across);
        let parts = strips.parts(4, &meets).concat();
        let seen = parts
            .iter()
            .filter(|part| (0.37..0.62).contains(&part.place.0));
        let width: f64 = seen.map(|part| part.share).sum();
        assert!((width - 0.25).abs() < 1e-4, "{width}");
    }
}
