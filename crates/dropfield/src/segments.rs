//! The cells along a ray.
//!
//! In lattice coordinates (1 = a voxel) the ray is o + t d, and it crosses the plane x = i at
//! t = (i - o)/d. Every crossing is computed from its plane, never by adding up steps, so that
//! errors do not grow along the ray, and one cell's exit is bit for bit the next one's entry.
//! Rounding may put a crossing before the one already passed; such a cell has no length and is left
//! out, and so is one without drops at its corners. A direction component of exactly 0 never crosses.
//! Cells are a voxel wide, or as coarse as an error allows there (see `coarse_cells`), inside a brick; one
//! without drops is one empty cell.
//! [AW87] Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics
//! 1987, 3-10 (with planes instead of increments).

use glam::DVec3;
use glam::IVec3;
use glam::Vec3;
use glam::Vec3A;
use glam::Vec4;

use crate::Bricks;
use crate::Sample;
use crate::bricks::BRICK_DIM;
use crate::bricks::Cell;
use crate::bricks::NO_BRICK;
use crate::bricks::cell_base;
use crate::coarse_cells::NO_DROPS;

/// The run of a ray through one cell, in which the field is one trilinear polynomial (and so a
/// cubic one along the ray).
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// Distance at which the ray enters, in units of the direction's length.
    pub t_enter: f64,
    /// Distance at which it leaves, in the same units.
    pub t_exit: f64,
    bricks: &'a Bricks,
    brick: u32,
    cell: Cell,
    /// Relative error because of the width of the cell.
    error: f32,
    local_enter: Vec3A,
    local_exit: Vec3A,
}

impl Segment<'_> {
    /// The field at a fraction (0..=1) of the run.
    #[inline]
    pub fn sample(&self, fraction: f32) -> Sample {
        if self.is_coarse() {
            let [c0, c1, c2, c3] = self.cubic();
            let [m2, m3, m4, tau_sun] =
                (c0 + fraction * (c1 + fraction * (c2 + fraction * c3))).to_array();
            return Sample {
                m2,
                m3,
                m4,
                tau_sun,
            };
        }
        let local = self.local_enter * (1.0 - fraction) + self.local_exit * fraction;
        self.bricks.sample_cell(self.cell.base, Vec3::from(local))
    }

    /// The lanes of [`Sample`] along the run, as the factors c0 to c3 of the cubic
    /// c0 + c1 x + c2 x² + c3 x³ of the fraction x; of lanes that are interpolated themselves, so of
    /// [`Interpolation::Moments`](crate::Interpolation::Moments) only.
    #[inline]
    pub fn cubic(&self) -> [Vec4; 4] {
        let way = self.local_exit - self.local_enter;
        self.bricks.cubic_in_cell(self.cell, self.local_enter, way)
    }

    /// Whether the cell is wider than a voxel.
    #[inline]
    pub fn is_coarse(&self) -> bool {
        self.cell.width > 1
    }

    /// Relative error of the moments and of sunlight because the cell is coarse; else 0.
    pub fn relative_error(&self) -> f32 {
        self.error
    }

    /// Bounds on M2 in the brick that the cell belongs to (um²/m³).
    pub fn m2_range(&self) -> (f32, f32) {
        self.bricks.m2_range(self.brick)
    }
}

/// A ray in lattice coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LatticeRay {
    origin: DVec3,
    direction: DVec3,
    /// One over each component of the direction.
    inverse: DVec3,
}

impl LatticeRay {
    #[inline]
    pub(crate) fn new(origin: DVec3, direction: DVec3) -> Self {
        Self {
            origin,
            direction,
            inverse: direction.recip(),
        }
    }

