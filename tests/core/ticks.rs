//! The method of ticks: judged by the plain method, contact for contact, under commands at every
//! tick.

use std::collections::BTreeSet;

use carom::motion::plain::{Laws, Plain};
use carom::motion::ticks::{NotInTicks, Ticks};
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Walls};
use glam::DVec2;

use crate::common::{Random, disc, energy, gas, momentum};

fn walled(side: f64, restitution: f64) -> Laws {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution };
    Laws { restitution, walls: Some(walls), ..Laws::FREE }
}

fn periodic(side: f64) -> Laws {
    Laws { periodic: Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) }), ..Laws::FREE }
}

fn arena(laws: Laws, discs: &[Disc], tick: f64) -> Ticks {
    Ticks::new(laws, discs, tick).expect("a tick and no gravity")
}

fn run(arena: &mut Ticks, until: f64) -> Vec<Contact> {
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    contacts
}

fn states(arena: &Ticks) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

/// Two methods fed with the same commands.
struct Twins {
    ticks: Ticks,
    plain: Plain,
    found: Vec<Contact>,
    due: Vec<Contact>,
}

impl Twins {
    fn new(laws: Laws, discs: &[Disc], tick: f64) -> Self {
        let ticks = arena(laws, discs, tick);
        let plain = Plain::new(laws, discs, 0.2);
        Self { ticks, plain, found: Vec::new(), due: Vec::new() }
    }

    fn advance(&mut self, until: f64) {
        self.found.extend(run(&mut self.ticks, until));
        while self.plain.now() < until {
            self.plain.advance(until, &mut self.due).expect("no stall");
        }
    }

    fn set_velocity(&mut self, id: u32, velocity: DVec2) {
        self.ticks.set_velocity(id, velocity);
        self.plain.set_velocity(id, velocity);
    }

    /// The same contacts, in order; times and states to rounding, which contacts let grow.
    fn compare(&self, tolerance: f64) {
        assert_eq!(self.found.len(), self.due.len());
        for (a, b) in self.found.iter().zip(&self.due) {
            assert_eq!((a.a, a.b), (b.a, b.b), "at {} and {}", a.time, b.time);
            assert!((a.time - b.time).abs() < tolerance, "{} {}", a.time, b.time);
            assert!((a.impulse - b.impulse).abs() < 1e3 * tolerance);
            assert!(a.point.distance(b.point) < 1e2 * tolerance);
        }
        for owner in [Owner::Simulated, Owner::Observed] {
            for (a, b) in self.ticks.discs(owner).zip(self.plain.discs(owner)) {
                assert_eq!(a.id, b.id);
                assert!(a.position.distance(b.position) < 1e2 * tolerance, "{a:?} {b:?}");
                assert!(a.velocity.distance(b.velocity) < 1e3 * tolerance, "{a:?} {b:?}");
            }
        }
        assert_eq!(self.ticks.contacts(), self.plain.contacts());
    }
}

/// New velocities for all at every tick; returns the number of contacts.
fn drive(laws: Laws, discs: &[Disc], tick: f64, ticks: usize, seed: u64) -> usize {
    let mut twins = Twins::new(laws, discs, tick);
    let mut random = Random::new(seed);
    for k in 1..=ticks {
        for disc in discs {
            twins.set_velocity(disc.id, random.vector(2.0));
        }
        twins.advance(k as f64 * tick);
    }
    twins.compare(1e-10);
    assert!(twins.ticks.relative_energy_drift().abs() < 1e-13);
    assert!(twins.ticks.largest_overlap() < 1e-12);
    twins.found.len()
}

#[test]
fn driven_discs_have_the_contacts_of_the_plain_method() {
    for seed in 0..10 {
        let restitution = if seed % 2 == 0 { 1.0 } else { 0.6 };
        let mut discs = gas(seed, 25, 8.0, (0.2, 0.6), (0.5, 3.0));
        discs[3].mass = f64::INFINITY;
        let contacts = drive(walled(8.0, restitution), &discs, 0.1, 40, seed);
        assert!(contacts > 50, "{contacts}");
    }
}

