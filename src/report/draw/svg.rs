//! A drawing: title, plotting area, axes and legend as SVG, one below the other.
//!
//! It scales with its view box and is laid out for a phone, on which letters are larger in relation
//! to it. Colours are classes of the style sheet ([`super::look`]). The legend has its own room
//! below; nothing ever stands over the data.

use maud::{Markup, PreEscaped, html};

use super::look::{self, DIGIT_WIDTH, LETTER, LETTER_WIDTH, LINE, Look};
use super::scale::{Label, Scale, Tick};
use super::text::{clean, with_unit, wrapped};
use crate::report::page::Axis;

/// Width of every drawing, in its own units.
pub const WIDTH: f64 = 600.0;

/// Height of the plotting area.
const AREA_HEIGHT: f64 = 340.0;

/// Room for a sample in the legend.
const SAMPLE: f64 = 42.0;

/// A drawing that grows downwards.
pub struct Drawing {
    name: String,
    title: String,
    description: String,
    alone: bool,
    parts: Vec<Markup>,
    /// How far down it goes.
    pub height: f64,
}

/// Where the data are.
#[derive(Clone, Debug)]
pub struct Area {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    x: Scale,
    y: Scale,
}

/// How a line of the legend looks.
#[derive(Clone, Copy, Debug)]
pub enum Sample {
    /// A mark on a line.
    Curve(Look),
    /// A mark.
    Marks(Look),
    /// The k-th broken line.
    Guide(usize),
    /// A line without marks.
    Line,
    /// The k-th class of a map.
    Class(usize),
}

impl Area {
    /// Where a point lies; `None` where it has no place.
    pub fn at(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        // Far outside is as good as farther.
        let near = |place: f64| place.clamp(-20.0, 20.0);
        let (x, y) = (near(self.x.place(x)?), near(self.y.place(y)?));
        Some((self.left + x * self.width, self.top + (1.0 - y) * self.height))
    }
}

