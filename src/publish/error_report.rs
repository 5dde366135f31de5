//! The error report: how an interval of wall time went, as `error_report` and `/diagnostics`.
//!
//! What a step costs here is one entry in a table of durations, whose clock the caller reads
//! anyway. All sums over pucks are made when a report is, never at a step.

use std::time::Duration;

use crate::messages::{DiagnosticArray, DiagnosticStatus, ErrorReport, Header, KeyValue, Time};
use crate::motion::arena::Arena;
use crate::receive::Refused;

/// Part of the real-time factor asked for below which it counts as missed.
const REAL_TIME: f64 = 0.9;

/// Binary digits behind the leading one by which durations are told apart.
const DIGITS: u32 = 5;
/// From nanoseconds to beyond a minute, in octaves.
const OCTAVES: u32 = 37;

/// How long steps took.
#[derive(Clone, Debug)]
pub struct Durations {
    counts: Vec<u32>,
    steps: u64,
    /// ns
    sum: u64,
    /// ns
    max: u64,
}

impl Default for Durations {
    fn default() -> Self {
        Self { counts: vec![0; (OCTAVES << DIGITS) as usize], steps: 0, sum: 0, max: 0 }
    }
}

impl Durations {
    /// Takes note of a step.
    #[inline]
    pub fn note(&mut self, time: Duration) {
        // Steps of centuries are none.
        let nanoseconds = time.as_nanos() as u64;
        self.counts[Self::place(nanoseconds)] += 1;
        self.steps += 1;
        self.sum = self.sum.saturating_add(nanoseconds);
        self.max = self.max.max(nanoseconds);
    }

    /// Exponent and leading digits.
    #[inline]
    fn place(nanoseconds: u64) -> usize {
        let shift = (63 - (nanoseconds | 1).leading_zeros()).saturating_sub(DIGITS);
        let place = (u64::from(shift) << DIGITS) + (nanoseconds >> shift);
        place.min(u64::from((OCTAVES << DIGITS) - 1)) as usize
    }

    /// The middle of the durations at a place, ns.
    fn middle(place: usize) -> f64 {
        let shift = (place >> DIGITS).saturating_sub(1);
        let least = (place - (shift << DIGITS)) as f64;
        let unit = (1u64 << shift) as f64;
        (least + 0.5) * unit - 0.5
    }

    /// Steps noted.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Their mean, s; 0 without any.
    pub fn mean(&self) -> f64 {
        if self.steps > 0 { 1e-9 * self.sum as f64 / self.steps as f64 } else { 0.0 }
    }

    /// The longest, s.
    pub fn max(&self) -> f64 {
        1e-9 * self.max as f64
    }

    /// What this part of them does not exceed, s, to 2 %.
    pub fn quantile(&self, part: f64) -> f64 {
        let wanted = ((part * self.steps as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for (place, &count) in self.counts.iter().enumerate() {
            seen += u64::from(count);
            if seen >= wanted {
                return (1e-9 * Self::middle(place)).min(self.max());
            }
        }
        0.0
    }

    fn clear(&mut self) {
        self.counts.fill(0);
        (self.steps, self.sum, self.max) = (0, 0, 0);
    }
}

/// What is counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// The present of the arena, s.
    pub simulated: f64,
    /// Contacts of the arena and of answers.
    pub contacts: u64,
    /// Input that was refused.
    pub refused: Refused,
    /// Messages to the node that it never read.
    pub dropped_in: u64,
    /// Messages of the node that were not sent.
    pub dropped_out: u64,
}

impl Totals {
    fn dropped(&self) -> u64 {
        self.dropped_in + self.dropped_out
    }
}

/// The interval that a report is about.
#[derive(Clone, Debug, Default)]
pub struct Interval {
    /// How long its steps took.
    pub durations: Durations,
    before: Totals,
}

/// What a report says beside the interval.
#[derive(Clone, Debug, Default)]
pub struct Facts {
    /// Frame of the arena.
    pub frame_id: String,
    /// The method of motion.
    pub method: String,
    /// Simulated seconds in a second of wall time; 0 = as many as possible.
    pub real_time_factor_asked: f64,
    /// The parts that do not run.
    pub left_out: Vec<String>,
}

/// A report, and whether all is well.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// `error_report`
    pub report: ErrorReport,
    /// What is not as it was asked for.
    pub warnings: Vec<String>,
}

impl Interval {
    /// Begins anew.
    pub fn begin(&mut self, totals: Totals) {
        self.durations.clear();
        self.before = totals;
    }

