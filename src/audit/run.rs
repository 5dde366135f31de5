//! From one sample to the next: every stage of the judgement in order.
//!
//! Nothing here computes a collision; it keeps what one interval must know of the one before.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::findings::{Break, Collision, Findings, Impulse, Kind, Met, Violation};
use super::flight::{self, Course, Flight, Means, Span};
use super::groups::{self, Crossing, Groups};
use super::judge::{Encounter, JUDGED};
use super::law::Law;
use super::noise::{Noise, median};
use super::overlaps::Overlaps;
use super::silent::Silence;
use super::surroundings::Surroundings;
use super::verdict::{Court, Verdict, gain, is_vague};
use super::{Frame, Listener, Options, alike};
use crate::detect::impact::pair_impact;
use crate::resolve::pair::MassFractions;
use crate::world::{Disc, DiscId};

/// A time between samples above so many usual ones is a gap.
const GAP: f64 = 1.5;

/// Usual times between samples beyond which nothing between them is judged.
const GAP_JUDGED: f64 = 20.0;

/// Samples over which a wrong collision is followed.
const PARTS_MAX: u32 = 256;

/// Impulses without a partner at one interval among which pairs are looked for.
const LONELY_MAX: usize = 64;

/// A run through a recording.
pub(super) struct Run {
    findings: Findings,
    tolerance: f64,
    surroundings: Rc<Surroundings>,
    silence: Silence,
    last: Option<Frame>,
    overlaps: Overlaps,
    held: BTreeMap<(DiscId, DiscId), Held>,
}

/// A wrong collision that may go on at the next sample.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// The two before it began.
    discs: [Disc; 2],
    /// Between which samples, s.
    began: f64,
    ended: f64,
    parts: u32,
    collision: Collision,
}

/// The largest speed of two frames, m/s.
pub(super) fn fastest(before: &Frame, after: &Frame) -> f64 {
    let both = before.discs.iter().chain(&after.discs);
    both.map(|disc| disc.velocity.length_squared()).fold(0.0, f64::max).sqrt()
}

impl Run {
    pub fn new(law: Law, noise: Noise, options: &Options) -> Self {
        let mut findings = Findings::new(law, noise);
        findings.tolerance = options.tolerance;
        findings.crash_speed = options.crash_speed;
        Self {
            findings,
            tolerance: options.tolerance,
            surroundings: Rc::new(options.surroundings.clone()),
            silence: Silence::default(),
            last: None,
            overlaps: Overlaps::default(),
            held: BTreeMap::new(),
        }
    }

    /// The usual time between samples is that of these, and whoever is silent.
    pub fn expect_steps_of(&mut self, frames: &[Frame]) {
        let mut steps: Vec<f64> = super::steps(frames).map(|(_, _, seconds)| seconds).collect();
        self.findings.usual_step = median(&mut steps);
        self.silence.learn(frames);
    }

    /// Takes the samples of a stamp, and judges what is ready.
    pub fn hear(&mut self, frame: Frame, listener: &mut Listener) {
        let Findings { law, noise, .. } = &self.findings;
        let ready = self.silence.hear(frame, law, noise);
        ready.into_iter().for_each(|frame| self.step(frame, listener));
    }

    /// Judges what happened since the last sample.
    fn step(&mut self, frame: Frame, listener: &mut Listener) {
        let counts = &mut self.findings.counts;
        counts.frames += 1;
        counts.samples += frame.discs.len() as u64;
        counts.discs = counts.discs.max(frame.discs.len() as u64);
        let energy = frame.discs.iter().map(Disc::kinetic_energy).sum();
        self.findings.ledger.last_j = energy;
        let Some(last) = self.last.take() else {
            self.findings.times = (frame.seconds(), frame.seconds());
            self.findings.ledger.first_j = energy;
            self.last = Some(frame);
            return;
        };
        self.findings.times.1 = frame.seconds();
        if self.is_continued(&last, &frame) {
            self.between(&last, &frame, listener);
        } else {
            self.end_held(f64::INFINITY, listener);
            self.end_overlaps(f64::INFINITY);
        }
        self.last = Some(frame);
    }

