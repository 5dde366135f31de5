//! When will two discs, or a disc and a wall, touch? The time of impact.
//!
//! With relative position `d`, relative velocity `w` and reach `s = ra + rb`, contact is at the
//! smaller root of `|d + w t| = s`. The textbook root loses all digits for near, far or grazing
//! pairs. Here `B = d.w` and `X = d x w` are taken with one fused operation each, `C = d.d - s^2`
//! and the discriminant `s^2 w^2 - X^2` in double-double only where they cancel, and the root as
//! `C / (-B + sqrt(disc))`, which has no subtraction: a few u of relative error in every case.
//! [`pair_impacts`] computes many pairs side by side.
//!
//! Overlapping and approaching means now; overlapping and separating means never again: the
//! direction of motion decides, no distance tolerance (Bannerman et al., arXiv:1211.6718).

use glam::DVec2;

use super::fused;
use crate::exact::{
    UNIT_ROUNDOFF, power_of_two_near, sum_of_products, sum_of_two_products, two_product, two_sum,
};
use crate::world::{Side, Walls};

/// One disc seen from another: all that the time of their impact depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Relative {
    /// Position, m.
    pub d: DVec2,
    /// Velocity, m/s.
    pub w: DVec2,
    /// Reach: sum of the radii, m.
    pub s: f64,
}

/// Time until two discs touch, s from now; 0 = they touch already and approach; `None` = never.
///
/// `d`: position of the second seen from the first, m; `w`: its relative velocity, m/s; `s`: sum
/// of the radii, m. Valid while products of four of them neither over- nor underflow.
pub fn pair_impact(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    fused::pair_impact(d, w, s)
}

/// [`pair_impact`] of many pairs, to the same bits in less than half the time; infinite = never.
///
/// # Panics
/// Unless there are as many times as pairs.
pub fn pair_impacts(pairs: &[Relative], times: &mut [f64]) {
    fused::pair_impacts(pairs, times);
}

/// [`pair_impact`], to be compiled for each kind of processor.
#[inline(always)]
pub(super) fn pair_impact_here(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let b = sum_of_products(d.x, w.x, d.y, w.y);
    if b >= 0.0 {
        return None;
    }
    let c = clearance(d, s);
    if c <= 0.0 {
        return Some(0.0);
    }
    let discriminant = discriminant(d, w, s);
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - b))
}

/// [`pair_impact`] with everything in double-double, needed or not: to show what looking first
/// saves, and that it costs no digit. Not in the same bits.
pub fn pair_impact_in_full(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    fused::pair_impact_in_full(d, w, s)
}

/// [`pair_impact_in_full`], to be compiled for each kind of processor.
#[inline(always)]
pub(super) fn pair_impact_in_full_here(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let (b, b_rest) = sum_of_two_products(d.x, w.x, d.y, w.y);
    if b + b_rest >= 0.0 {
        return None;
    }
    let c = exact_clearance(d, s);
    if c <= 0.0 {
        return Some(0.0);
    }
    let discriminant = exact_discriminant(d, w, s);
    (discriminant >= 0.0).then(|| c / (discriminant.sqrt() - (b + b_rest)))
}

/// [`pair_impact`] for any finite input: lengths and speeds are divided by powers of two first,
/// which costs no digit, so squares of the scaled numbers stay in range. The same bits where the
/// plain one is valid.
pub fn pair_impact_at_any_scale(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    let length = power_of_two_near(d.abs().max_element().max(s));
    let speed = power_of_two_near(w.abs().max_element());
    let time = pair_impact(d / length, w / speed, s / length)?;
    // No step may leave the range of doubles unless the result does.
    let alike = (length > 1.0) == (speed > 1.0);
    Some(if alike { time * (length / speed) } else { time * length / speed })
}

/// `d.d - s^2`, in double-double where the two are close.
#[inline(always)]
pub(super) fn clearance(d: DVec2, s: f64) -> f64 {
    let (clearance, good) = plain_clearance(d, s);
    if good { clearance } else { exact_clearance(d, s) }
}

/// `d.d - s^2` and whether it has kept its digits.
#[inline(always)]
pub(super) fn plain_clearance(d: DVec2, s: f64) -> (f64, bool) {
    let (d2, s2) = (d.length_squared(), s * s);
    (d2 - s2, d2 > 2.0 * s2)
}

