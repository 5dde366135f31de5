//! The law for two discs: error against time, for the form that carom runs and those of others.
//!
//! The judge has 1200 bits. That the error of carom stays within its stated bound and that it never
//! takes a parting pair for an approaching one is a condition of the report, not a result.

pub mod pairs;

pub mod variants;

use std::hint::black_box;

use glam::DVec2;

use super::items::{self, against_time, decades, guide, numbers, point, short, times, words};
use super::timing::{self, Timing};
use crate::exact::{DoubleDouble, RunningSum, UNIT_ROUNDOFF};
use crate::report::digits::{self, BigVec};
use crate::report::page::{Axis, Column, Item, Kind, Plot, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};
use crate::world::Disc;
use pairs::{Category, SEED, Touching};
use variants::{ALL, Law, Variant};

/// How much is tried.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Pairs in a random category.
    pub pairs: usize,
    /// Timed repeats.
    pub repeats: usize,
    /// Collisions of one pair of masses with each other, for the bias of the energy.
    pub collisions: usize,
}

impl Size {
    /// For this effort.
    pub fn of(effort: Effort) -> Self {
        match effort {
            Effort::Quick => Self { pairs: 10_000, repeats: 15, collisions: 20_000 },
            Effort::Full => Self { pairs: 200_000, repeats: 41, collisions: 400_000 },
        }
    }
}

/// How one form fared on one category.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Largest error of a velocity, in `u |dv|`, `dv` the relative velocity.
    pub largest: f64,
    /// Mean over the pairs of the larger of the two discs' errors, in the same unit.
    pub mean: f64,
    /// Largest error as a part of carom's stated bound.
    pub of_bound: f64,
    /// How often a pair that parts was collided, or one that approaches was not.
    pub wrong: usize,
    /// How often the result was infinite or NaN.
    pub no_number: usize,
    /// Time of all timed pairs.
    pub timing: Timing,
    /// How many pairs that were.
    pub timed: usize,
}

/// Measures the section.
///
/// # Errors
/// [`ReportError::Wrong`] when carom breaks its bound.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    section_of(Size::of(effort), progress)
}

/// The same to a given size.
///
/// # Errors
/// As [`section`].
pub fn section_of(size: Size, progress: Progress) -> Result<Section, ReportError> {
    let categories = pairs::categories(size.pairs).map_err(ReportError::Wrong)?;
    let mut outcomes = Vec::new();
    for (k, category) in categories.iter().enumerate() {
        outcomes.push(outcomes_of(category, size)?);
        progress(0.9 * (k + 1) as f64 / categories.len() as f64);
    }
    let biases: Vec<Bias> = ALL.iter().map(|variant| bias(variant.law, size.collisions)).collect();
    progress(1.0);
    let plotted = |shown| Item::Plot(plot(&categories, &outcomes, size, shown));
    let judge = judge_time(&categories[2].pairs);
    Ok(Section {
        name: "resolver",
        title: "One contact: how exact, and at what price".to_owned(),
        text: text(size, &categories),
        items: vec![
            plotted(Shown::OfBound),
            plotted(Shown::Largest),
            plotted(Shown::Mean),
            Item::Table(table(&categories, &outcomes, judge)),
            Item::Table(bias_table(&biases, size)),
        ],
    })
}

/// How every form fares on a category.
///
/// # Errors
/// [`ReportError::Wrong`] when carom breaks its bound.
pub fn outcomes_of(category: &Category, size: Size) -> Result<Vec<Outcome>, ReportError> {
    let judged: Vec<_> = category
        .pairs
        .iter()
        .map(|pair| digits::collide(&pair.a, &pair.b, pair.restitution))
        .collect();
    let outcomes = ALL.iter().map(|variant| outcome(variant.law, category, &judged, size));
    let outcomes: Vec<Outcome> = outcomes.collect();
    for (variant, outcome) in ALL.iter().zip(&outcomes) {
        let is_meant = variant.is_bounded && (variant.at_any_scale || !category.is_extreme);
        let holds = outcome.of_bound <= 1.0 && outcome.wrong + outcome.no_number == 0;
        if is_meant && !holds {
            let Variant { name, .. } = variant;
            return Err(ReportError::Wrong(format!(
                "resolver: {name} has {} of its bound, {} wrong decisions on {}",
                outcome.of_bound, outcome.wrong, category.name
            )));
        }
    }
    Ok(outcomes)
}

