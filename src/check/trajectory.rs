//! Kinds `edmd_*` judged by event lists, states and laws: chaotic scenes, reversal, mirror
//! symmetry, conservation.

use super::Effort;
use super::arena::{Run, Setup, Trouble, letter};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use super::number;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::world::{Contact, Disc, Partner};

type Findings = Result<Vec<Finding>, Trouble>;

/// Checkpoints with a tolerance above so much of the smallest radius are lost to chaos.
const LOST: f64 = 0.1;

/// A chaotic scene. At each checkpoint positions are within its own tolerance; once that exceeds a
/// tenth of the smallest radius only the energy is judged, to `64 u (1 + n_events)` of itself (what
/// restitution takes depends on directions too: there `tolerance / radius` is added). The order of
/// events and their counts are exact up to the last checkpoint that is not lost.
pub fn trajectory(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, tolerances) = (Setup::read(&inputs)?, root.get("tolerance")?.get("value")?);
    let mut run = Run::new(&setup);
    let smallest = setup.discs.iter().map(|disc| disc.radius).fold(f64::INFINITY, f64::min);
    let (mut findings, mut contacts, mut trusted) = (Vec::new(), Vec::new(), 0);
    let (mut lost, mut tolerance) = (false, 0.0);
    for (k, checkpoint) in expected.get("checkpoints")?.items()?.iter().enumerate() {
        let time = checkpoint.get("t")?.finite()?;
        tolerance = tolerances.item(k)?.number()?;
        let mut tally = Tally::new(format!("t = {time}"));
        contacts.append(&mut run.contacts(time)?);
        lost |= tolerance > LOST * smallest;
        if lost {
            tally.note(format!("lost to chaos: tolerance {tolerance:.1e}"));
        } else {
            trusted = contacts.len();
            let events = checkpoint.get("n_events")?.count(u64::MAX)?;
            tally.exact("events", contacts.len() as u64, events);
            judge_places(&mut tally, &run.discs(), checkpoint, tolerance)?;
        }
        findings.push(tally.finish());
    }
    contacts.append(&mut run.contacts(inputs.get("t_end")?.finite()?)?);
    let mut tally = Tally::new("events and energy");
    judge_events(&mut tally, &contacts[..trusted], &expected.get("events")?)?;
    if !lost {
        tally.exact("events", contacts.len() as u64, expected.get("n_events")?.count(u64::MAX)?);
        tally.exact("pairs", run.pairs, expected.get("n_pair")?.count(u64::MAX)?);
        tally.exact("walls", run.walls, expected.get("n_wall")?.count(u64::MAX)?);
    }
    let elastic = setup.settings.restitution == 1.0
        && setup.settings.walls.is_none_or(|walls| walls.restitution == 1.0);
    if !lost || elastic {
        let wanted = expected.get("energy_final")?.decimal()?;
        let rounding = 64.0 * UNIT_ROUNDOFF * (1.0 + contacts.len() as f64);
        let chaos = if elastic { 0.0 } else { tolerance / smallest };
        tally.near("energy", energy(&run.discs()), wanted, (rounding + chaos) * wanted.hi);
    }
    findings.push(tally.finish());
    Ok(findings)
}

fn judge_places(tally: &mut Tally, discs: &[Disc], checkpoint: &Field, tolerance: f64) -> Read<()> {
    let states = checkpoint.get("state_x_y_vx_vy")?;
    for (k, disc) in discs.iter().enumerate() {
        let state = states.item(k)?;
        tally.near(&format!("x of {k}"), disc.position.x, state.item(0)?.decimal()?, tolerance);
        tally.near(&format!("y of {k}"), disc.position.y, state.item(1)?.decimal()?, tolerance);
    }
    Ok(())
}

