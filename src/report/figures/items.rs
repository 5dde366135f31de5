//! Short ways to write down axes, columns and numbers of a section. Nothing here measures.

use super::timing::Timing;
use crate::report::page::{Axis, Column, Kind, Point, Series};

/// An axis of decades.
pub fn decades(label: &str, unit: &str) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), log: true, timed: false }
}

/// An axis of decades of run time.
pub fn timed(label: &str, unit: &str) -> Axis {
    Axis { timed: true, ..decades(label, unit) }
}

/// A column of words.
pub fn words(label: &str) -> Column {
    Column { label: label.to_owned(), number: false, timed: false }
}

/// A column of numbers that are the same in every report.
pub fn numbers(label: &str) -> Column {
    Column { number: true, ..words(label) }
}

/// A column of run times.
pub fn times(label: &str) -> Column {
    Column { timed: true, ..numbers(label) }
}

/// A point with a run time of `count` things, in ns each, as abscissa.
pub fn against_time(timing: &Timing, count: usize, y: f64, note: &str) -> Point {
    let each = |seconds: f64| 1e9 * seconds / count as f64;
    let spread = Some((each(timing.least_s), each(timing.most_s)));
    Point { x: each(timing.median_s), y, spread, note: note.to_owned() }
}

/// A point without a run time.
pub fn point(x: f64, y: f64) -> Point {
    Point { x, y, spread: None, note: String::new() }
}

/// A theory or a bound, drawn through these points.
pub fn guide(label: &str, points: Vec<Point>) -> Series {
    Series { label: label.to_owned(), kind: Kind::Guide, points }
}

/// A number to about three digits.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        size if !size.is_finite() => "no number".to_owned(),
        size if (0.01..1e4).contains(&size) => {
            let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => format!("{x:.1e}"),
    }
}
