//! Gravity: parabolas, rest on walls, work in the account, and a judge that steps in time.

use carom::detect::falling::{Approach, falling_pair_impact};
use carom::world::{Partner, Settings, Walls};
use glam::DVec2;

use crate::common::{Random, arena, box_settings, disc, gas, run, states};

fn tilted(side: f64, restitution: f64, gravity: [f64; 2]) -> Settings {
    Settings { gravity: Some(DVec2::from_array(gravity)), ..box_settings(side, restitution) }
}

#[test]
fn a_throw_is_a_parabola() {
    let settings = Settings { gravity: Some(DVec2::new(0.5, -2.0)), ..Settings::default() };
    let mut arena = arena(&settings, &[disc(1, [0.0; 2], [1.0, 3.0], 0.5, 2.0)]);
    assert!(run(&mut arena, 2.0).is_empty());
    let thrown = states(&arena)[0];
    assert_eq!(thrown.position, DVec2::new(3.0, 2.0));
    assert_eq!(thrown.velocity, DVec2::new(2.0, -1.0));
    assert!(arena.relative_energy_drift().abs() < 1e-15);
}

#[test]
fn a_falling_box_sees_the_same_collisions() {
    // Without walls gravity is a change of frame: times are unchanged, places fall.
    let discs = gas(6, 20, 6.0, (0.3, 0.4), (0.5, 2.0));
    let mut still = arena(&Settings::default(), &discs);
    let gravity = Settings { gravity: Some(DVec2::new(0.0, -9.81)), ..Settings::default() };
    let mut falling = arena(&gravity, &discs);
    let (a, b) = (run(&mut still, 3.0), run(&mut falling, 3.0));
    assert!(a.len() > 5 && a.len() == b.len(), "{} {}", a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!((a.a, a.b), (b.a, b.b));
        assert!((a.time - b.time).abs() < 1e-9);
    }
}

#[test]
fn energy_with_the_work_of_gravity_is_kept() {
    for gravity in [[0.0, -9.81], [3.0, 0.5]] {
        let mut arena = arena(&tilted(8.0, 1.0, gravity), &gas(4, 20, 8.0, (0.3, 0.6), (0.5, 3.0)));
        assert!(run(&mut arena, 30.0).len() > 1000);
        assert!(arena.relative_energy_drift().abs() < 1e-12, "{}", arena.relative_energy_drift());
        assert!(arena.largest_overlap() < 1e-12);
    }
}

#[test]
fn a_disc_comes_to_rest_in_a_corner_and_stays() {
    let settings = tilted(10.0, 0.5, [-1.0, -9.81]);
    let mut arena = arena(&settings, &[disc(1, [5.0, 5.0], [2.0, 1.0], 0.5, 1.0)]);
    assert!(run(&mut arena, 60.0).len() < 200);
    assert!(run(&mut arena, 1e6).is_empty());
    let resting = states(&arena)[0];
    assert_eq!((resting.position, resting.velocity), (DVec2::splat(0.5), DVec2::ZERO));
    assert!(arena.relative_energy_drift().abs() < 1e-13);
}

#[test]
fn nearly_elastic_floors_end_in_rest_too() {
    for restitution in [0.0, 0.9, 0.99, 0.999] {
        let settings = tilted(10.0, restitution, [0.0, -9.81]);
        let mut arena = arena(&settings, &[disc(1, [5.0, 0.6], [0.3, 0.0], 0.5, 1.0)]);
        let contacts = run(&mut arena, 1000.0);
        assert!(contacts.len() < 30_000, "{restitution}: {}", contacts.len());
        assert_eq!(states(&arena)[0].velocity.y, 0.0, "{restitution}");
        // Friction there is none: it slides on.
        assert!(restitution == 0.0 || states(&arena)[0].velocity.x != 0.0);
    }
}

#[test]
fn an_elastic_ball_never_rests() {
    let mut arena =
        arena(&tilted(10.0, 1.0, [0.0, -2.0]), &[disc(1, [5.0, 1.5], [0.0; 2], 0.5, 1.0)]);
    let contacts = run(&mut arena, 1000.0);
    assert_eq!(contacts.len(), 500);
    for (k, contact) in contacts.iter().enumerate() {
        assert!((contact.time - (2.0 * k as f64 + 1.0)).abs() < 1e-9, "{k}");
    }
}

