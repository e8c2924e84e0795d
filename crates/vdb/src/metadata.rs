//! Named, typed items that a file or a grid carries besides its voxels.

use std::collections::BTreeMap;

/// The value of a metadata item.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum MetaValue {
    /// `bool`.
    Bool(bool),
    /// `int32`.
    Int32(i32),
    /// `int64`.
    Int64(i64),
    /// `float`.
    Float(f32),
    /// `double`.
    Double(f64),
    /// `string`, UTF-8.
    String(String),
    /// `vec3i`.
    Vec3i([i32; 3]),
    /// `vec3s`.
    Vec3s([f32; 3]),
    /// `vec3d`.
    Vec3d([f64; 3]),
    /// Any other type, kept byte for byte.
    Unknown {
        /// OpenVDB's name of the type.
        type_name: String,
        /// The value as it stands in the file.
        bytes: Vec<u8>,
    },
}

/// Metadata items by name, in the order of their names (as OpenVDB writes them).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Metadata {
    items: BTreeMap<String, MetaValue>,
}

impl Metadata {
    /// No items.
    pub fn new() -> Self {
        Self::default()
    }

    /// Set an item; an item of that name is replaced.
    pub fn insert(&mut self, name: impl Into<String>, value: impl Into<MetaValue>) {
        self.items.insert(name.into(), value.into());
    }

    /// Take an item out.
    pub fn remove(&mut self, name: &str) -> Option<MetaValue> {
        self.items.remove(name)
    }

    /// The item of that name.
    pub fn get(&self, name: &str) -> Option<&MetaValue> {
        self.items.get(name)
    }

    /// The item of that name, if it is a string.
    pub fn get_str(&self, name: &str) -> Option<&str> {
        match self.items.get(name) {
            Some(MetaValue::String(text)) => Some(text),
            _ => None,
        }
    }

    /// All items in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &MetaValue)> {
        self.items
            .iter()
            .map(|(name, value)| (name.as_str(), value))
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is no item.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}

impl From<bool> for MetaValue {
    fn from(value: bool) -> Self {
        Self::Bool(value)
    }
}

impl From<i32> for MetaValue {
    fn from(value: i32) -> Self {
        Self::Int32(value)
    }
}

impl From<i64> for MetaValue {
    fn from(value: i64) -> Self {
        Self::Int64(value)
    }
}

impl From<f32> for MetaValue {
    fn from(value: f32) -> Self {
        Self::Float(value)
    }
}

impl From<f64> for MetaValue {
    fn from(value: f64) -> Self {
        Self::Double(value)
    }
}

impl From<&str> for MetaValue {
    fn from(value: &str) -> Self {
        Self::String(value.to_owned())
    }
}

impl From<String> for MetaValue {
    fn from(value: String) -> Self {
        Self::String(value)
    }
}

impl From<[i32; 3]> for MetaValue {
    fn from(value: [i32; 3]) -> Self {
        Self::Vec3i(value)
    }
}

impl From<[f32; 3]> for MetaValue {
    fn from(value: [f32; 3]) -> Self {
        Self::Vec3s(value)
    }
}

impl From<[f64; 3]> for MetaValue {
    fn from(value: [f64; 3]) -> Self {
        Self::Vec3d(value)
    }
}
