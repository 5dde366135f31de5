//! The plan: what scenes need is derived rightly, and what they do not need changes no bit.

use carom::motion::arena::Arena;
use carom::plan::parts::{Part, Parts};
use carom::plan::why::{Told, Verdict};
use carom::plan::{BroadPhase, Method, Plan};
use carom::scene::{Scene, shipped};
use carom::world::{
    Command, Contact, Disc, Instants, Owner, Partner, Periodic, Report, Segment, Segments,
    Settings, World,
};
use glam::DVec2;

use crate::common::{Random, box_settings, disc, gas};

/// Sixty equal elastic discs in the free plane, which need nothing.
fn simple() -> (Settings, Vec<Disc>) {
    (Settings::default(), gas(3, 60, 14.0, (0.4, 0.4), (2.0, 2.0)))
}

fn needed(settings: &Settings, discs: &[Disc]) -> Parts {
    Plan::of(settings, discs).needed
}

#[test]
fn a_simple_scene_needs_nothing() {
    let (settings, discs) = simple();
    let plan = Plan::of(&settings, &discs);
    assert_eq!((plan.needed, plan.built), (Parts::NONE, Parts::NONE));
    assert_eq!((plan.method, plan.contact_time), (Method::Events, 0.0));
    let laws = plan.laws(&settings);
    assert!(laws.walls.is_none() && laws.gravity.is_none() && !laws.extreme_units);
}

#[test]
fn a_scene_needs_what_its_settings_say() {
    let (settings, discs) = simple();
    let periodic = Periodic { min: DVec2::ZERO, max: DVec2::splat(14.0) };
    let lossy = [Part::Restitution, Part::ContactTime, Part::Remembered];
    let cases: [(Settings, &[Part]); 7] = [
        (box_settings(14.0, 1.0), &[Part::Walls]),
        (box_settings(14.0, 0.9), &[Part::Walls, lossy[0], lossy[1], lossy[2]]),
        (Settings { periodic: Some(periodic), ..settings }, &[Part::Periodic]),
        (Settings { restitution: 0.9, ..settings }, &lossy),
        (Settings { restitution: 0.9, contact_time: Some(0.0), ..settings }, &[lossy[0], lossy[2]]),
        (Settings { drag: 0.1, ..settings }, &[Part::Drag]),
        (Settings { gravity: Some(DVec2::NEG_Y), ..settings }, &[Part::Gravity]),
    ];
    for (settings, parts) in cases {
        let parts = parts.iter().map(|part| Parts::only(*part)).fold(Parts::NONE, Parts::and);
        assert_eq!(needed(&settings, &discs), parts, "{settings:?}");
    }
    let none = Settings { gravity: Some(DVec2::ZERO), contact_time: Some(1.0), ..settings };
    assert_eq!(needed(&none, &discs), Parts::NONE);
    // Only the walls take energy: contacts may follow each other endlessly, pairs are elastic.
    let mut soft = box_settings(14.0, 1.0);
    soft.walls.iter_mut().for_each(|walls| walls.restitution = 0.5);
    assert_eq!(needed(&soft, &discs), Parts::only(Part::Walls).and(Parts::only(Part::ContactTime)));
}

#[test]
fn a_scene_needs_what_its_discs_say() {
    let (settings, discs) = simple();
    let changed = |change: fn(&mut Disc)| {
        let mut discs = discs.clone();
        change(&mut discs[17]);
        needed(&settings, &discs)
    };
    assert_eq!(changed(|disc| disc.mass = 3.0), Parts::only(Part::Masses));
    assert_eq!(changed(|disc| disc.radius = 0.39), Parts::only(Part::Radii));
    assert_eq!(changed(|disc| disc.position.x = 1e80), Parts::only(Part::ExtremeUnits));
    assert_eq!(
        changed(|disc| disc.velocity = DVec2::new(1e-80, 0.0)),
        Parts::only(Part::ExtremeUnits)
    );
    let fixed = Parts::only(Part::FixedDiscs).and(Parts::only(Part::Masses));
    let still = changed(|disc| (disc.mass, disc.velocity) = (f64::INFINITY, DVec2::ZERO));
    assert_eq!(still, fixed);
    let moving = changed(|disc| (disc.mass, disc.velocity) = (f64::INFINITY, DVec2::X));
    assert_eq!(moving, fixed.and(Parts::only(Part::Observed)));
    let one = disc(1, [0.0; 2], [1.0, 0.0], 0.5, 2.0);
    let many: Vec<Disc> = (0..30_000).map(|id| Disc { id, ..one }).collect();
    assert_eq!(needed(&settings, &many), Parts::only(Part::Ahead));
    assert_eq!(needed(&settings, &many[1..]), Parts::NONE);
    assert_eq!(needed(&settings, &[]), Parts::NONE);
}

