//! The event-driven method under gravity, judged by the plain one, closed forms and the energy.

use carom::motion::events::{Events, Lanes};
use carom::plan::{Method, Plan};
use carom::world::{Contact, Disc, Owner, Partner, Settings, Side};
use glam::DVec2;

use crate::common::{box_settings, disc, gas};
use crate::events::{Twins, check, is_same, laws};

const DOWN: [f64; 2] = [0.0, -2.0];
const SLANTED: [f64; 2] = [0.7, -1.3];

fn tilted(side: f64, restitution: f64, gravity: [f64; 2]) -> Settings {
    Settings { gravity: Some(DVec2::from_array(gravity)), ..box_settings(side, restitution) }
}

fn arena(settings: &Settings, discs: &[Disc]) -> Events {
    Events::new(laws(settings, discs), discs)
}

fn run(arena: &mut Events, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    contacts
}

fn states(arena: &Events) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

fn with_pegs(mut discs: Vec<Disc>) -> Vec<Disc> {
    for disc in discs.iter_mut().step_by(7) {
        (disc.mass, disc.velocity) = (f64::INFINITY, DVec2::ZERO);
    }
    discs
}

#[test]
fn the_plan_takes_events_for_many_discs_that_fall() {
    let plan = |count| {
        let discs = gas(1, count, 14.0, (0.4, 0.4), (1.0, 1.0));
        Plan::of(&tilted(14.0, 1.0, DOWN), &discs).method
    };
    assert_eq!((plan(40), plan(60)), (Method::Plain, Method::Events));
}

#[test]
fn agrees_with_the_plain_method_in_a_box() {
    for seed in 0..4 {
        for gravity in [DOWN, SLANTED, [0.0, -9.81]] {
            let discs = gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0));
            check("equal", &tilted(12.0, 1.0, gravity), &discs, 6.0);
            let discs = gas(seed, 60, 12.0, (0.2, 0.5), (0.1, 10.0));
            check("mixed", &tilted(12.0, 1.0, gravity), &discs, 6.0);
            check("lossy", &tilted(12.0, 0.8, gravity), &discs, 1.5);
        }
    }
}

#[test]
fn agrees_with_the_plain_method_around_fixed_discs() {
    for seed in 0..4 {
        for gravity in [DOWN, SLANTED] {
            let discs = with_pegs(gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0)));
            check("fixed", &tilted(12.0, 1.0, gravity), &discs, 6.0);
            let discs = with_pegs(gas(seed, 60, 12.0, (0.2, 0.5), (0.1, 10.0)));
            check("mixed", &tilted(12.0, 0.8, gravity), &discs, 2.5);
        }
    }
}

#[test]
fn agrees_with_the_plain_method_around_a_fixed_disc_that_moves() {
    for seed in 0..4 {
        let mut discs = gas(seed, 60, 12.0, (0.4, 0.4), (1.0, 1.0));
        discs[30].mass = f64::INFINITY;
        check("moving", &tilted(12.0, 1.0, DOWN), &discs, 6.0);
    }
}

#[test]
fn agrees_with_the_plain_method_in_the_free_plane() {
    for seed in 0..4 {
        let mut discs = gas(seed, 60, 12.0, (0.3, 0.5), (1.0, 3.0));
        for disc in &mut discs {
            disc.velocity = (DVec2::splat(6.0) - disc.position) * 0.3 + disc.velocity * 0.5;
        }
        let settings = Settings { gravity: Some(SLANTED.into()), ..Settings::default() };
        check("free", &settings, &discs, 20.0);
        check("pegs", &settings, &with_pegs(discs), 6.0);
    }
}

#[test]
fn agrees_with_the_plain_method_where_discs_come_to_rest() {
    // So few that they do not come to lie on each other, which is slow.
    for (seed, restitution) in [(0, 0.5), (1, 0.5), (2, 0.0), (3, 0.3)] {
        let discs = gas(seed, 8, 40.0, (0.2, 0.3), (1.0, 2.0));
        for (gravity, until) in [([0.0, -9.81], 8.0), ([0.1, -9.81], 4.0)] {
            let settings = Settings { restitution: 1.0, ..tilted(40.0, restitution, gravity) };
            let (mut ours, mut judged) = Twins::new(&settings, &discs).run(until);
            // The two round differently where two that just met graze each other.
            for contacts in [&mut ours, &mut judged] {
                contacts.retain(|contact| contact.approach_speed > 1e-9);
            }
            let same = ours.iter().zip(&judged).take_while(is_same).count();
            assert!(judged.len() > 8);
            assert_eq!((same, ours.len()), (judged.len(), judged.len()), "{seed} {restitution}");
        }
    }
}