/// Who met whom, in order, as far as both lists go.
fn judge_events(tally: &mut Tally, contacts: &[Contact], events: &Field) -> Read<()> {
    for (event, contact) in events.items()?.iter().zip(contacts) {
        let with = event.get("j")?;
        let wanted = (event.get("i")?.count(u64::MAX)?, name(&with)?);
        let ours = match contact.b {
            Partner::Disc(b) => b.to_string(),
            Partner::Wall(side) => letter(side).to_owned(),
            Partner::Segment(k) => format!("segment {k}"),
        };
        let k = event.get("k")?.count(u64::MAX)?;
        let (a, b) = (u64::from(contact.a), ours);
        // A pair may be listed either way round.
        let turned = b.parse().ok().map(|b: u64| (b, a.to_string()));
        if (a, b.clone()) != wanted && turned.as_ref() != Some(&wanted) {
            tally.fail(format!("event {k}: {a} and {b}, must be {} and {}", wanted.0, wanted.1));
        }
    }
    Ok(())
}

/// An index or a letter.
fn name(field: &Field) -> Read<String> {
    match field.words() {
        Ok(words) => Ok(words.to_owned()),
        Err(_) => Ok(field.count(u64::MAX)?.to_string()),
    }
}

fn energy(discs: &[Disc]) -> f64 {
    discs.iter().map(Disc::kinetic_energy).collect::<RunningSum>().value()
}

/// There, velocities turned, and back: `n_events_each_way` exact, the way back ends within the
/// tolerance of the start.
pub fn reverse(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, until) = (Setup::read(&inputs)?, inputs.get("t_forward")?.finite()?);
    let tolerance = root.get("tolerance")?.get("value")?.number()?;
    let events = expected.get("n_events_each_way")?.count(u64::MAX)?;
    let mut tally = Tally::new("there and back");
    let mut forth = Run::new(&setup);
    tally.exact("events forth", forth.contacts(until)?.len() as u64, events);
    let turn = |disc: &Disc| Disc { velocity: -disc.velocity, ..*disc };
    let mut back = Run::new(&setup.with(forth.discs().iter().map(turn).collect()));
    tally.exact("events back", back.contacts(until)?.len() as u64, events);
    for (k, (disc, start)) in back.discs().iter().zip(&setup.discs).enumerate() {
        let place = (disc.position - start.position).abs().max_element();
        tally.within(format!("place of {k}"), place, tolerance);
        let velocity = (disc.velocity + start.velocity).abs().max_element();
        tally.within(format!("velocity of {k}"), velocity, tolerance);
    }
    Ok(vec![tally.finish()])
}

/// Looks at the mirror gas so many times.
const LOOKS: u32 = 400;

/// A scene that mirrors itself about half the height of its box, discs `i` and `i + N/2`. The
/// asymmetry is `>` nothing stated within the `first` so many collisions per disc; energy, and
/// momentum x with what the walls give, drift by no more than `drift >`.
pub fn mirror(root: &Field, _: Effort) -> Findings {
    let inputs = root.get("inputs")?;
    let (setup, value) = (Setup::read(&inputs)?, root.get("tolerance")?.get("value")?);
    let (until, walls) = (inputs.get("t_end")?.finite()?, super::arena::walls(&inputs, 1.0)?);
    let (bound, first) = (value.number_after("it is >")?, value.number_after("the first")?);
    let height = walls.min.y + walls.max.y;
    let (energy_0, momentum_0) = (energy(&setup.discs), momentum_x(&setup.discs));
    let (mut run, mut given, mut in_time, mut at) =
        (Run::new(&setup), RunningSum::default(), 0.0, None);
    let size: f64 = setup.discs.iter().map(|disc| disc.mass * disc.velocity.length()).sum();
    for k in 1..=LOOKS {
        run.advance(until * f64::from(k) / f64::from(LOOKS), |contact| {
            if let Partner::Wall(_) = contact.b {
                given.add(-contact.impulse * contact.normal.x);
            }
        })?;
        let asymmetry = asymmetry(&run.discs(), height);
        if ((2 * run.pairs + run.walls) as f64) < first * setup.discs.len() as f64 {
            in_time = asymmetry;
        }
        if asymmetry > bound && at.is_none() {
            at = Some((run.now(), (2 * run.pairs + run.walls) as f64 / setup.discs.len() as f64));
        }
    }
    let mut tally = Tally::new("mirror");
    tally.within(format!("asymmetry in the first {first} collisions per disc"), in_time, bound);
    let bound = value.number_after("drift >")?;
    let after = run.discs();
    tally.within("energy drift", ((energy(&after) - energy_0) / energy_0).abs(), bound);
    let momentum = momentum_x(&after) - momentum_0 - given.value();
    tally.within("momentum x drift", momentum.abs() / size, bound);
    tally.note(format!("asymmetry {:.1e} at the end", asymmetry(&after, height)));
    if let Some((time, collisions)) = at {
        tally.note(format!("lost at t = {time}, {collisions:.1} collisions per disc"));
    }
    Ok(vec![tally.finish()])
}