    #[inline]
    fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// The part of a range of distances that lies in the box from 0 to `size`; empty as (0, 0).
    fn clip(&self, size: DVec3, t_range: (f64, f64)) -> (f64, f64) {
        let Self {
            origin,
            direction,
            inverse,
        } = *self;
        let (mut t_enter, mut t_exit) = t_range;
        // Also where an end is not a number, which `max` and `min` would pass over.
        if t_enter.partial_cmp(&t_exit) != Some(std::cmp::Ordering::Less) {
            return (0.0, 0.0);
        }
        let (at_low, at_high) = (-origin * inverse, (size - origin) * inverse);
        for axis in 0..3 {
            let (low, high) = (at_low[axis], at_high[axis]);
            // Against the stored direction: only an exact 0 runs along the faces.
            if direction[axis] == 0.0 {
                if !(0.0..size[axis]).contains(&origin[axis]) {
                    return (0.0, 0.0);
                }
                continue;
            }
            let (near, far) = if low < high { (low, high) } else { (high, low) };
            t_enter = if near > t_enter { near } else { t_enter };
            t_exit = if far < t_exit { far } else { t_exit };
        }
        // Written so that a NaN gives nothing.
        if t_enter < t_exit && (direction + origin).is_finite() {
            (t_enter, t_exit)
        } else {
            (0.0, 0.0)
        }
    }
}

/// Iterator over the cells along a ray, those without drops left out.
#[derive(Debug, Clone)]
pub struct Segments<'a> {
    bricks: &'a Bricks,
    ray: LatticeRay,
    /// 1 along axes on which the ray runs upwards, else 0.
    upwards: IVec3,
    /// Lowest voxel of the cell.
    cell: IVec3,
    brick: u32,
    /// Edge of the cell in voxels, one over it, and relative error because of it or `NO_DROPS`.
    width: i32,
    per_width: f64,
    error: f32,
    /// From a cell to the next ones, and to the faces through which the ray leaves it.
    to_next: IVec3,
    to_exit: IVec3,
    /// Largest relative error of cells that are coarse.
    most_error: f32,
    /// At multiples of so many voxels a width is chosen.
    choice_span: i32,
    /// Distances at which the ray leaves the cell along each axis.
    exits: DVec3,
    t: f64,
    t_end: f64,
    /// Where the ray is at `t`.
    at: DVec3,
}

impl<'a> Segments<'a> {
    #[inline]
    pub(crate) fn new(
        bricks: &'a Bricks,
        ray: LatticeRay,
        t_range: (f64, f64),
        most_error: f32,
    ) -> Self {
        let n_cells = bricks.n_cells();
        let upwards = IVec3::from(ray.direction.to_array().map(|axis| i32::from(axis > 0.0)));
        let (t, t_end) = ray.clip(n_cells.as_dvec3(), t_range);
        let mut segments = Self {
            bricks,
            ray,
            upwards,
            cell: IVec3::ZERO,
            brick: NO_BRICK,
            width: 0,
            per_width: 0.0,
            error: 0.0,
            to_next: IVec3::ZERO,
            to_exit: IVec3::ZERO,
            most_error,
            choice_span: BRICK_DIM,
            exits: DVec3::INFINITY,
            t,
            t_end,
            at: ray.at(t),
        };
        if segments.t < segments.t_end {
            // What rounding puts below 0 becomes 0.
            segments.cell = segments.at.as_ivec3().clamp(IVec3::ZERO, n_cells - 1);
            segments.enter_brick();
            segments.change_width(0);
        }
        segments
    }

    /// Distance at which the ray leaves the cell along an axis.
    #[inline]
    fn exit(&self, axis: usize) -> f64 {
        let plane = f64::from(self.cell[axis] + self.to_exit[axis]);
        // Against the stored direction: only an exact 0 never crosses.
        if self.ray.direction[axis] == 0.0 {
            f64::INFINITY
        } else {
            (plane - self.ray.origin[axis]) * self.ray.inverse[axis]
        }
    }

    /// Go on to the cell behind the far face; the end of the ray where that is outside the lattice.
    #[inline]
    fn cross(&mut self, axis: usize) {
        let left = self.cell[axis];
        let cell = left + self.to_next[axis];
        self.cell[axis] = cell;
        if cell < 0 || cell >= self.bricks.n_cells()[axis] {
            self.t = self.t_end;
            return;
        }
        if (cell ^ left) >= self.choice_span {
            if (cell ^ left) >= BRICK_DIM {
                self.enter_brick();
            }
            self.change_width(axis);
        } else {
            self.exits[axis] = self.exit(axis);
        }
    }

