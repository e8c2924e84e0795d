//! Lines of numbers, and lists of them as users type them.

use crate::failure::Failure;
use crate::flags::numbers;

/// The wavelengths of a list as the user gave it, nm.
pub(super) fn wavelengths_nm(list: &str) -> Result<Vec<f64>, Failure> {
    let wavelengths_nm = numbers(list).map_err(Failure::Usage)?;
    let is_outside = |nm: &&f64| !(300.0..=1000.0).contains(*nm);
    if let Some(nm) = wavelengths_nm.iter().find(is_outside) {
        return Err(Failure::Usage(format!(
            "found {nm} nm, expected 300 to 1000 nm"
        )));
    }
    Ok(wavelengths_nm)
}

/// A line of CSV in full precision.
pub(super) fn line(values: &[f64]) -> String {
    // Display of f64 is the shortest decimal that reads back as the same number; tiny and huge ones
    // are clearer with an exponent.
    let fields: Vec<String> = values
        .iter()
        .map(|value| {
            let plain = *value == 0.0 || (1e-4..1e15).contains(&value.abs());
            if plain {
                format!("{value}")
            } else {
                format!("{value:e}")
            }
        })
        .collect();
    fields.join(",") + "\n"
}
