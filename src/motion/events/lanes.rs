//! Who is near, and the earliest meeting with one of them: many at a time where the processor can.
//!
//! The same operations in the same order in all forms, none of them fused, so the bits are the same
//! on every processor; a test holds that. With [`vectors`] one of the few with unsafe code: it
//! calls what the processor was asked for, and prefetches.
#![allow(unsafe_code, reason = "measured: about twice as fast, carom bench gas")]

#[cfg(target_arch = "x86_64")]
mod vectors;

use glam::DVec2;

use super::cells::{Block, ROOM_MAX};
use super::{Events, Flight};
use crate::motion::Witness;
use crate::motion::plain::Stall;

/// What the discs that look can see, and when.
#[derive(Clone, Copy, Debug)]
pub struct Sight<'a> {
    /// What the cells hold.
    pub numbers: &'a [u32],
    /// How all discs fly.
    pub flights: &'a [Flight],
    /// Their radii, m; empty where all are equal.
    pub radii: &'a [f64],
    /// The square of the sum of two radii, m^2, where all are equal.
    pub square: f64,
    /// The present, s.
    pub now: f64,
    /// The periodic box, where its border may lie between.
    pub wrap: Option<Wrap>,
    /// Meetings that follow the earliest within this time are at the same instant, s.
    pub instant: f64,
}

impl Sight<'_> {
    /// Square of the distance at which two discs touch, m^2.
    #[inline(always)]
    fn square_of(&self, disc: usize, with: u32) -> f64 {
        if self.radii.is_empty() {
            return self.square;
        }
        let reach = self.radii[disc] + self.radii[with as usize];
        reach * reach
    }
}

/// Sides of a periodic box, m, and one over them.
#[derive(Clone, Copy, Debug)]
pub struct Wrap {
    size: DVec2,
    per_size: DVec2,
}

impl Wrap {
    /// One that leaves every difference as it is.
    pub const NONE: Self = Self { size: DVec2::ONE, per_size: DVec2::ZERO };

    /// Of a box of this size, m.
    pub fn new(size: DVec2) -> Self {
        Self { size, per_size: size.recip() }
    }

    /// A difference of two positions, seen from the nearest image.
    #[inline(always)]
    pub fn nearest(&self, d: DVec2) -> DVec2 {
        d - self.size * ((d * self.per_size + WHOLE) - WHOLE)
    }
}

/// The earliest meeting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// When, s; infinite = none.
    pub time: f64,
    /// With which disc.
    pub with: u32,
    /// Whether another one is at the same instant.
    pub tie: bool,
}

/// No meeting.
pub const NOBODY: Meeting = Meeting { time: f64::INFINITY, with: u32::MAX, tie: false };

impl Meeting {
    /// The earliest of the meetings with the discs `near`, at `times`; of equals the first.
    pub fn earliest(near: &[u32], times: &[f64], instant: f64) -> Self {
        let mut found = NOBODY;
        for (&with, &time) in near.iter().zip(times) {
            if time < found.time {
                (found.time, found.with) = (time, with);
            }
        }
        let latest = found.time + instant;
        let tied = times.iter().filter(|time| **time <= latest).count() > 1;
        Self { tie: tied && found.time < f64::INFINITY, ..found }
    }
}

/// How discs that are near and meetings with them are looked for.
pub trait Unit {
    /// Whether the arena is known to be [bare](Events::is_bare).
    const BARE: bool;
    /// Whether masses are known to be equal too, and nothing to be lost.
    const ALIKE: bool;

    /// Names in `near` the discs of a block, behind those named there already.
    fn gather(numbers: &[u32], block: &Block, near: &mut Near);

    /// The earliest meeting of a disc with those named in `near`.
    fn earliest_gathered(sight: &Sight, disc: usize, near: &mut Near) -> Meeting;

