//! What nature would not do: contradictions between a wanted bow and its picture.
//!
//! Each check is a function of plain values; what is not known is not checked. Thresholds stand with
//! their sources.
//! [LF01] R. L. Lee, A. B. Fraser, The Rainbow Bridge (2001).
//! [Bla46] H. R. Blackwell, Contrast thresholds of the human eye, J. Opt. Soc. America 36, 624-643
//! (1946): large patches in daylight are seen from a contrast of about 0.01 on.

use niji_radiometry::Micrometers;
use niji_radiometry::Radians;

use crate::finding::Finding;
use crate::finding::Severity;

/// Differences of the sun from the ephemeris that are wrong for sure, degrees.
const SUN_WRONG_DEG: f64 = 5.0;
/// Differences that are doubtful at least, degrees.
const SUN_DOUBT_DEG: f64 = 1.0;
/// Least contrast that is seen (Bla46).
const VISIBLE_CONTRAST: f64 = 0.01;
/// Effective variance above which fringes are washed out.
const FRINGE_VARIANCE: f64 = 0.1;
/// Radius above which sunlight makes a colored bow and no fogbow (LF01: white below 25 µm or so).
const FOGBOW_RADIUS_UM: f64 = 100.0;
/// Radius above which falling drops are flat enough to lower the top of the bow by a degree.
const FLAT_RADIUS_UM: f64 = 500.0;
/// Clear sky, overcast sky: parts of the sky covered by clouds.
const CLEAR: f64 = 0.05;
const OVERCAST: f64 = 0.95;

/// The sun stands too high for a bow in the air above the horizon.
#[must_use]
pub fn sun_too_high(
    sun_elevation: Radians,
    bow_angle: Radians,
    lowest_view: Radians,
) -> Option<Finding> {
    let bow_top = bow_angle.0 - sun_elevation.0;
    let is_seen_from_above = lowest_view.0 < bow_top;
    // Also false where the sun is not known.
    let is_too_high = bow_top < 0.0;
    if !is_too_high {
        return None;
    }
    let severity = if is_seen_from_above {
        Severity::Warning
    } else {
        Severity::Error
    };
    Some(Finding::new(
        "sun-too-high",
        severity,
        format!(
            "the sun stands {:.1} degrees high, above the bow angle of {:.1}: the whole bow lies below \
             the horizon",
            sun_elevation.to_degrees(),
            bow_angle.to_degrees()
        ),
        "lower the sun below the bow angle, or look down into spray",
    ))
}

/// The sun is below the horizon.
#[must_use]
pub fn sun_below_horizon(sun_elevation: Radians) -> Option<Finding> {
    // Half of the disc.
    (sun_elevation.to_degrees() < -0.27).then(|| {
        Finding::new(
            "sun-below-horizon",
            Severity::Error,
            format!(
                "the sun stands at {:.1} degrees",
                sun_elevation.to_degrees()
            ),
            "no bow without the sun: choose a time at which it is up",
        )
    })
}

/// The bow stands on the sun's side of the sky.
#[must_use]
pub fn bow_on_the_suns_side(
    angle_of_view_axis_from_sun: Radians,
    half_diagonal: Radians,
) -> Option<Finding> {
    let nearest = angle_of_view_axis_from_sun.0 - half_diagonal.0;
    (angle_of_view_axis_from_sun.0 < std::f64::consts::FRAC_PI_2).then(|| {
        let glare = if nearest <= 0.0 {
            ", and it is in the picture"
        } else {
            ""
        };
        Finding::new(
            "suns-side",
            Severity::Error,
            format!(
                "the sun is {:.0} degrees from the middle of the picture{glare}; a bow stands opposite",
                angle_of_view_axis_from_sun.to_degrees()
            ),
            "turn the sun behind the camera; 22 or 46 degrees from the sun there are ice halos",
        )
    })
}

/// The sun by the bow and by the ephemeris differ.
#[must_use]
pub fn sun_elsewhere(difference: Radians, standard_error: Radians) -> Option<Finding> {
    let (difference_deg, error_deg) = (difference.to_degrees(), standard_error.to_degrees());
    if difference_deg <= SUN_DOUBT_DEG.max(3.0 * error_deg) {
        return None;
    }
    let severity = if difference_deg > SUN_WRONG_DEG.max(3.0 * error_deg) {
        Severity::Error
    } else {
        Severity::Warning
    };
    Some(Finding::new(
        "sun-elsewhere",
        severity,
        format!(
            "at that time and place the sun is {difference_deg:.1} degrees from where the bow puts it \
             (known to {error_deg:.1})"
        ),
        "check the clock's time zone, the azimuth of the camera and the picks",
    ))
}

