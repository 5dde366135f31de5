//! Error against run time on small scenes whose true end is known to hundreds of bits.
//!
//! Exact methods are points at the rounding of doubles; steps and springs are curves, and what
//! their errors follow as steps get shorter or springs stiffer is fitted. Never past the horizon: a
//! scene ends while a perturbation of the start has grown by less than a few hundred.

mod known;

pub use known::{Checkpoint, Known, all};

use super::fit::power_law;
use super::items::{against_time, decades, guide, point, short, timed};
use super::mover::{self, Error, Mover, power, seconds};
use super::timing::Timing;
use super::turns::{Timed, in_turns};
use crate::bench;
use crate::exact::UNIT_ROUNDOFF;
use crate::report::page::{Axis, Item, Kind, Plot, Point, Section, Series};
use crate::report::{Effort, Progress, ReportError};

/// An exact method is wrong if it is off by more than so many `u G`, in radii.
const ROUNDINGS_MOST: f64 = 1e3;

/// The step of the springs while their stiffness is varied, s.
const SPRING_STEP: f64 = 1.0 / 256.0;

/// The stiffness of the springs while their step is varied, N/m.
const SPRING_STIFFNESS: f64 = 1e6;

/// Tick of the method of ticks, s.
const TICK: f64 = 1.0 / 64.0;

/// What is timed together lasts so long at least, s.
const TIMED_S: f64 = 2e-4;

/// One method at one setting on one scene.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Who.
    pub mover: Mover,
    /// Off by.
    pub error: Error,
    /// Run time, if it was taken.
    pub timing: Option<Timing>,
}

/// A scene and what all made of it.
pub struct Measured {
    /// The scene.
    pub known: Known,
    /// One row for each method and setting.
    pub rows: Vec<Row>,
    /// What a method does not do, if it refused.
    pub refused: Vec<String>,
}

impl Measured {
    /// `u G` at the end: what one rounding has become, relative.
    pub fn one_rounding(&self) -> f64 {
        UNIT_ROUNDOFF * self.known.end().growth
    }

    /// Errors of the worst disc of the movers for which there is an abscissa.
    fn worst(&self, of: impl Fn(Mover) -> Option<f64>) -> Vec<(f64, f64)> {
        let point = |row: &Row| of(row.mover).map(|x| (x, row.error.worst));
        self.rows.iter().filter_map(point).collect()
    }
}

/// What an error is made of on one scene, for whoever has to choose a method: the worst disc is off
/// by about `steps_per_s` times the step, or `springs_per_root` over the root of the stiffness.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// Name of the case.
    pub scene: &'static str,
    /// What a perturbation of the start is multiplied by.
    pub growth: f64,
    /// Error of steps per step, radii/s.
    pub steps_per_s: f64,
    /// Error of springs times the root of their stiffness, radii sqrt(N/m), where there are any.
    pub springs_per_root: Option<f64>,
}

/// The coefficients of all scenes; the same bits every time, in about a second.
///
/// # Errors
/// As [`section`].
pub fn coefficients() -> Result<Vec<Coefficients>, ReportError> {
    let of = |known: Known| {
        let gas = measure(known, &movers(Effort::Quick))?;
        let steps: Vec<f64> =
            gas.worst(step_of).into_iter().map(|(step, error)| error / step).collect();
        let springs: Vec<f64> =
            gas.worst(stiffness_of).into_iter().map(|(k, error)| error * k.sqrt()).collect();
        Ok(Coefficients {
            scene: gas.known.name,
            growth: gas.known.end().growth,
            steps_per_s: median(steps).unwrap_or(f64::NAN),
            springs_per_root: median(springs),
        })
    };
    all()?.into_iter().map(of).collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Whom a report of this effort compares.
pub fn movers(effort: Effort) -> Vec<Mover> {
    let full = effort == Effort::Full;
    let step = |k: i32| 2f64.powi(-k);
    let mut movers = vec![Mover::Events, Mover::Plain, Mover::Ticks(TICK)];
    let finest = if full { 20 } else { 16 };
    movers.extend((6..=finest).step_by(2).map(|k| Mover::Steps(step(k))));
    let springs = |stiffness, step| Mover::Springs { stiffness, step };
    let stiff = [1e4, 1e6, 1e8, 1e10, 1e12];
    movers.extend(stiff.map(|stiffness| springs(stiffness, SPRING_STEP)));
    movers.extend([6, 10, 12].map(|k| springs(SPRING_STIFFNESS, step(k))));
    movers
}

/// The curve of a mover.
fn curve(mover: Mover) -> &'static str {
    match mover {
        Mover::Events => "events (exact)",
        Mover::Plain => "plain (exact)",
        Mover::Ticks(_) => "ticks (exact)",
        Mover::Steps(_) => "steps",
        Mover::Springs { step: SPRING_STEP, .. } => "springs, by stiffness",
        Mover::Springs { .. } => "springs, by step",
    }
}