    /// Ends the run.
    pub fn finish(mut self, listener: &mut Listener) -> Findings {
        let Findings { law, noise, .. } = &self.findings;
        let left = self.silence.end(law, noise);
        left.into_iter().for_each(|frame| self.step(frame, listener));
        self.findings.counts.carried = self.silence.carried;
        self.findings.counts.samples -= self.silence.carried;
        self.end_held(f64::INFINITY, listener);
        self.end_overlaps(f64::INFINITY);
        self.findings.overlaps = self.overlaps.count;
        self.findings.deepest_overlap = self.overlaps.deepest;
        self.findings
    }

    /// Whether what happened between two samples can be judged.
    fn is_continued(&mut self, last: &Frame, frame: &Frame) -> bool {
        let (from, to) = (last.seconds(), frame.seconds());
        if frame.time_ns <= last.time_ns {
            if frame.time_ns < last.time_ns {
                self.findings.add_break(Break::Reset { time_s: to });
            } else {
                self.findings.counts.repeated += 1;
            }
            return false;
        }
        let law = &self.findings.law;
        let length = Span::new(to - from, law.drag).length;
        if !law.shows_nearest(frame, fastest(last, frame), length) {
            self.findings.counts.far += 1;
            return false;
        }
        let usual = self.findings.usual_step;
        if to - from > GAP * usual && usual > 0.0 {
            let missing = ((to - from) / usual).round() as u64 - 1;
            self.findings.add_break(Break::Gap { time_s: from, missing });
        }
        to - from <= GAP_JUDGED * usual || usual == 0.0
    }

    fn between(&mut self, last: &Frame, frame: &Frame, listener: &mut Listener) {
        let law = self.findings.law;
        let seconds = 1e-9 * (frame.time_ns - last.time_ns) as f64;
        let span = Span::new(seconds, law.drag);
        let noise = self.findings.noise;
        let means = Means { law: &law, noise: &noise, fastest: fastest(last, frame) };
        let flights: Vec<Flight> =
            alike(last, frame).map(|(before, after)| means.flight(before, after, &span)).collect();
        self.findings.counts.unpaired += (frame.discs.len() - flights.len()) as u64;
        self.note_jumps(&flights, frame.seconds());
        let Ok(found) = groups::find(&flights, &span, &means, self.tolerance) else {
            self.findings.counts.heaped += 1;
            return;
        };
        let (tolerance, time) = (self.tolerance, last.seconds());
        let surroundings = self.surroundings.clone();
        let unbound = surroundings.unbound(&flights, (last.seconds(), frame.seconds()));
        let court = Court {
            flights: &flights,
            span: &span,
            law: &law,
            surroundings: &surroundings,
            unbound: &unbound,
            tolerance,
            time,
        };
        let through = flights.iter().filter_map(|flight| court.through_a_segment(flight));
        through.for_each(|violation| self.findings.add_violation(violation));
        self.see_overlaps(&court, &found, frame.seconds());
        let mut lonely = Vec::new();
        for (group, verdict) in court.judge_all(&found) {
            let acted = || {
                surroundings.may_have_acted(&flights, &group, &span)
                    || group.iter().any(|&k| court.is_unbound_or_met_one(k))
            };
            let is_told = verdict.is_lawful() || matches!(verdict, Verdict::AtSegment(_));
            if !is_told && acted() {
                self.leave(&court, &group);
            } else {
                self.take(&court, &group, verdict, &mut lonely, listener);
            }
        }
        self.lonely(&court, &lonely, listener);
        self.end_held(frame.seconds(), listener);
        self.end_overlaps(frame.seconds());
    }

    fn note_jumps(&mut self, flights: &[Flight], time_s: f64) {
        for flight in flights.iter().filter(|flight| flight.course == Course::Jumped) {
            self.findings.add_break(Break::Teleport { time_s, disc: flight.before.id });
        }
    }

    fn see_overlaps(&mut self, court: &Court, found: &Groups, time: f64) {
        for &((i, j), depth) in &found.overlaps {
            let (a, b) = (&court.flights[i], &court.flights[j]);
            let new = !self.overlaps.is_open(a.before.id, b.before.id);
            let shift = court.law.shift(a.after.position, b.after.position);
            let beside = Disc { position: b.after.position + shift, ..b.after };
            self.overlaps.see((&a.after, &beside), depth, time);
            if new && let Some(entered) = entered(court, (i, j)) {
                let at = court.time + court.span.seconds_at(entered.instant, court.law.drag);
                self.overlaps.enter(a.before.id, b.before.id, &entered, at);
            }
        }
        for crossing in &found.crossings {
            self.cross(court, crossing, found);
        }
    }

