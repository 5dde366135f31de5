//! What happens at an event: the contact is resolved, booked and noted, and whoever took part is
//! predicted again. Contacts at the same instant that share a disc are resolved together.

use super::agenda::{Event, With};
use super::{Body, Ticks};
use crate::detect::Pair;
use crate::detect::touching::gap;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::resolve::pair::{Impact, collide};
use crate::resolve::segment::{self, segment_contact};
use crate::resolve::touching::{self, pair_contact};
use crate::resolve::wall::{bounce, wall_contact};
use crate::world::{Contact, Disc, Side, limits};

/// Events closer than this, in units of their offset or the scale of event times, are at the same
/// instant: their times differ by no more than rounding.
const SAME_INSTANT: f64 = 16.0 * UNIT_ROUNDOFF;

impl Ticks {
    /// Lets an event happen at the present, which is its time.
    pub(super) fn process(&mut self, event: Event, contacts: &mut Vec<Contact>) {
        let k = event.first as usize;
        match event.with {
            With::Wall(side) => self.bounce_off(k, side, contacts),
            With::Segment(segment) => self.bounce_off_segment(k, segment, contacts),
            // A group may close around a periodic box, where no image shows it whole.
            With::Body(partner) if self.laws.periodic.is_some() => {
                let (i, j) = self.by_id(k, partner as usize);
                self.collide_pair(i, j, contacts);
            }
            With::Body(partner) => {
                self.find_together(self.by_id(k, partner as usize));
                if let [(i, j)] = self.together[..] {
                    self.collide_pair(i, j, contacts);
                } else {
                    self.collide_together(contacts);
                }
            }
        }
    }

    /// Two discs, the smaller id first.
    pub(super) fn by_id(&self, k: usize, l: usize) -> Pair {
        if self.body(k).id < self.body(l).id { (k, l) } else { (l, k) }
    }

    /// Finds the contacts at the present instant that hang together with that of a pair.
    fn find_together(&mut self, pair: Pair) {
        let offset = self.present.offset;
        let latest = offset + SAME_INSTANT * offset.max(self.scale);
        self.together.clear();
        self.together.push(pair);
        let mut seen = 0;
        while let Some(&(i, j)) = self.together.get(seen) {
            seen += 1;
            for k in [i, j] {
                for event in self.agenda.of(k).filter(|event| event.time <= latest) {
                    let With::Body(partner) = event.with else { continue };
                    let pair = self.by_id(event.first as usize, partner as usize);
                    if !self.together.contains(&pair) {
                        self.together.push(pair);
                    }
                }
            }
        }
        if self.together.len() > 1 {
            self.complete_group(latest);
        }
    }

    /// Contacts at one instant that share discs.
    fn collide_together(&mut self, contacts: &mut Vec<Contact>) {
        let pairs = std::mem::take(&mut self.together);
        let mut places: Vec<usize> = pairs.iter().flat_map(|&(i, j)| [i, j]).collect();
        places.sort_unstable();
        places.dedup();
        let move_to = |&k: &usize| self.bodies.move_to(k, self.present);
        let before: Vec<Disc> = places.iter().map(move_to).collect();
        // Every disc of a pair is in the sorted list.
        let place = |k: usize| places.partition_point(|&other| other < k);
        let local: Vec<Pair> = pairs.iter().map(|&(i, j)| (place(i), place(j))).collect();
        for (&(i, j), &(a, b)) in pairs.iter().zip(&local) {
            self.note_overlap(i, j, gap(&before[a], &before[b]));
        }
        let restitution = self.restitution(self.laws.restitution, &places);
        let mut after = before.clone();
        let resolved = touching::resolve(&mut after, &local, restitution, self.now);
        self.book_together(&places, &before, &after, &resolved.contacts);
        for (&k, disc) in places.iter().zip(&after) {
            self.bodies.flights[k].velocity = disc.velocity;
        }
        let touched: Vec<usize> = resolved.touched.iter().map(|&k| places[k]).collect();
        self.note_contacts(&touched, resolved.contacts.len());
        contacts.extend(resolved.contacts);
        self.together = pairs;
        self.predict_again(&places);
    }

    fn collide_pair(&mut self, i: usize, j: usize, contacts: &mut Vec<Contact>) {
        let [a, b] = [i, j].map(|k| self.bodies.move_to(k, self.present));
        let b = self.bodies.near(a.position, b);
        let restitution = self.restitution(self.laws.restitution, &[i, j]);
        if let Some(impact) = collide(&a, &b, restitution) {
            let contact = pair_contact(&a, &b, &impact, self.now);
            self.note_overlap(i, j, contact.gap);
            self.book_pair((i, &a), (j, &b), &impact);
            self.bodies.flights[i].velocity = impact.velocity_a;
            self.bodies.flights[j].velocity = impact.velocity_b;
            self.note_contacts(&[i, j], 1);
            contacts.push(contact);
        }
        self.predict_again(&[i, j]);
    }