/// The step of steps, s.
pub fn step_of(mover: Mover) -> Option<f64> {
    if let Mover::Steps(step) = mover { Some(step) } else { None }
}

/// The stiffness of springs whose step is the usual one, N/m.
pub fn stiffness_of(mover: Mover) -> Option<f64> {
    match mover {
        Mover::Springs { stiffness, step: SPRING_STEP } => Some(stiffness),
        _ => None,
    }
}

/// Runs all on a scene and judges the exact ones; nothing is timed.
///
/// # Errors
/// [`ReportError::Wrong`] where an exact method is not.
pub fn measure(known: Known, movers: &[Mover]) -> Result<Measured, ReportError> {
    let (mut rows, mut refused) = (Vec::new(), Vec::new());
    for &mover in movers {
        let wrong = |what: String| ReportError::Wrong(format!("{}: {what}", known.name));
        let mut arena = match mover.arena(&known.scene) {
            Ok(arena) => arena,
            Err(why) => {
                let why = format!("{why} ({})", known.name);
                if !refused.contains(&why) {
                    refused.push(why);
                }
                continue;
            }
        };
        mover::pass(&mut arena, known.scene.until).map_err(wrong)?;
        let error = Error::of(&mover::discs(&arena), &known.end().truth);
        judge(mover, &error, known.end()).map_err(wrong)?;
        rows.push(Row { mover, error, timing: None });
    }
    Ok(Measured { known, rows, refused })
}

/// Whether what calls itself exact is.
///
/// # Errors
/// By how much it is not.
pub fn judge(mover: Mover, error: &Error, end: &Checkpoint) -> Result<(), String> {
    let most = ROUNDINGS_MOST * UNIT_ROUNDOFF * end.growth;
    let is_off = error.worst.is_nan() || error.worst > most;
    if mover.method().is_exact() && is_off {
        let (name, worst) = (curve(mover), error.worst);
        return Err(format!("{name} is off by {worst:.1e} radii, may be by {most:.1e}"));
    }
    Ok(())
}

/// Times all rows in turns.
fn time(gas: &mut Measured, repeats: usize) -> Result<(), String> {
    let until = gas.known.scene.until;
    let mut timed: Vec<Timed> = Vec::new();
    for row in &gas.rows {
        let start = row.mover.arena(&gas.known.scene)?;
        let run = move |times: usize| {
            let mut arenas = vec![start.clone(); times];
            let (time, passed) = bench::seconds(|| {
                arenas.iter_mut().try_for_each(|arena| mover::pass(arena, until))
            });
            passed.map(|()| time / times as f64)
        };
        // Short runs are timed several at once.
        let times = (TIMED_S / run(1)?.max(1e-7)).ceil() as usize;
        timed.push(Box::new(move || run(times.clamp(1, 1000))));
    }
    let timings = in_turns(repeats, &mut timed, |_| ())?;
    drop(timed);
    for (row, timing) in gas.rows.iter_mut().zip(timings) {
        row.timing = Some(timing);
    }
    Ok(())
}

/// The section.
///
/// # Errors
/// [`ReportError::Wrong`] where an exact method is not.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    let repeats = if effort == Effort::Full { 10 } else { 5 };
    let scenes = all()?;
    let (count, mut measured) = (scenes.len() as f64, Vec::new());
    let growth = growth(&scenes[1])?;
    for (k, known) in scenes.into_iter().enumerate() {
        let mut gas = measure(known, &movers(effort))?;
        time(&mut gas, repeats).map_err(ReportError::Wrong)?;
        measured.push(gas);
        progress((k + 1) as f64 / count);
    }
    let mut plots: Vec<Plot> = measured.iter().map(|gas| against_run_time(gas, repeats)).collect();
    plots.extend([
        normalised(&measured),
        law_of_steps(&measured),
        law_of_springs(&measured),
        growth,
    ]);
    let items = plots.into_iter().map(Item::Plot).collect();
    let title = "Small scenes with a known end: error against run time".to_owned();
    Ok(Section { name: "short_time", title, text: text(&measured, repeats), items })
}

fn mark(row: &Row, y: f64) -> Option<Point> {
    let mut mark = against_time(row.timing.as_ref()?, 1, y, &row.mover.note());
    // From ns to us.
    mark.x *= 1e-3;
    mark.spread = mark.spread.map(|(least, most)| (1e-3 * least, 1e-3 * most));
    Some(mark)
}

/// Adds a mark to its curve.
fn push(series: &mut Vec<Series>, label: &str, kind: Kind, mark: Point) {
    match series.iter_mut().find(|series| series.label == label) {
        Some(series) => series.points.push(mark),
        None => series.push(Series { label: label.to_owned(), kind, points: vec![mark] }),
    }
}

