//! A first look at a recording: what contacts of two discs alone and turns of one alone say of the
//! law.
//!
//! Nothing is judged here.

use super::flight::{Course, Flight, Means, Span};
use super::groups;
use super::judge::{Encounter, JUDGED, VAGUE};
use super::law::{Law, Turn};
use super::noise::Noise;
use super::{Frame, run};
use crate::world::Side;

/// Part of a change that may lie along a wall.
const ALONG_WALL: f64 = 1e-3;

/// Restitutions with their deviations, and turns at walls.
pub(super) type Survey = (Vec<(f64, f64)>, Vec<Turn>);

/// Looks at all frames.
pub(super) fn survey(frames: &[Frame], law: &Law, noise: &Noise, tolerance: f64) -> Survey {
    let (mut contacts, mut turns) = (Vec::new(), Vec::new());
    for (before, after, seconds) in super::steps(frames) {
        let span = Span::new(seconds, law.drag);
        let means = Means { law, noise, fastest: run::fastest(before, after) };
        if !law.shows_nearest(before, means.fastest, span.length) {
            continue;
        }
        let flights: Vec<Flight> = super::alike(before, after)
            .map(|(before, after)| means.flight(before, after, &span))
            .collect();
        let Ok(found) = groups::find(&flights, &span, &means, tolerance) else { continue };
        for group in &found.groups {
            match *group.as_slice() {
                [k] => turns.extend(turn(&flights[k], law, span.length)),
                [i, j] => {
                    contacts.extend(contact((&flights[i], &flights[j]), law, &span, tolerance))
                }
                _ => {}
            }
        }
    }
    (contacts, turns)
}

/// The restitution of two discs, if nothing but that could be wrong with their contact.
fn contact(
    (a, b): (&Flight, &Flight),
    law: &Law,
    span: &Span,
    tolerance: f64,
) -> Option<(f64, f64)> {
    let bent = |flight: &Flight| matches!(flight.course, Course::Bent(_));
    if !bent(a) || !bent(b) {
        return None;
    }
    let encounter = Encounter::new(a, b, span.length, law);
    let seen = encounter.look(tolerance);
    let (kinds, _) = encounter.judge(&seen, Some(seen.restitution.0), tolerance);
    let (restitution, sigma) = seen.restitution;
    let sound = (0.0..1.5).contains(&restitution) && sigma <= VAGUE && seen.approach > 0.0;
    (sound && seen.reached && kinds.iter().all(super::findings::Kind::is_of_instant))
        .then_some((restitution, sigma))
}

/// The wall at which a disc turned round, if it did so along an axis.
fn turn(flight: &Flight, law: &Law, length: f64) -> Option<Turn> {
    let Course::Bent(instant) = flight.course else { return None };
    let (change, sigma) = (flight.change, flight.sigma);
    let size = change.length();
    let slack = ALONG_WALL * size + JUDGED * sigma.of_change();
    let side = match (change.x.abs() <= slack, change.y.abs() <= slack) {
        (false, true) => {
            if change.x > 0.0 {
                Side::Left
            } else {
                Side::Right
            }
        }
        (true, false) => {
            if change.y > 0.0 {
                Side::Bottom
            } else {
                Side::Top
            }
        }
        _ => return None,
    };
    let n = side.normal();
    let (before, after) = (flight.before.velocity.dot(n), flight.after.velocity.dot(n));
    if before <= 0.0 || after > JUDGED * sigma.velocity {
        return None;
    }
    let fall = flight.fall(law);
    let at = flight.before.position
        + (flight.before.velocity + 0.5 * fall * instant) * instant
        + n * flight.before.radius;
    Some(Turn {
        side,
        place: at.dot(n.abs()),
        tolerance: JUDGED * sigma.of_rest(length) + 0.02 * flight.before.radius,
        restitution: -after / before,
    })
}
