//! What can keep a picture from being rendered.

use niji_radiometry::Bytes;
use niji_radiometry::WavelengthGrid;

/// A request that cannot be met.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Whoever waits for it wants no more.
    #[error("stopped")]
    Stopped,
    /// The region has no pixels or lies too far away.
    #[error("{0}")]
    Region(niji_geometry::Error),
    /// The picture does not fit into memory.
    #[error(
        "a picture of {} x {} pixels needs {}, which cannot be had (at most {limit}): render fewer \
         pixels, or a part of them at a time", size_px.0, size_px.1, Bytes(u128::from(*bytes))
    )]
    Memory {
        /// Width and height of the region.
        size_px: (u32, u32),
        /// What its arrays take.
        bytes: u64,
        /// What they may take.
        limit: Bytes,
    },
    /// The direction towards the sun is not a unit vector.
    #[error("found a sun direction {found:?}, expected a unit vector towards the sun")]
    SunDirection {
        /// The vector found.
        found: [f64; 3],
    },
    /// The shadows in the drops are those of another sun.
    #[error(
        "the drops hold the shadows of a sun in another direction than {expected:?}: light them \
         again for this sun"
    )]
    ShadowOfAnotherSun {
        /// The sun of the picture.
        expected: [f64; 3],
    },
    /// Drops shall cast shadows, but their way to the sun was never looked at.
    #[error("drop shadow is on, but the drops were lit with the sun path ignored")]
    NoShadow,
    /// Light that drops scatter more than once is what their extinction takes.
    #[error(
        "multiple scattering by drops is on without {without}: it gives back what that takes, switch \
         both on or both off"
    )]
    OrdersWithout {
        /// The effect that is off.
        without: &'static str,
    },
    /// The setting of a level is out of its range.
    #[error("{level} = {found}, expected {expected}")]
    Level {
        /// Which setting.
        level: &'static str,
        /// Its value.
        found: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// The optical-depth volume would not fit.
    #[error(
        "sun path: a volume with voxels of {found_m} m needs more than 2^26 nodes, expected voxels of at \
         least {smallest_m:.3} m"
    )]
    SunVolumeTooLarge {
        /// Voxels asked for, in metres.
        found_m: f64,
        /// Smallest voxels that fit, in metres.
        smallest_m: f64,
    },
    /// The irradiance does not fit the wavelengths, or is not a number.
    #[error(
        "found {found} values of sun irradiance, expected {expected} that are finite and not \
         negative"
    )]
    SunIrradiance {
        /// Number of values found.
        found: usize,
        /// Number of wavelengths of the picture.
        expected: usize,
    },
    /// An input was made for other wavelengths.
    #[error("the {input} has wavelengths {found}, expected those of the picture, {expected}")]
    Wavelengths {
        /// Which input.
        input: Input,
        /// Its wavelengths.
        found: Wavelengths,
        /// The picture's.
        expected: Wavelengths,
    },
    /// An effect is on whose input is missing.
    #[error("{effect} is on, but there is no {input}")]
    MissingInput {
        /// The effect.
        effect: &'static str,
        /// What it needs.
        input: Input,
    },
    /// Rays see the drops at scattering angles that the table does not hold.
    #[error(
        "the scattering table covers scattering angles {found_deg:?} degrees, expected at least \
         {expected_deg:?}"
    )]
    AngleRange {
        /// First and last angle of the table in degrees.
        found_deg: (f64, f64),
        /// What the picture needs, in degrees.
        expected_deg: (f64, f64),
    },
    /// Drops are smaller or larger than the table's.
    #[error(
        "the scattering table covers effective radii {found_um:?} um, expected at least \
         {expected_um:?} um"
    )]
    SizeRange {
        /// First and last effective radius of the table in um.
        found_um: (f64, f64),
        /// Those of the drops in um.
        expected_um: (f64, f64),
    },
    /// A distance that no surface has.
    #[error(
        "found a surface at {found_m} m in pixel ({x}, {y}), expected a distance of at least 0"
    )]
    SurfaceDistance {
        /// Column, from 0 at the left.
        x: usize,
        /// Row, from 0 at the top.
        y: usize,
        /// The distance found, in metres.
        found_m: f32,
    },
    /// A map of surfaces that shows nothing, not even the sky.
    #[error("found no distance in the map of surfaces: it is empty or NaN everywhere")]
    NoSurfaces,
    /// A map of surfaces that is not one of this picture.
    #[error(
        "found surfaces of {} x {} pixels, expected the shape of the picture, {} x {}", found.0,
        found.1, expected.0, expected.1
    )]
    SurfaceShape {
        /// Width and height of the map.
        found: (usize, usize),
        /// Width and height of the picture.
        expected: (u32, u32),
    },
    /// A table that cannot be interpolated.
    #[error("the {input} cannot be used: {reason}")]
    BadTable {
        /// Which table.
        input: Input,
        /// What is wrong.
        reason: &'static str,
    },
}

impl Error {
    /// Which of the tables is at fault; `None` if it is anything else.
    #[must_use]
    pub fn input(&self) -> Option<Input> {
        match self {
            Self::Wavelengths { input, .. }
            | Self::MissingInput { input, .. }
            | Self::BadTable { input, .. } => Some(*input),
            Self::AngleRange { .. } | Self::SizeRange { .. } => Some(Input::ScatteringTable),
            Self::Region(_)
            | Self::Memory { .. }
            | Self::SunDirection { .. }
            | Self::ShadowOfAnotherSun { .. }
            | Self::NoShadow
            | Self::OrdersWithout { .. }
            | Self::Level { .. }
            | Self::SunVolumeTooLarge { .. }
            | Self::SunIrradiance { .. }
            | Self::SurfaceDistance { .. }
            | Self::NoSurfaces
            | Self::SurfaceShape { .. }
            | Self::Stopped => None,
        }
    }
}

/// What a picture is made from beside its drops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// How drops scatter.
    ScatteringTable,
    /// The air.
    AtmosphereTable,
    /// Light that the air scatters more than once, a part of its table.
    DiffuseLight,
}

impl std::fmt::Display for Input {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::ScatteringTable => "scattering table",
            Self::AtmosphereTable => "atmosphere table",
            Self::DiffuseLight => "diffuse light in the atmosphere table",
        })
    }
}

/// A wavelength grid as an error shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wavelengths(pub WavelengthGrid);

impl std::fmt::Display for Wavelengths {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let grid = self.0;
        write!(
            formatter,
            "{} x {} nm from {} nm",
            grid.len(),
            grid.step_nm(),
            grid.first_nm()
        )
    }
}
