//! Light of single drops that moves along the scattering angle where air has flattened them.
//!
//! t(θ) = t_still(θ) + Σ_p t_p(θ − Δθ_p)
//! `t` the scattering table, `t_p` the light of order p in it, linear between angles of its own, which are
//! fewer: alone an order has no ripple; `t_still` all other light of the table, `Δθ_p` the shift of [`BowShift`]
//! for an order and a wavelength. Drops tilt and tremble: what moves is as wide as [`FallingDrops`] of a radius
//! say.

use ndarray::Array4;
use ndarray::s;
use niji_radiometry::Nanometers;
use niji_radiometry::WavelengthGrid;

use crate::attributes::AttributeValue;
use crate::bow_shift::BowShift;
use crate::error::Error;
use crate::falling_drops::FallingDrops;
use crate::table::Axis;
use crate::table::TablePart;
use crate::wavelength_names::short_name;

/// Names of parts begin with it.
const PREFIX: &str = "moved.";
/// Attributes that list a number from 0 to 1 for each radius.
const OF_DROPS: [(&str, OfDrops); 4] = [
    ("niji:eccentricity", |drops| drops.eccentricity),
    ("niji:eccentricitySd", |drops| drops.eccentricity_sd),
    ("niji:meanSquaredSineOfTilt", |drops| drops.mean_sin2),
    ("niji:meanFourthPowerOfSineOfTilt", |drops| drops.mean_sin4),
];

/// A number of drops.
type OfDrops = fn(&FallingDrops) -> f64;

/// Orders of a table of single sizes that flattening moves: of its largest drops, for those of smaller ones
/// stay.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedBows {
    /// How drops lie, by radius of those that move, which are the last of the table.
    pub drops: Vec<FallingDrops>,
    /// The orders, ascending.
    pub orders: Vec<MovedOrder>,
}

/// An order that moves.
#[derive(Clone, Debug, PartialEq)]
pub struct MovedOrder {
    /// Number p of the order.
    pub order: u32,
    /// How it moves, by wavelength.
    pub shifts: Vec<BowShift>,
    /// Scattering angles, ascending, from the table's first to its last, in radians.
    pub theta_rad: Vec<f64>,
    /// Its part of the table's values, by polarization, radius of those that move, wavelength and its own
    /// angles, 1/sr.
    pub values: Array4<f32>,
}

impl MovedBows {
    /// The parts of the file.
    ///
    /// # Panics
    /// If drops are more than radii; if shifts or values are not as many as the drops, wavelengths and angles
    /// of an order.
    pub(crate) fn parts(&self, main: &TablePart, wavelengths: &WavelengthGrid) -> Vec<TablePart> {
        let n_moved = self.drops.len();
        let radii = last(&main.row_axes[0], n_moved);
        let part = |order: &MovedOrder| {
            assert_eq!(
                order.values.dim(),
                (2, n_moved, wavelengths.len(), order.theta_rad.len()),
                "moved values have the shape of the axes"
            );
            assert_eq!(
                order.shifts.len(),
                wavelengths.len(),
                "shifts are known for each wavelength"
            );
            let mut attributes = main.attributes.clone();
            attributes.extend(self.attributes(order, wavelengths));
            TablePart {
                name: format!("{PREFIX}{}", order.order),
                column_axis: Axis {
                    values: order.theta_rad.clone(),
                    ..main.column_axis.clone()
                },
                row_axes: vec![radii.clone()],
                channels: crate::scattering_table::channels(wavelengths, |polarization, index| {
                    let values = order.values.slice(s![polarization, .., index, ..]);
                    values.to_owned()
                }),
                attributes,
            }
        };
        self.orders.iter().map(part).collect()
    }

    fn attributes(
        &self,
        order: &MovedOrder,
        wavelengths: &WavelengthGrid,
    ) -> Vec<(String, AttributeValue)> {
        let shifts = wavelengths.centers().zip(&order.shifts);
        let shifts = shifts
            .map(|(wavelength, shift)| (shift_name(wavelength), list(&shift.coefficients_rad)));
        let of_drops = OF_DROPS.map(|(name, value)| {
            let values: Vec<f64> = self.drops.iter().map(value).collect();
            (name.to_owned(), list(&values))
        });
        shifts.chain(of_drops).collect()
    }

    /// Takes the orders of a table with these radii and ends of angles out of the parts of a file; `None` if there
    /// are none.
    ///
    /// # Errors
    /// Parts with other axes or other drops, without a channel or attribute, or whose orders do not
    /// ascend; a table of sizes that are not single.
    pub(crate) fn take(
        parts: Vec<TablePart>,
        main: &TablePart,
        wavelengths: &WavelengthGrid,
    ) -> Result<Option<Self>, Error> {
        let mut found: Option<Self> = None;
        for mut part in parts {
            if !part.name.starts_with(PREFIX) {
                continue;
            }
            let order = order_number(&part)?;
            check_axes(&part, main)?;
            let drops = drops(&part)?;
            let order = MovedOrder {
                order,
                shifts: shifts(&part, wavelengths)?,
                theta_rad: part.column_axis.values.clone(),
                values: crate::scattering_table::take_values(&mut part, wavelengths)?,
            };
            match &mut found {
                Some(bows) => bows.push((drops, order))?,
                None => {
                    found = Some(Self {
                        drops,
                        orders: vec![order],
                    });
                }
            }
        }
        Ok(found)
    }

