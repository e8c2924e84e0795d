//! Named values in the header of a part.

use std::collections::BTreeMap;

/// A value in a header.
#[derive(Clone, Debug, PartialEq)]
pub enum AttributeValue {
    /// An EXR `string`.
    Text(String),
    /// An EXR `double`.
    Number(f64),
}

/// The standard attribute for how wide a pinhole looks, 2 tan(fov/2), a number of f32; 1 where nothing says it.
pub const WINDOW_WIDTH: &str = "screenWindowWidth";

/// Attributes by name.
pub type Attributes = BTreeMap<String, AttributeValue>;

/// Adds named texts, such as those of a provenance, to attributes.
pub(crate) fn insert_texts(attributes: &mut Attributes, items: Vec<(String, String)>) {
    for (name, text) in items {
        attributes.insert(name, AttributeValue::Text(text));
    }
}

/// The named texts among attributes.
pub(crate) fn texts(attributes: &Attributes) -> impl Iterator<Item = (&str, &str)> {
    attributes.iter().filter_map(|(name, value)| match value {
        AttributeValue::Text(text) => Some((name.as_str(), text.as_str())),
        AttributeValue::Number(_) => None,
    })
}
