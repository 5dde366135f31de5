//! Text in drawings: numbers for people, lines that fit, and what may stand in a file.
//!
//! SVG breaks no lines, and this crate knows no fonts: widths are those of a wide letter.

use crate::report::page::Axis;

/// An axis with its unit; ratios have none.
pub fn with_unit(axis: &Axis) -> String {
    match axis.unit.as_str() {
        "" | "1" => axis.label.clone(),
        unit => format!("{} ({unit})", axis.label),
    }
}

/// A value with its unit.
pub fn value(axis: &Axis, value: f64) -> String {
    match axis.unit.as_str() {
        "" | "1" => short(value),
        unit => format!("{} {unit}", short(value)),
    }
}

/// Four digits.
pub fn short(value: f64) -> String {
    let text = if value == 0.0 || !value.is_finite() {
        return value.to_string();
    } else if (1e-3..1e5).contains(&value.abs()) {
        let decimals = (3 - value.abs().log10().floor() as i32).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        return format!("{value:.3e}");
    };
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Lines of at most so many letters, broken between words where that is possible.
pub fn wrapped(text: &str, letters: usize) -> Vec<String> {
    let letters = letters.max(4);
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        for piece in pieces(word, letters) {
            let used = lines.last().map_or(0, |line| line.chars().count());
            let wide = piece.chars().count();
            match lines.last_mut() {
                Some(line) if used == 0 => line.push_str(&piece),
                Some(line) if used + 1 + wide <= letters => {
                    line.push(' ');
                    line.push_str(&piece);
                }
                _ => lines.push(piece),
            }
        }
    }
    lines
}

fn pieces(word: &str, letters: usize) -> Vec<String> {
    let all: Vec<char> = word.chars().collect();
    all.chunks(letters).map(|piece| piece.iter().collect()).collect()
}

/// Without what no XML file may contain.
pub fn clean(mut text: String) -> String {
    let allowed = |c: char| !c.is_control() || matches!(c, '\n' | '\t');
    text.retain(|c| allowed(c) && c != '\u{fffe}' && c != '\u{ffff}');
    text
}
