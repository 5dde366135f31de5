//! Which discs may have met between two samples: groups that must be judged together.
//!
//! Discs that flew straight or were bent once have a known path; two of them are linked if their
//! paths touch where they bend, or cross. Whoever is more tangled is linked with every disturbed
//! disc whose swept circle it meets. Straight paths that cross are runs through each other.
//!
//! It only looks: what the contacts were is judged elsewhere.

use glam::DVec2;

use super::chains::Chains;
use super::flight::{Course, Flight, Means, Span};
use super::images;
use super::judge::JUDGED;
use super::law::Law;
use super::noise::Sigma;
use crate::detect::impact::pair_impact;
use crate::detect::{self, Pair, TooManyPairs};
use crate::plan::BroadPhase;
use crate::world::Disc;

/// Discs from which cells pay.
const GRID_FROM: usize = 24;

/// Part of the smaller radius within which two discs count as touching where they bend.
pub(super) const NEAR: f64 = 1e-3;

/// Two straight flights that cross, or two discs that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub pair: Pair,
    /// s after the earlier sample.
    pub instant: f64,
    /// Unit normal from the first to the second then.
    pub normal: DVec2,
    /// m/s
    pub approach: f64,
    /// Deepest overlap, m.
    pub depth: f64,
}

/// All that may have happened between two samples.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups {
    /// Indices of discs that must be judged together, at least one of them disturbed.
    pub groups: Vec<Vec<usize>>,
    /// Pairs that came near each other.
    pub near: Vec<Pair>,
    /// Undisturbed pairs that ran into each other.
    pub crossings: Vec<Crossing>,
    /// Pairs that overlap at the later sample, with their depth, m.
    pub overlaps: Vec<(Pair, f64)>,
}

/// Finds them.
///
/// # Errors
/// Discs lie heaped on each other.
pub(super) fn find(
    flights: &[Flight],
    span: &Span,
    means: &Means,
    tolerance: f64,
) -> Result<Groups, TooManyPairs> {
    let near = near_pairs(flights, span, means)?;
    let mut sets = Sets::new(flights.len());
    let mut found = Groups::default();
    let mut bound = vec![false; flights.len()];
    let (mut later, mut last, mut resting) = (Vec::new(), Vec::new(), Vec::new());
    for &(i, j) in &near {
        let pair = Couple::new(&flights[i], &flights[j], span.length, means.law);
        if let Some(depth) = pair.overlap_after(tolerance) {
            found.overlaps.push(((i, j), depth));
        }
        if pair.has(Course::Jumped) || pair.falls_unevenly(means) {
            continue;
        }
        match (flights[i].is_disturbed(), flights[j].is_disturbed()) {
            (false, false) => {
                found.crossings.extend(pair.crossing((i, j), tolerance));
                resting.extend(pair.rests_in_touch().then_some((i, j)));
            }
            (true, true) if !pair.has(Course::Tangled) && pair.is_linked() => {
                sets.join(i, j);
                (bound[i], bound[j]) = (true, true);
            }
            (true, true) => later.push((i, j)),
            _ => last.push((i, j)),
        }
    }
    let mut loosely = bound.clone();
    for (i, j) in later {
        let pair = Couple::new(&flights[i], &flights[j], span.length, means.law);
        if pair.is_linked_loosely([bound[i], bound[j]]) {
            sets.join(i, j);
            (loosely[i], loosely[j]) = (true, true);
        }
    }
    // Whoever is undisturbed met nobody, unless nobody else explains what became of the other.
    for &(i, j) in &last {
        let pair = Couple::new(&flights[i], &flights[j], span.length, means.law);
        if pair.is_linked_to_quiet(loosely[i] || loosely[j]) {
            sets.join(i, j);
        }
    }
    let (law, length) = (means.law, span.length);
    Chains { flights, law, length, resting: &resting, mixed: &last }.join(&mut sets);
    found.near = near;
    found.groups = sets.groups(|k| flights[k].is_disturbed());
    Ok(found)
}

