//! The same linear drag for all discs, exactly: a mapping of time around a method in which discs
//! fly straight.
//!
//! Under `v' = -drag v` a disc moves straight, at constant velocity, in the time of [`slowing`];
//! the collision law is linear and homogeneous, so it is the same for the velocities of that time;
//! walls and the periodic box are where they were. So the method inside does all as if there were
//! no drag, and knows nothing of it but how long the contact time is in its own time. Here contacts
//! and velocities are told in the real time: speeds and impulses fall with exp(-drag t), energies
//! with its square.
//!
//! ```text
//! real     0 ------- ln 2 / drag ------- 2 ln 2 / drag ------- ...
//! straight 0 -- 1/2, halve: 0 -- 1/2, halve: 0 -- 1/2, ...  in units of 1 / drag
//! ```
//!
//! Where a stage ends does not depend on when somebody looks, so neither does the result. Once
//! nothing more would happen before all discs have stopped, no more stages begin, and any time is
//! reached at once, until somebody interferes.
//!
//! All discs slow down, whoever owns them: a fixed disc stays, one of infinite mass that moves
//! comes to rest like the others, and an observed circle slows down between two reports, although
//! its owner may not. The energy account is kept inside, where drag does no work: drift is relative
//! to the largest energy so far as drag has left it, so it stays error however slow all is.
//!
//! Never together with gravity, under which the motion is not straight in any time.

pub mod slowing;

use std::collections::BTreeSet;

use glam::DVec2;

use super::events::Events;
use super::plain::{Laws, Plain, Stall};
use crate::exact::RunningSum;
use crate::world::{Contact, Disc, DiscId, NotDone, Owner, limits};
use slowing::Slowing;

/// A method in which discs fly straight between contacts.
pub trait Straight {
    /// The laws of its arena.
    fn laws(&self) -> &Laws;
    /// Whether an advance has come so far (s).
    fn has_reached(&self, until: f64) -> bool;
    /// When the next event comes, s; never later than it does.
    fn next_event(&self) -> f64;
    /// Takes the present for the time `at`, s, and all discs for slower by a power of two, or at
    /// rest.
    fn begin_again(&mut self, at: f64, slowed: f64);
    /// The present, s.
    fn now(&self) -> f64;
    /// The discs of one owner as they are now.
    fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc>;
    /// Signed relative energy error.
    fn relative_energy_drift(&self) -> f64;
    /// Keeps account of the momentum from now on.
    fn keep_momentum(&mut self);
    /// Momentum gained by error, N s, while an account is kept.
    fn momentum_drift(&self) -> Option<DVec2>;
    /// Largest overlap at any contact, in radii.
    fn largest_overlap(&self) -> f64;
    /// Largest gap at any contact, in radii, where the method tells.
    fn largest_gap(&self) -> f64;
    /// Contacts since the start.
    fn contacts(&self) -> u64;
    /// Moves on, and adds the contacts on the way.
    fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall>;
    /// The same without a record.
    fn pass(&mut self, until: f64) -> Result<(), Stall>;
    /// Gives a simulated disc a velocity.
    fn set_velocity(&mut self, id: DiscId, velocity: DVec2);
    /// Adds a simulated disc.
    fn add(&mut self, disc: Disc) -> Result<(), NotDone>;
    /// Takes a simulated disc out.
    fn remove(&mut self, id: DiscId) -> Result<(), NotDone>;
    /// Puts a simulated disc somewhere else.
    fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone>;
    /// Moves the walls.
    fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone>;
    /// Puts an observed disc where it is.
    fn observe(&mut self, disc: Disc);
    /// Takes observed discs out.
    fn forget(&mut self, ids: &BTreeSet<DiscId>);
}

/// An arena whose discs slow down.
#[derive(Clone, Debug)]
pub struct Drag<M> {
    method: M,
    slowing: Slowing,
    now: f64,
    /// Whether nothing more happens by itself: then no more stages begin.
    at_peace: bool,
}

impl<M: Straight> Drag<M> {
    /// An arena at time 0, under the drag of its laws: 0 gives the same bits as the method alone.
    pub fn new(method: M) -> Self {
        let laws = method.laws();
        debug_assert!(laws.drag == 0.0 || laws.gravity.is_none(), "no drag with gravity");
        let slowing = Slowing::new(laws.drag);
        Self { method, slowing, now: 0.0, at_peace: false }
    }

