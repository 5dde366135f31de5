//! The flight of one disc between two samples: straight, bent once by a contact, or more tangled.
//!
//! Under the same linear drag for all discs every path is straight in the time
//! `(1 - exp(-c t)) / c`, with the later velocity scaled back: all of the audit runs in that time.
//! Gravity moves all discs of finite mass alike and cancels between two of them.
//!
//! Never judge a collision here.

use glam::DVec2;

use super::judge::JUDGED;
use super::law::Law;
use super::noise::{Noise, Sigma};
use crate::world::Disc;

/// Standard deviations beyond which a change is none of the noise: one in 7e7 in the plane.
const CHANGED: f64 = 6.0;

/// How far a displacement may exceed what the fastest disc could travel.
const TRAVEL: f64 = 1.5;

/// What the samples say of the way between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Course {
    /// Velocity and position are those of free motion.
    Quiet,
    /// One sudden change of the velocity explains the position, at this time, s.
    Bent(f64),
    /// Changed, and no single instant explains it.
    Tangled,
    /// Somewhere else: no motion leads there.
    Jumped,
}

/// One disc at two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flight {
    /// At the earlier sample.
    pub before: Disc,
    /// At the later one, at the image nearest to that; velocity scaled back by what drag took.
    pub after: Disc,
    /// Change of the velocity beyond free motion, m/s.
    pub change: DVec2,
    /// Change of the position beyond free motion, m.
    pub rest: DVec2,
    /// What lies between.
    pub course: Course,
    /// Errors of what was recorded.
    pub sigma: Sigma,
}

impl Flight {
    /// Whether a contact may have changed it.
    pub fn is_disturbed(&self) -> bool {
        matches!(self.course, Course::Bent(_) | Course::Tangled)
    }

    /// The acceleration of its free motion, m/s^2.
    pub fn fall(&self, law: &Law) -> DVec2 {
        if self.before.mass.is_finite() { law.gravity } else { DVec2::ZERO }
    }
}

/// The time between two samples in which drag leaves paths straight.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// As the stamps say, s.
    pub seconds: f64,
    /// As it is used, s.
    pub length: f64,
    /// Factor of later velocities.
    pub scale: f64,
}

impl Span {
    pub fn new(seconds: f64, drag: f64) -> Self {
        if drag == 0.0 {
            return Self { seconds, length: seconds, scale: 1.0 };
        }
        let length = -libm::expm1(-drag * seconds) / drag;
        Self { seconds, length, scale: libm::exp(drag * seconds) }
    }

    /// Seconds after the earlier sample of an instant in its own time.
    pub fn seconds_at(&self, instant: f64, drag: f64) -> f64 {
        if drag == 0.0 { instant } else { -libm::log1p(-drag * instant) / drag }
    }
}

/// What a flight is judged by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means<'a> {
    pub law: &'a Law,
    pub noise: &'a Noise,
    /// Speed of the fastest disc, m/s.
    pub fastest: f64,
}

impl Means<'_> {
    /// The flight of a disc.
    pub fn flight(&self, before: &Disc, after: &Disc, span: &Span) -> Flight {
        let position = after.position + self.law.shift(before.position, after.position);
        let after = Disc { position, velocity: after.velocity * span.scale, ..*after };
        let mut flight = Flight {
            before: *before,
            after,
            change: DVec2::ZERO,
            rest: DVec2::ZERO,
            course: Course::Quiet,
            sigma: Sigma { position: 0.0, velocity: 0.0 },
        };
        let (fall, length) = (flight.fall(self.law), span.length);
        let slowing = self.law.drag * before.velocity.length();
        flight.sigma = self.noise.of(before, &after, fall.length() + slowing);
        flight.change = after.velocity - before.velocity - fall * length;
        flight.rest =
            after.position - before.position - (before.velocity + 0.5 * fall * length) * length;
        flight.course = self.course(&flight, length);
        flight.sigma.velocity += driven_sigma(self.law, length);
        flight
    }

    fn course(&self, flight: &Flight, length: f64) -> Course {
        let Flight { before, after, change, rest, sigma, .. } = flight;
        let (rest_sigma, driven) = (sigma.of_rest(length), self.law.driven(length));
        let pushed = driven * length;
        let moved = (after.position - before.position).length();
        if moved > TRAVEL * self.fastest * length + CHANGED * rest_sigma + pushed {
            return Course::Jumped;
        }
        let size = change.length();
        if size <= CHANGED * sigma.of_change() + driven {
            let quiet = rest.length() <= CHANGED * rest_sigma + pushed;
            return if quiet { Course::Quiet } else { Course::Tangled };
        }
        let along = rest.dot(*change) / size;
        let across = rest.perp_dot(*change) / size;
        let instant = length - along / size;
        let margin = CHANGED * rest_sigma / size + 1e-9 * length;
        let within = instant >= -margin && instant <= length + margin;
        if within && across.abs() <= CHANGED * rest_sigma + pushed {
            Course::Bent(instant.clamp(0.0, length))
        } else {
            Course::Tangled
        }
    }
}

/// A deviation of velocities of which what drives may add in this time is at most [`JUDGED`].
pub(super) fn driven_sigma(law: &Law, length: f64) -> f64 {
    law.driven(length) / (JUDGED * std::f64::consts::SQRT_2)
}
