//! What a collision costs: against the number of discs, the density, the sizes, and in memory.
//!
//! Every run is one of `carom bench gas`, judged before its time is told: the collision rate by
//! kinetic theory in the fluid and by the free volume in the crystal, the energy and the distance
//! at contact in all. A wrong run ends the report.

use super::items::{decades, numbers, short, timed, times, words};
use crate::bench::gas::Gas;
use crate::bench::{self, Measured};
use crate::plan::Method;
use crate::report::page::{Item, Kind, Plot, Point, Section, Series, Table};
use crate::report::{Effort, Progress, ReportError};
use crate::scene::lattice::Lattice;

/// Seed of all gases.
const SEED: u64 = 1;
/// Collisions of a disc before anything is measured.
const MELT: f64 = 6.0;
/// The step of methods that have one, and the tick, s.
const STEP_S: f64 = 1.0 / 240.0;

/// Area fraction of the crystal, and by what part its rate may differ from theory.
const CRYSTAL: f64 = 0.88;
const CRYSTAL_RATE: f64 = 0.04;

/// Numbers of discs that fill a triangular lattice that nearly fits a square, from 100 on by
/// decades: 12 x 14, 26 x 30, 97 x 112, 305 x 352, 923 x 1066.
const CRYSTALS: [usize; 5] = [168, 780, 10_864, 107_360, 983_918];

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Size {
    /// Decades of the number of discs, the first one 2.
    pub decades: usize,
    /// Collisions that are timed: so many of a disc, and at least so many.
    pub collisions: (u64, u64),
    /// Timed blocks.
    pub blocks: u32,
    /// Numbers of discs for the look at all pairs.
    pub few: Vec<usize>,
    /// Numbers of discs for methods with steps.
    pub stepped: Vec<usize>,
}

impl Size {
    /// For this effort.
    pub fn of(effort: Effort) -> Self {
        match effort {
            Effort::Quick => Self {
                decades: 4,
                collisions: (3, 60_000),
                blocks: 5,
                few: vec![16, 32, 64, 128],
                stepped: vec![1_000],
            },
            Effort::Full => Self {
                decades: 5,
                collisions: (5, 400_000),
                blocks: 11,
                few: vec![16, 24, 32, 48, 64, 96, 128, 256, 512],
                stepped: vec![1_000, 10_000],
            },
        }
    }
}

/// One run.
#[derive(Clone, Copy, Debug)]
struct Run {
    gas: Gas,
    method: Method,
}

/// One curve: what it is called, and its runs.
struct Curve {
    label: String,
    runs: Vec<Run>,
}

/// A run and what it gave.
type Told = (Run, Measured);

/// Measures the section.
///
/// # Errors
/// [`ReportError::Wrong`] when a run is.
pub fn section(effort: Effort, progress: Progress) -> Result<Section, ReportError> {
    section_of(&Size::of(effort), progress)
}

/// The same to a given size.
///
/// # Errors
/// As [`section`].
pub fn section_of(size: &Size, progress: Progress) -> Result<Section, ReportError> {
    let [densities, sizes, few] = [by_density(size), by_sizes(size), by_few(size)];
    let stepped = stepped(size);
    let all = [&densities, &sizes, &few, &stepped].into_iter().flatten();
    let effort = |run: &Run| (size.collisions.1 as f64).max(10.0 * run.gas.lattice.count as f64);
    let whole: f64 = all.flat_map(|curve| &curve.runs).map(effort).sum();
    let mut done = 0.0;
    let mut measure = |curves: &[Curve]| -> Result<Vec<(String, Vec<Told>)>, ReportError> {
        let mut told = Vec::new();
        for Curve { label, runs } in curves {
            let mut points = Vec::new();
            for run in runs {
                points.push((*run, measured(run, size)?));
                done += effort(run);
                progress(done / whole);
            }
            told.push((label.clone(), points));
        }
        Ok(told)
    };
    // Memory is told of the first, before anything else has filled and freed it.
    let densities = measure(&densities)?;
    let (sizes, few, stepped) = (measure(&sizes)?, measure(&few)?, measure(&stepped)?);
    let titles = [
        ("scaling_density", "Equal discs at four densities", ""),
        ("scaling_sizes", "Discs of very different sizes", ""),
        ("scaling_few", "Few discs: all pairs or a calendar", FEW),
    ];
    let everything = [&densities, &sizes, &few].into_iter().flatten();
    let table = table(everything.flat_map(|(_, told)| told));
    let plots = titles.into_iter().zip([&densities, &sizes, &few]);
    let mut items: Vec<Item> =
        plots.map(|(words, curves)| Item::Plot(plot(words, curves, size))).collect();
    items.extend([Item::Table(methods_table(&stepped)), Item::Table(table)]);
    let title = "What a collision costs".to_owned();
    Ok(Section { name: "scaling", title, text: text(size), items })
}