fn outcome(
    law: Law,
    category: &Category,
    judged: &[Option<(BigVec, BigVec)>],
    size: Size,
) -> Outcome {
    let (mut largest, mut of_bound) = (0.0f64, 0.0f64);
    let (mut sum, mut wrong, mut no_number) = (RunningSum::default(), 0, 0);
    for (pair, judged) in category.pairs.iter().zip(judged) {
        let after = law(&pair.a, &pair.b, pair.restitution);
        let (Some(after), Some(judged)) = (after, judged) else {
            wrong += usize::from(after.is_some() != judged.is_some());
            continue;
        };
        let errors = [(after.0, &judged.0), (after.1, &judged.1)]
            .map(|(v, exact)| digits::error(v.x, &exact[0]).max(digits::error(v.y, &exact[1])));
        if !errors.iter().all(|error| error.is_finite()) {
            no_number += 1;
            continue;
        }
        let error = errors[0].max(errors[1]) / unit(pair);
        largest = largest.max(error);
        sum.add(error);
        let bounds = bounds(pair, after);
        of_bound = of_bound.max(errors[0] / bounds[0]).max(errors[1] / bounds[1]);
    }
    let (timing, timed) = time(law, &category.pairs, size.repeats);
    let counted = category.pairs.len() - wrong - no_number;
    let mean = sum.value() / counted.max(1) as f64;
    Outcome { largest, mean, of_bound, wrong, no_number, timing, timed }
}

/// `u |dv|`, at least the smallest number above 0.
fn unit(pair: &Touching) -> f64 {
    let w = pair.b.velocity - pair.a.velocity;
    (UNIT_ROUNDOFF * w.x.hypot(w.y)).max(f64::from_bits(1))
}

/// `16 u (1 + e) f |dv| + 2 u max(|v|, |v'|)` of both discs, as stated in [`crate::resolve::pair`].
fn bounds(pair: &Touching, after: (DVec2, DVec2)) -> [f64; 2] {
    let Touching { a, b, restitution } = pair;
    let w = b.velocity - a.velocity;
    let by_contact = 16.0 * UNIT_ROUNDOFF * (1.0 + restitution) * w.x.hypot(w.y);
    [(a, b, after.0), (b, a, after.1)].map(|(disc, other, after)| {
        let fraction = 1.0 / (1.0 + disc.mass / other.mass);
        let length = |v: DVec2| v.x.hypot(v.y);
        let rounding = 2.0 * UNIT_ROUNDOFF * length(disc.velocity).max(length(after));
        by_contact * fraction + rounding + f64::from_bits(1)
    })
}

/// Time of a good many contacts, and how many.
fn time(law: Law, pairs: &[Touching], repeats: usize) -> (Timing, usize) {
    let pairs = &pairs[..pairs.len().min(1024)];
    let turns = (4096 / pairs.len()).max(1);
    let timing = timing::repeat(repeats, || {
        for _ in 0..turns {
            for pair in pairs {
                black_box(law(black_box(&pair.a), black_box(&pair.b), pair.restitution));
            }
        }
    });
    (timing, turns * pairs.len())
}

/// Time of the judge for some contacts, and how many.
fn judge_time(pairs: &[Touching]) -> (Timing, usize) {
    let pairs = &pairs[..pairs.len().min(100)];
    let timing = timing::repeat(5, || {
        for pair in pairs {
            black_box(digits::collide(&pair.a, &pair.b, pair.restitution));
        }
    });
    (timing, pairs.len())
}

/// What a form does to the energy in the long run.
#[derive(Clone, Copy, Debug)]
pub struct Bias {
    /// Mean relative change of the pair's energy in a collision, in u: root mean square over pairs
    /// of masses.
    pub mean: f64,
    /// What that would be if the errors had no mean: their spread over the root of their number.
    pub chance: f64,
}

