//! What an audit found, in words and as one JSON object.

use std::io::{self, Write};

use glam::DVec2;
use serde::Serialize;

use super::findings::{Break, Counts, Crash, Findings, Impulse, Kind, Ledger, Violation, WORST};
use super::law::Source;
use crate::referee::Fault;
use crate::world::Walls;

/// Violations, impulses and breaks in the JSON object, at most of each.
const LISTED: usize = 1_000;

/// Writes what a person reads.
///
/// # Errors
/// Those of the output.
pub fn words(findings: &Findings, name: &str, out: &mut impl Write) -> io::Result<()> {
    for (label, text) in facts(findings, name) {
        writeln!(out, "{label:<12} {text}")?;
    }
    writeln!(out)?;
    verdict(findings, out)?;
    if !findings.worst.is_empty() {
        writeln!(out, "\nthe worst:")?;
    }
    for violation in findings.worst.iter().take(WORST) {
        writeln!(out, "  {}", line(violation))?;
    }
    crashes(findings, out)
}

fn verdict(findings: &Findings, out: &mut impl Write) -> io::Result<()> {
    let all = findings.violations_in_all();
    if all == 0 {
        return writeln!(out, "{}", clean(&findings.counts));
    }
    writeln!(out, "{all} violations")?;
    for (kind, count) in findings.by_kind.iter().filter(|(_, count)| *count > 0) {
        writeln!(out, "  {count:>8} {:<18} {}", kind.name(), kind.meaning())?;
    }
    Ok(())
}

/// The verdict where nothing is wrong: not more than was looked at.
pub fn clean(counts: &Counts) -> String {
    if counts.not_judged() == 0 {
        return "no violation".to_owned();
    }
    let open = (counts.ambiguous, "groups of contacts that could not be told apart");
    let parts = [&[open], &unseen(counts)[..]].concat();
    format!("no violation in what was judged; not judged: {}", listed(&parts))
}

/// Where contacts may have been that nobody looked for.
fn unseen(counts: &Counts) -> [(u64, &'static str); 5] {
    [
        (
            counts.beside,
            "changes at segments, robots that kick, commanded pucks or observed circles",
        ),
        (counts.unpaired, "states of discs that were not there, or were others, a sample before"),
        (counts.repeated, "sets of samples with the stamp of the one before"),
        (counts.heaped, "stamps with discs heaped on each other"),
        (counts.far, "stamps before which discs may have flown far round the periodic box"),
    ]
}

/// How many of what, of those that there are.
fn listed(parts: &[(u64, &str)]) -> String {
    let parts = parts.iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts.map(|(count, what)| format!("{count} {what}")).collect();
    parts.join(", ")
}

fn crashes(findings: &Findings, out: &mut impl Write) -> io::Result<()> {
    let Some(limit) = findings.crash_speed else { return Ok(()) };
    let count = findings.crashes_in_all;
    writeln!(out, "\n{count} collisions faster than {limit} m/s along the line of centres")?;
    for crash in &findings.crashes {
        let Crash { time_s, discs: [a, b], approach_speed_mps, speeds_mps: [va, vb], .. } = crash;
        let fault = match crash.fault {
            Fault::First => a.to_string(),
            Fault::Second => b.to_string(),
            Fault::Both => "both".to_owned(),
        };
        writeln!(
            out,
            "  {time_s:>12.6} s  {a} and {b}: {approach_speed_mps:.3} m/s (speeds {va:.3}, \
             {vb:.3} m/s), fault: {fault}"
        )?;
    }
    Ok(())
}

/// One violation in a line.
pub fn line(violation: &Violation) -> String {
    let Violation { kind, time_s, discs, place_m: [x, y], severity, detail, .. } = violation;
    let mut who: Vec<String> = discs.iter().map(ToString::to_string).collect();
    if violation.wall {
        who.push("wall".to_owned());
    }
    let who = who.join(", ");
    let severity =
        if *severity < 1e4 { format!("{severity:.3}") } else { format!("{severity:.3e}") };
    format!(
        "{time_s:>12.6} s  {:<18} {who}  at ({x:.3}, {y:.3}) m, {:.3} m/s, severity {severity}: \
         {detail}",
        kind.name(),
        violation.approach_speed_mps
    )
}

/// What was looked at and by what it was judged: name and text.
pub fn facts(findings: &Findings, name: &str) -> Vec<(&'static str, String)> {
    let Findings { counts, times, usual_step, .. } = findings;
    let mut facts = vec![
        ("recording", name.to_owned()),
        (
            "samples",
            format!(
                "{} of up to {} discs at {} stamps, {:.3} s to {:.3} s, usually {:.4} ms apart",
                counts.samples,
                counts.discs,
                counts.frames,
                times.0,
                times.1,
                1e3 * usual_step
            ),
        ),
    ];
    facts.extend(of_law(findings));
    facts.extend(of_judgement(findings));
    let left = left_out(counts);
    if !left.is_empty() {
        facts.push(("not judged", left));
    }
    if counts.carried > 0 {
        let carried = counts.carried;
        let text = format!("{carried} states of discs silent at a stamp, along their flight to it");
        facts.push(("carried", text));
    }
    let said = findings.said.iter().cloned();
    facts.extend(said.map(|text| ("note", text)));
    facts
}

fn source(source: Source) -> &'static str {
    match source {
        Source::Told => "told",
        Source::Estimated => "estimated",
        Source::Unknown => "unknown",
    }
}

