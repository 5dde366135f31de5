//! Kinds with endlessly many contacts in finite time: corner, piston, inelastic collapse.

use super::Effort;
use super::arena::{Run, Setup, Trouble, discs, letter};
use super::case::{Field, Malformed, Read};
use super::exact_solutions::judge_state;
use super::finding::{Finding, Tally};
use crate::world::{Contact, Disc, Partner, limits};

type Findings = Result<Vec<Finding>, Trouble>;

/// A disc that comes to rest in a corner: the walls, their times, the state at the end and that
/// nothing happens after are exact. Each event names its walls as letters.
pub fn corner(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let mut run = Run::new(&Setup::read(&inputs)?);
    let contacts = run.contacts(inputs.get("t_end")?.finite()?)?;
    let mut tally = Tally::new("at rest");
    let mut left = &contacts[..];
    for event in expected.get("events")?.items()? {
        let time = event.get("t")?.decimal()?;
        let words = event.get("wall")?.words()?;
        let named = words.split_whitespace().filter(|word| "LRBT".contains(word)).count();
        let (now, rest) = left.split_at(named.min(left.len()));
        tally.exact("walls hit", now.len(), named);
        for contact in now {
            let named = words.split_whitespace().any(|word| word == wall_of(contact));
            tally.exact("a wall named", named, true);
            tally.near("t", contact.time, time, 0.0);
        }
        left = rest;
    }
    let after = expected.get("events_after")?.count(u64::MAX)?;
    tally.exact("events after", left.len() as u64, after);
    judge_state(&mut tally, &run.discs()[0], &expected)?;
    Ok(vec![tally.finish()])
}

fn wall_of(contact: &Contact) -> &'static str {
    match contact.b {
        Partner::Wall(side) => letter(side),
        Partner::Disc(_) | Partner::Segment(_) => "",
    }
}

/// A ball dropped on a lossy floor: `times rel` bounds the listed times of its bounces; once they
/// have piled up it lies where `y=` says, slower than the speed at which the arena lets a disc
/// rest, and nothing happens any more.
pub fn bouncing_ball(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let relative = root.get("tolerance")?.get("kind")?.number_after("times rel")?;
    let (zeno, mut run) = (expected.get("zeno_time")?, Run::new(&Setup::read(&inputs)?));
    let late = zeno.number()? * (1.0 + relative);
    let mut tally = Tally::new("bounces, then rest");
    let contacts = run.contacts(late)?;
    for (k, time) in expected.get("bounce_times")?.items()?.iter().enumerate() {
        let ours = contacts.get(k).map_or(f64::NAN, |contact| contact.time);
        let what = format!("t of bounce {}", k + 1);
        tally.near(&what, ours, time.decimal()?, relative * time.number()?.abs());
    }
    let last = contacts.last().map_or(f64::NAN, |contact| contact.time);
    tally.note(format!("{} bounces, the last {:.1e} s early", contacts.len(), late - last));
    tally.exact("events at rest", run.contacts(2.0 * late)?.len(), 0);
    let ball = run.discs()[0];
    tally.within("|vy| at rest", ball.velocity.y.abs(), limits::REST_SPEED_MPS);
    let height = expected.get("rest_after_zeno")?.number_after("y=")?;
    tally.within("y at rest", (ball.position.y - height).abs(), relative * height.abs());
    Ok(vec![tally.finish()])
}

/// A light disc between a wall and a closing piston: `times rel` bounds the times of the listed
/// events, and the velocities between them; then the arena must stall, not hang.
pub fn piston(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let relative = root.get("tolerance")?.get("kind")?.number_after("times rel")?;
    let (events, mut run) = (expected.get("events")?.items()?, Run::new(&Setup::read(&inputs)?));
    let mut tally = Tally::new("events");
    let times: Vec<f64> = events.iter().map(|e| e.get("t")?.finite()).collect::<Read<_>>()?;
    for (k, event) in events.iter().enumerate() {
        let next = times.get(k + 1).copied();
        // Between this event and the next the velocity can be seen.
        let until = 0.5 * (times[k] + next.unwrap_or(times[k]));
        let contacts = run.contacts(until.max(times[k].next_up()))?;
        tally.exact(&format!("contacts up to event {}", k + 1), contacts.len(), 1);
        let Some(contact) = contacts.first() else { break };
        let time = event.get("t")?;
        let what = format!("t of event {}", k + 1);
        tally.near(&what, contact.time, time.decimal()?, relative * time.number()?.abs());
        let wall = event.get("type")?.words()? == "wall";
        tally.exact(&what, matches!(contact.b, Partner::Wall(_)), wall);
        if let Some(speed) = event.find("v_light_after") {
            let (ours, bound) = (run.discs()[0].velocity.x, relative * speed.number()?.abs());
            tally.near(&format!("v after event {}", k + 1), ours, speed.decimal()?, bound);
        }
    }
    judge_stall(&mut tally, &mut run, inputs.get("t_end")?.finite()?, &expected)?;
    Ok(vec![tally.finish()])
}

