//! How long a picture will take, by following a part of it.
//!
//! t = s + p N/n + (t_1 - t_2) + (t_2 + m) A/a
//! `s` seconds until the first ray, without paths of light of further orders; `p` those of the first `n` paths of each
//! direction, of which the error of these foretells `N`; `t_1`, `t_2` those of the rays of some strips of pixels the
//! first time, when they make the rows of the table that they meet, and again; `m` those of more rays for pixels that
//! err by too much; `a` pixels of the strips, `A` of the picture.
//!
//! Strips stand upright: each meets the horizon and the bows where the picture does.

use std::ops::ControlFlow;

use niji_geometry::PixelRegion;

use crate::deadline::Clock;
use crate::deadline::Deadline;
use crate::drop_orders::FIRST_PATHS;
use crate::drop_orders::foretold_paths;
use crate::error::Error;
use crate::levels::DropOrders;
use crate::levels::RenderLevels;
use crate::picture::Taken;
use crate::picture::tracer;
use crate::request::RenderRequest;

/// Strips that are followed, and how many times as wide the picture is at least, unless they were narrower than a few
/// pixels: around each two more are looked at on either side.
const N_STRIPS: u32 = 3;
const NARROWER: u32 = 24;
const LEAST_PX: u32 = 4;

/// Seconds that [`render`](crate::render) will take on this machine as it is: measured, so another time others.
///
/// # Errors
/// As those of [`render`](crate::render).
pub fn foretold_seconds(request: &RenderRequest, now_s: Clock) -> Result<f64, Error> {
    request.check()?;
    request.check_memory(request.region.height_px)?;
    let deadline = Deadline {
        now_s,
        ..Deadline::NEVER
    };
    let progress = &|_| ControlFlow::Continue(());
    let of_level = request.wanted_orders().map(|(_, n_paths)| n_paths);
    let first = RenderRequest {
        levels: RenderLevels {
            drop_orders: with_paths(request.levels.drop_orders, FIRST_PATHS),
            ..request.levels
        },
        orders_error_cd_m2: None,
        ..*request
    };
    let start_s = now_s();
    let mut tracer = tracer(&first, (progress, deadline))?;
    let mut seconds = now_s() - start_s;
    if let (Some(of_level), Some(light)) = (of_level, &tracer.frame.multiple) {
        let n_paths = (request.orders_error_cd_m2).map_or(of_level, |allowed_cd_m2| {
            foretold_paths(of_level, allowed_cd_m2, (light.n_paths, light.error_cd_m2))
        });
        seconds += light.seconds * (n_paths as f64 / light.n_paths as f64 - 1.0);
    }
    let (mut rows_s, mut rays_s, mut n_followed) = (0.0, 0.0, 0);
    for strip in strips(request.region) {
        tracer.region = strip;
        let rows = 0..strip.height_px as usize;
        let mut taken = Taken::dark(&tracer, &first);
        let mut follow_s = || {
            taken.forget_nodes(&tracer);
            let start_s = now_s();
            taken.trace(&tracer, &rows, progress)?;
            Ok::<_, Error>(now_s() - start_s)
        };
        let (first_s, again_s) = (follow_s()?, follow_s()?);
        rows_s += (first_s - again_s).max(0.0);
        let start_s = now_s();
        taken.add_missed(&tracer, &rows);
        if let Some(tolerance_cd_m2) = request.tolerance_cd_m2 {
            let (picture, refining) = taken.refining(&rows);
            tracer.refine(picture, &refining, request.coarser_rays * tolerance_cd_m2);
        }
        rays_s += again_s + now_s() - start_s;
        n_followed += strip.n_pixels();
    }
    tracer.frame.check_rows()?;
    let of_all = request.region.n_pixels() as f64 / n_followed as f64;
    Ok(seconds + rows_s + rays_s * of_all)
}

/// A level with no more paths.
fn with_paths(orders: DropOrders, at_most: usize) -> DropOrders {
    match orders {
        DropOrders::SingleScattering => orders,
        DropOrders::MultipleScattering {
            nodes_across,
            paths_per_node,
        } => DropOrders::MultipleScattering {
            nodes_across,
            paths_per_node: paths_per_node.min(at_most),
        },
    }
}

/// Upright strips in the middles of equal parts of a region; the region itself where it is not wider.
fn strips(region: PixelRegion) -> Vec<PixelRegion> {
    let width_px = (region.width_px / NARROWER).max(LEAST_PX);
    if N_STRIPS * width_px >= region.width_px {
        return vec![region];
    }
    let strip = |index: u32| {
        let middle_px = (2 * index + 1) * region.width_px / (2 * N_STRIPS);
        let left_px = i32::try_from(middle_px - width_px / 2).unwrap_or(i32::MAX);
        PixelRegion {
            x_px: region.x_px.saturating_add(left_px),
            width_px,
            ..region
        }
    };
    (0..N_STRIPS).map(strip).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_lie_apart_within_the_region() {
        for width_px in [1, 11, 12, 13, 64, 241, 1920, 100_000] {
            let region = PixelRegion {
                x_px: -7,
                y_px: 3,
                width_px,
                height_px: 5,
            };
            let strips = strips(region);
            let n_px: u32 = strips.iter().map(|it| it.width_px).sum();
            assert!(n_px <= width_px && n_px >= width_px.min(12), "{strips:?}");
            let mut left_px = i64::from(region.x_px);
            for strip in strips {
                assert!(i64::from(strip.x_px) >= left_px, "{strip:?}");
                assert_eq!((strip.y_px, strip.height_px), (3, 5));
                left_px = strip.right();
            }
            assert!(left_px <= region.right());
        }
    }
}