    /// Adds an order, whose drops must be those of the others.
    fn push(&mut self, (drops, order): (Vec<FallingDrops>, MovedOrder)) -> Result<(), Error> {
        let before = self.orders.last().map_or(0, |last| last.order);
        if order.order <= before {
            return Err(not_ascending(&format!("{} after {before}", order.order)));
        }
        let differs = |value: OfDrops| self.drops.iter().map(value).ne(drops.iter().map(value));
        if let Some((name, _)) = OF_DROPS.into_iter().find(|(_, value)| differs(*value)) {
            let both = format!("{name} of {PREFIX}{before} in {PREFIX}{}", order.order);
            return Err(Error::missing("attribute", &both));
        }
        self.orders.push(order);
        Ok(())
    }
}

/// The number in the name of a part, as it is written.
fn order_number(part: &TablePart) -> Result<u32, Error> {
    let number = part
        .name
        .strip_prefix(PREFIX)
        .and_then(|number| number.parse().ok());
    let number = number.filter(|order: &u32| part.name == format!("{PREFIX}{order}"));
    number.ok_or_else(|| not_ascending(&format!("part {:?}", part.name)))
}

fn not_ascending(found: &str) -> Error {
    Error::Axis {
        name: "order".to_owned(),
        problem: format!("found {found}"),
    }
}

/// Refuses axes that are not those of the main part, of which the last may have no values but 0; angles need but
/// have the same ends.
fn check_axes(part: &TablePart, main: &TablePart) -> Result<(), Error> {
    let [radii, variances] = [0, 1].map(|index| &main.row_axes[index]);
    // Stored numbers, so equal bits are meant.
    if let Some(&found) = variances.values.iter().find(|variance| **variance != 0.0) {
        return Err(Error::Range {
            axis: variances.name.clone(),
            found,
            min: 0.0,
            max: 0.0,
        });
    }
    let n_moved = part.row_axes.first().map_or(0, |axis| axis.values.len());
    let radii = last(radii, n_moved.clamp(1, radii.values.len()));
    let ends = |axis: &Axis| Axis {
        values: [axis.values.first(), axis.values.last()]
            .into_iter()
            .flatten()
            .copied()
            .collect(),
        ..axis.clone()
    };
    let expected = [ends(&main.column_axis), radii];
    let of_angles = ends(&part.column_axis);
    let axes: Vec<&Axis> = [&of_angles].into_iter().chain(&part.row_axes).collect();
    if axes.len() != expected.len() {
        return Err(Error::Shape {
            what: format!("axes in part {:?}", part.name),
            found: axes.len(),
            expected: expected.len(),
        });
    }
    match expected
        .iter()
        .zip(axes)
        .find(|(expected, axis)| expected != axis)
    {
        None => Ok(()),
        Some((axis, _)) => {
            let both = format!("{} of {} in {}", axis.name, main.name, part.name);
            Err(Error::missing("axis", &both))
        }
    }
}

/// The last values of an axis.
fn last(axis: &Axis, n: usize) -> Axis {
    let mut axis = axis.clone();
    axis.values.drain(..axis.values.len() - n);
    axis
}

fn shifts(part: &TablePart, wavelengths: &WavelengthGrid) -> Result<Vec<BowShift>, Error> {
    let shift = |wavelength| {
        let coefficients_rad = numbers(part, &shift_name(wavelength), 5)?;
        let coefficients_rad = std::array::from_fn(|index| coefficients_rad[index]);
        Ok(BowShift { coefficients_rad })
    };
    wavelengths.centers().map(shift).collect()
}

/// The drops of a part, by radius.
fn drops(part: &TablePart) -> Result<Vec<FallingDrops>, Error> {
    let n_radii = part.row_axes[0].values.len();
    let mut lists = Vec::with_capacity(OF_DROPS.len());
    for (name, _) in OF_DROPS {
        let list = numbers(part, name, n_radii)?;
        if let Some(&found) = list.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            return Err(Error::Range {
                axis: name.to_owned(),
                found,
                min: 0.0,
                max: 1.0,
            });
        }
        lists.push(list);
    }
    let of_radius = |row: usize| FallingDrops {
        eccentricity: lists[0][row],
        eccentricity_sd: lists[1][row],
        mean_sin2: lists[2][row],
        mean_sin4: lists[3][row],
    };
    Ok((0..n_radii).map(of_radius).collect())
}

fn shift_name(wavelength: Nanometers) -> String {
    format!("niji:bowShiftRad.{}", short_name(wavelength))
}

/// Numbers as text, each with all of its digits.
fn list(values: &[f64]) -> AttributeValue {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:e}")).collect();
    AttributeValue::Text(texts.join(" "))
}

/// The numbers of a list that must be `n` long.
fn numbers(part: &TablePart, name: &str, n: usize) -> Result<Vec<f64>, Error> {
    let numbers = part.text(name)?.split(' ').map(str::parse::<f64>);
    let numbers = numbers.map(|number| number.ok().filter(|value| value.is_finite()));
    let numbers: Option<Vec<f64>> = numbers.collect();
    let numbers = numbers.ok_or_else(|| Error::Attribute {
        part: part.name.clone(),
        name: name.to_owned(),
        kind: "numeric",
    })?;
    if numbers.len() == n {
        return Ok(numbers);
    }
    Err(Error::Shape {
        what: format!("numbers in attribute {name:?} of part {:?}", part.name),
        found: numbers.len(),
        expected: n,
    })
}
