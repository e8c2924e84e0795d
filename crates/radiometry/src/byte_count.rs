//! Amounts of memory and of file, as every message shows them.
//!
//! 1 KiB = 2^10, 1 MiB = 2^20, 1 GiB = 2^30 bytes; two digits of the largest unit of which there is one.

use std::fmt;

/// A number of bytes.
///
/// ```
/// use niji_radiometry::Bytes;
///
/// assert_eq!(Bytes(4 << 30).to_string(), "4 GiB");
/// assert_eq!(Bytes::of(1.5e6).to_string(), "1.4 MiB");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Bytes(pub u128);

/// Units from the largest down.
const UNITS: [(&str, u32); 4] = [("TiB", 40), ("GiB", 30), ("MiB", 20), ("KiB", 10)];

impl Bytes {
    /// A number that was computed, fractions left out.
    #[must_use]
    pub fn of(count: f64) -> Self {
        Self(count as u128)
    }

    /// The number that a text says, `4 GiB` or `1.5MiB`; `None` for any other.
    #[must_use]
    pub fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (unit, power) = UNITS.into_iter().find(|(unit, _)| text.ends_with(unit))?;
        let amount: f64 = text.strip_suffix(unit)?.trim_end().parse().ok()?;
        (amount.is_finite() && amount >= 0.0).then(|| Self::of(amount * 2_f64.powi(power as i32)))
    }
}

impl fmt::Display for Bytes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some((unit, power)) = UNITS.into_iter().find(|(_, power)| self.0 >> power > 0) else {
            return write!(out, "{} bytes", self.0);
        };
        let amount = self.0 as f64 / 2_f64.powi(power as i32);
        let n_decimals = usize::from(amount < 9.95);
        let text = format!("{amount:.n_decimals$}");
        write!(out, "{} {unit}", text.trim_end_matches(".0"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_of_the_largest_unit_are_shown() {
        for (bytes, text) in [
            (0, "0 bytes"),
            (1023, "1023 bytes"),
            (1024, "1 KiB"),
            (9_999, "9.8 KiB"),
            (10_210, "10 KiB"),
            (123_456_789, "118 MiB"),
            (5 << 30, "5 GiB"),
            (3 << 41, "6 TiB"),
            (u128::MAX, "309485009821345068724781056 TiB"),
        ] {
            assert_eq!(Bytes(bytes).to_string(), text);
        }
    }

    #[test]
    fn numbers_are_read_as_they_are_shown() {
        for (text, bytes) in [
            ("4 GiB", 4 << 30),
            ("1.5MiB", 3 << 19),
            (" 0 KiB ", 0),
            ("2TiB", 2 << 40),
        ] {
            assert_eq!(Bytes::parse(text), Some(Bytes(bytes)), "{text}");
        }
        for text in [
            "",
            "4",
            "GiB",
            "4 GB",
            "-1 GiB",
            "nan KiB",
            "infGiB",
            "4 Gib",
            "1e400 KiB",
        ] {
            assert_eq!(Bytes::parse(text), None, "{text}");
        }
    }

    #[test]
    fn what_is_no_number_of_bytes_is_none_or_the_most() {
        let found = [-1.0, f64::NAN, f64::INFINITY].map(|count| Bytes::of(count).0);
        assert_eq!(found, [0, 0, u128::MAX]);
    }
}
