//! Cells: which discs may meet which before one of them changes its cell.
//!
//! A cell is at least a largest diameter and two margins wide; a disc changes cells only after it
//! has left its own by the margin. So whatever it meets before that lies in the three by three
//! cells around its own. The grid has a rim of one cell: in a periodic box it mirrors the other
//! side, else it is empty.
//!
//! A cell holds a fixed number of discs, those beyond it are kept apart: geometry makes them rare.
//! They stand first in it, so that who looks at it need not search its empty places; how fast, is
//! for [`super::lanes`].

mod lists;
mod ring;

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec2;

use super::pages;

use crate::world::Periodic;

pub use lists::Lists;

/// Most columns or rows: places are kept in two halves of 32 bits.
const LINE_MAX: f64 = 60_000.0;

/// In a cell: no disc.
pub const EMPTY: u32 = u32::MAX;

/// Discs that a cell shall hold in the mean.
const DISCS_PER_CELL: f64 = 1.25;

/// Width of cells, in diameters, in which there are at most four discs, and up to which width it is
/// better to have such instead.
const BEST_WITH_FOUR: (f64, f64) = (1.2, 1.5);

/// Side of a square in which the centres of at most four discs lie, in diameters.
const FOUR_IN_SQUARE: f64 = std::f64::consts::SQRT_2 * (1.0 - 1e-5);

/// Most discs that a cell has room for.
pub const ROOM_MAX: usize = 16;

/// Rows of cells side by side, in [`Cells::numbers`].
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// The first number.
    pub start: usize,
    /// From a row to the next.
    pub stride: usize,
    /// Numbers in a row, a multiple of four.
    pub width: usize,
    /// Rows, at least one.
    pub rows: usize,
}

impl Block {
    /// The numbers of each row.
    pub fn rows(self) -> impl Iterator<Item = Range<usize>> {
        let start = move |row| self.start + row * self.stride;
        (0..self.rows).map(start).map(move |start| start..start + self.width)
    }

    /// Behind its last number.
    pub fn end(&self) -> usize {
        self.start + (self.rows - 1) * self.stride + self.width
    }

    /// How many numbers it has.
    pub fn count(&self) -> usize {
        self.rows * self.width
    }
}

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
    columns: u16,
    rows: u16,
    border: Border,
    /// By which a disc has left its cell, m.
    margin: f64,
    /// Where a disc of a column, or of a row, has left it: lower and upper edges, m.
    column_edges: Vec<Edges>,
    row_edges: Vec<Edges>,
    /// Discs that a cell has room for.
    size: usize,
    numbers: Vec<u32>,
    /// Discs beyond those that a cell holds.
    beyond: HashMap<usize, Vec<u32>>,
}

/// The lower and the upper edge of a column or a row, the margin included, m.
#[derive(Clone, Copy, Debug)]
struct Edges {
    low: f64,
    high: f64,
}

/// What a grid is made for.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// Lower left corner of what it covers, m.
    pub min: DVec2,
    /// Upper right corner, m.
    pub max: DVec2,
    /// Room for discs in it, m^2.
    pub area: f64,
    /// Largest diameter, m.
    pub diameter: f64,
    /// Discs per area, 1/m^2.
    pub density: f64,
    /// What bounds it.
    pub border: Border,
    /// Whether all discs are of that diameter: smaller ones lie closer.
    pub is_equal: bool,
    /// Whether larger discs lie in coarser cells above: they are written into all cells that they
    /// come near, so that a wide margin costs more than it saves.
    pub is_finest: bool,
}

/// Largest margin below coarser cells, in diameters.
const MARGIN_OF_FINEST: f64 = 0.2;

impl Cells {
    /// Empty cells.
    pub fn new(needs: &Needs) -> Self {
        let (width, mut margin) = widths(needs);
        let lines = lines(needs, width);
        let width = (needs.max - needs.min) / lines;
        let mean = needs.density * width.element_product();
        // Of five equal discs in a square two are nearer than its side over the root of two.
        let for_four = 0.5 * (FOUR_IN_SQUARE * needs.diameter - width.max_element());
        let size = if needs.is_equal && for_four >= 0.8 * margin && mean <= 1.3 {
            margin = margin.min(for_four);
            4
        } else if mean <= 2.0 {
            8
        } else {
            ROOM_MAX
        };
        Self::laid_out(needs, lines, margin, size)
    }

    /// Empty cells of about this width and margin, m, with room for so many discs each.
    pub fn of_width(needs: &Needs, width: f64, margin: f64, size: usize) -> Self {
        Self::laid_out(needs, lines(needs, width), margin, size)
    }

