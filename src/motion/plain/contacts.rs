//! What happens at an event: the contact is resolved, booked and noted, and whoever took part is
//! predicted again. Contacts at the same instant that share a body are found and resolved together.

use glam::DVec2;

use super::body::{Body, State};
use super::remembered::{self, Known};
use super::{Event, Plain, With};
use crate::detect::Pair;
use crate::detect::precise::{self, Sight, time_to_contact};
use crate::exact::{DoubleDouble, DoubleDoubleVec, RunningSum, UNIT_ROUNDOFF};
use crate::resolve::pair::Impact;
use crate::resolve::precise::{bounce, collide};
use crate::resolve::segment::{self, segment_contact};
use crate::resolve::touching::{self, pair_contact};
use crate::resolve::wall;
use crate::world::{Contact, Disc, Side, limits};

/// Events closer than this, in units of their offset or the epoch, are at the same instant: their
/// times differ by no more than rounding.
const SAME_INSTANT: f64 = 16.0 * UNIT_ROUNDOFF;

/// An event missed its contact by rounding if it did by less than this part of a radius.
const ROUNDING: f64 = 1e-9;

/// Two bodies as they touch.
struct Meeting {
    /// The one seen from the other.
    sight: Sight,
    /// `d.d - s^2`, m^2: 0, or an overlap.
    clearance: DoubleDouble,
    /// `d.w`, m^2/s.
    closing: DoubleDouble,
    /// How much later than the event's time they touch, s: rounding, of either sign.
    delay: f64,
    /// What was remembered of them.
    known: Option<Known>,
}

impl Meeting {
    /// How much of `closing` may be rounding.
    fn doubt(&self, a: &Disc, b: &Disc) -> f64 {
        self.known.map_or_else(
            || {
                let speeds = a.velocity.length() + b.velocity.length();
                remembered::ROUNDING * speeds * self.sight.reach.hi
            },
            |known| known.doubt + remembered::ROUNDING * known.closing.hi.abs(),
        )
    }
}

/// Contacts at one instant, and the bodies in them.
struct Together {
    pairs: Vec<Pair>,
    bodies: Vec<usize>,
}

impl Together {
    fn add(&mut self, (i, j): Pair) {
        if !self.pairs.contains(&(i, j)) {
            self.pairs.push((i, j));
        }
        for body in [i, j] {
            if !self.bodies.contains(&body) {
                self.bodies.push(body);
            }
        }
    }
}

impl Plain {
    pub(super) fn process(&mut self, k: usize, event: Event, contacts: &mut Vec<Contact>) {
        match event.with {
            With::Body(partner) => {
                let pairs = self.contacts_at(k, partner, event.time);
                if let [(i, j)] = pairs[..] {
                    self.collide_pair(i, j, event.time, contacts);
                } else if self.laws.periodic.is_some() {
                    // A group may close around the box, where no image shows it whole.
                    let (i, j) = self.by_id(k, partner);
                    self.collide_pair(i, j, event.time, contacts);
                } else {
                    self.collide_together(&pairs, event.time, contacts);
                }
            }
            With::Wall(side) => self.bounce_off(k, side, event.time, contacts),
            With::Segment(segment) => self.bounce_off_segment(k, segment, event.time, contacts),
            With::Renew => {
                self.move_to(k, event.time);
                self.predict_again(&[k], event.time);
            }
            With::Nothing => unreachable!("an event without a partner has no finite time"),
        }
    }

    /// The contacts at one instant that hang together with that of two bodies, by ids in each.
    fn contacts_at(&self, k: usize, l: usize, time: f64) -> Vec<Pair> {
        let latest = time + SAME_INSTANT * time.abs().max(self.clock.epoch());
        let mut found = Together { pairs: vec![self.by_id(k, l)], bodies: vec![k, l] };
        let at_once = |event: &Event| match event.with {
            With::Body(partner) if event.time <= latest => Some(partner),
            _ => None,
        };
        let mut seen = 0;
        while let Some(&body) = found.bodies.get(seen) {
            seen += 1;
            for (other, event) in self.next.iter().enumerate() {
                let Some(partner) = at_once(event) else { continue };
                if other == body || partner == body {
                    found.add(self.by_id(other, partner));
                }
            }
        }
        if found.pairs.len() > 1 {
            self.complete(&mut found, time, latest);
        }
        found.pairs
    }

