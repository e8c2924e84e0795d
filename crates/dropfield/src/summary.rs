//! What a person wants to know about a drop volume: water, extinction, sizes, optical depth.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::AreaMoments;
use crate::DropMode;
use crate::DropVolume;
use crate::Drops;
use crate::Warning;
use crate::mode::LEAF_NODES;

/// Figures of a drop volume. The modes of a volume may lie on different lattices, so that maxima of
/// sums are not known exactly: they are sums of the modes' maxima, exact for one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct VolumeSummary {
    /// Lowest corner of the box outside of which there are no drops (m).
    pub min_m: DVec3,
    /// Highest corner (m).
    pub max_m: DVec3,
    /// Nodes that have drops.
    pub n_nodes: u64,
    /// Drops in the whole volume.
    pub total_drops: f64,
    /// Liquid water in the whole volume (g).
    pub total_water_g: f64,
    /// Largest liquid water content of a node (g/m³).
    pub max_liquid_water_g_m3: f64,
    /// Mean liquid water content over the nodes that have drops (g/m³).
    pub mean_liquid_water_g_m3: f64,
    /// Largest extinction of a node without diffraction (1/m).
    pub max_extinction_m1_q1: f64,
    /// Smallest and largest effective radius of a node (um).
    pub effective_radius_um: (f64, f64),
    /// Smallest and largest effective variance of a node.
    pub effective_variance: (f64, f64),
    /// Smallest and largest number density of a node that has drops (1/m³).
    pub number_density_m3: (f64, f64),
    /// Optical depth without diffraction along x, y and z, each of the line of nodes where it is
    /// largest.
    pub optical_depth_q1: [f64; 3],
    /// What is outside the range of nature.
    pub warnings: Vec<Warning>,
}

impl DropVolume {
    /// Figures of the volume; without any drops all of them are 0.
    pub fn summary(&self) -> VolumeSummary {
        let modes: Vec<VolumeSummary> = self.modes.iter().filter_map(summarize_mode).collect();
        let sum = modes
            .into_iter()
            .reduce(|a, b| combine(&a, &b))
            .unwrap_or_else(empty);
        let optical_depth = sum.optical_depth_q1.into_iter().fold(0.0, f64::max);
        VolumeSummary {
            warnings: Warning::of_volume(self, optical_depth),
            ..sum
        }
    }
}

fn empty() -> VolumeSummary {
    VolumeSummary {
        min_m: DVec3::ZERO,
        max_m: DVec3::ZERO,
        n_nodes: 0,
        total_drops: 0.0,
        total_water_g: 0.0,
        max_liquid_water_g_m3: 0.0,
        mean_liquid_water_g_m3: 0.0,
        max_extinction_m1_q1: 0.0,
        effective_radius_um: (0.0, 0.0),
        effective_variance: (0.0, 0.0),
        number_density_m3: (0.0, 0.0),
        optical_depth_q1: [0.0; 3],
        warnings: Vec::new(),
    }
}

