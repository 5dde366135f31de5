//! Line segments under the event-driven method, judged by the plain one and by ticks; what no
//! method may do: let a disc out, gain energy, hang at the end of a face.

use carom::detect::segment::Edge;
use carom::motion::arena::Arena;
use carom::motion::events::Events;
use carom::motion::plain::{Laws, Plain};
use carom::motion::ticks::Ticks;
use carom::plan::parts::Part;
use carom::plan::why::{Told, Verdict};
use carom::plan::{Method, Plan};
use carom::scene::lattice::Lattice;
use carom::scene::spread;
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Segment, Segments, Settings, Walls};
use glam::DVec2;

use crate::common::{Random, disc, energy};
use crate::events::{Twins, check, is_same, laws};
use crate::segments::{closed, crowd, field, is_in_room};

/// A closed line around the origin, with corners that stick in.
fn polygon(random: &mut Random, corners: u32, reach: (f64, f64)) -> Vec<Segment> {
    let corner = |k: u32| {
        let angle = (f64::from(k) + random.uniform(0.1, 0.9)) / f64::from(corners);
        let at = DVec2::from_angle(std::f64::consts::TAU * angle);
        (at * random.uniform(reach.0, reach.1)).to_array()
    };
    closed(&(0..corners).map(corner).collect::<Vec<_>>())
}

/// A regular polygon, turned.
fn regular(corners: u32, reach: f64, turned: f64) -> Vec<Segment> {
    let corner = |k: u32| {
        let part = f64::from(k) / f64::from(corners);
        (DVec2::from_angle(turned + std::f64::consts::TAU * part) * reach).to_array()
    };
    closed(&(0..corners).map(corner).collect::<Vec<_>>())
}

/// A scene with segments at odd angles: a closed line, or a box; bars, whose ends stick out, in it.
struct Scene {
    settings: Settings,
    /// What must not be left, if it is segments.
    room: Option<Segments>,
}

impl Scene {
    fn hexagon() -> Self {
        let segments = Segments::new(&regular(6, 10.0, 0.3), 1.0).expect("segments");
        let settings = Settings { segments: Some(segments), ..Settings::default() };
        Self { settings, room: Some(segments) }
    }

    fn any(random: &mut Random) -> Self {
        let restitution = [1.0, 1.0, 0.9, 0.8][random.below(4)];
        let mut settings = Settings { restitution, ..Settings::default() };
        let mut all = Vec::new();
        let mut room = None;
        if random.below(4) == 0 {
            let (min, max) = (DVec2::splat(-7.0), DVec2::splat(7.0));
            settings.walls = Some(Walls { min, max, restitution });
        } else {
            let corners = 3 + random.below(10) as u32;
            all = polygon(random, corners, (5.0, 9.0));
            room = Segments::new(&all, restitution).ok();
        }
        for _ in 0..1 + random.below(4) {
            let from = random.vector(6.0);
            all.push(Segment { from, to: from + random.direction() * random.uniform(0.3, 4.0) });
        }
        settings.segments = Some(Segments::new(&all, restitution).expect("segments"));
        Self { settings, room }
    }

    fn holds(&self, disc: &Disc) -> bool {
        let Settings { walls, segments, .. } = &self.settings;
        walls.is_none_or(|walls| walls.contain(disc.position, disc.radius))
            && self.room.is_none_or(|room| room.contain(disc.position, disc.radius, false))
            && segments.is_none_or(|all| {
                let clear = |line: &Segment| line.distance(disc.position) >= disc.radius;
                all.all().iter().all(clear)
            })
    }

    fn crowd(&self, random: &mut Random, count: u32, radii: (f64, f64)) -> Vec<Disc> {
        let mut discs: Vec<Disc> = Vec::new();
        for _ in 0..100_000 {
            let (at, velocity) = (random.vector(9.0), random.vector(1.0));
            let (radius, mass) = (random.uniform(radii.0, radii.1), random.uniform(0.1, 10.0));
            let id = discs.len() as u32;
            let new = disc(id, at.to_array(), velocity.to_array(), radius, mass);
            let clear = |other: &Disc| other.position.distance(at) > other.radius + radius;
            if self.holds(&new) && discs.iter().all(clear) {
                discs.push(new);
            }
            if discs.len() == count as usize {
                break;
            }
        }
        discs
    }
}

fn advance(events: &mut Events, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while events.now() < until {
        events.advance(until, &mut contacts).expect("no stall");
    }
    contacts
}

