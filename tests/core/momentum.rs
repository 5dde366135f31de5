//! The momentum account: what comes from outside is booked, so that what is left is error.

use carom::motion::arena::Arena;
use carom::motion::momentum::MomentumAccount;
use carom::plan::{Method, Plan};
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Settings};
use glam::DVec2;

use crate::common::{Random, box_settings, disc, gas, momentum};

const EXACT: [Method; 3] = [Method::Events, Method::Plain, Method::Ticks];
const ALL: [Method; 4] = [Method::Events, Method::Plain, Method::Ticks, Method::Steps];

fn arena(settings: &Settings, discs: &[Disc], method: Method) -> Arena {
    let mut plan = Plan::of(settings, discs);
    plan.choose(Some(method), settings, discs).expect("it suits");
    Arena::new(&plan, plan.laws(settings), discs)
}

fn advance(arena: &mut Arena, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no halt");
    }
    contacts
}

fn simulated(arena: &Arena) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

/// The sum of the sizes of all momenta: what rounding is to be compared with.
fn scale(discs: &[Disc]) -> f64 {
    let finite = discs.iter().filter(|disc| disc.mass.is_finite());
    finite.map(|disc| disc.mass * disc.velocity.length()).sum()
}

fn drift(arena: &Arena) -> f64 {
    arena.momentum_drift().expect("an account").length()
}

#[test]
fn two_pucks_between_walls_have_the_momentum_of_the_closed_form() {
    // Equal masses change their velocities: after k blows of walls at 2 m/s each by 4 N s.
    let discs =
        [disc(1, [1.0, 1.0], [2.0, 0.0], 0.5, 1.0), disc(2, [4.0, 1.0], [0.0, 0.0], 0.5, 1.0)];
    for method in EXACT {
        let mut arena = arena(&box_settings(6.0, 1.0), &discs, method);
        assert_eq!(arena.momentum_drift(), None, "{method}: nobody asked");
        arena.keep_account();
        let contacts = advance(&mut arena, 9.8);
        let walls = contacts.iter().filter(|c| matches!(c.b, Partner::Wall(_)));
        assert_eq!((contacts.len(), walls.count()), (10, 5), "{method}: {contacts:?}");
        let found = momentum(&simulated(&arena));
        assert!((found - DVec2::new(-2.0, 0.0)).length() < 1e-13, "{method}: {found}");
        assert!(drift(&arena) < 1e-14, "{method}: {}", drift(&arena));
    }
}

#[test]
fn the_account_is_the_sum_of_the_impulses_of_walls() {
    for (seed, restitution) in [(1, 1.0), (2, 0.9)] {
        let discs = gas(seed, 60, 14.0, (0.3, 0.6), (0.5, 3.0));
        for method in ALL {
            let mut arena = arena(&box_settings(14.0, restitution), &discs, method);
            arena.keep_account();
            let mut sum = momentum(&discs);
            let contacts = advance(&mut arena, 10.0);
            let walls = contacts.iter().filter(|c| matches!(c.b, Partner::Wall(_)));
            walls.for_each(|contact| sum -= contact.impulse * contact.normal);
            let (found, size) = (momentum(&simulated(&arena)), scale(&discs));
            assert!(contacts.len() > 200, "{method}: {}", contacts.len());
            assert!((found - momentum(&discs)).length() > 0.05 * size, "{method}: walls push");
            assert!((found - sum).length() < 1e-13 * size, "{method}: {found} {sum}");
            assert!(drift(&arena) < 1e-13 * size, "{method}: {:e}", drift(&arena));
            let told = arena.momentum_drift().expect("an account");
            assert!((told - (found - sum)).length() < 1e-13 * size, "{method}: {told}");
        }
    }
}

