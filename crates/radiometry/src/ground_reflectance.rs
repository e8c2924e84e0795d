//! Reflectance of grounds as it was measured, by wavelength.
//!
//! A broken line through values every 10 nm from 350 to 830 nm, constant outside; between them grass errs most, by 0.003
//! where leaves begin to shine at 700 nm. Samples and records are named in `data/ground_reflectances.csv`.
//! [K17] R. F. Kokaly et al., USGS Spectral Library Version 7, U.S. Geological Survey Data Series 1035 (2017).

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::tabulated_spectrum::TabulatedSpectrum;

/// A ground whose reflectance was measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GroundCover {
    /// A lawn, measured where it grows.
    Grass,
    /// Golden grass of a dry summer.
    DryGrass,
    /// Needles of a pine, laid close.
    Needles,
    /// Pale dry mud of a playa.
    Soil,
    /// Sand of a beach.
    Sand,
    /// Melting snow.
    Snow,
    /// Light gray concrete of a road.
    Concrete,
}

static SPECTRA: LazyLock<[TabulatedSpectrum; GroundCover::ALL.len()]> = LazyLock::new(|| {
    let table = include_str!("../../../data/ground_reflectances.csv");
    GroundCover::ALL.map(|cover| {
        TabulatedSpectrum::from_csv(table, cover.name())
            .expect("the embedded table is part of this program and every column is read by tests")
    })
});

impl GroundCover {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Grass,
        Self::DryGrass,
        Self::Needles,
        Self::Soil,
        Self::Sand,
        Self::Snow,
        Self::Concrete,
    ];

    /// Its name in a scene, and of its column.
    pub fn name(self) -> &'static str {
        match self {
            Self::Grass => "grass",
            Self::DryGrass => "dry-grass",
            Self::Needles => "needles",
            Self::Soil => "soil",
            Self::Sand => "sand",
            Self::Snow => "snow",
            Self::Concrete => "concrete",
        }
    }

    /// Its reflectance, 0..1.
    pub fn spectrum(self) -> &'static TabulatedSpectrum {
        &SPECTRA[self as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Nanometers;

    #[test]
    fn every_column_is_a_reflectance() {
        for cover in GroundCover::ALL {
            let points = cover.spectrum().points();
            assert_eq!(points.len(), 49, "{cover:?}");
            assert!(points.iter().all(|point| (0.0..=1.0).contains(&point.1)));
        }
    }

    #[test]
    fn leaves_are_green_and_shine_beyond_700_nm_and_snow_is_white() {
        for leaves in [GroundCover::Grass, GroundCover::Needles] {
            let at = |nm| leaves.spectrum().at(Nanometers(nm));
            assert!(at(550.0) > at(450.0) && at(550.0) > at(670.0), "{leaves:?}");
            assert!(at(780.0) > 3.0 * at(670.0), "{leaves:?}");
        }
        let snow = |nm| GroundCover::Snow.spectrum().at(Nanometers(nm));
        assert!((snow(450.0) - snow(650.0)).abs() < 0.02 && snow(550.0) > 0.8);
        // Soil, sand and dry grass redden without a turn.
        for bare in [GroundCover::Soil, GroundCover::Sand, GroundCover::DryGrass] {
            let points = bare.spectrum().points();
            let visible = points.iter().filter(|point| point.0 <= 700.0);
            assert!(visible.is_sorted_by(|a, b| a.1 < b.1), "{bare:?}");
        }
    }

    #[test]
    fn between_its_nodes_a_lawn_is_as_measured() {
        // Values of the measurement by 1 nm that the table leaves out.
        for (nm, measured) in [
            (525.0, 0.0486),
            (695.0, 0.0521),
            (705.0, 0.1003),
            (715.0, 0.1660),
            (735.0, 0.3389),
        ] {
            let found = GroundCover::Grass.spectrum().at(Nanometers(nm));
            assert!(
                (found - measured).abs() < 5e-3,
                "{nm} nm: {found}, measured {measured}"
            );
        }
    }
}