#[test]
fn a_bouncing_ball_keeps_its_time() {
    let mut ball = arena(&tilted(10.0, 1.0, DOWN), &[disc(1, [5.0, 1.5], [0.0; 2], 0.5, 1.0)]);
    let contacts = run(&mut ball, 1000.0);
    assert_eq!(contacts.len(), 500);
    for (k, contact) in contacts.iter().enumerate() {
        assert!((contact.time - (2.0 * k as f64 + 1.0)).abs() < 1e-9, "{k}");
    }
    assert!(ball.relative_energy_drift().abs() < 1e-12, "{}", ball.relative_energy_drift());
}

#[test]
fn bounces_that_lose_energy_end_when_the_series_says_so() {
    let settings = Settings { contact_time: Some(0.0), ..tilted(10.0, 0.5, DOWN) };
    let mut ball = arena(&settings, &[disc(1, [5.0, 1.5], [0.25, 0.0], 0.5, 1.0)]);
    let contacts = run(&mut ball, 2.9);
    // A fall of 1 s, then hops of 1 s, 1/2 s, ...
    for (k, contact) in contacts.iter().enumerate() {
        let time = 3.0 - 2.0 * 0.5f64.powi(k as i32);
        assert!((contact.time - time).abs() < 1e-13, "{k}: {}", contact.time);
        assert!((contact.approach_speed - 2.0 * 0.5f64.powi(k as i32)).abs() < 1e-13);
    }
    let rest = run(&mut ball, 8.0).len() + contacts.len();
    assert_eq!(rest, 21);
    let state = states(&ball)[0];
    assert_eq!((state.position.y, state.velocity), (0.5, DVec2::new(0.25, 0.0)));
    assert!((state.position.x - 7.0).abs() < 1e-13);
    assert!(ball.relative_energy_drift().abs() < 1e-13);
    assert!(run(&mut ball, 1e6).iter().all(|contact| contact.b != Partner::Wall(Side::Bottom)));
}

