//! The look: colours, shapes and the style sheet, light and dark.
//!
//! Colours are those of Okabe and Ito (2008), which colour-blind readers can tell apart, darkened
//! on white and lightened on black as far as a line needs to be seen (a contrast of 3). No curve is
//! told by its colour alone: each has a shape, too. Colours stand in the style sheet only, so that
//! the reader's wish for a dark page recolours the plots.

use std::fmt::Write;

/// Colours of curves and classes on white.
pub const LIGHT: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#b8608f", "#b97f00", "#3a94c9", "#8f8600", "#5c5c5c"];

/// The same on black.
pub const DARK: [&str; 8] =
    ["#3d9be0", "#f07b2a", "#1fbf92", "#d98fb8", "#e69f00", "#8acdf2", "#f0e442", "#c9c9c9"];

/// Paper, ink, weak ink, grid, weak grid on white.
pub const LIGHT_PAPER: [&str; 5] = ["#ffffff", "#1b1f24", "#59626d", "#d5dae0", "#eceff2"];

/// The same on black.
pub const DARK_PAPER: [&str; 5] = ["#14171b", "#e7eaee", "#a3adb8", "#39414a", "#252b32"];

/// Letters on a narrow screen, in units of the drawing: everything is laid out for these.
pub const LETTER: f64 = 18.0;

/// Distance of lines of text.
pub const LINE: f64 = 23.0;

/// Width of a letter on the average: 0.51 of its height in DejaVu Sans, one of the widest.
pub const LETTER_WIDTH: f64 = 0.52 * LETTER;

/// Width of a digit there.
pub const DIGIT_WIDTH: f64 = 0.64 * LETTER;

/// Letters of page and plots.
pub const FONT: &str =
    "system-ui,-apple-system,\"Segoe UI\",Roboto,\"DejaVu Sans\",Helvetica,Arial,sans-serif";

/// The style sheet of a plot, for a page or a file of its own.
pub fn style() -> String {
    let mut css = format!(
        ".plot text{{font:12.5px {FONT};fill:currentColor}}\
         .plot .title{{font-weight:600}}\
         .plot .sup{{font-size:75%}}\
         .plot .curve{{fill:none;stroke:currentColor;stroke-width:1.8;stroke-linejoin:round}}\
         .plot .spread{{fill:none;stroke:currentColor;stroke-width:1.3;opacity:.7}}\
         .plot .mark{{fill:currentColor;stroke-width:.8}}\
         .plot .open{{stroke:currentColor;stroke-width:1.8}}\
         .plot .frame,.plot .grid,.plot .minor{{fill:none;stroke-width:1}}\
         .plot .guide{{fill:none;stroke-width:1.6}}\
         .plot .halo{{fill:none;stroke-width:4.5}}\
         .plot .hatch{{fill:none;stroke-width:1.2}}\
         .plot .cell{{shape-rendering:crispEdges}}\
         .plot .over{{pointer-events:none}}"
    );
    for (k, dash) in DASHES.iter().enumerate() {
        // Writing to a string does not fail.
        let _ = write!(css, ".plot .dash{k}{{stroke-dasharray:{dash}}}");
    }
    colours(&mut css, &LIGHT, LIGHT_PAPER);
    css.push_str("@media (prefers-color-scheme:dark){");
    colours(&mut css, &DARK, DARK_PAPER);
    css.push_str(
        "}@media (max-width:640px){.plot text{font-size:18px}.plot .sup{font-size:75%}\
         .plot .mark{transform-box:fill-box;transform-origin:center;transform:scale(1.4)}\
         .plot .curve{stroke-width:2.4}.plot .guide{stroke-width:2.2}}",
    );
    css
}

/// Broken lines of guides.
pub const DASHES: [&str; 4] = ["7 4", "2 3", "9 3 2 3", "14 5"];