    /// The present, s since the start.
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The discs of one owner as they are now.
    pub fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> {
        let speed = self.speed();
        let slow = move |disc: Disc| Disc { velocity: disc.velocity * speed, ..disc };
        self.method.discs(owner).map(slow)
    }

    /// Kinetic energy of the simulated discs, J.
    pub fn kinetic_energy(&self) -> f64 {
        let discs = self.discs(Owner::Simulated);
        discs.map(|disc| disc.kinetic_energy()).collect::<RunningSum>().value()
    }

    /// Signed energy error, with all work accounted for, relative to the largest energy so far as
    /// drag has left it.
    pub fn relative_energy_drift(&self) -> f64 {
        self.method.relative_energy_drift()
    }

    /// Keeps account of the momentum from now on.
    pub fn keep_momentum(&mut self) {
        self.method.keep_momentum();
    }

    /// Momentum gained by error, N s, while an account is kept: that of the method inside, where
    /// drag takes none, as slow as all is now.
    pub fn momentum_drift(&self) -> Option<DVec2> {
        self.method.momentum_drift().map(|drift| drift * self.speed())
    }

    /// Largest overlap of a simulated pair at any contact, in units of the smaller radius.
    pub fn largest_overlap(&self) -> f64 {
        self.method.largest_overlap()
    }

    /// Largest gap of a simulated pair at any contact, in units of the smaller radius, where the
    /// method tells.
    pub fn largest_gap(&self) -> f64 {
        self.method.largest_gap()
    }

    /// Contacts since the start, pairs and walls.
    pub fn contacts(&self) -> u64 {
        self.method.contacts()
    }

    /// Moves on to `until` (s) and adds the contacts on the way, at most a bounded number of
    /// events: [`Self::now`] tells how far it came.
    ///
    /// # Errors
    /// [`Stall`] when endlessly many contacts fall on one instant; the arena then stands there.
    pub fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
        self.go_on(until, |arena, straight| {
            let known = contacts.len();
            let advanced = arena.method.advance(straight, contacts);
            contacts[known..].iter_mut().for_each(|contact| arena.tell(contact));
            advanced
        })
    }

    /// The same without a record of the contacts.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(&mut self, until: f64) -> Result<(), Stall> {
        self.go_on(until, |arena, straight| arena.method.pass(straight))
    }

    /// Gives a simulated disc, if it is there, a new velocity from now on.
    pub fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
        self.wake();
        self.method.set_velocity(id, velocity / self.speed());
    }

    /// Adds a simulated disc.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
        self.wake();
        self.method.add(Disc { velocity: disc.velocity / self.speed(), ..disc })
    }

    /// Takes a simulated disc out.
    ///
    /// # Errors
    /// [`NotDone`] if there is none.
    pub fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
        self.wake();
        self.method.remove(id)
    }

    /// Puts a simulated disc somewhere else, with another velocity.
    ///
    /// # Errors
    /// [`NotDone`]; nothing is changed then.
    pub fn place(&mut self, id: DiscId, position: DVec2, velocity: DVec2) -> Result<(), NotDone> {
        self.wake();
        self.method.place(id, position, velocity / self.speed())
    }

    /// Moves the walls, and brings discs inside.
    ///
    /// # Errors
    /// [`NotDone`] if there are no walls, or no room within; nothing is changed then.
    pub fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
        self.wake();
        self.method.move_walls(min, max)
    }

    /// Puts an observed disc where its owner says that it is, adding it if it is new.
    pub fn observe(&mut self, disc: Disc) {
        self.wake();
        self.method.observe(Disc { velocity: disc.velocity / self.speed(), ..disc });
    }

    /// Takes observed discs out.
    pub fn forget(&mut self, ids: &BTreeSet<DiscId>) {
        self.wake();
        self.method.forget(ids);
    }

    /// Moves on stage by stage; `advance` brings the method to a time of its own.
    fn go_on(
        &mut self,
        until: f64,
        mut advance: impl FnMut(&mut Self, f64) -> Result<(), Stall>,
    ) -> Result<(), Stall> {
        if until.is_nan() {
            return Ok(());
        }
        let before = self.contacts();
        loop {
            let ends = !self.at_peace && self.slowing.is_later(until);
            let straight = if ends { self.slowing.end() } else { self.slowing.straight(until) };
            let advanced = advance(self, straight);
            if advanced.is_err() || !self.method.has_reached(straight) {
                self.now = self.now.max(self.slowing.time(self.method.now()));
                return advanced.map_err(|stall| Stall { time: self.now, ..stall });
            }
            if !ends {
                self.now = self.now.max(until);
                return Ok(());
            }
            self.end_stage();
            if self.contacts() - before >= limits::EVENTS_PER_ADVANCE as u64 {
                return Ok(());
            }
        }
    }

    /// Goes over to the next stage if anything happens before all discs have stopped.
    fn end_stage(&mut self) {
        self.at_peace = self.method.next_event() > self.slowing.stop();
        if !self.at_peace {
            self.method.begin_again(0.0, 0.5);
            self.slowing.begin_next();
            self.now = self.now.max(self.slowing.time(0.0));
        }
    }

    /// Goes over to the present stage, for something may happen again.
    fn wake(&mut self) {
        if self.at_peace {
            let (at, slowed) = self.slowing.begin_at(self.now);
            self.method.begin_again(at, slowed);
            self.at_peace = false;
        }
    }

    /// The speed of a disc now in units of what the method says.
    fn speed(&self) -> f64 {
        self.slowing.speed(self.now)
    }

    /// Tells a contact of the method in real time.
    fn tell(&self, contact: &mut Contact) {
        let speed = self.slowing.speed_at(contact.time);
        contact.approach_speed *= speed;
        contact.impulse *= speed;
        contact.energy_loss *= speed * speed;
        contact.time = self.slowing.time(contact.time);
    }
}

