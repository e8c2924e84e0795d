//! The atmosphere table as EXR.
//!
//! * part `spectra`: columns = wavelength; channels `sun_irradiance`, `ground_albedo` and for every
//!   constituent `NAME.extinction`, `NAME.scattering`
//! * part `NAME.profile`: columns = height; channel `density`, attribute `niji:densityLaw`
//! * part `NAME.reach` (exponential profiles only): columns = mu, rows = height; channel `reach`
//! * part `NAME.phase`: columns = scattering angle, rows = wavelength; channel `phase`
//! * where light of higher orders was asked for, the parts of `diffuse_file`
//!
//! Values are f32: 6e-8 relative, and the reach keeps that at any height, where an optical depth to
//! the top would fall by five decades.

use ndarray::Array2;
use niji_radiometry::WavelengthGrid;

use super::AirConstituent;
use super::AtmosphereTable;
use super::DensityLaw;
use super::diffuse_file;
use crate::attributes::AttributeValue;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::provenance::Provenance;
use crate::table::Axis;
use crate::table::Channel;
use crate::table::TableFile;
use crate::table::TablePart;
use crate::wavelength_names;

/// What the file says it holds.
const QUANTITY: &str = "atmosphere";
/// Name of the part with the spectra.
const SPECTRA: &str = "spectra";
/// Said in every header with a reach.
const REACH_MEANING: &str = "integral of the relative density along a ray to the top of the air, \
                             over the density at its start, in m; optical depth = extinction * \
                             density * reach";

impl AtmosphereTable {
    /// The table as a file.
    pub fn to_file(&self, provenance: Provenance) -> TableFile {
        let mut parts = vec![self.spectra()];
        for air in &self.constituents {
            parts.push(profile_part(air));
            if air.law == DensityLaw::Exponential {
                parts.push(reach_part(air));
            }
            parts.push(phase_part(air, wavelength_axis(&self.wavelengths)));
        }
        if let Some(diffuse) = &self.diffuse {
            let wavelengths = wavelength_axis(&self.wavelengths);
            parts.extend(diffuse_file::parts(
                diffuse,
                &self.constituents,
                &wavelengths,
            ));
        }
        TableFile {
            quantity: QUANTITY.to_owned(),
            parts,
            provenance,
        }
    }

    fn spectra(&self) -> TablePart {
        let mut channels = vec![
            single_row("sun_irradiance", &self.sun_irradiance),
            single_row("ground_albedo", &self.ground_albedo),
        ];
        for air in &self.constituents {
            channels.push(single_row(
                &format!("{}.extinction", air.name),
                &air.extinction_m1,
            ));
            channels.push(single_row(
                &format!("{}.scattering", air.name),
                &air.scattering_m1,
            ));
        }
        let names: Vec<&str> = self
            .constituents
            .iter()
            .map(|air| air.name.as_str())
            .collect();
        let attributes = Attributes::from([
            number("niji:planetRadiusM", self.planet_radius_m),
            number("niji:topHeightM", self.top_height_m),
            number("niji:wavelengthStepNm", self.wavelengths.step_nm()),
            text("niji:constituents", &names.join(",")),
        ]);
        TablePart {
            name: SPECTRA.to_owned(),
            column_axis: wavelength_axis(&self.wavelengths),
            row_axes: Vec::new(),
            channels,
            attributes,
        }
    }

    /// Reads the table from a file.
    ///
    /// # Errors
    /// A table of another quantity, a missing part, channel or attribute, sizes or wavelengths that
    /// disagree, or values that no air can have.
    pub fn from_file(file: &TableFile) -> Result<Self, Error> {
        file.expect_quantity(QUANTITY)?;
        let spectra = file.part(SPECTRA)?;
        let wavelengths = wavelength_names::grid(
            spectra.column_axis.values.clone(),
            spectra.number("niji:wavelengthStepNm")?,
        )?;
        let names = spectra.text("niji:constituents")?.split(',');
        let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
        let table = Self {
            planet_radius_m: spectra.number("niji:planetRadiusM")?,
            top_height_m: spectra.number("niji:topHeightM")?,
            wavelengths,
            sun_irradiance: spectrum(spectra, "sun_irradiance")?,
            ground_albedo: spectrum(spectra, "ground_albedo")?,
            constituents: names
                .iter()
                .map(|name| constituent(file, name))
                .collect::<Result<_, _>>()?,
            diffuse: diffuse_file::read(file, &names, &spectra.column_axis)?,
        };
        table.check_planet()?;
        Ok(table)
    }

    fn check_planet(&self) -> Result<(), Error> {
        for (what, value) in [
            ("planet radius", self.planet_radius_m),
            ("top of the air", self.top_height_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(bad_axis(what, format!("found {value} m")));
            }
        }
        Ok(())
    }
}

