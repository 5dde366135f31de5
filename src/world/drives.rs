//! Drives: how driven pucks follow their commands, and stop when nobody commands them any more.
//!
//! A robot cannot change its velocity at once: at every control tick, `tick_s` apart, each drive
//! brings it nearer to what was asked, within its limits. Between two ticks it goes straight on and
//! collides like any puck, so the motion stays exact; what a collision takes, the drive makes good
//! at its own acceleration. Ticks lie on simulated time alone, so the motion is the same at any
//! publish rate. Nothing here moves a disc or looks for contacts.
//!
//! **Kicker and dribbler.** A ball is in the mouth of a robot when it is seen from the robot's
//! centre within [`Kicker::half_angle`] of the heading and the gap between the two is
//! [`Kicker::reach`] at most. A kick there gives the ball the speed that is asked for along the
//! heading, whatever speed it had; across the heading, and in its spin, nothing changes. A robot
//! told to kick without a ball there waits for one: it kicks at the first tick at which one is in
//! its mouth, unless it is told not to, or the command is too old, before that. A dribbler that is
//! on has the nearest ball in its mouth at every tick: it gets the velocity that brings it to the
//! front of the robot, [`HOLD_GAP_M`] from it, as soon as it can stop there, and then keeps it
//! there while the robot drives and turns, with no larger acceleration than [`Kicker::grip`]; one
//! that lags behind so far that it leaves the mouth is lost. A held ball rolls when it is let go.
//! After a kick the dribbler lets a ball go until none is in the mouth. Neither conserves momentum:
//! the robot's wheels pass the recoil on to the floor.
//!
//! **Pull.** A force from outside draws a robot or a ball to a place and keeps it there, in the way
//! a dribbler does and with at most [`PULL_MPS2`], whatever drive and friction would do. A robot
//! turns as it is commanded meanwhile.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::ball::{Ball, BallMotion, Front, Kick, Rolling, drawn};
use super::contact::Contact;
use super::disc::{Disc, DiscId};

/// Distance at which a dribbler holds a ball from its robot, m: so the two do not collide all the
/// time.
pub const HOLD_GAP_M: f64 = 1e-3;

/// Acceleration with which a force from outside draws a robot or a ball to a place, m/s^2.
pub const PULL_MPS2: f64 = 10.0;

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
    /// The same where it slows down; `None` = the same number.
    pub braking_max: Option<f64>,
    /// Largest turning rate, rad/s.
    pub turn_max: f64,
    /// Largest change of the turning rate, rad/s^2.
    pub turn_acceleration_max: f64,
    /// The same where it slows down; `None` = the same number.
    pub turn_braking_max: Option<f64>,
    /// Where it looks at first, rad, 0 along x, against the clock.
    pub heading: f64,
    /// What it plays the ball with, if it can.
    pub kicker: Option<Kicker>,
}

/// Kicker and dribbler of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kicker {
    /// Largest speed that it gives a ball, m/s.
    pub speed_max: f64,
    /// Half of the mouth as seen from the centre, rad.
    pub half_angle: f64,
    /// Largest gap between the robot and a ball that is in the mouth, m.
    pub reach: f64,
    /// Largest acceleration that the dribbler gives a ball, m/s^2; 0 = there is no dribbler.
    pub grip: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            model: Model::Told,
            speed_max: f64::INFINITY,
            acceleration_max: f64::INFINITY,
            braking_max: None,
            turn_max: f64::INFINITY,
            turn_acceleration_max: f64::INFINITY,
            turn_braking_max: None,
            heading: 0.0,
            kicker: None,
        }
    }
}

/// In which frame a velocity is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Frame {
    /// The robot's: x along its heading, y to its left. A puck that is [`Model::Told`] its velocity
    /// has none, and takes it in the arena's.
    #[default]
    Own,
    /// The arena's; of two wheels the part along the heading.
    Arena,
}

