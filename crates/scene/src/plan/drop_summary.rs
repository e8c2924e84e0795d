//! What a plan needs to know of the drops: their box, extinction and sizes.

use std::collections::HashMap;

use glam::DVec3;
use niji_dropfield::DropMode;
use niji_dropfield::DropVolume;
use niji_dropfield::GridBox;
use niji_dropfield::LawShare;
use niji_dropfield::mixture_variance;
use niji_droplets::Shape;
use niji_geometry::Aabb;

use crate::drops::Drops;

use super::drop_file;
use super::drop_parts::DropPart;
use super::drop_parts::parts;
use super::laws_in_light::LawsInLight;

/// Figures of drops: of shapes before they are laid out, or of files after they were read.
#[derive(Debug, Clone, PartialEq)]
pub struct DropSummary {
    /// Lowest corner of the box outside of which there are no drops (m).
    pub min_m: DVec3,
    /// Highest corner (m).
    pub max_m: DVec3,
    /// Edge length of a voxel, of several modes the smallest (m).
    pub voxel_m: f64,
    /// Nodes with drops, at most.
    pub n_nodes: u64,
    /// Size of its VDB file, bytes; of a shape that was not laid out at most, of drops that were joined
    /// about.
    pub file_bytes: u64,
    /// Largest extinction without diffraction (1/m).
    pub max_extinction_m1_q1: f64,
    /// Smallest and largest effective radius (um).
    pub effective_radius_um: (f64, f64),
    /// Smallest and largest effective variance, mixtures between nodes included.
    pub effective_variance: (f64, f64),
    /// Their laws and what light is theirs.
    pub laws: LawsInLight,
    /// Boxes that hold all drops, each with the largest extinction in it.
    pub parts: Vec<DropPart>,
}

/// Shapes with more nodes than this are not laid out for a plan.
const MAX_NODES_LAID_OUT: u64 = 1_000_000;

/// Roundoff of the f32 numbers of a node: figures that near to a shape's own are its own.
const NODE_ROUNDOFF: f64 = 1e-6;

impl DropSummary {
    /// Figures of a shape; `None` if it is not valid or has no drops. Shapes of up to a million nodes
    /// are laid out to find where the drops are, larger ones count as full and as mixed throughout.
    pub fn of_shape(shape: &Shape) -> Option<Self> {
        Self::laid_out(shape)?.0
    }

    /// The same, and the volume where the shape is laid out; `None` if it is not valid.
    pub fn laid_out(shape: &Shape) -> Option<(Option<Self>, Option<DropVolume>)> {
        // What a fountain knows of itself comes from laying it out, each figure anew.
        if matches!(shape, Shape::Fountain(_)) {
            let volume = shape.volume().ok()?;
            let of_volume = Self::of_volume(&volume).and_then(|found| {
                let bounds = box_of(&shape.grid())?;
                Some(Self {
                    min_m: bounds.min,
                    max_m: bounds.max,
                    max_extinction_m1_q1: volume.summary().max_extinction_m1_q1,
                    ..found
                })
            });
            return Some((of_volume, Some(volume)));
        }
        let own_variance = shape.effective_variance_range();
        let whole = Self::in_closed_form(shape, own_variance)?;
        if whole.n_nodes > MAX_NODES_LAID_OUT {
            return Some((Some(whole), None));
        }
        let volume = shape.volume().ok()?;
        let of_volume = Self::of_volume(&volume).map(|found| Self {
            effective_radius_um: snapped(found.effective_radius_um, whole.effective_radius_um),
            effective_variance: snapped(found.effective_variance, own_variance),
            laws: found.laws,
            parts: found.parts,
            n_nodes: found.n_nodes,
            file_bytes: found.file_bytes,
            ..whole
        });
        Some((of_volume, Some(volume)))
    }

    /// Figures of drops that are shapes; `None` if any of them is none, or if all are without drops.
    pub fn of_shapes(drops: &Drops) -> Option<Self> {
        let shapes = drops.populations().iter().map(|it| it.source.shape());
        let shapes: Vec<Shape> = shapes.collect::<Option<_>>()?;
        Self::joined(shapes.iter().filter_map(Self::of_shape))
    }

    /// Figures of several drops in one air; `None` of none.
    pub fn joined(summaries: impl IntoIterator<Item = Self>) -> Option<Self> {
        let summaries: Vec<Self> = summaries.into_iter().collect();
        // In each place are those whose boxes meet there.
        let together = |one: &Self| -> f64 {
            let others = summaries.iter().filter(|other| one.meets(other));
            others.map(|other| other.max_extinction_m1_q1).sum()
        };
        let max_extinction_m1_q1 = summaries.iter().map(together).fold(0.0, f64::max);
        let whole = summaries.into_iter().reduce(Self::beside)?;
        Some(Self {
            max_extinction_m1_q1,
            ..whole
        })
    }

