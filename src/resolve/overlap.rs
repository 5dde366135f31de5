//! Overlap correction: parts discs that overlap, by moving them and nothing else.
//!
//! Steps of fixed length find contacts late, with an overlap. Each pair is parted along its line of
//! centres by at most its overlap, in the ratio of the inverse masses, so the centre of mass stays
//! and a fixed disc does too (split impulse, non-linear Gauss-Seidel: Catto, GDC 2006). A velocity
//! that does the same (Baumgarte) would add `mu (overlap / dt)^2 / 2` to the energy of each contact
//! and step.
//!
//! Never touch a velocity here: kinetic energy is the same to the last bit.

use glam::DVec2;

use super::pair::MassFractions;
use crate::detect::Pair;
use crate::detect::touching::gap;
use crate::exact::power_of_two_near;
use crate::world::{Disc, Periodic, Side, Walls};

/// Moves each of these pairs apart by its overlap, one after the other; returns how many moved. In
/// a periodic box discs may then be any of their images.
pub fn part_pairs(discs: &mut [Disc], pairs: &[Pair], periodic: Option<&Periodic>) -> usize {
    let moved = |&&(i, j): &&Pair| {
        let mut b = discs[j];
        if let Some(periodic) = periodic {
            b.position += periodic.shift(b.position - discs[i].position);
        }
        let Some((a, b)) = parted(&discs[i], &b) else { return false };
        (discs[i].position, discs[j].position) = (a, b);
        true
    };
    pairs.iter().filter(moved).count()
}

/// Moves a disc that reaches beyond a wall back to it; a fixed one stays.
pub fn part_from_walls(disc: &mut Disc, walls: &Walls) {
    if disc.mass.is_infinite() {
        return;
    }
    for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
        let beyond = -walls.gap(side, disc);
        if beyond > 0.0 {
            disc.position -= side.normal() * beyond;
        }
    }
}

/// The two places after parting, or `None` if the discs do not overlap or are both fixed.
fn parted(a: &Disc, b: &Disc) -> Option<(DVec2, DVec2)> {
    let overlap = -gap(a, b);
    if overlap <= 0.0 || (a.mass.is_infinite() && b.mass.is_infinite()) {
        return None;
    }
    let fractions = MassFractions::of(a.mass, b.mass);
    let normal = normal(a, b);
    Some((
        a.position - normal * (fractions.a.hi * overlap),
        b.position + normal * (fractions.b.hi * overlap),
    ))
}

/// Unit vector from a to b; coincident centres have none, the x axis serves as one.
pub fn normal(a: &Disc, b: &Disc) -> DVec2 {
    let d = b.position - a.position;
    let scaled = d / power_of_two_near(d.abs().max_element());
    if scaled == DVec2::ZERO { DVec2::X } else { scaled / scaled.length() }
}
