//! Writes a ball of fog as OpenVDB, reads it back and says what is in it:
//! `cargo run --release -p niji-vdb --example read-and-write -- ball.vdb`.

use std::fs::File;
use std::io::BufWriter;
use std::io::Write;
use std::path::Path;

use glam::DVec3;
use niji_vdb::Compression;
use niji_vdb::FOG_VOLUME;
use niji_vdb::FloatTree;
use niji_vdb::Grid;
use niji_vdb::LEAF_DIM;
use niji_vdb::LEAF_VOXELS;
use niji_vdb::Leaf;
use niji_vdb::Transform;
use niji_vdb::VdbFile;

/// Radius of the ball in voxels.
const RADIUS: i32 = 24;
const VOXEL_M: f64 = 0.5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let argument = std::env::args()
        .nth(1)
        .ok_or("expected the name of a file to write")?;
    let path = Path::new(&argument);

    // A grid has a name, a class, a place in the world, and a tree of leaves of 8 x 8 x 8 voxels.
    let tree = FloatTree::from_leaves(0.0, ball())?;
    let place = Transform::uniform_scale_translate(VOXEL_M, DVec3::new(0.0, 10.0, -30.0));
    let file = VdbFile::new(vec![Grid::new("density", FOG_VOLUME, place, tree)]);
    file.write(BufWriter::new(File::create(path)?), Compression::Zip)?;

    let file = VdbFile::read(path)?;
    let mut out = std::io::stdout().lock();
    for grid in &file.grids {
        let Some(tree) = grid.tree.as_float() else {
            continue;
        };
        writeln!(
            out,
            "{}: {} active voxels",
            grid.name,
            tree.active_voxel_count()
        )?;
        writeln!(
            out,
            "in the middle {}, outside {}",
            tree.get([0; 3]),
            tree.get([99; 3])
        )?;
    }
    Ok(())
}

/// Leaves with a density that falls from 1 in the middle to 0 at the edge; empty ones are left out.
fn ball() -> Vec<Leaf<f32>> {
    let along = (-RADIUS..RADIUS).step_by(LEAF_DIM as usize);
    let mut leaves = Vec::new();
    for x in along.clone() {
        for y in along.clone() {
            leaves.extend(along.clone().map(|z| leaf([x, y, z])));
        }
    }
    leaves.retain(|leaf| leaf.active_count() > 0);
    leaves
}

fn leaf(origin: [i32; 3]) -> Leaf<f32> {
    let mut leaf = Leaf::new(origin, 0.0);
    for index in 0..LEAF_VOXELS {
        let voxel = leaf.voxel(index);
        let distance = DVec3::from(voxel.map(f64::from)).length() / f64::from(RADIUS);
        if distance < 1.0 {
            // Files hold f32: smoke needs no more.
            leaf.set(voxel, (1.0 - distance) as f32);
        }
    }
    leaf
}
