//! Water that mirrors the sun: a plane, where it lies, and how rough waves make it.
//!
//! A point x above the water at height h sees the sun mirrored at the foot
//! p = x + u (x_y - h)/w_y,   u = (w_x, -w_y, w_z)
//! `w` unit vector towards the sun, `u` towards the sun in still water. Along a view ray p is linear in the
//! distance, so that the rays whose feet lie within a rectangle of water end at two distances.
//!
//! A view ray meets water that is seen on a sphere around the planet's centre, so that its horizon lies as low as that
//! of the ground.
//!
//! Slopes of waves are Gaussian, of the variance (0.003 + 0.00512 U)/2 along each axis, `U` wind speed in
//! m/s at 12.5 m; which way the wind blows, which makes one axis a third steeper, is left out.
//! [CM54] Cox and Munk, J. Opt. Soc. Am. 44, 838-850 (1954).

use glam::DVec2;
use glam::DVec3;
use niji_geometry::EARTH;
use niji_geometry::Planet;
use niji_geometry::Ray;
use niji_radiometry::Radians;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Error;
use crate::sun_streak::SunStreak;

/// Steepest waves, rms along an axis: a wind of 48 m/s has them.
const STEEPEST: f64 = 0.35;

/// Four standard deviations of the streak and what second orders add, in slopes of the waves.
const STREAK_REACH: f64 = 9.0;

/// A still or rough water surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaterSurface {
    /// Its height, y (m).
    pub height_m: f64,
    /// Smallest and largest x and z (m); infinite where water goes on to the horizon.
    pub extent_m: [DVec2; 2],
    /// Slope of its waves, rms along each of two axes, 0 to 0.35; 0 is a mirror.
    pub slope: f64,
    /// What it is made of.
    pub water: Water,
}

/// Where a view ray meets water.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Foot {
    /// Its distance from the eye (m).
    pub(crate) distance_m: f64,
    pub(crate) point: DVec3,
    /// Unit vector upwards.
    pub(crate) up: DVec3,
}

/// What of the light that water mirrors is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MirroredLight {
    /// Its irradiance alone, as if it were natural light. The bow errs by P_w P_b cos 2 chi, `P_w` and
    /// `P_b` degrees of polarization of the mirrored light and of the bow, chi the clock angle from its top:
    /// with the sun at 10, 20 and 40 degrees by 29, 59 and 90 % of itself, too dark at the top, too bright
    /// at the feet.
    Natural,
    /// Its polarization too: exact for spheres in still water. Flattened drops move the rows of each
    /// polarization, and turn none of it.
    Polarized,
}

/// Slope of waves under a wind at 12.5 m, rms along each of two axes (CM54).
///
/// ```
/// // Without wind 2.2 degrees are left.
/// assert!((niji_render::wave_slope(0.0).atan().to_degrees() - 2.22).abs() < 0.01);
/// ```
#[must_use]
pub fn wave_slope(wind_speed_m_s: f64) -> f64 {
    (0.5 * (0.003 + 0.005_12 * wind_speed_m_s)).sqrt()
}

/// Towards the sun in still water.
pub(crate) fn mirrored(sun_direction: DVec3) -> DVec3 {
    DVec3::new(sun_direction.x, -sun_direction.y, sun_direction.z)
}

impl WaterSurface {
    /// Where a ray first meets it; `None` where it misses it, or begins in it.
    pub(crate) fn met(&self, ray: &Ray) -> Option<Foot> {
        let level = Planet {
            radius_m: EARTH.radius_m + self.height_m,
        };
        let above = |point: DVec3| point.with_y(point.y - self.height_m);
        let eye = above(ray.origin);
        let height_m = level.height_m(eye);
        if height_m <= 0.0 {
            return None;
        }
        let distance_m =
            level.distance_to_ground(height_m, level.cos_zenith(eye, ray.direction))?;
        let point = ray.at(distance_m);
        let place = DVec2::new(point.x, point.z);
        let [min, max] = self.extent_m;
        let is_water = place.cmpge(min).all() && place.cmple(max).all();
        is_water.then(|| Foot {
            distance_m,
            point,
            up: level.zenith(above(point)),
        })
    }

    /// How a ray goes on that meets it where it is still.
    pub(crate) fn continued(&self, ray: &Ray) -> Option<Ray> {
        let Foot { point, up, .. } = self.met(ray)?;
        Some(Ray {
            origin: point,
            direction: ray.direction - 2.0 * ray.direction.dot(up) * up,
        })
    }

    /// Where the light is mirrored that reaches a point above the water; the point itself below.
    pub(crate) fn foot(&self, point: DVec3, sun_direction: DVec3) -> DVec3 {
        let way_m = (point.y - self.height_m).max(0.0) / sun_direction.y;
        point + mirrored(sun_direction) * way_m
    }

    /// The distances along a ray between which mirrored sunlight reaches it, within a range.
    pub(crate) fn lit_range_m(
        &self,
        ray: &Ray,
        sun_direction: DVec3,
        range_m: (f64, f64),
    ) -> Option<(f64, f64)> {
        let along = mirrored(sun_direction) / sun_direction.y;
        let (height_m, rise) = (ray.origin.y - self.height_m, ray.direction.y);
        // Each is to be at least 0: value at the eye, and its change with the distance.
        let of_axis = |axis: usize, place: usize| {
            let at_eye = ray.origin[axis] + along[axis] * height_m;
            let slope = ray.direction[axis] + along[axis] * rise;
            let [low, high] = self.extent_m.map(|corner| corner[place]);
            [(at_eye - low, slope), (high - at_eye, -slope)]
        };
        let (x, z) = (of_axis(0, 0), of_axis(2, 1));
        let (mut from_m, mut to_m) = range_m;
        for (at_eye, slope) in [(height_m, rise)].into_iter().chain(x).chain(z) {
            if at_eye == f64::INFINITY {
                continue;
            }
            let end_m = -at_eye / slope;
            if slope > 0.0 {
                from_m = from_m.max(end_m);
            } else if slope < 0.0 {
                to_m = to_m.min(end_m);
            } else if at_eye < 0.0 {
                return None;
            }
        }
        (from_m < to_m).then_some((from_m, to_m))
    }

