//! Four at a time, with AVX2.
//!
//! The same operations in the same order as in the plain form beside it. What reads and writes here
//! without a check says where it was checked; whoever calls asked the processor first.
#![allow(unsafe_code, reason = "measured: about twice as fast, carom bench gas")]

use std::arch::x86_64::*;

use super::*;

/// Four at a time.
struct Four<const BARE: bool, const ALIKE: bool>;

impl<const BARE: bool, const ALIKE: bool> Unit for Four<BARE, ALIKE> {
    const BARE: bool = BARE;
    const ALIKE: bool = ALIKE;

    #[inline(always)]
    fn gather(numbers: &[u32], block: &Block, near: &mut Near) {
        // SAFETY: reached only through the functions below.
        unsafe { collect_rows::<0>(numbers, block, near, near.count) };
    }

    #[inline(always)]
    fn earliest_gathered(sight: &Sight, disc: usize, near: &mut Near) -> Meeting {
        // SAFETY: reached only through the functions below.
        unsafe {
            match (sight.wrap, BARE || sight.radii.is_empty()) {
                (None, true) => earliest_gathered::<false, true>(sight, disc, near),
                (None, false) => earliest_gathered::<false, false>(sight, disc, near),
                (Some(_), true) => earliest_gathered::<true, true>(sight, disc, near),
                (Some(_), false) => earliest_gathered::<true, false>(sight, disc, near),
            }
        }
    }

    #[inline(always)]
    fn earliest(sight: &Sight, block: &Block, disc: usize, near: &mut Near) -> Meeting {
        // SAFETY: reached only through the functions below.
        unsafe {
            match (sight.wrap, BARE || sight.radii.is_empty()) {
                (None, true) => earliest::<false, true>(sight, block, disc, near),
                (None, false) => earliest::<false, false>(sight, block, disc, near),
                (Some(_), true) => earliest::<true, true>(sight, block, disc, near),
                (Some(_), false) => earliest::<true, false>(sight, block, disc, near),
            }
        }
    }

    #[inline(always)]
    fn earliest_of_two(
        sight: &Sight,
        blocks: &[Block; 2],
        discs: [usize; 2],
        near: &mut [Near; 2],
    ) -> [Meeting; 2] {
        // SAFETY: reached only through the functions below.
        unsafe {
            match (sight.wrap, BARE || sight.radii.is_empty()) {
                (None, true) => earliest_of_two::<false, true>(sight, blocks, discs, near),
                (None, false) => earliest_of_two::<false, false>(sight, blocks, discs, near),
                (Some(_), true) => earliest_of_two::<true, true>(sight, blocks, discs, near),
                (Some(_), false) => earliest_of_two::<true, false>(sight, blocks, discs, near),
            }
        }
    }

