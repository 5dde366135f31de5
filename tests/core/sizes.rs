//! Discs of very different sizes under the event-driven method, which then has levels of cells:
//! judged by the plain one, contact by contact.

use carom::motion::events::{Events, Lanes};
use carom::motion::plain::{Laws, Plain};
use carom::plan::Plan;
use carom::scene::lattice::Lattice;
use carom::scene::spread;
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Settings, Walls};
use glam::DVec2;

use crate::common::{Random, box_settings, disc};
use crate::events::check;

fn laws(settings: &Settings, discs: &[Disc]) -> Laws {
    Plan::of(settings, discs).laws(settings)
}

/// Radii of all octaves up to a ratio, between walls or in a periodic box.
fn mixture(seed: u64, count: usize, size_ratio: f64, walled: bool) -> (Settings, Vec<Disc>) {
    let area_fraction = 0.4;
    let lattice = Lattice { count, area_fraction, size_ratio, mass_max: 1.0, walled, seed };
    let (discs, side) = spread::discs(&lattice).expect("room");
    if walled {
        return (box_settings(side, 1.0), discs);
    }
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
    (Settings { periodic, ..Settings::default() }, discs)
}

/// Small discs beside one that is a thousand times larger and moves towards them.
fn beside_a_giant(seed: u64, mass: f64, velocity: [f64; 2]) -> Vec<Disc> {
    let mut random = Random::new(seed);
    let mut discs = vec![disc(0, [-500.5, 0.0], velocity, 500.0, mass)];
    while discs.len() < 120 {
        let position = DVec2::new(random.uniform(-2.0, 22.0), random.uniform(-12.0, 12.0));
        let reach = |d: &Disc| d.radius + 0.5 + 1e-6;
        if discs.iter().all(|d| d.position.distance(position) > reach(d)) {
            let id = discs.len() as u32;
            let velocity = random.vector(1.0).to_array();
            discs.push(disc(id, position.to_array(), velocity, 0.5, 1.0));
        }
    }
    discs
}

fn assert_levels(settings: &Settings, discs: &[Disc]) {
    assert!(Events::new(laws(settings, discs), discs).levels() > 1);
}

#[test]
fn agrees_with_the_plain_method_in_a_box() {
    for seed in 0..3 {
        for (count, ratio) in [(150, 8.0), (250, 30.0), (300, 1000.0)] {
            let (settings, discs) = mixture(seed, count, ratio, true);
            assert_levels(&settings, &discs);
            let until = if ratio > 100.0 { 100.0 } else { 10.0 };
            check("elastic", &settings, &discs, until);
            let walls = settings.walls.map(|walls| Walls { restitution: 0.9, ..walls });
            let lossy = Settings { restitution: 0.8, walls, ..settings };
            check("lossy", &lossy, &discs, until);
        }
    }
}

#[test]
fn agrees_with_the_plain_method_in_a_periodic_box() {
    for seed in 0..3 {
        let (settings, mut discs) = mixture(seed, 500, 12.0, false);
        assert_levels(&settings, &discs);
        check("periodic", &settings, &discs, 8.0);
        discs.iter_mut().for_each(|disc| disc.mass = 1.0);
        let lossy = Settings { restitution: 0.9, ..settings };
        check("lossy", &lossy, &discs, 8.0);
    }
}

#[test]
fn agrees_with_the_plain_method_in_a_periodic_box_with_a_disc_too_large_for_cells() {
    for seed in 0..3 {
        let (settings, discs) = mixture(seed, 300, 30.0, false);
        assert_levels(&settings, &discs);
        assert!(Events::suits(&laws(&settings, &discs), &discs));
        check("periodic", &settings, &discs, 12.0);
    }
}

#[test]
fn agrees_with_the_plain_method_in_the_free_plane() {
    for seed in 0..3 {
        let (settings, mut discs) = mixture(seed, 250, 30.0, true);
        let middle = 0.5 * settings.walls.expect("walls").max;
        for disc in &mut discs {
            disc.velocity = 0.1 * (middle - disc.position) + disc.velocity;
        }
        let settings = Settings::default();
        assert_levels(&settings, &discs);
        check("free", &settings, &discs, 60.0);
    }
}

