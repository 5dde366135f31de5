//! Motion: exact solutions, conservation, symmetry, and a judge that is plainer still.

use carom::detect::impact::{pair_impact, wall_impact};
use carom::motion::plain::Laws;
use carom::resolve::{pair, wall};
use carom::world::{Disc, Partner, Settings, Walls};
use glam::DVec2;

use crate::common::{Random, arena, box_settings, disc, energy, gas, momentum, run, states};

fn dense_gas(seed: u64) -> Vec<Disc> {
    gas(seed, 20, 8.0, (0.3, 0.6), (0.5, 3.0))
}

/// Searches every pair and every wall for the next event, moves all discs there, and so on.
fn plainest(laws: &Laws, mut discs: Vec<Disc>, until: f64) -> Vec<(f64, u32, Partner)> {
    let (mut now, mut events) = (0.0, Vec::new());
    loop {
        let mut first = (f64::INFINITY, 0, None);
        for (i, a) in discs.iter().enumerate() {
            let walls = laws.walls.expect("a box");
            if let Some(hit) = wall_impact(a.position, a.velocity, a.radius, &walls)
                && hit.time < first.0
            {
                first = (hit.time, i, Some(Err(hit.side)));
            }
            for (j, b) in discs.iter().enumerate().skip(i + 1) {
                let (d, w) = (b.position - a.position, b.velocity - a.velocity);
                if let Some(t) = pair_impact(d, w, a.radius + b.radius)
                    && t < first.0
                {
                    first = (t, i, Some(Ok(j)));
                }
            }
        }
        let (wait, i, with) = first;
        now += wait;
        if now > until {
            return events;
        }
        discs.iter_mut().for_each(|disc| disc.position += disc.velocity * wait);
        match with.expect("an event") {
            Ok(j) => {
                let impact =
                    pair::collide(&discs[i], &discs[j], laws.restitution).expect("approach");
                (discs[i].velocity, discs[j].velocity) = (impact.velocity_a, impact.velocity_b);
                events.push((now, discs[i].id, Partner::Disc(discs[j].id)));
            }
            Err(side) => {
                let bounce = wall::bounce(&discs[i], side, 1.0).expect("outwards");
                discs[i].velocity = bounce.velocity;
                events.push((now, discs[i].id, Partner::Wall(side)));
            }
        }
    }
}

#[test]
fn events_are_those_of_the_plainest_search() {
    for seed in 0..10 {
        let (settings, discs) = (box_settings(8.0, 1.0), dense_gas(seed));
        let mut arena = arena(&settings, &discs);
        let contacts = run(&mut arena, 5.0);
        let laws = carom::plan::Plan::of(&settings, &discs).laws(&settings);
        let judge = plainest(&laws, discs, 5.0);
        assert!(judge.len() > 40, "{}", judge.len());
        assert_eq!(contacts.len(), judge.len());
        for (contact, (time, a, b)) in contacts.iter().zip(judge) {
            assert_eq!((contact.a, contact.b), (a, b), "at {time}");
            // Rounding grows by about a digit for every collision of a disc.
            assert!((contact.time - time).abs() < 1e-7);
        }
    }
}

#[test]
fn two_pucks_between_walls_follow_the_closed_form() {
    // Masses 1 and 3, the lighter at rest: the pair of velocities has period 3 pair contacts.
    let discs =
        [disc(1, [1.0, 1.0], [2.0, 0.0], 0.5, 1.0), disc(2, [4.0, 1.0], [0.0, 0.0], 0.5, 3.0)];
    let mut arena = arena(&box_settings(8.0, 1.0), &discs);
    let contacts = run(&mut arena, 3.0);
    assert_eq!(contacts[0].time, 1.0);
    assert_eq!((contacts[0].a, contacts[0].b), (1, Partner::Disc(2)));
    assert_eq!((contacts[0].point, contacts[0].normal), (DVec2::new(3.5, 1.0), DVec2::X));
    assert_eq!((contacts[0].approach_speed, contacts[0].impulse), (2.0, 3.0));
    let after: Vec<DVec2> = states(&arena).iter().map(|d| d.velocity).collect();
    assert_eq!(after, [DVec2::new(-1.0, 0.0), DVec2::new(1.0, 0.0)]);
    let positions: Vec<f64> = states(&arena).iter().map(|d| d.position.x).collect();
    assert_eq!(positions, [1.0, 6.0]);
}

