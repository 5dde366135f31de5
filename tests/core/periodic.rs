//! The periodic box: conservation, all images judged by brute force, long flights.

use carom::detect::impact::pair_impact;
use carom::motion::plain::Plain;
use carom::plan::Plan;
use carom::resolve::pair;
use carom::world::{Contact, Disc, Owner, Partner, Periodic, Settings};
use glam::DVec2;

use crate::common::{disc, energy, gas, momentum};

fn settings(side: f64) -> Settings {
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(side) });
    Settings { periodic, ..Settings::default() }
}

fn run(settings: &Settings, discs: &[Disc], until: f64) -> (Plain, Vec<Contact>) {
    let plan = Plan::of(settings, discs);
    let mut arena = Plain::new(plan.laws(settings), discs, plan.epoch);
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    (arena, contacts)
}

fn states(arena: &Plain) -> Vec<Disc> {
    arena.discs(Owner::Simulated).collect()
}

/// Searches every pair in all 3x3 images, never further than a quarter of a box at a time.
fn replicated(mut discs: Vec<Disc>, side: f64, until: f64) -> Vec<(f64, u32, u32)> {
    let (mut now, mut events) = (0.0, Vec::new());
    while now < until {
        let fastest = discs.iter().map(|d| d.velocity.length()).fold(0.0, f64::max);
        let mut first = (0.25 * side / fastest, None);
        for i in 0..discs.len() {
            for j in i + 1..discs.len() {
                for image in 0..9 {
                    let shift =
                        side * DVec2::new(f64::from(image % 3 - 1), f64::from(image / 3 - 1));
                    let d = discs[j].position + shift - discs[i].position;
                    let w = discs[j].velocity - discs[i].velocity;
                    let reach = discs[i].radius + discs[j].radius;
                    if let Some(t) = pair_impact(d, w, reach)
                        && t < first.0
                    {
                        first = (t, Some((i, j, shift)));
                    }
                }
            }
        }
        now += first.0;
        for d in &mut discs {
            d.position += d.velocity * first.0;
            if first.1.is_none() {
                d.position = d.position.rem_euclid(DVec2::splat(side));
            }
        }
        if let Some((i, j, shift)) = first.1.filter(|_| now <= until) {
            let b = Disc { position: discs[j].position + shift, ..discs[j] };
            let impact = pair::collide(&discs[i], &b, 1.0).expect("approach");
            (discs[i].velocity, discs[j].velocity) = (impact.velocity_a, impact.velocity_b);
            discs.iter_mut().for_each(|d| d.position = d.position.rem_euclid(DVec2::splat(side)));
            events.push((now, discs[i].id, discs[j].id));
        }
    }
    events
}

#[test]
fn events_are_those_of_all_images() {
    for seed in 0..20 {
        let count = 2 + 2 * (seed as usize % 5);
        let discs = gas(seed, count, 3.0, (0.2, 0.4), (0.5, 3.0));
        let (_, contacts) = run(&settings(3.0), &discs, 4.0);
        let judge = replicated(discs, 3.0, 4.0);
        assert_eq!(contacts.len(), judge.len(), "seed {seed}");
        // Rounding grows with every collision; later ones may be others.
        for (contact, (time, a, b)) in contacts.iter().zip(judge).take(25) {
            assert_eq!((contact.a, contact.b), (a, Partner::Disc(b)), "seed {seed} at {time}");
            assert!((contact.time - time).abs() < 1e-6);
        }
    }
}

#[test]
fn momentum_and_energy_are_kept_and_all_stay_inside() {
    let discs = gas(2, 60, 10.0, (0.2, 0.5), (0.1, 10.0));
    let (arena, contacts) = run(&settings(10.0), &discs, 60.0);
    assert!(contacts.len() > 1_000);
    let now = states(&arena);
    assert!(momentum(&now).distance(momentum(&discs)) < 1e-12);
    assert!((energy(&now) - energy(&discs)).abs() < 1e-12 * energy(&discs));
    assert!(arena.largest_overlap() < 1e-12, "{}", arena.largest_overlap());
    assert!(now.iter().all(|d| d.position.cmpge(DVec2::ZERO).all()));
    assert!(now.iter().all(|d| d.position.cmple(DVec2::splat(10.0)).all()));
}

#[test]
fn the_order_of_discs_does_not_matter() {
    let discs = gas(8, 12, 5.0, (0.3, 0.4), (1.0, 2.0));
    let turned: Vec<Disc> = discs.iter().rev().copied().collect();
    let (_, a) = run(&settings(5.0), &discs, 3.0);
    let (_, b) = run(&settings(5.0), &turned, 3.0);
    assert!(a.len() > 10 && a.len() == b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!((a.a, a.b), (b.a, b.b));
        assert!((a.time - b.time).abs() < 1e-9);
    }
}

#[test]
fn a_fast_disc_flies_many_boxes_to_a_fixed_one() {
    // It climbs 1/64 of a box each time round, and meets the fixed disc at last.
    let discs = [
        disc(1, [0.5, 0.5], [64.0, 1.0], 0.25, 1.0),
        disc(2, [0.5, 8.0], [0.0; 2], 0.25, f64::INFINITY),
    ];
    let (arena, contacts) = run(&settings(16.0), &discs, 8.0);
    // Rows: y = 0.5 + t at x = 0.5 + 64 t (mod 16): every 0.25 s; reach 0.5 about y = 8.
    assert_eq!(contacts.len(), 1);
    assert!((contacts[0].time - 7.0).abs() < 0.26, "{}", contacts[0].time);
    assert!((states(&arena)[0].velocity.length() - 64.0f64.hypot(1.0)).abs() < 1e-12);
}

#[test]
fn a_fast_disc_among_fixed_ones_finds_what_all_images_show() {
    let mut discs = vec![disc(1, [0.1, 0.2], [7.0, 3.1], 0.1, 1.0)];
    for (k, place) in [[1.5, 1.5], [3.2, 0.6], [2.4, 3.3]].into_iter().enumerate() {
        discs.push(disc(k as u32 + 2, place, [0.0; 2], 0.1, f64::INFINITY));
    }
    let (_, contacts) = run(&settings(4.0), &discs, 10.0);
    let judge = replicated(discs, 4.0, 10.0);
    assert!(judge.len() > 3);
    for (contact, (time, _, b)) in contacts.iter().zip(judge).take(6) {
        assert_eq!(contact.b, Partner::Disc(b));
        assert!((contact.time - time).abs() < 1e-6);
    }
}
