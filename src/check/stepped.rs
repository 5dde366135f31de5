//! Kinds `stepped_*`: what steps of fixed length find late, miss, and must not change.

use super::Effort;
use super::arena::{Run, Setup, Trouble};
use super::case::{Field, Read};
use super::detect::SplitMix64;
use super::finding::{Finding, Tally};
use crate::detect;
use crate::exact::UNIT_ROUNDOFF;
use crate::motion::plain::{Laws, Plain};
use crate::motion::steps::{Stepping, Steps};
use crate::resolve::overlap::part_pairs;
use crate::world::{Contact, Disc, Owner, limits};
use glam::DVec2;

type Findings = Result<Vec<Finding>, Trouble>;

/// Most steps a case may ask for.
const STEPS_MOST: f64 = 1e7;

/// Bullets for each step length.
const BULLETS: u32 = 4_000;

/// Sweeps of the overlap correction, alone and after each of so many steps.
const SWEEPS: usize = 10;

fn stepping(field: &Field) -> Read<Stepping> {
    let step = field.finite()?;
    if step <= 0.0 {
        return Err(field.wrong("must be above 0"));
    }
    Ok(Stepping::of(step))
}

fn steps(laws: Laws, discs: &[Disc], stepping: Stepping, at: &Field) -> Read<Steps> {
    Steps::new(laws, discs, stepping).map_err(|error| at.wrong(error))
}

fn advance(arena: &mut Steps, until: f64, at: &Field) -> Read<Vec<Contact>> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).map_err(|error| at.wrong(error))?;
    }
    Ok(contacts)
}

/// Two discs head on, at several step lengths: the step of detection is exact; lag, overlap and
/// the error of each position after are within the first number of the tolerance. The events judge:
/// their error, to the true position, is within the number after `<=`.
pub fn head_on(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, value) = (Setup::read(&inputs)?, root.get("tolerance")?.get("value")?);
    let laws = Laws { restitution: setup.settings.restitution, ..Laws::default() };
    let contact = expected.get("t_contact")?.decimal()?;
    let mut findings = Vec::new();
    for (field, row) in inputs.get("dts")?.items()?.iter().zip(expected.get("rows")?.items()?) {
        let stepping = stepping(field)?;
        let count = row.get("steps_to_detection")?.finite()?.min(STEPS_MOST);
        let until = 2.0 * count * stepping.step;
        let mut arena = steps(laws, &setup.discs, stepping, field)?;
        let contacts = advance(&mut arena, until, field)?;
        let mut tally = Tally::new(format!("dt = {}", stepping.step));
        tally.exact("contacts", contacts.len(), 1);
        tally.exact("contacts seen late", arena.unseen().late, 1);
        let Some(first) = contacts.first() else { continue };
        let bound = value.formula_between("", " against")?;
        tally.exact("steps to detection", first.time / stepping.step, count);
        let lag = row.get("lag")?.decimal()?;
        tally.near("lag", first.time - contact.hi, lag, bound);
        let overlap = row.get("penetration_at_detection")?.decimal()?;
        tally.near("overlap", -first.gap, overlap, bound);
        let mut judge = Run::new(&setup);
        judge.pass(until)?;
        let wanted = row.get("position_error_each_after")?.decimal()?;
        for (stepped, exact) in arena.discs(Owner::Simulated).zip(judge.discs()) {
            let error = stepped.position.distance(exact.position);
            tally.near("position error", error, wanted, bound);
        }
        findings.push(tally.finish());
    }
    findings.push(judge(&setup, contact.hi, value.formula_between("<=", " for")?)?);
    Ok(findings)
}

/// The events themselves: the time of contact, to `bound` of itself.
fn judge(setup: &Setup, contact: f64, bound: f64) -> Result<Finding, Trouble> {
    let mut tally = Tally::new("events");
    let contacts = Run::new(setup).contacts(2.0 * contact)?;
    let error = contacts.first().map_or(f64::INFINITY, |first| (first.time - contact).abs());
    tally.within("time of contact", error, bound * contact);
    Ok(tally.finish())
}