    /// A body knows only its earliest event: looks at all pairs with a body of the group.
    fn complete(&self, found: &mut Together, time: f64, latest: f64) {
        let mut seen = 0;
        while let Some(&body) = found.bodies.get(seen) {
            seen += 1;
            let watcher = self.watcher(body, time);
            for (other, candidate) in self.bodies.iter().enumerate() {
                if other == body || !self.bodies[body].can_collide_with(candidate) {
                    continue;
                }
                let disc = candidate.roughly_at(time);
                if !self.may_meet(&watcher, &disc, latest - time) {
                    continue;
                }
                if self.meeting(&watcher, other).is_some_and(|wait| wait <= latest - time) {
                    found.add(self.by_id(body, other));
                }
            }
        }
    }

    /// Two bodies, the smaller id first.
    fn by_id(&self, k: usize, l: usize) -> Pair {
        if self.bodies[k].disc.id < self.bodies[l].disc.id { (k, l) } else { (l, k) }
    }

    /// Contacts at one instant that share bodies.
    fn collide_together(&mut self, pairs: &[Pair], time: f64, contacts: &mut Vec<Contact>) {
        let mut places: Vec<usize> = pairs.iter().flat_map(|&(i, j)| [i, j]).collect();
        places.sort_unstable();
        places.dedup();
        let origin = self.move_to(places[0], time).position;
        let mut discs: Vec<Disc> =
            places.iter().map(|&k| self.move_near(k, time, origin)).collect();
        // Every body of a pair is in the sorted list.
        let place = |k: usize| places.partition_point(|&other| other < k);
        let local: Vec<Pair> = pairs.iter().map(|&(i, j)| (place(i), place(j))).collect();
        local.iter().for_each(|&(i, j)| self.note_overlap(places[i], places[j]));
        let restitution = self.restitution(self.laws.restitution, &places, time);
        let resolved = touching::resolve(&mut discs, &local, restitution, self.now);
        self.book_together(&places, &discs, &resolved.contacts);
        for (&k, disc) in places.iter().zip(&discs) {
            if disc.velocity != self.bodies[k].disc.velocity {
                self.set_velocity_of(k, disc.velocity);
            }
            // What doubles made of them must hold, or they would meet again and again.
            self.remembered.forget(k);
        }
        let touched: Vec<_> = resolved.touched.iter().map(|&k| (places[k], None)).collect();
        self.note_contacts(&touched, time, resolved.contacts.len());
        let in_place = |contact: Contact| Contact { point: origin + contact.point, ..contact };
        contacts.extend(resolved.contacts.into_iter().map(in_place));
        self.predict_again(&places, time);
    }

    /// Brings a body to an offset; returns it as seen from a place, so that differences of
    /// positions lose no digits.
    fn move_near(&mut self, k: usize, time: f64, origin: DVec2) -> Disc {
        let disc = self.move_to(k, time);
        let position = self.bodies[k].state().position.plus_double(-origin).hi();
        Disc { position, ..disc }
    }

    fn collide_pair(&mut self, i: usize, j: usize, time: f64, contacts: &mut Vec<Contact>) {
        let (a, b) = (self.move_to(i, time), self.move_to(j, time));
        let b = self.laws.near(a.position, b);
        let restitution = self.restitution(self.laws.restitution, &[i, j], time);
        let meeting = self.meeting_of(i, j, time);
        let (d, closing) = (&meeting.sight.d, meeting.closing);
        if let Some(kicks) = collide((&a, &b), d, closing, restitution) {
            let impact = &kicks.impact;
            self.book_pair(i, j, impact);
            self.kick(i, &kicks.a, time, meeting.delay, j);
            self.kick(j, &kicks.b, time, meeting.delay, i);
            // What changes no digit of a velocity is no sign of a collapse.
            let speeds = a.velocity.length() + b.velocity.length();
            let is_felt = impact.approach_speed > UNIT_ROUNDOFF * speeds;
            let bodies = [(i, Some(j)), (j, Some(i))];
            self.note_contacts(if is_felt { &bodies } else { &[] }, time, 1);
            self.remember(i, j, &meeting, restitution, time);
            contacts.push(pair_contact(&a, &b, impact, self.now));
        }
        self.predict_again(&[i, j], time);
    }

    /// Two bodies at the instant at which they touch: the event's time is that to rounding.
    fn meeting_of(&self, i: usize, j: usize, time: f64) -> Meeting {
        let mut sight = self.sight(i, &self.bodies[i].state(), j, &self.bodies[j].state());
        let known = self.remembered.find(i, j).map(|known| {
            let mut known = *known;
            known.fly(time.into(), &sight);
            known
        });
        let (mut clearance, mut closing) = known.map_or_else(
            || (sight.clearance(), sight.closing()),
            |known| (known.clearance, known.closing),
        );
        let speed2 = known
            .map_or_else(|| sight.w.hi().length_squared().into(), |known| known.speed2(&sight));
        let delay =
            time_to_contact(clearance.value(), closing.value(), speed2.value() / -closing.value());
        // What is no rounding is an overlap, and stays one.
        let farthest = ROUNDING * sight.reach.hi;
        let delay = delay.filter(|delay| delay * delay * speed2.value() <= farthest * farthest);
        let delay = delay.filter(|_| self.laws.gravity.is_none()).unwrap_or(0.0);
        if delay != 0.0 {
            sight = sight.after(delay);
            clearance = DoubleDouble::default();
            let gained = speed2.times_double(delay);
            closing = known.map_or_else(|| sight.closing(), |_| closing.plus(gained));
        }
        Meeting { sight, clearance, closing, delay, known }
    }