    /// Figures that hold for any of several frames; where their drops are is told by the box of all.
    pub(super) fn of_any<'a>(first: &'a Self, others: impl Iterator<Item = &'a Self>) -> Self {
        let mut any = others.fold(first.clone(), |any, other| Self {
            n_nodes: any.n_nodes.max(other.n_nodes),
            file_bytes: any.file_bytes.max(other.file_bytes),
            max_extinction_m1_q1: any.max_extinction_m1_q1.max(other.max_extinction_m1_q1),
            ..any.clone().beside(other.clone())
        });
        any.parts = vec![DropPart {
            bounds: any.bounds(),
            max_extinction_m1_q1: any.max_extinction_m1_q1,
            mode: 0,
            within: Vec::new(),
        }];
        any
    }

    /// Whether the boxes of both have a place in common.
    fn meets(&self, other: &Self) -> bool {
        self.min_m.cmple(other.max_m).all() && other.min_m.cmple(self.max_m).all()
    }

    /// With others beside them, whose modes are numbered after one's own.
    fn beside(self, other: Self) -> Self {
        let wider = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        let n_modes = self.parts.iter().map(|part| part.mode + 1).max();
        let others = other.parts.into_iter();
        let others = others.map(|part| part.with_mode_after(n_modes.unwrap_or(0)));
        Self {
            min_m: self.min_m.min(other.min_m),
            max_m: self.max_m.max(other.max_m),
            voxel_m: self.voxel_m.min(other.voxel_m),
            n_nodes: self.n_nodes + other.n_nodes,
            file_bytes: self.file_bytes + other.file_bytes - drop_file::FILE_BYTES,
            max_extinction_m1_q1: self.max_extinction_m1_q1 + other.max_extinction_m1_q1,
            effective_radius_um: wider(self.effective_radius_um, other.effective_radius_um),
            effective_variance: wider(self.effective_variance, other.effective_variance),
            laws: self.laws.beside(other.laws),
            parts: self.parts.into_iter().chain(others).collect(),
        }
    }

    /// What a shape knows of itself before it is laid out. Its range of effective variances is handed
    /// over, because a fountain has to be laid out for it.
    fn in_closed_form(shape: &Shape, (narrowest, broadest): (f64, f64)) -> Option<Self> {
        let grid = shape.grid();
        let (counts, bounds) = (grid.n_nodes().ok()?, box_of(&grid)?);
        let n_nodes = counts
            .iter()
            .map(|count| u64::from(count.unsigned_abs()))
            .product();
        let max_extinction_m1_q1 = shape.max_extinction_m1_q1();
        let radii = shape.effective_radius_range_um();
        let variances = (narrowest, mixture_variance(radii, broadest));
        Some(Self {
            min_m: bounds.min,
            max_m: bounds.max,
            voxel_m: grid.voxel_m,
            n_nodes,
            file_bytes: drop_file::bytes_of_box(counts, broadest > 0.0),
            max_extinction_m1_q1,
            parts: vec![DropPart {
                bounds,
                max_extinction_m1_q1,
                mode: 0,
                within: Vec::new(),
            }],
            effective_radius_um: radii,
            effective_variance: variances,
            laws: LawsInLight::between(radii, variances),
        })
    }

    /// Figures of a volume; `None` if it has no drops.
    pub fn of_volume(volume: &DropVolume) -> Option<Self> {
        let summary = volume.summary();
        if summary.n_nodes == 0 {
            return None;
        }
        let voxels = volume.modes.iter().map(niji_dropfield::DropMode::voxel_m);
        let (low, high) = summary.effective_variance;
        let modes = volume.modes.iter().enumerate();
        let parts: Vec<DropPart> = modes
            .flat_map(|(number, mode)| parts(mode, number))
            .collect();
        let mixtures = volume.modes.iter().map(largest_mixture_variance);
        Some(Self {
            min_m: summary.min_m,
            max_m: summary.max_m,
            voxel_m: voxels.fold(f64::INFINITY, f64::min),
            n_nodes: summary.n_nodes,
            file_bytes: drop_file::bytes_of_volume(volume),
            // Between nodes that differ in both, interpolated radius and density may exceed them.
            max_extinction_m1_q1: parts
                .iter()
                .map(|part| part.max_extinction_m1_q1)
                .fold(summary.max_extinction_m1_q1, f64::max),
            parts,
            effective_radius_um: summary.effective_radius_um,
            effective_variance: (low, mixtures.fold(high, f64::max)),
            laws: LawsInLight::of_volume(volume),
        })
    }

    /// The same drops, each law one size.
    pub(super) fn without_spread(self) -> Self {
        let laws = self.laws.each(|law| LawShare {
            effective_variance: (0.0, 0.0),
            ..law
        });
        Self {
            effective_variance: (0.0, 0.0),
            laws,
            ..self
        }
    }

    /// The box outside of which there are no drops.
    pub fn bounds(&self) -> Aabb {
        Aabb {
            min: self.min_m,
            max: self.max_m,
        }
    }
}

/// The box of trilinear drops, which fade out over the voxel beyond the outermost nodes.
fn box_of(grid: &GridBox) -> Option<Aabb> {
    let n = DVec3::from(grid.n_nodes().ok()?.map(f64::from));
    let half = DVec3::splat(0.5 * grid.voxel_m);
    Some(Aabb {
        min: grid.min - half,
        max: grid.min + n * grid.voxel_m + half,
    })
}