fn of_law(findings: &Findings) -> Vec<(&'static str, String)> {
    let law = &findings.law;
    let restitution = match law.restitution {
        Some(e) => format!("restitution {e:.6} ({})", source(law.restitution_source)),
        None => "restitution unknown: too few collisions of two discs alone".to_owned(),
    };
    let motion = match (law.gravity.length() > 0.0, law.drag > 0.0) {
        (false, false) => "free motion without drag or gravity".to_owned(),
        (true, _) => format!("gravity ({:.6}, {:.6}) m/s^2", law.gravity.x, law.gravity.y),
        (_, true) => format!("drag {:.6} 1/s", law.drag),
    };
    let walls = match (law.walls, law.periodic) {
        (Some(walls), _) => {
            let Walls { min, max, restitution } = walls;
            let (bounds, source) = (bounds(min, max), source(law.walls_source));
            format!("walls {bounds}, restitution {restitution:.6} ({source})")
        }
        (None, Some(periodic)) => {
            format!("periodic box {} (told)", bounds(periodic.min, periodic.max))
        }
        (None, None) if law.walls_source == Source::Told => "no walls (told)".to_owned(),
        (None, None) => "walls unknown".to_owned(),
    };
    let noise = findings.noise;
    let format = if noise.single { "4-byte numbers" } else { "8-byte numbers" };
    vec![
        ("law", format!("{restitution}; {motion}; {walls}")),
        ("noise", format!("{:.1e} m, {:.1e} m/s, {format}", noise.position, noise.velocity)),
        (
            "violation",
            format!(
                "beyond 5 deviations and {:.1e} of what is exchanged, of the restitution, of the \
                 smaller radius, rad",
                findings.tolerance
            ),
        ),
    ]
}

/// A box in words; a wall that nobody reached is `-`.
fn bounds(min: DVec2, max: DVec2) -> String {
    let [a, b, c, d] = [min.x, max.x, min.y, max.y]
        .map(|x| if x.abs() < 1e100 { format!("{x:.6}") } else { "-".to_owned() });
    format!("x {a} to {b}, y {c} to {d} m")
}

fn of_judgement(findings: &Findings) -> Vec<(&'static str, String)> {
    let Counts { alone, foretold, singled, walls, ambiguous, unexplained, vague, .. } =
        findings.counts;
    let Ledger { first_j, last_j, pairs_j, pairs_law_j, clusters_j, .. } = findings.ledger;
    let by_law =
        if pairs_law_j.is_nan() { "unknown".to_owned() } else { format!("{pairs_law_j:+.6} J") };
    vec![
        (
            "judged",
            format!(
                "{alone} collisions of two discs alone, {foretold} among several as the law \
                 foretells, {singled} singled out; {walls} at walls"
            ),
        ),
        (
            "left open",
            format!(
                "{ambiguous} groups of contacts that could not be told apart; {unexplained} \
                 changes of one disc alone (walls, drives); {vague} collisions too weak or grazing \
                 to tell a restitution"
            ),
        ),
        (
            "energy",
            format!(
                "{first_j:.6} J to {last_j:.6} J; two discs alone {pairs_j:+.6} J (by the law \
                 {by_law}), groups {clusters_j:+.6} J, walls {:+.6} J, unexplained \
                 {:+.6} J",
                findings.ledger.walls_j, findings.ledger.unexplained_j
            ),
        ),
        (
            "overlaps",
            format!(
                "{}, the deepest {:.3e} smaller radii",
                findings.overlaps, findings.deepest_overlap
            ),
        ),
    ]
}

