//! Data files: every number of an item, one file each.
//!
//! Numbers have 17 digits, so that they come back as the same bits. The heading of a column that
//! depends on the machine ends with `[timed]`: all other columns are the same in every report, and
//! [`untimed`] keeps those alone.

use csv::{Error, ReaderBuilder, Writer};

use super::plot::spread_along_x;
use crate::report::page::{Axis, Item, Map, Plot, Series, Table};

/// How the heading of a timed column ends.
pub const TIMED: &str = " [timed]";

/// The file of an item.
pub fn text(item: &Item) -> String {
    let (head, rows) = match item {
        Item::Plot(plot) => of_plot(plot),
        Item::Map(map) => of_map(map),
        Item::Table(table) => of_table(table),
    };
    // Rows of unequal lengths are the page's, and shown as they are.
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    // Writing to memory does not fail.
    let _ = std::iter::once(head).chain(rows).try_for_each(|row| writer.write_record(row));
    finished(writer)
}

/// The columns of a data file that are the same in every report.
///
/// # Errors
/// The text is no CSV.
pub fn untimed(text: &str) -> Result<String, Error> {
    let mut reader = ReaderBuilder::new().flexible(true).from_reader(text.as_bytes());
    let head = reader.headers()?.clone();
    let kept = |k: usize| head.get(k).is_none_or(|label| !label.ends_with(TIMED));
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    let mut keep = |row: &csv::StringRecord| {
        writer.write_record(row.iter().enumerate().filter(|(k, _)| kept(*k)).map(|(_, cell)| cell))
    };
    keep(&head)?;
    for row in reader.records() {
        keep(&row?)?;
    }
    Ok(finished(writer))
}

fn finished(writer: Writer<Vec<u8>>) -> String {
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

type Rows = (Vec<String>, Vec<Vec<String>>);

fn heading(axis: &Axis) -> String {
    let timed = if axis.timed { TIMED } else { "" };
    format!("{} ({}){timed}", axis.label, if axis.unit.is_empty() { "1" } else { &axis.unit })
}

/// 17 digits.
fn number(value: f64) -> String {
    format!("{value:.16e}")
}

fn of_plot(plot: &Plot) -> Rows {
    let spread = heading(if spread_along_x(plot) { &plot.x } else { &plot.y });
    let spreads = plot.series.iter().flat_map(|series| &series.points);
    let spreads = spreads.filter(|point| point.spread.is_some()).count() > 0;
    let mut head = vec!["series".to_owned(), heading(&plot.x), heading(&plot.y)];
    if spreads {
        head.extend(["least ", "most "].map(|end| format!("{end}{spread}")));
    }
    head.push("note".to_owned());
    let mut rows = Vec::new();
    for series in &plot.series {
        for point in &series.points {
            let mut row = vec![series.label.clone(), number(point.x), number(point.y)];
            if spreads {
                let ends = point.spread.map(|(least, most)| [least, most].map(number));
                row.extend(ends.unwrap_or_default());
            }
            row.push(point.note.clone());
            rows.push(row);
        }
    }
    (head, rows)
}

/// Cells row by row, then the lines over them, whose last column is empty.
fn of_map(map: &Map) -> Rows {
    use crate::report::page::Scale;
    let (meaning, told): (String, &dyn Fn(f64) -> String) = match &map.scale {
        Scale::Continuous(axis) => (heading(axis), &number),
        Scale::Classes(classes) => ("class".to_owned(), &|value| class(classes, value)),
    };
    let head = vec!["part".to_owned(), heading(&map.x), heading(&map.y), meaning];
    let mut rows = Vec::new();
    for (y, values) in map.ys.iter().zip(&map.values) {
        for (x, value) in map.xs.iter().zip(values) {
            rows.push(vec!["cell".to_owned(), number(*x), number(*y), told(*value)]);
        }
    }
    rows.extend(map.lines.iter().flat_map(line));
    (head, rows)
}

fn class(classes: &[String], value: f64) -> String {
    let class = (value >= 0.0).then(|| classes.get(value as usize)).flatten();
    class.cloned().unwrap_or_default()
}

fn line(series: &Series) -> impl Iterator<Item = Vec<String>> {
    let row = |x, y| vec![series.label.clone(), number(x), number(y), String::new()];
    series.points.iter().map(move |point| row(point.x, point.y))
}

fn of_table(table: &Table) -> Rows {
    let timed = |timed| if timed { TIMED } else { "" };
    let columns = table.columns.iter();
    let head = columns.map(|column| format!("{}{}", column.label, timed(column.timed)));
    (head.collect(), table.rows.clone())
}
