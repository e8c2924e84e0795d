//! Strict reading of TOML into plain serde types, with the line of whatever is wrong.
//!
//! A serde deserializer over the parsed document that differs from the one of the `toml` crate in
//! four ways:
//! 1. a key that a struct does not have is an error at every depth, with its line, a suggestion
//!    and the list of the keys that it does have;
//! 2. an enum whose variants carry settings is written as a table with a naming key (`shape` for
//!    drop shapes, `level` for accuracy levels): the name is read first and the rest of the table
//!    goes to that variant alone, so that serde's tagged enums with their buffered, line-less
//!    content are not needed; other keys of whoever holds such a choice may stand in the same table;
//! 3. drops are a table, or a list of tables;
//! 4. every message says what was found and what was expected in the words of a scene file; one about a key that a
//!    table lacks names all that it lacks.

mod fault;
mod named;
mod place;
mod stand_in;
mod table;

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::de::Visitor;
use toml::Spanned;
use toml::de::DeTable;
use toml::de::DeValue;

use crate::drops::DROPS;
use crate::error::SceneError;

use fault::Fault;
use named::NamedTable;
pub(crate) use named::Naming;
use named::UnitName;
pub(crate) use named::naming;
use place::Place;
use place::Source;
use place::join;
pub(crate) use place::section_of;
use table::Entries;
use table::Items;
use table::Only;
use table::WithChoice;

/// A parsed value together with every line that a later check of its content may have to name.
pub(crate) struct Document<T> {
    /// The typed content.
    pub(crate) value: T,
    /// Line of every key by its full path; the empty path is the document itself.
    pub(crate) lines: BTreeMap<String, usize>,
}

/// Parses `text` strictly.
pub(crate) fn parse<T: DeserializeOwned>(text: &str) -> Result<Document<T>, SceneError> {
    let mut source = Source::new(text);
    let root = DeTable::parse(text).map_err(|error| source.syntax_error(&error))?;
    let span = root.span();
    let root = Spanned::new(span, DeValue::Table(root.into_inner()));
    let fault = match read(&root, &source) {
        Ok(value) => {
            let mut lines = BTreeMap::new();
            collect_lines(&root, "", &source, &mut lines);
            return Ok(Document { value, lines });
        }
        Err(fault) => fault,
    };
    let mut next = fault.lacking();
    while next.is_some_and(|lacking| source.stand_in_for(lacking)) {
        next = read::<T>(&root, &source).err().and_then(|it| it.lacking());
    }
    Err(fault.into_scene_error(source.into_stand_ins()))
}

/// The content of a document.
fn read<T: DeserializeOwned>(root: &Spanned<DeValue<'_>>, source: &Source) -> Result<T, Fault> {
    T::deserialize(Node {
        value: root,
        elsewhere: &[],
        place: Place {
            source,
            path: String::new(),
            line: 1,
        },
    })
}

fn collect_lines(
    value: &Spanned<DeValue<'_>>,
    path: &str,
    source: &Source,
    lines: &mut BTreeMap<String, usize>,
) {
    if let DeValue::Array(items) = value.get_ref() {
        for (index, item) in items.iter().enumerate() {
            let path = format!("{path}[{index}]");
            lines.insert(path.clone(), source.line(item.span().start));
            collect_lines(item, &path, source, lines);
        }
    }
    let DeValue::Table(table) = value.get_ref() else {
        return;
    };
    for (key, child) in table {
        let child_path = join(path, key.get_ref());
        lines.insert(child_path.clone(), source.line(key.span().start));
        collect_lines(child, &child_path, source, lines);
    }
}

/// One value of the document.
struct Node<'a> {
    value: &'a Spanned<DeValue<'a>>,
    /// Keys of a table that belong to whoever holds this value.
    elsewhere: &'static [&'static str],
    place: Place<'a>,
}

impl Node<'_> {
    fn visit<'de, V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(integer) => {
                match i64::from_str_radix(integer.as_str(), integer.radix()) {
                    Ok(number) => visitor.visit_i64(number),
                    Err(_) => Err(Fault::out_of_range(integer.to_string(), "a 64-bit integer")),
                }
            }
            DeValue::Float(float) => match float.as_str().parse::<f64>() {
                Ok(number) if number.is_finite() => visitor.visit_f64(number),
                Ok(_) | Err(_) => Err(Fault::out_of_range(float.to_string(), "a finite number")),
            },
            DeValue::Boolean(flag) => visitor.visit_bool(*flag),
            DeValue::Datetime(date) => Err(Fault::wrong_type(
                format!("the date {date}"),
                "no date of its own: dates stand in quotes",
            )),
            DeValue::Array(array) => visitor.visit_seq(Items::new(array, &self.place)),
            DeValue::Table(table) => visitor.visit_map(Entries::new(table, &[], &self.place)),
        }
    }

    fn visit_struct<'de, V: Visitor<'de>>(
        self,
        struct_name: &str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let DeValue::Table(table) = self.value.get_ref() else {
            let found = fault::describe(self.value.get_ref());
            return Err(Fault::wrong_type(found, "a table of keys"));
        };
        let Some((choice, own)) = named::choice_within(struct_name) else {
            table::check_keys(table, &[], fields, &self.place)?;
            return visitor.visit_map(Entries::new(table, &[], &self.place).and_lacking(fields));
        };
        let keys = table.keys().map(|key| &**key.get_ref());
        let of_choice: Vec<&str> = keys.filter(|key| !own.contains(key)).collect();
        let entries = Entries::new(table, &of_choice, &self.place);
        let node = Node {
            elsewhere: own,
            ..self
        };
        visitor.visit_map(WithChoice::new(entries, choice, node))
    }

    fn visit_named<'de, V: Visitor<'de>>(
        self,
        enum_name: &str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        match self.value.get_ref() {
            DeValue::String(name) => {
                named::check_name(name, names)?;
                visitor.visit_enum(UnitName::new(name))
            }
            DeValue::Table(table) => {
                let named = NamedTable::read(table, enum_name, names, &self.place)?;
                visitor.visit_enum(named.without(self.elsewhere))
            }
            DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_) => {
                let expected = format!("one of {}", names.join(", "));
                Err(Fault::wrong_type(
                    fault::describe(self.value.get_ref()),
                    &expected,
                ))
            }
        }
    }
}

impl<'de> serde::Deserializer<'de> for Node<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        let place = self.place.clone();
        place.locate(self.visit(visitor))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let place = self.place.clone();
        match self.value.get_ref() {
            DeValue::Array(list) if name == DROPS => {
                place.locate(visitor.visit_seq(Items::new(list, &place)))
            }
            _ if name == DROPS => place.locate(visitor.visit_seq(Only::new(self))),
            _ => visitor.visit_newtype_struct(self),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let place = self.place.clone();
        place.locate(self.visit_struct(name, fields, visitor))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        let place = self.place.clone();
        place.locate(self.visit_named(name, variants, visitor))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}
