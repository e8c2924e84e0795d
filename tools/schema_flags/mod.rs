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
mod field;
mod schema;
mod values;

use std::marker::PhantomData;

use clap::Arg;
use clap::ArgMatches;
use clap::Args;
use clap::Command;
use clap::FromArgMatches;
use clap::builder::TypedValueParser;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::failure::Failure;

pub(crate) use field::Flags;
pub(crate) use field::Variant;
use field::flagged;

impl Flags {
    /// The fields of a struct.
    pub(crate) fn of<T: JsonSchema>() -> Self {
        Self {
            fields: schema::fields(&schema::of::<T>(), ""),
        }
    }

    /// The same with a default for a field that the struct requires.
    pub(crate) fn with_default(mut self, key: &str, value: &Value) -> Self {
        for field in self.fields.iter_mut().filter(|field| field.key == key) {
            field.default = Some(value.clone());
        }
        self
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

/// A struct that a command takes by its flags.
pub(crate) trait Flagged: JsonSchema + DeserializeOwned {
    /// Its fields.
    fn flags() -> Flags {
        Flags::of::<Self>()
    }

    /// The flags, for the command.
    fn arguments() -> Vec<Arg> {
        Self::flags().arguments()
    }
}

/// What a command line says of a struct.
#[derive(Debug)]
pub(crate) struct Given<T>(ArgMatches, PhantomData<T>);

impl<T: Flagged> Given<T> {
    /// The struct.
    ///
    /// # Errors
    /// As [`Flags::value`] and [`read`].
    pub(crate) fn read(&self) -> Result<T, Failure> {
        read(T::flags().value(&self.0)?)
    }
}

impl<T: Flagged> Args for Given<T> {
    fn augment_args(command: Command) -> Command {
        command.args(T::arguments())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T> FromArgMatches for Given<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self(matches.clone(), PhantomData))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0 = matches.clone();
        Ok(())
    }
}

/// The variants of an enum of structs.
pub(crate) fn variants<T: JsonSchema>() -> Vec<Variant> {
    schema::variants(&schema::of::<T>())
}

/// Values of an enum of plain names, by their names in scene files.
pub(crate) fn names<T>() -> impl TypedValueParser<Value = T>
where
    T: JsonSchema + DeserializeOwned + Clone + Send + Sync + 'static,
{
    let names = arguments::possible(&schema::names(&schema::of::<T>()));
    names.try_map(|name| serde_json::from_value(name.into()))
}

/// The name of such a value.
pub(crate) fn name(value: impl Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

/// The type that JSON stands for.
///
/// # Errors
/// A number beyond the range of its type.
pub(crate) fn read<T: DeserializeOwned>(value: Value) -> Result<T, Failure> {
    serde_json::from_value(value).map_err(|error| Failure::Usage(error.to_string()))
}

#[cfg(test)]
mod tests;
