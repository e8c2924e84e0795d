//! The horizon that heights make.
//!
//! tan e = max over d of (h(d) - y)/d
//! `d` horizontal distance along an azimuth, `h` height of the surface there, `y` that of the eye. Between the edges of
//! triangles h is linear in d and the slope of the sight monotonic, so the largest stands at an edge. A block is passed
//! over where its greatest height at its nearest point is not above what was found.

use glam::DVec2;
use glam::DVec3;

use super::HeightField;
use super::walk::Walk;

/// What is nearer is the place itself, cells.
const LEAST: f64 = 1e-6;

/// Sights along an azimuth.
struct Look {
    from: DVec2,
    along: DVec2,
    /// Height of the eye over that of the corner of the field (m).
    eye_m: f64,
}

impl HeightField {
    /// Tangent of the elevation up to which the surface stands, from a point along a horizontal unit vector; `least`,
    /// which is not below 0, where it stands no higher than that.
    #[must_use]
    pub fn horizon(&self, from: DVec3, along: DVec3, least: f64) -> f64 {
        let look = Look {
            from: DVec2::new(from.x, from.z),
            along: DVec2::new(along.x, along.z),
            eye_m: from.y - self.map.corner.y,
        };
        let mut slope = least;
        let Some(mut walk) = Walk::new(self, [look.from, look.along], 0.0) else {
            return slope;
        };
        let highest_m = self.range_m(walk.block())[1];
        // It is near that most of the slope is found.
        while walk.block().level > 0 {
            walk.open();
        }
        while highest_m - from.y > slope * walk.enter() {
            let high_m = self.range_m(walk.block())[1];
            if high_m - from.y > slope * walk.enter() {
                if walk.block().level > 0 {
                    walk.open();
                    continue;
                }
                slope = self.slope_in(&walk, &look, slope);
            }
            if !walk.pass() {
                break;
            }
        }
        slope
    }

    /// Largest slope of the sights to the surface within a cell, and `least` where that is larger.
    fn slope_in(&self, walk: &Walk, look: &Look, least: f64) -> f64 {
        let cell = walk.block();
        let [a, b, c, d] = self.heights_m(cell).map(|height_m| height_m - look.eye_m);
        let corner = self.at(cell.place[0] as usize, cell.place[1] as usize);
        let start = look.from - DVec2::new(corner.x, corner.z);
        let spacing_m = self.map.spacing_m;
        let (enter_m, leave_m) = (walk.enter(), walk.leave());
        // Where it crosses the diagonal from north-west to south-east.
        let diagonal_m = (start.y - start.x) / (look.along.x - look.along.y);
        let mut slope = least;
        for distance_m in [enter_m, diagonal_m, leave_m] {
            let DVec2 { x: right, y: down } = (start + distance_m * look.along) / spacing_m;
            let rise_m = if down >= right {
                a + down * (c - a) + right * (d - c)
            } else {
                a + right * (b - a) + down * (d - b)
            };
            let is_within = distance_m >= enter_m && distance_m <= leave_m;
            if is_within && distance_m > LEAST * spacing_m && rise_m > slope * distance_m {
                slope = rise_m / distance_m;
            }
        }
        slope
    }
}
