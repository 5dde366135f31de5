//! The world: who owns what, and what one step answers.

use carom::world::{Command, Disc, Instants, Outcome, Refusal, Report, Settings, World};
use glam::DVec2;

use crate::common::disc;

fn observe(discs: &[Disc]) -> Command {
    Command::Observe(Report { discs: discs.to_vec(), time: 42.0 })
}

fn step(world: &mut World, commands: &[Command], time: f64) -> Outcome {
    world.step(commands, Instants { heard_at: time, advance_to: time })
}

fn pair() -> [Disc; 2] {
    [disc(1, [0.0; 2], [1.0, 0.0], 0.5, 1.0), disc(2, [1.0, 0.0], [-1.0, 0.0], 0.5, 1.0)]
}

#[test]
fn a_report_is_answered_and_the_same_report_gets_the_same_answer() {
    let mut world = World::new(Settings::default(), &[]);
    let first = step(&mut world, &[observe(&pair())], 0.0);
    assert_eq!(first.answers[0].velocities, [(1, DVec2::NEG_X), (2, DVec2::X)]);
    assert_eq!(first.answers[0].contacts[0].time, 42.0);
    assert_eq!(step(&mut world, &[observe(&pair())], 0.1), first);
}

#[test]
fn circles_of_several_reporters_meet() {
    let mut world = World::new(Settings::default(), &[]);
    let [a, b] = pair();
    assert!(step(&mut world, &[observe(&[a])], 0.0).answers[0].contacts.is_empty());
    let answer = &step(&mut world, &[observe(&[b])], 0.1).answers[0];
    assert_eq!(answer.velocities, [(1, DVec2::NEG_X), (2, DVec2::X)]);
    // A third reporter far away is not told of a contact that is not its own.
    let far = disc(3, [50.0, 0.0], [0.0; 2], 0.5, 1.0);
    assert!(step(&mut world, &[observe(&[far])], 0.2).answers[0].contacts.is_empty());
}

#[test]
fn stale_circles_leave() {
    let mut world = World::new(Settings::default(), &[]);
    let [a, b] = pair();
    step(&mut world, &[observe(&[a])], 0.0);
    assert_eq!(step(&mut world, &[observe(&[b])], 0.5).answers[0].contacts.len(), 1);
    assert!(step(&mut world, &[observe(&[b])], 0.51).answers[0].contacts.is_empty());
    assert_eq!(world.observed_count(), 1);
    step(&mut world, &[], 2.0);
    assert_eq!(world.observed_count(), 0);
}

#[test]
fn many_circles_use_the_grid_and_keep_their_ids() {
    let mut world = World::new(Settings::default(), &[]);
    let discs: Vec<Disc> = (0..400u32)
        .flat_map(|k| {
            let y = 3.0 * f64::from(k);
            let (mut a, mut b) = (pair()[0], pair()[1]);
            (a.id, b.id) = (1000 - 2 * k, 1001 - 2 * k);
            (a.position.y, b.position.y) = (y, y);
            [a, b]
        })
        .collect();
    let outcome = step(&mut world, &[observe(&discs)], 0.0);
    let answer = &outcome.answers[0];
    assert_eq!((answer.contacts.len(), answer.velocities.len()), (400, 800));
    assert!(answer.velocities.is_sorted_by_key(|(id, _)| *id));
}

#[test]
fn observed_circles_are_never_moved_but_meet_pucks() {
    let puck = disc(100, [0.0; 2], [1.0, 0.0], 0.5, 1.0);
    let mut world = World::new(Settings::default(), &[puck]);
    let guard = disc(7, [3.0, 0.0], [0.0; 2], 0.5, 3.0);
    let mut time = 0.0;
    let mut corrections = Vec::new();
    while time < 4.0 {
        time += 0.1;
        let outcome = step(&mut world, &[observe(&[guard])], time);
        assert!(outcome.answers[0].contacts.is_empty());
        corrections.extend(outcome.corrections);
    }
    assert_eq!(corrections, [(7, DVec2::new(0.5, 0.0))]);
    let arena = world.arena().expect("one puck");
    let pucks: Vec<Disc> = arena.discs(carom::world::Owner::Simulated).collect();
    assert_eq!((pucks[0].id, pucks[0].velocity), (100, DVec2::new(-0.5, 0.0)));
    assert_eq!(pucks.len(), 1);
    assert!((pucks[0].position.x - 1.0).abs() < 1e-12);
    assert_eq!(arena.relative_energy_drift(), 0.0);
}