    /// Empty cells in so many columns and rows.
    fn laid_out(needs: &Needs, lines: DVec2, margin: f64, size: usize) -> Self {
        let (columns, rows) = (lines.x as u16, lines.y as u16);
        let width = (needs.max - needs.min) / lines;
        if let Border::Periodic(periodic) = needs.border
            && lines.min_element() >= 5.0
        {
            let apart = 2.0 * (width + margin);
            assert!(apart.cmplt(0.5 * periodic.size()).all(), "one image within two cells");
        }
        let count = (usize::from(columns) + 2) * (usize::from(rows) + 2);
        let mut numbers = pages::with_room_for(count * size);
        numbers.resize(count * size, EMPTY);
        let is_closed = needs.border == Border::Closed;
        let edges = |min, width, lines| edges(min, width, lines, margin, is_closed);
        Self {
            min: needs.min,
            width,
            columns,
            rows,
            border: needs.border,
            margin,
            column_edges: edges(needs.min.x, width.x, columns),
            row_edges: edges(needs.min.y, width.y, rows),
            size,
            numbers,
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
    #[inline(always)]
    pub fn is_outermost(&self, place: Place) -> bool {
        // Without branches: which it is cannot be foreseen.
        (place.column == 1)
            | (place.row == 1)
            | (place.column == self.columns)
            | (place.row == self.rows)
    }

    /// Where a disc of this cell has left it: lower and upper edges, the margin included.
    #[inline(always)]
    pub fn edges(&self, place: Place) -> (DVec2, DVec2) {
        let x = self.column_edges[usize::from(place.column)];
        let y = self.row_edges[usize::from(place.row)];
        (DVec2::new(x.low, y.low), DVec2::new(x.high, y.high))
    }

    /// The next cell along an axis and what that adds to the position; `None` where the grid ends.
    pub fn neighbour(&self, place: Place, along_x: bool, up: bool) -> Option<(Place, DVec2)> {
        // Without branches: which way it goes cannot be foreseen.
        let step = u16::from(up).wrapping_mul(2).wrapping_sub(1);
        let column = place.column.wrapping_add(step.wrapping_mul(u16::from(along_x)));
        let row = place.row.wrapping_add(step.wrapping_mul(u16::from(!along_x)));
        let lies_within =
            (column.wrapping_sub(1) < self.columns) & (row.wrapping_sub(1) < self.rows);
        if lies_within {
            return Some((Place { column, row }, DVec2::ZERO));
        }
        let Border::Periodic(periodic) = self.border else { return None };
        let around = |line: u16, lines: u16| if line == 0 { lines } else { (line - 1) % lines + 1 };
        let moved = Place { column: around(column, self.columns), row: around(row, self.rows) };
        let box_size = periodic.size() * if up { -1.0 } else { 1.0 };
        let shift = if along_x { DVec2::new(box_size.x, 0.0) } else { DVec2::new(0.0, box_size.y) };
        Some((moved, shift))
    }

    /// Index of a cell's first number.
    #[inline(always)]
    pub fn start(&self, place: Place) -> usize {
        let stride = usize::from(self.columns) + 2;
        (usize::from(place.row) * stride + usize::from(place.column)) * self.size
    }

    /// Index of a cell among all, those of the rim too.
    #[inline(always)]
    fn index(&self, place: Place) -> usize {
        usize::from(place.row) * (usize::from(self.columns) + 2) + usize::from(place.column)
    }

    #[inline(always)]
    fn row_stride(&self) -> usize {
        (usize::from(self.columns) + 2) * self.size
    }

    /// The three by three cells around a cell.
    #[inline(always)]
    pub fn around(&self, place: Place) -> Block {
        let (stride, size) = (self.row_stride(), self.size);
        Block { start: self.start(place) - stride - size, stride, width: 3 * size, rows: 3 }
    }

    /// The three cells that come near where a disc enters this one.
    #[inline(always)]
    pub fn ahead(&self, place: Place, along_x: bool, up: bool) -> Block {
        let (stride, size) = (self.row_stride(), self.size);
        // From it to the next, and between the three: one by one either way, so that what looks at
        // them does the same.
        let (step, stride) = if along_x { (size, stride) } else { (stride, size) };
        let middle = self.start(place);
        let next = if up { middle + step } else { middle - step };
        Block { start: next - stride, stride, width: size, rows: 3 }
    }

    /// Whether some cell holds more than it has room for.
    #[inline(always)]
    pub fn is_spilled(&self) -> bool {
        !self.beyond.is_empty()
    }

    /// The discs of a block beyond those that its cells have room for.
    pub fn beyond(&self, block: &Block) -> impl Iterator<Item = u32> {
        let starts = block.rows().flat_map(|row| row.step_by(self.size));
        starts.filter_map(|start| self.beyond.get(&start)).flatten().copied()
    }

    /// Puts a disc into a cell.
    pub fn add(&mut self, place: Place, disc: u32) {
        self.for_each_image(place, |cells, start| cells.add_at(start, disc));
    }

    /// Takes a disc out of its cell.
    pub fn remove(&mut self, place: Place, disc: u32) {
        self.for_each_image(place, |cells, start| cells.remove_at(start, disc));
    }

    /// Calls a disc of a cell otherwise.
    pub fn rename(&mut self, place: Place, disc: u32, to: u32) {
        self.remove(place, disc);
        self.add(place, to);
    }

    /// Takes all discs out.
    pub fn clear(&mut self) {
        self.numbers.fill(EMPTY);
        self.beyond.clear();
    }

    /// Whether a place lies within what the cells are made for.
    pub fn covers(&self, position: DVec2) -> bool {
        let (columns, rows) = (f64::from(self.columns), f64::from(self.rows));
        let max = self.min + self.width * DVec2::new(columns, rows);
        let lies_within = position.cmpge(self.min).all() && position.cmple(max).all();
        self.border != Border::Open || lies_within
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
        let cell = &mut self.numbers[start..start + self.size];
        match cell.get_mut(first_place(cell, EMPTY)) {
            Some(room) => *room = disc,
            None => self.beyond.entry(start).or_default().push(disc),
        }
    }

    fn remove_at(&mut self, start: usize, disc: u32) {
        let cell = &mut self.numbers[start..start + self.size];
        let at = first_place(cell, disc);
        let Some(beyond) = self.beyond.get_mut(&start) else {
            let end = first_place(cell, EMPTY).min(self.size);
            if at < end {
                cell[at] = cell[end - 1];
                cell[end - 1] = EMPTY;
            }
            return;
        };
        match cell.get_mut(at) {
            Some(held) => *held = beyond.pop().unwrap_or(EMPTY),
            None => beyond.retain(|&other| other != disc),
        }
        if beyond.is_empty() {
            self.beyond.remove(&start);
        }
    }
}

/// Where a number stands first, without a branch, for that cannot be foreseen; beyond all if it
/// does not.
#[inline(always)]
fn first_place(cell: &[u32], number: u32) -> usize {
    let found = cell.as_chunks::<4>().0.iter().rev().fold(0u32, |found, four| {
        let is = |at: usize| u32::from(four[at] == number) << at;
        (found << 4) | is(0) | is(1) | is(2) | is(3)
    });
    found.trailing_zeros() as usize
}

/// Columns and rows of cells that are no narrower than that, m.
fn lines(needs: &Needs, width: f64) -> DVec2 {
    ((needs.max - needs.min) / width).floor().clamp(DVec2::ONE, DVec2::splat(LINE_MAX))
}

/// The edges of all columns or rows, those of the rim too, which nobody asks for. Where nothing
/// leaves, the outermost have no outer edge.
fn edges(min: f64, width: f64, lines: u16, margin: f64, is_closed: bool) -> Vec<Edges> {
    let edges = |line: u16| {
        let upper = min + width * f64::from(line);
        let (is_first, is_last) = (is_closed && line <= 1, is_closed && line >= lines);
        Edges {
            low: if is_first { f64::NEG_INFINITY } else { upper - width - margin },
            high: if is_last { f64::INFINITY } else { upper + margin },
        }
    };
    (0..=lines + 1).map(edges).collect()
}

/// Side of a periodic box, in diameters, below which five cells and their margins are narrow
/// enough: `2 (w + m) < L / 2` with `w = L / 5` and `m = (w - d) / 2`.
const FIVE_BELOW: f64 = 9.9;

/// Least width of a cell and margin, m, as measured with `carom bench gas`: so wide that a cell
/// holds a disc and a quarter, which trades discs that are looked at for changes of cells; but
/// where that is close to a width at which no five discs fit into one, that.
pub fn widths(needs: &Needs) -> (f64, f64) {
    let mut width = (DISCS_PER_CELL / needs.density).sqrt();
    if width < BEST_WITH_FOUR.1 * needs.diameter {
        width = width.min(BEST_WITH_FOUR.0 * needs.diameter);
    }
    if let Border::Periodic(periodic) = needs.border {
        // Discs of cells side by side are up to two widths and two margins apart: were that more
        // than half the box, another image than the one they may meet could be the nearer one. Six
        // of them are narrow enough for that, and five where that leaves little margin.
        let side = periodic.size().min_element();
        let fewest = if side < FIVE_BELOW * needs.diameter { 5.0 } else { 6.0 };
        width = width.min(side / fewest * (1.0 - 1e-8));
    }
    let width = width.max(needs.diameter);
    let margin = 0.5 * (width - needs.diameter);
    let most = if needs.is_finest { MARGIN_OF_FINEST * needs.diameter } else { f64::INFINITY };
    (width * (1.0 + 1e-9), margin.min(most))
}
