//! Colors as people compare them: Oklab.
//!
//! Distances in Oklab are close to perceived differences; L runs from 0 to 1, a and b within ±0.4.
//! [Ott20] B. Ottosson, A perceptual color space for image processing (2020), as the crate `palette`
//! computes it.

use palette::LinSrgb;
use palette::Oklab;
use palette::convert::FromColorUnclamped;

/// L, a, b of a linear Rec.709 color.
pub(crate) fn oklab([red, green, blue]: [f32; 3]) -> [f32; 3] {
    let lab = Oklab::from_color_unclamped(LinSrgb::new(red, green, blue));
    [lab.l, lab.a, lab.b]
}

/// Linear Rec.709 of L, a, b.
pub(crate) fn from_oklab([l, a, b]: [f32; 3]) -> [f32; 3] {
    let color = LinSrgb::from_color_unclamped(Oklab::new(l, a, b));
    [color.red, color.green, color.blue]
}

/// The square of the difference of two colors of Oklab.
pub(crate) fn square_apart(one: [f32; 3], other: [f32; 3]) -> f32 {
    let pairs = one.iter().zip(other);
    pairs
        .map(|(one, other)| (one - other) * (one - other))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_red_and_blue_are_where_the_author_puts_them() {
        // Ott20 and CSS Color 4: red 0.62796 0.22486 0.12585, blue 0.45201 -0.03246 -0.31153.
        for (rgb, expected) in [
            ([1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.62796, 0.22486, 0.12585]),
            ([0.0, 0.0, 1.0], [0.45201, -0.03246, -0.31153]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ] {
            let found = oklab(rgb);
            for (found, expected) in found.iter().zip(expected) {
                // The published values have four digits.
                assert!((found - expected).abs() < 1e-4, "{rgb:?}: {found}");
            }
            for (back, channel) in from_oklab(found).iter().zip(rgb) {
                assert!((back - channel).abs() < 1e-5);
            }
        }
    }
}