/// One scene. What is exact to the last bit has no place on an axis of decades: it is drawn at an
/// eighth of a rounding.
fn against_run_time(gas: &Measured, repeats: usize) -> Plot {
    let mut series = Vec::new();
    for row in &gas.rows {
        let y = row.error.worst.max(UNIT_ROUNDOFF / 8.0);
        mark(row, y).into_iter().for_each(|mark| {
            push(&mut series, curve(row.mover), Kind::Curve, mark);
        });
    }
    let known = &gas.known;
    let x = || series.iter().flat_map(|series: &Series| &series.points).map(|mark| mark.x);
    let (from, to) = (x().fold(f64::INFINITY, f64::min), x().fold(0.0, f64::max));
    let y = gas.one_rounding();
    series.push(guide("u G", vec![point(from, y), point(to, y)]));
    Plot {
        name: format!("short_time_{}", known.name.to_lowercase()),
        title: format!("{}: error at t = {} s", known.name, known.end().time),
        caption: format!(
            "{} discs, {} contacts until then, a perturbation grows by G = {}. Median of {repeats} \
             runs, bars from the quickest to the slowest. The guide is u G, one rounding at the \
             start, in radii.",
            known.scene.discs.len(),
            known.end().truth.contacts,
            short(known.end().growth),
        ),
        x: timed("run time", "us"),
        y: decades("error of the worst disc", "smallest radii"),
        series,
    }
}

/// All scenes at once, in units of what one rounding becomes.
fn normalised(all: &[Measured]) -> Plot {
    let mut series = Vec::new();
    for gas in all {
        for row in &gas.rows {
            let y = row.error.worst.max(UNIT_ROUNDOFF / 8.0) / gas.one_rounding();
            mark(row, y).into_iter().for_each(|mut mark| {
                mark.note = format!("{} {}", gas.known.name, mark.note).trim_end().to_owned();
                push(&mut series, curve(row.mover), Kind::Marks, mark);
            });
        }
    }
    Plot {
        name: "short_time_normalised".to_owned(),
        title: "All scenes: error over u G, what the scene makes of one rounding".to_owned(),
        caption: "An ideal method in doubles lies between 0.1 and 100 here, whatever the scene."
            .to_owned(),
        x: timed("run time", "us"),
        y: decades("error of the worst disc over u G", "1"),
        series,
    }
}

/// A plot of errors against a setting, one curve a scene, with a guide of some slope.
fn law(
    all: &[Measured],
    (name, title, caption): (&str, &str, &str),
    x: Axis,
    of: impl Fn(Mover) -> Option<f64>,
    note: fn(f64) -> String,
    (label, slope): (&str, f64),
) -> Plot {
    let mut series = Vec::new();
    for gas in all {
        let marks = gas.worst(&of).into_iter();
        let points: Vec<Point> =
            marks.map(|(x, y)| Point { note: note(x), ..point(x, y) }).collect();
        if !points.is_empty() {
            series.push(Series { label: gas.known.name.to_owned(), kind: Kind::Curve, points });
        }
    }
    // Below the first curve, from its last mark on.
    if let Some(Series { points, .. }) = series.first()
        && let (Some(first), Some(last)) = (points.first(), points.last())
    {
        let at = |x: f64| point(x, 0.3 * last.y * (x / last.x).powf(slope));
        series.push(guide(label, vec![at(first.x), at(last.x)]));
    }
    Plot {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: caption.to_owned(),
        x,
        y: decades("error of the worst disc", "smallest radii"),
        series,
    }
}

fn law_of_steps(all: &[Measured]) -> Plot {
    let head = (
        "short_time_steps",
        "Steps: the error is of first order",
        "One curve a scene, at the same times as above. How late a contact is found is chance, so \
         curves are rough.",
    );
    let guide = ("slope 1", 1.0);
    law(all, head, decades("length of the step", "s"), step_of, seconds, guide)
}

fn law_of_springs(all: &[Measured]) -> Plot {
    let head = (
        "short_time_springs",
        "Springs: a floor that falls as the root of the stiffness",
        "One curve a scene, steps of 1/256 s. A contact lasts pi sqrt(mu / k), and each disc of it \
         is late by that.",
    );
    let guide = ("slope -1/2", -0.5);
    law(all, head, decades("stiffness", "N/m"), stiffness_of, power, guide)
}

