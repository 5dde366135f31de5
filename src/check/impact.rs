//! Kinds `toi_*`: when will discs touch?

use super::Effort;
use super::arena::{Run, Setup, Trouble};
use super::case::{Field, Read};
use super::finding::{Finding, Tally};
use crate::detect::impact::pair_impact_at_any_scale;
use crate::exact::DoubleDouble;
use crate::world::{Contact, Disc, Partner};

/// One pair: `t`, or null for never. The tolerance is a formula in `t`, `s` = r1 + r2, `|w|` the
/// relative speed, `|v_n|` the speed of approach at the start, and `k`, where the impact parameter
/// is `s (1 - 2^-k)`; of kind `rel` it is a multiple of `t`. Never and some time differ by no
/// tolerance.
pub fn pair(root: &Field, _: Effort) -> Result<Vec<Finding>, Trouble> {
    let tolerance = root.get("tolerance")?;
    let mut findings = Vec::new();
    for (label, input, expected) in root.subcases()? {
        let mut tally = Tally::new(label);
        let discs = Setup::read(&input)?.discs;
        let [a, b] = discs[..] else { return Err(input.wrong("must have two bodies").into()) };
        let (d, w) = (b.position - a.position, b.velocity - a.velocity);
        let time = pair_impact_at_any_scale(d, w, a.radius + b.radius);
        match (expected.find("t"), time) {
            (Some(wanted), Some(time)) => {
                let bound = bound(&tolerance, &a, &b, wanted.number()?)?;
                tally.near("t", time, wanted.decimal()?, bound);
            }
            (Some(wanted), None) => tally.fail(format!("never, must be {}", wanted.number()?)),
            (None, Some(time)) => tally.fail(format!("t = {time}, must be never")),
            (None, None) => {}
        }
        findings.push(tally.finish());
    }
    Ok(findings)
}

/// The tolerance of one pair, s.
fn bound(tolerance: &Field, a: &Disc, b: &Disc, time: f64) -> Read<f64> {
    let (d, w) = (b.position - a.position, b.velocity - a.velocity);
    let reach = a.radius + b.radius;
    let (distance, speed) = (d.x.hypot(d.y), w.x.hypot(w.y));
    let approach = (d / distance).dot(w).abs();
    let names = [("t", time), ("s", reach), ("|w|", speed), ("|v_n|", approach), ("k", k(a, b))];
    let bound = tolerance.get("value")?.formula(&names)?;
    let relative = tolerance.get("kind")?.words()? == "rel";
    Ok(if relative { bound * time } else { bound })
}

/// `k` of `|1 - b/s| = 2^-k`, from `s^2 w^2 - (d x w)^2` in double-double.
fn k(a: &Disc, b: &Disc) -> f64 {
    let (d, w) = (b.position - a.position, b.velocity - a.velocity);
    let square = |x: f64| DoubleDouble::product(x, x);
    let reach2 = square(a.radius + b.radius);
    let cross = DoubleDouble::product(d.x, w.y).plus(DoubleDouble::product(-d.y, w.x));
    let swept2 = reach2.times(square(w.x).plus(square(w.y)));
    let difference = swept2.plus(cross.times(cross).negated()).value();
    let swept = swept2.value().sqrt();
    -(difference / (swept * (swept + cross.value().abs()))).abs().log2()
}

/// Many discs and a bullet: the first contact of the arena and its time (formula times `t`); with a
/// `chain`, the discs are met in their order.
pub fn many(root: &Field, _: Effort) -> Result<Vec<Finding>, Trouble> {
    let setup = Setup::read(&root.get("inputs")?)?;
    let expected = root.get("expected")?;
    let first = expected.get("first_hit_index")?.count(setup.discs.len() as u64)? as u32;
    let time = expected.get("t")?;
    let names = [("t", time.number()?)];
    let bound = root.get("tolerance")?.get("value")?.formula(&names)? * time.number()?.abs();
    let mut tally = Tally::new("first hit");
    let contacts = chain(&setup, time.number()?)?;
    let Some(contact) = contacts.first() else {
        tally.fail("no contact");
        return Ok(vec![tally.finish()]);
    };
    tally.exact("hit", (contact.a, contact.b), (0, Partner::Disc(first)));
    tally.near("t", contact.time, time.decimal()?, bound);
    if expected.find("chain").is_some() {
        let order = newly_met(&contacts);
        tally.exact("order of hits", order, (1..setup.discs.len() as u32).collect());
    }
    Ok(vec![tally.finish()])
}

/// The contacts until every disc has been met, or for a million times the time of the first.
fn chain(setup: &Setup, first: f64) -> Result<Vec<Contact>, Trouble> {
    let mut run = Run::new(setup);
    let mut contacts = Vec::new();
    let mut until = 2.0 * first;
    for _ in 0..20 {
        run.advance(until, |contact| contacts.push(*contact))?;
        if newly_met(&contacts).len() + 1 >= setup.discs.len() {
            break;
        }
        until *= 2.0;
    }
    Ok(contacts)
}

/// The discs other than the bullet in the order in which they are first met.
fn newly_met(contacts: &[Contact]) -> Vec<u32> {
    let mut met = Vec::new();
    for contact in contacts {
        let Partner::Disc(partner) = contact.b else { continue };
        for id in [contact.a, partner] {
            if id != 0 && !met.contains(&id) {
                met.push(id);
            }
        }
    }
    met
}