/// Bullets with a random start phase, through a fixed disc: how many the steps never touch is
/// binomial to the stated number of sigmas, the arena reports each, and the events miss none.
pub fn tunnelling(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let sigmas = root.get("tolerance")?.get("value")?.number_after("binomial")?;
    let mut findings = Vec::new();
    for (seed, field) in inputs.get("dts")?.items()?.iter().enumerate() {
        let stepping = stepping(field)?;
        let wanted =
            expected.get("miss_probability")?.entry_with_number(stepping.step)?.finite()?;
        let mut tally = Tally::new(format!("dt = {}", stepping.step));
        let mut random = SplitMix64(seed as u64);
        let (mut unseen, mut reported, mut swept) = (0, 0, 0);
        for _ in 0..BULLETS {
            let phase = (random.next() >> 11) as f64 / (1u64 << 53) as f64;
            let shot = shoot(&inputs, stepping, phase, field)?;
            unseen += u64::from(!shot.seen);
            reported += shot.reported;
            swept += u64::from(!shot.swept);
        }
        tally.exact("missed, as reported", reported, unseen);
        tally.exact("missed by the events", swept, 0);
        let probability = unseen as f64 / f64::from(BULLETS);
        let sigma = (wanted * (1.0 - wanted) / f64::from(BULLETS)).sqrt();
        tally.within("miss probability", (probability - wanted).abs(), sigmas * sigma);
        tally.note(format!("{unseen} of {BULLETS} missed"));
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// What became of a bullet.
struct Shot {
    /// It touched the target at a step end.
    seen: bool,
    /// Misses that the arena reports.
    reported: u64,
    /// The event method saw it.
    swept: bool,
}

fn shoot(inputs: &Field, stepping: Stepping, phase: f64, at: &Field) -> Result<Shot, Trouble> {
    let positive = |key: &str| {
        let field = inputs.get(key)?;
        let number = field.finite()?;
        if number > 0.0 { Ok(number) } else { Err(field.wrong("must be above 0")) }
    };
    let (r, target, speed) = (positive("r_bullet")?, positive("r_target")?, positive("v")?);
    let start = -(r + target) - phase * speed * stepping.step;
    let fixed = Disc {
        id: 1,
        position: DVec2::ZERO,
        velocity: DVec2::ZERO,
        radius: target,
        mass: f64::INFINITY,
    };
    let (position, velocity) = (DVec2::new(start, 0.0), DVec2::new(speed, 0.0));
    let bullet = Disc { id: 0, position, velocity, radius: r, mass: 1.0 };
    let laws = Laws::default();
    let until = 3.0 * (r + target) / speed + 2.0 * stepping.step;
    if until > STEPS_MOST * stepping.step {
        return Err(at.wrong("too short for the speed").into());
    }
    let mut arena = steps(laws, &[bullet, fixed], stepping, at)?;
    let contacts = advance(&mut arena, until, at)?;
    let seen = !contacts.is_empty() || arena.unseen().too_late > 0;
    let mut events = Plain::new(laws, &[bullet, fixed], target / speed);
    let mut met = Vec::new();
    events.advance(until, &mut met)?;
    let turned = events.discs(Owner::Simulated).any(|disc| disc.velocity.x < 0.0);
    Ok(Shot { seen, reported: arena.unseen().missed, swept: turned && met.len() == 1 })
}

/// A hexagonal packing with overlaps, at rest: parting it, in sweeps alone and after steps, leaves
/// every velocity 0. The largest overlap left is shown.
pub fn overlap_energy(root: &Field, _: Effort) -> Findings {
    let discs = packing(&root.get("inputs")?)?;
    let at = root.get("inputs")?;
    let pairs = detect::all_pairs::touching_pairs(&discs, 0.0).map_err(|error| at.wrong(error))?;
    let mut swept = discs.clone();
    let moved: usize = (0..SWEEPS).map(|_| part_pairs(&mut swept, &pairs, None)).sum();
    let laws = Laws { restitution: 0.5, ..Laws::default() };
    let stepping = Stepping { overlap_sweeps: SWEEPS, ..Stepping::of(0.015625) };
    let mut arena = steps(laws, &discs, stepping, &at)?;
    advance(&mut arena, stepping.step * SWEEPS as f64, &at)?;
    let stepped: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    let mut findings = Vec::new();
    for (label, after) in [("sweeps", swept), ("steps", stepped)] {
        let mut tally = Tally::new(label);
        let energy: f64 = after.iter().map(Disc::kinetic_energy).sum();
        tally.within("kinetic energy", energy, 0.0);
        let left = deepest(&after, &pairs);
        tally.exact("overlaps shrink", moved > 0 && left < deepest(&discs, &pairs), true);
        tally.within("centre of mass", shift(&discs, &after), 64.0 * UNIT_ROUNDOFF * size(&discs));
        tally.note(format!("deepest overlap {:.1e}, was {:.1e}", left, deepest(&discs, &pairs)));
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// `rows` x `cols` discs of radius `r`, neighbours `pitch` apart, every other row set off.
fn packing(inputs: &Field) -> Read<Vec<Disc>> {
    let count = |key: &str| inputs.get(key)?.count(1_000);
    let (rows, cols) = (count("rows")?, count("cols")?);
    let (radius, pitch) = (inputs.get("r")?.finite()?, inputs.get("pitch")?.finite()?);
    if (rows * cols) as usize > limits::PUCKS_PER_SCENE || radius <= 0.0 || pitch <= 0.0 {
        return Err(inputs.wrong("must be a packing of discs"));
    }
    let place = |k: u64| {
        let (row, col) = (k / cols, k % cols);
        let x = (col as f64 + 0.5 * (row % 2) as f64) * pitch;
        DVec2::new(x, row as f64 * 0.75f64.sqrt() * pitch)
    };
    let velocity = DVec2::ZERO;
    let disc = |k: u64| Disc { id: k as u32, position: place(k), velocity, radius, mass: 1.0 };
    Ok((0..rows * cols).map(disc).collect())
}

fn deepest(discs: &[Disc], pairs: &[detect::Pair]) -> f64 {
    let overlap = |&(i, j): &detect::Pair| -detect::touching::gap(&discs[i], &discs[j]);
    pairs.iter().map(overlap).fold(0.0, f64::max)
}

/// How far the centre of equal masses moved, m.
fn shift(before: &[Disc], after: &[Disc]) -> f64 {
    let moved = before.iter().zip(after).map(|(a, b)| b.position - a.position);
    moved.sum::<DVec2>().length() / before.len().max(1) as f64
}

fn size(discs: &[Disc]) -> f64 {
    discs.iter().map(|disc| disc.position.length() + disc.radius).fold(0.0, f64::max)
}
