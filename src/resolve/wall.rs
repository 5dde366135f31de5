//! The law for a disc and a wall: the part of the velocity along the normal turns round.
//!
//! A wall is a body of infinite mass at rest; its normal is an axis, so no digit is lost.

use glam::DVec2;

use crate::world::{Contact, Disc, Partner, Side, Walls};

/// What a wall contact changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// New velocity, m/s.
    pub velocity: DVec2,
    /// Speed of approach, m/s; above 0.
    pub approach_speed: f64,
    /// Impulse along the normal, N s.
    pub impulse: f64,
    /// Kinetic energy lost, J.
    pub energy_loss: f64,
}

/// Bounces a disc off a wall; `None` when it does not move outwards.
///
/// A disc of infinite mass is turned round too: it keeps its kinetic state, not its direction, or
/// it would leave the box. It exchanges no finite impulse; 0 is reported.
pub fn bounce(disc: &Disc, side: Side, restitution: f64) -> Option<Bounce> {
    let approach_speed = disc.velocity.dot(side.normal());
    if approach_speed <= 0.0 {
        return None;
    }
    let mut velocity = disc.velocity;
    match side {
        Side::Left | Side::Right => velocity.x *= -restitution,
        Side::Bottom | Side::Top => velocity.y *= -restitution,
    }
    let mass = if disc.mass.is_finite() { disc.mass } else { 0.0 };
    let loss = (1.0 - restitution) * (1.0 + restitution);
    Some(Bounce {
        velocity,
        approach_speed,
        impulse: mass * (1.0 + restitution) * approach_speed,
        energy_loss: 0.5 * mass * loss * approach_speed * approach_speed,
    })
}

/// The record of a bounce.
pub fn wall_contact(disc: &Disc, side: Side, walls: &Walls, bounce: &Bounce, time: f64) -> Contact {
    Contact {
        a: disc.id,
        b: Partner::Wall(side),
        point: disc.position + side.normal() * disc.radius,
        normal: side.normal(),
        gap: walls.gap(side, disc),
        approach_speed: bounce.approach_speed,
        impulse: bounce.impulse,
        energy_loss: bounce.energy_loss,
        time,
    }
}
