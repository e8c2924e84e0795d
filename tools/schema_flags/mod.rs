//! Flags that follow from a type: each field of a shape or size law is a flag, and nothing else is.
//!
//! Scene files and the command line read the same structs. Their JSON schema says what there is:
//! names, documentation, types, defaults. From it come the flags, and what was given on the command
//! line goes back as JSON into the very type. A key `max_rain_rate_mm_h` is `--max-rain-rate-mm-h`;
//! 1. of a struct inside a struct, the flags carry its name: `--turbulence-strength`;
//! 2. of an enum of structs, a flag names the variant and the flags of that variant stand beside it:
//!    `--law monodisperse --radius-um 100`;
//! 3. of an enum of plain numbers, each variant is a flag and one of them may be given.

mod arguments;
mod schema;
mod values;

use clap::Arg;
use clap::ArgMatches;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::failure::Failure;

/// The fields of a struct as flags.
#[derive(Clone, Debug)]
pub(crate) struct Flags {
    fields: Vec<Field>,
}

/// A variant of an enum of structs.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    /// Its name in files and on the command line.
    pub(crate) name: String,
    /// What it is.
    pub(crate) about: String,
    /// Its fields.
    pub(crate) flags: Flags,
}

/// A field of a struct.
#[derive(Clone, Debug)]
struct Field {
    key: String,
    flag: String,
    help: String,
    is_required: bool,
    default: Option<Value>,
    kind: Kind,
}

/// What a field holds.
#[derive(Clone, Debug)]
enum Kind {
    Number,
    WholeNumber,
    Text,
    /// A list of so many numbers.
    Numbers(usize),
    /// One of some names, each with what it means.
    Name(Vec<(String, String)>),
    /// A struct.
    Group(Vec<Field>),
    /// One of some structs.
    Choice(Vec<Variant>),
    /// One of some plain numbers.
    OneOf(Vec<Field>),
}

impl Flags {
    /// The fields of a struct.
    pub(crate) fn of<T: JsonSchema>() -> Self {
        Self {
            fields: schema::fields(&schema::of::<T>(), ""),
        }
    }

    /// The flags, for a command.
    pub(crate) fn arguments(&self) -> Vec<Arg> {
        arguments::of_fields(&self.fields)
    }

    /// What was given, as the JSON of the struct.
    ///
    /// # Errors
    /// A flag that is missing, or that belongs to another variant.
    pub(crate) fn value(&self, matches: &ArgMatches) -> Result<Value, Failure> {
        values::object(&self.fields, matches)
    }

    /// A message of a library with flags in place of the names of fields.
    pub(crate) fn name_flags(&self, message: &str) -> String {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let flag = |word: &str| flagged(&self.fields).find(|field| field.key == word);
        let named = |(place, part): (usize, &str)| {
            let word = part.trim_end_matches(|c: char| !is_word(c));
            // A name of one word is a name where it begins the message, and else may be prose.
            match flag(word).filter(|_| place == 0 || word.contains('_')) {
                Some(field) => format!("--{}{}", field.flag, &part[word.len()..]),
                None => part.to_owned(),
            }
        };
        let parts = message.split_inclusive(|c: char| !is_word(c));
        parts.enumerate().map(named).collect()
    }
}

/// The variants of an enum of structs.
pub(crate) fn variants<T: JsonSchema>() -> Vec<Variant> {
    schema::variants(&schema::of::<T>())
}

/// The type that JSON stands for.
///
/// # Errors
/// A number beyond the range of its type.
pub(crate) fn read<T: DeserializeOwned>(value: Value) -> Result<T, Failure> {
    serde_json::from_value(value).map_err(|error| Failure::Usage(error.to_string()))
}

/// The fields that have a flag of their own, at any depth.
fn flagged(fields: &[Field]) -> Box<dyn Iterator<Item = &Field> + '_> {
    Box::new(fields.iter().flat_map(|field| match &field.kind {
        Kind::Group(inner) | Kind::OneOf(inner) => flagged(inner),
        Kind::Choice(variants) => {
            let inner = variants
                .iter()
                .flat_map(|variant| flagged(&variant.flags.fields));
            Box::new(std::iter::once(field).chain(inner))
        }
        Kind::Number | Kind::WholeNumber | Kind::Text | Kind::Numbers(_) | Kind::Name(_) => {
            Box::new(std::iter::once(field))
        }
    }))
}

#[cfg(test)]
mod tests;
