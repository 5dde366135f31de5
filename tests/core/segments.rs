//! Line segments: times, faces and ends, energy, corners, and both methods against each other.

use carom::detect::segment::Edge;
use carom::motion::plain::{Laws, Plain};
use carom::motion::ticks::Ticks;
use carom::plan::parts::Part;
use carom::plan::{Method, Plan};
use carom::world::{
    BadSegment, Command, Contact, Disc, Instants, NotDone, Owner, Partner, Segment, Segments,
    Settings, Walls, World,
};
use glam::DVec2;

use crate::common::{Random, disc};

pub fn closed(points: &[[f64; 2]]) -> Vec<Segment> {
    let points: Vec<DVec2> = points.iter().map(|point| DVec2::from_array(*point)).collect();
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(from, to)| Segment { from: *from, to: *to }).collect()
}

/// A room of 4 m by 3 m with cut corners, pockets for goals, and a bar in it.
pub fn field() -> Vec<Segment> {
    let mut all = closed(&[
        [-1.9, -1.5],
        [1.9, -1.5],
        [2.0, -1.4],
        [2.0, -0.4],
        [2.3, -0.4],
        [2.3, 0.4],
        [2.0, 0.4],
        [2.0, 1.4],
        [1.9, 1.5],
        [-1.9, 1.5],
        [-2.0, 1.4],
        [-2.0, 0.4],
        [-2.3, 0.4],
        [-2.3, -0.4],
        [-2.0, -0.4],
        [-2.0, -1.4],
    ]);
    all.push(Segment { from: DVec2::new(-0.3, 0.55), to: DVec2::new(0.37, 0.81) });
    all
}

pub fn laws(segments: &[Segment], restitution: f64) -> Laws {
    let segments = Some(Segments::new(segments, restitution).expect("segments"));
    Laws { segments, restitution, ..Laws::FREE }
}

/// Discs inside of the field.
pub fn crowd(random: &mut Random, count: u32, speed: f64) -> Vec<Disc> {
    let segments = Segments::new(&field(), 1.0).expect("segments");
    let mut discs: Vec<Disc> = Vec::new();
    while discs.len() < count as usize {
        let (at, velocity) = (random.vector(2.0), random.vector(speed));
        let (radius, mass) = (random.uniform(0.02, 0.12), random.uniform(0.1, 3.0));
        let id = discs.len() as u32;
        let new = disc(id, at.to_array(), velocity.to_array(), radius, mass);
        let clear = |other: &Disc| other.position.distance(at) > other.radius + radius;
        // The bar is no closed line, so the room is asked without it.
        let room = Segments::new(&field()[..16], 1.0).expect("segments");
        let is_free = segments.contain(at, radius, false) && room.contain(at, radius, false);
        if is_free && discs.iter().all(clear) {
            discs.push(new);
        }
    }
    discs
}

fn advance_plain(plain: &mut Plain, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while plain.now() < until {
        plain.advance(until, &mut contacts).expect("goes on");
    }
    contacts
}

fn advance_ticks(ticks: &mut Ticks, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while ticks.now() < until {
        ticks.advance(until, &mut contacts).expect("goes on");
    }
    contacts
}

pub fn is_in_room(position: DVec2, radius: f64) -> bool {
    let room = Segments::new(&field()[..16], 1.0).expect("segments");
    room.contain(position, radius * (1.0 - 1e-6), false)
}

