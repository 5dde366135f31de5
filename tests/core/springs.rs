//! Springs: the closed form and a fine integration, laws, orders, limits, the hard disc at the end.

use carom::motion::plain::{self, Plain};
use carom::motion::springs::oscillator::Oscillator;
use carom::motion::springs::{
    Ending, Explicit, Implicit, Laws, Refused, Scheme, Springs, Stepping,
};
use carom::plan::BroadPhase;
use carom::world::{Contact, Disc, Owner, Walls};
use glam::DVec2;

use crate::common::{Random, disc, energy, gas, momentum};

fn laws(stiffness: f64, damping: f64) -> Laws {
    Laws { stiffness, damping, ending: Ending::NoAttraction, walls: None }
}

fn walls(side: f64) -> Option<Walls> {
    Some(Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution: 1.0 })
}

fn stepping(step: f64, scheme: Scheme) -> Stepping {
    Stepping { step, scheme, refuse_unstable: true, broad_phase: BroadPhase::AllPairs }
}

fn arena(laws: Laws, discs: &[Disc], step: f64) -> Springs {
    Springs::new(laws, discs, stepping(step, Scheme::ClosedForm)).expect("sound")
}

fn run(arena: &mut Springs, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("stable");
    }
    contacts
}

fn states(arena: &Springs) -> Vec<Disc> {
    arena.discs().collect()
}

fn total(arena: &Springs) -> f64 {
    arena.kinetic_energy() + arena.elastic_energy().expect("few pairs")
}

/// Classical RK4 in many small steps.
fn fine(k: f64, gamma: f64, (mut x, mut v): (f64, f64), t: f64) -> (f64, f64) {
    let (steps, force) = (20_000, |x: f64, v: f64| -k * x - gamma * v);
    let h = t / f64::from(steps);
    for _ in 0..steps {
        let (k1, l1) = (v, force(x, v));
        let (k2, l2) = (v + 0.5 * h * l1, force(x + 0.5 * h * k1, v + 0.5 * h * l1));
        let (k3, l3) = (v + 0.5 * h * l2, force(x + 0.5 * h * k2, v + 0.5 * h * l2));
        let (k4, l4) = (v + h * l3, force(x + h * k3, v + h * l3));
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
    }
    (x, v)
}

#[test]
fn the_closed_form_is_the_solution_from_undamped_to_overdamped() {
    let near = [2.0 * (1.0 - 1e-9), 2.0, 2.0 * (1.0 + 1e-9), 2.0 * (1.0 + 1e-4)];
    for gamma in [0.0, 0.1, 1.0, 1.9, 2.1, 2.2, 2.4, 5.0, 50.0].into_iter().chain(near) {
        let contact = Oscillator::new(1.0, gamma, 1.0);
        for start in [(0.0, 1.0), (0.5, 1.0), (0.5, -0.2), (1.0, 0.0)] {
            for t in [0.01, 0.7, 2.0] {
                let (x, v) = contact.after(start.0, start.1, t);
                let (fx, fv) = fine(1.0, gamma, start, t);
                assert!((x - fx).abs() < 1e-11 && (v - fv).abs() < 1e-11, "{gamma} {start:?} {t}");
            }
        }
    }
}

#[test]
fn a_contact_ends_where_its_rule_says_and_not_before() {
    let mut random = Random::new(41);
    for _ in 0..2_000 {
        let (k, gamma) = (10f64.powf(random.uniform(0.0, 12.0)), random.uniform(0.0, 3.0));
        let (mu, v) = (random.uniform(0.1, 3.0), random.uniform(0.1, 3.0));
        let gamma = gamma * (k * mu).sqrt();
        let contact = Oscillator::new(k, gamma, 1.0 / mu);
        for ending in [Ending::OverlapGone, Ending::NoAttraction] {
            let end = contact.end(0.0, v, ending);
            if end.is_infinite() {
                assert!(ending == Ending::OverlapGone && contact.beta() >= contact.omega0());
                continue;
            }
            let what = |t: f64| {
                let (x, v_t) = contact.after(0.0, v, t);
                let force = contact.push(x, v_t) / (contact.omega0() * v);
                if ending == Ending::OverlapGone { x * contact.omega0() / v } else { force }
            };
            assert!(what(end).abs() < 1e-12, "{k} {gamma} {mu} {}", what(end));
            assert!((1..100).all(|part| what(end * f64::from(part) / 100.0) > 0.0));
        }
    }
}

