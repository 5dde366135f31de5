//! What may come into an arena while it runs: sound discs, within the walls, that overlap nobody.
//!
//! One place for all methods, so that all refuse the same. It only looks.

use glam::DVec2;

use super::plain::Laws;
use crate::detect::touching::overlap;
use crate::world::{Disc, NotDone, Periodic, Walls, limits};

/// Whether a disc by itself may come, or stand where it is: numbers in range, within the walls.
///
/// # Errors
/// The first thing that is wrong.
pub fn may_stand(disc: &Disc, walls: Option<&Walls>) -> Result<(), NotDone> {
    if let Some(defect) = disc.refusal() {
        return Err(NotDone::Defect(defect));
    }
    let is_outside = |walls: &&Walls| !walls.contain(disc.position, disc.radius);
    if walls.is_some_and(|walls| is_outside(&walls)) { Err(NotDone::OutsideWalls) } else { Ok(()) }
}

/// The same under laws that may have segments.
///
/// # Errors
/// As [`may_stand`].
pub fn may_stand_among(disc: &Disc, laws: &Laws) -> Result<(), NotDone> {
    let walls = laws.walls.as_ref();
    may_stand(disc, walls)?;
    let is_in_one = laws.segments.as_ref().is_some_and(|segments| segments.refuse(disc, walls));
    if is_in_one { Err(NotDone::OutsideWalls) } else { Ok(()) }
}

/// Whether a disc is so small that it can touch every other in one image of a periodic box only.
///
/// # Errors
/// If it is not.
pub fn fits_box(disc: &Disc, periodic: Option<Periodic>) -> Result<(), NotDone> {
    let side = periodic.map(|periodic| periodic.size().min_element());
    let is_wide = side.is_some_and(|side| disc.radius > limits::RADIUS_IN_PERIODIC_BOX * side);
    if is_wide { Err(NotDone::TooWide) } else { Ok(()) }
}

/// Whether a disc overlaps none of these; touching is allowed.
///
/// # Errors
/// The smallest id of those that it overlaps.
pub fn is_clear(
    disc: &Disc,
    others: impl IntoIterator<Item = Disc>,
    periodic: Option<Periodic>,
) -> Result<(), NotDone> {
    let overlaps = |other: &Disc| {
        let shift = |periodic: Periodic| periodic.shift(other.position - disc.position);
        let position = other.position + periodic.map_or(DVec2::ZERO, shift);
        overlap(disc, &Disc { position, ..*other })
    };
    let first = others.into_iter().filter(overlaps).map(|other| other.id).min();
    first.map_or(Ok(()), |id| Err(NotDone::Overlaps(id)))
}

/// The walls of an arena moved to these corners, m; `widest`: the largest radius within, m.
///
/// # Errors
/// If there are none, or there is no room.
pub fn moved(
    from: Option<Walls>,
    (min, max): (DVec2, DVec2),
    widest: f64,
) -> Result<Walls, NotDone> {
    let size = max - min;
    // Each by itself: of two numbers the larger is never the one that is none.
    let is_near = |corner: DVec2| corner.abs().cmple(DVec2::splat(limits::SIZE_MAX)).all();
    let is_box = is_near(min) && is_near(max);
    let has_room = is_box && size.min_element() >= 2.0 * widest && size.min_element() > 0.0;
    let from = from.filter(|walls| *walls != Walls::FAR_AWAY).ok_or(NotDone::NoWalls)?;
    if has_room { Ok(Walls { min, max, ..from }) } else { Err(NotDone::NoRoom) }
}
