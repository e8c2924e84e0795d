//! The radius of drops as a formula of what a file holds: `6 + 0.5*sqrt(age)`.
//!
//! sum     = product { (+|-) product }
//! product = factor { (*|/) factor }
//! factor  = - factor | atom [ ^ factor ]
//! atom    = number | name | function ( sum { , sum } ) | ( sum )
//!
//! So -2^2 is -4 and 2^3^2 is 2^9, as in mathematics and Python. A name is that of a grid, in braces where it is no word
//! (`{age of drops}`). Functions are `sqrt`, `exp`, `ln`, `abs`, `min` and `max`. A formula has [`MAX_BYTES`] at most,
//! which bounds how deep it is; it becomes a list of steps, one for each number, name and operator.
//!
//! Why not a crate: `exmex` 0.21 refuses `max(2, min(a, 7))`, has -2^2 = 4 and (2^3)^2, and its messages name addresses
//! in memory, but no column; `fasteval` has not been kept up since 2020; `evalexpr` is under AGPL since its version 12.

use crate::Error;

/// Longest formula, bytes.
const MAX_BYTES: usize = 200;

/// A formula, understood.
#[derive(Clone, Debug)]
pub(crate) struct RadiusFormula {
    text: String,
    /// What it does, one after the other, to a pile of numbers.
    steps: Vec<Step>,
    names: Vec<Name>,
}

/// A name that a formula uses.
#[derive(Clone, Debug)]
struct Name {
    name: String,
    column: usize,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Number(f64),
    /// The value of the name at this place among the names.
    Name(usize),
    Of1(fn(f64) -> f64),
    Of2(fn(f64, f64) -> f64),
}

/// Functions by their names.
const FUNCTIONS: [(&str, Step); 6] = [
    ("sqrt", Step::Of1(f64::sqrt)),
    ("exp", Step::Of1(f64::exp)),
    ("ln", Step::Of1(f64::ln)),
    ("abs", Step::Of1(f64::abs)),
    ("min", Step::Of2(f64::min)),
    ("max", Step::Of2(f64::max)),
];

impl RadiusFormula {
    /// Understands a formula.
    ///
    /// # Errors
    /// [`Error::BadFormula`], with the column where it stops to make sense.
    pub(crate) fn parse(text: &str) -> Result<Self, Error> {
        let mut reader = Reader {
            text,
            at: 0,
            steps: Vec::new(),
            names: Vec::new(),
        };
        if text.len() > MAX_BYTES {
            reader.at = MAX_BYTES;
            return Err(reader.refused("the end: 200 bytes at most"));
        }
        reader.sum()?;
        if reader.next().is_some() {
            return Err(reader.refused("an operator or the end"));
        }
        Ok(Self {
            text: text.to_owned(),
            steps: reader.steps,
            names: reader.names,
        })
    }

    /// The names that it uses, in the order of the values that it wants.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(|it| it.name.as_str())
    }

    /// What it comes to for values of its names.
    pub(crate) fn value(&self, values: &[f64]) -> f64 {
        let mut pile = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            let value = match step {
                Step::Number(number) => *number,
                Step::Name(place) => values.get(*place).copied().unwrap_or(f64::NAN),
                Step::Of1(function) => pile.pop().map_or(f64::NAN, function),
                Step::Of2(function) => {
                    let (right, left) = (pile.pop(), pile.pop());
                    left.zip(right).map_or(f64::NAN, |(a, b)| function(a, b))
                }
            };
            pile.push(value);
        }
        pile.pop().unwrap_or(f64::NAN)
    }

    /// Refuses a name that no grid has.
    pub(crate) fn unknown(&self, name: &str, grids: Vec<String>) -> Error {
        let column = self.names.iter().find(|it| it.name == name);
        Error::UnknownName {
            formula: self.text.clone(),
            column: column.map_or(1, |it| it.column),
            name: name.to_owned(),
            grids,
        }
    }
}

/// A formula that is read.
struct Reader<'a> {
    text: &'a str,
    /// The byte where it stands.
    at: usize,
    steps: Vec<Step>,
    names: Vec<Name>,
}

