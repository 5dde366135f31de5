//! The methods as a scene chooses them: the exact ones agree, the others say how far off they are,
//! and what does not suit is refused in one line with its place.

use std::collections::BTreeSet;

use carom::motion::arena::Arena;
use carom::plan::{Method, Plan};
use carom::scene::{Scene, file};
use carom::world::{
    Command, Disc, Instants, Owner, Pace, Periodic, Refusal, Report, Settings, World,
};
use glam::DVec2;

use crate::common::{box_settings, disc, gas};

fn under(method: Method, settings: Settings, discs: &[Disc]) -> Arena {
    let settings = Settings { method: Some(method), ..settings };
    let mut plan = Plan::of(&settings, discs);
    plan.choose(settings.method, &settings, discs).expect("it suits");
    assert_eq!(plan.method, method);
    Arena::new(&plan, plan.laws(&settings), discs)
}

fn run(arena: &mut Arena, until: f64) {
    while arena.now() < until {
        arena.advance(until, &mut Vec::new()).expect("it goes on");
    }
}

fn states(arena: &Arena) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

fn apart(a: &Arena, b: &Arena) -> f64 {
    let (a, b) = (states(a), states(b));
    let pairs = a.iter().zip(&b);
    pairs.map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
}

#[test]
fn exact_methods_agree_and_the_others_come_near_as_their_step_goes_to_0() {
    let discs = gas(81, 14, 8.0, (0.3, 0.5), (0.5, 3.0));
    let pace = Pace { step: 1e-5, stiffness: 1e10, ..Pace::default() };
    let settings = Settings { pace, ..box_settings(8.0, 1.0) };
    let mut judge = under(Method::Plain, settings, &discs);
    run(&mut judge, 2.0);
    assert!(judge.contacts() > 10, "{}", judge.contacts());
    for method in Method::ALL {
        let mut arena = under(method, settings, &discs);
        run(&mut arena, 2.0);
        assert_eq!(arena.contacts(), judge.contacts(), "{method}");
        let tolerance = if method.is_exact() { 1e-10 } else { 1e-2 };
        assert!(apart(&arena, &judge) < tolerance, "{method}: {:e}", apart(&arena, &judge));
        let drift = if method == Method::Springs { 1e-6 } else { 1e-13 };
        assert!(arena.relative_energy_drift().abs() < drift, "{method}");
        assert_eq!(arena.steps().is_some(), matches!(method, Method::Steps | Method::Springs));
        assert_eq!(arena.unseen().is_some(), method == Method::Steps);
    }
}

#[test]
fn every_method_takes_commands() {
    let discs = gas(82, 10, 8.0, (0.3, 0.5), (0.5, 3.0));
    let pace = Pace { step: 1e-4, stiffness: 1e9, ..Pace::default() };
    let settings = Settings { pace, ..box_settings(8.0, 1.0) };
    let drive = |method: Method| {
        let mut arena = under(method, settings, &discs);
        for k in 1..=8 {
            run(&mut arena, 0.1037 * f64::from(k));
            arena.set_velocity(k % 10, DVec2::from_angle(f64::from(k)));
            arena.set_velocity(77, DVec2::X);
        }
        run(&mut arena, 1.0);
        arena
    };
    let judge = drive(Method::Plain);
    for method in Method::ALL {
        let arena = drive(method);
        let tolerance = if method.is_exact() { 1e-10 } else { 1e-2 };
        assert!(apart(&arena, &judge) < tolerance, "{method}: {:e}", apart(&arena, &judge));
        let drift = arena.relative_energy_drift();
        // The turning of a spring's normal is split off: of second order in the angle.
        let most = if method == Method::Springs { 1e-5 } else { 1e-13 };
        assert!(drift.abs() < most, "{method}: {drift:e}");
    }
}

