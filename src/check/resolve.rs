//! Kinds `resolve_*`: one contact, or several at one instant, given as such.
//!
//! The contact is presupposed (some pairs of the files miss each other by a hair), so they enter
//! where the world enters after detection: [`crate::resolve::touching::resolve`] and
//! [`crate::resolve::wall::bounce`].

use glam::DVec2;

use super::Effort;
use super::arena::{self, Setup, Trouble};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use crate::detect::touching_pairs;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::plan::Plan;
use crate::resolve::pair::MassFractions;
use crate::resolve::touching::resolve;
use crate::resolve::wall::bounce;
use crate::world::{Contact, Disc, Settings, Side};

type Findings = Result<Vec<Finding>, Trouble>;

/// One pair. Velocities: each component within the sub-case's own `tol`, one number a body. Without
/// a collision the bits must stay. The impulse is held to the part of that formula that the
/// contact itself brings, `16 u (1 + e) mu |w|`; the overlap to `8 u (r1 + r2)`, the rounding of
/// coordinates near each other.
pub fn pair(root: &Field, _: Effort) -> Findings {
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let before = Setup::read(&input.find("inputs").unwrap_or(input))?;
        findings.push(one_pair(label, &before, &expected)?);
    }
    Ok(findings)
}

fn one_pair(label: String, before: &Setup, expected: &Field) -> Read<Finding> {
    let mut tally = Tally::new(label);
    let (after, contacts) = resolve_all(before, &[(0, 1)]);
    let collides = expected.get("collides")?.flag()?;
    tally.exact("collides", !contacts.is_empty(), collides);
    let (velocities, tolerances) = (expected.get("v")?, expected.get("tol")?);
    for (k, disc) in after.iter().enumerate() {
        let tolerance = tolerances.item(k)?.number()?;
        for (axis, name) in ["vx", "vy"].into_iter().enumerate() {
            let wanted = velocities.item(k)?.item(axis)?.decimal()?;
            tally.near(&format!("{name} of {k}"), disc.velocity[axis], wanted, tolerance);
        }
        if !collides {
            let bits = |v: DVec2| [v.x.to_bits(), v.y.to_bits()];
            tally.exact("bits of v", bits(disc.velocity), bits(before.discs[k].velocity));
        }
    }
    if let [contact] = contacts[..] {
        judge_contact(&mut tally, before, &contact, expected)?;
    }
    Ok(tally.finish())
}

fn judge_contact(
    tally: &mut Tally,
    before: &Setup,
    contact: &Contact,
    expected: &Field,
) -> Read<()> {
    let (a, b) = (&before.discs[0], &before.discs[1]);
    if let Some(impulse) = expected.find("impulse") {
        let fraction = MassFractions::of(a.mass, b.mass).a.hi;
        let reduced_mass = if a.mass.is_finite() { a.mass * fraction } else { b.mass };
        let speed = (b.velocity.x - a.velocity.x).hypot(b.velocity.y - a.velocity.y);
        let bound = 16.0 * UNIT_ROUNDOFF * (1.0 + before.settings.restitution);
        let tolerance = bound * reduced_mass * speed + f64::from_bits(1);
        tally.near("impulse", contact.impulse, impulse.decimal()?, tolerance);
    }
    if let Some(overlap) = expected.find("overlap") {
        let tolerance = 8.0 * UNIT_ROUNDOFF * (a.radius + b.radius) + f64::from_bits(1);
        tally.near("overlap", -contact.gap, overlap.decimal()?, tolerance);
    }
    Ok(())
}

