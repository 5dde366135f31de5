//! Do two discs touch now? Decided exactly, for every finite input.
//!
//! The test is `|d|^2 <= (ra + rb)^2` on the doubles as given, without rounding: plain arithmetic
//! decides when its error bound allows, else the sum is evaluated exactly. No tolerance, so a gap
//! of one ulp is a gap, and nothing creeps.

use crate::exact::{DoubleDouble, UNIT_ROUNDOFF, power_of_two_near, sign_of_sum};
use crate::world::Disc;

/// Whether the gap between two discs is at most `margin` (m, 0 = contact).
///
/// Exact for a margin of 0; else the reach `ra + rb + margin` is right to 2^-104.
pub fn touch(a: &Disc, b: &Disc, margin: f64) -> bool {
    sign_of_gap(a, b, margin) <= 0
}

/// Whether two discs overlap: touching is not enough. Exact.
pub fn overlap(a: &Disc, b: &Disc) -> bool {
    sign_of_gap(a, b, 0.0) < 0
}

/// The sign of the gap less the margin.
fn sign_of_gap(a: &Disc, b: &Disc, margin: f64) -> i32 {
    let d = b.position - a.position;
    let reach = a.radius + b.radius + margin;
    let (distance2, reach2) = (d.length_squared(), reach * reach);
    let sum = distance2 + reach2;
    // Each side has a relative error below 8u; squares below 1e-280 may have lost bits.
    let in_range = sum > 1e-280 && sum < 1e300;
    let difference = distance2 - reach2;
    if in_range && difference.abs() > 16.0 * UNIT_ROUNDOFF * sum {
        return if difference < 0.0 { -1 } else { 1 };
    }
    exact_sign_of_gap(a, b, margin)
}

/// The same by exact arithmetic, after scaling by a power of two.
fn exact_sign_of_gap(a: &Disc, b: &Disc, margin: f64) -> i32 {
    let all = [a.position, b.position].map(|p| p.abs().max_element());
    let largest = all.into_iter().chain([a.radius, b.radius, margin]).fold(0.0, f64::max);
    // A quarter: sums of a few scaled numbers and their squares then stay finite.
    let unit = power_of_two_near(largest) * 4.0;
    let dx = DoubleDouble::sum(b.position.x / unit, -a.position.x / unit);
    let dy = DoubleDouble::sum(b.position.y / unit, -a.position.y / unit);
    let radii = DoubleDouble::sum(a.radius / unit, b.radius / unit);
    let reach = radii.plus(DoubleDouble { hi: margin / unit, lo: 0.0 });
    let mut terms = [0.0; 18];
    for (part, square) in terms.chunks_exact_mut(6).zip([dx, dy, reach]) {
        part.copy_from_slice(&square_terms(square));
    }
    terms[12..].iter_mut().for_each(|term| *term = -*term);
    sign_of_sum(&mut terms)
}

/// The six doubles whose exact sum is the square of `x`.
fn square_terms(x: DoubleDouble) -> [f64; 6] {
    let high = DoubleDouble::product(x.hi, x.hi);
    let cross = DoubleDouble::product(2.0 * x.hi, x.lo);
    let low = DoubleDouble::product(x.lo, x.lo);
    [low.lo, low.hi, cross.lo, cross.hi, high.lo, high.hi]
}

/// Distance of the two surfaces, m; negative = overlap. Right to a few u of itself or, in a deep
/// overlap, of the radii.
pub fn gap(a: &Disc, b: &Disc) -> f64 {
    let d = b.position - a.position;
    let reach = a.radius + b.radius;
    let distance = d.length();
    // Far from contact nothing cancels; a distance out of range is not finite or 0.
    let overlap = reach - distance;
    if overlap > 0.125 * reach && distance > 1e-140 && reach < 1e140 {
        return -overlap;
    }
    let unit = power_of_two_near(d.abs().max_element().max(reach));
    let (x, y, s) = (d.x / unit, d.y / unit, reach / unit);
    // (d^2 - s^2) / (|d| + s): the cancelling difference is taken before anything is rounded.
    let squares = DoubleDouble::product(x, x).plus(DoubleDouble::product(y, y));
    let difference = squares.plus(DoubleDouble::product(s, s).negated()).value();
    difference / (squares.hi.sqrt() + s) * unit
}
