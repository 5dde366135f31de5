//! The earliest meeting of a disc with those near it: four at a time where the processor can.
//!
//! The same operations in the same order in both forms, none of them fused, so the bits are the
//! same on every processor; a test holds that. One of the two files with unsafe code: it calls
//! what the processor was asked for, reads four rows at places that were checked, and prefetches.
#![allow(unsafe_code, reason = "measured: about twice as fast, carom bench gas")]

use glam::DVec2;

use super::{Events, Flight};
use crate::motion::Witness;
use crate::motion::plain::Stall;

/// Who looks, when, and how far away is too near.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The disc that looks.
    pub disc: usize,
    /// The present, s.
    pub now: f64,
    /// Sum of the radii, m, where all are equal; else the radius of the disc that looks.
    pub reach: f64,
    /// The periodic box, where its border may lie between.
    pub wrap: Option<DVec2>,
}

/// The earliest meeting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// When, s; infinite = none.
    pub time: f64,
    /// With which disc.
    pub with: u32,
    /// When the one after it is.
    pub second: f64,
}

/// No meeting.
pub const NOBODY: Meeting = Meeting { time: f64::INFINITY, with: u32::MAX, second: f64::INFINITY };

/// How meetings are looked for.
pub trait Unit {
    /// The earliest meeting with the discs `near`, whose count is a multiple of four; `radii` is
    /// empty where all are equal. A disc does not meet itself.
    fn earliest(query: &Query, flights: &[Flight], radii: &[f64], near: &[u32]) -> Meeting;

    /// Changes the velocity of a flight.
    fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
        flight.deflect(now, by);
    }
}

/// One at a time, on every processor.
pub struct OneByOne;

impl Unit for OneByOne {
    fn earliest(query: &Query, flights: &[Flight], radii: &[f64], near: &[u32]) -> Meeting {
        one_by_one(query, flights, radii, near)
    }
}

/// [`Events::advance`], with the best that the processor has.
pub fn advance<W: Witness>(arena: &mut Events, until: f64, witness: &mut W) -> Result<(), Stall> {
    #[cfg(target_arch = "x86_64")]
    if has_four() {
        // SAFETY: the processor has what the function asks for.
        return unsafe { avx2::advance(arena, until, witness) };
    }
    arena.advance_with::<OneByOne, W>(until, witness)
}

/// [`Events::renew_all`], with the best that the processor has.
pub fn renew_all(arena: &mut Events, discs: &[usize]) {
    #[cfg(target_arch = "x86_64")]
    if has_four() {
        // SAFETY: the processor has what the function asks for.
        return unsafe { avx2::renew_all(arena, discs) };
    }
    arena.renew_all::<OneByOne>(discs);
}

#[cfg(target_arch = "x86_64")]
fn has_four() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
}

/// What rounds a double to a whole number when it is added and taken away again.
const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

fn one_by_one(query: &Query, flights: &[Flight], radii: &[f64], near: &[u32]) -> Meeting {
    let mut found = NOBODY;
    for &with in near {
        let Some(time) = meeting(query, flights, radii, with as usize) else { continue };
        found.second = found.second.min(time.max(found.time));
        if time < found.time {
            (found.time, found.with) = (time, with);
        }
    }
    found
}

/// When two discs meet, s.
pub fn meeting(query: &Query, flights: &[Flight], radii: &[f64], with: usize) -> Option<f64> {
    let (own, other) = (&flights[query.disc], &flights[with]);
    let (wx, wy) = (other.vx - own.vx, other.vy - own.vy);
    let mut dx = (other.x - own.x) + wx * query.now;
    let mut dy = (other.y - own.y) + wy * query.now;
    if let Some(size) = query.wrap {
        dx -= size.x * ((dx / size.x + WHOLE) - WHOLE);
        dy -= size.y * ((dy / size.y + WHOLE) - WHOLE);
    }
    let b = dx * wx + dy * wy;
    let reach = if radii.is_empty() { query.reach } else { query.reach + radii[with] };
    let s2 = reach * reach;
    let cross = dx * wy - dy * wx;
    let root = s2 * (wx * wx + wy * wy) - cross * cross;
    let meets = b < 0.0 && root >= 0.0;
    let c = (dx * dx + dy * dy - s2).max(0.0);
    meets.then(|| query.now + c / (root.sqrt() - b))
}