#[test]
fn agrees_with_the_plain_method_around_fixed_discs_and_with_mixed_masses() {
    for seed in 0..3 {
        let (settings, mut discs) = mixture(seed, 250, 30.0, true);
        for disc in discs.iter_mut().filter(|disc| disc.radius > 3.0) {
            (disc.mass, disc.velocity) = (f64::INFINITY, DVec2::ZERO);
        }
        check("fixed", &settings, &discs, 15.0);
        let mut random = Random::new(seed);
        discs.iter_mut().for_each(|disc| disc.mass = 10f64.powf(random.uniform(-2.0, 2.0)));
        check("mixed", &settings, &discs, 15.0);
    }
}

#[test]
fn agrees_with_the_plain_method_beside_a_giant() {
    let walls = Walls { min: DVec2::splat(-1002.0), max: DVec2::splat(40.0), restitution: 1.0 };
    let walled = Settings { walls: Some(walls), ..Settings::default() };
    for seed in 0..3 {
        for (mass, velocity) in
            [(1e6, [1.0, 0.0]), (1e6, [0.1, 2.0]), (30.0, [0.5, 0.1]), (f64::INFINITY, [0.0; 2])]
        {
            let discs = beside_a_giant(seed, mass, velocity);
            assert_levels(&walled, &discs);
            check("giant", &walled, &discs, 12.0);
            check("giant, free", &Settings::default(), &discs, 12.0);
        }
    }
}

#[test]
fn what_lies_in_a_large_disc_and_approaches_collides_at_once() {
    // A small one at rest deep in the giant, which sets out later; and one near its middle.
    let mut discs = beside_a_giant(1, 1e6, [0.0, 0.0]);
    discs.push(disc(900, [-100.0, 3.0], [0.0; 2], 0.5, 1.0));
    discs.push(disc(901, [-480.0, -7.0], [0.0; 2], 0.5, 1.0));
    let settings = Settings::default();
    assert_levels(&settings, &discs);
    let plan = Plan::of(&settings, &discs);
    let laws = plan.laws(&settings);
    let mut events = Events::new(laws, &discs);
    let mut plain = Plain::new(laws, &discs, plan.epoch);
    let (mut ours, mut judged) = (Vec::new(), Vec::new());
    events.advance(0.01, &mut ours).expect("no stall");
    plain.advance(0.01, &mut judged).expect("no stall");
    events.set_velocity(0, DVec2::X);
    plain.set_velocity(0, DVec2::X);
    events.advance(0.5, &mut ours).expect("no stall");
    plain.advance(0.5, &mut judged).expect("no stall");
    assert!(judged.iter().any(|contact| contact.b == Partner::Disc(900)));
    assert!(judged.iter().any(|contact| contact.b == Partner::Disc(901)));
    assert_eq!(partners(&ours), partners(&judged));
}

fn partners(contacts: &[Contact]) -> Vec<(u32, Partner)> {
    contacts.iter().map(|contact| (contact.a, contact.b)).collect()
}

/// What one method of both does under the same circles.
macro_rules! observed {
    ($arena:expr, $side:expr) => {{
        let (mut arena, mut contacts) = ($arena, Vec::<Contact>::new());
        for k in 1..40 {
            arena.advance(0.05 * f64::from(k), &mut contacts).expect("no stall");
            let at = $side * f64::from(k) / 40.0;
            // A giant that sweeps through, one that grows, a small one that jumps into others.
            let giant = disc(900, [at, 0.5 * $side], [6.0, 0.0], 0.2 * $side, 1e9);
            let growing = disc(901, [0.3 * $side, at], [0.0, 3.0], 0.1 * f64::from(k), 1e3);
            let small = disc(902, [$side - at, at], [-3.0, 3.0], 0.2, 10.0);
            let seen = [(k > 20).then_some(giant), Some(growing), (k % 9 < 6).then_some(small)];
            seen.into_iter().flatten().for_each(|circle| arena.observe(circle));
            if k % 9 == 6 {
                arena.forget(&[902].into());
            }
        }
        // Of pairs that overlap when a circle comes, any may be first.
        contacts.sort_by_key(|contact| ((contact.time * 1e7).round() as u64, contact.a));
        contacts
    }};
}

