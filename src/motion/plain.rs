//! The plain event-driven method: the next collision among all pairs, then the next.
//!
//! Between collisions discs fly straight, so the state at any instant is exact. Each disc keeps the
//! position and the time of its own last event and moves only there: an instant looked at between
//! events changes nothing, so results do not depend on the frame rate. Every disc knows its
//! earliest event; after a collision the two discs are predicted against all others. That is O(N)
//! an event and O(N^2) at the start: right for small arenas, and for ever the judge of faster
//! methods.
//!
//! Policies: a pair that overlaps and approaches collides now, one that separates does not; of
//! events at the same time the smaller index goes first. Below restitution 1 a disc whose contacts
//! follow each other within the contact time, hundreds in a row, collides elastically until it has
//! peace, so that a collapse ends (after Luding, McNamara, doi:10.1007/s100350050017, who allow no
//! such contact to lose energy: that would throw a disc out of a corner). An arena that still
//! cannot leave an instant is stalled, and says so.

use glam::DVec2;

use super::clock::Clock;
use super::energy::EnergyAccount;
use crate::detect::impact::{may_meet_within, pair_impact, wall_impact};
use crate::detect::touching::gap;
use crate::exact::{RunningSum, UNIT_ROUNDOFF};
use crate::resolve::pair::{Impact, approach, collide};
use crate::resolve::touching::pair_contact;
use crate::resolve::wall::bounce;
use crate::world::{Contact, Disc, DiscId, Owner, Partner, Side, Walls, limits};

/// What the discs of an arena obey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws {
    /// Restitution of pairs, 0 to 1.
    pub restitution: f64,
    /// The box, if there is one.
    pub walls: Option<Walls>,
    /// Contact time of the collapse model, s; 0 = left out.
    pub contact_time: f64,
}

/// An arena that cannot leave an instant: endlessly many contacts at the same time.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "arena stalled at t = {time} s: more than {events} contacts at one instant, the last of disc \
     {disc}; raise contact_time_s, or part the discs"
)]
pub struct Stall {
    /// The instant, s.
    pub time: f64,
    /// The budget that was used up.
    pub events: usize,
    /// A disc that takes part.
    pub disc: DiscId,
}

/// The state of an arena under the plain method.
#[derive(Clone, Debug)]
pub struct Plain {
    laws: Laws,
    clock: Clock,
    now: f64,
    bodies: Vec<Body>,
    next: Vec<Event>,
    instant: f64,
    events_at_instant: usize,
    energy: EnergyAccount,
    largest_overlap: f64,
    contacts: u64,
}

/// A disc at the time of its own last event.
#[derive(Clone, Copy, Debug)]
struct Body {
    disc: Disc,
    owner: Owner,
    /// Offset at which `disc.position` holds, s.
    own_time: f64,
    /// Offset of its last contact, s.
    last_contact: f64,
    /// Contacts in a row, each within the contact time of the one before.
    quick_contacts: u32,
}

impl Body {
    fn position(&self, offset: f64) -> DVec2 {
        self.disc.position + self.disc.velocity * (offset - self.own_time)
    }

    fn at(&self, offset: f64) -> Disc {
        Disc { position: self.position(offset), ..self.disc }
    }

    fn is_simulated(&self) -> bool {
        self.owner == Owner::Simulated
    }
}

/// The earliest event that a disc knows of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Event {
    /// Offset, s; infinite = none.
    time: f64,
    with: With,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum With {
    Nothing,
    Body(usize),
    Wall(Side),
}

/// What counts as one instant, in epochs. Even a disc thrown to and fro between two a million times
/// heavier meets them less often than the budget allows.
const INSTANT: f64 = 1e-10;

const NEVER: Event = Event { time: f64::INFINITY, with: With::Nothing };

impl Plain {
    /// An arena at time 0. `epoch` (s) is the scale of event times: about radius over speed.
    pub fn new(laws: Laws, discs: &[Disc], epoch: f64) -> Self {
        let mut arena = Self {
            laws,
            clock: Clock::new(epoch),
            now: 0.0,
            bodies: Vec::with_capacity(discs.len()),
            next: Vec::new(),
            instant: 0.0,
            events_at_instant: 0,
            energy: EnergyAccount::default(),
            largest_overlap: 0.0,
            contacts: 0,
        };
        discs.iter().for_each(|disc| arena.push(*disc, Owner::Simulated));
        arena.predict_all();
        arena
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs of one owner as they are now, in the order in which they came.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> + '_ {
        let offset = self.clock.offset(self.now);
        self.bodies.iter().filter(move |body| body.owner == owner).map(move |body| body.at(offset))
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let simulated = self.bodies.iter().filter(|body| body.is_simulated());
        simulated.map(|body| body.disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        self.energy.relative_drift(self.kinetic_energy())
    }

    /// Largest overlap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.largest_overlap
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.contacts
    }

