//! What can be wrong with a camera.

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// The field of view of a pinhole camera lies strictly between 0 and 180 degrees.
    #[error("found a field of view of {found_deg} degrees, expected more than 0 and less than 180")]
    FieldOfView {
        /// The field of view asked for, in degrees.
        found_deg: f64,
    },
    /// A picture needs pixels.
    #[error("found a picture of {width_px} x {height_px} pixels, expected at least 1 x 1")]
    EmptyPicture {
        /// Width asked for.
        width_px: u32,
        /// Height asked for.
        height_px: u32,
    },
    /// NaN or infinity in a position or an angle.
    #[error("found a position or an angle that is not a finite number")]
    NotFinite,
}
