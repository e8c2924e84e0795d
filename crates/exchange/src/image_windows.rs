//! Which pixels of a frame an image holds, and which of them are shown.
//!
//! The data window of an EXR file says where its pixels lie, the display window what the camera
//! frames: a tile's data window is a part of it, that of an image with overscan is larger.
//! [EXR] OpenEXR, technical introduction, "Image size, data window".

use niji_geometry::PixelRegion;

/// The two windows of an image.
///
/// ```
/// use niji_exchange::ImageWindows;
/// use niji_geometry::PixelRegion;
/// let frame = PixelRegion::frame(640, 480);
/// let windows = ImageWindows { data: frame.grown(16)?, display: frame };
/// assert_eq!(windows.shown(), frame);
/// assert_eq!(ImageWindows::whole(640, 480).shown(), frame);
/// # Ok::<(), niji_geometry::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageWindows {
    /// The pixels that the image holds.
    pub data: PixelRegion,
    /// The pixels of the camera's frame.
    pub display: PixelRegion,
}

impl ImageWindows {
    /// An image that is its frame.
    #[must_use]
    pub fn whole(width_px: usize, height_px: usize) -> Self {
        let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        let frame = PixelRegion::frame(size(width_px), size(height_px));
        Self {
            data: frame,
            display: frame,
        }
    }

    /// What a preview shows: the part of the frame that is there, or all pixels of a tile that lies
    /// outside the frame.
    #[must_use]
    pub fn shown(&self) -> PixelRegion {
        self.data.intersection(self.display).unwrap_or(self.data)
    }
}
