//! Linear RGB with the primaries of a display or of an exchange between programs.
//!
//! RGB' = M RGB,  M = P'^-1 A P,  A = B^-1 diag(B W'/B W) B
//! `P` XYZ of the primaries of unit white, `W` XYZ of the white, `B` cone responses of Bradford: a
//! neutral stays one, though D65 is the white of Rec.709 and (0.32168, 0.33767), near D60, that of
//! ACEScg. Entries are that definition in exact arithmetic.
//! [S2014] S-2014-004, ACEScg, a working space for CGI render and compositing, AMPAS (2014); adaptation
//! as in [ACES] ACESlib.Utilities_Color, `calculate_cat_matrix`, AMPAS (2016); [BT709] ITU-R BT.709-6.

use crate::color_space::linear_rec709_to_xyz;
use crate::color_space::multiply;

/// ACEScg of linear Rec.709.
const ACESCG_FROM_REC709: [[f64; 3]; 3] = [
    [
        0.613097402401187649,
        0.339523146184105669,
        0.0473794514147066822,
    ],
    [
        0.0701937224695817406,
        0.916353879057344160,
        0.0134523984730740991,
    ],
    [
        0.0206155928822269733,
        0.109569772938135487,
        0.869814634179637540,
    ],
];

/// Linear Rec.709 of ACEScg.
const REC709_FROM_ACESCG: [[f64; 3]; 3] = [
    [
        1.70505099265798340,
        -0.621792120657004731,
        -0.0832588720009786693,
    ],
    [
        -0.130256417507043475,
        1.14080473657540148,
        -0.0105483190683580077,
    ],
    [
        -0.0240033568046181255,
        -0.128968976064970616,
        1.15297233286958874,
    ],
];

/// Share of each primary of ACEScg in the luminance.
const ACESCG_LUMINANCE: [f64; 3] = [
    0.272228716780914564,
    0.674081765811148387,
    0.0536895174079370493,
];

/// How far chromaticities in a file may be from the definition: they are rounded in some.
const ROUNDED: f64 = 1e-3;

/// Which lights red, green and blue stand for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RgbPrimaries {
    /// Rec.709, also those of sRGB.
    #[default]
    Rec709,
    /// AP1, in which compositors exchange ACES: its triangle holds nearly all colors of surfaces.
    AcesCg,
}