/// The same of both methods, by its name.
macro_rules! straight {
    ($method:ty) => {
        impl Straight for $method {
            fn laws(&self) -> &Laws {
                <$method>::laws(self)
            }
            fn has_reached(&self, until: f64) -> bool {
                <$method>::has_reached(self, until)
            }
            fn next_event(&self) -> f64 {
                <$method>::next_event(self)
            }
            fn begin_again(&mut self, at: f64, slowed: f64) {
                <$method>::begin_again(self, at, slowed);
            }
            fn now(&self) -> f64 {
                <$method>::now(self)
            }
            fn discs(&self, owner: Owner) -> impl Iterator<Item = Disc> {
                <$method>::discs(self, owner)
            }
            fn relative_energy_drift(&self) -> f64 {
                <$method>::relative_energy_drift(self)
            }
            fn keep_momentum(&mut self) {
                <$method>::keep_momentum(self);
            }
            fn momentum_drift(&self) -> Option<DVec2> {
                <$method>::momentum_drift(self)
            }
            fn largest_overlap(&self) -> f64 {
                <$method>::largest_overlap(self)
            }
            fn largest_gap(&self) -> f64 {
                <$method>::largest_gap(self)
            }
            fn contacts(&self) -> u64 {
                <$method>::contacts(self)
            }
            fn advance(&mut self, until: f64, contacts: &mut Vec<Contact>) -> Result<(), Stall> {
                <$method>::advance(self, until, contacts)
            }
            fn pass(&mut self, until: f64) -> Result<(), Stall> {
                <$method>::pass(self, until)
            }
            fn set_velocity(&mut self, id: DiscId, velocity: DVec2) {
                <$method>::set_velocity(self, id, velocity);
            }
            fn add(&mut self, disc: Disc) -> Result<(), NotDone> {
                <$method>::add(self, disc)
            }
            fn remove(&mut self, id: DiscId) -> Result<(), NotDone> {
                <$method>::remove(self, id)
            }
            fn place(&mut self, id: DiscId, position: DVec2, v: DVec2) -> Result<(), NotDone> {
                <$method>::place(self, id, position, v)
            }
            fn move_walls(&mut self, min: DVec2, max: DVec2) -> Result<(), NotDone> {
                <$method>::move_walls(self, min, max)
            }
            fn observe(&mut self, disc: Disc) {
                <$method>::observe(self, disc);
            }
            fn forget(&mut self, ids: &BTreeSet<DiscId>) {
                <$method>::forget(self, ids);
            }
        }
    };
}

straight!(Plain);
straight!(Events);