#[test]
fn damping_from_none_to_far_overdamped_gives_restitutions_from_1_to_0() {
    let mut last = 1.0 + 1e-12;
    for exponent in -40..=60 {
        let gamma =
            if exponent == -40 { 0.0 } else { 1e3 * 10f64.powf(f64::from(exponent) / 10.0) };
        let discs =
            [disc(1, [0.0; 2], [1.0, 0.3], 0.5, 1.0), disc(2, [1.5, 0.0], [0.0, 0.3], 0.5, 1.0)];
        let mut arena = arena(laws(1e6, gamma), &discs, 0.25);
        let contacts = run(&mut arena, 2.0);
        let after = states(&arena);
        let e = after[1].velocity.x - after[0].velocity.x;
        assert!((0.0..=last).contains(&e), "{gamma}: {e} after {last}");
        assert_eq!(contacts.len(), 1, "{gamma}");
        let lost = energy(&discs) - energy(&after);
        assert!((contacts[0].energy_loss - lost).abs() < 1e-12, "{gamma}");
        assert!((contacts[0].impulse - 0.5 * (1.0 + e)).abs() < 1e-12);
        assert!((contacts[0].time - 0.5).abs() < 1e-12);
        last = e + 1e-12;
    }
    assert!(last < 1e-3);
}

#[test]
fn a_wall_and_a_fixed_disc_are_alike() {
    for gamma in [0.0, 100.0, 3e3] {
        let box_laws = Laws { walls: walls(9.0), ..laws(1e6, gamma) };
        let mut wall = arena(box_laws, &[disc(1, [1.0, 4.0], [-1.0, 0.5], 0.5, 0.7)], 0.1);
        let fixed = disc(2, [-0.5, 4.0], [0.0, 0.5], 0.5, f64::INFINITY);
        let puck = disc(1, [1.0, 4.0], [-1.0, 0.5], 0.5, 0.7);
        let mut post = arena(laws(1e6, gamma), &[puck, fixed], 0.1);
        let (a, b) = (run(&mut wall, 1.0), run(&mut post, 1.0));
        assert!((a[0].impulse - b[0].impulse).abs() < 1e-10 && a.len() == 1 && b.len() == 1);
        assert!(states(&wall)[0].position.distance(states(&post)[0].position) < 1e-11);
        assert!(states(&wall)[0].velocity.distance(states(&post)[0].velocity) < 1e-11);
    }
}

#[test]
fn energy_and_momentum_are_kept_in_a_crowd() {
    let discs = gas(42, 40, 6.5, (0.3, 0.5), (0.2, 5.0));
    for (stiffness, bound) in [(1e3, 1e-3), (1e6, 1e-3)] {
        let mut free = arena(laws(stiffness, 0.0), &discs, 0.01);
        assert!(run(&mut free, 3.0).len() > 10);
        assert!(momentum(&states(&free)).distance(momentum(&discs)) < 1e-11);
        let boxed = Laws { walls: walls(6.5), ..laws(stiffness, 0.0) };
        let mut arena = arena(boxed, &discs, 0.01);
        assert!(run(&mut arena, 3.0).len() > 50);
        let drift = total(&arena) / energy(&discs) - 1.0;
        println!("k = {stiffness}: drift {drift:e}");
        assert!(drift.abs() < bound, "{drift}");
    }
}

#[test]
fn a_stiffness_of_1e12_is_stable_and_ends_at_the_hard_disc() {
    let discs = gas(43, 6, 6.0, (0.3, 0.6), (0.5, 3.0));
    let hard = plain::Laws { restitution: 1.0, walls: walls(6.0), ..plain::Laws::default() };
    let mut judge = Plain::new(hard, &discs, 0.3);
    let mut events = Vec::new();
    judge.advance(2.0, &mut events).expect("no stall");
    assert!(events.len() >= 3);
    let error = |stiffness: f64| {
        let laws = Laws { walls: walls(6.0), ..laws(stiffness, 0.0) };
        let mut arena = arena(laws, &discs, 0.01);
        assert_eq!(run(&mut arena, 2.0).len(), events.len());
        assert!((total(&arena) / energy(&discs) - 1.0).abs() < 1e-6);
        let both = judge.discs(Owner::Simulated).zip(states(&arena));
        both.map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
    };
    let errors = [1e8, 1e10, 1e12].map(error);
    println!("{errors:?}");
    assert!(errors[2] < 1e-4);
    // k^-1/2: a tenth for each factor of a hundred.
    for pair in errors.windows(2) {
        assert!((5.0..20.0).contains(&(pair[0] / pair[1])), "{errors:?}");
    }
}