#[test]
fn ticks_have_the_contacts_of_the_plain_method() {
    let (mut faces, mut ends, mut pairs) = (0, 0, 0);
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let restitution = if seed % 2 == 0 { 1.0 } else { 0.8 };
        let laws = laws(&field(), restitution);
        let discs = crowd(&mut random, 7, 2.0);
        let mut plain = Plain::new(laws, &discs, 0.01);
        let mut ticks = Ticks::new(laws, &discs, 1e-3).expect("suits");
        let (judged, ours) = (advance_plain(&mut plain, 0.8), advance_ticks(&mut ticks, 0.8));
        assert_eq!(ours.len(), judged.len(), "seed {seed}");
        for (k, (our, judge)) in ours.iter().zip(&judged).enumerate() {
            assert_eq!((our.a, our.b), (judge.a, judge.b), "seed {seed}, contact {k}");
            assert!((our.time - judge.time).abs() < 1e-9, "seed {seed}: {our:?} {judge:?}");
            assert!((our.approach_speed - judge.approach_speed).abs() < 1e-8);
            assert!((our.normal - judge.normal).length() < 1e-7 && our.gap.abs() < 1e-12);
            let Partner::Segment(place) = our.b else {
                pairs += 1;
                continue;
            };
            let Segment { from, to } = field()[place as usize];
            let is_end = our.point.distance(from).min(our.point.distance(to)) < 1e-9;
            if is_end { ends += 1 } else { faces += 1 }
        }
        for disc in ticks.discs(Owner::Simulated) {
            assert!(is_in_room(disc.position, disc.radius), "seed {seed}: {disc:?}");
        }
    }
    assert!(faces > 500 && ends > 25 && pairs > 150, "{faces} faces, {ends} ends, {pairs} pairs");
}

#[test]
fn energy_stays_and_every_contact_obeys_the_law() {
    let mut random = Random::new(77);
    let discs = crowd(&mut random, 12, 2.0);
    for method in [Method::Plain, Method::Ticks] {
        let laws = laws(&field(), 1.0);
        let (drift, contacts) = match method {
            Method::Plain => {
                let mut plain = Plain::new(laws, &discs, 0.01);
                let contacts = advance_plain(&mut plain, 20.0);
                (plain.relative_energy_drift(), contacts)
            }
            _ => {
                let mut ticks = Ticks::new(laws, &discs, 1.0 / 60.0).expect("suits");
                let contacts = advance_ticks(&mut ticks, 20.0);
                (ticks.relative_energy_drift(), contacts)
            }
        };
        assert!(drift.abs() < 1e-14, "{method}: {drift}");
        assert!(contacts.len() > 300, "{}", contacts.len());
        for contact in contacts {
            let Partner::Segment(place) = contact.b else { continue };
            let disc = discs.iter().find(|disc| disc.id == contact.a).expect("a disc");
            let centre = contact.point - contact.normal * disc.radius;
            let nearest = field()[place as usize].nearest(centre);
            let off = (nearest - centre).normalize() - contact.normal;
            assert!(off.length() < 1e-9, "{contact:?}: the normal points at what is nearest");
            assert!((nearest.distance(centre) - disc.radius).abs() < 1e-12, "{contact:?}");
        }
    }
}

#[test]
fn no_disc_leaves_through_a_corner_or_past_an_end() {
    for (seed, speed) in [(1, 1e3), (2, 1e5), (3, 1e7), (4, 2.0)] {
        let mut random = Random::new(seed);
        let mut discs = crowd(&mut random, 5, 1.0);
        // Straight into what could leak: corners, joints, ends.
        for (disc, segment) in discs.iter_mut().zip(field().iter().step_by(3)) {
            disc.velocity = (segment.from - disc.position).normalize() * speed;
        }
        let laws = laws(&field(), 1.0);
        let mut ticks = Ticks::new(laws, &discs, 1e-3).expect("suits");
        let mut contacts = Vec::new();
        let until = 4_000.0 / speed;
        for k in 1..=100u32 {
            let until = until * f64::from(k) / 100.0;
            while ticks.now() < until && contacts.len() < 40_000 {
                ticks.advance(until, &mut contacts).expect("goes on");
            }
            for disc in ticks.discs(Owner::Simulated) {
                assert!(is_in_room(disc.position, disc.radius), "at {speed} m/s: {disc:?}");
            }
        }
        assert!(contacts.len() > 1_000, "{}", contacts.len());
    }
}

