//! The law for two discs in each of the forms that are compared: carom's own, and plain ones that
//! others use, which stand here for nothing but the comparison.

use glam::DVec2;

use crate::exact::{DoubleDouble, DoubleDoubleVec, sum_of_products};
use crate::resolve::pair::{self, MassFractions};
use crate::resolve::{precise, vector_method};
use crate::world::Disc;

/// Velocities after the contact of two discs; `None` = they do not approach.
pub type Law = fn(&Disc, &Disc, f64) -> Option<(DVec2, DVec2)>;

/// One form.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Its name in legends.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// The form.
    pub law: Law,
    /// Whether its errors must stay within the bound for all pairs.
    pub is_bounded: bool,
    /// Whether it is meant for sizes whose squares leave the range of doubles.
    pub at_any_scale: bool,
}

/// All of them, the plainest first.
pub const ALL: [Variant; 5] = [
    Variant {
        name: "seven steps",
        what: "the vector method as it is taught",
        law: seven_steps,
        is_bounded: false,
        at_any_scale: false,
    },
    Variant {
        name: "reduced mass",
        what: "an impulse along the unit normal, mass fractions rounded once",
        law: reduced_mass,
        is_bounded: false,
        at_any_scale: false,
    },
    Variant {
        name: "carom",
        what: "the answer to circle states: mass fractions as hi + lo, signs decided exactly",
        law: carom,
        is_bounded: true,
        at_any_scale: true,
    },
    Variant {
        name: "carom, events",
        what: "the same in the method events: no unit normal, so no root",
        law: events,
        is_bounded: true,
        at_any_scale: false,
    },
    Variant {
        name: "carom, plain",
        what: "the same in the method plain: double-double",
        law: double_double,
        is_bounded: true,
        at_any_scale: false,
    },
];

fn seven_steps(a: &Disc, b: &Disc, restitution: f64) -> Option<(DVec2, DVec2)> {
    approach(a, b).then(|| vector_method::collide(a, b, restitution))
}

fn approach(a: &Disc, b: &Disc) -> bool {
    (b.position - a.position).dot(b.velocity - a.velocity) < 0.0
}

fn reduced_mass(a: &Disc, b: &Disc, restitution: f64) -> Option<(DVec2, DVec2)> {
    let d = b.position - a.position;
    let n = d / d.length();
    let along = (b.velocity - a.velocity).dot(n);
    let total = a.mass + b.mass;
    let jump = (1.0 + restitution) * along;
    (along < 0.0)
        .then(|| (a.velocity + b.mass / total * jump * n, b.velocity - a.mass / total * jump * n))
}

fn carom(a: &Disc, b: &Disc, restitution: f64) -> Option<(DVec2, DVec2)> {
    pair::collide(a, b, restitution).map(|impact| (impact.velocity_a, impact.velocity_b))
}

fn events(a: &Disc, b: &Disc, restitution: f64) -> Option<(DVec2, DVec2)> {
    let share = MassFractions::of(a.mass, b.mass);
    let d = b.position - a.position;
    let w = b.velocity - a.velocity;
    // Decided when the contact was foreseen, as in `detect::impact`.
    if sum_of_products(d.x, w.x, d.y, w.y) >= 0.0 {
        return None;
    }
    let after = pair::exchange(d, (a.velocity, b.velocity), restitution, &share, true);
    Some((a.velocity + after.by_a, b.velocity + after.by_b))
}

fn double_double(a: &Disc, b: &Disc, restitution: f64) -> Option<(DVec2, DVec2)> {
    let difference = |b: DVec2, a: DVec2| DoubleDoubleVec {
        x: DoubleDouble::sum(b.x, -a.x),
        y: DoubleDouble::sum(b.y, -a.y),
    };
    let d = difference(b.position, a.position);
    let closing = d.dot(difference(b.velocity, a.velocity));
    precise::collide((a, b), &d, closing, restitution)
        .map(|kicks| (kicks.impact.velocity_a, kicks.impact.velocity_b))
}
