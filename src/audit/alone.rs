//! One disc that changed its velocity between two samples, and no other near: a wall or a segment
//! that it met, or nobody.
//!
//! A hit of a segment is judged where nothing else can have acted: by how the change is directed
//! and by the restitution that it shows. A disc that went through a segment is a violation too.
//!
//! Never judge what shares its time with a contact of two discs.

use glam::DVec2;

use super::findings::{Collision, Kind, Kinds, Met, Sight, Violation};
use super::flight::{Course, Flight};
use super::judge::{JUDGED, VAGUE};
use super::law::Source;
use super::surroundings::NEAR;
use super::verdict::{Court, Verdict};
use crate::world::{Disc, Segment, Side};

/// A hit of something that does not move.
struct Hit {
    at: Disc,
    /// Unit normal towards it.
    normal: DVec2,
    /// Distance of the surfaces, m.
    gap: f64,
    /// The restitution that it should show.
    law: f64,
}

impl Court<'_> {
    /// One disc: walls, a segment, or nobody.
    pub(super) fn single(&self, k: usize) -> Verdict {
        let flight = &self.flights[k];
        if self.law.walls.is_some()
            && let Some(sequel) = self.follow(&[k], None)
            && !sequel.touches.is_empty()
            && self.agrees(&sequel, &[k])
        {
            return Verdict::Collisions(self.foretold(&sequel, &[k]));
        }
        match flight.course {
            Course::Bent(instant) => match self.wall_hit(flight, instant) {
                Some(collision) => Verdict::Collisions(vec![collision]),
                None => self.segment_hit(k, instant).unwrap_or(Verdict::Alone(k)),
            },
            _ if flight.change.length() > JUDGED * flight.sigma.of_change() => Verdict::Alone(k),
            _ => Verdict::Displaced,
        }
    }

    /// A hit of a wall that is not as the law says, if it is one.
    fn wall_hit(&self, flight: &Flight, instant: f64) -> Option<Collision> {
        let walls = self.law.walls?;
        let at = Disc { position: self.place(flight, instant), ..flight.before };
        let inwards = flight.change;
        let side = [Side::Left, Side::Right, Side::Bottom, Side::Top]
            .into_iter()
            .find(|side| -inwards.dot(side.normal()) > 0.9 * inwards.length())?;
        let near = JUDGED * (flight.sigma.of_rest(self.span.length) + self.law.walls_sigma)
            + flight.before.velocity.length() * self.span.length;
        let gap = walls.gap(side, &at);
        if gap.abs() > near {
            return None;
        }
        let hit = Hit { at, normal: side.normal(), gap, law: walls.restitution };
        let mut collision = self.collision_of(flight, instant, &hit);
        let (_, sigma) = collision.restitution;
        let wrong = collision.wrong > (JUDGED * sigma).max(self.tolerance);
        if self.law.walls_source == Source::Told && wrong {
            collision.kinds.add(Kind::Energy);
        }
        Some(collision)
    }

    /// A hit of a segment, if it is one and nothing else can have acted.
    fn segment_hit(&self, k: usize, instant: f64) -> Option<Verdict> {
        let around = self.surroundings;
        let others_acted = || {
            around.others_may_have_acted(self.flights, k, self.span)
                || self.is_unbound_or_met_one(k)
        };
        if around.segments.is_empty() || others_acted() {
            return None;
        }
        let flight = &self.flights[k];
        let at = Disc { position: self.place(flight, instant), ..flight.before };
        let blur = JUDGED * flight.sigma.of_rest(self.span.length);
        let near = at.radius + NEAR * at.radius + blur;
        let points = around.segments.iter().map(|segment| segment.nearest(at.position));
        let mut touched = points.filter(|point| point.distance(at.position) <= near);
        let point = touched.next()?;
        // Between two of them both may have given of it.
        if touched.any(|other| other.distance(point) > NEAR * at.radius) {
            return None;
        }
        let (normal, distance) =
            ((point - at.position).try_normalize()?, point.distance(at.position));
        let law = around.segment_restitution;
        let hit = Hit { at, normal, gap: distance - at.radius, law };
        let mut collision = self.collision_of(flight, instant, &hit);
        let (_, sigma) = collision.restitution;
        if collision.approach <= 0.0 || sigma > VAGUE {
            return None;
        }
        if collision.wrong > (JUDGED * sigma).max(self.tolerance) {
            collision.kinds.add(Kind::Energy);
        }
        // At an end the normal is as unsure as the place.
        let is_end = |segment: &Segment| [segment.from, segment.to].contains(&point);
        let turned = if around.segments.iter().any(is_end) { blur / at.radius } else { 0.0 };
        let sigma = flight.sigma.of_change() / flight.change.length();
        let allowed = JUDGED * sigma + turned;
        if collision.angle.0.abs() > allowed.max(self.tolerance) {
            collision.kinds.add(Kind::Normal);
        }
        Some(Verdict::AtSegment(collision))
    }

    /// What a hit shows, without a judgement.
    fn collision_of(&self, flight: &Flight, instant: f64, hit: &Hit) -> Collision {
        let Hit { at, normal, gap, law } = *hit;
        let (before, after) = (flight.before.velocity, flight.after.velocity);
        let approach = before.dot(normal);
        let restitution = -after.dot(normal) / approach;
        let sigma = flight.sigma.of_change() / approach.abs();
        let mass = flight.before.mass;
        Collision {
            time: self.time + self.span.seconds_at(instant, self.law.drag),
            a: at.id,
            b: Met::Wall,
            place: at.position + normal * at.radius,
            normal,
            before: [before, DVec2::ZERO],
            approach,
            gap,
            momentum: 0.0,
            energy: flight.after.kinetic_energy() - flight.before.kinetic_energy(),
            energy_law: 0.5 * mass * (law * law - 1.0) * approach * approach,
            restitution: (restitution, sigma),
            angle: (normal.perp_dot(flight.change).atan2(-normal.dot(flight.change)), sigma),
            wrong: (restitution - law).abs(),
            smaller_radius: at.radius,
            window: self.span.seconds,
            sight: Sight::Alone,
            kinds: Kinds::default(),
        }
    }

    /// The violation of a disc that went through a segment, far from its ends.
    pub(super) fn through_a_segment(&self, flight: &Flight) -> Option<Violation> {
        let (from, to) = (flight.before.position, flight.after.position);
        let is_unbound =
            self.unbound.iter().any(|&k| self.flights[k].before.id == flight.before.id);
        // Of any other course nobody knows the way.
        let turn = match flight.course {
            Course::Quiet => to,
            Course::Bent(instant) if !is_unbound => self.place(flight, instant),
            Course::Bent(_) | Course::Tangled | Course::Jumped => return None,
        };
        let crossed = |segment: &&Segment| {
            let legs = [(from, turn), (turn, to)];
            legs.iter().any(|&(from, to)| crossing(segment, from, to, flight.before.radius))
        };
        let segment = self.surroundings.segments.iter().find(crossed)?;
        let normal = (segment.to - segment.from).perp().normalize();
        Some(Violation {
            kind: Kind::Tunnelling,
            also: Vec::new(),
            time_s: self.time,
            discs: vec![flight.before.id],
            wall: true,
            place_m: segment.nearest(from).to_array(),
            approach_speed_mps: flight.before.velocity.dot(normal).abs(),
            severity: 1.0,
            detail: "a segment of the boundary lies between two samples".to_owned(),
        })
    }
}

/// Whether a way leads across a segment, farther than `margin` from its ends.
fn crossing(segment: &Segment, from: DVec2, to: DVec2, margin: f64) -> bool {
    let along = (segment.to - segment.from).normalize();
    let [start, end] = [from, to].map(|place| along.perp_dot(place - segment.from));
    if (start > 0.0) == (end > 0.0) || start == end {
        return false;
    }
    let place = from.lerp(to, start / (start - end));
    let at = along.dot(place - segment.from);
    at > margin && at < (segment.to - segment.from).length() - margin
}