#[test]
fn observed_circles_are_met_or_refused() {
    let puck = disc(100, [0.0; 2], [1.0, 0.0], 0.5, 1.0);
    let guard = disc(7, [3.0, 0.0], [0.0; 2], 0.5, 3.0);
    for method in Method::ALL {
        let settings = Settings { method: Some(method), ..Settings::default() };
        let mut world = World::new(settings, &[puck]);
        let mut corrections = Vec::new();
        for k in 1..=40 {
            let time = 0.1 * f64::from(k);
            let report = Command::Observe(Report { discs: vec![guard], time });
            let outcome = world.step(&[report], Instants { heard_at: time, advance_to: time });
            let refused =
                if method == Method::Springs { vec![(7, Refusal::NotMet)] } else { vec![] };
            assert_eq!(outcome.answers[0].refused, refused, "{method}");
            corrections.extend(outcome.corrections);
        }
        let arena = world.arena().expect("one puck");
        let expected = if method == Method::Springs { 0 } else { 1 };
        assert_eq!(corrections.len(), expected, "{method}");
        for (id, velocity) in corrections {
            assert_eq!(id, 7);
            assert!(velocity.distance(DVec2::new(0.5, 0.0)) < 1e-12, "{method}: {velocity}");
        }
        assert!(arena.relative_energy_drift().abs() < 1e-12, "{method}");
        // They leave when nobody reports them.
        let mut arena = arena.clone();
        arena.forget(&BTreeSet::from([7]));
        assert_eq!(arena.discs(Owner::Observed).count(), 0);
        run(&mut arena, 6.0);
    }
}

/// Whoever goes stale goes in the same order each time, or discs would not be in the same places.
#[test]
fn circles_that_go_stale_leave_the_same_bits() {
    let pucks = gas(84, 8, 8.0, (0.3, 0.5), (0.5, 3.0));
    let guards: Vec<Disc> = (0..12)
        .map(|k| disc(500 + k, [40.0 + 2.0 * f64::from(k), 40.0], [0.0; 2], 0.5, 3.0))
        .collect();
    for method in Method::ALL.into_iter().filter(|method| *method != Method::Springs) {
        let drive = || {
            let settings = Settings { method: Some(method), ..Settings::default() };
            let mut world = World::new(settings, &pucks);
            let step = |world: &mut World, commands: &[Command], time: f64| {
                world.step(commands, Instants { heard_at: time, advance_to: time })
            };
            step(&mut world, &[Command::Observe(Report { discs: guards.clone(), time: 0.1 })], 0.1);
            for k in 0..6 {
                let puck = disc(900 + k, [-3.0 - 2.0 * f64::from(k), 0.0], [0.5, 0.1], 0.5, 1.0);
                let outcome = step(&mut world, &[Command::AddPuck(puck)], 0.2);
                assert!(outcome.not_done.is_empty(), "{method}");
            }
            step(&mut world, &[], 3.0);
            let arena = world.arena().expect("pucks").clone();
            assert_eq!(arena.discs(Owner::Observed).count(), 0, "{method}");
            states(&arena)
        };
        assert_eq!(drive(), drive(), "{method}");
    }
}

/// So narrow that another image is nearly as near as the nearest.
#[test]
fn contacts_in_the_narrowest_periodic_boxes_are_at_contact() {
    for side in [0.4003, 0.401, 0.403, 0.41, 0.47] {
        let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
        let settings = Settings { periodic, ..Settings::default() };
        let discs =
            [disc(0, [0.1, 0.1], [1.0, 0.3], 0.1, 1.0), disc(1, [0.3, 0.3], [-1.0, 0.2], 0.1, 1.0)];
        for method in [Method::Plain, Method::Ticks] {
            let (mut arena, mut contacts) = (under(method, settings, &discs), Vec::new());
            while arena.now() < 5.0 {
                arena.advance(5.0, &mut contacts).expect("it goes on");
            }
            let deepest = contacts.iter().map(|contact| contact.gap.abs()).fold(0.0, f64::max);
            assert!(contacts.len() > 10 && deepest < 1e-13, "{method}, {side} m: {deepest:e} m");
        }
    }
}

