//! When will two discs, or a disc and a wall, touch, from states in double-double?
//!
//! The formulas are those of [`super::impact`], and the inputs have the digits that make them
//! worth it: of two discs that follow each other slowly the gap is known to 2^-100 of their
//! coordinates, not to 2^-53. Costly, so [`Doubt`] sorts out first, in plain doubles and never
//! wrongly, whom nobody meets in time.
//!
//! An event's time is a double, its rounding an error of up to u epochs. [`time_to_contact`] tells
//! afterwards by how much it missed the contact, so that the contact can be resolved where it was.

use glam::DVec2;

use crate::exact::{DoubleDouble, DoubleDoubleVec, UNIT_ROUNDOFF, power_of_two_near};
use crate::world::{Side, Walls};

use super::impact::Hit;

/// Two discs as they see each other: what [`pair_impact`] needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Position of the second seen from the first, m.
    pub d: DoubleDoubleVec,
    /// Its relative velocity, m/s.
    pub w: DoubleDoubleVec,
    /// Sum of the radii, m.
    pub reach: DoubleDouble,
}

impl Sight {
    /// `d.w`, below 0 when the two approach, m^2/s.
    pub fn closing(&self) -> DoubleDouble {
        self.d.dot(self.w)
    }

    /// `d.d - s^2`, below 0 when they overlap, m^2.
    pub fn clearance(&self) -> DoubleDouble {
        self.d.length_squared().minus(self.reach.squared())
    }

    /// The same seen a little later.
    pub fn after(&self, time: f64) -> Self {
        Self { d: self.d.plus(self.w.times_double(time)), ..*self }
    }

    /// The same in units of powers of two that bring squares and products into range; with them.
    fn scaled(&self) -> (Self, f64, f64) {
        let size = |v: &DoubleDoubleVec| v.x.hi.abs().max(v.y.hi.abs());
        let length = power_of_two_near(size(&self.d).max(self.reach.hi));
        let speed = power_of_two_near(size(&self.w));
        let (by_length, by_speed) = (length.recip(), speed.recip());
        let (d, w) = (self.d.scaled(by_length), self.w.scaled(by_speed));
        (Self { d, w, reach: self.reach.scaled(by_length) }, length, speed)
    }
}

/// Time until two discs touch, s from now; 0 = they touch already and approach; `None` = never.
/// Right to a few u; for any size of lengths and speeds.
pub fn pair_impact(sight: &Sight) -> Option<f64> {
    let (sight, length, speed) = sight.scaled();
    let closing = sight.closing().value();
    if closing >= 0.0 {
        return None;
    }
    let clearance = sight.clearance().value();
    if clearance <= 0.0 {
        return Some(0.0);
    }
    let time = clearance / (discriminant(&sight)?.sqrt() - closing);
    // No step may leave the range of doubles unless the result does.
    let alike = (length > 1.0) == (speed > 1.0);
    Some(if alike { time * (length / speed) } else { time * length / speed })
}

/// `s^2 w^2 - (d x w)^2`, or `None` if it is negative: the paths pass each other.
fn discriminant(sight: &Sight) -> Option<f64> {
    let cross = sight.d.cross(sight.w);
    let (swept, passed) = (sight.reach.hi * sight.w.hi().length(), cross.hi.abs());
    let margin = swept - passed;
    if margin > 0.25 * swept {
        return Some(margin * (swept + passed));
    }
    if margin < -0.25 * swept {
        return None;
    }
    let swept2 = sight.reach.squared().times(sight.w.length_squared());
    let exact = swept2.minus(cross.squared()).value();
    (exact >= 0.0).then_some(exact)
}

/// Time until a clearance `C = d.d - s^2` has shrunk to 0, from `B = d.w < 0` and `w^2 / -B`;
/// below 0 if that was in the past. `None` if it never does. No square of `B` is formed: it would
/// underflow in a collapse.
pub fn time_to_contact(clearance: f64, closing: f64, speed2_over_closing: f64) -> Option<f64> {
    let time = clearance / -closing;
    let discriminant = 1.0 - time * speed2_over_closing;
    (discriminant >= 0.0).then(|| time / (1.0 + discriminant.sqrt()))
}