    #[inline(always)]
    fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
        // SAFETY: reached only through the functions below.
        unsafe { deflect(flight, now, by) }
    }

    #[inline(always)]
    fn sort_few(numbers: &mut [u64]) {
        // SAFETY: reached only through the functions below.
        unsafe { sort_few(numbers) }
    }

    #[inline(always)]
    fn renew(arena: &mut Events, k: usize, noted: f64) {
        // SAFETY: reached only through the functions below.
        unsafe { renew::<BARE, ALIKE>(arena, k, noted) }
    }

    #[inline(always)]
    fn renew_two(arena: &mut Events, i: usize, j: usize, noted: f64) {
        // SAFETY: reached only through the functions below.
        unsafe { renew_two::<BARE, ALIKE>(arena, i, j, noted) }
    }

    #[inline(always)]
    fn next_day(arena: &mut Events) {
        // SAFETY: reached only through the functions below.
        unsafe { next_day::<BARE, ALIKE>(arena) }
    }
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
pub fn advance<const BARE: bool, const ALIKE: bool, W: Witness>(
    arena: &mut Events,
    until: f64,
    witness: &mut W,
) -> Result<(), Stall> {
    arena.advance_with::<Four<BARE, ALIKE>, W>(until, witness)
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
pub fn renew_all(arena: &mut Events, discs: &[usize]) {
    arena.renew_all::<Four<false, false>>(discs);
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline(never)]
fn renew<const BARE: bool, const ALIKE: bool>(arena: &mut Events, k: usize, noted: f64) {
    arena.predict_again::<Four<BARE, ALIKE>>(k, noted);
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline(never)]
fn renew_two<const BARE: bool, const ALIKE: bool>(
    arena: &mut Events,
    i: usize,
    j: usize,
    noted: f64,
) {
    arena.predict_two_again::<Four<BARE, ALIKE>>(i, j, noted);
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline(never)]
fn next_day<const BARE: bool, const ALIKE: bool>(arena: &mut Events) {
    arena.open_next_day::<Four<BARE, ALIKE>>();
}

/// The place of each is how many are larger: no branch is guessed wrongly.
#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn sort_few(numbers: &mut [u64]) {
    const FEW: usize = 32;
    let count = numbers.len();
    if count > FEW {
        return numbers.sort_unstable_by(|a, b| b.cmp(a));
    }
    let (mut from, mut to) = ([0; FEW], [0; FEW]);
    from[..count].copy_from_slice(numbers);
    let groups = count.div_ceil(4);
    for &number in numbers.iter() {
        let own = _mm256_set1_epi64x(number as i64);
        let mut larger = 0;
        for four in &from.as_chunks::<4>().0[..groups] {
            // SAFETY: there are four numbers to read.
            let four = unsafe { _mm256_loadu_si256(four.as_ptr().cast()) };
            let is_larger = _mm256_castsi256_pd(_mm256_cmpgt_epi64(four, own));
            larger += _mm256_movemask_pd(is_larger).count_ones() as usize;
        }
        to[larger % FEW] = number;
    }
    // Equals took one place, which leaves another empty.
    if to[..count].contains(&0) {
        return numbers.sort_unstable_by(|a, b| b.cmp(a));
    }
    numbers.copy_from_slice(&to[..count]);
}

/// All four numbers at once: what is written in parts is slow to read whole.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
    let by = _mm256_setr_pd(by.x, by.y, by.x, by.y);
    let times = _mm256_setr_pd(-now, -now, 1.0, 1.0);
    // SAFETY: a flight is four doubles in a row.
    unsafe {
        let row: *mut f64 = (flight as *mut Flight).cast();
        let changed = _mm256_add_pd(_mm256_loadu_pd(row), _mm256_mul_pd(by, times));
        _mm256_storeu_pd(row, changed);
    }
}

/// Returns the largest disc that was named.
#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn collect(numbers: &[u32], block: &Block, near: &mut Near) -> u32 {
    match block.width {
        12 => collect_rows::<3>(numbers, block, near, 0),
        24 => collect_rows::<6>(numbers, block, near, 0),
        _ => collect_rows::<0>(numbers, block, near, 0),
    }
}

/// The same where a row is so many fours wide, or any number of them (0); behind so many discs that
/// were named before.
#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn collect_rows<const FOURS: usize>(
    numbers: &[u32],
    block: &Block,
    near: &mut Near,
    before: usize,
) -> u32 {
    let fours = if FOURS == 0 { block.width / 4 } else { FOURS };
    assert!(block.end() <= numbers.len() && block.count() <= BLOCK_MAX);
    assert!(before + block.count() <= NEAR_MAX);
    let mut largest = _mm_setzero_si128();
    let (mut start, mut count) = (block.start, before);
    for _ in 0..block.rows {
        for four in 0..fours {
            // SAFETY: the block ends before the numbers do, and there is room for all of it.
            unsafe {
                let discs = _mm_loadu_si128(numbers.as_ptr().add(start + 4 * four).cast());
                _mm_storeu_si128(near.discs.as_mut_ptr().add(count).cast(), discs);
                // Of all numbers in cells only EMPTY has the highest bit, and it stands last.
                largest = _mm_max_epi32(largest, discs);
                let empty = _mm_movemask_ps(_mm_castsi128_ps(discs));
                count += 4 - empty.count_ones() as usize;
            }
        }
        start += block.stride;
    }
    near.count = count;
    let half = _mm_max_epu32(largest, _mm_shuffle_epi32::<0b1110>(largest));
    let most = _mm_max_epu32(half, _mm_shuffle_epi32::<0b0001>(half));
    _mm_cvtsi128_si32(most) as u32
}

/// Who looks, in all four lanes.
#[derive(Clone, Copy)]
struct Looker {
    x: __m256d,
    y: __m256d,
    vx: __m256d,
    vy: __m256d,
    reach: __m256d,
    square: __m256d,
    now: __m256d,
}

