//! Absorption coefficients of the gases of the air by wavelength, 300 to 1000 nm.
//!
//! Ozone in 1/(atm cm), water vapor in 1/cm of precipitable water, the mixed gases (here: oxygen) in
//! units of the model. Broken lines through the 122 wavelengths of SPCTRAL2, averaged over bins.
//! [BR86] Bird and Riordan, J. Climate Appl. Meteorol. 25, 87-97 (1986), table 1.

use std::sync::LazyLock;

use niji_radiometry::Nanometers;
use niji_radiometry::TabulatedSpectrum;

const TABLE: &str = include_str!("../../../data/gas_absorption_spctral2.csv");

static OZONE: LazyLock<TabulatedSpectrum> = LazyLock::new(|| column("ozone"));
static WATER_VAPOR: LazyLock<TabulatedSpectrum> = LazyLock::new(|| column("water_vapour"));
static OXYGEN: LazyLock<TabulatedSpectrum> = LazyLock::new(|| column("mixed_gas"));

fn column(name: &str) -> TabulatedSpectrum {
    TabulatedSpectrum::from_csv(TABLE, name)
        .expect("the embedded table is part of this program and parsed by the tests below")
}

/// A gas of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Gas {
    Ozone,
    WaterVapor,
    Oxygen,
}

/// Mean coefficient of a gas between two wavelengths.
pub(crate) fn absorption(gas: Gas, (lo, hi): (Nanometers, Nanometers)) -> f64 {
    let spectrum = match gas {
        Gas::Ozone => &OZONE,
        Gas::WaterVapor => &WATER_VAPOR,
        Gas::Oxygen => &OXYGEN,
    };
    spectrum.bin_mean(lo, hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coefficients_of_the_bands_stand_at_their_wavelengths() {
        // SPCTRAL2 (BR86), as pvlib has them.
        for (gas, nm, printed) in [
            (Gas::Ozone, 593.0, 0.119),
            (Gas::WaterVapor, 593.0, 0.075),
            (Gas::WaterVapor, 724.4, 2.5),
            (Gas::Oxygen, 690.0, 0.15),
            (Gas::Oxygen, 762.5, 4.0),
        ] {
            let found = absorption(gas, (Nanometers(nm), Nanometers(nm)));
            assert!((found - printed).abs() < 1e-12, "{gas:?} {nm}: {found}");
        }
    }
}
