//! The law that a recording is held against: as told, or as its own first frames show it.
//!
//! What was not told is estimated: drag or gravity from what changes velocities where no contact
//! does, restitution from the contacts of two discs alone, walls from where discs turn round. A law
//! that two contacts or fewer would tell is unknown, and nothing is judged by it.

use glam::DVec2;
use serde::Serialize;

use super::noise::{STAMP_S, median};
use super::{Frame, Options};
use crate::world::{Disc, Periodic, Side, Walls};

/// Contacts from which a restitution is estimated, at least.
const CONTACTS_MIN: usize = 3;

/// Steps from which what a third of all velocities do is taken for the motion of all; of fewer it
/// must be what all of them do.
const STEPS_MIN: usize = 3;

/// How many times farther off than a third of all a velocity may be, and still tell the motion.
const TELLING: f64 = 4.0;

/// Part of the change of velocities that an estimated motion may leave unexplained.
const UNEXPLAINED: f64 = 0.2;

/// Where a number of the law comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// An option, or the scene in the recording.
    Told,
    /// The recording itself.
    Estimated,
    /// Nobody.
    Unknown,
}

/// What collisions and free motion must obey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Restitution of pairs.
    pub restitution: Option<f64>,
    /// Where it comes from.
    pub restitution_source: Source,
    /// The box around, if one is known; a side that nobody reached is far away.
    pub walls: Option<Walls>,
    /// Where it comes from.
    pub walls_source: Source,
    /// How far an estimated wall may be off, m.
    pub walls_sigma: f64,
    /// The box that repeats around, if it does: then there are no walls.
    pub periodic: Option<Periodic>,
    /// The same acceleration of all discs of finite mass, m/s^2.
    pub gravity: DVec2,
    /// The same linear drag of all discs, 1/s.
    pub drag: f64,
    /// Where gravity and drag come from.
    pub motion_source: Source,
    /// Acceleration that drives may add at any time, m/s^2.
    pub acceleration_max: f64,
    /// Time between two changes by drives, s.
    pub drive_tick: f64,
}

impl Law {
    /// What drives may add to a velocity within this time, s, at most, m/s.
    pub(super) fn driven(&self, length: f64) -> f64 {
        self.acceleration_max * (length + self.drive_tick)
    }

    /// What was told, nothing else.
    pub(super) fn told(options: &Options) -> Self {
        let source = |told: bool| if told { Source::Told } else { Source::Unknown };
        let motion = options.gravity.is_some() || options.drag.is_some();
        let around = options.walls.is_some() || options.periodic.is_some();
        let walls_are_told = around || options.no_walls;
        Self {
            restitution: options.restitution,
            restitution_source: source(options.restitution.is_some()),
            walls: options.walls.map(|told| Walls {
                min: told.min,
                max: told.max,
                restitution: told.restitution.or(options.restitution).unwrap_or(1.0),
            }),
            walls_source: source(walls_are_told),
            walls_sigma: 0.0,
            periodic: options.periodic.filter(|_| options.walls.is_none()),
            gravity: options.gravity.unwrap_or(DVec2::ZERO),
            drag: options.drag.unwrap_or(0.0),
            motion_source: source(motion),
            acceleration_max: options.acceleration_max.unwrap_or(0.0),
            drive_tick: options.drive_tick,
        }
    }

    /// Adds gravity or drag, if that explains what velocities do between contacts.
    pub(super) fn learn_motion(&mut self, frames: &[Frame]) {
        if self.motion_source == Source::Told {
            return;
        }
        let (mut x, mut y, mut drag, mut still) = (vec![], vec![], vec![], vec![]);
        for_each_step(frames, |before, after, seconds| {
            let change = after.velocity - before.velocity;
            x.push(change.x / seconds);
            y.push(change.y / seconds);
            still.push(change.length() / seconds);
            let speeds = before.velocity.length_squared() * after.velocity.length_squared();
            if speeds > 0.0 {
                let ratio = after.velocity.length_squared() / before.velocity.length_squared();
                drag.push(-0.5 * ratio.ln() / seconds);
            }
        });
        if still.len() < CONTACTS_MIN {
            return;
        }
        let gravity = DVec2::new(median(&mut x), median(&mut y));
        let drag = median(&mut drag).max(0.0);
        let left = lower_third(&mut still);
        let (mut falling, mut slowing) = (vec![], vec![]);
        for_each_step(frames, |before, after, seconds| {
            let change = after.velocity - before.velocity;
            falling.push((change / seconds - gravity).length());
            let slowed = before.velocity * libm::exp(-drag * seconds);
            slowing.push((after.velocity - slowed).length() / seconds);
        });
        let few = super::steps(frames).count() < STEPS_MIN;
        let off = |values: &mut Vec<f64>| {
            if few { values.iter().copied().fold(0.0, f64::max) } else { lower_third(values) }
        };
        let (falling, slowing) = (off(&mut falling), off(&mut slowing));
        if falling.min(slowing) > UNEXPLAINED * left || left == 0.0 {
            return;
        }
        self.motion_source = Source::Estimated;
        if falling < slowing {
            self.gravity = nearer_gravity(frames, gravity, falling);
        } else {
            self.drag = nearer_drag(frames, drag, slowing);
        }
    }