/// The shape's own ends of a range, unless the nodes found others.
fn snapped(found: (f64, f64), own: (f64, f64)) -> (f64, f64) {
    let end = |found: f64, own: f64| {
        let is_near = (found - own).abs() <= NODE_ROUNDOFF * own.abs();
        if is_near { own } else { found }
    };
    (end(found.0, own.0), end(found.1, own.1))
}

/// Largest effective variance anywhere in a mode, between its nodes as well.
fn largest_mixture_variance(mode: &DropMode) -> f64 {
    let drops = || mode.nodes().map(|(_, drops)| drops);
    let whole = drops().fold(Sizes::NONE, Sizes::with);
    let n_nodes = drops().count() as u64;
    if whole.radius_um.0 >= whole.radius_um.1 || n_nodes > MAX_NODES_LAID_OUT {
        return mixture_variance(whole.radius_um, whole.variance);
    }
    let mut cells: HashMap<[i32; 3], Sizes> = HashMap::new();
    for (node, drops) in mode.nodes() {
        for corner in 0..8 {
            let cell = std::array::from_fn(|axis| node[axis] - (corner >> axis & 1));
            let sizes = cells.entry(cell).or_insert(Sizes::NONE);
            *sizes = sizes.with(drops);
        }
    }
    cells
        .values()
        .map(|sizes| mixture_variance(sizes.radius_um, sizes.variance))
        .fold(0.0, f64::max)
}

/// Smallest and largest effective radius of some nodes, and their largest effective variance.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    radius_um: (f64, f64),
    variance: f64,
}

impl Sizes {
    const NONE: Self = Self {
        radius_um: (f64::INFINITY, 0.0),
        variance: 0.0,
    };

    fn with(self, drops: niji_dropfield::Drops) -> Self {
        let radius_um = 1e6 * f64::from(drops.effective_radius_m);
        Self {
            radius_um: (
                self.radius_um.0.min(radius_um),
                self.radius_um.1.max(radius_um),
            ),
            variance: self.variance.max(f64::from(drops.effective_variance)),
        }
    }
}

#[cfg(test)]
mod tests {
    use niji_droplets::Axis;
    use niji_droplets::Gradient;
    use niji_sizes::MarshallPalmer;
    use niji_sizes::SizeLaw;

    use super::*;

    fn gradient(voxel_m: f64) -> Shape {
        Shape::Gradient(Gradient {
            box_min_m: [0.0; 3],
            box_max_m: [20.0, 64.0, 20.0],
            voxel_m,
            axis: Axis::Y,
            radius_at_min_um: 1500.0,
            radius_at_max_um: 10.0,
            number_density_at_min_m3: 1000.0,
            number_density_at_max_m3: 1000.0,
            effective_variance: 0.0,
        })
    }

    #[test]
    fn a_shape_and_its_volume_have_the_same_figures() {
        let shape = gradient(2.0);
        let before = DropSummary::in_closed_form(&shape, shape.effective_variance_range()).unwrap();
        let after = DropSummary::of_volume(&shape.volume().unwrap()).unwrap();
        assert_eq!((before.min_m, before.max_m), (after.min_m, after.max_m));
        assert_eq!(
            (before.n_nodes, before.voxel_m),
            (after.n_nodes, after.voxel_m)
        );
        assert!(before.max_extinction_m1_q1 >= after.max_extinction_m1_q1);
        assert!(before.effective_radius_um.0 <= after.effective_radius_um.0);
        assert!(before.effective_radius_um.1 >= after.effective_radius_um.1);
        assert!(before.effective_variance.1 >= after.effective_variance.1);
    }

    #[test]
    fn one_size_everywhere_keeps_the_numbers_of_the_shape() {
        // 1/3 and 513 um have no exact f32.
        let rain = Shape::Uniform(niji_droplets::Uniform {
            box_min_m: [0.0; 3],
            box_max_m: [8.0; 3],
            voxel_m: 1.0,
            law: SizeLaw::MarshallPalmer(MarshallPalmer::untruncated(5.0)),
            number_density_m3: None,
        });
        let summary = DropSummary::of_shape(&rain).unwrap();
        assert_eq!(
            summary.effective_radius_um,
            rain.effective_radius_range_um()
        );
        assert_eq!(summary.effective_variance, rain.effective_variance_range());
    }

    #[test]
    fn mixtures_of_a_gradient_spread_more_on_coarser_lattices() {
        let spread = |voxel_m| {
            DropSummary::of_shape(&gradient(voxel_m))
                .unwrap()
                .effective_variance
                .1
        };
        // Two sizes of ratio q have at most (q - 1)²/(4 q): the lowest two of the finest lattice are
        // 15.8 and 27.5 um.
        assert!((spread(0.5) - (27.461 - 15.82_f64).powi(2) / (4.0 * 27.461 * 15.82)).abs() < 5e-3);
        assert!(spread(8.0) > spread(2.0) && spread(8.0) < 0.49);
    }

    #[test]
    fn an_empty_volume_has_no_figures() {
        assert_eq!(
            DropSummary::of_volume(&DropVolume { modes: Vec::new() }),
            None
        );
    }
}
