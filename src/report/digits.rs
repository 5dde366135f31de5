//! The laws of one pair in many digits: what they give for exactly the doubles that are given.
//!
//! Sums and products of the inputs are exact within 1200 bits, quotients and roots good to 300, so
//! decisions are right and errors are those of the formula that is judged. Written from the laws
//! alone, without a robust form, for digits cost nothing here. Never use one where a run is timed.

use dashu_float::FBig;
use glam::DVec2;

use crate::detect::impact::Relative;
use crate::world::Disc;

/// A number of many digits.
pub type Big = FBig;

/// Digits of sums and products: exact for what figures ask.
const EXACT_BITS: usize = 1200;
/// Digits of quotients and roots.
const BITS: usize = 300;

/// A finite double, exactly.
///
/// # Panics
/// For infinities and NaN.
pub fn big(x: f64) -> Big {
    with_bits(x, EXACT_BITS)
}

/// A finite double, exactly, of which all that is computed has so many bits.
///
/// # Panics
/// For infinities and NaN.
pub fn with_bits(x: f64, bits: usize) -> Big {
    // Scenes are of finite numbers, and what a formula gave was looked at before.
    let exact = Big::try_from(x).expect("a finite number");
    exact.with_precision(bits).value()
}

/// A number to as many digits as a quotient or root shall have.
fn short(x: &Big) -> Big {
    x.clone().with_precision(BITS).value()
}

/// The nearest double.
pub fn nearest(x: &Big) -> f64 {
    x.to_f64().value()
}

/// `|actual - exact|`, infinite if the actual number is not finite.
pub fn error(actual: f64, exact: &Big) -> f64 {
    if actual.is_finite() { nearest(&(big(actual) - exact)).abs() } else { f64::INFINITY }
}

/// A vector of many digits.
pub type BigVec = [Big; 2];

/// A vector of finite doubles, exactly.
pub fn big_vec(v: DVec2) -> BigVec {
    [big(v.x), big(v.y)]
}

/// The scalar product.
pub fn dot(a: &BigVec, b: &BigVec) -> Big {
    &a[0] * &b[0] + &a[1] * &b[1]
}

/// `a - b`.
pub fn minus(a: &BigVec, b: &BigVec) -> BigVec {
    [&a[0] - &b[0], &a[1] - &b[1]]
}

/// `a + k b`.
pub fn plus_times(a: &BigVec, k: &Big, b: &BigVec) -> BigVec {
    [&a[0] + k * &b[0], &a[1] + k * &b[1]]
}

/// When two discs touch, s from now; 0 = they do and approach, `None` = never.
pub fn time_of_impact(pair: &Relative) -> Option<Big> {
    let (d, w, s) = (big_vec(pair.d), big_vec(pair.w), big(pair.s));
    let b = dot(&d, &w);
    let c = dot(&d, &d) - &s * &s;
    let discriminant = &b * &b - dot(&w, &w) * &c;
    if b >= Big::ZERO {
        return None;
    }
    if c <= Big::ZERO {
        return Some(Big::ZERO);
    }
    (discriminant >= Big::ZERO).then(|| short(&c) / (short(&discriminant).sqrt() - short(&b)))
}

/// Velocities of two discs of finite mass after their contact; `None` = they do not approach.
pub fn collide(a: &Disc, b: &Disc, restitution: f64) -> Option<(BigVec, BigVec)> {
    let (va, vb) = (big_vec(a.velocity), big_vec(b.velocity));
    let d = minus(&big_vec(b.position), &big_vec(a.position));
    let closing = dot(&d, &minus(&vb, &va));
    if closing >= Big::ZERO {
        return None;
    }
    let (ma, mb) = (big(a.mass), big(b.mass));
    // (1 + e) w.d / (d.d (ma + mb)), of which each disc takes the mass of the other.
    let share = short(&(closing * (big(1.0) + big(restitution))))
        / short(&dot(&d, &d))
        / short(&(&ma + &mb));
    Some((plus_times(&va, &(&share * &mb), &d), plus_times(&vb, &-(share * ma), &d)))
}
