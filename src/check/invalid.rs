//! Kind `invalid`: input that must be refused whole, by name, and change nothing.
//!
//! Bodies come through the door for messages, the restitution through the door for scenes. carom's
//! policies where the files leave a choice: an infinite mass is a fixed disc, a radius of 0 is
//! refused.

use super::Effort;
use super::arena::{Trouble, any_disc};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use crate::messages::{CircleState, CircleStates};
use crate::receive::{self, BadCircle};
use crate::scene;
use crate::world::{Answer, Command, Instants, Settings, World};

/// What carom did with an input.
struct Handling {
    /// Index and field of each body refused.
    refused: Vec<(u32, String)>,
    /// Why the restitution was refused.
    restitution: Option<String>,
    /// The world's answer to what was taken.
    answer: Option<Answer>,
}

/// Each sub-case by the first word of its `outcome`; a body and field that it names must be the
/// ones refused.
pub fn invalid(root: &Field, _: Effort) -> Result<Vec<Finding>, Trouble> {
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let outcome = expected.get("outcome")?;
        let words = outcome.words()?;
        let restitution = input.find("e").map(|field| field.number()).transpose()?;
        let handling = handle(&input, restitution.unwrap_or(1.0))?;
        let mut tally = Tally::new(label);
        let refused = !handling.refused.is_empty() || handling.restitution.is_some();
        if words.starts_with("InvalidInput") {
            tally.exact("refused", refused, true);
            judge_refusal(&mut tally, &handling, &outcome)?;
        } else if words.starts_with("Ok") {
            tally.exact("refused", refused, false);
            judge_taken(&mut tally, &handling, words, &input)?;
        } else if words.contains("InvalidInput") {
            tally.note(if refused { "refused" } else { "accepted" });
        } else {
            return Err(outcome.wrong("must say InvalidInput or Ok").into());
        }
        judge_finite(&mut tally, &handling);
        findings.push(tally.finish());
    }
    Ok(findings)
}

fn handle(input: &Field, restitution: f64) -> Read<Handling> {
    let mut circles = Vec::new();
    for (k, body) in input.get("bodies")?.items()?.iter().enumerate() {
        let disc = any_disc(body, k as u32)?;
        let (p, v) = (disc.position, disc.velocity);
        let (radius, mass) = (disc.radius, disc.mass);
        circles.push(CircleState { id: disc.id, x: p.x, y: p.y, vx: v.x, vy: v.y, radius, mass });
    }
    let (restitution, reason) = restitution_at_the_door(restitution);
    let message = CircleStates { circles, ..CircleStates::default() };
    let (report, bad) = receive::report(&message).map_err(|error| input.wrong(error))?;
    let field = |reason: &BadCircle| match reason {
        BadCircle::Defect(defect) => defect.field.to_owned(),
        other => other.to_string(),
    };
    let refused = bad.iter().map(|(id, reason)| (*id, field(reason))).collect();
    let mut world = World::new(Settings { restitution, ..Settings::default() }, &[]);
    let instants = Instants { heard_at: 0.0, advance_to: 0.0 };
    let mut outcome = world.step(&[Command::Observe(report)], instants);
    let answer = if reason.is_none() { outcome.answers.pop() } else { None };
    Ok(Handling { refused, restitution: reason, answer })
}

/// The restitution as a scene takes it, or why it does not.
fn restitution_at_the_door(value: f64) -> (f64, Option<String>) {
    let number = match value {
        value if value.is_nan() => ".nan".to_owned(),
        value if value.is_infinite() => if value > 0.0 { ".inf" } else { "-.inf" }.to_owned(),
        value => format!("{value:?}"),
    };
    match scene::file::parse(&format!("restitution: {number}\n"), "case") {
        Ok(scene) => (scene.settings.restitution, None),
        Err(error) => (1.0, Some(error.message)),
    }
}

/// "naming body B and field F".
fn judge_refusal(tally: &mut Tally, handling: &Handling, outcome: &Field) -> Read<()> {
    // A refused body leaves its partner alone: nothing is left to collide.
    let changed = handling.answer.as_ref().is_some_and(|answer| !answer.velocities.is_empty());
    tally.exact("velocities changed", changed, false);
    let words = outcome.words()?;
    let Some((_, named)) = words.split_once("naming body ") else { return Ok(()) };
    let (body, field) = named
        .split_once(" and field ")
        .ok_or_else(|| outcome.wrong("must be `naming body <index> and field <name>`"))?;
    let body: u32 = body.trim().parse().map_err(|_| outcome.wrong("must name a body"))?;
    let field = match field.trim() {
        "m" => "mass",
        "r" => "radius",
        other => other,
    };
    tally.exact("names", handling.refused.clone(), vec![(body, field.to_owned())]);
    Ok(())
}

/// "no contacts", "same as e=0".
fn judge_taken(tally: &mut Tally, handling: &Handling, words: &str, input: &Field) -> Read<()> {
    let Some(answer) = &handling.answer else { return Ok(()) };
    if words.contains("no contacts") {
        tally.exact("contacts", answer.contacts.len(), 0);
    }
    if words.contains("same as e=0") {
        let discs = input.get("bodies")?.items()?;
        tally.exact("contacts", answer.contacts.is_empty(), discs.len() < 2);
        let same = handle(input, 0.0)?.answer;
        let bits = |answer: &Answer| -> Vec<_> {
            answer.velocities.iter().map(|(id, v)| (*id, v.x.to_bits(), v.y.to_bits())).collect()
        };
        tally.exact("velocities", Some(bits(answer)), same.as_ref().map(bits));
    }
    Ok(())
}

fn judge_finite(tally: &mut Tally, handling: &Handling) {
    let velocities = handling.answer.iter().flat_map(|answer| &answer.velocities);
    tally.exact("finite", velocities.into_iter().all(|(_, v)| v.is_finite()), true);
}