/// A coordinate as it is written.
pub fn c(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

impl Drawing {
    /// An empty one; `alone` in a file of its own, with its title and style.
    pub fn new(name: &str, title: &str, description: &str, alone: bool) -> Self {
        let [name, title, description] = [name, title, description].map(str::to_owned);
        let mut new = Self { name, title, description, alone, parts: Vec::new(), height: 4.0 };
        if alone {
            let title = new.title.clone();
            new.lines(&title, "title");
            new.height += 6.0;
        }
        new
    }

    /// Adds what was drawn somewhere.
    pub fn add(&mut self, part: Markup) {
        self.parts.push(part);
    }

    /// Adds lines of text.
    pub fn lines(&mut self, text: &str, class: &str) {
        // Titles are bold, so wider.
        for line in wrapped(text, (WIDTH / (1.15 * LETTER_WIDTH)) as usize) {
            let y = c(self.height + LETTER);
            self.add(html! { text class=(class) x="4" y=(y) { (line) } });
            self.height += LINE;
        }
    }

    /// Adds axes and grid, and says where the data belong.
    pub fn area(&mut self, (x_axis, x): (&Axis, Scale), (y_axis, y): (&Axis, Scale)) -> Area {
        self.lines(&with_unit(y_axis), "label");
        let y_ticks = y.ticks(8);
        let digits = y_ticks.iter().filter_map(|tick| tick.label.as_ref()).map(Label::digits);
        let left = (DIGIT_WIDTH * digits.fold(1.0, f64::max) + 11.0).clamp(40.0, 200.0);
        let top = self.height + 0.5 * LINE;
        let width = WIDTH - left - 30.0;
        let area = Area { left, top, width, height: AREA_HEIGHT, x, y };
        let x_ticks = x.ticks(if x_axis.log { 7 } else { 5 });
        self.parts.push(grid(&area, &x_ticks, &y_ticks));
        self.height = top + AREA_HEIGHT + LINE + 2.0;
        self.parts.push(numbers(&area, &x_ticks, &y_ticks));
        for line in wrapped(&with_unit(x_axis), (WIDTH / LETTER_WIDTH) as usize) {
            let middle = c(left + 0.5 * width);
            let middle = if line.chars().count() > 40 { c(0.5 * WIDTH) } else { middle };
            let y = c(self.height + LETTER);
            self.add(html! { text x=(middle) y=(y) text-anchor="middle" { (line) } });
            self.height += LINE;
        }
        self.height += 8.0;
        area
    }

    /// Adds what must not leave the area.
    pub fn add_clipped(&mut self, area: &Area, part: &Markup) {
        let id = format!("{}-clip", self.name);
        let Area { left, top, width, height, .. } = area;
        self.add(html! {
            clipPath id=(id) {
                rect x=(c(*left)) y=(c(*top)) width=(c(*width)) height=(c(*height)) {}
            }
            g clip-path={ "url(#" (id) ")" } { (part) }
        });
    }

    /// Adds the legend, in as many columns as its texts allow.
    pub fn legend(&mut self, entries: &[(Sample, &str)]) {
        let letters = ((WIDTH - SAMPLE - 8.0) / LETTER_WIDTH) as usize;
        let wrapped: Vec<_> = entries.iter().map(|(_, text)| wrapped(text, letters)).collect();
        let longest = wrapped.iter().flatten().map(|line| line.chars().count()).max().unwrap_or(0);
        let wide = SAMPLE + LETTER_WIDTH * longest as f64 + 10.0;
        let columns = ((WIDTH / wide) as usize).clamp(1, 3).min(entries.len().max(1));
        let rows = entries.len().div_ceil(columns);
        let (top, mut bottom) = (self.height, self.height);
        for (k, ((sample, _), lines)) in entries.iter().zip(&wrapped).enumerate() {
            if k % rows == 0 {
                self.height = top;
            }
            let x = WIDTH / columns as f64 * (k / rows) as f64 + 4.0;
            let part = self.sample(*sample, x, self.height + 0.5 * LINE);
            self.add(part);
            for line in lines {
                let (x, y) = (c(x + SAMPLE), c(self.height + 0.5 * LINE));
                self.add(html! { text x=(x) y=(y) dy=".35em" { (line) } });
                self.height += LINE;
            }
            bottom = self.height.max(bottom);
        }
        self.height = bottom;
    }

    fn sample(&self, sample: Sample, x: f64, y: f64) -> Markup {
        let line = format!("M{} {}h32", c(x), c(y));
        match sample {
            Sample::Curve(look) | Sample::Marks(look) => html! {
                g class={ "c" (look.colour) } {
                    @if matches!(sample, Sample::Curve(_)) { path class="curve" d=(line) {} }
                    path class=(look.classes()) d=(look::mark(look.shape, x + 16.0, y)) {}
                }
            },
            Sample::Guide(k) => html! { path class={ "guide dash" (k % 4) } d=(line) {} },
            Sample::Line => html! { path class="guide" d=(line) {} },
            Sample::Class(k) => {
                let box_ = format!("M{} {}h28v16h-28Z", c(x + 2.0), c(y - 8.0));
                html! {
                    path class={ "f" (k % 8) } d=(box_) {}
                    @if k % 8 > 0 { path fill={ "url(#" (self.hatch(k)) ")" } d=(box_) {} }
                }
            }
        }
    }

    /// The name of the hatch of a class; classes 0, 8, ... have none.
    pub fn hatch(&self, class: usize) -> String {
        format!("{}-hatch{}", self.name, class % 8)
    }

    /// Adds the hatches of so many classes.
    pub fn hatches(&mut self, classes: usize) {
        let which = 1..classes.clamp(1, 8);
        let part = html! {
            defs {
                @for k in which {
                    pattern id=(self.hatch(k)) patternUnits="userSpaceOnUse" width="8" height="8" {
                        path class="hatch" d=(look::hatch(k - 1)) {}
                    }
                }
            }
        };
        self.add(part);
    }

    /// The drawing as a text.
    pub fn finish(self) -> String {
        let [title, description] = ["title", "text"].map(|end| format!("{}-{end}", self.name));
        let height = c(self.height + 6.0);
        let pixels = self.alone.then(|| c(1.3 * WIDTH));
        let markup = html! {
            svg xmlns="http://www.w3.org/2000/svg" class="plot" width=[pixels]
                viewBox={ "0 0 " (WIDTH) " " (height) }
                role="img" aria-labelledby={ (title) " " (description) } {
                title id=(title) { (self.title) }
                desc id=(description) { (self.description) }
                @if self.alone {
                    style { (PreEscaped(look::style())) }
                    rect class="paper" width="100%" height="100%" {}
                }
                @for part in &self.parts { (part) }
            }
        };
        clean(markup.into_string())
    }
}

fn grid(area: &Area, x_ticks: &[Tick], y_ticks: &[Tick]) -> Markup {
    let Area { left, top, width, height, .. } = area;
    let upright = |t: &Tick| format!("M{} {}v{}", c(left + t.place * width), c(*top), c(*height));
    let level =
        |t: &Tick| format!("M{} {}h{}", c(*left), c(top + (1.0 - t.place) * height), c(*width));
    let path = |labelled: bool| -> String {
        let wanted = |tick: &&Tick| tick.label.is_some() == labelled;
        let uprights = x_ticks.iter().filter(wanted).map(upright);
        uprights.chain(y_ticks.iter().filter(wanted).map(level)).collect()
    };
    let strips: String = [
        area.x.zero_strip().map(|at| format!("M{} {}v{height}", c(left + at * width), c(*top))),
        area.y
            .zero_strip()
            .map(|at| format!("M{} {}h{}", c(*left), c(top + (1.0 - at) * height), c(*width))),
    ]
    .into_iter()
    .flatten()
    .collect();
    html! {
        path class="minor" d=(path(false)) {}
        path class="grid" d=(path(true)) {}
        @if !strips.is_empty() { path class="frame" stroke-dasharray="2 4" d=(strips) {} }
        rect class="frame" x=(c(*left)) y=(c(*top)) width=(c(*width)) height=(c(*height)) {}
    }
}

/// The numbers at the ticks.
fn numbers(area: &Area, x_ticks: &[Tick], y_ticks: &[Tick]) -> Markup {
    let Area { left, top, width, height, .. } = area;
    let labelled = |tick: &Tick| tick.label.clone().map(|label| (tick.place, label));
    html! {
        @for (place, label) in x_ticks.iter().filter_map(labelled) {
            text x=(c(left + place * width)) y=(c(top + height + LETTER + 3.0))
                text-anchor="middle" { (set(&label)) }
        }
        @for (place, label) in y_ticks.iter().filter_map(labelled) {
            text x=(c(left - 7.0)) y=(c(top + (1.0 - place) * height)) dy=".35em"
                text-anchor="end" { (set(&label)) }
        }
    }
}

/// A number with its exponent above the line.
pub fn set(label: &Label) -> Markup {
    html! {
        (label.base)
        @if let Some(exponent) = &label.exponent {
            tspan class="sup" dy="-.5em" { (exponent) }
        }
    }
}
