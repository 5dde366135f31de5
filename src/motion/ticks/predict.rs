//! What happens within a window: who meets whom and which wall, in order of time.

use super::Ticks;
use super::agenda::With;
use super::bodies::{Flight, Sizes};
use crate::detect::impact::{
    Relative, may_meet_within, pair_impact, pair_impact_at_any_scale, pair_impacts, wall_impact,
};
use crate::resolve::pair::{approach, rounding_speed};
use crate::world::Disc;

/// Mean ways of discs in a window, in mean radii: in longer ones most discs would be near to most.
const WAY_MAX: f64 = 1.0;

/// Most halvings of a tick for the sake of that.
const HALVINGS_MAX: u32 = 20;

/// Meetings that are looked at side by side.
#[derive(Clone, Debug, Default)]
pub(super) struct Forecast {
    pairs: Vec<[u32; 2]>,
    relative: Vec<Relative>,
    times: Vec<f64>,
}

impl Ticks {
    /// Plans the window that begins now; returns the offset at which it ends.
    pub(super) fn plan(&mut self) -> f64 {
        let sizes = self.bodies.look(self.present);
        let end = self.end_of_window(&sizes);
        self.window_end = Some(end);
        let horizon = end - self.present.offset;
        if self.laws.extreme_units {
            self.neighbours.prepare_none(self.bodies.len());
        } else {
            self.neighbours.prepare(&self.bodies, &sizes, horizon);
        }
        self.agenda.clear(self.bodies.len());
        (0..self.bodies.len()).for_each(|k| self.foresee_wall(k, horizon));
        self.foresee_segments(0..self.bodies.len(), horizon);
        self.foresee_pairs(horizon);
        end
    }

    /// The tick's end, or a part of a tick by powers of two: the first such mark ahead.
    fn end_of_window(&mut self, sizes: &Sizes) -> f64 {
        let mut length = self.tick_s;
        let longest = WAY_MAX * sizes.radius_mean / sizes.speed_mean;
        if !self.laws.extreme_units {
            for _ in 0..HALVINGS_MAX {
                length *= if length > longest { 0.5 } else { 1.0 };
            }
        }
        if let Some(periodic) = self.laws.periodic {
            // For so long the nearest images stay those that touch next.
            let way = periodic.room(2.0 * sizes.radius_max).min_element();
            while 2.0 * sizes.component_max * length > way {
                length *= 0.5;
            }
            self.speed_allowed = way / (2.0 * length);
        }
        let offset = self.present.offset;
        let mark = ((offset / length).floor() + 1.0) * length;
        // Discs so fast that the clock has no such mark go on by its smallest step.
        let sound = mark > offset && mark - offset <= 1.5 * length;
        if sound { mark.min(self.tick_s) } else { offset.next_up() }
    }

    /// The wall that a disc meets next, if it does so in the window.
    fn foresee_wall(&mut self, k: usize, horizon: f64) {
        let Some(walls) = self.laws.walls else { return };
        let Flight { velocity, radius, .. } = self.bodies.flights[k];
        let position = self.bodies.flights[k].at(self.present, self.tick_s);
        let stays = walls.contain(position + velocity * horizon, radius);
        if (stays && !self.laws.extreme_units) || !self.body(k).is_simulated() {
            return;
        }
        if let Some(hit) = wall_impact(position, velocity, radius, &walls) {
            let offset = self.present.offset + hit.time;
            if self.is_in_window(offset) {
                self.agenda.add(offset, k, With::Wall(hit.side));
            }
        }
    }

    pub(super) fn is_in_window(&self, offset: f64) -> bool {
        self.window_end.is_some_and(|end| offset <= end)
    }

    fn foresee_pairs(&mut self, horizon: f64) {
        let (laws, seen) = (&self.laws, &self.bodies.seen[..]);
        let Forecast { pairs, relative, times } = &mut self.forecast;
        pairs.clear();
        relative.clear();
        self.neighbours.for_each_pair(|i, j| {
            let (a, b) = (&seen[i], &seen[j]);
            let (mut d, w) = (b.position - a.position, b.velocity - a.velocity);
            if let Some(periodic) = &laws.periodic {
                d += periodic.shift(d);
            }
            let s = a.radius + b.radius;
            if laws.extreme_units || may_meet_within(d, w, s, horizon) {
                pairs.push([i as u32, j as u32]);
                relative.push(Relative { d, w, s });
            }
        });
        times.resize(pairs.len(), 0.0);
        if laws.extreme_units {
            for (time, Relative { d, w, s }) in times.iter_mut().zip(relative) {
                *time = pair_impact_at_any_scale(*d, *w, *s).unwrap_or(f64::INFINITY);
            }
        } else {
            pair_impacts(relative, times);
        }
        for k in 0..self.forecast.pairs.len() {
            let ([i, j], time) = (self.forecast.pairs[k], self.forecast.times[k]);
            let offset = self.present.offset + time;
            let (i, j) = (i as usize, j as usize);
            if self.is_in_window(offset) && self.may_collide(i, j, time) {
                self.agenda.add(offset, i, With::Body(j as u32));
            }
        }
    }

