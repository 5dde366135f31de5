//! Decimal strings as expected values: up to forty digits, more than a double can hold.
//!
//! Where a tolerance is near the rounding of a double, comparing with the rounded expected value
//! would judge that rounding too. A decimal is therefore kept as `hi + lo`, and the difference is
//! taken exactly. Nothing here knows what a number stands for.

use crate::exact::DoubleDouble;

/// Digits of `hi` and of the decimal that are compared to find `lo`.
const DIGITS: usize = 60;

/// The value of a decimal string to about 32 digits; "Infinity", "-Infinity" and "NaN" as well.
pub fn decimal(text: &str) -> Option<DoubleDouble> {
    let hi: f64 = text.trim().parse().ok()?;
    let whole = DoubleDouble { hi, lo: 0.0 };
    if hi == 0.0 || !hi.is_finite() {
        return Some(whole);
    }
    let wanted = Digits::read(text.trim().trim_start_matches(['+', '-']))?;
    let nearest = Digits::read(&format!("{:.*e}", DIGITS, hi.abs()))?;
    let lo = wanted.minus(&nearest);
    Some(DoubleDouble { hi, lo: if hi < 0.0 { -lo } else { lo } })
}

/// `|actual - expected|`; infinite where only one of them is a finite number.
pub fn error(actual: f64, expected: DoubleDouble) -> f64 {
    if actual == expected.hi && expected.lo == 0.0 {
        return 0.0;
    }
    let difference = DoubleDouble::sum(actual, -expected.hi);
    let error = difference.plus(DoubleDouble { hi: -expected.lo, lo: 0.0 }).value().abs();
    if error.is_finite() { error } else { f64::INFINITY }
}

/// A measured value with its standard error: "13.80005(237)" or "5.91473 +- 0.00011".
pub fn with_error(text: &str) -> Option<(f64, f64)> {
    if let Some((value, error)) = text.split_once("+-") {
        return Some((value.trim().parse().ok()?, error.trim().parse().ok()?));
    }
    let (value, rest) = text.split_once('(')?;
    let units: f64 = rest.split(')').next()?.parse().ok()?;
    let decimals = value.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    Some((value.trim().parse().ok()?, units * 10f64.powi(-(decimals as i32))))
}

/// The number that follows `marker` in a text.
pub fn after(text: &str, marker: &str) -> Option<f64> {
    let rest = text.split_once(marker)?.1.trim_start();
    let end = rest.find(|c: char| !c.is_ascii_digit() && !".+-eE".contains(c));
    let mut number = &rest[..end.unwrap_or(rest.len())];
    // A full stop or a dash may end the phrase and not belong to the number.
    while !number.is_empty() && number.parse::<f64>().is_err() {
        number = &number[..number.len() - 1];
    }
    number.parse().ok()
}

/// A positive decimal number `0.d1 d2 d3 ... * 10^exponent`.
struct Digits {
    digits: Vec<i8>,
    exponent: i32,
}

impl Digits {
    fn read(text: &str) -> Option<Self> {
        let (mantissa, exponent) = match text.split_once(['e', 'E']) {
            Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let all = whole.bytes().chain(fraction.bytes());
        let digits: Vec<i8> = all.map(|digit| digit.wrapping_sub(b'0') as i8).collect();
        if digits.iter().any(|digit| !(0..=9).contains(digit)) {
            return None;
        }
        let leading = digits.iter().position(|&digit| digit != 0)?;
        let exponent = exponent.checked_add(whole.len() as i32)?.checked_sub(leading as i32)?;
        Some(Self { digits: digits[leading..].to_vec(), exponent })
    }

    /// The digit of weight `10^place`.
    fn at(&self, place: i32) -> i8 {
        let index = usize::try_from(self.exponent - 1 - place).ok();
        index.and_then(|index| self.digits.get(index)).copied().unwrap_or(0)
    }

    /// `self - other`, rounded.
    fn minus(&self, other: &Self) -> f64 {
        let top = self.exponent.max(other.exponent);
        let places = (0..DIGITS as i32 + 4).map(|k| top - 1 - k);
        let differences: Vec<i8> = places.map(|place| self.at(place) - other.at(place)).collect();
        let first = differences.iter().copied().find(|&difference| difference != 0).unwrap_or(0);
        let mut digits: Vec<i8> = differences.iter().map(|d| d * first.signum()).collect();
        for k in (1..digits.len()).rev() {
            if digits[k] < 0 {
                digits[k] += 10;
                digits[k - 1] -= 1;
            }
        }
        let digits: String = digits.iter().map(|&digit| char::from(b'0' + digit as u8)).collect();
        let size: f64 = format!("0.{digits}e{top}").parse().unwrap_or(0.0);
        f64::from(first.signum()) * size
    }
}