    fn enter_brick(&mut self) {
        self.brick = self.bricks.brick_of(self.cell);
        let is_coarse = self.bricks.has_coarse_cells(self.brick, self.most_error);
        self.choice_span = if is_coarse { 2 } else { BRICK_DIM };
    }

    /// Take the width of the cells where the ray is, that has just crossed a face across an axis.
    fn change_width(&mut self, axis: usize) {
        let (bricks, most_error) = (self.bricks, self.most_error);
        let mut coarsest = bricks.coarsest_cell(self.brick, self.cell, most_error);
        // Else all voxels of the cell have the width of the lowest one.
        if coarsest.0 < self.width {
            self.find_voxel(axis);
            coarsest = bricks.coarsest_cell(self.brick, self.cell, most_error);
        }
        let (width, error) = coarsest;
        self.error = error;
        if width == self.width {
            self.exits[axis] = self.exit(axis);
        } else {
            self.set_width(width);
        }
    }

    /// Make the cell the one of a width around its voxel.
    fn set_width(&mut self, width: i32) {
        self.width = width;
        self.per_width = 1.0 / f64::from(width);
        self.to_exit = self.upwards * width;
        self.to_next = 2 * self.to_exit - width;
        self.cell &= -width;
        self.exits = DVec3::from([0, 1, 2].map(|axis| self.exit(axis)));
    }

    /// The voxel where the ray is, that has just crossed a face across an axis: along the other axes it
    /// is still beside the cell it left.
    fn find_voxel(&mut self, axis: usize) {
        let high = (self.cell + self.width - 1).min(self.bricks.n_cells() - 1);
        let mut voxel = self.at.as_ivec3().clamp(self.cell, high);
        // Of a cell below, the highest one.
        voxel[axis] = self.cell[axis] + (1 - self.upwards[axis]) * (self.width - 1);
        self.cell = voxel;
    }

    /// Whether there are drops at the nodes of the cell.
    #[inline]
    fn has_drops(&self) -> bool {
        if self.width > 1 {
            self.error > NO_DROPS
        } else {
            !self.bricks.is_empty_cell(self.brick, self.cell)
        }
    }

    /// From where the ray is to its exit from the cell.
    #[inline]
    fn segment(&self, t_exit: f64, exit: DVec3) -> Segment<'a> {
        let (low, scale) = (self.cell.as_dvec3(), self.per_width);
        // f32 is enough inside a cell: 1e-7 of its width.
        let local = |at: DVec3| {
            ((at - low) * scale)
                .as_vec3a()
                .clamp(Vec3A::ZERO, Vec3A::ONE)
        };
        Segment {
            t_enter: self.t,
            t_exit,
            bricks: self.bricks,
            brick: self.brick,
            cell: Cell {
                base: cell_base(self.brick, self.cell),
                width: self.width,
            },
            error: self.error,
            local_enter: local(self.at),
            local_exit: local(exit),
        }
    }
}

impl<'a> Iterator for Segments<'a> {
    type Item = Segment<'a>;

    #[inline]
    fn next(&mut self) -> Option<Segment<'a>> {
        while self.t < self.t_end {
            let (axis, t_next) = first(self.exits);
            let t_exit = t_next.min(self.t_end);
            if t_exit <= self.t {
                self.cross(axis);
                continue;
            }
            let exit = self.ray.at(t_exit);
            let segment = self.has_drops().then(|| self.segment(t_exit, exit));
            (self.t, self.at) = (t_exit, exit);
            self.cross(axis);
            if segment.is_some() {
                return segment;
            }
        }
        None
    }
}

/// The first of three crossings: its axis and distance.
#[inline]
fn first(exits: DVec3) -> (usize, f64) {
    // Choices of values, not of ways: which axis is next nobody can foresee.
    let (axis, exit) = if exits.y <= exits.z {
        (1, exits.y)
    } else {
        (2, exits.z)
    };
    if exits.x <= exit {
        (0, exits.x)
    } else {
        (axis, exit)
    }
}

#[cfg(test)]
#[path = "segments_tests.rs"]
mod tests;
