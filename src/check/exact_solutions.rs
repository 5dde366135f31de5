//! Kinds `edmd_*` whose answer is known in closed form: Galperin's billiard, the Tonks gas,
//! unfolded and closed orbits, the cradle. No chaos, so every digit lost is the engine's.

use std::collections::BTreeSet;

use glam::DVec2;

use super::Effort;
use super::arena::{Run, Setup, Trouble};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use crate::exact::UNIT_ROUNDOFF;
use crate::world::{Contact, Disc, Partner, Side};

type Findings = Result<Vec<Finding>, Trouble>;

/// Two discs and a wall. The counts are exact; `|dV| <=` and `|dv| <=` bound the final velocities
/// of the big (second) and the small disc, `times rel` the event times, all in `N`, the number of
/// collisions, `|V|`, the first speed of the big disc, and `M/m`.
pub fn galperin(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, tolerance) = (Setup::read(&inputs)?, root.get("tolerance")?.get("kind")?);
    let [small, big] = setup.discs[..] else {
        return Err(inputs.wrong("must have two bodies").into());
    };
    let mut run = Run::new(&setup);
    let contacts = run.contacts(inputs.get("t_end")?.finite()?)?;
    let total = expected.get("total_collisions")?.count(u64::MAX)?;
    let names = [("N", total as f64), ("|V|", big.velocity.length()), ("M", big.mass)];
    let names = [&names[..], &[("m", small.mass)]].concat();
    let mut tally = Tally::new("counts, times, velocities");
    tally.exact("collisions", contacts.len() as u64, total);
    tally.exact("of the pair", run.pairs, expected.get("pair_collisions")?.count(u64::MAX)?);
    tally.exact("with the wall", run.walls, expected.get("wall_collisions")?.count(u64::MAX)?);
    let relative = tolerance.formula_after("times rel", &names)?;
    for event in expected.get("events")?.items()? {
        judge_numbered(&mut tally, &event, &contacts, relative)?;
    }
    if let (Some(last), Some(time)) = (contacts.last(), expected.find("last_event_time")) {
        let bound = relative * time.number()?.abs();
        tally.near("last event", last.time, time.decimal()?, bound);
    }
    let after = run.discs();
    let bound = tolerance.formula_after("|dV| <=", &names)?;
    tally.near("V", after[1].velocity.x, expected.get("final_v_big")?.decimal()?, bound);
    let bound = tolerance.formula_after("|dv| <=", &names)?;
    tally.near("v", after[0].velocity.x, expected.get("final_v_small")?.decimal()?, bound);
    Ok(vec![tally.finish()])
}

/// The contact with number `k`: `type` wall or not, and the time to so much of itself.
fn judge_numbered(
    tally: &mut Tally,
    event: &Field,
    contacts: &[Contact],
    relative: f64,
) -> Read<()> {
    let k = event.get("k")?.count(u64::MAX)? as usize;
    let Some(contact) = k.checked_sub(1).and_then(|k| contacts.get(k)) else {
        tally.fail(format!("event {k} is missing"));
        return Ok(());
    };
    let wall = event.get("type")?.words()? == "wall";
    tally.exact(&format!("event {k} a wall"), matches!(contact.b, Partner::Wall(_)), wall);
    let time = event.get("t")?;
    let bound = relative * time.number()?.abs();
    tally.near(&format!("t of event {k}"), contact.time, time.decimal()?, bound);
    Ok(())
}

/// Equal discs on a line. Counts exact; `x` within `x` (gold: `x_gold`), `vx` within `vx`; nothing
/// may leave the line.
pub fn tonks(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, tolerance) = (Setup::read(&inputs)?, root.get("tolerance")?);
    let mut run = Run::new(&setup);
    run.pass(inputs.get("t_end")?.finite()?)?;
    let mut tally = Tally::new("state at the end");
    tally.exact("pairs", run.pairs, expected.get("pair_collisions")?.count(u64::MAX)?);
    tally.exact("walls", run.walls, expected.get("wall_collisions")?.count(u64::MAX)?);
    let bound = |key: &str| tolerance.get(key)?.number();
    let (pass, gold, of_v) = (bound("x")?, bound("x_gold")?, bound("vx")?);
    let (x, vx) = (expected.get("x")?, expected.get("vx")?);
    for (k, (disc, before)) in run.discs().iter().zip(&setup.discs).enumerate() {
        let error = super::number::error(disc.position.x, x.item(k)?.decimal()?);
        tally.gold(&format!("x of {k}"), error, pass, gold);
        tally.near(&format!("vx of {k}"), disc.velocity.x, vx.item(k)?.decimal()?, of_v);
        tally.exact("y", disc.position.y, before.position.y);
        tally.exact("vy", disc.velocity.y, before.velocity.y);
    }
    Ok(vec![tally.finish()])
}

