//! The budget: the cheapest method whose error stays under a bound within a time, or which of the
//! two gives way and by how much.
//!
//! **Error** is that of one contact of two pucks: by how much their relative velocity after it
//! differs from the exact one, over their relative speed before it, root mean square over the
//! contacts of the scene. A puck that flies on for one contact distance is off by about so much of
//! that distance. Methods that resolve each contact at its instant have rounding: `ticks` of
//! coordinates, which may be far larger than what they differ by at a contact, the others only
//! after a long way. `steps` find it up to a step late, so the error is in proportion to the way
//! in a step over the contact distance; `springs` turn about each other while they touch, in
//! proportion to the way in that time. What chaos makes of an error afterwards is the same for all
//! methods, and not in it.
//!
//! **Budget** is run time in a publish period, `1 / publish_rate_hz` of simulated time.
//!
//! **Rule:** the error is kept, the time gives way; with a budget alone, the most exact method
//! within it. Coefficients come from `config/error_model.json`, times from the caller, who measures
//! them on the scene itself. Nothing here reads a clock or moves a disc.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Method;

/// What was measured of each method, built in.
const MEASURED: &str = include_str!("../../config/error_model.json");

/// Errors of one contact, as they were measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorModel {
    /// The command that measured it.
    pub command: String,
    /// What the coefficients are.
    pub meaning: String,
    /// Of the method events: the error itself.
    pub events: f64,
    /// Of the method plain.
    pub plain: f64,
    /// Of the method ticks.
    pub ticks: f64,
    /// Of the method steps, over the way in a step in contact distances.
    pub steps: f64,
    /// Of the method springs, over the way in `sqrt(mu / k)` in contact distances.
    pub springs: f64,
    /// By what all are larger than what was measured, so that they bound it.
    pub margin: f64,
}

/// How fast the pucks of a scene meet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Meetings {
    /// Relative speed over contact distance, root mean square, 1/s.
    pub rate: f64,
    /// The same times the root of the reduced mass, kg^(1/2)/s.
    pub weighted: f64,
    /// Largest coordinate of a contact over the contact distance, root mean square.
    pub coordinate: f64,
    /// The same of the way from where the pucks began.
    pub way: f64,
}

/// Coordinates, in contact distances, at which the errors of exact methods were measured.
const MEASURED_AT: f64 = 2.0;

/// Way, in contact distances, after which flights are carried on, which rounds them.
const CARRIED_AFTER: f64 = 1024.0;

/// No rounding may carry what just keeps a bound beyond it.
const SAFE: f64 = 1.0 - 1e-9;

/// Largest error that a contact can have: a relative velocity that points the other way.
const ERROR_MAX: f64 = 2.0;

impl ErrorModel {
    /// The one in `config/error_model.json`.
    pub fn measured() -> Self {
        // The file is part of the program, and a test reads it.
        serde_json::from_str(MEASURED).expect("a file that was checked")
    }

    /// The error of a way to move, in a scene whose pucks meet so.
    pub fn error(&self, way: Way, meetings: &Meetings, restitution: f64) -> f64 {
        let far = (meetings.coordinate / MEASURED_AT).max(1.0);
        let error = match way {
            Way::Exact(Method::Plain) if meetings.way < CARRIED_AFTER => self.plain,
            Way::Exact(Method::Plain) => self.plain * far,
            Way::Exact(Method::Ticks) => self.ticks * far,
            Way::Exact(_) => self.rounding(meetings),
            Way::Steps(step) => {
                let per_step = self.steps * 0.5 * (1.0 + restitution) * meetings.rate;
                per_step * step + self.rounding(meetings)
            }
            Way::Springs(stiffness) => {
                self.springs * meetings.weighted / stiffness.sqrt() + self.rounding(meetings)
            }
        };
        error.min(ERROR_MAX)
    }

    /// The error of the method events; what steps and springs add to is no less.
    pub fn rounding(&self, meetings: &Meetings) -> f64 {
        let times = (meetings.way / CARRIED_AFTER).floor();
        self.events * (times * meetings.coordinate / MEASURED_AT).max(1.0)
    }

    /// The longest step (s) whose error is no more than that.
    pub fn step_for(&self, error: f64, meetings: &Meetings, restitution: f64) -> f64 {
        let error_per_step = self.steps * 0.5 * (1.0 + restitution) * meetings.rate;
        SAFE * (error - self.rounding(meetings)) / error_per_step
    }

    /// The softest spring (N/m) whose error is no more than that.
    pub fn stiffness_for(&self, error: f64, meetings: &Meetings) -> f64 {
        let left = error - self.rounding(meetings);
        (self.springs * meetings.weighted / (SAFE * left)).powi(2)
    }
}

/// A way to move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// A method that resolves each contact at its instant.
    Exact(Method),
    /// Steps of this length, s.
    Steps(f64),
    /// Springs of this constant, N/m.
    Springs(f64),
}

