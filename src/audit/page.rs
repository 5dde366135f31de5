//! What an audit found as a page: plots, tables, the data beside them.
//!
//! The files are drawn by the report. Nothing here judges.

use super::findings::{Break, Collision, Findings, Kind, Violation};
use super::tell;
use crate::referee::Fault;
use crate::report::draw::text::short;
use crate::report::page::{
    Axis, Column, Front, Item, Kind as Shape, Page, Plot, Point, Section, Series, Table,
};

/// Rows of the table of violations.
const ROWS: usize = 500;

/// Parts of the time in which violations are counted.
const BINS: usize = 60;

/// Header of the file of all collisions.
pub const COLLISIONS: &str = "time_s,a,b,x_m,y_m,normal_x,normal_y,approach_mps,gap_m,\
    momentum_off,energy_j,energy_law_j,restitution,restitution_sigma,angle_rad,angle_sigma,wrong,\
    window_s,sight,kinds";

/// A collision as a line of that file; what was not measured is empty.
pub fn row(collision: &Collision) -> String {
    use std::fmt::Write;
    let Collision { time, a, place, normal, approach, gap, momentum, .. } = collision;
    let b = match collision.b {
        super::findings::Met::Disc(b) => b.to_string(),
        super::findings::Met::Wall => "wall".to_owned(),
    };
    let mut line = format!("{time:.9},{a},{b}");
    let numbers = [
        place.x,
        place.y,
        normal.x,
        normal.y,
        *approach,
        *gap,
        *momentum,
        collision.energy,
        collision.energy_law,
        collision.restitution.0,
        collision.restitution.1,
        collision.angle.0,
        collision.angle.1,
        collision.wrong,
        collision.window,
    ];
    for number in numbers {
        let known = number.is_finite();
        // Writing to a string does not fail.
        let _ = if known { write!(line, ",{number:.9e}") } else { write!(line, ",") };
    }
    let kinds: Vec<&str> = collision.kinds.iter().map(Kind::name).collect();
    let sight = format!("{:?}", collision.sight).to_lowercase();
    let _ = write!(line, ",{sight},{}", kinds.join(" "));
    line
}

/// Tables of a page, those that there may be.
const TABLES: [&str; 7] = [
    "audit_kinds",
    "audit_worst",
    "audit_violations",
    "audit_energy",
    "audit_impulses",
    "audit_breaks",
    "audit_crashes",
];

/// Its plots.
const PLOTS: [&str; 5] =
    ["audit_over_time", "audit_restitution", "audit_angle", "audit_momentum", "audit_gap"];

/// Names of all files that an audit may write beside its page.
pub fn names() -> Vec<String> {
    let tables = TABLES.iter().chain(&PLOTS).map(|name| format!("{name}.csv"));
    tables.chain(PLOTS.iter().map(|name| format!("{name}.svg"))).collect()
}

/// The page.
pub fn page(findings: &Findings, name: &str) -> Page {
    let all = findings.violations_in_all();
    let lead = match all {
        0 if findings.counts.not_judged() > 0 => "No violation in what was judged.".to_owned(),
        0 => "No violation.".to_owned(),
        1 => "One violation.".to_owned(),
        _ => format!("{all} violations."),
    };
    let facts = tell::facts(findings, name);
    let front = Front {
        command: "carom audit",
        lead,
        facts: "Recording",
        note: "What was looked at, by what it was judged, and what had to be left open.",
    };
    let machine = facts.into_iter().map(|(name, text)| (name.to_owned(), text)).collect();
    let sections = [violations(findings), collisions(findings), energy(findings), rest(findings)];
    Page { front, machine, sections: sections.into_iter().flatten().collect() }
}

fn axis(label: &str, unit: &str, log: bool) -> Axis {
    Axis { label: label.to_owned(), unit: unit.to_owned(), log, timed: false }
}

fn column(label: &str, number: bool) -> Column {
    Column { label: label.to_owned(), number, timed: false }
}

fn violations(findings: &Findings) -> Option<Section> {
    let by_kind = findings.by_kind.iter().filter(|(_, count)| *count > 0);
    let rows = by_kind
        .map(|(kind, count)| {
            vec![kind.name().to_owned(), count.to_string(), kind.meaning().to_owned()]
        })
        .collect();
    let kinds = Table {
        name: "audit_kinds".to_owned(),
        title: "Violations by kind".to_owned(),
        caption: "Each under the name that fits best.".to_owned(),
        columns: vec![column("kind", false), column("count", true), column("meaning", false)],
        rows,
    };
    let mut items = vec![Item::Table(kinds)];
    if !findings.violations.is_empty() {
        items.push(Item::Plot(over_time(findings)));
        items.push(listed("audit_worst", "The worst", &findings.worst));
        let first = &findings.violations[..findings.violations.len().min(ROWS)];
        items.push(listed("audit_violations", "The first", first));
    }
    let text = vec![
        "A violation is what the recording shows beyond 5 deviations of its own noise, format and \
         stamps, and beyond the tolerance. Severity is the wrong part of the velocities over the \
         relative speed; of what is early, late or out of reach, and of overlaps, the distance or \
         depth over the smaller radius."
            .to_owned(),
    ];
    Some(Section { name: "violations", title: "Violations".to_owned(), text, items })
}

