//! An error on its way up to the place in the document that it belongs to.

use std::fmt;

use serde::de::Expected;
use serde::de::Unexpected;
use toml::de::DeValue;

use crate::error::SceneError;
use crate::error::suggest;

use super::place::Lacking;
use super::place::Place;
use super::place::section_of;

/// What went wrong, with its place as soon as that is known.
#[derive(Debug)]
pub(super) struct Fault {
    line: usize,
    path: String,
    section: String,
    is_located: bool,
    kind: Kind,
}

#[derive(Debug)]
enum Kind {
    UnknownKey { key: String, allowed: Vec<String> },
    UnknownName { found: String, allowed: Vec<String> },
    MissingKey { key: String, other: Option<String> },
    WrongType { found: String, expected: String },
    OutOfRange { found: String, expected: String },
    Refused { reason: String },
}

impl Fault {
    fn new(kind: Kind) -> Self {
        Self {
            line: 0,
            path: String::new(),
            section: String::new(),
            is_located: false,
            kind,
        }
    }

    pub(super) fn unknown_key(key: &str, allowed: Vec<String>) -> Self {
        Self::new(Kind::UnknownKey {
            key: key.to_string(),
            allowed,
        })
    }

    pub(super) fn unknown_name(found: &str, allowed: &[&str]) -> Self {
        let allowed = allowed.iter().map(ToString::to_string).collect();
        Self::new(Kind::UnknownName {
            found: found.to_string(),
            allowed,
        })
    }

    pub(super) fn missing_key(key: &str, other: Option<&str>) -> Self {
        Self::new(Kind::MissingKey {
            key: key.to_string(),
            other: other.map(str::to_string),
        })
    }

    pub(super) fn wrong_type(found: String, expected: &str) -> Self {
        Self::new(Kind::WrongType {
            found,
            expected: expected.to_string(),
        })
    }

    pub(super) fn out_of_range(found: String, expected: &str) -> Self {
        Self::new(Kind::OutOfRange {
            found,
            expected: expected.to_string(),
        })
    }

    /// The same error at `place`, unless it was found further inside.
    pub(super) fn located(mut self, place: &Place<'_>) -> Self {
        if !self.is_located {
            self.line = place.line;
            self.path.clone_from(&place.path);
            self.section = section_of(&place.path);
            self.is_located = true;
        }
        self
    }

    /// The key that it says is lacking.
    pub(super) fn lacking(&self) -> Option<Lacking> {
        let Kind::MissingKey { key, .. } = &self.kind else {
            return None;
        };
        Some(Lacking {
            path: self.path.clone(),
            key: key.clone(),
        })
    }

    /// As readers of scenes meet it; `lacking` are all keys that its table lacks, if it says that one is.
    pub(super) fn into_scene_error(self, lacking: Vec<Lacking>) -> SceneError {
        let Self {
            line,
            path,
            section,
            kind,
            ..
        } = self;
        match kind {
            Kind::UnknownKey { key, allowed } => {
                let suggestion = suggest(&key, &allowed);
                SceneError::UnknownKey {
                    line,
                    section,
                    key,
                    suggestion,
                    allowed,
                }
            }
            Kind::UnknownName { found, allowed } => {
                let suggestion = suggest(&found, &allowed);
                SceneError::UnknownName {
                    line,
                    key: path,
                    found,
                    suggestion,
                    allowed,
                }
            }
            Kind::MissingKey { key, other } => SceneError::MissingKey {
                line,
                section,
                also: lacking.into_iter().skip(1).map(|it| it.key).collect(),
                key,
                other,
            },
            Kind::WrongType { found, expected } => SceneError::WrongType {
                line,
                key: path,
                found,
                expected,
            },
            Kind::OutOfRange { found, expected } => SceneError::OutOfRange {
                line,
                key: path,
                found,
                expected,
            },
            Kind::Refused { reason } => SceneError::Refused {
                line,
                key: path,
                reason,
            },
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:?}", self.kind)
    }
}

impl std::error::Error for Fault {}

impl serde::de::Error for Fault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Self::new(Kind::Refused {
            reason: message.to_string(),
        })
    }

    fn invalid_type(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::wrong_type(found.to_string(), &in_scene_words(expected))
    }

    fn invalid_value(found: Unexpected<'_>, expected: &dyn Expected) -> Self {
        Self::out_of_range(found.to_string(), &in_scene_words(expected))
    }

    fn invalid_length(found: usize, expected: &dyn Expected) -> Self {
        Self::wrong_type(
            format!("an array of length {found}"),
            &in_scene_words(expected),
        )
    }

    fn unknown_field(field: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown_key(field, expected.iter().map(ToString::to_string).collect())
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        Self::unknown_name(variant, expected)
    }

    fn missing_field(field: &'static str) -> Self {
        Self::missing_key(field, None)
    }
}

/// Names of Rust types as a writer of scene files would put them.
fn in_scene_words(expected: &dyn Expected) -> String {
    match expected.to_string().as_str() {
        "f64" | "f32" => "a number".to_string(),
        "u32" | "u64" | "usize" => "a whole number from 0 up".to_string(),
        "i32" | "i64" => "a whole number".to_string(),
        "a string" => "a text in quotes".to_string(),
        "a boolean" => "true or false".to_string(),
        other => other.to_string(),
    }
}

/// A value as a message shows it.
pub(super) fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("string \"{text}\""),
        DeValue::Integer(number) => format!("integer {number}"),
        DeValue::Float(number) => format!("number {number}"),
        DeValue::Boolean(flag) => format!("{flag}"),
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "an array".to_string(),
        DeValue::Table(_) => "a table".to_string(),
    }
}
