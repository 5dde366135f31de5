//! The calendar: which disc is due next, for all times of one epoch.
//!
//! An epoch is cut into days of a power of two of seconds. A day's entries lie unsorted in chunks
//! until the day comes; then those that still hold are sorted, and later ones inserted in place
//! (after Brown 1988, doi:10.1145/63039.63045, and Paul 2007, doi:10.1016/j.jcp.2006.06.042). An
//! entry is one number: the time within its day above, the disc below, so sorting needs nothing
//! else. Nothing is ever removed: an entry holds if its disc is still due at that time.
//!
//! Never ask here what is due: the engine knows.

use super::lanes::{Unit, whole_part};
use super::pages;

/// Entries in a chunk: two cache lines.
const CHUNK: usize = 16;

/// No chunk.
const NONE: u32 = u32::MAX;

/// The entries of one epoch.
#[derive(Clone, Debug)]
pub struct Calendar {
    /// Length of a day, s: a power of two.
    day: f64,
    per_second: f64,
    disc_bits: u32,
    /// In which a day is counted.
    steps: f64,
    days: Vec<Day>,
    /// Days up to now, up to tomorrow, and in the epoch; the first is -1 before the first day.
    today: f64,
    tomorrow: f64,
    end: f64,
    /// Today's entries, latest first.
    open: Vec<u64>,
    chunks: Vec<Chunk>,
    free: u32,
}

#[derive(Clone, Copy, Debug)]
struct Day {
    chunk: u32,
    entries: u32,
}

#[derive(Clone, Copy, Debug)]
struct Chunk {
    entries: [u64; CHUNK],
    next: u32,
}

const EMPTY: Day = Day { chunk: NONE, entries: 0 };

impl Calendar {
    /// An empty calendar of so many days, for so many discs. `day` (s) is a power of two.
    pub fn new(day: f64, days: usize, discs: usize) -> Self {
        let mut calendar = Self {
            day,
            per_second: day.recip(),
            disc_bits: 0,
            steps: 0.0,
            days: vec![EMPTY; days],
            today: -1.0,
            tomorrow: 0.0,
            end: days as f64,
            open: Vec::new(),
            // Nearly all that a calendar ever holds.
            chunks: pages::with_room_for(2 * discs / CHUNK),
            free: NONE,
        };
        calendar.make_room_for(discs);
        calendar
    }

    /// Lets entries name so many discs; what is in the calendar no longer holds.
    pub fn make_room_for(&mut self, discs: usize) {
        self.disc_bits = usize::BITS - discs.max(2).leading_zeros();
        self.steps = (1u64 << (63 - self.disc_bits)) as f64;
    }

    /// Whether entries can name so many discs.
    pub fn has_room_for(&self, discs: usize) -> bool {
        usize::BITS - discs.max(2).leading_zeros() <= self.disc_bits
    }

    /// Length of the epoch, s.
    pub fn epoch(&self) -> f64 {
        self.day * self.days.len() as f64
    }

    /// Days in the epoch.
    pub fn days(&self) -> usize {
        self.days.len()
    }

    /// When today began, s; the start of the epoch before the first day.
    pub fn today(&self) -> f64 {
        self.today.max(0.0) * self.day
    }

    /// Length of a day, s.
    pub fn day(&self) -> f64 {
        self.day
    }

    /// Starts again before the first day, with other days and without entries.
    pub fn restart(&mut self, day: f64, days: usize) {
        (self.day, self.per_second) = (day, day.recip());
        (self.today, self.tomorrow, self.end) = (-1.0, 0.0, days as f64);
        self.open.clear();
        self.days.clear();
        self.days.resize(days, EMPTY);
        self.chunks.clear();
        self.free = NONE;
    }

    /// Notes that a disc is due; times beyond the epoch are not noted.
    #[inline(always)]
    pub fn insert(&mut self, time: f64, disc: usize) {
        let scaled = time * self.per_second;
        if scaled < self.tomorrow {
            return self.insert_today(scaled, disc);
        }
        if scaled < self.end {
            let day = whole_part(scaled);
            self.append(day as usize, self.entry(scaled - day as f64, disc));
        }
    }

