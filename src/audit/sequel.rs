//! What the law makes of a few discs from one sample to the next, or backwards.
//!
//! The next of all contacts, then the next: exact, and plain, for groups of a few discs. Backwards
//! the same law holds with the inverse restitution, which is why this is not the arena. Along with
//! every disc goes a bound of its error, which each contact widens by its geometry.
//!
//! Never used for a whole arena.

use glam::DVec2;

use super::noise::Sigma;
use crate::detect::falling::falling_wall_impact;
use crate::detect::impact::{pair_impact, wall_impact};
use crate::detect::touching::gap;
use crate::resolve::pair::{MassFractions, collide};
use crate::resolve::touching::resolve_in;
use crate::world::{Disc, Partner, Periodic, Walls};

/// Discs of a group that is still followed.
pub(super) const DISCS_MAX: usize = 64;

/// Contacts of a group that is still followed.
const CONTACTS_MAX: usize = 200;

/// Contacts within this part of the time are at once.
const AT_ONCE: f64 = 1e-12;

/// The rules.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rules<'a> {
    pub restitution: f64,
    pub walls: Option<&'a Walls>,
    pub wall_restitution: f64,
    /// The box that repeats.
    pub periodic: Option<&'a Periodic>,
    /// How far a wall may be off, m.
    pub walls_sigma: f64,
    /// Acceleration of discs of finite mass, m/s^2.
    pub gravity: DVec2,
    /// Two discs that do not see each other.
    pub blind: Option<(usize, usize)>,
    /// Ends just before this contact.
    pub until_contact: usize,
}

impl Rules<'_> {
    /// A disc at its image nearest to another.
    fn image(&self, of: &Disc, disc: &Disc) -> Disc {
        let shift = |periodic: &Periodic| periodic.shift(disc.position - of.position);
        let by = self.periodic.map_or(DVec2::ZERO, shift);
        Disc { position: disc.position + by, ..*disc }
    }
}

/// A contact on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Touch {
    pub a: usize,
    /// `None` = a wall.
    pub b: Option<usize>,
    /// s after the beginning.
    pub time: f64,
    /// From a to b.
    pub normal: DVec2,
    pub place: DVec2,
    pub approach: f64,
    pub before: [DVec2; 2],
    /// Kinetic energy gained, J.
    pub energy: f64,
    /// How deep the two overlapped already, m; 0 at a wall.
    pub depth: f64,
    /// Bound of the errors of both before it.
    pub errors: Sigma,
}

/// Discs on their way.
#[derive(Clone, Debug)]
pub(super) struct Sequel {
    pub discs: Vec<Disc>,
    /// Bounds of their errors.
    pub errors: Vec<Sigma>,
    pub touches: Vec<Touch>,
    /// Pairs that touch and have no approach left but rounding.
    settled: Vec<(usize, usize)>,
    now: f64,
}

#[derive(Clone, Copy)]
enum Next {
    Pair(usize, usize),
    Wall(usize, crate::world::Side),
}

impl Sequel {
    /// Discs at the beginning, with the errors of what was recorded.
    pub fn new(discs: Vec<Disc>, errors: Vec<Sigma>) -> Self {
        Self { discs, errors, touches: Vec::new(), settled: Vec::new(), now: 0.0 }
    }

    /// The largest bound of the error of a velocity, m/s.
    pub fn unsure(&self) -> f64 {
        self.errors.iter().map(|error| error.velocity).fold(0.0, f64::max)
    }

    /// Moves on by `length` (s), or to just before a contact; `None` = there are too many.
    pub fn follow(mut self, length: f64, rules: &Rules) -> Option<Self> {
        if self.discs.len() > DISCS_MAX {
            return None;
        }
        loop {
            let (wait, at_once) = self.next(rules);
            let due = self.now + wait <= length * (1.0 + AT_ONCE);
            if !due || self.touches.len() >= rules.until_contact {
                let end = if due { self.now + wait } else { length };
                self.drift(end.min(length) - self.now, rules.gravity);
                return Some(self);
            }
            if self.touches.len() > CONTACTS_MAX {
                return None;
            }
            self.drift(wait, rules.gravity);
            self.contact(&at_once, rules);
        }
    }

    /// Time to the next contact, and all that come then.
    fn next(&self, rules: &Rules) -> (f64, Vec<Next>) {
        let mut first = f64::INFINITY;
        let mut found: Vec<(f64, Next)> = Vec::new();
        let mut add = |time: f64, next: Next| {
            let margin = AT_ONCE * (self.now + time);
            if time <= first + margin {
                first = first.min(time);
                found.push((time, next));
            }
        };
        for (i, a) in self.discs.iter().enumerate() {
            for (j, b) in self.discs.iter().enumerate().skip(i + 1) {
                if rules.blind == Some((i, j)) || self.settled.contains(&(i, j)) {
                    continue;
                }
                let (d, w) = (rules.image(a, b).position - a.position, b.velocity - a.velocity);
                let time = pair_impact(d, w, a.radius + b.radius);
                time.into_iter().for_each(|time| add(time, Next::Pair(i, j)));
            }
            let hit = rules.walls.and_then(|walls| {
                if rules.gravity == DVec2::ZERO || a.mass.is_infinite() {
                    wall_impact(a.position, a.velocity, a.radius, walls)
                } else {
                    falling_wall_impact(a, rules.gravity, walls)
                }
            });
            hit.into_iter().for_each(|hit| add(hit.time, Next::Wall(i, hit.side)));
        }
        let margin = AT_ONCE * (self.now + first);
        found.retain(|(time, _)| *time <= first + margin);
        (first, found.into_iter().map(|(_, next)| next).collect())
    }