    /// Two undisturbed discs ran into each other.
    fn cross(&mut self, court: &Court, crossing: &Crossing, found: &Groups) {
        let (i, j) = crossing.pair;
        let (a, b) = (&court.flights[i], &court.flights[j]);
        let (a_id, b_id) = (a.before.id, b.before.id);
        let time = court.time + court.span.seconds_at(crossing.instant, court.law.drag);
        let overlaps = found.overlaps.iter().any(|(pair, _)| *pair == crossing.pair);
        if overlaps {
            self.overlaps.enter(a_id, b_id, crossing, time);
            return;
        }
        let e = court.law.restitution.unwrap_or(0.0);
        if self.overlaps.is_open(a_id, b_id) || !is_seen(a, b, crossing, e) {
            return;
        }
        let w = (b.before.velocity - a.before.velocity).length();
        let at = a.before.position + a.before.velocity * crossing.instant;
        self.findings.add_violation(Violation {
            kind: Kind::Tunnelling,
            also: Vec::new(),
            time_s: time,
            discs: vec![a_id, b_id],
            wall: false,
            place_m: (at + crossing.normal * a.before.radius).to_array(),
            approach_speed_mps: crossing.approach,
            severity: (1.0 + e) * crossing.approach / w,
            detail: format!("{:.3e} m deep on the way", crossing.depth),
        });
    }

    fn take(
        &mut self,
        court: &Court,
        group: &[usize],
        verdict: Verdict,
        lonely: &mut Vec<usize>,
        listener: &mut Listener,
    ) {
        let energy: f64 = group.iter().map(|&k| gain(&court.flights[k])).sum();
        let ledger = &mut self.findings.ledger;
        match verdict {
            Verdict::Collisions(collisions) => {
                if let ([i, j], [collision]) = (group, collisions.as_slice()) {
                    self.pair((court, *i, *j), collision, listener);
                } else {
                    self.many(&collisions, energy, listener);
                }
            }
            Verdict::Violated(collisions, violation) => {
                self.findings.add_violation(violation);
                self.answer(court, group);
                self.many(&collisions, energy, listener);
            }
            Verdict::AtSegment(collision) => self.many(&[collision], energy, listener),
            Verdict::Alone(k) => lonely.push(k),
            Verdict::Displaced => {
                ledger.unexplained_j += energy;
                self.findings.counts.displaced += 1;
            }
            Verdict::Ambiguous => {
                ledger.clusters_j += energy;
                ledger.clusters_law_j += energy;
                self.findings.counts.ambiguous += 1;
                self.answer(court, group);
            }
        }
    }

    /// Leaves a group unjudged, and what was held of its pairs.
    fn leave(&mut self, court: &Court, group: &[usize]) {
        let is_of = |id: DiscId| group.iter().any(|&k| court.flights[k].before.id == id);
        self.held.retain(|(a, b), _| !is_of(*a) || !is_of(*b));
        self.answer(court, group);
        self.findings.counts.beside += 1;
        let energy: f64 = group.iter().map(|&k| gain(&court.flights[k])).sum();
        self.findings.ledger.unexplained_j += energy;
    }

    /// Collisions of a group, or walls.
    fn many(&mut self, collisions: &[Collision], energy: f64, listener: &mut Listener) {
        let walls = |collision: &&Collision| collision.b == Met::Wall;
        let alone = collisions.iter().all(|collision| collision.b == Met::Wall);
        let law: f64 = collisions.iter().map(|collision| collision.energy_law).sum();
        let ledger = &mut self.findings.ledger;
        if alone && !collisions.is_empty() {
            ledger.walls_j += energy;
        } else {
            let at_walls: f64 = collisions.iter().filter(walls).map(|each| each.energy).sum();
            ledger.walls_j += at_walls;
            ledger.clusters_j += energy - at_walls;
            ledger.clusters_law_j += law - at_walls;
        }
        for collision in collisions {
            self.add(collision, listener);
        }
    }

    fn add(&mut self, collision: &Collision, listener: &mut Listener) {
        if is_vague(collision) && collision.b != Met::Wall {
            self.findings.counts.vague += 1;
        }
        if let Met::Disc(b) = collision.b {
            self.overlaps.answer(collision.a, b);
        }
        self.findings.add_collision(collision);
        listener(collision);
    }

