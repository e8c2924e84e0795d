//! How drops scatter, ready for a renderer.
//!
//! t = (dσ/dΩ) / (π⟨r²⟩)   [1/sr]
//! so that a volume element whose drops have the area moment M2 = N⟨r²⟩ scatters π M2 t of the
//! irradiance it receives. `θ` is the scattering angle, 0 forward; s and p are the components
//! perpendicular and parallel to the scattering plane, natural light takes half of their sum. The
//! table is never renormalised: its integral over the sphere is what the theory says, less the part
//! of the forward lobe that is left out.

use std::f64::consts::PI;

use ndarray::Array2;
use ndarray::Array4;
use ndarray::Array5;
use ndarray::s;
use niji_radiometry::Water;
use niji_radiometry::WavelengthGrid;

use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::interpolation_error::InterpolationError;
use crate::moved_bows::MovedBows;
use crate::provenance::Provenance;
use crate::table::Axis;
use crate::table::Channel;
use crate::table::TableFile;
use crate::table::TablePart;
use crate::wavelength_names;
use crate::wavelength_names::parse_wavelength;
use crate::wavelength_names::short_name;

/// What the file says it holds.
const QUANTITY: &str = "scattering";
/// The part of the phase functions.
const PHASE_FUNCTIONS: &str = "phase_functions";
/// Prefixes of the channels of the two polarisations.
const POLARIZATIONS: [&str; 2] = ["s", "p"];
/// Columns and rows with their units.
const AXES: [(&str, &str); 3] = [
    ("theta", "rad"),
    ("effective_radius", "um"),
    ("effective_variance", "-"),
];
/// Said in every header, because this is where people err.
const ANGLE_CONVENTION: &str = "scattering angle between the directions of travel before and after: \
                                0 = forward, pi = backward; bow angle = pi - theta";
/// The water: its temperature, and its salt where there is any.
const TEMPERATURE: &str = "niji:waterTemperatureC";
const SALINITY: &str = "niji:waterSalinityPerMille";
/// pi, give or take the rounding of 180 degrees.
const MAX_THETA_RAD: f64 = PI + 1e-12;
/// Gamma distributions of the area exist below this.
const MAX_EFFECTIVE_VARIANCE: f64 = 0.5;
/// Said in every header.
const NORM: &str = "(dsigma/dOmega) / (pi <r^2>) in 1/sr for each polarization; natural light = \
                    (s + p) / 2; p11 (mean over the sphere 1) = 4 pi (s + p) / 2 / Q_sca; never \
                    renormalised";

/// What the rows of a table are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowUse {
    /// Each is a law of its effective radius and variance.
    Laws,
    /// Each is a single size, and any law is a sum over them.
    Sums,
}

impl RowUse {
    /// As the header says it.
    fn name(self) -> &'static str {
        match self {
            Self::Laws => "laws",
            Self::Sums => "sums",
        }
    }
}

/// A scattering table.
#[derive(Clone, Debug, PartialEq)]
pub struct ScatteringTable {
    /// Theory that made it.
    pub theory: String,
    /// Debye orders in it, `2,3` say, or `all`.
    pub orders: String,
    /// Wavelength bins.
    pub wavelengths: WavelengthGrid,
    /// Scattering angles, ascending, in radians.
    pub theta_rad: Vec<f64>,
    /// Effective radii, ascending, in micrometres.
    pub effective_radius_um: Vec<f64>,
    /// Effective variances, ascending.
    pub effective_variance: Vec<f64>,
    /// What the rows are for.
    pub row_use: RowUse,
    /// Values in 1/sr by polarisation (0 = s, 1 = p), effective radius, effective variance,
    /// wavelength and scattering angle.
    pub values: Array5<f32>,
    /// What of the values moves where drops are flattened; `None` for spheres. Rows are of single sizes
    /// then: the only effective variance is 0.
    pub moved: Option<MovedBows>,
    /// A coarser table of the same drops and wavelengths at all angles and by every way through a drop: what
    /// light that is scattered more than once goes by. `None` where that is not asked for, or where this table
    /// itself is such a one.
    pub phase_functions: Option<Box<ScatteringTable>>,
    /// Error of interpolation that it was made for, in parts of the peak of the bow.
    pub relative_error: f64,
    /// Diameter of the sun's disc that the table is averaged over, in radians; 0 for a point.
    pub sun_disc_diameter_rad: f64,
    /// Scattering angle between the secondary bow (smaller) and the primary (larger), in radians.
    pub split_theta_rad: f64,
    /// Part of the scattered light that lies in the forward lobe left out, from 0 to 1.
    pub forward_fraction_left_out: f64,
    /// What the drops are made of.
    pub water: Water,
    /// What linear interpolation along each axis costs, if that was measured.
    pub interpolation_error: Option<InterpolationError>,
}