    /// Takes over what contacts of two discs alone showed: restitutions with their deviations.
    pub(super) fn learn_restitution(&mut self, seen: &mut [(f64, f64)]) {
        if self.restitution_source == Source::Told || seen.len() < CONTACTS_MIN {
            return;
        }
        self.restitution = Some(weighted_median(seen));
        self.restitution_source = Source::Estimated;
    }

    /// Takes over walls where discs turned round.
    pub(super) fn learn_walls(&mut self, turns: &[Turn]) {
        if self.walls_source == Source::Told {
            return;
        }
        let mut walls = Walls::FAR_AWAY;
        let (mut all, mut sigma): (Vec<f64>, f64) = (Vec::new(), 0.0);
        for side in [Side::Left, Side::Right, Side::Bottom, Side::Top] {
            let at = turns.iter().filter(|turn| turn.side == side);
            let mut places: Vec<f64> = at.clone().map(|turn| turn.place).collect();
            let place = median(&mut places);
            let tolerance = |turn: &&Turn| (turn.place - place).abs() <= turn.tolerance;
            let near: Vec<&Turn> = at.filter(tolerance).collect();
            if near.len() < CONTACTS_MIN || 10 * near.len() < 8 * places.len() {
                continue;
            }
            let mut off: Vec<f64> = near.iter().map(|turn| (turn.place - place).abs()).collect();
            sigma = sigma.max(1.5 * median(&mut off));
            all.extend(near.iter().map(|turn| turn.restitution));
            *bound(&mut walls, side) = place;
        }
        if !all.is_empty() {
            walls.restitution = median(&mut all);
            self.walls = Some(walls);
            self.walls_sigma = sigma;
            self.walls_source = Source::Estimated;
        }
    }
}

/// The coordinate of a wall.
fn bound(walls: &mut Walls, side: Side) -> &mut f64 {
    match side {
        Side::Left => &mut walls.min.x,
        Side::Right => &mut walls.max.x,
        Side::Bottom => &mut walls.min.y,
        Side::Top => &mut walls.max.y,
    }
}

/// A disc that turned round alone, as at a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turn {
    pub side: Side,
    /// Coordinate of the wall, m.
    pub place: f64,
    /// How far that may be off, m.
    pub tolerance: f64,
    pub restitution: f64,
}

fn for_each_step(frames: &[Frame], mut look: impl FnMut(&Disc, &Disc, f64)) {
    for (before, after, seconds) in super::steps(frames) {
        super::alike(before, after)
            .filter(|(before, _)| before.mass.is_finite())
            .for_each(|(before, after)| look(before, after, seconds));
    }
}

/// The gravity of all steps that this one explains, by least squares: each alone is off by what its
/// stamps were rounded by. `off`: what this one leaves unexplained of a third of all, m/s^2.
fn nearer_gravity(frames: &[Frame], gravity: DVec2, off: f64) -> DVec2 {
    let (mut sum, mut squares) = (DVec2::ZERO, 0.0);
    for_each_step(frames, |before, after, seconds| {
        let left = after.velocity - before.velocity - gravity * seconds;
        let rounding = 2.0 * STAMP_S * gravity.length();
        if left.length() <= TELLING * off * seconds + rounding {
            sum += left * seconds;
            squares += seconds * seconds;
        }
    });
    if squares > 0.0 { gravity + sum / squares } else { gravity }
}

/// The same of drag.
fn nearer_drag(frames: &[Frame], drag: f64, off: f64) -> f64 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for_each_step(frames, |before, after, seconds| {
        let slowed = before.velocity * libm::exp(-drag * seconds);
        let left = after.velocity - slowed;
        let rounding = 2.0 * STAMP_S * drag * slowed.length();
        if left.length() <= TELLING * off * seconds + rounding {
            sum -= left.dot(slowed) * seconds;
            squares += slowed.length_squared() * seconds * seconds;
        }
    });
    if squares > 0.0 { (drag + sum / squares).max(0.0) } else { drag }
}

fn lower_third(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    *values.select_nth_unstable_by(values.len() / 3, f64::total_cmp).1
}

/// The middle of values with deviations: each counts by the inverse of its variance.
fn weighted_median(values: &mut [(f64, f64)]) -> f64 {
    values.sort_by(|a, b| f64::total_cmp(&a.0, &b.0));
    let best = values.iter().map(|(_, sigma)| *sigma).fold(f64::INFINITY, f64::min);
    // None may outvote all others.
    let least = (10.0 * best).max(1e-9);
    let weight = |sigma: f64| sigma.max(least).powi(-2);
    let half = 0.5 * values.iter().map(|(_, sigma)| weight(*sigma)).sum::<f64>();
    let mut sum = 0.0;
    for &(value, sigma) in values.iter() {
        sum += weight(sigma);
        if sum >= half {
            return value;
        }
    }
    f64::NAN
}