#[test]
fn driven_discs_in_a_periodic_box_too() {
    for seed in 0..10 {
        let discs = gas(seed, 25, 8.0, (0.2, 0.6), (0.5, 3.0));
        let contacts = drive(periodic(8.0), &discs, 0.1, 40, seed);
        assert!(contacts > 50, "{contacts}");
    }
}

#[test]
fn many_driven_discs_too() {
    // Enough for a grid; one much larger than the rest.
    let mut discs = gas(11, 150, 20.0, (0.2, 0.5), (0.5, 3.0));
    discs.retain(|disc| disc.position.distance(DVec2::splat(10.0)) > 2.6 + disc.radius);
    discs.push(disc(900, [10.0, 10.0], [0.0, 0.0], 2.5, 50.0));
    assert!(discs.len() > 100);
    let contacts = drive(walled(20.0, 0.9), &discs, 0.05, 40, 1);
    assert!(contacts > 200, "{contacts}");
    let contacts = drive(periodic(20.0), &discs, 0.05, 40, 2);
    assert!(contacts > 200, "{contacts}");
    // In the free plane they scatter.
    drive(Laws::FREE, &discs, 0.05, 40, 3);
}

#[test]
fn free_flight_has_the_contacts_of_the_plain_method_for_every_tick() {
    for (seed, laws) in [(1, walled(8.0, 1.0)), (2, walled(8.0, 0.8)), (3, periodic(8.0))] {
        let discs = gas(seed, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
        // Ticks long enough to be divided, and short.
        for tick in [1e-3, 0.017, 0.3, 10.0, 1e4] {
            let mut twins = Twins::new(laws, &discs, tick);
            twins.advance(3.0);
            assert!(twins.found.len() > 20);
            twins.compare(1e-9);
        }
    }
}

#[test]
fn commands_between_ticks_count_from_then_on() {
    let discs = gas(21, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
    let mut twins = Twins::new(walled(8.0, 1.0), &discs, 0.1);
    let (mut random, mut now) = (Random::new(21), 0.0);
    for _ in 0..100 {
        now += random.uniform(0.0, 0.08);
        twins.advance(now);
        let id = random.below(22) as u32;
        twins.set_velocity(id, random.vector(1.5));
    }
    assert!(twins.found.len() > 50);
    twins.compare(1e-9);
}

#[test]
fn observed_discs_come_move_and_go() {
    let discs = gas(22, 12, 6.0, (0.2, 0.4), (0.5, 3.0));
    let mut twins = Twins::new(walled(6.0, 1.0), &discs, 0.1);
    let mut random = Random::new(22);
    for k in 1..=120 {
        let place = [random.uniform(0.0, 6.0), random.uniform(0.0, 6.0)];
        let id = 100 + random.below(4) as u32;
        let mut seen = disc(id, place, [0.3, -0.2], random.uniform(0.1, 0.3), 1.0);
        // Clear of all pucks, or there is no saying who moves first.
        let free = |seen: &Disc| {
            let all = twins.ticks.discs(Owner::Simulated);
            all.into_iter().all(|d| d.position.distance(seen.position) > d.radius + seen.radius)
        };
        if !free(&seen) {
            seen.position = DVec2::splat(-50.0);
        }
        twins.ticks.observe(seen);
        twins.plain.observe(seen);
        if k % 10 == 0 {
            let gone = BTreeSet::from([100, 102]);
            twins.ticks.forget(&gone);
            twins.plain.forget(&gone);
        }
        twins.advance(0.083 * f64::from(k));
    }
    let met = |contact: &&Contact| matches!(contact.b, Partner::Disc(id) if id >= 100);
    assert!(twins.found.iter().filter(met).count() > 3);
    twins.compare(1e-9);
    assert!(twins.ticks.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn where_one_stops_to_look_does_not_matter() {
    for (laws, tick) in [(walled(8.0, 0.9), 0.1), (periodic(8.0), 0.03), (walled(8.0, 1.0), 2.0)] {
        let discs = gas(3, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
        let mut once = arena(laws, &discs, tick);
        let whole = run(&mut once, 20.0);
        assert!(whole.len() > 100);
        let mut random = Random::new(4);
        for longest in [0.011, 0.3] {
            let mut many = arena(laws, &discs, tick);
            let mut contacts = Vec::new();
            while many.now() < 20.0 {
                let until = (many.now() + random.uniform(0.0, longest)).min(20.0);
                contacts.extend(run(&mut many, until));
                // Looking changes nothing, nor does a command that does not.
                let looked = states(&many)[0];
                many.set_velocity(looked.id, looked.velocity);
            }
            assert_eq!(contacts, whole);
            assert_eq!(states(&many), states(&once));
        }
    }
}

#[test]
fn energy_and_momentum_are_kept_and_nothing_overlaps() {
    let discs = gas(5, 60, 12.0, (0.2, 0.5), (0.1, 10.0));
    let mut arena = arena(periodic(12.0), &discs, 1.0 / 60.0);
    run(&mut arena, 60.0);
    let now = states(&arena);
    for (k, a) in now.iter().enumerate() {
        for b in &now[k + 1..] {
            let gap = carom::detect::touching::gap(a, b);
            assert!(gap > -1e-12 * a.radius.min(b.radius), "{gap}");
        }
    }
    assert!(arena.contacts() > 1_000);
    assert!(momentum(&now).distance(momentum(&discs)) < 1e-12);
    assert!((energy(&now) - energy(&discs)).abs() < 1e-12 * energy(&discs));
    assert!(arena.relative_energy_drift().abs() < 1e-13);
    assert!(arena.largest_overlap() < 1e-12, "{}", arena.largest_overlap());
}

#[test]
fn the_order_of_the_discs_changes_no_bit() {
    let mut random = Random::new(51);
    for seed in 0..5 {
        let mut discs = gas(seed, 40, 10.0, (0.3, 0.6), (0.5, 3.0));
        let after = |discs: &[Disc]| {
            let mut arena = arena(walled(10.0, 0.95), discs, 0.05);
            let contacts = run(&mut arena, 10.0);
            let mut discs = states(&arena);
            discs.sort_by_key(|disc| disc.id);
            (contacts, discs)
        };
        let straight = after(&discs);
        assert!(straight.0.len() > 100);
        random.shuffle(&mut discs);
        assert_eq!(after(&discs), straight);
    }
}

#[test]
fn contacts_at_the_same_instant_are_resolved_together() {
    // A striker flies into the notch of two resting discs: mirror images stay mirror images.
    let y = 0.5 + 1e-3;
    let discs = [
        disc(1, [-3.0, 0.0], [1.0, 0.0], 0.5, 1.0),
        disc(2, [0.0, y], [0.0, 0.0], 0.5, 1.0),
        disc(3, [0.0, -y], [0.0, 0.0], 0.5, 1.0),
    ];
    for tick in [1e-3, 0.1, 5.0] {
        let mut arena = arena(Laws::FREE, &discs, tick);
        let contacts = run(&mut arena, 10.0);
        assert_eq!(contacts.len(), 2);
        assert_eq!(contacts[0].time, contacts[1].time);
        let after = states(&arena);
        assert!(after[0].velocity.x < -0.1 && after[0].velocity.y.abs() < 1e-15);
        let mirror = DVec2::new(after[1].velocity.x, -after[1].velocity.y);
        assert!(after[2].velocity.distance(mirror) < 1e-15);
        assert!(arena.relative_energy_drift().abs() < 1e-15);
    }
}

#[test]
fn a_rack_struck_in_the_middle_breaks_symmetrically() {
    // Ten touching discs in a triangle, struck head-on along its axis.
    let mut discs = vec![disc(0, [-4.0, 0.0], [2.0, 0.0], 0.5, 1.0)];
    for row in 0..4u32 {
        for k in 0..=row {
            let y = f64::from(k) - 0.5 * f64::from(row);
            let x = f64::from(row) * 0.75f64.sqrt() * (1.0 + 1e-15);
            discs.push(disc(discs.len() as u32, [x, y], [0.0, 0.0], 0.5, 1.0));
        }
    }
    let mut arena = arena(Laws::FREE, &discs, 1.0 / 60.0);
    run(&mut arena, 20.0);
    let after = states(&arena);
    assert!((energy(&after) - 2.0).abs() < 1e-14 && after[10].velocity.length() > 0.1);
    let mirrored = |d: &Disc| DVec2::new(d.position.x, -d.position.y);
    for d in &after {
        let twin = after.iter().map(|t| mirrored(t).distance(d.position)).fold(9.0, f64::min);
        assert!(twin < 1e-9, "{d:?} has no mirror image: {twin:e}");
    }
}

#[test]
fn discs_that_touch_or_overlap_at_the_start_collide_only_if_they_approach() {
    let pair = |x: f64, speed: f64| {
        [disc(1, [0.0; 2], [speed, 0.0], 0.5, 1.0), disc(2, [x, 0.0], [0.0; 2], 0.5, 1.0)]
    };
    for x in [1.0, 0.7, 1e-9] {
        assert!(run(&mut arena(Laws::FREE, &pair(x, 0.0), 0.1), 1.0).is_empty());
        let contacts = run(&mut arena(Laws::FREE, &pair(x, 1.0), 0.1), 1.0);
        assert_eq!((contacts.len(), contacts[0].time), (1, 0.0));
        assert!(run(&mut arena(Laws::FREE, &pair(x, -1.0), 0.1), 1.0).is_empty());
    }
    // Centres that coincide do not approach: they fly apart.
    assert!(run(&mut arena(Laws::FREE, &pair(0.0, 1.0), 0.1), 2.0).is_empty());
}

#[test]
fn robots_driven_against_each_other_and_a_wall_stay_apart() {
    let discs: Vec<Disc> =
        (0..8).map(|k| disc(k, [0.5 + 1.0 * f64::from(k), 1.0], [0.0; 2], 0.45, 1.0)).collect();
    let laws = Laws { contact_time: 1e-7, ..walled(9.0, 0.0) };
    let mut arena = arena(laws, &discs, 1e-3);
    let mut contacts = Vec::new();
    for tick in 1..=2_500 {
        discs.iter().for_each(|disc| arena.set_velocity(disc.id, DVec2::new(-1.0, 0.0)));
        arena.advance(f64::from(tick) * 1e-3, &mut contacts).expect("no stall");
    }
    for (k, disc) in states(&arena).iter().enumerate() {
        assert!((disc.position.x - (0.45 + 0.9 * k as f64)).abs() < 1e-6, "{disc:?}");
    }
    assert!(arena.largest_overlap() < 1e-12);
}

#[test]
fn a_fast_ball_does_not_pass_through_robots() {
    // A row of robots across the field, and balls of many speeds that fly over all of it in a tick.
    for speed in [3.0, 80.0, 1e3, 1e6, 1e9] {
        // Less room between two of them than the ball needs.
        let row = (0..48).map(|k| disc(k, [5.0, 0.1 + 0.185 * f64::from(k)], [0.0; 2], 0.09, 2.8));
        let ball = disc(99, [0.5, 2.97], [speed, 0.02 * speed], 0.0215, 0.046);
        let discs: Vec<Disc> = row.chain([ball]).collect();
        let mut twins = Twins::new(walled(9.0, 1.0), &discs, 0.01);
        let mut until = 0.0;
        while twins.found.len() < 5 {
            until += 0.3 / speed;
            twins.advance(until);
            let ball = states(&twins.ticks)[48];
            assert!(ball.position.x < 5.2, "passed at {speed} m/s");
        }
        twins.found.truncate(5);
        twins.due.truncate(5);
        for (a, b) in twins.found.iter().zip(&twins.due) {
            assert_eq!((a.a, a.b), (b.a, b.b), "at {speed} m/s");
            assert!((a.time - b.time).abs() < 1e-10 / speed);
        }
    }
}

#[test]
fn an_empty_arena_and_one_at_rest_have_no_contacts() {
    let mut empty = arena(Laws::FREE, &[], 0.01);
    assert!(run(&mut empty, 1.0).is_empty() && states(&empty).is_empty());
    assert_eq!((empty.now(), empty.kinetic_energy()), (1.0, 0.0));
    empty.set_velocity(1, DVec2::X);
    for laws in [walled(8.0, 1.0), periodic(8.0), Laws::FREE] {
        let mut discs = gas(1, 40, 8.0, (0.2, 0.4), (1.0, 1.0));
        discs.iter_mut().for_each(|disc| disc.velocity = DVec2::ZERO);
        let mut still = arena(laws, &discs, 0.1);
        assert!(run(&mut still, 10.0).is_empty());
        assert_eq!(states(&still), discs);
    }
}

#[test]
fn time_does_not_run_back_and_bad_times_are_no_time() {
    let mut arena = arena(walled(8.0, 1.0), &gas(1, 5, 8.0, (0.2, 0.4), (1.0, 1.0)), 0.1);
    run(&mut arena, 1.0);
    let before = states(&arena);
    for until in [0.5, 1.0, -1.0, f64::NAN, f64::NEG_INFINITY] {
        arena.advance(until, &mut Vec::new()).expect("nothing happens");
        assert_eq!((arena.now(), states(&arena)), (1.0, before.clone()));
    }
}

#[test]
fn what_ticks_cannot_do_is_refused() {
    for tick in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Ticks::new(Laws::FREE, &[], tick).expect_err("no tick");
        assert!(error.to_string().ends_with("must be a finite number above 0"), "{error}");
    }
    let falling = Laws { gravity: Some(DVec2::NEG_Y), ..Laws::FREE };
    assert_eq!(Ticks::new(falling, &[], 0.1).expect_err("gravity"), NotInTicks::Gravity);
}

#[test]
fn an_inelastic_collapse_ends() {
    let laws = Laws { restitution: 0.05, contact_time: 1e-6, ..Laws::FREE };
    let discs = [
        disc(1, [0.0, 0.0], [1.0, 0.0], 0.25, 1.0),
        disc(2, [1.5, 0.0], [0.0, 0.0], 0.25, 1.0),
        disc(3, [3.5, 0.0], [-1.0, 0.0], 0.25, 1.0),
    ];
    let mut arena = arena(laws, &discs, 0.1);
    assert!(run(&mut arena, 10.0).len() < 2_000);
    let speeds: Vec<f64> = states(&arena).iter().map(|d| d.velocity.x).collect();
    let spread = speeds.iter().fold(0.0f64, |s, v| s.max((v - speeds[0]).abs()));
    assert!(spread < 1e-8, "{speeds:?}");
}

#[test]
fn a_dense_cooling_gas_goes_on() {
    let discs = gas(10, 60, 8.0, (0.3, 0.4), (1.0, 1.0));
    let laws = Laws { contact_time: 1e-6, ..walled(8.0, 0.3) };
    let mut arena = arena(laws, &discs, 1.0 / 60.0);
    let contacts = run(&mut arena, 60.0).len();
    assert!((500..2_000_000).contains(&contacts), "{contacts}");
    assert!(arena.largest_overlap() < 1e-9, "{}", arena.largest_overlap());
}

#[test]
fn an_elastic_squeeze_without_end_is_a_stall_and_no_hang() {
    // A light disc between a wall and a piston that closes the gap at t = 3.
    let walls = Walls { min: DVec2::ZERO, max: DVec2::new(100.0, 4.0), restitution: 1.0 };
    let laws = Laws { walls: Some(walls), ..Laws::FREE };
    let discs = [
        disc(1, [1.0, 2.0], [1.0, 0.0], 0.5, 1.0),
        disc(2, [4.5, 2.0], [-1.0, 0.0], 0.5, f64::INFINITY),
    ];
    let mut arena = arena(laws, &discs, 0.1);
    let stall = loop {
        if let Err(stall) = arena.advance(10.0, &mut Vec::new()) {
            break stall;
        }
    };
    assert!((stall.time - 3.0).abs() < 1e-6, "{stall}");
    assert!(states(&arena).iter().all(|d| d.position.is_finite()));
}

#[test]
fn units_do_not_matter() {
    let discs = gas(31, 8, 6.0, (0.3, 0.5), (1.0, 2.0));
    let contacts = run(&mut arena(walled(6.0, 1.0), &discs, 0.1), 5.0);
    for (length, speed) in [(1e-150, 1e-150), (1e150, 1e100), (1e-100, 1e100), (1e80, 1e-80)] {
        // Powers of two: every digit stays.
        let [length, speed] = [length, speed].map(carom::exact::power_of_two_near);
        let scale = |d: &Disc| Disc {
            position: d.position * length,
            velocity: d.velocity * speed,
            radius: d.radius * length,
            ..*d
        };
        let scaled: Vec<Disc> = discs.iter().map(scale).collect();
        let laws = Laws { extreme_units: true, ..walled(6.0 * length, 1.0) };
        let mut arena = arena(laws, &scaled, 0.1 * length / speed);
        let pairs = run(&mut arena, 5.0 * length / speed);
        assert_eq!(pairs.len(), contacts.len());
        for (scaled, plain) in pairs.iter().zip(&contacts) {
            assert_eq!((scaled.a, scaled.b), (plain.a, plain.b));
            assert!((scaled.time * speed / length - plain.time).abs() < 1e-7);
        }
    }
}

#[test]
fn late_times_keep_their_digits() {
    // 4000 bounces of exactly representable length end exactly where they began, whatever the tick.
    for tick in [0.1, 1.0 / 3.0, 0.25] {
        let discs = [disc(1, [0.5, 0.375], [1.0, 1.0], 0.25, 1.0)];
        let mut arena = arena(walled(1.0, 1.0), &discs, tick);
        run(&mut arena, 1_000.0);
        assert_eq!(arena.contacts(), 4_000);
        assert!(states(&arena)[0].position.distance(discs[0].position) < 1e-12);
    }
    // A million ticks without a contact add no rounding.
    let discs = [disc(1, [0.0, 0.0], [0.1, 0.3], 0.25, 1.0)];
    let mut arena = arena(Laws::FREE, &discs, 1e-3);
    run(&mut arena, 1e3);
    assert!(states(&arena)[0].position.distance(DVec2::new(100.0, 300.0)) < 1e-13 * 300.0);
}

#[test]
fn golden_bits() {
    // The same in debug and release, with and without fused instructions, from run to run.
    let mut found = Vec::new();
    for laws in [walled(10.0, 0.9), periodic(10.0)] {
        let discs = gas(71, 50, 10.0, (0.2, 0.5), (0.5, 3.0));
        let mut arena = arena(laws, &discs, 1.0 / 60.0);
        let mut random = Random::new(71);
        for tick in 1..=120 {
            discs.iter().for_each(|disc| arena.set_velocity(disc.id, random.vector(3.0)));
            run(&mut arena, f64::from(tick) / 60.0);
        }
        let states = states(&arena);
        let numbers =
            states.iter().flat_map(|d| [d.position, d.velocity]).flat_map(|v| v.to_array());
        let bytes = numbers.flat_map(|x| x.to_bits().to_le_bytes());
        // FNV-1a.
        found.push(bytes.fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        }));
    }
    assert_eq!(found, [0xbe6d_5732_aae7_4dc9, 0x2453_f306_3996_c8a3], "{found:x?}");
}