/// One disc in a box. Bounces and velocities exact, the place within `value` (gold: `gold`).
pub fn unfold(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let (setup, tolerance) = (Setup::read(&inputs)?, root.get("tolerance")?);
    let mut run = Run::new(&setup);
    let mut x_bounces = 0;
    run.advance(inputs.get("t_end")?.finite()?, |contact| {
        x_bounces += u64::from(matches!(contact.b, Partner::Wall(Side::Left | Side::Right)));
    })?;
    let mut tally = Tally::new("state at the end");
    tally.exact("x bounces", x_bounces, expected.get("x_bounces")?.count(u64::MAX)?);
    let y_bounces = run.walls - x_bounces;
    tally.exact("y bounces", y_bounces, expected.get("y_bounces")?.count(u64::MAX)?);
    let (pass, gold) = (tolerance.get("value")?.number()?, tolerance.get("gold")?.number()?);
    let disc = run.discs()[0];
    for (name, value) in [("x", disc.position.x), ("y", disc.position.y)] {
        let error = super::number::error(value, expected.get(name)?.decimal()?);
        tally.gold(name, error, pass, gold);
    }
    for (name, value) in [("vx", disc.velocity.x), ("vy", disc.velocity.y)] {
        tally.near(name, value, expected.get(name)?.decimal()?, 0.0);
    }
    Ok(vec![tally.finish()])
}

/// An orbit of dyadic numbers that closes: state and count at the end are exact.
pub fn closed_orbit(root: &Field, _: Effort) -> Findings {
    let (inputs, expected) = (root.get("inputs")?, root.get("expected")?);
    let setup = Setup::read(&inputs)?;
    let mut run = Run::new(&setup);
    run.pass(inputs.get("t_end")?.finite()?)?;
    let mut tally = Tally::new("state at the end");
    tally.exact("walls", run.walls, expected.get("wall_collisions")?.count(u64::MAX)?);
    judge_state(&mut tally, &run.discs()[0], &expected)?;
    Ok(vec![tally.finish()])
}

/// `x`, `y`, `vx`, `vy` of one disc, exactly.
pub fn judge_state(tally: &mut Tally, disc: &Disc, expected: &Field) -> Read<()> {
    let (p, v) = (disc.position, disc.velocity);
    for (name, value) in [("x", p.x), ("y", p.y), ("vx", v.x), ("vy", v.y)] {
        tally.near(name, value, expected.get(name)?.decimal()?, 0.0);
    }
    Ok(())
}

/// A disc on the line between two fixed ones, for `n_bounces`: every bounce exactly at its time
/// (from the gaps and the speed, dyadic), never off the line, speed kept.
pub fn axis_orbit(root: &Field, _: Effort) -> Findings {
    let inputs = root.get("inputs")?;
    let setup = Setup::read(&inputs)?;
    let bounces = inputs.get("n_bounces")?.count(1 << 40)?;
    let Some((first, between)) = bounce_times(&setup.discs) else {
        return Err(inputs.wrong("must be a disc moving in x between two fixed discs").into());
    };
    let due = |k: u64| first + between * (k as f64 - 1.0);
    let mut tally = Tally::new(format!("{bounces} bounces"));
    let mut run = Run::new(&setup);
    let (mut k, mut latest) = (0, 0.0f64);
    run.advance(due(bounces) + 0.5 * between, |contact| {
        k += 1;
        latest = latest.max((contact.time - due(k)).abs());
    })?;
    tally.exact("bounces", k, bounces);
    tally.within("time of a bounce", latest, 0.0);
    let (disc, before) = (run.discs()[0], setup.discs[0]);
    let bits = |v: DVec2| v.y.to_bits();
    tally.exact("bits of y", bits(disc.position), bits(before.position));
    tally.exact("bits of vy", bits(disc.velocity), bits(before.velocity));
    tally.exact("|vx|", disc.velocity.x.abs(), before.velocity.x.abs());
    Ok(vec![tally.finish()])
}