impl ScatteringTable {
    /// The table as a file: width = θ, height = effective radius × effective variance, channels
    /// `s.550nm` and `p.550nm`.
    ///
    /// # Panics
    /// If the shape of the values is not that of the axes.
    #[must_use]
    pub fn to_file(&self, provenance: Provenance) -> TableFile {
        let phase_functions = self.phase_functions.iter();
        let phase_functions = phase_functions.flat_map(|table| table.parts(PHASE_FUNCTIONS));
        TableFile {
            quantity: QUANTITY.to_owned(),
            parts: self.parts(QUANTITY).chain(phase_functions).collect(),
            provenance,
        }
    }

    /// The table without its phase functions as parts, of which the first has a name.
    fn parts(&self, name: &str) -> impl Iterator<Item = TablePart> {
        let shape = self.shape();
        assert_eq!(
            self.values.dim(),
            shape,
            "values have the shape of the axes"
        );
        let (_, n_radii, n_variances, _, n_theta) = shape;
        let channels = channels(&self.wavelengths, |polarization, index| {
            let values = self.values.slice(s![polarization, .., .., index, ..]);
            let flat: Vec<f32> = values.iter().copied().collect();
            Array2::from_shape_vec((n_radii * n_variances, n_theta), flat)
                .expect("rows are the product of their axes")
        });
        let part = TablePart {
            name: name.to_owned(),
            column_axis: axis(0, &self.theta_rad),
            row_axes: vec![
                axis(1, &self.effective_radius_um),
                axis(2, &self.effective_variance),
            ],
            channels,
            attributes: self.attributes(),
        };
        let moved = self
            .moved
            .iter()
            .flat_map(|moved| moved.parts(&part, &self.wavelengths));
        let moved: Vec<TablePart> = moved.collect();
        [part].into_iter().chain(moved)
    }

    fn shape(&self) -> (usize, usize, usize, usize, usize) {
        (
            2,
            self.effective_radius_um.len(),
            self.effective_variance.len(),
            self.wavelengths.len(),
            self.theta_rad.len(),
        )
    }

    fn attributes(&self) -> Attributes {
        let text = |text: &str| AttributeValue::Text(text.to_owned());
        let number = AttributeValue::Number;
        [
            ("niji:theory", text(&self.theory)),
            ("niji:orders", text(&self.orders)),
            ("niji:angleConvention", text(ANGLE_CONVENTION)),
            ("niji:norm", text(NORM)),
            (
                "niji:sunDiscDiameterRad",
                number(self.sun_disc_diameter_rad),
            ),
            ("niji:splitThetaRad", number(self.split_theta_rad)),
            (
                "niji:forwardFractionLeftOut",
                number(self.forward_fraction_left_out),
            ),
            ("niji:relativeError", number(self.relative_error)),
            ("niji:rowUse", text(self.row_use.name())),
            (TEMPERATURE, number(self.water.temperature_c)),
        ]
        .into_iter()
        .chain(self.salinity())
        .map(|(name, value)| (name.to_owned(), value))
        .chain(wavelength_names::describe(&self.wavelengths))
        .chain(
            self.interpolation_error
                .iter()
                .flat_map(InterpolationError::attributes),
        )
        .collect()
    }

    /// Said where there is salt; a table that says nothing is of pure water.
    fn salinity(&self) -> Option<(&'static str, AttributeValue)> {
        let salinity = self.water.salinity_per_mille;
        (salinity > 0.0).then_some((SALINITY, AttributeValue::Number(salinity)))
    }

    /// Reads the table from a file.
    ///
    /// # Errors
    /// A table of another quantity, a missing axis, channel or attribute, sizes or wavelengths that
    /// disagree, or values that are negative or not finite.
    pub fn from_file(file: TableFile) -> Result<Self, Error> {
        file.expect_quantity(QUANTITY)?;
        let (part, mut others) = file.into_part(QUANTITY)?;
        let phase_functions = others.iter().position(|it| it.name == PHASE_FUNCTIONS);
        let phase_functions = phase_functions.map(|place| others.remove(place));
        let mut table = Self::from_parts(part, others)?;
        if let Some(part) = phase_functions {
            let phase_functions = Self::from_parts(part, Vec::new())?;
            if phase_functions.wavelengths != table.wavelengths {
                let both = format!("wavelengths of {QUANTITY} in {PHASE_FUNCTIONS}");
                return Err(Error::missing("axis", &both));
            }
            table.phase_functions = Some(Box::new(phase_functions));
        }
        Ok(table)
    }