/// What a command asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wanted {
    /// m/s
    pub linear: DVec2,
    /// rad/s
    pub angular: f64,
    /// The frame of `linear`.
    pub frame: Frame,
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
    dribbles: bool,
    armed: Option<Armed>,
    /// It has kicked, and the ball may still be in its mouth.
    has_kicked: bool,
    /// When it last kicked a ball, s.
    kicked_at: Option<f64>,
    /// Where a force draws it, if one does, m.
    pulled_to: Option<DVec2>,
}

/// A kick that waits for a ball.
#[derive(Clone, Copy, Debug)]
struct Armed {
    /// Along the heading, m/s.
    speed: f64,
    /// Simulated time of its command, s.
    since: f64,
}

/// All driven pucks, and the balls.
#[derive(Clone, Debug)]
pub struct Drives {
    robots: Vec<Robot>,
    balls: Vec<Rolling>,
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
        Self { robots: Vec::new(), balls: Vec::new(), tick, next: 1, timeout }
    }

    /// A puck is driven from now on.
    pub fn add(&mut self, id: DiscId, drive: Drive) {
        let pose = Pose { heading: drive.heading, turn: 0.0 };
        let (wanted, commanded_at) = (Wanted::default(), f64::INFINITY);
        let (dribbles, armed, has_kicked, kicked_at) = (false, None, false, None);
        self.robots.push(Robot {
            id,
            drive,
            pose,
            wanted,
            commanded_at,
            dribbles,
            armed,
            has_kicked,
            kicked_at,
            pulled_to: None,
        });
    }

    /// A puck is a ball from now on; returns the velocity that it has until the next tick.
    pub fn add_ball(&mut self, disc: &Disc, ball: Ball, now: f64) -> DVec2 {
        let next = self.next_after(now);
        let mut rolling = Rolling::new(disc.id, ball);
        let motion = BallMotion { velocity: disc.velocity, spin: DVec2::ZERO };
        let velocity = rolling.begin(disc, motion, now, next);
        self.balls.push(rolling);
        velocity
    }

    /// A puck is gone.
    pub fn remove(&mut self, id: DiscId) {
        self.robots.retain(|robot| robot.id != id);
        self.balls.retain(|ball| ball.id != id);
    }

    /// Commands are valid for so long from now on, s; 0 = for ever.
    pub fn set_timeout(&mut self, timeout: f64) {
        self.timeout = timeout;
    }

    /// How a robot stands, if it is one.
    pub fn pose(&self, id: DiscId) -> Option<Pose> {
        self.robots.iter().find(|robot| robot.id == id).map(|robot| robot.pose)
    }

    /// The drive of a robot, if it is one.
    pub fn drive(&self, id: DiscId) -> Option<Drive> {
        self.robots.iter().find(|robot| robot.id == id).map(|robot| robot.drive)
    }

    /// Gives a robot another pose; whether it is one.
    pub fn set_pose(&mut self, id: DiscId, heading: f64, turn: f64) -> bool {
        let robot = self.robots.iter_mut().find(|robot| robot.id == id);
        robot.map(|robot| robot.pose = Pose { heading: wrapped(heading), turn }).is_some()
    }

    /// Gives a robot other limits, and leaves its pose; whether it is one.
    pub fn set_drive(&mut self, id: DiscId, drive: Drive) -> bool {
        let robot = self.robots.iter_mut().find(|robot| robot.id == id);
        robot.map(|robot| robot.drive = drive).is_some()
    }

    /// Lets the dribbler of a robot run, or not; whether it is one.
    pub fn dribble(&mut self, id: DiscId, on: bool) -> bool {
        let robot = self.robots.iter_mut().find(|robot| robot.id == id);
        robot.map(|robot| robot.dribbles = on).is_some()
    }

    /// Draws a robot or a ball to a place, m, or no more; whether it is one.
    pub fn pull(&mut self, id: DiscId, to: Option<DVec2>) -> bool {
        let robot = self.robots.iter_mut().find(|robot| robot.id == id);
        let robot = robot.map(|robot| robot.pulled_to = to).is_some();
        let ball = self.balls.iter_mut().find(|ball| ball.id == id);
        ball.map(|ball| ball.pulled_to = to).is_some() || robot
    }

    /// Whether a puck is a ball.
    pub fn is_ball(&self, id: DiscId) -> bool {
        self.balls.iter().any(|ball| ball.id == id)
    }

    /// How a ball moves now, where the arena has it as this disc; `None` = it is no ball.
    pub fn motion(&self, disc: &Disc, now: f64) -> Option<BallMotion> {
        self.balls.iter().find(|ball| ball.id == disc.id).map(|ball| ball.motion(disc, now))
    }

    /// A ball moves otherwise from now on, where the arena has it as this disc; the velocity that
    /// it has until the next tick.
    pub fn move_ball(&mut self, disc: &Disc, motion: BallMotion, now: f64) -> Option<DVec2> {
        let next = self.next_after(now);
        let ball = self.balls.iter_mut().find(|ball| ball.id == disc.id)?;
        ball.kick = None;
        Some(ball.begin(disc, motion, now, next))
    }

    /// The kick from which a ball moves, if there is one.
    pub fn kick_of(&self, id: DiscId) -> Option<Kick> {
        self.balls.iter().find(|ball| ball.id == id)?.kick
    }

    /// The nearest ball in the mouth of a robot.
    pub fn in_mouth(&self, id: DiscId, discs: &[Disc]) -> Option<Disc> {
        let robot = self.robots.iter().find(|robot| robot.id == id)?;
        let own = discs.iter().find(|disc| disc.id == id)?;
        let balls = discs.iter().filter(|disc| self.is_ball(disc.id));
        let near = balls.filter_map(|ball| Some((robot.gap_in_mouth(own, ball)?, *ball)));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, ball)| ball)
    }

    /// Kicks with a speed (m/s) along the heading, now or as soon as a ball is there; 0 = not any
    /// more. The ball that goes now, and its velocity until the next tick.
    pub fn kick(
        &mut self,
        id: DiscId,
        speed: f64,
        discs: &[Disc],
        now: f64,
    ) -> Option<(DiscId, DVec2)> {
        let robot = self.robots.iter_mut().find(|robot| robot.id == id)?;
        robot.armed = (speed > 0.0).then_some(Armed { speed, since: now });
        let ball = self.in_mouth(id, discs)?;
        self.fire(id, &ball, now)
    }

    /// The speed of the kick with which a robot waits for a ball, m/s.
    pub fn armed(&self, id: DiscId) -> Option<f64> {
        let robot = self.robots.iter().find(|robot| robot.id == id)?;
        robot.armed.map(|armed| armed.speed)
    }

    /// When a robot last kicked a ball, s.
    pub fn kicked_at(&self, id: DiscId) -> Option<f64> {
        self.robots.iter().find(|robot| robot.id == id)?.kicked_at
    }

    /// An armed robot kicks a ball in its mouth: which, and its velocity until the next tick.
    fn fire(&mut self, id: DiscId, ball: &Disc, now: f64) -> Option<(DiscId, DVec2)> {
        let motion = self.motion(ball, now)?;
        let robot = self.robots.iter_mut().find(|robot| robot.id == id)?;
        let speed = robot.armed.take()?.speed.min(robot.drive.kicker?.speed_max);
        (robot.has_kicked, robot.kicked_at) = (true, Some(now));
        let heading = direction(robot.pose.heading);
        let change = heading * (speed - motion.velocity.dot(heading));
        let motion = BallMotion { velocity: motion.velocity + change, ..motion };
        let given = self.move_ball(ball, motion, now)?;
        let kick =
            Kick { robot: id, position: ball.position, velocity: motion.velocity, time: now };
        let gone = self.balls.iter_mut().find(|other| other.id == ball.id)?;
        gone.kick = Some(kick);
        Some((ball.id, given))
    }

    /// All that wait and have a ball now kick it, each ball once: the balls that go.
    fn fire_all(&mut self, discs: &[Disc], now: f64) -> Vec<(DiscId, DVec2)> {
        let mut gone: Vec<(DiscId, DVec2)> = Vec::new();
        for k in 0..self.robots.len() {
            let Robot { id, armed: Some(armed), .. } = self.robots[k] else { continue };
            if self.timeout > 0.0 && now - armed.since > self.timeout {
                self.robots[k].armed = None;
                continue;
            }
            let Some(ball) = self.in_mouth(id, discs) else { continue };
            if gone.iter().all(|(other, _)| *other != ball.id) {
                gone.extend(self.fire(id, &ball, now));
            }
        }
        gone
    }

    /// Takes a command; the velocity to be set at once, if the model is told its velocity.
    pub fn command(&mut self, id: DiscId, wanted: Wanted, now: f64) -> Option<DVec2> {
        let Some(robot) = self.robots.iter_mut().find(|robot| robot.id == id) else {
            return Some(wanted.linear);
        };
        (robot.wanted, robot.commanded_at) = (wanted, now);
        let is_told = robot.drive.model == Model::Told && robot.pulled_to.is_none();
        is_told.then_some(wanted.linear)
    }

    /// Takes note of what happened on the way.
    pub fn note(&mut self, contacts: &[Contact]) {
        self.balls.iter_mut().for_each(|ball| ball.note(contacts));
    }

    /// The next control tick up to a time, s, if there is anything to control.
    pub fn due(&mut self, now: f64, until: f64) -> Option<f64> {
        let idle = |robot: &Robot| {
            robot.drive.model == Model::Told
                && robot.pulled_to.is_none()
                && (self.timeout == 0.0 || robot.commanded_at == f64::INFINITY)
        };
        if self.balls.is_empty() && self.robots.iter().all(idle) {
            return None;
        }
        let next = self.next_after(now);
        (next <= until && next > now).then_some(next)
    }

    /// The next control tick, s; those that passed with nothing to control are left out.
    fn next_after(&mut self, now: f64) -> f64 {
        if self.next as f64 * self.tick <= now {
            self.next = (now / self.tick).floor() as u64 + 1;
            // The quotient may have been rounded down.
            self.next += u64::from(self.next as f64 * self.tick <= now);
        }
        self.next as f64 * self.tick
    }

    /// The velocities that pucks have from this tick on, of those whose velocity changes.
    pub fn follow(&mut self, now: f64, discs: &[Disc]) -> Vec<(DiscId, DVec2)> {
        self.next += 1;
        let next = self.next as f64 * self.tick;
        let kicked = self.fire_all(discs, now);
        let held = self.held(discs);
        let (tick, timeout) = (self.tick, self.timeout);
        let mut changed = Vec::new();
        let mut change = |disc: &Disc, velocity: DVec2| {
            if velocity != disc.velocity {
                changed.push((disc.id, velocity));
            }
        };
        let mut fronts = vec![Front::default(); held.len()];
        for disc in discs {
            let Some(robot) = self.robots.iter_mut().find(|robot| robot.id == disc.id) else {
                continue;
            };
            let before = direction(robot.pose.heading);
            let velocity = robot.next_velocity(disc, now, tick, timeout);
            change(disc, velocity);
            let own = held.iter().zip(&mut fronts).filter(|(held, _)| held.by == disc.id);
            for (held, front) in own {
                let reach = disc.radius + held.ball.radius + HOLD_GAP_M;
                let centre = disc.position + velocity * (next - now);
                front.now = disc.position + before * reach;
                front.next = centre + direction(robot.pose.heading) * reach;
            }
        }
        for ball in &mut self.balls {
            let Some(disc) = discs.iter().find(|disc| disc.id == ball.id) else { continue };
            let kicked = kicked.iter().find(|(id, _)| *id == ball.id);
            let holder = held.iter().zip(&fronts).find(|(held, _)| held.ball.id == ball.id);
            let velocity = match (kicked, ball.pulled_to, holder) {
                (Some((_, velocity)), _, _) => *velocity,
                (None, Some(to), _) => ball.hold(disc, &Front::fixed(to), PULL_MPS2, now, next),
                (None, None, Some((held, front))) => ball.hold(disc, front, held.grip, now, next),
                (None, None, None) => ball.follow(disc, now, next),
            };
            change(disc, velocity);
        }
        changed
    }

    /// Who holds which ball in the coming tick.
    fn held(&mut self, discs: &[Disc]) -> Vec<Held> {
        let mut all: Vec<Held> = Vec::new();
        for k in 0..self.robots.len() {
            let Robot { id: by, drive, dribbles, has_kicked, .. } = self.robots[k];
            if !dribbles && !has_kicked {
                continue;
            }
            let ball = self.in_mouth(by, discs);
            self.robots[k].has_kicked &= ball.is_some();
            let grip = drive.kicker.map_or(0.0, |kicker| kicker.grip);
            let holds = dribbles && !has_kicked && grip > 0.0;
            let Some(ball) = ball.filter(|_| holds) else { continue };
            let is_free = all.iter().all(|held| held.ball.id != ball.id);
            if is_free {
                all.push(Held { by, ball, grip });
            }
        }
        all
    }
}

