//! A mode laid out for rays: bricks of 8³ cells with their 9³ nodes in one piece.
//!
//! A cell lies between 8 neighbouring nodes; inside it the field is trilinear. A brick holds the
//! nodes of its cells, those on the upper faces as copies, so that a sample reads one short stretch
//! of memory and never looks up a neighbour. Each node has four f32 lanes: three for the drops (see
//! [`Interpolation`]) and the optical depth towards the sun. Only bricks with drops exist.
//!
//! A sample waits for memory. Optical depths take nothing but M2, and so M2 of the moments stands once
//! more by itself: a quarter more memory, of which [`Bricks::m2`] then touches a quarter. Arithmetic
//! counts all the same, because the fewer instructions a sample has, the more samples wait at once.
//!
//! Where the field ends: nodes beyond the outermost ones count as 0, so that it fades out over one
//! voxel beyond them. With [`Interpolation::RadiusDensity`] only the number density fades; the
//! radius is the mean over those corners of a cell that have drops, because a radius that fades to
//! 0 would put a fogbow around every cloud of rain.
//!
//! Interpolation is a (1 - t) + b t throughout, see [`crate::AreaMoments`].

mod m2_row;
mod node_values;

pub use node_values::NodeValues;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use std::ops::Add;
use std::ops::Mul;

use glam::DVec3;
use glam::IVec3;
use glam::Vec3;
use glam::Vec3A;
use glam::Vec4;
use glam::Vec4Swizzles;
use rayon::prelude::*;

use crate::AreaMoments;
use crate::DropMode;
use crate::Error;
use crate::Segments;
use crate::SizeRange;
use crate::area_moments::M2_PER_UM2;
use crate::brick_layout::CellMask;
use crate::brick_layout::Lattice;
use crate::brick_layout::brick_sizes;
use crate::brick_layout::cells_without_drops;
use crate::brick_layout::fill_brick;
use crate::brick_layout::m2_range;
use crate::brick_layout::occupied;
use crate::coarse_cells::CoarseErrors;
use crate::coarse_cells::NO_DROPS;
use crate::coarse_cells::TOO_COARSE;
use crate::grid_box::node_limit;
use crate::segments::LatticeRay;

/// Cells along an edge of a brick.
pub(crate) const BRICK_DIM: i32 = 8;
/// Nodes along an edge of a brick.
pub(crate) const BRICK_NODES: usize = 9;
/// Nodes of a brick.
pub(crate) const NODES_PER_BRICK: usize = BRICK_NODES * BRICK_NODES * BRICK_NODES;
/// Distance in memory of neighbouring nodes along x and y; along z it is 1.
pub(crate) const STRIDE_X: usize = BRICK_NODES * BRICK_NODES;
pub(crate) const STRIDE_Y: usize = BRICK_NODES;
/// Stretch of memory from the lowest to the highest corner of a cell.
const CELL_SPAN: usize = STRIDE_X + STRIDE_Y + 2;
/// Added to a number from 0 to 2^28, it leaves a double 24 bits behind the point: whole cells and
/// their fraction can then be read from the bits, in half the time of conversions there and back.
const FIXED_POINT: f64 = (1_u64 << (52 - FRACTION_BITS)) as f64;
/// As many as a local coordinate in f32 has.
const FRACTION_BITS: u32 = 24;
const FRACTION_MASK: u32 = (1 << FRACTION_BITS) - 1;
const FRACTION_UNIT: f32 = 1.0 / (1_u32 << FRACTION_BITS) as f32;
/// Most cells along an axis.
pub(crate) const MOST_CELLS: f64 = FIXED_POINT;
/// In place of a brick without drops.
pub(crate) const NO_BRICK: u32 = u32::MAX;

/// What is interpolated between nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Radius and number density, each on its own, as published systems do it. Lanes: radius (um),
    /// number density (1/m³), effective variance, optical depth.
    RadiusDensity,
    /// The area moments: between nodes of different drops lies their mixture. Lanes: M2, M3, M4,
    /// optical depth.
    Moments,
}

/// The field at a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// N <r²> (um²/m³).
    pub m2: f32,
    /// N <r³> (um³/m³).
    pub m3: f32,
    /// N <r⁴> (um⁴/m³).
    pub m4: f32,
    /// Optical depth of the drops towards the sun.
    pub tau_sun: f32,
}

