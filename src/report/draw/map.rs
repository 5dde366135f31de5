//! Maps: a colour for every cell of a plane, with its scale or classes, and lines over it.
//!
//! Numbers have the colours of cividis, which is as even for colour-blind readers as for others;
//! classes have a hatch besides. A number beyond the scale has the colour of the nearer end, none
//! (NaN) leaves the paper bare. Rows that are too short are bare at their ends.

use maud::{Markup, html};

use super::plot::{guide, labels, line, samples};
use super::scale::Scale;
use super::svg::{Area, Drawing, Sample, c, set};
use super::text::{value, with_unit};
use crate::report::page::{Axis, Map, Scale as Meaning};

/// Cells that can be pointed at one by one; of more the page would be too heavy.
const POINTED_MAX: usize = 3000;

/// How much a cell reaches under its neighbours, so that no seam shows where pixels are rounded.
const UNDER: f64 = 0.6;

/// Colours of the bar.
const BAR_STEPS: usize = 60;

/// The map as SVG; `alone` in a file of its own.
pub fn draw(map: &Map, alone: bool) -> String {
    let mut drawing = Drawing::new(&map.name, &map.title, &map.caption, alone);
    let (x_edges, y_edges) = (edges(&map.x, &map.xs), edges(&map.y, &map.ys));
    let (x, y) = (scale(&map.x, &x_edges), scale(&map.y, &y_edges));
    let area = drawing.area((&map.x, x), (&map.y, y));
    let cells = cells(map, &area, &x_edges, &y_edges);
    let colours = match &map.scale {
        Meaning::Continuous(axis) => numbers(map, axis, &cells),
        Meaning::Classes(classes) => {
            drawing.hatches(classes.len());
            kinds(map, classes, &cells, &drawing)
        }
    };
    let samples = samples(&map.lines);
    let content = html! {
        (colours)
        @for (series, sample) in map.lines.iter().zip(&samples) {
            path class="halo over" d=(line(&series.points, &area)) {}
            @if let Sample::Guide(k) = sample { (guide(series, *k, &area)) }
            @else { path class="guide over" d=(line(&series.points, &area)) {} }
        }
    };
    drawing.add_clipped(&area, &content);
    let solid = |sample: &Sample| match sample {
        Sample::Guide(k) => Sample::Guide(*k),
        _ => Sample::Line,
    };
    let mut entries: Vec<_> = samples.iter().map(solid).zip(labels(&map.lines)).collect();
    match &map.scale {
        Meaning::Continuous(axis) => bar(&mut drawing, axis, &area, range(map, axis)),
        Meaning::Classes(classes) => {
            let classes = classes.iter().enumerate();
            let classes = classes.map(|(k, label)| (Sample::Class(k), label.as_str()));
            entries = classes.chain(entries).collect();
        }
    }
    drawing.legend(&entries);
    drawing.finish()
}

/// A cell: its outline, its number and what it says.
struct Cell {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
    value: f64,
    place: String,
}

/// Ends of the cells around the centres: in the middle between two of them.
fn edges(axis: &Axis, centres: &[f64]) -> Vec<f64> {
    let log = axis.log && centres.iter().all(|centre| *centre > 0.0);
    let to = |x: f64| if log { x.ln() } else { x };
    let from = |x: f64| if log { x.exp() } else { x };
    let centres: Vec<f64> = centres.iter().map(|x| to(*x)).collect();
    let [first, .., last] = centres[..] else {
        let Some(only) = centres.first() else { return Vec::new() };
        let half = if log || *only == 0.0 { 1.0 } else { 0.1 * only.abs() };
        return vec![from(only - half), from(only + half)];
    };
    let n = centres.len();
    let ends = |end: f64, next: f64| end - 0.5 * (next - end);
    let mut edges = vec![ends(first, centres[1])];
    edges.extend(centres.windows(2).map(|pair| 0.5 * pair[0] + 0.5 * pair[1]));
    edges.push(ends(last, centres[n - 2]));
    edges.into_iter().map(from).collect()
}

fn scale(axis: &Axis, edges: &[f64]) -> Scale {
    let finite = || edges.iter().copied().filter(|edge| edge.is_finite());
    Scale::over(axis, finite().fold(f64::INFINITY, f64::min), finite().fold(f64::MIN, f64::max))
}

