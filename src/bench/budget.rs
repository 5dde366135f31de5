//! What a budget is decided on: each way to move, timed on the scene itself.
//!
//! The exact method runs first, to see how fast pucks meet; then a copy of the start is moved on
//! for some milliseconds in each way, so that times are right on any machine and for any scene.
//! What is decided, and by which rule, is in [`crate::plan::budget`].

use std::io::{self, Write};

use serde_json::json;

use super::collision::{arena, meetings, with};
use super::seconds;
use crate::motion::arena::Arena;
use crate::plan::budget::{Candidate, Choice, ErrorModel, Meetings, Way, Wish, decide, duration};
use crate::plan::{Method, Plan};
use crate::scene::Scene;
use crate::world::{Contact, Disc};

/// Run time of the look at how pucks meet, and contacts that are enough for it.
const LOOK_S: f64 = 0.015;
const LOOK_CONTACTS: usize = 2_000;

/// Simulated time beyond which no contact is waited for, s.
const LOOK_SIMULATED_S: f64 = 100.0;

/// Run time of a block of a candidate, s; blocks, of which the quickest counts.
const BLOCK_S: f64 = 0.005;
const BLOCKS: usize = 3;

/// Publish periods that are enough for a block.
const PERIODS: u32 = 500;

/// Up to so many pucks the plain method is timed: it begins with all pairs.
const PLAIN_UP_TO: usize = 400;

/// Steps that are tried where no error is asked for, as parts of the publish period.
const STEPS: [f64; 4] = [1.0, 0.25, 0.0625, 0.015625];

/// All that was found out.
#[derive(Clone, Debug)]
pub struct Budget {
    /// What was asked for.
    pub wish: Wish,
    /// How fast pucks meet.
    pub meetings: Meetings,
    /// The ways to move.
    pub candidates: Vec<Candidate>,
    /// What was decided, if any way can be gone.
    pub choice: Option<Choice>,
    /// Simulated time of a publish period, s.
    period: f64,
}

impl Budget {
    /// Measures and decides for a scene; `None` if it has no pucks or nothing is asked for.
    pub fn of(scene: &Scene, wish: Wish) -> Option<Self> {
        if scene.pucks.is_empty() || wish.is_none() {
            return None;
        }
        let discs: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
        let period = 1.0 / scene.node.publish_rate_hz;
        let meetings = look(scene, &discs);
        let model = ErrorModel::measured();
        let restitution = scene.settings.restitution;
        let candidates: Vec<Candidate> = ways(scene, &wish, &model, &meetings, period)
            .into_iter()
            .map(|way| Candidate {
                way,
                error: model.error(way, &meetings, restitution),
                time: time(scene, &discs, way, period),
            })
            .collect();
        let choice = decide(&wish, &candidates);
        Some(Self { wish, meetings, candidates, choice, period })
    }

    /// Lets a scene move in the way that was chosen.
    pub fn apply(&self, scene: &mut Scene) {
        if let Some(choice) = &self.choice {
            scene.settings = with(self.candidates[choice.index].way, &scene.settings);
        }
    }

    /// The candidates as a table, and the verdict.
    ///
    /// # Errors
    /// When the output cannot be written.
    pub fn write_table(&self, out: &mut impl Write) -> io::Result<()> {
        let period = duration(self.period);
        writeln!(out, "\n{:<26} {:<10} run time of {period}", "method", "error")?;
        for (k, candidate) in self.candidates.iter().enumerate() {
            let time = match &candidate.time {
                Ok(time) => duration(*time),
                Err(why) => format!("- ({why})"),
            };
            let is_chosen = self.choice.as_ref().is_some_and(|choice| choice.index == k);
            let mark = if is_chosen { "   <- chosen" } else { "" };
            let way = candidate.way.to_string();
            writeln!(out, "{way:<26} {:<10} {time}{mark}", format!("{:.1e}", candidate.error))?;
        }
        writeln!(out, "\n{}", self.verdict())
    }

    /// What is taken and what gives way, in one line.
    pub fn verdict(&self) -> &str {
        self.choice.as_ref().map_or("no method suits the scene", |choice| &choice.verdict)
    }

