//! Where the drops of a volume are: boxes, each with the largest extinction in it.
//!
//! beta <= max N max <r^2> pi
//! over the nodes that reach into a box, `N` their number density and `<r^2>` their mean square
//! radius: it holds for interpolated moments and for interpolated radius and density. Boxes come in
//! two sizes, so that whoever asks for those on a ray passes most of them by at once.

use std::array::from_fn;
use std::collections::BTreeMap;

use niji_dropfield::AreaMoments;
use niji_dropfield::DropMode;
use niji_geometry::Aabb;

/// Small boxes along each axis, at most.
const MOST: [i32; 3] = [36, 24, 36];

/// Small boxes along each axis of a large one.
const SMALL_IN_LARGE: i32 = 3;

/// A large box whose small ones are full and differ by less is one box.
const EVEN: f64 = 0.98;

/// A box within a drop volume.
#[derive(Debug, Clone, PartialEq)]
pub struct DropPart {
    /// The box.
    pub bounds: Aabb,
    /// Largest extinction without diffraction of the mode in it (1/m).
    pub max_extinction_m1_q1: f64,
    /// Number of the mode: extinctions of several add up.
    pub mode: usize,
    /// Smaller boxes that hold all of its drops; empty where they would say no more.
    pub within: Vec<DropPart>,
}

impl DropPart {
    /// The same box of a mode that stands after so many others.
    pub(super) fn with_mode_after(self, n_modes: usize) -> Self {
        let within = self.within.into_iter();
        Self {
            mode: self.mode + n_modes,
            within: within.map(|part| part.with_mode_after(n_modes)).collect(),
            ..self
        }
    }
}

/// Small boxes of the nodes of a mode, by place.
struct Lattice {
    /// First and last node with drops.
    low: [i32; 3],
    high: [i32; 3],
    /// Nodes along each axis of a small box.
    size: [i32; 3],
    /// Small boxes along each axis, one more at each end than there are nodes for: drops fade out
    /// over the voxel beyond the outermost nodes.
    counts: [i32; 3],
    /// Largest number density and mean square radius of the nodes that reach into each box.
    largest: Vec<(f64, f64)>,
}

impl Lattice {
    /// `None` if the mode has no drops.
    fn of_mode(mode: &DropMode) -> Option<Self> {
        let (low, high) = mode.node_range()?;
        let n: [i32; 3] = from_fn(|axis| high[axis] - low[axis] + 1);
        let size: [i32; 3] = from_fn(|axis| (n[axis] + MOST[axis] - 1) / MOST[axis]);
        let counts: [i32; 3] = from_fn(|axis| (n[axis] + size[axis] - 1) / size[axis] + 2);
        let n_boxes = counts.iter().map(|count| *count as usize).product();
        let mut lattice = Self {
            low,
            high,
            size,
            counts,
            largest: vec![(0.0, 0.0); n_boxes],
        };
        for (node, drops) in mode.nodes() {
            let number = f64::from(drops.number_density_m3);
            let square = AreaMoments::from_drops(&drops).extinction_m1_q1() / number;
            lattice.add(node, (number, square));
        }
        Some(lattice)
    }

    /// Adds a node to the boxes that its drops reach into: between nodes they are interpolated, so
    /// that a node on the border of two boxes belongs to both.
    fn add(&mut self, node: [i32; 3], (number, square): (f64, f64)) {
        let from_low = |axis: usize| node[axis] - self.low[axis];
        let above: [i32; 3] = from_fn(|axis| from_low(axis).div_euclid(self.size[axis]));
        let below: [i32; 3] = from_fn(|axis| (from_low(axis) - 1).div_euclid(self.size[axis]));
        for x in below[0]..=above[0] {
            for y in below[1]..=above[1] {
                for z in below[2]..=above[2] {
                    let index = self.index([x, y, z]);
                    let entry = &mut self.largest[index];
                    *entry = (entry.0.max(number), entry.1.max(square));
                }
            }
        }
    }

    /// Where a box stands in the list; the first place is -1.
    fn index(&self, place: [i32; 3]) -> usize {
        let [x, y, z] = place.map(|axis| axis + 1);
        ((x * self.counts[1] + y) * self.counts[2] + z) as usize
    }

    /// The box at a place.
    fn bounds(&self, mode: &DropMode, place: [i32; 3]) -> Aabb {
        let edge = |axis: usize, step: i32| {
            let node = self.low[axis] + (place[axis] + step) * self.size[axis];
            node.clamp(self.low[axis] - 1, self.high[axis] + 1)
        };
        Aabb {
            min: mode.node_position(from_fn(|axis| edge(axis, 0))),
            max: mode.node_position(from_fn(|axis| edge(axis, 1))),
        }
    }

