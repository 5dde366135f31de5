//! A grid of cells that lists all near pairs, into buffers that are kept.
//!
//! Cells are as wide as the largest reach of ordinary discs, so a disc is near to those of its own
//! and the eight cells around only; half of them are looked at, the other half looks back. Cells of
//! a row lie one after the other in memory: what is to be looked at are a few long ranges. Where
//! the plane is much wider than its discs it is wound around about as many cells as there are
//! discs, so that outliers cost nothing. Discs much larger than the mean are looked at with all.
//! Judged by all pairs.

use std::ops::Range;

use glam::DVec2;

use super::lanes::{Centre, Entries, Pairs};
use crate::detect::TooManyPairs;
use crate::world::{Periodic, limits};

/// Discs with a radius above so many times the mean are looked at with all others.
const LARGE_RADIUS_RATIO: f64 = 4.0;

/// In fewer columns or rows the cells around a cell are not nine different ones.
const LINES_MIN: usize = 4;

/// Up to so many discs looking at all is quicker than sorting into cells.
const ALL_UP_TO: usize = 24;

/// Discs sorted by cell.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    periodic: Option<Periodic>,
    columns: usize,
    rows: usize,
    /// Whether the plane is wound around the cells: columns and rows are powers of two then.
    is_wound: bool,
    /// Lower left corner of the first cell, m.
    min: DVec2,
    /// Width and height of a cell, m.
    size: DVec2,
    /// Cell `c` holds the entries `starts[c] .. starts[c + 1]`; row by row.
    starts: Vec<u32>,
    free: Vec<u32>,
    cell_of: Vec<u32>,
    entries: Entries,
    large: Vec<u32>,
    /// Pairs beyond which discs lie heaped.
    most: usize,
}

/// The cell of a disc that is in none.
const NO_CELL: u32 = u32::MAX;

impl Cells {
    /// In a periodic box, or none.
    pub fn new(periodic: Option<Periodic>) -> Self {
        Self { periodic, ..Self::default() }
    }

    /// Lists all pairs with a gap up to `margin` (m), and perhaps some more.
    ///
    /// # Errors
    /// [`TooManyPairs`] when discs lie heaped on each other.
    pub fn list(
        &mut self,
        places: &[DVec2],
        radii: &[f64],
        margin: f64,
        pairs: &mut Pairs,
    ) -> Result<(), TooManyPairs> {
        pairs.clear();
        self.most = limits::TOUCHING_PAIRS.max(limits::NEAR_PAIRS_PER_DISC * places.len());
        let mean = radii.iter().sum::<f64>() / radii.len().max(1) as f64;
        let large_from = LARGE_RADIUS_RATIO * mean;
        let ordinary = radii.iter().copied().filter(|r| *r <= large_from);
        // A hair wider than the reach: the rounding of a cell's index can then not hide a pair.
        let width = (2.0 * ordinary.fold(0.0, f64::max) + margin) * 1.001;
        self.divide(places, width);
        self.sort(places, radii, large_from);
        if self.starts.len() == 2 {
            self.look_at_all(margin, pairs)?;
        } else {
            self.look_around(margin, pairs)?;
        }
        self.look_from_large(places, radii, margin, pairs)?;
        pairs.seal(places.len());
        Ok(())
    }

    fn check(&self, pairs: &Pairs) -> Result<(), TooManyPairs> {
        if pairs.len() > self.most { Err(TooManyPairs) } else { Ok(()) }
    }

