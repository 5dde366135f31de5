//! Rates with exact values: how far off after how much run time.
//!
//! Chaos leaves only averages. An exact method gets them right, and the longer it runs the better,
//! as the root of the time; a rough one ends at a wrong value, however long it runs. Never an
//! average that is not known exactly.

mod known;

pub use known::{Known, Parts};

use super::items::{decades, guide, numbers, point, short, timed, times, words};
use super::mover::Mover;
use super::turns::timing;
use crate::check::statistics::estimate;
use crate::report::page::{Item, Kind, Plot, Point, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};

/// Parts of a run that is plotted, a power of two.
const PARTS: usize = 256;

/// Parts of the same run, long enough to forget each other.
const LONG_PARTS: usize = 16;

/// Parts of a run of the table.
const TABLE_PARTS: usize = 64;

/// Seeds of each box with two discs in the table.
const SEEDS: u64 = 4;

/// A mean is wrong beyond so many standard errors.
const SIGMAS: f64 = 4.0;

/// The set of z-scores is wrong if chance makes one so odd no more often than this.
const CHANCE: f64 = 1e-4;

/// One mean of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Score {
    /// Scene and seed.
    pub name: String,
    /// What was measured.
    pub what: &'static str,
    /// Its exact value.
    pub exact: f64,
    /// As measured, and its standard error.
    pub mean: (f64, f64),
    /// Run time, s.
    run_s: f64,
}

impl Score {
    /// Difference to the exact value in standard errors.
    pub fn z(&self) -> f64 {
        (self.mean.0 - self.exact) / self.mean.1
    }
}

/// The section.
///
/// # Errors
/// [`ReportError::Wrong`] where an exact method misses an exact value.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    let (of_curves, of_table) = if effort == Effort::Full { (1.0, 1.0) } else { (0.05, 0.025) };
    let mut plots = Vec::new();
    let scenes = plotted().map_err(ReportError::Wrong)?;
    let count = scenes.len() as f64;
    for (k, (name, known, movers)) in scenes.into_iter().enumerate() {
        let mut done = 0.0;
        let told = || {
            done += 1.0;
            progress(0.6 * (k as f64 + done / movers.len() as f64) / count);
        };
        plots.push(plot(name, &known, &movers, of_curves, told).map_err(ReportError::Wrong)?);
    }
    let scores = scores(of_table, |part| progress(0.6 + 0.4 * part)).map_err(ReportError::Wrong)?;
    let test = judge(&scores).map_err(ReportError::Wrong)?;
    let text = text(&plots, &scores, test);
    let mut items: Vec<Item> = plots.into_iter().map(|(plot, _)| Item::Plot(plot)).collect();
    items.push(Item::Table(table(&scores, test)));
    let title = "Statistics: rates against their exact values".to_owned();
    Ok(Section { name: "statistics", title, text, items })
}

/// Contacts in each part of a curve of a full report.
type Curves = Vec<(Mover, f64)>;

/// A whole run: who, relative difference to the exact value, z-score.
type Whole = (Mover, f64, f64);

/// The scenes that are plotted, and who runs them.
fn plotted() -> Result<Vec<(&'static str, Known, Curves)>, String> {
    let first = |known: Vec<Known>, k: usize| {
        known.into_iter().nth(k).ok_or_else(|| "a scene is missing".to_owned())
    };
    let exact = [(Mover::Plain, 3e4), (Mover::Events, 3e4), (Mover::Ticks(1.0 / 60.0), 1e4)];
    let rough = [
        (Mover::Steps(1.0 / 60.0), 2e4),
        (Mover::Steps(1.0 / 1000.0), 6e3),
        (Mover::Springs { stiffness: 1e4, step: 1.0 / 240.0 }, 6e3),
    ];
    let exact_ones = || exact[..2].to_vec();
    Ok(vec![
        ("statistics_two_discs", first(known::two_discs(1)?, 0)?, [&exact[..], &rough].concat()),
        ("statistics_caged_disc", first(known::caged_discs(PARTS as u64)?, 1)?, exact_ones()),
        ("statistics_billiard", first(known::billiards()?, 1)?, exact_ones()),
    ])
}

/// The error of runs of ever more parts: the root mean square over as many such runs as there are.
/// With how many parts, how far off, how many runs.
pub fn errors(means: &[f64], exact: f64) -> Vec<(usize, f64, usize)> {
    let mut errors = Vec::new();
    let mut length = 1;
    while 4 * length <= means.len() {
        let runs = means.chunks_exact(length);
        let count = runs.len();
        let off = |run: &[f64]| run.iter().sum::<f64>() / length as f64 / exact - 1.0;
        let squares: f64 = runs.map(|run| off(run).powi(2)).sum();
        errors.push((length, (squares / count as f64).sqrt(), count));
        length *= 2;
    }
    errors
}