impl Sample {
    /// The moments alone.
    pub fn moments(&self) -> AreaMoments {
        AreaMoments {
            m2: self.m2,
            m3: self.m3,
            m4: self.m4,
        }
    }
}

/// A mode, ready for sampling along rays.
#[derive(Debug, Clone)]
pub struct Bricks {
    interpolation: Interpolation,
    voxel_m: f64,
    inverse_voxel_m: f64,
    /// World position of lattice node 0, the lowest corner of the box with drops.
    origin_m: DVec3,
    n_cells: IVec3,
    /// Bricks of the bounding box along each axis.
    n_slots: IVec3,
    /// Number of the brick at each place of the bounding box, or [`NO_BRICK`].
    slots: Vec<u32>,
    /// Place of each brick, in bricks.
    places: Vec<IVec3>,
    /// Bounds on M2 inside each brick (um²/m³).
    m2_ranges: Vec<(f32, f32)>,
    /// Cells without drops of each brick.
    empty_cells: Vec<CellMask>,
    /// Errors of coarser cells of each brick.
    coarse_errors: Vec<CoarseErrors>,
    /// Lanes of all nodes, brick by brick, x slowest.
    nodes: Vec<Vec4>,
    /// M2 of all nodes in the same order (um²/m³); empty unless it is what is interpolated.
    m2: Vec<f32>,
}

impl Bricks {
    /// Lay out a mode (in parallel by brick, the same result for any number of threads).
    ///
    /// # Errors
    /// [`Error::TooManyNodes`] if the bricks would not fit into memory.
    pub fn build(mode: &DropMode, interpolation: Interpolation) -> Result<Self, Error> {
        let Lattice {
            low,
            n_cells,
            n_slots,
        } = Lattice::of(mode)?;
        let (slots, places) = occupied(mode, low, n_slots);
        let n_nodes = places.len() * NODES_PER_BRICK;
        if n_nodes as u64 > node_limit() {
            return Err(Error::too_many_nodes(n_nodes as f64));
        }
        let mut nodes = vec![Vec4::ZERO; n_nodes];
        let bricks = nodes.par_chunks_mut(NODES_PER_BRICK).zip(&places);
        let fill = |(lanes, place): (&mut [Vec4], &IVec3)| {
            fill_brick(mode, interpolation, low + *place * BRICK_DIM, lanes);
            (m2_range(interpolation, lanes), cells_without_drops(lanes))
        };
        let (m2_ranges, empty_cells) = bricks.map(fill).unzip();
        let m2 = match interpolation {
            Interpolation::Moments => nodes.par_iter().map(|lanes| lanes.x).collect(),
            Interpolation::RadiusDensity => Vec::new(),
        };
        Ok(Self {
            coarse_errors: vec![TOO_COARSE; places.len()],
            interpolation,
            voxel_m: mode.voxel_m(),
            inverse_voxel_m: 1.0 / mode.voxel_m(),
            origin_m: mode.node_position(low.to_array()),
            n_cells,
            n_slots,
            slots,
            m2_ranges,
            empty_cells,
            places,
            nodes,
            m2,
        })
    }

    /// What is interpolated.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Lowest and highest corner of the box outside of which there are no drops (m); `None` if
    /// there are none at all.
    pub fn world_bounds(&self) -> Option<(DVec3, DVec3)> {
        let size = self.n_cells.as_dvec3() * self.voxel_m;
        (!self.places.is_empty()).then_some((self.origin_m, self.origin_m + size))
    }

    /// Edge length of a cell (m).
    pub fn voxel_m(&self) -> f64 {
        self.voxel_m
    }

    /// Number of bricks that exist.
    pub fn n_bricks(&self) -> usize {
        self.places.len()
    }

    /// Bytes that the nodes take.
    pub fn memory_bytes(&self) -> usize {
        let nodes = size_of_val(self.nodes.as_slice()) + size_of_val(self.m2.as_slice());
        let empty = size_of_val(self.empty_cells.as_slice());
        let coarse = size_of_val(self.coarse_errors.as_slice());
        nodes + empty + coarse + size_of_val(self.slots.as_slice())
    }

    /// Bound on the extinction without diffraction at any point (1/m): with moments the largest
    /// value that occurs, with radius and density at most a brick's largest values multiplied.
    pub fn max_extinction_m1_q1(&self) -> f64 {
        let m2 = self
            .m2_ranges
            .iter()
            .fold(0.0, |most: f32, range| most.max(range.1));
        M2_PER_UM2 * std::f64::consts::PI * f64::from(m2)
    }

