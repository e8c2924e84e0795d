//! Hard cases of photographs: picks on a line, in one place, of several colors or upside down; suns
//! without a bow; damaged pictures.

use std::fs;
use std::io::Cursor;

use glam::DVec3;
use ndarray::Array2;
use niji_exchange::ImageWindows;
use niji_exchange::Provenance;
use niji_geometry::PinholeCamera;
use niji_geometry::PinholeRequest;
use niji_photo::BowAnglePrior;
use niji_photo::Error;
use niji_photo::FitRequest;
use niji_photo::Frame;
use niji_photo::LinearPicture;
use niji_photo::Photograph;
use niji_photo::PickedEdge;
use niji_photo::PremultipliedPicture;
use niji_photo::SunSolution;
use niji_photo::Verdict;
use niji_photo::circle_through_picks;
use niji_photo::diagnose_picks;
use niji_photo::sun_below_horizon;
use niji_photo::sun_from_picks;
use niji_photo::sun_too_high;
use niji_photo::write_jpeg;
use niji_photo::write_png;
use niji_radiometry::Radians;
use niji_radiometry::RgbPrimaries;

use crate::selftest::hard_case::HardCase;
use crate::selftest::hard_case::violations;
use crate::selftest::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "exact picks give the sun back, of a tenth of a turn and of all",
        measure: "error of the antisolar point, degrees",
        allowed: 1e-8,
        error: exact_picks,
    },
    HardCase {
        claim: "picks on a line are a great circle, told, and no bow",
        measure: "error of its angle of 90 degrees",
        allowed: 1e-6,
        error: collinear_picks,
    },
    HardCase {
        claim: "directions on any great circle span 90 degrees to the last digits",
        measure: "error of the angle, degrees",
        allowed: 1e-12,
        error: great_circles,
    },
    HardCase {
        claim: "picks in one place, opposite ones and NaN have no circle",
        measure: "circles found",
        allowed: 0.0,
        error: coincident_directions,
    },
    HardCase {
        claim: "picks that coincide or nearly do are told",
        measure: "picks without the finding",
        allowed: 0.0,
        error: coincident_picks,
    },
    HardCase {
        claim: "mixed colors are told and throw the sun off as published",
        measure: "difference from the published 16 degrees",
        allowed: 1.0,
        error: mixed_colors,
    },
    HardCase {
        claim: "a bow upside down is impossible",
        measure: "missing findings",
        allowed: 0.0,
        error: upside_down,
    },
    HardCase {
        claim: "a sun too high, below the horizon or unknown has no bow and no NaN",
        measure: "wrong verdicts",
        allowed: 0.0,
        error: no_bow_possible,
    },
    HardCase {
        claim: "requests of two picks, of NaN and without noise are refused",
        measure: "accepted requests",
        allowed: 0.0,
        error: impossible_requests,
    },
    HardCase {
        claim: "truncated, empty and foreign pictures are errors",
        measure: "files of 64 without the error",
        allowed: 0.0,
        error: damaged_pictures,
    },
    HardCase {
        claim: "a header of 32767 x 32767 pixels in a file of 100 bytes takes no memory",
        measure: "accepted files",
        allowed: 0.0,
        error: huge_header,
    },
];

/// 4000 pixels and 60 degrees wide, level.
fn camera() -> PinholeCamera {
    PinholeCamera::new(PinholeRequest {
        position: DVec3::ZERO,
        azimuth: Radians(0.0),
        elevation: Radians(0.0),
        roll: Radians(0.0),
        horizontal_fov: Radians::from_degrees(60.0),
        width_px: 4000,
        height_px: 3000,
    })
    .expect("a camera like others")
}

/// The sun is 15 degrees high behind the camera.
fn antisolar() -> DVec3 {
    let (sin, cos) = (-15.0_f64).to_radians().sin_cos();
    DVec3::new(0.0, sin, -cos)
}

/// Points of a bow of `theta_deg`, evenly over `arc_deg` about its top.
fn picks(theta_deg: f64, arc_deg: f64, n_picks: usize) -> Vec<[f64; 2]> {
    let axis = antisolar();
    let up = DVec3::X.cross(axis);
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    let pick = |index: usize| {
        let clock_deg = arc_deg * (index as f64 / (n_picks - 1) as f64 - 0.5);
        let (s, c) = clock_deg.to_radians().sin_cos();
        let direction = cos * axis + sin * (c * up + s * DVec3::X);
        let (x, y) = camera().project(direction).expect("in front of the camera");
        [x, y]
    };
    (0..n_picks).map(pick).collect()
}

