//! What comes next for a body: the earliest of all meetings with others and with the walls.

use glam::DVec2;

use super::ahead::Ahead;
use super::{Event, NEVER, Plain, With};
use crate::detect::falling::{Approach, falling_pair_impact, falling_wall_impact};
use crate::detect::impact::{may_meet_within, pair_impact, pair_impact_at_any_scale, wall_impact};
use crate::resolve::pair::{approach, rounding_speed};
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
        let body = self.bodies[k];
        let disc = body.at(offset);
        let mut first = self.next[k];
        if let Some(walls) = self.laws.walls.filter(|_| body.is_simulated()) {
            let hit = if body.acceleration == DVec2::ZERO {
                wall_impact(disc.position, disc.velocity, disc.radius, &walls)
            } else {
                falling_wall_impact(&disc, body.acceleration, &walls)
            };
            if let Some(hit) = hit.filter(|hit| offset + hit.time < first.time) {
                first = Event { time: offset + hit.time, with: With::Wall(hit.side) };
            }
        }
        let mut ahead = Ahead::new();
        for (l, other) in self.bodies.iter().enumerate() {
            let latest = first.time.max(self.next[l].time);
            if offset + ahead.time(self, k, l, offset) >= latest {
                continue;
            }
            if l == k || !body.can_collide_with(other) {
                continue;
            }
            let (pull, other) = (other.acceleration - body.acceleration, other.at(offset));
            let other = self.laws.near(disc.position, other);
            let Some(time) = self.meeting(&disc, &other, pull, latest - offset) else { continue };
            let time = offset + time;
            if time < first.time {
                first = Event { time, with: With::Body(l) };
            }
            if time < self.next[l].time {
                self.next[l] = Event { time, with: With::Body(k) };
            }
        }
        if let Some(periodic) = self.laws.periodic {
            // How long the nearest images stay the nearest.
            let time = offset + valid_for(&periodic, ahead.fastest, ahead.widest);
            if time < first.time {
                first = Event { time, with: With::Renew };
            }
        }
        self.next[k] = first;
    }

    /// Time until two discs collide, s, if that is within the horizon; `pull`: acceleration of the
    /// second seen from the first, m/s^2.
    pub(super) fn meeting(&self, a: &Disc, b: &Disc, pull: DVec2, horizon: f64) -> Option<f64> {
        let (d, w) = (b.position - a.position, b.velocity - a.velocity);
        let reach = a.radius + b.radius;
        if self.laws.gravity.is_some() && pull != DVec2::ZERO {
            // Quick enough for the collapse model to make it a hop: or it would sink in.
            let quick = 0.25 * self.laws.contact_time;
            let shortest = if quick > 0.0 { quick } else { limits::PRESSED_CONTACT_S };
            let next = falling_pair_impact(d, w, pull, reach, shortest);
            return next.map(|time| match time {
                Approach::At(time) => time,
                Approach::Now if approaches_beyond_rounding(a, b) => 0.0,
                Approach::Now | Approach::Pressed => shortest,
            });
        }
        let time = if self.laws.extreme_units {
            pair_impact_at_any_scale(d, w, reach)?
        } else if may_meet_within(d, w, reach, horizon) {
            pair_impact(d, w, reach)?
        } else {
            return None;
        };
        // Touching already: the resolver has the last word on whether they approach.
        (time > 0.0 || approaches_beyond_rounding(a, b)).then_some(time)
    }
}

/// For how long the nearest images of all pairs remain those that touch next, s: at first another
/// is at least half a box away on one axis, and it must come to the reach. The margin is rounding;
/// an observed circle too wide for the box may be missed.
fn valid_for(periodic: &Periodic, fastest: DVec2, widest: f64) -> f64 {
    let half = 0.5 * periodic.size();
    let way = (half - widest).max(half / 64.0) * (1.0 - 1e-9);
    (way / fastest).min_element()
}

/// Whether two discs in contact approach by more than the rounding of their velocities; a pair that
/// does not creeps by some 1e-16 of its speed instead of colliding.
fn approaches_beyond_rounding(a: &Disc, b: &Disc) -> bool {
    approach(a, b).is_some_and(|(_, speed)| speed > rounding_speed(a, b))
}
