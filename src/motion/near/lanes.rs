//! The loops over all discs and all listed pairs: several at a time where the processor can.
//!
//! The same operations in the same order in both forms, none of them fused, so the results are the
//! same on every processor; a test holds that. One of the few files with unsafe code: it calls what
//! the processor was asked for, reads places by indices that were checked when a list was sealed,
//! and writes into room that was made. Never decide here who collides: only who is near.
#![allow(
    unsafe_code,
    reason = "measured: twice as fast, six times around a box, cargo bench --bench steps"
)]

use glam::DVec2;

/// Pairs of discs by their indices.
#[derive(Clone, Debug, Default)]
pub struct Pairs {
    first: Vec<u32>,
    second: Vec<u32>,
    /// All indices are below this.
    bound: usize,
}

/// What a search looks at.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Where the discs are, m.
    pub places: &'a [DVec2],
    /// Their radii, m; empty where all are equal.
    pub radii: &'a [f64],
    /// Sum of two radii where all are equal, m.
    pub reach: f64,
    /// Gap up to which a pair is near, m.
    pub margin: f64,
    /// Size of the periodic box, m.
    pub wrap: Option<DVec2>,
}

/// No rounding may hide a pair that touches.
const SLACK: f64 = 1.0 + 1e-9;

/// Entries that are looked at together.
const WIDTH: usize = 4;

/// Squares below this may have lost their digits.
const TINY: f64 = 1e-280;

impl Pairs {
    /// How many.
    pub fn len(&self) -> usize {
        self.first.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// All of them; in each the smaller index first.
    pub fn iter(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.first.iter().zip(&self.second).map(|(&i, &j)| (i as usize, j as usize))
    }

    /// Forgets all, keeps the memory.
    pub fn clear(&mut self) {
        self.first.clear();
        self.second.clear();
        self.bound = usize::MAX;
    }

    /// Adds a pair.
    pub fn push(&mut self, i: u32, j: u32) {
        self.first.push(i.min(j));
        self.second.push(i.max(j));
        self.bound = usize::MAX;
    }

    /// Drops pairs.
    pub fn retain(&mut self, stays: impl Fn(usize, usize) -> bool) {
        let mut kept = 0;
        for k in 0..self.len() {
            let (i, j) = (self.first[k], self.second[k]);
            (self.first[kept], self.second[kept]) = (i, j);
            kept += usize::from(stays(i as usize, j as usize));
        }
        self.first.truncate(kept);
        self.second.truncate(kept);
    }

    /// To be called when the list is complete, with the number of discs.
    ///
    /// # Panics
    /// If an index is no disc.
    pub fn seal(&mut self, discs: usize) {
        let largest = self.second.iter().copied().max();
        assert!(largest.is_none_or(|k| (k as usize) < discs), "indices of discs");
        self.bound = discs;
    }

    /// Puts the pairs of this sealed list that are near into another, in the same order.
    pub fn select(&self, look: &Look, found: &mut Self) {
        found.clear();
        #[cfg(target_arch = "x86_64")]
        if is_wide() {
            // SAFETY: the processor has what the function asks for.
            unsafe { avx2::select(self, look, found) };
            found.bound = self.bound;
            return;
        }
        self.select_one_by_one(look, found);
    }

    /// The same on every processor.
    pub fn select_one_by_one(&self, look: &Look, found: &mut Self) {
        found.clear();
        let inverse = look.wrap.map(DVec2::recip);
        for (&i, &j) in self.first.iter().zip(&self.second) {
            let (i, j) = (i as usize, j as usize);
            let mut d = look.places[j] - look.places[i];
            if let (Some(size), Some(inverse)) = (look.wrap, inverse) {
                d -= size * nearest(d * inverse);
            }
            let reach =
                if look.radii.is_empty() { look.reach } else { look.radii[i] + look.radii[j] };
            if is_near(d, reach + look.margin) {
                found.first.push(i as u32);
                found.second.push(j as u32);
            }
        }
        found.bound = self.bound;
    }
}

#[inline(always)]
fn is_near(d: DVec2, reach: f64) -> bool {
    let reach = reach * SLACK;
    let reach2 = reach * reach;
    d.length_squared() <= reach2 || reach2 < TINY
}

/// The nearest whole numbers; of two as near either.
fn nearest(x: DVec2) -> DVec2 {
    DVec2::new(x.x.round_ties_even(), x.y.round_ties_even())
}

/// Discs in the order of cells.
#[derive(Clone, Debug, Default)]
pub struct Entries {
    count: usize,
    x: Vec<f64>,
    y: Vec<f64>,
    radius: Vec<f64>,
    disc: Vec<u32>,
}

/// Who looks for others among entries.
#[derive(Clone, Copy, Debug)]
pub struct Centre {
    /// m.
    pub place: DVec2,
    /// Own radius and the gap up to which others are near, m.
    pub reach: f64,
    /// Which disc it is.
    pub disc: u32,
    /// Size of the periodic box, where its border may lie between, m.
    pub wrap: Option<DVec2>,
}

impl Entries {
    /// Room for so many, and for those that wide loops read beyond the end.
    pub fn resize(&mut self, count: usize) {
        self.count = count;
        for numbers in [&mut self.x, &mut self.y, &mut self.radius] {
            numbers.resize(count + WIDTH, 0.0);
        }
        self.disc.resize(count + WIDTH, 0);
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Place, radius and number of an entry.
    pub fn get(&self, slot: usize) -> (DVec2, f64, u32) {
        (DVec2::new(self.x[slot], self.y[slot]), self.radius[slot], self.disc[slot])
    }

    /// Writes an entry.
    pub fn set(&mut self, slot: usize, place: DVec2, radius: f64, disc: u32) {
        (self.x[slot], self.y[slot]) = (place.x, place.y);
        (self.radius[slot], self.disc[slot]) = (radius, disc);
    }

    /// Adds the pairs of a disc with all near ones in a range of entries.
    pub fn scan(&self, centre: &Centre, range: std::ops::Range<usize>, pairs: &mut Pairs) {
        #[cfg(target_arch = "x86_64")]
        if is_wide() {
            // SAFETY: the processor has what the function asks for.
            return unsafe { avx2::scan(self, centre, range, pairs) };
        }
        self.scan_one_by_one(centre, range, pairs);
    }

    /// The same on every processor.
    pub fn scan_one_by_one(
        &self,
        centre: &Centre,
        range: std::ops::Range<usize>,
        pairs: &mut Pairs,
    ) {
        let inverse = centre.wrap.map(DVec2::recip);
        for slot in range {
            let mut d = DVec2::new(self.x[slot], self.y[slot]) - centre.place;
            if let (Some(size), Some(inverse)) = (centre.wrap, inverse) {
                d -= size * nearest(d * inverse);
            }
            if is_near(d, centre.reach + self.radius[slot]) {
                pairs.push(centre.disc, self.disc[slot]);
            }
        }
    }
}

/// Straight flights from where and when they began.
#[derive(Clone, Copy, Debug)]
pub struct Flight<'a> {
    /// m.
    pub starts: &'a [DVec2],
    /// m/s.
    pub velocities: &'a [DVec2],
    /// In steps.
    pub began: &'a [f64],
    /// In steps.
    pub now: f64,
    /// s.
    pub step: f64,
    /// What lies strictly between these corners is far from walls.
    pub inside: (DVec2, DVec2),
}

impl Flight<'_> {
    /// Where a disc is.
    #[inline(always)]
    pub fn at(&self, k: usize) -> DVec2 {
        self.starts[k] + self.velocities[k] * ((self.now - self.began[k]) * self.step)
    }