fn direction([x_px, y_px]: [f64; 2]) -> DVec3 {
    camera().ray(x_px, y_px).direction
}

fn error_deg(found: DVec3) -> f64 {
    let off = found.cross(antisolar()).length();
    off.atan2(found.dot(antisolar())).to_degrees()
}

/// The suns of picks without further knowledge, and the findings about picks of a red primary.
fn diagnosis(picks_px: &[[f64; 2]]) -> (Vec<SunSolution>, Vec<&'static str>) {
    let camera = camera();
    let offsets_rad = vec![0.0; picks_px.len()];
    let expected = BowAnglePrior {
        angle: Radians::from_degrees(42.3),
        standard_error: Radians::from_degrees(0.4),
    };
    let free = FitRequest {
        camera: &camera,
        picks_px,
        offsets_rad: &offsets_rad,
        noise_px: 1.0,
        prior: None,
    };
    let edge = PickedEdge {
        order: 2,
        expected,
        other_edge: Radians::from_degrees(-1.7),
    };
    let known = FitRequest {
        prior: Some(expected),
        ..free
    };
    let solve = |request| sun_from_picks(request).expect("sound picks");
    let findings = diagnose_picks(&known, edge, &solve(&known));
    let codes = findings.iter().map(|finding| finding.code).collect();
    (solve(&free), codes)
}

/// How many of the picks do not have the finding.
fn without(code: &str, picks_px: &[&[[f64; 2]]]) -> f64 {
    violations(
        picks_px
            .iter()
            .map(|picks| diagnosis(picks).1.contains(&code)),
    )
}

fn exact_picks() -> f64 {
    let arcs = [(36.0, 3), (36.0, 7), (60.0, 3), (90.0, 7)];
    worst(arcs.map(|(arc_deg, n_picks)| {
        let (suns, _) = diagnosis(&picks(42.0, arc_deg, n_picks));
        error_deg(suns[0].fit.antisolar)
    }))
}

fn collinear_picks() -> f64 {
    let line = [[500.0, 900.0], [2000.0, 1000.0], [3500.0, 1100.0]];
    let (suns, _) = diagnosis(&line);
    let is_no_bow = violations([suns[0].verdict != Verdict::Possible]);
    (suns[0].fit.bow_angle.to_degrees() - 90.0).abs()
        + is_no_bow
        + without("straight-line", &[&line])
}

fn great_circles() -> f64 {
    worst((0..50).map(|step| {
        let turn = f64::from(step);
        let x = DVec3::new(turn.sin(), (2.0 * turn).cos(), 0.5).normalize();
        let y = x.any_orthonormal_vector();
        let picks = [0.0, 0.4, 1.3].map(|clock: f64| clock.cos() * x + clock.sin() * y);
        let angle = circle_through_picks(picks).map(|circle| circle.bow_angle.to_degrees());
        (angle.unwrap_or(f64::NAN) - 90.0).abs()
    }))
}

fn coincident_directions() -> f64 {
    let (a, b) = (DVec3::X, DVec3::Y);
    let triples = [
        [a, a, a],
        [a, b, b],
        [a, b, a],
        [a, b, DVec3::NAN],
        [DVec3::NAN; 3],
        [a, a + 1e-17 * b, b],
    ];
    violations(triples.map(|picks| circle_through_picks(picks).is_none()))
}

fn coincident_picks() -> f64 {
    let first = picks(42.3, 60.0, 3)[0];
    let near = [
        first,
        [first[0] + 3.0, first[1]],
        [first[0], first[1] + 3.0],
    ];
    without("picks-too-close", &[&[first; 3], &near])
}

fn mixed_colors() -> f64 {
    let (red, blue) = (picks(42.3, 60.0, 3), picks(40.6, 60.0, 3));
    let mixed = [red[0], blue[1], red[2]];
    // Published: 16 degrees for red, blue, red over 60 degrees of arc.
    let circle = circle_through_picks(mixed.map(direction));
    let off_deg = circle.map_or(f64::NAN, |circle| error_deg(circle.antisolar));
    (off_deg - 16.0).abs() + 2.0 * without("mixed-colors", &[&mixed])
}