impl Way {
    /// The method.
    pub fn method(self) -> Method {
        match self {
            Self::Exact(method) => method,
            Self::Steps(_) => Method::Steps,
            Self::Springs(_) => Method::Springs,
        }
    }
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact(method) => write!(f, "{method}"),
            Self::Steps(step) => write!(f, "steps of {step:.2e} s"),
            Self::Springs(stiffness) => write!(f, "springs of {stiffness:.2e} N/m"),
        }
    }
}

/// What is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wish {
    /// Largest error of a contact, if there is a bound.
    pub error: Option<f64>,
    /// Longest run time of a publish period, s, if there is a bound.
    pub budget: Option<f64>,
}

impl Wish {
    /// Whether nothing is.
    pub fn is_none(&self) -> bool {
        self.error.is_none() && self.budget.is_none()
    }
}

/// A way to move, what it costs, and how wrong it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// How.
    pub way: Way,
    /// Predicted error of a contact.
    pub error: f64,
    /// Measured run time of a publish period, s, or why there is none.
    pub time: Result<f64, String>,
}

/// What was decided.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Which of the candidates.
    pub index: usize,
    /// In one line: what is taken, and what gives way.
    pub verdict: String,
}

/// Decides; `None` if no candidate has a time.
pub fn decide(wish: &Wish, candidates: &[Candidate]) -> Option<Choice> {
    let timed = |k: &usize| candidates[*k].time.is_ok();
    let time = |k: usize| candidates[k].time.as_ref().copied().unwrap_or(f64::INFINITY);
    let error = |k: usize| candidates[k].error;
    let all = || (0..candidates.len()).filter(timed);
    let exact_enough = |k: &usize| wish.error.is_none_or(|bound| error(*k) <= bound);
    let quick_enough = |k: &usize| wish.budget.is_none_or(|budget| time(*k) <= budget);
    let by_time = |a: &usize, b: &usize| time(*a).total_cmp(&time(*b));
    let by_error = |a: &usize, b: &usize| error(*a).total_cmp(&error(*b)).then(by_time(a, b));
    let index = if wish.error.is_some() {
        // The error is kept; where it cannot be, it gives way as little as can be.
        all().filter(exact_enough).min_by(by_time).or_else(|| all().min_by(by_error))
    } else {
        all().filter(quick_enough).min_by(by_error).or_else(|| all().min_by(by_time))
    }?;
    Some(Choice { index, verdict: verdict(wish, &candidates[index], time(index)) })
}

/// A factor, with an exponent where its digits would fill the line.
fn times(factor: f64) -> String {
    if factor < 1e6 { format!("{factor:.3}") } else { format!("{factor:.1e}") }
}

fn verdict(wish: &Wish, chosen: &Candidate, time: f64) -> String {
    let Candidate { way, error, .. } = chosen;
    let taken = format!("{way}: error {error:.1e}, {} a publish period", duration(time));
    let mut kept = Vec::new();
    let mut broken = Vec::new();
    if let Some(bound) = wish.error {
        if *error <= bound {
            kept.push(format!("error {bound:.1e}"));
        } else {
            let factor = times(error / bound);
            broken.push(format!("the error of {bound:.1e} gives way, by {factor} times"));
        }
    }
    if let Some(budget) = wish.budget {
        if time <= budget {
            kept.push(format!("budget {}", duration(budget)));
        } else {
            let (budget, factor) = (duration(budget), times(time / budget));
            broken.push(format!("the budget of {budget} gives way, by {factor} times"));
        }
    }
    if broken.is_empty() {
        format!("{taken}; within {}", kept.join(" and "))
    } else {
        format!("{taken}; {}", broken.join(" and "))
    }
}

/// A time in the unit in which it is easiest to read.
pub fn duration(seconds: f64) -> String {
    let (factor, unit) = match seconds {
        s if s < 1e-6 => (1e9, "ns"),
        s if s < 1e-3 => (1e6, "us"),
        s if s < 1.0 => (1e3, "ms"),
        _ => (1.0, "s"),
    };
    let value = format!("{:.3}", seconds * factor);
    format!("{} {unit}", value.trim_end_matches('0').trim_end_matches('.'))
}

/// Reads a bound of the error.
///
/// # Errors
/// What would be right.
pub fn parse_error(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|x| *x > 0.0 && x.is_finite());
    value.ok_or_else(|| "must be a number above 0, such as 1e-6".to_owned())
}

/// Reads a time such as `2ms`, `500us`, `0.1 s` or a number of seconds.
///
/// # Errors
/// What would be right.
pub fn parse_budget(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3), ("s", 1.0)];
    let unit = units.into_iter().find(|(unit, _)| text.ends_with(unit));
    let (unit, factor) = unit.unwrap_or(("", 1.0));
    let number = text[..text.len() - unit.len()].trim().parse::<f64>().ok();
    let value = number.map(|number| number * factor).filter(|x| *x > 0.0 && x.is_finite());
    value.ok_or_else(|| "must be a time above 0, such as 2ms".to_owned())
}
