//! The periodic box: what leaves it on one side comes in on the other.
//!
//! Never decide here how long an image stays the nearest: that is prediction.

use glam::DVec2;

/// An axis-parallel box that repeats without end; wider and higher than twice the largest reach
/// (sum of two radii), so that a pair touches in one image at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// Lower left corner, m.
    pub min: DVec2,
    /// Upper right corner, m.
    pub max: DVec2,
}

impl Periodic {
    /// Width and height, m.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// The image of a place that lies in the box; the same bits if it does already.
    pub fn inside(&self, position: DVec2) -> DVec2 {
        if position.cmpge(self.min).all() && position.cmplt(self.max).all() {
            return position;
        }
        position - self.size() * ((position - self.min) / self.size()).floor()
    }

    /// How much nearer two places may come, along each axis, before another image than the nearest
    /// can be in reach, m: at first another is at least half a box away on one axis. The margin is
    /// rounding; what is too wide for the box may be missed.
    pub fn room(&self, reach: f64) -> DVec2 {
        let half = 0.5 * self.size();
        // Below what boxes leave that are wide enough for their pucks.
        (half - reach).max(half / 8192.0) * (1.0 - 1e-9)
    }

    /// What brings a difference of two places to that of the nearest images: whole boxes.
    pub fn shift(&self, difference: DVec2) -> DVec2 {
        // Adding this rounds to whole numbers, far quicker than a call does.
        const WHOLE: DVec2 = DVec2::splat(1.5 * (1u64 << 52) as f64);
        -self.size() * ((difference / self.size() + WHOLE) - WHOLE)
    }
}