fn gas(count: usize, area_fraction: f64, size_ratio: f64, walled: bool) -> Gas {
    let lattice = Lattice { count, area_fraction, size_ratio, mass_max: 1.0, walled, seed: SEED };
    Gas { lattice, spread: false, restitution: 1.0, melt: MELT, step: STEP_S }
}

fn by_density(size: &Size) -> Vec<Curve> {
    let counts = |phi: f64| -> Vec<usize> {
        let usual = |k: usize| 10usize.pow(k as u32 + 2);
        let crystal = phi == CRYSTAL;
        (0..size.decades).map(|k| if crystal { CRYSTALS[k] } else { usual(k) }).collect()
    };
    // The first is that whose memory is told.
    let curve = |phi: f64| {
        let run = |count: &usize| Run { gas: gas(*count, phi, 1.0, false), method: Method::Events };
        let state = if phi == CRYSTAL { ", a crystal" } else { "" };
        Curve {
            label: format!("area fraction {phi}{state}"),
            runs: counts(phi).iter().map(run).collect(),
        }
    };
    [0.5, 0.1, 0.7, CRYSTAL].map(curve).into()
}

fn by_sizes(size: &Size) -> Vec<Curve> {
    let curve = |(label, phi, ratio, spread, decades): (&str, f64, f64, bool, usize)| {
        let run = |k: usize| {
            let count = 10usize.pow(k as u32 + 2);
            let gas = Gas { spread, ..gas(count, phi, ratio, false) };
            Run { gas, method: Method::Events }
        };
        let runs = (1..size.decades.min(decades)).map(run).collect();
        Curve { label: label.to_owned(), runs }
    };
    let curves = [
        ("equal, area fraction 0.3", 0.3, 1.0, false, 5),
        ("two sizes 1:1000, 0.3", 0.3, 1000.0, false, 5),
        ("two sizes 1:1000, 0.1", 0.1, 1000.0, false, 4),
        ("all sizes 1:1000, 0.3", 0.3, 1000.0, true, 5),
        ("all sizes 1:1000, 0.5", 0.5, 1000.0, true, 4),
    ];
    curves.map(curve).into()
}

fn by_few(size: &Size) -> Vec<Curve> {
    let curve = |(label, method): (&str, Method)| {
        let run = |count: &usize| Run { gas: gas(*count, 0.5, 1.0, true), method };
        Curve { label: label.to_owned(), runs: size.few.iter().map(run).collect() }
    };
    [("plain: all pairs", Method::Plain), ("events: a calendar", Method::Events)].map(curve).into()
}

fn stepped(size: &Size) -> Vec<Curve> {
    let methods = [Method::Events, Method::Ticks, Method::Steps, Method::Springs];
    let curve = |method: Method| {
        let run = |count: &usize| Run { gas: gas(*count, 0.3, 1.0, true), method };
        Curve { label: method.to_string(), runs: size.stepped.iter().map(run).collect() }
    };
    methods.map(curve).into()
}