    /// Changes the velocity of a body that stands at an offset, as if `delay` (s) later.
    fn kick(&mut self, k: usize, change: &DoubleDoubleVec, time: f64, delay: f64, by: usize) {
        if self.laws.remember_contacts() {
            let mut remembered = std::mem::take(&mut self.remembered);
            let own = self.bodies[k].state();
            let sight = |l: usize| self.sight(k, &own, l, &self.bodies[l].state_at(time));
            remembered.kick((k, by), change, (time, delay), sight);
            self.remembered = remembered;
        }
        self.bodies[k].kick(change, delay);
        self.note_state(k);
    }

    /// Remembers two bodies after their contact.
    fn remember(&mut self, i: usize, j: usize, meeting: &Meeting, restitution: f64, time: f64) {
        let free = [i, j].iter().all(|&k| self.bodies[k].collapse.is_free());
        if !free || !self.laws.remember_contacts() {
            return;
        }
        let closing = meeting.closing.times_double(-restitution);
        let doubt = meeting.doubt(&self.bodies[i].disc, &self.bodies[j].disc);
        self.remembered.remember(Known {
            pair: (i.min(j), i.max(j)),
            clearance: meeting.clearance,
            closing,
            doubt: restitution * doubt,
            time: DoubleDouble::sum(time, meeting.delay),
            reach: meeting.sight.reach,
        });
    }

    fn bounce_off(&mut self, k: usize, side: Side, time: f64, contacts: &mut Vec<Contact>) {
        let mut disc = self.move_to(k, time);
        let Some(walls) = self.laws.walls else { return };
        let mut restitution = self.restitution(walls.restitution, &[k], time);
        if self.laws.gravity.is_some() {
            // No rounding may leave it a little above the wall, or below: flights are short.
            disc.position = walls.onto(side, &disc);
            let slow = disc.velocity.dot(side.normal()) * restitution <= limits::REST_SPEED_MPS;
            let collapses = restitution != walls.restitution;
            if self.laws.presses_on(side) && walls.restitution < 1.0 && (slow || collapses) {
                restitution = 0.0;
            }
            self.set_state(k, disc);
        }
        if let Some(bounce) = wall::bounce(&disc, side, restitution) {
            self.energy.book(-bounce.energy_loss);
            self.momentum.book(side.normal() * -bounce.impulse);
            self.turn_at_wall(k, side, restitution, bounce.approach_speed);
            self.note_contacts(&[(k, None)], time, 1);
            contacts.push(wall::wall_contact(&disc, side, &walls, &bounce, self.now));
        } else if self.laws.presses_on(side) {
            self.lay_down(k, side);
        }
        self.predict_again(&[k], time);
    }

    /// Turns a body at a wall, at the instant at which it really touches.
    fn turn_at_wall(&mut self, k: usize, side: Side, restitution: f64, speed: f64) {
        let (body, Some(walls)) = (&mut self.bodies[k], self.laws.walls) else { return };
        let State { position, velocity } = body.state();
        let gap = precise::wall_gap(&position, body.disc.radius, &walls, side);
        let is_rounding = self.laws.gravity.is_none() && gap.abs() <= ROUNDING * body.disc.radius;
        let delay = if is_rounding { gap / speed } else { 0.0 };
        body.kick(&bounce(&velocity, side, restitution), delay);
        self.remembered.forget(k);
        self.note_state(k);
    }