/// Asks for the line of memory of an element before it is needed.
#[inline(always)]
pub fn prefetch<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if index < items.len() {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: the element exists, and a prefetch reads nothing.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(items.as_ptr().add(index).cast()) };
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{DVec2, Events, Flight, Meeting, NOBODY, Query, Stall, Unit, WHOLE, Witness};

    /// Four at a time.
    struct FourByFour;

    impl Unit for FourByFour {
        #[inline(always)]
        fn earliest(query: &Query, flights: &[Flight], radii: &[f64], near: &[u32]) -> Meeting {
            // SAFETY: reached only through the functions below.
            unsafe {
                match (query.wrap.is_some(), radii.is_empty()) {
                    (false, true) => earliest::<false, true>(query, flights, radii, near),
                    (true, true) => earliest::<true, true>(query, flights, radii, near),
                    (false, false) => earliest::<false, false>(query, flights, radii, near),
                    (true, false) => earliest::<true, false>(query, flights, radii, near),
                }
            }
        }

        #[inline(always)]
        fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
            // SAFETY: reached only through the functions below.
            unsafe { deflect(flight, now, by) }
        }
    }

    /// All four numbers at once: what is written in parts is slow to read whole.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
        let by = _mm256_setr_pd(by.x, by.y, by.x, by.y);
        let times = _mm256_setr_pd(-now, -now, 1.0, 1.0);
        let changed = _mm256_add_pd(row(flight), _mm256_mul_pd(by, times));
        // SAFETY: a flight is four doubles in a row.
        unsafe { _mm256_storeu_pd((flight as *mut Flight).cast(), changed) };
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn advance<W: Witness>(
        arena: &mut Events,
        until: f64,
        witness: &mut W,
    ) -> Result<(), Stall> {
        arena.advance_with::<FourByFour, W>(until, witness)
    }

    #[target_feature(enable = "avx2,fma")]
    pub fn renew_all(arena: &mut Events, discs: &[usize]) {
        arena.renew_all::<FourByFour>(discs);
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn earliest<const WRAP: bool, const EQUAL: bool>(
        query: &Query,
        flights: &[Flight],
        radii: &[f64],
        near: &[u32],
    ) -> Meeting {
        let own = row(&flights[query.disc]);
        let (x, y) = (_mm256_permute4x64_pd::<0x00>(own), _mm256_permute4x64_pd::<0x55>(own));
        let (vx, vy) = (_mm256_permute4x64_pd::<0xaa>(own), _mm256_permute4x64_pd::<0xff>(own));
        let now = _mm256_set1_pd(query.now);
        let zero = _mm256_setzero_pd();
        let infinity = _mm256_set1_pd(f64::INFINITY);
        let mut s2 = _mm256_set1_pd(query.reach * query.reach);
        let (mut best, mut second) = (infinity, infinity);
        let (mut best_group, mut group) = (_mm256_setzero_si256(), _mm256_setzero_si256());
        let one = _mm256_set1_epi64x(1);
        for four in near.as_chunks::<4>().0 {
            let [r0, r1, r2, r3] = four.map(|k| row(&flights[k as usize]));
            let (low0, low1) = (_mm256_unpacklo_pd(r0, r1), _mm256_unpacklo_pd(r2, r3));
            let (high0, high1) = (_mm256_unpackhi_pd(r0, r1), _mm256_unpackhi_pd(r2, r3));
            let wx = _mm256_sub_pd(_mm256_permute2f128_pd::<0x31>(low0, low1), vx);
            let wy = _mm256_sub_pd(_mm256_permute2f128_pd::<0x31>(high0, high1), vy);
            let dx = _mm256_sub_pd(_mm256_permute2f128_pd::<0x20>(low0, low1), x);
            let dy = _mm256_sub_pd(_mm256_permute2f128_pd::<0x20>(high0, high1), y);
            let mut dx = _mm256_add_pd(dx, _mm256_mul_pd(wx, now));
            let mut dy = _mm256_add_pd(dy, _mm256_mul_pd(wy, now));
            if WRAP && let Some(size) = query.wrap {
                let whole = _mm256_set1_pd(WHOLE);
                let (sx, sy) = (_mm256_set1_pd(size.x), _mm256_set1_pd(size.y));
                let nx = _mm256_sub_pd(_mm256_add_pd(_mm256_div_pd(dx, sx), whole), whole);
                let ny = _mm256_sub_pd(_mm256_add_pd(_mm256_div_pd(dy, sy), whole), whole);
                dx = _mm256_sub_pd(dx, _mm256_mul_pd(sx, nx));
                dy = _mm256_sub_pd(dy, _mm256_mul_pd(sy, ny));
            }
            let b = _mm256_add_pd(_mm256_mul_pd(dx, wx), _mm256_mul_pd(dy, wy));
            if !EQUAL {
                let [a, b, c, d] = four.map(|k| radii[k as usize]);
                let reach = _mm256_add_pd(_mm256_set1_pd(query.reach), _mm256_setr_pd(a, b, c, d));
                s2 = _mm256_mul_pd(reach, reach);
            }
            let cross = _mm256_sub_pd(_mm256_mul_pd(dx, wy), _mm256_mul_pd(dy, wx));
            let w2 = _mm256_add_pd(_mm256_mul_pd(wx, wx), _mm256_mul_pd(wy, wy));
            let root = _mm256_sub_pd(_mm256_mul_pd(s2, w2), _mm256_mul_pd(cross, cross));
            let d2 = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
            let c = _mm256_max_pd(_mm256_sub_pd(d2, s2), zero);
            let wait = _mm256_div_pd(c, _mm256_sub_pd(_mm256_sqrt_pd(root), b));
            let meets = _mm256_and_pd(
                _mm256_cmp_pd::<_CMP_LT_OQ>(b, zero),
                _mm256_cmp_pd::<_CMP_GE_OQ>(root, zero),
            );
            let time = _mm256_blendv_pd(infinity, _mm256_add_pd(now, wait), meets);
            second = _mm256_min_pd(second, _mm256_max_pd(time, best));
            let earlier = _mm256_cmp_pd::<_CMP_LT_OQ>(time, best);
            best_group = _mm256_blendv_epi8(best_group, group, _mm256_castpd_si256(earlier));
            best = _mm256_min_pd(time, best);
            group = _mm256_add_epi64(group, one);
        }
        choose(best, second, best_group, near)
    }

    /// The earliest of four lanes, of equals the first in the list.
    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn choose(best: __m256d, second: __m256d, group: __m256i, near: &[u32]) -> Meeting {
        let earliest = least(best);
        let is_earliest = _mm256_cmp_pd::<_CMP_EQ_OQ>(best, _mm256_set1_pd(earliest));
        let lanes = _mm256_movemask_pd(is_earliest);
        if earliest == f64::INFINITY {
            return NOBODY;
        }
        if lanes.count_ones() > 1 {
            return choose_of_equals(best, group, lanes, near);
        }
        let lane = lanes.trailing_zeros() as usize & 3;
        let others = _mm256_blendv_pd(best, _mm256_set1_pd(f64::INFINITY), is_earliest);
        let with = near[groups(group)[lane] as usize * 4 + lane];
        Meeting { time: earliest, with, second: least(_mm256_min_pd(second, others)) }
    }

    #[cold]
    #[target_feature(enable = "avx2,fma")]
    fn choose_of_equals(best: __m256d, group: __m256i, lanes: i32, near: &[u32]) -> Meeting {
        let time = least(best);
        let equal = (0..4).filter(|lane| lanes & (1 << lane) != 0);
        let at = equal.map(|lane| groups(group)[lane] as usize * 4 + lane).min();
        Meeting { time, with: near[at.unwrap_or(0)], second: time }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn least(lanes: __m256d) -> f64 {
        let halves = _mm_min_pd(_mm256_castpd256_pd128(lanes), _mm256_extractf128_pd::<1>(lanes));
        _mm_cvtsd_f64(_mm_min_pd(halves, _mm_unpackhi_pd(halves, halves)))
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn row(flight: &Flight) -> __m256d {
        // SAFETY: a flight is four doubles in a row.
        unsafe { _mm256_loadu_pd((flight as *const Flight).cast()) }
    }

    #[target_feature(enable = "avx2,fma")]
    #[inline]
    fn groups(lanes: __m256i) -> [u64; 4] {
        let mut array = [0; 4];
        // SAFETY: four numbers fit.
        unsafe { _mm256_storeu_si256(array.as_mut_ptr().cast(), lanes) };
        array
    }
}
