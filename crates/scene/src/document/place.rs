//! Where keys stand in a document.

use crate::error::SceneError;

use super::fault::Fault;
/// Path of `key` below `path`.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_string()
    } else {
        format!("{path}.{key}")
    }
}

/// A key that a table lacks.
#[derive(Debug)]
pub(super) struct Lacking {
    /// Path of the table.
    pub(super) path: String,
    pub(super) key: String,
}

/// Where the lines of the text begin, and which keys of a table are read as if they stood there.
pub(super) struct Source {
    line_starts: Vec<usize>,
    stand_ins: Vec<Lacking>,
}

impl Source {
    pub(super) fn new(text: &str) -> Self {
        let after_breaks = text.match_indices('\n').map(|(offset, _)| offset + 1);
        Self {
            line_starts: std::iter::once(0).chain(after_breaks).collect(),
            stand_ins: Vec::new(),
        }
    }

    /// Read a key from now on as if it stood in its table; false if it is of another table than those before, or one of them.
    pub(super) fn stand_in_for(&mut self, lacking: Lacking) -> bool {
        let is_another = |it: &Lacking| it.path == lacking.path && it.key != lacking.key;
        let is_wanted = self.stand_ins.iter().all(is_another);
        if is_wanted {
            self.stand_ins.push(lacking);
        }
        is_wanted
    }

    /// The keys that are read so.
    pub(super) fn into_stand_ins(self) -> Vec<Lacking> {
        self.stand_ins
    }

    /// Those of them that the table at a path should have.
    pub(super) fn lacking(&self, path: &str) -> impl Iterator<Item = &str> {
        let in_table = self.stand_ins.iter().filter(move |it| it.path == path);
        in_table.map(|it| it.key.as_str())
    }

    /// Line, from 1, that holds the byte at `offset`.
    pub(super) fn line(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|&start| start <= offset)
    }

    pub(super) fn syntax_error(&self, error: &toml::de::Error) -> SceneError {
        let offset = error.span().map_or(0, |span| span.start);
        SceneError::Syntax {
            line: self.line(offset),
            message: error.message().replace('\n', "; "),
        }
    }
}

/// A place in the document, to be named in messages.
#[derive(Clone)]
pub(super) struct Place<'a> {
    pub(super) source: &'a Source,
    pub(super) path: String,
    pub(super) line: usize,
}

/// A section as a reader would call it: `[sun]`, or one of a list, as `drops[1]`.
pub(crate) fn section_of(path: &str) -> String {
    if path.is_empty() {
        "the top level".to_string()
    } else if path.ends_with(']') {
        path.to_string()
    } else {
        format!("[{path}]")
    }
}

impl Place<'_> {
    /// Gives an error that does not know its place yet this one.
    pub(super) fn locate<T>(&self, result: Result<T, Fault>) -> Result<T, Fault> {
        result.map_err(|fault| fault.located(self))
    }
}
