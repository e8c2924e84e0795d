//! What the camera can see of the drops: scattering angles, distances and lengths, as bounds.
//!
//! The picture is cut into blocks of pixels. The rays of a block are `w = f + x r + y u`, `f`
//! forward, with (x, y) in a rectangle. Every quantity below holds for all of them, not for samples:
//! * the angle between the block's middle ray and any other is largest at a corner, because
//!   directions within an angle of the middle form a convex cone;
//! * the components of `w` are linear in (x, y), so their extremes are at the corners, and the slabs
//!   of the box give intervals of the ray parameter: entry at or after the largest of the smallest
//!   entries, exit at or before the smallest of the largest exits.
//!
//! theta is the scattering angle, cos theta = s . d, `s` towards the sun, `d` from the eye. m is the
//! difference of the squared heights of the unit vectors along s + d and s - d
//! ([`flattening_along`]). A square changes by at most the turn of its vector, and a turn of d by an
//! angle a turns the two by at most a/(2 cos(theta/2)) and a/(2 sin(theta/2)).

use std::f64::consts::PI;

use glam::DVec3;
use niji_geometry::Aabb;
use niji_geometry::PinholeCamera;
use niji_render::flattening_along;

/// Most blocks along the width and the height of the picture.
const MAX_BLOCKS: (u32, u32) = (32, 24);

/// A rectangle of pixels, with bounds that hold for each of its rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Block {
    /// Share of the picture's pixels, 0..1.
    pub(super) share: f64,
    /// Smallest and largest scattering angle, rad.
    pub(super) theta_rad: (f64, f64),
    /// Smallest and largest m, by which flat drops move the bow.
    pub(super) flattening: (f64, f64),
    /// Unit vectors to the corners and the middle.
    pub(super) samples: [DVec3; 5],
    /// What the rays may meet of the drops; `None` where all of them miss.
    pub(super) drops: Option<Chord>,
    /// Largest optical depth of the drops on any ray, Q = 1.
    pub(super) depth: f64,
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

/// A part of the drops' box and the largest extinction in it at Q = 1 (1/m).
pub(super) type Part = (Aabb, f64);

/// Where drops are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent<'a> {
    /// The box outside of which there are none.
    pub(super) whole: Aabb,
    /// Largest extinction of all modes together at Q = 1 (1/m).
    pub(super) extinction_m1: f64,
    /// Boxes that hold all drops; those of several modes may overlap.
    pub(super) parts: &'a [Part],
}

/// Cuts the picture into blocks. The optical depth of a ray is at most the sum over the parts of
/// their extinction times its way inside, and at most the largest extinction times its way through
/// the whole.
pub(super) fn blocks(camera: &PinholeCamera, sun: DVec3, drops: &Extent<'_>) -> Vec<Block> {
    let (width, height) = (camera.width_px(), camera.height_px());
    let (n_x, n_y) = (width.min(MAX_BLOCKS.0), height.min(MAX_BLOCKS.1));
    let edge = |index: u32, n: u32, size: u32| {
        f64::from((u64::from(index) * u64::from(size) / u64::from(n)) as u32)
    };
    let mut blocks = Vec::with_capacity((n_x * n_y) as usize);
    for row in 0..n_y {
        let y_px = (edge(row, n_y, height), edge(row + 1, n_y, height));
        for column in 0..n_x {
            let x_px = (edge(column, n_x, width), edge(column + 1, n_x, width));
            let rectangle = Rectangle { x_px, y_px };
            blocks.push(rectangle.block(camera, sun, drops));
        }
    }
    blocks
}

struct Rectangle {
    x_px: (f64, f64),
    y_px: (f64, f64),
}

impl Rectangle {
    fn block(&self, camera: &PinholeCamera, sun: DVec3, drops: &Extent<'_>) -> Block {
        let ((x0, x1), (y0, y1)) = (self.x_px, self.y_px);
        let ray = |x, y| camera.ray(x, y).direction;
        let middle = ray(0.5 * (x0 + x1), 0.5 * (y0 + y1));
        let corners = [ray(x0, y0), ray(x1, y0), ray(x0, y1), ray(x1, y1)];
        let radius_rad = corners
            .iter()
            .map(|corner| angle_rad(middle, *corner))
            .fold(0.0, f64::max);
        let theta_rad = angle_rad(middle, sun);
        let theta_range_rad = (
            (theta_rad - radius_rad).max(0.0),
            (theta_rad + radius_rad).min(PI),
        );
        let whole_chord = chord(camera, &corners, &drops.whole);
        let depth = whole_chord.map_or(0.0, |whole| {
            let in_part = |(bounds, extinction_m1): &Part| {
                chord(camera, &corners, bounds).map_or(0.0, |c| extinction_m1 * c.length_m)
            };
            let sum: f64 = drops.parts.iter().map(in_part).sum();
            sum.min(drops.extinction_m1 * whole.length_m)
        });
        let pixels = f64::from(camera.width_px()) * f64::from(camera.height_px());
        Block {
            share: (x1 - x0) * (y1 - y0) / pixels,
            theta_rad: theta_range_rad,
            flattening: flattening(flattening_along(middle, sun), radius_rad, theta_range_rad),
            samples: [corners[0], corners[1], corners[2], corners[3], middle],
            drops: whole_chord,
            depth,
        }
    }
}