    /// Which drops there are; `None` if there are none.
    pub fn size_range(&self) -> Option<SizeRange> {
        let bricks = self.nodes.par_chunks(NODES_PER_BRICK);
        let of_brick = |lanes: &[Vec4]| brick_sizes(self.interpolation, lanes);
        bricks.filter_map(of_brick).reduce_with(SizeRange::union)
    }

    /// The field at a point; zero outside the bricks.
    #[inline]
    pub fn sample(&self, world: DVec3) -> Sample {
        self.locate(world)
            .map_or_else(Sample::default, |(base, local)| {
                self.sample_cell(base, local)
            })
    }

    /// M2 at a point (um²/m³), bit for bit that of [`Bricks::sample`]; zero outside the bricks.
    #[inline]
    pub fn m2(&self, world: DVec3) -> f32 {
        self.locate(world)
            .map_or(0.0, |(base, local)| self.m2_in_cell(base, local))
    }

    /// The cell around a point, by the place of its lowest corner, and local coordinates in 0..1, to
    /// 24 bits.
    #[allow(
        clippy::inline_always,
        reason = "a call hands the coordinates over in memory, which takes a third of the time"
    )]
    #[inline(always)]
    fn locate(&self, world: DVec3) -> Option<(usize, Vec3)> {
        // A product where `to_lattice` divides: three divisions would take as long as the rest.
        let position = (world - self.origin_m) * self.inverse_voxel_m;
        let fixed = (position + FIXED_POINT)
            .to_array()
            .map(|sum| sum.to_bits().wrapping_sub(FIXED_POINT.to_bits()));
        let place = fixed.map(|fixed| fixed >> (FRACTION_BITS + 3));
        let n_slots = self.n_slots.as_u64vec3().to_array();
        // Coordinates below 0, from 2^28 on and NaN are beyond any box in these bits.
        if !(place[0] < n_slots[0] && place[1] < n_slots[1] && place[2] < n_slots[2]) {
            return None;
        }
        // Inside the box nothing overflows; checks would cost a tenth of the time.
        let row = place[0].wrapping_mul(n_slots[1]).wrapping_add(place[1]);
        let brick = self.slots[row.wrapping_mul(n_slots[2]).wrapping_add(place[2]) as usize];
        if brick == NO_BRICK {
            return None;
        }
        let [x, y, z] = fixed.map(|fixed| (fixed >> FRACTION_BITS) as usize % BRICK_DIM as usize);
        // Through i32, which has a conversion of its own.
        let local = fixed.map(|fixed| (fixed as u32 & FRACTION_MASK) as i32 as f32);
        let base = brick as usize * NODES_PER_BRICK + x * STRIDE_X + y * STRIDE_Y + z;
        Some((base, Vec3::from(local) * FRACTION_UNIT))
    }

    /// The cells that a ray crosses between two distances, in order, those without drops left out.
    ///
    /// The point at distance t is `origin + t direction`; a unit direction makes t metres. Each
    /// cell's exit is exactly the entry of the next one that it touches, and a ray that runs in a
    /// face between cells belongs to the upper one.
    #[inline]
    pub fn segments(&self, origin: DVec3, direction: DVec3, t_range: (f64, f64)) -> Segments<'_> {
        self.coarse_segments(origin, direction, t_range, 0.0)
    }

    /// The same by cells 2, 4 or 8 voxels wide where these err by no more than `relative_error`; where
    /// that is 0, no cell is coarse.
    #[inline]
    pub fn coarse_segments(
        &self,
        origin: DVec3,
        direction: DVec3,
        t_range: (f64, f64),
        relative_error: f64,
    ) -> Segments<'_> {
        Segments::new(
            self,
            LatticeRay::new(self.to_lattice(origin), direction / self.voxel_m),
            t_range,
            relative_error as f32,
        )
    }

    /// Lattice coordinates of a world position: whole numbers are nodes.
    #[inline]
    fn to_lattice(&self, world: DVec3) -> DVec3 {
        (world - self.origin_m) / self.voxel_m
    }

    /// Number of cells along each axis.
    pub(crate) fn n_cells(&self) -> IVec3 {
        self.n_cells
    }

    /// The brick around a cell inside the lattice, or [`NO_BRICK`].
    #[inline]
    pub(crate) fn brick_of(&self, cell: IVec3) -> u32 {
        let place: IVec3 = cell >> 3;
        let slot = (place.x * self.n_slots.y + place.y) * self.n_slots.z + place.z;
        self.slots[slot as usize]
    }

    /// Whether a brick's cell has no drops.
    #[inline]
    pub(crate) fn is_empty_cell(&self, brick: u32, cell: IVec3) -> bool {
        let inside = cell & (BRICK_DIM - 1);
        let layer = self.empty_cells[brick as usize][inside.x as usize];
        layer >> (BRICK_DIM * inside.y + inside.z) & 1 == 1
    }

    /// Width in voxels of the coarsest cell around a brick's voxel that errs by no more than
    /// `relative_error`, and its error or [`NO_DROPS`]. Where no cell with drops is coarse, none is: wide
    /// empty ones alone are not worth a choice at every other voxel.
    #[inline]
    pub(crate) fn coarsest_cell(
        &self,
        brick: u32,
        voxel: IVec3,
        relative_error: f32,
    ) -> (i32, f32) {
        match self.coarse_errors.get(brick as usize) {
            // One empty cell.
            None => (BRICK_DIM, NO_DROPS),
            Some(_) if !self.has_coarse_cells(brick, relative_error) => (1, 0.0),
            Some(errors) => errors.coarsest(voxel, relative_error),
        }
    }

    /// Whether that is wider than a voxel somewhere in a brick with drops.
    #[inline]
    pub(crate) fn has_coarse_cells(&self, brick: u32, relative_error: f32) -> bool {
        let errors = self.coarse_errors.get(brick as usize);
        relative_error > 0.0 && errors.is_some_and(|errors| errors.allow(relative_error))
    }

    /// Bounds on M2 inside a brick (um²/m³).
    pub(crate) fn m2_range(&self, brick: u32) -> (f32, f32) {
        self.m2_ranges[brick as usize]
    }

    #[inline]
    fn m2_in_cell(&self, base: usize, local: Vec3) -> f32 {
        match self.interpolation {
            Interpolation::Moments => trilinear_scalar(&self.m2[base..base + CELL_SPAN], local),
            Interpolation::RadiusDensity => self.sample_cell(base, local).m2,
        }
    }

    /// The field inside a cell at local coordinates in 0..=1.
    #[inline]
    pub(crate) fn sample_cell(&self, base: usize, local: Vec3) -> Sample {
        let cell = &self.nodes[base..base + CELL_SPAN];
        match self.interpolation {
            Interpolation::Moments => {
                let [m2, m3, m4, tau_sun] = trilinear(cell, local, |lanes: Vec4| lanes).to_array();
                Sample {
                    m2,
                    m3,
                    m4,
                    tau_sun,
                }
            }
            Interpolation::RadiusDensity => sample_radius_density(cell, local),
        }
    }

    /// All lanes inside a cell on the line from `start` to `start + way` in local coordinates.
    #[inline]
    pub(crate) fn cubic_in_cell(&self, cell: Cell, start: Vec3A, way: Vec3A) -> [Vec4; 4] {
        if cell.width > 1 {
            self.cubic_in_coarse_cell(cell, start, way)
        } else {
            trilinear_along::<1>(&self.nodes[cell.base..], start, way)
        }
    }

    // In one `match` with the others, cells of one voxel took 4 % more instructions.
    fn cubic_in_coarse_cell(&self, cell: Cell, start: Vec3A, way: Vec3A) -> [Vec4; 4] {
        let nodes = &self.nodes[cell.base..];
        match cell.width {
            2 => trilinear_along::<2>(nodes, start, way),
            4 => trilinear_along::<4>(nodes, start, way),
            _ => trilinear_along::<8>(nodes, start, way),
        }
    }
}

