//! Rectangles of pixels in the frame of a camera.
//!
//! band i of n:  rows floor(i h / n) .. floor((i + 1) h / n)
//! `h` rows of the region that is cut. Pixel (0, 0) of the frame is its top left one; a region may
//! reach beyond the frame (overscan) and has negative coordinates there.
//!
//! A frame is shared out in bands of whole rows rather than in near-square tiles: files hold rows, so
//! bands are put together by writing one behind the other and a picture that was interrupted goes on
//! at a row. Where pixels are rendered beyond a tile's edge, because an estimate looks at neighbors,
//! a band of h rows costs 2/h more work; 16 bands of a frame of 1080 rows, 3 %.

use crate::error::Error;

/// Farthest from the frame's corner that a region may reach, in pixels: EXR counts them in 32 bits,
/// and some readers add two such numbers.
const FARTHEST_PX: i64 = 1 << 24;

/// A rectangle of pixels.
///
/// ```
/// use niji_geometry::PixelRegion;
/// let frame = PixelRegion::frame(1920, 1080);
/// let overscan = frame.grown(32)?;
/// assert_eq!((overscan.x_px, overscan.width_px), (-32, 1984));
/// assert_eq!(overscan.bands(3)?.len(), 3);
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRegion {
    /// Column of its left pixels.
    pub x_px: i32,
    /// Row of its top pixels.
    pub y_px: i32,
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

impl PixelRegion {
    /// The whole frame of a camera.
    #[must_use]
    pub fn frame(width_px: u32, height_px: u32) -> Self {
        Self {
            x_px: 0,
            y_px: 0,
            width_px,
            height_px,
        }
    }

    /// The region if it has pixels and files can count them.
    ///
    /// # Errors
    /// [`Error::Region`] for a region without pixels, or one that reaches farther than 2^24 pixels
    /// from the frame's corner.
    pub fn checked(self) -> Result<Self, Error> {
        let ends = [
            self.x_px.into(),
            self.y_px.into(),
            self.right(),
            self.bottom(),
        ];
        let is_near = ends.iter().all(|end: &i64| end.abs() <= FARTHEST_PX);
        if self.width_px == 0 || self.height_px == 0 || !is_near {
            return Err(Error::Region { found: self });
        }
        Ok(self)
    }

    /// The region with a margin on all sides.
    ///
    /// # Errors
    /// As [`Self::checked`].
    pub fn grown(self, margin_px: u32) -> Result<Self, Error> {
        let refused = Error::Region { found: self };
        let margin = i32::try_from(margin_px).map_err(|_| refused.clone())?;
        let grown = |size: u32| size.checked_add(margin_px)?.checked_add(margin_px);
        let region = || {
            Some(Self {
                x_px: self.x_px.checked_sub(margin)?,
                y_px: self.y_px.checked_sub(margin)?,
                width_px: grown(self.width_px)?,
                height_px: grown(self.height_px)?,
            })
        };
        region().ok_or(refused)?.checked()
    }

    /// The region cut into bands of whole rows from top to bottom, as even as can be.
    ///
    /// # Errors
    /// [`Error::Bands`] for no bands, or more than there are rows.
    pub fn bands(self, n_bands: u32) -> Result<Vec<Self>, Error> {
        if n_bands == 0 || n_bands > self.height_px {
            return Err(Error::Bands {
                n_bands,
                n_rows: self.height_px,
            });
        }
        let (n_rows, n) = (u64::from(self.height_px), u64::from(n_bands));
        // At most the number of rows, so both fit again.
        let row = |index: u64| (index * n_rows / n) as u32;
        let band = |index: u64| Self {
            y_px: self.y_px + row(index) as i32,
            height_px: row(index + 1) - row(index),
            ..self
        };
        Ok((0..n).map(band).collect())
    }

    /// The column right of it.
    #[must_use]
    pub fn right(self) -> i64 {
        i64::from(self.x_px) + i64::from(self.width_px)
    }

    /// The row below it.
    #[must_use]
    pub fn bottom(self) -> i64 {
        i64::from(self.y_px) + i64::from(self.height_px)
    }

    /// Does another region lie in it?
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.x_px <= other.x_px
            && self.y_px <= other.y_px
            && other.right() <= self.right()
            && other.bottom() <= self.bottom()
    }

    /// The pixels that both have; `None` if there are none.
    #[must_use]
    pub fn intersection(self, other: Self) -> Option<Self> {
        let (x_px, y_px) = (self.x_px.max(other.x_px), self.y_px.max(other.y_px));
        let size = |end: i64, start: i32| u32::try_from(end - i64::from(start)).ok();
        let width_px = size(self.right().min(other.right()), x_px)?;
        let height_px = size(self.bottom().min(other.bottom()), y_px)?;
        (width_px > 0 && height_px > 0).then_some(Self {
            x_px,
            y_px,
            width_px,
            height_px,
        })
    }

    /// Number of its pixels.
    #[must_use]
    pub fn n_pixels(self) -> u64 {
        u64::from(self.width_px) * u64::from(self.height_px)
    }
}