/// Time at which a disc touches a segment, by bisection of the distance in double-double: plain,
/// slow, and with none of the formulas.
fn judged_time(segment: Segment, disc: &Disc, near: f64) -> f64 {
    use carom::exact::{DoubleDouble, DoubleDoubleVec};
    let along = DoubleDoubleVec {
        x: DoubleDouble::sum(segment.to.x, -segment.from.x),
        y: DoubleDouble::sum(segment.to.y, -segment.from.y),
    };
    // Below 0 = closer than the radius: |d|^2 - r^2 of the nearest point, times along^2 for a face.
    let clearance = |time: DoubleDouble| {
        let velocity = DoubleDoubleVec::from(disc.velocity);
        let centre = DoubleDoubleVec::from(disc.position).plus(velocity.times(time));
        let seen = centre.plus_double(-segment.from);
        let (foot, whole) = (along.dot(seen), along.length_squared());
        let radius2 = DoubleDouble::product(disc.radius, disc.radius);
        if foot.value() <= 0.0 {
            return seen.length_squared().minus(radius2).value();
        }
        if foot.minus(whole).value() >= 0.0 {
            return centre.plus_double(-segment.to).length_squared().minus(radius2).value();
        }
        along.cross(seen).squared().minus(radius2.times(whole)).value()
    };
    let (mut low, mut high) = (DoubleDouble::from(0.9 * near), DoubleDouble::from(1.0001 * near));
    assert!(clearance(low) > 0.0 && clearance(high) < 0.0, "{disc:?} {segment:?}");
    for _ in 0..150 {
        let middle = low.plus(high).scaled(0.5);
        if clearance(middle) > 0.0 { low = middle } else { high = middle }
    }
    high.value()
}

#[test]
fn times_are_those_of_a_judge_with_many_digits() {
    let mut random = Random::new(5);
    let (mut faces, mut ends, mut worst) = (0, 0, 0.0f64);
    while faces < 2_000 || ends < 2_000 {
        let segment = Segment { from: random.vector(3.0), to: random.vector(3.0) };
        let aim = segment.from + (segment.to - segment.from) * random.uniform(-0.05, 1.05);
        let radius = random.uniform(0.01, 0.3);
        let at = aim + random.direction() * random.uniform(2.0 * radius, 4.0);
        if segment.distance(at) < 1.01 * radius {
            continue;
        }
        let velocity = (aim - at).normalize() * random.uniform(0.1, 10.0);
        let disc = disc(0, at.to_array(), velocity.to_array(), radius, 1.0);
        let edge = Edge::new(segment);
        let Some(time) = edge.impact(&at.into(), &velocity.into(), radius) else { continue };
        let there = at + velocity * time;
        let is_end = edge.near(&there.into(), radius).is_end;
        // A grazing hit of an end is not deep enough for the judge's bracket.
        let nearest = segment.nearest(there);
        if velocity.normalize().dot((nearest - there).normalize()) < 0.3 {
            continue;
        }
        let wrong = (time - judged_time(segment, &disc, time)).abs() / time;
        worst = worst.max(wrong);
        if is_end { ends += 1 } else { faces += 1 }
    }
    assert!(worst < 8.0 * f64::EPSILON, "{worst:e}");
}