#[test]
fn a_disc_comes_to_rest_in_a_corner_and_stays() {
    let settings = tilted(10.0, 0.5, [-1.0, -9.81]);
    let mut corner = arena(&settings, &[disc(1, [5.0, 5.0], [2.0, 1.0], 0.5, 1.0)]);
    assert!(run(&mut corner, 60.0).len() < 200);
    assert!(run(&mut corner, 1e6).is_empty());
    let resting = states(&corner)[0];
    assert_eq!((resting.position, resting.velocity), (DVec2::splat(0.5), DVec2::ZERO));
    assert!(corner.relative_energy_drift().abs() < 1e-13);
    // And is woken.
    corner.set_velocity(1, DVec2::new(0.0, 9.81));
    let contacts = run(&mut corner, 1e6 + 50.0);
    assert!((contacts[0].time - 1e6 - 2.0).abs() < 1e-9, "{}", contacts[0].time);
    assert_eq!(states(&corner)[0].position, DVec2::splat(0.5));
    assert!(corner.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn nearly_elastic_floors_end_in_rest_too() {
    for restitution in [0.0, 0.9, 0.99, 0.999] {
        let ball = [disc(1, [5.0, 0.6], [0.3, 0.0], 0.5, 1.0)];
        let mut arena = arena(&tilted(10.0, restitution, [0.0, -9.81]), &ball);
        let contacts = run(&mut arena, 1000.0);
        assert!(contacts.len() < 30_000, "{restitution}: {}", contacts.len());
        assert_eq!(states(&arena)[0].velocity.y, 0.0, "{restitution}");
    }
}

#[test]
fn a_disc_falls_on_a_resting_one_and_on_a_fixed_one() {
    for mass in [1.0, f64::INFINITY] {
        let y = if mass.is_finite() { 0.5 } else { 3.0 };
        let discs =
            [disc(1, [5.0, y], [0.0; 2], 0.5, mass), disc(2, [5.0, y + 2.0], [0.0; 2], 0.5, 1.0)];
        let contacts = run(&mut arena(&tilted(10.0, 0.5, DOWN), &discs), 1.2);
        assert_eq!(contacts[0].b, Partner::Disc(2));
        assert!((contacts[0].time - 1.0).abs() < 1e-15, "{}", contacts[0].time);
        assert!((contacts[0].approach_speed - 2.0).abs() < 1e-15);
    }
}

#[test]
fn a_disc_that_came_to_rest_is_hit_where_it_lies() {
    // The first falls from rest and stays; its flight looks the same before and after.
    let discs = [
        disc(1, [5.0, 1.5], [0.0; 2], 0.5, 1.0),
        disc(2, [3.0, 5.0], [0.5, 0.0], 0.5, 1.0),
        disc(3, [9.0, 9.0], [0.0; 2], 0.5, 1.0),
    ];
    let settings = Settings { restitution: 1.0, ..tilted(10.0, 0.0, DOWN) };
    let mut twins = Twins::new(&settings, &discs);
    let (ours, judged) = twins.run(20.0);
    assert_eq!(ours.len(), judged.len());
    assert!(ours.iter().any(|contact| contact.b == Partner::Disc(2)));
    assert!(ours.iter().zip(&judged).all(|pair| is_same(&pair)));
}

#[test]
fn a_disc_balanced_on_a_post_goes_on() {
    for restitution in [0.0, 0.5] {
        let discs = [
            disc(1, [5.0, 3.0], [0.0; 2], 0.5, f64::INFINITY),
            disc(2, [5.0, 4.5], [0.0; 2], 0.5, 1.0),
        ];
        let mut arena = arena(&tilted(10.0, restitution, [0.0, -9.81]), &discs);
        run(&mut arena, 1.1);
        let place = states(&arena)[1].position;
        assert!(place.distance(DVec2::new(5.0, 4.0)) < 1e-6, "{place}");
        assert!(arena.largest_overlap() < 1e-8, "{}", arena.largest_overlap());
    }
}

#[test]
fn energy_with_the_work_of_gravity_is_kept() {
    for (gravity, pegs) in [([0.0, -9.81], false), (SLANTED, true)] {
        let mut discs = gas(4, 200, 25.0, (0.3, 0.6), (0.5, 3.0));
        if pegs {
            discs = with_pegs(discs);
        }
        let mut arena = arena(&tilted(25.0, 1.0, gravity), &discs);
        while arena.contacts() < 100_000 {
            arena.pass(f64::MAX).expect("no stall");
        }
        assert!(arena.relative_energy_drift().abs() < 1e-12, "{}", arena.relative_energy_drift());
        let miss = arena.largest_overlap().max(arena.largest_gap());
        assert!(miss < 1e-11, "contact distance off by {miss} radii");
    }
}

#[test]
fn looking_between_events_changes_nothing_on_any_processor() {
    for restitution in [1.0, 0.9] {
        let discs = with_pegs(gas(8, 200, 25.0, (0.3, 0.4), (1.0, 2.0)));
        let settings = tilted(25.0, restitution, SLANTED);
        let run = |steps: u32, lanes: Option<Lanes>| {
            let mut arena = arena(&settings, &discs);
            lanes.into_iter().for_each(|lanes| arena.use_lanes(lanes));
            for k in 1..=steps {
                let until = 8.0 * f64::from(k) / f64::from(steps);
                while arena.now() < until {
                    arena.pass(until).expect("no stall");
                }
            }
            (arena.contacts(), states(&arena))
        };
        let once = run(1, None);
        assert!(once.0 > 400, "{}", once.0);
        assert_eq!(once, run(997, None));
        assert_eq!(once, run(1, Some(Lanes::portable())));
    }
}

#[test]
fn commands_and_observed_discs_act_at_once() {
    let discs = gas(4, 50, 12.0, (0.3, 0.3), (1.0, 1.0));
    let mut twins = Twins::new(&tilted(12.0, 1.0, DOWN), &discs);
    let (ours, judged) = twins.run_with_commands_and_guests();
    assert!(judged.len() > 100, "{}", judged.len());
    let same = ours.iter().zip(&judged).take_while(is_same).count();
    assert_eq!((same, ours.len()), (judged.len(), judged.len()));
    assert!(twins.events.relative_energy_drift().abs() < 1e-12);
}