#[test]
fn a_periodic_gas_keeps_its_initial_momentum() {
    let periodic = Periodic { min: DVec2::ZERO, max: DVec2::splat(14.0) };
    let settings = Settings { periodic: Some(periodic), ..Settings::default() };
    let discs = gas(3, 60, 13.4, (0.3, 0.4), (0.5, 3.0));
    for method in ALL {
        let mut arena = arena(&settings, &discs, method);
        arena.keep_account();
        assert!(advance(&mut arena, 20.0).len() > 300, "{method}");
        let size = scale(&discs);
        let change = momentum(&simulated(&arena)) - momentum(&discs);
        assert!(change.length() < 1e-13 * size, "{method}: {change}");
        assert!(drift(&arena) < 1e-13 * size, "{method}: {:e}", drift(&arena));
    }
}

#[test]
fn fixed_discs_observed_circles_and_commands_are_no_error() {
    let mut discs = gas(4, 60, 14.0, (0.3, 0.5), (0.5, 3.0));
    // Far from the way of the circle that is observed: between the two a puck would be squeezed.
    let away = |disc: &Disc| disc.position.distance(DVec2::new(9.0, 7.0));
    let far = discs.iter().max_by(|a, b| away(a).total_cmp(&away(b))).expect("discs").id;
    let fixed = &mut discs[far as usize];
    (fixed.mass, fixed.velocity) = (f64::INFINITY, DVec2::ZERO);
    for moving in [false, true] {
        for method in ALL {
            let settings = box_settings(14.0, if moving { 0.95 } else { 1.0 });
            let mut arena = arena(&settings, &discs, method);
            arena.keep_account();
            let mut random = Random::new(5);
            let mut contacts = Vec::new();
            for k in 1..=200 {
                contacts.extend(advance(&mut arena, 0.05 * f64::from(k)));
                if moving {
                    arena.set_velocity(random.below(60) as u32, random.vector(1.5));
                    let position = DVec2::new(7.0 + 0.02 * f64::from(k), 7.0);
                    let velocity = DVec2::new(0.4, 0.0);
                    let guest = Disc { id: 900, position, velocity, radius: 0.6, mass: 4.0 };
                    arena.observe(guest);
                }
            }
            let met = |id: u32| contacts.iter().filter(|c| c.discs().any(|d| d == id)).count();
            let (met_fixed, met_guest) = (met(far), met(900));
            assert!(met_fixed > 1, "{method}: {met_fixed}");
            assert_eq!(met_guest > 3, moving, "{method}: {met_guest}");
            let size = scale(&discs);
            assert!(drift(&arena) < 1e-12 * size, "{method} {moving}: {:e}", drift(&arena));
        }
    }
}

#[test]
fn gravity_and_drag_are_no_error() {
    let discs = gas(6, 60, 14.0, (0.3, 0.5), (0.5, 3.0));
    for method in [Method::Events, Method::Plain] {
        let gravity = Some(DVec2::new(0.3, -2.0));
        for (restitution, seconds) in [(1.0, 3.0), (0.9, 2.0)] {
            let settings = Settings { gravity, ..box_settings(14.0, restitution) };
            let mut arena = arena(&settings, &discs, method);
            advance(&mut arena, 0.25);
            arena.keep_account();
            arena.keep_account();
            assert!(advance(&mut arena, seconds).len() > 50);
            let size = scale(&discs) + 2.0 * seconds * 60.0;
            assert!(drift(&arena) < 1e-12 * size, "{method}: {:e}", drift(&arena));
        }
        let settings = Settings { drag: 0.3, ..box_settings(14.0, 1.0) };
        let mut arena = arena(&settings, &discs, method);
        advance(&mut arena, 0.5);
        arena.keep_account();
        assert!(advance(&mut arena, 9.0).len() > 50);
        let left = scale(&simulated(&arena));
        assert!(left < 0.1 * scale(&discs), "drag takes it: {left}");
        assert!(drift(&arena) < 1e-13 * scale(&discs), "{method}: {:e}", drift(&arena));
    }
}

