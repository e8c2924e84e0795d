//! Hard cases of light and color: bins of no width, darkness, light that no display has.

use niji_radiometry::GamutPolicy;
use niji_radiometry::Nanometers;
use niji_radiometry::RgbPrimaries;
use niji_radiometry::TabulatedSpectrum;
use niji_radiometry::Water;
use niji_radiometry::ice_refractive_index;
use niji_radiometry::into_gamut;
use niji_radiometry::srgb_decode;
use niji_radiometry::srgb_encode;
use niji_radiometry::xy_chromaticity;

use crate::hard_case::HardCase;
use crate::hard_case::relative;
use crate::hard_case::violations;
use crate::hard_case::worst;

pub(crate) const CASES: &[HardCase] = &[
    HardCase {
        claim: "a bin of a billionth of a nanometre has the light at its middle",
        measure: "relative difference of its mean from the value there",
        allowed: 1e-10,
        error: narrow_bins,
    },
    HardCase {
        claim: "darkness and NaN have no chromaticity",
        measure: "colors found",
        allowed: 0.0,
        error: chromaticity_of_darkness,
    },
    HardCase {
        claim: "light that no display has, from 1e-300 to 1e300, ends in its gamut",
        measure: "colors that are not finite, or negative",
        allowed: 0.0,
        error: colors_beyond_the_gamut,
    },
    HardCase {
        claim: "sRGB gives linear light back from 1e-300 to 1",
        measure: "relative error",
        allowed: 1e-14,
        error: srgb_round_trip,
    },
    HardCase {
        claim: "supercooled, boiling, salt, ultraviolet and infrared water refracts",
        measure: "indices outside of 1.3 to 1.4",
        allowed: 0.0,
        error: ends_of_the_spectrum,
    },
];

fn narrow_bins() -> f64 {
    let spectrum = TabulatedSpectrum::from_points(&[(300.0, 1.0), (500.0, 3.0), (1000.0, 0.5)]);
    let spectrum = spectrum.expect("three points");
    // On a node of the table and between nodes.
    worst([300.5, 393.7, 500.0, 760.123].map(|center_nm| {
        let [lo, hi] = [-0.5e-9, 0.5e-9].map(|off| Nanometers(center_nm + off));
        relative(
            spectrum.bin_mean(lo, hi),
            spectrum.at(Nanometers(center_nm)),
        )
    }))
}

fn chromaticity_of_darkness() -> f64 {
    let dark = [
        [0.0; 3],
        [-1.0, 0.0, 0.0],
        [f64::NAN; 3],
        [f64::INFINITY; 3],
    ];
    violations(dark.map(|xyz| xy_chromaticity(xyz).is_none()))
}

fn colors_beyond_the_gamut() -> f64 {
    let scales = [1e-300, 1e-12, 1.0, 1e12, 1e300].into_iter();
    violations(scales.flat_map(|scale| {
        let colors = [
            [-1.0, 1.0, 0.5],
            [1.0, -1e-17, 0.0],
            [-1.0, -1.0, -1.0],
            [0.0, 0.0, 0.0],
            [5.0, -0.4, 0.1],
        ];
        colors.map(|color| {
            let color = color.map(|channel| scale * channel);
            let shown = into_gamut(color, RgbPrimaries::Rec709, GamutPolicy::Desaturate);
            shown
                .into_iter()
                .all(|channel| channel.is_finite() && channel >= 0.0)
        })
    }))
}

fn srgb_round_trip() -> f64 {
    let light = [1e-300, 1e-12, 0.003_130_8, 0.003_130_9, 0.18, 1.0];
    worst(light.map(|linear| relative(srgb_decode(srgb_encode(linear)), linear)))
}

fn ends_of_the_spectrum() -> f64 {
    let wavelengths = [300.0, 550.0, 1000.0].map(Nanometers);
    violations(wavelengths.into_iter().flat_map(|wavelength| {
        let water = [-20.0, 0.0, 100.0].map(Water::pure);
        let salt = [0.0, 30.0].map(Water::of_the_sea);
        let (ice, absorption) = ice_refractive_index(wavelength);
        let indices = water.into_iter().chain(salt);
        let indices = indices.map(|water| water.refractive_index(wavelength));
        let indices = indices.chain([ice, 1.35 + absorption]);
        indices.map(|n| (1.3..1.4).contains(&n)).collect::<Vec<_>>()
    }))
}