    fn answer(&mut self, court: &Court, group: &[usize]) {
        for (place, &i) in group.iter().enumerate() {
            for &j in &group[place + 1..] {
                let [a, b] = [i, j].map(|k| court.flights[k].before.id);
                self.overlaps.answer(a, b);
            }
        }
    }

    /// A collision of two discs alone: one that is wrong may go on at the next sample.
    fn pair(
        &mut self,
        (court, i, j): (&Court, usize, usize),
        collision: &Collision,
        listener: &mut Listener,
    ) {
        let (a, b) = (&court.flights[i], &court.flights[j]);
        let key = (a.before.id, b.before.id);
        let held = self.held.remove(&key);
        let (began, discs) =
            held.map_or((court.time, [a.before, b.before]), |held| (held.began, held.discs));
        let ended = court.time + court.span.seconds;
        let collision = match held {
            None => *collision,
            Some(_) => whole(court, (a, b), discs, began),
        };
        let parts = held.map_or(1, |held| held.parts + 1);
        let near = 1e-2 * a.before.radius.min(b.before.radius);
        let reach = a.before.radius + b.before.radius;
        let touches = court.law.apart_after(a, b).length() - reach <= near;
        if !collision.kinds.is_empty() && touches && parts < PARTS_MAX {
            self.held.insert(key, Held { discs, began, ended, parts, collision });
        } else {
            self.add_pair(&collision, listener);
        }
    }

    fn add_pair(&mut self, collision: &Collision, listener: &mut Listener) {
        let ledger = &mut self.findings.ledger;
        ledger.pairs_j += collision.energy;
        ledger.pairs_law_j += collision.energy_law;
        self.add(collision, listener);
    }

    /// Ends wrong collisions that did not go on before this time.
    fn end_held(&mut self, before: f64, listener: &mut Listener) {
        let over: Vec<_> =
            self.held.iter().filter(|(_, held)| held.ended < before).map(|(k, _)| *k).collect();
        for key in over {
            if let Some(held) = self.held.remove(&key) {
                self.add_pair(&held.collision, listener);
            }
        }
    }

    fn end_overlaps(&mut self, before: f64) {
        for violation in self.overlaps.close(before) {
            self.findings.add_violation(violation);
        }
    }

    /// Discs that changed alone: two of them that exchanged momentum out of reach, or impulses
    /// without a partner.
    fn lonely(&mut self, court: &Court, lonely: &[usize], listener: &mut Listener) {
        let mut free: Vec<usize> = lonely.to_vec();
        if free.len() <= LONELY_MAX {
            while let Some((i, j)) = phantom(court, &free) {
                free.retain(|&k| k != i && k != j);
                let (a, b) = (&court.flights[i], &court.flights[j]);
                let encounter = Encounter::new(a, b, court.span.length, court.law);
                let seen = encounter.look(court.tolerance);
                let (mut kinds, wrong) =
                    encounter.judge(&seen, court.law.restitution, court.tolerance);
                kinds.add(Kind::Phantom);
                let sight = super::findings::Sight::Alone;
                self.add_pair(&court.collision((a, b), &seen, kinds, wrong, sight), listener);
            }
        }
        for &k in &free {
            let flight = &court.flights[k];
            if has_neighbour(court, &free, k) {
                // Some engines answer contacts of several discs before they are there.
                self.findings.ledger.clusters_j += gain(flight);
                self.findings.ledger.clusters_law_j += gain(flight);
                self.findings.counts.ambiguous += 1;
                continue;
            }
            let instant = if let Course::Bent(instant) = flight.course { instant } else { 0.0 };
            let at = flight.before.position + flight.before.velocity * instant;
            self.findings.ledger.unexplained_j += gain(flight);
            self.findings.add_impulse(Impulse {
                time_s: court.time + court.span.seconds_at(instant, court.law.drag),
                disc: flight.before.id,
                place_m: at.to_array(),
                change_mps: flight.change.to_array(),
            });
        }
    }
}

/// Whether another of these discs may have met this one within twice the time.
fn has_neighbour(court: &Court, free: &[usize], k: usize) -> bool {
    let a = &court.flights[k];
    free.iter().filter(|&&other| other != k).any(|&other| {
        let b = &court.flights[other];
        let speed =
            |flight: &Flight| flight.before.velocity.length().max(flight.after.velocity.length());
        let way = 2.0 * (speed(a) + speed(b)) * court.span.length;
        let reach = a.before.radius + b.before.radius;
        court.law.apart(a, b).length() <= reach + way
    })
}