/// A cell among the nodes of the bricks.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// Place in `nodes` of its lowest corner.
    pub(crate) base: usize,
    /// Its edge in voxels.
    pub(crate) width: i32,
}

/// The trilinear interpolant on the line start + x way, as a cubic of x: linear along the edges,
/// quadratic on two faces, cubic between them. Where all corners are equal, so are all values: the
/// differences vanish exactly. The cell is `WIDTH` voxels wide, from the first node on.
#[inline]
fn trilinear_along<const WIDTH: usize>(nodes: &[Vec4], start: Vec3A, way: Vec3A) -> [Vec4; 4] {
    let cell = &nodes[..=WIDTH * (CELL_SPAN - 1)];
    let edge = |low: usize| {
        let low = WIDTH * low;
        let rise = cell[low + WIDTH * STRIDE_X] - cell[low];
        [cell[low] + rise * start.x, rise * way.x]
    };
    let face = |[a0, a1]: [Vec4; 2], [b0, b1]: [Vec4; 2]| {
        let (d0, d1) = (b0 - a0, b1 - a1);
        [
            a0 + d0 * start.y,
            a1 + d1 * start.y + d0 * way.y,
            d1 * way.y,
        ]
    };
    let [a0, a1, a2] = face(edge(0), edge(STRIDE_Y));
    let [b0, b1, b2] = face(edge(1), edge(STRIDE_Y + 1));
    let (d0, d1, d2) = (b0 - a0, b1 - a1, b2 - a2);
    [
        a0 + d0 * start.z,
        a1 + d1 * start.z + d0 * way.z,
        a2 + d2 * start.z + d1 * way.z,
        d2 * way.z,
    ]
}