fn upside_down() -> f64 {
    let picks = picks(42.3, 60.0, 5).into_iter();
    let flipped: Vec<[f64; 2]> = picks.map(|[x, y]| [x, 3000.0 - y]).collect();
    without("sun-below-horizon", &[&flipped])
}

fn no_bow_possible() -> f64 {
    let degrees = Radians::from_degrees;
    let too_high = |sun_deg| sun_too_high(degrees(sun_deg), degrees(42.0), degrees(-5.0));
    violations([
        too_high(60.0).is_some(),
        too_high(42.1).is_some(),
        too_high(41.9).is_none(),
        too_high(f64::NAN).is_none(),
        sun_below_horizon(degrees(-1.0)).is_some(),
        sun_below_horizon(degrees(-0.26)).is_none(),
        sun_below_horizon(degrees(f64::NAN)).is_none(),
    ])
}

fn impossible_requests() -> f64 {
    let camera = camera();
    let exact = picks(42.0, 60.0, 3);
    let request = FitRequest {
        camera: &camera,
        picks_px: &exact,
        offsets_rad: &[0.0; 3],
        noise_px: 1.0,
        prior: None,
    };
    let wrong = [
        FitRequest {
            picks_px: &exact[..2],
            offsets_rad: &[0.0; 2],
            ..request
        },
        FitRequest {
            offsets_rad: &[0.0; 2],
            ..request
        },
        FitRequest {
            noise_px: 0.0,
            ..request
        },
        FitRequest {
            picks_px: &[[f64::NAN, 0.0]; 3],
            ..request
        },
    ];
    violations(wrong.map(|request| sun_from_picks(&request).is_err()))
}

fn gradient() -> LinearPicture {
    Array2::from_shape_fn((16, 24), |(y, x)| [y as f32 / 16.0, x as f32 / 24.0, 0.5])
}

fn png() -> Vec<u8> {
    let mut png = Vec::new();
    write_png(&gradient(), &Provenance::default(), &mut png).expect("memory takes everything");
    png
}

fn exr() -> Vec<u8> {
    let mut exr = Cursor::new(Vec::new());
    let alpha = Array2::zeros((16, 24));
    let frame = Frame {
        primaries: RgbPrimaries::Rec709,
        windows: ImageWindows::whole(24, 16),
    };
    let picture = PremultipliedPicture {
        light: &gradient(),
        alpha: Some(&alpha),
        frame,
    };
    let written = picture.write_exr(&Provenance::default(), &mut exr);
    written.expect("memory takes everything");
    exr.into_inner()
}

/// What comes of reading bytes as a picture.
fn read(bytes: &[u8]) -> Result<Photograph, Error> {
    let folder = tempfile::tempdir().expect("a folder for damaged files");
    let path = folder.path().join("picture");
    fs::write(&path, bytes).expect("a file of some bytes");
    Photograph::read(&path)
}

fn damaged_pictures() -> f64 {
    let mut jpeg = Vec::new();
    write_jpeg(&gradient(), &mut jpeg).expect("memory takes everything");
    let truncated = [png(), jpeg, exr()].into_iter().flat_map(|whole| {
        let cut = |part: usize| whole[..(whole.len() - 16) * part / 20].to_vec();
        (1..=20).map(cut).collect::<Vec<_>>()
    });
    let foreign = [
        matches!(read(b""), Err(Error::Empty)),
        matches!(read(b"hello"), Err(Error::UnknownFormat)),
        read(b"\x76\x2f\x31\x01").is_err(),
        read(b"\x89PNG\r\n\x1a\n").is_err(),
    ];
    violations(truncated.map(|bytes| read(&bytes).is_err())) + violations(foreign)
}

fn huge_header() -> f64 {
    let mut png = png();
    // Width and height stand at 16 and 20, their checksum at 29.
    png[16..24].copy_from_slice(&[0, 0, 0x7f, 0xff, 0, 0, 0x7f, 0xff]);
    let checksum = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&checksum.to_be_bytes());
    violations([matches!(read(&png), Err(Error::TooLarge { .. }))])
}

/// The checksum of PNG chunks (ISO/IEC 15948, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    let remainder = bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            if crc & 1 == 1 {
                0xedb8_8320 ^ (crc >> 1)
            } else {
                crc >> 1
            }
        })
    });
    !remainder
}