/// Masses against 1 kg, none of which gives fractions that are doubles.
const MASSES: [f64; 8] = [0.1, 0.3, 0.6, 1.3, 1.7, 2.9, 5.3, 9.7];

/// Collides two discs of unequal masses again and again, at random angles.
pub fn bias(law: Law, collisions: usize) -> Bias {
    let (mut means, mut chances) = (0.0, 0.0);
    for (k, mass) in MASSES.into_iter().enumerate() {
        let mut random = super::random::Random::new(SEED + k as u64);
        let disc = |id, mass, vx| Disc {
            id,
            position: DVec2::ZERO,
            velocity: DVec2::new(vx, 0.25),
            radius: 0.5,
            mass,
        };
        let (mut a, mut b) = (disc(0, 1.0, 0.7), disc(1, mass, -0.3));
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..collisions {
            let d = DVec2::from_angle(random.uniform(0.0, std::f64::consts::TAU));
            b.position = if d.dot(b.velocity - a.velocity) < 0.0 { d } else { -d };
            let before = energy(&a, &b);
            let after = law(&a, &b, 1.0).unwrap_or((a.velocity, b.velocity));
            (a.velocity, b.velocity) = after;
            let change = energy(&a, &b).minus(before).value() / (before.hi * UNIT_ROUNDOFF);
            sum += change;
            squares += change * change;
        }
        let count = collisions as f64;
        means += (sum / count).powi(2) / MASSES.len() as f64;
        chances += squares / count / count / MASSES.len() as f64;
    }
    Bias { mean: means.sqrt(), chance: chances.sqrt() }
}

/// Twice the kinetic energy, to 100 bits.
fn energy(a: &Disc, b: &Disc) -> DoubleDouble {
    let of = |disc: &Disc| {
        let DVec2 { x, y } = disc.velocity;
        let square = DoubleDouble::product(x, x).plus(DoubleDouble::product(y, y));
        square.times_double(disc.mass)
    };
    of(a).plus(of(b))
}

fn text(size: Size, categories: &[Category]) -> Vec<String> {
    let count = |k: usize| categories[k].pairs.len();
    vec![
        "What a contact of two circles does to their velocities can be computed in several forms, \
         which are the same on paper. They differ in the digits that they lose where masses, \
         speeds or places are far apart, and in their time."
            .to_owned(),
        "carom's error stays within 16 u (1 + e) f |dv| + 2 u max(|v|, |v'|) in every category, \
         with u = 2^-53, dv the relative velocity and f the share of the disc; the report ends \
         where it does not. The plain forms exceed that where masses differ, lose the sign of a \
         grazing approach and give no number in extreme units."
            .to_owned(),
        format!(
            "Measured on {} pairs of the reference cases R03 to R09, {} of R10 and R11 and {} \
             random ones in each of five categories (seed {SEED}), against 1200 bits. Times are \
             medians of {} repeats over up to 1024 pairs one by one after one untimed; the bars \
             reach from the least to the largest.",
            count(0), count(1), size.pairs, size.repeats
        ),
        "The forms of the methods events and plain are not used in extreme units (carom refuses or \
         scales such scenes), so nothing is asked of them there. In the arena the first of them is \
         compiled for the processor's fused multiply-add and is quicker than here."
            .to_owned(),
    ]
}

/// What a plot shows of an outcome.
#[derive(Clone, Copy)]
enum Shown {
    OfBound,
    Largest,
    Mean,
}

impl Shown {
    fn of(self, outcome: &Outcome) -> f64 {
        match self {
            Self::OfBound => outcome.of_bound,
            Self::Largest => outcome.largest,
            Self::Mean => outcome.mean,
        }
    }

    /// Name, title, axis.
    fn words(self) -> (&'static str, &'static str, Axis) {
        let axis = |label: &str| decades(label, "u |dv|");
        match self {
            Self::OfBound => (
                "resolver_bound",
                "The largest error of a velocity, beside carom's bound",
                decades("largest error over the bound", "1"),
            ),
            Self::Largest => (
                "resolver_largest",
                "The largest error of a velocity after a contact",
                axis("largest error"),
            ),
            Self::Mean => (
                "resolver_mean",
                "The mean error of a velocity after a contact",
                axis("mean error"),
            ),
        }
    }
}

