//! Wavelengths in channel names: `s.550nm`, with a decimal comma where the number is not whole,
//! because a point separates layers.

use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::error::Error;

/// Largest deviation of a wavelength from an equidistant grid, in nm.
const TOLERANCE_NM: f64 = 1e-4;

/// `550nm`, or `552,5nm`.
pub(crate) fn wavelength_name(wavelength: Nanometers) -> String {
    format!("{}nm", wavelength.0.to_string().replace('.', ","))
}

/// The number in `550nm`, `552,5nm` or `550,000000nm`.
pub(crate) fn parse_wavelength(name: &str) -> Option<Nanometers> {
    let number = name.strip_suffix("nm")?.replace(',', ".");
    number.parse().ok().map(Nanometers)
}

/// The equidistant grid behind a list of wavelengths in any order. One wavelength has bins of
/// `lone_step_nm`.
pub(crate) fn grid(mut wavelengths_nm: Vec<f64>, lone_step_nm: f64) -> Result<WavelengthGrid, Error> {
    wavelengths_nm.sort_by(f64::total_cmp);
    let Some(&first_nm) = wavelengths_nm.first() else {
        return Err(Error::Wavelengths("found none, expected at least one".to_owned()));
    };
    let n = wavelengths_nm.len();
    let last_nm = wavelengths_nm[n - 1];
    let step_nm = if n > 1 { (last_nm - first_nm) / (n - 1) as f64 } else { lone_step_nm };
    for (index, &found_nm) in wavelengths_nm.iter().enumerate() {
        let expected_nm = first_nm + step_nm * index as f64;
        if (found_nm - expected_nm).abs() > TOLERANCE_NM {
            let message = format!("found {found_nm} nm, expected {expected_nm} nm: equal steps");
            return Err(Error::Wavelengths(message));
        }
    }
    WavelengthGrid::new(first_nm, step_nm, n).map_err(|error| Error::Wavelengths(error.to_string()))
}