impl RgbPrimaries {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Rec709, Self::AcesCg];

    /// Chromaticities (x, y) of red, green, blue and white.
    ///
    /// ```
    /// use niji_radiometry::RgbPrimaries;
    /// let [.., white] = RgbPrimaries::AcesCg.chromaticities();
    /// assert_eq!(white, [0.32168, 0.33767]);
    /// ```
    pub fn chromaticities(self) -> [[f64; 2]; 4] {
        match self {
            Self::Rec709 => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]],
            Self::AcesCg => [
                [0.713, 0.293],
                [0.165, 0.830],
                [0.128, 0.044],
                [0.32168, 0.33767],
            ],
        }
    }

    /// The primaries with these chromaticities of red, green, blue and white, if there are any here.
    pub fn of_chromaticities(found: [[f64; 2]; 4]) -> Option<Self> {
        Self::ALL.into_iter().find(|primaries| {
            let pairs = primaries.chromaticities().into_iter().zip(found);
            let is_near = |(a, b): (f64, f64)| (a - b).abs() <= ROUNDED;
            pairs
                .flat_map(|(own, found)| own.into_iter().zip(found))
                .all(is_near)
        })
    }

    /// The color `rgb` of linear Rec.709 in these primaries; no channel is clipped.
    pub fn of_linear_rec709(self, rgb: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Rec709 => rgb,
            Self::AcesCg => multiply(&ACESCG_FROM_REC709, rgb),
        }
    }

    /// Linear Rec.709 of a color in these primaries.
    pub fn to_linear_rec709(self, rgb: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Rec709 => rgb,
            Self::AcesCg => multiply(&REC709_FROM_ACESCG, rgb),
        }
    }

    /// Luminance of a color in these primaries, 1 for white.
    pub fn luminance(self, rgb: [f64; 3]) -> f64 {
        match self {
            Self::Rec709 => linear_rec709_to_xyz(rgb)[1],
            Self::AcesCg => {
                let shares = ACESCG_LUMINANCE.into_iter().zip(rgb);
                shares.map(|(share, channel)| share * channel).sum()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding: worst found 4.5e-16.
    const ROUND_TRIP: f64 = 2e-15;

    const COLORS: [[f64; 3]; 4] = [
        [0.2, 0.5, 0.9],
        [-0.3, 0.7, 0.1],
        [1.0, 0.0, 0.0],
        [40.0, 0.0, 1e-3],
    ];

    #[test]
    fn matrices_follow_from_chromaticities_and_bradford() {
        // Primaries of unit white in XYZ, adapted to the white of the other space, must be the same
        // colors: checked on each of the three, whose sum is the white.
        let white_xyz = |[x, y]: [f64; 2]| [x / y, 1.0, (1.0 - x - y) / y];
        let cones = [
            [0.8951, 0.2664, -0.1614],
            [-0.7502, 1.7135, 0.0367],
            [0.0389, -0.0685, 1.0296],
        ];
        let whites = RgbPrimaries::ALL.map(|primaries| {
            let [.., white] = primaries.chromaticities();
            multiply(&cones, white_xyz(white))
        });
        for unit in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let rec709 = RgbPrimaries::AcesCg.to_linear_rec709(unit);
            let seen = multiply(&cones, linear_rec709_to_xyz(rec709));
            let adapted = [0, 1, 2].map(|cone| seen[cone] * whites[1][cone] / whites[0][cone]);
            let [red, green, blue, _] = RgbPrimaries::AcesCg.chromaticities();
            let index = unit.iter().position(|&channel| channel > 0.0).unwrap();
            let [x, y] = [red, green, blue][index];
            let luminance = ACESCG_LUMINANCE[index];
            let expected = multiply(&cones, white_xyz([x, y])).map(|cone| luminance * cone);
            for (found, expected) in adapted.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-14, "{found} {expected}");
            }
        }
    }

    #[test]
    fn colors_survive_a_round_trip_and_white_stays_white() {
        for primaries in RgbPrimaries::ALL {
            for rgb in COLORS {
                let back = primaries.to_linear_rec709(primaries.of_linear_rec709(rgb));
                for (found, expected) in back.iter().zip(rgb) {
                    assert!((found - expected).abs() <= ROUND_TRIP * 40.0_f64.max(expected));
                }
            }
            for channel in primaries.of_linear_rec709([1.0; 3]) {
                assert!((channel - 1.0).abs() <= ROUND_TRIP);
            }
            assert!((primaries.luminance([1.0; 3]) - 1.0).abs() <= ROUND_TRIP);
        }
    }

    #[test]
    fn rec709_red_is_the_published_color_of_acescg() {
        // The first column of the matrix that OpenColorIO ships for these spaces.
        let found = RgbPrimaries::AcesCg.of_linear_rec709([1.0, 0.0, 0.0]);
        for (found, published) in found.iter().zip([0.613097, 0.070194, 0.020616]) {
            assert!((found - published).abs() < 5e-7);
        }
    }

    #[test]
    fn rounded_chromaticities_are_known_and_others_are_not() {
        for primaries in RgbPrimaries::ALL {
            let rounded = primaries
                .chromaticities()
                .map(|xy| xy.map(|value| f64::from(value as f32)));
            assert_eq!(RgbPrimaries::of_chromaticities(rounded), Some(primaries));
        }
        let mut rec2020 = [
            [0.708, 0.292],
            [0.170, 0.797],
            [0.131, 0.046],
            [0.3127, 0.329],
        ];
        assert_eq!(RgbPrimaries::of_chromaticities(rec2020), None);
        rec2020[0][0] = f64::NAN;
        assert_eq!(RgbPrimaries::of_chromaticities(rec2020), None);
    }
}