#[test]
fn discs_that_come_go_and_are_put_elsewhere_are_no_error() {
    let discs = gas(11, 60, 14.0, (0.3, 0.5), (0.5, 3.0));
    for (method, gravity) in ALL.map(|method| (method, None)).into_iter().chain([
        (Method::Events, Some(DVec2::new(0.2, -1.0))),
        (Method::Plain, Some(DVec2::new(0.2, -1.0))),
    ]) {
        let settings = Settings { gravity, ..box_settings(14.0, 1.0) };
        let mut arena = arena(&settings, &discs, method);
        arena.keep_account();
        let mut random = Random::new(12);
        let (mut came, mut went, mut moved) = (0, 0, 0);
        for k in 1..=60 {
            advance(&mut arena, 0.05 * f64::from(k));
            let place = DVec2::splat(7.0) + random.vector(6.0);
            let new = disc(500 + k, place.to_array(), [1.0, -0.5], 0.3, 2.5);
            came += u32::from(arena.add(new).is_ok());
            let place = DVec2::splat(7.0) + random.vector(6.0);
            moved += u32::from(arena.place(random.below(30) as u32, place, DVec2::X).is_ok());
            went += u32::from(k % 4 == 0 && arena.remove(29 + k / 4).is_ok());
        }
        advance(&mut arena, 4.0);
        assert!(came > 5 && went > 10 && moved > 5, "{method}: {came} {went} {moved}");
        assert!(drift(&arena) < 1e-12 * scale(&discs), "{method}: {:e}", drift(&arena));
    }
}

#[test]
fn a_disc_that_comes_to_rest_on_the_floor_is_no_error() {
    let settings = Settings { gravity: Some(DVec2::NEG_Y), ..box_settings(6.0, 0.5) };
    let discs = [disc(1, [2.0, 1.0], [0.5, 0.0], 0.5, 2.0)];
    for method in [Method::Events, Method::Plain] {
        let mut arena = arena(&settings, &discs, method);
        arena.keep_account();
        advance(&mut arena, 20.0);
        let found = simulated(&arena)[0];
        assert_eq!(found.velocity.y, 0.0, "{method}: it rests");
        assert!(drift(&arena) < 1e-13, "{method}: {:e}", drift(&arena));
    }
}

#[test]
fn error_is_told_to_the_last_digit() {
    let discs = gas(8, 200, 40.0, (0.3, 0.5), (0.5, 3.0));
    let mut account = MomentumAccount::default();
    account.book(DVec2::ONE);
    assert_eq!(account.drift(0.0, discs.iter().copied()), None, "not kept");
    account.begin(discs.iter().copied());
    let told = account.drift(3.0, discs.iter().copied()).expect("kept");
    assert!(told.length() < 1e-29 * scale(&discs), "{told}");
    let mut wrong = discs.clone();
    wrong[17] =
        Disc { velocity: wrong[17].velocity + DVec2::new(2f64.powi(-50), 0.0), ..wrong[17] };
    let error = wrong[17].mass * (wrong[17].velocity.x - discs[17].velocity.x);
    let told = account.drift(3.0, wrong.iter().copied()).expect("kept");
    assert!((told.x / error - 1.0).abs() < 1e-9 && told.y.abs() < 1e-25, "{told} {error:e}");
    account.book_change(2.0, DVec2::new(0.25, -1.0));
    account.book_pull(1.0, DVec2::new(0.0, 8.0));
    let told = account.drift(3.0, discs.iter().copied()).expect("kept");
    assert!((told - DVec2::new(-0.5, 2.0 - 16.0)).length() < 1e-14, "{told}");
}

#[test]
fn springs_tell_none() {
    let discs = gas(9, 5, 8.0, (0.3, 0.5), (0.5, 3.0));
    let mut arena = arena(&box_settings(8.0, 1.0), &discs, Method::Springs);
    arena.keep_account();
    assert_eq!(arena.momentum_drift(), None);
}