fn cells(map: &Map, area: &Area, x_edges: &[f64], y_edges: &[f64]) -> Vec<Cell> {
    let mut cells = Vec::new();
    let rows = map.values.iter().zip(&map.ys).zip(y_edges.windows(2));
    for ((row, y), y_ends) in rows {
        for ((value, x), x_ends) in row.iter().zip(&map.xs).zip(x_edges.windows(2)) {
            let corners = (area.at(x_ends[0], y_ends[0]), area.at(x_ends[1], y_ends[1]));
            let (Some(one), Some(other)) = corners else { continue };
            if value.is_nan() {
                continue;
            }
            cells.push(Cell {
                left: one.0.min(other.0),
                top: one.1.min(other.1),
                right: one.0.max(other.0) + UNDER,
                bottom: one.1.max(other.1) + UNDER,
                value: *value,
                place: format!("{}\n{}", named(&map.x, *x), named(&map.y, *y)),
            });
        }
    }
    cells
}

fn named(axis: &Axis, number: f64) -> String {
    format!("{}: {}", axis.label, value(axis, number))
}

/// Least and largest number that has a place.
fn range(map: &Map, axis: &Axis) -> Scale {
    let placed = |value: &&f64| value.is_finite() && (!axis.log || **value > 0.0);
    let placed = || map.values.iter().flatten().filter(placed).copied();
    Scale::over(axis, placed().fold(f64::INFINITY, f64::min), placed().fold(f64::MIN, f64::max))
}

/// The colour of a place on the scale.
fn colour(place: f64) -> String {
    let colour = colorous::CIVIDIS.eval_continuous(place.clamp(0.0, 1.0));
    format!("#{colour:x}")
}

fn numbers(map: &Map, axis: &Axis, cells: &[Cell]) -> Markup {
    let scale = range(map, axis);
    let end = |value: f64| if value > 0.0 && value.is_infinite() { 1.0 } else { 0.0 };
    let place = |value: f64| scale.place(value).unwrap_or_else(|| end(value));
    html! {
        @for cell in cells {
            rect class="cell" fill=(colour(place(cell.value))) x=(c(cell.left)) y=(c(cell.top))
                width=(c(cell.right - cell.left)) height=(c(cell.bottom - cell.top)) {
                @if cells.len() <= POINTED_MAX {
                    title { (cell.place) "\n" (named(axis, cell.value)) }
                }
            }
        }
    }
}

fn kinds(map: &Map, classes: &[String], cells: &[Cell], drawing: &Drawing) -> Markup {
    let class = |cell: &Cell| (cell.value >= 0.0).then_some(cell.value as usize);
    let outline = |cell: &Cell| {
        let Cell { left, top, right, bottom, .. } = cell;
        format!("M{} {}H{}V{}H{}Z", c(*left), c(*top), c(*right), c(*bottom), c(*left))
    };
    let of = |k: usize| cells.iter().filter(move |cell| class(cell) == Some(k));
    let told = |k: usize, cell: &Cell| format!("{}\n{}", classes[k], cell.place);
    html! {
        @for k in 0..classes.len() {
            @if map.values.iter().map(Vec::len).sum::<usize>() <= POINTED_MAX {
                @for cell in of(k) {
                    path class={ "cell f" (k % 8) } d=(outline(cell)) { title { (told(k, cell)) } }
                }
            } @else {
                path class={ "cell f" (k % 8) } d=(of(k).map(outline).collect::<String>()) {}
            }
            @if k % 8 > 0 {
                path class="over" fill={ "url(#" (drawing.hatch(k)) ")" }
                    d=(of(k).map(outline).collect::<String>()) {}
            }
        }
    }
}

/// The colours with their numbers, below the map.
fn bar(drawing: &mut Drawing, axis: &Axis, area: &Area, scale: Scale) {
    drawing.height += 4.0;
    drawing.lines(&with_unit(axis), "label");
    let (left, top, width) = (area.left, drawing.height + 6.0, area.width);
    let step = width / BAR_STEPS as f64;
    let ticks = scale.ticks(5);
    let labelled = ticks.iter().filter_map(|tick| Some((tick.place, tick.label.as_ref()?)));
    drawing.add(html! {
        @for k in 0..BAR_STEPS {
            rect class="cell" fill=(colour((k as f64 + 0.5) / BAR_STEPS as f64))
                x=(c(left + k as f64 * step)) y=(c(top)) width=(c(step + UNDER)) height="14" {}
        }
        @for (place, label) in labelled {
            path class="frame" d={ "M" (c(left + place * width)) " " (c(top + 14.0)) "v5" } {}
            text x=(c(left + place * width)) y=(c(top + 38.0)) text-anchor="middle" { (set(label)) }
        }
    });
    drawing.height = top + 48.0;
}
