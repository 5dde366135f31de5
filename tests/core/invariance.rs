//! What must not change the physics: names, mirrors, frames of reference, the build.

use carom::motion::plain::Plain;
use carom::plan::Plan;
use carom::scene::Scene;
use carom::world::{Contact, Disc, Instants, Owner, Settings, Walls};
use glam::DVec2;

use crate::common::{Random, gas};

/// A gas in a box centred on the origin, so that mirror images are exact.
fn centred(seed: u64) -> (Settings, Vec<Disc>) {
    let walls = Walls { min: DVec2::splat(-4.0), max: DVec2::splat(4.0), restitution: 0.9 };
    let settings = Settings { walls: Some(walls), restitution: 0.95, ..Settings::default() };
    let mut discs = gas(seed, 20, 8.0, (0.3, 0.6), (0.5, 3.0));
    discs.iter_mut().for_each(|disc| disc.position -= DVec2::splat(4.0));
    (settings, discs)
}

fn run(settings: &Settings, discs: &[Disc], until: f64) -> (Vec<Contact>, Vec<Disc>) {
    let plan = Plan::of(settings, discs);
    let mut arena = Plain::new(plan.laws(settings), discs, plan.epoch);
    let mut contacts = Vec::new();
    while arena.now() < until {
        arena.advance(until, &mut contacts).expect("no stall");
    }
    let mut discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
    discs.sort_by_key(|disc| disc.id);
    (contacts, discs)
}

#[test]
fn the_order_of_the_discs_changes_no_bit() {
    let mut random = Random::new(51);
    for seed in 0..5 {
        let (settings, mut discs) = centred(seed);
        let straight = run(&settings, &discs, 20.0);
        assert!(straight.0.len() > 100);
        random.shuffle(&mut discs);
        assert_eq!(run(&settings, &discs, 20.0), straight);
    }
}

#[test]
fn mirror_images_stay_mirror_images_to_the_last_bit() {
    for seed in 0..5 {
        let (settings, discs) = centred(seed);
        let mirror = |v: DVec2| DVec2::new(-v.x, v.y);
        let image = |disc: &Disc| Disc {
            position: mirror(disc.position),
            velocity: mirror(disc.velocity),
            ..*disc
        };
        let images: Vec<Disc> = discs.iter().map(image).collect();
        let (contacts, after) = run(&settings, &discs, 20.0);
        let (mirrored, after_mirrored) = run(&settings, &images, 20.0);
        assert_eq!(after.iter().map(image).collect::<Vec<_>>(), after_mirrored);
        for (a, b) in contacts.iter().zip(&mirrored) {
            assert_eq!((a.time, a.impulse, mirror(a.normal)), (b.time, b.impulse, b.normal));
        }
    }
}

#[test]
fn a_moving_frame_sees_the_same_collisions() {
    let discs = gas(61, 12, 5.0, (0.3, 0.5), (0.5, 2.0));
    let (contacts, after) = run(&Settings::default(), &discs, 3.0);
    assert!(contacts.len() > 5);
    for frame in [DVec2::new(1.0, -2.0), DVec2::new(30.0, 7.0)] {
        let boosted: Vec<Disc> =
            discs.iter().map(|disc| Disc { velocity: disc.velocity + frame, ..*disc }).collect();
        let (seen, ended) = run(&Settings::default(), &boosted, 3.0);
        assert_eq!(seen.len(), contacts.len());
        for (a, b) in seen.iter().zip(&contacts) {
            assert_eq!((a.a, a.b), (b.a, b.b));
            assert!((a.time - b.time).abs() < 1e-10);
        }
        for (a, b) in ended.iter().zip(&after) {
            assert!((a.position - 3.0 * frame).distance(b.position) < 1e-10);
        }
    }
}

#[test]
fn a_turned_scene_turns_its_result() {
    let discs = gas(62, 12, 5.0, (0.3, 0.5), (0.5, 2.0));
    let (contacts, after) = run(&Settings::default(), &discs, 3.0);
    for angle in [0.3, 1.0, std::f64::consts::FRAC_PI_2] {
        let turn = DVec2::from_angle(angle);
        let turned: Vec<Disc> = discs
            .iter()
            .map(|disc| Disc {
                position: turn.rotate(disc.position),
                velocity: turn.rotate(disc.velocity),
                ..*disc
            })
            .collect();
        let (seen, ended) = run(&Settings::default(), &turned, 3.0);
        assert_eq!(seen.len(), contacts.len());
        for (a, b) in ended.iter().zip(&after) {
            assert!(a.position.distance(turn.rotate(b.position)) < 1e-10);
        }
    }
}

/// FNV-1a over the bits of all positions and velocities.
fn fingerprint(discs: impl Iterator<Item = Disc>) -> u64 {
    let numbers = discs.flat_map(|d| [d.position.x, d.position.y, d.velocity.x, d.velocity.y]);
    numbers.flat_map(|x| x.to_bits().to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn golden_bits() {
    // The same in debug and release, with and without fused instructions, from run to run. A change
    // of a formula may change them: then look at `carom check` first, and copy the new numbers
    // from this test's message.
    let golden = [
        ("arena", 0x4e0a34d20820c77a),
        ("break_shot", 0xae06b9a14da65998),
        ("newtons_cradle", 0x21efc044ae5d5a02),
        ("head_on", 0x799a1d1d639e1345),
        ("teams", 0x6ee143a812b90987),
        ("thousand", 0xe956245b65b70e8e),
    ];
    let found: Vec<(&str, u64)> = golden
        .iter()
        .map(|&(name, _)| {
            let mut world = Scene::load(name).expect("shipped").world();
            while world.arena().expect("pucks").now() < 10.0 {
                let outcome = world.step(&[], Instants { heard_at: 0.0, advance_to: 10.0 });
                assert_eq!(outcome.stall, None);
            }
            (name, fingerprint(world.arena().expect("pucks").discs(Owner::Simulated)))
        })
        .collect();
    assert_eq!(found, golden);
}
