//! Wavelengths in channel names, with a decimal comma because a point separates layers.
//!
//! Tables say `s.550nm` and `s.552,5nm`, spectral images `S0.550,000000nm`. Names are rounded to
//! 1e-6 nm; the exact first wavelength and step stand in attributes beside them.

use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::part::Part;

/// Name of the attribute that holds the first wavelength.
pub(crate) const FIRST: &str = "niji:wavelengthFirstNm";
/// Name of the attribute that holds the step between wavelengths.
pub(crate) const STEP: &str = "niji:wavelengthStepNm";
/// Name of the attribute that holds their number, where no channel has their names.
pub(crate) const COUNT: &str = "niji:wavelengthCount";
/// Largest deviation of a wavelength from an equidistant grid, in nm.
const TOLERANCE_NM: f64 = 1e-4;

/// `550nm`, or `552,5nm`.
pub(crate) fn short_name(wavelength: Nanometers) -> String {
    let digits = format!("{:.6}", wavelength.0);
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    format!("{}nm", digits.replace('.', ","))
}

/// `550,000000nm`, as the authors of the spectral layout write it.
pub(crate) fn long_name(wavelength: Nanometers) -> String {
    format!("{:.6}nm", wavelength.0).replace('.', ",")
}

/// The number in `550nm`, `552,5nm` or `550,000000nm`.
pub(crate) fn parse_wavelength(name: &str) -> Option<Nanometers> {
    let number = name.strip_suffix("nm")?.replace(',', ".");
    number
        .parse()
        .ok()
        .filter(|number: &f64| number.is_finite())
        .map(Nanometers)
}

/// The attributes that hold a grid exactly.
pub(crate) fn describe(wavelengths: &WavelengthGrid) -> [(String, AttributeValue); 2] {
    [
        (FIRST, wavelengths.first_nm()),
        (STEP, wavelengths.step_nm()),
    ]
    .map(|(name, number)| (name.to_owned(), AttributeValue::Number(number)))
}

/// The grid that the attributes of a part state, which has no channel with their names.
pub(crate) fn grid_of(part: &Part) -> Result<WavelengthGrid, Error> {
    let count = part.number(COUNT)?;
    // As many as a file can have channels at most; a fraction or NaN is refused with what it becomes.
    let n = count.clamp(0.0, f64::from(u16::MAX)) as usize;
    let grid = WavelengthGrid::new(part.number(FIRST)?, part.number(STEP)?, n);
    grid.map_err(|error| Error::Wavelengths(error.to_string()))
}

/// The grid behind the wavelengths in channel names: the one that the attributes state, if it fits,
/// or else an equidistant one. A single wavelength without attributes has a bin of 1 nm.
pub(crate) fn described_grid(
    wavelengths_nm: Vec<f64>,
    attributes: &Attributes,
) -> Result<WavelengthGrid, Error> {
    let number = |name| match attributes.get(name) {
        Some(AttributeValue::Number(number)) => Some(*number),
        Some(AttributeValue::Text(_)) | None => None,
    };
    let step_nm = number(STEP).unwrap_or(1.0);
    let found = grid(wavelengths_nm, step_nm)?;
    let Some(first_nm) = number(FIRST) else {
        return Ok(found);
    };
    if (first_nm - found.first_nm()).abs() > TOLERANCE_NM {
        let message = format!(
            "found {first_nm} nm in attribute {FIRST}, expected {} nm as in the channel names",
            found.first_nm()
        );
        return Err(Error::Wavelengths(message));
    }
    new_grid(first_nm, found.step_nm(), found.len())
}

/// The equidistant grid behind a list of wavelengths in any order, with the stated step if that fits
/// or if there is only one wavelength.
pub(crate) fn grid(
    mut wavelengths_nm: Vec<f64>,
    stated_step_nm: f64,
) -> Result<WavelengthGrid, Error> {
    wavelengths_nm.sort_by(f64::total_cmp);
    let (Some(&first_nm), Some(&last_nm)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Err(Error::Wavelengths(
            "found none, expected at least one".to_owned(),
        ));
    };
    let n_steps = (wavelengths_nm.len() - 1) as f64;
    let fits = (first_nm + n_steps * stated_step_nm - last_nm).abs() <= TOLERANCE_NM;
    let step_nm = if fits {
        stated_step_nm
    } else {
        (last_nm - first_nm) / n_steps
    };
    for (index, &found_nm) in wavelengths_nm.iter().enumerate() {
        let expected_nm = first_nm + step_nm * index as f64;
        if (found_nm - expected_nm).abs() > TOLERANCE_NM {
            let message = format!("found {found_nm} nm, expected {expected_nm} nm: equal steps");
            return Err(Error::Wavelengths(message));
        }
    }
    new_grid(first_nm, step_nm, wavelengths_nm.len())
}

/// Refuses NaN too, which passes every comparison above.
fn new_grid(first_nm: f64, step_nm: f64, n: usize) -> Result<WavelengthGrid, Error> {
    WavelengthGrid::new(first_nm, step_nm, n).map_err(|error| Error::Wavelengths(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_survive_a_round_trip_and_use_the_decimal_comma() {
        for (nm, short, long) in [
            (550.0, "550nm", "550,000000nm"),
            (552.5, "552,5nm", "552,500000nm"),
        ] {
            assert_eq!(short_name(Nanometers(nm)), short);
            assert_eq!(long_name(Nanometers(nm)), long);
            assert_eq!(parse_wavelength(short), Some(Nanometers(nm)));
            assert_eq!(parse_wavelength(long), Some(Nanometers(nm)));
        }
        // 380 + 3.3 in f64 is 383.3 only to 17 digits.
        assert_eq!(short_name(Nanometers(380.0 + 3.3)), "383,3nm");
        for bad in ["550", "nm", "infnm", "NaNnm", "5 50nm"] {
            assert_eq!(parse_wavelength(bad), None, "{bad}");
        }
    }

    #[test]
    fn a_grid_of_odd_numbers_comes_back_exactly() {
        let exact = WavelengthGrid::new(381.0 / 0.97, 10.0 / 3.0, 41).unwrap();
        let rounded = exact
            .centers()
            .map(|nm| parse_wavelength(&short_name(nm)).unwrap().0);
        let attributes = Attributes::from(describe(&exact));
        assert_eq!(
            described_grid(rounded.collect(), &attributes).unwrap(),
            exact
        );
    }

    #[test]
    fn unequal_steps_and_contradicting_attributes_are_refused() {
        assert!(matches!(
            grid(vec![400.0, 410.0, 425.0], 10.0),
            Err(Error::Wavelengths(_))
        ));
        assert!(matches!(grid(Vec::new(), 10.0), Err(Error::Wavelengths(_))));
        assert!(matches!(
            grid(vec![400.0, 400.0], 0.0),
            Err(Error::Wavelengths(_))
        ));
        let attributes = Attributes::from(describe(&WavelengthGrid::visible()));
        let found = described_grid(vec![400.0, 410.0], &attributes);
        assert!(matches!(found, Err(Error::Wavelengths(_))));
        // A foreign file states nothing.
        let found = described_grid(vec![600.0, 550.0], &Attributes::new()).unwrap();
        assert_eq!((found.first_nm(), found.step_nm()), (550.0, 50.0));
    }
}