    /// Moves all; tells in ascending order which may touch a wall.
    pub fn fly(&self, places: &mut [DVec2], outside: &mut Vec<u32>) {
        let count = places.len();
        assert!([self.starts.len(), self.velocities.len(), self.began.len()] == [count; 3]);
        outside.clear();
        let mut done = 0;
        #[cfg(target_arch = "x86_64")]
        if is_wide() {
            // SAFETY: the processor has what the function asks for; all are equally long.
            done = unsafe { avx2::fly(self, places, outside) };
        }
        self.fly_one_by_one(done, places, outside);
    }

    /// The same on every processor, from a disc on.
    pub fn fly_one_by_one(&self, from: usize, places: &mut [DVec2], outside: &mut Vec<u32>) {
        let (low, high) = self.inside;
        for (k, place) in places.iter_mut().enumerate().skip(from) {
            *place = self.at(k);
            if place.cmple(low).any() || place.cmpge(high).any() {
                outside.push(k as u32);
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn is_wide() -> bool {
    std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::*;

    use super::{Centre, DVec2, Entries, Flight, Look, Pairs, SLACK, TINY, WIDTH};

    /// For each mask of four lanes: where the bytes of those that stay come from.
    static COMPRESS: [[u8; 16]; 16] = compress();

    const fn compress() -> [[u8; 16]; 16] {
        let mut table = [[0x80; 16]; 16];
        let mut mask = 0;
        while mask < 16 {
            let (mut lane, mut to) = (0, 0);
            while lane < 4 {
                if mask & (1 << lane) != 0 {
                    let mut byte = 0;
                    while byte < 4 {
                        table[mask][4 * to + byte] = (4 * lane + byte) as u8;
                        byte += 1;
                    }
                    to += 1;
                }
                lane += 1;
            }
            mask += 1;
        }
        table
    }

    /// Writes the lanes of a mask one after the other; there must be room for four.
    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    unsafe fn put(first: __m128i, second: __m128i, mask: usize, pairs: &mut Pairs, at: &mut usize) {
        // SAFETY: the table has an entry for each mask; the caller made room.
        unsafe {
            let order = _mm_loadu_si128(COMPRESS[mask & 15].as_ptr().cast());
            let (i, j) = (_mm_shuffle_epi8(first, order), _mm_shuffle_epi8(second, order));
            _mm_storeu_si128(pairs.first.as_mut_ptr().add(*at).cast(), i);
            _mm_storeu_si128(pairs.second.as_mut_ptr().add(*at).cast(), j);
        }
        *at += mask.count_ones() as usize;
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub unsafe fn select(list: &Pairs, look: &Look, found: &mut Pairs) {
        // SAFETY: as the caller says.
        unsafe {
            match (look.wrap.is_some(), look.radii.is_empty()) {
                (false, true) => select_as::<false, true>(list, look, found),
                (true, true) => select_as::<true, true>(list, look, found),
                (false, false) => select_as::<false, false>(list, look, found),
                (true, false) => select_as::<true, false>(list, look, found),
            }
        }
    }

    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    unsafe fn select_as<const WRAP: bool, const EQUAL: bool>(
        list: &Pairs,
        look: &Look,
        found: &mut Pairs,
    ) {
        assert!(list.bound <= look.places.len(), "a sealed list of these discs");
        assert!(EQUAL || list.bound <= look.radii.len(), "a radius for each disc");
        found.first.reserve(list.len() + 4);
        found.second.reserve(list.len() + 4);
        let size = look.wrap.unwrap_or(DVec2::ONE);
        let sizes = _mm256_setr_pd(size.x, size.y, size.x, size.y);
        let inverse = size.recip();
        let inverses = _mm256_setr_pd(inverse.x, inverse.y, inverse.x, inverse.y);
        let places = look.places.as_ptr().cast::<f64>();
        let (margin, slack) = (_mm256_set1_pd(look.margin), _mm256_set1_pd(SLACK));
        let (chunks, rest) = list.first.as_chunks::<4>();
        let mut at = 0;
        for (first, second) in chunks.iter().zip(list.second.as_chunks::<4>().0) {
            // SAFETY: all indices are below the bound, which was compared with the lengths.
            let (row, radius) = unsafe {
                let two = |k: u32, l: u32| {
                    let low = _mm_loadu_pd(places.add(2 * k as usize));
                    let high = _mm_loadu_pd(places.add(2 * l as usize));
                    _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
                };
                let radius = |k: u32| *look.radii.get_unchecked(k as usize);
                (two, radius)
            };
            let [mut even, mut odd] = [[0, 2], [1, 3]]
                .map(|[k, l]| _mm256_sub_pd(row(second[k], second[l]), row(first[k], first[l])));
            if WRAP {
                [even, odd] =
                    [even, odd].map(|d| {
                        let whole = _mm256_round_pd::<
                            { _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC },
                        >(_mm256_mul_pd(d, inverses));
                        _mm256_sub_pd(d, _mm256_mul_pd(sizes, whole))
                    });
            }
            let squares = _mm256_hadd_pd(_mm256_mul_pd(even, even), _mm256_mul_pd(odd, odd));
            let reach = if EQUAL {
                _mm256_set1_pd(look.reach)
            } else {
                let of = |k: [u32; 4]| {
                    let [a, b, c, d] = k.map(radius);
                    _mm256_setr_pd(a, b, c, d)
                };
                _mm256_add_pd(of(*first), of(*second))
            };
            let reach = _mm256_mul_pd(_mm256_add_pd(reach, margin), slack);
            let mask = near(squares, _mm256_mul_pd(reach, reach));
            // SAFETY: a list is at least as long as what is found in it, and four more fit.
            unsafe {
                let first = _mm_loadu_si128(first.as_ptr().cast());
                let second = _mm_loadu_si128(second.as_ptr().cast());
                put(first, second, mask, found, &mut at);
            }
        }
        // SAFETY: so many were written.
        unsafe {
            found.first.set_len(at);
            found.second.set_len(at);
        }
        select_rest(list, list.len() - rest.len(), look, found);
    }

    /// The last few of a list.
    #[inline(never)]
    fn select_rest(list: &Pairs, from: usize, look: &Look, found: &mut Pairs) {
        let rest = Pairs {
            first: list.first[from..].to_vec(),
            second: list.second[from..].to_vec(),
            bound: list.bound,
        };
        let mut more = Pairs::default();
        rest.select_one_by_one(look, &mut more);
        found.first.extend(more.first);
        found.second.extend(more.second);
    }

    /// Which squares of distances are at most those of reaches.
    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    fn near(squares: __m256d, reach2: __m256d) -> usize {
        let near = _mm256_cmp_pd::<_CMP_LE_OQ>(squares, reach2);
        let tiny = _mm256_cmp_pd::<_CMP_LT_OQ>(reach2, _mm256_set1_pd(TINY));
        _mm256_movemask_pd(_mm256_or_pd(near, tiny)) as usize
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub unsafe fn scan(
        entries: &Entries,
        centre: &Centre,
        range: std::ops::Range<usize>,
        pairs: &mut Pairs,
    ) {
        let Entries { x, y, radius, disc, .. } = entries;
        let ends = [x.len(), y.len(), radius.len(), disc.len()];
        assert!(ends.iter().all(|end| range.end + WIDTH <= *end));
        pairs.first.reserve(range.len() + 4);
        pairs.second.reserve(range.len() + 4);
        let set = _mm256_set1_pd;
        let (own_x, own_y) = (set(centre.place.x), set(centre.place.y));
        let own = _mm_set1_epi32(centre.disc as i32);
        let (mut slot, mut at) = (range.start, pairs.first.len());
        while slot < range.end {
            // SAFETY: the slots begin in the range; it and what is read beyond it exist.
            let (mut dx, mut dy, radii, other) = unsafe {
                (
                    _mm256_sub_pd(_mm256_loadu_pd(x.as_ptr().add(slot)), own_x),
                    _mm256_sub_pd(_mm256_loadu_pd(y.as_ptr().add(slot)), own_y),
                    _mm256_loadu_pd(radius.as_ptr().add(slot)),
                    _mm_loadu_si128(disc.as_ptr().add(slot).cast()),
                )
            };
            if let Some(size) = centre.wrap {
                (dx, dy) = (wrapped(dx, size.x), wrapped(dy, size.y));
            }
            let squares = _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy));
            let reach = _mm256_mul_pd(_mm256_add_pd(set(centre.reach), radii), set(SLACK));
            let own_part = 15 >> (slot + WIDTH).saturating_sub(range.end);
            let mask = near(squares, _mm256_mul_pd(reach, reach)) & own_part;
            // SAFETY: there is room for the range and four more.
            unsafe {
                let (low, high) = (_mm_min_epu32(own, other), _mm_max_epu32(own, other));
                put(low, high, mask, pairs, &mut at);
            }
            slot += WIDTH;
        }
        // SAFETY: so many were written.
        unsafe {
            pairs.first.set_len(at);
            pairs.second.set_len(at);
        }
        pairs.bound = usize::MAX;
    }

    #[target_feature(enable = "avx2,popcnt")]
    #[inline]
    fn wrapped(d: __m256d, size: f64) -> __m256d {
        let whole = _mm256_round_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(
            _mm256_mul_pd(d, _mm256_set1_pd(size.recip())),
        );
        _mm256_sub_pd(d, _mm256_mul_pd(_mm256_set1_pd(size), whole))
    }

    /// Two discs at a time; returns how many were moved.
    #[target_feature(enable = "avx2,popcnt")]
    pub unsafe fn fly(flight: &Flight, places: &mut [DVec2], outside: &mut Vec<u32>) -> usize {
        let (low, high) = flight.inside;
        let low = _mm256_setr_pd(low.x, low.y, low.x, low.y);
        let high = _mm256_setr_pd(high.x, high.y, high.x, high.y);
        let (now, step) = (_mm_set1_pd(flight.now), _mm_set1_pd(flight.step));
        let twos = places.len() / 2;
        for two in 0..twos {
            let k = 2 * two;
            // SAFETY: the caller says that all are equally long; a vector is two doubles in a row.
            let place = unsafe {
                let began = _mm_loadu_pd(flight.began.as_ptr().add(k));
                let time = _mm_mul_pd(_mm_sub_pd(now, began), step);
                let time = _mm256_permute4x64_pd::<0b01_01_00_00>(_mm256_castpd128_pd256(time));
                let start = _mm256_loadu_pd(flight.starts.as_ptr().add(k).cast());
                let velocity = _mm256_loadu_pd(flight.velocities.as_ptr().add(k).cast());
                let place = _mm256_add_pd(start, _mm256_mul_pd(velocity, time));
                _mm256_storeu_pd(places.as_mut_ptr().add(k).cast(), place);
                place
            };
            let beyond = _mm256_or_pd(
                _mm256_cmp_pd::<_CMP_LE_OQ>(place, low),
                _mm256_cmp_pd::<_CMP_GE_OQ>(place, high),
            );
            let mask = _mm256_movemask_pd(beyond);
            if mask != 0 {
                outside.extend((mask & 3 != 0).then_some(k as u32));
                outside.extend((mask & 12 != 0).then_some(k as u32 + 1));
            }
        }
        2 * twos
    }
}
