//! Every touching pair by a uniform grid: a disc is tested against those in its own and the eight
//! neighbouring cells only.
//!
//! Cells are as wide as the largest reach of the ordinary discs. There are about as many as discs:
//! the plane is wrapped around them, so that far outliers cost nothing and only meet strangers.
//! Discs much larger than the mean would blow up the cells: these few are tested against all.
//! Judged by [`super::all_pairs`].

use std::ops::{ControlFlow, Range};

use glam::DVec2;

use super::touching::touch;
use super::{Pair, Pairs, TooManyPairs};
use crate::world::Disc;

/// Discs with a radius above so many times the mean are tested against all others.
const LARGE_RADIUS_RATIO: f64 = 4.0;

/// All pairs that touch (gap at most `margin`, m), in ascending order of indices.
///
/// # Errors
/// [`TooManyPairs`] when the discs are heaped on each other beyond the limit.
pub fn touching_pairs(discs: &[Disc], margin: f64) -> Result<Vec<Pair>, TooManyPairs> {
    let mean = discs.iter().map(|disc| disc.radius).sum::<f64>() / discs.len() as f64;
    let large_from = mean * LARGE_RADIUS_RATIO;
    let (large, ordinary): (Vec<usize>, Vec<usize>) =
        (0..discs.len()).partition(|&k| discs[k].radius > large_from);
    let mut pairs = Pairs::default();
    for &i in &large {
        for j in 0..discs.len() {
            // Two large discs would find each other twice: keep the ordered one.
            let twice = discs[j].radius > large_from && j <= i;
            if !twice && touch(&discs[i], &discs[j], margin) {
                pairs.add(i, j)?;
            }
        }
    }
    let radius = ordinary.iter().map(|&k| discs[k].radius).fold(0.0, f64::max);
    let cells = Cells::new(discs, &ordinary, radius, margin);
    let outcome = cells.for_each_near_pair(|i, j| {
        if touch(&discs[i], &discs[j], margin) {
            return pairs.add(i, j).map_or_else(ControlFlow::Break, ControlFlow::Continue);
        }
        ControlFlow::Continue(())
    });
    match outcome {
        ControlFlow::Break(error) => Err(error),
        ControlFlow::Continue(()) => Ok(pairs.sorted()),
    }
}

/// What the first test needs of a disc, in the order of cells.
#[derive(Clone, Copy, Default)]
struct Entry {
    position: DVec2,
    radius: f64,
    disc: u32,
}

/// Discs sorted by cell. Columns and rows are powers of two, at least 4: the cells around a cell
/// are then nine different ones.
struct Cells {
    columns: usize,
    rows: usize,
    /// Cell `c` holds the entries `starts[c] .. starts[c + 1]`; row by row.
    starts: Vec<u32>,
    entries: Vec<Entry>,
    margin: f64,
}

impl Cells {
    /// Sorts `chosen` discs, the largest of this radius, into cells (counting sort).
    fn new(discs: &[Disc], chosen: &[usize], radius: f64, margin: f64) -> Self {
        // A hair wider than the reach: the rounding of a cell's index can then not hide a pair.
        let width = (2.0 * radius + margin) * 1.001;
        let (columns, rows) = size(discs, chosen, width);
        let cell_of = |k: usize| {
            let index = discs[k].position / width;
            let (x, y) = (floor(index.x) as usize, floor(index.y) as usize);
            (y & (rows - 1)) * columns + (x & (columns - 1))
        };
        let cells: Vec<u32> = chosen.iter().map(|&k| cell_of(k) as u32).collect();
        let mut starts = vec![0u32; columns * rows + 1];
        cells.iter().for_each(|&cell| starts[cell as usize + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut free = starts.clone();
        let mut entries = vec![Entry::default(); chosen.len()];
        for (&k, &cell) in chosen.iter().zip(&cells) {
            let Disc { position, radius, .. } = discs[k];
            entries[free[cell as usize] as usize] = Entry { position, radius, disc: k as u32 };
            free[cell as usize] += 1;
        }
        Self { columns, rows, starts, entries, margin }
    }

    /// Calls `found` once for each two discs that are near enough to be looked at exactly, until
    /// it breaks.
    fn for_each_near_pair<E>(
        &self,
        mut found: impl FnMut(usize, usize) -> ControlFlow<E>,
    ) -> ControlFlow<E> {
        for y in 0..self.rows {
            for x in 0..self.columns {
                let cell = y * self.columns + x;
                let end = self.starts[cell + 1] as usize;
                for slot in self.starts[cell] as usize..end {
                    self.near(slot, slot + 1..end, &mut found)?;
                    for range in self.ahead(x, y) {
                        self.near(slot, range, &mut found)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Half of the cells around a cell, as ranges of entries: the other half sees it from there.
    fn ahead(&self, x: usize, y: usize) -> [Range<usize>; 4] {
        let right = (x + 1) & (self.columns - 1);
        let left = x.wrapping_sub(1) & (self.columns - 1);
        let above = (y + 1) & (self.rows - 1);
        [(right, y), (left, above), (x, above), (right, above)].map(|(x, y)| {
            let cell = y * self.columns + x;
            self.starts[cell] as usize..self.starts[cell + 1] as usize
        })
    }

    /// Passes on the entries of a range that may touch the one in a slot.
    fn near<E>(
        &self,
        slot: usize,
        range: Range<usize>,
        found: &mut impl FnMut(usize, usize) -> ControlFlow<E>,
    ) -> ControlFlow<E> {
        let a = self.entries[slot];
        for b in &self.entries[range] {
            let reach = a.radius + b.radius + self.margin;
            // Never rejects a touching pair: the exact test has the last word. Overflow makes both
            // sides infinite; squares near underflow have lost digits.
            let distance2 = (b.position - a.position).length_squared();
            let reach2 = reach * reach * (1.0 + 1e-14);
            if distance2 <= reach2 || reach2 < 1e-280 {
                found(a.disc as usize, b.disc as usize)?;
            }
        }
        ControlFlow::Continue(())
    }
}

/// The integer below; saturates beyond 2^63, which keeps neighbours neighbours. Without a call:
/// the plain x86-64 instruction set has no rounding to integers.
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > x))
}

/// Columns and rows: as many as the discs are spread over, but together at most eight a disc.
fn size(discs: &[Disc], chosen: &[usize], width: f64) -> (usize, usize) {
    let positions = || chosen.iter().map(|&k| discs[k].position);
    let min = positions().fold(DVec2::INFINITY, DVec2::min);
    let max = positions().fold(DVec2::NEG_INFINITY, DVec2::max);
    let spread = ((max - min) / width).min(DVec2::splat(1e6));
    let cells = |spread: f64| (spread as usize + 1).next_power_of_two().max(4);
    let (mut columns, mut rows) = (cells(spread.x), cells(spread.y));
    while columns * rows > (8 * chosen.len()).max(16) {
        let longer = if columns > rows { &mut columns } else { &mut rows };
        *longer /= 2;
    }
    (columns, rows)
}