#[test]
fn stale_circles_leave_the_arena_too() {
    let puck = disc(100, [0.0; 2], [1.0, 0.0], 0.5, 1.0);
    let mut world = World::new(Settings::default(), &[puck]);
    step(&mut world, &[observe(&[disc(7, [3.0, 0.0], [0.0; 2], 0.5, 3.0)])], 0.0);
    step(&mut world, &[], 0.6);
    assert!(step(&mut world, &[], 10.0).contacts.is_empty());
}

#[test]
fn many_circles_going_stale_at_once_hold_nobody_up() {
    let pucks: Vec<Disc> =
        (0..50).map(|k| disc(k, [3.0 * f64::from(k), 0.0], [0.1, 0.0], 0.5, 1.0)).collect();
    let mut world = World::new(Settings::default(), &pucks);
    let crowd: Vec<Disc> = (0..2_000)
        .map(|k| disc(1_000 + k, [3.0 * f64::from(k), 50.0], [0.0; 2], 0.5, 1.0))
        .collect();
    let start = std::time::Instant::now();
    step(&mut world, &[observe(&crowd)], 0.0);
    step(&mut world, &[], 1.0);
    assert_eq!(world.observed_count(), 0);
    assert!(start.elapsed().as_secs_f64() < 2.0, "{:?}", start.elapsed());
}

#[test]
fn extreme_but_finite_input_gives_finite_answers() {
    let mut random = crate::common::Random::new(41);
    let sizes: [f64; 9] = [0.0, 1.0, -1.0, 1e-60, 1e60, -1e60, 5e-324, 1e30, -1e-30];
    for round in 0..2_000 {
        let mut pick = || sizes[random.below(sizes.len())];
        let discs: Vec<Disc> = (0..5)
            .map(|id| {
                let (radius, mass) = (pick().abs().max(1e-60), pick().abs().max(1e-60));
                disc(id, [pick(), pick()], [pick(), pick()], radius, mass)
            })
            .collect();
        assert!(discs.iter().all(|disc| disc.refusal().is_none()));
        let mut world = World::new(Settings::default(), &[]);
        for answer in step(&mut world, &[observe(&discs)], 0.0).answers {
            assert!(answer.velocities.iter().all(|(_, v)| v.is_finite()), "{round}: {discs:?}");
            for c in answer.contacts {
                let numbers = [c.gap, c.approach_speed, c.impulse, c.energy_loss, c.point.x];
                assert!(numbers.iter().all(|x| x.is_finite()), "{round}: {c:?} {discs:?}");
            }
        }
    }
}

#[test]
fn the_id_of_a_puck_is_refused() {
    let puck = disc(1, [50.0, 0.0], [0.0; 2], 0.5, 1.0);
    let mut world = World::new(Settings::default(), &[puck]);
    let answer = &step(&mut world, &[observe(&pair())], 0.0).answers[0];
    assert_eq!(answer.refused, [(1, Refusal::Simulated)]);
    assert!(answer.contacts.is_empty());
}

#[test]
fn a_circle_too_wide_for_a_periodic_box_is_refused() {
    let periodic = Some(carom::world::Periodic { min: DVec2::ZERO, max: DVec2::splat(20.0) });
    let puck = disc(1, [5.0, 5.0], [0.0; 2], 0.5, 1.0);
    let mut world = World::new(Settings { periodic, ..Settings::default() }, &[puck]);
    let wide = disc(7, [15.0, 15.0], [0.0; 2], 1.5, 1.0);
    let narrow = disc(8, [15.0, 15.0], [0.0; 2], 1.3, 1.0);
    let answer = &step(&mut world, &[observe(&[wide, narrow])], 0.0).answers[0];
    assert_eq!(answer.refused, [(7, Refusal::TooWide)]);
    assert_eq!(world.observed_count(), 1);
}

#[test]
fn commands_set_velocities() {
    let puck = disc(5, [0.0; 2], [0.0; 2], 0.5, 1.0);
    let mut world = World::new(Settings::default(), &[puck]);
    step(&mut world, &[], 1.0);
    let command = Command::SetVelocity { id: 5, velocity: DVec2::new(2.0, 1.0) };
    // A command takes effect at the instant that the arena has reached.
    step(&mut world, &[command], 1.5);
    let arena = world.arena().expect("one puck");
    let puck = arena.discs(carom::world::Owner::Simulated).next().expect("one puck");
    assert_eq!(puck.position, DVec2::new(1.0, 0.5));
    // An unknown puck changes nothing.
    step(&mut world, &[Command::SetVelocity { id: 9, velocity: DVec2::X }], 1.6);
}