#[test]
fn agrees_with_the_plain_method_in_any_room() {
    let (mut faces, mut ends, mut pairs) = (0, 0, 0);
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let scene = Scene::any(&mut random);
        let (count, most) = ([8, 20, 60][random.below(3)], [0.6, 0.4, 0.25][random.below(3)]);
        let mut discs = scene.crowd(&mut random, count, (0.1, most));
        match random.below(4) {
            0 => (discs[0].mass, discs[0].velocity) = (f64::INFINITY, DVec2::ZERO),
            1 => discs[1].velocity *= 50.0,
            _ => {}
        }
        check(&format!("seed {seed}"), &scene.settings, &discs, 15.0);
        let mut events = Events::new(laws(&scene.settings, &discs), &discs);
        events.keep_momentum();
        let contacts = advance(&mut events, 15.0);
        assert_eq!(events.contacts(), contacts.len() as u64);
        for contact in contacts {
            let Partner::Segment(place) = contact.b else {
                pairs += usize::from(matches!(contact.b, Partner::Disc(_)));
                continue;
            };
            let Segment { from, to } = scene.settings.segments.expect("some").all()[place as usize];
            let is_end = contact.point.distance(from).min(contact.point.distance(to)) < 1e-9;
            if is_end { ends += 1 } else { faces += 1 }
        }
        let drift = events.relative_energy_drift();
        assert!(drift.abs() < 1e-13, "seed {seed}: {drift}");
        let drift = events.momentum_drift().expect("an account");
        assert!(drift.length() < 1e-9, "seed {seed}: {drift} N s");
        for disc in events.discs(Owner::Simulated) {
            let smaller = Disc { radius: disc.radius * (1.0 - 1e-9), ..disc };
            assert!(scene.holds(&smaller), "seed {seed}: {disc:?}");
        }
    }
    println!("{faces} faces, {ends} ends, {pairs} pairs");
    assert!(faces > 15_000 && ends > 700 && pairs > 30_000, "{faces}, {ends}, {pairs}");
}

/// All contacts of runs that are too short for rounding to grow.
#[test]
fn has_the_contacts_of_the_plain_method() {
    let mut seen = 0;
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let restitution = if seed % 2 == 0 { 1.0 } else { 0.8 };
        let laws = crate::segments::laws(&field(), restitution);
        let discs = crowd(&mut random, 7, 2.0);
        let (mut plain, mut events) = (Plain::new(laws, &discs, 0.01), Events::new(laws, &discs));
        let (mut judged, ours) = (Vec::new(), advance(&mut events, 0.8));
        while plain.now() < 0.8 {
            plain.advance(0.8, &mut judged).expect("no stall");
        }
        assert_eq!(ours.len(), judged.len(), "seed {seed}");
        for (our, judge) in ours.iter().zip(&judged) {
            assert_eq!((our.a, our.b), (judge.a, judge.b), "seed {seed}");
            assert!((our.time - judge.time).abs() < 1e-9, "seed {seed}: {our:?} {judge:?}");
            assert!((our.approach_speed - judge.approach_speed).abs() < 1e-8);
            assert!((our.normal - judge.normal).length() < 1e-7 && our.gap.abs() < 1e-12);
        }
        seen += ours.len();
    }
    assert!(seen > 700, "{seen}");
}

#[test]
fn agrees_with_ticks_in_a_dense_hexagon() {
    let scene = Scene::hexagon();
    let settings = scene.settings;
    let discs = scene.crowd(&mut Random::new(4), 300, (0.33, 0.33));
    assert_eq!(discs.len(), 300);
    let laws = laws(&settings, &discs);
    let mut events = Events::new(laws, &discs);
    let mut ticks = Ticks::new(laws, &discs, 1e-2).expect("suits");
    let (ours, mut judged) = (advance(&mut events, 20.0), Vec::new());
    while ticks.now() < 20.0 {
        ticks.advance(20.0, &mut judged).expect("no stall");
    }
    let same = ours.iter().zip(&judged).take_while(is_same).count();
    let at_segments =
        ours[..same].iter().filter(|contact| matches!(contact.b, Partner::Segment(_))).count();
    println!("{same} of {} the same, {at_segments} at segments", ours.len());
    assert!(same > 800 && at_segments > 70, "{same}, {at_segments}");
    // What chaos leaves: as many contacts.
    let ratio = ours.len() as f64 / judged.len() as f64;
    assert!((ratio - 1.0).abs() < 0.05, "{} and {}", ours.len(), judged.len());
    for (drift, name) in
        [(events.relative_energy_drift(), "events"), (ticks.relative_energy_drift(), "ticks")]
    {
        assert!(drift.abs() < 1e-13, "{name}: {drift}");
    }
}

