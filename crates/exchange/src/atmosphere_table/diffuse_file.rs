//! The light of higher orders in the file of an atmosphere table: three parts, all or none.
//!
//! * `diffuse_light`: columns = wavelength, rows = height x sun_zenith; a channel `moment.LL.MM` for
//!   every pair of degree and order
//! * `diffuse_light_on_ground`: columns = wavelength, rows = sun_zenith; channel `irradiance`
//! * `phase_moments`: columns = wavelength, rows = degree; a channel for every constituent
//!
//! Their names hold no point, so that no constituent's part can bear them. At 41 wavelengths and the
//! usual level the file grows by 1 MB in clear air and by 10 MB in haze.

use ndarray::Array2;

use super::AirConstituent;
use super::diffuse_light::DiffuseLight;
use super::diffuse_light::LARGEST_DEGREE;
use super::file::bad_axis;
use super::file::number;
use super::file::text;
use super::harmonics::moment_index;
use super::harmonics::n_moments;
use crate::attributes::Attributes;
use crate::error::Error;
use crate::table::Axis;
use crate::table::Channel;
use crate::table::TableFile;
use crate::table::TablePart;

const LIGHT: &str = "diffuse_light";
const ON_GROUND: &str = "diffuse_light_on_ground";
const PHASES: &str = "phase_moments";
const MAX_DEGREE: &str = "niji:maxDegree";
/// Said in the header.
const MEANING: &str = "integral over directions of radiance Y_lm(mu) cos(m phi) over the sun's \
                       irradiance above the air; mu, phi where the light comes from, phi from the \
                       sun's azimuth; Y_lm = sqrt((l-m)!/(l+m)!) P_lm without Condon-Shortley phase";

/// The parts of a table with diffuse light.
pub(super) fn parts(
    light: &DiffuseLight,
    constituents: &[AirConstituent],
    wavelengths: &Axis,
) -> [TablePart; 3] {
    let n = wavelengths.values.len();
    let suns = Axis::new("sun_zenith", "rad", light.sun_zenith_rad.clone());
    let rows_of = |values: &[f32]| {
        Array2::from_shape_fn((values.len() / n, n), |(row, column)| {
            values[row * n + column]
        })
    };
    let n_pairs = n_moments(light.max_degree);
    let n_nodes = light.height_m.len() * light.sun_zenith_rad.len();
    let moments = pairs(light.max_degree).map(|(l, m)| Channel {
        name: channel_name(l, m),
        values: Array2::from_shape_fn((n_nodes, n), |(node, column)| {
            light.moments[(node * n_pairs + moment_index(l, m)) * n + column]
        }),
    });
    let phases = constituents.iter().enumerate().map(|(index, air)| Channel {
        name: air.name.clone(),
        values: rows_of(light.phase_moments_of(index)),
    });
    let part = |name: &str, row_axes, channels| TablePart {
        name: name.to_owned(),
        column_axis: wavelengths.clone(),
        row_axes,
        channels,
        attributes: Attributes::new(),
    };
    let heights = Axis::new("height", "m", light.height_m.clone());
    let mut main = part(LIGHT, vec![heights, suns.clone()], moments.collect());
    // Small whole numbers are exact.
    let max_degree = light.max_degree as f64;
    main.attributes = Attributes::from([
        number(MAX_DEGREE, max_degree),
        text("niji:meaning", MEANING),
    ]);
    let irradiance = Channel {
        name: "irradiance".to_owned(),
        values: rows_of(&light.on_ground),
    };
    let degrees = (0..=light.max_degree).map(|l| l as f64).collect();
    let degrees = Axis::new("degree", "-", degrees);
    [
        main,
        part(ON_GROUND, vec![suns], vec![irradiance]),
        part(PHASES, vec![degrees], phases.collect()),
    ]
}

