//! Choices by name: a bare name, or a table whose naming key says which variant the rest is for.

use serde::de::DeserializeSeed;
use serde::de::EnumAccess;
use serde::de::IntoDeserializer;
use serde::de::VariantAccess;
use serde::de::Visitor;
use serde::de::value::StrDeserializer;
use toml::de::DeTable;
use toml::de::DeValue;

use super::fault;
use super::fault::Fault;
use super::place::Place;
use super::place::join;
use super::table;
use super::table::Entries;

/// How the variants of an enum are written.
pub(crate) enum Naming {
    /// `{ level = "march", step_m = 1.0 }`: a key of the same table says the name.
    Key(&'static str),
    /// `{ column = { radius_m = 40.0 } }`: the only key is the name.
    OnlyKey,
}

/// The variant of drops that is named by having this key, in place of a shape.
const FILE: &str = "file";

/// Parts of drop shapes nest; the drops themselves and the levels of accuracy have a naming key.
pub(crate) fn naming(enum_name: &str) -> Naming {
    match enum_name {
        "DropSource" | "IceShape" => Naming::Key("shape"),
        "SizeLaw" | "Footprint" => Naming::OnlyKey,
        _ => Naming::Key("level"),
    }
}

/// The field of a struct that is a choice whose keys stand beside those of the other fields, as
/// `{ name = "fine", shape = "uniform", … }`, and these other fields.
pub(super) fn choice_within(struct_name: &str) -> Option<(&'static str, &'static [&'static str])> {
    (struct_name == "Population").then_some(("source", &["name"]))
}

pub(super) fn check_name(found: &str, names: &[&str]) -> Result<(), Fault> {
    if names.contains(&found) {
        Ok(())
    } else {
        Err(Fault::unknown_name(found, names))
    }
}

pub(super) fn check_key(found: &str, names: &[&str]) -> Result<(), Fault> {
    let allowed = || names.iter().map(ToString::to_string).collect();
    if names.contains(&found) {
        Ok(())
    } else {
        Err(Fault::unknown_key(found, allowed()))
    }
}

/// A variant given by its name alone.
pub(super) struct UnitName<'a> {
    name: &'a str,
}

impl<'a> UnitName<'a> {
    pub(super) fn new(name: &'a str) -> Self {
        Self { name }
    }

    fn needs_settings<T>(&self, key: &str) -> Result<T, Fault> {
        let expected = format!("a table, {{ level = \"{}\", {key} = … }}", self.name);
        Err(Fault::wrong_type(
            format!("the bare name \"{}\"", self.name),
            &expected,
        ))
    }
}

impl<'de, 'a> EnumAccess<'de> for UnitName<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Fault> {
        let name: StrDeserializer<'a, Fault> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for UnitName<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        Ok(())
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, _seed: T) -> Result<T::Value, Fault> {
        self.needs_settings("…")
    }

    fn tuple_variant<V: Visitor<'de>>(self, _len: usize, _v: V) -> Result<V::Value, Fault> {
        self.needs_settings("…")
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        _visitor: V,
    ) -> Result<V::Value, Fault> {
        self.needs_settings(fields.first().unwrap_or(&"…"))
    }
}

/// A variant with its settings.
pub(super) struct NamedTable<'a> {
    name: &'a str,
    /// The naming key, and keys that belong to whoever holds the choice.
    elsewhere: Vec<&'static str>,
    table: &'a DeTable<'a>,
    place: Place<'a>,
}