pub(crate) fn wider(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

fn combine(a: &VolumeSummary, b: &VolumeSummary) -> VolumeSummary {
    let n_nodes = a.n_nodes + b.n_nodes;
    let water = |mode: &VolumeSummary| mode.mean_liquid_water_g_m3 * mode.n_nodes as f64;
    VolumeSummary {
        min_m: a.min_m.min(b.min_m),
        max_m: a.max_m.max(b.max_m),
        n_nodes,
        total_drops: a.total_drops + b.total_drops,
        total_water_g: a.total_water_g + b.total_water_g,
        max_liquid_water_g_m3: a.max_liquid_water_g_m3 + b.max_liquid_water_g_m3,
        mean_liquid_water_g_m3: (water(a) + water(b)) / n_nodes as f64,
        max_extinction_m1_q1: a.max_extinction_m1_q1 + b.max_extinction_m1_q1,
        effective_radius_um: wider(a.effective_radius_um, b.effective_radius_um),
        effective_variance: wider(a.effective_variance, b.effective_variance),
        number_density_m3: wider(a.number_density_m3, b.number_density_m3),
        optical_depth_q1: std::array::from_fn(|axis| {
            a.optical_depth_q1[axis] + b.optical_depth_q1[axis]
        }),
        warnings: Vec::new(),
    }
}

/// Figures of a mode; `None` if it has no drops.
fn summarize_mode(mode: &DropMode) -> Option<VolumeSummary> {
    let (low, high) = mode.node_range()?;
    let mut sum = VolumeSummary {
        min_m: mode.node_position(low) - mode.voxel_m(),
        max_m: mode.node_position(high) + mode.voxel_m(),
        effective_radius_um: (f64::INFINITY, 0.0),
        effective_variance: (f64::INFINITY, 0.0),
        number_density_m3: (f64::INFINITY, 0.0),
        optical_depth_q1: [0, 1, 2].map(|axis| max_optical_depth_q1(mode, axis)),
        ..empty()
    };
    let mut drops_per_m3 = 0.0;
    let mut water_g_m3 = 0.0;
    for (_, drops) in mode.nodes() {
        let moments = AreaMoments::from_drops(&drops);
        let number = f64::from(drops.number_density_m3);
        let radius_um = 1e6 * f64::from(drops.effective_radius_m);
        let variance = f64::from(drops.effective_variance);
        let water = moments.liquid_water_g_m3();
        drops_per_m3 += number;
        water_g_m3 += water;
        sum.n_nodes += 1;
        sum.max_liquid_water_g_m3 = sum.max_liquid_water_g_m3.max(water);
        sum.max_extinction_m1_q1 = sum.max_extinction_m1_q1.max(moments.extinction_m1_q1());
        sum.effective_radius_um = wider(sum.effective_radius_um, (radius_um, radius_um));
        sum.effective_variance = wider(sum.effective_variance, (variance, variance));
        sum.number_density_m3 = wider(sum.number_density_m3, (number, number));
    }
    let voxel_m3 = mode.voxel_m().powi(3);
    sum.total_drops = drops_per_m3 * voxel_m3;
    sum.total_water_g = water_g_m3 * voxel_m3;
    sum.mean_liquid_water_g_m3 = water_g_m3 / sum.n_nodes as f64;
    Some(sum)
}

/// Largest optical depth over the lines of nodes along an axis. The trilinear field is largest on
/// such a line, and its integral there is the sum over the nodes times the voxel.
pub(crate) fn max_optical_depth_q1(mode: &DropMode, axis: usize) -> f64 {
    let extinction = |drops: &Drops| AreaMoments::from_drops(drops).extinction_m1_q1();
    largest_line_sum(mode, axis, extinction) * mode.voxel_m()
}

/// Largest sum of a quantity over the nodes of a line along an axis.
fn largest_line_sum(mode: &DropMode, axis: usize, quantity: impl Fn(&Drops) -> f64) -> f64 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns: BTreeMap<[i32; 2], [f64; 64]> = BTreeMap::new();
    for leaf in mode.leaves() {
        let column = columns
            .entry([leaf.origin[u], leaf.origin[v]])
            .or_insert([0.0; 64]);
        for place in 0..LEAF_NODES {
            let inside = [place >> 6, place >> 3 & 7, place & 7];
            column[inside[u] << 3 | inside[v]] += quantity(&leaf.drops[place]);
        }
    }
    columns
        .values()
        .flatten()
        .fold(0.0, |max: f64, sum| max.max(*sum))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridBox;

    fn slab(name: &str, number_density_m3: f32, radius_um: f32) -> DropMode {
        let grid = GridBox {
            min: DVec3::ZERO,
            max: DVec3::new(40.0, 20.0, 10.0),
            voxel_m: 2.0,
        };
        let effective_radius_m = 1e-6 * radius_um;
        let drops = Drops {
            number_density_m3,
            effective_radius_m,
            effective_variance: 0.0,
        };
        DropMode::from_fn(name, &grid, |_| drops).unwrap()
    }

    fn summary(modes: Vec<DropMode>) -> VolumeSummary {
        DropVolume { modes }.summary()
    }

    #[test]
    fn a_box_of_known_drops_has_known_figures() {
        // 1e8 drops of 10 um: pi 1e-2 /m, (4/3) pi 1e-1 g/m³.
        let found = summary(vec![slab("", 1e8, 10.0)]);
        let sigma = 0.031_415_926_5;
        assert!((found.max_extinction_m1_q1 / sigma - 1.0).abs() < 1e-6);
        for (axis, length_m) in [(0, 40.0), (1, 20.0), (2, 10.0)] {
            assert!((found.optical_depth_q1[axis] / (sigma * length_m) - 1.0).abs() < 1e-6);
        }
        assert!((found.max_liquid_water_g_m3 / 0.418_879 - 1.0).abs() < 1e-6);
        assert!((found.mean_liquid_water_g_m3 / found.max_liquid_water_g_m3 - 1.0).abs() < 1e-9);
        assert!((found.total_drops / 8e11 - 1.0).abs() < 1e-6);
        assert!((found.total_water_g / (8e3 * 0.418_879) - 1.0).abs() < 1e-6);
        assert_eq!(
            (found.n_nodes, found.effective_variance),
            (20 * 10 * 5, (0.0, 0.0))
        );
        // One voxel beyond the outermost nodes, half of one beyond the box.
        assert_eq!(
            (found.min_m, found.max_m),
            (DVec3::splat(-1.0), DVec3::new(41.0, 21.0, 11.0))
        );
        assert_eq!(found.warnings, []);
    }

    #[test]
    fn optical_depth_is_that_of_the_densest_line() {
        let grid = GridBox {
            min: DVec3::ZERO,
            max: DVec3::splat(16.0),
            voxel_m: 1.0,
        };
        // A rod along y through x = 3.5, z = 4.5 in very thin air.
        let rod = |position: DVec3| (position.x - 3.5).hypot(position.z - 4.5) < 0.1;
        let mode = DropMode::from_fn("", &grid, |position| Drops {
            number_density_m3: if rod(position) { 1e9 } else { 1e3 },
            effective_radius_m: 1e-5,
            effective_variance: 0.0,
        })
        .unwrap();
        let [x, y, z] = summary(vec![mode]).optical_depth_q1;
        assert!((y / (16.0 * 0.314_159_27) - 1.0).abs() < 1e-6);
        assert!((x / 0.314_164 - 1.0).abs() < 1e-4 && (z / 0.314_164 - 1.0).abs() < 1e-4);
    }

    #[test]
    fn modes_add() {
        let (rain, mist) = (slab("rain", 1000.0, 500.0), slab("mist", 1e8, 10.0));
        let (one, other) = (summary(vec![rain.clone()]), summary(vec![mist.clone()]));
        let both = summary(vec![rain, mist]);
        assert_eq!(both.n_nodes, 2000);
        let sum = one.max_extinction_m1_q1 + other.max_extinction_m1_q1;
        assert!((both.max_extinction_m1_q1 - sum).abs() < 1e-12);
        assert!((both.total_water_g - one.total_water_g - other.total_water_g).abs() < 1e-6);
        assert!((both.effective_radius_um.0 - 10.0).abs() < 1e-4);
        assert!((both.effective_radius_um.1 - 500.0).abs() < 1e-3);
    }

    /// Warnings about a mode, as a person reads them.
    fn said(mode: DropMode) -> Vec<String> {
        let warnings = summary(vec![mode]).warnings;
        warnings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn fourteen_grams_of_water_are_more_than_the_air_holds() {
        // 1000 drops of 1.5 mm a cubic metre.
        let flood = said(slab("big", 1000.0, 1500.0));
        assert!(flood[0].starts_with("big: 14.14 g/m³"), "{flood:?}");
        assert_eq!(
            flood.len(),
            1,
            "flat drops are what rain is made of: {flood:?}"
        );
    }

    #[test]
    fn fog_of_a_thousand_drops_a_cubic_metre_is_too_thin_to_see() {
        let fog = said(slab("", 1000.0, 10.0));
        assert!(
            fog.len() == 2 && fog[0].contains("fog") && fog[1].contains("hardly"),
            "{fog:?}"
        );
    }

    #[test]
    fn what_nature_does_not_make_is_said() {
        let giants = said(slab("", 0.1, 4000.0));
        assert!(
            giants[0].contains("larger drops than 2 mm break up"),
            "{giants:?}"
        );
        let milk = said(slab("", 1e10, 10.0));
        assert!(
            milk.iter().any(|text| text.contains("outermost")),
            "{milk:?}"
        );
        let metres = said(slab("", 1000.0, 1e-4));
        assert!(metres[0].contains("micrometres"), "{metres:?}");
        assert_eq!(said(slab("", 1000.0, 300.0)), Vec::<String>::new());
    }

    #[test]
    fn an_empty_volume_has_no_figures_and_says_so() {
        for found in [summary(vec![]), summary(vec![slab("", 0.0, 10.0)])] {
            assert_eq!((found.n_nodes, found.total_drops), (0, 0.0));
            assert_eq!(found.warnings, [Warning::Empty]);
        }
    }
}