    /// A table of a part, beside those of bows that move.
    fn from_parts(mut part: TablePart, others: Vec<TablePart>) -> Result<Self, Error> {
        part.expect_axes(&AXES)?;
        let [radii, variances] = [0, 1].map(|index| part.row_axes[index].values.clone());
        check_range(&part.column_axis, (0.0, MAX_THETA_RAD))?;
        check_range(&part.row_axes[0], (0.0, f64::INFINITY))?;
        check_range(&part.row_axes[1], (0.0, MAX_EFFECTIVE_VARIANCE))?;
        let wavelengths = wavelengths(&part)?;
        let moved = MovedBows::take(others, &part, &wavelengths)?;
        let values = take_values(&mut part, &wavelengths)?;
        let (_, _, n_wavelengths, n_theta) = values.dim();
        let shape = (2, radii.len(), variances.len(), n_wavelengths, n_theta);
        let n_rows = values.dim().1;
        let values = values.into_shape_with_order(shape);
        let values = values.map_err(|_| Error::Shape {
            what: format!("rows of {}", part.name),
            found: n_rows,
            expected: radii.len() * variances.len(),
        })?;
        Ok(Self {
            theory: part.text("niji:theory")?.to_owned(),
            orders: part.text("niji:orders")?.to_owned(),
            wavelengths,
            theta_rad: part.column_axis.values.clone(),
            effective_radius_um: radii,
            effective_variance: variances,
            values,
            moved,
            phase_functions: None,
            row_use: row_use(&part)?,
            relative_error: part.number("niji:relativeError")?,
            sun_disc_diameter_rad: part.number("niji:sunDiscDiameterRad")?,
            split_theta_rad: part.number("niji:splitThetaRad")?,
            forward_fraction_left_out: part.number("niji:forwardFractionLeftOut")?,
            water: water(&part)?,
            interpolation_error: InterpolationError::read(&part)?,
        })
    }
}

fn row_use(part: &TablePart) -> Result<RowUse, Error> {
    let name = part.text("niji:rowUse")?;
    let known = [RowUse::Laws, RowUse::Sums]
        .into_iter()
        .find(|row_use| row_use.name() == name);
    known.ok_or_else(|| Error::missing("attribute", "niji:rowUse of laws or sums"))
}

/// Channels of both polarizations by wavelength, from rows by polarization and wavelength.
pub(crate) fn channels(
    wavelengths: &WavelengthGrid,
    rows: impl Fn(usize, usize) -> Array2<f32>,
) -> Vec<Channel> {
    let mut channels = Vec::with_capacity(2 * wavelengths.len());
    for (polarization, prefix) in POLARIZATIONS.into_iter().enumerate() {
        for (index, wavelength) in wavelengths.centers().enumerate() {
            let name = format!("{prefix}.{}", short_name(wavelength));
            let values = rows(polarization, index);
            channels.push(Channel { name, values });
        }
    }
    channels
}

/// Takes the values of all channels out of a part, by polarization, row, wavelength and angle.
pub(crate) fn take_values(
    part: &mut TablePart,
    wavelengths: &WavelengthGrid,
) -> Result<Array4<f32>, Error> {
    let n_rows: usize = part.row_axes.iter().map(|axis| axis.values.len()).product();
    let n_theta = part.column_axis.values.len();
    let mut values = Array4::zeros((2, n_rows, wavelengths.len(), n_theta));
    for (polarization, prefix) in POLARIZATIONS.into_iter().enumerate() {
        for (index, wavelength) in wavelengths.centers().enumerate() {
            let name = format!("{prefix}.{}", short_name(wavelength));
            // Given back once it is copied: a large table would stand in memory twice.
            let channel = part.take(&name)?;
            check_values(&part.name, &name, &channel)?;
            values
                .slice_mut(s![polarization, .., index, ..])
                .assign(&channel);
        }
    }
    Ok(values)
}

fn axis(index: usize, values: &[f64]) -> Axis {
    let (name, unit) = AXES[index];
    Axis::new(name, unit, values.to_vec())
}

fn water(part: &TablePart) -> Result<Water, Error> {
    let pure = Water::pure(part.number(TEMPERATURE)?);
    if !part.attributes.contains_key(SALINITY) {
        return Ok(pure);
    }
    Ok(Water {
        salinity_per_mille: part.number(SALINITY)?,
        ..pure
    })
}

fn wavelengths(part: &TablePart) -> Result<WavelengthGrid, Error> {
    let names = part
        .channels
        .iter()
        .filter_map(|channel| channel.name.strip_prefix("s."));
    let wavelengths_nm = names
        .filter_map(parse_wavelength)
        .map(|wavelength| wavelength.0);
    wavelength_names::described_grid(wavelengths_nm.collect(), &part.attributes)
}

/// Ascending values are within a range if the first and the last are.
fn check_range(axis: &Axis, (min, max): (f64, f64)) -> Result<(), Error> {
    let outside = [axis.values.first(), axis.values.last()]
        .into_iter()
        .flatten();
    match outside.copied().find(|value| !(min..=max).contains(value)) {
        None => Ok(()),
        Some(value) => Err(Error::Range {
            axis: axis.name.clone(),
            found: value,
            min,
            max,
        }),
    }
}

fn check_values(part: &str, name: &str, values: &Array2<f32>) -> Result<(), Error> {
    let bad = values
        .indexed_iter()
        .find(|(_, value)| !(value.is_finite() && **value >= 0.0));
    let Some(((y, x), &value)) = bad else {
        return Ok(());
    };
    let (part, channel) = (part.to_owned(), name.to_owned());
    if value.is_finite() {
        Err(Error::Negative {
            part,
            channel,
            x,
            y,
            value,
        })
    } else {
        Err(Error::NotFinite {
            part,
            channel,
            x,
            y,
            value,
        })
    }
}