    /// Chooses the cells: at least so wide, about as many as discs; one where that is too few.
    fn divide(&mut self, places: &[DVec2], width: f64) {
        let (min, max) = self.periodic.map_or_else(
            || {
                let min = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
                (min, places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max))
            },
            |periodic| (periodic.min, periodic.max),
        );
        let fit = ((max - min) / width).min(DVec2::splat(1e6)).max(DVec2::ZERO).to_array();
        let most = (2 * places.len()).max(LINES_MIN * LINES_MIN);
        // Cells of a periodic box are a little wider, those of a plane stick out of it.
        let extra = usize::from(self.periodic.is_none());
        [self.columns, self.rows] = fit.map(|fit| fit as usize + extra);
        self.is_wound = self.periodic.is_none() && self.columns * self.rows > most;
        if self.is_wound {
            [self.columns, self.rows] = fit.map(|fit| (fit as usize + 1).next_power_of_two());
        }
        while self.columns * self.rows > most {
            let longer = if self.columns > self.rows { &mut self.columns } else { &mut self.rows };
            *longer = longer.div_ceil(2);
        }
        if self.columns < LINES_MIN || self.rows < LINES_MIN || places.len() <= ALL_UP_TO {
            (self.columns, self.rows, self.is_wound) = (1, 1, false);
        }
        let lines = DVec2::new(self.columns as f64, self.rows as f64);
        self.min = min;
        self.size = self.periodic.map_or(DVec2::splat(width), |periodic| periodic.size() / lines);
    }

    fn cell(&self, place: DVec2) -> usize {
        let index = (place - self.min) / self.size;
        let (x, y) = (floor(index.x), floor(index.y));
        if self.is_wound {
            return (y as usize & (self.rows - 1)) * self.columns
                + (x as usize & (self.columns - 1));
        }
        // Inside, but for the rounding of the quotient.
        let clamp = |index: i64, count: usize| (index.max(0) as usize).min(count - 1);
        clamp(y, self.rows) * self.columns + clamp(x, self.columns)
    }

    /// Sorts the ordinary discs into cells (counting sort).
    fn sort(&mut self, places: &[DVec2], radii: &[f64], large_from: f64) {
        self.starts.clear();
        self.starts.resize(self.columns * self.rows + 1, 0);
        self.cell_of.clear();
        self.large.clear();
        for (k, place) in places.iter().enumerate() {
            if radii[k] > large_from {
                self.cell_of.push(NO_CELL);
                self.large.push(k as u32);
                continue;
            }
            let inside = self.periodic.map_or(*place, |periodic| periodic.inside(*place));
            let cell = self.cell(inside);
            self.cell_of.push(cell as u32);
            self.starts[cell + 1] += 1;
        }
        for cell in 1..self.starts.len() {
            self.starts[cell] += self.starts[cell - 1];
        }
        self.free.clone_from(&self.starts);
        self.entries.resize(places.len() - self.large.len());
        for (k, (place, &cell)) in places.iter().zip(&self.cell_of).enumerate() {
            if cell != NO_CELL {
                let inside = self.periodic.map_or(*place, |periodic| periodic.inside(*place));
                let free = &mut self.free[cell as usize];
                self.entries.set(*free as usize, inside, radii[k], k as u32);
                *free += 1;
            }
        }
    }

    fn centre(&self, slot: usize, margin: f64, wrap: Option<DVec2>) -> Centre {
        let (place, radius, disc) = self.entries.get(slot);
        Centre { place, reach: radius + margin, disc, wrap }
    }

    /// Every two entries.
    fn look_at_all(&self, margin: f64, pairs: &mut Pairs) -> Result<(), TooManyPairs> {
        let (count, wrap) = (self.entries.len(), self.periodic.map(|periodic| periodic.size()));
        for slot in 0..count {
            self.entries.scan(&self.centre(slot, margin, wrap), slot + 1..count, pairs);
            self.check(pairs)?;
        }
        Ok(())
    }

    /// Every two entries of the same or of neighbouring cells, once.
    fn look_around(&self, margin: f64, pairs: &mut Pairs) -> Result<(), TooManyPairs> {
        let size = self.periodic.map(|periodic| periodic.size());
        let last = self.columns - 1;
        for y in 0..self.rows {
            let row = y * self.columns;
            let above = if y + 1 == self.rows { 0 } else { row + self.columns };
            for x in 0..self.columns {
                let (left, right) = (x.saturating_sub(1), (x + 1).min(last));
                let (own, end) = (self.slots(row + x, row + x), self.slots(row, row + right).end);
                let ahead = self.slots(above + left, above + right);
                // What lies beyond the end of a row is at its other end.
                let beyond = match x {
                    0 => [self.slots(above + last, above + last), 0..0],
                    _ if x == last => [self.slots(above, above), self.slots(row, row)],
                    _ => [0..0, 0..0],
                };
                let border = x == 0 || x == last || y + 1 == self.rows;
                let wrap = size.filter(|_| border);
                for slot in own {
                    let centre = self.centre(slot, margin, wrap);
                    self.entries.scan(&centre, slot + 1..end, pairs);
                    self.entries.scan(&centre, ahead.clone(), pairs);
                    if border {
                        beyond.iter().for_each(|far| {
                            self.entries.scan(&centre, far.clone(), pairs);
                        });
                    }
                    self.check(pairs)?;
                }
            }
        }
        Ok(())
    }

    /// The entries of a row of cells.
    fn slots(&self, first: usize, last: usize) -> Range<usize> {
        self.starts[first] as usize..self.starts[last + 1] as usize
    }

    /// Large discs with all others.
    fn look_from_large(
        &self,
        places: &[DVec2],
        radii: &[f64],
        margin: f64,
        pairs: &mut Pairs,
    ) -> Result<(), TooManyPairs> {
        let wrap = self.periodic.map(|periodic| periodic.size());
        for (n, &k) in self.large.iter().enumerate() {
            let (place, reach) = (places[k as usize], radii[k as usize] + margin);
            let centre = Centre { place, reach, disc: k, wrap };
            self.entries.scan(&centre, 0..self.entries.len(), pairs);
            // Of each other nothing is known: whoever lists them looks.
            self.large[n + 1..].iter().for_each(|&l| pairs.push(k, l));
            self.check(pairs)?;
        }
        Ok(())
    }
}

/// The integer below; saturates beyond 2^63, which keeps neighbours neighbours.
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero.saturating_sub(i64::from(towards_zero as f64 > x))
}