    /// The earliest meeting of a disc with those of a block, which are named in `near`. It may be
    /// one of them: nobody comes nearer to itself.
    fn earliest(sight: &Sight, block: &Block, disc: usize, near: &mut Near) -> Meeting;

    /// The same for two that look at once.
    fn earliest_of_two(
        sight: &Sight,
        blocks: &[Block; 2],
        discs: [usize; 2],
        [near_a, near_b]: &mut [Near; 2],
    ) -> [Meeting; 2] {
        let a = Self::earliest(sight, &blocks[0], discs[0], near_a);
        [a, Self::earliest(sight, &blocks[1], discs[1], near_b)]
    }

    /// Asks for the flights of the discs of a block, which are named in `near`.
    #[inline(always)]
    fn fetch_flights(numbers: &[u32], flights: &[Flight], block: &Block, near: &mut Near) {
        near.clear();
        Self::gather(numbers, block, near);
        let count = near.count;
        near.discs[count..count + 8].fill(0);
        let first = &near.discs[..8];
        // A loop that is always as long is foreseen.
        first.iter().for_each(|&disc| prefetch(flights, disc as usize));
        if count > 8 {
            near.discs[8..count].iter().for_each(|&disc| prefetch(flights, disc as usize));
        }
    }

    /// Changes the velocity of a flight.
    fn deflect(flight: &mut Flight, now: f64, by: DVec2) {
        flight.deflect(now, by);
    }

    /// Sorts a few numbers below 2^63, the largest first.
    fn sort_few(numbers: &mut [u64]) {
        numbers.sort_unstable_by(|a, b| b.cmp(a));
    }

    // Functions of [`Events`] of which there shall be one copy, made for the processor.

    /// [`Events::predict_again`]
    #[inline(never)]
    fn renew(arena: &mut Events, k: usize, noted: f64)
    where
        Self: Sized,
    {
        arena.predict_again::<Self>(k, noted);
    }

    /// [`Events::predict_two_again`]
    #[inline(never)]
    fn renew_two(arena: &mut Events, i: usize, j: usize, noted: f64)
    where
        Self: Sized,
    {
        arena.predict_two_again::<Self>(i, j, noted);
    }

    /// [`Events::open_next_day`]
    #[inline(never)]
    fn next_day(arena: &mut Events)
    where
        Self: Sized,
    {
        arena.open_next_day::<Self>();
    }
}

/// Discs that are near, and when they are met.
#[derive(Clone, Debug)]
pub struct Near {
    count: usize,
    /// The discs, and room for whole vectors behind them.
    discs: [u32; NEAR_MAX + SLACK],
    /// When each is met, s.
    times: [f64; NEAR_MAX + SLACK],
    /// Those that come nearer, and of these the ones that may meet: for who looks one by one.
    nearing: [Nearing; NEAR_MAX + SLACK],
    crossing: [Crossing; NEAR_MAX + SLACK],
}

/// Most discs of a block.
const BLOCK_MAX: usize = 9 * ROOM_MAX;

/// Most discs that are near: some blocks may be gathered before anybody is met.
const NEAR_MAX: usize = 3 * BLOCK_MAX;

/// Room for whole vectors.
const SLACK: usize = 12;

impl Default for Near {
    fn default() -> Self {
        Self {
            count: 0,
            discs: [0; NEAR_MAX + SLACK],
            times: [f64::INFINITY; NEAR_MAX + SLACK],
            nearing: [Nearing::default(); NEAR_MAX + SLACK],
            crossing: [Crossing::default(); NEAR_MAX + SLACK],
        }
    }
}

impl Near {
    /// The discs that are near.
    pub fn discs(&self) -> &[u32] {
        &self.discs[..self.count]
    }

    /// Nobody is near.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether so many more may be named.
    pub fn has_room(&self, count: usize) -> bool {
        self.count + count <= NEAR_MAX
    }

    /// Names one more disc, for which there must be room.
    pub fn push(&mut self, disc: u32) {
        self.discs[self.count] = disc;
        self.count += 1;
    }