    fn bounce_off(&mut self, k: usize, side: Side, contacts: &mut Vec<Contact>) {
        let Some(walls) = self.laws.walls else { return };
        let disc = self.bodies.move_to(k, self.present);
        let restitution = self.restitution(walls.restitution, &[k]);
        if let Some(bounce) = bounce(&disc, side, restitution) {
            self.energy.book(-bounce.energy_loss);
            self.momentum.book(side.normal() * -bounce.impulse);
            self.bodies.flights[k].velocity = bounce.velocity;
            self.note_contacts(&[k], 1);
            contacts.push(wall_contact(&disc, side, &walls, &bounce, self.now));
        }
        self.predict_again(&[k]);
    }

    fn bounce_off_segment(&mut self, k: usize, place: u32, contacts: &mut Vec<Contact>) {
        let Some(usual) = self.laws.segments.map(|segments| segments.restitution) else { return };
        let disc = self.bodies.move_to(k, self.present);
        let restitution = self.restitution(usual, &[k]);
        let near = self.fence.edge(place).near(&disc.position.into(), disc.radius);
        if let Some(turn) = segment::turn(&disc, &disc.velocity.into(), &near, restitution) {
            self.energy.book(-turn.bounce.energy_loss);
            self.momentum.book(turn.normal * -turn.bounce.impulse);
            self.bodies.flights[k].velocity = turn.bounce.velocity;
            self.note_contacts(&[k], 1);
            contacts.push(segment_contact(&disc, place, near.gap, &turn, self.now));
        }
        self.predict_again(&[k]);
    }

    /// The restitution of a contact: elastic for a disc caught in a collapse.
    fn restitution(&self, usual: f64, places: &[usize]) -> f64 {
        let collapsing = |&k: &usize| {
            let caught = self.body(k).quick_contacts >= limits::QUICK_CONTACTS;
            caught && self.is_quick(self.body(k))
        };
        if usual < 1.0 && places.iter().any(collapsing) { 1.0 } else { usual }
    }

    /// Whether the last contact of a disc was within the contact time.
    fn is_quick(&self, body: &Body) -> bool {
        self.present.since(body.last_contact, self.tick_s) < self.laws.contact_time
    }

    fn note_contacts(&mut self, places: &[usize], count: usize) {
        for &k in places {
            let quick = self.is_quick(self.body(k));
            let body = &mut self.bodies.bodies[k];
            body.quick_contacts = if quick { body.quick_contacts.saturating_add(1) } else { 0 };
            body.last_contact = self.present;
        }
        self.contacts += count as u64;
    }

    /// Books what a contact does to the energy of simulated discs.
    fn book_pair(&mut self, a: (usize, &Disc), b: (usize, &Disc), impact: &Impact) {
        if self.body(a.0).is_closed() && self.body(b.0).is_closed() {
            self.energy.book(-impact.energy_loss);
            return;
        }
        for (side, after, sign) in [(a, impact.velocity_a, -1.0), (b, impact.velocity_b, 1.0)] {
            if self.body(side.0).is_closed() {
                let mean_velocity = 0.5 * (side.1.velocity + after);
                self.energy.book(sign * impact.impulse * impact.normal.dot(mean_velocity));
                self.momentum.book(impact.normal * (sign * impact.impulse));
            }
        }
    }

    /// The same for contacts together. With discs that bring in energy from outside, what they
    /// brought is what is there: no error is told from work then.
    fn book_together(
        &mut self,
        places: &[usize],
        before: &[Disc],
        after: &[Disc],
        contacts: &[Contact],
    ) {
        let is_closed = |k: &usize| self.body(*k).is_closed();
        let mut changes = Vec::new();
        let work: RunningSum = if places.iter().all(is_closed) {
            contacts.iter().map(|contact| -contact.energy_loss).collect()
        } else {
            let all = places.iter().zip(before.iter().zip(after));
            let closed = all.filter(|(k, _)| is_closed(k));
            let gain = |(_, (before, after)): (_, (&Disc, &Disc))| {
                changes.push((after.mass, after.velocity - before.velocity));
                after.kinetic_energy() - before.kinetic_energy()
            };
            closed.map(gain).collect()
        };
        self.energy.book(work.value());
        changes.into_iter().for_each(|(mass, by)| self.momentum.book_change(mass, by));
    }

    fn note_overlap(&mut self, i: usize, j: usize, gap: f64) {
        if self.body(i).is_simulated() && self.body(j).is_simulated() {
            let [a, b] = [i, j].map(|k| self.bodies.flights[k].radius);
            self.largest_overlap = self.largest_overlap.max(-gap / a.min(b));
        }
    }
}
