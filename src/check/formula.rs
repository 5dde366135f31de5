//! Tolerances as the files state them: short formulas such as `4u*s/|v_n|` or `8u*t + 2^-k`.
//!
//! `u` is 2^-53; what the other names stand for is for each kind to say. Numbers, names, `|name|`,
//! `+ - * / ^`, brackets, `sqrt`; a product needs no sign. No other syntax, and nothing here knows
//! physics.

use crate::exact::UNIT_ROUNDOFF;

/// Longest formula read: it bounds the depth of the brackets.
const LONGEST: usize = 200;

/// The value of a formula, with the names in it.
///
/// # Errors
/// What is wrong, in words.
pub fn evaluate(text: &str, names: &[(&str, f64)]) -> Result<f64, String> {
    if text.len() > LONGEST {
        return Err(format!("formula longer than {LONGEST} bytes"));
    }
    let mut parser = Parser { rest: text.trim(), names };
    let value = parser.sum();
    match value {
        Ok(value) if parser.rest.is_empty() => Ok(value),
        Ok(_) => Err(format!("formula `{text}`: cannot read `{}`", parser.rest)),
        Err(error) => Err(format!("formula `{text}`: {error}")),
    }
}

struct Parser<'a> {
    rest: &'a str,
    names: &'a [(&'a str, f64)],
}

impl<'a> Parser<'a> {
    fn sum(&mut self) -> Result<f64, String> {
        let mut value = self.product()?;
        loop {
            if self.take("+") {
                value += self.product()?;
            } else if self.take("-") {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut value = self.power()?;
        loop {
            if self.take("*") {
                value *= self.power()?;
            } else if self.take("/") {
                value /= self.power()?;
            } else if self.rest.starts_with(|c: char| c.is_alphanumeric() || "(|".contains(c)) {
                value *= self.power()?;
            } else {
                return Ok(value);
            }
        }
    }

    fn power(&mut self) -> Result<f64, String> {
        if self.take("-") {
            return Ok(-self.power()?);
        }
        let base = self.atom()?;
        if self.take("^") { Ok(base.powf(self.power()?)) } else { Ok(base) }
    }

    fn atom(&mut self) -> Result<f64, String> {
        if self.take("(") {
            let value = self.sum()?;
            return if self.take(")") { Ok(value) } else { Err("a `)` is missing".to_owned()) };
        }
        if self.rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            return self.number();
        }
        let name = self.name();
        match name {
            "sqrt" => Ok(self.atom()?.sqrt()),
            "u" => Ok(UNIT_ROUNDOFF),
            _ => {
                let known = self.names.iter().find(|(known, _)| *known == name);
                known.map(|(_, value)| *value).ok_or_else(|| format!("unknown name `{name}`"))
            }
        }
    }

    fn number(&mut self) -> Result<f64, String> {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if bytes.get(end).is_some_and(|b| b.eq_ignore_ascii_case(&b'e')) {
            let sign = usize::from(bytes.get(end + 1).is_some_and(|b| b"+-".contains(b)));
            let exponent = bytes.get(end + 1 + sign).map_or(0, |_| digits(end + 1 + sign));
            end += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let (number, rest) = self.rest.split_at(end);
        self.rest = rest.trim_start();
        number.parse().map_err(|_| format!("`{number}` is not a number"))
    }

    /// A word, or a word between bars.
    fn name(&mut self) -> &'a str {
        let rest = self.rest;
        let bar = usize::from(rest.starts_with('|'));
        let word = rest[bar..].find(|c: char| !c.is_alphanumeric() && c != '_');
        let end = word.map_or(rest.len(), |end| end + bar);
        let closing = usize::from(bar == 1 && rest[end..].starts_with('|'));
        let (name, rest) = rest.split_at(end + closing);
        self.rest = rest.trim_start();
        name
    }

    fn take(&mut self, sign: &str) -> bool {
        let Some(rest) = self.rest.strip_prefix(sign) else { return false };
        self.rest = rest.trim_start();
        true
    }
}