impl<'a> NamedTable<'a> {
    /// Reads the name of the variant.
    pub(super) fn read(
        table: &'a DeTable<'a>,
        enum_name: &str,
        names: &[&'static str],
        place: &Place<'a>,
    ) -> Result<Self, Fault> {
        match naming(enum_name) {
            Naming::Key(key) => Self::read_by_key(table, key, names, place),
            Naming::OnlyKey => Self::read_only_key(table, names, place),
        }
    }

    /// Leaves keys to whoever holds the choice.
    pub(super) fn without(mut self, elsewhere: &[&'static str]) -> Self {
        self.elsewhere.extend(elsewhere);
        self
    }

    fn read_only_key(
        table: &'a DeTable<'a>,
        names: &[&'static str],
        place: &Place<'a>,
    ) -> Result<Self, Fault> {
        table::check_keys(table, &[], names, place)?;
        let mut entries = table.iter();
        let (Some((key, value)), None) = (entries.next(), entries.next()) else {
            let expected = format!("exactly one of {}", names.join(", "));
            return Err(Fault::wrong_type(
                format!("a table of {} keys", table.len()),
                &expected,
            ));
        };
        let source = place.source;
        let line = source.line(key.span().start);
        let place = Place {
            source,
            path: join(&place.path, key.get_ref()),
            line,
        };
        let DeValue::Table(table) = value.get_ref() else {
            let found = fault::describe(value.get_ref());
            return Err(Fault::wrong_type(found, "a table of keys").located(&place));
        };
        Ok(Self {
            name: key.get_ref(),
            elsewhere: Vec::new(),
            table,
            place,
        })
    }

    /// A drops table without `shape` but with `file` is the variant `file`.
    fn read_by_key(
        table: &'a DeTable<'a>,
        key: &'static str,
        names: &[&'static str],
        place: &Place<'a>,
    ) -> Result<Self, Fault> {
        let place = place.clone();
        if table.get(key).is_none() && names.contains(&FILE) && table.get(FILE).is_some() {
            return Ok(Self {
                name: FILE,
                elsewhere: Vec::new(),
                table,
                place,
            });
        }
        let Some((spanned_key, value)) = table.get_key_value(key) else {
            let other = names.contains(&FILE).then_some(FILE);
            return Err(missing_naming_key(table, (key, other), &place));
        };
        let name_place = Place {
            source: place.source,
            path: join(&place.path, key),
            line: place.source.line(spanned_key.span().start),
        };
        let choices: Vec<&str> = names.iter().copied().filter(|name| *name != FILE).collect();
        let DeValue::String(name) = value.get_ref() else {
            let expected = format!("one of {}", choices.join(", "));
            let found = fault::describe(value.get_ref());
            return Err(Fault::wrong_type(found, &expected).located(&name_place));
        };
        name_place.locate(check_name(name, &choices))?;
        Ok(Self {
            name,
            elsewhere: vec![key],
            table,
            place,
        })
    }
}

/// A misspelt naming key is reported as such, an absent one as missing; `other` would do as well as `key`.
fn missing_naming_key(
    table: &DeTable<'_>,
    (key, other): (&'static str, Option<&'static str>),
    place: &Place<'_>,
) -> Fault {
    let keys: Vec<&str> = [key].into_iter().chain(other).collect();
    // A `profile` is not a misspelt `file`.
    let is_like = |found: &str, key: &str| {
        found.chars().next() == key.chars().next() && crate::error::suggest(found, &[key]).is_some()
    };
    let lookalike = table
        .keys()
        .find(|found| keys.iter().any(|key| is_like(found.get_ref(), key)));
    match lookalike {
        Some(found) => {
            let line = place.source.line(found.span().start);
            let allowed = keys.iter().map(ToString::to_string).collect();
            Fault::unknown_key(found.get_ref(), allowed).located(&Place {
                line,
                ..place.clone()
            })
        }
        None => Fault::missing_key(key, other),
    }
}

impl<'de, 'a> EnumAccess<'de> for NamedTable<'a> {
    type Error = Fault;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), Fault> {
        let name: StrDeserializer<'a, Fault> = self.name.into_deserializer();
        Ok((seed.deserialize(name)?, self))
    }
}

impl<'de> VariantAccess<'de> for NamedTable<'_> {
    type Error = Fault;

    fn unit_variant(self) -> Result<(), Fault> {
        table::check_keys(self.table, &self.elsewhere, &[], &self.place)
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Fault> {
        seed.deserialize(self)
    }

    fn tuple_variant<V: Visitor<'de>>(self, len: usize, _visitor: V) -> Result<V::Value, Fault> {
        Err(Fault::wrong_type(
            "a table".to_string(),
            &format!("an array of length {len}"),
        ))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        table::check_keys(self.table, &self.elsewhere, fields, &self.place)?;
        let place = self.place.clone();
        let entries = Entries::new(self.table, &self.elsewhere, &self.place).and_lacking(fields);
        place.locate(visitor.visit_map(entries))
    }
}

/// The settings of a variant that is a struct of its own.
impl<'de> serde::Deserializer<'de> for NamedTable<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let place = self.place.clone();
        place.locate(visitor.visit_map(Entries::new(self.table, &self.elsewhere, &self.place)))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.struct_variant(fields, visitor)
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        option unit unit_struct newtype_struct seq tuple tuple_struct map enum identifier
        ignored_any
    }
}