fn left_out(counts: &Counts) -> String {
    let parts = [
        (counts.gaps, "gaps with samples missing"),
        (counts.resets, "times at which time went back"),
        (counts.teleports, "discs put elsewhere"),
        (counts.displaced, "small displacements without a cause"),
        (counts.unsound, "states that are no discs or have an id that is taken"),
    ];
    listed(&[&parts[..], &unseen(counts)].concat())
}

/// All of it for a program.
#[derive(Serialize)]
struct Told<'a> {
    recording: &'a str,
    first_s: f64,
    last_s: f64,
    usual_step_s: f64,
    law: ToldLaw,
    position_noise_m: f64,
    velocity_noise_mps: f64,
    single_precision: bool,
    tolerance: f64,
    counts: &'a Counts,
    energy: &'a Ledger,
    overlaps: u64,
    deepest_overlap_radii: f64,
    violations: u64,
    not_judged: u64,
    by_kind: Vec<(Kind, u64)>,
    worst: &'a [Violation],
    first: &'a [Violation],
    impulses: &'a [Impulse],
    breaks: &'a [Break],
    crashes: &'a [Crash],
    notes: &'a [String],
}

#[derive(Serialize)]
struct ToldLaw {
    restitution: Option<f64>,
    restitution_source: Source,
    walls_min_m: Option<[f64; 2]>,
    walls_max_m: Option<[f64; 2]>,
    walls_restitution: Option<f64>,
    walls_source: Source,
    periodic_min_m: Option<[f64; 2]>,
    periodic_max_m: Option<[f64; 2]>,
    gravity_mps2: [f64; 2],
    drag_per_s: f64,
    motion_source: Source,
}

/// Writes what a program reads.
///
/// # Errors
/// Those of the output.
pub fn json(findings: &Findings, name: &str, out: &mut impl Write) -> io::Result<()> {
    fn first<T>(all: &[T]) -> &[T] {
        &all[..all.len().min(LISTED)]
    }
    let (law, noise) = (&findings.law, &findings.noise);
    let told = Told {
        recording: name,
        first_s: findings.times.0,
        last_s: findings.times.1,
        usual_step_s: findings.usual_step,
        law: ToldLaw {
            restitution: law.restitution,
            restitution_source: law.restitution_source,
            walls_min_m: law.walls.map(|walls| walls.min.to_array()),
            walls_max_m: law.walls.map(|walls| walls.max.to_array()),
            walls_restitution: law.walls.map(|walls| walls.restitution),
            walls_source: law.walls_source,
            periodic_min_m: law.periodic.map(|periodic| periodic.min.to_array()),
            periodic_max_m: law.periodic.map(|periodic| periodic.max.to_array()),
            gravity_mps2: law.gravity.to_array(),
            drag_per_s: law.drag,
            motion_source: law.motion_source,
        },
        position_noise_m: noise.position,
        velocity_noise_mps: noise.velocity,
        single_precision: noise.single,
        tolerance: findings.tolerance,
        counts: &findings.counts,
        energy: &findings.ledger,
        overlaps: findings.overlaps,
        deepest_overlap_radii: findings.deepest_overlap,
        violations: findings.violations_in_all(),
        not_judged: findings.counts.not_judged(),
        by_kind: findings.by_kind.iter().filter(|(_, count)| *count > 0).copied().collect(),
        worst: &findings.worst,
        first: first(&findings.violations),
        impulses: first(&findings.impulses),
        breaks: first(&findings.breaks),
        crashes: first(&findings.crashes),
        notes: &findings.said,
    };
    let text = serde_json::to_string_pretty(&told).map_err(io::Error::from)?;
    writeln!(out, "{text}")
}
