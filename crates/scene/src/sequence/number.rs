//! Numbers of a scene, and those between two of them.

use toml::Value;
use toml::de::DeValue;

/// A number, or a list of numbers or lists.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Number {
    /// As it is written, without a point.
    Whole(i64),
    Real(f64),
    Many(Vec<Number>),
}

impl Number {
    /// What is written, where it is a number.
    pub(super) fn written(value: &DeValue) -> Option<Self> {
        match value {
            DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
                .ok()
                .map(Self::Whole),
            DeValue::Float(number) => number.as_str().parse().ok().map(Self::Real),
            DeValue::Array(items) if !items.is_empty() => {
                let numbers = items.iter().map(|item| Self::written(item.get_ref()));
                numbers.collect::<Option<_>>().map(Self::Many)
            }
            DeValue::Array(_)
            | DeValue::String(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Table(_) => None,
        }
    }

    pub(super) fn of(value: &Value) -> Option<Self> {
        match value {
            Value::Integer(number) => Some(Self::Whole(*number)),
            Value::Float(number) if number.is_finite() => Some(Self::Real(*number)),
            Value::Array(items) => {
                let items = items.iter().map(Self::of);
                items.collect::<Option<_>>().map(Self::Many)
            }
            Value::Float(_)
            | Value::String(_)
            | Value::Boolean(_)
            | Value::Datetime(_)
            | Value::Table(_) => None,
        }
    }

    pub(super) fn is_whole(&self) -> bool {
        match self {
            Self::Whole(_) => true,
            Self::Real(_) => false,
            Self::Many(items) => items.iter().all(Self::is_whole),
        }
    }

    pub(super) fn into_real(self) -> Self {
        match self {
            // Coordinates and angles: far below 2^53.
            Self::Whole(number) => Self::Real(number as f64),
            Self::Real(number) => Self::Real(number),
            Self::Many(items) => Self::Many(items.into_iter().map(Self::into_real).collect()),
        }
    }

    pub(super) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Whole(_) | Self::Real(_), Self::Whole(_) | Self::Real(_)) => true,
            (Self::Many(one), Self::Many(other)) => {
                let mut pairs = one.iter().zip(other);
                one.len() == other.len() && pairs.all(|(one, other)| one.is_like(other))
            }
            (Self::Whole(_) | Self::Real(_), Self::Many(_))
            | (Self::Many(_), Self::Whole(_) | Self::Real(_)) => false,
        }
    }

    /// The value `done` of `all` frames on the way to another.
    pub(super) fn mix(&self, other: &Self, (done, all): (u32, u32)) -> Self {
        match (self, other) {
            (Self::Whole(a), Self::Whole(b)) => whole_between((*a, *b), (done, all)),
            (Self::Real(_), Self::Real(_)) => {
                self.mix_real(other, f64::from(done) / f64::from(all))
            }
            (Self::Many(a), Self::Many(b)) => {
                let pairs = a.iter().zip(b);
                Self::Many(pairs.map(|(a, b)| a.mix(b, (done, all))).collect())
            }
            // Of one form, and all whole or none: they were checked.
            (Self::Whole(_), Self::Real(_) | Self::Many(_))
            | (Self::Real(_), Self::Whole(_) | Self::Many(_))
            | (Self::Many(_), Self::Whole(_) | Self::Real(_)) => self.clone(),
        }
    }

    /// The value a part of the way to another.
    pub(super) fn mix_real(&self, other: &Self, part: f64) -> Self {
        match (self.clone().into_real(), other.clone().into_real()) {
            (Self::Real(a), Self::Real(b)) => Self::Real((1.0 - part) * a + part * b),
            (Self::Many(a), Self::Many(b)) => {
                let pairs = a.iter().zip(&b);
                Self::Many(pairs.map(|(a, b)| a.mix_real(b, part)).collect())
            }
            (same, _) => same,
        }
    }

    pub(super) fn to_toml(&self) -> String {
        match self {
            Self::Whole(number) => number.to_string(),
            // The shortest decimals that read back exactly, with a point or an exponent.
            Self::Real(number) => format!("{number:?}"),
            Self::Many(items) => {
                let items: Vec<String> = items.iter().map(Self::to_toml).collect();
                format!("[{}]", items.join(", "))
            }
        }
    }
}

/// Between whole numbers, whole where a whole number lies there: in integers, for a sum of fractions
/// misses 2 by its last digit.
fn whole_between((a, b): (i64, i64), (done, all): (u32, u32)) -> Number {
    let way = (i128::from(b) - i128::from(a)) * i128::from(done);
    let (passed, rest) = (way / i128::from(all), way % i128::from(all));
    match i64::try_from(i128::from(a) + passed) {
        Ok(number) if rest == 0 => Number::Whole(number),
        Ok(_) | Err(_) => Number::Real(a as f64 + way as f64 / f64::from(all)),
    }
}
