//! A ball on the ground: it slides until its spin fits its speed, then rolls until it stops.
//!
//! With velocity `v` and spin `u` (angular velocity times radius, as a vector along the ground; it
//! rolls where `u = v`) and slip `s = v - u`: while it slides, `v' = -a s/|s|` and
//! `u' = (k / (1 - k)) a s/|s|`, so the slip keeps its direction and is gone after
//! `(1 - k) |s| / a`, with `v = u = k v0 + (1 - k) u0`. Then `v' = -b v/|v| - c v` until it stands,
//! for good; `c` is 0 but in a league that has it. `k` is the part of its speed that a ball kicked
//! without spin has left when it begins to roll: 5/7 for a massive sphere, 3/5 for a hollow one.
//! All of this has closed forms.
//!
//! An arena flies straight between control ticks, so a ball gets at each tick the velocity that
//! brings it to where the closed form has it at the next, with a change of phase or a stop in
//! between: at ticks it is where it should be, to rounding that does not grow, as long as it meets
//! nobody. Within a tick it is off the curve by `a tick^2 / 8` at most (4e-7 m at 3 m/s^2, 1 ms),
//! and a collision sees the mean velocity of the tick, `a tick / 2` from the true one (1.5 mm/s).
//! It changes `v` and leaves `u`: there is no friction between discs. After it the ball flies
//! straight until the tick ends, `a tick^2 / 2` from the curve at most (1.5e-6 m), and slows down
//! for that time all the same. Nothing here moves a disc or looks for contacts.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::contact::Contact;
use super::disc::{Disc, DiscId};

/// How a ball slows down.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ball {
    /// Deceleration while it slides, m/s^2; above 0.
    pub sliding: f64,
    /// Deceleration while it rolls, m/s^2; 0 or more.
    pub rolling: f64,
    /// Drag while it rolls, besides, 1/s; 0 or more.
    #[serde(default)]
    pub drag: f64,
    /// Part of its speed that a ball kicked without spin has when it begins to roll, above 0 and at
    /// most 1.
    pub switch_ratio: f64,
}

impl Default for Ball {
    /// As TIGERs Mannheim have it for the ball of the Small Size League.
    fn default() -> Self {
        Self { sliding: 3.0, rolling: 0.26, drag: 0.0, switch_ratio: 0.64 }
    }
}

/// How a ball moves at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BallMotion {
    /// m/s
    pub velocity: DVec2,
    /// Angular velocity times radius, along the ground, m/s: equal to `velocity` when it rolls.
    pub spin: DVec2,
}

impl BallMotion {
    /// A ball that rolls.
    pub fn rolling(velocity: DVec2) -> Self {
        Self { velocity, spin: velocity }
    }
}

impl Ball {
    /// How it moves after a time (s, 0 or more) in which it meets nobody, and its way until then,
    /// m: the closed form, to a few roundings.
    pub fn after(&self, motion: BallMotion, time: f64) -> (BallMotion, DVec2) {
        let BallMotion { velocity, spin } = motion;
        let slip = velocity - spin;
        let (slip_speed, left) = (slip.length(), 1.0 - self.switch_ratio);
        if slip_speed == 0.0 {
            return self.roll(velocity, time);
        }
        let (along, slides_for) = (slip / slip_speed, left * slip_speed / self.sliding);
        if time < slides_for {
            let change = along * (self.sliding * time);
            let spin = spin + change * (self.switch_ratio / left);
            return (
                BallMotion { velocity: velocity - change, spin },
                velocity * time - change * (0.5 * time),
            );
        }
        let way = velocity * slides_for - along * (0.5 * self.sliding * slides_for * slides_for);
        let (motion, more) = self.roll(velocity - slip * left, time - slides_for);
        (motion, way + more)
    }

    /// After how long it stands if it meets nobody, s; infinite if it never does.
    pub fn rests_after(&self, motion: BallMotion) -> f64 {
        let (slip, left) = (motion.velocity - motion.spin, 1.0 - self.switch_ratio);
        let slides_for = left * slip.length() / self.sliding;
        match (motion.velocity - slip * left).length() {
            0.0 => slides_for,
            _ if self.rolling == 0.0 => f64::INFINITY,
            speed if self.drag > 0.0 => {
                slides_for + libm::log1p(self.drag * speed / self.rolling) / self.drag
            }
            speed => slides_for + speed / self.rolling,
        }
    }

    fn roll(&self, velocity: DVec2, time: f64) -> (BallMotion, DVec2) {
        let speed = velocity.length();
        if self.drag > 0.0 && speed > 0.0 {
            return self.roll_with_drag(velocity, time);
        }
        if speed <= self.rolling * time {
            // It stands, at last or all the time.
            let rolls_for = if speed > 0.0 { speed / self.rolling } else { 0.0 };
            return (BallMotion::default(), velocity * (0.5 * rolls_for));
        }
        let lost = self.rolling * time / speed;
        (BallMotion::rolling(velocity * (1.0 - lost)), velocity * (time * (1.0 - 0.5 * lost)))
    }
}

impl Ball {
    /// `v' = -b v/|v| - c v`: the speed is `(v + b/c) exp(-c t) - b/c` until that is 0.
    fn roll_with_drag(&self, velocity: DVec2, time: f64) -> (BallMotion, DVec2) {
        let steady = self.rolling / (self.drag * velocity.length());
        let rolls_for = match steady {
            0.0 => f64::INFINITY,
            steady => libm::log1p(steady.recip()) / self.drag,
        };
        if time >= rolls_for {
            return (
                BallMotion::default(),
                velocity * ((1.0 - steady * self.drag * rolls_for) / self.drag),
            );
        }
        let lost = -libm::expm1(-self.drag * time) * (1.0 + steady);
        let way = velocity * (lost / self.drag - steady * time);
        (BallMotion::rolling(velocity * (1.0 - lost)), way)
    }
}

