//! Fields as the arguments of a command.

use clap::Arg;
use clap::ArgAction;
use clap::builder::PossibleValue;
use clap::builder::PossibleValuesParser;
use serde_json::Value;

use super::field::Field;
use super::field::Kind;
use super::field::Variant;
use crate::flags::numbers;

/// Units by the ending of a key, the longer of two that fit first.
const UNITS: [(&str, &str); 20] = [
    ("_g_m3", "G/M3"),
    ("_m3", "1/M3"),
    ("_m1", "1/M"),
    ("_mm_h", "MM/H"),
    ("_kg_s", "KG/S"),
    ("_m_s", "M/S"),
    ("_1_s", "1/S"),
    ("_per_mm", "1/MM"),
    ("_per_um_gamma", "UM^-GAMMA"),
    ("_deg", "DEG"),
    ("_dbz", "DBZ"),
    ("_hpa", "HPA"),
    ("_dobson", "DU"),
    ("_cm", "CM"),
    ("_um", "UM"),
    ("_mm", "MM"),
    ("_km", "KM"),
    ("_m", "M"),
    ("_s", "S"),
    ("", "NUMBER"),
];

/// The arguments of a struct's fields.
pub(super) fn of_fields(fields: &[Field]) -> Vec<Arg> {
    fields
        .iter()
        .flat_map(|field| of_field(field, field.is_required))
        .collect()
}

/// The arguments of fields that only some command lines need.
fn optional(fields: &[Field]) -> Vec<Arg> {
    fields
        .iter()
        .flat_map(|field| of_field(field, false))
        .collect()
}

fn of_field(field: &Field, is_required: bool) -> Vec<Arg> {
    match &field.kind {
        Kind::Group(inner) => {
            let heading = format!("{} (--{}-…)", field.help, field.flag);
            let under = |arg: Arg| arg.help_heading(heading.clone());
            optional(inner).into_iter().map(under).collect()
        }
        Kind::Choice(variants) => {
            let names = PossibleValuesParser::new(variants.iter().map(described));
            let naming = plain(field, is_required)
                .value_name("NAME")
                .value_parser(names);
            let own = of_variants(&field.flag, variants);
            std::iter::once(naming).chain(own).collect()
        }
        Kind::OneOf(inner) => optional(inner),
        Kind::Number
        | Kind::WholeNumber
        | Kind::Text
        | Kind::Numbers(_)
        | Kind::Name(_)
        | Kind::Names(_) => vec![scalar(field, is_required)],
    }
}

/// The flags of all variants, each once: several size laws have a smallest diameter.
fn of_variants(flag: &str, variants: &[Variant]) -> Vec<Arg> {
    let mut owners: Vec<(Arg, Vec<&str>)> = Vec::new();
    for variant in variants {
        for arg in optional(&variant.flags.fields) {
            let known = owners
                .iter_mut()
                .find(|(known, _)| known.get_id() == arg.get_id());
            match known {
                Some((_, names)) => names.push(&variant.name),
                None => owners.push((arg, vec![&variant.name])),
            }
        }
    }
    let of_owners = |(arg, names): (Arg, Vec<&str>)| {
        let help = arg.get_help().cloned().unwrap_or_default();
        arg.help(format!("{help} [{}]", names.join(", ")))
            .help_heading(format!("For --{flag}"))
    };
    owners.into_iter().map(of_owners).collect()
}

/// The name of a variant; its help ends with its flags, those that may be left out in brackets.
fn described(variant: &Variant) -> PossibleValue {
    let flag = |field: &Field| {
        if field.is_required {
            format!("--{}", field.flag)
        } else {
            format!("[--{}]", field.flag)
        }
    };
    let flags: Vec<String> = variant.flags.fields.iter().map(flag).collect();
    PossibleValue::new(variant.name.clone()).help(format!("{}: {}", variant.about, flags.join(" ")))
}

fn plain(field: &Field, is_required: bool) -> Arg {
    let help = match &field.default {
        Some(value) => format!("{} [default: {}]", field.help, shown(value)),
        None => field.help.clone(),
    };
    let arg = Arg::new(field.flag.clone())
        .help(help)
        .required(is_required && field.default.is_none());
    // The file that a volume is made from is what its command is about: it needs no flag.
    if field.key == "file" {
        arg
    } else {
        arg.long(field.flag.clone())
    }
}

fn scalar(field: &Field, is_required: bool) -> Arg {
    let arg = plain(field, is_required);
    match &field.kind {
        Kind::Numbers(n) => {
            let n = *n;
            // Pairs are horizontal everywhere.
            let axes = if n == 2 { "X,Z" } else { "X,Y,Z" };
            arg.value_name(axes)
                .allow_hyphen_values(true)
                .value_parser(move |text: &str| list(text, n))
        }
        Kind::Name(names) => arg.value_name("NAME").value_parser(possible(names)),
        Kind::Names(names) => arg
            .value_name("NAME,NAME,…")
            .value_delimiter(',')
            .action(ArgAction::Append)
            .value_parser(possible(names)),
        Kind::WholeNumber => arg
            .value_name("NUMBER")
            .value_parser(clap::value_parser!(u32)),
        Kind::Text => arg.value_name(if field.key == "file" { "FILE" } else { "NAME" }),
        Kind::Number | Kind::Group(_) | Kind::Choice(_) | Kind::OneOf(_) => arg
            .value_name(unit(&field.key))
            .allow_negative_numbers(true)
            .value_parser(number),
    }
}

/// Names with what they mean.
pub(super) fn possible(names: &[(String, String)]) -> PossibleValuesParser {
    let value =
        |(name, help): &(String, String)| PossibleValue::new(name.clone()).help(help.clone());
    PossibleValuesParser::new(names.iter().map(value))
}

fn unit(key: &str) -> &'static str {
    let fits = |(ending, _): &&(&str, &str)| key.ends_with(ending);
    UNITS.iter().find(fits).map_or("NUMBER", |(_, unit)| unit)
}

/// A default as it would be typed.
fn shown(value: &Value) -> String {
    match value {
        Value::Array(items) => items.iter().map(shown).collect::<Vec<_>>().join(","),
        Value::Number(number) => number
            .as_f64()
            .map_or_else(String::new, |number| number.to_string()),
        Value::String(text) => text.clone(),
        Value::Null | Value::Bool(_) | Value::Object(_) => value.to_string(),
    }
}

fn number(text: &str) -> Result<f64, String> {
    match list(text, 1)?[..] {
        [value] => Ok(value),
        _ => Err(format!("found {text:?}, expected a number")),
    }
}

fn list(text: &str, n: usize) -> Result<Vec<f64>, String> {
    let values = numbers(text)?;
    if values.len() == n {
        return Ok(values);
    }
    let expected = ["a number", "2 numbers as 1,2", "3 numbers as 1,2,3"][(n - 1).min(2)];
    Err(format!("found {text:?}, expected {expected}"))
}
