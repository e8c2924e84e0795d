//! The names that `shape` may have: those of the shapes, asked of the type itself, and our own.

use std::fmt;
use std::sync::LazyLock;

use niji_droplets::Shape;
use serde::Deserialize;
use serde::Deserializer;
use serde::de::Visitor;

use super::FILE;
use super::FROM_VDB;

/// All names of [`super::DropSource`].
pub(super) fn all() -> &'static [&'static str] {
    static ALL: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
        let shapes = match Shape::deserialize(Asking) {
            Err(Names(names)) => names,
            // Nothing was there to be read.
            Ok(_) => &[],
        };
        [shapes, &[FROM_VDB, FILE]].concat()
    });
    &ALL
}

/// A deserializer that holds nothing: a type that comes to it tells its names and goes.
struct Asking;

/// The names, on the way of an error.
#[derive(Debug)]
struct Names(&'static [&'static str]);

impl fmt::Display for Names {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}", self.0)
    }
}

impl std::error::Error for Names {}

impl serde::de::Error for Names {
    fn custom<T: fmt::Display>(_message: T) -> Self {
        Self(&[])
    }
}

impl<'de> Deserializer<'de> for Asking {
    type Error = Names;

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Names> {
        Err(Names(&[]))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, Names> {
        Err(Names(variants))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        option unit unit_struct newtype_struct seq tuple tuple_struct map struct identifier
        ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_and_both_files_have_a_name() {
        let names = all();
        assert!(names.len() >= 10, "{names:?}");
        for name in [
            "uniform",
            "rain-shaft",
            "fog-bank",
            "sea-spray",
            "from-vdb",
            "file",
        ] {
            assert!(names.contains(&name), "{name}");
        }
    }
}