/// Reads the light from a file that may have none.
///
/// # Errors
/// A missing part, channel or attribute, axes that disagree with each other or with the wavelengths,
/// or values that no light can have.
pub(super) fn read(
    file: &TableFile,
    names: &[&str],
    wavelengths: &Axis,
) -> Result<Option<DiffuseLight>, Error> {
    let is_there = |name: &&str| file.parts.iter().any(|part| part.name == *name);
    if ![LIGHT, ON_GROUND, PHASES].iter().any(is_there) {
        return Ok(None);
    }
    let (main, on_ground) = (file.part(LIGHT)?, file.part(ON_GROUND)?);
    let phases = file.part(PHASES)?;
    let axis = |name, unit| (name, unit);
    let columns = axis("wavelength", "nm");
    let suns = axis("sun_zenith", "rad");
    main.expect_axes(&[columns, axis("height", "m"), suns])?;
    on_ground.expect_axes(&[columns, suns])?;
    phases.expect_axes(&[columns, axis("degree", "-")])?;
    for part in [main, on_ground, phases] {
        if part.column_axis.values != wavelengths.values {
            let problem = format!("those of part {:?} are not those of the air", part.name);
            return Err(bad_axis("wavelength", problem));
        }
    }
    let sun_zenith_rad = main.row_axis("sun_zenith")?.values.clone();
    if on_ground.row_axis("sun_zenith")?.values != sun_zenith_rad {
        let problem = format!("part {ON_GROUND:?} has others than part {LIGHT:?}");
        return Err(bad_axis("sun_zenith", problem));
    }
    let max_degree = max_degree(main, phases)?;
    let mut phase_moments = Vec::new();
    for name in names {
        phase_moments.extend(finite(phases, name, f32::MIN)?);
    }
    let light = DiffuseLight {
        height_m: main.row_axis("height")?.values.clone(),
        sun_zenith_rad,
        max_degree,
        moments: moments(main, max_degree)?,
        on_ground: finite(on_ground, "irradiance", 0.0)?,
        phase_moments,
    };
    check_axes(&light)?;
    Ok(Some(light))
}

fn max_degree(main: &TablePart, phases: &TablePart) -> Result<usize, Error> {
    let found = main.number(MAX_DEGREE)?;
    let degrees = phases.row_axis("degree")?;
    // Compared with a value that was stored.
    let fits = (1..=LARGEST_DEGREE).find(|degree| *degree as f64 == found);
    let Some(max_degree) = fits else {
        let problem = format!("found a largest one of {found}, expected 1 to {LARGEST_DEGREE}");
        return Err(bad_axis("degree", problem));
    };
    if degrees.values.len() == max_degree + 1 {
        return Ok(max_degree);
    }
    Err(Error::Shape {
        what: format!("degrees of part {PHASES:?}"),
        found: degrees.values.len(),
        expected: max_degree + 1,
    })
}

/// The channels of all pairs, interleaved.
fn moments(main: &TablePart, max_degree: usize) -> Result<Vec<f32>, Error> {
    let channel = |(l, m)| {
        let least = if l == 0 { 0.0 } else { f32::MIN };
        finite(main, &channel_name(l, m), least)
    };
    let channels = pairs(max_degree).map(channel);
    let channels: Vec<Vec<f32>> = channels.collect::<Result<_, _>>()?;
    let n = main.column_axis.values.len();
    let n_nodes = channels[0].len() / n;
    let mut moments = Vec::with_capacity(n_nodes * channels.len() * n);
    for node in 0..n_nodes {
        for channel in &channels {
            moments.extend_from_slice(&channel[node * n..(node + 1) * n]);
        }
    }
    Ok(moments)
}

/// A channel, row by row, none of its values below `least`.
fn finite(part: &TablePart, name: &str, least: f32) -> Result<Vec<f32>, Error> {
    let values = part.channel(name)?;
    let place = |y, x, value| (part.name.clone(), name.to_owned(), x, y, value);
    for ((y, x), &value) in values.indexed_iter() {
        if !value.is_finite() {
            let (part, channel, x, y, value) = place(y, x, value);
            return Err(Error::NotFinite {
                part,
                channel,
                x,
                y,
                value,
            });
        }
        if value < least {
            let (part, channel, x, y, value) = place(y, x, value);
            return Err(Error::Negative {
                part,
                channel,
                x,
                y,
                value,
            });
        }
    }
    Ok(values.iter().copied().collect())
}

fn check_axes(light: &DiffuseLight) -> Result<(), Error> {
    for (name, axis) in [
        ("height", &light.height_m),
        ("sun_zenith", &light.sun_zenith_rad),
    ] {
        if axis.len() < 2 {
            return Err(bad_axis(name, "found one value, expected several".into()));
        }
    }
    let first = light.sun_zenith_rad[0];
    let last = light.sun_zenith_rad[light.sun_zenith_rad.len() - 1];
    if first < 0.0 || last > std::f64::consts::PI {
        let problem = format!("found {first} to {last}, expected angles from 0 to pi");
        return Err(bad_axis("sun_zenith", problem));
    }
    Ok(())
}

fn pairs(max_degree: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..=max_degree).flat_map(|l| (0..=l).map(move |m| (l, m)))
}

/// Two digits, so that names sort like the pairs.
fn channel_name(degree: usize, order: usize) -> String {
    format!("moment.{degree:02}.{order:02}")
}
