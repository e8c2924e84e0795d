//! Linear light by row and column, and how much of it a file may hold.

use ndarray::Array2;
use niji_radiometry::Bytes;
use niji_radiometry::memory_limit;

use crate::error::Error;

/// Most pixels that are read: a square of 16384.
pub(crate) const MOST_PIXELS: u64 = 1 << 28;
/// Most bits in a byte of a file: deflate packs at most 1032 bytes into one.
const MOST_BITS_PER_BYTE: u64 = 8 * 1032;
/// Linear Rec.709 by row and column.
pub type LinearPicture = Array2<[f32; 3]>;

/// Refuses what does not fit into memory.
pub(crate) fn check_memory(needed_bytes: u128) -> Result<(), Error> {
    let (needed, limit) = (Bytes(needed_bytes), memory_limit());
    if needed > limit {
        return Err(Error::Memory { needed, limit });
    }
    Ok(())
}

/// Refuses sizes that no sound file of this length has whose pixels have so many bits.
pub(crate) fn check_size(
    [width, height]: [u64; 2],
    bits: u64,
    file_bytes: u64,
) -> Result<(), Error> {
    let most = MOST_PIXELS.min(file_bytes.saturating_mul(MOST_BITS_PER_BYTE) / bits.max(1));
    let n_pixels = width.saturating_mul(height);
    if n_pixels == 0 || n_pixels > most {
        return Err(Error::TooLarge {
            width,
            height,
            file_bytes,
            most,
        });
    }
    Ok(())
}
