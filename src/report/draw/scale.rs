//! Scales: where a value lies along an axis, and which ticks a reader needs.
//!
//! A logarithmic axis has decades as ticks. An error may be exactly zero, which is what an exact
//! method is for: then the axis ends in a strip of its own for it. No value makes a scale fail:
//! what cannot be placed (infinite, not a number, negative where decades are equally long) has no
//! place.

use crate::report::page::Axis;

/// Part of a logarithmic axis that belongs to zero, where there is one.
const ZERO_STRIP: f64 = 0.09;

/// Part of the range that is left free at each end.
const PAD: f64 = 0.04;

/// What a straight axis still can place: sums and differences of these are finite.
const LARGEST: f64 = 1e300;

/// What a straight axis takes for zero: steps between its ticks are still normal numbers.
const LEAST: f64 = 1e-280;

/// A straight axis shows no less than this part of its values: more digits fit no label.
const FINEST: f64 = 1e-9;

/// From values to places, 0 to 1, along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    log: bool,
    zero: bool,
    low: f64,
    high: f64,
}

/// A line across the plot, with its number where it has one.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Along the axis, 0 to 1.
    pub place: f64,
    /// What stands beside it; `None` = a light line only.
    pub label: Option<Label>,
}

/// A number as it is set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Label {
    /// On the line.
    pub base: String,
    /// Above the line, of powers of ten.
    pub exponent: Option<String>,
}

impl Label {
    fn plain(base: String) -> Self {
        Self { base: base.replace('-', "\u{2212}"), exponent: None }
    }

    fn power(factor: &str, exponent: i32) -> Self {
        let exponent = exponent.to_string().replace('-', "\u{2212}");
        Self { base: format!("{factor}10").replace('-', "\u{2212}"), exponent: Some(exponent) }
    }

    /// Width, in widths of a digit.
    pub fn digits(&self) -> f64 {
        let wide = |c: char| if c.is_ascii_digit() { 1.0 } else { 1.3 };
        let width = |text: &str| text.chars().map(wide).sum::<f64>();
        width(&self.base) + 0.75 * self.exponent.as_deref().map_or(0.0, width)
    }
}