fn measured(run: &Run, size: &Size) -> Result<Measured, ReportError> {
    let Run { gas, method } = *run;
    let each = match method {
        // So many steps as well.
        Method::Steps | Method::Springs | Method::Ticks => {
            (2 * gas.lattice.count as u64).max(2_000)
        }
        // The time of one grows with the number of discs.
        Method::Plain => size.collisions.1 / 3,
        _ => (size.collisions.0 * gas.lattice.count as u64).max(size.collisions.1),
    };
    let options = bench::Options {
        gas,
        method: Some(method),
        keep_all: false,
        collisions: each,
        portable: false,
        json: false,
    };
    let wrong =
        |what: String| ReportError::Wrong(format!("scaling, {gas}, method {method}: {what}"));
    let measured =
        bench::measure(&options, size.blocks).map_err(|error| wrong(error.to_string()))?;
    measured.judgement.verdict().map_err(wrong)?;
    if gas.lattice.area_fraction == CRYSTAL && gas.lattice.count > 500 {
        let (rate, expected) = (measured.judgement.rate, crystal_rate(CRYSTAL));
        let off = rate / expected - 1.0;
        if off.is_nan() || off.abs() > CRYSTAL_RATE {
            return Err(wrong(format!("{rate:.3} collisions a disc and s, must be {expected:.3}")));
        }
    }
    Ok(measured)
}

/// Collisions of a disc per second near close packing, with `kT = m = d = 1`:
/// `4 (Z - 1) / sqrt(pi)` with `Z = 2/a + 1.90 + 0.67 a`, `a` the free part of the area (Alder,
/// Hoover, Young, doi:10.1063/1.1670653).
fn crystal_rate(area_fraction: f64) -> f64 {
    let closest = std::f64::consts::PI / 12f64.sqrt();
    let a = closest / area_fraction - 1.0;
    let z = 2.0 / a + 1.90 + 0.67 * a;
    4.0 * (z - 1.0) / std::f64::consts::PI.sqrt()
}

fn text(size: &Size) -> Vec<String> {
    vec![
        "The exact method pays for collisions, not for time or area: empty space is free. What one \
         collision costs hardly depends on the number of discs until they no longer fit the \
         caches, and little on their density; discs of very different sizes cost more."
            .to_owned(),
        format!(
            "Measured as carom bench gas does: a gas of seed {SEED} melts from a lattice in a \
             periodic box for {MELT} collisions of a disc, untimed, then {} collisions of a disc, \
             at least {}, are timed in {} blocks; told is the median, the bars reach from the \
             least to the largest. One thread.",
            size.collisions.0, size.collisions.1, size.blocks
        ),
        format!(
            "Judged before a time is told: at area fractions up to 0.5 the collision rate of equal \
             discs must be that of kinetic theory within 3 %, in the crystal that of Alder, Hoover \
             and Young within {} %, energy and distance at contact right to 1e-9 everywhere.",
            100.0 * CRYSTAL_RATE
        ),
        "Left out: the rate at area fraction 0.7, where fluid and crystal coexist and a lattice \
         takes hundreds of collisions to melt, and that of mixed sizes, for which there is no such \
         number; two sizes 1:1000 above 0.45 and all sizes above 0.5, which find no start; a \
         million discs in the quick report, and where mixed sizes make that long. The numbers \
         of discs of the crystal are those that fill a lattice."
            .to_owned(),
    ]
}

/// What to know of the look at all pairs.
const FEW: &str = " Area fraction 0.5 between walls. The method plain looks at all pairs for every \
                   event and carries twice the digits: it is the judge of the other.";

fn plot(
    (name, title, more): (&str, &str, &str),
    curves: &[(String, Vec<Told>)],
    size: &Size,
) -> Plot {
    let point = |(run, measured): &Told| Point {
        x: run.gas.lattice.count as f64,
        y: measured.ns_per_collision,
        spread: Some((measured.ns_per_collision_min, measured.ns_per_collision_max)),
        note: String::new(),
    };
    let series = curves.iter().map(|(label, told)| Series {
        label: label.clone(),
        kind: Kind::Curve,
        points: told.iter().map(point).collect(),
    });
    Plot {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: format!("Median of {} blocks, seed {SEED}.{more}", size.blocks),
        x: decades("discs", "1"),
        y: timed("run time of a collision", "ns"),
        series: series.collect(),
    }
}

