//! When will a disc touch a line segment? Its face from either side, or one of its ends.
//!
//! With `a` from one end to the other, `p` the disc's centre seen from the first, the face is
//! touched when `|a x p| = |a| r`, which is linear in time; it counts where the foot `a.p` then
//! lies between 0 and `a^2`. An end is a disc of radius 0 that stands. Both from double-double, so
//! that a time is right to a few u of itself however near the contact is.
//!
//! What of a disc touches already and does not approach is no contact, whatever the distance: a
//! segment is convex, so what leaves it never comes back. Nor does the end of a face along which a
//! disc slides, that lies deeper by rounding, stand in its way. A centre exactly on the line has no
//! normal to it and passes.

use glam::DVec2;

use super::precise::{Sight, pair_impact};
use crate::exact::{DoubleDouble, DoubleDoubleVec, UNIT_ROUNDOFF};
use crate::world::{Segment, Segments};

/// A segment, prepared.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Its ends.
    pub segment: Segment,
    /// From one end to the other, m.
    along: DoubleDoubleVec,
    /// The square of that, m^2.
    along2: DoubleDouble,
    /// Its length, m.
    length: DoubleDouble,
    /// From one end to the other, of length 1 to rounding.
    direction: DVec2,
}

/// What rounding may make of a length or a speed that was computed in plain doubles, in parts of
/// the coordinates that it came from; and of a radius.
const DOUBT: (f64, f64) = (1e-14, 1e-9);

/// What of a segment is nearest to a disc.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Towards the segment, of any length: the normal; 0 where there is none.
    pub towards: DoubleDoubleVec,
    /// Distance of the disc's surface, m.
    pub gap: f64,
    /// Whether it is an end.
    pub is_end: bool,
}

impl Edge {
    /// All segments of an arena, prepared.
    pub fn all(segments: Option<&Segments>) -> Vec<Self> {
        segments.map_or(&[][..], Segments::all).iter().map(|segment| Self::new(*segment)).collect()
    }

    /// Of a segment.
    pub fn new(segment: Segment) -> Self {
        let Segment { from, to } = segment;
        let along = DoubleDoubleVec {
            x: DoubleDouble::sum(to.x, -from.x),
            y: DoubleDouble::sum(to.y, -from.y),
        };
        let along2 = along.length_squared();
        let length = root(along2);
        Self { segment, along, along2, length, direction: along.hi() / length.value() }
    }

    /// Whether a disc could touch it within `horizon` seconds: cheap, and never wrongly `false`.
    ///
    /// It must come as near as its radius to the line, and beside the segment on the way.
    #[inline]
    pub fn may_touch_within(
        &self,
        position: DVec2,
        velocity: DVec2,
        radius: f64,
        horizon: f64,
    ) -> bool {
        let (from, direction) = (self.segment.from, self.direction);
        let seen = position - from;
        let size = position.abs() + from.abs();
        let reach = radius + DOUBT.1 * radius + DOUBT.0 * (size.x + size.y);
        let speed_doubt = DOUBT.0 * (velocity.x.abs() + velocity.y.abs());
        let (above, rise) = (direction.perp_dot(seen), direction.perp_dot(velocity));
        let closing = if above < 0.0 { rise } else { -rise } + speed_doubt;
        let left = above.abs() - reach;
        if left > 0.0 && left > closing * horizon {
            return false;
        }
        let (foot, run) = (direction.dot(seen), direction.dot(velocity));
        // Without speed and end both are no numbers, which no bound excludes.
        let last = foot + (run + speed_doubt).max(0.0) * horizon;
        let first = foot + (run - speed_doubt).min(0.0) * horizon;
        !(first > self.length.value() + reach || last < -reach)
    }

    /// Time until a disc touches it, s from now; 0 = it does and approaches; `None` = never.
    pub fn impact(
        &self,
        position: &DoubleDoubleVec,
        velocity: &DoubleDoubleVec,
        radius: f64,
    ) -> Option<f64> {
        let near = self.near(position, radius);
        if near.gap <= 0.0 {
            return (near.towards.dot(*velocity).value() > 0.0).then_some(0.0);
        }
        if let Some(time) = self.face_impact(position, velocity, radius) {
            return Some(time);
        }
        let end = |end: DVec2| {
            let sight = Sight {
                d: position.plus_double(-end).scaled(-1.0),
                w: velocity.scaled(-1.0),
                reach: radius.into(),
            };
            pair_impact(&sight)
        };
        match (end(self.segment.from), end(self.segment.to)) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    fn face_impact(
        &self,
        position: &DoubleDoubleVec,
        velocity: &DoubleDoubleVec,
        radius: f64,
    ) -> Option<f64> {
        let seen = position.plus_double(-self.segment.from);
        let (above, speed) = (self.along.cross(seen), self.along.cross(*velocity));
        // Seen from the side on which it is.
        let side = if above.value() < 0.0 { -1.0 } else { 1.0 };
        let (above, speed) = (above.scaled(side), speed.scaled(side));
        if above.value() == 0.0 || speed.value() >= 0.0 {
            return None;
        }
        let left = above.minus(self.length.times_double(radius));
        let time = if left.value() > 0.0 { left.over(speed.negated()).value() } else { 0.0 };
        let foot = self.along.dot(seen.plus(velocity.times_double(time)));
        let is_beside = foot.value() >= 0.0 && self.along2.minus(foot).value() >= 0.0;
        is_beside.then_some(time)
    }

    /// Whether a disc approaches what of it is nearest by more than the rounding of its velocity:
    /// one that touches it and does not creeps by some 1e-16 of its way instead of meeting it
    /// again and again.
    pub fn is_approached(&self, position: DVec2, velocity: DVec2, radius: f64) -> bool {
        let towards = self.near(&position.into(), radius).towards.hi();
        towards.dot(velocity) > 4.0 * UNIT_ROUNDOFF * velocity.length() * towards.length()
    }

    /// What of it is nearest to a disc.
    pub fn near(&self, position: &DoubleDoubleVec, radius: f64) -> Near {
        let seen = position.plus_double(-self.segment.from);
        let foot = self.along.dot(seen);
        let Segment { from, to } = self.segment;
        let end = match foot.value() {
            foot if foot < 0.0 => Some(from),
            _ if self.along2.minus(foot).value() < 0.0 => Some(to),
            _ => None,
        };
        if let Some(end) = end {
            let towards = position.plus_double(-end).scaled(-1.0);
            let distance2 = towards.length_squared();
            let gap = distance2.minus(DoubleDouble::product(radius, radius)).value()
                / (towards.hi().length() + radius);
            return Near { towards, gap, is_end: true };
        }
        let above = self.along.cross(seen);
        let side = match above.value() {
            above if above < 0.0 => -1.0,
            above if above > 0.0 => 1.0,
            _ => 0.0,
        };
        let towards = DoubleDoubleVec { x: self.along.y, y: self.along.x.negated() }.scaled(side);
        let left = above.scaled(side).minus(self.length.times_double(radius));
        Near { towards, gap: left.over(self.length).value(), is_end: false }
    }
}

/// The root of a number above 0, to about 2^-105.
fn root(x: DoubleDouble) -> DoubleDouble {
    let first = x.value().sqrt();
    let rest = x.minus(DoubleDouble::product(first, first)).value();
    DoubleDouble::sum(first, rest / (2.0 * first))
}