#[test]
fn what_is_asked_for_is_built_where_it_can_be() {
    let (settings, discs) = simple();
    let all = Settings { keep: Parts::ALL, ..settings };
    let mut plan = Plan::of(&all, &discs);
    assert_eq!((plan.needed, plan.method), (Parts::NONE, Method::Events));
    let events = [
        (Part::Walls, true),
        (Part::Periodic, true),
        (Part::WrapInside, false),
        (Part::Masses, true),
        (Part::Radii, true),
        (Part::Restitution, true),
        (Part::ContactTime, true),
        (Part::Gravity, false),
        (Part::Drag, true),
        (Part::Commands, true),
        (Part::Observed, true),
        (Part::ExtremeUnits, false),
        (Part::Ahead, true),
    ];
    for (part, is_built) in events {
        assert_eq!(plan.built.has(part), is_built, "{part:?}");
    }
    let arena = Arena::new(&plan, plan.laws(&all), &discs);
    assert!(matches!(arena, Arena::SlowedEvents(_)));
    plan.choose(Some(Method::Plain), &all, &discs).expect("it suits");
    for part in [Part::Walls, Part::Drag, Part::ExtremeUnits] {
        assert!(plan.built.has(part), "{part:?}");
    }
    assert!(!plan.built.has(Part::Periodic) && plan.laws(&all).extreme_units);
    for method in [Method::Ticks, Method::Steps, Method::Springs] {
        plan.choose(Some(method), &all, &discs).expect("it suits");
        assert!(!plan.built.has(Part::Drag) && plan.laws(&all).walls.is_none(), "{method}");
    }
    // Circles that are reported are looked for in a grid then, however few.
    assert_eq!(Plan::of(&all, &[]).broad_phase(2), BroadPhase::Grid);
    assert_eq!(Plan::of(&settings, &[]).broad_phase(2), BroadPhase::AllPairs);
}

/// The bits of all that an arena shows and has told.
#[derive(Default, PartialEq)]
struct Bits {
    discs: Vec<u64>,
    contacts: Vec<u64>,
    count: u64,
}

impl Bits {
    fn note(&mut self, contacts: &[Contact]) {
        for contact in contacts {
            let Contact { a, b, point, normal, gap, .. } = *contact;
            let b = match b {
                Partner::Disc(id) => u64::from(id),
                Partner::Wall(side) => u64::MAX - side as u64,
                Partner::Segment(k) => u64::MAX - 4 - u64::from(k),
            };
            self.contacts.extend([u64::from(a), b]);
            let (approach, impulse) = (contact.approach_speed, contact.impulse);
            let rest = [gap, approach, impulse, contact.energy_loss, contact.time];
            let numbers = [point.x, point.y, normal.x, normal.y].into_iter().chain(rest);
            self.contacts.extend(numbers.map(f64::to_bits));
            self.count += 1;
        }
    }

    fn look(&mut self, arena: &Arena) {
        for disc in arena.discs(Owner::Simulated).chain(arena.discs(Owner::Observed)) {
            let Disc { position, velocity, .. } = disc;
            let numbers = [position.x, position.y, velocity.x, velocity.y];
            self.discs.extend(numbers.map(f64::to_bits));
        }
        let told = [arena.now(), arena.largest_overlap(), arena.largest_miss()];
        self.discs.extend(told.map(f64::to_bits));
    }
}

/// What a scene does for some seconds; with `busy`, with commands and reports in between.
fn bits(settings: Settings, discs: &[Disc], seconds: f64, busy: bool) -> Bits {
    let mut world = World::new(settings, discs);
    let mut bits = Bits::default();
    for frame in 1..=8u32 {
        let time = seconds * f64::from(frame) / 8.0;
        let mut commands = if busy { asked(frame, discs, time) } else { Vec::new() };
        while world.arena().is_some_and(|arena| arena.now() < time) {
            let instants = Instants { heard_at: time, advance_to: time };
            let outcome = world.step(&std::mem::take(&mut commands), instants);
            assert_eq!(outcome.stall, None);
            outcome.answers.iter().for_each(|answer| bits.note(&answer.contacts));
            bits.note(&outcome.contacts);
        }
        world.arena().into_iter().for_each(|arena| bits.look(arena));
    }
    bits
}

