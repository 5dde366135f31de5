//! The plain event-driven method: the next collision among all pairs, then the next.
//!
//! Between collisions discs fly straight, so the state at any instant is exact. Each disc keeps the
//! position and the time of its own last event and moves only there: an instant looked at between
//! events changes nothing, so results do not depend on the frame rate. Every disc knows its
//! earliest event; after a collision the two discs are predicted against all others. That is O(N)
//! an event and O(N^2) at the start: right for small arenas, and for ever the judge of faster
//! methods.
//!
//! What happens where the laws do not say is in [`super`]. Of events at the same time the smaller
//! index goes first. The collapse model (after Luding, McNamara, doi:10.1007/s100350050017, who
//! allow no quick contact to lose energy) wants a hundred in a row: a single one would throw a disc
//! out of a corner.
//!
//! Positions and velocities are carried in double-double, and a contact is resolved at the instant
//! at which it is one, not at that instant rounded to a double: a path is right to 2^-100, times
//! what the scene makes of an error. Partners are sought in plain doubles, so this costs little.
//! Where even that does not tell two discs apart, in a collapse of a few, their contacts are
//! remembered. Groups of contacts at one instant, and discs under gravity, are as right as doubles.
//!
//! Under gravity discs fly along parabolas: two that fall see each other fly straight, so only
//! walls, and pairs of which one does not fall (fixed, observed or at rest), need other times. A
//! disc that comes to rest on a wall has no more events there. Discs that lie on discs go on
//! colliding, as often as the contact time allows: heaps are too slow to be of use.
//!
//! In a periodic box a pair is looked at as the nearest image of one sees the other. That is right
//! until another image could come near: at that time a disc's event is to look again.

mod again;
mod body;
mod collapse;
mod contacts;
mod edit;
mod predict;
mod remembered;

use glam::DVec2;

use super::clock::Clock;
use super::drag::slowing::straight_span;
use super::energy::EnergyAccount;
use super::momentum::MomentumAccount;
use crate::detect::precise::Doubt;
use crate::detect::segment::Edge;
use crate::exact::{DoubleDoubleVec, RunningSum, UNIT_ROUNDOFF};
use crate::world::{Contact, Disc, DiscId, Owner, Periodic, Segments, Side, Walls, limits};
use body::Body;
use remembered::Remembered;

/// What the discs of an arena obey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Laws {
    /// Restitution of pairs, 0 to 1.
    pub restitution: f64,
    /// The box, if there is one.
    pub walls: Option<Walls>,
    /// Line segments, if there are any; not with gravity, drag or a periodic box.
    pub segments: Option<Segments>,
    /// The same acceleration of all simulated discs of finite mass, m/s^2; `None` = left out.
    pub gravity: Option<DVec2>,
    /// The periodic box, if there is one; not with walls or gravity.
    pub periodic: Option<Periodic>,
    /// The same linear drag of all discs, 1/s; not with gravity. [`Drag`](super::drag::Drag) does
    /// it; the method inside knows of it only what `contact_time` is in its own time.
    pub drag: f64,
    /// Contact time of the collapse model, s; 0 = left out.
    pub contact_time: f64,
    /// Whether lengths or speeds are so large or small that products of four leave the range of
    /// doubles: times of impact are then computed in units of their own.
    pub extreme_units: bool,
}

impl Laws {
    /// Elastic discs in the free plane.
    pub const FREE: Self = Self {
        restitution: 1.0,
        walls: None,
        segments: None,
        gravity: None,
        periodic: None,
        drag: 0.0,
        contact_time: 0.0,
        extreme_units: false,
    };

    /// Whether discs fly straight at a constant velocity, in a plane that does not repeat: what
    /// segments ask for.
    pub fn are_straight(&self) -> bool {
        self.gravity.is_none() && self.drag == 0.0 && self.periodic.is_none()
    }