/// The next wall that a disc reaches and the time until then, as [`super::impact::wall_impact`].
pub fn wall_impact(
    position: &DoubleDoubleVec,
    velocity: DVec2,
    radius: f64,
    walls: &Walls,
) -> Option<Hit> {
    let hit = |side: Side, speed: f64| {
        let left = wall_gap(position, radius, walls, side);
        Hit { time: if left > 0.0 { left / speed } else { 0.0 }, side }
    };
    let along = |speed: f64, low: Side, high: Side| {
        let side = if speed > 0.0 { high } else { low };
        (speed != 0.0).then(|| hit(side, speed.abs()))
    };
    let x = along(velocity.x, Side::Left, Side::Right);
    let y = along(velocity.y, Side::Bottom, Side::Top);
    match (x, y) {
        (Some(x), Some(y)) => Some(if y.time < x.time { y } else { x }),
        (x, y) => x.or(y),
    }
}

/// Distance of a disc's surface from a wall, m, rounded once; negative = beyond it.
pub fn wall_gap(position: &DoubleDoubleVec, radius: f64, walls: &Walls, side: Side) -> f64 {
    let above = |x: DoubleDouble, low: f64| x.minus(DoubleDouble::sum(low, radius)).value();
    let below = |x: DoubleDouble, high: f64| DoubleDouble::sum(high, -radius).minus(x).value();
    match side {
        Side::Left => above(position.x, walls.min.x),
        Side::Right => below(position.x, walls.max.x),
        Side::Bottom => above(position.y, walls.min.y),
        Side::Top => below(position.y, walls.max.y),
    }
}

/// How wrong differences of positions and velocities may be that were computed in plain doubles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Doubt {
    /// Along each axis, m.
    pub position: f64,
    /// Along each axis, m/s.
    pub velocity: f64,
}

impl Doubt {
    /// Whether a pair could touch within `horizon` seconds: cheap, and never wrongly `false`.
    ///
    /// First whether they approach, and whether `C / (2 |B|)`, which is never too late, lies within
    /// the horizon; then the time of impact itself. Each number is taken at that end of its error
    /// which lets the pair meet earlier.
    #[inline(always)]
    pub fn may_meet_within(&self, d: DVec2, w: DVec2, s: f64, horizon: f64) -> bool {
        const SAFE: f64 = 1.0 + 32.0 * UNIT_ROUNDOFF;
        let (bx, by) = (d.x * w.x, d.y * w.y);
        let (d_sum, w_sum) = (d.x.abs() + d.y.abs(), w.x.abs() + w.y.abs());
        let given = self.position * w_sum + self.velocity * d_sum;
        let closing = 8.0 * UNIT_ROUNDOFF * (bx.abs() + by.abs()) + given - (bx + by);
        if closing < 0.0 {
            return false;
        }
        let (d2, s2) = (d.length_squared(), s * s);
        let c_doubt =
            8.0 * UNIT_ROUNDOFF * (d2 + s2) + 4.0 * self.position * (d_sum + self.position);
        let clearance = d2 - s2 - c_doubt;
        if clearance > 2.0 * closing * horizon * SAFE {
            return false;
        }
        let (x, y) = (d.x * w.y, d.y * w.x);
        let passed = (x - y).abs() - 8.0 * UNIT_ROUNDOFF * (x.abs() + y.abs()) - given;
        let swept = s * (w.length() + 2.0 * self.velocity) * SAFE;
        if passed > swept {
            return false;
        }
        let passed = passed.max(0.0);
        let root = ((swept - passed) * (swept + passed)).sqrt();
        clearance <= (closing + root) * horizon * SAFE
    }
}
