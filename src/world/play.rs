//! What robots are asked to do with a ball, and with themselves: commands carried out at once.
//!
//! Numbers are looked at here, whoever sends them. Never decide here how a robot follows a velocity
//! or a ball slows down.

use glam::DVec2;

use super::ball::BallMotion;
use super::command::{Command, NotDone};
use super::disc::{Defect, Disc, DiscId};
use super::drives::{Drive, Drives};
use super::{Owner, limits};
use crate::motion::arena::Arena;

/// Carries out a command to a robot or a ball.
///
/// # Errors
/// [`NotDone`]; nothing is changed then.
pub(super) fn play(
    drives: &mut Drives,
    arena: &mut Arena,
    command: &Command,
) -> Result<(), NotDone> {
    let done = |is_robot: bool, id| if is_robot { Ok(()) } else { Err(NotDone::NotDriven(id)) };
    match *command {
        Command::Kick { id, speed } => {
            let speed = sound("speed", speed, "0 to 1e60 m/s", |speed| speed >= 0.0)?;
            done(drives.pose(id).is_some(), id)?;
            let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
            if let Some((ball, velocity)) = drives.kick(id, speed, &discs, arena.now()) {
                arena.set_velocity(ball, velocity);
            }
            Ok(())
        }
        Command::Dribble { id, on } => done(drives.dribble(id, on), id),
        Command::Pull { id, to } => {
            for value in to.iter().flat_map(|to| to.to_array()) {
                sound("to", value, "finite, up to 1e60 m", |_| true)?;
            }
            done(drives.pull(id, to), id)
        }
        Command::Turn { id, heading, turn } => {
            let heading = sound("heading", heading, "a finite number", |_| true)?;
            let turn = sound("turn", turn, "a finite number", |_| true)?;
            done(drives.set_pose(id, heading, turn), id)
        }
        Command::SetDrive { id, drive } => {
            drive.defect().map_or(Ok(()), |defect| Err(NotDone::Defect(defect)))?;
            done(drives.set_drive(id, drive), id)
        }
        Command::Roll { id } => {
            let disc = arena.disc(id).ok_or(NotDone::Unknown(id))?;
            let now = arena.now();
            let motion = drives.motion(&disc, now).ok_or(NotDone::NoBall(id))?;
            let motion = BallMotion::rolling(motion.velocity);
            let velocity = drives.move_ball(&disc, motion, now);
            velocity.into_iter().for_each(|velocity| arena.set_velocity(id, velocity));
            Ok(())
        }
        // Whoever calls has looked.
        _ => Ok(()),
    }
}

impl Drives {
    /// A puck that was given a velocity flies as a ball does, if it is one: with this spin, or the
    /// one it has.
    pub(super) fn let_go(&mut self, arena: &mut Arena, id: DiscId, spin: Option<DVec2>) {
        if !self.is_ball(id) {
            return;
        }
        let Some(disc) = arena.disc(id) else { return };
        let now = arena.now();
        let spin = spin.or_else(|| self.motion(&disc, now).map(|motion| motion.spin));
        let motion = BallMotion { velocity: disc.velocity, spin: spin.unwrap_or_default() };
        let velocity = self.move_ball(&disc, motion, now);
        velocity.into_iter().for_each(|velocity| arena.set_velocity(id, velocity));
    }
}

impl Drive {
    /// The first thing wrong with its numbers, if any.
    pub fn defect(&self) -> Option<Defect> {
        let limits = [
            ("speed_max", self.speed_max),
            ("acceleration_max", self.acceleration_max),
            ("braking_max", self.braking_max.unwrap_or(1.0)),
            ("turn_max", self.turn_max),
            ("turn_acceleration_max", self.turn_acceleration_max),
            ("turn_braking_max", self.turn_braking_max.unwrap_or(1.0)),
            ("kick_speed_max", self.kicker.map_or(1.0, |kicker| kicker.speed_max)),
        ];
        let wrong = limits.into_iter().find(|(_, value)| value.is_nan() || *value <= 0.0);
        if let Some((field, value)) = wrong {
            return Some(Defect { field, value, wanted: "above 0" });
        }
        let kicker = self.kicker?;
        let from_0 =
            [("half_angle", kicker.half_angle), ("reach", kicker.reach), ("grip", kicker.grip)];
        let wrong = from_0.into_iter().find(|(_, value)| value.is_nan() || *value < 0.0);
        wrong.map(|(field, value)| Defect { field, value, wanted: "0 or more" })
    }
}

/// A number that is finite, not beyond the limits, and right.
fn sound(
    field: &'static str,
    value: f64,
    wanted: &'static str,
    is_right: impl Fn(f64) -> bool,
) -> Result<f64, NotDone> {
    if value.abs() <= limits::SIZE_MAX && is_right(value) {
        return Ok(value);
    }
    Err(NotDone::Defect(Defect { field, value, wanted }))
}
