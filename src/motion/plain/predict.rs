//! What comes next for a body: the earliest of all meetings with others and with the walls.

use glam::DVec2;

use super::body::State;
use super::{Event, NEVER, Plain, With};
use crate::detect::falling::{Approach, falling_pair_impact, falling_wall_impact};
use crate::detect::impact::Hit;
use crate::detect::precise::{Sight, pair_impact, wall_impact};
use crate::exact::DoubleDouble;
use crate::resolve::pair::rounding_speed;
use crate::world::{Disc, Periodic, limits};

impl Plain {
    pub(super) fn predict_all(&mut self) {
        self.next = vec![NEVER; self.bodies.len()];
        let offset = self.clock.offset(self.now);
        (0..self.bodies.len()).for_each(|k| self.predict(k, offset));
    }

    /// Predicts the bodies that changed, and those whose next event was with one of them.
    pub(super) fn predict_again(&mut self, changed: &[usize], offset: f64) {
        let stale = |event: &Event| matches!(event.with, With::Body(k) if changed.contains(&k));
        let orphans: Vec<usize> = (0..self.next.len()).filter(|&k| stale(&self.next[k])).collect();
        for &k in changed.iter().chain(&orphans) {
            self.next[k] = NEVER;
        }
        changed.iter().for_each(|&k| self.predict(k, offset));
        let orphans = orphans.into_iter().filter(|k| !changed.contains(k));
        orphans.for_each(|k| self.predict(k, offset));
    }

    /// Finds the earliest event of a body; tells the partners for whom it comes before theirs.
    fn predict(&mut self, k: usize, offset: f64) {
        let watcher = self.watcher(k, offset);
        let mut first = self.next[k];
        if let Some(hit) = self.wall_ahead(&watcher)
            && offset + hit.time < first.time
        {
            first = Event { time: offset + hit.time, with: With::Wall(hit.side) };
        }
        if let Some((time, segment)) = self.segment_ahead(&watcher)
            && offset + time < first.time
        {
            first = Event { time: offset + time, with: With::Segment(segment) };
        }
        // Largest relative velocity and reach seen: how long the nearest images stay the nearest.
        let (mut fastest, mut widest) = (DVec2::ZERO, 0.0f64);
        for (l, other) in self.bodies.iter().enumerate() {
            if l == k || !self.bodies[k].can_collide_with(other) {
                continue;
            }
            let mut disc = other.roughly_at(offset);
            if self.laws.periodic.is_some() {
                disc = self.laws.near(watcher.disc.position, disc);
                fastest = fastest.max((disc.velocity - watcher.disc.velocity).abs());
                widest = widest.max(disc.radius + watcher.disc.radius);
            }
            let latest = first.time.max(self.next[l].time);
            if !self.may_meet(&watcher, &disc, latest - offset) {
                continue;
            }
            let Some(time) = self.meeting(&watcher, l) else { continue };
            let time = offset + time;
            if time < first.time {
                first = Event { time, with: With::Body(l) };
            }
            if time < self.next[l].time {
                self.next[l] = Event { time, with: With::Body(k) };
            }
        }
        if let Some(periodic) = self.laws.periodic {
            let time = offset + valid_for(&periodic, fastest, widest);
            if time < first.time {
                first = Event { time, with: With::Renew };
            }
        }
        self.next[k] = first;
    }

    /// A body as it looks for partners at an offset.
    pub(super) fn watcher(&self, k: usize, offset: f64) -> Watcher {
        let (body, state) = (&self.bodies[k], self.bodies[k].state_at(offset));
        let (position, velocity) = (state.position.hi(), state.velocity.hi());
        Watcher { k, offset, state, disc: Disc { position, velocity, ..body.disc } }
    }

    /// The next wall of a body.
    fn wall_ahead(&self, watcher: &Watcher) -> Option<Hit> {
        let (body, disc) = (&self.bodies[watcher.k], &watcher.disc);
        let walls = self.laws.walls.filter(|_| body.is_simulated())?;
        if body.acceleration == DVec2::ZERO {
            return wall_impact(&watcher.state.position, disc.velocity, disc.radius, &walls);
        }
        falling_wall_impact(disc, body.acceleration, &walls)
    }

