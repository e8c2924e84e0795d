//! The voxel types that a tree may hold, and their bytes in a file.

use half::f16;

/// A voxel value: `f32`, `f64`, `half::f16`, `[f32; 3]`, `i32` or `bool`.
///
/// Sealed: the tree types of a VDB file are a closed list.
pub trait Value:
    Copy + PartialEq + std::fmt::Debug + Send + Sync + sealed::Bytes + 'static
{
}

pub(crate) mod sealed {
    /// How a value stands in a file, little-endian.
    pub trait Bytes: Copy {
        /// Zero, or false.
        const ZERO: Self;
        /// Bytes of a value in a file.
        const SIZE: usize;
        /// Bytes of a value in a file that stores reals as halves; 0 where there is no such form.
        const HALF_SIZE: usize;
        /// Leaves of bools are stored as two masks.
        const IS_BOOL: bool = false;
        /// Name of the value in the grid type `Tree_<name>_5_4_3`.
        const TYPE_NAME: &'static str;

        /// Decode `SIZE` bytes.
        fn decode(bytes: &[u8]) -> Self;
        /// Decode `HALF_SIZE` bytes.
        fn decode_half(bytes: &[u8]) -> Self;
        /// Fill `SIZE` bytes.
        fn fill(self, bytes: &mut [u8]);
        /// Append `SIZE` bytes.
        fn encode(self, bytes: &mut Vec<u8>) {
            Self::encode_all(&[self], bytes);
        }
        /// Append all values, one behind the other.
        fn encode_all(values: &[Self], bytes: &mut Vec<u8>) {
            let start = bytes.len();
            bytes.resize(start + values.len() * Self::SIZE, 0);
            let places = bytes[start..].chunks_exact_mut(Self::SIZE);
            for (place, value) in places.zip(values) {
                value.fill(place);
            }
        }
        /// The value with the other sign, as `-background` is meant in a file.
        fn negated(self) -> Self;
        /// Equality of the stored bytes, so that a NaN equals itself and -0 differs from 0.
        fn same_bytes(self, other: Self) -> bool;
    }
}

/// The first `N` bytes; callers hand over slices of at least that length.
fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[..N]);
    out
}

impl Value for f32 {}

impl sealed::Bytes for f32 {
    const ZERO: Self = 0.0;
    const SIZE: usize = 4;
    const HALF_SIZE: usize = 2;
    const TYPE_NAME: &'static str = "float";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        Self::from_le_bytes(array(bytes))
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        f16::from_le_bytes(array(bytes)).to_f32()
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn negated(self) -> Self {
        -self
    }

    fn same_bytes(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl Value for f64 {}

impl sealed::Bytes for f64 {
    const ZERO: Self = 0.0;
    const SIZE: usize = 8;
    const HALF_SIZE: usize = 2;
    const TYPE_NAME: &'static str = "double";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        Self::from_le_bytes(array(bytes))
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        f16::from_le_bytes(array(bytes)).to_f64()
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn negated(self) -> Self {
        -self
    }

    fn same_bytes(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl Value for f16 {}

impl sealed::Bytes for f16 {
    const ZERO: Self = Self::ZERO;
    const SIZE: usize = 2;
    // OpenVDB: `RealToHalf` knows no shorter form of a half.
    const HALF_SIZE: usize = 0;
    const TYPE_NAME: &'static str = "half";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        Self::from_le_bytes(array(bytes))
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        Self::decode(bytes)
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn negated(self) -> Self {
        -self
    }

    fn same_bytes(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
}

impl Value for [f32; 3] {}

impl sealed::Bytes for [f32; 3] {
    const ZERO: Self = [0.0; 3];
    const SIZE: usize = 12;
    const HALF_SIZE: usize = 6;
    const TYPE_NAME: &'static str = "vec3s";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        [0, 4, 8].map(|at| f32::decode(&bytes[at..at + 4]))
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        [0, 2, 4].map(|at| f32::decode_half(&bytes[at..at + 2]))
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        for (place, component) in bytes.chunks_exact_mut(4).zip(self) {
            component.fill(place);
        }
    }

    fn negated(self) -> Self {
        self.map(|component| -component)
    }

    fn same_bytes(self, other: Self) -> bool {
        self.map(f32::to_bits) == other.map(f32::to_bits)
    }
}

impl Value for i32 {}

impl sealed::Bytes for i32 {
    const ZERO: Self = 0;
    const SIZE: usize = 4;
    const HALF_SIZE: usize = 0;
    const TYPE_NAME: &'static str = "int32";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        Self::from_le_bytes(array(bytes))
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        Self::decode(bytes)
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        bytes.copy_from_slice(&self.to_le_bytes());
    }

    fn negated(self) -> Self {
        // The least i32 has no opposite; C++ on every common machine wraps.
        self.wrapping_neg()
    }

    fn same_bytes(self, other: Self) -> bool {
        self == other
    }
}

impl Value for bool {}

impl sealed::Bytes for bool {
    const ZERO: Self = false;
    const SIZE: usize = 1;
    const HALF_SIZE: usize = 0;
    const IS_BOOL: bool = true;
    const TYPE_NAME: &'static str = "bool";

    #[inline]
    fn decode(bytes: &[u8]) -> Self {
        bytes[0] != 0
    }

    #[inline]
    fn decode_half(bytes: &[u8]) -> Self {
        Self::decode(bytes)
    }

    #[inline]
    fn fill(self, bytes: &mut [u8]) {
        bytes[0] = u8::from(self);
    }

    fn negated(self) -> Self {
        // OpenVDB: `math::negative(bool)` is the other value.
        !self
    }

    fn same_bytes(self, other: Self) -> bool {
        self == other
    }
}
