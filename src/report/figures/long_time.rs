//! What a long run keeps: energy and the distance at contact, over up to some 10^8 events.
//!
//! No trajectory means anything after so long, so none is looked at. The drift of the energy is
//! told apart into what every event adds, a bias, and what wanders.

use serde_json::Value;

use super::fit::Walk;
use super::gas::melted;
use super::items::{decades, guide, numbers, point, short, times, words};
use super::mover::{self, Mover, Scene};
use crate::bench::seconds;
use crate::check::arena::Setup;
use crate::check::case::Field;
use crate::report::page::{Item, Kind, Plot, Point, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};

/// A hundred discs of masses 0.1 to 10 kg and radii 0.2 to 0.5 m in a box.
const MIXED: &str = include_str!("../../../tests/cases/C01_conservation.json");

/// Equally long parts of a run, of which the bias and the wandering are told.
const PARTS: usize = 128;

/// Contacts from which the rate of contacts is taken.
const FIRST: u64 = 1000;

/// Largest drift of the energy and distance at contact (radii) of an exact method.
const EXACT_MOST: f64 = 1e-9;

/// Where a drift of 0 is drawn: an axis of decades has no 0.
const NO_DRIFT: f64 = 1e-18;

/// One method on one scene.
#[derive(Clone, Debug)]
pub struct Long {
    /// Who.
    pub mover: Mover,
    /// Events, drift of the energy (signed) and largest overlap (smaller radii) on the way.
    pub course: Vec<(u64, f64, f64)>,
    /// Bias and wandering of the drift, by event.
    pub walk: Walk,
    /// Run time of all, s.
    pub run_s: f64,
}

impl Long {
    fn end(&self) -> (u64, f64, f64) {
        self.course.last().copied().unwrap_or_default()
    }
}

/// Runs a method for about so many events.
///
/// # Errors
/// Why it does not go on, or what an exact method did not keep.
pub fn run(
    scene: &Scene,
    mover: Mover,
    events: f64,
    mut told: impl FnMut(f64),
) -> Result<Long, String> {
    let mut arena = mover.arena(scene)?;
    let before = mover::energy(&scene.discs);
    let mut glance = 1e-3;
    while arena.contacts() < FIRST {
        let until = arena.now() + glance;
        mover::pass(&mut arena, until)?;
        glance *= 1.1;
    }
    let rate = arena.contacts() as f64 / arena.now();
    let (part, began) = (events / rate / PARTS as f64, arena.now());
    let look = |arena: &crate::motion::arena::Arena| {
        // Springs that push at the moment hold energy.
        let drift = match mover {
            Mover::Springs { .. } => arena.relative_energy_drift(),
            _ => mover::drift(before, mover::energy(&mover::discs(arena))),
        };
        (arena.contacts(), drift, arena.largest_miss())
    };
    let mut course = vec![look(&arena)];
    let first = arena.contacts();
    // Within the first part, three looks a decade.
    let mut early = 10f64.powf(1.0 / 3.0) * began;
    let (run_s, passed) = seconds(|| {
        while early < began + part {
            mover::pass(&mut arena, early)?;
            course.push(look(&arena));
            early *= 10f64.powf(1.0 / 3.0);
        }
        let mut sums = vec![course[0].1];
        for k in 1..=PARTS {
            mover::pass(&mut arena, began + k as f64 * part)?;
            course.push(look(&arena));
            sums.push(course[course.len() - 1].1);
            told(k as f64 / PARTS as f64);
        }
        Ok::<_, String>(sums)
    });
    let sums = passed?;
    let each = (arena.contacts() - first) as f64 / PARTS as f64;
    let long = Long { mover, course, walk: Walk::of(&sums, each), run_s };
    judge(&long)?;
    Ok(long)
}

/// Whether what calls itself exact kept what it must.
///
/// # Errors
/// What it did not.
pub fn judge(long: &Long) -> Result<(), String> {
    let (events, drift, overlap) = long.end();
    let off = |size: f64| size.is_nan() || size.abs() > EXACT_MOST;
    if !long.mover.method().is_exact() || !(off(drift) || off(overlap)) {
        return Ok(());
    }
    let name = long.mover.method();
    Err(format!("{name}: energy drift {drift:e}, overlap {overlap:e} radii after {events} events"))
}