/// m of all rays within an angle of one.
fn flattening(of_middle: f64, radius_rad: f64, (low_rad, high_rad): (f64, f64)) -> (f64, f64) {
    // At the antisolar point and at the sun nothing is known but that m lies within -1 to 1.
    let turn = 0.5 * radius_rad / (0.5 * high_rad).cos().max(f64::MIN_POSITIVE)
        + 0.5 * radius_rad / (0.5 * low_rad).sin().max(f64::MIN_POSITIVE);
    ((of_middle - turn).max(-1.0), (of_middle + turn).min(1.0))
}

/// Angle between unit vectors without the loss of an arc cosine near 0 and pi.
fn angle_rad(a: DVec3, b: DVec3) -> f64 {
    2.0 * (a - b).length().atan2((a + b).length())
}

/// Interval arithmetic of the slab test over all rays between the corners.
fn chord(camera: &PinholeCamera, corners: &[DVec3; 4], bounds: &Aabb) -> Option<Chord> {
    let forward = camera.forward();
    let eye = camera.position();
    // w has the length 1 along the optical axis, so that it is linear in the pixel.
    let rays = corners.map(|corner| corner / corner.dot(forward));
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let components = rays.map(|ray| ray[axis]);
        let low = components.into_iter().fold(f64::INFINITY, f64::min);
        let high = components.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let (axis_enter, axis_leave) = slab(
            (bounds.min[axis] - eye[axis], bounds.max[axis] - eye[axis]),
            (low, high),
        )?;
        enter = enter.max(axis_enter);
        leave = leave.min(axis_leave);
    }
    if enter >= leave {
        return None;
    }
    let longest = rays.iter().map(|ray| ray.length()).fold(0.0, f64::max);
    let farthest_m = farthest_corner_m(eye, bounds);
    let leave_m = (leave * longest).min(farthest_m);
    let length_m = ((leave - enter) * longest)
        .min(bounds.size().length())
        .min(leave_m);
    Some(Chord {
        enter_m: enter.min(leave_m),
        leave_m,
        length_m,
    })
}

/// Earliest entry into and latest exit from a slab at `near..far` relative to the eye, for all
/// components `low..high` of the direction; `None` if every ray leads away from it.
fn slab((near, far): (f64, f64), (low, high): (f64, f64)) -> Option<(f64, f64)> {
    if near <= 0.0 && far >= 0.0 {
        // A ray of component 0 never leaves, and there is one among components of both signs.
        let leave = if low > 0.0 {
            far / low
        } else if high < 0.0 {
            near / high
        } else {
            f64::INFINITY
        };
        return Some((0.0, leave));
    }
    // Mirror a slab on the negative side.
    let (near, far, low, high) = if near > 0.0 {
        (near, far, low, high)
    } else {
        (-far, -near, -high, -low)
    };
    if high <= 0.0 {
        return None;
    }
    let leave = if low > 0.0 { far / low } else { f64::INFINITY };
    Some((near / high, leave))
}