    /// Turns a body at a segment, at the instant at which it really touches.
    fn bounce_off_segment(
        &mut self,
        k: usize,
        segment: u32,
        time: f64,
        contacts: &mut Vec<Contact>,
    ) {
        let disc = self.move_to(k, time);
        let Some(usual) = self.laws.segments.map(|segments| segments.restitution) else { return };
        let restitution = self.restitution(usual, &[k], time);
        let (edge, state) = (self.edges[segment as usize], self.bodies[k].state());
        let mut near = edge.near(&state.position, disc.radius);
        let gap = near.gap;
        let speed = near.towards.dot(state.velocity).value() / near.towards.hi().length();
        let is_rounding = gap.abs() <= ROUNDING * disc.radius && speed > 0.0;
        // To second order for an end: what is left is far below any rounding.
        let delay = if is_rounding { gap / speed } else { 0.0 };
        if near.is_end {
            let there = state.position.plus(state.velocity.times_double(delay));
            near = edge.near(&there, disc.radius);
        }
        if let Some(turn) = segment::turn(&disc, &state.velocity, &near, restitution) {
            self.energy.book(-turn.bounce.energy_loss);
            self.momentum.book(turn.normal * -turn.bounce.impulse);
            self.bodies[k].kick(&turn.change, delay);
            self.remembered.forget(k);
            self.note_state(k);
            self.note_contacts(&[(k, None)], time, 1);
            contacts.push(segment_contact(&disc, segment, gap, &turn, self.now));
        }
        self.predict_again(&[k], time);
    }

    /// Ends a hop off a wall that is too short for the clock.
    fn lay_down(&mut self, k: usize, side: Side) {
        let before = self.bodies[k].disc;
        let velocity = before.velocity - side.normal() * before.velocity.dot(side.normal());
        self.set_velocity_of(k, velocity);
        self.energy.book(self.bodies[k].disc.kinetic_energy() - before.kinetic_energy());
        self.momentum.book_change(before.mass, velocity - before.velocity);
    }

    /// The restitution of a contact: elastic for discs caught in a collapse.
    fn restitution(&self, usual: f64, bodies: &[usize], time: f64) -> f64 {
        let caught = |&k: &usize| self.is_caught(k, time);
        if usual < 1.0 && bodies.iter().all(caught) { 1.0 } else { usual }
    }

    /// Whether a body is caught in a collapse.
    pub(super) fn is_caught(&self, k: usize, time: f64) -> bool {
        self.bodies[k].collapse.is_caught(time, self.contact_time(k))
    }

    /// The contact time after the last contact of a body, s.
    fn contact_time(&self, k: usize) -> f64 {
        let last = self.bodies[k].collapse.last_contact();
        self.laws.contact_time_after(self.clock.time(last))
    }

    /// Takes note of contacts of bodies, each with one partner, or else with walls or several.
    fn note_contacts(&mut self, bodies: &[(usize, Option<usize>)], time: f64, count: usize) {
        for &(k, partner) in bodies {
            let contact_time = self.contact_time(k);
            self.bodies[k].collapse.note_contact(time, partner, contact_time);
            if !self.bodies[k].collapse.is_free() {
                self.remembered.forget(k);
            }
        }
        self.contacts += count as u64;
    }

    /// Books what a contact does to the energy of simulated discs, before velocities change.
    fn book_pair(&mut self, i: usize, j: usize, impact: &Impact) {
        self.note_overlap(i, j);
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        if a.is_closed() && b.is_closed() {
            self.energy.book(-impact.energy_loss);
            return;
        }
        for (body, after, sign) in [(a, impact.velocity_a, -1.0), (b, impact.velocity_b, 1.0)] {
            if body.is_closed() {
                let mean_velocity = 0.5 * (body.disc.velocity + after);
                self.energy.book(sign * impact.impulse * impact.normal.dot(mean_velocity));
                self.momentum.book(impact.normal * (sign * impact.impulse));
            }
        }
    }

    /// The same for contacts together. With bodies that bring in energy from outside, what they
    /// brought is what is there: no error is told from work then.
    fn book_together(&mut self, places: &[usize], after: &[Disc], contacts: &[Contact]) {
        let bodies = || places.iter().map(|&k| &self.bodies[k]);
        let mut changes = Vec::new();
        let work: RunningSum = if bodies().all(Body::is_closed) {
            contacts.iter().map(|contact| -contact.energy_loss).collect()
        } else {
            let closed = bodies().zip(after).filter(|(body, _)| body.is_closed());
            let gain = |(body, after): (&Body, &Disc)| {
                changes.push((after.mass, after.velocity - body.disc.velocity));
                after.kinetic_energy() - body.disc.kinetic_energy()
            };
            closed.map(gain).collect()
        };
        self.energy.book(work.value());
        changes.into_iter().for_each(|(mass, by)| self.momentum.book_change(mass, by));
    }

    fn note_overlap(&mut self, i: usize, j: usize) {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        if a.is_simulated() && b.is_simulated() {
            let sight = self.sight(i, &a.state(), j, &b.state());
            let gap = sight.clearance().value() / (sight.d.hi().length() + sight.reach.hi);
            let overlap = -gap / a.disc.radius.min(b.disc.radius);
            self.largest_overlap = self.largest_overlap.max(overlap);
        }
    }
}
