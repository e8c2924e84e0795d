//! The drops of a picture, for whoever points at a place in it.
//!
//! r = sum_k int M3_k ds / sum_k int M2_k ds
//! along a view ray up to the surface that ends it, over the modes `k`: the effective radius of all drops on the ray taken
//! together, which is the mean of their effective radii by extinction π M2 (Q = 1). Moments are cubic along the ray in
//! each cell, so that Simpson's rule is exact.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_exchange::SpectralImage;
use niji_geometry::Camera;
use niji_geometry::PixelRegion;
use niji_geometry::Ray;
use niji_photo::broken_lines;

use crate::error::Error;
use crate::picture::PictureWork;
use crate::sky_marks::Lines;
use crate::watch::Watch;

/// Points along an edge of a box.
const N_POINTS: usize = 256;

/// The drops of a picture.
pub struct SeenDrops {
    bricks: Vec<Bricks>,
}

impl PictureWork {
    /// Renders a region as it is at one instant, and leaves the drops that were seen; the image has no provenance.
    ///
    /// # Errors
    /// As [`Self::render`].
    pub fn render_with_drops(
        self,
        region: PixelRegion,
        watch: Watch,
    ) -> Result<(SpectralImage, SeenDrops), Error> {
        let image = self.at_once(region, watch)?;
        let bricks = self.into_bricks();
        Ok((image, SeenDrops { bricks }))
    }
}

impl SeenDrops {
    /// Effective radius of the drops along a ray of unit direction up to a distance (m), in µm; `None` where there are
    /// none.
    pub fn effective_radius_um(&self, ray: &Ray, end_m: f64) -> Option<f64> {
        let mut sums = [0.0, 0.0];
        for bricks in &self.bricks {
            for cell in bricks.segments(ray.origin, ray.direction, (0.0, end_m)) {
                let length_m = cell.t_exit - cell.t_enter;
                for (fraction, weight) in [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)] {
                    let sample = cell.sample(fraction);
                    for (sum, moment) in sums.iter_mut().zip([sample.m2, sample.m3]) {
                        *sum += weight / 6.0 * length_m * f64::from(moment);
                    }
                }
            }
        }
        let [m2, m3] = sums;
        (m2 > 0.0).then(|| m3 / m2)
    }

    /// The edges of the boxes outside of which there are no drops, in pixels from the top left corner.
    pub fn box_lines(&self, camera: &Camera) -> Lines {
        let mut boxes: Vec<[DVec3; 2]> = Vec::new();
        for (low, high) in self.bricks.iter().filter_map(Bricks::world_bounds) {
            // The modes of a population share theirs.
            if !boxes.contains(&[low, high]) {
                boxes.push([low, high]);
            }
        }
        let edges = boxes.iter().flat_map(edges);
        let lines = edges.flat_map(|[from, to]| {
            let point = |step| from.lerp(to, step as f64 / N_POINTS as f64) - camera.position();
            broken_lines(camera, (0..=N_POINTS).map(point))
        });
        lines.collect()
    }
}

/// The twelve edges of a box.
fn edges([low, high]: &[DVec3; 2]) -> impl Iterator<Item = [DVec3; 2]> {
    let corner = |bits: usize| {
        let side = |axis: usize| [low[axis], high[axis]][bits >> axis & 1];
        DVec3::new(side(0), side(1), side(2))
    };
    let edge = move |from: usize, axis: usize| {
        let to = from | 1 << axis;
        (to != from).then(|| [corner(from), corner(to)])
    };
    (0..8).flat_map(move |from| (0..3).filter_map(move |axis| edge(from, axis)))
}

#[cfg(test)]
mod tests {
    use niji_dropfield::DropMode;
    use niji_dropfield::Drops;
    use niji_dropfield::GridBox;
    use niji_dropfield::Interpolation;
    use niji_scene::Scene;

    use super::*;

    const HALF_M: f64 = 32.0;

    /// Drops of one number whose size changes towards the north, and as many of another size in the same box.
    fn seen() -> SeenDrops {
        let grid = GridBox {
            min: DVec3::splat(-HALF_M),
            max: DVec3::splat(HALF_M),
            voxel_m: 2.0,
        };
        let mode = |radius_m: fn(DVec3) -> f64| {
            let drops = |point: DVec3| Drops {
                number_density_m3: 1000.0,
                effective_radius_m: radius_m(point) as f32,
                effective_variance: 0.0,
            };
            let mode = DropMode::from_fn("", &grid, drops).unwrap();
            Bricks::build(&mode, Interpolation::Moments).unwrap()
        };
        let changing = |point: DVec3| 1e-4 * (2.0 - point.z / HALF_M);
        SeenDrops {
            bricks: vec![mode(changing), mode(|_| 5e-5)],
        }
    }

    #[test]
    fn the_effective_radius_along_a_ray_is_the_mean_by_extinction() {
        let seen = seen();
        let ray = Ray {
            origin: DVec3::new(1.0, 3.0, HALF_M + 10.0),
            direction: DVec3::NEG_Z,
        };
        let expected = |until: f64| {
            // int (1 + x)³ dx / int (1 + x)² dx in units of 100 µm, x from the southern face, and the other drops.
            let x = until / HALF_M;
            let m2 = ((1.0 + x).powi(3) - 1.0) / 3.0 + 0.25 * x;
            let m3 = ((1.0 + x).powi(4) - 1.0) / 4.0 + 0.125 * x;
            100.0 * m3 / m2
        };
        for (end_m, until_m) in [(f64::INFINITY, 2.0 * HALF_M), (10.0 + HALF_M, HALF_M)] {
            let found = seen.effective_radius_um(&ray, end_m).unwrap();
            // Squares and cubes are linear between nodes.
            assert!((found / expected(until_m) - 1.0).abs() < 2e-3, "{found}");
        }
        // Drops fade over a voxel beyond their nodes.
        assert_eq!(seen.effective_radius_um(&ray, 7.0), None);
        let away = Ray {
            direction: DVec3::Z,
            ..ray
        };
        assert_eq!(seen.effective_radius_um(&away, f64::INFINITY), None);
    }

    #[test]
    fn the_box_is_drawn_once_through_its_corners() {
        let scene = include_str!("../../../data/scenes/rain-5-mm-h-flattened.toml");
        let mut scene = Scene::from_toml(scene).unwrap();
        scene.camera.position_m = [0.0, 0.0, 200.0];
        scene.camera.azimuth_deg = 0.0;
        scene.camera.elevation_deg = 0.0;
        let camera = scene.camera.camera().unwrap();
        let seen = seen();
        let (low, high) = seen.bricks[0].world_bounds().unwrap();
        assert!((low - DVec3::splat(-HALF_M)).abs().max_element() <= 2.0);
        let lines = seen.box_lines(&camera);
        assert_eq!(lines.len(), 12);
        for bits in 0..8 {
            let side = |axis: usize| [low[axis], high[axis]][bits >> axis & 1];
            let corner = DVec3::new(side(0), side(1), side(2));
            let (x, y) = camera.project(corner - camera.position()).unwrap();
            let at_corner = |[a, b]: &[f64; 2]| (a - x).hypot(b - y) < 1e-6;
            let ends = lines
                .iter()
                .flat_map(|line| [line[0], line[line.len() - 1]]);
            assert_eq!(ends.filter(at_corner).count(), 3, "{corner}");
        }
    }
}
