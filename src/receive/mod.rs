//! Receive: messages become reports and commands, or a refusal that names what is wrong.
//!
//! A message with some bad circles keeps the good ones. What is refused is counted by its
//! [`Cause`]. Nothing here changes the world.

mod cause;

use std::collections::HashMap;

use glam::DVec2;

use crate::messages::{CircleState, CircleStates, Contact, Odometry, Twist};
use crate::world::{Defect, Disc, DiscId, Frame, Report, Wanted, limits};

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

/// Where a robot is, by its odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Centre, m, in the frame of the odometry.
    pub position: DVec2,
    /// Velocity, m/s, in the same frame.
    pub velocity: DVec2,
    /// Where it looks at, rad, 0 along x, against the clock.
    pub heading: f64,
}

/// Where a robot is and how fast, in the frame of its odometry; its twist comes in its own.
///
/// # Errors
/// [`Defect`] of a number that is none.
pub fn standing(odom: &Odometry) -> Result<Standing, Defect> {
    let (pose, twist) = (&odom.pose.pose, &odom.twist.twist);
    let q = &pose.orientation;
    for (field, value) in [
        ("position.x", pose.position.x),
        ("position.y", pose.position.y),
        ("orientation.x", q.x),
        ("orientation.y", q.y),
        ("orientation.z", q.z),
        ("orientation.w", q.w),
        ("linear.x", twist.linear.x),
        ("linear.y", twist.linear.y),
    ] {
        if !value.is_finite() {
            return Err(Defect { field, value, wanted: "a finite number" });
        }
    }
    // The yaw of a rotation of any length; of none at all it is 0.
    let heading =
        (2.0 * (q.w * q.z + q.x * q.y)).atan2(q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z);
    let own = DVec2::new(twist.linear.x, twist.linear.y);
    let position = DVec2::new(pose.position.x, pose.position.y);
    Ok(Standing { position, velocity: DVec2::from_angle(heading).rotate(own), heading })
}

/// What a Twist asks a driven puck for; that it shall leave the plane is not heard.
///
/// # Errors
/// [`Defect`] when it is not finite.
pub fn wanted(twist: &Twist) -> Result<Wanted, Defect> {
    let Twist { linear, angular } = twist;
    for (field, value) in [("linear.x", linear.x), ("linear.y", linear.y), ("angular.z", angular.z)]
    {
        if !value.is_finite() {
            return Err(Defect { field, value, wanted: "a finite number" });
        }
        if value.abs() > limits::SIZE_MAX {
            return Err(Defect { field, value, wanted: "1e60 at most" });
        }
    }
    Ok(Wanted { linear: DVec2::new(linear.x, linear.y), angular: angular.z, frame: Frame::Own })
}
