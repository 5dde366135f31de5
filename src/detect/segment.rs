//! When will a disc touch a line segment? Its face from either side, or one of its ends.
//!
//! With `a` from one end to the other, `p` the disc's centre seen from the first, the face is
//! touched when `|a x p| = |a| r`, which is linear in time; it counts where the foot `a.p` then
//! lies between 0 and `a^2`. An end is a disc of radius 0 that stands. Both from double-double, so
//! that a time is right to a few u of itself however near the contact is.
//!
//! What of a disc touches already and does not approach is no contact, whatever the distance. A
//! centre exactly on the line has no normal to it and passes.

use glam::DVec2;

use super::precise::{Sight, pair_impact};
use crate::exact::{DoubleDouble, DoubleDoubleVec};
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
}

/// What of a segment is nearest to a disc.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// Towards the segment, of any length: the normal.
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
        Self { segment, along, along2, length: root(along2) }
    }

    /// Time until a disc touches it, s from now; 0 = it does and approaches; `None` = never.
    pub fn impact(
        &self,
        position: &DoubleDoubleVec,
        velocity: &DoubleDoubleVec,
        radius: f64,
    ) -> Option<f64> {
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
        let side = if above.value() < 0.0 { -1.0 } else { 1.0 };
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