    /// The next segment of a body: when, and which, the first of equals.
    fn segment_ahead(&self, watcher: &Watcher) -> Option<(f64, u32)> {
        if self.edges.is_empty() || !self.bodies[watcher.k].is_simulated() {
            return None;
        }
        let State { position, velocity } = &watcher.state;
        let radius = watcher.disc.radius;
        let times = self.edges.iter().map(|edge| edge.impact(position, velocity, radius));
        let hits = (0u32..).zip(times).filter_map(|(k, time)| Some((time?, k)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Whether a disc, known in plain doubles, could meet it within the horizon (s): quick, and
    /// never wrongly `false`.
    #[inline(always)]
    pub(super) fn may_meet(&self, watcher: &Watcher, disc: &Disc, horizon: f64) -> bool {
        let (d, w) = (disc.position - watcher.disc.position, disc.velocity - watcher.disc.velocity);
        let reach = disc.radius + watcher.disc.radius;
        // Falling discs come back; extreme units have no squares.
        let any = self.laws.gravity.is_some() || self.laws.extreme_units;
        any || self.doubt.may_meet_within(d, w, reach, horizon)
    }

    /// Time until it collides with a body, s.
    pub(super) fn meeting(&self, watcher: &Watcher, l: usize) -> Option<f64> {
        let other = &self.bodies[l];
        let state = other.state_at(watcher.offset);
        let sight = self.sight(watcher.k, &watcher.state, l, &state);
        let rounding_speed = || {
            let velocity = state.velocity.hi();
            rounding_speed(&watcher.disc, &Disc { velocity, ..other.disc })
        };
        // A pair that touches and approaches by no more than the rounding of its velocities creeps
        // by some 1e-16 of its speed instead of colliding.
        let approaches = || -sight.closing().value() > rounding_speed() * sight.d.hi().length();
        let pull = other.acceleration - self.bodies[watcher.k].acceleration;
        if self.laws.gravity.is_some() && pull != DVec2::ZERO {
            // Quick enough for the collapse model to make it a hop: or it would sink in.
            let quick = 0.25 * self.laws.contact_time;
            let shortest = if quick > 0.0 { quick } else { limits::PRESSED_CONTACT_S };
            let (d, w) = (sight.d.hi(), sight.w.hi());
            let next = falling_pair_impact(d, w, pull, sight.reach.value(), shortest);
            return next.map(|time| match time {
                Approach::At(time) => time,
                Approach::Now if approaches() => 0.0,
                Approach::Now | Approach::Pressed => shortest,
            });
        }
        if let Some(mut known) = self.remembered.find(watcher.k, l).copied() {
            known.fly(watcher.offset.into(), &sight);
            let caught = [watcher.k, l].iter().all(|&k| self.is_caught(k, watcher.offset));
            return known.time_to_contact(&sight).filter(|_| !caught || approaches());
        }
        pair_impact(&sight).filter(|time| *time > 0.0 || approaches())
    }

    /// One body as another sees it, from their states at the same instant.
    pub(super) fn sight(&self, k: usize, own: &State, l: usize, other: &State) -> Sight {
        let radius = |k: usize| self.bodies[k].disc.radius;
        Sight {
            d: self.laws.nearest(other.position.minus(own.position)),
            w: other.velocity.minus(own.velocity),
            reach: DoubleDouble::sum(radius(k), radius(l)),
        }
    }
}

/// A body that looks for partners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Watcher {
    /// Its index.
    k: usize,
    /// When it looks, s.
    offset: f64,
    state: State,
    /// The same as doubles show it.
    disc: Disc,
}

/// For how long the nearest images of all pairs remain those that touch next, s.
fn valid_for(periodic: &Periodic, fastest: DVec2, widest: f64) -> f64 {
    (periodic.room(widest) / fastest).min_element()
}