fn table<'a>(told: impl Iterator<Item = &'a Told>) -> Table {
    let rows = told.map(|(run, measured)| {
        let Lattice { count, area_fraction, size_ratio, walled, .. } = run.gas.lattice;
        let sizes = match (size_ratio == 1.0, run.gas.spread) {
            (true, _) => "equal".to_owned(),
            (_, false) => format!("two, 1:{size_ratio}"),
            (_, true) => format!("all, 1:{size_ratio}"),
        };
        let judgement = &measured.judgement;
        let crystal = (area_fraction == CRYSTAL).then(|| crystal_rate(CRYSTAL));
        let expected = judgement.rate_expected.map(|(rate, _)| rate).or(crystal);
        // Of few discs the system tells no more than noise.
        let bytes = measured.bytes_per_disc.filter(|_| count >= 10_000 && area_fraction == 0.5);
        vec![
            count.to_string(),
            area_fraction.to_string(),
            sizes,
            format!("{}, {}", run.method, if walled { "walls" } else { "periodic" }),
            format!("{:.1}", measured.ns_per_collision),
            format!("{:.1}", measured.ns_per_collision_min),
            format!("{:.3}", judgement.rate),
            expected.map_or("-".to_owned(), |rate| format!("{rate:.3}")),
            format!("{:+.1e}", judgement.energy_drift),
            short(judgement.largest_miss),
            bytes.filter(|_| !run.gas.spread).map_or("-".to_owned(), |bytes| format!("{bytes:.0}")),
        ]
    });
    Table {
        name: "scaling_runs".to_owned(),
        title: "Every run, and what was judged".to_owned(),
        caption:
            "Rate: collisions of a disc in a second of its time. Memory: resident memory that \
                  the arena took, told where it is more than noise."
                .to_owned(),
        columns: vec![
            numbers("discs"),
            numbers("area fraction"),
            words("sizes"),
            words("method"),
            times("time of a collision, median (ns)"),
            times("least (ns)"),
            numbers("rate (1/s)"),
            numbers("theory (1/s)"),
            numbers("energy drift"),
            numbers("farthest from contact (radii)"),
            times("memory of a disc (bytes)"),
        ],
        rows: rows.collect(),
    }
}

/// Methods beside each other: what a disc costs in each step of its time.
fn methods_table(curves: &[(String, Vec<Told>)]) -> Table {
    let told = curves.iter().flat_map(|(_, told)| told);
    let rows = told.map(|(run, measured)| {
        let judgement = &measured.judgement;
        // Half a collision belongs to each of two discs.
        let in_step = |ns: f64| ns * 0.5 * judgement.rate * STEP_S;
        let step = measured.ns_per_disc_step.unwrap_or(in_step(measured.ns_per_collision));
        let share =
            |part: Option<f64>| part.map_or("-".to_owned(), |part| format!("{:.2}", 100.0 * part));
        vec![
            run.method.to_string(),
            run.gas.lattice.count.to_string(),
            format!("{step:.1}"),
            format!("{:.0}", measured.ns_per_collision),
            format!("{:.0}", measured.ns_per_collision_min),
            format!("{:+.1e}", judgement.energy_drift),
            share(judgement.late),
            share(judgement.missed),
        ]
    });
    Table {
        name: "scaling_methods".to_owned(),
        title: "Methods beside each other: 1/240 s of a disc".to_owned(),
        caption: "Equal discs at area fraction 0.3 between walls, speeds of about a diameter a \
                  second; springs of 10^4 N/m. Exact methods have no step: told is what 1/240 s \
                  of a disc costs by the collisions in it."
            .to_owned(),
        columns: vec![
            words("method"),
            numbers("discs"),
            times("1/240 s of a disc (ns)"),
            times("a collision, median (ns)"),
            times("least (ns)"),
            numbers("energy drift"),
            numbers("contacts late (%)"),
            numbers("missed (%)"),
        ],
        rows: rows.collect(),
    }
}
