//! Contacts at the same instant that share discs, resolved together: the generalised reflection
//! operator of Smith, Kaufman, Vouga, Tamstorf, Grinspun, doi:10.1145/2185520.2185602.
//!
//! Of all contacts that approach, impulses `l >= 0` are sought so that no contact approaches faster
//! than restitution allows: `0 <= l  _|_  A l + (1 + e) s >= 0`, with `s` the relative normal
//! velocities (negative) and `A = N^T M^-1 N`. Momentum is kept, energy too at restitution 1, and a
//! symmetric scene stays symmetric, which pair by pair it would not. One contact alone is the pair
//! law, so nothing here runs unless contacts share a disc.

use glam::DVec2;

use crate::world::Disc;

/// Pivots and gradients below this part of the largest are nothing but rounding.
const ROUNDING: f64 = 1e-13;

/// One contact of a cluster: two indices into its discs and the unit normal from the first to the
/// second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touching {
    /// The first disc.
    pub i: usize,
    /// The second disc.
    pub j: usize,
    /// Unit normal from the first to the second.
    pub normal: DVec2,
}

/// What one contact of a cluster gave.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blow {
    /// Impulse along the normal, N s.
    pub impulse: f64,
    /// Speed of approach before, m/s; above 0.
    pub approach_speed: f64,
    /// Kinetic energy taken, J.
    pub energy_loss: f64,
}

/// Reflects groups of contacts; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub struct Reflector {
    /// `A = N^T M^-1 N`, row by row: what an impulse at one contact does to the speed at another.
    coupling: Vec<f64>,
    /// Relative normal speeds before, m/s.
    before: Vec<f64>,
    /// The changes of them that restitution asks for, m/s.
    wanted: Vec<f64>,
    impulses: Vec<f64>,
    blows: Vec<Blow>,
    /// Contacts with an impulse, in order.
    active: Vec<usize>,
    /// Impulses if the active contacts were all.
    target: Vec<f64>,
    /// The elimination's copy of the active part of `coupling`, with `wanted` as last column.
    rows: Vec<f64>,
}

impl Reflector {
    /// Reflects the velocities of `discs` at `contacts`, all of which approach.
    pub fn reflect(&mut self, discs: &mut [Disc], contacts: &[Touching], restitution: f64) {
        let normal_speed = |discs: &[Disc], c: &Touching| {
            (discs[c.j].velocity - discs[c.i].velocity).dot(c.normal)
        };
        self.before.clear();
        self.before.extend(contacts.iter().map(|c| normal_speed(discs, c)));
        self.wanted.clear();
        self.wanted.extend(self.before.iter().map(|s| -(1.0 + restitution) * s));
        self.couple(discs, contacts);
        self.find_impulses();
        for (c, impulse) in contacts.iter().zip(&self.impulses) {
            let kick = *impulse * c.normal;
            // An infinite mass takes nothing: a finite number over infinity is 0.
            discs[c.i].velocity -= kick / discs[c.i].mass;
            discs[c.j].velocity += kick / discs[c.j].mass;
        }
        let told = contacts.iter().zip(&self.before).zip(&self.impulses);
        self.blows.clear();
        self.blows.extend(told.map(|((c, s), impulse)| {
            let loss = -0.5 * impulse * (s + normal_speed(discs, c));
            // Plus 0: no loss has no sign.
            let energy_loss = if restitution < 1.0 { loss + 0.0 } else { 0.0 };
            // That they approach is known exactly; by rounding their speed may be none.
            let approach_speed = (-s).max(f64::MIN_POSITIVE);
            Blow { impulse: *impulse, approach_speed, energy_loss }
        }));
    }

    /// What each contact of the last reflection gave.
    pub fn blows(&self) -> &[Blow] {
        &self.blows
    }

    fn couple(&mut self, discs: &[Disc], contacts: &[Touching]) {
        self.coupling.clear();
        for a in contacts {
            for b in contacts {
                let mut sum = 0.0;
                for (x, sign_x) in [(a.i, -1.0), (a.j, 1.0)] {
                    for (y, sign_y) in [(b.i, -1.0), (b.j, 1.0)] {
                        if x == y {
                            sum += sign_x * sign_y / discs[x].mass;
                        }
                    }
                }
                self.coupling.push(sum * a.normal.dot(b.normal));
            }
        }
    }