/// When four discs are met, s; see [`meeting`].
///
/// # Safety
/// All four must be there.
#[target_feature(enable = "avx2,fma")]
#[inline]
unsafe fn meetings<const WRAP: bool, const EQUAL: bool>(
    looker: &Looker,
    sight: &Sight,
    four: &[u32; 4],
) -> __m256d {
    let zero = _mm256_setzero_pd();
    // SAFETY: the caller knows that they are there.
    let [f0, f1, f2, f3] = four.map(|k| unsafe { sight.flights.get_unchecked(k as usize) });
    let (even, odd) = (halves(f0, f2), halves(f1, f3));
    let wx = _mm256_sub_pd(_mm256_unpacklo_pd(even.1, odd.1), looker.vx);
    let wy = _mm256_sub_pd(_mm256_unpackhi_pd(even.1, odd.1), looker.vy);
    let dx = _mm256_sub_pd(_mm256_unpacklo_pd(even.0, odd.0), looker.x);
    let dy = _mm256_sub_pd(_mm256_unpackhi_pd(even.0, odd.0), looker.y);
    let mut dx = _mm256_add_pd(dx, _mm256_mul_pd(wx, looker.now));
    let mut dy = _mm256_add_pd(dy, _mm256_mul_pd(wy, looker.now));
    if WRAP && let Some(Wrap { size, per_size }) = sight.wrap {
        (dx, dy) = (nearest(dx, size.x, per_size.x), nearest(dy, size.y, per_size.y));
    }
    let b = _mm256_add_pd(_mm256_mul_pd(dx, wx), _mm256_mul_pd(dy, wy));
    let mut s2 = looker.square;
    if !EQUAL {
        // SAFETY: as above.
        let [a, b, c, d] = four.map(|k| unsafe { *sight.radii.get_unchecked(k as usize) });
        let reach = _mm256_add_pd(looker.reach, _mm256_setr_pd(a, b, c, d));
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
    let infinity = _mm256_set1_pd(f64::INFINITY);
    _mm256_blendv_pd(infinity, _mm256_add_pd(looker.now, wait), meets)
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn earliest<const WRAP: bool, const EQUAL: bool>(
    sight: &Sight,
    block: &Block,
    disc: usize,
    near: &mut Near,
) -> Meeting {
    let largest = collect(sight.numbers, block, near);
    let groups = near.count.div_ceil(4).max(1);
    let best = note_times::<WRAP, EQUAL>(sight, disc, near, largest, groups);
    choose(best, near, groups, sight.instant)
}

#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn earliest_gathered<const WRAP: bool, const EQUAL: bool>(
    sight: &Sight,
    disc: usize,
    near: &mut Near,
) -> Meeting {
    let largest = near.discs().iter().copied().max().unwrap_or(0);
    let groups = near.count.div_ceil(4);
    let best = note_times::<WRAP, EQUAL>(sight, disc, near, largest, groups);
    choose(best, near, groups, sight.instant)
}

/// Both side by side: while one waits for a root, the other goes on.
#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn earliest_of_two<const WRAP: bool, const EQUAL: bool>(
    sight: &Sight,
    blocks: &[Block; 2],
    discs: [usize; 2],
    [near_a, near_b]: &mut [Near; 2],
) -> [Meeting; 2] {
    let largest_a = collect(sight.numbers, &blocks[0], near_a);
    let largest_b = collect(sight.numbers, &blocks[1], near_b);
    // A loop that is mostly as long is foreseen: two fours are mostly enough.
    let groups_a = near_a.count.div_ceil(4).max(2);
    let groups_b = near_b.count.div_ceil(4).max(2);
    let best_a = note_times::<WRAP, EQUAL>(sight, discs[0], near_a, largest_a, groups_a);
    let best_b = note_times::<WRAP, EQUAL>(sight, discs[1], near_b, largest_b, groups_b);
    let a = choose(best_a, near_a, groups_a, sight.instant);
    [a, choose(best_b, near_b, groups_b, sight.instant)]
}

