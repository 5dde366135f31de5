//! Times of impact under gravity: a wall seen from a falling disc, and a pair of which one falls.
//!
//! A disc that falls has `c + v t + a t^2 / 2` left to a wall: the root is taken without
//! subtraction and its discriminant with fused operations. Two falling discs see each other fly
//! straight ([`super::impact`]). Where only one falls (the other is fixed, observed or at rest) the
//! squared distance is of fourth degree in `t`: between the roots of its derivative it is monotone,
//! so bisection finds the first time at which it comes down to the reach, and misses none.
//!
//! What touches already counts as touching exactly, as for straight flight.

use glam::DVec2;

use super::impact::{Hit, clearance};
use crate::exact::{power_of_two_near, sum_of_products};
use crate::world::{Disc, Side, Walls};

/// The next wall that a falling disc reaches; 0 = it is at or beyond the wall and moves outwards.
/// Of two walls at once, the one named first in [`Side`].
pub fn falling_wall_impact(disc: &Disc, acceleration: DVec2, walls: &Walls) -> Option<Hit> {
    let mut first: Option<Hit> = None;
    for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
        let normal = side.normal();
        let place = walls.onto(side, disc);
        let left = (place - disc.position).dot(normal);
        let (speed, pull) = (disc.velocity.dot(normal), acceleration.dot(normal));
        if let Some(time) = time_to_fall(left, speed, pull)
            && first.is_none_or(|first| time < first.time)
        {
            first = Some(Hit { time, side });
        }
    }
    first
}

/// First time at which a distance `left`, that shrinks with `speed` and ever faster by `pull`, is
/// used up.
pub fn time_to_fall(left: f64, speed: f64, pull: f64) -> Option<f64> {
    if left <= 0.0 {
        if speed > 0.0 {
            return Some(0.0);
        }
        // It leaves, and may come back. At rest and pressed it has no acceleration.
        return (pull > 0.0 && speed < 0.0).then(|| -2.0 * speed / pull);
    }
    if pull == 0.0 || (speed <= 0.0 && pull < 0.0) {
        return (speed > 0.0).then(|| left / speed);
    }
    let discriminant = sum_of_products(speed, speed, 2.0 * pull, left);
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    Some(if speed >= 0.0 { 2.0 * left / (speed + root) } else { (root - speed) / pull })
}

/// When two discs, one of which falls, touch next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Approach {
    /// They touch already and approach.
    Now,
    /// After so many seconds.
    At(f64),
    /// They touch, do not approach, and are about to: one carries the other.
    Pressed,
}

/// The next contact of two discs; `None` = never. `d`, `w`, `a`: position (m), velocity (m/s) and
/// acceleration (m/s^2, not 0) of the second seen from the first; `s`: sum of the radii, m;
/// `shortest`: the shortest time between two contacts that counts as flight, s.
pub fn falling_pair_impact(
    d: DVec2,
    w: DVec2,
    a: DVec2,
    s: f64,
    shortest: f64,
) -> Option<Approach> {
    let length = power_of_two_near(d.abs().max_element().max(s));
    let slowest = (length / w.length()).min((length / a.length()).sqrt());
    let unit = power_of_two_near(slowest);
    let (d, s) = (d / length, s / length);
    let (w, half) = (w * (unit / length), 0.5 * a * (unit / length) * unit);
    let touching = clearance(d, s);
    let closing = sum_of_products(d.x, w.x, d.y, w.y);
    if touching <= 0.0 && closing < 0.0 {
        return Some(Approach::Now);
    }
    let quartic = [
        touching.max(0.0),
        2.0 * closing,
        sum_of_products(w.x, w.x, w.y, w.y) + 2.0 * sum_of_products(d.x, half.x, d.y, half.y),
        2.0 * sum_of_products(w.x, half.x, w.y, half.y),
        half.length_squared(),
    ];
    // From then on the pull alone has carried them apart.
    let speed = w.length();
    let root = (speed * speed + 4.0 * half.length() * (d.length() + s)).sqrt();
    let end = 1.0625 * (speed + root) / (2.0 * half.length());
    let time = first_descent(&quartic, end)? * unit;
    let pressed = touching <= 0.0 && time < shortest;
    Some(if pressed { Approach::Pressed } else { Approach::At(time) })
}

/// Value of a polynomial, lowest coefficient first.
fn value(polynomial: &[f64], t: f64) -> f64 {
    polynomial.iter().rev().fold(0.0, |sum, &coefficient| sum.mul_add(t, coefficient))
}

/// The first time in `[0, end]` at which a polynomial that begins at 0 or above gets below 0.
fn first_descent(polynomial: &[f64; 5], end: f64) -> Option<f64> {
    let mut bounds = turns(polynomial, end);
    bounds.push(end);
    let mut low = 0.0;
    for high in bounds {
        if value(polynomial, high) < 0.0 {
            return Some(bisect(polynomial, low, high));
        }
        low = high;
    }
    None
}

/// The roots of the derivative in `(0, end)`, rising: between them the polynomial is monotone.
fn turns(polynomial: &[f64], end: f64) -> Vec<f64> {
    let scaled = polynomial.iter().enumerate().skip(1);
    let derivative: Vec<f64> = scaled.map(|(k, coefficient)| k as f64 * coefficient).collect();
    if derivative.len() < 2 {
        return Vec::new();
    }
    let mut bounds = turns(&derivative, end);
    bounds.push(end);
    let mut roots = Vec::new();
    let mut low = 0.0;
    for high in bounds {
        if (value(&derivative, low) < 0.0) != (value(&derivative, high) < 0.0) {
            roots.push(bisect(&derivative, low, high));
        }
        low = high;
    }
    roots
}

/// Where a monotone piece changes sign: the end of the last interval between neighbours.
fn bisect(polynomial: &[f64], mut low: f64, mut high: f64) -> f64 {
    let end_is_below = value(polynomial, high) < 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if (value(polynomial, middle) < 0.0) == end_is_below {
            high = middle;
        } else {
            low = middle;
        }
    }
}