/// Time of the first bounce of the first disc, and from then on between bounces.
fn bounce_times(discs: &[Disc]) -> Option<(f64, f64)> {
    let [disc, one, other] = discs else { return None };
    let fixed = one.mass.is_infinite() && other.mass.is_infinite();
    if !fixed || disc.velocity.x == 0.0 {
        return None;
    }
    let towards = |a: &&Disc| (a.position.x > disc.position.x) == (disc.velocity.x > 0.0);
    let ahead = [one, other].into_iter().find(towards)?;
    let reach = |a: &Disc| a.radius + disc.radius;
    let free = (one.position.x - other.position.x).abs() - reach(one) - reach(other);
    let gap = (ahead.position.x - disc.position.x).abs() - reach(ahead);
    let speed = disc.velocity.x.abs();
    Some((gap / speed, free / speed))
}

/// Discs in a row. `v:` and `times:` are formulas in `n_collisions`, `|v0|` and `t`; number and
/// order of each disc's contacts are exact where the smallest gap is above `gaps >`.
pub fn cradle(root: &Field, _: Effort) -> Findings {
    let inputs = root.get("inputs")?;
    let tolerance = root.get("tolerance")?.get("value")?;
    let countable = tolerance.number_after("gaps >")?;
    let scene = Setup::read_laws(&inputs)?;
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let setup = scene.with(super::arena::discs(&input.get("bodies")?)?);
        let last = expected.get("last_collision_time")?;
        let mut run = Run::new(&setup);
        let contacts = run.contacts(2.0 * last.finite()?)?;
        let mut tally = Tally::new(label);
        let number = expected.get("collisions")?.count(u64::MAX)?;
        if smallest_gap(&setup.discs) > countable {
            tally.exact("collisions", contacts.len() as u64, number);
            if let Some(order) = expected.find("order") {
                judge_order(&mut tally, &contacts, &order)?;
            }
        }
        let speed = setup.discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max);
        let time = last.number()?;
        let names = [("n_collisions", number as f64), ("|v0|", speed), ("t", time)];
        let bound = tolerance.formula_after("times:", &names)?;
        let ours = contacts.last().map_or(f64::NAN, |contact| contact.time);
        tally.near("last time", ours, last.decimal()?, bound);
        let (bound, velocities) = (tolerance.formula_after("v:", &names)?, expected.get("v")?);
        for (k, disc) in run.discs().iter().enumerate() {
            let wanted = velocities.item(k)?.decimal()?;
            tally.near(&format!("v of {k}"), disc.velocity.x, wanted, bound);
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// The smallest gap between neighbours in the list, beyond the rounding of the coordinates.
fn smallest_gap(discs: &[Disc]) -> f64 {
    let gap = |pair: &[Disc]| {
        let distance = (pair[1].position.x - pair[0].position.x).abs();
        distance - pair[0].radius - pair[1].radius - UNIT_ROUNDOFF * distance
    };
    discs.windows(2).map(gap).fold(f64::INFINITY, f64::min)
}

/// Contacts as "a-b", compared disc by disc: events of different discs at one instant have no order
/// that doubles could tell, those of one disc have.
fn judge_order(tally: &mut Tally, contacts: &[Contact], order: &Field) -> Read<()> {
    let words = |contact: &Contact| match contact.b {
        Partner::Disc(b) => (contact.a.to_string(), b.to_string()),
        Partner::Wall(side) => (contact.a.to_string(), super::arena::letter(side).to_owned()),
        Partner::Segment(k) => (contact.a.to_string(), format!("segment {k}")),
    };
    let ours: Vec<(String, String)> = contacts.iter().map(words).collect();
    let mut theirs = Vec::new();
    for field in order.items()? {
        let pair = field.words()?.split_once('-').ok_or_else(|| field.wrong("must be `a-b`"))?;
        theirs.push((pair.0.to_owned(), pair.1.to_owned()));
    }
    let met: BTreeSet<&String> = theirs.iter().flat_map(|(a, b)| [a, b]).collect();
    for disc in met {
        let of = |list: &[(String, String)]| -> Vec<(String, String)> {
            list.iter().filter(|(a, b)| a == disc || b == disc).cloned().collect()
        };
        tally.exact(&format!("contacts of {disc}"), of(&ours), of(&theirs));
    }
    Ok(())
}
