//! The time of impact: error against time, for the formula that carom runs and those of others.
//!
//! That carom's is right to 8 u in every category and never takes a miss for a hit is a condition
//! of the report, not a result. `benches/impact.rs` prints the same as a table.

pub mod formulas;

pub mod pairs;

use super::items::{against_time, decades, guide, numbers, point, short, timed, times, words};
use super::timing::{self, Timing};
use crate::detect::impact::Relative;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::report::digits::{self, Big};
use crate::report::page::{Item, Kind, Plot, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};
use formulas::Formula;
use pairs::{Category, SEED};

/// Largest relative error of carom's formula, u.
pub const ERROR_MAX: f64 = 8.0;

/// Pairs that are timed: they fit a cache.
const TIMED: usize = 4096;
/// Rounds over them in a repeat.
const ROUNDS: usize = 4;

/// How much is tried.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Pairs in a category.
    pub pairs: usize,
    /// Timed repeats.
    pub repeats: usize,
}

impl Size {
    /// For this effort.
    pub fn of(effort: Effort) -> Self {
        match effort {
            Effort::Quick => Self { pairs: 20_000, repeats: 21 },
            Effort::Full => Self { pairs: 400_000, repeats: 41 },
        }
    }
}

/// How one formula fared on one category.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Which formula.
    pub formula: Formula,
    /// Largest relative error of a time, u.
    pub largest: f64,
    /// Mean relative error, u.
    pub mean: f64,
    /// How often hit and miss, or now and later, were taken for each other.
    pub wrong: usize,
    /// Time of all timed pairs.
    pub timing: Timing,
    /// How many that were.
    pub timed: usize,
}

impl Outcome {
    /// Median time of a pair, ns.
    pub fn ns(&self) -> f64 {
        1e9 * self.timing.median_s / self.timed as f64
    }
}

/// Measures the section.
///
/// # Errors
/// [`ReportError::Wrong`] when carom's times are not right to [`ERROR_MAX`].
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    section_of(Size::of(effort), progress)
}

/// The same to a given size.
///
/// # Errors
/// As [`section`].
pub fn section_of(size: Size, progress: Progress) -> Result<Section, ReportError> {
    let mut all = Vec::new();
    for (k, category) in Category::ALL.into_iter().enumerate() {
        all.push((category, outcomes(category, size)?));
        progress((k + 1) as f64 / Category::ALL.len() as f64);
    }
    Ok(Section {
        name: "impact",
        title: "The time of impact: how exact, and at what price".to_owned(),
        text: text(size),
        items: vec![
            Item::Plot(plot(&all, size, true)),
            Item::Plot(plot(&all, size, false)),
            Item::Table(table(&all)),
        ],
    })
}

/// How every formula fares on a category.
///
/// # Errors
/// [`ReportError::Wrong`] when carom's times are not right to [`ERROR_MAX`], or not the same bits
/// one by one and many at once.
pub fn outcomes(category: Category, size: Size) -> Result<Vec<Outcome>, ReportError> {
    let pairs = category.pairs(size.pairs);
    let exact: Vec<Option<Big>> = pairs.iter().map(digits::time_of_impact).collect();
    let mut by_formula: Vec<Vec<f64>> = Vec::new();
    let mut outcomes = Vec::new();
    for formula in Formula::ALL {
        let mut times = vec![0.0; pairs.len()];
        formula.times(&pairs, &mut times);
        outcomes.push(outcome(formula, &times, &exact, &pairs, size.repeats));
        by_formula.push(times);
    }
    let of = |formula: Formula| &by_formula[formula as usize];
    let wrong = |what: String| ReportError::Wrong(format!("impact, {}: {what}", category.name()));
    if of(Formula::Carom) != of(Formula::CaromMany) {
        return Err(wrong("one by one and many at once differ".to_owned()));
    }
    for Outcome { formula, largest, wrong: decisions, .. } in &outcomes {
        if formula.is_robust() && (*largest > ERROR_MAX || *decisions > 0) {
            let name = formula.name();
            return Err(wrong(format!("{name}: {largest} u, {decisions} wrong decisions")));
        }
    }
    Ok(outcomes)
}