    /// Minimises `l A l / 2 - wanted l` over `l >= 0`: the solution of the complementarity problem.
    ///
    /// First all contacts at once, which mostly holds; else the active-set method of Lawson and
    /// Hanson (Solving Least Squares Problems, 1974, chapter 23), which ends after finitely many
    /// steps.
    fn find_impulses(&mut self) {
        let count = self.wanted.len();
        self.active.clear();
        self.active.extend(0..count);
        if self.solve_active() && self.target.iter().all(|l| *l >= 0.0) {
            self.impulses.clone_from(&self.target);
            return;
        }
        self.active.clear();
        self.impulses.clear();
        self.impulses.resize(count, 0.0);
        let scale = self.wanted.iter().fold(0.0f64, |scale, w| scale.max(w.abs()));
        let mut refused = vec![false; count];
        // Each step adds a contact; what is taken out again is bounded by the method.
        for _ in 0..4 * count {
            let open = (0..count).filter(|k| !refused[*k] && !self.active.contains(k));
            let best = open.map(|k| (k, self.lack(k))).max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((k, _)) = best.filter(|(_, lack)| *lack > ROUNDING * scale) else { break };
            let place = self.active.partition_point(|other| *other < k);
            self.active.insert(place, k);
            if !self.shrink_to_feasible() {
                // Its impulse depends on those of the others: it is not needed.
                self.active.retain(|other| *other != k);
                refused[k] = true;
            }
        }
    }

    /// What the impulses so far leave to be wanted at a contact.
    fn lack(&self, k: usize) -> f64 {
        let count = self.wanted.len();
        let row = &self.coupling[k * count..(k + 1) * count];
        self.wanted[k] - row.iter().zip(&self.impulses).map(|(a, l)| a * l).sum::<f64>()
    }

    /// Moves towards the solution of the active contacts; those whose impulse would turn negative
    /// on the way leave. `false` if the active contacts depend on each other.
    fn shrink_to_feasible(&mut self) -> bool {
        loop {
            if !self.solve_active() {
                return false;
            }
            let mut step = 1.0f64;
            for (&k, l) in self.active.iter().zip(&self.target) {
                if *l <= 0.0 {
                    step = step.min(self.impulses[k] / (self.impulses[k] - l));
                }
            }
            for (&k, l) in self.active.iter().zip(&self.target) {
                self.impulses[k] += step * (l - self.impulses[k]);
            }
            if step >= 1.0 {
                return true;
            }
            let largest = self.impulses.iter().copied().fold(0.0, f64::max);
            let (before, impulses) = (self.active.len(), &mut self.impulses);
            self.active.retain(|k| impulses[*k] > ROUNDING * largest);
            for k in (0..impulses.len()).filter(|k| !self.active.contains(k)) {
                impulses[k] = 0.0;
            }
            if self.active.len() == before || self.active.is_empty() {
                return true;
            }
        }
    }

    /// Solves `A l = wanted` on the active contacts by elimination, into `target`; `false` if they
    /// depend on each other.
    fn solve_active(&mut self) -> bool {
        let (count, all) = (self.active.len(), self.wanted.len());
        let width = count + 1;
        self.rows.clear();
        for &k in &self.active {
            self.rows.extend(self.active.iter().map(|&l| self.coupling[k * all + l]));
            self.rows.push(self.wanted[k]);
        }
        let rows = &mut self.rows;
        let largest = (0..count).fold(0.0f64, |largest, k| largest.max(rows[k * width + k]));
        for step in 0..count {
            // A is symmetric and not negative: its diagonal serves as pivots.
            let pivot = rows[step * width + step];
            if pivot <= ROUNDING * largest {
                return false;
            }
            for below in step + 1..count {
                let factor = rows[below * width + step] / pivot;
                for column in step..width {
                    rows[below * width + column] -= factor * rows[step * width + column];
                }
            }
        }
        self.target.clear();
        self.target.resize(count, 0.0);
        for step in (0..count).rev() {
            let row = &rows[step * width..(step + 1) * width];
            let known: f64 = (step + 1..count).map(|l| row[l] * self.target[l]).sum();
            self.target[step] = (row[count] - known) / row[step];
        }
        true
    }
}
