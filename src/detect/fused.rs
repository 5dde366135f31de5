//! The time of impact, compiled more than once: for wide registers and the processor's fused
//! multiply-add, and without them.
//!
//! The plain x86-64 instruction set has no fused operation, so each would be a call; on the
//! processors of the last decade it is one instruction, and four pairs fit a register. The bits are
//! the same, which a test holds. Never put a formula here, and never ask the processor for each of
//! many pairs. One of two files with unsafe code: it calls what the processor was asked for just
//! before.
#![allow(unsafe_code, reason = "measured: two to four times as fast, cargo bench --bench impact")]

use glam::DVec2;

use super::impact::{Relative, pair_impact_here, pair_impact_in_full_here};
use super::side_by_side::pair_impacts_here;

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

/// [`super::impact::pair_impact_in_full`]
#[inline]
pub fn pair_impact_in_full(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the one feature that the function asks for.
        return unsafe { in_full_with_fused_operations(d, w, s) };
    }
    pair_impact_in_full_here(d, w, s)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
fn in_full_with_fused_operations(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    pair_impact_in_full_here(d, w, s)
}

/// For every processor.
pub fn without_fused_operations(d: DVec2, w: DVec2, s: f64) -> Option<f64> {
    pair_impact_here(d, w, s)
}

/// [`super::impact::pair_impacts`]
pub fn pair_impacts(pairs: &[Relative], times: &mut [f64]) {
    assert_eq!(pairs.len(), times.len(), "a time for each pair");
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the two features that the function asks for.
        return unsafe { in_wide_registers(pairs, times) };
    }
    if cfg!(target_arch = "aarch64") {
        // It always has both.
        return pair_impacts_here(pairs, times);
    }
    one_by_one(pairs, times);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn in_wide_registers(pairs: &[Relative], times: &mut [f64]) {
    pair_impacts_here(pairs, times);
}

/// For every processor: while a fused operation is a call, to leave out is best.
pub fn one_by_one(pairs: &[Relative], times: &mut [f64]) {
    for (pair, time) in pairs.iter().zip(times) {
        *time = without_fused_operations(pair.d, pair.w, pair.s).unwrap_or(f64::INFINITY);
    }
}
