//! Drives: how driven pucks follow their commands, and stop when nobody commands them any more.
//!
//! A robot cannot change its velocity at once: at every control tick, `tick_s` apart, each drive
//! brings it nearer to what was asked, within its limits. Between two ticks it goes straight on and
//! collides like any puck, so the motion stays exact; what a collision takes, the drive makes good
//! at its own acceleration. Ticks lie on simulated time alone, so the motion is the same at any
//! publish rate. Nothing here moves a disc or looks for contacts.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::disc::{Disc, DiscId};

/// Which velocities a robot can have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// Any, at once, in the arena's frame: a puck that is told its velocity.
    #[default]
    Told,
    /// Any, in its own frame, and it turns: omnidirectional wheels.
    Holonomic,
    /// Along its heading alone, and it turns: two wheels.
    Differential,
}

/// A drive and its limits; infinite = none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Which velocities it can have.
    pub model: Model,
    /// Largest speed that it asks for, m/s.
    pub speed_max: f64,
    /// Largest change of velocity, m/s^2.
    pub acceleration_max: f64,
    /// Largest turning rate, rad/s.
    pub turn_max: f64,
    /// Largest change of the turning rate, rad/s^2.
    pub turn_acceleration_max: f64,
    /// Where it looks at first, rad, 0 along x, against the clock.
    pub heading: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            model: Model::Told,
            speed_max: f64::INFINITY,
            acceleration_max: f64::INFINITY,
            turn_max: f64::INFINITY,
            turn_acceleration_max: f64::INFINITY,
            heading: 0.0,
        }
    }
}

/// What a command asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// m/s, in the frame that the model says.
    pub linear: DVec2,
    /// rad/s
    pub angular: f64,
}

/// How a robot stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// rad, from -pi to pi
    pub heading: f64,
    /// rad/s
    pub turn: f64,
}

#[derive(Clone, Debug)]
struct Robot {
    id: DiscId,
    drive: Drive,
    pose: Pose,
    wanted: Wanted,
    /// Simulated time of the last command, s; infinite once it was too long ago.
    commanded_at: f64,
}

/// All driven pucks.
#[derive(Clone, Debug)]
pub struct Drives {
    robots: Vec<Robot>,
    /// Between two control ticks, s.
    tick: f64,
    /// The next of them.
    next: u64,
    /// A command older than this is over, s; 0 = never.
    timeout: f64,
}

impl Drives {
    /// None yet; ticks are so far apart, s, and commands valid for `timeout`, s, 0 = for ever.
    pub fn new(tick: f64, timeout: f64) -> Self {
        Self { robots: Vec::new(), tick, next: 1, timeout }
    }

    /// A puck is driven from now on.
    pub fn add(&mut self, id: DiscId, drive: Drive) {
        let pose = Pose { heading: drive.heading, turn: 0.0 };
        let (wanted, commanded_at) = (Wanted::default(), f64::INFINITY);
        self.robots.push(Robot { id, drive, pose, wanted, commanded_at });
    }

    /// A puck is gone.
    pub fn remove(&mut self, id: DiscId) {
        self.robots.retain(|robot| robot.id != id);
    }

    /// Commands are valid for so long from now on, s; 0 = for ever.
    pub fn set_timeout(&mut self, timeout: f64) {
        self.timeout = timeout;
    }

    /// How a robot stands, if it is one.
    pub fn pose(&self, id: DiscId) -> Option<Pose> {
        self.robots.iter().find(|robot| robot.id == id).map(|robot| robot.pose)
    }

    /// Takes a command; the velocity to be set at once, if the model is told its velocity.
    pub fn command(&mut self, id: DiscId, wanted: Wanted, now: f64) -> Option<DVec2> {
        let Some(robot) = self.robots.iter_mut().find(|robot| robot.id == id) else {
            return Some(wanted.linear);
        };
        (robot.wanted, robot.commanded_at) = (wanted, now);
        (robot.drive.model == Model::Told).then_some(wanted.linear)
    }

    /// The next control tick up to a time, s, if there is anything to control.
    pub fn due(&mut self, now: f64, until: f64) -> Option<f64> {
        let idle = |robot: &Robot| {
            robot.drive.model == Model::Told
                && (self.timeout == 0.0 || robot.commanded_at == f64::INFINITY)
        };
        if self.robots.iter().all(idle) {
            return None;
        }
        // Ticks that passed with nothing to control.
        if self.next as f64 * self.tick <= now {
            self.next = (now / self.tick).floor() as u64 + 1;
        }
        let next = self.next as f64 * self.tick;
        (next <= until && next > now).then_some(next)
    }

    /// The velocities that robots have from this tick on, of those whose velocity changes.
    pub fn follow(&mut self, now: f64, discs: impl Iterator<Item = Disc>) -> Vec<(DiscId, DVec2)> {
        self.next += 1;
        let (tick, timeout) = (self.tick, self.timeout);
        let mut changed = Vec::new();
        for disc in discs {
            let Some(robot) = self.robots.iter_mut().find(|robot| robot.id == disc.id) else {
                continue;
            };
            let velocity = robot.next_velocity(disc.velocity, now, tick, timeout);
            if velocity != disc.velocity {
                changed.push((disc.id, velocity));
            }
        }
        changed
    }
}

impl Robot {
    fn next_velocity(&mut self, velocity: DVec2, now: f64, tick: f64, timeout: f64) -> DVec2 {
        let is_over = timeout > 0.0 && now - self.commanded_at > timeout;
        if is_over {
            (self.wanted, self.commanded_at) = (Wanted::default(), f64::INFINITY);
        }
        let Drive { model, speed_max, acceleration_max, turn_max, turn_acceleration_max, .. } =
            self.drive;
        if model == Model::Told {
            return if is_over { DVec2::ZERO } else { velocity };
        }
        let turn = self.wanted.angular.clamp(-turn_max, turn_max);
        let more = turn_acceleration_max * tick;
        self.pose.turn += (turn - self.pose.turn).clamp(-more, more);
        // Straight on at the mean heading of the tick: an arc to second order.
        let half = 0.5 * self.pose.turn * tick;
        let heading = direction(self.pose.heading + half);
        self.pose.heading = wrapped(self.pose.heading + 2.0 * half);
        let asked = match model {
            Model::Differential => heading * self.wanted.linear.x,
            Model::Told | Model::Holonomic => heading.rotate(self.wanted.linear),
        };
        let difference = asked.clamp_length_max(speed_max) - velocity;
        velocity + difference.clamp_length_max(acceleration_max * tick)
    }
}

/// The same bits on every machine, which the standard library does not promise.
fn direction(heading: f64) -> DVec2 {
    let (y, x) = libm::sincos(heading);
    DVec2::new(x, y)
}

/// From -pi to pi.
fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle.abs() <= PI { angle } else { angle - TAU * (angle / TAU).round() }
}