fn plot(categories: &[Category], outcomes: &[Vec<Outcome>], size: Size, shown: Shown) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    for (k, variant) in ALL.iter().enumerate() {
        let points = categories.iter().zip(outcomes).filter_map(|(category, outcomes)| {
            let (outcome, y) = (&outcomes[k], shown.of(&outcomes[k]));
            let is_told = y > 0.0 && outcome.no_number + outcome.wrong == 0;
            is_told.then(|| against_time(&outcome.timing, outcome.timed, y, category.name))
        });
        let points = points.collect();
        series.push(Series { label: variant.name.to_owned(), kind: Kind::Marks, points });
    }
    if matches!(shown, Shown::OfBound) {
        series.push(guide("the bound", [4.0, 400.0].map(|ns| point(ns, 1.0)).to_vec()));
    }
    let (name, title, y) = shown.words();
    Plot {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: format!(
            "One mark for each category of pairs. u = 2^-53, dv = the relative velocity. A frame \
             that moves fast costs every form the digits of its speed. Median of {} repeats, seed \
             {SEED}; where a form decided wrongly or gave no number there is no mark, see the \
             table.",
            size.repeats
        ),
        x: items::timed("time of a contact", "ns"),
        y,
        series,
    }
}

fn table(categories: &[Category], outcomes: &[Vec<Outcome>], judge: (Timing, usize)) -> Table {
    let columns: Vec<Column> = vec![
        words("pairs"),
        words("form"),
        numbers("largest error (u |dv|)"),
        numbers("mean error (u |dv|)"),
        numbers("largest error (of carom's bound)"),
        numbers("wrong decisions"),
        numbers("no number"),
        times("time, median (ns)"),
        times("least (ns)"),
    ];
    let mut rows = Vec::new();
    for (category, outcomes) in categories.iter().zip(outcomes) {
        for (variant, outcome) in ALL.iter().zip(outcomes) {
            let each = |seconds: f64| format!("{:.1}", 1e9 * seconds / outcome.timed as f64);
            rows.push(vec![
                format!("{} ({})", category.name, category.pairs.len()),
                variant.name.to_owned(),
                short(outcome.largest),
                short(outcome.mean),
                short(outcome.of_bound),
                outcome.wrong.to_string(),
                outcome.no_number.to_string(),
                each(outcome.timing.median_s),
                each(outcome.timing.least_s),
            ]);
        }
    }
    let zero = || "0".to_owned();
    let each = |seconds: f64| format!("{:.0}", 1e9 * seconds / judge.1 as f64);
    let mut row = vec![categories[2].name.to_owned(), "many digits, the judge".to_owned()];
    row.extend([zero(), zero(), zero(), zero(), zero()]);
    row.extend([each(judge.0.median_s), each(judge.0.least_s)]);
    rows.push(row);
    Table {
        name: "resolver_forms".to_owned(),
        title: "Every form on every category".to_owned(),
        caption:
            "A wrong decision takes circles that part for approaching ones, or the other way; \
                  errors are over the pairs decided rightly that gave numbers."
                .to_owned(),
        columns,
        rows,
    }
}

fn bias_table(biases: &[Bias], size: Size) -> Table {
    let row = |(variant, bias): (&Variant, &Bias)| {
        vec![
            variant.name.to_owned(),
            variant.what.to_owned(),
            format!("{:.4}", bias.mean),
            format!("{:.4}", bias.chance),
        ]
    };
    Table {
        name: "resolver_energy".to_owned(),
        title: "Energy in the long run: the mean error of a collision".to_owned(),
        caption: format!(
            "Two discs of unequal masses ({} pairs) collide {} times at random angles; told is the \
             mean relative change of their energy in a collision, in u, root mean square over the \
             pairs of masses. What is well above chance is a bias: it adds up with the number of \
             collisions, not with its root. It is why carom carries mass fractions as hi + lo.",
            MASSES.len(),
            size.collisions
        ),
        columns: vec![
            words("form"),
            words("what it is"),
            numbers("mean error (u)"),
            numbers("by chance (u)"),
        ],
        rows: ALL.iter().zip(biases).map(row).collect(),
    }
}