impl<'a> Reader<'a> {
    fn sum(&mut self) -> Result<(), Error> {
        self.product()?;
        while let Some(sign) = self.take_one_of("+-") {
            self.product()?;
            self.steps.push(Step::Of2(match sign {
                '+' => |a, b| a + b,
                _ => |a, b| a - b,
            }));
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), Error> {
        self.factor()?;
        while let Some(sign) = self.take_one_of("*/") {
            self.factor()?;
            self.steps.push(Step::Of2(match sign {
                '*' => |a, b| a * b,
                _ => |a, b| a / b,
            }));
        }
        Ok(())
    }

    fn factor(&mut self) -> Result<(), Error> {
        if self.take_one_of("-").is_some() {
            self.factor()?;
            self.steps.push(Step::Of1(|value| -value));
            return Ok(());
        }
        self.atom()?;
        if self.take_one_of("^").is_some() {
            self.factor()?;
            self.steps.push(Step::Of2(f64::powf));
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), Error> {
        const EXPECTED: &str = "a number, the name of a grid, a function or (";
        match self.next() {
            Some('(') => {
                self.at += 1;
                self.sum()?;
                self.must_take(")", "an operator or )")
            }
            Some('{') => {
                let (column, inside) = (self.column(), &self.rest()[1..]);
                let Some(end) = inside.find('}') else {
                    self.at = self.text.len();
                    return Err(self.refused("}"));
                };
                self.at += end + 2;
                self.name(&inside[..end], column);
                Ok(())
            }
            Some(first) if first.is_ascii_digit() || first == '.' => self.number(),
            Some(first) if first.is_alphabetic() || first == '_' => {
                let column = self.column();
                let is_word = |it: char| it.is_alphanumeric() || it == '_';
                let word = self.take_while(|_, it| is_word(it));
                let function = FUNCTIONS.into_iter().find(|(name, _)| *name == word);
                if let Some((_, function)) = function {
                    return self.function(function);
                }
                self.name(word, column);
                Ok(())
            }
            Some(_) | None => Err(self.refused(EXPECTED)),
        }
    }

    fn number(&mut self) -> Result<(), Error> {
        let start = self.at;
        let digits = self.take_while(|before, it| {
            let is_sign = matches!(it, '+' | '-') && matches!(before, Some('e' | 'E'));
            is_sign || it.is_ascii_digit() || matches!(it, '.' | 'e' | 'E')
        });
        let Ok(number) = digits.parse() else {
            self.at = start;
            return Err(self.refused("a number"));
        };
        self.steps.push(Step::Number(number));
        Ok(())
    }

    fn function(&mut self, function: Step) -> Result<(), Error> {
        self.must_take("(", "( behind the name of a function")?;
        self.sum()?;
        if matches!(function, Step::Of2(_)) {
            self.must_take(",", "an operator or a second value behind a comma")?;
            self.sum()?;
        }
        self.must_take(")", "an operator or )")?;
        self.steps.push(function);
        Ok(())
    }

    fn name(&mut self, name: &str, column: usize) {
        let known = self.names.iter().position(|it| it.name == name);
        let place = known.unwrap_or(self.names.len());
        if known.is_none() {
            let name = name.to_owned();
            self.names.push(Name { name, column });
        }
        self.steps.push(Step::Name(place));
    }

    /// The next character that is no space, before which it stands then.
    fn next(&mut self) -> Option<char> {
        self.take_while(|_, it| it.is_whitespace());
        self.rest().chars().next()
    }

    fn take_one_of(&mut self, wanted: &str) -> Option<char> {
        let found = self.next().filter(|it| wanted.contains(*it))?;
        self.at += found.len_utf8();
        Some(found)
    }

    fn must_take(&mut self, wanted: &str, expected: &str) -> Result<(), Error> {
        let taken = self.take_one_of(wanted);
        taken.map(|_| ()).ok_or_else(|| self.refused(expected))
    }

    /// What fits, by each character and the one before it.
    fn take_while(&mut self, fits: impl Fn(Option<char>, char) -> bool) -> &'a str {
        let (rest, mut before) = (self.rest(), None);
        let is_end = |(_, it): &(usize, char)| {
            let ends = !fits(before, *it);
            before = Some(*it);
            ends
        };
        let end = rest
            .char_indices()
            .find(is_end)
            .map_or(rest.len(), |it| it.0);
        self.at += end;
        &rest[..end]
    }

    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }

    /// Where it stands, from 1.
    fn column(&self) -> usize {
        let before = self.text.char_indices().take_while(|(at, _)| *at < self.at);
        before.count() + 1
    }

    fn refused(&self, expected: &str) -> Error {
        Error::BadFormula {
            formula: self.text.to_owned(),
            column: self.column(),
            found: match self.rest().chars().next() {
                Some(found) => format!("{found:?}"),
                None => "the end".to_owned(),
            },
            expected: expected.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(text: &str) -> usize {
        match RadiusFormula::parse(text).unwrap_err() {
            Error::BadFormula { column, .. } => column,
            other => panic!("{other}"),
        }
    }

    #[test]
    fn formulas_are_what_they_say() {
        for (text, expected) in [
            ("12.5", 12.5),
            (" 6 + 0.5*sqrt(age) ", 6.0 + 0.5 * 3.0),
            ("max(2, min(age, 7)) ^ 2", 49.0),
            ("{drop age} * -1", -9.0),
            ("exp(-age/9)", f64::exp(-1.0)),
            ("-2^2", -4.0),
            ("2^3^2", 512.0),
            ("2^-1", 0.5),
            ("1 - 2 - 3", -4.0),
            ("8/4/2", 1.0),
            ("1 + 2*3", 7.0),
            ("(1 + 2)*3", 9.0),
            ("1.5e-1 + 2E2", 200.15),
            ("abs(ln(exp(-2)))", 2.0),
            ("größe", 9.0),
        ] {
            let formula = RadiusFormula::parse(text).unwrap();
            let values = vec![9.0; formula.names().count()];
            assert!((formula.value(&values) - expected).abs() < 1e-12, "{text}");
        }
        let formula = RadiusFormula::parse("temperature - age + temperature").unwrap();
        let names: Vec<&str> = formula.names().collect();
        assert_eq!(names, ["temperature", "age"]);
        assert!((formula.value(&[2.0, 1.0]) - 3.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_formula_is_refused_at_its_column() {
        for (text, expected) in [
            ("6 + * age", 5),
            ("6 + age)", 8),
            ("sqrt(age", 9),
            ("sqrt age", 6),
            ("max(age)", 8),
            ("sqrt(age, 2)", 9),
            ("6 $ age", 3),
            ("6 +", 4),
            ("", 1),
            ("{age", 5),
            ("1.2.3", 1),
            ("größe $", 7),
            ("2 age", 3),
        ] {
            assert_eq!(column(text), expected, "{text:?}");
        }
        assert_eq!(column(&"1+".repeat(101)), MAX_BYTES + 1);
        let error = RadiusFormula::parse("6 + * age").unwrap_err();
        let expected = "the formula `6 + * age` has '*' at column 5, expected a number, the name of a grid, a function \
                        or (";
        assert_eq!(error.to_string(), expected);
    }

    #[test]
    fn no_text_ends_the_program() {
        // Without a pattern, of the characters of formulas.
        const CHARACTERS: [&str; 18] = [
            "0", "9", ".", "e", "+", "-", "*", "/", "^", "(", ")", ",", "{", "}", " ", "age",
            "max(", "ß",
        ];
        let mut state = 7_u64;
        let mut next = |n: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state % n as u64) as usize
        };
        let mut n_sound = 0;
        for _ in 0..100_000 {
            let length = next(16);
            let text: String = (0..length)
                .map(|_| CHARACTERS[next(CHARACTERS.len())])
                .collect();
            if let Ok(formula) = RadiusFormula::parse(&text) {
                let values = vec![1.0; formula.names().count()];
                let _ = formula.value(&values);
                n_sound += 1;
            }
        }
        assert!(n_sound > 1000, "{n_sound}");
        for deep in ["(", "-", "sqrt(", "{", "1^", "max(1,"] {
            let _ = RadiusFormula::parse(&deep.repeat(MAX_BYTES / deep.len()));
        }
    }
}
