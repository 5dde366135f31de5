//! The time of impact, compiled twice: with the processor's fused multiply-add and without it.
//!
//! The plain x86-64 instruction set has no fused operation, so each would be a call; on the
//! processors of the last decade it is one instruction. The bits are the same, which a test holds.
//! The only file with unsafe code: it calls what the processor was asked for just before.
#![allow(unsafe_code, reason = "measured: two to four times as fast, cargo bench --bench impact")]

use glam::DVec2;

use super::impact::pair_impact_here;

/// [`super::impact::pair_impact`]
#[inline]
pub fn pair_impact(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the one feature that the function asks for.
        return unsafe { with_fused_operations(d, w, s) };
    }
    without_fused_operations(d, w, s)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
fn with_fused_operations(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    pair_impact_here(d, w, s)
}

/// For every processor.
pub fn without_fused_operations(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    pair_impact_here(d, w, s)
}
