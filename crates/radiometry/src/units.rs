//! Lengths and angles that cannot be mistaken for each other.
//!
//! 1 m = 1e6 um = 1e9 nm, pi rad = 180 deg.
//! Conversions multiply or divide by an exact power of ten, so they round once.
//! Public functions of the workspace take these types and unwrap them with `.0` on their first
//! lines.

/// A length in metres.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Meters(pub f64);

/// A length in micrometres, the unit of drop radii.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Micrometers(pub f64);

/// A length in nanometres, the unit of wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Nanometers(pub f64);

/// An angle in radians.
///
/// ```
/// use niji_radiometry::{Meters, Micrometers, Radians};
///
/// assert_eq!(Radians::from_degrees(180.0).0, std::f64::consts::PI);
/// assert_eq!(Meters::from(Micrometers(500.0)).0, 500.0 * 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Radians(pub f64);

impl Radians {
    /// An angle given in degrees.
    pub fn from_degrees(angle_deg: f64) -> Self {
        Self(angle_deg.to_radians())
    }

    /// The angle in degrees, for the command line and for scene files.
    pub fn to_degrees(self) -> f64 {
        self.0.to_degrees()
    }
}

impl From<Micrometers> for Meters {
    fn from(length: Micrometers) -> Self {
        Self(length.0 / 1e6)
    }
}

impl From<Nanometers> for Meters {
    fn from(length: Nanometers) -> Self {
        Self(length.0 / 1e9)
    }
}

impl From<Meters> for Micrometers {
    fn from(length: Meters) -> Self {
        Self(length.0 * 1e6)
    }
}

impl From<Nanometers> for Micrometers {
    fn from(length: Nanometers) -> Self {
        Self(length.0 / 1e3)
    }
}

impl From<Meters> for Nanometers {
    fn from(length: Meters) -> Self {
        Self(length.0 * 1e9)
    }
}

impl From<Micrometers> for Nanometers {
    fn from(length: Micrometers) -> Self {
        Self(length.0 * 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wavelength_is_the_same_length_in_every_unit() {
        assert_eq!(Micrometers::from(Nanometers(550.0)), Micrometers(0.55));
        assert_eq!(Meters::from(Nanometers(550.0)), Meters(550e-9));
        assert_eq!(Meters::from(Micrometers(100.0)), Meters(1e-4));
        assert_eq!(Micrometers::from(Meters(1e-3)), Micrometers(1000.0));
        assert_eq!(Nanometers::from(Meters(1.0)), Nanometers(1e9));
        assert_eq!(Nanometers::from(Micrometers(0.5)), Nanometers(500.0));
    }

    #[test]
    fn degrees_survive_a_round_trip() {
        for angle_deg in [-180.0, -0.266, 0.0, 42.1, 137.9, 180.0] {
            let back = Radians::from_degrees(angle_deg).to_degrees();
            assert!(
                (back - angle_deg).abs() <= 1e-13,
                "{angle_deg} came back as {back}"
            );
        }
    }
}
