//! Where in a pixel its rays go.

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