    /// The same as a document.
    pub fn document(&self) -> serde_json::Value {
        let candidate = |(k, candidate): (usize, &Candidate)| {
            let step = if let Way::Steps(step) = candidate.way { Some(step) } else { None };
            let stiffness =
                if let Way::Springs(stiffness) = candidate.way { Some(stiffness) } else { None };
            json!({
                "method": candidate.way.method(), "step_s": step, "stiffness": stiffness,
                "error": candidate.error, "time_s": candidate.time.as_ref().ok(),
                "chosen": self.choice.as_ref().is_some_and(|choice| choice.index == k),
            })
        };
        json!({
            "error": self.wish.error, "budget_s": self.wish.budget, "period_s": self.period,
            "candidates": self.candidates.iter().enumerate().map(candidate).collect::<Vec<_>>(),
            "verdict": self.verdict(),
        })
    }
}

/// The exact method that the plan takes by itself.
fn exact(scene: &Scene, discs: &[Disc]) -> Way {
    Way::Exact(Plan::of(&scene.settings, discs).method)
}

/// How fast pucks meet in the first stretch of a scene.
fn look(scene: &Scene, discs: &[Disc]) -> Meetings {
    let mut contacts: Vec<Contact> = Vec::new();
    if let Ok(mut arena) = arena(exact(scene, discs), &scene.settings, discs) {
        let (mut spent, mut stretch) = (0.0, Plan::of(&scene.settings, discs).epoch);
        let enough = |contacts: &[Contact]| contacts.len() >= LOOK_CONTACTS;
        while spent < LOOK_S && arena.now() < LOOK_SIMULATED_S && !enough(&contacts) {
            let until = arena.now() + stretch;
            let (time, moved) = seconds(|| arena.advance(until, &mut contacts));
            spent += time;
            stretch *= 1.5;
            if moved.is_err() {
                break;
            }
        }
    }
    meetings(&contacts, discs)
}

/// The ways to be timed: every method, with the step or the spring that just keeps the error.
fn ways(
    scene: &Scene,
    wish: &Wish,
    model: &ErrorModel,
    meetings: &Meetings,
    period: f64,
) -> Vec<Way> {
    let restitution = scene.settings.restitution;
    let mut ways: Vec<Way> = [Method::Events, Method::Plain, Method::Ticks].map(Way::Exact).into();
    let usable = |x: f64| x > 0.0 && x.is_finite();
    if let Some(error) = wish.error {
        // A step is not longer than what is published: that would be shown nothing of.
        let step = model.step_for(error, meetings, restitution).min(period);
        let stiffness = model.stiffness_for(error, meetings);
        ways.extend(Some(step).filter(|step| usable(*step)).map(Way::Steps));
        let error_can_be_kept = usable(stiffness) && error > model.rounding(meetings);
        ways.extend(Some(stiffness).filter(|_| error_can_be_kept).map(Way::Springs));
    } else {
        ways.extend(STEPS.map(|part| Way::Steps(part * period)));
        ways.push(Way::Springs(scene.settings.pace.stiffness));
    }
    // Who names a method has chosen it.
    ways.retain(|way| scene.settings.method.is_none_or(|method| method == way.method()));
    ways
}

/// Run time of a publish period, s, or why there is none.
fn time(scene: &Scene, discs: &[Disc], way: Way, period: f64) -> Result<f64, String> {
    if way == Way::Exact(Method::Plain) && discs.len() > PLAIN_UP_TO {
        return Err(format!("not for more than {PLAIN_UP_TO} pucks"));
    }
    let start = arena(way, &scene.settings, discs)?;
    if matches!(way, Way::Springs(_)) && scene.settings.method != Some(Method::Springs) {
        return Err("pucks pass through observed circles: name it to have it".to_owned());
    }
    let mut best = f64::INFINITY;
    for _ in 0..BLOCKS {
        best = best.min(block(start.clone(), period)?);
    }
    Ok(best)
}

/// The same of one block.
fn block(mut arena: Arena, period: f64) -> Result<f64, String> {
    let began = arena.now();
    let (mut spent, mut periods) = (0.0, 0);
    let mut contacts = Vec::new();
    while spent < BLOCK_S && periods < PERIODS {
        periods += 1;
        let until = began + f64::from(periods) * period;
        while arena.now() < until && spent < BLOCK_S {
            contacts.clear();
            let (time, moved) = seconds(|| arena.advance(until, &mut contacts));
            spent += time;
            moved.map_err(|halt| halt.to_string())?;
        }
    }
    let simulated = arena.now() - began;
    if simulated > 0.0 { Ok(spent / simulated * period) } else { Err("it stands still".into()) }
}
