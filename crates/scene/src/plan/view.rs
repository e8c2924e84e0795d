//! What the camera can see of the drops: scattering angles, distances and lengths, as bounds.
//!
//! The picture is cut into blocks of pixels. The rays of a block of a pinhole are `w = f + x r + y u`,
//! `f` forward, with (x, y) in a rectangle. Every quantity below holds for all of them, not for
//! samples:
//! * the angle between the block's middle ray and any other is largest at a corner, because
//!   directions within an angle of the middle form a convex cone;
//! * the components of `w` are linear in (x, y), so their extremes are at the corners, and the slabs
//!   of the box give intervals of the ray parameter: entry at or after the largest of the smallest
//!   entries, exit at or before the smallest of the largest exits.
//!
//! The rays of a block of another projection lie in the cone around one of them that
//! [`Camera::reach`] opens; unit vectors within an angle `a` of one with the component cos b have
//! components from cos(b + a) to cos(b - a).
//!
//! theta is the scattering angle, cos theta = s . d, `s` towards the sun, `d` from the eye. The rise of
//! a ray is the vertical component of the direction across `s` in which `d` leaves it,
//! (d - s cos theta)/sin theta: the cosine of its clock angle around the sun times that of the sun's
//! elevation. A turn of d by an angle a changes the clock angle by at most a/sin theta.

use std::f64::consts::PI;

use glam::DVec2;
use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::Camera;
use niji_geometry::EARTH;
use niji_geometry::PinholeCamera;
use niji_geometry::PixelRegion;
use niji_render::WaterSurface;

use super::depth::Bundle;
use super::drop_parts::DropPart;

/// Most blocks along the width and the height of the picture of a pinhole.
const MAX_BLOCKS: (u32, u32) = (32, 24);

/// The same of a picture that may show all directions, and of what waves blur.
const MAX_WIDE_BLOCKS: (u32, u32) = (64, 48);
const MAX_BLURRED_BLOCKS: (u32, u32) = (8, 6);

/// Water that goes on to the horizon ends here, and is as thick (m).
const FAR_M: f64 = 1e7;
const THIN_M: f64 = 1e-3;

/// How far the planet turns rays that go on from water 6 km away.
const CURVED_RAD: f64 = 0.002;

/// A rectangle of pixels, with bounds that hold for each of its rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    /// Share of the picture's pixels, 0..1.
    pub(super) share: f64,
    /// Its row and column in the picture; of rays that go on from water, none that counts.
    pub(super) place: (usize, usize),
    /// Smallest and largest scattering angle, rad.
    pub(super) theta_rad: (f64, f64),
    /// Smallest and largest rise, by which flat drops move the bow.
    pub(super) rise: (f64, f64),
    /// Unit vectors to the corners and the middle; where a corner shows nothing, another ray.
    pub(super) samples: [DVec3; 5],
    /// What the rays may meet of the drops; `None` where all of them miss.
    pub(super) drops: Option<Chord>,
    /// Largest optical depth of the drops on any ray, Q = 1.
    pub(super) depth: f64,
    /// The same between the sun and the ground that rays meet from above it; `None` where none does.
    pub(super) ground_sun_depth: Option<f64>,
}

/// Bounds on the way of rays through the drops' box.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_field_names, reason = "names end with their unit")]
pub(super) struct Chord {
    /// No ray enters before this distance, m.
    pub(super) enter_m: f64,
    /// No ray is inside beyond this distance, m.
    pub(super) leave_m: f64,
    /// No ray has a longer way inside, m.
    pub(super) length_m: f64,
}

/// Where drops are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent<'a> {
    /// The box outside of which there are none.
    pub(super) whole: Aabb,
    /// Largest extinction of all modes together at Q = 1 (1/m).
    pub(super) extinction_m1: f64,
    /// Boxes that hold all drops; those of several modes may overlap.
    pub(super) parts: &'a [DropPart],
}

