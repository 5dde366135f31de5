//! Every touching pair by a uniform grid: a disc is tested against those in its own and the eight
//! neighbouring cells only.
//!
//! Cells are as wide as the largest reach of the ordinary discs and live in a hash table, so far
//! outliers cost nothing. Discs much larger than the mean would blow up the cells: these few are
//! tested against all. Judged by [`super::all_pairs`].

use std::ops::ControlFlow;

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
    let mean = discs.iter().map(|disc| disc.radius / discs.len() as f64).sum::<f64>();
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
    let cells = Cells::new(discs, &ordinary, 2.0 * radius + margin);
    let outcome = cells.for_each_neighbour_pair(|i, j| {
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

/// A cell's column and row.
type Cell = (i32, i32);

/// Discs sorted by cell, with a hash table of where each cell begins.
struct Cells {
    /// Entry `h` .. entry `h + 1` of `members` hash to `h`.
    starts: Vec<u32>,
    members: Vec<(Cell, u32)>,
    mask: u32,
}

impl Cells {
    /// Sorts `chosen` discs into cells at least `reach` wide (counting sort by hash).
    fn new(discs: &[Disc], chosen: &[usize], reach: f64) -> Self {
        // A hair wider than the reach: the rounding of a cell's index can then not hide a pair.
        let width = reach * 1.001;
        let mask = (2 * chosen.len().max(1)).next_power_of_two() as u32 - 1;
        let cells: Vec<Cell> = chosen.iter().map(|&k| cell_of(discs[k].position, width)).collect();
        let mut starts = vec![0u32; mask as usize + 2];
        cells.iter().for_each(|&cell| starts[(hash(cell) & mask) as usize + 1] += 1);
        for h in 1..starts.len() {
            starts[h] += starts[h - 1];
        }
        let mut free = starts.clone();
        let mut members = vec![((0, 0), 0); chosen.len()];
        for (&k, &cell) in chosen.iter().zip(&cells) {
            let slot = &mut free[(hash(cell) & mask) as usize];
            members[*slot as usize] = (cell, k as u32);
            *slot += 1;
        }
        Self { starts, members, mask }
    }

    /// Calls `found` once for each two discs in the same or in neighbouring cells, until it breaks.
    fn for_each_neighbour_pair<E>(
        &self,
        mut found: impl FnMut(usize, usize) -> ControlFlow<E>,
    ) -> ControlFlow<E> {
        // Half of the neighbours: the other half finds the same pairs from its side.
        const AHEAD: [Cell; 4] = [(1, -1), (1, 0), (1, 1), (0, 1)];
        for (slot, &(cell, i)) in self.members.iter().enumerate() {
            let bucket_end = self.starts[(hash(cell) & self.mask) as usize + 1] as usize;
            for &(other, j) in &self.members[slot + 1..bucket_end] {
                if other == cell {
                    found(i as usize, j as usize)?;
                }
            }
            for (dx, dy) in AHEAD {
                let (Some(x), Some(y)) = (cell.0.checked_add(dx), cell.1.checked_add(dy)) else {
                    continue;
                };
                for j in self.in_cell((x, y)) {
                    found(i as usize, j)?;
                }
            }
        }
        ControlFlow::Continue(())
    }

    /// Discs in one cell.
    fn in_cell(&self, cell: Cell) -> impl Iterator<Item = usize> + '_ {
        let h = (hash(cell) & self.mask) as usize;
        let bucket = self.starts[h] as usize..self.starts[h + 1] as usize;
        self.members[bucket]
            .iter()
            .filter(move |&&(other, _)| other == cell)
            .map(|&(_, k)| k as usize)
    }
}

/// The cell of a position. Beyond 2^31 cells all share the last one, which keeps neighbours
/// neighbours.
fn cell_of(position: DVec2, width: f64) -> Cell {
    let index = (position / width).floor();
    (index.x as i32, index.y as i32)
}

fn hash((x, y): Cell) -> u32 {
    (x as u32).wrapping_mul(0x9E37_79B1).wrapping_add((y as u32).wrapping_mul(0x85EB_CA77)) >> 7
}
