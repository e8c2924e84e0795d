//! How far light flies through the drops before it meets one.
//!
//! p(s) = sigma(s) exp(-int_0^s sigma ds')
//!
//! `sigma` extinction of all modes without diffraction [1/m]. Drawn by tracking with fictitious
//! collisions [WMHL65]: in each cell of a coarse lattice the extinction is filled up to a bound on it,
//! so that flights between collisions are exponential, and a collision is real with the ratio of
//! both. What comes out follows the interpolated field itself, however coarse the lattice is. Where
//! radius and density are interpolated apart, sigma may exceed the largest value of the nodes around
//! by up to a fifth; there it counts as the bound.
//!
//! [WMHL65] E. Woodcock et al., "Techniques used in the GEM code for Monte Carlo neutronics
//! calculations", ANL-7050, 557-579 (1965).

use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering;

use glam::DVec3;
use glam::IVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::Ray;

use super::randoms::Randoms;
use crate::lit_drops::extinction_m1;
use crate::piece::EXTINCTION_PER_M2;

/// Cells along the longest edge of the box.
const N_CELLS: f64 = 32.0;

/// Margin for the rounding of samples in f32.
const ROUNDING: f64 = 1.0 + 1e-5;

/// The drops with bounds on their extinction.
pub(crate) struct FreeFlight<'a> {
    bricks: &'a [Bricks],
    bounds: Aabb,
    n_cells: IVec3,
    cell_m: DVec3,
    /// Bounds on the extinction, x slowest [1/m].
    bounds_m1: Vec<f64>,
}

impl<'a> FreeFlight<'a> {
    /// Lay the lattice over the drops.
    pub(crate) fn new(bricks: &'a [Bricks], bounds: Aabb) -> Self {
        let size = bounds.max - bounds.min;
        let n_cells = (size / (size.max_element() / N_CELLS))
            .ceil()
            .max(DVec3::ONE);
        let n_cells = n_cells.min(DVec3::splat(N_CELLS));
        let mut lattice = Self {
            bricks,
            bounds,
            n_cells: n_cells.as_ivec3(),
            cell_m: size / n_cells,
            bounds_m1: Vec::new(),
        };
        let mut sums = vec![0.0; n_cells.element_product() as usize];
        for mode in bricks {
            for (sum, m2) in sums.iter_mut().zip(lattice.largest_m2(mode)) {
                *sum += EXTINCTION_PER_M2 * f64::from(m2) * ROUNDING;
            }
        }
        lattice.bounds_m1 = sums;
        lattice
    }

    /// Largest M2 of the nodes that take part in each cell. The bits of floats from 0 up are ordered
    /// as the floats, and a maximum does not depend on the order in which threads arrive.
    fn largest_m2(&self, mode: &Bricks) -> Vec<f32> {
        let n_cells = self.n_cells.as_usizevec3().element_product();
        let largest: Vec<AtomicU32> = (0..n_cells).map(|_| AtomicU32::new(0)).collect();
        let reach = DVec3::splat(mode.voxel_m());
        // Only the maxima are wanted, not the values at the nodes.
        let _ = mode.at_nodes(|point| {
            let m2 = mode.m2(point);
            if m2 > 0.0 {
                let (low, high) = (self.cell(point - reach), self.cell(point + reach));
                for x in low.x..=high.x {
                    for y in low.y..=high.y {
                        for z in low.z..=high.z {
                            let index = self.index(IVec3::new(x, y, z));
                            largest[index].fetch_max(m2.to_bits(), Ordering::Relaxed);
                        }
                    }
                }
            }
            m2
        });
        largest
            .into_iter()
            .map(|bits| f32::from_bits(bits.into_inner()))
            .collect()
    }

    /// Where light that starts inside the box meets its next drop; `None` if it leaves.
    pub(crate) fn next_drop(&self, ray: &Ray, randoms: &mut Randoms) -> Option<DVec3> {
        let (_, leave_m) = self.bounds.intersect(ray)?;
        let mut depth = exponential(randoms.next_even());
        let mut from_m = 0.0;
        let mut cell = self.cell(ray.origin);
        let mut exits = Exits::of(self, ray, cell);
        loop {
            let (axis, exit_m) = exits.nearest();
            let exit_m = exit_m.min(leave_m);
            let bound_m1 = self.bounds_m1[self.index(cell)];
            loop {
                // Where there are no drops there is no collision, not even at a depth of 0.
                let collision_m = from_m + depth / bound_m1;
                if bound_m1 <= 0.0 || collision_m > exit_m {
                    break;
                }
                let point = ray.at(collision_m);
                if randoms.next() * bound_m1 < extinction_m1(self.bricks, point) {
                    return Some(point);
                }
                from_m = collision_m;
                depth = exponential(randoms.next());
            }
            depth -= bound_m1 * (exit_m - from_m).max(0.0);
            depth = depth.max(0.0);
            from_m = from_m.max(exit_m);
            cell[axis] += if ray.direction[axis] > 0.0 { 1 } else { -1 };
            let inside = (0..self.n_cells[axis]).contains(&cell[axis]);
            if !inside || from_m >= leave_m {
                return None;
            }
            exits.pass(axis);
        }
    }

    /// The cell of a point; the nearest one outside.
    fn cell(&self, point: DVec3) -> IVec3 {
        let place = (point - self.bounds.min) / self.cell_m;
        place
            .floor()
            .as_ivec3()
            .clamp(IVec3::ZERO, self.n_cells - 1)
    }