/// Place in `nodes` of the lowest corner of a cell.
#[inline]
pub(crate) fn cell_base(brick: u32, cell: IVec3) -> usize {
    let inside = cell & (BRICK_DIM - 1);
    let (x, y, z) = (inside.x as usize, inside.y as usize, inside.z as usize);
    brick as usize * NODES_PER_BRICK + x * STRIDE_X + y * STRIDE_Y + z
}

#[inline]
fn lerp<T: Copy + Add<Output = T> + Mul<f32, Output = T>>(a: T, b: T, t: f32) -> T {
    a * (1.0 - t) + b * t
}

#[inline]
fn trilinear<N, T>(cell: &[N], local: Vec3, value: impl Fn(N) -> T) -> T
where
    N: Copy,
    T: Copy + Add<Output = T> + Mul<f32, Output = T>,
{
    // Written out: closures for the rows were not inlined, which doubled the time.
    let along_x = |low: usize| lerp(value(cell[low]), value(cell[low + STRIDE_X]), local.x);
    let low = lerp(along_x(0), along_x(STRIDE_Y), local.y);
    let high = lerp(along_x(1), along_x(STRIDE_Y + 1), local.y);
    lerp(low, high, local.z)
}

/// The same of one value a node, in the same order, four products at a time.
#[inline]
fn trilinear_scalar(cell: &[f32], local: Vec3) -> f32 {
    let plane = |at: usize| {
        Vec4::new(
            cell[at],
            cell[at + 1],
            cell[at + STRIDE_Y],
            cell[at + STRIDE_Y + 1],
        )
    };
    let rows = lerp(plane(0), plane(STRIDE_X), local.x);
    let pair = lerp(rows, rows.zwzw(), local.y);
    lerp(pair.x, pair.y, local.z)
}

/// The nodes around a cell.
fn corners(cell: &[Vec4]) -> impl Iterator<Item = &Vec4> {
    [
        0,
        1,
        STRIDE_Y,
        STRIDE_Y + 1,
        STRIDE_X,
        STRIDE_X + 1,
        STRIDE_X + STRIDE_Y,
        CELL_SPAN - 1,
    ]
    .into_iter()
    .map(|at| &cell[at])
}

/// The literal reading of the papers: N and r are trilinear, and then M2 = N <r²>.
fn sample_radius_density(cell: &[Vec4], local: Vec3) -> Sample {
    let [radius, number_density, variance, tau_sun] =
        trilinear(cell, local, |lanes: Vec4| lanes).to_array();
    // Share of the corners that have drops; the other corners hold a radius of 0.
    let share = if corners(cell).all(|lanes| lanes.x > 0.0) {
        1.0
    } else {
        trilinear(cell, local, |lanes: Vec4| {
            Vec4::from(lanes.cmpgt(Vec4::ZERO))
        })
        .x
    };
    if share <= 0.0 {
        return Sample {
            tau_sun,
            ..Sample::default()
        };
    }
    let (r_e, v_e) = (radius / share, variance / share);
    let m2 = number_density * r_e * r_e * (1.0 - v_e) * (1.0 - 2.0 * v_e);
    let m3 = r_e * m2;
    Sample {
        m2,
        m3,
        m4: (1.0 + v_e) * r_e * m3,
        tau_sun,
    }
}

#[cfg(test)]
#[path = "bricks_tests.rs"]
mod tests;