/// The exact methods over time on one scene, up to the horizon.
fn growth(known: &Known) -> Result<Plot, ReportError> {
    let mut series = Vec::new();
    for mover in [Mover::Events, Mover::Plain, Mover::Ticks(TICK), Mover::Steps(1.0 / 16384.0)] {
        let wrong = |what: String| ReportError::Wrong(format!("{}: {what}", known.name));
        let mut arena = mover.arena(&known.scene).map_err(wrong)?;
        for checkpoint in &known.checkpoints {
            mover::pass(&mut arena, checkpoint.time).map_err(wrong)?;
            let error = Error::of(&mover::discs(&arena), &checkpoint.truth).worst;
            let mark = point(checkpoint.time, error.max(UNIT_ROUNDOFF / 8.0));
            push(&mut series, curve(mover), Kind::Curve, mark);
        }
    }
    let rounding = |at: &Checkpoint| point(at.time, UNIT_ROUNDOFF * at.growth);
    series.push(guide("u G(t)", known.checkpoints.iter().map(rounding).collect()));
    Ok(Plot {
        name: "short_time_growth".to_owned(),
        title: format!("{}: how an error grows, up to the horizon", known.name),
        caption: "Where a curve reaches the order of a radius its method knows nothing of this \
                  scene any more. plain carries twice the digits: what is shown of it is the \
                  rounding of its output. Steps are of 1/16384 s."
            .to_owned(),
        x: Axis { log: false, ..decades("simulated time", "s") },
        y: decades("error of the worst disc", "smallest radii"),
        series,
    })
}

fn text(all: &[Measured], repeats: usize) -> Vec<String> {
    let scenes: Vec<String> = all
        .iter()
        .map(|gas| {
            let known = &gas.known;
            format!("{} to {} s", known.name, known.end().time)
        })
        .collect();
    let mut text = vec![
        "On a scene whose true end is known, how far off is each method, and how long did it take? \
         The exact methods are as wrong as one rounding becomes; steps and springs are wrong by \
         what they leave out."
            .to_owned(),
        format!(
            "Scenes are reference cases of the project: {}. Their ends were computed in 700 and \
             950 bits by another program, and the report's judge (300 bits) agrees with each to \
             1e-28 m. Errors are from one untimed run; times are the median and the least of \
             {repeats} repeats in turns, of several runs at once where one is shorter than \
             0.2 ms. No scene goes past the horizon: later states of these scenes would say \
             nothing of a method.",
            scenes.join(", ")
        ),
        found(all),
    ];
    let refused: Vec<&str> = all.iter().flat_map(|gas| &gas.refused).map(String::as_str).collect();
    text.push(format!(
        "Left out: {}. Explicit rules for springs: the closed form is exact for a contact alone.",
        if refused.is_empty() { "no method on any scene".to_owned() } else { refused.join("; ") }
    ));
    text
}

/// What the numbers say.
fn found(all: &[Measured]) -> String {
    let exact = |gas: &Measured| {
        let rows = gas.rows.iter().filter(|row| row.mover.method().is_exact());
        rows.map(|row| row.error.worst / gas.one_rounding()).fold(0.0, f64::max)
    };
    let worst = all.iter().map(exact).fold(0.0, f64::max);
    let of_scenes = |of: fn(Mover) -> Option<f64>, law: f64| {
        let (mut lawful, mut others) = (Vec::new(), Vec::new());
        for gas in all {
            let points = gas.worst(of);
            if points.len() > 2 {
                let power = power_law(&points).0;
                let said = format!("{} {power:+.2}", gas.known.name);
                let list = if (power / law - 1.0).abs() < 0.35 { &mut lawful } else { &mut others };
                list.push(said);
            }
        }
        let mut said = format!("p: {}", lawful.join(", "));
        if !others.is_empty() {
            said += &format!("; not reached on {}", others.join(", "));
        }
        said
    };
    let beaten = all.iter().all(|gas| {
        let time = |row: &Row| row.timing.map_or(f64::INFINITY, |timing| timing.median_s);
        let events = gas.rows.iter().find(|row| row.mover == Mover::Events);
        let rough = || gas.rows.iter().filter(|row| !row.mover.method().is_exact());
        events.is_some_and(|events| rough().all(|row| time(events) < time(row)))
    });
    let quicker = if beaten {
        "On each scene events is quicker than steps and springs at every setting."
    } else {
        "Some rough settings of steps or springs are quicker than events."
    };
    let (steps, springs) = (of_scenes(step_of, 1.0), of_scenes(stiffness_of, -0.5));
    let why = if format!("{steps}{springs}").contains("not reached") {
        " Where no law is reached, contacts follow each other so closely that their order is lost \
         in every step and under every spring (packed discs, E25), or a disc a million times \
         heavier sinks deep into the walls (E22)."
    } else {
        ""
    };
    format!(
        "Exact methods are off by {} u G at most. The error of steps goes as step^p, {steps}. That \
         of springs goes as stiffness^p, {springs}.{why} {quicker}",
        short(worst),
    )
}