    /// When each of them is met, s, once that was looked for; infinite = never.
    pub fn times(&self) -> &[f64] {
        &self.times[..self.count]
    }
}

/// What the processor of this machine can do, to be chosen from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lanes(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    OneByOne,
    #[cfg(target_arch = "x86_64")]
    Four,
}

impl Lanes {
    /// All that this processor has, the best one last.
    pub fn all() -> Vec<Self> {
        let mut all = vec![Self(Kind::OneByOne)];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") && has!("popcnt") && has!("bmi1") {
                all.push(Self(Kind::Four));
            }
        }
        all
    }

    /// The best that this processor has.
    pub fn best() -> Self {
        Self::all().pop().unwrap_or(Self(Kind::OneByOne))
    }

    /// What every processor has.
    pub fn portable() -> Self {
        Self(Kind::OneByOne)
    }

    /// [`Events::advance`] with it.
    pub fn advance<W: Witness>(
        self,
        arena: &mut Events,
        until: f64,
        witness: &mut W,
    ) -> Result<(), Stall> {
        let (bare, alike) = (arena.is_bare(), arena.is_alike());
        match (self.0, bare, bare && alike) {
            (Kind::OneByOne, true, true) => {
                arena.advance_with::<OneByOne<true, true>, W>(until, witness)
            }
            (Kind::OneByOne, true, false) => {
                arena.advance_with::<OneByOne<true, false>, W>(until, witness)
            }
            (Kind::OneByOne, ..) => arena.advance_with::<OneByOne<false, false>, W>(until, witness),
            // SAFETY: the processor was asked for what the functions need.
            #[cfg(target_arch = "x86_64")]
            (Kind::Four, true, true) => unsafe {
                vectors::advance::<true, true, W>(arena, until, witness)
            },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            (Kind::Four, true, false) => unsafe {
                vectors::advance::<true, false, W>(arena, until, witness)
            },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            (Kind::Four, ..) => unsafe {
                vectors::advance::<false, false, W>(arena, until, witness)
            },
        }
    }

    /// Predicts these discs again, with it.
    pub fn renew_all(self, arena: &mut Events, discs: &[usize]) {
        match self.0 {
            Kind::OneByOne => arena.renew_all::<OneByOne<false, false>>(discs),
            // SAFETY: the processor was asked for what the functions need.
            #[cfg(target_arch = "x86_64")]
            _ => unsafe { vectors::renew_all(arena, discs) },
        }
    }
}

/// One at a time, on every processor.
pub struct OneByOne<const BARE: bool, const ALIKE: bool>;

impl<const BARE: bool, const ALIKE: bool> Unit for OneByOne<BARE, ALIKE> {
    const BARE: bool = BARE;
    const ALIKE: bool = ALIKE;

    fn gather(numbers: &[u32], block: &Block, near: &mut Near) {
        let mut count = near.count;
        for row in block.rows() {
            for four in numbers[row].as_chunks::<4>().0 {
                // Of all numbers in cells only EMPTY has the highest bit, and it stands last.
                near.discs[count..count + 4].copy_from_slice(four);
                count += four.iter().map(|number| 1 - (number >> 31)).sum::<u32>() as usize;
            }
        }
        near.count = count;
    }

    fn earliest(sight: &Sight, block: &Block, disc: usize, near: &mut Near) -> Meeting {
        near.clear();
        Self::gather(sight.numbers, block, near);
        Self::earliest_gathered(sight, disc, near)
    }

