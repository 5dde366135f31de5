//! How wrong the recorded numbers are by themselves: format, stamps, measurement.
//!
//! The noise is measured where nothing happened: the lower quartile of what velocities and
//! positions do beyond free motion, of which contacts are the upper part. What was stored as f32 is
//! known to no more than f32. Stamps are whole nanoseconds: of a period that is none, positions and
//! velocities are of another instant than they say.

use glam::DVec2;

use super::Frame;
use super::flight::{Means, Span};
use super::law::Law;
use crate::world::Disc;

/// The length that a quarter of two-dimensional Gaussian vectors do not reach, over the deviation
/// of one component: `sqrt(-2 ln 0.75)`.
const QUARTER: f64 = 0.758_527_5;

/// Error of a stamp, s: it is rounded to a nanosecond.
pub(super) const STAMP_S: f64 = 0.5e-9;

/// Relative error of a number stored in 4 and in 8 bytes, with a few operations of its program.
const FORMATS: (f64, f64) = (6e-8, 4.5e-16);

/// Changes from which noise is measured: of fewer the lower quartile may be a contact.
const CHANGES_MIN: usize = 4;

/// Deviations of one component of what is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Of a position, m.
    pub position: f64,
    /// Of a velocity, m/s.
    pub velocity: f64,
    /// Whether all numbers fit 4 bytes.
    pub single: bool,
}

/// The same of one disc between two samples, with its format and its stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sigma {
    /// m
    pub position: f64,
    /// m/s
    pub velocity: f64,
}

impl Sigma {
    /// Of a difference of two velocities.
    pub fn of_change(self) -> f64 {
        std::f64::consts::SQRT_2 * self.velocity
    }

    /// Of a position against what an earlier one foretells.
    pub fn of_rest(self, length: f64) -> f64 {
        (std::f64::consts::SQRT_2 * self.position).hypot(self.velocity * length)
    }
}

impl Noise {
    /// None at all but that of the format.
    pub const NONE: Self = Self { position: 0.0, velocity: 0.0, single: false };

    /// Errors of a disc that is recorded at two samples, under this acceleration, m/s^2.
    pub(super) fn of(&self, before: &Disc, after: &Disc, acceleration: f64) -> Sigma {
        let format = if self.single { FORMATS.0 } else { FORMATS.1 };
        let largest = |a: DVec2, b: DVec2| a.abs().max(b.abs()).max_element();
        let place = largest(before.position, after.position);
        let speed = largest(before.velocity, after.velocity);
        let rounding = format * place + STAMP_S * speed;
        let position = self.position.max(rounding);
        let velocity = self.velocity.max(format * speed + STAMP_S * acceleration);
        Sigma { position, velocity }
    }

    /// Measures it on the first frames, under this law.
    pub(super) fn measure(frames: &[Frame], law: &Law) -> Self {
        let single = frames.iter().flat_map(|frame| &frame.discs).all(fits_4_bytes);
        let none = Self { position: 0.0, velocity: 0.0, single };
        let (mut changes, mut rests) = (Vec::new(), Vec::new());
        let mut lengths = Vec::new();
        for (before, after, seconds) in super::steps(frames) {
            let span = Span::new(seconds, law.drag);
            let means = Means { law, noise: &none, fastest: f64::INFINITY };
            for (before, after) in super::alike(before, after) {
                let flight = means.flight(before, after, &span);
                changes.push(flight.change.length());
                rests.push(flight.rest.length());
            }
            lengths.push(span.length);
        }
        if changes.len() < CHANGES_MIN {
            return none;
        }
        let root2 = std::f64::consts::SQRT_2;
        let velocity = quartile(&mut changes) / (QUARTER * root2);
        let length = median(&mut lengths);
        let rest = quartile(&mut rests) / QUARTER;
        let position = (rest * rest - (velocity * length).powi(2)).max(0.0).sqrt() / root2;
        Self { position, velocity, single }
    }
}

fn fits_4_bytes(disc: &Disc) -> bool {
    let Disc { position, velocity, .. } = disc;
    let all = [position.x, position.y, velocity.x, velocity.y];
    all.into_iter().all(|value| f64::from(value as f32) == value)
}

/// The value that a quarter do not exceed; 0 of none.
fn quartile(values: &mut [f64]) -> f64 {
    order_statistic(values, values.len() / 4)
}

/// The middle value; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    order_statistic(values, values.len() / 2)
}

fn order_statistic(values: &mut [f64], place: usize) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}