/// A pair without physical answer: finite, momentum within `momentum_conserved_rel` of the sizes of
/// the momenta, no energy gained beyond that, the same bits every time, equal velocities left.
pub fn pair_invariant(root: &Field, _: Effort) -> Findings {
    let expected = root.get("expected")?;
    let bound = expected.get("momentum_conserved_rel")?.formula(&[])?;
    let mut findings = Vec::new();
    for (k, input) in root.get("inputs")?.get("subcases")?.items()?.into_iter().enumerate() {
        let label = input.find("label").map(|label| label.words()).transpose()?;
        let mut tally = Tally::new(label.map_or_else(|| format!("#{k}"), str::to_owned));
        let before = Setup::read(&input)?;
        let (after, _) = resolve_all(&before, &[(0, 1)]);
        let again = resolve_all(&before, &[(0, 1)]).0;
        tally.exact("finite", after.iter().all(|disc| disc.velocity.is_finite()), true);
        tally.exact("the same again", again == after, true);
        judge_conservation(&mut tally, &before.discs, &after, bound);
        if before.discs.iter().all(|disc| disc.velocity == before.discs[0].velocity) {
            tally.exact("unchanged", after == before.discs, true);
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// Momentum kept, energy not gained, relative to the sum of their sizes.
fn judge_conservation(tally: &mut Tally, before: &[Disc], after: &[Disc], bound: f64) {
    let size: f64 = before.iter().map(|disc| disc.mass * disc.velocity.length()).sum();
    for (axis, name) in ["momentum x", "momentum y"].into_iter().enumerate() {
        let sum = |discs: &[Disc]| discs.iter().map(|d| d.mass * d.velocity[axis]).sum::<f64>();
        tally.within(name, (sum(after) - sum(before)).abs(), bound * size);
    }
    let energy = |discs: &[Disc]| discs.iter().map(Disc::kinetic_energy).sum::<f64>();
    let gain = (energy(after) - energy(before)).max(0.0);
    tally.within("energy gained", gain, bound * energy(before));
}

/// A disc at a wall: "1 ulp" of each component, as one multiplication deserves.
pub fn wall(root: &Field, _: Effort) -> Findings {
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let letter = input.get("wall")?;
        let sides = [Side::Left, Side::Right, Side::Bottom, Side::Top];
        let side = sides.into_iter().find(|&side| letter.words() == Ok(arena::letter(side)));
        let side = side.ok_or_else(|| letter.wrong("must be L, R, B or T"))?;
        let mut disc = arena::disc(&input.get("body")?, 0)?;
        let restitution = restitution(&input)?;
        if let Some(bounce) = bounce(&disc, side, restitution) {
            disc.velocity = bounce.velocity;
        }
        let mut tally = Tally::new(label);
        judge_ulps(&mut tally, root, disc.velocity, &expected.get("v")?)?;
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// A disc at two walls of a corner, which must be independent of their order: "1 ulp per
/// component". Once by the wall law in both orders, once in an arena.
pub fn corner(root: &Field, _: Effort) -> Findings {
    let input = root.get("inputs")?;
    let disc = arena::disc(&input.get("body")?, 0)?;
    let restitution = restitution(&input)?;
    let walls = arena::walls(&input, restitution)?;
    let expected = root.get("expected")?.get("v")?;
    let sides = [Side::Left, Side::Right, Side::Bottom, Side::Top];
    let touched: Vec<Side> = sides.into_iter().filter(|&s| walls.gap(s, &disc) <= 0.0).collect();
    let mut findings = Vec::new();
    for (label, order) in [("x first", touched.clone()), ("y first", reversed(&touched))] {
        let mut disc = disc;
        for side in order {
            if let Some(bounce) = bounce(&disc, side, restitution) {
                disc.velocity = bounce.velocity;
            }
        }
        let mut tally = Tally::new(label);
        judge_ulps(&mut tally, root, disc.velocity, &expected)?;
        findings.push(tally.finish());
    }
    let settings = Settings { walls: Some(walls), ..Settings::default() };
    let mut run = arena::Run::new(&Setup { settings, discs: vec![disc] });
    // Any instant before the next wall will do.
    run.pass(1e-3 * disc.radius / disc.velocity.length().max(f64::MIN_POSITIVE))?;
    let mut tally = Tally::new("in an arena");
    judge_ulps(&mut tally, root, run.discs()[0].velocity, &expected)?;
    findings.push(tally.finish());
    Ok(findings)
}

fn reversed(sides: &[Side]) -> Vec<Side> {
    sides.iter().rev().copied().collect()
}

fn restitution(input: &Field) -> Read<f64> {
    let field = input.get("e")?;
    let value = field.number()?;
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(field.wrong("must be from 0 to 1")) }
}

/// Velocity components against the `<n> ulp` of the tolerance.
fn judge_ulps(tally: &mut Tally, root: &Field, velocity: DVec2, expected: &Field) -> Read<()> {
    let field = root.get("tolerance")?.get("value")?;
    let ulps = field.words()?.split_whitespace().next().and_then(|n| n.parse::<f64>().ok());
    let ulps = ulps.ok_or_else(|| field.wrong("must be `<number> ulp`"))?;
    for (axis, name) in ["vx", "vy"].into_iter().enumerate() {
        let wanted = expected.item(axis)?.decimal()?;
        let size = wanted.hi.abs();
        tally.near(name, velocity[axis], wanted, ulps * (size.next_up() - size));
    }
    Ok(())
}

/// Discs that all touch at once: what the world would detect is resolved. `v` along x, `momentum`
/// and `energy` within the tolerance times the largest speed, momentum and energy.
pub fn cradle(root: &Field, _: Effort) -> Findings {
    let before = Setup::read(&root.get("inputs")?)?;
    let expected = root.get("expected")?;
    let tolerance = root.get("tolerance")?.get("value")?.formula(&[])?;
    let broad_phase = Plan::of(&before.settings, &before.discs).broad_phase(before.discs.len());
    let pairs = touching_pairs(&before.discs, 0.0, broad_phase);
    let mut tally = Tally::new("all at once");
    let Ok(pairs) = pairs else {
        tally.fail("too many touching pairs");
        return Ok(vec![tally.finish()]);
    };
    let (after, _) = resolve_all(&before, &pairs);
    let speed = before.discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
    let velocities = expected.get("v")?;
    for (k, disc) in after.iter().enumerate() {
        let wanted = velocities.item(k)?.decimal()?;
        tally.near(&format!("vx of {k}"), disc.velocity.x, wanted, tolerance * speed);
        tally.exact("vy", disc.velocity.y, before.discs[k].velocity.y);
    }
    let momentum: RunningSum = after.iter().map(|disc| disc.mass * disc.velocity.x).collect();
    let energy: RunningSum = after.iter().map(Disc::kinetic_energy).collect();
    for (name, value) in [("momentum", momentum.value()), ("energy", energy.value())] {
        let wanted = expected.get(name)?.decimal()?;
        tally.near(name, value, wanted, tolerance * wanted.hi.abs());
    }
    Ok(vec![tally.finish()])
}

/// Contacts at the same instant that share a disc: `v0`, `v1`, ... within the tolerance, `v` being
/// the largest speed; momentum and energy kept to 8u.
pub fn symmetric(root: &Field, _: Effort) -> Findings {
    let inputs = root.get("inputs")?;
    let before = Setup::read(&inputs)?;
    let last = before.discs.len().saturating_sub(1) as u64;
    let mut pairs = Vec::new();
    for contact in inputs.get("contacts")?.items()? {
        let [i, j] = [contact.item(0)?.count(last)?, contact.item(1)?.count(last)?];
        pairs.push((i as usize, j as usize));
    }
    let speed = before.discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
    let tolerance = root.get("tolerance")?.get("value")?.formula(&[("v", speed)])?;
    let expected = root.get("expected")?.get("generalised_reflection")?;
    let (after, _) = resolve_all(&before, &pairs);
    let mut tally = Tally::new("all at once");
    for (k, disc) in after.iter().enumerate() {
        let wanted = expected.get(&format!("v{k}"))?;
        for (axis, name) in ["vx", "vy"].into_iter().enumerate() {
            let wanted = wanted.item(axis)?.decimal()?;
            tally.near(&format!("{name} of {k}"), disc.velocity[axis], wanted, tolerance);
        }
    }
    let energy = |discs: &[Disc]| discs.iter().map(Disc::kinetic_energy).sum::<f64>();
    let momentum = |discs: &[Disc]| discs.iter().map(|d| d.mass * d.velocity).sum::<DVec2>();
    let (start, size) = (energy(&before.discs), momentum(&before.discs).length());
    tally.within("energy", (energy(&after) - start).abs(), 8.0 * UNIT_ROUNDOFF * start);
    let change = (momentum(&after) - momentum(&before.discs)).length();
    tally.within("momentum", change, 8.0 * UNIT_ROUNDOFF * size);
    Ok(vec![tally.finish()])
}

fn resolve_all(before: &Setup, pairs: &[(usize, usize)]) -> (Vec<Disc>, Vec<Contact>) {
    let mut discs = before.discs.clone();
    // A pair that the file does not have is no pair.
    let pairs: Vec<_> = pairs.iter().copied().filter(|&(_, j)| j < discs.len()).collect();
    let resolved = resolve(&mut discs, &pairs, before.settings.restitution, 0.0);
    (discs, resolved.contacts)
}
