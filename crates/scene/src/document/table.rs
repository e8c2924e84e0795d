//! Tables and arrays of the document, entry by entry.

use serde::de::DeserializeSeed;
use serde::de::MapAccess;
use serde::de::SeqAccess;
use serde::de::Visitor;
use toml::Spanned;
use toml::de::DeArray;
use toml::de::DeString;
use toml::de::DeTable;
use toml::de::DeValue;

use super::Node;
use super::fault::Fault;
use super::named;
use super::named::UnitName;
use super::place::Place;
use super::place::join;
use super::stand_in::StandIn;

/// Refuses the first key, in the order of the file, that is neither in `fields` nor among those that
/// are read elsewhere.
pub(super) fn check_keys(
    table: &DeTable<'_>,
    elsewhere: &[&str],
    fields: &[&str],
    place: &Place<'_>,
) -> Result<(), Fault> {
    let is_known = |key: &str| elsewhere.contains(&key) || fields.contains(&key);
    let first_unknown = table
        .keys()
        .filter(|key| !is_known(key.get_ref()))
        .min_by_key(|key| key.span().start);
    let Some(key) = first_unknown else {
        return Ok(());
    };
    let allowed = elsewhere
        .iter()
        .chain(fields)
        .map(ToString::to_string)
        .collect();
    let key_place = Place {
        line: place.source.line(key.span().start),
        ..place.clone()
    };
    Err(Fault::unknown_key(key.get_ref(), allowed).located(&key_place))
}

/// Entries of a table, without the keys that are read elsewhere.
pub(super) struct Entries<'a> {
    rest: Vec<(&'a Spanned<DeString<'a>>, &'a Spanned<DeValue<'a>>)>,
    next_value: Option<Node<'a>>,
    /// Keys that it lacks, behind all others.
    lacking: Vec<&'a str>,
    place: Place<'a>,
}

impl<'a> Entries<'a> {
    pub(super) fn new(table: &'a DeTable<'a>, elsewhere: &[&str], place: &Place<'a>) -> Self {
        let mut rest: Vec<_> = table
            .iter()
            .filter(|(key, _)| !elsewhere.contains(&&**key.get_ref()))
            .collect();
        // The file's order, last first, so that the first mistake in the file is reported.
        rest.sort_by_key(|(key, _)| std::cmp::Reverse(key.span().start));
        Self {
            rest,
            next_value: None,
            lacking: Vec::new(),
            place: place.clone(),
        }
    }

    /// The same with keys that something stands in for, of those that a struct has.
    pub(super) fn and_lacking(mut self, fields: &[&str]) -> Self {
        let lacking = self.place.source.lacking(&self.place.path);
        self.lacking = lacking.filter(|key| fields.contains(key)).collect();
        self
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Fault> {
        let Some((key, value)) = self.rest.pop() else {
            let place = self.place.clone();
            let key = self.lacking.pop();
            return key
                .map(|name| seed.deserialize(Key { name, place }))
                .transpose();
        };
        let line = self.place.source.line(key.span().start);
        let path = join(&self.place.path, key.get_ref());
        let key_place = Place {
            line,
            ..self.place.clone()
        };
        self.next_value = Some(Node {
            value,
            elsewhere: &[],
            place: Place {
                source: self.place.source,
                path,
                line,
            },
        });
        seed.deserialize(Key {
            name: key.get_ref(),
            place: key_place,
        })
        .map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        match self.next_value.take() {
            Some(node) => {
                // What a type refuses when its parts are read already belongs here.
                let place = node.place.clone();
                place.locate(seed.deserialize(node))
            }
            None => seed.deserialize(StandIn),
        }
    }
}

/// Items of an array.
pub(super) struct Items<'a> {
    rest: std::iter::Enumerate<std::slice::Iter<'a, Spanned<DeValue<'a>>>>,
    place: Place<'a>,
}

impl<'a> Items<'a> {
    pub(super) fn new(array: &'a DeArray<'a>, place: &Place<'a>) -> Self {
        Self {
            rest: array.iter().enumerate(),
            place: place.clone(),
        }
    }
}

impl<'de> SeqAccess<'de> for Items<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Fault> {
        let Some((index, value)) = self.rest.next() else {
            return Ok(None);
        };
        let source = self.place.source;
        let path = format!("{}[{index}]", self.place.path);
        let line = source.line(value.span().start);
        seed.deserialize(Node {
            value,
            elsewhere: &[],
            place: Place { source, path, line },
        })
        .map(Some)
    }
}

/// A value in place of a list of one.
pub(super) struct Only<'a>(Option<Node<'a>>);

impl<'a> Only<'a> {
    pub(super) fn new(node: Node<'a>) -> Self {
        Self(Some(node))
    }
}

impl<'de> SeqAccess<'de> for Only<'_> {
    type Error = Fault;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Fault> {
        self.0.take().map(|node| seed.deserialize(node)).transpose()
    }
}

/// Entries of a struct in whose table the keys of a choice stand too.
pub(super) struct WithChoice<'a> {
    own: Entries<'a>,
    choice: Option<(&'static str, Node<'a>)>,
}

impl<'a> WithChoice<'a> {
    /// `own` are the entries besides those of the choice, which the field `name` holds.
    pub(super) fn new(own: Entries<'a>, name: &'static str, choice: Node<'a>) -> Self {
        let choice = Some((name, choice));
        Self { own, choice }
    }
}

impl<'de> MapAccess<'de> for WithChoice<'_> {
    type Error = Fault;

    fn next_key_seed<K: DeserializeSeed<'de>>(
        &mut self,
        seed: K,
    ) -> Result<Option<K::Value>, Fault> {
        match &self.choice {
            Some((name, choice)) if self.own.rest.is_empty() => {
                let place = choice.place.clone();
                seed.deserialize(Key { name, place }).map(Some)
            }
            Some(_) | None => self.own.next_key_seed(seed),
        }
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Fault> {
        match self.choice.take_if(|_| self.own.next_value.is_none()) {
            Some((_, choice)) => seed.deserialize(choice),
            None => self.own.next_value_seed(seed),
        }
    }
}

/// The key of an entry; as a key of a map it may have to be one of an enum's names.
struct Key<'a> {
    name: &'a str,
    place: Place<'a>,
}

impl<'de> serde::Deserializer<'de> for Key<'_> {
    type Error = Fault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fault> {
        self.place.locate(visitor.visit_str(self.name))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fault> {
        self.place.locate(named::check_key(self.name, variants))?;
        self.place
            .locate(visitor.visit_enum(UnitName::new(self.name)))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        option unit unit_struct newtype_struct seq tuple tuple_struct map struct identifier
        ignored_any
    }
}