    /// Moves on to `until` (s) and adds the contacts on the way; nothing happens if that is past.
    ///
    /// Stops short of `until` after [`limits::EVENTS_PER_ADVANCE`] events, so that a storm of
    /// contacts holds nobody up: [`Self::now`] tells, and calling again goes on.
    ///
    /// # Errors
    /// [`Stall`] when endlessly many contacts fall on one instant; the arena then stands there.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        for _ in 0..limits::EVENTS_PER_ADVANCE {
            let next = self.earliest().map(|first| (first, self.next[first]));
            let Some((first, event)) =
                next.filter(|(_, event)| event.time <= self.clock.offset(until))
            else {
                // An event's time may have rounded to just after `until`.
                self.now = self.now.max(until);
                return Ok(());
            };
            self.now = self.clock.time(event.time);
            self.count_event(first, event.time)?;
            self.process(first, event, contacts);
            self.rebase(event.time);
        }
        Ok(())
    }

    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        let Some(k) = self.find(id, Owner::Simulated) else { return };
        let before = self.bodies[k].disc.kinetic_energy();
        let disc = Disc { velocity, ..self.move_to_now(k) };
        self.energy.book(disc.kinetic_energy() - before);
        self.replace(k, disc);
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        if let Some(k) = self.find(disc.id, Owner::Observed) {
            self.move_to_now(k);
            self.replace(k, disc);
        } else {
            self.push(disc, Owner::Observed);
            let last = self.bodies.len() - 1;
            self.replace(last, disc);
        }
    }

    /// Takes an observed disc out, if it is there.
    pub fn forget(&mut self, id: DiscId) {
        if let Some(k) = self.find(id, Owner::Observed) {
            self.bodies.remove(k);
            self.predict_all();
        }
    }

    fn find(&self, id: DiscId, owner: Owner) -> Option<usize> {
        self.bodies.iter().position(|body| body.disc.id == id && body.owner == owner)
    }

    fn push(&mut self, disc: Disc, owner: Owner) {
        let own_time = self.clock.offset(self.now);
        let last_contact = f64::NEG_INFINITY;
        self.bodies.push(Body { disc, owner, own_time, last_contact, quick_contacts: 0 });
        self.next.push(NEVER);
        if owner == Owner::Simulated {
            self.energy.book(disc.kinetic_energy());
        }
    }

    /// The body with the earliest event, the first of equals.
    fn earliest(&self) -> Option<usize> {
        let mut earliest = None;
        let mut time = f64::INFINITY;
        for (k, event) in self.next.iter().enumerate() {
            if event.time < time {
                (earliest, time) = (Some(k), event.time);
            }
        }
        earliest
    }

    fn count_event(&mut self, k: usize, time: f64) -> Result<(), Stall> {
        if time > self.instant + INSTANT * self.clock.epoch() {
            (self.instant, self.events_at_instant) = (time, 0);
        }
        self.events_at_instant += 1;
        let events =
            limits::EVENTS_PER_INSTANT + limits::EVENTS_PER_INSTANT_AND_DISC * self.bodies.len();
        if self.events_at_instant > events {
            // A later call starts with a fresh budget.
            self.events_at_instant = 0;
            return Err(Stall { time: self.now, events, disc: self.bodies[k].disc.id });
        }
        Ok(())
    }

    fn process(&mut self, k: usize, event: Event, contacts: &mut Vec<Contact>) {
        match event.with {
            With::Body(partner) => self.collide_pair(k, partner, event.time, contacts),
            With::Wall(side) => self.bounce_off(k, side, event.time, contacts),
            With::Nothing => unreachable!("an event without a partner has no finite time"),
        }
    }

    fn collide_pair(&mut self, k: usize, l: usize, time: f64, contacts: &mut Vec<Contact>) {
        let (i, j) = if self.bodies[k].disc.id < self.bodies[l].disc.id { (k, l) } else { (l, k) };
        let (a, b) = (self.move_to(i, time), self.move_to(j, time));
        let restitution = self.restitution(self.laws.restitution, &[i, j], time);
        if let Some(impact) = collide(&a, &b, restitution) {
            self.book_pair(i, j, &impact);
            self.bodies[i].disc.velocity = impact.velocity_a;
            self.bodies[j].disc.velocity = impact.velocity_b;
            self.note_contact(&[i, j], time);
            contacts.push(pair_contact(&a, &b, &impact, self.now));
        }
        self.predict_again(&[i, j], time);
    }

    fn bounce_off(&mut self, k: usize, side: Side, time: f64, contacts: &mut Vec<Contact>) {
        let disc = self.move_to(k, time);
        let Some(walls) = self.laws.walls else { return };
        let restitution = self.restitution(walls.restitution, &[k], time);
        if let Some(bounce) = bounce(&disc, side, restitution) {
            self.energy.book(-bounce.energy_loss);
            self.bodies[k].disc.velocity = bounce.velocity;
            self.note_contact(&[k], time);
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
        }
        self.predict_again(&[k], time);
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

    fn note_contact(&mut self, bodies: &[usize], time: f64) {
        for &k in bodies {
            let body = &mut self.bodies[k];
            let quick = time - body.last_contact < self.laws.contact_time;
            body.quick_contacts = if quick { body.quick_contacts.saturating_add(1) } else { 0 };
            body.last_contact = time;
        }
        self.contacts += 1;
    }

    /// Books what a contact does to the energy of simulated discs, before velocities change.
    fn book_pair(&mut self, i: usize, j: usize, impact: &Impact) {
        let (a, b) = (&self.bodies[i], &self.bodies[j]);
        let closed = |body: &Body| body.is_simulated() && body.disc.mass.is_finite();
        if a.is_simulated() && b.is_simulated() {
            let overlap = -gap(&a.disc, &b.disc) / a.disc.radius.min(b.disc.radius);
            self.largest_overlap = self.largest_overlap.max(overlap);
        }
        if closed(a) && closed(b) {
            self.energy.book(-impact.energy_loss);
            return;
        }
        for (body, after, sign) in [(a, impact.velocity_a, -1.0), (b, impact.velocity_b, 1.0)] {
            if closed(body) {
                let mean_velocity = 0.5 * (body.disc.velocity + after);
                self.energy.book(sign * impact.impulse * impact.normal.dot(mean_velocity));
            }
        }
    }

    /// Brings a body to an offset; returns it.
    fn move_to(&mut self, k: usize, offset: f64) -> Disc {
        let body = &mut self.bodies[k];
        body.disc.position = body.position(offset);
        body.own_time = offset;
        body.disc
    }

    fn move_to_now(&mut self, k: usize) -> Disc {
        let offset = self.clock.offset(self.now);
        self.rebase(offset);
        self.move_to(k, self.clock.offset(self.now))
    }

    /// Gives a body that stands at the present a new state.
    fn replace(&mut self, k: usize, disc: Disc) {
        self.bodies[k].disc = disc;
        self.predict_again(&[k], self.clock.offset(self.now));
    }

    /// Moves the base of all offsets when the present has left the epoch.
    fn rebase(&mut self, offset: f64) {
        if !self.clock.is_past(offset) {
            return;
        }
        let shift = self.clock.advance(offset);
        self.instant -= shift;
        for (body, event) in self.bodies.iter_mut().zip(&mut self.next) {
            body.own_time -= shift;
            body.last_contact -= shift;
            event.time -= shift;
        }
    }

    fn predict_all(&mut self) {
        self.next = vec![NEVER; self.bodies.len()];
        let offset = self.clock.offset(self.now);
        (0..self.bodies.len()).for_each(|k| self.predict(k, offset));
    }

    /// Predicts the bodies that changed, and those whose next event was with one of them.
    fn predict_again(&mut self, changed: &[usize], offset: f64) {
        let stale = |event: &Event| matches!(event.with, With::Body(k) if changed.contains(&k));
        let orphans: Vec<usize> = (0..self.next.len()).filter(|&k| stale(&self.next[k])).collect();
        for &k in changed.iter().chain(&orphans) {
            self.next[k] = NEVER;
        }
        changed.iter().for_each(|&k| self.predict(k, offset));
        let orphans = orphans.into_iter().filter(|k| !changed.contains(k));
        orphans.for_each(|k| self.predict(k, offset));
    }

    /// Finds the earliest event of a body; tells the partners for whom it comes before theirs.
    fn predict(&mut self, k: usize, offset: f64) {
        let body = self.bodies[k];
        let disc = body.at(offset);
        let mut first = self.next[k];
        if let Some(walls) = self.laws.walls.filter(|_| body.is_simulated()) {
            let hit = wall_impact(disc.position, disc.velocity, disc.radius, &walls);
            if let Some(hit) = hit.filter(|hit| offset + hit.time < first.time) {
                first = Event { time: offset + hit.time, with: With::Wall(hit.side) };
            }
        }
        for (l, other) in self.bodies.iter().enumerate() {
            let nobody_ours = !body.is_simulated() && !other.is_simulated();
            if l == k || nobody_ours {
                continue;
            }
            let latest = first.time.max(self.next[l].time);
            let Some(time) = meeting(&disc, &other.at(offset), latest - offset) else { continue };
            let time = offset + time;
            if time < first.time {
                first = Event { time, with: With::Body(l) };
            }
            if time < self.next[l].time {
                self.next[l] = Event { time, with: With::Body(k) };
            }
        }
        self.next[k] = first;
    }
}

/// Time until two discs collide, s, if that is within the horizon.
fn meeting(a: &Disc, b: &Disc, horizon: f64) -> Option<f64> {
    let (d, w) = (b.position - a.position, b.velocity - a.velocity);
    let reach = a.radius + b.radius;
    if !may_meet_within(d, w, reach, horizon) {
        return None;
    }
    let time = pair_impact(d, w, reach)?;
    (time > 0.0 || approaches_beyond_rounding(a, b)).then_some(time)
}

/// Whether two discs in contact approach by more than the rounding of their velocities.
///
/// What is less would be answered by velocities that differ from it by as much: discs at rest on
/// each other would collide for ever. Such a pair creeps by some 1e-16 of its speed instead.
fn approaches_beyond_rounding(a: &Disc, b: &Disc) -> bool {
    let rounding = 4.0 * UNIT_ROUNDOFF * (a.velocity.length() + b.velocity.length());
    approach(a, b).is_some_and(|(_, speed)| speed > rounding)
}
