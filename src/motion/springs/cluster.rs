//! Springs that share discs, over one step: implicit, so stable at any stiffness and any step.
//!
//! The elastic force of a step is the difference of the spring's energy over the difference of its
//! overlap (a discrete gradient: Gonzalez, doi:10.1007/BF02440162). So what the springs take from
//! the motion is what they store, also
//! where a contact begins or ends within the step, and energy can
//! not grow. While a contact lasts this is the implicit midpoint rule. Normals are those half
//! a step on. The impulses are found by Gauss-Seidel sweeps: each contact's equation has one
//! root, and momentum is kept by every sweep. Sweeps are bounded: beyond `h omega` of about 5 they
//! end before the last digits, and only backward Euler, which damps, stays harmless.
//!
//! Never choose a step here: how fine is for the caller to know.

use glam::DVec2;

use super::Laws;
use super::links::{Link, Other};
use super::oscillator::Ending;
use crate::exact::UNIT_ROUNDOFF;
use crate::world::{Disc, limits};

/// An implicit rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Implicit {
    /// Keeps the energy; second order.
    Midpoint,
    /// Damps what it cannot resolve; first order.
    BackwardEuler,
}

/// A contact in the equations of a step.
struct Equation {
    link: Link,
    normal: DVec2,
    inverse_masses: (f64, f64),
    /// Overlap at the start, m.
    overlap: f64,
    /// N s.
    impulse: f64,
}

/// Moves the discs by `h` (s); returns the impulse of each link, N s, and along which normal.
pub fn step(
    discs: &mut [Disc],
    links: &[Link],
    laws: &Laws,
    h: f64,
    rule: Implicit,
) -> Vec<(f64, DVec2)> {
    let theta = if rule == Implicit::Midpoint { 0.5 } else { 1.0 };
    // Normals half a step on, or energy would leak as the line of centres turns.
    let ahead = if rule == Implicit::Midpoint { 0.5 * h } else { 0.0 };
    let halfway: Vec<Disc> = discs
        .iter()
        .map(|disc| Disc { position: disc.position + ahead * disc.velocity, ..*disc })
        .collect();
    let mut equations: Vec<Equation> = links
        .iter()
        .map(|&link| Equation {
            link,
            normal: link.normal(&halfway),
            inverse_masses: link.inverse_masses(discs),
            overlap: link.overlap(discs, laws),
            impulse: 0.0,
        })
        .collect();
    let mut changes = vec![DVec2::ZERO; discs.len()];
    for _ in 0..limits::SPRING_SWEEPS {
        let mut largest: f64 = 0.0;
        for equation in &mut equations {
            largest = largest.max(equation.relax(discs, &mut changes, laws, h, rule));
        }
        if largest <= 4.0 * UNIT_ROUNDOFF {
            break;
        }
    }
    for (disc, change) in discs.iter_mut().zip(changes) {
        disc.position += h * (disc.velocity + theta * change);
        disc.velocity += change;
    }
    equations.iter().map(|equation| (equation.impulse, equation.normal)).collect()
}

impl Equation {
    /// Solves this contact with the others as they are; returns by what part its speed changed.
    fn relax(
        &mut self,
        discs: &[Disc],
        changes: &mut [DVec2],
        laws: &Laws,
        h: f64,
        rule: Implicit,
    ) -> f64 {
        let theta = if rule == Implicit::Midpoint { 0.5 } else { 1.0 };
        let inverse_mass = self.inverse_masses.0 + self.inverse_masses.1;
        let a = self.link.a;
        let mut velocity = discs[a].velocity + theta * changes[a];
        if let Other::Disc(b) = self.link.b {
            velocity -= discs[b].velocity + theta * changes[b];
        }
        // The speed of approach if this contact did not push.
        let free = velocity.dot(self.normal) + theta * inverse_mass * self.impulse;
        let c = h * h * theta * inverse_mass;
        let end = root(self.overlap, self.overlap + h * free, c, laws, h, rule);
        // From the force, or where it is stiff from the motion: either way no digits are lost.
        let impulse = if c * laws.stiffness < 1.0 || end <= 0.0 {
            h * force(self.overlap, end, laws, h, rule)
        } else {
            (free - (end - self.overlap) / h) / (theta * inverse_mass)
        };
        let change = impulse - self.impulse;
        self.impulse = impulse;
        changes[a] -= self.normal * (change * self.inverse_masses.0);
        if let Other::Disc(b) = self.link.b {
            changes[b] += self.normal * (change * self.inverse_masses.1);
        }
        let noise = free.abs() + self.overlap.abs() / h;
        if change == 0.0 { 0.0 } else { (change * inverse_mass).abs() / noise }
    }
}

/// Mean force of a step from one overlap to another, N: it never falls as `end` grows.
fn force(start: f64, end: f64, laws: &Laws, h: f64, rule: Implicit) -> f64 {
    let (p, q) = (start.max(0.0), end.max(0.0));
    let elastic = match rule {
        Implicit::BackwardEuler => q,
        // The mean of the overlaps while both are there, else less: what the energy asks for.
        Implicit::Midpoint if start >= 0.0 && end >= 0.0 => 0.5 * (p + q),
        Implicit::Midpoint if start == end => 0.0,
        Implicit::Midpoint => 0.5 * (p + q) * ((q - p) / (end - start)),
    };
    let force = laws.stiffness * elastic + laws.damping * ((q - p) / h);
    if laws.ending == Ending::NoAttraction { force.max(0.0) } else { force }
}

/// The end overlap `x` of `x + c force(x) = free`: the left side grows, so there is one.
fn root(start: f64, free: f64, c: f64, laws: &Laws, h: f64, rule: Implicit) -> f64 {
    if start <= 0.0 && free <= 0.0 {
        return free;
    }
    // The usual case is linear: in contact from start to end.
    let theta = if rule == Implicit::Midpoint { 0.5 } else { 1.0 };
    let slope = laws.stiffness * theta + laws.damping / h;
    let rest = (laws.stiffness * (1.0 - theta) - laws.damping / h) * start;
    let x = (free - c * rest) / (1.0 + c * slope);
    let pulls = laws.ending == Ending::NoAttraction && rest + slope * x < 0.0;
    if start >= 0.0 && x >= 0.0 && !pulls {
        return x;
    }
    let value = |x: f64| x + c * force(start, x, laws, h, rule) - free;
    let far = free - value(free);
    bracketed((far.min(free), far.max(free)), value)
}

/// The zero of a growing function: false position, with bisection every third time.
fn bracketed((mut low, mut high): (f64, f64), value: impl Fn(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (value(low), value(high));
    for k in 0..limits::ROOT_STEPS {
        if at_low >= 0.0 || at_high <= 0.0 {
            break;
        }
        let middle = 0.5 * (low + high);
        let guess = low + (high - low) * (-at_low / (at_high - at_low));
        let x = if k % 3 == 2 { middle } else { guess };
        if !(x > low && x < high) {
            break;
        }
        let at = value(x);
        if at < 0.0 {
            (low, at_low) = (x, at);
        } else {
            (high, at_high) = (x, at);
        }
    }
    if -at_low < at_high { low } else { high }
}
