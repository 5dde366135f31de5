//! Receive: messages become reports and commands, or a refusal that names what is wrong.
//!
//! A message with some bad circles keeps the good ones. What is refused is counted by its
//! [`Cause`]. Nothing here changes the world.

mod cause;

use std::collections::HashMap;

use glam::DVec2;

use crate::messages::{CircleState, CircleStates, Contact, Twist};
use crate::world::{Defect, Disc, DiscId, Report, limits};

pub use cause::{Cause, Refused};

/// Why a circle of a message is not taken.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BadCircle {
    /// A number is not finite or out of range.
    #[error(transparent)]
    Defect(#[from] Defect),
    /// Two or more circles of one message have the same id: none of them can be trusted.
    #[error("duplicate id: {count} circles of the message have it, none is taken")]
    Duplicate {
        /// How many.
        count: u32,
    },
    /// The id stands for a wall.
    #[error("the id {} stands for a wall", Contact::WALL)]
    Wall,
}

/// A message with more circles than are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} circles in one message, at most {max}; send parts", max = limits::CIRCLES_PER_MESSAGE)]
pub struct TooManyCircles(pub usize);

/// The good circles of a message as a report, and the bad ones, each id once.
///
/// # Errors
/// [`TooManyCircles`]: the whole message is refused.
pub fn report(
    message: &CircleStates,
) -> Result<(Report, Vec<(DiscId, BadCircle)>), TooManyCircles> {
    if message.circles.len() > limits::CIRCLES_PER_MESSAGE {
        return Err(TooManyCircles(message.circles.len()));
    }
    let mut report = Report { time: message.header.stamp.as_seconds(), ..Report::default() };
    report.discs.reserve(message.circles.len());
    let mut bad = Vec::new();
    let mut duplicates = duplicates(&message.circles);
    for circle in &message.circles {
        // Each id with twins is named once, at its first circle.
        match duplicates.get_mut(&circle.id).map(std::mem::take) {
            None => match disc(circle) {
                Ok(disc) => report.discs.push(disc),
                Err(reason) => bad.push((circle.id, reason)),
            },
            Some(0) => {}
            Some(count) => bad.push((circle.id, BadCircle::Duplicate { count })),
        }
    }
    Ok((report, bad))
}

/// The ids that stand more than once, and how often.
fn duplicates(circles: &[CircleState]) -> HashMap<DiscId, u32> {
    // The usual message has ascending ids.
    if circles.is_sorted_by(|a, b| a.id < b.id) {
        return HashMap::new();
    }
    let mut counts: HashMap<DiscId, u32> = HashMap::with_capacity(circles.len());
    for circle in circles {
        *counts.entry(circle.id).or_default() += 1;
    }
    counts.retain(|_, count| *count > 1);
    counts
}

fn disc(circle: &CircleState) -> Result<Disc, BadCircle> {
    if circle.id == Contact::WALL {
        return Err(BadCircle::Wall);
    }
    let disc = Disc {
        id: circle.id,
        position: DVec2::new(circle.x, circle.y),
        velocity: DVec2::new(circle.vx, circle.vy),
        radius: circle.radius,
        mass: circle.mass,
    };
    disc.refusal().map_or(Ok(disc), |defect| Err(defect.into()))
}

/// The velocity that a Twist asks for, m/s in the frame of the arena.
///
/// # Errors
/// [`Defect`] when it is not finite.
pub fn velocity(twist: &Twist) -> Result<DVec2, Defect> {
    for (field, value) in [("linear.x", twist.linear.x), ("linear.y", twist.linear.y)] {
        if !value.is_finite() {
            return Err(Defect { field, value, wanted: "a finite number" });
        }
        if value.abs() > limits::SIZE_MAX {
            return Err(Defect { field, value, wanted: "1e60 at most" });
        }
    }
    Ok(DVec2::new(twist.linear.x, twist.linear.y))
}
