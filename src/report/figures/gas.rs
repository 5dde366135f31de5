//! The main plot: one second of a thousand discs, error against run time, for every method.
//!
//! Every method starts from the same melted gas. What is measured is how far each disc is from
//! where it truly is at the end, and how long the second took. The conclusion is made from the
//! numbers, whatever they are.

#[cfg(feature = "peers")]
mod peers;
mod runs;
mod scene;
mod words;

pub use runs::{Ended, Row, Who, ended, judge, movers, repeats, rows};
pub use scene::{Stretch, melted};
pub use words::conclusion;
#[cfg(feature = "peers")]
pub use words::not_beaten;

use super::items::{against_time, decades, guide, numbers, point, short, timed, times, words};
use crate::report::page::{Item, Kind, Plot, Point, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};

/// Discs of the gas.
const DISCS: usize = 1000;

/// Simulated time, s.
const SECONDS: f64 = 1.0;

/// Shares of the area that they cover.
const AREA_FRACTIONS: [f64; 2] = [0.3, 0.6];

/// Where an energy that is kept to the last bit is drawn: an axis of decades has no 0.
const NO_ENERGY_ERROR: f64 = 1e-18;

/// One gas and what all made of it.
pub struct Measured {
    /// The gas.
    pub stretch: Stretch,
    /// One row for each point.
    pub rows: Vec<Row>,
}

impl Measured {
    /// Measures a gas of so many discs for so many seconds.
    ///
    /// # Errors
    /// [`ReportError::Wrong`] where an exact method is not.
    pub fn new(
        (count, area_fraction, seconds): (usize, f64, f64),
        movers: &[Who],
        repeats: usize,
        told: impl FnMut(f64),
    ) -> Result<Self, ReportError> {
        let stretch = Stretch::new(count, area_fraction, seconds)?;
        let rows = rows(&stretch, movers, repeats, told).map_err(ReportError::Wrong)?;
        Ok(Self { stretch, rows })
    }

    /// The rows of a curve.
    pub fn curve(&self, name: &str) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.who.curve() == name)
    }
}

/// The section.
///
/// # Errors
/// [`ReportError::Wrong`] where an exact method is not.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    let (movers, repeats) = (movers(effort), repeats(effort));
    let mut all = Vec::new();
    for (k, area_fraction) in AREA_FRACTIONS.into_iter().enumerate() {
        let told = |done: f64| progress((k as f64 + done) / AREA_FRACTIONS.len() as f64);
        all.push(Measured::new((DISCS, area_fraction, SECONDS), &movers, repeats, told)?);
    }
    let mut items: Vec<Item> = all.iter().map(|gas| Item::Plot(worst(gas))).collect();
    items.extend(all.iter().map(|gas| Item::Plot(typical(gas))));
    items.extend(all.iter().map(|gas| Item::Plot(energy(gas))));
    items.extend(all.iter().map(|gas| Item::Table(table(gas))));
    let title = "A thousand discs for a second: error against run time".to_owned();
    Ok(Section { name: "gas", title, text: words::text(&all, repeats), items })
}

/// The main plot.
fn worst(gas: &Measured) -> Plot {
    let mut plot = plot(gas, "worst", "Distance of the worst disc from its true place", |ended| {
        ended.error.worst
    });
    plot.y = decades("error of the worst disc", "radii");
    plot.caption = format!(
        "{} Lower and further left is better. Marks of steps, springs and other engines are joined \
         in the order of their steps or stiffness; the guide is what one rounding of the largest \
         coordinate at the start has become.",
        plot.caption
    );
    let ms = || plot.series.iter().flat_map(|series| &series.points).map(|point| point.x);
    let (from, to) = (ms().fold(f64::INFINITY, f64::min), ms().fold(0.0, f64::max));
    let y = gas.stretch.one_rounding();
    plot.series.push(guide("one rounding at the start", vec![point(from, y), point(to, y)]));
    plot
}

/// The same of the median disc.
fn typical(gas: &Measured) -> Plot {
    let mut plot =
        plot(gas, "typical", "Distance of the median disc from its true place", |ended| {
            ended.error.median
        });
    plot.y = decades("error of the median disc", "radii");
    plot.caption += " Where the worst disc is lost, most others are not yet.";
    plot
}

fn energy(gas: &Measured) -> Plot {
    let mut plot = plot(gas, "energy", "Relative error of the energy", |ended| {
        ended.energy.abs().max(NO_ENERGY_ERROR)
    });
    plot.y = decades("relative error of the energy", "1");
    plot.caption += &format!(" Below {NO_ENERGY_ERROR:e} is drawn there.");
    plot
}

/// A plot of something against run time.
fn plot(gas: &Measured, what: &str, title: &str, value: fn(&Ended) -> f64) -> Plot {
    let area_fraction = gas.stretch.area_fraction;
    let mut series: Vec<Series> = Vec::new();
    for row in gas.rows.iter().filter(|row| row.ended.lost == 0) {
        let label = row.who.curve();
        let mut mark = against_time(&row.timing, 1, value(&row.ended), &row.who.note());
        // From ns to ms.
        mark.x *= 1e-6;
        mark.spread = mark.spread.map(|(least, most)| (1e-6 * least, 1e-6 * most));
        push(&mut series, label, mark);
    }
    let percent = 100.0 * area_fraction;
    Plot {
        name: format!("gas_{what}_{percent:03.0}"),
        title: format!("{title}, area fraction {area_fraction}"),
        caption: format!(
            "{DISCS} equal elastic discs between walls, one simulated second, {:.1} contacts of a \
             disc, seed {}. Median of {} runs, bars from the quickest to the slowest.",
            gas.stretch.contacts_per_disc(),
            scene::SEED,
            gas.rows.first().map_or(0, |row| row.timing.repeats),
        ),
        x: timed("run time of a simulated second", "ms"),
        y: decades("", "1"),
        series,
    }
}

fn push(series: &mut Vec<Series>, label: &str, mark: Point) {
    match series.iter_mut().find(|series| series.label == label) {
        Some(series) => series.points.push(mark),
        None => {
            series.push(Series { label: label.to_owned(), kind: Kind::Curve, points: vec![mark] });
        }
    }
}

fn table(gas: &Measured) -> Table {
    let ms = |seconds: f64| format!("{:.3}", 1e3 * seconds);
    let row = |row: &Row| {
        let Ended { error, energy, lost } = row.ended;
        let lost = if lost > 0 { format!("{lost} discs left the box") } else { String::new() };
        vec![
            row.who.curve().to_owned(),
            row.who.note(),
            ms(row.timing.median_s),
            ms(row.timing.least_s),
            short(error.worst),
            short(error.rms),
            short(error.median),
            format!("{energy:+.1e}"),
            lost,
        ]
    };
    let area_fraction = gas.stretch.area_fraction;
    Table {
        name: format!("gas_{:03.0}", 100.0 * area_fraction),
        title: format!("All points, area fraction {area_fraction}"),
        caption: "Errors of places in radii; energy: relative and signed. A run that lost a disc \
                  is not in the plots."
            .to_owned(),
        columns: vec![
            words("method"),
            words("setting"),
            times("median (ms)"),
            times("least (ms)"),
            numbers("worst disc (radii)"),
            numbers("root mean square (radii)"),
            numbers("median disc (radii)"),
            numbers("energy"),
            words("wrong"),
        ],
        rows: gas.rows.iter().map(row).collect(),
    }
}