/// Pairs whose swept circles meet, and of which one can change.
fn near_pairs(flights: &[Flight], span: &Span, means: &Means) -> Result<Vec<Pair>, TooManyPairs> {
    let sweep = |flight: &Flight| {
        let Flight { before, after, sigma, course, .. } = flight;
        if *course == Course::Jumped {
            return *after;
        }
        let own = before.velocity.length().max(after.velocity.length());
        let speed = match course {
            // Between two contacts it may have been faster than before and after.
            Course::Tangled => means.fastest,
            // Some engines answer a contact that would come later.
            Course::Bent(_) => 2.0 * own,
            _ => own,
        };
        let slack = JUDGED * sigma.position + NEAR * before.radius;
        let radius = before.radius + 0.5 * speed * span.length + slack;
        Disc { position: 0.5 * (before.position + after.position), radius, ..*before }
    };
    let swept: Vec<Disc> = flights.iter().map(sweep).collect();
    let few = swept.len() < GRID_FROM;
    let broad_phase = if few { BroadPhase::AllPairs } else { BroadPhase::Grid };
    let mut pairs = match &means.law.periodic {
        Some(periodic) => images::touching_pairs(&swept, periodic, broad_phase)?,
        None => detect::touching_pairs(&swept, 0.0, broad_phase)?,
    };
    // Two fixed discs pass through each other.
    let is_fixed = |k: usize| flights[k].before.mass.is_infinite();
    pairs.retain(|&(i, j)| !is_fixed(i) || !is_fixed(j));
    Ok(pairs)
}

/// Two flights.
pub(super) struct Couple<'a> {
    pub a: &'a Flight,
    pub b: &'a Flight,
    length: f64,
    /// From the second disc to its image nearest to the first, m.
    shift: DVec2,
}

impl<'a> Couple<'a> {
    pub fn new(a: &'a Flight, b: &'a Flight, length: f64, law: &Law) -> Self {
        Self { a, b, length, shift: law.shift_of(a, b) }
    }

    fn has(&self, course: Course) -> bool {
        self.a.course == course || self.b.course == course
    }

    fn falls_unevenly(&self, means: &Means) -> bool {
        self.a.fall(means.law) != self.b.fall(means.law)
    }

    pub fn reach(&self) -> f64 {
        self.a.before.radius + self.b.before.radius
    }

    fn smaller_radius(&self) -> f64 {
        self.a.before.radius.min(self.b.before.radius)
    }

    fn sigma(&self) -> Sigma {
        Sigma {
            position: self.a.sigma.position.hypot(self.b.sigma.position),
            velocity: self.a.sigma.velocity.hypot(self.b.sigma.velocity),
        }
    }

    /// Overlap at the later sample, if it is one.
    fn overlap_after(&self, tolerance: f64) -> Option<f64> {
        let depth = self.reach() - self.late().length();
        let allowed = (JUDGED * self.sigma().position).max(tolerance * self.smaller_radius());
        (depth > allowed).then_some(depth)
    }

    /// Relative position at an instant, from the earlier sample, or from the later one.
    pub fn early(&self, instant: f64) -> DVec2 {
        let (a, b) = (&self.a.before, &self.b.before);
        b.position - a.position + self.shift + (b.velocity - a.velocity) * instant
    }

    /// Relative position at the later sample.
    fn late(&self) -> DVec2 {
        self.b.after.position - self.a.after.position + self.shift
    }

    /// Place of one disc in the frame that falls with all.
    fn place(&self, flight: &Flight, instant: f64) -> DVec2 {
        let Flight { before, change, rest, course, .. } = flight;
        let straight = before.position + before.velocity * instant;
        match course {
            Course::Bent(bend) if instant > *bend => {
                // From the later sample backwards.
                let end = before.position + before.velocity * self.length + *rest;
                end - (before.velocity + *change) * (self.length - instant)
            }
            _ => straight,
        }
    }

    pub fn apart(&self, instant: f64) -> DVec2 {
        self.place(self.b, instant) - self.place(self.a, instant) + self.shift
    }

    /// Least distance of the surfaces of two known paths, m.
    fn least_gap(&self) -> f64 {
        let mut instants = [0.0, self.bend(self.a), self.bend(self.b), self.length];
        instants.sort_by(f64::total_cmp);
        let least = |ends: &[f64]| {
            let (p, q) = (self.apart(ends[0]), self.apart(ends[1]));
            closest(p, q - p).length()
        };
        instants.windows(2).map(least).fold(f64::INFINITY, f64::min) - self.reach()
    }

    fn bend(&self, flight: &Flight) -> f64 {
        if let Course::Bent(instant) = flight.course { instant } else { 0.0 }
    }

    /// How far the instant of a bend may be off, s.
    fn blur(&self, flight: &Flight) -> f64 {
        let size = flight.change.length();
        JUDGED * flight.sigma.of_rest(self.length) / size + 1e-6 * self.length
    }

    pub fn is_at_once(&self) -> bool {
        match (self.a.course, self.b.course) {
            (Course::Bent(a), Course::Bent(b)) => {
                (a - b).abs() <= self.blur(self.a) + self.blur(self.b)
            }
            _ => true,
        }
    }

    /// How far two surfaces may be apart and yet touch, m.
    pub fn nearness(&self) -> f64 {
        JUDGED * self.sigma().of_rest(self.length) + NEAR * self.smaller_radius()
    }