/// A scene, and the z-score of each method's whole run.
fn plot(
    name: &str,
    known: &Known,
    movers: &[(Mover, f64)],
    share: f64,
    mut told: impl FnMut(),
) -> Result<(Plot, Vec<Whole>), String> {
    let (mut series, mut scores) = (Vec::new(), Vec::new());
    let mut expected = Vec::new();
    for &(mover, contacts) in movers {
        let Parts { means, times } = known.parts(mover, PARTS, share * contacts)?;
        let mean = estimate(&means);
        // Short parts remember each other: the score is that of few and long ones.
        let long = means.chunks_exact(PARTS / LONG_PARTS);
        let long = long.map(|part| part.iter().sum::<f64>() / part.len() as f64);
        let error = estimate(&long.collect::<Vec<_>>()).1;
        scores.push((mover, mean.0 / known.exact - 1.0, (mean.0 - known.exact) / error));
        let each = timing(times);
        let at = |parts: usize, y: f64, note: String| {
            let ms = |seconds: f64| 1e3 * parts as f64 * seconds;
            let spread = Some((ms(each.least_s), ms(each.most_s)));
            Point { x: ms(each.median_s), y, spread, note }
        };
        let errors = errors(&means, known.exact).into_iter();
        let points: Vec<Point> =
            errors.map(|(parts, error, runs)| at(parts, error, format!("{runs} runs"))).collect();
        if mover == Mover::Events {
            let sigma = mean.1 * (PARTS as f64).sqrt() / known.exact;
            let law = |parts: usize| {
                point(1e3 * parts as f64 * each.median_s, sigma / (parts as f64).sqrt())
            };
            expected = vec![law(1), law(PARTS / 4)];
        }
        let label = format!("{} {}", mover.method(), mover.note()).trim_end().to_owned();
        series.push(Series { label, kind: Kind::Curve, points });
        told();
    }
    series.push(guide("events, expected: time^-1/2", expected));
    let plot = Plot {
        name: name.to_owned(),
        title: format!("{}: {}", known.name, known.what),
        caption: format!(
            "Exact value {:.10}. One run of each method in {PARTS} equal parts: a mark is the root \
             mean square error of all runs of so many parts. What becomes level is a bias. Times: \
             median of the parts, bars from the quickest to the slowest.",
            known.exact
        ),
        x: timed("run time", "ms"),
        y: decades("relative error", "1"),
        series,
    };
    Ok((plot, scores))
}

/// Means of the exact methods over all scenes, in turn by events and plain, all independent.
///
/// # Errors
/// Why one does not go on.
pub fn scores(share: f64, mut told: impl FnMut(f64)) -> Result<Vec<Score>, String> {
    let contacts = share * 4e5;
    let mut all = known::two_discs(SEEDS)?;
    let starts = (TABLE_PARTS as f64 * 4.0) as u64;
    let cages = known::caged_discs(starts)?;
    all.extend(known::billiards()?);
    let count = (all.len() + cages.len()) as f64;
    let mut scores = Vec::new();
    // A cage is run from many starts, each for a short while.
    let sparse = cages.into_iter().map(|known| (known, starts as usize, contacts / 16.0));
    let dense = all.into_iter().map(|known| (known, TABLE_PARTS, contacts));
    for (k, (known, parts, contacts)) in dense.chain(sparse).enumerate() {
        let mover = if k % 2 == 0 { Mover::Events } else { Mover::Plain };
        let Parts { means, times } = known.parts(mover, parts, contacts)?;
        scores.push(Score {
            name: format!("{} ({})", known.name, mover.method()),
            what: known.what,
            exact: known.exact,
            mean: estimate(&means),
            run_s: times.iter().sum(),
        });
        told((k + 1) as f64 / count);
    }
    Ok(scores)
}

