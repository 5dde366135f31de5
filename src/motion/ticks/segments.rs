//! The segments that a disc meets within a window, and who need not look at any.
//!
//! For each disc a place is kept, and how far the nearest segment is from there: as long as the
//! disc stays within that, no segment is looked at, for many ticks. That is true of the place
//! whoever was there, so nothing has to be made anew when discs come and go.

use std::ops::Range;

use glam::DVec2;

use super::Ticks;
use super::agenda::With;
use super::bodies::Flight;
use crate::detect::segment::Edge;
use crate::world::Segments;

/// What rounding may make of a distance.
const SAFE: f64 = 1.0 + 1e-9;

/// A place without a segment near.
#[derive(Clone, Copy, Debug)]
struct Clear {
    place: DVec2,
    /// Distance of the nearest segment, m.
    distance: f64,
}

/// All segments, and where there are none.
#[derive(Clone, Debug)]
pub(super) struct Fence {
    edges: Vec<Edge>,
    /// One for each disc.
    clear: Vec<Clear>,
}

impl Fence {
    /// Of these segments.
    pub fn new(segments: Option<&Segments>) -> Self {
        Self { edges: Edge::all(segments), clear: Vec::new() }
    }

    /// A segment by its place.
    pub fn edge(&self, place: u32) -> &Edge {
        &self.edges[place as usize]
    }

    /// Whether disc `k`, at this place, might touch a segment on a way of so many metres.
    fn is_near(&mut self, k: usize, position: DVec2, reach: f64) -> bool {
        let reach = reach * SAFE;
        let Clear { place, distance } = self.clear[k];
        if position.distance(place) * SAFE + reach < distance {
            return false;
        }
        let distances = self.edges.iter().map(|edge| edge.segment.distance(position));
        let distance = distances.fold(f64::INFINITY, f64::min) / SAFE;
        self.clear[k] = Clear { place: position, distance };
        reach >= distance
    }

    /// The first segment that a disc meets from an offset (s) on within a horizon (s): at which
    /// offset, and which.
    fn first(
        &self,
        flight: &Flight,
        position: DVec2,
        now: f64,
        horizon: f64,
    ) -> Option<(f64, u32)> {
        let Flight { velocity, radius, .. } = *flight;
        let way = (velocity.length() * horizon + radius) * SAFE;
        let (position_whole, velocity_whole) = (position.into(), velocity.into());
        let mut first: Option<(f64, u32)> = None;
        for (place, edge) in (0..).zip(&self.edges) {
            if edge.segment.distance(position) > way * SAFE {
                continue;
            }
            let wait = edge.impact(&position_whole, &velocity_whole, radius);
            let Some(offset) = wait.map(|wait| now + wait) else { continue };
            let is_met = offset > now || edge.is_approached(position, velocity, radius);
            if is_met && first.is_none_or(|(other, _)| offset < other) {
                first = Some((offset, place));
            }
        }
        first
    }
}

impl Ticks {
    /// The segments that discs meet next, if they do so in the window.
    pub(super) fn foresee_segments(&mut self, discs: Range<usize>, horizon: f64) {
        if self.fence.edges.is_empty() {
            return;
        }
        let unknown = Clear { place: DVec2::ZERO, distance: f64::NEG_INFINITY };
        self.fence.clear.resize(self.bodies.len(), unknown);
        for k in discs {
            let flight = self.bodies.flights[k];
            let position = flight.at(self.present, self.tick_s);
            let reach = flight.velocity.length() * horizon + flight.radius;
            if !self.body(k).is_simulated() || !self.fence.is_near(k, position, reach) {
                continue;
            }
            let first = self.fence.first(&flight, position, self.present.offset, horizon);
            let Some((offset, place)) = first else { continue };
            if self.is_in_window(offset) {
                self.agenda.add(offset, k, With::Segment(place));
            }
        }
    }
}