/// A scene and what all did with it.
struct Measured {
    name: &'static str,
    title: &'static str,
    all: Vec<Long>,
}

/// The section.
///
/// # Errors
/// [`ReportError::Wrong`] where an exact method does not keep the energy or the distance.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    let mixed = mixed().map_err(ReportError::Wrong)?;
    let gas = melted(1000, 0.6, 0.0).map_err(ReportError::Wrong)?;
    let scenes = [
        ("mixed", "a hundred discs, masses 1:100", mixed),
        ("gas", "a thousand equal discs, area fraction 0.6", gas),
    ];
    let lengths = lengths(effort);
    let (count, mut done) = ((scenes.len() * lengths.len()) as f64, 0.0);
    let mut measured = Vec::new();
    for (k, (name, title, scene)) in scenes.into_iter().enumerate() {
        let mut all = Vec::new();
        for &(mover, events) in &lengths {
            let told = |part: f64| progress((done + part) / count);
            let long = run(&scene, mover, events[k], told);
            all.push(long.map_err(|what| ReportError::Wrong(format!("{title}: {what}")))?);
            done += 1.0;
        }
        measured.push(Measured { name, title, all });
    }
    let mut items: Vec<Item> = Vec::new();
    for scene in &measured {
        items.push(Item::Plot(energy(scene)));
        items.push(Item::Plot(overlap(scene)));
    }
    items.push(Item::Table(table(&measured)));
    let title = "Long runs: what is kept over many events".to_owned();
    Ok(Section { name: "long_time", title, text: text(&measured), items })
}

/// Who runs for how many events, with mixed and with equal discs.
fn lengths(effort: Effort) -> Vec<(Mover, [f64; 2])> {
    let springs = Mover::Springs { stiffness: 1e8, step: 1.0 / 240.0 };
    let full = effort == Effort::Full;
    let events = |quick: [f64; 2], whole: [f64; 2]| if full { whole } else { quick };
    vec![
        (Mover::Events, events([4e6, 4e6], [4e8, 2.5e8])),
        (Mover::Plain, events([4e4, 5e3], [1e6, 1e5])),
        (Mover::Ticks(1.0 / 60.0), events([1e5, 2e5], [3e6, 3e6])),
        (Mover::Steps(1.0 / 240.0), events([1e5, 3e5], [3e6, 1e7])),
        (springs, events([2e4, 1e4], [4e5, 1e5])),
    ]
}

fn mixed() -> Result<Scene, String> {
    let document: Value = serde_json::from_str(MIXED).map_err(|error| error.to_string())?;
    let root = Field::root(&document);
    let setup = root.get("inputs").and_then(|inputs| Setup::read(&inputs));
    let setup = setup.map_err(|error| error.to_string())?;
    Ok(Scene { settings: setup.settings, discs: setup.discs, until: 0.0 })
}

/// Of a course, some three marks a decade.
fn thinned(course: &[(u64, f64, f64)], y: impl Fn(f64, f64) -> f64) -> Vec<Point> {
    let mut next = 0.0;
    let mut points = Vec::new();
    for (k, &(events, drift, overlap)) in course.iter().enumerate() {
        if events as f64 >= next || k + 1 == course.len() {
            points.push(point(events as f64, y(drift, overlap)));
            next = events as f64 * 10f64.powf(0.33);
        }
    }
    points
}

fn plot(scene: &Measured, what: &str, title: &str, y: impl Fn(f64, f64) -> f64 + Copy) -> Plot {
    let curve = |long: &Long| Series {
        label: format!("{} {}", long.mover.method(), long.mover.note()).trim_end().to_owned(),
        kind: Kind::Curve,
        points: thinned(&long.course, y),
    };
    Plot {
        name: format!("long_time_{what}_{}", scene.name),
        title: format!("{title}: {}", scene.title),
        caption: String::new(),
        x: decades("contacts of pairs and walls", "1"),
        y: decades(title, "1"),
        series: scene.all.iter().map(curve).collect(),
    }
}

