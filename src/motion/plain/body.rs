//! A disc of an arena at the time of its own last event, its state in double-double.
//!
//! A double knows a coordinate to 2^-53 of itself. That is too little where discs follow each other
//! slowly, or a light disc is thrown to and fro a hundred thousand times: what counts there are
//! differences. So position and velocity have low parts; whom a disc will meet is sought with the
//! high parts alone, which is as quick as before.

use glam::DVec2;

use super::collapse::Collapse;
use crate::exact::{DoubleDouble, DoubleDoubleVec};
use crate::world::{Disc, Owner};

/// Position and velocity at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    pub position: DoubleDoubleVec,
    pub velocity: DoubleDoubleVec,
}

/// A disc at the time of its own last event.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    /// The disc as doubles show it.
    pub disc: Disc,
    /// What its position leaves out, m.
    position_rest: DVec2,
    /// What its velocity leaves out, m/s.
    velocity_rest: DVec2,
    pub owner: Owner,
    /// Acceleration between its events, m/s^2: none for fixed, observed and resting discs.
    pub acceleration: DVec2,
    /// Offset at which `disc` holds, s; the rest keeps what a long rest loses.
    pub own_time: DoubleDouble,
    pub collapse: Collapse,
}

impl Body {
    /// A body whose state is known to the precision of doubles.
    pub fn new(disc: Disc, owner: Owner, own_time: f64) -> Self {
        Self {
            disc,
            position_rest: DVec2::ZERO,
            velocity_rest: DVec2::ZERO,
            owner,
            acceleration: DVec2::ZERO,
            own_time: own_time.into(),
            collapse: Collapse::default(),
        }
    }

    /// Brings it to an offset.
    pub fn move_to(&mut self, offset: f64) {
        if offset != self.own_time.hi || self.own_time.lo != 0.0 {
            self.set(&self.state_at(offset));
            self.own_time = offset.into();
        }
    }

    /// Puts it elsewhere at its own time, by whole boxes.
    pub fn shift(&mut self, boxes: DVec2) {
        if boxes != DVec2::ZERO {
            let State { position, velocity } = self.state();
            self.set(&State { position: position.plus_double(boxes), velocity });
        }
    }

    /// Changes its velocity at its own time, as if that had happened `delay` (s) later.
    pub fn kick(&mut self, change: &DoubleDoubleVec, delay: f64) {
        let State { position, velocity } = self.state();
        let ahead = change.times_double(-delay);
        self.set(&State { position: position.plus(ahead), velocity: velocity.plus(*change) });
    }

    /// The state at its own time.
    pub fn state(&self) -> State {
        State {
            position: DoubleDoubleVec::of(self.disc.position, self.position_rest),
            velocity: DoubleDoubleVec::of(self.disc.velocity, self.velocity_rest),
        }
    }

    /// Gives it another state at its own time.
    pub fn set(&mut self, state: &State) {
        (self.disc.position, self.position_rest) = (state.position.hi(), state.position.lo());
        (self.disc.velocity, self.velocity_rest) = (state.velocity.hi(), state.velocity.lo());
    }

    /// Gives it the state of a disc, to the precision of doubles.
    pub fn set_disc(&mut self, disc: Disc) {
        self.disc = disc;
        (self.position_rest, self.velocity_rest) = (DVec2::ZERO, DVec2::ZERO);
    }

    /// Takes its own time for another, from which on it flies slower by a power of two.
    pub fn begin_again(&mut self, own_time: f64, slowed: f64) {
        self.disc.velocity *= slowed;
        self.velocity_rest *= slowed;
        self.own_time = own_time.into();
    }

    /// Gives it another velocity, to the precision of doubles.
    pub fn set_velocity(&mut self, velocity: DVec2) {
        (self.disc.velocity, self.velocity_rest) = (velocity, DVec2::ZERO);
    }

    /// The state at an offset.
    pub fn state_at(&self, offset: f64) -> State {
        let State { position, velocity } = self.state();
        let wait = DoubleDouble::from(offset).minus(self.own_time);
        let falls = self.acceleration != DVec2::ZERO;
        if wait.hi == 0.0 || (self.disc.velocity == DVec2::ZERO && !falls) {
            return State { position, velocity };
        }
        if !falls {
            return State { position: position.plus(velocity.times(wait)), velocity };
        }
        let gained = DoubleDoubleVec::from(self.acceleration).times(wait);
        let mean = velocity.plus(gained.scaled(0.5));
        State { position: position.plus(mean.times(wait)), velocity: velocity.plus(gained) }
    }

    /// The disc at an offset, as doubles show it.
    pub fn at(&self, offset: f64) -> Disc {
        let state = self.state_at(offset);
        Disc { position: state.position.hi(), velocity: state.velocity.hi(), ..self.disc }
    }

    /// The same computed in doubles: quick, and off by a few u of the coordinates.
    #[inline(always)]
    pub fn roughly_at(&self, offset: f64) -> Disc {
        let wait = offset - self.own_time.hi;
        if self.acceleration == DVec2::ZERO {
            let position = self.disc.position + self.disc.velocity * wait;
            return Disc { position, ..self.disc };
        }
        let position = self.disc.position + self.fall(wait);
        Disc { position, velocity: self.disc.velocity + self.acceleration * wait, ..self.disc }
    }

    /// How far it comes under its acceleration.
    fn fall(&self, wait: f64) -> DVec2 {
        (self.disc.velocity + 0.5 * self.acceleration * wait) * wait
    }

    /// What gravity does to its kinetic energy on the way to an offset, J.
    pub fn work_until(&self, offset: f64) -> f64 {
        if self.acceleration == DVec2::ZERO {
            return 0.0;
        }
        self.disc.mass * self.acceleration.dot(self.fall(offset - self.own_time.hi))
    }

    pub fn is_simulated(&self) -> bool {
        self.owner == Owner::Simulated
    }

    /// Whether a contact of the two is ours to resolve and would change one of them.
    pub fn can_collide_with(&self, other: &Body) -> bool {
        let ours = self.is_simulated() || other.is_simulated();
        ours && (self.disc.mass.is_finite() || other.disc.mass.is_finite())
    }

    /// Whether its energy counts, and changes only by known amounts.
    pub fn is_closed(&self) -> bool {
        self.is_simulated() && self.disc.mass.is_finite()
    }
}