    /// Places of all boxes, in order.
    fn places(&self) -> impl Iterator<Item = [i32; 3]> {
        let [n_x, n_y, n_z] = self.counts;
        let places = (-1..n_x - 1).flat_map(move |x| (-1..n_y - 1).map(move |y| (x, y)));
        places.flat_map(move |(x, y)| (-1..n_z - 1).map(move |z| [x, y, z]))
    }
}

/// The boxes of a mode.
pub(super) fn parts(mode: &DropMode, number: usize) -> Vec<DropPart> {
    let Some(lattice) = Lattice::of_mode(mode) else {
        return Vec::new();
    };
    let mut large: BTreeMap<[i32; 3], Vec<DropPart>> = BTreeMap::new();
    for place in lattice.places() {
        let (density, square) = lattice.largest[lattice.index(place)];
        if density > 0.0 {
            let part = DropPart {
                bounds: lattice.bounds(mode, place),
                max_extinction_m1_q1: density * square,
                mode: number,
                within: Vec::new(),
            };
            let place = place.map(|axis| axis.div_euclid(SMALL_IN_LARGE));
            large.entry(place).or_default().push(part);
        }
    }
    large.into_values().filter_map(together).collect()
}

/// A box of smaller ones.
fn together(within: Vec<DropPart>) -> Option<DropPart> {
    let union = |a: Aabb, b: Aabb| Aabb {
        min: a.min.min(b.min),
        max: a.max.max(b.max),
    };
    let bounds = within.iter().map(|part| part.bounds).reduce(union)?;
    let extinctions = || within.iter().map(|part| part.max_extinction_m1_q1);
    let smallest = extinctions().fold(f64::INFINITY, f64::min);
    let largest = extinctions().fold(0.0, f64::max);
    let is_full = within.len() as i32 == SMALL_IN_LARGE.pow(3);
    Some(DropPart {
        bounds,
        max_extinction_m1_q1: largest,
        mode: within.first()?.mode,
        within: if is_full && smallest >= EVEN * largest {
            Vec::new()
        } else {
            within
        },
    })
}

/// The smallest boxes.
#[cfg(test)]
pub(super) fn leaves(parts: &[DropPart]) -> Vec<&DropPart> {
    fn of_part(part: &DropPart) -> Vec<&DropPart> {
        if part.within.is_empty() {
            vec![part]
        } else {
            leaves(&part.within)
        }
    }
    parts.iter().flat_map(of_part).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use niji_dropfield::Bricks;
    use niji_dropfield::Interpolation;

    use super::super::drop_summary::DropSummary;
    use crate::scene::Scene;

    use super::*;

    /// Every mode of the drops of a shipped scene, the summary of all of them.
    fn shipped(text: &str) -> (Vec<DropMode>, DropSummary) {
        let shape = Scene::from_toml(text).unwrap().drops.shape().unwrap();
        let volume = shape.volume().unwrap();
        let summary = DropSummary::of_volume(&volume).unwrap();
        (volume.modes, summary)
    }

    #[test]
    fn parts_bound_the_extinction_everywhere() {
        let (modes, summary) = shipped(include_str!(
            "../../../../data/scenes/paper-c-figure-4.toml"
        ));
        let bricks = Bricks::build(&modes[0], Interpolation::RadiusDensity).unwrap();
        let leaves = leaves(&summary.parts);
        let mut covered = 0;
        for index in 0..20_000_u32 {
            // A lattice that hits no node, half a voxel beyond the box on every side.
            let part = |step: u32, n: u32| f64::from(index / step % n) / f64::from(n);
            let place = DVec3::new(part(1, 19), part(19, 53), part(19 * 53, 19));
            let point = summary.min_m + place * (summary.max_m - summary.min_m);
            let found = f64::from(bricks.sample(point).moments().extinction_m1_q1() as f32);
            let inside = leaves.iter().filter(|part| part.bounds.contains(point));
            let bound = inside
                .map(|part| part.max_extinction_m1_q1)
                .fold(0.0, f64::max);
            assert!(found <= bound * (1.0 + 1e-5), "{point}: {found} {bound}");
            covered += u32::from(found > 0.0);
        }
        assert!(covered > 10_000);
    }

    #[test]
    fn an_even_volume_needs_no_small_boxes_and_a_large_box_holds_its_own() {
        let (_, even) = shipped(include_str!(
            "../../../../data/scenes/rain-shaft-5-mm-h.toml"
        ));
        assert!(
            even.parts
                .iter()
                .filter(|part| part.within.is_empty())
                .count()
                > 10
        );
        let (_, fall) = shipped(include_str!("../../../../data/scenes/waterfall-gorge.toml"));
        for large in &fall.parts {
            for small in &large.within {
                assert!(small.max_extinction_m1_q1 <= large.max_extinction_m1_q1);
                assert!(large.bounds.contains(small.bounds.min));
                assert!(large.bounds.contains(small.bounds.max));
                assert_eq!(small.mode, large.mode);
            }
        }
    }
}
