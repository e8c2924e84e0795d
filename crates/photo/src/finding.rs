//! What is found to be wrong, doubtful or worth knowing, with a reason and a way out.

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing.
    Info,
    /// Nature would hardly do that.
    Warning,
    /// Nature would not do that.
    Error,
}

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Its name for scripts.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What was found and why it matters.
    pub reason: String,
    /// What to do about it.
    pub suggestion: String,
}

impl Finding {
    /// A finding.
    pub(crate) fn new(
        code: &'static str,
        severity: Severity,
        reason: impl Into<String>,
        suggestion: impl Into<String>,
    ) -> Self {
        Self {
            code,
            severity,
            reason: reason.into(),
            suggestion: suggestion.into(),
        }
    }
}