    /// In three rounds, of which each keeps some without a branch: half of all come nearer, half of
    /// these meet.
    fn earliest_gathered(sight: &Sight, disc: usize, near: &mut Near) -> Meeting {
        let mut nearing = 0;
        for (place, &with) in near.discs[..near.count].iter().enumerate() {
            near.nearing[nearing] = Nearing { place, ..Nearing::of(sight, disc, with) };
            nearing += usize::from(near.nearing[nearing].b < 0.0);
        }
        let mut crossing = 0;
        for pair in &near.nearing[..nearing] {
            let with = near.discs[pair.place];
            near.crossing[crossing] = Crossing::of(pair, sight.square_of(disc, with));
            crossing += usize::from(near.crossing[crossing].root >= 0.0);
        }
        if !BARE {
            near.times[..near.count].fill(f64::INFINITY);
        }
        let (mut found, crossing) = (NOBODY, &mut near.crossing[..crossing]);
        for Crossing { place, time, .. } in crossing.iter_mut().map(|met| met.at(sight.now)) {
            if !BARE {
                near.times[*place] = *time;
            }
            if *time < found.time {
                (found.time, found.with) = (*time, near.discs[*place]);
            }
        }
        let latest = found.time + sight.instant;
        let tied = crossing.iter().filter(|met| met.time <= latest).count() > 1;
        Meeting { tie: tied && found.time < f64::INFINITY, ..found }
    }
}

/// What rounds a double to a whole number when it is added and taken away again.
const WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// When a disc meets another, s.
pub fn meeting(sight: &Sight, disc: usize, with: usize) -> Option<f64> {
    let pair = Nearing::of(sight, disc, with as u32);
    let square = sight.square_of(disc, with as u32);
    let mut met = (pair.b < 0.0).then(|| Crossing::of(&pair, square))?;
    (met.root >= 0.0).then(|| met.at(sight.now).time)
}

/// A disc as another one sees it.
#[derive(Clone, Copy, Debug, Default)]
struct Nearing {
    d: DVec2,
    w: DVec2,
    /// `d.w`: below 0 they come nearer.
    b: f64,
    /// Where the disc stands among those that are near.
    place: usize,
}

impl Nearing {
    #[inline(always)]
    fn of(sight: &Sight, disc: usize, with: u32) -> Self {
        let (own, other) = (&sight.flights[disc], &sight.flights[with as usize]);
        let w = other.velocity() - own.velocity();
        let mut d = (other.start() - own.start()) + w * sight.now;
        if let Some(wrap) = sight.wrap {
            d = wrap.nearest(d);
        }
        Self { d, w, b: d.x * w.x + d.y * w.y, place: 0 }
    }
}

/// What the time of contact of two that come nearer is made of.
#[derive(Clone, Copy, Debug, Default)]
struct Crossing {
    /// Below 0 they pass each other.
    root: f64,
    b: f64,
    c: f64,
    /// As in [`Nearing`].
    place: usize,
    /// When they meet, s.
    time: f64,
}

impl Crossing {
    /// `square`: of the distance at contact, m^2.
    #[inline(always)]
    fn of(&Nearing { d, w, b, place }: &Nearing, square: f64) -> Self {
        let cross = d.x * w.y - d.y * w.x;
        let root = square * (w.x * w.x + w.y * w.y) - cross * cross;
        let c = (d.x * d.x + d.y * d.y - square).max(0.0);
        Self { root, b, c, place, time: 0.0 }
    }

    #[inline(always)]
    fn at(&mut self, now: f64) -> &Self {
        self.time = now + self.c / (self.root.sqrt() - self.b);
        self
    }
}

/// The whole part of a number that is not negative and far below 2^63.
#[inline(always)]
pub fn whole_part(x: f64) -> u64 {
    debug_assert!((0.0..9e18).contains(&x));
    let x = if x < 9e18 { x } else { 0.0 };
    // SAFETY: it is in range, and no number was taken for 0.
    unsafe { x.to_int_unchecked::<i64>() as u64 }
}

/// Asks for the line of memory of an element before it is needed.
#[inline(always)]
pub fn prefetch<T>(items: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a prefetch reads nothing, wherever it points to.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(items.as_ptr().wrapping_add(index).cast()) };
    }
}