#[test]
fn on_levels_of_cells_it_agrees_with_the_plain_method() {
    for seed in 0..3 {
        let (area_fraction, size_ratio) = (0.4, 30.0);
        let lattice =
            Lattice { count: 250, area_fraction, size_ratio, mass_max: 1.0, walled: true, seed };
        let (discs, side) = spread::discs(&lattice).expect("room");
        // Around the box that they lie in, and a bar as wide as two of the smallest in it.
        let middle = DVec2::splat(0.5 * side);
        let mut all = regular(5, 0.95 * side, 0.1);
        all.iter_mut().for_each(|line| {
            (line.from, line.to) = (line.from + middle, line.to + middle);
        });
        let settings = |all: &[Segment]| Settings {
            segments: Some(Segments::new(all, 1.0).expect("segments")),
            ..Settings::default()
        };
        let arena = Events::new(laws(&settings(&all), &discs), &discs);
        assert!(arena.levels() > 1);
        check("levels", &settings(&all), &discs, 10.0);
    }
}

/// Discs that leave through a gap, and such as are outside from the beginning, are held by nobody.
#[test]
fn through_a_gap_discs_leave() {
    let mut random = Random::new(8);
    let (mut outside, mut at_bar) = (0, 0);
    for seed in 0..20 {
        let mut random_scene = Random::new(seed);
        let all = polygon(&mut random_scene, 7, (5.0, 8.0));
        let room = Segments::new(&all, 1.0).expect("segments");
        let whole = Settings { segments: Some(room), ..Settings::default() };
        let scene = Scene { settings: whole, room: Some(room) };
        let discs = scene.crowd(&mut random, 60, (0.1, 0.4));
        let gap = Segments::new(&all[..6], 1.0).expect("segments");
        let settings = Settings { segments: Some(gap), ..Settings::default() };
        check("gap", &settings, &discs, 25.0);
        let mut events = Events::new(laws(&settings, &discs), &discs);
        advance(&mut events, 200.0);
        outside += events.discs(Owner::Simulated).filter(|disc| !scene.holds(disc)).count();
        let drift = events.relative_energy_drift();
        assert!(drift.abs() < 1e-13, "seed {seed}: {drift}");
        // A bar in the free plane, and nobody beside it.
        let bar = Segment { from: DVec2::new(20.0, -9.0), to: DVec2::new(21.0, 9.0) };
        let bar = Segments::new(&[bar], 1.0).expect("segments");
        let settings = Settings { segments: Some(bar), ..Settings::default() };
        let ours = Twins::new(&settings, &discs).run(60.0).0;
        let met = ours.iter().filter(|contact| contact.b == Partner::Segment(0)).count();
        at_bar += met;
        check("bar", &settings, &discs, 60.0);
    }
    assert!(outside > 300 && at_bar > 100, "{outside} went outside, {at_bar} met the bar");
}

#[test]
fn nobody_escapes_however_fast_or_small() {
    for (seed, speed, radius) in
        [(1, 1e7, 0.05), (2, 1e7, 1e-3), (3, 1.0, 1e-3), (4, 1e-6, 0.02), (5, 1e4, 0.1)]
    {
        let mut random = Random::new(seed);
        let mut discs = crowd(&mut random, 9, speed);
        for (disc, segment) in discs.iter_mut().zip(field().iter().step_by(2)) {
            disc.radius = disc.radius.min(radius);
            // Straight into what could leak: corners, joints, ends.
            disc.velocity = (segment.from - disc.position).normalize() * speed;
        }
        for restitution in [1.0, 0.9] {
            let laws = crate::segments::laws(&field(), restitution);
            let laws = Laws { contact_time: 1e-9 / speed, ..laws };
            let mut events = Events::new(laws, &discs);
            let mut contacts = Vec::new();
            for k in 1..=300u32 {
                let until = 3_000.0 / speed * f64::from(k) / 300.0;
                while events.now() < until {
                    events.advance(until, &mut contacts).expect("no stall");
                }
                for disc in events.discs(Owner::Simulated) {
                    assert!(is_in_room(disc.position, disc.radius), "at {speed} m/s: {disc:?}");
                }
            }
            let drift = events.relative_energy_drift();
            assert!(drift.abs() < 1e-12, "at {speed} m/s: {drift}");
            assert!(contacts.len() > 500, "at {speed} m/s: {}", contacts.len());
            if restitution == 1.0 {
                let (was, is) = (energy(&discs), events.kinetic_energy());
                assert!((is - was).abs() < 1e-12 * was, "at {speed} m/s: {was} {is}");
                assert!(contacts.len() > 5_000, "at {speed} m/s: {}", contacts.len());
            }
            for contact in &contacts {
                assert!(contact.gap.abs() < 1e-9 * radius, "at {speed} m/s: {contact:?}");
            }
        }
    }
}