    /// What gravity does to a disc: nothing along the normal of a wall on which the disc lies
    /// still and is pressed.
    pub(super) fn acceleration(&self, gravity: DVec2, disc: &Disc) -> DVec2 {
        let Some(walls) = self.walls else { return gravity };
        let rests = |side: Side| {
            let normal = side.normal();
            let lies = walls.gap(side, disc) <= 0.0 || walls.onto(side, disc) == disc.position;
            lies && gravity.dot(normal) > 0.0 && disc.velocity.dot(normal) == 0.0
        };
        let along = |low, high, pull: f64| if rests(low) || rests(high) { 0.0 } else { pull };
        DVec2::new(
            along(Side::Left, Side::Right, gravity.x),
            along(Side::Bottom, Side::Top, gravity.y),
        )
    }

    /// A disc as the periodic box shows it.
    fn inside(&self, disc: Disc) -> Disc {
        let Some(periodic) = self.periodic else { return disc };
        Disc { position: periodic.inside(disc.position), ..disc }
    }

    /// The place of the nearest image of what lies there, seen from elsewhere.
    fn nearest(&self, seen: DoubleDoubleVec) -> DoubleDoubleVec {
        let Some(periodic) = self.periodic else { return seen };
        seen.plus_double(periodic.shift(seen.hi()))
    }

    /// Whether contacts are remembered: for collapses, which need restitution below 1. Under
    /// gravity discs do not part in a straight line.
    fn remember_contacts(&self) -> bool {
        self.restitution < 1.0 && self.gravity.is_none()
    }

    /// The image of a disc that is nearest to a place.
    fn near(&self, place: DVec2, disc: Disc) -> Disc {
        let Some(periodic) = self.periodic else { return disc };
        let shift = periodic.shift(disc.position - place);
        Disc { position: disc.position + shift, ..disc }
    }

    /// The contact time in a method's own time, s, after a contact at `last` in that time.
    #[inline(always)]
    pub(super) fn contact_time_after(&self, last: f64) -> f64 {
        if self.drag == 0.0 {
            return self.contact_time;
        }
        straight_span(self.drag, last, self.contact_time)
    }

    /// Whether gravity presses discs on this wall.
    pub(super) fn presses_on(&self, side: Side) -> bool {
        self.gravity.is_some_and(|gravity| gravity.dot(side.normal()) > 0.0)
    }
}

impl Default for Laws {
    fn default() -> Self {
        Self::FREE
    }
}

/// An arena that cannot leave an instant: endlessly many contacts at the same time.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "arena stalled at t = {} s: more than {events} contacts at one instant, the last of disc \
     {disc}; part the discs, or raise contact_time_s where restitution is below 1",
    limits::short(*.time)
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
    /// The segments, prepared.
    edges: Vec<Edge>,
    clock: Clock,
    now: f64,
    bodies: Vec<Body>,
    next: Vec<Event>,
    remembered: Remembered,
    doubt: Doubt,
    instant: f64,
    events_at_instant: usize,
    energy: EnergyAccount,
    momentum: MomentumAccount,
    largest_overlap: f64,
    contacts: u64,
}

