//! What else of a scene may change a velocity: segments, kickers, drives.
//!
//! No heading is recorded and nobody says when a robot kicks: what happened at a robot that can
//! kick, and is not as the law says of discs alone, is counted and not judged. So is what happened
//! to several discs beside a segment; one alone there is judged.
//! What drives and the ground may add at any time is a bound of every change. A commanded puck
//! whose drive has no such bound takes any velocity at once: what happened to it, or to a disc that
//! it may have met, and is not as the law says, is counted and not judged either. So is what
//! happened to a disc while it met somebody who is in no sample.
//!
//! Never call anything lawful or a violation here.

use super::Options;
use super::flight::{Flight, Span};
use super::verdict::Court;
use crate::scene::Scene;
use crate::world::{DiscId, Drive, Segment};

/// Part of its radius by which a disc may be off a segment that it met.
pub(super) const NEAR: f64 = 0.05;

/// What stamps are rounded by, and a little more, s.
const STAMP: f64 = 2e-9;

/// What acts beside the discs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    /// Segments that discs bounce off.
    pub segments: Vec<Segment>,
    /// With this restitution.
    pub segment_restitution: f64,
    /// Discs that can be kicked.
    pub balls: Vec<DiscId>,
    /// Discs that kick, each with the largest gap, m, over which it does.
    pub kickers: Vec<(DiscId, f64)>,
    /// Discs that somebody commands, and that take any velocity at once.
    pub commanded: Vec<DiscId>,
    /// Contacts of which one disc may be in no sample, in the order of time.
    pub meetings: Vec<Meeting>,
}

/// Two discs met, as somebody says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// When, s of the recording's clock.
    pub time: f64,
    /// Who.
    pub discs: [DiscId; 2],
}

impl Options {
    /// Takes over from a scene what was not told: what drives and the ground may add, and what acts
    /// beside the discs. The law of collisions is not touched.
    pub fn take_surroundings(&mut self, scene: &Scene) {
        let pucks = || scene.pucks.iter();
        // Not the dribbler's: it has only balls at its mouth, where nothing else is judged either.
        let of_drive = |drive: &Drive| [Some(drive.acceleration_max), drive.braking_max];
        let drives = pucks().filter(|puck| puck.driven).flat_map(|puck| of_drive(&puck.drive));
        let of_balls = pucks().filter_map(|puck| puck.ball);
        let ground = of_balls.flat_map(|ball| [Some(ball.sliding), Some(ball.rolling)]);
        let finite = drives.chain(ground).flatten().filter(|most| most.is_finite());
        let most = finite.fold(0.0, f64::max);
        self.acceleration_max = self.acceleration_max.or(Some(most));
        self.drive_tick = scene.settings.pace.tick;
        let kicker = |drive: &Drive| drive.kicker.map(|kicker| kicker.reach);
        self.surroundings = Surroundings {
            segments: scene.settings.segments.map_or(vec![], |all| all.all().to_vec()),
            segment_restitution: scene.settings.segments.map_or(1.0, |all| all.restitution),
            balls: pucks().filter(|puck| puck.ball.is_some()).map(|puck| puck.disc.id).collect(),
            kickers: pucks().filter_map(|p| Some((p.disc.id, kicker(&p.drive)?))).collect(),
            // Who commands and who else is there is not known to the scene.
            commanded: Vec::new(),
            meetings: Vec::new(),
        };
    }
}

impl Surroundings {
    /// The flights of discs to which anything may have happened between samples at these times.
    pub(super) fn unbound(&self, all: &[Flight], (from, to): (f64, f64)) -> Vec<usize> {
        let first = self.meetings.partition_point(|each| each.time < from - STAMP);
        let meetings = self.meetings[first..].iter().take_while(|each| each.time <= to + STAMP);
        let pairs: Vec<[DiscId; 2]> = meetings.map(|each| each.discs).collect();
        if self.commanded.is_empty() && pairs.is_empty() {
            return Vec::new();
        }
        let is_sampled = |id: DiscId| all.iter().any(|flight| flight.before.id == id);
        let met = |id: DiscId| {
            pairs.iter().any(|&[a, b]| a == id && !is_sampled(b) || b == id && !is_sampled(a))
        };
        let is_unbound = |id: DiscId| self.commanded.contains(&id) || met(id);
        (0..all.len()).filter(|&k| is_unbound(all[k].before.id)).collect()
    }

    /// Whether any of it may have changed a velocity of this group between the two samples.
    pub(super) fn may_have_acted(&self, all: &[Flight], group: &[usize], span: &Span) -> bool {
        let fastest = group.iter().map(|&k| speed(&all[k])).fold(0.0, f64::max);
        let way = fastest * span.length;
        let at_segment = |flight: &Flight| {
            let near = (1.0 + NEAR) * flight.before.radius + way;
            let at = flight.before.position;
            self.segments.iter().any(|segment| segment.distance(at) <= near)
        };
        // A ball that two robots press at rests, and changes both.
        let pressed = |flight: &Flight| all.iter().any(|ball| self.may_kick(flight, ball, span));
        group.iter().map(|&k| &all[k]).any(|flight| {
            at_segment(flight) || pressed(flight) || self.is_in_a_mouth(all, flight, span)
        })
    }

    /// Whether another disc, or a kicker, may have changed the velocity of this one.
    pub(super) fn others_may_have_acted(&self, all: &[Flight], k: usize, span: &Span) -> bool {
        let own = &all[k];
        let near = |other: &Flight| {
            let way = (speed(own) + speed(other)) * span.length;
            let reach = (1.0 + NEAR) * (own.before.radius + other.before.radius) + way;
            own.before.position.distance(other.before.position) <= reach
        };
        let others = all.iter().filter(|other| other.before.id != own.before.id);
        others.into_iter().any(near) || self.is_in_a_mouth(all, own, span)
    }

    /// Whether a ball was so near a robot that this may have kicked it, whatever its heading.
    fn is_in_a_mouth(&self, all: &[Flight], ball: &Flight, span: &Span) -> bool {
        all.iter().any(|robot| self.may_kick(robot, ball, span))
    }

    /// Whether a robot kicks, and a ball is so near it.
    fn may_kick(&self, robot: &Flight, ball: &Flight, span: &Span) -> bool {
        if !self.balls.contains(&ball.before.id) {
            return false;
        }
        let mut kickers = self.kickers.iter();
        let Some((_, reach)) = kickers.find(|(own, _)| *own == robot.before.id) else {
            return false;
        };
        let touching = robot.before.radius + ball.before.radius;
        let nearest = touching + reach + (speed(robot) + speed(ball)) * span.length;
        robot.before.position.distance(ball.before.position) <= nearest
    }
}

impl Court<'_> {
    /// Whether anything may have happened to this disc, or to one that it may have met.
    pub(super) fn is_unbound_or_met_one(&self, k: usize) -> bool {
        let own = &self.flights[k];
        let way = |flight: &Flight| {
            let moved = flight.after.position - flight.before.position;
            moved.length().max(speed(flight) * self.span.length)
        };
        let near = |other: &Flight| {
            let touching = (1.0 + NEAR) * (own.before.radius + other.before.radius);
            self.law.apart(own, other).length() <= touching + way(own) + way(other)
        };
        self.unbound.iter().any(|&other| other == k || near(&self.flights[other]))
    }
}

/// The larger of the speeds at both samples, m/s.
fn speed(flight: &Flight) -> f64 {
    flight.before.velocity.length().max(flight.after.velocity.length())
}
