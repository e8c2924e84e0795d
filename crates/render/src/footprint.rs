//! Where in a pixel its rays go, and which of its neighbors its error estimate looks at.

use niji_geometry::PixelRegion;

use crate::levels::PixelFootprint;

/// Pixels on every side that an estimate looks at.
pub(crate) const REACH_PX: u32 = 2;

/// Rays along a side of a pixel.
pub(crate) fn rays_along(footprint: PixelFootprint) -> u32 {
    match footprint {
        PixelFootprint::Center | PixelFootprint::Prefiltered => 1,
        PixelFootprint::Grid { n } => n,
    }
}

/// Places of n x n rays in a pixel.
pub(crate) fn offsets(n: u32) -> impl Iterator<Item = (f64, f64)> + Clone {
    let place = move |index: u32| (f64::from(index) + 0.5) / f64::from(n);
    (0..n * n).map(move |index| (place(index % n), place(index / n)))
}

/// Places of n x n rays in a pixel, turned so that no two stand in one line with its sides: an edge that
/// runs along a row of pixels, as horizons do, meets n² distances instead of n. One ray in each of
/// n x n squares, and no correlation of both places, as with [`offsets`].
pub(crate) fn turned_offsets(n: u32) -> impl Iterator<Item = (f64, f64)> + Clone {
    let n_f64 = f64::from(n);
    let place = move |square: u32, within: u32| {
        (f64::from(square) + (f64::from(within) + 0.5) / n_f64) / n_f64
    };
    (0..n * n).map(move |index| {
        let (column, row) = (index % n, index / n);
        (place(column, row), place(row, n - 1 - column))
    })
}

/// The pixels within [`REACH_PX`] around a region: above and below it with the corners, left and right of it.
pub(crate) fn apron(region: PixelRegion) -> [PixelRegion; 4] {
    let (x_px, y_px) = (region.x_px, region.y_px);
    // A region that was checked ends far below 2^31.
    let (right, bottom) = (region.right() as i32, region.bottom() as i32);
    let reach = REACH_PX as i32;
    let rows = |y_px| PixelRegion {
        x_px: x_px - reach,
        y_px,
        width_px: region.width_px + 2 * REACH_PX,
        height_px: REACH_PX,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_places_stand_at_all_distances_of_both_axes_once() {
        for n in [1, 2, 5, 8] {
            let n_rays = f64::from(n * n);
            for axis in [|place: (f64, f64)| place.0, |place: (f64, f64)| place.1] {
                let mut along: Vec<f64> = turned_offsets(n).map(axis).collect();
                along.sort_by(f64::total_cmp);
                for (index, place) in (0..).zip(along) {
                    let expected = (f64::from(index) + 0.5) / n_rays;
                    assert!((place - expected).abs() < 1e-12, "{n}: {place} {expected}");
                }
            }
        }
    }

    #[test]
    fn turned_places_have_the_mean_of_a_pixel_and_no_correlation() {
        for n in [1, 2, 3, 8] {
            let mean = |of: fn(f64, f64) -> f64| {
                turned_offsets(n).map(|(x, y)| of(x, y)).sum::<f64>() / f64::from(n * n)
            };
            assert!((mean(|x, _| x) - 0.5).abs() < 1e-12);
            assert!((mean(|_, y| y) - 0.5).abs() < 1e-12);
            assert!((mean(|x, y| x * y) - 0.25).abs() < 1e-12);
        }
    }
}