#[test]
fn segments_that_are_a_box_are_the_box() {
    let (min, max) = (DVec2::new(-1.0, -2.0), DVec2::new(3.0, 0.5));
    let corners = [[-1.0, -2.0], [3.0, -2.0], [3.0, 0.5], [-1.0, 0.5]];
    let mut segments = closed(&corners);
    segments.swap(0, 2);
    let square = Segments::new(&segments, 0.7).expect("segments");
    assert_eq!(square.as_box(), Some(Walls { min, max, restitution: 0.7 }));
    let mut tilted = segments.clone();
    tilted[1].to.x += 1e-9;
    assert_eq!(Segments::new(&tilted, 0.7).expect("segments").as_box(), None);
    assert_eq!(Segments::new(&segments[..3], 0.7).expect("segments").as_box(), None);
    let settings = |segments| Settings { segments: Some(segments), ..Settings::default() };
    let pucks = [disc(1, [0.0, 0.0], [1.0, 0.3], 0.2, 1.0)];
    let plan = Plan::of(&settings(square), &pucks);
    assert!(plan.needed.has(Part::Walls) && !plan.needed.has(Part::Segments));
    let open = Segments::new(&tilted, 0.7).expect("segments");
    let plan = Plan::of(&settings(open), &pucks);
    assert!(!plan.needed.has(Part::Walls) && plan.needed.has(Part::Segments));
    // Met as segments they are no other walls.
    let mut random = Random::new(9);
    let discs: Vec<Disc> = (0..6)
        .map(|id| {
            let at = [f64::from(id % 3) - 0.5, -1.5 + f64::from(id / 3)];
            disc(id, at, random.vector(1.0).to_array(), 0.2, 1.0)
        })
        .collect();
    let boxed = Laws { walls: square.as_box(), contact_time: 0.0, ..Laws::FREE };
    let met = Laws { segments: Some(square), contact_time: 0.0, ..Laws::FREE };
    let (walls, faces) = (Plain::new(boxed, &discs, 0.1), Plain::new(met, &discs, 0.1));
    let [walls, faces] = [walls, faces].map(|mut plain| advance_plain(&mut plain, 4.0));
    assert!(walls.len() > 10 && walls.len() == faces.len());
    for (wall, face) in walls.iter().zip(&faces) {
        assert_eq!((wall.a, wall.normal), (face.a, face.normal));
        assert!((wall.time - face.time).abs() < 1e-12, "{wall:?} {face:?}");
        assert!((wall.approach_speed - face.approach_speed).abs() < 1e-12);
    }
}

#[test]
fn commands_respect_segments_and_others_refuse_them() {
    let segments = Segments::new(&field()[..16], 0.5).expect("segments");
    let settings = Settings { segments: Some(segments), ..Settings::default() };
    let pucks = [disc(1, [0.0, 0.0], [1.0, 0.3], 0.1, 1.0)];
    let place = |x: f64, y: f64| Command::PlacePuck {
        id: 1,
        position: DVec2::new(x, y),
        velocity: DVec2::ZERO,
    };
    let commands = [
        place(2.2, 0.0),
        place(2.2, 0.35),
        place(1.95, 1.0),
        place(5.0, 0.0),
        place(1.93, -1.43),
        Command::AddPuck(disc(2, [0.0, 1.45], [0.0; 2], 0.1, 1.0)),
        Command::MoveWalls { min: DVec2::splat(-1.0), max: DVec2::splat(1.0) },
    ];
    for method in [Method::Plain, Method::Events, Method::Ticks] {
        let settings = Settings { method: Some(method), ..settings };
        let mut world = World::new(settings, &pucks);
        assert_eq!(world.plan().method, method);
        let outcome = world.step(&commands, Instants { heard_at: 0.0, advance_to: 0.0 });
        let outside = |k| (k, NotDone::OutsideWalls);
        let expected = [outside(1), outside(2), outside(3), outside(4), outside(5)];
        assert_eq!(outcome.not_done[..5], expected, "{method}");
        assert_eq!(outcome.not_done[5..], [(6, NotDone::FixedField)], "{method}");
    }
    for method in [Method::Steps, Method::Springs] {
        let error = Plan::of(&settings, &pucks).choose(Some(method), &settings, &pucks);
        assert!(error.expect_err("refused").contains("segments; take events, ticks or plain"));
    }
    let short = Segment { from: DVec2::ONE, to: DVec2::ONE };
    assert_eq!(Segments::new(&[field()[0], short], 1.0), Err(BadSegment::NoLine(1)));
    assert_eq!(Segments::new(&[field()[0]; 65], 1.0), Err(BadSegment::TooMany));
}

#[test]
fn a_bar_is_an_obstacle_in_a_box() {
    let bar = closed(&[[0.0, -0.1], [1.0, -0.1], [1.0, 0.1], [0.0, 0.1]]);
    let bar = Segments::new(&bar, 1.0).expect("segments");
    assert!(bar.contain(DVec2::new(0.5, 0.5), 0.1, true));
    assert!(!bar.contain(DVec2::new(0.5, 0.0), 0.01, true), "in its middle");
    assert!(bar.contain(DVec2::new(0.5, 0.0), 0.01, false), "a room");
}