#[test]
fn observed_circles_of_any_size_come_move_and_go() {
    for seed in 0..3 {
        let (settings, discs) = mixture(seed, 200, 30.0, true);
        let side = settings.walls.expect("walls").max.x;
        let plan = Plan::of(&settings, &discs);
        let laws = plan.laws(&settings);
        let mut moved = discs.clone();
        moved.iter_mut().for_each(|disc| disc.position += disc.position * f64::EPSILON);
        let judged = observed!(Plain::new(laws, &discs, plan.epoch), side);
        let again = observed!(Plain::new(laws, &moved, plan.epoch), side);
        let ours = observed!(Events::new(laws, &discs), side);
        let same = |contacts: &[Contact]| {
            let pairs = partners(contacts).into_iter().zip(partners(&judged));
            pairs.take_while(|(a, b)| a == b).count()
        };
        let (ours, predictable) = (same(&ours), same(&again));
        assert!(predictable > 100, "{seed}: {predictable} of {}", judged.len());
        assert!(ours * 4 >= predictable * 3, "{seed}: {ours} of {predictable} are the same");
    }
}

#[test]
fn energy_and_distance_are_kept_over_a_hundred_thousand_contacts() {
    for (count, ratio, walled) in [(2000, 30.0, false), (2000, 1000.0, true), (3000, 1000.0, false)]
    {
        let (settings, discs) = mixture(5, count, ratio, walled);
        assert_levels(&settings, &discs);
        let mut arena = Events::new(laws(&settings, &discs), &discs);
        while arena.contacts() < 100_000 {
            arena.pass(arena.now() + 10.0).expect("no stall");
        }
        assert!(arena.relative_energy_drift().abs() < 1e-12);
        let largest = arena.largest_overlap().max(arena.largest_gap());
        // Of the smaller radius; positions are rounded to parts of the larger.
        let bound = if ratio > 100.0 { 1e-9 } else { 1e-11 };
        assert!(largest < bound, "1:{ratio}: contact distance off by {largest} radii");
        let now: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let periodic = settings.periodic;
        let apart = |a: &Disc, b: &Disc| {
            let d = b.position - a.position;
            let d = periodic.map_or(d, |p| d - p.size() * (d / p.size()).round());
            d.length() - a.radius - b.radius
        };
        for (k, a) in now.iter().enumerate() {
            for b in &now[..k] {
                assert!(apart(a, b) > -1e-8, "{a:?} overlaps {b:?}");
            }
        }
    }
}

#[test]
fn every_processor_gives_the_same_bits() {
    for (ratio, walled) in [(8.0, false), (30.0, true), (1000.0, true)] {
        let (settings, discs) = mixture(3, 400, ratio, walled);
        let [mut four, mut one] = [(); 2].map(|()| Events::new(laws(&settings, &discs), &discs));
        one.use_lanes(Lanes::portable());
        while four.contacts() < 5_000 {
            let until = four.now() + 10.0;
            four.pass(until).expect("no stall");
            one.pass(until).expect("no stall");
        }
        assert_eq!(four.contacts(), one.contacts());
        let states = |arena: &Events| arena.discs(Owner::Simulated).collect::<Vec<Disc>>();
        assert_eq!(states(&four), states(&one));
    }
}

#[test]
fn equal_discs_have_one_level() {
    let (settings, discs) = mixture(1, 300, 1.0, false);
    assert_eq!(Events::new(laws(&settings, &discs), &discs).levels(), 1);
}