/// The kick from which a ball moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kick {
    /// Who kicked.
    pub robot: DiscId,
    /// Where the ball was, m.
    pub position: DVec2,
    /// Its velocity just after, m/s.
    pub velocity: DVec2,
    /// When, s.
    pub time: f64,
}

/// A ball of an arena.
#[derive(Clone, Debug)]
pub(super) struct Rolling {
    pub id: DiscId,
    pub ball: Ball,
    /// Where it was when it last began anew, m.
    origin: DVec2,
    /// How it moved then.
    motion: BallMotion,
    /// When, s.
    since: f64,
    /// The velocity that it was given, m/s.
    given: DVec2,
    /// When something last touched it since it was given that, s.
    touched_at: Option<f64>,
    /// Whether a dribbler has it: it goes where that goes.
    pub held: bool,
    /// The kick from which it moves; none once it stood, was held, or was moved by hand.
    pub kick: Option<Kick>,
    /// Where a force draws it, if one does, m.
    pub pulled_to: Option<DVec2>,
}

impl Rolling {
    /// A ball that stands until the first tick.
    pub fn new(id: DiscId, ball: Ball) -> Self {
        let motion = BallMotion::default();
        let (origin, given) = (DVec2::NAN, DVec2::NAN);
        let (since, touched_at, held, kick, pulled_to) = (0.0, None, false, None, None);
        Self { id, ball, origin, motion, since, given, touched_at, held, kick, pulled_to }
    }

    /// Takes note of contacts on the way.
    pub fn note(&mut self, contacts: &[Contact]) {
        let own = contacts.iter().filter(|contact| contact.discs().any(|id| id == self.id));
        self.touched_at = own.map(|contact| contact.time).next_back().or(self.touched_at);
    }

    /// How it moves now, where the arena has it as this disc.
    pub fn motion(&self, disc: &Disc, now: f64) -> BallMotion {
        let after = |motion, time: f64| match self.held {
            true => motion,
            false => self.ball.after(motion, time.max(0.0)).0,
        };
        if let Some(touched_at) = self.touched_at {
            let spin = after(self.motion, touched_at - self.since).spin;
            return after(BallMotion { velocity: disc.velocity, spin }, now - touched_at);
        }
        let motion = after(self.motion, now - self.since);
        if disc.velocity == self.given {
            return motion;
        }
        // Somebody gave it another velocity: at first, the scene.
        BallMotion { velocity: disc.velocity, ..motion }
    }

    /// It moves otherwise from now on; returns the velocity until `next`, s.
    pub fn begin(&mut self, disc: &Disc, motion: BallMotion, now: f64, next: f64) -> DVec2 {
        (self.origin, self.motion, self.since) = (disc.position, motion, now);
        (self.touched_at, self.held) = (None, false);
        let (_, way) = self.ball.after(motion, next - now);
        // So short a way says nothing of a velocity.
        let is_long = next - now > 1e-9 * next;
        self.given = if is_long { way / (next - now) } else { motion.velocity };
        self.given
    }

    /// The velocity from this tick to the next.
    pub fn follow(&mut self, disc: &Disc, now: f64, next: f64) -> DVec2 {
        let undisturbed = self.touched_at.is_none() && disc.velocity == self.given && !self.held;
        let motion = self.motion(disc, now);
        let stands = motion == BallMotion::default();
        self.kick = self.kick.filter(|_| !stands);
        if !undisturbed {
            return self.begin(disc, motion, now, next);
        }
        let (_, way) = self.ball.after(self.motion, next - self.since);
        self.given =
            if stands { DVec2::ZERO } else { (self.origin + way - disc.position) / (next - now) };
        self.given
    }

    /// A dribbler draws it to a place that moves, with no more than this acceleration, m/s^2;
    /// returns the velocity until the next tick. It rolls.
    pub fn hold(&mut self, disc: &Disc, front: &Front, grip: f64, now: f64, next: f64) -> DVec2 {
        let before = self.motion(disc, now).velocity;
        self.given = drawn(before, disc.position, front, grip, next - now);
        (self.origin, self.motion, self.since) =
            (disc.position, BallMotion::rolling(self.given), now);
        (self.touched_at, self.held, self.kick) = (None, true, None);
        self.given
    }
}

/// Where a dribbler wants a ball, m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Front {
    pub now: DVec2,
    /// At the next tick.
    pub next: DVec2,
}

impl Front {
    /// A place that stays.
    pub fn fixed(place: DVec2) -> Self {
        Self { now: place, next: place }
    }
}

/// The velocity in the coming tick (s) of something that is drawn to a place that moves, with no
/// more than this acceleration, m/s^2.
pub(super) fn drawn(before: DVec2, at: DVec2, front: &Front, most: f64, tick: f64) -> DVec2 {
    // Not so fast that it could not stop there: v tick + v^2 / (2 most) = the distance.
    let lag = front.now - at;
    let distance = lag.length();
    let per_second = 2.0 / (tick + (tick * tick + 2.0 * distance / most).sqrt());
    let wanted = (front.next - front.now) / tick + lag * per_second;
    before + (wanted - before).clamp_length_max(most * tick)
}