/// A ball that a robot holds.
struct Held {
    by: DiscId,
    ball: Disc,
    /// m/s^2
    grip: f64,
}

impl Robot {
    /// The gap between the robot and a ball, m, if that is in its mouth.
    fn gap_in_mouth(&self, own: &Disc, ball: &Disc) -> Option<f64> {
        let kicker = self.drive.kicker?;
        let seen = ball.position - own.position;
        let distance = seen.length();
        let gap = distance - own.radius - ball.radius;
        let ahead = seen.dot(direction(self.pose.heading));
        let is_there = gap <= kicker.reach
            && ahead >= distance * libm::cos(kicker.half_angle.min(std::f64::consts::PI));
        is_there.then_some(gap)
    }

    fn next_velocity(&mut self, disc: &Disc, now: f64, tick: f64, timeout: f64) -> DVec2 {
        let own = self.own_velocity(disc.velocity, now, tick, timeout);
        self.pulled_to.map_or(own, |to| {
            drawn(disc.velocity, disc.position, &Front::fixed(to), PULL_MPS2, tick)
        })
    }

    /// What its drive makes of its command.
    fn own_velocity(&mut self, velocity: DVec2, now: f64, tick: f64, timeout: f64) -> DVec2 {
        let is_over = timeout > 0.0 && now - self.commanded_at > timeout;
        if is_over {
            (self.wanted, self.commanded_at) = (Wanted::default(), f64::INFINITY);
            self.dribbles = false;
        }
        let Drive { model, speed_max, acceleration_max, braking_max, .. } = self.drive;
        if model == Model::Told {
            return if is_over { DVec2::ZERO } else { velocity };
        }
        self.turn(tick);
        // Straight on at the mean heading of the tick: an arc to second order.
        let half = 0.5 * self.pose.turn * tick;
        let heading = direction(self.pose.heading + half);
        self.pose.heading = wrapped(self.pose.heading + 2.0 * half);
        let Wanted { linear, frame, .. } = self.wanted;
        let asked = match (model, frame) {
            (Model::Differential, Frame::Own) => heading * linear.x,
            (Model::Differential, Frame::Arena) => heading * heading.dot(linear),
            (Model::Told | Model::Holonomic, Frame::Own) => heading.rotate(linear),
            (Model::Told | Model::Holonomic, Frame::Arena) => linear,
        };
        let difference = asked.clamp_length_max(speed_max) - velocity;
        let most = match braking_max {
            Some(braking) if difference.dot(velocity) < 0.0 => braking,
            _ => acceleration_max,
        };
        velocity + difference.clamp_length_max(most * tick)
    }

    /// Brings the turning rate nearer to what is asked.
    fn turn(&mut self, tick: f64) {
        let Drive { turn_max, turn_acceleration_max, turn_braking_max, .. } = self.drive;
        let difference = self.wanted.angular.clamp(-turn_max, turn_max) - self.pose.turn;
        let most = match turn_braking_max {
            Some(braking) if difference * self.pose.turn < 0.0 => braking,
            _ => turn_acceleration_max,
        };
        self.pose.turn += difference.clamp(-most * tick, most * tick);
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
