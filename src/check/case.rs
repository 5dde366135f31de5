//! A case file as a tree whose every value knows its path, so that an error says where.
//!
//! Nothing here knows a kind, and nothing here panics: what a file lacks is a [`Malformed`].

use serde_json::Value;

use super::formula;
use super::number;
use crate::exact::DoubleDouble;

/// What is wrong with a case file, and where in it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Malformed(pub String);

/// What reading gives.
pub type Read<T> = Result<T, Malformed>;

/// A value of the file and its path.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    path: String,
    value: &'a Value,
}

impl<'a> Field<'a> {
    /// The whole file.
    pub fn root(value: &'a Value) -> Self {
        Self { path: String::new(), value }
    }

    /// An error about this value.
    pub fn wrong(&self, what: impl std::fmt::Display) -> Malformed {
        let path = if self.path.is_empty() { "the file" } else { &self.path };
        Malformed(format!("{path}: {what}"))
    }

    /// The member of this name; `None` if it is absent or null.
    pub fn find(&self, key: &str) -> Option<Self> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        let dot = if self.path.is_empty() { "" } else { "." };
        Some(Self { path: format!("{}{dot}{key}", self.path), value })
    }

    /// The member of this name.
    pub fn get(&self, key: &str) -> Read<Self> {
        self.find(key).ok_or_else(|| self.wrong(format_args!("`{key}` is missing")))
    }

    /// The items of a list.
    pub fn items(&self) -> Read<Vec<Self>> {
        let items = self.value.as_array().ok_or_else(|| self.wrong("must be a list"))?;
        let item = |(k, value)| Self { path: format!("{}[{k}]", self.path), value };
        Ok(items.iter().enumerate().map(item).collect())
    }

    /// The item with this index.
    pub fn item(&self, index: usize) -> Read<Self> {
        let item = self.value.get(index);
        let item = item.ok_or_else(|| self.wrong(format_args!("has no item {index}")))?;
        Ok(Self { path: format!("{}[{index}]", self.path), value: item })
    }

    /// The members of an object.
    pub fn entries(&self) -> Read<Vec<(&'a str, Self)>> {
        let members = self.value.as_object().ok_or_else(|| self.wrong("must be an object"))?;
        let member = |(key, value): (&'a String, &'a Value)| {
            (key.as_str(), Self { path: format!("{}.{key}", self.path), value })
        };
        Ok(members.iter().map(member).collect())
    }

    /// The member whose name is this number, however it is written.
    pub fn entry_with_number(&self, number: f64) -> Read<Self> {
        let named = |(key, _): &(&str, Self)| key.parse() == Ok(number);
        let member = self.entries()?.into_iter().find(named);
        let missing = || self.wrong(format_args!("`{number}` is missing"));
        member.map(|(_, field)| field).ok_or_else(missing)
    }

    /// The pairs of this file's `inputs.subcases` and `expected.subcases`, with their labels.
    pub fn subcases(&self) -> Read<Vec<(String, Self, Self)>> {
        let inputs = self.get("inputs")?.get("subcases")?.items()?;
        let expected = self.get("expected")?.get("subcases")?;
        if expected.items()?.len() != inputs.len() {
            return Err(expected.wrong(format_args!("must be {} like the inputs", inputs.len())));
        }
        let pair = |(k, input): (usize, Self)| {
            let expected = expected.item(k)?;
            let label = |field: &Self| field.find("label").map(|label| label.words()).transpose();
            let (ours, theirs) = (label(&input)?, label(&expected)?);
            if let (Some(ours), Some(theirs)) = (ours, theirs)
                && ours != theirs
            {
                return Err(expected.wrong(format_args!("label `{theirs}`, but input `{ours}`")));
            }
            Ok((ours.map_or_else(|| format!("#{k}"), str::to_owned), input, expected))
        };
        inputs.into_iter().enumerate().map(pair).collect()
    }

    /// A text.
    pub fn words(&self) -> Read<&'a str> {
        self.value.as_str().ok_or_else(|| self.wrong("must be a text"))
    }

    /// True or false.
    pub fn flag(&self) -> Read<bool> {
        self.value.as_bool().ok_or_else(|| self.wrong("must be true or false"))
    }

    /// Any double: a JSON number, a decimal string, "NaN" or "Infinity".
    pub fn number(&self) -> Read<f64> {
        self.decimal().map(|decimal| decimal.hi)
    }

    /// The same, to twice the precision.
    pub fn decimal(&self) -> Read<DoubleDouble> {
        let parsed = match self.value {
            Value::Number(number) => number.as_f64().map(|hi| DoubleDouble { hi, lo: 0.0 }),
            Value::String(text) => number::decimal(text),
            _ => None,
        };
        parsed.ok_or_else(|| self.wrong("must be a number"))
    }

    /// A finite number.
    pub fn finite(&self) -> Read<f64> {
        let number = self.number()?;
        if number.is_finite() { Ok(number) } else { Err(self.wrong("must be a finite number")) }
    }

    /// A whole number from 0, at most `most`.
    pub fn count(&self, most: u64) -> Read<u64> {
        let count = self.value.as_u64().filter(|&count| count <= most);
        count.ok_or_else(|| self.wrong(format_args!("must be a whole number from 0 to {most}")))
    }

    /// A number, or a formula in words of which `names` gives the names.
    pub fn formula(&self, names: &[(&str, f64)]) -> Read<f64> {
        match self.value {
            Value::String(text) => formula_in(text, names).map_err(|error| self.wrong(error)),
            _ => self.number(),
        }
    }

    /// The formula that follows `marker` in this text, up to the next `;`.
    pub fn formula_after(&self, marker: &str, names: &[(&str, f64)]) -> Read<f64> {
        let text = self.words()?;
        let rest = text.split_once(marker).map(|(_, rest)| rest);
        let rest = rest.ok_or_else(|| self.wrong(format_args!("does not say `{marker}`")))?;
        formula_in(rest, names).map_err(|error| self.wrong(error))
    }

    /// The formula between two markers in this text.
    pub fn formula_between(&self, start: &str, end: &str) -> Read<f64> {
        let rest = self.words()?.split_once(start).and_then(|(_, rest)| rest.split_once(end));
        let says = || self.wrong(format_args!("does not say `{start} <formula> {end}`"));
        let (formula, _) = rest.ok_or_else(says)?;
        formula_in(formula, &[]).map_err(|error| self.wrong(error))
    }

    /// The number that follows `marker` in this text.
    pub fn number_after(&self, marker: &str) -> Read<f64> {
        let number = number::after(self.words()?, marker);
        number.ok_or_else(|| self.wrong(format_args!("does not say `{marker} <number>`")))
    }
}

fn formula_in(text: &str, names: &[(&str, f64)]) -> Result<f64, String> {
    let end = text.find([';', ',']).unwrap_or(text.len());
    formula::evaluate(&text[..end], names)
}