/// Error at a time within a contact off the centre, against the finest.
fn errors_in_contact(scheme: Scheme, steps: [f64; 2]) -> [f64; 2] {
    let discs = [disc(1, [0.0; 2], [1.0, 0.5], 0.5, 1.0), disc(2, [0.8, 0.3], [0.0; 2], 0.5, 2.0)];
    let at = |step: f64, scheme: Scheme| {
        let laws = Laws { ending: Ending::OverlapGone, ..laws(10.0, 0.4) };
        let mut arena = Springs::new(laws, &discs, stepping(step, scheme)).expect("stable");
        run(&mut arena, 0.25);
        states(&arena)
    };
    let finest = at(1.0 / 65536.0, Scheme::Explicit(Explicit::Rk4));
    steps.map(|step| {
        let both = at(step, scheme).into_iter().zip(&finest);
        both.map(|(a, b)| a.position.distance(b.position)).fold(0.0, f64::max)
    })
}

#[test]
fn rules_converge_with_their_order() {
    let orders = [
        (Scheme::Explicit(Explicit::ForwardEuler), 1.0),
        (Scheme::Explicit(Explicit::SemiImplicitEuler), 1.0),
        (Scheme::Explicit(Explicit::Rk2), 2.0),
        (Scheme::Explicit(Explicit::Rk3), 3.0),
        (Scheme::Explicit(Explicit::Rk4), 4.0),
        (Scheme::Implicit(Implicit::BackwardEuler), 1.0),
        (Scheme::ClosedForm, 2.0),
    ];
    for (scheme, order) in orders {
        let [coarse, fine] = errors_in_contact(scheme, [1.0 / 64.0, 1.0 / 128.0]);
        let ours = (coarse / fine).log2();
        println!("{scheme:?}: {coarse:e} {fine:e}, order {ours:.2}");
        assert!((ours - order).abs() < 0.35, "{scheme:?}: {ours}");
    }
}

#[test]
fn too_long_a_step_is_refused_with_the_longest_stable_one() {
    let pair = [disc(1, [0.0; 2], [1.0, 0.0], 0.5, 1.0), disc(2, [3.0, 0.0], [0.0; 2], 0.5, 1.0)];
    let verlet = stepping(0.02, Scheme::Explicit(Explicit::VelocityVerlet));
    let error = Springs::new(laws(1e4, 0.0), &pair, verlet).expect_err("too long");
    let Refused::StepTooLong { largest, .. } = error else { panic!("{error}") };
    assert!((largest - 2.0 / 2e4f64.sqrt()).abs() < 1e-15);
    let text = error.to_string();
    assert!(text.contains("velocity Verlet") && text.contains("1.414213562373095"), "{text}");
    // Damped semi-implicit Euler: 2 (sqrt(beta^2 + omega^2) - beta) / omega^2.
    for beta in [0.1, 1.0, 10.0] {
        let ours = Explicit::SemiImplicitEuler.largest_stable_step(3.0, beta);
        let wanted = 2.0 * (f64::sqrt(beta * beta + 9.0) - beta) / 9.0;
        assert!((ours - wanted).abs() < 1e-9 * wanted, "{beta}: {ours} {wanted}");
    }
    // A row that closes up on the way is stiffer than a pair: found when it does.
    let row = [
        disc(1, [0.0; 2], [0.0; 2], 0.5, 1.0),
        disc(2, [1.0, 0.0], [0.0; 2], 0.5, 1.0),
        disc(3, [2.2, 0.0], [-1.0, 0.0], 0.5, 1.0),
    ];
    let near = stepping(0.0135, Scheme::Explicit(Explicit::VelocityVerlet));
    let mut arena = Springs::new(laws(1e4, 0.0), &row[1..], near).expect("a pair stands it");
    assert!(arena.advance(1.0, &mut Vec::new()).is_ok());
    let mut arena = Springs::new(laws(1e4, 0.0), &row, near).expect("as long as it is a pair");
    let mut outcome = Ok(());
    while outcome.is_ok() && arena.now() < 1.0 {
        outcome = arena.advance(1.0, &mut Vec::new());
    }
    assert!(matches!(outcome, Err(Refused::StepTooLong { .. })), "{outcome:?}");
}

#[test]
fn bad_numbers_are_refused() {
    let pair = [disc(1, [0.0; 2], [0.0; 2], 0.5, 1.0), disc(2, [3.0, 0.0], [0.0; 2], 0.5, 1.0)];
    for (k, gamma, step) in [
        (0.0, 0.0, 0.1),
        (f64::NAN, 0.0, 0.1),
        (1.0, -1.0, 0.1),
        (1.0, f64::INFINITY, 0.1),
        (1.0, 0.0, 0.0),
        (1e300, 0.0, 0.1),
        (1.0, 1e160, 0.1),
    ] {
        let outcome = Springs::new(laws(k, gamma), &pair, stepping(step, Scheme::ClosedForm));
        assert!(matches!(outcome, Err(Refused::Number { .. })), "{k} {gamma} {step}");
    }
}