#[test]
fn a_row_of_equal_discs_is_a_gas_of_points() {
    // Equal discs on a line exchange velocities: unfold the free points and sort (Tonks 1936).
    let (count, side, until) = (12, 40.0, 50.0);
    let mut random = Random::new(12);
    let mut discs = Vec::new();
    for id in 0..count {
        let x = 0.5 + 3.2 * f64::from(id) + random.uniform(0.0, 2.0);
        discs.push(disc(id, [x, 1.0], [random.uniform(-2.0, 2.0), 0.0], 0.5, 1.0));
    }
    let mut settings = box_settings(side, 1.0);
    settings.walls.as_mut().expect("a box").max.y = 2.0;
    let mut arena = arena(&settings, &discs);
    run(&mut arena, until);
    let free = side - f64::from(count);
    let point = |(id, d): (usize, &Disc)| {
        let x = d.position.x - 0.5 - id as f64 + d.velocity.x * until;
        let folded = x.rem_euclid(2.0 * free);
        folded.min(2.0 * free - folded)
    };
    let mut points: Vec<f64> = discs.iter().enumerate().map(point).collect();
    points.sort_by(f64::total_cmp);
    for (k, (d, x)) in states(&arena).iter().zip(points).enumerate() {
        assert!((d.position.x - (x + 0.5 + k as f64)).abs() < 1e-11, "disc {k}");
    }
}

#[test]
fn results_do_not_depend_on_the_frame_rate() {
    let (settings, discs) = (box_settings(8.0, 0.9), dense_gas(3));
    let mut once = arena(&settings, &discs);
    let whole = run(&mut once, 20.0);
    for frames in [7, 60, 1000] {
        let mut many = arena(&settings, &discs);
        let mut contacts = Vec::new();
        for k in 1..=20 * frames {
            contacts.extend(run(&mut many, f64::from(k) / f64::from(frames)));
            // Looking changes nothing.
            let _ = states(&many);
        }
        assert_eq!(contacts, whole, "{frames} frames a second");
        assert_eq!(states(&many), states(&once));
    }
}

#[test]
fn energy_and_momentum_are_kept_and_nothing_overlaps() {
    let discs = gas(5, 60, 12.0, (0.2, 0.5), (0.1, 10.0));
    let mut arena = arena(&box_settings(12.0, 1.0), &discs);
    for second in 1..=60 {
        run(&mut arena, f64::from(second));
        let now = states(&arena);
        for (k, a) in now.iter().enumerate() {
            for b in &now[k + 1..] {
                let gap = carom::detect::touching::gap(a, b);
                assert!(gap > -1e-12 * a.radius.min(b.radius), "{gap}");
            }
        }
    }
    assert!(arena.contacts() > 1_500);
    assert!(arena.relative_energy_drift().abs() < 1e-13);
    assert!((arena.kinetic_energy() - energy(&discs)).abs() < 1e-12 * energy(&discs));
    assert!(arena.largest_overlap() < 1e-12, "{}", arena.largest_overlap());
}

#[test]
fn momentum_is_kept_in_free_space() {
    let discs = gas(6, 40, 7.0, (0.2, 0.4), (0.1, 5.0));
    let mut arena = arena(&Settings::default(), &discs);
    let contacts = run(&mut arena, 100.0);
    assert!(contacts.len() > 20);
    assert!(momentum(&states(&arena)).distance(momentum(&discs)) < 1e-13);
}

#[test]
fn time_runs_back_to_the_start() {
    let discs = gas(7, 8, 6.0, (0.3, 0.5), (1.0, 2.0));
    let mut forth = arena(&box_settings(6.0, 1.0), &discs);
    assert!(run(&mut forth, 6.0).len() > 10);
    let turned: Vec<Disc> =
        states(&forth).iter().map(|d| Disc { velocity: -d.velocity, ..*d }).collect();
    let mut back = arena(&box_settings(6.0, 1.0), &turned);
    run(&mut back, 6.0);
    for (d, start) in states(&back).iter().zip(&discs) {
        assert!(d.position.distance(start.position) < 1e-8);
    }
}

#[test]
fn the_energy_account_knows_losses_and_commands() {
    let discs = dense_gas(9);
    let mut arena = arena(&box_settings(8.0, 0.8), &discs);
    run(&mut arena, 5.0);
    arena.set_velocity(3, DVec2::new(2.0, -1.0));
    run(&mut arena, 10.0);
    assert!(arena.kinetic_energy() < 0.8 * energy(&discs));
    assert!(arena.relative_energy_drift().abs() < 1e-13, "{:e}", arena.relative_energy_drift());
}

#[test]
fn a_moving_fixed_disc_does_work_that_is_accounted_for() {
    let discs = [
        disc(1, [1.0, 1.0], [0.5, 0.0], 0.5, 2.0),
        disc(2, [5.0, 1.0], [-1.0, 0.0], 0.5, f64::INFINITY),
    ];
    let mut arena = arena(&Settings::default(), &discs);
    assert_eq!(run(&mut arena, 4.0).len(), 1);
    assert_eq!(states(&arena)[0].velocity.x, -2.5);
    assert_eq!(arena.relative_energy_drift(), 0.0);
}

