//! Steps of fixed length: laws first, then what they find late or never, then the events as judge.

use std::collections::BTreeSet;

use carom::motion::plain::{Laws, Plain};
use carom::motion::steps::plain::PlainSteps;
use carom::motion::steps::{NotInSteps, Stepping, Steps, Unseen};
use carom::plan::BroadPhase;
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Walls};
use glam::DVec2;

use crate::common::{Random, disc, energy, gas, momentum};

fn laws(side: f64, restitution: f64) -> Laws {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution };
    Laws { restitution, walls: Some(walls), ..Laws::default() }
}

const FREE: Laws = Laws::FREE;

fn stepping(step: f64) -> Stepping {
    Stepping::of(step)
}

fn arena(laws: Laws, discs: &[Disc], stepping: Stepping) -> Steps {
    Steps::new(laws, discs, stepping).expect("a step")
}

fn run(arena: &mut Steps, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("few pairs");
    }
    contacts
}

fn states(arena: &Steps) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

#[test]
fn energy_is_kept_to_rounding_whatever_the_step() {
    let discs = gas(31, 40, 10.0, (0.2, 0.5), (0.1, 10.0));
    for step in [0.3, 0.03, 0.003] {
        let mut arena = arena(laws(10.0, 1.0), &discs, stepping(step));
        assert!(run(&mut arena, 30.0).len() > 300);
        assert!(arena.relative_energy_drift().abs() < 1e-13, "{}", arena.relative_energy_drift());
        assert!((arena.kinetic_energy() - energy(&discs)).abs() < 1e-12 * energy(&discs));
        assert!(arena.unseen().late > 100);
    }
}

#[test]
fn momentum_is_kept_in_free_space_with_the_correction_too() {
    let discs = gas(32, 40, 7.0, (0.2, 0.4), (0.1, 5.0));
    let centre = |discs: &[Disc]| discs.iter().map(|d| d.mass * d.position).sum::<DVec2>();
    for overlap_sweeps in [0, 4] {
        let mut arena = arena(FREE, &discs, Stepping { overlap_sweeps, ..stepping(0.01) });
        assert!(run(&mut arena, 20.0).len() > 10);
        assert!(momentum(&states(&arena)).distance(momentum(&discs)) < 1e-13);
        let straight = centre(&discs) + 20.0 * momentum(&discs);
        assert!(centre(&states(&arena)).distance(straight) < 1e-10);
    }
}