#[test]
fn scenes_name_their_method() {
    let box_ = "walls: {x: [0, 9], y: [0, 9]}\n";
    let puck = "pucks: [{name: a, position: [1, 1], velocity: [3, 0.3], radius: 0.5}]\n";
    for name in ["auto", "events", "plain", "ticks", "steps", "springs"] {
        let text = format!("method: {name}\nstep_s: 0.01\ntick_s: 0.02\n{box_}{puck}");
        let scene = file::parse(&text, "scene.yaml").expect("sound");
        assert_eq!(scene.settings.method, Method::named(name).expect("a name"));
        assert_eq!(scene.settings.pace.step, 0.01);
        let mut world = scene.world();
        let outcome = world.step(&[], Instants { heard_at: 0.0, advance_to: 5.0 });
        assert!(outcome.stall.is_none() && !outcome.contacts.is_empty(), "{name}");
    }
    let refused = [
        (
            "method: fast",
            "1:9: method: `fast` is no method: auto, events, plain, ticks, steps, springs",
        ),
        ("step_s: 0", "1:9: step_s = 0, must be above 0"),
        ("tick_s: .inf", "1:9: tick_s = inf, must be above 0"),
        ("stiffness: -1", "1:12: stiffness = -1, must be above 0"),
        ("damping: -1", "1:10: damping = -1, must be 0 or more"),
        (
            "method: steps\ngravity: [0, -1]",
            "1:9: method steps does not do gravity; take events or plain",
        ),
        (
            "method: ticks\ngravity: [0, -1]",
            "1:9: method ticks does not do gravity; take events or plain",
        ),
        (
            "method: events\nperiodic: {x: [0, 3], y: [0, 3]}",
            "1:9: method events does not do extreme units \
          and periodic boxes of less than five diameters",
        ),
        (
            "method: springs\nrestitution: 0.9",
            "1:9: method springs does not do restitution; leave it \
          out and set damping",
        ),
        (
            "method: springs\nperiodic: {x: [0, 9], y: [0, 9]}",
            "1:9: method springs does not do \
          periodic boxes; take steps",
        ),
        ("method: springs\nstiffness: 1.0e+250", "1:9: stiffness over mass = "),
        ("method: springs\nstep_s: 1.0e+100", "1:9: stiffness over mass times step squared = "),
    ];
    for (keys, message) in refused {
        let error = file::parse(&format!("{keys}\n{puck}"), "scene.yaml");
        let error = error.expect_err("refused").to_string();
        assert!(error.starts_with(&format!("scene.yaml:{}", &message[..4])), "{error}");
        assert!(
            error.contains(message[message.find(": ").expect("a place") + 2..].trim_end()),
            "{error}"
        );
        assert_eq!(error.lines().count(), 1);
    }
    let pushed = "method: springs\nwalls: {x: [0, 9], y: [0, 9]}\n\
                  pucks: [{name: a, position: [5, 5], velocity: [1, 0], radius: 1, mass: .inf}]";
    let error = file::parse(pushed, "scene.yaml").expect_err("refused").to_string();
    assert!(error.contains("fixed pucks that move among walls, which no spring stops"), "{error}");
}

#[test]
fn a_scene_can_be_told_another_method() {
    let mut scene = Scene::load("teams").expect("shipped");
    let before = scene.settings;
    let refusal = scene.choose(Some(Some(Method::Springs)), None).expect_err("it has restitution");
    assert!(refusal.contains("restitution"), "{refusal}");
    assert_eq!(scene.settings, before);
    scene.choose(Some(Some(Method::Steps)), Some(0.01)).expect("it suits");
    assert_eq!((scene.settings.method, scene.settings.pace.step), (Some(Method::Steps), 0.01));
    scene.choose(Some(None), None).expect("auto");
    assert_eq!(scene.settings.method, None);
}