    /// Late for today; and a time that rounded to before it comes first.
    fn insert_today(&mut self, scaled: f64, disc: usize) {
        let entry = self.entry((scaled - self.today).max(0.0), disc);
        let mut at = self.open.len();
        self.open.push(entry);
        while at > 0 && self.open[at - 1] < entry {
            self.open[at] = self.open[at - 1];
            at -= 1;
        }
        self.open[at] = entry;
    }

    /// Whether this is the entry of a disc that is due today at `time`.
    #[inline(always)]
    pub fn holds(&self, entry: u64, time: f64) -> bool {
        self.entry_at(time, self.disc(entry)) == entry
    }

    /// No entry of today up to `time` is later than this.
    #[inline(always)]
    pub fn latest(&self, time: f64) -> u64 {
        self.entry_at(time, (1 << self.disc_bits) - 1)
    }

    /// The entry for a time of today; for a later time later than all.
    #[inline(always)]
    fn entry_at(&self, time: f64, disc: usize) -> u64 {
        self.entry((time * self.per_second - self.today).clamp(0.0, 1.0), disc)
    }

    /// The disc of an entry.
    #[inline(always)]
    pub fn disc(&self, entry: u64) -> usize {
        (entry & ((1 << self.disc_bits) - 1)) as usize
    }

    /// Today's entries that are left, the next one last.
    #[inline(always)]
    pub fn open(&self) -> &[u64] {
        &self.open
    }

    /// Takes the next entry of today out.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<u64> {
        self.open.pop()
    }

    /// Whether today is the last day.
    pub fn is_last_day(&self) -> bool {
        self.tomorrow == self.end
    }

    /// When tomorrow begins, s.
    pub fn tomorrow(&self) -> f64 {
        self.tomorrow * self.day
    }

    /// Goes on to the next day and sorts those of its entries that hold. `due` is the time at
    /// which a disc is due.
    #[inline(always)]
    pub fn next_day<U: Unit>(&mut self, due: impl Fn(usize) -> f64) {
        debug_assert!(self.open.is_empty());
        (self.today, self.tomorrow) = (self.tomorrow, self.tomorrow + 1.0);
        let today = &mut self.days[self.today as usize];
        let Day { mut chunk, entries } = std::mem::replace(today, EMPTY);
        if entries == 0 {
            return;
        }
        self.open.resize(entries as usize, 0);
        let (mut kept, mut used) = (0, (entries as usize - 1) % CHUNK + 1);
        while chunk != NONE {
            let Chunk { entries, next } = self.chunks[chunk as usize];
            for &entry in &entries[..used] {
                self.open[kept] = entry;
                kept += usize::from(self.holds(entry, due(self.disc(entry))));
            }
            used = CHUNK;
            self.chunks[chunk as usize].next = self.free;
            self.free = chunk;
            chunk = next;
        }
        self.open.truncate(kept);
        U::sort_few(&mut self.open);
    }

    #[inline(always)]
    fn entry(&self, part_of_day: f64, disc: usize) -> u64 {
        (whole_part(part_of_day * self.steps) << self.disc_bits) | disc as u64
    }

    #[inline(always)]
    fn append(&mut self, day: usize, entry: u64) {
        let Day { chunk, entries } = self.days[day];
        let at = entries as usize % CHUNK;
        let chunk = if at == 0 { self.new_chunk(chunk) } else { chunk };
        self.chunks[chunk as usize].entries[at] = entry;
        self.days[day] = Day { chunk, entries: entries + 1 };
    }

    #[inline(never)]
    fn new_chunk(&mut self, next: u32) -> u32 {
        if self.free == NONE {
            pages::make_room_for_one(&mut self.chunks);
            self.chunks.push(Chunk { entries: [0; CHUNK], next });
            return (self.chunks.len() - 1) as u32;
        }
        let chunk = self.free;
        self.free = self.chunks[chunk as usize].next;
        self.chunks[chunk as usize].next = next;
        chunk
    }
}