    /// Whether two discs that meet in so many seconds from now have a contact then.
    fn may_collide(&self, i: usize, j: usize, time: f64) -> bool {
        if !self.body(i).can_collide_with(self.body(j)) {
            return false;
        }
        if time > 0.0 {
            return true;
        }
        // Touching already: the resolver has the last word on whether they approach.
        let a = self.bodies.at(i, self.present);
        let b = self.bodies.near(a.position, self.bodies.at(j, self.present));
        approaches_beyond_rounding(&a, &b)
    }

    /// Predicts discs whose flights began anew at the present.
    pub(super) fn predict_again(&mut self, changed: &[usize]) {
        let Some(end) = self.window_end else { return };
        let horizon = end - self.present.offset;
        for &k in changed {
            self.agenda.void(k);
            let flight = &self.bodies.flights[k];
            if flight.velocity.abs().max_element() > self.speed_allowed {
                // Too fast for the images of this window.
                self.window_end = None;
                return;
            }
            self.neighbours.follow(k, flight.start, flight.velocity.length() * horizon);
        }
        for (place, &k) in changed.iter().enumerate() {
            self.foresee_wall(k, horizon);
            self.foresee_segments(k..k + 1, horizon);
            self.meet_neighbours(k, horizon, &changed[..place]);
            for n in 0..self.forecast.pairs.len() {
                let ([_, j], time) = (self.forecast.pairs[n], self.forecast.times[n]);
                let (first, second) = (k.min(j as usize), k.max(j as usize));
                if self.is_in_window(self.present.offset + time) {
                    let with = With::Body(second as u32);
                    self.agenda.add(self.present.offset + time, first, with);
                }
            }
        }
    }

    /// Notes when a disc meets its neighbours, but for those that are done.
    fn meet_neighbours(&mut self, k: usize, horizon: f64, done: &[usize]) {
        let mut forecast = std::mem::take(&mut self.forecast);
        let Forecast { pairs, times, .. } = &mut forecast;
        pairs.clear();
        times.clear();
        let (flights, extreme) = (&self.bodies.flights[..], self.laws.extreme_units);
        let position = flights[k].at(self.present, self.tick_s);
        for j in self.neighbours.of(k) {
            if j == k || done.contains(&j) {
                continue;
            }
            let mut d = flights[j].at(self.present, self.tick_s) - position;
            if let Some(periodic) = &self.laws.periodic {
                d += periodic.shift(d);
            }
            let w = flights[j].velocity - flights[k].velocity;
            let s = flights[k].radius + flights[j].radius;
            let time = if extreme {
                pair_impact_at_any_scale(d, w, s)
            } else if may_meet_within(d, w, s, horizon) {
                pair_impact(d, w, s)
            } else {
                None
            };
            if let Some(time) = time.filter(|time| self.may_collide(k, j, *time)) {
                pairs.push([k as u32, j as u32]);
                times.push(time);
            }
        }
        self.forecast = forecast;
    }

    /// Adds to a group of contacts at one instant what touches any of its discs by `latest`.
    pub(super) fn complete_group(&mut self, latest: f64) {
        let wait = latest - self.present.offset;
        let mut seen = 0;
        while let Some(&(i, j)) = self.together.get(seen) {
            seen += 1;
            for k in [i, j] {
                self.meet_neighbours(k, wait, &[]);
                for n in 0..self.forecast.pairs.len() {
                    let pair = self.by_id(k, self.forecast.pairs[n][1] as usize);
                    if self.forecast.times[n] <= wait && !self.together.contains(&pair) {
                        self.together.push(pair);
                    }
                }
            }
        }
    }
}

/// Whether two discs in contact approach by more than the rounding of their velocities; a pair that
/// does not creeps by some 1e-16 of its speed instead of colliding.
fn approaches_beyond_rounding(a: &Disc, b: &Disc) -> bool {
    approach(a, b).is_some_and(|(_, speed)| speed > rounding_speed(a, b))
}
