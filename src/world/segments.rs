//! Line segments that discs bounce off: the walls of a field, goals, posts.
//!
//! A disc meets a face from either side, or an end, which is a fixed point. Where four of them are
//! exactly a box, the box is enough: it costs less. Never decide here when one is hit: that is
//! detection.

use std::fmt;

use glam::DVec2;

use super::disc::Disc;
use super::limits;
use super::walls::Walls;

/// A straight piece of a boundary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Segment {
    /// One end, m.
    pub from: DVec2,
    /// The other end, m.
    pub to: DVec2,
}

impl Segment {
    /// The point of it that is nearest to a place, m, to rounding.
    pub fn nearest(&self, place: DVec2) -> DVec2 {
        let along = self.to - self.from;
        let part = (place - self.from).dot(along) / along.length_squared();
        match part {
            part if part <= 0.0 => self.from,
            part if part >= 1.0 => self.to,
            part => self.from + along * part,
        }
    }

    /// Distance of a place from it, m, to rounding.
    pub fn distance(&self, place: DVec2) -> f64 {
        self.nearest(place).distance(place)
    }
}

/// Why segments are refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BadSegment {
    /// There are more than fit.
    #[error("at most {} segments", limits::SEGMENTS)]
    TooMany,
    /// A segment without a direction, or with one that is no number or too large.
    #[error("segment {0}: two different points, finite and up to 1e60 m")]
    NoLine(usize),
}

/// All segments of an arena.
#[derive(Clone, Copy, PartialEq)]
pub struct Segments {
    all: [Segment; limits::SEGMENTS],
    count: usize,
    /// Restitution of a contact with them, 0 to 1.
    pub restitution: f64,
}

impl fmt::Debug for Segments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { restitution, .. } = self;
        let mut debug = f.debug_struct("Segments");
        debug.field("all", &self.all()).field("restitution", restitution).finish()
    }
}

impl Segments {
    /// These.
    ///
    /// # Errors
    /// [`BadSegment`].
    pub fn new(segments: &[Segment], restitution: f64) -> Result<Self, BadSegment> {
        if segments.len() > limits::SEGMENTS {
            return Err(BadSegment::TooMany);
        }
        let good = |segment: &Segment| {
            let size = segment.from.abs().max(segment.to.abs());
            // What is so short beside its place has no direction.
            let length = segment.from.distance(segment.to);
            let least = limits::SIZE_MIN.max(1e-9 * size.max_element());
            size.cmple(DVec2::splat(limits::SIZE_MAX)).all() && length > least
        };
        if let Some(bad) = segments.iter().position(|segment| !good(segment)) {
            return Err(BadSegment::NoLine(bad));
        }
        let mut all = [Segment::default(); limits::SEGMENTS];
        all[..segments.len()].copy_from_slice(segments);
        Ok(Self { all, count: segments.len(), restitution })
    }

    /// Each of them; contacts name them by their place here.
    pub fn all(&self) -> &[Segment] {
        &self.all[..self.count]
    }

    /// The box that they are, if they are exactly one: four axis-parallel sides that close.
    pub fn as_box(&self) -> Option<Walls> {
        let [a, b, c, d] = self.all() else { return None };
        let ends = [a, b, c, d].map(|segment| [segment.from, segment.to]);
        let corners = ends.as_flattened();
        let min = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let max = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let (a, c) = (DVec2::new(max.x, min.y), DVec2::new(min.x, max.y));
        let is_side = |[from, to]: [DVec2; 2]| {
            ends.iter().any(|end| *end == [from, to] || *end == [to, from])
        };
        let all = [[min, a], [a, max], [max, c], [c, min]].into_iter().all(is_side);
        all.then_some(Walls { min, max, restitution: self.restitution })
    }

    /// Whether every line closes: at each end as many come as go.
    fn is_closed(&self) -> bool {
        let ends = || self.all().iter().flat_map(|segment| [segment.from, segment.to]);
        ends().all(|end| ends().filter(|other| *other == end).count() % 2 == 0)
    }

    /// Whether a disc may stand there: it overlaps none of them by more than rounding; and where
    /// all lines close it is within them, or, where a box is around them too, outside of them.
    pub fn contain(&self, position: DVec2, radius: f64, is_walled: bool) -> bool {
        let least = radius * (1.0 - limits::OVERLAP_OF_ROUNDING);
        if self.all().iter().any(|segment| segment.distance(position) < least) {
            return false;
        }
        let crossed = |segment: &&Segment| {
            let Segment { from, to } = **segment;
            let part = (position.y - from.y) / (to.y - from.y);
            (from.y > position.y) != (to.y > position.y)
                && position.x < from.x + (to.x - from.x) * part
        };
        let is_within = self.all().iter().filter(crossed).count() % 2 == 1;
        !self.is_closed() || is_within != is_walled
    }

    /// Whether a disc overlaps one of them or lies where none may.
    pub(crate) fn refuse(&self, disc: &Disc, walls: Option<&Walls>) -> bool {
        let is_walled = walls.is_some_and(|walls| *walls != Walls::FAR_AWAY);
        !self.contain(disc.position, disc.radius, is_walled)
    }
}
