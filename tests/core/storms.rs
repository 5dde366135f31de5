//! Thousands of contacts at one instant: all of them happen, or the arena says that it stands.

use carom::bench::collision::arena;
use carom::motion::arena::Arena;
use carom::motion::events::Events;
use carom::plan::Method;
use carom::plan::budget::Way;
use carom::world::{Disc, Owner, Settings, Walls};
use glam::DVec2;

use crate::common::{box_settings, disc};
use crate::events::laws;

/// Pairs in rows, of which the two discs are so far apart and fly towards each other; the side of
/// their box, m.
fn pairs(rows: u32, gap: f64) -> (Vec<Disc>, f64) {
    let pair = |k: u32| {
        let (x, y) = (2.0 * f64::from(k % rows), f64::from(k / rows));
        let at = |x: f64| [x, 2.0 * y + 1.0];
        let left = disc(2 * k, at(x + 0.75 - 0.5 * gap), [0.5, 0.0], 0.25, 1.0);
        [left, disc(2 * k + 1, at(x + 1.25 + 0.5 * gap), [-0.5, 0.0], 0.25, 1.0)]
    };
    ((0..rows * rows).flat_map(pair).collect(), 2.0 * f64::from(rows))
}

/// Goes on to this time, if nothing stalls.
fn run(arena: &mut Arena, until: f64) -> Result<(), String> {
    let mut contacts = Vec::new();
    for _ in 0..100_000 {
        if arena.now() >= until {
            return Ok(());
        }
        arena.advance(until, &mut contacts).map_err(|stall| stall.to_string())?;
    }
    panic!("it neither stalls nor goes on");
}

#[test]
fn pairs_that_all_meet_at_one_instant_all_collide() {
    for gap in [0.0, 0.5] {
        let (discs, side) = pairs(68, gap);
        let settings = box_settings(side, 1.0);
        let mut arena = Events::new(laws(&settings, &discs), &discs);
        let mut contacts = Vec::new();
        while arena.now() < 2.0 {
            arena.advance(2.0, &mut contacts).expect("no stall");
        }
        // Then each meets one of the next pair, or a wall.
        let (meet, then) = (gap, gap + 1.0);
        let at = |time: f64| contacts.iter().filter(|c| (c.time - time).abs() < 1e-9).count();
        let pairs = discs.len() / 2;
        assert_eq!(at(meet), pairs, "gap {gap}");
        assert_eq!(at(then), pairs + 68, "gap {gap}");
        assert!(arena.largest_overlap() < 1e-12, "{}", arena.largest_overlap());
    }
}

/// Discs that have nothing to do with a storm elsewhere.
fn bystanders(count: u32, y: f64) -> impl Iterator<Item = Disc> {
    (0..count).map(move |k| disc(100 + k, [0.05 + 0.04 * f64::from(k), y], [0.0; 2], 0.015, 1.0))
}

#[test]
fn a_disc_without_a_way_out_stalls_every_exact_method_however_many_others_there_are() {
    for others in [0, 8, 60] {
        let press = disc(0, [1.0, 0.6], [0.0, -0.5], 0.1, f64::INFINITY);
        let victim = disc(1, [1.0, 0.1], [0.0, 0.0], 0.1, 1.0);
        let discs: Vec<Disc> = [press, victim].into_iter().chain(bystanders(others, 2.5)).collect();
        let settings = box_settings(3.0, 1.0);
        for method in [Method::Events, Method::Plain, Method::Ticks] {
            let mut arena = arena(Way::Exact(method), &settings, &discs).expect("suits");
            let outcome = run(&mut arena, 3.0);
            assert!(outcome.is_err(), "{method}, {others} others: {:?}", arena.now());
            assert!((arena.now() - 0.6).abs() < 1e-6, "{method}: {}", arena.now());
        }
    }
}

#[test]
fn a_heavy_disc_that_falls_on_a_light_one_lets_nobody_through_the_floor() {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(3.0), restitution: 0.9 };
    let gravity = Some(DVec2::new(0.0, -5.0));
    let settings = Settings { walls: Some(walls), gravity, ..Settings::default() };
    let light = disc(0, [1.0, 0.1], [0.0, 0.0], 0.1, 0.001);
    let heavy = disc(1, [1.001, 0.5], [0.0, -0.5], 0.1, 1.0);
    let discs: Vec<Disc> = [light, heavy].into_iter().chain(bystanders(60, 2.5)).collect();
    let mut arena = arena(Way::Exact(Method::Events), &settings, &discs).expect("suits");
    let outcome = run(&mut arena, 1.5);
    let inside = |disc: Disc| disc.position.y > disc.radius - 1e-9;
    assert!(arena.discs(Owner::Simulated).all(inside), "{outcome:?}");
}
