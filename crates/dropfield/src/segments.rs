//! The cells along a ray.
//!
//! In lattice coordinates (1 = a voxel) the ray is o + t d, and it crosses the plane x = i at
//! t = (i - o)/d. Every crossing is computed from its plane, never by adding up steps, so that
//! errors do not grow along the ray, and one cell's exit is bit for bit the next one's entry.
//! Rounding may put a crossing before the one already passed; such a cell has no length and is left
//! out, and so is one without drops at its corners. A direction component of exactly 0 never crosses.
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
use crate::bricks::NO_BRICK;
use crate::bricks::cell_base;

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
    base: usize,
    local_enter: Vec3A,
    local_exit: Vec3A,
}

impl Segment<'_> {
    /// The field at a fraction (0..=1) of the run.
    #[inline]
    pub fn sample(&self, fraction: f32) -> Sample {
        let local = self.local_enter * (1.0 - fraction) + self.local_exit * fraction;
        self.bricks.sample_cell(self.base, Vec3::from(local))
    }

    /// The lanes of [`Sample`] along the run, as the factors c0 to c3 of the cubic
    /// c0 + c1 x + c2 x² + c3 x³ of the fraction x; of lanes that are interpolated themselves, so of
    /// [`Interpolation::Moments`](crate::Interpolation::Moments) only.
    #[inline]
    pub fn cubic(&self) -> [Vec4; 4] {
        let way = self.local_exit - self.local_enter;
        self.bricks.cubic_in_cell(self.base, self.local_enter, way)
    }

    /// Bounds on M2 in the brick that the cell belongs to (um²/m³).
    pub fn m2_range(&self) -> (f32, f32) {
        self.bricks.m2_range(self.brick)
    }
}

/// Iterator over the cells along a ray, those without drops left out.
#[derive(Debug, Clone)]
pub struct Segments<'a> {
    bricks: &'a Bricks,
    /// The ray in lattice coordinates.
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
    /// 1 along axes on which the ray runs upwards, else 0.
    upwards: IVec3,
    cell: IVec3,
    brick: u32,
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
        origin: DVec3,
        direction: DVec3,
        t_range: (f64, f64),
    ) -> Self {
        let n_cells = bricks.n_cells();
        let inverse = direction.recip();
        let upwards = IVec3::from(direction.to_array().map(|axis| i32::from(axis > 0.0)));
        let (t, t_end) = clip(n_cells.as_dvec3(), (origin, direction, inverse), t_range);
        let mut segments = Self {
            bricks,
            origin,
            direction,
            inverse,
            upwards,
            cell: IVec3::ZERO,
            brick: NO_BRICK,
            exits: DVec3::INFINITY,
            t,
            t_end,
            at: origin + direction * t,
        };
        if segments.t < segments.t_end {
            // What rounding puts below 0 becomes 0.
            segments.cell = segments.at.as_ivec3().clamp(IVec3::ZERO, n_cells - 1);
            segments.brick = bricks.brick_of(segments.cell);
            segments.exits = segments.exits_of(1);
        }
        segments
    }

    /// Distance at which the ray leaves a block of `size` cells along an axis.
    #[inline]
    fn exit_of(&self, axis: usize, size: i32) -> f64 {
        // Round down to the block, then up to its far side where the ray runs upwards.
        let block = self.cell[axis] & -size;
        let plane = f64::from(block + self.upwards[axis] * size);
        // Against the stored direction: only an exact 0 never crosses.
        if self.direction[axis] == 0.0 {
            f64::INFINITY
        } else {
            (plane - self.origin[axis]) * self.inverse[axis]
        }
    }

    #[inline]
    fn exits_of(&self, size: i32) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| self.exit_of(axis, size)))
    }

    /// Go on to the cell behind the far face of a block of `size` cells; the end of the ray where
    /// that is outside the lattice.
    #[inline]
    fn cross(&mut self, axis: usize, size: i32) {
        let block = self.cell[axis] & -size;
        self.cell[axis] = if self.upwards[axis] == 1 {
            block + size
        } else {
            block - 1
        };
        if self.cell[axis] < 0 || self.cell[axis] >= self.bricks.n_cells()[axis] {
            self.t = self.t_end;
            return;
        }
        let new_brick =
            self.cell[axis] & (BRICK_DIM - 1) == (BRICK_DIM - 1) * (1 - self.upwards[axis]);
        if size == BRICK_DIM || new_brick {
            self.brick = self.bricks.brick_of(self.cell);
        }
        if size == 1 {
            self.exits[axis] = self.exit_of(axis, 1);
        }
    }

    /// Leave a brick without drops at once.
    fn skip_brick(&mut self) {
        let (axis, t_exit) = first(self.exits_of(BRICK_DIM));
        self.t = self.t.max(t_exit);
        if self.t >= self.t_end {
            return;
        }
        // Along the other axes the ray is still inside the brick.
        let low = self.cell & -BRICK_DIM;
        let high = (low + BRICK_DIM - 1).min(self.bricks.n_cells() - 1);
        let along = self.cell[axis];
        self.at = self.origin + self.direction * self.t;
        self.cell = self.at.as_ivec3().clamp(low, high);
        self.cell[axis] = along;
        self.cross(axis, BRICK_DIM);
        self.exits = self.exits_of(1);
    }

    /// From where the ray is to its exit from the cell.
    #[inline]
    fn segment(&self, t_exit: f64, exit: DVec3) -> Segment<'a> {
        let low = self.cell.as_dvec3();
        // f32 is enough inside a cell: 1e-7 of a voxel.
        let local = |at: DVec3| (at - low).as_vec3a().clamp(Vec3A::ZERO, Vec3A::ONE);
        Segment {
            t_enter: self.t,
            t_exit,
            bricks: self.bricks,
            brick: self.brick,
            base: cell_base(self.brick, self.cell),
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
            if self.brick == NO_BRICK {
                self.skip_brick();
                continue;
            }
            let (axis, t_next) = first(self.exits);
            let t_exit = t_next.min(self.t_end);
            if t_exit <= self.t {
                self.cross(axis, 1);
                continue;
            }
            let exit = self.origin + self.direction * t_exit;
            let has_drops = !self.bricks.is_empty_cell(self.brick, self.cell);
            let segment = has_drops.then(|| self.segment(t_exit, exit));
            (self.t, self.at) = (t_exit, exit);
            self.cross(axis, 1);
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

/// The part of a range of distances that lies in the box from 0 to `size`; empty as (0, 0).
fn clip(
    size: DVec3,
    (origin, direction, inverse): (DVec3, DVec3, DVec3),
    (mut t_enter, mut t_exit): (f64, f64),
) -> (f64, f64) {
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

#[cfg(test)]
#[path = "segments_tests.rs"]
mod tests;