    fn drift(&mut self, length: f64, gravity: DVec2) {
        for (disc, error) in self.discs.iter_mut().zip(&mut self.errors) {
            let fall = if disc.mass.is_finite() { gravity } else { DVec2::ZERO };
            disc.position += (disc.velocity + 0.5 * fall * length) * length;
            disc.velocity += fall * length;
            error.position += error.velocity * length;
        }
        self.now += length;
    }

    fn contact(&mut self, at_once: &[Next], rules: &Rules) {
        let pairs: Vec<(usize, usize)> = at_once.iter().filter_map(|next| pair(*next)).collect();
        if pairs.len() > 1 && rules.restitution <= 1.0 {
            self.together(&pairs, rules);
            return;
        }
        match at_once.first() {
            Some(&Next::Pair(i, j)) => self.meet(i, j, rules),
            Some(&Next::Wall(i, side)) => self.bounce(i, side.normal(), rules),
            None => {}
        }
    }

    fn meet(&mut self, i: usize, j: usize, rules: &Rules) {
        let restitution = rules.restitution;
        let a = self.discs[i];
        let b = rules.image(&a, &self.discs[j]);
        let energy = a.kinetic_energy() + b.kinetic_energy();
        let Some(impact) = collide(&a, &b, restitution) else {
            self.settled.push((i, j));
            return;
        };
        let errors = self.errors_of(i, j);
        self.widen(i, j, impact.approach_speed, restitution);
        self.discs[i].velocity = impact.velocity_a;
        self.discs[j].velocity = impact.velocity_b;
        let after = self.discs[i].kinetic_energy() + self.discs[j].kinetic_energy();
        self.touches.push(Touch {
            a: i,
            b: Some(j),
            time: self.now,
            normal: impact.normal,
            place: a.position + impact.normal * a.radius,
            approach: impact.approach_speed,
            before: [a.velocity, b.velocity],
            energy: after - energy,
            depth: depth(&a, &b),
            errors,
        });
    }

    fn together(&mut self, pairs: &[(usize, usize)], rules: &Rules) {
        let restitution = rules.restitution;
        let before = self.discs.clone();
        let resolved = resolve_in(&mut self.discs, pairs, restitution, self.now, rules.periodic);
        let place = |id| before.iter().position(|disc| disc.id == id);
        if resolved.contacts.is_empty() {
            self.settled.extend(pairs);
        }
        for contact in &resolved.contacts {
            let Partner::Disc(b) = contact.b else { continue };
            let (Some(i), Some(j)) = (place(contact.a), place(b)) else { continue };
            let errors = self.errors_of(i, j);
            self.widen(i, j, contact.approach_speed, restitution);
            self.touches.push(Touch {
                a: i,
                b: Some(j),
                time: self.now,
                normal: contact.normal,
                place: contact.point,
                approach: contact.approach_speed,
                before: [before[i].velocity, before[j].velocity],
                energy: -contact.energy_loss,
                depth: depth(&before[i], &rules.image(&before[i], &before[j])),
                errors,
            });
        }
    }

    /// The bound of the errors of two discs to each other.
    fn errors_of(&self, i: usize, j: usize) -> Sigma {
        let (a, b) = (self.errors[i], self.errors[j]);
        Sigma { position: a.position + b.position, velocity: a.velocity + b.velocity }
    }

    /// What the errors of two discs become by their contact.
    fn widen(&mut self, i: usize, j: usize, approach: f64, restitution: f64) {
        let (a, b) = (&self.discs[i], &self.discs[j]);
        let w = (b.velocity - a.velocity).length();
        let (ea, eb) = (self.errors[i], self.errors[j]);
        let place = ea.position + eb.position;
        let speed = ea.velocity + eb.velocity;
        let steep = (approach / w).max(1e-9);
        let turned = place / ((a.radius + b.radius) * steep);
        let jump = (1.0 + restitution) * ((w * turned).min(w) + speed);
        let late = place / approach.max(f64::MIN_POSITIVE);
        let shares = MassFractions::of(a.mass, b.mass);
        let change = (1.0 + restitution) * approach;
        for (k, share) in [(i, shares.a.hi), (j, shares.b.hi)] {
            self.errors[k].velocity += share * jump;
            self.errors[k].position += share * change * late;
        }
    }

    fn bounce(&mut self, i: usize, normal: DVec2, rules: &Rules) {
        let disc = self.discs[i];
        let restitution = rules.wall_restitution;
        let approach = disc.velocity.dot(normal);
        if approach <= 0.0 {
            return;
        }
        self.discs[i].velocity -= (1.0 + restitution) * approach * normal;
        self.errors[i].velocity *= 1.0 + restitution;
        self.errors[i].position += (1.0 + restitution) * rules.walls_sigma;
        self.touches.push(Touch {
            a: i,
            b: None,
            time: self.now,
            normal,
            place: disc.position + normal * disc.radius,
            approach,
            before: [disc.velocity, DVec2::ZERO],
            energy: self.discs[i].kinetic_energy() - disc.kinetic_energy(),
            depth: 0.0,
            errors: self.errors[i],
        });
    }
}

/// Overlap of two discs, m.
fn depth(a: &Disc, b: &Disc) -> f64 {
    (-gap(a, b)).max(0.0)
}

fn pair(next: Next) -> Option<(usize, usize)> {
    match next {
        Next::Pair(i, j) => Some((i, j)),
        Next::Wall(..) => None,
    }
}