/// Notes when the discs that are near, of which none is beyond the largest, are met; returns
/// the earliest times of each lane. Two groups at least if there are less discs.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn note_times<const WRAP: bool, const EQUAL: bool>(
    sight: &Sight,
    disc: usize,
    near: &mut Near,
    largest: u32,
    groups: usize,
) -> __m256d {
    let (largest, count) = (largest as usize, near.count);
    let is_there = largest < sight.flights.len() && (EQUAL || largest < sight.radii.len());
    assert!(is_there && count <= NEAR_MAX && groups <= (count + 8) / 4);
    let own = &sight.flights[disc];
    // Where all are equal the square says all.
    let reach = if EQUAL { 0.0 } else { sight.radii[disc] };
    let looker = Looker {
        x: _mm256_set1_pd(own.x),
        y: _mm256_set1_pd(own.y),
        vx: _mm256_set1_pd(own.vx),
        vy: _mm256_set1_pd(own.vy),
        reach: _mm256_set1_pd(reach),
        square: _mm256_set1_pd(sight.square),
        now: _mm256_set1_pd(sight.now),
    };
    let mut best = _mm256_set1_pd(f64::INFINITY);
    // SAFETY: there is room for two vectors and more behind the last disc, the discs are
    // there, and who looks fills the groups, as nobody meets itself.
    unsafe {
        let filling = _mm_set1_epi32(disc as i32);
        let (discs, times) = (near.discs.as_mut_ptr(), near.times.as_mut_ptr());
        _mm_storeu_si128(discs.add(count).cast(), filling);
        _mm_storeu_si128(discs.add(count + 4).cast(), filling);
        for group in 0..groups {
            let time = meetings::<WRAP, EQUAL>(&looker, sight, &*discs.add(4 * group).cast());
            best = _mm256_min_pd(best, time);
            _mm256_storeu_pd(times.add(4 * group), time);
        }
    }
    best
}

/// A coordinate seen from the nearest image.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn nearest(d: __m256d, size: f64, per_size: f64) -> __m256d {
    let whole = _mm256_set1_pd(WHOLE);
    let boxes = _mm256_add_pd(_mm256_mul_pd(d, _mm256_set1_pd(per_size)), whole);
    let boxes = _mm256_sub_pd(boxes, whole);
    _mm256_sub_pd(d, _mm256_mul_pd(_mm256_set1_pd(size), boxes))
}

/// Which of the meetings the earliest is, of equals the first, and whether another is at the
/// same instant.
#[target_feature(enable = "avx2,fma,popcnt,bmi1")]
#[inline]
fn choose(best: __m256d, near: &Near, groups: usize, instant: f64) -> Meeting {
    let time = least(best);
    let times = &near.times.as_chunks::<4>().0[..groups];
    if groups > 16 {
        return Meeting::earliest(&near.discs, times.as_flattened(), instant);
    }
    let (earliest, latest) = (_mm256_set1_pd(time), _mm256_set1_pd(time + instant));
    let (mut first, mut soon) = (0u64, 0u64);
    for times in times.iter().rev() {
        // SAFETY: there are four numbers to read.
        let times = unsafe { _mm256_loadu_pd(times.as_ptr()) };
        let is_first = _mm256_cmp_pd::<_CMP_EQ_OQ>(times, earliest);
        let is_soon = _mm256_cmp_pd::<_CMP_LE_OQ>(times, latest);
        first = (first << 4) | _mm256_movemask_pd(is_first) as u64;
        soon = (soon << 4) | _mm256_movemask_pd(is_soon) as u64;
    }
    let with = near.discs[first.trailing_zeros() as usize];
    Meeting { time, with, tie: soon.count_ones() > 1 && time < f64::INFINITY }
}

#[target_feature(enable = "avx2,fma")]
#[inline]
fn least(lanes: __m256d) -> f64 {
    let halves = _mm_min_pd(_mm256_castpd256_pd128(lanes), _mm256_extractf128_pd::<1>(lanes));
    _mm_cvtsd_f64(_mm_min_pd(halves, _mm_unpackhi_pd(halves, halves)))
}

/// The starts of two flights, and their velocities.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn halves(low: &Flight, high: &Flight) -> (__m256d, __m256d) {
    let (low, high): (*const f64, *const f64) =
        ((low as *const Flight).cast(), (high as *const Flight).cast());
    // SAFETY: a flight is four doubles in a row.
    unsafe { (_mm256_loadu2_m128d(high, low), _mm256_loadu2_m128d(high.add(2), low.add(2))) }
}
