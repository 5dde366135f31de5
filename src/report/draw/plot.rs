//! Plots: curves with marks, spreads and guides.
//!
//! What has no place on the axes (infinite, not a number, negative on a logarithmic axis) is not
//! drawn, breaks its curve and is counted below the plot. Nothing here measures.

use maud::{Markup, html};

use super::look::{self, Look};
use super::scale::Scale;
use super::svg::{Area, Drawing, Sample, c};
use super::text::value;
use crate::report::page::{Axis, Kind, Plot, Point, Series};

/// The plot as SVG; `alone` in a file of its own.
pub fn draw(plot: &Plot, alone: bool) -> String {
    let mut drawing = Drawing::new(&plot.name, &plot.title, &plot.caption, alone);
    let along_x = spread_along_x(plot);
    let (x, y) = (scale(plot, along_x, true), scale(plot, !along_x, false));
    let area = drawing.area((&plot.x, x), (&plot.y, y));
    let samples = samples(&plot.series);
    let curves = html! {
        @for guide in [true, false] {
            // The most important last, so above the others.
            @for (series, sample) in plot.series.iter().zip(&samples).rev() {
                @if (series.kind == Kind::Guide) == guide {
                    (curve(plot, series, *sample, &area))
                }
            }
        }
    };
    drawing.add_clipped(&area, &curves);
    let entries: Vec<_> = samples.iter().copied().zip(labels(&plot.series)).collect();
    drawing.legend(&entries);
    let all = || plot.series.iter().flat_map(|series| &series.points);
    let lost = all().filter(|point| area.at(point.x, point.y).is_none()).count();
    if lost > 0 {
        let text = format!("{lost} of {} points have no place here: see the CSV", all().count());
        drawing.lines(&text, "weak");
    }
    drawing.finish()
}

/// Whether spreads belong to the abscissa.
pub fn spread_along_x(plot: &Plot) -> bool {
    plot.x.timed
}

fn scale(plot: &Plot, spread: bool, x: bool) -> Scale {
    let axis = if x { &plot.x } else { &plot.y };
    let values = plot.series.iter().flat_map(|series| &series.points).flat_map(|point| {
        let own = if x { point.x } else { point.y };
        let (least, most) = point.spread.filter(|_| spread).unwrap_or((own, own));
        // Zero has a place of its own only as a value.
        let positive = |end: f64| if end == 0.0 { own } else { end };
        [own, positive(least), positive(most)]
    });
    Scale::around(axis, values)
}

/// How each series looks: measured ones and guides are counted apart.
pub fn samples(series: &[Series]) -> Vec<Sample> {
    let (mut measured, mut guides) = (0, 0);
    let next = |counter: &mut usize| {
        *counter += 1;
        *counter - 1
    };
    let sample = |series: &Series| match series.kind {
        Kind::Curve => Sample::Curve(Look::of(next(&mut measured))),
        Kind::Marks => Sample::Marks(Look::of(next(&mut measured))),
        Kind::Guide => Sample::Guide(next(&mut guides)),
    };
    series.iter().map(sample).collect()
}

/// For the legend.
pub fn labels(series: &[Series]) -> impl Iterator<Item = &str> {
    series.iter().map(|series| series.label.as_str())
}

fn curve(plot: &Plot, series: &Series, sample: Sample, area: &Area) -> Markup {
    match sample {
        Sample::Curve(look) => measured(plot, series, look, true, area),
        Sample::Marks(look) => measured(plot, series, look, false, area),
        Sample::Guide(k) => guide(series, k, area),
        Sample::Line | Sample::Class(_) => html! {},
    }
}

/// A broken line, on paper of its own where it lies over something.
pub fn guide(series: &Series, k: usize, area: &Area) -> Markup {
    html! { path class={ "guide dash" (k % look::DASHES.len()) } d=(line(&series.points, area)) {} }
}

/// The points joined, as far as they have a place.
pub fn line(points: &[Point], area: &Area) -> String {
    let mut path = String::new();
    let mut joined = false;
    for point in points {
        let Some((x, y)) = area.at(point.x, point.y) else {
            joined = false;
            continue;
        };
        path.push_str(&format!("{}{} {}", if joined { 'L' } else { 'M' }, c(x), c(y)));
        joined = true;
    }
    path
}

fn measured(plot: &Plot, series: &Series, look: Look, joined: bool, area: &Area) -> Markup {
    let bars: String = series.points.iter().filter_map(|point| bar(plot, point, area)).collect();
    html! {
        g class={ "c" (look.colour) } {
            @if joined { path class="curve over" d=(line(&series.points, area)) {} }
            @if !bars.is_empty() { path class="spread" d=(bars) {} }
            @for point in &series.points {
                @if let Some((x, y)) = area.at(point.x, point.y) {
                    path class=(look.classes()) d=(look::mark(look.shape, x, y)) {
                        title { (told(plot, series, point)) }
                    }
                }
            }
        }
    }
}

/// From the least to the largest of the repeats, with an end at each.
fn bar(plot: &Plot, point: &Point, area: &Area) -> Option<String> {
    let (least, most) = point.spread?;
    if spread_along_x(plot) {
        let (from, y) = area.at(least, point.y)?;
        let (to, _) = area.at(most, point.y)?;
        let (from, to, y) = (c(from), c(to), y);
        let end = c(y - 3.5);
        Some(format!("M{from} {end}v7M{to} {end}v7M{from} {y:.1}H{to}"))
    } else {
        let (x, from) = area.at(point.x, least)?;
        let (_, to) = area.at(point.x, most)?;
        let (from, to, x) = (c(from), c(to), x);
        let end = c(x - 3.5);
        Some(format!("M{end} {from}h7M{end} {to}h7M{x:.1} {from}V{to}"))
    }
}

/// What a mark says when it is pointed at.
fn told(plot: &Plot, series: &Series, point: &Point) -> String {
    let mut text = series.label.clone();
    if !point.note.is_empty() {
        text = format!("{text}, {}", point.note);
    }
    let mut say = |axis: &Axis, number: f64, spread: Option<(f64, f64)>| {
        text.push_str(&format!("\n{}: {}", axis.label, value(axis, number)));
        if let Some((least, most)) = spread {
            text.push_str(&format!(" ({} to {})", value(axis, least), value(axis, most)));
        }
    };
    let along_x = spread_along_x(plot);
    say(&plot.x, point.x, point.spread.filter(|_| along_x));
    say(&plot.y, point.y, point.spread.filter(|_| !along_x));
    text
}
