//! Icebergs by chance: closed, plausible, floating at the right height.
//!
//! The surface is a distance r(u) from a middle for every direction u, so it is closed and never cuts
//! itself: a rounded body, cut by planes (calving leaves plane faces), raised by pinnacles, roughened
//! by fractal noise. It floats where the share of its volume above the water is
//!   1 - rho_ice/rho_sea = 1 - 917/1025
//! (Archimedes; densities in kg/m³ of glacier ice and of sea water at 0 C). That it would also stay
//! upright is not asked for.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;
use niji_geometry::TriangleMesh;
use niji_geometry::direction_from_azimuth_elevation;
use niji_radiometry::Radians;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::error::check_range;
use crate::noise::fractal_noise;
use crate::sampler::hash;

/// Density of ice over that of sea water.
const DENSITY_RATIO: f64 = 917.0 / 1025.0;
/// An octahedron is split so often: 8 x 4^7 = 131072 triangles.
const N_SPLITS: u32 = 7;
/// Planes that cut the body.
const N_CUTS: u32 = 14;
/// Pinnacles on top.
const N_PINNACLES: u32 = 4;

/// An iceberg.
///
/// ```
/// use niji_ice::Iceberg;
///
/// let berg = Iceberg { length_m: 80.0, seed: 7, ruggedness: 0.5 }.mesh()?;
/// let bounds = berg.bounds();
/// assert!((bounds.size().x.max(bounds.size().z) - 80.0).abs() < 1e-6);
/// // It floats: most of it is below the water line, y = 0.
/// assert!(bounds.max.y > 0.0 && bounds.min.y < -bounds.max.y);
/// # Ok::<(), niji_ice::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Iceberg {
    /// Longest horizontal extent, under water too, m.
    #[schemars(range(min = 0.01, max = 1e5))]
    pub length_m: f64,
    /// Another seed is another iceberg.
    #[serde(default)]
    pub seed: u32,
    /// How rough it is, 0 smooth to 1 torn.
    #[serde(default = "usual_ruggedness")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub ruggedness: f64,
}

fn usual_ruggedness() -> f64 {
    0.5
}

impl Iceberg {
    /// Checks the ranges.
    ///
    /// # Errors
    /// A length that is not 0.01 m to 100 km, or a ruggedness outside 0..1.
    pub fn check(&self) -> Result<(), Error> {
        check_range("length_m", self.length_m, [0.01, 1e5], "0.01 to 100000")?;
        check_range("ruggedness", self.ruggedness, [0.0, 1.0], "0 to 1")
    }

    /// Its surface, the water line at y = 0, its middle above the origin.
    ///
    /// # Errors
    /// As [`Iceberg::check`].
    pub fn mesh(&self) -> Result<TriangleMesh, Error> {
        self.check()?;
        let (directions, triangles) = split_octahedron(N_SPLITS);
        let form = Form::new(self.seed, self.ruggedness);
        let corners: Vec<DVec3> = directions.iter().map(|&u| form.radius(u) * u).collect();
        let mesh = TriangleMesh::new(&corners, &triangles)?;
        let water_y = water_line(&mesh);
        let bounds = mesh.bounds();
        let scale = self.length_m / bounds.size().x.max(bounds.size().z);
        let middle = 0.5 * (bounds.min + bounds.max);
        let origin = DVec3::new(middle.x, water_y, middle.z);
        Ok(mesh.moved(|corner| (corner - origin) * scale)?)
    }
}

/// What makes up the shape.
struct Form {
    seed: u32,
    ruggedness: f64,
    /// Unit normals and distances.
    cuts: Vec<(DVec3, f64)>,
    /// Directions, heights and sharpnesses.
    pinnacles: Vec<(DVec3, f64, f64)>,
}

impl Form {
    fn new(seed: u32, ruggedness: f64) -> Self {
        let random = |index: u32| f64::from(hash(hash(seed) ^ index)) / f64::from(u32::MAX);
        let direction = |azimuth: f64, elevation_rad: f64| {
            direction_from_azimuth_elevation(Radians(TAU * azimuth), Radians(elevation_rad))
        };
        let cuts = (0..N_CUTS).map(|k| {
            let [azimuth, slope, depth] = [0, 1, 2].map(|i| random(100 + 3 * k + i));
            // Cliffs all around, sometimes overhanging a little.
            let around = (f64::from(k) + azimuth) / f64::from(N_CUTS);
            let normal = direction(around, -0.35 + 1.2 * slope);
            (normal, 0.62 + 0.3 * depth)
        });
        // One nearly level plane takes off the top of the body, as of a shelf that it was once part of.
        let table = {
            let [azimuth, slope, height] = [0, 1, 2].map(|i| random(300 + i));
            (direction(azimuth, 1.35 - 0.35 * slope), 0.5 + 0.12 * height)
        };
        let pinnacles = (0..N_PINNACLES).map(|k| {
            let [azimuth, slope, height] = [0, 1, 2].map(|i| random(200 + 3 * k + i));
            let at = direction(azimuth, 0.75 + 0.6 * slope);
            (at, 0.08 + 0.27 * height, 8.0 + 20.0 * azimuth)
        });
        Self {
            seed,
            ruggedness,
            cuts: cuts.chain([table]).collect(),
            pinnacles: pinnacles.collect(),
        }
    }

