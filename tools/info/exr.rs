//! What an EXR file holds.

use std::fmt::Write as _;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use niji_exchange::AttributeValue;
use niji_exchange::PartContents;
use niji_exchange::contents;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use super::Report;
use super::assertion::Ranges;
use crate::failure::Failure;

/// Channels of a part that are listed one by one for people.
const MOST_CHANNELS: usize = 8;
/// Characters of an attribute that are shown to people.
const MOST_CHARACTERS: usize = 76;

/// First bytes of every OpenEXR file.
const START: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

pub(super) fn report(path: &Path) -> Result<Report, Failure> {
    if is_something_else(path) {
        let message = "found neither an OpenVDB nor an OpenEXR file".to_owned();
        return Err(Failure::bad_input(path, message));
    }
    let parts = contents(path).map_err(|error| Failure::bad_input(path, error))?;
    let mut text = String::new();
    let mut ranges = Ranges::new();
    for part in &parts {
        describe(part, &mut text);
        for channel in &part.channels {
            let range = [f64::from(channel.min), f64::from(channel.max), channel.mean];
            ranges.insert(format!("{}:{}", part.name, channel.name), range);
            ranges.entry(channel.name.clone()).or_insert(range);
        }
    }
    let json = json!({ "parts": parts.iter().map(part_json).collect::<Vec<_>>() });
    Ok(Report { text, json, ranges })
}

/// Is it a file that begins otherwise? What cannot be read at all is the reader's to say.
fn is_something_else(path: &Path) -> bool {
    let mut start = [0; START.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut start));
    read.is_ok() && start != START
}

fn describe(part: &PartContents, text: &mut String) {
    let (width, height, n) = (part.width, part.height, part.channels.len());
    let _ = writeln!(text, "{}  {width} x {height}, {n} channels", part.name);
    for channel in part.channels.iter().take(MOST_CHANNELS) {
        let (min, max, mean) = (channel.min, channel.max, channel.mean);
        let _ = writeln!(
            text,
            "  {:<18} {min:.6e} .. {max:.6e}, mean {mean:.6e}",
            channel.name
        );
    }
    if n > MOST_CHANNELS {
        let _ = writeln!(text, "  … and {} more", n - MOST_CHANNELS);
    }
    for (name, value) in &part.attributes {
        let value = match value {
            AttributeValue::Text(text) => text.clone(),
            AttributeValue::Number(number) => number.to_string(),
        };
        let shown: String = value.chars().take(MOST_CHARACTERS).collect();
        let rest = if shown.len() < value.len() {
            " …"
        } else {
            ""
        };
        let _ = writeln!(text, "  {name} = {shown}{rest}");
    }
}

fn part_json(part: &PartContents) -> Value {
    let channels: Vec<Value> = part
        .channels
        .iter()
        .map(|c| json!({ "name": c.name, "min": c.min, "max": c.max, "mean": c.mean }))
        .collect();
    let attributes: Map<String, Value> = part
        .attributes
        .iter()
        .map(|(name, value)| match value {
            AttributeValue::Text(text) => (name.clone(), json!(text)),
            AttributeValue::Number(number) => (name.clone(), json!(number)),
        })
        .collect();
    json!({
        "name": part.name,
        "width": part.width,
        "height": part.height,
        "channels": channels,
        "attributes": attributes,
    })
}