fn energy(scene: &Measured) -> Plot {
    let mut plot =
        plot(scene, "energy", "Relative drift of the energy", |drift, _| drift.abs().max(NO_DRIFT));
    if let Some(events) = scene.all.first() {
        let (last, ..) = events.end();
        let (from, to) = (FIRST as f64, last as f64);
        let law = |y: &dyn Fn(f64) -> f64| {
            let at = |n: f64| point(n, y(n).max(NO_DRIFT));
            vec![at(from), at(to)]
        };
        let Walk { bias, step, .. } = events.walk;
        plot.series.push(guide("events, wandering: b sqrt(n)", law(&|n| step * n.sqrt())));
        plot.series.push(guide("events, bias, if it is one: a n", law(&|n| bias.abs() * n)));
        let start = 3e-17;
        plot.series.push(guide("slope 1/2", law(&|n| start * (n / from).sqrt())));
        plot.series.push(guide("slope 1", law(&|n| start * (n / from))));
    }
    plot.caption = format!(
        "What wanders grows as the root of the number of events, a bias as the number. a and b are \
         fitted to {PARTS} equal parts of the run of events. Below {NO_DRIFT:e} is drawn there."
    );
    plot
}

fn overlap(scene: &Measured) -> Plot {
    let mut plot =
        plot(scene, "overlap", "Largest overlap so far", |_, overlap| overlap.max(NO_DRIFT));
    plot.y = decades("largest overlap so far", "smaller radii");
    plot.caption = "How far a pair was from touching when it collided, at worst. Of events a gap \
                    counts as well."
        .to_owned();
    plot
}

fn table(all: &[Measured]) -> Table {
    let row = |(scene, long): (&Measured, &Long)| {
        let (events, drift, overlap) = long.end();
        let Walk { bias, bias_error, step } = long.walk;
        vec![
            scene.title.to_owned(),
            long.mover.method().to_string(),
            long.mover.note(),
            format!("{:.1e}", events as f64),
            format!("{drift:+.1e}"),
            format!("{bias:+.1e} +- {bias_error:.0e}"),
            if long.walk.is_biased() { "yes" } else { "no" }.to_owned(),
            format!("{step:.1e}"),
            format!("{overlap:.1e}"),
            short(long.run_s),
        ]
    };
    let rows = all.iter().flat_map(|scene| scene.all.iter().map(move |long| (scene, long)));
    Table {
        name: "long_time".to_owned(),
        title: "All long runs".to_owned(),
        caption:
            "Drift of the energy: a n + b sqrt(n). A bias counts as one beyond three standard \
                  errors."
                .to_owned(),
        columns: vec![
            words("scene"),
            words("method"),
            words("setting"),
            numbers("events n"),
            numbers("drift at the end"),
            numbers("bias a, per event"),
            words("biased"),
            numbers("wandering b"),
            numbers("largest overlap (radii)"),
            times("run time (s)"),
        ],
        rows: rows.map(row).collect(),
    }
}

fn text(all: &[Measured]) -> Vec<String> {
    vec![
        "What becomes of the energy, and of the distance at which discs collide, after very many \
         events? After so long no method knows where a disc is; what it must keep is all that can \
         be asked."
            .to_owned(),
        format!(
            "Two scenes: the reference case C01 (a hundred discs of masses 0.1 to 10 kg, radii \
             0.2 to 0.5 m, between walls) and the gas of the main plot at area fraction 0.6. Each \
             method runs once, from the same start; the energy is summed without rounding at {} \
             times. One run, no repeats: nothing here is a time but the last column of the table.",
            PARTS + 1
        ),
        found(all),
        "Left out: 10^9 events, for which the time of a report does not suffice (events has the \
         most, see the table); longer runs of the slower methods."
            .to_owned(),
    ]
}

fn found(all: &[Measured]) -> String {
    let said = all.iter().flat_map(|scene| {
        let events = scene.all.iter().find(|long| long.mover == Mover::Events);
        events.map(|long| {
            let (events, drift, overlap) = long.end();
            let Walk { bias, bias_error, step } = long.walk;
            let is_biased = if long.walk.is_biased() {
                format!("it has a bias of {bias:+.1e} +- {bias_error:.0e} an event")
            } else {
                format!(
                    "no bias is seen ({bias:+.1e} +- {bias_error:.0e} an event), it wanders as \
                     {step:.0e} sqrt(n)"
                )
            };
            format!(
                "With {}, the energy of events has drifted by {drift:+.1e} after {:.1e} events: \
                 {is_biased}; no pair collided farther than {overlap:.0e} radii from contact.",
                scene.title, events as f64
            )
        })
    });
    said.collect::<Vec<_>>().join(" ")
}