    /// Whether two known paths touch where they bend, or cross.
    fn is_linked(&self) -> bool {
        let near = self.nearness();
        let bends = [self.a, self.b].into_iter().filter(|flight| flight.is_disturbed());
        let touches =
            |flight: &Flight| (self.apart(self.bend(flight)).length() - self.reach()).abs() <= near;
        (self.is_at_once() && bends.into_iter().any(touches)) || self.least_gap() < -near
    }

    /// Whether two disturbed discs may have met though their paths do not say so. `bound`: whether
    /// each has met somebody who explains its bend.
    fn is_linked_loosely(&self, bound: [bool; 2]) -> bool {
        let free = |flight: &Flight, bound: bool| flight.course == Course::Tangled || !bound;
        free(self.a, bound[0])
            && free(self.b, bound[1])
            && (self.has(Course::Tangled)
                || (self.is_at_once() && (self.meets_ahead() || self.is_balanced())))
    }

    /// Whether one gained the momentum that the other lost, while they approached.
    fn is_balanced(&self) -> bool {
        let (a, b) = (self.a, self.b);
        let (ma, mb) = (a.before.mass, b.before.mass);
        let gained = (ma * a.change + mb * b.change).length();
        let moved = ma * a.change.length() + mb * b.change.length();
        let sigma = ma * a.sigma.of_change() + mb * b.sigma.of_change();
        let w = b.before.velocity - a.before.velocity;
        gained <= JUDGED * sigma + 1e-5 * moved && self.early(0.0).dot(w) < 0.0
    }

    /// Whether an undisturbed disc may have been met by one that met others, or nobody else.
    fn is_linked_to_quiet(&self, bound: bool) -> bool {
        if [self.a, self.b].into_iter().any(|flight| flight.before.mass.is_infinite()) {
            return self.has(Course::Tangled) || self.is_linked() || self.meets_ahead();
        }
        let apart = self.early(0.0).length() > self.reach() - self.nearness();
        !bound && apart && !self.has(Course::Tangled) && self.is_linked()
    }

    /// Whether the earlier velocities lead to contact in time.
    pub fn meets_ahead(&self) -> bool {
        let w = self.b.before.velocity - self.a.before.velocity;
        let time = pair_impact(self.early(0.0), w, self.reach());
        time.is_some_and(|time| time <= self.length)
    }

    /// Whether the later velocities come from a contact in time.
    pub fn met_behind(&self) -> bool {
        let w = self.a.after.velocity - self.b.after.velocity;
        let time = pair_impact(self.late(), w, self.reach());
        time.is_some_and(|time| time <= self.length)
    }

    /// Whether a relative speed is none, m/s.
    pub fn is_still(&self, speed: f64) -> bool {
        speed * self.length <= NEAR * self.smaller_radius()
            || speed <= JUDGED * self.sigma().velocity
    }

    /// Two undisturbed discs that run into each other, not only by a hair.
    fn crossing(&self, pair: Pair, tolerance: f64) -> Option<Crossing> {
        let d = self.early(0.0);
        let w = self.b.before.velocity - self.a.before.velocity;
        let instant = pair_impact(d, w, self.reach()).filter(|time| *time < self.length)?;
        let depth = self.reach() - closest(d, w * self.length).length();
        let allowed = JUDGED * self.sigma().of_rest(self.length);
        if depth <= allowed.max(tolerance * self.smaller_radius()) {
            return None;
        }
        let normal = (d + w * instant).normalize_or_zero();
        Some(Crossing { pair, instant, normal, approach: -w.dot(normal), depth })
    }
}

/// The point nearest to 0 on the way from `p` along `way`.
fn closest(p: DVec2, way: DVec2) -> DVec2 {
    let square = way.length_squared();
    let part = if square > 0.0 { (-p.dot(way) / square).clamp(0.0, 1.0) } else { 0.0 };
    p + way * part
}

/// Sets that are joined.
pub(super) struct Sets(Vec<usize>);

impl Sets {
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    pub fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    pub fn join(&mut self, i: usize, j: usize) {
        let (i, j) = (self.root(i), self.root(j));
        self.0[i.max(j)] = i.min(j);
    }

    /// All sets with a wanted member, in ascending order.
    fn groups(mut self, wanted: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let all = self.0.len();
        let mut place = vec![usize::MAX; all];
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let roots: Vec<usize> = (0..all).map(|k| self.root(k)).collect();
        for k in (0..all).filter(|&k| wanted(k)) {
            if place[roots[k]] == usize::MAX {
                place[roots[k]] = groups.len();
                groups.push(Vec::new());
            }
        }
        for k in 0..all {
            if let Some(group) = groups.get_mut(place[roots[k]]) {
                group.push(k);
            }
        }
        groups
    }
}