    /// Distance from the middle to the surface in a direction.
    fn radius(&self, u: DVec3) -> f64 {
        let stretched = DVec3::new(u.x / 1.15, u.y / 0.8, u.z / 0.85);
        let body = 1.0 / stretched.length();
        let noise =
            |scale, n_octaves, salt| fractal_noise(u * scale, n_octaves, hash(self.seed) ^ salt);
        let mut radius = body * (1.0 + 0.5 * noise(1.3, 3, 1));
        for &(normal, distance) in &self.cuts {
            let towards = u.dot(normal);
            if towards > 0.05 {
                radius = blunt_min(radius, distance / towards);
            }
        }
        for &(at, height, sharpness) in &self.pinnacles {
            radius += height * (sharpness * (u.dot(at) - 1.0)).exp();
        }
        // Gullies: creases of the noise, not its hills; fewer on top, where snow levels them.
        let gullies = 0.7 * noise(2.2, 4, 2).abs() + 0.35 * noise(7.0, 4, 3).abs();
        let steepness = 1.0 - 0.75 * u.y.max(0.0);
        radius * (1.0 - 0.7 * self.ruggedness * steepness * gullies)
    }
}

/// The smaller of two lengths, rounded off where they are alike (I. Quilez, polynomial smooth minimum).
fn blunt_min(a: f64, b: f64) -> f64 {
    let width = 0.04;
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - 0.25 * width * near * near
}

/// Height of the plane above which lies the share of the volume that floats.
fn water_line(mesh: &TriangleMesh) -> f64 {
    let above = (1.0 - DENSITY_RATIO) * mesh.volume_m3();
    let bounds = mesh.bounds();
    let (mut low, mut high) = (bounds.min.y, bounds.max.y);
    // Each step halves the interval; 60 use up the digits.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if volume_above_m3(mesh, middle) > above {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Volume above a plane: area of each triangle seen from above times its mean height over the plane.
///
/// Triangles across the plane count the mean of their corners, an error of second order in their size.
fn volume_above_m3(mesh: &TriangleMesh, plane_y: f64) -> f64 {
    let column = |index: usize| {
        let [a, b, c] = mesh.corners(index);
        let seen_m2 = 0.5 * (b - a).cross(c - a).y;
        let height = |corner: DVec3| (corner.y - plane_y).max(0.0);
        seen_m2 * (height(a) + height(b) + height(c)) / 3.0
    };
    (0..mesh.triangles().len()).map(column).sum()
}

/// Unit vectors and triangles of an octahedron whose triangles are split into four, `n_splits` times.
fn split_octahedron(n_splits: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut directions: Vec<DVec3> = axes.iter().flat_map(|&axis| [axis, -axis]).collect();
    let mut triangles = Vec::new();
    for octant in 0..8_u32 {
        let [x, y, z] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
        // An odd number of mirrored axes turns the triangle over.
        let is_mirrored = octant.count_ones() % 2 == 1;
        triangles.push(if is_mirrored { [x, z, y] } else { [x, y, z] });
    }
    for _ in 0..n_splits {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
                *middles
                    .entry((from.min(to), from.max(to)))
                    .or_insert_with(|| {
                        let middle = directions[from as usize] + directions[to as usize];
                        directions.push(middle.normalize());
                        directions.len() as u32 - 1
                    })
            });
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    (directions, triangles)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn iceberg(seed: u32) -> TriangleMesh {
        Iceberg {
            length_m: 100.0,
            seed,
            ruggedness: 0.5,
        }
        .mesh()
        .unwrap()
    }

    #[test]
    fn icebergs_are_closed_and_as_long_as_asked_for() {
        for seed in 0..2 {
            let mesh = iceberg(seed);
            assert!(mesh.check_closed().is_ok() && mesh.volume_m3() > 0.0);
            let size = mesh.bounds().size();
            assert!((size.x.max(size.z) - 100.0).abs() < 1e-9);
            assert_eq!(mesh.winding_number(DVec3::new(0.0, -5.0, 0.0)), 1);
        }
    }

    #[test]
    fn a_tenth_of_the_volume_is_above_the_water() {
        for seed in 0..2 {
            let mesh = iceberg(seed);
            let share = volume_above_m3(&mesh, 0.0) / mesh.volume_m3();
            assert!((share - (1.0 - DENSITY_RATIO)).abs() < 1e-9, "{share}");
            let height_m = mesh.bounds().max.y;
            assert!(height_m > 5.0 && height_m < 60.0, "{height_m} m of 100 m");
        }
    }

    #[test]
    fn the_volume_above_a_plane_is_that_of_a_cap() {
        let (directions, triangles) = split_octahedron(6);
        let ball = TriangleMesh::new(&directions, &triangles).unwrap();
        // pi h² (3 - h)/3 for a cap of height h = 0.5 on a ball of radius 1.
        let cap = std::f64::consts::PI * 0.25 * 2.5 / 3.0;
        // Worst found 4e-4, the facets of the ball.
        assert!((volume_above_m3(&ball, 0.5) / cap - 1.0).abs() < 1e-3);
        assert!((volume_above_m3(&ball, -1.0) / ball.volume_m3() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn another_seed_is_another_iceberg() {
        let radius = |seed| Form::new(seed, 0.5).radius(DVec3::new(0.6, 0.64, 0.48));
        assert_eq!(radius(4), radius(4));
        assert!((radius(4) - radius(5)).abs() > 1e-3);
    }

    #[test]
    fn impossible_icebergs_are_refused() {
        for (length_m, ruggedness) in [(0.0, 0.5), (f64::NAN, 0.5), (100.0, 1.5)] {
            let bad = Iceberg {
                length_m,
                seed: 0,
                ruggedness,
            };
            assert!(matches!(bad.mesh(), Err(Error::Parameter { .. })));
        }
    }
}