    /// Ends after so many seconds of wall time, and tells how it went; the next one begins.
    pub fn end(&mut self, totals: Totals, wall: f64, facts: &Facts, arena: Option<&Arena>) -> Told {
        let wall = wall.max(1e-9);
        let (before, steps) = (self.before, &self.durations);
        let report = ErrorReport {
            header: Header {
                stamp: Time::from_seconds(totals.simulated),
                frame_id: facts.frame_id.clone(),
            },
            method: facts.method.clone(),
            steps: steps.steps(),
            step_mean_s: steps.mean(),
            step_p99_s: steps.quantile(0.99),
            step_max_s: steps.max(),
            contacts_per_second: totals.contacts.saturating_sub(before.contacts) as f64 / wall,
            real_time_factor_asked: facts.real_time_factor_asked,
            real_time_factor: (totals.simulated - before.simulated) / wall,
            energy: arena.map_or(0.0, Arena::kinetic_energy),
            relative_energy_drift: arena.map_or(0.0, Arena::relative_energy_drift),
            momentum_drift: arena.map_or(0.0, |arena| {
                arena.momentum_drift().map_or(f64::NAN, |drift| drift.length())
            }),
            largest_overlap: arena.map_or(0.0, |arena| arena.largest_overlap_m().max(0.0)),
            refused_causes: totals.refused.counts().map(|(cause, _)| cause.name().into()).collect(),
            refused_counts: totals.refused.counts().map(|(_, count)| count).collect(),
            dropped_in: totals.dropped_in,
            dropped_out: totals.dropped_out,
            left_out: facts.left_out.clone(),
        };
        let warnings = warnings(&report, &before, &totals, arena.is_some());
        self.begin(totals);
        Told { report, warnings }
    }
}

fn warnings(report: &ErrorReport, before: &Totals, now: &Totals, moves: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    let (asked, reached) = (report.real_time_factor_asked, report.real_time_factor);
    if moves && reached < REAL_TIME * asked {
        warnings.push(format!("real-time factor {reached:.3} of {asked} asked"));
    }
    let refused = now.refused.total() - before.refused.total();
    if refused > 0 {
        let causes = now.refused.counts().zip(before.refused.counts());
        let fresh = causes.filter(|((_, now), (_, before))| now > before);
        let names: Vec<&str> = fresh.map(|((cause, _), _)| cause.name()).collect();
        warnings.push(format!("{refused} inputs refused: {}", names.join(", ")));
    }
    let dropped = now.dropped() - before.dropped();
    if dropped > 0 {
        warnings.push(format!("{dropped} messages dropped"));
    }
    warnings
}

/// `/diagnostics`: the same numbers as text, stamped with wall time, as tools expect it.
pub fn diagnostics(told: &Told, stamp: Time) -> DiagnosticArray {
    let Told { report, warnings } = told;
    let message = if warnings.is_empty() { "as asked".to_owned() } else { warnings.join("; ") };
    let status = DiagnosticStatus {
        level: if warnings.is_empty() { DiagnosticStatus::OK } else { DiagnosticStatus::WARN },
        name: "carom".to_owned(),
        message,
        hardware_id: "carom".to_owned(),
        values: values(report),
    };
    DiagnosticArray { header: Header { stamp, frame_id: String::new() }, status: vec![status] }
}

/// Each field by its name, to all digits; a count of refusals for each cause.
fn values(report: &ErrorReport) -> Vec<KeyValue> {
    let numbers = [
        ("step_mean_s", report.step_mean_s),
        ("step_p99_s", report.step_p99_s),
        ("step_max_s", report.step_max_s),
        ("contacts_per_second", report.contacts_per_second),
        ("real_time_factor_asked", report.real_time_factor_asked),
        ("real_time_factor", report.real_time_factor),
        ("energy", report.energy),
        ("relative_energy_drift", report.relative_energy_drift),
        ("momentum_drift", report.momentum_drift),
        ("largest_overlap", report.largest_overlap),
    ];
    let pair = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let mut values = vec![pair("method", report.method.clone())];
    values.push(pair("steps", report.steps.to_string()));
    values.extend(numbers.map(|(key, value)| pair(key, format!("{value:?}"))));
    for (cause, count) in report.refused_causes.iter().zip(&report.refused_counts) {
        values.push(pair(&format!("refused.{cause}"), count.to_string()));
    }
    values.push(pair("dropped_in", report.dropped_in.to_string()));
    values.push(pair("dropped_out", report.dropped_out.to_string()));
    values.push(pair("left_out", report.left_out.join(", ")));
    values
}