#[test]
fn an_inelastic_collapse_ends() {
    // Three equal discs, the outer two squeezing the middle one, far below the critical 0.0718.
    let settings = Settings { restitution: 0.05, ..Settings::default() };
    let discs = [
        disc(1, [0.0, 0.0], [1.0, 0.0], 0.25, 1.0),
        disc(2, [1.5, 0.0], [0.0, 0.0], 0.25, 1.0),
        disc(3, [3.5, 0.0], [-1.0, 0.0], 0.25, 1.0),
    ];
    let mut arena = arena(&settings, &discs);
    let contacts = run(&mut arena, 10.0);
    assert!(contacts.len() < 2_000);
    let speeds: Vec<f64> = states(&arena).iter().map(|d| d.velocity.x).collect();
    let spread = speeds.iter().fold(0.0f64, |s, v| s.max((v - speeds[0]).abs()));
    assert!(spread < 1e-8, "{speeds:?}");
}

#[test]
fn contacts_that_change_no_digit_are_no_collapse() {
    // Of a row that is all but touching the first three press on each other without end before the
    // next is met, each time half as fast.
    for gap in [1e-10, 1e-9, 1e-8, 1e-7] {
        let speed = |k: u32| if k == 0 { 1.0 } else { 0.0 };
        let place = |k: u32| f64::from(k) * (0.25 + gap);
        let discs: Vec<Disc> =
            (0..4).map(|k| disc(k + 1, [place(k), 0.0], [speed(k), 0.0], 0.125, 1.0)).collect();
        let mut arena = arena(&Settings { restitution: 0.0, ..Settings::default() }, &discs);
        run(&mut arena, 4.0);
        let speeds: Vec<f64> = states(&arena).iter().map(|disc| disc.velocity.x).collect();
        assert!(speeds.iter().all(|speed| (speed - 0.25).abs() < 1e-6), "{gap}: {speeds:?}");
    }
}

#[test]
fn a_dense_cooling_gas_goes_on() {
    let discs = gas(10, 60, 8.0, (0.3, 0.4), (1.0, 1.0));
    let mut arena = arena(&box_settings(8.0, 0.3), &discs);
    let mut contacts = 0;
    for second in 1..=60 {
        contacts += run(&mut arena, f64::from(second)).len();
    }
    println!("{contacts} contacts");
    assert!((500..2_000_000).contains(&contacts), "{contacts}");
    assert!(arena.largest_overlap() < 1e-9, "{}", arena.largest_overlap());
}

#[test]
fn an_elastic_squeeze_without_end_is_a_stall_and_no_hang() {
    // A light disc between a wall and a piston that closes the gap at t = 3.
    let walls = Walls { min: DVec2::ZERO, max: DVec2::new(100.0, 4.0), restitution: 1.0 };
    let settings = Settings { walls: Some(walls), ..Settings::default() };
    let discs = [
        disc(1, [1.0, 2.0], [1.0, 0.0], 0.5, 1.0),
        disc(2, [4.5, 2.0], [-1.0, 0.0], 0.5, f64::INFINITY),
    ];
    let mut arena = arena(&settings, &discs);
    let stall = loop {
        if let Err(stall) = arena.advance(10.0, &mut Vec::new()) {
            break stall;
        }
    };
    assert!((stall.time - 3.0).abs() < 1e-6, "{stall}");
    assert!(states(&arena).iter().all(|d| d.position.is_finite()));
}

#[test]
fn a_train_pressed_into_a_corner_comes_to_rest() {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(10.0), restitution: 0.0 };
    let settings = Settings { restitution: 0.0, walls: Some(walls), ..Settings::default() };
    let discs: Vec<Disc> =
        (0..6).map(|k| disc(k, [1.0 + f64::from(k) * 1.1, 0.5], [-1.0, -0.5], 0.5, 1.0)).collect();
    let mut arena = arena(&settings, &discs);
    assert!(run(&mut arena, 30.0).len() < 5_000);
    let speeds: Vec<f64> = states(&arena).iter().map(|d| d.velocity.length()).collect();
    assert!(speeds.iter().all(|speed| *speed < 1e-7), "{speeds:?}");
}

