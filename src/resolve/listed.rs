//! The law for a list of pairs, in its order: for who knows which pairs touch and wants their
//! velocities, without records and without a look at what shares discs (which [`super::touching`]
//! resolves together).
//!
//! For each pair it is [`super::pair::exchange`]; [`super::pair::collide`] is asked near grazing,
//! where it is a question of rounding whether a pair approaches, and at extreme scales. Compiled
//! twice, as [`crate::detect::fused`] is: with the processor's fused multiply-add, and for every
//! processor; the bits are the same, which a test holds. One of the few files with unsafe code: it
//! calls what the processor was asked for just before.
#![allow(unsafe_code, reason = "measured: twice as fast, cargo bench --bench resolver")]

use super::pair::{MassFractions, collide, exchange};
use crate::detect::Pair;
use crate::exact::UNIT_ROUNDOFF;
use crate::world::Disc;

/// Squares in between have room for their products and what these leave out.
const IN_RANGE: std::ops::Range<f64> = 1e-140..1e140;

/// Gives each pair of a list that approaches its impulse, one after the other; returns how many
/// did. A pair of which neither disc can move, or that does not approach, stays as it is.
///
/// `restitution` from 0 to 1. Whether they touch is for the caller to know.
///
/// # Panics
/// If an index is no disc.
pub fn resolve(discs: &mut [Disc], pairs: &[Pair], restitution: f64) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx") && std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the two features that the function asks for.
        return unsafe { with_fused_operations(discs, pairs, restitution) };
    }
    without_fused_operations(discs, pairs, restitution)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx,fma")]
fn with_fused_operations(discs: &mut [Disc], pairs: &[Pair], restitution: f64) -> usize {
    resolve_here(discs, pairs, restitution)
}

/// For every processor.
pub fn without_fused_operations(discs: &mut [Disc], pairs: &[Pair], restitution: f64) -> usize {
    resolve_here(discs, pairs, restitution)
}

#[inline(always)]
fn resolve_here(discs: &mut [Disc], pairs: &[Pair], restitution: f64) -> usize {
    let mut count = 0;
    for &(i, j) in pairs {
        let (a, b) = (&discs[i], &discs[j]);
        let (d, w) = (b.position - a.position, b.velocity - a.velocity);
        let (x, y) = (w.x * d.x, w.y * d.y);
        let is_clear = ((x + y).abs() > 8.0 * UNIT_ROUNDOFF * (x.abs() + y.abs()))
            & IN_RANGE.contains(&d.length_squared())
            & IN_RANGE.contains(&w.length_squared())
            & (a.mass.is_finite() | b.mass.is_finite());
        if !is_clear {
            count += usize::from(resolve_with_care(discs, (i, j), restitution));
        } else if x + y < 0.0 {
            let share = MassFractions::of(a.mass, b.mass);
            let change = exchange(d, (a.velocity, b.velocity), restitution, &share, true);
            discs[i].velocity += change.by_a;
            discs[j].velocity += change.by_b;
            count += 1;
        }
    }
    count
}

#[cold]
fn resolve_with_care(discs: &mut [Disc], (i, j): Pair, restitution: f64) -> bool {
    let Some(impact) = collide(&discs[i], &discs[j], restitution) else { return false };
    discs[i].velocity = impact.velocity_a;
    discs[j].velocity = impact.velocity_b;
    true
}