/// The Kolmogorov test of z-scores against the normal law: the largest distance of the
/// distributions, and how often chance makes it so large (with the correction of Stephens,
/// doi:10.1080/01621459.1974.10480196).
pub fn kolmogorov(scores: &[f64]) -> (f64, f64) {
    let mut sorted = scores.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len() as f64;
    let normal = |z: f64| 0.5 * libm::erfc(-z / std::f64::consts::SQRT_2);
    let apart = |(k, z): (usize, &f64)| {
        let at = normal(*z);
        (at - k as f64 / count).max((k + 1) as f64 / count - at)
    };
    let distance = sorted.iter().enumerate().map(apart).fold(0.0, f64::max);
    let root = count.sqrt();
    let scaled = (root + 0.12 + 0.11 / root) * distance;
    let term = |k: i32| {
        let k = f64::from(k);
        2.0 * (-2.0 * (k * scaled).powi(2)).exp() * if k % 2.0 == 0.0 { -1.0 } else { 1.0 }
    };
    // Below that the series does not converge, and chance is 1 to nine digits.
    let chance = if scaled < 0.2 { 1.0 } else { (1..=100).map(term).sum::<f64>() };
    (distance, chance.clamp(0.0, 1.0))
}

/// Whether all means are right, one by one and as a set; returns what the set came to.
///
/// # Errors
/// Which is not.
pub fn judge(scores: &[Score]) -> Result<(f64, f64), String> {
    let off = |score: &&Score| score.z().is_nan() || score.z().abs() > SIGMAS;
    if let Some(score) = scores.iter().find(off) {
        let (name, what) = (&score.name, score.what);
        return Err(format!("{name}: {what} is {:.1} standard errors off", score.z()));
    }
    let z: Vec<f64> = scores.iter().map(Score::z).collect();
    let test = kolmogorov(&z);
    if test.1 < CHANCE {
        return Err(format!(
            "z-scores are not normal: chance makes such a set once in {:.0}",
            1.0 / test.1
        ));
    }
    Ok(test)
}

fn table(scores: &[Score], (distance, chance): (f64, f64)) -> Table {
    let row = |score: &Score| {
        let (mean, error) = score.mean;
        vec![
            score.name.clone(),
            score.what.to_owned(),
            format!("{:.9}", score.exact),
            format!("{mean:.9}"),
            format!("{:.1e}", error / score.exact),
            format!("{:+.2}", score.z()),
            short(score.run_s),
        ]
    };
    Table {
        name: "statistics".to_owned(),
        title: "Means against exact values, in standard errors".to_owned(),
        caption: format!(
            "{} independent runs of exact methods. Kolmogorov's test of all z against the normal \
             law: distance {distance:.3}, which chance exceeds with probability {chance:.2}.",
            scores.len()
        ),
        columns: vec![
            words("scene (method)"),
            words("what"),
            numbers("exact"),
            numbers("measured"),
            numbers("relative standard error"),
            numbers("z"),
            times("run time (s)"),
        ],
        rows: scores.iter().map(row).collect(),
    }
}

fn text(plots: &[(Plot, Vec<Whole>)], scores: &[Score], (_, chance): (f64, f64)) -> Vec<String> {
    let largest = scores.iter().map(|score| score.z().abs()).fold(0.0, f64::max);
    let of_all = plots.first().map(|(_, scores)| scores.as_slice()).unwrap_or_default();
    let rough: Vec<String> = of_all
        .iter()
        .filter(|(mover, _, z)| !mover.method().is_exact() && z.abs() > SIGMAS)
        .map(|(mover, off, _)| {
            format!("{} at {} by {:+.2} %", mover.method(), mover.note(), 100.0 * off)
        })
        .collect();
    let rough = if rough.is_empty() {
        "no rough method shows a bias in runs of this length".to_owned()
    } else {
        format!(
            "of two discs in a box the rate is wrong, however long the run: {}",
            rough.join(", ")
        )
    };
    vec![
        "Chaos leaves only averages: how far off is a collision rate after \
         so much run time? For an exact method only chance is left, which falls as the root of \
         the time; a rough method ends at a wrong value."
            .to_owned(),
        format!(
            "Scenes with exact values: two discs in a box (S01, quadrature), a disc in a cage of \
             six (S08, geometry), Sinai's billiard (S11, geometry); made by the code that checks \
             these cases, from fixed seeds. A curve is one run in {PARTS} parts. The table is of \
             {} independent runs, standard errors from {TABLE_PARTS} parts of each (of cages: from \
             {} random starts). No repeats: the parts are the repeats.",
            scores.len(),
            4 * TABLE_PARTS
        ),
        format!(
            "Exact methods: the largest of {} z-scores is {largest:.2}, and as a set they look as \
             chance makes them (Kolmogorov: {chance:.2}); {rough}.",
            scores.len()
        ),
        "Left out: steps and springs in the cage and the billiard, whose gaps they would have to \
         resolve; stiffer springs, which gain energy in a run so long unless steps are far \
         shorter; the Lyapunov exponents of S11 and the wall rates of S01, which are not \
         independent of what is shown (carom check judges them)."
            .to_owned(),
    ]
}