/// Shadows in the picture must point to the antisolar point.
#[must_use]
pub fn shadows_point_elsewhere(difference: Radians) -> Option<Finding> {
    // People pick the tip of a shadow within some degrees.
    (difference.to_degrees() > 10.0).then(|| {
        Finding::new(
            "shadows",
            Severity::Error,
            format!(
                "a shadow points {:.0} degrees past the antisolar point, the middle of every bow",
                difference.to_degrees()
            ),
            "move the bow's middle to where shadows point",
        )
    })
}

/// Rain needs clouds, and a bow needs sun.
#[must_use]
pub fn cloud_cover(cover: f64, drops: DropSource) -> Option<Finding> {
    let is_rain = drops == DropSource::Rain;
    if cover <= CLEAR && is_rain {
        return Some(Finding::new(
            "cloudless",
            Severity::Error,
            "a cloudless sky has no rain to make a bow",
            "use spray, a fountain or fog as the source of drops, or a cloudy picture",
        ));
    }
    (cover >= OVERCAST).then(|| {
        Finding::new(
            "overcast",
            Severity::Error,
            "under an overcast sky no sunlight reaches the drops",
            "choose a picture with a gap for the sun",
        )
    })
}

/// Where the drops come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropSource {
    /// Rain.
    Rain,
    /// Spray of a fountain, a waterfall or the sea.
    Spray,
    /// Fog or cloud.
    Fog,
}

/// A bow too faint to be seen: its luminance over that of what lies behind it.
#[must_use]
pub fn contrast_too_low(contrast: f64, bow: &str) -> Option<Finding> {
    // False for NaN, which is unknown.
    (contrast < VISIBLE_CONTRAST).then(|| {
        Finding::new(
            "invisible",
            Severity::Warning,
            format!(
                "the {bow} bow has a contrast of {:.2} % against what lies behind it; people see 1 %",
                100.0 * contrast
            ),
            "more drops, a longer way through them, or a darker background",
        )
    })
}

/// Supernumeraries need drops of one size.
#[must_use]
pub fn supernumeraries_washed_out(effective_variance: f64) -> Option<Finding> {
    (effective_variance > FRINGE_VARIANCE).then(|| {
        Finding::new(
            "supernumeraries",
            Severity::Warning,
            format!(
                "drops of effective variance {effective_variance:.2} wash out supernumerary bows"
            ),
            "ask for a variance below 0.1; rain by Marshall and Palmer has 0.33",
        )
    })
}

/// A fogbow needs small drops.
#[must_use]
pub fn fogbow_of_large_drops(effective_radius: Micrometers) -> Option<Finding> {
    (effective_radius.0 > FOGBOW_RADIUS_UM).then(|| {
        Finding::new(
            "fogbow",
            Severity::Error,
            format!("drops of {:.0} µm make a colored bow", effective_radius.0),
            "a white fogbow needs drops below about 25 µm",
        )
    })
}

/// Large drops are flat and take the top off the bow.
#[must_use]
pub fn flattened_drops(effective_radius: Micrometers, sun_elevation: Radians) -> Option<Finding> {
    let shows_top = sun_elevation.to_degrees() < 42.0;
    (effective_radius.0 > FLAT_RADIUS_UM && shows_top).then(|| {
        Finding::new(
            "flattened-drops",
            Severity::Warning,
            format!(
                "falling drops of {:.0} µm are flat: their light leaves the top of the bow",
                effective_radius.0
            ),
            "switch drop flattening on, or expect a bow that is bright at its feet only",
        )
    })
}

/// The sky inside a primary bow is brighter than outside, between the bows.
#[must_use]
pub fn inside_not_brighter(inside_luminance: f64, outside_luminance: f64) -> Option<Finding> {
    (inside_luminance < outside_luminance).then(|| {
        Finding::new(
            "inside-darker",
            Severity::Info,
            "the picture is darker inside the bow than outside, where Alexander's dark band should be",
            "natural bows brighten their inside; darken the outside, or let drops add their light there",
        )
    })
}

/// The bow does not run through the picture.
#[must_use]
pub fn bow_outside_picture(n_points_inside: usize) -> Option<Finding> {
    (n_points_inside == 0).then(|| {
        Finding::new(
            "outside-picture",
            Severity::Warning,
            "no part of the bow lies within the picture",
            "turn the camera to the side away from the sun, or take a wider lens",
        )
    })
}

