//! Cells: which discs may meet which before one of them changes its cell.
//!
//! A cell is at least a largest diameter and two margins wide; a disc changes cells only after it
//! has left its own by the margin. So whatever it meets before that lies in the three by three
//! cells around its own. The grid has a rim of one cell: in a periodic box it mirrors the other
//! side, else it is empty.
//!
//! A cell holds a fixed number of discs, those beyond it are kept apart: geometry makes them rare.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec2;

use crate::world::Periodic;

/// Most columns or rows: places are kept in two halves of 32 bits.
const LINE_MAX: f64 = 60_000.0;

/// A cell: column and row, counted from 1, the rim not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Column, from 1.
    pub column: u16,
    /// Row, from 1.
    pub row: u16,
}

/// What bounds the region that cells cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Border {
    /// Nothing leaves: the outermost cells have no outer edge.
    Closed,
    /// What leaves comes in on the other side.
    Periodic(Periodic),
    /// Leaving needs a new grid.
    Open,
}

/// The discs by cells.
#[derive(Clone, Debug)]
pub struct Cells {
    min: DVec2,
    width: DVec2,
    margin: f64,
    columns: u16,
    rows: u16,
    border: Border,
    /// Numbers in a cell: discs, then their count.
    size: usize,
    numbers: Vec<u32>,
    /// Discs beyond those that a cell holds.
    beyond: HashMap<usize, Vec<u32>>,
}

/// What a grid is made for.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Lower left corner of what it covers, m.
    pub min: DVec2,
    /// Upper right corner, m.
    pub max: DVec2,
    /// Largest diameter, m.
    pub diameter: f64,
    /// Discs per area, 1/m^2.
    pub density: f64,
    /// What bounds it.
    pub border: Border,
}

impl Cells {
    /// Empty cells.
    pub fn new(needs: &Needs) -> Self {
        let (width, margin) = widths(needs);
        let size = needs.max - needs.min;
        let lines = (size / width).floor().clamp(DVec2::ONE, DVec2::splat(LINE_MAX));
        let (columns, rows) = (lines.x as u16, lines.y as u16);
        let width = size / lines;
        // Discs in a cell where they lie as close as they can, and in one of mean density.
        let most = (width.x + 2.0 * margin + needs.diameter)
            * (width.y + 2.0 * margin + needs.diameter)
            / (0.75f64.sqrt() * needs.diameter * needs.diameter);
        let mean = needs.density * width.element_product();
        let size = if most < 5.0 {
            4
        } else if mean <= 2.0 {
            8
        } else {
            16
        };
        let count = (usize::from(columns) + 2) * (usize::from(rows) + 2);
        Self {
            min: needs.min,
            width,
            margin,
            columns,
            rows,
            border: needs.border,
            size,
            numbers: vec![0; count * size],
            beyond: HashMap::new(),
        }
    }

    /// Columns or rows, whichever are fewer.
    pub fn lines_min(&self) -> u16 {
        self.columns.min(self.rows)
    }

    /// All numbers, cell by cell, row by row.
    #[inline]
    pub fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The cell of a position; the nearest one of a position outside.
    pub fn place(&self, position: DVec2) -> Place {
        let cell = ((position - self.min) / self.width).floor();
        let last = DVec2::new(f64::from(self.columns), f64::from(self.rows)) - 1.0;
        let cell = cell.clamp(DVec2::ZERO, last);
        Place { column: cell.x as u16 + 1, row: cell.y as u16 + 1 }
    }

    /// Whether the cell is one of the outermost.
    #[inline]
    pub fn is_outermost(&self, place: Place) -> bool {
        place.column == 1
            || place.row == 1
            || place.column == self.columns
            || place.row == self.rows
    }

    /// Where a disc of this cell has left it: lower and upper edges, the margin included.
    #[inline]
    pub fn edges(&self, place: Place) -> (DVec2, DVec2) {
        let cell = DVec2::new(f64::from(place.column), f64::from(place.row));
        let upper = self.min + self.width * cell;
        let (mut low, mut high) = (upper - self.width - self.margin, upper + self.margin);
        if self.border == Border::Closed && self.is_outermost(place) {
            if place.column == 1 {
                low.x = f64::NEG_INFINITY;
            }
            if place.row == 1 {
                low.y = f64::NEG_INFINITY;
            }
            if place.column == self.columns {
                high.x = f64::INFINITY;
            }
            if place.row == self.rows {
                high.y = f64::INFINITY;
            }
        }
        (low, high)
    }

    /// The next cell along an axis and what that adds to the position; `None` where the grid ends.
    pub fn neighbour(&self, place: Place, along_x: bool, up: bool) -> Option<(Place, DVec2)> {
        let (line, lines) =
            if along_x { (place.column, self.columns) } else { (place.row, self.rows) };
        let next = if up { line + 1 } else { line - 1 };
        let inside = (1..=lines).contains(&next);
        let to = if inside {
            next
        } else if up {
            1
        } else {
            lines
        };
        let moved =
            if along_x { Place { column: to, ..place } } else { Place { row: to, ..place } };
        if inside {
            return Some((moved, DVec2::ZERO));
        }
        let Border::Periodic(periodic) = self.border else { return None };
        let box_size = periodic.size() * if up { -1.0 } else { 1.0 };
        let shift = if along_x { DVec2::new(box_size.x, 0.0) } else { DVec2::new(0.0, box_size.y) };
        Some((moved, shift))
    }

    /// Index of a cell's first number.
    #[inline]
    pub fn start(&self, place: Place) -> usize {
        let stride = usize::from(self.columns) + 2;
        (usize::from(place.row) * stride + usize::from(place.column)) * self.size
    }

