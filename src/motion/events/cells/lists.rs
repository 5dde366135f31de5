//! For each cell the line segments that a disc in it may touch: made once with the cells.
//!
//! What lies farther from a cell than a radius of its discs is not listed, so most cells list
//! nothing, however many segments there are. Lists may have a few too many, for discs are taken for
//! squares; never too few: the margin of a cell counts, and rounding is added.

use super::{Cells, Edges, Place};
use crate::world::Segment;

/// What rounding may make of a coordinate, in widths of a cell and in coordinates.
const SLACK: (f64, f64) = (1e-9, 1e-13);

/// Numbers of segments, cell by cell.
#[derive(Clone, Debug, Default)]
pub struct Lists {
    /// By index of a cell: where its list begins; that of the next is where it ends.
    starts: Vec<u32>,
    numbers: Vec<u32>,
}

impl Cells {
    /// The segments that a disc of a cell may touch, the first ones first.
    #[inline]
    pub fn listed<'a>(&self, lists: &'a Lists, place: Place) -> &'a [u32] {
        let at = self.index(place);
        &lists.numbers[lists.starts[at] as usize..lists.starts[at + 1] as usize]
    }

    /// Lists for discs of up to a radius, m.
    pub fn lists(&self, segments: &[Segment], radius: f64) -> Lists {
        let count = (usize::from(self.columns) + 2) * (usize::from(self.rows) + 2);
        let mut starts = vec![0u32; count + 1];
        for segment in segments {
            self.for_each_near(segment, radius, |at| starts[at] += 1);
        }
        let mut end = 0;
        for start in &mut starts {
            end += *start;
            *start = end;
        }
        let mut numbers = vec![0; end as usize];
        // Each list is filled from its end.
        for (number, segment) in segments.iter().enumerate().rev() {
            self.for_each_near(segment, radius, |at| {
                starts[at] -= 1;
                numbers[starts[at] as usize] = number as u32;
            });
        }
        Lists { starts, numbers }
    }

    /// The cells, by index, whose discs of a radius may touch a segment.
    fn for_each_near(&self, segment: &Segment, radius: f64, mut act: impl FnMut(usize)) {
        let Segment { from, to } = *segment;
        let far = from.abs().max(to.abs()).max_element();
        let reach = radius + SLACK.0 * (radius + self.width.max_element()) + SLACK.1 * far;
        let (low, high) = (from.y.min(to.y), from.y.max(to.y));
        for row in between(&self.row_edges, low - reach, high + reach) {
            let Edges { low: bottom, high: top } = self.row_edges[row];
            // What of it discs of this row may come near.
            let ends = [bottom - reach, top + reach].map(|y| {
                let part = (y.clamp(low, high) - from.y) / (to.y - from.y);
                from.x + part * (to.x - from.x)
            });
            let level = to.y == from.y;
            let [a, b] = if level { [from.x, to.x] } else { ends };
            for column in between(&self.column_edges, a.min(b) - reach, a.max(b) + reach) {
                act(self.index(Place { column: column as u16, row: row as u16 }));
            }
        }
    }
}

/// The lines whose discs may lie between two coordinates, but for the rim.
fn between(edges: &[Edges], low: f64, high: f64) -> std::ops::Range<usize> {
    let inner = &edges[1..edges.len() - 1];
    let first = inner.partition_point(|edges| edges.high < low);
    let end = inner.partition_point(|edges| edges.low <= high);
    first + 1..end.max(first) + 1
}