#[test]
fn discs_touching_at_the_start_collide_only_if_they_approach() {
    let resting = [disc(1, [0.0; 2], [0.0; 2], 0.5, 1.0), disc(2, [1.0, 0.0], [0.0; 2], 0.5, 1.0)];
    assert!(run(&mut arena(&Settings::default(), &resting), 10.0).is_empty());
    let mut struck = resting;
    struck[0].velocity.x = 1.0;
    let contacts = run(&mut arena(&Settings::default(), &struck), 10.0);
    assert_eq!((contacts.len(), contacts[0].time), (1, 0.0));
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
    let mut arena = arena(&Settings::default(), &discs);
    let contacts = run(&mut arena, 10.0);
    assert_eq!(contacts.len(), 2);
    assert_eq!(contacts[0].time, contacts[1].time);
    let after = states(&arena);
    assert!(after[0].velocity.x < -0.1 && after[0].velocity.y.abs() < 1e-15);
    let mirror = DVec2::new(after[1].velocity.x, -after[1].velocity.y);
    assert!(after[2].velocity.distance(mirror) < 1e-15);
    assert!(arena.relative_energy_drift().abs() < 1e-15);
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
    let mut arena = arena(&Settings::default(), &discs);
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
fn units_do_not_matter() {
    let discs = gas(31, 8, 6.0, (0.3, 0.5), (1.0, 2.0));
    let mut plain = arena(&box_settings(6.0, 1.0), &discs);
    let contacts = run(&mut plain, 5.0);
    for (length, speed) in [(1e-150, 1e-150), (1e150, 1e100), (1e-100, 1e100), (1e80, 1e-80)] {
        // Powers of two: every digit stays.
        let [length, speed] = [length, speed].map(carom::exact::power_of_two_near);
        let scaled: Vec<Disc> = discs
            .iter()
            .map(|d| Disc {
                position: d.position * length,
                velocity: d.velocity * speed,
                radius: d.radius * length,
                ..*d
            })
            .collect();
        let mut arena = arena(&box_settings(6.0 * length, 1.0), &scaled);
        let pairs = run(&mut arena, 5.0 * length / speed);
        assert_eq!(pairs.len(), contacts.len());
        for (scaled, plain) in pairs.iter().zip(&contacts) {
            assert_eq!((scaled.a, scaled.b), (plain.a, plain.b));
            assert!((scaled.time * speed / length - plain.time).abs() < 1e-7);
        }
    }
}

#[test]
fn fixed_discs_pass_through_each_other() {
    let discs = [
        disc(1, [0.0, 0.0], [1.0, 0.0], 0.5, f64::INFINITY),
        disc(2, [3.0, 0.0], [0.0, 0.0], 0.5, f64::INFINITY),
    ];
    let mut arena = arena(&Settings::default(), &discs);
    assert!(run(&mut arena, 10.0).is_empty());
    assert_eq!(states(&arena)[0].position.x, 10.0);
}

#[test]
fn slow_starts_do_not_switch_restitution_off() {
    for speed in [0.0, 1e-12, 1e-3] {
        let discs = [
            disc(1, [-1.0, 0.0], [speed, 0.0], 0.5, 1.0),
            disc(2, [1.0, 0.0], [-speed, 0.0], 0.5, 1.0),
        ];
        let settings = Settings { restitution: 0.5, ..Settings::default() };
        let mut arena = arena(&settings, &discs);
        for cycle in 0..200 {
            arena.set_velocity(1, DVec2::X);
            arena.set_velocity(2, DVec2::NEG_X);
            let met = run(&mut arena, 4.0 * f64::from(cycle) + 2.0);
            let loss: f64 = met.iter().map(|contact| contact.energy_loss).sum();
            assert!((loss - 0.75).abs() < 1e-12, "{speed} {cycle}: {loss}");
            arena.set_velocity(1, DVec2::NEG_X);
            arena.set_velocity(2, DVec2::X);
            run(&mut arena, 4.0 * f64::from(cycle) + 3.0);
            // Back to where they were, to the last digit or so.
            let gap = states(&arena)[1].position.x - states(&arena)[0].position.x;
            arena.set_velocity(1, DVec2::new(0.5 * gap - 1.0, 0.0));
            arena.set_velocity(2, DVec2::new(1.0 - 0.5 * gap, 0.0));
            run(&mut arena, 4.0 * f64::from(cycle) + 4.0);
        }
    }
}

#[test]
fn late_times_keep_their_digits() {
    // 10^6 bounces of exactly representable length end exactly where they began.
    let discs = [disc(1, [0.5, 0.375], [1.0, 1.0], 0.25, 1.0)];
    let mut arena = arena(&box_settings(1.0, 1.0), &discs);
    for second in 1..=250_000 {
        run(&mut arena, f64::from(second));
    }
    assert_eq!(arena.contacts(), 1_000_000);
    assert_eq!(states(&arena), discs);
}