/// Cuts a region of the picture into blocks. The optical depth of a ray is at most what the parts that
/// it crosses have, and at most the largest extinction times its way through the whole. Blocks in
/// which the camera sees nothing are left out.
pub(super) fn blocks(
    camera: &Camera,
    region: PixelRegion,
    sun: DVec3,
    drops: &Extent<'_>,
) -> Vec<Block> {
    let pixels = region.n_pixels() as f64;
    let block = |rectangle: Rectangle| {
        let ((x0, x1), (y0, y1)) = (rectangle.x_px, rectangle.y_px);
        let share = (x1 - x0) * (y1 - y0) / pixels;
        Some(Block {
            share,
            place: rectangle.place,
            ..rectangle.rays(camera)?.block(camera.position(), sun, drops)
        })
    };
    let rectangles = rectangles(region, most_blocks(camera)).into_iter();
    rectangles.filter_map(block).collect()
}

/// The blocks of the rays that go on from water, of whose light the picture has no more than all; none where no ray meets it.
///
/// They are those of an eye as far below the water: waves turn them as far as the streak of the sun reaches, and the planet
/// by less than [`CURVED_RAD`].
pub(super) fn blocks_in_water(
    camera: &Camera,
    region: PixelRegion,
    sun: DVec3,
    (drops, water): (&Extent<'_>, &WaterSurface),
) -> Vec<Block> {
    let eye = camera.position();
    if eye.y <= water.height_m {
        return Vec::new();
    }
    let corner = |corner: usize, y: f64| {
        let [x, z] = water.extent_m[corner]
            .clamp(-DVec2::splat(FAR_M), DVec2::splat(FAR_M))
            .into();
        DVec3::new(x, y, z)
    };
    let plane = Aabb {
        min: corner(0, water.height_m - THIN_M),
        max: corner(1, water.height_m + THIN_M),
    };
    let streak_rad = water.streak_reach().0;
    let block = |rectangle: Rectangle| {
        let rays = rectangle.rays(camera)?;
        rays.bundle(eye).range(&plane)?;
        let flip = DVec3::new(1.0, -1.0, 1.0);
        let middle = rays.middle * flip;
        let radius_rad = rays.radius_rad + streak_rad + CURVED_RAD;
        let rays = Rays {
            middle,
            radius_rad,
            samples: rays.samples.map(|ray| (ray * flip).with_y(ray.y.abs())),
            components: cone(middle, radius_rad),
            longest: 1.0,
        };
        let below = eye.with_y(2.0 * water.height_m - eye.y);
        Some(rays.block(below, sun, drops))
    };
    let most = if streak_rad > 0.0 {
        MAX_BLURRED_BLOCKS
    } else {
        most_blocks(camera)
    };
    let rectangles = rectangles(region, most).into_iter();
    rectangles.filter_map(block).collect()
}

/// Smallest and largest component along each axis of unit vectors within an angle of one.
fn cone(middle: DVec3, radius_rad: f64) -> [(f64, f64); 3] {
    [0, 1, 2].map(|axis| {
        let from_axis_rad = middle[axis].clamp(-1.0, 1.0).acos();
        (
            (from_axis_rad + radius_rad).min(PI).cos(),
            (from_axis_rad - radius_rad).max(0.0).cos(),
        )
    })
}

/// Rows and columns of the blocks of a region of a picture.
pub(super) fn n_blocks(camera: &Camera, region: PixelRegion) -> (usize, usize) {
    let (n_x, n_y) = n_rectangles(region, most_blocks(camera));
    (n_y as usize, n_x as usize)
}

fn n_rectangles(region: PixelRegion, most: (u32, u32)) -> (u32, u32) {
    (region.width_px.min(most.0), region.height_px.min(most.1))
}

/// Most blocks along the width and the height of a picture.
fn most_blocks(camera: &Camera) -> (u32, u32) {
    match camera {
        Camera::Pinhole(_) => MAX_BLOCKS,
        Camera::Fisheye(_) | Camera::Panorama(_) => MAX_WIDE_BLOCKS,
    }
}

fn rectangles(region: PixelRegion, most: (u32, u32)) -> Vec<Rectangle> {
    let (width, height) = (region.width_px, region.height_px);
    let corner = (f64::from(region.x_px), f64::from(region.y_px));
    let (n_x, n_y) = n_rectangles(region, most);
    let edge = |index: u32, n: u32, size: u32| {
        f64::from((u64::from(index) * u64::from(size) / u64::from(n)) as u32)
    };
    let mut rectangles = Vec::with_capacity((n_x * n_y) as usize);
    for row in 0..n_y {
        let y_px = [row, row + 1].map(|index| corner.1 + edge(index, n_y, height));
        let y_px = y_px.into();
        for column in 0..n_x {
            let x_px = [column, column + 1].map(|index| corner.0 + edge(index, n_x, width));
            let x_px = x_px.into();
            rectangles.push(Rectangle {
                place: (row as usize, column as usize),
                x_px,
                y_px,
            });
        }
    }
    rectangles
}

struct Rectangle {
    /// Row and column.
    place: (usize, usize),
    x_px: (f64, f64),
    y_px: (f64, f64),
}

/// The rays of a rectangle: each within an angle of one, and in a box of components.
struct Rays {
    middle: DVec3,
    radius_rad: f64,
    samples: [DVec3; 5],
    /// Smallest and largest component along each axis, of vectors of at most this length.
    components: [(f64, f64); 3],
    longest: f64,
}

impl Rays {
    /// The rays from an eye.
    fn bundle(&self, eye: DVec3) -> Bundle {
        Bundle {
            origin: Aabb { min: eye, max: eye },
            components: self.components,
            longest: self.longest,
        }
    }

    /// Bounds of the rays from an eye; of the picture nothing yet.
    fn block(&self, eye: DVec3, sun: DVec3, drops: &Extent<'_>) -> Block {
        let theta_rad = angle_rad(self.middle, sun);
        let theta_range_rad = (
            (theta_rad - self.radius_rad).max(0.0),
            (theta_rad + self.radius_rad).min(PI),
        );
        let bundle = self.bundle(eye);
        let whole_chord = chord(&bundle, &drops.whole);
        let depth = whole_chord.map_or(0.0, |whole| {
            let of_parts = bundle.largest_depth(drops.parts);
            of_parts.min(drops.extinction_m1 * whole.length_m)
        });
        Block {
            share: 0.0,
            place: (0, 0),
            theta_rad: theta_range_rad,
            rise: rises(self, sun, theta_range_rad),
            samples: self.samples,
            drops: whole_chord,
            depth,
            ground_sun_depth: self
                .ground(eye)
                .filter(|_| sun.y > 0.0)
                .map(|ground| Bundle::parallel(ground, sun).largest_depth(drops.parts)),
        }
    }

    /// A box of the ground that rays from an eye above it meet: from where they cross y = 0, below which it falls away, to
    /// its horizon.
    fn ground(&self, eye: DVec3) -> Option<Aabb> {
        let [x, (lowest, highest), z] = self.components;
        if eye.y < 0.0 || lowest >= 0.0 {
            return None;
        }
        let height_m = EARTH.height_m(eye).max(0.0);
        // No ray is shorter than its parameter, and the flattest goes farthest.
        let met_m = EARTH.distance_to_ground(height_m, highest / self.longest);
        let horizon_m = (height_m * (2.0 * EARTH.radius_m + height_m)).sqrt();
        let (nearest, farthest) = (eye.y / -lowest, met_m.unwrap_or(horizon_m));
        if nearest > farthest {
            return None;
        }
        let (low, high) = (DVec3::new(x.0, 0.0, z.0), DVec3::new(x.1, 0.0, z.1));
        let fall_m = EARTH.height_m(DVec3::X * (eye.x.hypot(eye.z) + farthest));
        let over = eye.with_y(0.0);
        Some(Aabb {
            min: over - DVec3::Y * fall_m + (low * nearest).min(low * farthest),
            max: over + (high * nearest).max(high * farthest),
        })
    }
}

impl Rectangle {
    /// Bounds of its rays; `None` if it has none.
    fn rays(&self, camera: &Camera) -> Option<Rays> {
        match camera {
            Camera::Pinhole(pinhole) => Some(self.between_corners(pinhole)),
            Camera::Fisheye(_) | Camera::Panorama(_) => self.in_a_cone(camera),
        }
    }

    fn corners(&self) -> [(f64, f64); 4] {
        let ((x0, x1), (y0, y1)) = (self.x_px, self.y_px);
        [(x0, y0), (x1, y0), (x0, y1), (x1, y1)]
    }

    fn middle(&self) -> (f64, f64) {
        let ((x0, x1), (y0, y1)) = (self.x_px, self.y_px);
        (0.5 * (x0 + x1), 0.5 * (y0 + y1))
    }

    fn between_corners(&self, camera: &PinholeCamera) -> Rays {
        let direction = |(x, y)| camera.ray(x, y).direction;
        let middle = direction(self.middle());
        let corners = self.corners().map(direction);
        let angles = corners.map(|corner| angle_rad(middle, corner));
        // w has the length 1 along the optical axis, so that it is linear in the pixel.
        let w = corners.map(|corner| corner / corner.dot(camera.forward()));
        let component = |axis: usize| {
            let values = w.map(|ray| ray[axis]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            (low, values.into_iter().fold(f64::NEG_INFINITY, f64::max))
        };
        let [a, b, c, d] = corners;
        Rays {
            middle,
            radius_rad: angles.into_iter().fold(0.0, f64::max),
            samples: [a, b, c, d, middle],
            components: [component(0), component(1), component(2)],
            longest: w.iter().map(|ray| ray.length()).fold(0.0, f64::max),
        }
    }

    fn in_a_cone(&self, camera: &Camera) -> Option<Rays> {
        let direction = |(x, y)| camera.ray(x, y).map(|ray| ray.direction);
        let size = (f64::from(camera.width_px()), f64::from(camera.height_px()));
        // Where the middle shows nothing, the place next to the middle of the picture is the last
        // that a fisheye's circle leaves.
        let innermost = (
            (0.5 * size.0).clamp(self.x_px.0, self.x_px.1),
            (0.5 * size.1).clamp(self.y_px.0, self.y_px.1),
        );
        let mut places = [self.middle(), innermost].into_iter();
        let (place, middle) = places.find_map(|place| Some((place, direction(place)?)))?;
        let farthest_px = self
            .corners()
            .map(|(x, y)| (x - place.0).hypot(y - place.1))
            .into_iter()
            .fold(0.0, f64::max);
        let radius_rad = camera.reach(place, farthest_px).0;
        let [a, b, c, d] = self
            .corners()
            .map(|corner| direction(corner).unwrap_or(middle));
        Some(Rays {
            middle,
            radius_rad,
            samples: [a, b, c, d, middle],
            components: cone(middle, radius_rad),
            longest: 1.0,
        })
    }
}

/// The rise of a ray; 0 towards the sun and away from it.
pub(super) fn rise(direction: DVec3, sun: DVec3) -> f64 {
    (direction - sun * sun.dot(direction)).normalize_or_zero().y
}

/// The rise of all rays of a bundle, at these scattering angles.
fn rises(rays: &Rays, sun: DVec3, (low_rad, high_rad): (f64, f64)) -> (f64, f64) {
    let steepest = sun.x.hypot(sun.z);
    // At the antisolar point and at the sun no more is known.
    let least_sine = low_rad.sin().min(high_rad.sin()).max(f64::MIN_POSITIVE);
    let (middle, turn) = (
        rise(rays.middle, sun),
        steepest * rays.radius_rad / least_sine,
    );
    (
        (middle - turn).max(-steepest),
        (middle + turn).min(steepest),
    )
}

/// Angle between unit vectors without the loss of an arc cosine near 0 and pi.
fn angle_rad(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

/// Interval arithmetic of the slab test over all rays of a block.
fn chord(rays: &Bundle, bounds: &Aabb) -> Option<Chord> {
    let (enter, leave) = rays.range(bounds)?;
    let leave_m = (leave * rays.longest).min(rays.farthest_m(bounds));
    let length_m = ((leave - enter) * rays.longest)
        .min(bounds.size().length())
        .min(leave_m);
    Some(Chord {
        enter_m: enter.min(leave_m),
        leave_m,
        length_m,
    })
}

/// Longest way through the box along a direction, m.
pub(super) fn longest_chord_m(bounds: &Aabb, direction: DVec3) -> f64 {
    let size = bounds.size();
    (0..3)
        .filter(|&axis| direction[axis].abs() > f64::MIN_POSITIVE)
        .map(|axis| size[axis] / direction[axis].abs())
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
#[path = "view_tests.rs"]
mod tests;