fn colours(css: &mut String, curves: &[&str], [paper, ink, weak, grid, minor]: [&str; 5]) {
    let _ = write!(
        css,
        ".plot{{color:{ink};background:{paper}}}\
         .plot .weak{{color:{weak}}}.plot .paper{{fill:{paper}}}\
         .plot .mark{{stroke:{paper}}}.plot .open{{fill:{paper};stroke:currentColor}}\
         .plot .frame{{stroke:{weak}}}.plot .grid{{stroke:{grid}}}.plot .minor{{stroke:{minor}}}\
         .plot .guide{{stroke:{ink}}}.plot .halo{{stroke:{paper}}}.plot .hatch{{stroke:{paper}}}"
    );
    for (k, colour) in curves.iter().enumerate() {
        let _ = write!(css, ".plot .c{k}{{color:{colour}}}.plot .f{k}{{fill:{colour}}}");
    }
}

/// How a measured curve is told from the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Which colour.
    pub colour: usize,
    /// Which shape.
    pub shape: usize,
    /// Whether the mark is hollow.
    pub open: bool,
}

impl Look {
    /// That of the k-th measured curve: the first 128 differ.
    pub fn of(k: usize) -> Self {
        let round = k / LIGHT.len();
        Self { colour: k % 8, shape: (k + round / 2) % 8, open: round % 2 == 1 }
    }

    /// Classes of its mark.
    pub fn classes(self) -> &'static str {
        if self.open { "mark open" } else { "mark" }
    }
}

/// The outline of a mark.
pub fn mark(shape: usize, x: f64, y: f64) -> String {
    let corners: &[(f64, f64)] = match shape {
        0 => return circle(x, y, 4.4),
        1 => &[(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)],
        2 => &[(0.0, -5.4), (5.0, 3.8), (-5.0, 3.8)],
        3 => &[(0.0, -5.8), (5.0, 0.0), (0.0, 5.8), (-5.0, 0.0)],
        4 => &[(0.0, 5.4), (5.0, -3.8), (-5.0, -3.8)],
        5 => &PLUS,
        6 => &CROSS,
        _ => &STAR,
    };
    let mut path = String::new();
    for (k, (dx, dy)) in corners.iter().enumerate() {
        let letter = if k == 0 { 'M' } else { 'L' };
        let _ = write!(path, "{letter}{:.1} {:.1}", x + dx, y + dy);
    }
    path + "Z"
}

fn circle(x: f64, y: f64, radius: f64) -> String {
    let (left, way) = (x - radius, 2.0 * radius);
    format!("M{left:.1} {y:.1}a{radius} {radius} 0 1 0 {way} 0a{radius} {radius} 0 1 0 -{way} 0Z")
}

const PLUS: [(f64, f64); 12] = [
    (-1.8, -5.2),
    (1.8, -5.2),
    (1.8, -1.8),
    (5.2, -1.8),
    (5.2, 1.8),
    (1.8, 1.8),
    (1.8, 5.2),
    (-1.8, 5.2),
    (-1.8, 1.8),
    (-5.2, 1.8),
    (-5.2, -1.8),
    (-1.8, -1.8),
];

const CROSS: [(f64, f64); 12] = [
    (-5.0, -2.6),
    (-2.6, -5.0),
    (0.0, -2.4),
    (2.6, -5.0),
    (5.0, -2.6),
    (2.4, 0.0),
    (5.0, 2.6),
    (2.6, 5.0),
    (0.0, 2.4),
    (-2.6, 5.0),
    (-5.0, 2.6),
    (-2.4, 0.0),
];

const STAR: [(f64, f64); 10] = [
    (0.0, -6.0),
    (1.5, -2.0),
    (5.7, -1.9),
    (2.4, 0.8),
    (3.5, 4.9),
    (0.0, 2.5),
    (-3.5, 4.9),
    (-2.4, 0.8),
    (-5.7, -1.9),
    (-1.5, -2.0),
];

/// The lines of the k-th hatch, in a square of 8 units.
pub fn hatch(k: usize) -> &'static str {
    match k {
        0 => "M-1 9L9 -1M-1 1L1 -1M7 9L9 7",
        1 => "M-1 -1L9 9M-1 7L1 9M7 -1L9 1",
        2 => "M0 4H8",
        3 => "M4 0V8",
        4 => "M-1 9L9 -1M-1 -1L9 9",
        5 => "M3.4 4H4.6",
        _ => "M0 4H8M4 0V8",
    }
}