#[test]
fn losses_and_the_work_of_moving_fixed_discs_are_accounted_for() {
    let mut discs = gas(33, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
    discs[0] = Disc { mass: f64::INFINITY, velocity: DVec2::new(0.3, 0.1), ..discs[0] };
    let mut arena = arena(laws(8.0, 0.8), &discs, stepping(0.01));
    assert!(run(&mut arena, 10.0).len() > 20);
    assert!(arena.relative_energy_drift().abs() < 1e-13, "{:e}", arena.relative_energy_drift());
}

#[test]
fn results_do_not_depend_on_where_one_looks() {
    let discs = gas(34, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
    let mut once = arena(laws(8.0, 0.9), &discs, stepping(0.0123));
    let whole = run(&mut once, 10.0);
    let mut many = arena(laws(8.0, 0.9), &discs, stepping(0.0123));
    let seen: Vec<Contact> = (1..=70).flat_map(|k| run(&mut many, f64::from(k) / 7.0)).collect();
    assert_eq!(seen, whole);
    assert_eq!(states(&many), states(&once));
}

/// The same bits as the plain form by all pairs and by a grid; returns the contacts.
fn judged(laws: Laws, discs: &[Disc], stepping: Stepping, until: f64) -> usize {
    let mut arena = arena(laws, discs, stepping);
    let found = run(&mut arena, until);
    for broad_phase in [BroadPhase::AllPairs, BroadPhase::Grid] {
        let mut judge = PlainSteps::new(laws, discs, stepping, broad_phase).expect("a step");
        let mut due = Vec::new();
        while judge.now() < until {
            judge.advance(until, &mut due).expect("few pairs");
        }
        assert_eq!(found, due);
        assert!(arena.discs(Owner::Simulated).eq(judge.discs()));
        assert_eq!(arena.unseen(), judge.unseen());
        assert_eq!(arena.largest_overlap(), judge.largest_overlap());
        assert_eq!(arena.contacts(), judge.contacts());
    }
    found.len()
}

#[test]
fn lists_of_neighbours_change_no_bit() {
    let periodic = Periodic { min: DVec2::new(-3.0, 1.0), max: DVec2::new(9.0, 13.0) };
    let around = Laws { periodic: Some(periodic), ..FREE };
    for (seed, restitution) in [(35, 1.0), (36, 0.7), (37, 0.0)] {
        let mut discs = gas(seed, 90, 12.0, (0.2, 0.5), (0.5, 3.0));
        discs[3].mass = f64::INFINITY;
        (discs[5].mass, discs[5].velocity) = (f64::INFINITY, DVec2::new(0.1, -0.2));
        for step in [0.2, 0.02, 0.002] {
            for overlap_sweeps in [0, 2] {
                for count_missed in [false, true] {
                    let stepping = Stepping { step, overlap_sweeps, count_missed };
                    let until = (400.0 * step).min(20.0);
                    judged(laws(12.0, restitution), &discs, stepping, until);
                    judged(Laws { restitution, ..FREE }, &discs, stepping, until);
                    let contacts = judged(Laws { restitution, ..around }, &discs, stepping, until);
                    assert!(contacts > 10 || step < 0.01, "{contacts}");
                }
            }
        }
    }
}

#[test]
fn lists_hold_for_odd_crowds() {
    // One much larger than the rest, one much faster, outliers, equal radii, ids in another order.
    let mut discs = gas(38, 120, 16.0, (0.2, 0.2), (1.0, 1.0));
    discs.iter_mut().for_each(|disc| disc.id = 1_000 - disc.id);
    assert!(judged(laws(16.0, 1.0), &discs, stepping(0.01), 8.0) > 50);
    discs.retain(|disc| disc.position.distance(DVec2::splat(8.0)) > 2.3);
    discs.push(disc(2_000, [8.0, 8.0], [0.0, 0.1], 2.0, 50.0));
    discs[0].velocity = DVec2::new(300.0, 100.0);
    assert!(judged(laws(16.0, 0.9), &discs, stepping(0.01), 8.0) > 50);
    discs.push(disc(2_001, [1e9, -1e12], [0.0; 2], 0.5, 1.0));
    discs.push(disc(2_002, [1e9, -1e12 + 3.0], [0.0, -1.0], 0.5, 1.0));
    assert!(judged(FREE, &discs, stepping(0.01), 8.0) > 0);
    // Everyone at rest but one.
    discs.iter_mut().skip(1).for_each(|disc| disc.velocity = DVec2::ZERO);
    judged(laws(16.0, 0.9), &discs[..60], stepping(0.001), 1.0);
}

#[test]
fn units_change_no_digit() {
    let discs = gas(39, 40, 8.0, (0.2, 0.4), (0.5, 3.0));
    let scaled = |length: f64, speed: f64| -> Vec<Disc> {
        let scale = |d: &Disc| Disc {
            position: d.position * length,
            velocity: d.velocity * speed,
            radius: d.radius * length,
            ..*d
        };
        discs.iter().map(scale).collect()
    };
    let plain = run(&mut arena(laws(8.0, 1.0), &discs, stepping(0.03)), 6.0);
    assert!(plain.len() > 50);
    for (length, speed) in [(1e-150, 1e-150), (1e140, 1e100), (1e-100, 1e100), (1e80, 1e-80)] {
        let [length, speed] = [length, speed].map(carom::exact::power_of_two_near);
        let laws = Laws { extreme_units: true, ..laws(8.0 * length, 1.0) };
        let step = stepping(0.03 * (length / speed));
        let found = run(&mut arena(laws, &scaled(length, speed), step), 6.0 * length / speed);
        assert_eq!(found.len(), plain.len());
        for (found, plain) in found.iter().zip(&plain) {
            assert_eq!((found.a, found.b), (plain.a, plain.b));
            assert_eq!(found.normal, plain.normal);
        }
    }
}

#[test]
fn long_runs_keep_their_energy() {
    let discs = gas(40, 60, 9.0, (0.3, 0.5), (0.1, 10.0));
    let mut arena = arena(laws(9.0, 1.0), &discs, stepping(1.0 / 240.0));
    while arena.now() < 400.0 {
        arena.pass(400.0).expect("few pairs");
    }
    assert!(arena.contacts() > 40_000, "{}", arena.contacts());
    assert!(arena.relative_energy_drift().abs() < 1e-12, "{:e}", arena.relative_energy_drift());
}

#[test]
fn heaped_discs_are_refused_and_stay_as_they_are() {
    let discs: Vec<Disc> = (0..4_000).map(|k| disc(k, [0.0; 2], [0.0; 2], 1.0, 1.0)).collect();
    let mut arena = arena(FREE, &discs, stepping(0.1));
    arena.advance(1.0, &mut Vec::new()).expect_err("heaped");
    assert_eq!((arena.now(), states(&arena)), (0.0, discs));
}

#[test]
fn commands_observed_discs_and_those_that_leave() {
    // Judge: the events, at a step so short that no contact is off by more than that.
    let discs = gas(41, 12, 6.0, (0.2, 0.4), (0.5, 3.0));
    let step = 1e-5;
    let mut stepped = arena(laws(6.0, 1.0), &discs, stepping(step));
    let mut exact = Plain::new(laws(6.0, 1.0), &discs, 0.3);
    let (mut found, mut due) = (Vec::new(), Vec::new());
    let mut random = Random::new(41);
    for k in 1..=30 {
        let id = random.below(12) as u32;
        let velocity = random.vector(1.0);
        let guest = disc(100 + k % 3, [0.7 * f64::from(k % 3), 6.5], [0.1, -0.6], 0.2, 2.0);
        let meets = |d: Disc| d.position.distance(guest.position) < d.radius + guest.radius + 0.05;
        if !exact.discs(Owner::Simulated).any(meets) {
            stepped.observe(guest);
            exact.observe(guest);
        }
        stepped.set_velocity(id, velocity);
        exact.set_velocity(id, velocity);
        if k % 10 == 0 {
            stepped.forget(&BTreeSet::from([100, 101]));
            exact.forget(&BTreeSet::from([100, 101]));
        }
        let until = 0.17 * f64::from(k);
        found.extend(run(&mut stepped, until));
        exact.advance(until, &mut due).expect("no stall");
    }
    assert!(due.len() > 10, "{}", due.len());
    let who = |contacts: &[Contact]| contacts.iter().map(|c| (c.a, c.b)).collect::<Vec<_>>();
    assert_eq!(who(&found), who(&due));
    for owner in [Owner::Simulated, Owner::Observed] {
        for (a, b) in stepped.discs(owner).zip(exact.discs(owner)) {
            assert_eq!(a.id, b.id);
            assert!(a.position.distance(b.position) < 0.02, "{a:?} {b:?}");
        }
    }
    assert!(stepped.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn the_error_is_that_of_the_lag_and_of_first_order() {
    // Judge: the events. Each disc is off by (1 + e) lag |v_n| mu / m after the first contact.
    let mut random = Random::new(36);
    for _ in 0..200 {
        let (ma, mb) = (random.uniform(0.1, 10.0), random.uniform(0.1, 10.0));
        let (e, x) = (random.uniform(0.0, 1.0), random.uniform(2.0, 3.0));
        let discs =
            [disc(1, [0.0; 2], [1.5, 0.0], 0.5, ma), disc(2, [x, 0.0], [-0.5, 0.0], 0.5, mb)];
        let laws = Laws { restitution: e, ..FREE };
        let step = random.uniform(0.001, 0.01);
        let mut stepped = arena(laws, &discs, stepping(step));
        let time = run(&mut stepped, 3.0)[0].time;
        let mut exact = Plain::new(laws, &discs, 1.0);
        exact.advance(3.0, &mut Vec::new()).expect("no stall");
        let lag = time - (x - 1.0) / 2.0;
        assert!((0.0..=step).contains(&lag));
        for (a, b) in states(&stepped).iter().zip(exact.discs(Owner::Simulated)) {
            let error = (1.0 + e) * lag * 2.0 * (ma * mb / (ma + mb)) / a.mass;
            assert!((a.position.distance(b.position) - error).abs() < 1e-13);
        }
    }
}

#[test]
fn a_gas_goes_to_the_event_method_as_the_step_goes_to_0() {
    let discs = gas(37, 8, 6.0, (0.3, 0.6), (0.5, 3.0));
    let mut exact = Plain::new(laws(6.0, 0.9), &discs, 0.3);
    let mut events = Vec::new();
    exact.advance(3.0, &mut events).expect("no stall");
    assert!(events.len() > 3);
    let error = |step: f64| {
        let mut arena = arena(laws(6.0, 0.9), &discs, stepping(step));
        let contacts = run(&mut arena, 3.0);
        // Within a step the order is that of the ids.
        let who = |contacts: &[Contact]| {
            let mut who: Vec<_> = contacts.iter().map(|c| (c.a, c.b)).collect();
            who.sort();
            who
        };
        assert_eq!(who(&contacts), who(&events));
        let both = exact.discs(Owner::Simulated).zip(states(&arena));
        both.map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
    };
    let errors = [1e-3, 1e-4, 1e-5].map(error);
    assert!(errors[0] < 0.1 && errors[1] < 0.01 && errors[2] < 0.001, "{errors:?}");
}

#[test]
fn what_is_missed_is_counted() {
    // A bullet passes a thin disc between two step ends; one grazes; one is caught too late.
    let fixed = disc(1, [0.0; 2], [0.0; 2], 0.09, f64::INFINITY);
    let bullet = |x: f64, y: f64| disc(2, [x, y], [100.0, 0.0], 0.01, 1.0);
    for (x, y, unseen) in [
        (-0.5, 0.0, Unseen { missed: 1, ..Unseen::default() }),
        (-0.5, 0.0999, Unseen { missed: 1, ..Unseen::default() }),
        (-0.5, 0.1001, Unseen::default()),
        (-0.95, 0.0, Unseen { too_late: 1, ..Unseen::default() }),
        (-1.05, 0.0, Unseen { late: 1, ..Unseen::default() }),
    ] {
        let mut arena = arena(FREE, &[bullet(x, y), fixed], stepping(0.01));
        let contacts = run(&mut arena, 0.05);
        assert_eq!(arena.unseen(), unseen, "{x} {y}");
        assert_eq!(contacts.len() as u64, unseen.late);
    }
}

#[test]
fn the_correction_moves_positions_only() {
    let mut random = Random::new(38);
    let mut discs: Vec<Disc> = (0..60)
        .map(|k| Disc {
            id: k,
            position: random.vector(2.0),
            ..disc(k, [0.0; 2], [0.0; 2], 0.4, 1.0)
        })
        .collect();
    discs.iter_mut().for_each(|d| d.mass = random.uniform(0.1, 10.0));
    discs[7].mass = f64::INFINITY;
    discs[8].position = discs[9].position;
    let sweeps = Stepping { overlap_sweeps: 50, ..stepping(0.01) };
    let mut arena = arena(Laws { restitution: 0.5, ..FREE }, &discs, sweeps);
    run(&mut arena, 5.0);
    let after = states(&arena);
    assert!(after.iter().all(|d| d.velocity == DVec2::ZERO && d.position.is_finite()));
    assert_eq!(after[7].position, discs[7].position);
    for (k, a) in after.iter().enumerate() {
        for b in &after[k + 1..] {
            assert!(carom::detect::touching::gap(a, b) > -1e-6);
        }
    }
}

#[test]
fn walls_hold_and_report() {
    let discs = [disc(1, [1.0, 1.0], [3.0, 0.5], 0.5, 2.0)];
    let sweeps = Stepping { overlap_sweeps: 1, ..stepping(0.01) };
    let mut arena = arena(laws(4.0, 0.5), &discs, sweeps);
    let contacts = run(&mut arena, 1.0);
    assert_eq!(contacts.len(), 1);
    assert!(matches!(contacts[0].b, Partner::Wall(_)));
    assert!((contacts[0].energy_loss - 0.75 * 9.0).abs() < 1e-12);
    assert_eq!(states(&arena)[0].velocity, DVec2::new(-1.5, 0.5));
    assert!(arena.relative_energy_drift().abs() < 1e-15);
}

#[test]
fn a_bad_step_is_refused() {
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Steps::new(FREE, &[], stepping(step)).expect_err("no step");
        assert!(error.to_string().ends_with("must be a finite number above 0"), "{error}");
    }
    let falling = Laws { gravity: Some(DVec2::NEG_Y), ..FREE };
    let error = Steps::new(falling, &[], stepping(0.1)).expect_err("gravity");
    assert_eq!(error, NotInSteps::Gravity);
}
