//! Who may push whom: the contacts of a set of discs within a step, their geometry and their
//! stiffest mode.
//!
//! It only looks; what a contact does is for the others to know.

use glam::DVec2;

use super::Laws;
use crate::detect::impact::{may_meet_within, pair_impact_at_any_scale};
use crate::detect::touching::{gap, touch};
use crate::detect::{self, TooManyPairs};
use crate::plan::BroadPhase;
use crate::resolve::overlap::normal;
use crate::world::{Disc, Side, Walls};

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Other {
    /// A disc, by its index.
    Disc(usize),
    /// A wall.
    Wall(Side),
}

/// Two bodies that touch, or may.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Link {
    /// Index of the first disc; the smaller one of a pair.
    pub a: usize,
    /// What it touches.
    pub b: Other,
}

/// All four walls.
const SIDES: [Side; 4] = [Side::Left, Side::Right, Side::Bottom, Side::Top];

impl Link {
    /// The overlap, m; negative = a gap.
    pub fn overlap(&self, discs: &[Disc], laws: &Laws) -> f64 {
        match self.b {
            Other::Disc(b) => -gap(&discs[self.a], &discs[b]),
            Other::Wall(side) => {
                laws.walls.map_or(f64::NEG_INFINITY, |walls| -walls.gap(side, &discs[self.a]))
            }
        }
    }

    /// Energy in the spring, J.
    pub fn stored(&self, discs: &[Disc], laws: &Laws) -> f64 {
        let overlap = self.overlap(discs, laws).max(0.0);
        0.5 * laws.stiffness * overlap * overlap
    }

    /// Unit normal away from the first disc.
    pub fn normal(&self, discs: &[Disc]) -> DVec2 {
        match self.b {
            Other::Disc(b) => normal(&discs[self.a], &discs[b]),
            Other::Wall(side) => side.normal(),
        }
    }

    /// Velocity of the first disc seen from the other, m/s.
    pub fn velocity(&self, discs: &[Disc]) -> DVec2 {
        let a = discs[self.a].velocity;
        if let Other::Disc(b) = self.b { a - discs[b].velocity } else { a }
    }

    /// `1 / m` of both sides, 1/kg.
    pub fn inverse_masses(&self, discs: &[Disc]) -> (f64, f64) {
        let b = if let Other::Disc(b) = self.b { 1.0 / discs[b].mass } else { 0.0 };
        (1.0 / discs[self.a].mass, b)
    }

    /// Whether anything can come of it.
    pub fn moves(&self, discs: &[Disc]) -> bool {
        let (a, b) = self.inverse_masses(discs);
        a + b > 0.0
    }
}

/// The contacts that exist now, and those to which straight flight leads within `h` (s).
///
/// # Errors
/// [`TooManyPairs`].
pub fn within(
    discs: &[Disc],
    walls: Option<&Walls>,
    h: f64,
    broad_phase: BroadPhase,
) -> Result<Vec<Link>, TooManyPairs> {
    let near = detect::touching_pairs(discs, 2.0 * fastest(discs) * h, broad_phase)?;
    Ok(among(discs, &near, walls, h, 1.0))
}

/// The largest speed, m/s.
pub fn fastest(discs: &[Disc]) -> f64 {
    discs.iter().map(|disc| disc.velocity.length()).fold(0.0, f64::max)
}

/// The same of these pairs only; with `sense` -1 those from which straight flight has led here.
pub fn among(
    discs: &[Disc],
    near: &[detect::Pair],
    walls: Option<&Walls>,
    h: f64,
    sense: f64,
) -> Vec<Link> {
    let meet = |&&(a, b): &&detect::Pair| {
        let (first, second) = (&discs[a], &discs[b]);
        let d = second.position - first.position;
        let w = sense * (second.velocity - first.velocity);
        let s = first.radius + second.radius;
        let usual = |square: f64| (1e-140..1e140).contains(&square);
        let (d2, w2) = (d.length_squared(), w.length_squared());
        if usual(d2) && usual(w2) && d2 > s * s * (1.0 + 1e-9) && !may_meet_within(d, w, s, h) {
            return false;
        }
        let impact = || pair_impact_at_any_scale(d, w, s);
        touch(first, second, 0.0) || (h > 0.0 && impact().is_some_and(|time| time < h))
    };
    let pair = |&(a, b): &detect::Pair| Link { a, b: Other::Disc(b) };
    let mut links: Vec<Link> = near.iter().filter(meet).map(pair).collect();
    for (a, disc) in discs.iter().enumerate() {
        let Some(walls) = walls else { break };
        let reach = disc.radius + h * disc.velocity.abs().max_element();
        if walls.contain(disc.position, reach * (1.0 + 1e-9)) {
            continue;
        }
        for side in SIDES {
            let (gap, out) = (walls.gap(side, disc), disc.velocity.dot(side.normal()));
            if gap < 0.0 || (out > 0.0 && gap <= out * h) {
                links.push(Link { a, b: Other::Wall(side) });
            }
        }
    }
    links.retain(|link| link.moves(discs));
    links
}

/// A bound of `omega^2` (1/s^2) of all modes of these contacts: Gershgorin's for `k N M^-1 N^T`,
/// exact for a pair, a chain and a disc on a wall, and never too low.
pub fn stiffest_mode(discs: &[Disc], links: &[Link], stiffness: f64) -> f64 {
    let normals: Vec<DVec2> = links.iter().map(|link| link.normal(discs)).collect();
    let mut of_disc: Vec<Vec<usize>> = vec![Vec::new(); discs.len()];
    for (k, link) in links.iter().enumerate() {
        of_disc[link.a].push(k);
        if let Other::Disc(b) = link.b {
            of_disc[b].push(k);
        }
    }
    let shared = |k: usize, disc: usize| -> f64 {
        let along = |l: &usize| normals[k].dot(normals[*l]).abs();
        of_disc[disc].iter().map(along).sum::<f64>() / discs[disc].mass
    };
    let row = |(k, link): (usize, &Link)| {
        let b = if let Other::Disc(b) = link.b { shared(k, b) } else { 0.0 };
        shared(k, link.a) + b
    };
    stiffness * links.iter().enumerate().map(row).fold(0.0, f64::max)
}
