//! Our side of the comparison of samplers that `tests/peers/vdb_sampling.py` runs.
//!
//! Reads a drop volume, lays it out as bricks and samples it at the points that `vdb_sampling.cc`
//! samples. For each order of the points it prints: name, order, nanoseconds for a sample (best of
//! nine), sum of the number densities. Voxels are 1 m and drops 0.1 mm, so that points are indices
//! and the number density is M2 over the squared radius.

use std::error::Error;
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use glam::Vec3;
use niji_dropfield::Bricks;
use niji_dropfield::DropVolume;
use niji_dropfield::Interpolation;
use niji_vdb::VdbFile;

const N_POINTS: usize = 1 << 22;
const N_REPEATS: usize = 9;
const STRETCH: usize = 1 << 14;
/// Between the points of a line, in voxels.
const STEP: f32 = 0.5;
/// Square of the radius of all drops (um²).
const RADIUS_SQUARED_UM2: f64 = 1e4;

/// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }
}

/// A point in a random leaf.
fn point(random: &mut Random, leaves: &[Vec3]) -> Vec3 {
    let leaf = leaves[(random.next() % leaves.len() as u64) as usize];
    let (x, y, z) = (random.unit(), random.unit(), random.unit());
    leaf + 7.0 * Vec3::new(x, y, z)
}

fn scattered(leaves: &[Vec3]) -> Vec<Vec3> {
    let mut random = Random(1);
    (0..N_POINTS).map(|_| point(&mut random, leaves)).collect()
}

/// Along lines from one such point to another.
fn coherent(leaves: &[Vec3]) -> Vec<Vec3> {
    let mut random = Random(2);
    let mut points = Vec::with_capacity(N_POINTS);
    while points.len() < N_POINTS {
        let (from, to) = (point(&mut random, leaves), point(&mut random, leaves));
        let length = (to - from).length();
        let n_steps = (length / STEP).ceil() as usize;
        let line = (0..n_steps).map(|n| from + n as f32 * (STEP / length) * (to - from));
        points.extend(line.take(N_POINTS - points.len()));
    }
    points
}

/// Short stretches of points, each at its best: other programs on the machine then hardly count.
fn time(name: &str, order: &str, points: &[Vec3], m2_at: impl Fn(DVec3) -> f64) {
    let mut best = vec![f64::INFINITY; points.len() / STRETCH];
    let mut sum = 0.0;
    for _ in 0..N_REPEATS {
        sum = 0.0;
        for (best, stretch) in best.iter_mut().zip(points.chunks_exact(STRETCH)) {
            let start = Instant::now();
            sum += stretch.iter().map(|at| m2_at(at.as_dvec3())).sum::<f64>();
            *best = start.elapsed().as_secs_f64().min(*best);
        }
    }
    let nanoseconds = 1e9 * best.iter().sum::<f64>() / points.len() as f64;
    println!("{name} {order} {nanoseconds} {}", sum / RADIUS_SQUARED_UM2);
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("usage: sampling_speed FILE")?;
    let file = VdbFile::read(Path::new(&path))?;
    let number = file.grid("number_density").ok_or("no number_density")?;
    let tree = number.tree.as_float().ok_or("number_density is no float")?;
    let leaves = tree
        .leaves()
        .iter()
        .map(|leaf| leaf.origin.map(|axis| axis as f32));
    let leaves = leaves.map(Vec3::from).collect::<Vec<_>>();
    let volume = DropVolume::from_vdb(&file)?;
    let bricks = Bricks::build(&volume.modes[0], Interpolation::Moments)?;
    for (order, points) in [
        ("coherent", coherent(&leaves)),
        ("random", scattered(&leaves)),
    ] {
        let four = |at| f64::from(black_box(bricks.sample(at)).m2);
        let one = |at| f64::from(bricks.m2(at));
        time("bricks4", order, &points, four);
        time("bricks", order, &points, one);
    }
    eprintln!(
        "{} bricks, {} MB",
        bricks.n_bricks(),
        bricks.memory_bytes() >> 20
    );
    Ok(())
}
