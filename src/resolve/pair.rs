//! The law for two discs: an impulse along the line of centres.
//!
//! With unit normal `n` from a to b, relative velocity `w = vb - va` and approach `w.n < 0`:
//! `va += fa (1 + e) (w.n) n`, `vb -= fb (1 + e) (w.n) n`, with the mass fractions
//! `fa = mb / (ma + mb)`, `fb = ma / (ma + mb)`. The tangential part is never formed, so it stays
//! as it is to the last bit; an infinite mass has fraction 0. The error is bounded by
//! `16 u (1 + e) f |w| + 2 u max(|v|, |v'|)`, in any frame.
//!
//! Three refinements, each where it matters: the sign of `w.n` is decided in double-double near
//! grazing; a fraction is carried as `hi + lo`, because its rounding error would be the same in
//! every collision of a pair and energy would drift, not wander; and the impulse is taken along the
//! normal as it was rounded, divided by its square, because a length of 1 + u makes energy drift
//! too (measured: 2e-19 a collision for 100 discs without, below 1e-20 with).
//!
//! Policy: coincident centres have no normal, the relative velocity serves as one; equal
//! velocities are then left alone. Overlapping discs that separate are never collided again.

use glam::DVec2;

use crate::exact::{
    DoubleDouble, UNIT_ROUNDOFF, power_of_two_near, sum_of_products, sum_of_two_products, two_sum,
};
use crate::world::Disc;

/// What a contact changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Unit normal from a to b.
    pub normal: DVec2,
    /// Speed of approach along the normal, m/s; above 0.
    pub approach_speed: f64,
    /// New velocity of a, m/s.
    pub velocity_a: DVec2,
    /// New velocity of b, m/s.
    pub velocity_b: DVec2,
    /// Impulse along the normal, N s.
    pub impulse: f64,
    /// Kinetic energy lost, J.
    pub energy_loss: f64,
}

/// Collides two discs that touch; `None` when they do not approach, or neither can change.
///
/// `restitution` from 0 to 1. Whether they touch is for the caller to know.
pub fn collide(a: &Disc, b: &Disc, restitution: f64) -> Option<Impact> {
    if a.mass.is_infinite() && b.mass.is_infinite() {
        return None;
    }
    let (normal, approach_speed) = approach(a, b)?;
    let fractions = MassFractions::of(a.mass, b.mass);
    let (jump, jump_lo) = jump(a, b, restitution, normal, approach_speed);
    let reduced_mass =
        if a.mass.is_finite() { a.mass * fractions.a.hi } else { b.mass * fractions.b.hi };
    Some(Impact {
        normal,
        approach_speed,
        velocity_a: a.velocity - normal * fractions.a.times(jump, jump_lo),
        velocity_b: b.velocity + normal * fractions.b.times(jump, jump_lo),
        impulse: reduced_mass * jump,
        energy_loss: 0.5
            * reduced_mass
            * (1.0 - restitution)
            * (1.0 + restitution)
            * approach_speed
            * approach_speed,
    })
}

/// The change of the relative velocity along a rounded normal `n`, `(1 + e) (-w.n) / n.n`, as
/// `hi + lo`: what keeps the energy for this `n`.
fn jump(a: &Disc, b: &Disc, restitution: f64, n: DVec2, approach_speed: f64) -> (f64, f64) {
    let w = b.velocity - a.velocity;
    let along = -sum_of_products(w.x, n.x, w.y, n.y);
    // Near grazing the rounding of the normal swamps it: there the exact approach speed counts.
    let close = (along - approach_speed).abs() <= 0.25 * approach_speed;
    let jump = (1.0 + restitution) * if close { along } else { approach_speed };
    let excess = n.x.mul_add(n.x, -1.0) + n.y * n.y;
    (jump, -excess * jump)
}

/// Unit normal and approach speed (above 0), or `None` if the two do not approach.
pub fn approach(a: &Disc, b: &Disc) -> Option<(DVec2, f64)> {
    let d = b.position - a.position;
    let w = b.velocity - a.velocity;
    let in_range = |x: f64| x > 1e-140 && x < 1e140;
    if in_range(d.length_squared()) && in_range(w.length_squared()) {
        return approach_along(d, w, || approach_near_grazing(a, b, 1.0, 1.0));
    }
    // Exact scaling: squares and products of the scaled numbers are in range.
    let length = power_of_two_near(d.abs().max_element());
    let speed = power_of_two_near(w.abs().max_element());
    let near_grazing = || approach_near_grazing(a, b, length, speed);
    let (normal, approach_speed) = approach_along(d / length, w / speed, near_grazing)?;
    Some((normal, approach_speed * speed))
}

/// The same from relative position and velocity; `near_grazing` decides where `w.d` cancels.
fn approach_along(d: DVec2, w: DVec2, near_grazing: impl FnOnce() -> f64) -> Option<(DVec2, f64)> {
    if d == DVec2::ZERO {
        let speed = w.length();
        return (speed > 0.0).then(|| (-w / speed, speed));
    }
    let (x, y) = (w.x * d.x, w.y * d.y);
    let mut along = x + y;
    if along.abs() <= 8.0 * UNIT_ROUNDOFF * (x.abs() + y.abs()) {
        along = near_grazing();
    }
    let distance = d.length();
    (along < 0.0).then(|| (d / distance, -along / distance))
}