fn outcome(
    formula: Formula,
    times: &[f64],
    exact: &[Option<Big>],
    pairs: &[Relative],
    repeats: usize,
) -> Outcome {
    let (mut largest, mut sum, mut count, mut wrong) = (0.0f64, RunningSum::default(), 0, 0);
    for (time, exact) in times.iter().zip(exact) {
        match exact {
            Some(exact) if *exact > Big::ZERO && time.is_finite() => {
                let error = digits::error(*time, exact) / digits::nearest(exact) / UNIT_ROUNDOFF;
                largest = largest.max(error);
                sum.add(error);
                count += 1;
            }
            Some(_) => wrong += usize::from(*time != 0.0),
            None => wrong += usize::from(time.is_finite()),
        }
    }
    let pairs = &pairs[..pairs.len().min(TIMED)];
    let mut scratch = vec![0.0; pairs.len()];
    let timing = timing::repeat(repeats, || {
        (0..ROUNDS).for_each(|_| formula.run(pairs, &mut scratch));
    });
    let mean = sum.value() / f64::from(count.max(1));
    Outcome { formula, largest, mean, wrong, timing, timed: ROUNDS * pairs.len() }
}

fn text(size: Size) -> Vec<String> {
    vec![
        "An exact method stands and falls with the time at which two discs will touch. The formula \
         of school loses digits for pairs that are near, far or graze each other: so many that a \
         hit is taken for a miss. carom looks first, and takes the longer way, in double-double, \
         only where digits would be lost."
            .to_owned(),
        format!(
            "carom's times are right to {ERROR_MAX} u in every category (u = 2^-53, relative), \
             without a wrong decision; the report ends where they are not."
        ),
        format!(
            "Measured on {} random pairs in each of six categories (seed {SEED} and the five after \
             it), the doubles taken as exact, against a judge whose decisions are exact and whose \
             roots have 300 bits. Times are medians of {} repeats over up to {TIMED} pairs after \
             one untimed, one by one but for the last formula; the bars reach from the least to \
             the largest. A formula that was never wrong but had no error to show, as with pairs \
             that overlap, has no mark.",
            size.pairs, size.repeats
        ),
    ]
}

type All = [(Category, Vec<Outcome>)];

fn plot(all: &All, size: Size, is_largest: bool) -> Plot {
    let which = if is_largest { "largest" } else { "mean" };
    let mut series: Vec<Series> = Vec::new();
    for formula in Formula::ALL {
        let mut points = Vec::new();
        for (category, outcomes) in all {
            let outcome = &outcomes[formula as usize];
            let error = if is_largest { outcome.largest } else { outcome.mean };
            if error > 0.0 && error.is_finite() {
                let name = category.name();
                points.push(against_time(&outcome.timing, outcome.timed, error, name));
            }
        }
        series.push(Series { label: formula.name().to_owned(), kind: Kind::Marks, points });
    }
    if is_largest {
        let ends = [1.0, 100.0].map(|ns| point(ns, ERROR_MAX));
        series.push(guide("carom's bound", ends.to_vec()));
    }
    Plot {
        name: format!("impact_{which}"),
        title: format!("The {which} error of a time of impact"),
        caption: format!(
            "One mark for each category of pairs. Relative error in u = 2^-53. Median of {} \
             repeats, seed {SEED}.",
            size.repeats
        ),
        x: timed("time of a pair", "ns"),
        y: decades(&format!("{which} relative error"), "u"),
        series,
    }
}

fn table(all: &All) -> Table {
    let mut rows = Vec::new();
    for (category, outcomes) in all {
        for outcome in outcomes {
            let each = |seconds: f64| format!("{:.2}", 1e9 * seconds / outcome.timed as f64);
            rows.push(vec![
                category.name().to_owned(),
                outcome.formula.name().to_owned(),
                short(outcome.largest),
                short(outcome.mean),
                outcome.wrong.to_string(),
                each(outcome.timing.median_s),
                each(outcome.timing.least_s),
            ]);
        }
    }
    Table {
        name: "impact_formulas".to_owned(),
        title: "Every formula on every category".to_owned(),
        caption:
            "Wrong: a hit taken for a miss, a miss for a hit, or now for later. Errors are over \
                  the hits that were decided rightly."
                .to_owned(),
        columns: vec![
            words("pairs"),
            words("formula"),
            numbers("largest error (u)"),
            numbers("mean error (u)"),
            numbers("wrong"),
            times("time, median (ns)"),
            times("least (ns)"),
        ],
        rows,
    }
}
