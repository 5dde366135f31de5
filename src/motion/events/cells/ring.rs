//! Parts of a grid seen from a disc of a coarser one: a ring around it.
//!
//! Lines are counted from 0 here, and in a periodic box on beyond its border.

use glam::DVec2;

use super::{Block, Border, Cells, Place};

/// By how much a line reaches over its edges for rounding, in widths.
const SLACK: f64 = 1e-9;

/// Cells of a row that are looked at together.
const SPAN_MAX: usize = 8;

/// First and last column or row, counted from 0.
type Lines = (i64, i64);

impl Cells {
    /// Width of a cell, m, the larger of both.
    pub fn width(&self) -> f64 {
        self.width.max_element()
    }

    fn is_periodic(&self) -> bool {
        matches!(self.border, Border::Periodic(_))
    }

    /// Columns (axis 0) or rows whose discs may lie between two coordinates.
    fn lines_between(&self, axis: usize, low: f64, high: f64) -> Lines {
        let (min, width) = (self.min[axis], self.width[axis]);
        let first = ((low - self.margin - min) / width - SLACK).floor() as i64;
        let last = ((high + self.margin - min) / width + SLACK).floor() as i64;
        if self.is_periodic() {
            return (first, last);
        }
        let end = i64::from([self.columns, self.rows][axis]) - 1;
        (first.clamp(0, end), last.clamp(0, end))
    }

    /// Nearest and farthest that a disc of a row may be from a coordinate, m.
    fn distances(&self, row: i64, from: f64) -> (f64, f64) {
        let slack = self.margin + SLACK * self.width.y;
        let low = self.min.y + row as f64 * self.width.y;
        let is_closed = self.border == Border::Closed;
        let (is_first, is_last) = (row == 0, row + 1 == i64::from(self.rows));
        let below = if is_closed && is_first { f64::NEG_INFINITY } else { low - slack };
        let above = if is_closed && is_last { f64::INFINITY } else { low + self.width.y + slack };
        ((below - from).max(from - above).max(0.0), (from - below).max(above - from))
    }

    /// The cells whose discs may lie between two distances from a point, m, in parts of rows.
    pub fn for_each_in_ring(
        &self,
        centre: DVec2,
        (inner, outer): (f64, f64),
        act: &mut impl FnMut(Block),
    ) {
        let (first, last) = self.lines_between(1, centre.y - outer, centre.y + outer);
        for row in first..=last {
            let (near, far) = self.distances(row, centre.y);
            if near > outer {
                continue;
            }
            let half = (outer * outer - near * near).sqrt();
            let columns = self.lines_between(0, centre.x - half, centre.x + half);
            if far >= inner {
                self.for_each_in_row(row, columns, act);
                continue;
            }
            // Cells that lie wholly within the inner distance are left out.
            let hole = (inner * inner - far * far).sqrt();
            let (left, right) = (centre.x - hole, centre.x + hole);
            let left = self.lines_between(0, centre.x - half, left).1;
            let right = self.lines_between(0, right, centre.x + half).0;
            if right <= left + 1 {
                self.for_each_in_row(row, columns, act);
            } else {
                self.for_each_in_row(row, (columns.0, left), act);
                self.for_each_in_row(row, (right, columns.1), act);
            }
        }
    }

    fn for_each_in_row(&self, row: i64, (first, last): Lines, act: &mut impl FnMut(Block)) {
        let columns = usize::from(self.columns);
        let row = row.rem_euclid(i64::from(self.rows)) as u16 + 1;
        let mut column = first.rem_euclid(columns as i64) as usize;
        let mut left = ((last - first + 1).max(0) as usize).min(columns);
        while left > 0 {
            let count = left.min(SPAN_MAX).min(columns - column);
            let start = self.start(Place { column: column as u16 + 1, row });
            act(Block { start, stride: 0, width: count * self.size, rows: 1 });
            column = (column + count) % columns;
            left -= count;
        }
    }

    /// One cell.
    pub fn only(&self, place: Place) -> Block {
        Block { start: self.start(place), stride: 0, width: self.size, rows: 1 }
    }

    /// Puts a disc into all cells of a block.
    pub fn add_to(&mut self, block: &Block, disc: u32) {
        let size = self.size;
        for start in block.rows().flat_map(move |row| row.step_by(size)) {
            self.add_at(start, disc);
        }
    }

    /// Takes a disc out of all cells of a block.
    pub fn remove_from(&mut self, block: &Block, disc: u32) {
        let size = self.size;
        for start in block.rows().flat_map(move |row| row.step_by(size)) {
            self.remove_at(start, disc);
        }
    }
}
