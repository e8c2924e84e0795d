//! Where in a pixel its rays go, and which of its neighbors its error estimate looks at.

use niji_geometry::PixelRegion;

use crate::footprint_error::REACH_PX;
use crate::levels::PixelFootprint;

/// Rays along a side of a pixel.
pub(crate) fn rays_along(footprint: PixelFootprint) -> u32 {
    match footprint {
        PixelFootprint::Center | PixelFootprint::Prefiltered => 1,
        PixelFootprint::Grid { n } => n,
    }
}

/// Places of n x n rays in a pixel.
pub(crate) fn offsets(n: u32) -> impl Iterator<Item = (f64, f64)> {
    let place = move |index: u32| (f64::from(index) + 0.5) / f64::from(n);
    (0..n * n).map(move |index| (place(index % n), place(index / n)))
}

/// The pixels within [`REACH_PX`] around a region: above, below, left and right of it. Corners are
/// not looked at.
pub(crate) fn apron(region: PixelRegion) -> [PixelRegion; 4] {
    let (x_px, y_px) = (region.x_px, region.y_px);
    // A region that was checked ends far below 2^31.
    let (right, bottom) = (region.right() as i32, region.bottom() as i32);
    let reach = REACH_PX as i32;
    let rows = |y_px| PixelRegion {
        y_px,
        height_px: REACH_PX,
        ..region
    };
    let columns = |x_px| PixelRegion {
        x_px,
        width_px: REACH_PX,
        ..region
    };
    [
        rows(y_px - reach),
        rows(bottom),
        columns(x_px - reach),
        columns(right),
    ]
}