/// The arena must stall no later than at `accumulation_time`, and all stay finite.
fn judge_stall(tally: &mut Tally, run: &mut Run, until: f64, expected: &Field) -> Read<()> {
    let accumulation = expected.get("accumulation_time")?.finite()?;
    match run.pass(until) {
        Ok(()) => tally.fail(format!("no stall up to t = {until}")),
        Err(halt) => {
            let time = halt.time().unwrap_or(f64::INFINITY);
            tally.exact("stall too late", time > accumulation * (1.0 + 1e-9), false);
            tally.note(format!("stalled at t = {time:.9}"));
        }
    }
    let finite = |disc: &Disc| disc.position.is_finite() && disc.velocity.is_finite();
    tally.exact("finite", run.discs().iter().all(finite), true);
    Ok(())
}

/// The tolerances of `edmd_collapse`, read from their sentence.
struct Bounds {
    velocity: f64,
    time: f64,
    relative_velocity: f64,
}

/// Three discs on a line. Above the critical restitution: `collisions` exact, velocities within
/// `v abs`. Below: carom's policy (elastic contacts end the collapse, or a stall) must have its
/// last contact, however slow, `t at stop within` so much of `collapse_time`, with
/// `final relative velocities <`.
pub fn collapse(root: &Field, _: Effort) -> Findings {
    let field = root.get("tolerance")?.get("kind")?;
    let bounds = Bounds {
        velocity: field.number_after("v abs")?,
        time: field.number_after("t at stop within")?,
        relative_velocity: field.number_after("final relative velocities <")?,
    };
    let inputs = root.get("inputs")?;
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let mut laws = Setup::read_laws(&inputs)?;
        laws.settings.restitution = Setup::read_laws(&input)?.settings.restitution;
        let setup = laws.with(discs(&input.get("bodies")?)?);
        let mut tally = Tally::new(label);
        if expected.get("finite")?.flag()? {
            finite_collapse(&mut tally, &setup, &expected, &bounds)?;
        } else {
            endless_collapse(&mut tally, &setup, &expected, &bounds)?;
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

fn finite_collapse(
    tally: &mut Tally,
    setup: &Setup,
    expected: &Field,
    bounds: &Bounds,
) -> Result<(), Trouble> {
    let mut run = Run::new(setup);
    let contacts = run.contacts(2.0 * expected.get("last_time")?.finite()?)?;
    let collisions = expected.get("collisions")?.count(u64::MAX)?;
    tally.exact("collisions", contacts.len() as u64, collisions);
    let velocities = expected.get("v")?;
    for (k, disc) in run.discs().iter().enumerate() {
        let wanted = velocities.item(k)?.decimal()?;
        tally.near(&format!("v of {k}"), disc.velocity.x, wanted, bounds.velocity);
    }
    Ok(())
}

fn endless_collapse(
    tally: &mut Tally,
    setup: &Setup,
    expected: &Field,
    bounds: &Bounds,
) -> Result<(), Malformed> {
    let collapse = expected.get("collapse_time")?;
    let mut run = Run::new(setup);
    let (mut last, mut contacts) = (f64::NAN, 0u64);
    let stall = run.advance(2.0 * collapse.finite()?, |contact| {
        (last, contacts) = (contact.time, contacts + 1);
    });
    let (policy, stop) = match stall {
        Ok(()) => ("elastic contacts", last),
        Err(halt) => ("stall", halt.time().unwrap_or(f64::INFINITY)),
    };
    tally.near("time of the last contact", stop, collapse.decimal()?, bounds.time);
    let speeds: Vec<f64> = run.discs().iter().map(|disc| disc.velocity.x).collect();
    let (low, high) = speeds.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    tally.within("relative velocity", high - low, bounds.relative_velocity);
    tally.note(format!("{contacts} contacts, ended by {policy}"));
    Ok(())
}

/// Information: `tan^2(pi/4 (1 - 1/N))` beside the values of the table.
pub fn threshold(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?.get("e_crit")?);
    let mut findings = Vec::new();
    for field in inputs.get("N")?.items()? {
        let number = field.finite()?;
        let label = format!("{number}");
        let mut tally = Tally::new(format!("N = {label}"));
        let ours = (0.25 * std::f64::consts::PI * (1.0 - 1.0 / number)).tan().powi(2);
        tally.near("e_c", ours, expected.get(&label)?.decimal()?, 1e-14);
        findings.push(tally.finish());
    }
    Ok(findings)
}
