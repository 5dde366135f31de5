//! Driven pucks: limits, headings, time-outs, and the same bits at any publish rate.

use carom::world::{
    Command, Disc, Drive, Instants, Model, Owner, Pace, Settings, Walls, Wanted, World,
};
use glam::DVec2;

const TICK: f64 = 0.01;

fn settings() -> Settings {
    Settings { pace: Pace { tick: TICK, ..Pace::default() }, ..Settings::default() }
}

fn disc(id: u32, x: f64, velocity: DVec2) -> Disc {
    Disc { id, position: DVec2::new(x, 0.0), velocity, radius: 0.1, mass: 1.0 }
}

fn world(settings: Settings, discs: &[Disc], drive: Drive) -> World {
    let mut world = World::new(settings, discs);
    world.drive(1, drive);
    world
}

fn go(world: &mut World, commands: &[Command], to: f64) {
    let outcome = world.step(commands, Instants { heard_at: 0.0, advance_to: to });
    assert_eq!((outcome.stall, outcome.not_done), (None, vec![]));
}

fn command(x: f64, y: f64, angular: f64) -> Command {
    Command::Drive {
        id: 1,
        wanted: Wanted { linear: DVec2::new(x, y), angular, ..Wanted::default() },
    }
}

fn robot(world: &World) -> Disc {
    world.arena().unwrap().discs(Owner::Simulated).find(|disc| disc.id == 1).unwrap()
}

#[test]
fn a_drive_accelerates_no_faster_than_it_can() {
    let drive = Drive {
        model: Model::Holonomic,
        acceleration_max: 2.0,
        speed_max: 3.0,
        ..Drive::default()
    };
    let mut world = world(settings(), &[disc(1, 0.0, DVec2::ZERO)], drive);
    go(&mut world, &[command(0.0, 5.0, 0.0)], 1.0);
    assert!(
        (robot(&world).velocity - DVec2::new(0.0, 2.0)).length() < 1e-12,
        "{:?}",
        robot(&world)
    );
    // s = a t^2 / 2, less half a tick: the velocity changes at the ends of ticks.
    assert!((robot(&world).position.y - (1.0 - TICK)).abs() < TICK, "{:?}", robot(&world));
    go(&mut world, &[], 3.0);
    assert!((robot(&world).velocity - DVec2::new(0.0, 3.0)).length() < 1e-12);
    let drift = world.arena().unwrap().relative_energy_drift();
    assert!(drift.abs() < 1e-13, "the drive's work is no error: {drift}");
}

#[test]
fn two_wheels_go_round_in_a_circle() {
    let drive = Drive { model: Model::Differential, heading: 0.5, ..Drive::default() };
    let mut world = world(settings(), &[disc(1, 0.0, DVec2::ZERO)], drive);
    // The first tick sets it in motion; a turn takes 100 of them more.
    let turn = std::f64::consts::TAU / (100.0 * TICK);
    go(&mut world, &[command(1.0, 7.0, turn)], TICK);
    let start = robot(&world).position;
    let mut far = 0.0f64;
    for k in 1..=100 {
        go(&mut world, &[], TICK * (1.0 + f64::from(k)));
        far = far.max(robot(&world).position.distance(start));
    }
    assert!(robot(&world).position.distance(start) < 1e-9, "it comes back: {:?}", robot(&world));
    assert!((far - 2.0 / turn).abs() < 1e-3 / turn, "across: {far}, {}", 2.0 / turn);
    assert!((robot(&world).velocity.length() - 1.0).abs() < 1e-12, "never sideways");
    let heading = world.pose(1).unwrap().heading;
    assert!((heading - 0.5 - turn * TICK).abs() < 1e-9, "{heading}");
}

#[test]
fn a_command_is_over_after_the_timeout() {
    for model in [Model::Told, Model::Holonomic] {
        let settings = Settings { command_timeout: 0.3, ..settings() };
        let drive = Drive { model, ..Drive::default() };
        let mut world = world(settings, &[disc(1, 0.0, DVec2::ZERO)], drive);
        go(&mut world, &[command(1.0, 0.0, 0.0)], 0.295);
        assert_eq!(robot(&world).velocity, DVec2::X, "{model:?}");
        go(&mut world, &[command(1.0, 0.0, 0.0)], 0.59);
        assert_eq!(robot(&world).velocity, DVec2::X, "commanded again: {model:?}");
        go(&mut world, &[], 1.0);
        assert_eq!(robot(&world).velocity, DVec2::ZERO, "{model:?}");
        assert!(robot(&world).position.x < 0.62, "{model:?}: {:?}", robot(&world));
        world.set_command_timeout(0.0);
        go(&mut world, &[command(1.0, 0.0, 0.0)], 99.0);
        assert_eq!(robot(&world).velocity, DVec2::X, "for ever: {model:?}");
    }
}

#[test]
fn a_drive_makes_good_what_a_collision_took() {
    let drive = Drive { model: Model::Holonomic, acceleration_max: 5.0, ..Drive::default() };
    // They meet between two ticks, at 0.503 s.
    let discs = [disc(1, 0.0, DVec2::X), disc(2, 0.703, DVec2::ZERO)];
    let mut world = world(settings(), &discs, drive);
    go(&mut world, &[command(1.0, 0.0, 0.0)], 0.505);
    assert!(robot(&world).velocity.length() < 1e-12, "all went to the other: {:?}", robot(&world));
    go(&mut world, &[], 2.0);
    assert_eq!(robot(&world).velocity, DVec2::X);
}

#[test]
fn the_publish_rate_changes_no_bit() {
    let walls = Some(Walls { min: DVec2::splat(-2.0), max: DVec2::splat(2.0), restitution: 1.0 });
    let settings = Settings { walls, command_timeout: 1.5, ..settings() };
    let drive = Drive {
        model: Model::Differential,
        acceleration_max: 3.0,
        turn_acceleration_max: 9.0,
        ..Drive::default()
    };
    let discs: Vec<Disc> =
        (1..8).map(|k| disc(k, 0.45 * f64::from(k) - 1.8, DVec2::Y * f64::from(k))).collect();
    let run = |steps: u32| {
        let mut world = world(settings, &discs, drive);
        for k in 1..=steps {
            let commands: &[Command] = if k == 1 { &[command(2.0, 0.0, 3.0)] } else { &[] };
            go(&mut world, commands, 4.0 * f64::from(k) / f64::from(steps));
        }
        world.arena().unwrap().discs(Owner::Simulated).collect::<Vec<_>>()
    };
    let often = run(977);
    assert_eq!(run(3), often);
    assert!(often[0].velocity.length() < 1e-12, "nobody commands it any more: {:?}", often[0]);
}
