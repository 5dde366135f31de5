//! A grid of cells that lists who is near whom, into buffers that are kept.
//!
//! The plane is wrapped around as many cells as there are discs, so that outliers cost nothing; a
//! periodic box is divided into whole cells. Never decide here who meets: only who is near.

use glam::DVec2;

use super::bodies::Seen;
use crate::world::Periodic;

/// Up to so many discs looking at all is quicker than sorting into cells.
const ALL_UP_TO: usize = 32;

/// Discs with a radius above so many times the mean are near to all.
const LARGE_RADIUS_RATIO: f64 = 4.0;

/// What a cell knows of a disc.
#[derive(Clone, Copy, Debug, Default)]
struct Entry {
    position: DVec2,
    radius: f64,
    disc: u32,
}

/// Discs sorted by cell.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    periodic: Option<Periodic>,
    /// Columns and rows.
    counts: [usize; 2],
    /// Width and height of a cell, m.
    size: DVec2,
    /// Cell `c` holds the entries `starts[c] .. starts[c + 1]`; row by row.
    starts: Vec<u32>,
    free: Vec<u32>,
    cell_of: Vec<u32>,
    entries: Vec<Entry>,
    large: Vec<Entry>,
    large_from: f64,
    margin: f64,
}

impl Cells {
    /// In a periodic box, or none.
    pub fn new(periodic: Option<Periodic>) -> Self {
        Self { periodic, ..Self::default() }
    }

    /// Sorts discs, so that all with a gap up to `margin` (m) can be listed.
    pub fn sort(&mut self, seen: &[Seen], radius_mean: f64, margin: f64) {
        self.large_from = LARGE_RADIUS_RATIO * radius_mean;
        self.margin = margin;
        let ordinary = seen.iter().map(|disc| disc.radius).filter(|r| *r <= self.large_from);
        // A hair wider than the reach: the rounding of a cell's index can then not hide a pair.
        let width = (2.0 * ordinary.fold(0.0, f64::max) + margin) * 1.001;
        self.divide(seen, width);
        self.large.clear();
        self.starts.clear();
        self.starts.resize(self.counts[0] * self.counts[1] + 1, 0);
        self.cell_of.clear();
        for (k, disc) in (0..).zip(seen) {
            let cell = self.cell(disc.position);
            self.cell_of.push(cell as u32);
            if disc.radius > self.large_from {
                self.large.push(entry(k, disc));
            } else {
                self.starts[cell + 1] += 1;
            }
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        self.free.clone_from(&self.starts);
        self.entries.clear();
        self.entries.resize(seen.len() - self.large.len(), Entry::default());
        for ((k, disc), &cell) in (0..).zip(seen).zip(&self.cell_of) {
            if disc.radius <= self.large_from {
                let free = &mut self.free[cell as usize];
                self.entries[*free as usize] = entry(k, disc);
                *free += 1;
            }
        }
    }

    /// Calls `found` for all others with a gap up to the margin to a disc, and perhaps some more.
    pub fn for_each_near(&self, seen: &[Seen], k: usize, mut found: impl FnMut(u32)) {
        let disc = &seen[k];
        let mut look = |entries: &[Entry]| {
            for other in entries {
                let mut d = other.position - disc.position;
                if let Some(periodic) = &self.periodic {
                    d += periodic.shift(d);
                }
                let reach = (disc.radius + other.radius + self.margin) * (1.0 + 1e-9);
                if d.length_squared() <= reach * reach && other.disc as usize != k {
                    found(other.disc);
                }
            }
        };
        if disc.radius > self.large_from {
            look(&self.entries);
        } else {
            let cell = self.cell_of[k] as usize;
            let (column, row) = (cell % self.counts[0], cell / self.counts[0]);
            for row in around(row, self.counts[1]) {
                for column in around(column, self.counts[0]) {
                    let cell = row * self.counts[0] + column;
                    let (start, end) = (self.starts[cell], self.starts[cell + 1]);
                    look(&self.entries[start as usize..end as usize]);
                }
            }
        }
        look(&self.large);
    }

    /// Chooses the cells: at least so wide, about as many as discs.
    fn divide(&mut self, seen: &[Seen], width: f64) {
        let most = (2 * seen.len()).max(16);
        let positions = || seen.iter().map(|disc| disc.position);
        let spread = self.periodic.map_or_else(
            || {
                let min = positions().fold(DVec2::INFINITY, DVec2::min);
                let max = positions().fold(DVec2::NEG_INFINITY, DVec2::max);
                max - min
            },
            |periodic| periodic.size(),
        );
        let fit = (spread / width).min(DVec2::splat(1e6)).to_array();
        self.counts = fit.map(|fit| match self.periodic {
            _ if seen.len() <= ALL_UP_TO => 1,
            Some(_) => (fit as usize).max(1),
            None => (fit as usize + 1).next_power_of_two(),
        });
        while self.counts[0] * self.counts[1] > most {
            let longer = usize::from(self.counts[1] > self.counts[0]);
            self.counts[longer] = self.counts[longer].div_ceil(2);
        }
        let [columns, rows] = self.counts.map(|count| count as f64);
        let exact = |periodic: Periodic| periodic.size() / DVec2::new(columns, rows);
        self.size = self.periodic.map_or(DVec2::splat(width), exact);
    }

    fn cell(&self, position: DVec2) -> usize {
        let [columns, rows] = self.counts;
        let index = (position - self.periodic.map_or(DVec2::ZERO, |box_| box_.min)) / self.size;
        let (x, y) = (floor(index.x), floor(index.y));
        if self.periodic.is_some() {
            // Inside, but for the rounding of the quotient.
            let clamp = |index: i64, count: usize| (index.max(0) as usize).min(count - 1);
            return clamp(y, rows) * columns + clamp(x, columns);
        }
        (y as usize & (rows - 1)) * columns + (x as usize & (columns - 1))
    }
}

fn entry(disc: u32, seen: &Seen) -> Entry {
    Entry { position: seen.position, radius: seen.radius, disc }
}

/// A cell and the two beside it on a ring of so many, each once.
fn around(cell: usize, count: usize) -> impl Iterator<Item = usize> {
    let before = if cell == 0 { count - 1 } else { cell - 1 };
    let after = if cell + 1 == count { 0 } else { cell + 1 };
    [cell, after, before].into_iter().take(count)
}

/// The integer below; saturates beyond 2^63, which keeps neighbours neighbours.
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > x))
}
