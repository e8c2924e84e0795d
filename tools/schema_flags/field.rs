//! A struct as flags: what stands between its schema and the command line.

use serde_json::Value;

/// The fields of a struct as flags.
#[derive(Clone, Debug)]
pub(crate) struct Flags {
    pub(super) fields: Vec<Field>,
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
pub(super) struct Field {
    pub(super) key: String,
    pub(super) flag: String,
    pub(super) help: String,
    pub(super) is_required: bool,
    pub(super) default: Option<Value>,
    pub(super) kind: Kind,
}

/// What a field holds.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    Number,
    WholeNumber,
    Text,
    /// A list of so many numbers.
    Numbers(usize),
    /// One of some names, each with what it means.
    Name(Vec<(String, String)>),
    /// Some of such names.
    Names(Vec<(String, String)>),
    /// A struct.
    Group(Vec<Field>),
    /// One of some structs.
    Choice(Vec<Variant>),
    /// One of some plain numbers.
    OneOf(Vec<Field>),
}

/// The fields that have a flag of their own, at any depth.
pub(super) fn flagged(fields: &[Field]) -> Box<dyn Iterator<Item = &Field> + '_> {
    Box::new(fields.iter().flat_map(|field| match &field.kind {
        Kind::Group(inner) | Kind::OneOf(inner) => flagged(inner),
        Kind::Choice(variants) => {
            let inner = variants
                .iter()
                .flat_map(|variant| flagged(&variant.flags.fields));
            Box::new(std::iter::once(field).chain(inner))
        }
        Kind::Number
        | Kind::WholeNumber
        | Kind::Text
        | Kind::Numbers(_)
        | Kind::Name(_)
        | Kind::Names(_) => Box::new(std::iter::once(field)),
    }))
}
