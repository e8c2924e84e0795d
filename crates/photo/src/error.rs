//! What can be wrong with a photograph, a depth map or a request.

use niji_radiometry::Bytes;

/// Why a photograph cannot be read, or a request about it cannot be met. The path is known to the
/// caller.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// An empty file.
    #[error("found an empty file, expected a PNG, JPEG or EXR picture")]
    Empty,
    /// A file of another kind.
    #[error("found no PNG, JPEG or EXR picture: convert it to one of them")]
    UnknownFormat,
    /// The bytes are no sound picture.
    #[error("not a sound picture ({0}): it is truncated or damaged, copy it again")]
    Damaged(String),
    /// The header promises more than is read here, or more than the file can hold.
    #[error(
        "the header promises {width} x {height} pixels, found a file of {}, expected at most {most} pixels",
        Bytes(u128::from(*file_bytes))
    )]
    TooLarge {
        /// Promised width.
        width: u64,
        /// Promised height.
        height: u64,
        /// Length of the file.
        file_bytes: u64,
        /// Most pixels such a file may hold.
        most: u64,
    },
    /// A picture that does not fit into memory.
    #[error(
        "the header promises a picture that takes {needed} of memory, expected at most {limit}: make \
         it smaller"
    )]
    Memory {
        /// Memory that its pixels take.
        needed: Bytes,
        /// Memory that they may take.
        limit: Bytes,
    },
    /// A sound EXR file without what a picture needs.
    #[error("found no channel {0:?} in the EXR file, expected R, G and B")]
    MissingChannel(&'static str),
    /// Red, green, blue and white of something else than Rec.709 or ACEScg.
    #[error(
        "found the chromaticities {0:?} of red, green, blue and white in the EXR file, expected those of \
         Rec.709 or ACEScg: convert it, or name its primaries"
    )]
    Primaries([[f64; 2]; 4]),
    /// A rendered image without what compositing needs.
    #[error("found no AOV {0:?} in the image, expected one written by niji render")]
    MissingAov(&'static str),
    /// A depth file without a depth.
    #[error("found several channels and none called Z in the EXR file, expected one channel or Z")]
    NoDepthChannel,
    /// Channels any of which may be the depth.
    #[error("found {0:?} in the EXR file, expected one channel of distances: call it Z or depth.Z")]
    DepthChannels(Vec<String>),
    /// A depth that is measured in something else.
    #[error("found a channel Z in {0:?}, expected a depth in metres")]
    DepthUnit(String),
    /// A value that may not enter a file.
    #[error("found {value} in channel {channel}, pixel ({x}, {y}), expected a finite number")]
    NotFinite {
        /// Channel.
        channel: &'static str,
        /// Column, from 0 at the left.
        x: usize,
        /// Row, from 0 at the top.
        y: usize,
        /// What was found.
        value: f32,
    },
    /// Two pictures that must have one size.
    #[error("found {what} of {found_width} x {found_height} pixels, expected {width} x {height}")]
    Size {
        /// Which picture.
        what: &'static str,
        /// Its width.
        found_width: usize,
        /// Its height.
        found_height: usize,
        /// The width expected.
        width: usize,
        /// The height expected.
        height: usize,
    },
    /// A distance that no surface has.
    #[error("found the depth {value} in pixel ({x}, {y}), expected a number of at least 0")]
    Depth {
        /// Column, from 0 at the left.
        x: usize,
        /// Row, from 0 at the top.
        y: usize,
        /// What was found.
        value: f32,
    },
    /// A file of layers that says something else.
    #[error("no file of layers: {0}")]
    Layers(String),
    /// Anchor points from which no scale follows.
    #[error("the anchor points give no depth: {0}")]
    Anchors(String),
    /// Too few picked pixels.
    #[error("found {found} picked pixels, expected at least {expected}")]
    TooFewPicks {
        /// Picks given.
        found: usize,
        /// Picks needed.
        expected: usize,
    },
    /// A value outside its range.
    #[error("found {found} for {what}, expected {expected}")]
    Range {
        /// The quantity.
        what: &'static str,
        /// Its value.
        found: f64,
        /// The range, in words.
        expected: &'static str,
    },
    /// A picture that cannot be encoded.
    #[error("the picture cannot be encoded: {0}")]
    Encode(String),
    /// A camera that cannot be.
    #[error("{0}")]
    Camera(#[from] niji_geometry::Error),
}
