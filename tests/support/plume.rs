//! Plumes in a wind as numbered volumes of another program: densities, or drops whose sizes vary.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "each test target uses its own part, and a test may panic"
)]

use std::fs::File;
use std::path::Path;

use glam::DVec3;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

/// Edge of a voxel, and the lowest corner (m).
const VOXEL_M: f64 = 4.0;
const CORNER_M: [f64; 3] = [-62.0, 0.0, -160.0];
/// Nodes along each axis.
const NODES: [i32; 3] = [32, 24, 24];

/// A plume that grows from nothing and is blown aside.
#[derive(Clone, Copy)]
pub struct Plume {
    /// Its height (m).
    pub top_m: f64,
    /// Where its swirls are in their rise (rad).
    pub phase_rad: f64,
}

impl Plume {
    /// That of a frame of so many: the first has none, and it grows slowest at both ends.
    pub fn at(frame: u32, n_frames: u32) -> Self {
        let t = f64::from(frame - 1) / f64::from(n_frames - 1);
        Self {
            top_m: 90.0 * t * t * (3.0 - 2.0 * t),
            phase_rad: 9.0 * t,
        }
    }

    /// Its density at a place above the lowest corner (m), 0 to 1.
    pub fn density(&self, at_m: DVec3) -> f64 {
        let below_top = ((self.top_m - at_m.y) / (2.0 * VOXEL_M)).clamp(0.0, 1.0);
        let (x, z) = (at_m.x - 48.0 - 0.15 * at_m.y, at_m.z - 48.0);
        let width_m = 16.0 + 0.3 * at_m.y;
        let swirl = (0.12 * at_m.y - self.phase_rad + z.atan2(x)).sin();
        let across = (-(x * x + z * z) / (width_m * width_m)).exp();
        // Thin edges end, so that boxes grow with it.
        let density = below_top * across * (1.0 + 0.4 * swirl) / 1.4;
        if density < 0.01 { 0.0 } else { density }
    }

    /// Writes it as one grid.
    pub fn write_density(&self, path: &Path) {
        write(path, &[("density", &|at_m| self.density(at_m))]);
    }

    /// Writes it as drops of a radius (um) at each of its places.
    pub fn write_drops(&self, path: &Path, radius_um: impl Fn(DVec3) -> f64) {
        // A square centimetre of drops in a cubic metre, at most.
        let number = |at_m| {
            let radius_m = 1e-6 * radius_um(at_m);
            0.01 * self.density(at_m) / (std::f64::consts::PI * radius_m * radius_m)
        };
        let radius = |at_m| match self.density(at_m) {
            0.0 => 0.0,
            _ => 1e-6 * radius_um(at_m),
        };
        write(
            path,
            &[("number_density", &number), ("effective_radius", &radius)],
        );
    }
}

type Field<'a> = &'a dyn Fn(DVec3) -> f64;

/// Writes fields as fog volumes, their values at places above the lowest corner.
fn write(path: &Path, fields: &[(&str, Field)]) {
    let grids = fields.iter().map(|(name, field)| {
        let tree = FloatTree::from_leaves(0.0, leaves(field)).unwrap();
        let corner = DVec3::from(CORNER_M);
        let transform = Transform::uniform_scale_translate(VOXEL_M, corner);
        Grid::new(*name, FOG_VOLUME, transform, tree)
    });
    let file = VdbFile::new(grids.collect());
    file.write(File::create(path).unwrap(), Compression::None)
        .unwrap();
}

fn leaves(field: Field) -> Vec<Leaf<f32>> {
    let mut leaves = Vec::new();
    let starts = |axis: usize| (0..NODES[axis]).step_by(8);
    for x in starts(0) {
        for (y, z) in starts(1).flat_map(|y| starts(2).map(move |z| (y, z))) {
            let mut leaf = Leaf::new([x, y, z], 0.0);
            for voxel in 0..512 {
                let at = [x + voxel / 64, y + voxel / 8 % 8, z + voxel % 8];
                let value = field(VOXEL_M * DVec3::from(at.map(f64::from)));
                if value > 0.0 {
                    leaf.set(at, value as f32);
                }
            }
            leaves.push(leaf);
        }
    }
    leaves.retain(|leaf| leaf.mask.iter().any(|word| *word != 0));
    leaves
}