fn asymmetry(discs: &[Disc], height: f64) -> f64 {
    let half = discs.len() / 2;
    let pairs = discs[..half].iter().zip(&discs[half..]);
    let difference = |(a, b): (&Disc, &Disc)| {
        let place = (a.position.x - b.position.x).abs();
        place.max((a.position.y + b.position.y - height).abs())
    };
    pairs.map(difference).fold(0.0, f64::max)
}

fn momentum_x(discs: &[Disc]) -> f64 {
    discs.iter().map(|disc| disc.mass * disc.velocity.x).collect::<RunningSum>().value()
}

/// A disc between two fixed ones, on an unstable orbit. At bounce k the place across, `y`, and the
/// time are within `C u Lambda^k`; then nothing more happens.
pub fn unstable_pair(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, bounces) = (Setup::read(&inputs)?, expected.get("bounces")?.items()?);
    let value = root.get("tolerance")?.get("value")?;
    let c = value.number_after("C=")?;
    let multiplier = expected.get("multiplier_per_bounce")?.number()?;
    let last = bounces.last().ok_or_else(|| expected.wrong("no bounces"))?;
    let contacts = Run::new(&setup).contacts(4.0 * last.get("t")?.finite()?)?;
    let mut tally = Tally::new("bounces");
    tally.exact("bounces", contacts.len(), bounces.len());
    for (bounce, contact) in bounces.iter().zip(&contacts) {
        let k = bounce.get("bounce")?.count(1 << 20)?;
        let bound = c * UNIT_ROUNDOFF * multiplier.powi(k as i32);
        let with = bounce.get("with_body")?.count(u64::from(u32::MAX))? as u32;
        tally.exact(&format!("bounce {k}"), contact.b, Partner::Disc(with));
        let radius = setup.discs[0].radius;
        let y = contact.point.y - contact.normal.y * (radius + 0.5 * contact.gap);
        tally.near(&format!("y at bounce {k}"), y, bounce.get("y")?.decimal()?, bound);
        tally.near(&format!("t of bounce {k}"), contact.time, bounce.get("t")?.decimal()?, bound);
    }
    Ok(vec![tally.finish()])
}

/// A gas for `n_events`: the relative energy drift `<` the first bound, gold the second. The bias
/// per collision of a pair is shown.
pub fn conservation(root: &Field, _: Effort) -> Findings {
    let inputs = root.get("inputs")?;
    let (setup, value) = (Setup::read(&inputs)?, root.get("tolerance")?.get("value")?);
    let events = inputs.get("n_events")?.count(1 << 40)?;
    let pass = value.number_after("<")?;
    let gold = value.words()?.split_once("(pass)").and_then(|(_, rest)| number::after(rest, "<"));
    let before = energy(&setup.discs);
    let mut run = Run::new(&setup);
    // About ten events a step at first, then as many as are left.
    let mut step = 1e-2;
    while run.pairs + run.walls < events {
        run.pass(run.now() + step)?;
        let done = (run.pairs + run.walls).max(1);
        let left = events.saturating_sub(done) as f64;
        step = (run.now() / done as f64 * left).clamp(1e-3 * step, 1e3 * step).max(1e-3);
    }
    let drift = (energy(&run.discs()) - before) / before;
    let mut tally = Tally::new(format!("{} events", run.pairs + run.walls));
    tally.gold("energy drift", drift.abs(), pass, gold.unwrap_or(0.0));
    tally.note(format!("bias {:+.1e} per collision", drift / run.pairs.max(1) as f64));
    tally.note(format!("largest overlap {:.1e} of the radius", run.largest_overlap()));
    Ok(vec![tally.finish()])
}