#[test]
fn results_do_not_depend_on_where_one_looks() {
    let discs = gas(44, 12, 5.0, (0.3, 0.6), (0.5, 3.0));
    let laws = Laws { walls: walls(5.0), ..laws(1e5, 3.0) };
    let (mut once, mut many) = (arena(laws, &discs, 0.013), arena(laws, &discs, 0.013));
    let whole = run(&mut once, 2.0);
    let seen: Vec<Contact> = (1..=14).flat_map(|k| run(&mut many, f64::from(k) / 7.0)).collect();
    assert_eq!((seen, states(&many)), (whole, states(&once)));
}

#[test]
fn wild_numbers_stay_numbers() {
    let mut random = Random::new(45);
    for round in 0..40 {
        let discs: Vec<Disc> = (0..2 + random.below(4) as u32)
            .map(|id| Disc {
                id,
                position: random.vector(1.0),
                velocity: random.vector(1.0) * random.wide(3.0),
                radius: random.wide(1.0).abs(),
                mass: if random.below(5) == 0 { f64::INFINITY } else { random.wide(6.0).abs() },
            })
            .collect();
        let mut discs = discs;
        if round % 3 == 0 {
            discs[1].position = discs[0].position;
        }
        let ending = if round % 2 == 0 { Ending::OverlapGone } else { Ending::NoAttraction };
        let box_walls = if round % 4 == 0 { walls(1.0) } else { None };
        let (stiffness, damping) = (random.wide(12.0).abs(), random.wide(8.0).abs());
        let laws = Laws { stiffness, damping, ending, walls: box_walls };
        let mut arena = arena(laws, &discs, 0.01);
        let mut contacts = Vec::new();
        arena.advance(0.02, &mut contacts).expect("finite");
        assert!(states(&arena).iter().all(|d| d.position.is_finite() && d.velocity.is_finite()));
    }
}

#[test]
fn lists_of_neighbours_change_no_bit() {
    for (seed, stiffness, damping) in [(61, 1e3, 0.0), (62, 1e5, 3.0), (63, 1e8, 0.0)] {
        let discs = gas(seed, 60, 9.0, (0.2, 0.5), (0.5, 3.0));
        let laws = Laws { walls: walls(9.0), ..laws(stiffness, damping) };
        let all = stepping(0.01, Scheme::ClosedForm);
        let grid = Stepping { broad_phase: BroadPhase::Grid, ..all };
        let mut judge = Springs::new(laws, &discs, all).expect("sound");
        let mut listed = Springs::new(laws, &discs, grid).expect("sound");
        for k in 1..=90 {
            // Also between step ends, and after a command there.
            let until = 0.0333 * f64::from(k);
            assert_eq!(run(&mut listed, until), run(&mut judge, until));
            assert_eq!(states(&listed), states(&judge));
            if k % 20 == 0 {
                for arena in [&mut listed, &mut judge] {
                    arena.set_velocity(k, DVec2::new(1.5, -0.5)).expect("stable");
                }
            }
        }
        assert!(listed.contacts() > 100, "{}", listed.contacts());
        assert_eq!(listed.relative_energy_drift(), judge.relative_energy_drift());
        assert!(listed.relative_energy_drift().abs() < 1e-3);
    }
}

#[test]
fn commands_count_from_the_present() {
    let discs = [disc(1, [0.0; 2], [1.0, 0.0], 0.5, 1.0), disc(2, [3.0, 0.0], [0.0; 2], 0.5, 1.0)];
    let mut arena = arena(laws(1e4, 0.0), &discs, 0.01);
    run(&mut arena, 0.505);
    arena.set_velocity(1, DVec2::new(0.0, 2.0)).expect("stable");
    arena.set_velocity(9, DVec2::X).expect("nobody");
    run(&mut arena, 1.003);
    let after = states(&arena);
    assert!(after[0].position.distance(DVec2::new(0.505, 0.996)) < 1e-12);
    assert_eq!(after[0].velocity, DVec2::new(0.0, 2.0));
    assert!(arena.relative_energy_drift().abs() < 1e-15);
    // In the middle of a contact: its record goes on.
    let mut arena = self::arena(laws(1e2, 0.0), &discs, 0.01);
    let mut contacts = run(&mut arena, 2.1);
    arena.set_velocity(1, DVec2::new(1.2, 0.0)).expect("stable");
    contacts.extend(run(&mut arena, 4.0));
    assert_eq!((contacts.len(), arena.contacts()), (1, 1));
    assert!(arena.relative_energy_drift().abs() < 1e-12, "{}", arena.relative_energy_drift());
}