/// The approach speed, m/s, up to which it may be nothing but the rounding of the velocities.
///
/// A contact that slow would be answered by velocities that differ from it by as much: discs at
/// rest on each other would collide for ever.
pub fn rounding_speed(a: &Disc, b: &Disc) -> f64 {
    4.0 * UNIT_ROUNDOFF * (a.velocity.length() + b.velocity.length())
}

/// `w.d` from the coordinates as given, without rounding their differences first.
fn approach_near_grazing(a: &Disc, b: &Disc, length_unit: f64, speed_unit: f64) -> f64 {
    let difference = |b: f64, a: f64, unit: f64| DoubleDouble::sum(b / unit, -a / unit);
    let dx = difference(b.position.x, a.position.x, length_unit);
    let dy = difference(b.position.y, a.position.y, length_unit);
    let wx = difference(b.velocity.x, a.velocity.x, speed_unit);
    let wy = difference(b.velocity.y, a.velocity.y, speed_unit);
    dx.times(wx).plus(dy.times(wy)).value()
}

/// What [`exchange`] gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exchange {
    /// Change of the velocity of a, m/s.
    pub by_a: DVec2,
    /// Change of the velocity of b, m/s.
    pub by_b: DVec2,
    /// `w.d`, m^2/s; negative = they approach.
    pub along: f64,
    /// `d.d`, m^2.
    pub square: f64,
}

/// The law of [`collide`] without a unit normal, so without a root: for two discs that touch and
/// are known to approach.
///
/// `d`: position of b seen from a, m. With `q = w.d / d.d` the velocities change by
/// `fa (1 + e) q d` and `-fb (1 + e) q d`. `q` is carried as `hi + lo` from exact products: at
/// contact `d.d` is nearly the same number every time, so what the division rounds away has a mean,
/// and energy would drift (measured: 5e-17 kT a collision without, below 1e-19 with).
///
/// `looks`: whether it looks if masses are equal and nothing is lost, which is quicker then.
#[inline(always)]
pub fn exchange(
    d: DVec2,
    (va, vb): (DVec2, DVec2),
    restitution: f64,
    share: &MassFractions,
    looks: bool,
) -> Exchange {
    let (wx, wx_lo) = two_sum(vb.x, -va.x);
    let (wy, wy_lo) = two_sum(vb.y, -va.y);
    let (along, along_lo) = sum_of_two_products(d.x, wx, d.y, wy);
    let along_lo = along_lo + (d.x * wx_lo + d.y * wy_lo);
    let (square, square_lo) = sum_of_two_products(d.x, d.x, d.y, d.y);
    let per_square = square.recip();
    let q = along * per_square;
    let q_lo = ((-q).mul_add(square, along) + (along_lo - q * square_lo)) * per_square;
    if looks && restitution == 1.0 && share.a == Fraction::HALF {
        // Of equal masses: what follows, to the last bit.
        let by = DVec2::new(d.x.mul_add(q, d.x * q_lo), d.y.mul_add(q, d.y * q_lo));
        return Exchange { by_a: by, by_b: -by, along, square };
    }
    let both = 1.0 + restitution;
    let jump = both * q;
    let jump_lo = both.mul_add(q, -jump) + both * q_lo;
    let change = |fraction: Fraction| {
        let k = fraction.hi * jump;
        let rest = fraction.hi.mul_add(jump_lo, fraction.lo * jump);
        let k_lo = fraction.hi.mul_add(jump, -k) + rest;
        DVec2::new(d.x.mul_add(k, d.x * k_lo), d.y.mul_add(k, d.y * k_lo))
    };
    Exchange { by_a: change(share.a), by_b: -change(share.b), along, square }
}

/// The share of the velocity change that each disc takes, as `hi + lo`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassFractions {
    /// `mb / (ma + mb)`.
    pub a: Fraction,
    /// `ma / (ma + mb)`.
    pub b: Fraction,
}

/// A number in [0, 1], carried to twice the precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fraction {
    /// The nearest double.
    pub hi: f64,
    /// What it leaves out.
    pub lo: f64,
}

impl MassFractions {
    /// Of equal masses.
    pub const EQUAL: Self = Self { a: Fraction::HALF, b: Fraction::HALF };

    /// Of two masses above 0, of which at most one is infinite.
    #[inline]
    pub fn of(mass_a: f64, mass_b: f64) -> Self {
        let whole = |hi| Fraction { hi, lo: 0.0 };
        if mass_a == mass_b {
            return Self::EQUAL;
        }
        if mass_a.is_infinite() || mass_b.is_infinite() {
            let b_moves = f64::from(u8::from(mass_a.is_infinite()));
            return Self { a: whole(1.0 - b_moves), b: whole(b_moves) };
        }
        // Exact scaling: the sum of two huge masses must not overflow.
        let unit = power_of_two_near(mass_a.max(mass_b)) * 2.0;
        let (mass_a, mass_b) = (mass_a / unit, mass_b / unit);
        let (total, error) = two_sum(mass_a, mass_b);
        let fraction = |mass: f64| {
            let hi = mass / total;
            Fraction { hi, lo: ((-hi).mul_add(total, mass) - hi * error) / total }
        };
        Self { a: fraction(mass_b), b: fraction(mass_a) }
    }
}

impl Fraction {
    const HALF: Self = Self { hi: 0.5, lo: 0.0 };

    /// The fraction of `x + lo`.
    fn times(self, x: f64, lo: f64) -> f64 {
        self.hi.mul_add(x, self.hi.mul_add(lo, self.lo * x))
    }
}
