//! Line segments: which of them a disc touches before it leaves its cell, and what that does to it.
//!
//! Each cell has a list of those that its discs may touch, so a disc asks for these alone; where it
//! changes its cell it looks again anyway. What plain doubles cannot exclude is told by the exact
//! routine of [`crate::detect::segment`].
//!
//! Segments bound no cells: who leaves through a gap is held by nobody, and flies on.
//!
//! Without segments nothing of this is there. Never together with gravity, drag or a periodic box.

use glam::DVec2;

use super::cells::{Border, Lists};
use super::lanes::Unit;
use super::{Events, SEGMENT};
use crate::detect::segment::Edge;
use crate::motion::Witness;
use crate::resolve::segment::{segment_contact, turn};
use crate::world::{Disc, Owner, Segments};

/// All segments, and where there are which.
#[derive(Clone, Debug)]
pub(super) struct Fence {
    edges: Vec<Edge>,
    restitution: f64,
    /// By level of cells.
    lists: Vec<Lists>,
}

impl Fence {
    /// Of these segments.
    pub fn new(segments: &Segments) -> Self {
        let (edges, lists) = (Edge::all(Some(segments)), Vec::new());
        Self { edges, restitution: segments.restitution, lists }
    }
}

/// Lines at which the room within segments is measured.
const SCAN: u32 = 64;

/// Of its box the room within segments counts as this part at least, or there were too many cells.
const ROOM_MIN: f64 = 1.0 / 16.0;

/// Corners, border and room (m^2) of cells for discs within segments: the box around these, if
/// three of four discs are in it. Who is not, or leaves, counts for one of an outermost cell.
pub(super) fn field(segments: &Segments, discs: &[Disc]) -> Option<(DVec2, DVec2, Border, f64)> {
    let ends = || segments.all().iter().flat_map(|segment| [segment.from, segment.to]);
    let (min, max) = (ends().reduce(DVec2::min)?, ends().reduce(DVec2::max)?);
    let lies_within =
        |disc: &&Disc| disc.position.cmpge(min).all() && disc.position.cmple(max).all();
    let within = discs.iter().filter(lies_within).count();
    let area = (max - min).element_product();
    (within > 0 && 4 * within >= 3 * discs.len() && area > 0.0)
        .then(|| (min, max, Border::Closed, room(segments, min, max).max(ROOM_MIN * area)))
}

/// About how much room there is within segments, m^2: only the speed depends on it.
fn room(segments: &Segments, min: DVec2, max: DVec2) -> f64 {
    let height = (max.y - min.y) / f64::from(SCAN);
    let across = |line: u32| {
        let y = min.y + (f64::from(line) + 0.5) * height;
        let crossed = segments.all().iter().filter(|of| (of.from.y > y) != (of.to.y > y));
        let x = crossed.map(|of| {
            of.from.x + (of.to.x - of.from.x) * ((y - of.from.y) / (of.to.y - of.from.y))
        });
        let mut x: Vec<f64> = x.collect();
        x.sort_unstable_by(f64::total_cmp);
        let pairs = x.chunks_exact(2).map(|two| two[1] - two[0]);
        // Of a line that ends in the room nobody knows the other side.
        if x.len().is_multiple_of(2) { pairs.sum() } else { max.x - min.x }
    };
    (0..SCAN).map(across).sum::<f64>() * height
}

impl Events {
    /// Lists the segments near each cell.
    pub(super) fn list_segments(&mut self) {
        let Some(segments) = self.laws.segments.as_ref().filter(|_| self.fence.is_some()) else {
            return;
        };
        let list = |level: usize| {
            let radius = self.levels.radius(level).unwrap_or(0.5 * self.diameter);
            self.levels.grid(&self.cells, level).lists(segments.all(), radius)
        };
        let lists = (0..self.levels()).map(list).collect();
        if let Some(fence) = &mut self.fence {
            fence.lists = lists;
        }
    }

    /// A segment may come before what a disc of a level is due for.
    #[inline(never)]
    pub(super) fn consider_segments(&mut self, k: usize, level: usize) {
        let Some(fence) = &self.fence else { return };
        let due = &mut self.dues[k];
        let cells = self.levels.grid(&self.cells, level);
        let near = cells.listed(&fence.lists[level], due.place);
        if near.is_empty() || self.owners[k] != Owner::Simulated {
            return;
        }
        let (flight, radius) = (&self.flights[k], self.radii.get(k));
        let (position, velocity) = (flight.at(self.now), flight.velocity());
        for &place in near {
            let (edge, horizon) = (&fence.edges[place as usize], due.time() - self.now);
            if !edge.may_touch_within(position, velocity, radius, horizon) {
                continue;
            }
            let wait = edge.impact(&position.into(), &velocity.into(), radius);
            let Some(time) = wait.map(|wait| self.now + wait) else { continue };
            let is_met = time > self.now || edge.is_approached(position, velocity, radius);
            if time < due.contact && is_met {
                (due.contact, due.partner) = (time, SEGMENT | place);
            }
        }
    }

    /// A disc touches a segment: it turns round.
    pub(super) fn bounce_off_segment<U: Unit>(
        &mut self,
        k: usize,
        place: usize,
        witness: &mut impl Witness,
    ) {
        let Some(fence) = &self.fence else { return };
        let disc = self.disc(k);
        let restitution = self.restitution(fence.restitution, &[k]);
        let near = fence.edges[place].near(&disc.position.into(), disc.radius);
        if let Some(turn) = turn(&disc, &disc.velocity.into(), &near, restitution) {
            self.flights[k].turn(self.now, turn.bounce.velocity);
            self.energy.book(-turn.bounce.energy_loss);
            self.momentum.book(turn.normal * -turn.bounce.impulse);
            self.note_contacts::<U>(&[k], 1);
            let (gap, now) = (near.gap, self.now());
            witness.see(|| segment_contact(&disc, place as u32, gap, &turn, now));
        }
        U::renew(self, k, f64::NAN);
    }
}