/// Whether products of four lengths or speeds of a disc may over- or underflow; 0 may not.
pub fn is_extreme(disc: &Disc) -> bool {
    let [x, v] = [disc.position, disc.velocity].map(|vector| vector.abs().max_element());
    let beyond = |size: f64| size != 0.0 && !(1e-70..=1e70).contains(&size);
    beyond(x) || beyond(v) || beyond(disc.radius)
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
    /// A segment, by its place.
    Segment(u32),
    /// Nobody: the nearest images may be others from now on.
    Renew,
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
            edges: Edge::all(laws.segments.as_ref()),
            clock: Clock::new(epoch),
            now: 0.0,
            bodies: Vec::with_capacity(discs.len()),
            next: Vec::new(),
            remembered: Remembered::default(),
            doubt: Doubt::default(),
            instant: 0.0,
            events_at_instant: 0,
            energy: EnergyAccount::default(),
            momentum: MomentumAccount::default(),
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
        let bodies = self.bodies.iter().filter(move |body| body.owner == owner);
        bodies.map(move |body| self.laws.inside(body.at(offset)))
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let discs = self.discs(Owner::Simulated);
        discs.map(|disc| disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed relative energy error, with all work accounted for.
    pub fn relative_energy_drift(&self) -> f64 {
        let offset = self.clock.offset(self.now);
        let mut account = self.energy;
        self.bodies.iter().for_each(|body| account.book(body.work_until(offset)));
        account.relative_drift(self.kinetic_energy())
    }

    /// Keeps account of the momentum from now on.
    pub fn keep_momentum(&mut self) {
        if self.momentum.is_kept() {
            return;
        }
        let mut account = self.momentum;
        account.begin(self.discs(Owner::Simulated));
        self.momentum = account;
        self.momentum.set_pull(self.now, self.weight());
    }

    /// What gravity does to all that falls, N.
    fn weight(&self) -> DVec2 {
        let falling = self.bodies.iter().filter(|body| body.acceleration != DVec2::ZERO);
        falling.map(|body| body.disc.mass * body.acceleration).sum()
    }

    /// Momentum gained by error, N s, while an account is kept.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        self.momentum.drift(self.now, self.discs(Owner::Simulated))
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

    /// The same without a record of the contacts.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), Stall> {
        self.advance(until, &mut Vec::new())
    }

    fn find(&self, id: DiscId, owner: Owner) -> Option<usize> {
        self.bodies.iter().position(|body| body.disc.id == id && body.owner == owner)
    }

    fn push(&mut self, disc: Disc, owner: Owner) {
        self.bodies.push(Body::new(disc, owner, self.clock.offset(self.now)));
        self.next.push(NEVER);
        self.set_state(self.bodies.len() - 1, disc);
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

    /// Brings a body to an offset; returns it.
    fn move_to(&mut self, k: usize, offset: f64) -> Disc {
        let body = &mut self.bodies[k];
        if body.acceleration != DVec2::ZERO {
            self.energy.book(body.work_until(offset));
        }
        body.move_to(offset);
        if let Some(periodic) = self.laws.periodic {
            body.shift(periodic.inside(body.disc.position) - body.disc.position);
        }
        let disc = body.disc;
        self.note_size(&disc);
        disc
    }

    /// Gives a body a state known to the precision of doubles, at its own time.
    fn set_state(&mut self, k: usize, disc: Disc) {
        self.bodies[k].set_disc(disc);
        self.remembered.forget(k);
        self.note_state(k);
    }

    /// Takes note of a state just given to a body.
    fn note_state(&mut self, k: usize) {
        let body = &mut self.bodies[k];
        let disc = body.disc;
        if let Some(gravity) = self.laws.gravity.filter(|_| body.is_closed()) {
            let before = body.acceleration;
            body.acceleration = self.laws.acceleration(gravity, &disc);
            let change = body.acceleration - before;
            if change != DVec2::ZERO {
                self.momentum.book_pull(self.clock.time(body.own_time.hi), change * disc.mass);
            }
        }
        self.note_size(&disc);
    }

    /// Keeps up what the search for partners in plain doubles may be wrong by: a place is that of
    /// the last event, at most so far out, and a flight that ends near another disc.
    fn note_size(&mut self, disc: &Disc) {
        let size = |vector: DVec2| 64.0 * UNIT_ROUNDOFF * vector.abs().max_element();
        self.doubt.position = self.doubt.position.max(size(disc.position));
        self.doubt.velocity = self.doubt.velocity.max(size(disc.velocity));
    }

    /// Gives a body another velocity, known to the precision of doubles, at its own time.
    fn set_velocity_of(&mut self, k: usize, velocity: DVec2) {
        self.bodies[k].set_velocity(velocity);
        self.remembered.forget(k);
        self.note_state(k);
    }

    fn move_to_now(&mut self, k: usize) -> Disc {
        let offset = self.clock.offset(self.now);
        self.rebase(offset);
        self.move_to(k, self.clock.offset(self.now))
    }

    /// Gives a body that stands at the present a new state.
    fn replace(&mut self, k: usize, disc: Disc) {
        self.set_state(k, disc);
        self.predict_again(&[k], self.clock.offset(self.now));
    }

    /// Moves the base of all offsets when the present has left the epoch.
    fn rebase(&mut self, offset: f64) {
        if !self.clock.is_past(offset) {
            return;
        }
        let shift = self.clock.advance(offset);
        self.instant -= shift;
        self.remembered.rebase(shift);
        for (body, event) in self.bodies.iter_mut().zip(&mut self.next) {
            body.own_time = body.own_time.minus(shift.into());
            body.collapse.rebase(shift);
            event.time -= shift;
        }
    }
}
