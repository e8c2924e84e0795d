//! Linear light by row and column, and how much of it a file may hold.

use ndarray::Array2;
use ndarray::ArrayView2;
use ndarray::Zip;
use niji_radiometry::Bytes;
use niji_radiometry::memory_limit;

use crate::error::Error;

/// Most pixels that are read: a square of 16384.
pub(crate) const MOST_PIXELS: u64 = 1 << 28;
/// Most bits in a byte of a file: deflate packs at most 1032 bytes into one.
const MOST_BITS_PER_BYTE: u64 = 8 * 1032;
/// Linear Rec.709 by row and column.
pub type LinearPicture = Array2<[f32; 3]>;

/// Means of squares of `n` x `n` pixels, `n` above 0; those at the right and below may hold fewer.
#[must_use]
pub fn square_means<const N: usize>(picture: &ArrayView2<[f32; N]>, n: usize) -> Array2<[f32; N]> {
    let (height, width) = picture.dim();
    let mut means = Array2::from_elem((height.div_ceil(n), width.div_ceil(n)), [0.0; N]);
    Zip::indexed(&mut means).par_for_each(|(y, x), mean: &mut [f32; N]| {
        let (mut sum, mut n_pixels) = ([0.0_f32; N], 0.0);
        for row in y * n..((y + 1) * n).min(height) {
            for column in x * n..((x + 1) * n).min(width) {
                n_pixels += 1.0;
                for (sum, channel) in sum.iter_mut().zip(picture[[row, column]]) {
                    *sum += channel;
                }
            }
        }
        *mean = sum.map(|sum| sum / n_pixels);
    });
    means
}

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