/// The whole of a collision that took several samples.
fn whole(court: &Court, (a, b): (&Flight, &Flight), discs: [Disc; 2], began: f64) -> Collision {
    let seconds = court.time + court.span.seconds - began;
    let span = Span::new(seconds, court.law.drag);
    let join = |before: Disc, flight: &Flight| {
        // Later velocities are those of the last sample, scaled back to the first.
        let velocity = flight.after.velocity / court.span.scale * span.scale;
        let shift = court.law.shift(before.position, flight.after.position);
        let after = Disc { position: flight.after.position + shift, velocity, ..flight.after };
        let fall = flight.fall(court.law);
        let change = velocity - before.velocity - fall * span.length;
        let straight = before.position + (before.velocity + 0.5 * fall * span.length) * span.length;
        let mut sigma = flight.sigma;
        sigma.velocity += flight::driven_sigma(court.law, span.length - court.span.length);
        Flight { before, after, change, rest: after.position - straight, sigma, ..*flight }
    };
    let (a, b) = (join(discs[0], a), join(discs[1], b));
    let encounter = Encounter::new(&a, &b, span.length, court.law);
    let seen = encounter.look(court.tolerance);
    let (kinds, wrong) = encounter.judge(&seen, court.law.restitution, court.tolerance);
    let court = Court { span: &span, time: began, ..*court };
    court.collision((&a, &b), &seen, kinds, wrong, super::findings::Sight::Alone)
}

/// How a pair ran into each other, if it was apart at the earlier sample and nobody jumped.
fn entered(court: &Court, (i, j): (usize, usize)) -> Option<Crossing> {
    let (a, b) = (&court.flights[i], &court.flights[j]);
    let d = court.law.apart(a, b);
    let reach = a.before.radius + b.before.radius;
    let near = 1e-3 * a.before.radius.min(b.before.radius);
    if [a, b].into_iter().any(|f| f.course == Course::Jumped) || d.length() < reach - near {
        return None;
    }
    let w = b.before.velocity - a.before.velocity;
    let meet = pair_impact(d, w, reach).filter(|time| *time <= court.span.length);
    let (instant, depth) = (meet.unwrap_or(0.0), 0.0);
    let normal = (d + w * instant).normalize_or_zero();
    Some(Crossing { pair: (i, j), instant, normal, approach: (-w.dot(normal)).max(0.0), depth })
}

/// Whether the change that a collision would have made could be seen.
fn is_seen(a: &Flight, b: &Flight, crossing: &Crossing, restitution: f64) -> bool {
    if a.before.mass.is_infinite() && b.before.mass.is_infinite() {
        return false;
    }
    let shares = MassFractions::of(a.before.mass, b.before.mass);
    let jump = (1.0 + restitution) * crossing.approach;
    let seen = |flight: &Flight, share: f64| share * jump > 2.0 * JUDGED * flight.sigma.of_change();
    seen(a, shares.a.hi) || seen(b, shares.b.hi)
}

/// Two discs that changed at once, approached, and exchanged momentum, out of reach.
fn phantom(court: &Court, free: &[usize]) -> Option<(usize, usize)> {
    let bend = |k: usize| match court.flights[k].course {
        Course::Bent(instant) => Some(instant),
        _ => None,
    };
    for (place, &i) in free.iter().enumerate() {
        for &j in &free[place + 1..] {
            let (a, b) = (&court.flights[i], &court.flights[j]);
            let (Some(at), Some(bt)) = (bend(i), bend(j)) else { continue };
            let (ma, mb) = (a.before.mass, b.before.mass);
            let gained = (ma * a.change + mb * b.change).length();
            let moved = ma * a.change.length() + mb * b.change.length();
            let sigma = (ma * a.sigma.of_change()).hypot(mb * b.sigma.of_change());
            let allowed = (JUDGED * sigma).max(1e-6 * moved);
            let blur = |flight: &Flight| {
                JUDGED * flight.sigma.of_rest(court.span.length) / flight.change.length()
            };
            let at_once = (at - bt).abs() <= blur(a) + blur(b) + 1e-6 * court.span.length;
            let d = court.law.apart(a, b);
            let approach = (b.before.velocity - a.before.velocity).dot(d) < 0.0;
            if gained <= allowed && allowed < 0.1 * moved && at_once && approach {
                return Some((i, j));
            }
        }
    }
    None
}
