//! What happens at an event: the contact is resolved, booked and noted, and whoever took part is
//! predicted again. Contacts at the same instant that share a body are found and resolved together.

use super::{Body, Event, Plain, With};
use crate::detect::Pair;
use crate::detect::touching::gap;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::resolve::pair::{Impact, collide};
use crate::resolve::touching::{self, pair_contact};
use crate::resolve::wall::bounce;
use crate::world::{Contact, Disc, Partner, Side, limits};

/// Events closer than this, in units of their offset or the epoch, are at the same instant: their
/// times differ by no more than rounding.
const SAME_INSTANT: f64 = 16.0 * UNIT_ROUNDOFF;

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
            let disc = self.bodies[body].at(time);
            for (other, candidate) in self.bodies.iter().enumerate() {
                if other == body || !self.bodies[body].can_collide_with(candidate) {
                    continue;
                }
                let pull = candidate.acceleration - self.bodies[body].acceleration;
                let candidate = self.laws.near(disc.position, candidate.at(time));
                let wait = self.meeting(&disc, &candidate, pull, latest - time);
                if wait.is_some_and(|wait| wait <= latest - time) {
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
        let mut discs: Vec<Disc> = places.iter().map(|&k| self.move_to(k, time)).collect();
        // Every body of a pair is in the sorted list.
        let place = |k: usize| places.partition_point(|&other| other < k);
        let local: Vec<Pair> = pairs.iter().map(|&(i, j)| (place(i), place(j))).collect();
        local.iter().for_each(|&(i, j)| self.note_overlap(places[i], places[j]));
        let restitution = self.restitution(self.laws.restitution, &places, time);
        let resolved = touching::resolve(&mut discs, &local, restitution, self.now);
        self.book_together(&places, &discs, &resolved.contacts);
        for (&k, disc) in places.iter().zip(&discs) {
            self.set_velocity_of(k, disc.velocity);
        }
        let touched: Vec<usize> = resolved.touched.iter().map(|&k| places[k]).collect();
        self.note_contacts(&touched, time, resolved.contacts.len());
        contacts.extend(resolved.contacts);
        self.predict_again(&places, time);
    }

    fn collide_pair(&mut self, i: usize, j: usize, time: f64, contacts: &mut Vec<Contact>) {
        let (a, b) = (self.move_to(i, time), self.move_to(j, time));
        let b = self.laws.near(a.position, b);
        let restitution = self.restitution(self.laws.restitution, &[i, j], time);
        if let Some(impact) = collide(&a, &b, restitution) {
            self.book_pair(i, j, &impact);
            self.set_velocity_of(i, impact.velocity_a);
            self.set_velocity_of(j, impact.velocity_b);
            self.note_contacts(&[i, j], time, 1);
            contacts.push(pair_contact(&a, &b, &impact, self.now));
        }
        self.predict_again(&[i, j], time);
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
        if let Some(bounce) = bounce(&disc, side, restitution) {
            self.energy.book(-bounce.energy_loss);
            self.set_velocity_of(k, bounce.velocity);
            self.note_contacts(&[k], time, 1);
            contacts.push(Contact {
                a: disc.id,
                b: Partner::Wall(side),
                point: disc.position + side.normal() * disc.radius,
                normal: side.normal(),
                gap: walls.gap(side, &disc),
                approach_speed: bounce.approach_speed,
                impulse: bounce.impulse,
                energy_loss: bounce.energy_loss,
                time: self.now,
            });
        } else if self.laws.presses_on(side) {
            self.lay_down(k, side);
        }
        self.predict_again(&[k], time);
    }

    /// Ends a hop off a wall that is too short for the clock.
    fn lay_down(&mut self, k: usize, side: Side) {
        let before = self.bodies[k].disc;
        let velocity = before.velocity - side.normal() * before.velocity.dot(side.normal());
        self.set_velocity_of(k, velocity);
        self.energy.book(self.bodies[k].disc.kinetic_energy() - before.kinetic_energy());
    }

    /// The restitution of a contact: elastic for a disc caught in a collapse.
    fn restitution(&self, usual: f64, bodies: &[usize], time: f64) -> f64 {
        let collapsing = |&k: &usize| {
            let body = &self.bodies[k];
            let quick = time - body.last_contact < self.laws.contact_time;
            quick && body.quick_contacts >= limits::QUICK_CONTACTS
        };
        if usual < 1.0 && bodies.iter().any(collapsing) { 1.0 } else { usual }
    }

    fn note_contacts(&mut self, bodies: &[usize], time: f64, count: usize) {
        for &k in bodies {
            let body = &mut self.bodies[k];
            let quick = time - body.last_contact < self.laws.contact_time;
            body.quick_contacts = if quick { body.quick_contacts.saturating_add(1) } else { 0 };
            body.last_contact = time;
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
            }
        }
    }

    /// The same for contacts together. With bodies that bring in energy from outside, what they
    /// brought is what is there: no error is told from work then.
    fn book_together(&mut self, places: &[usize], after: &[Disc], contacts: &[Contact]) {
        let bodies = || places.iter().map(|&k| &self.bodies[k]);
        let work: RunningSum = if bodies().all(Body::is_closed) {
            contacts.iter().map(|contact| -contact.energy_loss).collect()
        } else {
            let closed = bodies().zip(after).filter(|(body, _)| body.is_closed());
            closed.map(|(b, after)| after.kinetic_energy() - b.disc.kinetic_energy()).collect()
        };
        self.energy.book(work.value());
    }

    fn note_overlap(&mut self, i: usize, j: usize) {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        if a.is_simulated() && b.is_simulated() {
            let near = self.laws.near(a.disc.position, b.disc);
            let overlap = -gap(&a.disc, &near) / a.disc.radius.min(b.disc.radius);
            self.largest_overlap = self.largest_overlap.max(overlap);
        }
    }
}
