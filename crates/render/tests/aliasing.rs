//! Supernumeraries narrower than pixels: what each footprint makes of the bow of one drop size.
//!
//! Fringes as drops of 0.25 mm have them without the width of the sun: the first two 1.1 degrees
//! apart, the others closer (theta - theta_D ~ m^(2/3)).

#![allow(clippy::unwrap_used, reason = "tests stop at what they did not expect")]

mod common;

use common::*;
use glam::DVec3;
use niji_dropfield::GridBox;
use niji_geometry::Camera;
use niji_render::LitDrops;
use niji_render::PictureLayer;
use niji_render::PixelFootprint;
use niji_render::Rendered;
use niji_render::SunPath;

/// Width of the first fringes (rad).
const SCALE_RAD: f64 = 0.0085;

/// Intensity of a bow by Airy's leading asymptotic behavior: an exponential rise to its edge at
/// 138 degrees, cos² of (2/3) z^(3/2) inside it.
fn bow(theta_rad: f64) -> f64 {
    let z = (theta_rad - 138_f64.to_radians()) / SCALE_RAD;
    let inside = z.max(0.0);
    let fringe = (2.0 / 3.0 * inside.powf(1.5) - std::f64::consts::FRAC_PI_4)
        .cos()
        .powi(2);
    0.1 * fringe / (1.0 + inside).sqrt() * (2.0 * z.min(0.0)).exp()
}

/// RMS of luminance against 16 x 16 rays a pixel, over the peak of the picture.
fn error(
    camera: &Camera,
    drops: &LitDrops,
    footprint: PixelFootprint,
    reference: &Rendered,
) -> f64 {
    let expected = &reference[PictureLayer::BowPrimary];
    let found = &picture(camera, drops, footprint)[PictureLayer::BowPrimary];
    let peak = expected.iter().copied().fold(0.0, f32::max);
    let squares = found.iter().zip(expected).map(|(a, b)| (a - b).powi(2));
    f64::from((squares.sum::<f32>() / found.len() as f32).sqrt() / peak)
}

fn picture(camera: &Camera, drops: &LitDrops, footprint: PixelFootprint) -> Rendered {
    let table = table(|_, theta| bow(theta));
    let mut request = request(camera, sun_in_the_south(20.0), drops, &table);
    request.levels.pixel_footprint = footprint;
    rendered(&request)
}

#[test]
fn prefiltered_pixels_do_not_alias_supernumeraries() {
    let grid = GridBox {
        min: DVec3::new(-300.0, -20.0, -260.0),
        max: DVec3::new(300.0, 300.0, -60.0),
        voxel_m: 20.0,
    };
    let sun = sun_in_the_south(20.0);
    let drops = LitDrops::new(vec![bricks(&grid, |_| 1e-4)], sun, SunPath::Ignore).unwrap();
    // Pixels of 0.14 degrees, as of a camera of 640 pixels over 90 degrees; of half a degree, wider
    // than most fringes; and of one, wider than all.
    for (pixel_deg, of_center, of_prefiltered, of_four) in [
        (0.14, 5e-2, 5e-4, 5e-3),
        (0.5, 2e-1, 5e-3, 1e-2),
        (1.0, 2e-1, 2e-2, 2e-2),
    ] {
        let (width, height) = (36, 20);
        let fov_deg = pixel_deg * f64::from(width);
        // The top of the bow, 42 degrees from the antisolar point.
        let camera = camera(DVec3::ZERO, (0.0, 19.0), fov_deg, (width, height));
        let reference = picture(&camera, &drops, PixelFootprint::Grid { n: 16 });
        let error = |footprint| error(&camera, &drops, footprint, &reference);
        let center = error(PixelFootprint::Center);
        let prefiltered = error(PixelFootprint::Prefiltered);
        let grids = [2, 4].map(|n| error(PixelFootprint::Grid { n }));
        println!(
            "{pixel_deg}: center {center:.1e}, prefiltered {prefiltered:.1e}, grids {grids:?}"
        );
        assert!(center < of_center && prefiltered < of_prefiltered && grids[1] < of_four);
        assert!(prefiltered < 0.25 * center && prefiltered < grids[0]);
    }
}