/// What slides along a face lies deeper than it by rounding, or not at all: its end is no obstacle.
#[test]
fn nobody_hangs_at_the_end_of_a_face() {
    let mut random = Random::new(11);
    for round in 0..300 {
        let (from, along) = (random.vector(3.0), random.direction());
        let segment = Segment { from, to: from + along * random.uniform(0.5, 2.0) };
        let radius = random.uniform(0.05, 0.5);
        let deeper = [0.0, 1e-16, -1e-16, 1e-13][round % 4] * radius;
        let at = 0.5 * (segment.from + segment.to) + along.perp() * (radius - deeper);
        let slides = along * random.uniform(0.5, 2.0);
        // Another one falls onto the face, is stopped there, and slides on.
        let falls = slides - along.perp();
        let laws = crate::segments::laws(&[segment], 0.0);
        for (at, velocity) in [(at, slides), (at - 0.1 * falls, falls)] {
            let one = [disc(0, at.to_array(), velocity.to_array(), radius, 1.0)];
            let mut events = Events::new(laws, &one);
            let mut ticks = Ticks::new(laws, &one, 0.1).expect("suits");
            let mut judged = Vec::new();
            while ticks.now() < 10.0 {
                ticks.advance(10.0, &mut judged).expect("no stall");
            }
            let mut plain = Plain::new(laws, &one, 0.1);
            plain.advance(10.0, &mut Vec::new()).expect("no stall");
            let met = [advance(&mut events, 10.0).len(), judged.len()];
            assert!(met[0] < 9 && met[1] < 9, "round {round}: {met:?}");
            let there = at + velocity * 0.1 + slides * 9.9;
            let passed =
                [events.discs(Owner::Simulated).next(), ticks.discs(Owner::Simulated).next()];
            for disc in passed.into_iter().flatten().filter(|_| velocity == falls) {
                assert!(disc.position.distance(there) < 1e-6, "round {round}: {disc:?} {there}");
            }
        }
        // Nor is it met again by who touches it and goes away from what is nearest.
        let (away, deep) = (slides + along.perp() * 1e-9, at - along.perp() * 1e-9);
        let time = Edge::new(segment).impact(&deep.into(), &away.into(), radius);
        assert_eq!(time, None, "round {round}");
    }
}

/// What a quick look excludes does not happen.
#[test]
fn a_quick_look_is_never_wrong() {
    let mut random = Random::new(6);
    let (mut met, mut excluded, mut vain) = (0, 0, 0);
    for _ in 0..200_000 {
        let shift = random.vector(1.0) * random.wide(3.0);
        let segment = Segment { from: shift + random.vector(2.0), to: shift + random.vector(2.0) };
        let (at, velocity) = (shift + random.vector(3.0), random.vector(1.0) * random.wide(3.0));
        let radius = random.uniform(1e-3, 0.5);
        let edge = Edge::new(segment);
        let time = edge.impact(&at.into(), &velocity.into(), radius);
        if let Some(time) = time {
            met += 1;
            let looks = |horizon| edge.may_touch_within(at, velocity, radius, horizon);
            assert!(looks(time) && looks(2.0 * time) && looks(f64::INFINITY), "{segment:?} {at}");
            excluded += usize::from(!looks(0.5 * time));
        } else if edge.may_touch_within(at, velocity, radius, f64::INFINITY) {
            vain += 1;
        }
    }
    assert!(met > 20_000 && excluded > met / 2, "{met} met, {excluded} excluded");
    println!("{met} met, {excluded} excluded at half the time, {vain} looked at in vain");
    let still = Edge::new(Segment { from: DVec2::ZERO, to: DVec2::X });
    assert!(!still.may_touch_within(DVec2::new(0.5, 1.0), DVec2::ZERO, 0.1, 1.0));
}

#[test]
fn the_plan_takes_events_where_it_would_in_a_box() {
    let scene = Scene::hexagon();
    let settings = scene.settings;
    let discs = scene.crowd(&mut Random::new(3), 49, (0.1, 0.3));
    let plan = Plan::of(&settings, &discs);
    assert_eq!(plan.method, Method::Events);
    assert_eq!(Plan::of(&settings, &discs[1..]).method, Method::Plain);
    assert!(matches!(Arena::new(&plan, plan.laws(&settings), &discs), Arena::Events(_)));
    let told = Told { plan: &plan, settings: &settings, pucks: &discs };
    let row = told.rows().into_iter().find(|row| row.part == Part::Segments).expect("told");
    assert_eq!((row.verdict, &row.why[..]), (Verdict::Kept, "6 of them, met at faces and ends"));
    let periodic = Periodic { min: DVec2::splat(-20.0), max: DVec2::splat(20.0) };
    for other in [
        Settings { gravity: Some(DVec2::NEG_Y), ..settings },
        Settings { drag: 0.1, ..settings },
        Settings { periodic: Some(periodic), ..settings },
    ] {
        let mut plan = Plan::of(&other, &discs);
        assert_ne!(plan.method, Method::Events);
        let error = plan.choose(Some(Method::Events), &other, &discs).expect_err("refused");
        let expected = "method events does not do segments with gravity, drag or a periodic box";
        assert_eq!(error, expected);
    }
}
