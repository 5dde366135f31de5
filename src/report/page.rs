//! What the report says, as data: sections of plots, maps and tables. Figures make it, `draw` turns
//! it into CSV, SVG and HTML.
//!
//! Numbers that depend on the machine are marked as timed, so that two reports can be compared: all
//! others must be the same bits. Nothing here measures or draws.

/// The whole report.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// What it says of itself.
    pub front: Front,
    /// Where and how it was measured: name and value, as a person reads them.
    pub machine: Vec<(String, String)>,
    /// What was measured, the main plot first.
    pub sections: Vec<Section>,
}

/// What a page says of itself.
#[derive(Clone, Debug)]
pub struct Front {
    /// The command that made it, and the title.
    pub command: &'static str,
    /// What it answers.
    pub lead: String,
    /// Heading of what was measured and how.
    pub facts: &'static str,
    /// What stands there besides.
    pub note: &'static str,
}

impl Default for Front {
    fn default() -> Self {
        Self {
            command: "carom report",
            lead: "How wrong is each method, and what does less error cost?".to_owned(),
            facts: "Machine",
            note: "Run times and columns marked timed are of this machine at that moment; all \
                   other numbers are the same bits in every report.",
        }
    }
}

/// One question and its answer.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// A word for file names and links, lower case, unique.
    pub name: &'static str,
    /// As a heading.
    pub title: String,
    /// What is shown, how it was measured, what it says; plain text, a paragraph each. The last one
    /// names what was left out and why, where something was.
    pub text: Vec<String>,
    /// Plots, maps and tables in their order.
    pub items: Vec<Item>,
}

/// What a section shows.
#[derive(Clone, Debug)]
pub enum Item {
    /// Curves.
    Plot(Plot),
    /// Colours in a plane.
    Map(Map),
    /// Rows.
    Table(Table),
}

impl Item {
    /// Its name, title and caption.
    pub fn texts(&self) -> (&str, &str, &str) {
        match self {
            Self::Plot(Plot { name, title, caption, .. })
            | Self::Map(Map { name, title, caption, .. })
            | Self::Table(Table { name, title, caption, .. }) => (name, title, caption),
        }
    }

    /// Its name, to be changed.
    pub fn name_mut(&mut self) -> &mut String {
        match self {
            Self::Plot(Plot { name, .. })
            | Self::Map(Map { name, .. })
            | Self::Table(Table { name, .. }) => name,
        }
    }
}

/// An axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// What it is, such as `run time of a simulated second`.
    pub label: String,
    /// Its unit, such as `ms`; `1` for ratios.
    pub unit: String,
    /// Whether decades are equally long; then all values are above 0.
    pub log: bool,
    /// Whether its values are run times, which no two runs share.
    pub timed: bool,
}

/// Curves over a common plane.
#[derive(Clone, Debug)]
pub struct Plot {
    /// A word for file names, lower case with underscores, unique in the report.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// How to read it; repeats, scene, seed.
    pub caption: String,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// The curves, most important first.
    pub series: Vec<Series>,
}

/// One curve.
#[derive(Clone, Debug)]
pub struct Series {
    /// For the legend.
    pub label: String,
    /// How it is drawn.
    pub kind: Kind,
    /// In the order in which they are joined.
    pub points: Vec<Point>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Marks joined by a line: measured.
    Curve,
    /// Marks alone: measured.
    Marks,
    /// A thin broken line without marks: a theory, a slope, a bound.
    Guide,
}

/// One measured value.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Abscissa (median of the repeats if timed).
    pub x: f64,
    /// Ordinate (median of the repeats if timed).
    pub y: f64,
    /// Least and largest of the repeats along the timed axis, if one is.
    pub spread: Option<(f64, f64)>,
    /// What distinguishes it on its curve, such as `1/240 s`; may be empty.
    pub note: String,
}

/// Colours in a plane.
#[derive(Clone, Debug)]
pub struct Map {
    /// As of a plot.
    pub name: String,
    /// As of a plot.
    pub title: String,
    /// As of a plot.
    pub caption: String,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// Centres of the columns.
    pub xs: Vec<f64>,
    /// Centres of the rows.
    pub ys: Vec<f64>,
    /// What the colours mean.
    pub scale: Scale,
    /// Row by row, as long as `ys`, each as long as `xs`; NaN = nothing there. Of classes: their
    /// number.
    pub values: Vec<Vec<f64>>,
    /// Drawn over it, such as a theoretical boundary.
    pub lines: Vec<Series>,
}

/// What colours mean.
#[derive(Clone, Debug)]
pub enum Scale {
    /// A number on this axis.
    Continuous(Axis),
    /// One of these.
    Classes(Vec<String>),
}

/// Rows under headings.
#[derive(Clone, Debug)]
pub struct Table {
    /// As of a plot.
    pub name: String,
    /// As of a plot.
    pub title: String,
    /// As of a plot.
    pub caption: String,
    /// The headings.
    pub columns: Vec<Column>,
    /// As long as the columns each.
    pub rows: Vec<Vec<String>>,
}

/// A heading.
#[derive(Clone, Debug)]
pub struct Column {
    /// With its unit, such as `time (ms)`.
    pub label: String,
    /// Whether it stands to the right, as numbers do.
    pub number: bool,
    /// Whether it depends on the machine.
    pub timed: bool,
}
