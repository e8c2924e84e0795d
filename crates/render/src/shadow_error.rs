//! How wrong the optical depth towards the sun is that the drops' nodes hold.
//!
//! delta(x) = tau_held(x) - int_0^inf pi M2(x + s w) ds   at Q = 1, `w` unit vector towards the sun
//!
//! `tau_held` is what a view ray finds at x: swept or marched to the nodes and interpolated between
//! them, so that the width over which a sweep spreads an edge, the voxel of the swept volume and that
//! of the drops all show in delta. It is taken at one place with drops in each cell of a coarse
//! lattice, against the integral from face to face of every cell on the way, which is exact for
//! interpolated moments. Errors change their sign from place to place; what is kept is the root of their
//! mean square over the cells around, and the light of a ray errs relatively by Q times that.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::Ray;
use rayon::prelude::*;

use crate::lit_drops::extinction_m1;
use crate::piece::EXTINCTION_PER_M2;

/// Cells along the longest side of the drops' box.
const CELLS_ALONG: f64 = 20.0;

/// Places that are tried in a cell until one has drops.
const TRIES: usize = 6;

/// Steps of a sequence that fills a cube evenly: powers of one over the real root of x⁴ = x + 1.
const SEQUENCE: DVec3 = DVec3::new(
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_3,
);

/// Fractions of the way through a cell of the two Gauss points: exact for cubics.
const GAUSS: [f32; 2] = [0.211_324_87, 0.788_675_1];

/// Rays along a face have the errors of its outermost cells only, which the mean over a coarse cell
/// holds too little of.
const SAFETY: f64 = 1.5;

/// Errors of the sun's optical depth on a coarse lattice over the drops' box.
#[derive(Clone, Debug)]
pub(crate) struct ShadowError {
    origin: DVec3,
    cells_per_m: DVec3,
    n_cells: [usize; 3],
    /// Root mean square over the cells around each, the last axis fastest.
    depths: Vec<f32>,
}

impl ShadowError {
    /// Compare what the nodes hold with the way to the sun itself.
    pub(crate) fn of(bricks: &[Bricks], bounds: Aabb, sun_direction: DVec3) -> Self {
        let size = bounds.max - bounds.min;
        let cell_m = size.max_element() / CELLS_ALONG;
        let n_cells = (size / cell_m).ceil().max(DVec3::ONE);
        let mut lattice = Self {
            origin: bounds.min,
            cells_per_m: n_cells / size,
            n_cells: n_cells.to_array().map(|n| n as usize),
            depths: Vec::new(),
        };
        let squares: Vec<Option<f64>> = (0..lattice.n_cells.iter().product())
            .into_par_iter()
            .map(|cell| {
                let point = lattice.place_with_drops(bricks, cell)?;
                Some((held_depth(bricks, point) - depth(bricks, point, sun_direction)).powi(2))
            })
            .collect();
        lattice.depths = (0..squares.len())
            .map(|cell| lattice.mean_around(cell, &squares).sqrt() as f32)
            .collect();
        lattice
    }

    /// Mean error at Q = 1 between two distances along a line.
    pub(crate) fn along(&self, ray: &Ray, (from_m, to_m): (f64, f64)) -> f64 {
        const PLACES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
        let [from, to] = [from_m, to_m].map(|at_m| self.place(ray.at(at_m)));
        let errors = PLACES.map(|part| self.at(from + part * (to - from)));
        SAFETY / PLACES.len() as f64 * errors.iter().sum::<f64>()
    }

    /// Root of the mean square over all cells, at Q = 1.
    pub(crate) fn rms(&self) -> f64 {
        let squares: f64 = self
            .depths
            .iter()
            .map(|depth| f64::from(*depth).powi(2))
            .sum();
        (squares / self.depths.len() as f64).sqrt()
    }

    /// Place of a point in cells.
    fn place(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.cells_per_m
    }

    /// In the cell at a place; the nearest cell holds outside.
    fn at(&self, place: DVec3) -> f64 {
        let [first, second, third] = self.n_cells;
        // A negative number or NaN converts to 0.
        let index = |place: f64, n: usize| (place as u32 as usize).min(n - 1);
        let row = index(place.x, first) * second + index(place.y, second);
        f64::from(self.depths[row * third + index(place.z, third)])
    }

    fn indices(&self, cell: usize) -> [usize; 3] {
        let [_, second, third] = self.n_cells;
        [cell / (second * third), cell / third % second, cell % third]
    }

    /// A place in a cell where there are drops.
    fn place_with_drops(&self, bricks: &[Bricks], cell: usize) -> Option<DVec3> {
        let corner = DVec3::from(self.indices(cell).map(|index| index as f64));
        (0..TRIES)
            .map(|attempt| {
                let in_cell = point_sequence(cell * TRIES + attempt + 1);
                self.origin + (corner + in_cell) / self.cells_per_m
            })
            .find(|point| extinction_m1(bricks, *point) > 0.0)
    }

    /// Mean over a cell and its neighbors that have drops; 0 where none has.
    fn mean_around(&self, cell: usize, squares: &[Option<f64>]) -> f64 {
        let [_, second, third] = self.n_cells;
        let ranges: [_; 3] = std::array::from_fn(|axis| {
            let index = self.indices(cell)[axis];
            index.saturating_sub(1)..(index + 2).min(self.n_cells[axis])
        });
        let [xs, ys, zs] = ranges;
        let (mut sum, mut n) = (0.0, 0.0);
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    if let Some(square) = squares[(x * second + y) * third + z] {
                        sum += square;
                        n += 1.0;
                    }
                }
            }
        }
        if n > 0.0 { sum / n } else { 0.0 }
    }
}

/// Points that fill a unit cube evenly, one by one.
pub(crate) fn point_sequence(index: usize) -> DVec3 {
    (index as f64 * SEQUENCE).fract()
}

/// What a view ray finds at a point: the mean over the modes by their extinction.
fn held_depth(bricks: &[Bricks], point: DVec3) -> f64 {
    let (mut sum, mut m2) = (0.0, 0.0);
    for sample in bricks.iter().map(|mode| mode.sample(point)) {
        sum += f64::from(sample.m2) * f64::from(sample.tau_sun);
        m2 += f64::from(sample.m2);
    }
    sum / m2
}

/// Optical depth from a point to the sun at Q = 1, cell by cell.
pub(crate) fn depth(bricks: &[Bricks], point: DVec3, sun_direction: DVec3) -> f64 {
    let segments = bricks
        .iter()
        .flat_map(|mode| mode.segments(point, sun_direction, (0.0, f64::INFINITY)));
    let columns = segments.map(|segment| {
        let m2: f64 = GAUSS.map(|x| f64::from(segment.sample(x).m2)).iter().sum();
        0.5 * m2 * (segment.t_exit - segment.t_enter)
    });
    EXTINCTION_PER_M2 * columns.sum::<f64>()
}