fn constituent(file: &TableFile, name: &str) -> Result<AirConstituent, Error> {
    let spectra = file.part(SPECTRA)?;
    let profile = file.part(&format!("{name}.profile"))?;
    let phase = file.part(&format!("{name}.phase"))?;
    let density = row(profile, "density")?;
    let law = density_law(profile, &density)?;
    let reach = match law {
        DensityLaw::Exponential => Some(file.part(&format!("{name}.reach"))?),
        DensityLaw::Linear => None,
    };
    let phase_sr1 = grid_of_values(phase, "phase")?;
    let n_wavelengths = spectra.column_axis.values.len();
    if phase_sr1.nrows() != n_wavelengths {
        let what = format!("phase functions of {name:?}");
        return Err(Error::Shape {
            what,
            found: phase_sr1.nrows(),
            expected: n_wavelengths,
        });
    }
    let mut air = AirConstituent {
        name: name.to_owned(),
        extinction_m1: spectrum(spectra, &format!("{name}.extinction"))?,
        scattering_m1: spectrum(spectra, &format!("{name}.scattering"))?,
        law,
        height_m: profile.column_axis.values.clone(),
        density,
        reach_height_m: Vec::new(),
        reach_mu: Vec::new(),
        reach_m: Array2::zeros((0, 0)),
        phase_angle_rad: phase.column_axis.values.clone(),
        phase_sr1,
    };
    if let Some(part) = reach {
        air.reach_height_m
            .clone_from(&part.row_axis("height")?.values);
        air.reach_mu.clone_from(&part.column_axis.values);
        air.reach_m = reaches(part, air.reach_height_m.len())?;
    }
    Ok(air)
}

fn density_law(profile: &TablePart, density: &[f64]) -> Result<DensityLaw, Error> {
    match profile.text("niji:densityLaw")? {
        "linear" => Ok(DensityLaw::Linear),
        "exponential" => {
            let zero = density.iter().position(|&density| density <= 0.0);
            zero.map_or(Ok(DensityLaw::Exponential), |x| {
                Err(bad_value(profile, "density", x, 0.0))
            })
        }
        other => Err(Error::Quantity {
            found: format!("profile {other}"),
            expected: "profile linear or exponential",
        }),
    }
}

/// The reaches, which only the last row of `n_heights` may have at 0.
fn reaches(part: &TablePart, n_heights: usize) -> Result<Array2<f64>, Error> {
    let values = grid_of_values(part, "reach")?;
    for ((row, column), &reach) in values.indexed_iter() {
        if row + 1 < n_heights && reach <= 0.0 {
            return Err(bad_value(part, "reach", column, 0.0));
        }
    }
    Ok(values)
}

fn profile_part(air: &AirConstituent) -> TablePart {
    let law = match air.law {
        DensityLaw::Exponential => "exponential",
        DensityLaw::Linear => "linear",
    };
    TablePart {
        name: format!("{}.profile", air.name),
        column_axis: Axis::new("height", "m", air.height_m.clone()),
        row_axes: Vec::new(),
        channels: vec![single_row("density", &air.density)],
        attributes: Attributes::from([text("niji:densityLaw", law)]),
    }
}

fn reach_part(air: &AirConstituent) -> TablePart {
    TablePart {
        name: format!("{}.reach", air.name),
        column_axis: Axis::new("mu", "-", air.reach_mu.clone()),
        row_axes: vec![Axis::new("height", "m", air.reach_height_m.clone())],
        channels: vec![channel("reach", &air.reach_m)],
        attributes: Attributes::from([text("niji:meaning", REACH_MEANING)]),
    }
}

fn phase_part(air: &AirConstituent, wavelengths: Axis) -> TablePart {
    TablePart {
        name: format!("{}.phase", air.name),
        column_axis: Axis::new("theta", "rad", air.phase_angle_rad.clone()),
        row_axes: vec![wavelengths],
        channels: vec![channel("phase", &air.phase_sr1)],
        attributes: Attributes::from([text("niji:norm", "1/sr, integral over the sphere = 1")]),
    }
}

fn wavelength_axis(wavelengths: &WavelengthGrid) -> Axis {
    Axis::new(
        "wavelength",
        "nm",
        wavelengths.centers().map(|center| center.0).collect(),
    )
}

fn channel(name: &str, values: &Array2<f64>) -> Channel {
    // f32: see the head of the file.
    Channel {
        name: name.to_owned(),
        values: values.mapv(|value| value as f32),
    }
}

fn single_row(name: &str, values: &[f64]) -> Channel {
    let values = Array2::from_shape_fn((1, values.len()), |(_, x)| values[x]);
    channel(name, &values)
}

/// A channel, every value of which must be finite and not negative.
fn grid_of_values(part: &TablePart, name: &str) -> Result<Array2<f64>, Error> {
    let values = part.channel(name)?.mapv(f64::from);
    let bad = values
        .indexed_iter()
        .find(|(_, value)| !(value.is_finite() && **value >= 0.0));
    match bad {
        None => Ok(values),
        Some(((_, x), &value)) => Err(bad_value(part, name, x, value)),
    }
}

/// A channel of one row.
fn row(part: &TablePart, name: &str) -> Result<Vec<f64>, Error> {
    Ok(grid_of_values(part, name)?.into_iter().collect())
}

fn spectrum(spectra: &TablePart, name: &str) -> Result<Vec<f64>, Error> {
    row(spectra, name)
}

fn bad_value(part: &TablePart, channel: &str, x: usize, value: f64) -> Error {
    let (part, channel) = (part.name.clone(), channel.to_owned());
    // f32: the value came from a file of f32.
    Error::NotFinite {
        part,
        channel,
        x,
        y: 0,
        value: value as f32,
    }
}

pub(super) fn bad_axis(name: &str, problem: String) -> Error {
    Error::Axis {
        name: name.to_owned(),
        problem,
    }
}

pub(super) fn text(name: &str, text: &str) -> (String, AttributeValue) {
    (name.to_owned(), AttributeValue::Text(text.to_owned()))
}

pub(super) fn number(name: &str, number: f64) -> (String, AttributeValue) {
    (name.to_owned(), AttributeValue::Number(number))
}
