//! The law for two discs, or a disc and a wall, in double-double: for an arena that carries its
//! states so.
//!
//! With `B = d.w` the change of velocity is `fa (1 + e) (B / d^2) d`: no unit normal is formed, so
//! none is rounded, and energy and momentum are kept to 2^-100. Cf. [`super::pair`], its judge.

use glam::DVec2;

use super::pair::{Fraction, Impact, MassFractions};
use crate::exact::{DoubleDouble, DoubleDoubleVec, power_of_two_near};
use crate::world::{Disc, Side};

/// What a contact changes in each of two discs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kicks {
    /// Change of the velocity of a, m/s.
    pub a: DoubleDoubleVec,
    /// Change of the velocity of b, m/s.
    pub b: DoubleDoubleVec,
    /// The record, in doubles.
    pub impact: Impact,
}

/// Collides two discs that touch: `d` is b seen from a, `closing` is `d.w` of their relative
/// velocity. `None` when they do not approach, when neither can change, or without a normal.
///
/// Of the discs only masses and rounded velocities are used.
pub fn collide(
    (a, b): (&Disc, &Disc),
    d: &DoubleDoubleVec,
    closing: DoubleDouble,
    restitution: f64,
) -> Option<Kicks> {
    let fixed = a.mass.is_infinite() && b.mass.is_infinite();
    if fixed || closing.value() >= 0.0 || d.hi() == DVec2::ZERO {
        return None;
    }
    // Exact scaling, so that the square of the distance is in range.
    let unit = power_of_two_near(d.hi().abs().max_element()).recip();
    let (d, closing) = (d.scaled(unit), closing.scaled(unit));
    let turn = closing.over(d.length_squared()).times(DoubleDouble::sum(1.0, restitution));
    let fractions = MassFractions::of(a.mass, b.mass);
    let kick =
        |fraction: Fraction| d.times(turn.times(DoubleDouble { hi: fraction.hi, lo: fraction.lo }));
    let (kick_a, kick_b) = (kick(fractions.a), kick(fractions.b).scaled(-1.0));
    let distance = d.hi().length();
    let approach_speed = -closing.value() / distance;
    let reduced_mass =
        if a.mass.is_finite() { a.mass * fractions.a.hi } else { b.mass * fractions.b.hi };
    let loss = (1.0 - restitution) * (1.0 + restitution);
    let impact = Impact {
        normal: d.hi() / distance,
        approach_speed,
        velocity_a: a.velocity + kick_a.hi(),
        velocity_b: b.velocity + kick_b.hi(),
        impulse: reduced_mass * (1.0 + restitution) * approach_speed,
        energy_loss: 0.5 * reduced_mass * loss * approach_speed * approach_speed,
    };
    Some(Kicks { a: kick_a, b: kick_b, impact })
}

/// What a wall does to the velocity of a disc that moves outwards: its change, m/s.
pub fn bounce(velocity: &DoubleDoubleVec, side: Side, restitution: f64) -> DoubleDoubleVec {
    let turned = DoubleDouble::sum(1.0, restitution).negated();
    match side {
        Side::Left | Side::Right => {
            DoubleDoubleVec { x: velocity.x.times(turned), ..DoubleDoubleVec::default() }
        }
        Side::Bottom | Side::Top => {
            DoubleDoubleVec { y: velocity.y.times(turned), ..DoubleDoubleVec::default() }
        }
    }
}
