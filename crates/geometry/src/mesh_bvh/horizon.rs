//! What a mesh covers of the sights along an azimuth.
//!
//! s = h/d over what of a triangle stands in the half plane of the azimuth
//! `d` horizontal distance from the eye, `h` height over it. A triangle is a straight piece in that half plane, along
//! which s is monotonic, so that it covers what lies between its ends. A box is passed over where all that it may cover is
//! covered already.

use glam::DVec2;
use glam::DVec3;

use super::Child;
use super::MeshBvh;
use super::Waiting;
use crate::aabb::Aabb;
use crate::covered_slopes::CoveredSlopes;
use crate::level_look::LevelLook;

impl MeshBvh {
    /// Cover the slopes of sights, from a point along a horizontal unit vector, in which triangles stand.
    pub fn cover(&self, from: DVec3, along: DVec3, covered: &mut CoveredSlopes) {
        let look = LevelLook::new(level(from), level(along));
        let seen = |bounds: &Aabb| {
            let (enter, slopes) = slopes_of_box(bounds, from.y, &look)?;
            Some((enter as f32, slopes))
        };
        let mut waiting = Waiting::new();
        let mut child = Child::default();
        while !covered.are_all() {
            if child.n_triangles == 0 {
                let boxes = &self.nodes[child.start as usize].boxes;
                let enter = |index| match boxes.get(index).as_ref().and_then(seen) {
                    Some((enter, slopes)) if !covered.hold(slopes) => enter,
                    _ => f32::INFINITY,
                };
                waiting.push_nearest_last(child.start, std::array::from_fn(enter));
            }
            for &triangle in self.triangles_of(child) {
                let corners = self.mesh.corners(triangle as usize);
                if let Some(slopes) = slopes_of_triangle(corners, from.y, &look) {
                    covered.add(slopes);
                }
            }
            let Some((_, place)) = waiting.next() else {
                return;
            };
            child = self.child(place);
        }
    }
}

fn level(vector: DVec3) -> DVec2 {
    DVec2::new(vector.x, vector.z)
}

/// Where a look enters a box, and the slopes between which it may meet from a height what is there; `None` where it passes by.
fn slopes_of_box(bounds: &Aabb, height: f64, look: &LevelLook) -> Option<(f64, [f64; 2])> {
    let (enter, leave) = look.within(level(bounds.min), level(bounds.max))?;
    let [low, high] = [bounds.min, bounds.max].map(|corner| corner.y - height);
    let slopes = [
        low / if low < 0.0 { enter } else { leave },
        high / if high > 0.0 { enter } else { leave },
    ];
    Some((enter, slopes))
}

/// Slopes of the sights to a triangle from a height in the half plane of a look; `None` where it is not there.
fn slopes_of_triangle(corners: [DVec3; 3], height: f64, look: &LevelLook) -> Option<[f64; 2]> {
    // Off the half plane, distance along it, height.
    let seen = corners.map(|corner| {
        let way = level(corner) - look.from;
        let rise = corner.y - height;
        (look.along.perp_dot(way), look.along.dot(way), rise)
    });
    // Neighbors find the same numbers at their edge: no sight slips between them.
    let crossing = |a: usize, b: usize| {
        let (left, right) = match (seen[a].0 < 0.0, seen[b].0 < 0.0) {
            (true, false) => (seen[a], seen[b]),
            (false, true) => (seen[b], seen[a]),
            _ => return None,
        };
        let share = left.0 / (left.0 - right.0);
        let between = |left: f64, right: f64| left + share * (right - left);
        Some((between(left.1, right.1), between(left.2, right.2)))
    };
    let edges = [(0, 1), (1, 2), (2, 0)];
    let mut crossings = edges.into_iter().filter_map(|(a, b)| crossing(a, b));
    let (one, other) = (crossings.next()?, crossings.next()?);
    let (near, far) = if one.0 <= other.0 {
        (one, other)
    } else {
        (other, one)
    };
    if far.0 <= 0.0 {
        return None;
    }
    let to_far = far.1 / far.0;
    let to_near = if near.0 > 0.0 {
        near.1 / near.0
    } else {
        // It runs over the place or under it.
        let overhead = near.1 + (far.1 - near.1) * near.0 / (near.0 - far.0);
        f64::INFINITY.copysign(overhead)
    };
    Some([to_near.min(to_far), to_near.max(to_far)])
}
