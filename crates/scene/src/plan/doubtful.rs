//! What a scene says that is hardly meant: numbers in other units, places where its ground is not.
//!
//! Each is asked about in one line, with the key to change, and rendered as it stands.
//! [WMO] World Meteorological Organization, World Weather & Climate Extremes Archive: 305 mm of rain in 42 minutes
//! (Holt, 1947); 401 mm in an hour (Shangdi, 1975) is the most that is reported.

use glam::DVec3;
use niji_geometry::EARTH;

use crate::figures::brief;
use crate::figures::length;
use crate::scene::Scene;
use crate::sections::Body;

use super::facts::Situation;

/// A sun so high in radians still makes a bow above the horizon: 42 degrees.
const HIGHEST_OF_BOWS_RAD: f64 = 0.733;

/// More rain than this has not been measured over an hour (WMO), mm/h.
const HEAVIEST_RAIN_MM_H: f64 = 401.0;

/// Stops below display white at which a picture is black.
const BLACK_EV: f64 = -6.0;

/// How much lower than the plane y = 0 the ground may lie before it is said (m): at 11 km.
const MOST_FALL_M: f64 = 10.0;

/// The questions to a scene.
pub(super) fn doubts(scene: &Scene, situation: &Situation) -> Vec<String> {
    let asked = [
        of_moonlight(scene),
        of_sun(scene),
        of_ground(scene, situation),
    ];
    asked.into_iter().flatten().chain(of_rain(scene)).collect()
}

/// The moon, exposed as the sun.
fn of_moonlight(scene: &Scene) -> Option<String> {
    let scale = scene.sun.irradiance_scale();
    let exposure_ev = scene.picture.exposure_ev;
    let is_black = exposure_ev + scale.log2() < BLACK_EV;
    (scene.sun.body == Body::Moon && is_black).then(|| {
        format!(
            "the moon is {:.0} times fainter than the sun, so that the picture is black: found \
             picture.exposure_ev = {}, expected about {:.0}",
            1.0 / scale,
            brief(exposure_ev),
            -scale.log2()
        )
    })
}

/// An elevation in radians.
fn of_sun(scene: &Scene) -> Option<String> {
    let elevation_deg = scene.sun.elevation_deg;
    let may_be_radians = elevation_deg > 0.0 && elevation_deg <= HIGHEST_OF_BOWS_RAD;
    may_be_radians.then(|| {
        format!(
            "the {} stands on the horizon: found sun.elevation_deg = {}; are {:.1} degrees meant, which \
             are as much in radians?",
            scene.sun.body.name(),
            brief(elevation_deg),
            elevation_deg.to_degrees()
        )
    })
}

/// Rain heavier than any.
fn of_rain(scene: &Scene) -> Vec<String> {
    let shapes = scene.drops.populations().iter();
    let rates = shapes.filter_map(|population| population.source.shape()?.rain_rate());
    let heavy = rates.filter(|(_, rate_mm_h)| *rate_mm_h > HEAVIEST_RAIN_MM_H);
    heavy
        .map(|(key, rate_mm_h)| {
            format!(
                "rain of {} mm/h, more than the heaviest hour ever measured, {HEAVIEST_RAIN_MM_H} mm: is \
                 drops.{key} meant so?",
                brief(rate_mm_h)
            )
        })
        .collect()
}

/// Eyes and drops over ground that has curved away.
fn of_ground(scene: &Scene, situation: &Situation) -> Option<String> {
    scene.air.as_ref()?;
    let bounds = situation.drops.bounds();
    let nearest = DVec3::ZERO.clamp(bounds.min, bounds.max);
    let eye = situation.camera.position();
    let places = [
        ("the camera stands", eye, "camera.position_m"),
        ("all drops stand", nearest, "[drops]"),
    ];
    places.into_iter().find_map(|(what, place, key)| {
        let fall_m = EARTH.height_m(place.with_y(0.0));
        let away_m = place.x.hypot(place.z);
        (fall_m > MOST_FALL_M).then(|| {
            format!(
                "{what} {} from the origin, where the curved ground of the air lies {} below y = 0: \
                 move the scene to the origin ({key})",
                length(away_m),
                length(fall_m)
            )
        })
    })
}