    fn index(&self, cell: IVec3) -> usize {
        ((cell.x * self.n_cells.y + cell.y) * self.n_cells.z + cell.z) as usize
    }
}

/// Where a ray leaves the cell that it is in, axis by axis.
struct Exits {
    /// Distances of the next faces; infinite along an axis that is never crossed [m].
    next_m: DVec3,
    /// Distances from face to face [m].
    step_m: DVec3,
}

impl Exits {
    fn of(lattice: &FreeFlight, ray: &Ray, cell: IVec3) -> Self {
        let mut exits = Self {
            next_m: DVec3::INFINITY,
            step_m: DVec3::ZERO,
        };
        for axis in 0..3 {
            let direction = ray.direction[axis];
            if direction == 0.0 {
                continue;
            }
            let face = cell[axis] + i32::from(direction > 0.0);
            let face_m = lattice.bounds.min[axis] + f64::from(face) * lattice.cell_m[axis];
            let per_m = direction.recip();
            exits.next_m[axis] = (face_m - ray.origin[axis]) * per_m;
            exits.step_m[axis] = (lattice.cell_m[axis] * per_m).abs();
        }
        exits
    }

    /// The axis whose face is next, and how far it is.
    fn nearest(&self) -> (usize, f64) {
        let [x, y, z] = self.next_m.to_array();
        if x <= y && x <= z {
            (0, x)
        } else if y <= z {
            (1, y)
        } else {
            (2, z)
        }
    }

    /// Goes on into the cell behind that face.
    fn pass(&mut self, axis: usize) {
        self.next_m[axis] += self.step_m[axis];
    }
}

/// An optical depth of mean 1. Random numbers have 53 bits after the point, so that the difference is exact.
fn exponential(random: f64) -> f64 {
    -(1.0 - random).ln()
}

#[cfg(test)]
mod tests {
    use niji_dropfield::DropMode;
    use niji_dropfield::Drops;
    use niji_dropfield::GridBox;
    use niji_dropfield::Interpolation;

    use super::*;

    /// Drops of 1/m times a function of the place.
    fn bricks(extinction_m1: impl Fn(DVec3) -> f64 + Sync) -> [Bricks; 1] {
        let grid = GridBox {
            min: DVec3::splat(-8.0),
            max: DVec3::splat(8.0),
            voxel_m: 1.0,
        };
        let mode = DropMode::from_fn("", &grid, |point| Drops {
            number_density_m3: (extinction_m1(point) / (std::f64::consts::PI * 1e-8)) as f32,
            effective_radius_m: 1e-4,
            effective_variance: 0.0,
        });
        [Bricks::build(&mode.unwrap(), Interpolation::Moments).unwrap()]
    }

    /// Share of flights that leave, and the share that the optical depth says.
    fn leaving(bricks: &[Bricks], ray: &Ray) -> (f64, f64) {
        let (min, max) = bricks[0].world_bounds().unwrap();
        let flight = FreeFlight::new(bricks, Aabb { min, max });
        let n = 20_000;
        let leave = |path: &u64| flight.next_drop(ray, &mut Randoms::of(0, *path)).is_none();
        let found = (0..n).filter(leave).count() as f64 / n as f64;
        let step_m = 1e-3;
        let depth: f64 = (0..40_000)
            .map(|step| ray.at((f64::from(step) + 0.5) * step_m))
            .map(|point| step_m * extinction_m1(bricks, point))
            .sum();
        (found, (-depth).exp())
    }

    #[test]
    fn as_many_flights_leave_as_the_optical_depth_lets_pass() {
        let wave = |point: DVec3| 0.2 * (1.0 + (0.9 * point.x + 0.4 * point.z).sin());
        let corner = |point: DVec3| if point.y > 3.0 { 1.5 } else { 0.0 };
        let (wave, corner) = (bricks(wave), bricks(corner));
        for direction in [DVec3::X, -DVec3::Y, DVec3::new(1.0, 2.0, -1.5).normalize()] {
            for (field, origin) in [
                (&wave, DVec3::new(-2.0, 1.0, 0.5)),
                (&corner, DVec3::new(0.3, 4.0, -0.2)),
                (&corner, DVec3::new(-1.0, -4.0, 1.0)),
            ] {
                let (found, expected) = leaving(field, &Ray { origin, direction });
                // Chance leaves 3.5e-3 of 20 000 flights; measured at most 6e-3.
                assert!(
                    (found - expected).abs() < 0.012,
                    "{direction} {found} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_single_voxel_and_a_start_on_a_face_end_well() {
        let one = bricks(|point| if point.length() < 0.9 { 5.0 } else { 0.0 });
        let (min, max) = one[0].world_bounds().unwrap();
        let flight = FreeFlight::new(&one, Aabb { min, max });
        for path in 0..1000 {
            let mut randoms = Randoms::of(0, path);
            for origin in [min, max, DVec3::ZERO, DVec3::new(min.x, 0.0, max.z)] {
                for direction in [DVec3::X, -DVec3::Z, DVec3::splat(1.0).normalize()] {
                    let ray = Ray { origin, direction };
                    if let Some(point) = flight.next_drop(&ray, &mut randoms) {
                        assert!(extinction_m1(&one, point) > 0.0);
                    }
                }
            }
        }
    }
}
