//! The law for a disc and a line segment: the part of the velocity towards its nearest point turns
//! round.
//!
//! A segment is a body of infinite mass at rest. No unit normal is formed, so none is rounded: with
//! `m` towards it the change is `-(1 + e) (v.m / m^2) m`, and energy stays.

use glam::DVec2;

use super::wall::Bounce;
use crate::detect::segment::Near;
use crate::exact::{DoubleDouble, DoubleDoubleVec};
use crate::world::{Contact, Disc, Partner};

/// What a segment does to a disc.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Change of the velocity, m/s.
    pub change: DoubleDoubleVec,
    /// Unit normal from the disc to the segment.
    pub normal: DVec2,
    /// The rest.
    pub bounce: Bounce,
}

/// Turns a disc round; `None` when it does not approach. `velocity` is that of the disc, to all its
/// digits. A disc of infinite mass is turned too, as [`super::wall::bounce`] does.
pub fn turn(
    disc: &Disc,
    velocity: &DoubleDoubleVec,
    near: &Near,
    restitution: f64,
) -> Option<Turn> {
    let towards = near.towards;
    let along = towards.dot(*velocity);
    if along.value() <= 0.0 {
        return None;
    }
    let factor = along.over(towards.length_squared()).times(DoubleDouble::sum(1.0, restitution));
    let change = towards.times(factor).scaled(-1.0);
    let length = towards.hi().length();
    let approach_speed = along.value() / length;
    let mass = if disc.mass.is_finite() { disc.mass } else { 0.0 };
    let loss = (1.0 - restitution) * (1.0 + restitution);
    let bounce = Bounce {
        velocity: velocity.plus(change).hi(),
        approach_speed,
        impulse: mass * (1.0 + restitution) * approach_speed,
        energy_loss: 0.5 * mass * loss * approach_speed * approach_speed,
    };
    Some(Turn { change, normal: towards.hi() / length, bounce })
}

/// The record of it; `segment` is its place among all.
pub fn segment_contact(disc: &Disc, segment: u32, gap: f64, turn: &Turn, time: f64) -> Contact {
    Contact {
        a: disc.id,
        b: Partner::Segment(segment),
        point: disc.position + turn.normal * disc.radius,
        normal: turn.normal,
        gap,
        approach_speed: turn.bounce.approach_speed,
        impulse: turn.bounce.impulse,
        energy_loss: turn.bounce.energy_loss,
        time,
    }
}