    #[inline]
    fn row_stride(&self) -> usize {
        (usize::from(self.columns) + 2) * self.size
    }

    /// Where the three rows of three cells around a cell are in [`Self::numbers`].
    #[inline(always)]
    pub fn rows_around(&self, place: Place) -> impl Iterator<Item = Range<usize>> {
        let (stride, width) = (self.row_stride(), 3 * self.size);
        let corner = self.start(place) - stride - self.size;
        (0..3).map(move |row| corner + row * stride).map(move |start| start..start + width)
    }

    /// Names the discs in the three by three cells around a cell, but for those beyond.
    #[inline(always)]
    pub fn for_each_near(&self, place: Place, mut name: impl FnMut(usize)) {
        for row in self.rows_around(place) {
            for cell in self.numbers[row].chunks_exact(self.size) {
                let held = (cell[self.size - 1] as usize).min(self.size - 1);
                cell[..held].iter().for_each(|&disc| name(disc as usize));
            }
        }
    }

    /// Puts a disc into a cell.
    pub fn add(&mut self, place: Place, disc: u32) {
        self.for_each_image(place, |cells, start| cells.add_at(start, disc));
    }

    /// Takes a disc out of its cell.
    pub fn remove(&mut self, place: Place, disc: u32) {
        self.for_each_image(place, |cells, start| cells.remove_at(start, disc));
    }

    fn for_each_image(&mut self, place: Place, mut act: impl FnMut(&mut Self, usize)) {
        act(self, self.start(place));
        if !matches!(self.border, Border::Periodic(_)) || !self.is_outermost(place) {
            return;
        }
        let image = |line: u16, lines: u16| match line {
            1 => Some(lines + 1),
            _ if line == lines => Some(0),
            _ => None,
        };
        let columns = [Some(place.column), image(place.column, self.columns)];
        let rows = [Some(place.row), image(place.row, self.rows)];
        for row in rows.into_iter().flatten() {
            for column in columns.into_iter().flatten() {
                let image = Place { column, row };
                if image != place {
                    act(self, self.start(image));
                }
            }
        }
    }

    fn add_at(&mut self, start: usize, disc: u32) {
        let (room, end) = (self.size - 1, start + self.size - 1);
        let count = self.numbers[end] as usize;
        if count < room {
            self.numbers[start + count] = disc;
        } else {
            self.beyond.entry(start).or_default().push(disc);
        }
        self.numbers[end] += 1;
    }

    fn remove_at(&mut self, start: usize, disc: u32) {
        let (room, end) = (self.size - 1, start + self.size - 1);
        let count = self.numbers[end] as usize;
        self.numbers[end] -= 1;
        let held = &mut self.numbers[start..start + count.min(room)];
        let last = held.len() - 1;
        let at = held.iter().position(|&held| held == disc);
        if count <= room {
            // A disc is in the cell of its place.
            held[at.unwrap_or(last)] = held[last];
            return;
        }
        let Some(beyond) = self.beyond.get_mut(&start) else { return };
        match at {
            Some(at) => held[at] = beyond.pop().unwrap_or(disc),
            None => beyond.retain(|&other| other != disc),
        }
        if beyond.is_empty() {
            self.beyond.remove(&start);
        }
    }

    /// All discs in the three by three cells around a cell into `near`; returns how many.
    #[inline(always)]
    pub fn collect(&self, place: Place, near: &mut Vec<u32>) -> usize {
        match self.size {
            4 => self.collect_sized::<4>(place, near),
            8 => self.collect_sized::<8>(place, near),
            _ => self.collect_sized::<16>(place, near),
        }
    }

    #[inline(always)]
    fn collect_sized<const SIZE: usize>(&self, place: Place, near: &mut Vec<u32>) -> usize {
        const CELLS: usize = 9;
        if near.len() < (CELLS + 1) * SIZE {
            near.resize((CELLS + 1) * SIZE, 0);
        }
        let (mut count, mut spilled) = (0, false);
        let stride = self.row_stride();
        let corner = self.start(place) - stride - SIZE;
        for row in 0..3 {
            let (cells, _) = self.numbers[corner + row * stride..][..3 * SIZE].as_chunks::<SIZE>();
            for cell in cells {
                let held = cell[SIZE - 1] as usize;
                spilled |= held >= SIZE;
                // Copying all is cheaper than asking how many.
                near[count..count + SIZE].copy_from_slice(cell);
                count += held.min(SIZE - 1);
            }
        }
        if spilled { self.collect_beyond(place, near, count) } else { count }
    }

    #[cold]
    fn collect_beyond(&self, place: Place, near: &mut Vec<u32>, mut count: usize) -> usize {
        let corner = self.start(place) - self.row_stride() - self.size;
        for row in 0..3 {
            for column in 0..3 {
                let start = corner + row * self.row_stride() + column * self.size;
                let Some(beyond) = self.beyond.get(&start) else { continue };
                near.truncate(count);
                near.extend_from_slice(beyond);
                count = near.len();
            }
        }
        near.resize(count + 16, 0);
        count
    }
}

/// Least width of a cell and margin, m: wide where changes of cells are frequent, narrow where
/// contacts are (measured: `carom bench gas`).
fn widths(needs: &Needs) -> (f64, f64) {
    let fraction = needs.density * needs.diameter * needs.diameter * std::f64::consts::FRAC_PI_4;
    // Discs per cell wanted, and the margin in diameters.
    let margin = (0.26 - 0.38 * fraction).clamp(0.0, 0.2) * needs.diameter;
    let roomy = (0.92 / needs.density).sqrt();
    (roomy.max(needs.diameter * 1.0 + 2.0 * margin) * (1.0 + 1e-9), margin)
}
