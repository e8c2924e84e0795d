//! Two EXR files, channel by channel.

use std::path::Path;

use niji_exchange::Channel;
use niji_exchange::PlainPart;
use niji_exchange::read_plain;
use niji_exchange::write_plain;

use super::measure::Measure;
use super::measure::same_names;
use crate::failure::Failure;
use crate::output;

pub(super) fn compare(
    reference: &Path,
    file: &Path,
    output: Option<&Path>,
) -> Result<Vec<Measure>, Failure> {
    let read = |path: &Path| read_plain(path).map_err(|error| Failure::bad_input(path, error));
    let (reference, mut found) = (read(reference)?, read(file)?);
    let names = |parts: &[PlainPart]| -> Vec<String> {
        parts.iter().map(|part| part.name.clone()).collect()
    };
    same_names("parts", &names(&reference), &names(&found))?;
    let mut measures = Vec::new();
    for part in &reference {
        let same = found.iter_mut().find(|other| other.name == part.name);
        if let Some(other) = same {
            measures.extend(compare_parts(part, other)?);
        }
    }
    if let Some(path) = output {
        output::write_file(path, |writer| write_plain(&found, writer))?;
    }
    Ok(measures)
}

/// Compares two parts and leaves the difference in the second.
fn compare_parts(reference: &PlainPart, found: &mut PlainPart) -> Result<Vec<Measure>, Failure> {
    let names = |part: &PlainPart| -> Vec<String> {
        part.channels
            .iter()
            .map(|channel| channel.name.clone())
            .collect()
    };
    same_names("channels", &names(reference), &names(found))?;
    let mut measures: Vec<Measure> = Vec::new();
    for channel in &reference.channels {
        let Some(other) = found
            .channels
            .iter_mut()
            .find(|other| other.name == channel.name)
        else {
            continue;
        };
        let group = group_name(&reference.name, &channel.name);
        let index = measures.iter().position(|measure| measure.name() == group);
        let index = index.unwrap_or_else(|| {
            measures.push(Measure::new(group));
            measures.len() - 1
        });
        compare_channels(channel, other, &mut measures[index])?;
    }
    Ok(measures)
}

/// Part and channel without its wavelength.
fn group_name(part: &str, channel: &str) -> String {
    let channel = match channel.split_once('.') {
        Some((prefix, wavelength)) if wavelength.ends_with("nm") => prefix,
        _ => channel,
    };
    if part.is_empty() {
        channel.to_owned()
    } else {
        format!("{part}:{channel}")
    }
}

fn compare_channels(
    reference: &Channel,
    found: &mut Channel,
    measure: &mut Measure,
) -> Result<(), Failure> {
    let ((h, w), (h_found, w_found)) = (reference.values.dim(), found.values.dim());
    if (h, w) != (h_found, w_found) {
        return Err(Failure::ComparisonFailed(format!(
            "{}: the reference has {w} x {h} pixels, the other {w_found} x {h_found}",
            measure.name()
        )));
    }
    let name = &reference.name;
    for ((place, value), &expected) in found.values.indexed_iter_mut().zip(&reference.values) {
        let (y, x) = place;
        measure.add(f64::from(expected), f64::from(*value), || {
            format!("{name} ({x}, {y})")
        });
        *value -= expected;
    }
    Ok(())
}