fn listed(name: &str, title: &str, violations: &[Violation]) -> Item {
    let row = |violation: &Violation| {
        let discs: Vec<String> = violation.discs.iter().map(ToString::to_string).collect();
        let also: Vec<&str> = violation.also.iter().map(|kind| kind.name()).collect();
        vec![
            format!("{:.6}", violation.time_s),
            violation.kind.name().to_owned(),
            format!("{}{}", discs.join(", "), if violation.wall { ", wall" } else { "" }),
            format!("{:.4}, {:.4}", violation.place_m[0], violation.place_m[1]),
            short(violation.approach_speed_mps),
            short(violation.severity),
            also.join(", "),
            violation.detail.clone(),
        ]
    };
    Item::Table(Table {
        name: name.to_owned(),
        title: title.to_owned(),
        caption: "Times of the recording's clock.".to_owned(),
        columns: vec![
            column("time (s)", true),
            column("kind", false),
            column("discs", false),
            column("place (m)", false),
            column("approach (m/s)", true),
            column("severity", true),
            column("also", false),
            column("detail", false),
        ],
        rows: violations.iter().map(row).collect(),
    })
}

/// Violations of each kind over the time.
fn over_time(findings: &Findings) -> Plot {
    let (from, to) = findings.times;
    let width = ((to - from) / BINS as f64).max(f64::MIN_POSITIVE);
    let series = findings.by_kind.iter().filter(|(_, count)| *count > 0).map(|(kind, _)| {
        let mut counts = [0u32; BINS];
        for violation in findings.violations.iter().filter(|each| each.kind == *kind) {
            let bin = ((violation.time_s - from) / width).max(0.0) as usize;
            counts[bin.min(BINS - 1)] += 1;
        }
        let point = |(k, count): (usize, &u32)| Point {
            x: from + (k as f64 + 0.5) * width,
            y: f64::from(*count),
            spread: None,
            note: String::new(),
        };
        let points = counts.iter().enumerate().map(point).collect();
        Series { label: kind.name().to_owned(), kind: Shape::Curve, points }
    });
    Plot {
        name: "audit_over_time".to_owned(),
        title: "When".to_owned(),
        caption: format!("The first {} violations.", findings.violations.len()),
        x: axis("time", "s", false),
        y: axis("violations", "1", false),
        series: series.collect(),
    }
}

/// A number of a collision and its deviation.
type Number = fn(&Collision) -> (f64, f64);

/// What is drawn of collisions of two discs alone: name, title, ordinate, number.
fn drawn() -> [(&'static str, &'static str, Axis, Number); 4] {
    [
        ("audit_restitution", "Implied restitution", axis("restitution", "1", false), |each| {
            each.restitution
        }),
        (
            "audit_angle",
            "From the line of centres to the impulse",
            axis("angle", "rad", false),
            |each| each.angle,
        ),
        (
            "audit_momentum",
            "Momentum gained, of what was exchanged",
            axis("momentum gained", "1", true),
            |each| (each.momentum.max(1e-17), 0.0),
        ),
        (
            "audit_gap",
            "Distance of the surfaces when the velocities changed",
            axis("gap", "m", false),
            |each| (each.gap, 0.0),
        ),
    ]
}

/// Collisions of two discs alone.
fn collisions(findings: &Findings) -> Option<Section> {
    let measured = |each: &&Collision| each.restitution.1.is_finite() && each.approach > 0.0;
    let all: Vec<&Collision> = findings.plotted.collisions().iter().filter(measured).collect();
    if all.is_empty() {
        return None;
    }
    let caption = format!(
        "Collisions of two discs alone; one of {} is drawn. Bars are a deviation to both sides.",
        findings.plotted.every()
    );
    let mut plots = drawn().map(|(name, title, y, value)| {
        let mut series = [(true, "lawful"), (false, "not")].map(|(lawful, label)| {
            let which = all.iter().filter(|each| each.kinds.is_empty() == lawful);
            let points = which.map(|each| point(each, value)).collect();
            Series { label: label.to_owned(), kind: Shape::Marks, points }
        });
        series.reverse();
        let series = series.into_iter().filter(|series| !series.points.is_empty()).collect();
        let [name, title] = [name, title].map(str::to_owned);
        let x = axis("speed of approach", "m/s", true);
        Plot { name, title, caption: caption.clone(), x, y, series }
    });
    plots[0].series.extend(findings.law.restitution.map(|law| guide(&all, law)));
    let text = "Of two discs that met nobody else between two samples everything is measured: \
                when and where they had to meet, when the velocities changed, and how. All \
                collisions are in the file `collisions.csv` beside this page.";
    let (title, text) = ("Collisions of two discs".to_owned(), vec![text.to_owned()]);
    let items = plots.map(Item::Plot).to_vec();
    Some(Section { name: "collisions", title, text, items })
}