/// Velocities for two pucks, and two circles that touch, one of them among the pucks.
fn asked(frame: u32, discs: &[Disc], time: f64) -> Vec<Command> {
    let id = frame as usize % discs.len();
    let angle = DVec2::from_angle(f64::from(frame));
    let mut commands = vec![Command::SetVelocity { id: discs[id].id, velocity: 0.7 * angle }];
    if frame.is_multiple_of(3) {
        let guest = Disc { id: 9_000_001, position: discs[0].position + 0.3, ..discs[0] };
        let next = guest.position + DVec2::new(1.9 * guest.radius, 0.0);
        let other = Disc { id: 9_000_002, position: next, velocity: -angle, ..guest };
        commands.push(Command::Observe(Report { discs: vec![guest, other], time }));
    }
    commands
}

/// Compares the scene as planned with each part alone and with all of them.
fn same_bits(name: &str, settings: Settings, discs: &[Disc], seconds: f64, each: bool) -> u64 {
    let plan = Plan::of(&settings, discs);
    let mut contacts = 0;
    for busy in [false, true] {
        let bare = bits(settings, discs, seconds, busy);
        let forced = |keep| bits(Settings { keep, ..settings }, discs, seconds, busy) == bare;
        for part in Part::ALL.into_iter().filter(|_| each) {
            assert!(forced(Parts::only(part)), "{name}, {}, {part:?}", plan.method);
        }
        assert!(forced(Parts::ALL), "{name}, {:?}, busy {busy}", settings.method);
        contacts += bare.count;
    }
    contacts
}

#[test]
fn shipped_scenes_have_the_same_bits_with_all_parts() {
    for name in shipped::names() {
        let scene = Scene::load(name).expect("shipped");
        let mut discs: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
        if discs.is_empty() {
            continue;
        }
        // Robots stand until somebody commands them.
        if discs.iter().all(|disc| disc.velocity == DVec2::ZERO) {
            let speed = if name == "league-2d" { 20.0 } else { 2.0 };
            let moving = discs.iter_mut().filter(|disc| disc.mass.is_finite());
            moving.for_each(|disc| disc.velocity = DVec2::from_angle(f64::from(disc.id)) * speed);
        }
        let seconds = if name == "thousand" { 2.0 } else { 6.0 };
        for method in [None, Some(Method::Plain), Some(Method::Events)] {
            let settings = Settings { method, ..scene.settings };
            if discs.len() > 400 && method == Some(Method::Plain) {
                continue;
            }
            let contacts = same_bits(name, settings, &discs, seconds, method.is_none());
            assert!(contacts > 5, "{name}: {contacts}");
        }
    }
}

/// A scene of any kind.
fn any(seed: u64) -> (Settings, Vec<Disc>) {
    let mut random = Random::new(1000 + seed);
    let count = [2, 9, 30, 60, 120, 250][random.below(6)];
    let (radii, masses) = ([(0.3, 0.3), (0.2, 0.4)], [(1.0, 1.0), (0.5, 3.0)]);
    let side = 0.8 + (f64::from(count) * random.uniform(0.6, 2.0)).sqrt().max(3.0);
    let (radius, mass) = (radii[random.below(2)], masses[random.below(2)]);
    let mut discs = gas(seed, count as usize, side, radius, mass);
    let restitution = [1.0, 1.0, 0.95, 0.6][random.below(4)];
    let mut settings = match random.below(3) {
        0 => Settings { restitution, ..Settings::default() },
        1 => box_settings(side, restitution),
        _ => {
            let periodic = Periodic { min: DVec2::ZERO, max: DVec2::splat(side + 0.8) };
            Settings { restitution, periodic: Some(periodic), ..Settings::default() }
        }
    };
    match random.below(5) {
        0 if settings.periodic.is_none() => settings.gravity = Some(DVec2::new(0.0, -0.3)),
        1 => settings.drag = 0.2,
        2 => discs[0].mass = f64::INFINITY,
        3 => (discs[0].mass, discs[0].velocity) = (f64::INFINITY, DVec2::ZERO),
        _ => {}
    }
    (settings, discs)
}

#[test]
fn any_scene_has_the_same_bits_with_all_parts() {
    let mut contacts = 0;
    for seed in 0..20 {
        let (settings, discs) = any(seed);
        for method in [Method::Events, Method::Plain] {
            let settings = Settings { method: Some(method), ..settings };
            let name = format!("seed {seed}: {settings:?}");
            let seconds = if discs.len() > 100 { 1.0 } else { 3.0 };
            contacts += same_bits(&name, settings, &discs, seconds, seed < 8);
        }
    }
    assert!(contacts > 4000, "{contacts}");
}