impl std::fmt::Display for PixelRegion {
    /// As the command line has it: `X,Y,W,H`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{},{},{},{}",
            self.x_px, self.y_px, self.width_px, self.height_px
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_cover_every_row_once_and_differ_by_one_row_at_most() {
        let region = PixelRegion::frame(7, 101).grown(3).unwrap();
        for n_bands in [1, 2, 3, 7, 50, 107] {
            let bands = region.bands(n_bands).unwrap();
            assert_eq!(bands.len(), n_bands as usize);
            let mut next = i64::from(region.y_px);
            for band in &bands {
                assert_eq!(i64::from(band.y_px), next);
                assert_eq!((band.x_px, band.width_px), (region.x_px, region.width_px));
                assert!(band.height_px.abs_diff(107 / n_bands) <= 1);
                next = band.bottom();
            }
            assert_eq!(next, region.bottom());
        }
    }

    #[test]
    fn more_bands_than_rows_or_none_are_refused() {
        for n_bands in [0, 11] {
            let error = PixelRegion::frame(5, 10).bands(n_bands).unwrap_err();
            assert_eq!(
                error,
                Error::Bands {
                    n_bands,
                    n_rows: 10
                }
            );
        }
    }

    #[test]
    fn regions_without_pixels_or_far_away_are_refused() {
        let frame = PixelRegion::frame(4, 4);
        for found in [
            PixelRegion {
                width_px: 0,
                ..frame
            },
            PixelRegion {
                height_px: 0,
                ..frame
            },
            PixelRegion {
                x_px: i32::MIN,
                ..frame
            },
            PixelRegion {
                y_px: i32::MAX,
                ..frame
            },
            PixelRegion {
                width_px: u32::MAX,
                ..frame
            },
        ] {
            assert_eq!(found.checked(), Err(Error::Region { found }));
        }
        assert!(frame.grown(u32::MAX).is_err());
        assert!(frame.grown(1 << 30).is_err());
        assert_eq!(frame.grown(0), Ok(frame));
    }

    #[test]
    fn what_two_regions_share_lies_in_both() {
        let frame = PixelRegion::frame(10, 8);
        let region = PixelRegion {
            x_px: -3,
            y_px: 6,
            width_px: 5,
            height_px: 9,
        };
        let shared = frame.intersection(region).unwrap();
        assert_eq!(shared.to_string(), "0,6,2,2");
        assert!(frame.contains(shared) && region.contains(shared));
        assert!(!frame.contains(region));
        // Side by side they share no pixel.
        let beside = PixelRegion { x_px: 10, ..frame };
        assert_eq!(frame.intersection(beside), None);
        assert_eq!(frame.n_pixels(), 80);
    }
}
