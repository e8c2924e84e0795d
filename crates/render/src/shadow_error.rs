//! How wrong the optical depth towards the sun is that the drops' nodes hold.
//!
//! delta(x) = tau_held(x) - int_0^inf pi M2(x + s w) ds   at Q = 1, `w` unit vector towards the sun
//!
//! `tau_held` is what a view ray finds at x: swept or marched to the nodes and interpolated between
//! them, so that the voxel of the swept volume and that of the drops both show in delta. It is taken at
//! some places with drops in each cell of a coarse lattice, against the integral from face to face of
//! every cell on the way, which is exact for interpolated moments. What is kept is its mean m and its
//! variance V over the cells around, in which places count by the sun that reaches them, exp(-tau): where
//! there is none, there is no light to err. Along a ray the first adds up and the second averages out:
//! light from n voxels of it errs relatively by `Q sqrt(<|m|>² + <V>/n)`, `<>` mean along the ray. Three
//! times as much is told.

use glam::DVec3;
use niji_dropfield::Bricks;
use niji_geometry::Aabb;
use niji_geometry::Ray;
use rayon::prelude::*;

use crate::lit_drops::depth;
use crate::lit_drops::extinction_m1;
use crate::lit_drops::finest_voxel_m;

/// Cells along each side of the drops' box; none is smaller than a voxel.
const CELLS_ALONG: f64 = 20.0;

/// Places in a cell.
const PLACES: usize = 2;

/// Steps of a sequence that fills a cube evenly: powers of one over the real root of x⁴ = x + 1.
const SEQUENCE: DVec3 = DVec3::new(
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_2,
    0.549_700_477_901_970_3,
);

/// Standard errors that are told; means over coarse cells hold too little of errors at faces and kinks.
const STANDARD_ERRORS: f64 = 3.0;

/// Errors of the sun's optical depth on a coarse lattice over the drops' box.
#[derive(Clone, Debug)]
pub(crate) struct ShadowError {
    origin: DVec3,
    cells_per_m: DVec3,
    n_cells: [usize; 3],
    /// Edge of the drops' finest cells (m).
    voxel_m: f64,
    /// Over the cells around each, the last axis fastest.
    depths: Vec<DepthError>,
    rms: f64,
}

/// Mean and variance over places in the sun.
#[derive(Clone, Copy, Debug, Default)]
struct DepthError {
    mean: f32,
    variance: f32,
}

/// Sums over places, by the sun that reaches them.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    sun: f64,
    error: f64,
    square: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.sun += other.sun;
        self.error += other.error;
        self.square += other.square;
    }

    fn mean(&self, sum: f64) -> f64 {
        if self.sun > 0.0 { sum / self.sun } else { 0.0 }
    }

    fn moments(&self) -> DepthError {
        let mean = self.mean(self.error);
        DepthError {
            mean: mean as f32,
            variance: (self.mean(self.square) - mean * mean).max(0.0) as f32,
        }
    }
}

impl ShadowError {
    /// Compare what the nodes hold with the way to the sun itself.
    pub(crate) fn of(bricks: &[Bricks], bounds: Aabb, sun_direction: DVec3) -> Self {
        let size = bounds.max - bounds.min;
        let voxel_m = finest_voxel_m(bricks);
        let n_cells = (size / voxel_m)
            .ceil()
            .clamp(DVec3::ONE, DVec3::splat(CELLS_ALONG));
        let mut lattice = Self {
            origin: bounds.min,
            cells_per_m: n_cells / size,
            n_cells: n_cells.to_array().map(|n| n as usize),
            voxel_m,
            depths: Vec::new(),
            rms: 0.0,
        };
        let of_cells: Vec<Sums> = (0..lattice.n_cells.iter().product())
            .into_par_iter()
            .map(|cell| {
                let mut sums = Sums::default();
                for point in lattice.places(cell) {
                    let extinction_m1 = extinction_m1(bricks, point);
                    if extinction_m1 > 0.0 {
                        let depth = depth(bricks, point, sun_direction);
                        let error = held_depth(bricks, point) - depth;
                        let sun = (-depth).exp();
                        sums.add(&Sums {
                            sun,
                            error: sun * error,
                            square: sun * error * error,
                        });
                    }
                }
                sums
            })
            .collect();
        lattice.depths = (0..of_cells.len())
            .map(|cell| lattice.sums_around(cell, &of_cells).moments())
            .collect();
        let mut all = Sums::default();
        for sums in &of_cells {
            all.add(sums);
        }
        lattice.rms = all.mean(all.square).sqrt();
        lattice
    }

    /// Error at Q = 1 of what comes from between two distances along a line.
    pub(crate) fn along(&self, ray: &Ray, (from_m, to_m): (f64, f64)) -> f64 {
        const PLACES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
        let [from, to] = [from_m, to_m].map(|at_m| self.place(ray.at(at_m)));
        let (mut mean, mut variance) = (0.0, 0.0);
        for part in PLACES {
            let error = self.at(from + part * (to - from));
            mean += f64::from(error.mean).abs() / PLACES.len() as f64;
            variance += f64::from(error.variance) / PLACES.len() as f64;
        }
        let n_voxels = ((to_m - from_m) / self.voxel_m).max(1.0);
        STANDARD_ERRORS * (mean * mean + variance / n_voxels).sqrt()
    }

    /// Root of the mean square over all places in the sun, at Q = 1.
    pub(crate) fn rms(&self) -> f64 {
        self.rms
    }

    /// Place of a point in cells.
    fn place(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.cells_per_m
    }

    /// In the cell at a place; the nearest cell holds outside.
    fn at(&self, place: DVec3) -> DepthError {
        let [first, second, third] = self.n_cells;
        // A negative number or NaN converts to 0.
        let index = |place: f64, n: usize| (place as u32 as usize).min(n - 1);
        let row = index(place.x, first) * second + index(place.y, second);
        self.depths[row * third + index(place.z, third)]
    }

    fn indices(&self, cell: usize) -> [usize; 3] {
        let [_, second, third] = self.n_cells;
        [cell / (second * third), cell / third % second, cell % third]
    }

    fn places(&self, cell: usize) -> impl Iterator<Item = DVec3> {
        let corner = DVec3::from(self.indices(cell).map(|index| index as f64));
        (0..PLACES).map(move |place| {
            let in_cell = point_sequence(cell * PLACES + place + 1);
            self.origin + (corner + in_cell) / self.cells_per_m
        })
    }

    /// Over a cell and its neighbors.
    fn sums_around(&self, cell: usize, of_cells: &[Sums]) -> Sums {
        let [_, second, third] = self.n_cells;
        let ranges: [_; 3] = std::array::from_fn(|axis| {
            let index = self.indices(cell)[axis];
            index.saturating_sub(1)..(index + 2).min(self.n_cells[axis])
        });
        let [xs, ys, zs] = ranges;
        let mut sums = Sums::default();
        for x in xs {
            for y in ys.clone() {
                for z in zs.clone() {
                    sums.add(&of_cells[(x * second + y) * third + z]);
                }
            }
        }
        sums
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
