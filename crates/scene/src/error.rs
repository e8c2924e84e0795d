//! What can be wrong with a scene, with the line of its file and with what would be right.

use thiserror::Error;

/// Why a scene was refused. Every variant that belongs to a place in the file names its line,
/// counted from 1; 0 stands for a scene that was not read from a file with lines.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum SceneError {
    /// The text is not TOML.
    #[error("line {line}: not valid TOML: {message}")]
    Syntax {
        /// Line of the first character that does not fit.
        line: usize,
        /// What the TOML parser says.
        message: String,
    },
    /// A key that no part of the scene has here.
    #[error("line {line}: unknown key `{key}` in {section}{}; allowed here: {}", did_you_mean(.suggestion.as_ref()), .allowed.join(", "))]
    UnknownKey {
        /// Line of the key.
        line: usize,
        /// Where the key stands, as `[sun]` or `the top level`.
        section: String,
        /// The key that was found.
        key: String,
        /// The allowed key that looks most like it.
        suggestion: Option<String>,
        /// Every key that is allowed at this place.
        allowed: Vec<String>,
    },
    /// A name that is not among the choices.
    #[error("line {line}: `{key}` is \"{found}\"{}; expected one of {}", did_you_mean(.suggestion.as_ref()), .allowed.join(", "))]
    UnknownName {
        /// Line of the value.
        line: usize,
        /// Full path of the key, as `accuracy.preset`.
        key: String,
        /// The name that was found.
        found: String,
        /// The allowed name that looks most like it.
        suggestion: Option<String>,
        /// Every name that is allowed.
        allowed: Vec<String>,
    },
    /// A key that must be there is not.
    #[error("line {line}: {section} lacks `{key}`{}{}", or(.other.as_ref()), and(.also))]
    MissingKey {
        /// Line at which the section begins.
        line: usize,
        /// The section, as `[camera]` or `the top level`.
        section: String,
        /// The key that is missing.
        key: String,
        /// Another that would do in its place.
        other: Option<String>,
        /// What else is missing there.
        also: Vec<String>,
    },
    /// A value of another type than the key wants.
    #[error("line {line}: `{key}` is {found}, expected {expected}")]
    WrongType {
        /// Line of the value.
        line: usize,
        /// Full path of the key.
        key: String,
        /// What stands there.
        found: String,
        /// What the key wants.
        expected: String,
    },
    /// A value of the right type that cannot be meant.
    #[error("{}`{key}` is {found}, expected {expected}", at(*.line))]
    OutOfRange {
        /// Line of the value.
        line: usize,
        /// Full path of the key.
        key: String,
        /// The value.
        found: String,
        /// The allowed range.
        expected: String,
    },
    /// Values that are sound one by one but cannot be meant together.
    #[error("{}`{key}` cannot be used: {reason}", at(*.line))]
    Refused {
        /// Line of the value or of its section.
        line: usize,
        /// Full path of the key.
        key: String,
        /// What was found or expected.
        reason: String,
    },
    /// Drops that cannot be laid out.
    #[error("{}{section}: {message}", at(*.line))]
    Drops {
        /// Line at which the section begins.
        line: usize,
        /// The section, `[drops]`, or one of several, as `drops[1]`.
        section: String,
        /// What the shape says.
        message: String,
    },
    /// Canonical JSON that does not hold a scene.
    #[error("not a scene in canonical JSON: {message}")]
    Json {
        /// What the JSON reader says.
        message: String,
    },
}

impl SceneError {
    /// Line of the scene file, counted from 1; `None` for a scene that has no lines.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::Syntax { line, .. }
            | Self::UnknownKey { line, .. }
            | Self::UnknownName { line, .. }
            | Self::MissingKey { line, .. }
            | Self::WrongType { line, .. }
            | Self::OutOfRange { line, .. }
            | Self::Refused { line, .. }
            | Self::Drops { line, .. } => Some(*line).filter(|line| *line > 0),
            Self::Json { .. } => None,
        }
    }
}

/// The beginning of a message about a line.
fn at(line: usize) -> String {
    if line == 0 {
        String::new()
    } else {
        format!("line {line}: ")
    }
}

fn or(other: Option<&String>) -> String {
    other.map_or_else(String::new, |key| format!(" or `{key}`"))
}

fn and(keys: &[String]) -> String {
    let each = keys.iter().enumerate().map(|(index, key)| {
        let between = if index + 1 == keys.len() { " and" } else { "," };
        format!("{between} `{key}`")
    });
    each.collect()
}

fn did_you_mean(suggestion: Option<&String>) -> String {
    suggestion.map_or_else(String::new, |name| format!(", did you mean `{name}`?"))
}

/// Largest normalized Damerau-Levenshtein distance at which a name is still worth suggesting.
const FARTHEST_SUGGESTION: f64 = 0.5;

/// Shortest beginning of a name that is taken for the name.
const SHORTEST_BEGINNING: usize = 3;

/// The allowed name that looks most like `found`, if any looks like it at all; one that begins so looks
/// more like it than one that ends so.
pub(crate) fn suggest<S: AsRef<str>>(found: &str, allowed: &[S]) -> Option<String> {
    let likeness = |name: &str| {
        let likeness = strsim::normalized_damerau_levenshtein(found, name);
        let is_beginning = found.len() >= SHORTEST_BEGINNING && name.starts_with(found);
        if is_beginning {
            1.0 + likeness
        } else {
            likeness
        }
    };
    allowed
        .iter()
        .map(|name| (likeness(name.as_ref()), name.as_ref()))
        .filter(|(score, _)| *score >= 1.0 - FARTHEST_SUGGESTION)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beginning_is_completed_before_other_likenesses_are_tried() {
        let shapes = ["gradient", "rain-shaft", "rain-cell"];
        assert_eq!(suggest("rain-", &shapes).as_deref(), Some("rain-cell"));
        assert_eq!(suggest("rain-sh", &shapes).as_deref(), Some("rain-shaft"));
        assert_eq!(suggest("gradent", &shapes).as_deref(), Some("gradient"));
        assert_eq!(suggest("xy", &shapes), None);
    }
}