impl Scale {
    /// A scale that shows all of the values that can be shown, with some room at its ends.
    pub fn around(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high, mut zero) = (f64::INFINITY, f64::NEG_INFINITY, false);
        for value in values {
            zero |= axis.log && value == 0.0;
            if let Some(value) = transformed(axis.log, value) {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        let mut scale = Self::between(axis.log, low, high);
        let pad = PAD * (scale.high - scale.low);
        scale.zero = zero;
        scale.low -= if zero { 0.0 } else { pad };
        scale.high += pad;
        scale
    }

    /// A scale from one value to another.
    pub fn over(axis: &Axis, low: f64, high: f64) -> Self {
        let end = |value, otherwise| transformed(axis.log, value).unwrap_or(otherwise);
        Self::between(axis.log, end(low, 0.0), end(high, 1.0))
    }

    /// Never empty: no values give 0 to 1, one value gives some room around it.
    fn between(log: bool, low: f64, high: f64) -> Self {
        let (mut low, mut high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let magnitude = low.abs().max(high.abs());
        let least = match (log, magnitude > 0.0) {
            (true, _) => 1.0,
            (false, true) => FINEST * magnitude,
            (false, false) => 1.0,
        };
        if high - low < least {
            let half = if log { 0.5 } else { (0.1 * magnitude).max(0.5 * least) };
            let middle = 0.5 * low + 0.5 * high;
            (low, high) = (middle - half, middle + half);
        }
        Self { log, zero: false, low, high }
    }

    /// Where a value lies, 0 at the low end; `None` where it has no place.
    pub fn place(&self, value: f64) -> Option<f64> {
        if self.log && value == 0.0 {
            return self.zero.then_some(0.3 * ZERO_STRIP);
        }
        Some(self.along(transformed(self.log, value)?))
    }

    /// Where the strip of the zero ends, if there is one.
    pub fn zero_strip(&self) -> Option<f64> {
        self.zero.then_some(0.7 * ZERO_STRIP)
    }

    fn along(&self, transformed: f64) -> f64 {
        let start = if self.zero { ZERO_STRIP } else { 0.0 };
        start + (1.0 - start) * (transformed - self.low) / (self.high - self.low)
    }

    /// The ticks, at most about `room` of them with a label.
    pub fn ticks(&self, room: usize) -> Vec<Tick> {
        let room = room.max(2);
        let mut ticks = if self.log { self.decades(room as i32) } else { self.steps(room) };
        if self.zero {
            let label = Some(Label::plain("0".to_owned()));
            ticks.insert(0, Tick { place: 0.3 * ZERO_STRIP, label });
        }
        ticks
    }

    fn decades(&self, room: i32) -> Vec<Tick> {
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let span = self.high - self.low;
        let strides = [1, 2, 3, 4, 5, 10, 20, 50, 100, 200, 500];
        let fits = |stride: &&i32| span <= f64::from(**stride * room);
        let stride = *strides.iter().find(fits).unwrap_or(&1000);
        let mut ticks = Vec::new();
        for decade in first..=last {
            let label = (decade % stride == 0).then(|| Label::power("", decade));
            ticks.push((f64::from(decade), label));
            // Between decades only where there is room.
            for factor in 2..=9 {
                let labelled = span <= 2.0 && (factor == 2 || factor == 5);
                let label = labelled.then(|| Label::power(&format!("{factor}\u{d7}"), decade));
                if span <= 5.0 {
                    ticks.push((f64::from(decade) + f64::from(factor).log10(), label));
                }
            }
        }
        let inside = |place: f64| (self.low - 1e-9..=self.high + 1e-9).contains(&place);
        ticks.retain(|(place, _)| inside(*place));
        ticks.into_iter().map(|(at, label)| Tick { place: self.along(at), label }).collect()
    }

    fn steps(&self, room: usize) -> Vec<Tick> {
        let rough = (self.high - self.low) / room as f64;
        let exponent = rough.log10().floor() as i32;
        let unit = 10_f64.powi(exponent);
        let fits = |factor: &&f64| **factor * unit >= rough * (1.0 - 1e-9);
        let step = unit * [1.0, 2.0, 5.0].iter().find(fits).unwrap_or(&10.0);
        let first = (self.low / step - 1e-9).ceil();
        let last = (self.high / step + 1e-9).floor();
        let count = (last - first).clamp(0.0, 100.0) as usize;
        let tick = |k: usize| {
            let value = (first + k as f64) * step;
            Tick { place: self.along(value), label: Some(number(value, step)) }
        };
        (0..=count).map(tick).collect()
    }
}

/// As it is placed; `None` if it has no place.
fn transformed(log: bool, value: f64) -> Option<f64> {
    if log {
        (value > 0.0 && value.is_finite()).then(|| value.log10())
    } else {
        let value = if value.abs() < LEAST { 0.0 } else { value };
        (value.abs() <= LARGEST).then_some(value)
    }
}

/// A multiple of a step with the digits that it needs.
fn number(value: f64, step: f64) -> Label {
    let below = step.abs().log10().floor() as i32;
    if value.abs() < 0.5 * step {
        return Label::plain("0".to_owned());
    }
    if (-4..=5).contains(&below) && value.abs() < 1e6 {
        let decimals = (-below).max(0) as usize;
        return Label::plain(format!("{value:.decimals$}"));
    }
    let exponent = value.abs().log10().floor() as i32;
    let decimals = (exponent - below).clamp(0, 12) as usize;
    let text = format!("{value:.decimals$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    Label::power(&format!("{mantissa}\u{d7}"), exponent.parse().unwrap_or(0))
}