/// `d.d - s^2` in double-double.
#[inline(always)]
pub(super) fn exact_clearance(d: DVec2, s: f64) -> f64 {
    let (x2, x2_error) = two_product(d.x, d.x);
    let (y2, y2_error) = two_product(d.y, d.y);
    let (s2, s2_error) = two_product(s, s);
    // Larger terms first: what the sums round away is small beside the result.
    let (part, part_error) = two_sum(x2, -s2);
    let (sum, sum_error) = two_sum(part, y2);
    sum + (part_error + sum_error + (x2_error + y2_error - s2_error))
}

/// `s^2 w^2 - (d x w)^2`, in double-double where the two are close. Below 0 the paths pass each
/// other.
#[inline(always)]
fn discriminant(d: DVec2, w: DVec2, s: f64) -> f64 {
    let (discriminant, good) = plain_discriminant(d, w, s);
    if good { discriminant } else { exact_discriminant(d, w, s) }
}

/// `s^2 w^2 - (d x w)^2` and whether it has kept its digits; below 0 only the sign is right.
#[inline(always)]
pub(super) fn plain_discriminant(d: DVec2, w: DVec2, s: f64) -> (f64, bool) {
    let cross = sum_of_products(d.x, w.y, -d.y, w.x).abs();
    let swept = s * w.length();
    let margin = swept - cross;
    // A negative product could underflow to 0, which is a hit.
    let discriminant = if margin < 0.0 { margin } else { margin * (swept + cross) };
    (discriminant, margin.abs() > 0.25 * swept)
}

/// `s^2 w^2 - (d x w)^2` in double-double.
#[inline(always)]
pub(super) fn exact_discriminant(d: DVec2, w: DVec2, s: f64) -> f64 {
    let (cross, cross_rest) = sum_of_two_products(d.x, w.y, -d.y, w.x);
    let (w2, w2_rest) = sum_of_two_products(w.x, w.x, w.y, w.y);
    let (s2, s2_rest) = two_product(s, s);
    let (swept2, swept2_error) = two_product(s2, w2);
    let (cross2, cross2_error) = two_product(cross, cross);
    let swept2_rest = swept2_error + s2.mul_add(w2_rest, s2_rest * w2);
    let cross2_rest = (2.0 * cross).mul_add(cross_rest, cross2_error);
    let (difference, error) = two_sum(swept2, -cross2);
    difference + (error + (swept2_rest - cross2_rest))
}

/// Whether the pair could touch within `horizon` seconds: cheap, and never wrongly `false`.
///
/// Rejects receding pairs and those whose lower bound `C / (2 |B|)` lies beyond the horizon.
pub fn may_meet_within(d: DVec2, w: DVec2, s: f64, horizon: f64) -> bool {
    let (bx, by) = (d.x * w.x, d.y * w.y);
    let b = bx + by;
    if b > 4.0 * UNIT_ROUNDOFF * (bx.abs() + by.abs()) {
        return false;
    }
    let (d2, s2) = (d.length_squared(), s * s);
    let c = d2 - s2 - 8.0 * UNIT_ROUNDOFF * (d2 + s2);
    let slowest = bx.abs() + by.abs();
    // Near-tangential motion makes |B| inexact; its bound by the sum of terms is always safe.
    let closing = if -b > 0.5 * slowest { -b } else { slowest };
    c <= 2.0 * closing * horizon * (1.0 + 16.0 * UNIT_ROUNDOFF)
}

/// The next wall that a disc reaches and the time until then, s; 0 = it is at or beyond the wall
/// and moves outwards. `None` without velocity. Of two walls at once, x comes first.
pub fn wall_impact(position: DVec2, velocity: DVec2, radius: f64, walls: &Walls) -> Option<Hit> {
    let x = axis_impact(position.x, velocity.x, walls.min.x + radius, walls.max.x - radius)
        .map(|(time, upper)| Hit { time, side: if upper { Side::Right } else { Side::Left } });
    let y = axis_impact(position.y, velocity.y, walls.min.y + radius, walls.max.y - radius)
        .map(|(time, upper)| Hit { time, side: if upper { Side::Top } else { Side::Bottom } });
    match (x, y) {
        (Some(x), Some(y)) => Some(if y.time < x.time { y } else { x }),
        (x, y) => x.or(y),
    }
}

/// When and which wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Time until the hit, s.
    pub time: f64,
    /// The wall.
    pub side: Side,
}

/// Time to the bound ahead on one axis, and whether that is the upper one.
fn axis_impact(x: f64, v: f64, low: f64, high: f64) -> Option<(f64, bool)> {
    let upper = v > 0.0;
    let ahead = if upper { high - x } else { low - x };
    if v == 0.0 {
        return None;
    }
    let inside = if upper { ahead > 0.0 } else { ahead < 0.0 };
    Some((if inside { ahead / v } else { 0.0 }, upper))
}