fn farthest_corner_m(eye: DVec3, bounds: &Aabb) -> f64 {
    (bounds.min - eye)
        .abs()
        .max((bounds.max - eye).abs())
        .length()
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
mod tests {
    use niji_geometry::PinholeRequest;
    use niji_geometry::direction_from_azimuth_elevation;
    use niji_radiometry::Radians;

    use super::*;

    const WIDTH: u32 = 90;
    const HEIGHT: u32 = 70;

    fn camera(position: DVec3, azimuth_deg: f64, elevation_deg: f64) -> PinholeCamera {
        PinholeCamera::new(PinholeRequest {
            position,
            azimuth: Radians::from_degrees(azimuth_deg),
            elevation: Radians::from_degrees(elevation_deg),
            roll: Radians::from_degrees(13.0),
            horizontal_fov: Radians::from_degrees(100.0),
            width_px: WIDTH,
            height_px: HEIGHT,
        })
        .unwrap()
    }

    fn extent(whole: &Aabb) -> Extent<'static> {
        Extent {
            whole: *whole,
            extinction_m1: 1.0,
            parts: &[],
        }
    }

    /// The block that holds a pixel.
    fn block_of(blocks: &[Block], x: u32, y: u32) -> &Block {
        let find = |p: u32, size: u32, n: u32| {
            (0..n)
                .find(|i| u64::from(p) < u64::from(i + 1) * u64::from(size) / u64::from(n))
                .unwrap()
        };
        let row = find(y, HEIGHT, MAX_BLOCKS.1) * MAX_BLOCKS.0;
        &blocks[(row + find(x, WIDTH, MAX_BLOCKS.0)) as usize]
    }

    #[test]
    fn bounds_hold_for_every_ray_of_every_pixel() {
        let bounds = Aabb {
            min: DVec3::new(-60.0, -5.0, -90.0),
            max: DVec3::new(30.0, 40.0, -20.0),
        };
        let sun = direction_from_azimuth_elevation(Radians(3.0), Radians(0.4));
        for (position, azimuth_deg, elevation_deg) in [
            (DVec3::new(0.0, 1.6, 0.0), 0.0, 10.0),
            (DVec3::new(0.0, 1.6, -50.0), 70.0, -20.0),
            (DVec3::new(50.0, 80.0, -100.0), 230.0, -40.0),
            (DVec3::new(0.0, 1.6, 0.0), 180.0, 80.0),
        ] {
            let camera = camera(position, azimuth_deg, elevation_deg);
            let blocks = blocks(&camera, sun, &extent(&bounds));
            for y in 0..HEIGHT {
                for x in 0..WIDTH {
                    let ray = camera.ray(f64::from(x) + 0.3, f64::from(y) + 0.9);
                    let block = block_of(&blocks, x, y);
                    let theta = ray.direction.dot(sun).clamp(-1.0, 1.0).acos();
                    let slack = 1e-7;
                    assert!(theta >= block.theta_rad.0 - slack);
                    assert!(theta <= block.theta_rad.1 + slack);
                    let m = flattening_along(ray.direction, sun);
                    assert!(m >= block.flattening.0 - slack && m <= block.flattening.1 + slack);
                    if let Some((enter, leave)) = bounds.intersect(&ray) {
                        let chord = block.drops.expect("a ray of the block meets the box");
                        assert!(enter >= chord.enter_m - slack && leave <= chord.leave_m + slack);
                        assert!(leave - enter <= chord.length_m + slack);
                    }
                }
            }
            assert!((blocks.iter().map(|block| block.share).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn bounds_are_tight_in_the_middle_of_a_distant_box() {
        let bounds = Aabb {
            min: DVec3::new(-90.0, -90.0, -120.0),
            max: DVec3::new(90.0, 90.0, -100.0),
        };
        let camera = camera(DVec3::ZERO, 0.0, 0.0);
        let blocks = blocks(&camera, DVec3::Y, &extent(&bounds));
        let chord = block_of(&blocks, WIDTH / 2, HEIGHT / 2).drops.unwrap();
        assert!(chord.length_m < 1.05 * 20.0, "{chord:?}");
        assert!(chord.enter_m > 99.9 && chord.leave_m < 121.0, "{chord:?}");
    }

    #[test]
    fn a_camera_that_looks_away_sees_no_drops() {
        let bounds = Aabb {
            min: DVec3::new(-9.0, 0.0, -30.0),
            max: DVec3::new(9.0, 9.0, -20.0),
        };
        let blocks = blocks(&camera(DVec3::ZERO, 180.0, 0.0), DVec3::Y, &extent(&bounds));
        assert!(blocks.iter().all(|block| block.drops.is_none()));
    }

    #[test]
    fn optical_depth_is_bounded_by_the_parts_that_a_ray_crosses() {
        let part = |x: f64| Aabb {
            min: DVec3::new(x, -9.0, -30.0),
            max: DVec3::new(x + 4.0, 9.0, -20.0),
        };
        let whole = Aabb {
            min: part(-20.0).min,
            max: part(16.0).max,
        };
        let parts = [(part(-20.0), 0.3), (part(16.0), 0.1)];
        let camera = camera(DVec3::ZERO, 0.0, 0.0);
        let drops = Extent {
            whole,
            extinction_m1: 0.3,
            parts: &parts,
        };
        for block in blocks(&camera, DVec3::Y, &drops) {
            assert!(block.depth <= 0.3 * block.drops.map_or(0.0, |chord| chord.length_m));
        }
        let drops = blocks(&camera, DVec3::Y, &drops);
        let middle = block_of(&drops, WIDTH / 2, HEIGHT / 2);
        assert!(middle.drops.is_some() && middle.depth < 1e-12, "{middle:?}");
        assert!(drops.iter().any(|block| block.depth > 1.0));
    }

    #[test]
    fn the_longest_chord_of_a_cube_is_its_diagonal() {
        let cube = Aabb {
            min: DVec3::ZERO,
            max: DVec3::ONE,
        };
        let diagonal = longest_chord_m(&cube, DVec3::ONE.normalize());
        assert!((diagonal - 3.0_f64.sqrt()).abs() < 1e-15);
        assert!((longest_chord_m(&cube, DVec3::Y) - 1.0).abs() < 1e-15);
    }
}