#[test]
fn a_disc_falls_on_a_resting_one_and_on_a_fixed_one() {
    for mass in [1.0, f64::INFINITY] {
        let y = if mass.is_finite() { 0.5 } else { 3.0 };
        let discs =
            [disc(1, [5.0, y], [0.0; 2], 0.5, mass), disc(2, [5.0, y + 2.0], [0.0; 2], 0.5, 1.0)];
        let mut arena = arena(&tilted(10.0, 0.5, [0.0, -2.0]), &discs);
        let contacts = run(&mut arena, 1.2);
        assert_eq!(contacts[0].b, Partner::Disc(2));
        assert!((contacts[0].time - 1.0).abs() < 1e-15, "{}", contacts[0].time);
        assert!((contacts[0].approach_speed - 2.0).abs() < 1e-15);
    }
}

#[test]
fn a_disc_balanced_on_a_post_goes_on() {
    for restitution in [0.0, 0.5] {
        let discs = [
            disc(1, [5.0, 3.0], [0.0; 2], 0.5, f64::INFINITY),
            disc(2, [5.0, 4.5], [0.0; 2], 0.5, 1.0),
        ];
        let mut arena = arena(&tilted(10.0, restitution, [0.0, -9.81]), &discs);
        run(&mut arena, 1.5);
        let place = states(&arena)[1].position;
        assert!(place.distance(DVec2::new(5.0, 4.0)) < 1e-6, "{place}");
        assert!(arena.largest_overlap() < 1e-8, "{}", arena.largest_overlap());
    }
}

/// The first time of contact by steps far below any time of the scene.
fn stepped(d: DVec2, w: DVec2, a: DVec2, s: f64) -> Option<f64> {
    let gap = |t: f64| (d + w * t + 0.5 * a * t * t).length() - s;
    let step = 1e-4;
    let hit = (1..200_000).map(|k| f64::from(k) * step).find(|&t| gap(t) <= 0.0)?;
    let (mut low, mut high) = (hit - step, hit);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if gap(middle) > 0.0 { low = middle } else { high = middle }
    }
    Some(high)
}

#[test]
fn parabolas_hit_when_small_steps_say_so() {
    let mut random = Random::new(1);
    let mut hits = 0;
    for _ in 0..300 {
        let mut vector =
            |size: f64| DVec2::new(random.uniform(-size, size), random.uniform(-size, size));
        let (d, w, a) = (vector(4.0), vector(3.0), vector(2.0));
        if d.length() < 1.0 {
            continue;
        }
        let ours = falling_pair_impact(d, w, a, 1.0, 0.0);
        match (ours, stepped(d, w, a, 1.0)) {
            (Some(Approach::At(ours)), Some(time)) => {
                hits += 1;
                assert!((ours - time).abs() < 1e-9 * time.max(1.0), "{ours} {time}");
            }
            (Some(Approach::At(ours)), None) => {
                // Grazing for less than a step, or later than the steps go.
                let deepest = (d + w * ours + 0.5 * a * ours * ours).length();
                assert!((deepest - 1.0).abs() < 1e-9);
            }
            (None, None) => {}
            other => panic!("{other:?}"),
        }
    }
    assert!(hits > 30, "{hits}");
}

#[test]
fn a_resting_disc_is_woken() {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(10.0), restitution: 0.5 };
    let gravity = Some(DVec2::new(0.0, -1.0));
    let settings = Settings { walls: Some(walls), gravity, ..Settings::default() };
    let mut arena = arena(&settings, &[disc(1, [5.0, 0.5], [0.0; 2], 0.5, 1.0)]);
    assert!(run(&mut arena, 1.0).is_empty());
    arena.set_velocity(1, DVec2::new(0.0, 1.0));
    let contacts = run(&mut arena, 100.0);
    assert!((contacts[0].time - 3.0).abs() < 1e-15);
    assert_eq!(states(&arena)[0].velocity, DVec2::ZERO);
    assert!(arena.relative_energy_drift().abs() < 1e-14);
}
