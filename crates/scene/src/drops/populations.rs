//! The drops of a scene: one population, or several whose extinctions and light add up.
//!
//! A scene file has `[drops]` for one and `[[drops]]` for each of several. In the drop volume the modes
//! of a population stand behind its name: `fine_number_density`.

use std::fmt;

use niji_droplets::Shape;
use serde::Deserialize;
use serde::Deserializer;
use serde::Serialize;
use serde::Serializer;
use serde::de::Error;
use serde::de::MapAccess;
use serde::de::SeqAccess;
use serde::de::Visitor;
use serde::de::value::MapAccessDeserializer;

use super::DropSource;

/// Name of [`Drops`] for who reads them: a table of theirs counts as a list of one.
pub(crate) const DROPS: &str = "Drops";

/// Populations of drops in one air; at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct Drops {
    populations: Vec<Population>,
}

/// Drops that are laid out together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Population {
    /// What its modes are called in the drop volume; see [`Drops::mode_names`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Where they are and how large.
    pub source: DropSource,
}

impl Population {
    /// What its name should have been; `None` if there is nothing wrong with it.
    #[must_use]
    pub fn name_fault(&self) -> Option<&'static str> {
        let name = self.name.as_deref()?;
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let is_word =
            name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(is_part);
        let is_told_apart = niji_dropfield::mode_name_fault(name).is_none();
        (!is_word || !is_told_apart).then_some(
            "a letter, then letters, digits, `-` or `_`, without `_` or `number` at its end",
        )
    }
}

impl Drops {
    /// The populations, in the order of the file.
    #[must_use]
    pub fn populations(&self) -> &[Population] {
        &self.populations
    }

    /// The same with every source changed, which is told its place.
    #[must_use]
    pub fn with_sources(mut self, change: impl Fn(usize, DropSource) -> DropSource) -> Self {
        for (place, population) in self.populations.iter_mut().enumerate() {
            population.source = change(place, population.source.clone());
        }
        self
    }

    /// The shape, where there is one population and it is a shape.
    #[must_use]
    pub fn shape(&self) -> Option<Shape> {
        match self.populations.as_slice() {
            [only] => only.source.shape(),
            _ => None,
        }
    }

    /// The drop volume to read, relative to the scene file; `None` if it has to be made.
    #[must_use]
    pub fn file(&self) -> Option<&str> {
        match self.populations.as_slice() {
            [
                Population {
                    name: None,
                    source: DropSource::File(drops),
                },
            ] => Some(&drops.file),
            _ => None,
        }
    }

    /// What stands before the modes of each population in the drop volume: its name; without one,
    /// nothing where it is the only one, and else what it is with its place, counted from 0, as
    /// `rain_shaft_1`.
    #[must_use]
    pub fn mode_names(&self) -> Vec<String> {
        let is_only = self.populations.len() == 1;
        let name = |(place, population): (usize, &Population)| match &population.name {
            Some(name) => name.clone(),
            None if is_only => String::new(),
            None => format!("{}_{place}", population.source.name().replace('-', "_")),
        };
        self.populations.iter().enumerate().map(name).collect()
    }
}

/// A single population without a name as itself, as files and hashes knew it before there were several.
impl Serialize for Drops {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.populations.as_slice() {
            [Population { name: None, source }] => source.serialize(serializer),
            populations => serializer.collect_seq(populations),
        }
    }
}

impl<'de> Deserialize<'de> for Drops {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_newtype_struct(DROPS, DropsVisitor)
    }
}

struct DropsVisitor;

impl<'de> Visitor<'de> for DropsVisitor {
    type Value = Drops;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a table of drops, or at least one of several")
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, inner: D) -> Result<Drops, D::Error> {
        inner.deserialize_any(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Drops, A::Error> {
        let mut populations = Vec::new();
        while let Some(population) = items.next_element()? {
            populations.push(population);
        }
        if populations.is_empty() {
            return Err(A::Error::invalid_length(0, &self));
        }
        Ok(Drops { populations })
    }

    /// As [`Drops`] are written where there is one population without a name.
    fn visit_map<A: MapAccess<'de>>(self, data: A) -> Result<Drops, A::Error> {
        let source = DropSource::deserialize(MapAccessDeserializer::new(data))?;
        let populations = vec![Population { name: None, source }];
        Ok(Drops { populations })
    }
}

#[cfg(test)]
mod tests {
    use crate::document;

    use super::*;

    const MIST: &str = "file = \"mist.vdb\"\n";

    #[derive(Debug, Deserialize)]
    struct Section {
        drops: Drops,
    }

    fn drops(text: &str) -> Drops {
        document::parse::<Section>(text).unwrap().value.drops
    }

    #[test]
    fn one_entry_of_a_list_is_the_table() {
        let one = drops(&format!("[drops]\n{MIST}"));
        for text in [
            format!("[[drops]]\n{MIST}"),
            "drops = [{ file = \"mist.vdb\" }]".to_owned(),
        ] {
            assert_eq!(drops(&text), one);
        }
        assert_eq!(
            (one.file(), one.mode_names()),
            (Some("mist.vdb"), vec![String::new()])
        );
        assert_eq!(
            serde_json::to_string(&one).unwrap(),
            r#"{"file":{"file":"mist.vdb"}}"#
        );
    }

    #[test]
    fn modes_are_called_by_name_or_by_what_they_are_and_where() {
        let named = drops(&format!("[drops]\nname = \"far\"\n{MIST}"));
        // A volume that is renamed has to be written.
        assert_eq!(
            (named.file(), named.mode_names()),
            (None, vec!["far".to_owned()])
        );
        let several =
            format!("[[drops]]\n{MIST}\n[[drops]]\n{MIST}name = \"far\"\n[[drops]]\n{MIST}");
        let several = drops(&several);
        assert_eq!(several.mode_names(), ["file_0", "far", "file_2"]);
        assert_eq!(several.file(), None);
        for drops in [named, several] {
            let json = serde_json::to_string(&drops).unwrap();
            assert_eq!(serde_json::from_str::<Drops>(&json).unwrap(), drops);
        }
    }

    #[test]
    fn names_are_those_that_grids_and_keys_of_sequences_can_have() {
        let fault = |name: &str| {
            let text = format!("[drops]\nname = \"{name}\"\n{MIST}");
            drops(&text).populations()[0].name_fault()
        };
        for name in ["fine", "r200", "a-b_c", "numbers"] {
            assert_eq!(fault(name), None, "{name}");
        }
        for name in [
            "", "2", "_a", "a_", "a b", "a.b", "Größe", "number", "a_number",
        ] {
            assert!(fault(name).is_some(), "{name}");
        }
    }

    #[test]
    fn no_drops_at_all_are_refused() {
        for text in ["drops = []", "drops = 3", "drops = [3]"] {
            let error = document::parse::<Section>(text).map(|_| ()).unwrap_err();
            assert_eq!(error.line(), Some(1), "{error}");
        }
        assert!(serde_json::from_str::<Drops>("[]").is_err());
    }
}