/// The surface stands before the drops and hides the bow.
#[must_use]
pub fn hidden_by_surface(hidden_share: f64) -> Option<Finding> {
    (hidden_share > 0.95).then(|| {
        Finding::new(
            "hidden",
            Severity::Warning,
            format!(
                "{:.0} % of the bow lies behind surfaces that are nearer than the drops",
                100.0 * hidden_share
            ),
            "bring the drops nearer, or choose picks before far surfaces and the sky",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(angle_deg: f64) -> Radians {
        Radians::from_degrees(angle_deg)
    }

    /// Each contradiction in a case where it is true and in one where it is false.
    #[test]
    fn every_contradiction_is_told_and_only_then() {
        let um = Micrometers;
        let cases: [(&str, Option<Finding>, Option<Finding>); 16] = [
            (
                "sun-too-high",
                sun_too_high(degrees(50.0), degrees(42.0), degrees(-5.0)),
                sun_too_high(degrees(41.0), degrees(42.0), degrees(-5.0)),
            ),
            (
                "sun-below-horizon",
                sun_below_horizon(degrees(-1.0)),
                sun_below_horizon(degrees(-0.2)),
            ),
            (
                "suns-side",
                bow_on_the_suns_side(degrees(50.0), degrees(35.0)),
                bow_on_the_suns_side(degrees(150.0), degrees(35.0)),
            ),
            (
                "sun-elsewhere",
                sun_elsewhere(degrees(8.0), degrees(1.0)),
                sun_elsewhere(degrees(2.0), degrees(1.0)),
            ),
            (
                "shadows",
                shadows_point_elsewhere(degrees(30.0)),
                shadows_point_elsewhere(degrees(4.0)),
            ),
            (
                "cloudless",
                cloud_cover(0.0, DropSource::Rain),
                cloud_cover(0.0, DropSource::Spray),
            ),
            (
                "overcast",
                cloud_cover(1.0, DropSource::Spray),
                cloud_cover(0.6, DropSource::Rain),
            ),
            (
                "overcast",
                cloud_cover(0.97, DropSource::Rain),
                cloud_cover(0.9, DropSource::Fog),
            ),
            (
                "invisible",
                contrast_too_low(0.003, "secondary"),
                contrast_too_low(0.05, "primary"),
            ),
            (
                "supernumeraries",
                supernumeraries_washed_out(0.33),
                supernumeraries_washed_out(0.02),
            ),
            (
                "fogbow",
                fogbow_of_large_drops(um(500.0)),
                fogbow_of_large_drops(um(10.0)),
            ),
            (
                "flattened-drops",
                flattened_drops(um(800.0), degrees(20.0)),
                flattened_drops(um(300.0), degrees(20.0)),
            ),
            (
                "inside-darker",
                inside_not_brighter(0.3, 0.4),
                inside_not_brighter(0.4, 0.3),
            ),
            (
                "invisible",
                contrast_too_low(0.009, "secondary"),
                contrast_too_low(0.02, "secondary"),
            ),
            (
                "outside-picture",
                bow_outside_picture(0),
                bow_outside_picture(12),
            ),
            ("hidden", hidden_by_surface(0.99), hidden_by_surface(0.5)),
        ];
        for (code, wrong, right) in cases {
            let finding = wrong.unwrap_or_else(|| panic!("{code} is not told"));
            assert_eq!(finding.code, code);
            assert!(!finding.reason.is_empty() && !finding.suggestion.is_empty());
            assert_eq!(right, None, "{code} is told where it is false");
        }
    }

    #[test]
    fn severity_follows_how_far_off_it_is() {
        let severity = |finding: Option<Finding>| finding.map(|finding| finding.severity);
        assert_eq!(
            severity(sun_elsewhere(degrees(2.0), degrees(0.1))),
            Some(Severity::Warning)
        );
        assert_eq!(
            severity(sun_elsewhere(degrees(6.0), degrees(0.1))),
            Some(Severity::Error)
        );
        let from_a_tower = sun_too_high(degrees(50.0), degrees(42.0), degrees(-30.0));
        assert_eq!(severity(from_a_tower), Some(Severity::Warning));
    }

    #[test]
    fn unknown_numbers_are_no_contradiction() {
        assert_eq!(contrast_too_low(f64::NAN, "primary"), None);
        assert_eq!(inside_not_brighter(f64::NAN, 1.0), None);
        assert_eq!(
            sun_too_high(degrees(f64::NAN), degrees(42.0), degrees(0.0)).map(|f| f.code),
            None
        );
    }
}