    /// Largest share of sunlight that reaches a drop by way of the water, of any wavelength and polarization;
    /// `None` if the sun is not above the horizon.
    #[must_use]
    pub fn largest_share(&self, sun_direction: DVec3, wavelengths: &WavelengthGrid) -> Option<f64> {
        let streak = SunStreak::new(self, sun_direction, wavelengths)?;
        let light = streak.natural.iter().zip(&streak.polarized);
        let across = light.map(|(natural, polarized)| f64::from(natural + polarized));
        // The rounding of f32.
        Some(1.000_001 * across.fold(0.0, f64::max))
    }

    /// How far waves turn the mirrored sun, as far as its light is followed.
    #[must_use]
    pub fn streak_reach(&self) -> Radians {
        Radians(STREAK_REACH * self.slope)
    }

    /// Refuse numbers that no water has.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let check = |is_sound: bool, (level, found, expected)| {
            let error = Error::Level {
                level,
                found,
                expected,
            };
            is_sound.then_some(()).ok_or(error)
        };
        let height = ("water surface: height", self.height_m, "a finite height");
        check(self.height_m.is_finite(), height)?;
        let slope = ("water surface: slope", self.slope, "0 to 0.35");
        check((0.0..=STEEPEST).contains(&self.slope), slope)?;
        let size = self.extent_m[1] - self.extent_m[0];
        let extent = (
            "water surface: extent",
            size.min_element(),
            "corners in ascending order",
        );
        check(size.min_element() >= 0.0, extent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pond() -> WaterSurface {
        WaterSurface {
            height_m: -2.0,
            extent_m: [DVec2::new(-10.0, -50.0), DVec2::new(30.0, 20.0)],
            slope: 0.0,
            water: Water::pure(15.0),
        }
    }

    fn sun() -> DVec3 {
        DVec3::new(0.5, 0.3, 0.4).normalize()
    }

    #[test]
    fn the_foot_lies_on_the_water_where_angles_of_incidence_and_reflection_agree() {
        let point = DVec3::new(3.0, 7.0, -20.0);
        let foot = pond().foot(point, sun());
        assert!((foot.y + 2.0).abs() < 1e-12);
        let up = (point - foot).normalize();
        assert!((up.y - sun().y).abs() < 1e-12 && (up + sun()).with_y(0.0).length() < 1e-12);
        assert_eq!(pond().foot(foot - DVec3::Y, sun()), foot - DVec3::Y);
    }

    #[test]
    fn a_ray_is_lit_exactly_where_its_feet_are_water() {
        let pond = pond();
        let is_lit = |point: DVec3| {
            let foot = pond.foot(point, sun());
            let place = DVec2::new(foot.x, foot.z);
            let [min, max] = pond.extent_m;
            point.y >= pond.height_m && place.cmpge(min).all() && place.cmple(max).all()
        };
        let mut n_lit = 0;
        for step in 0..400 {
            let turn = f64::from(step) * 2.399;
            let direction = DVec3::new(turn.cos(), 0.02 * f64::from(step % 40 - 20), turn.sin());
            let ray = Ray {
                origin: DVec3::new(0.0, f64::from(step % 5) - 3.0, 30.0),
                direction: direction.normalize(),
            };
            let range = pond.lit_range_m(&ray, sun(), (1.0, 200.0));
            for at in 0..200 {
                let distance_m = 1.0 + 0.99 * f64::from(at);
                let within = range.is_some_and(|(a, b)| a <= distance_m && distance_m <= b);
                assert_eq!(within, is_lit(ray.at(distance_m)), "{step} {distance_m}");
                n_lit += usize::from(within);
            }
        }
        assert!(n_lit > 1000, "{n_lit}");
    }

    #[test]
    fn endless_water_lights_all_that_is_above_it_and_none_lights_nothing() {
        let endless = WaterSurface {
            extent_m: [DVec2::NEG_INFINITY, DVec2::INFINITY],
            ..pond()
        };
        let level = Ray {
            origin: DVec3::ZERO,
            direction: DVec3::X,
        };
        let range_m = (5.0, 9.0);
        assert_eq!(endless.lit_range_m(&level, sun(), range_m), Some(range_m));
        let below = Ray {
            origin: -3.0 * DVec3::Y,
            ..level
        };
        assert_eq!(endless.lit_range_m(&below, sun(), range_m), None);
        let none = WaterSurface {
            extent_m: [DVec2::ZERO; 2],
            ..pond()
        };
        assert_eq!(none.lit_range_m(&level, sun(), (0.0, 1e6)), None);
        assert!(none.check().is_ok());
        let inverted = WaterSurface {
            extent_m: [DVec2::ONE, DVec2::ZERO],
            ..pond()
        };
        for bad in [
            inverted,
            WaterSurface {
                slope: -0.1,
                ..pond()
            },
            WaterSurface {
                height_m: f64::NAN,
                ..pond()
            },
        ] {
            assert!(bad.check().is_err());
        }
    }

    #[test]
    fn waves_are_those_that_were_measured() {
        // [CM54]: clean surface, 0.003 + 5.12e-3 U for both axes together; 0.0547 at 10.1 m/s.
        assert!((2.0 * wave_slope(10.1).powi(2) - 0.0547).abs() < 1e-4);
    }
}