fn point(collision: &Collision, value: Number) -> Point {
    let (y, sigma) = value(collision);
    let sigma = sigma.min(1.0);
    let spread = (sigma > 0.0).then_some((y - sigma, y + sigma));
    Point { x: collision.approach, y, spread, note: format!("{:.6} s", collision.time) }
}

/// The law, over all speeds.
fn guide(all: &[&Collision], law: f64) -> Series {
    let speeds = || all.iter().map(|each| each.approach);
    let ends = [speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max)];
    let point = |x| Point { x, y: law, spread: None, note: String::new() };
    Series { label: "law".to_owned(), kind: Shape::Guide, points: ends.map(point).to_vec() }
}

fn energy(findings: &Findings) -> Option<Section> {
    let ledger = findings.ledger;
    let row = |what: &str, gained: f64, law: Option<f64>| {
        // Of a restitution that nobody knows there is no law.
        let known = law.filter(|law| !law.is_nan());
        let law = known.map_or(String::new(), |law| format!("{law:.9e}"));
        vec![what.to_owned(), format!("{gained:.9e}"), law]
    };
    let rows = vec![
        row("collisions of two discs alone", ledger.pairs_j, Some(ledger.pairs_law_j)),
        row("groups of collisions", ledger.clusters_j, Some(ledger.clusters_law_j)),
        row("walls", ledger.walls_j, None),
        row("changes without a partner", ledger.unexplained_j, None),
        row("in all, from the first to the last sample", ledger.last_j - ledger.first_j, None),
    ];
    let table = Table {
        name: "audit_energy".to_owned(),
        title: "Kinetic energy by what changed it".to_owned(),
        caption: "Groups that could not be told apart count as lawful here.".to_owned(),
        columns: vec![column("by", false), column("gained (J)", true), column("law (J)", true)],
        rows,
    };
    let (title, items) = ("Energy".to_owned(), vec![Item::Table(table)]);
    Some(Section { name: "energy", title, text: Vec::new(), items })
}

/// What was no collision: impulses without a partner, breaks, crashes.
fn rest(findings: &Findings) -> Option<Section> {
    let mut items = Vec::new();
    let impulse = |each: &super::findings::Impulse| {
        let [vx, vy] = each.change_mps;
        vec![
            format!("{:.6}", each.time_s),
            each.disc.to_string(),
            format!("{:.4}, {:.4}", each.place_m[0], each.place_m[1]),
            format!("{vx:.4e}, {vy:.4e}"),
        ]
    };
    items.push(Table {
        name: "audit_impulses".to_owned(),
        title: "Changes of one disc alone".to_owned(),
        caption: "Walls that are not known, drives, hands.".to_owned(),
        columns: vec![
            column("time (s)", true),
            column("disc", true),
            column("place (m)", false),
            column("change (m/s)", false),
        ],
        rows: findings.impulses.iter().take(ROWS).map(impulse).collect(),
    });
    items.push(Table {
        name: "audit_breaks".to_owned(),
        title: "Holes and leaps".to_owned(),
        caption: "Nothing is judged across them but short gaps.".to_owned(),
        columns: vec![column("time (s)", true), column("what", false)],
        rows: findings.breaks.iter().take(ROWS).map(broken).collect(),
    });
    let crash = |each: &super::findings::Crash| {
        let [a, b] = each.discs;
        vec![
            format!("{:.6}", each.time_s),
            format!("{a}, {b}"),
            format!("{:.4}, {:.4}", each.place_m[0], each.place_m[1]),
            short(each.approach_speed_mps),
            format!("{:.4}, {:.4}", each.speeds_mps[0], each.speeds_mps[1]),
            match each.fault {
                Fault::First => a.to_string(),
                Fault::Second => b.to_string(),
                Fault::Both => "both".to_owned(),
            },
        ]
    };
    items.push(Table {
        name: "audit_crashes".to_owned(),
        title: "Crashes".to_owned(),
        caption: "Collisions above the speed that was asked for.".to_owned(),
        columns: vec![
            column("time (s)", true),
            column("discs", false),
            column("place (m)", false),
            column("approach (m/s)", true),
            column("speeds (m/s)", false),
            column("fault", false),
        ],
        rows: findings.crashes.iter().take(ROWS).map(crash).collect(),
    });
    items.retain(|table| !table.rows.is_empty());
    let items: Vec<Item> = items.into_iter().map(Item::Table).collect();
    let title = "Besides".to_owned();
    (!items.is_empty()).then_some(Section { name: "besides", title, text: Vec::new(), items })
}

fn broken(each: &Break) -> Vec<String> {
    let (time, what) = match each {
        Break::Gap { time_s, missing } => (time_s, format!("about {missing} samples missing")),
        Break::Reset { time_s } => (time_s, "time went back".to_owned()),
        Break::Teleport { time_s, disc } => (time_s, format!("disc {disc} is somewhere else")),
    };
    vec![format!("{time:.6}"), what]
}