#[test]
fn between_segments_all_parts_leave_the_bits_as_they_are() {
    let mut contacts = 0;
    for seed in 0..6 {
        let (radius, mass) =
            if seed % 2 == 0 { ((0.3, 0.3), (1.0, 1.0)) } else { ((0.2, 0.4), (0.5, 3.0)) };
        let discs = gas(seed, 60, 9.0, radius, mass);
        let corner = |k: u32| DVec2::from_angle(0.2 + f64::from(k) * 1.1) * 7.6 + 4.5;
        let all: Vec<Segment> =
            (0..6).map(|k| Segment { from: corner(k), to: corner((k + 1) % 6) }).collect();
        let restitution = if seed % 3 == 0 { 0.9 } else { 1.0 };
        let segments = Some(Segments::new(&all, restitution).expect("segments"));
        for method in [Method::Events, Method::Plain] {
            let method = Some(method);
            let settings = Settings { method, restitution, segments, ..Settings::default() };
            let name = format!("seed {seed}, segments");
            contacts += same_bits(&name, settings, &discs, 2.0, method == Some(Method::Events));
        }
    }
    assert!(contacts > 1000, "{contacts}");
}

#[test]
fn every_part_is_told_with_its_reason() {
    for name in shipped::names() {
        for keep in [Parts::NONE, Parts::ALL] {
            let mut scene = Scene::load(name).expect("shipped");
            scene.settings.keep = keep;
            let pucks: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
            let world = scene.world();
            let told = Told { plan: world.plan(), settings: &scene.settings, pucks: &pucks };
            let rows = told.rows();
            assert_eq!(rows.len(), Part::ALL.len());
            for row in &rows {
                assert!(!row.why.is_empty(), "{name}: {row:?}");
                assert!(row.why.chars().count() < 70, "{name}: {row:?}");
                let forced = row.verdict == Verdict::Forced;
                assert!(!forced || keep == Parts::ALL, "{name}: {row:?}");
            }
            let is_forced = rows.iter().any(|row| row.verdict == Verdict::Forced);
            assert_eq!(is_forced, keep == Parts::ALL, "{name}");
        }
    }
}

#[test]
fn what_a_method_does_not_have_is_not_said_to_be_kept() {
    let (settings, discs) = simple();
    let lossy = Settings { restitution: 0.9, keep: Parts::ALL, ..settings };
    for method in Method::ALL.into_iter().filter(|method| *method != Method::Springs) {
        let mut plan = Plan::of(&lossy, &discs);
        plan.choose(Some(method), &lossy, &discs).expect("it suits");
        let told = Told { plan: &plan, settings: &lossy, pucks: &discs };
        let is_kept = |part| {
            let row = told.rows().into_iter().find(|row| row.part == part).expect("listed");
            assert!(!row.why.is_empty(), "{method}: {row:?}");
            row.verdict != Verdict::LeftOut
        };
        assert_eq!(is_kept(Part::Remembered), method == Method::Plain, "{method}");
        assert_eq!(is_kept(Part::DoubleDouble), method == Method::Plain, "{method}");
        assert_eq!(is_kept(Part::Ahead), method == Method::Events, "{method}");
        assert_eq!(is_kept(Part::ContactTime), method != Method::Steps, "{method}");
    }
}

#[test]
fn words_have_the_numbers_of_the_scene() {
    let scene = Scene::load("thousand").expect("shipped");
    let pucks: Vec<Disc> = scene.pucks.iter().map(|puck| puck.disc).collect();
    let world = scene.world();
    let told = Told { plan: world.plan(), settings: &scene.settings, pucks: &pucks };
    let expected = [
        (Part::Walls, Verdict::Kept, "a box of 5 m by 5 m"),
        (Part::Masses, Verdict::LeftOut, "all 1000 masses are 1 kg"),
        (Part::Radii, Verdict::LeftOut, "all 1000 radii are 0.0488 m"),
        (Part::Restitution, Verdict::LeftOut, "pairs are elastic"),
    ];
    let rows = told.rows();
    for (part, verdict, why) in expected {
        let row = rows.iter().find(|row| row.part == part).expect("listed");
        assert_eq!((row.verdict, row.why.as_str()), (verdict, why));
    }
    assert!(told.why_method().starts_with("1000 pucks"), "{}", told.why_method());
}
