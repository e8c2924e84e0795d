//! What was given on the command line, as the JSON of the struct.

use clap::ArgMatches;
use serde_json::Map;
use serde_json::Value;

use super::field::Field;
use super::field::Kind;
use super::field::Variant;
use super::field::flagged;
use crate::failure::Failure;

/// The object of a struct's fields; those not given are left to the struct's own defaults.
pub(super) fn object(fields: &[Field], matches: &ArgMatches) -> Result<Value, Failure> {
    let mut object = Map::new();
    for field in fields {
        // A field that the struct requires has a default only on the command line.
        let usual = field.default.as_ref().filter(|_| field.is_required);
        match given(field, matches)?.or_else(|| usual.cloned()) {
            Some(value) => {
                object.insert(field.key.clone(), value);
            }
            None if field.is_required => {
                return Err(Failure::Usage(format!(
                    "expected --{}: {}",
                    field.flag, field.help
                )));
            }
            None => (),
        }
    }
    Ok(Value::Object(object))
}

fn given(field: &Field, matches: &ArgMatches) -> Result<Option<Value>, Failure> {
    let flag = field.flag.as_str();
    let value = match &field.kind {
        Kind::Number => matches
            .get_one::<f64>(flag)
            .map(|value| Value::from(*value)),
        Kind::WholeNumber => matches
            .get_one::<u32>(flag)
            .map(|value| Value::from(*value)),
        Kind::Text | Kind::Name(_) => {
            let value = matches.get_one::<String>(flag);
            value.map(|value| Value::from(value.as_str()))
        }
        Kind::Names(_) => {
            let names = matches.get_many::<String>(flag);
            names.map(|names| names.map(String::as_str).collect())
        }
        Kind::Numbers(_) => {
            let value = matches.get_one::<Vec<f64>>(flag);
            value.map(|value| Value::from(value.as_slice()))
        }
        Kind::Group(inner) => {
            if flagged(inner).any(|field| matches.contains_id(&field.flag)) {
                Some(object(inner, matches)?)
            } else {
                None
            }
        }
        Kind::Choice(variants) => match matches.get_one::<String>(flag) {
            Some(name) => Some(chosen((flag, name), variants, matches)?),
            None => None,
        },
        Kind::OneOf(inner) => one_of(inner, matches)?,
    };
    Ok(value)
}

/// The variant of that name with its fields; flags of the others may not be given.
fn chosen(
    (flag, name): (&str, &str),
    variants: &[Variant],
    matches: &ArgMatches,
) -> Result<Value, Failure> {
    let mut value = Map::new();
    for variant in variants.iter().filter(|variant| variant.name == name) {
        let own: Vec<&str> = flags(variant).collect();
        let says = format!("--{flag} {name} has --{}", own.join(", --"));
        let foreign = variants
            .iter()
            .flat_map(flags)
            .find(|flag| !own.contains(flag) && matches.contains_id(flag));
        if let Some(foreign) = foreign {
            return Err(Failure::Usage(format!("found --{foreign}, but {says}")));
        }
        let content = object(&variant.flags.fields, matches);
        let content = content.map_err(|failure| Failure::Usage(format!("{failure}; {says}")))?;
        value.insert(name.to_owned(), content);
    }
    Ok(Value::Object(value))
}

fn flags(variant: &Variant) -> impl Iterator<Item = &str> {
    flagged(&variant.flags.fields).map(|field| field.flag.as_str())
}

fn one_of(fields: &[Field], matches: &ArgMatches) -> Result<Option<Value>, Failure> {
    let given: Vec<&Field> = fields
        .iter()
        .filter(|field| matches.contains_id(&field.flag))
        .collect();
    match given[..] {
        [] => Ok(None),
        [field] => object(std::slice::from_ref(field), matches).map(Some),
        [one, other, ..] => Err(Failure::Usage(format!(
            "found --{} and --{}, expected one of them",
            one.flag, other.flag
        ))),
    }
}
