//! What a watcher tells of an arena gives the discs of the arena, bit for bit, whatever happens to
//! it between two looks.

use carom::motion::arena::Arena;
use carom::motion::watch::{Listener, Watcher};
use carom::plan::{Method, Plan};
use carom::world::{
    Command, Disc, Instants, Owner, Periodic, Report, Segment, Segments, Settings, World,
};
use glam::DVec2;

use crate::common::{Random, box_settings, disc, gas};

fn bits(discs: impl IntoIterator<Item = Disc>) -> Vec<(u32, [u64; 6])> {
    let numbers = |disc: &Disc| {
        let Disc { position, velocity, radius, mass, .. } = *disc;
        [position.x, position.y, velocity.x, velocity.y, radius, mass].map(f64::to_bits)
    };
    discs.into_iter().map(|disc| (disc.id, numbers(&disc))).collect()
}

/// Who watches, and who hears of it.
#[derive(Default)]
struct Pair(Watcher, Listener);

impl Pair {
    /// Looks; how many bytes that took.
    fn look(&mut self, world: &mut World) -> usize {
        let mut turns = Vec::new();
        let look = world.look(&mut self.0, &mut turns).unwrap();
        assert_eq!(look.turns(), turns.len());
        let bytes = look.bytes();
        let discs = world.arena().unwrap().discs(Owner::Simulated);
        assert_eq!(bits(self.1.hear(look, &turns)), bits(discs));
        bytes
    }
}

fn world(settings: Settings, discs: &[Disc]) -> World {
    World::new(settings, discs)
}

fn step(world: &mut World, commands: &[Command], to: f64) {
    let outcome = world.step(commands, Instants { heard_at: to, advance_to: to });
    assert!(outcome.stall.is_none());
}

/// Something done to the world, or nothing.
fn command(random: &mut Random, next: &mut u32) -> Option<Command> {
    let (id, place) = (random.below(60) as u32, random.vector(4.0) + 5.0);
    match random.below(12) {
        0 => {
            *next += 1;
            Some(Command::AddPuck(disc(*next, place.to_array(), [0.5, 0.1], 0.05, 2.0)))
        }
        1 => Some(Command::RemovePuck { id }),
        2 => Some(Command::PlacePuck { id, position: place, velocity: random.vector(1.0) }),
        3 => Some(Command::SetVelocity { id, velocity: random.vector(2.0) }),
        // The sign of a zero is told too.
        4 => Some(Command::SetVelocity { id, velocity: DVec2::new(-0.0, 0.0) }),
        5 => {
            let seen = disc(900, place.to_array(), [0.1, 0.0], 0.2, 1.0);
            Some(Command::Observe(Report { discs: vec![seen], time: 0.0 }))
        }
        _ => None,
    }
}

#[test]
fn looks_tell_the_discs_whatever_happens_to_them() {
    let periodic = Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(10.0) });
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let mut settings = box_settings(10.0, 0.9);
        if seed % 2 == 1 {
            (settings.walls, settings.periodic) = (None, periodic);
        }
        if seed % 4 == 2 {
            let (from, to) = (DVec2::new(3.0, -1.0), DVec2::new(7.0, 11.0));
            let bar = Segments::new(&[Segment { from, to }], 1.0).expect("a segment");
            settings.segments = Some(bar);
        }
        settings.method = Some(Method::Events);
        // Observed circles are forgotten between two looks.
        settings.stale_after = 0.2;
        let mut world = world(settings, &gas(seed, 60, 10.0, (0.1, 0.3), (0.5, 2.0)));
        let (mut pair, mut next) = (Pair::default(), 1_000);
        for k in 1..600 {
            let commands: Vec<Command> = command(&mut random, &mut next).into_iter().collect();
            step(&mut world, &commands, f64::from(k) * 0.05);
            pair.look(&mut world);
        }
    }
}

#[test]
fn discs_of_many_sizes_are_told_too() {
    for seed in 0..4 {
        let mut discs = gas(seed, 300, 20.0, (0.02, 0.02), (1.0, 1.0));
        discs.retain(|disc| disc.position.distance(DVec2::splat(10.0)) > 4.0);
        discs.push(disc(5_000, [10.0, 10.0], [1.0, 0.5], 3.0, 50.0));
        let mut settings = box_settings(20.0, 1.0);
        if seed % 2 == 1 {
            let periodic = Periodic { min: DVec2::ZERO, max: DVec2::splat(20.0) };
            (settings.walls, settings.periodic) = (None, Some(periodic));
        }
        settings.method = Some(Method::Events);
        let mut world = world(settings, &discs);
        assert!(matches!(world.arena(), Some(Arena::Events(events)) if events.levels() > 1));
        let mut pair = Pair::default();
        for k in 1..300 {
            step(&mut world, &[], f64::from(k) * 0.05);
            pair.look(&mut world);
        }
    }
}

#[test]
fn what_nobody_met_is_not_told_again() {
    let discs = gas(3, 1_000, 50.0, (0.2, 0.2), (1.0, 1.0));
    let settings = Settings { method: Some(Method::Events), ..box_settings(50.0, 1.0) };
    let (mut world, mut pair) = (world(settings, &discs), Pair::default());
    let all = pair.look(&mut world);
    assert_eq!(pair.look(&mut world), 0);
    let mut told = 0;
    for k in 1..=100 {
        step(&mut world, &[], f64::from(k) * 0.01);
        told += pair.look(&mut world);
    }
    assert!(told > 0 && told < 100 * all / 5, "{told} of {}", 100 * all);
}

#[test]
fn another_arena_and_other_methods_are_told_in_full() {
    let mut pair = Pair::default();
    for method in [Method::Events, Method::Plain, Method::Ticks, Method::Steps, Method::Springs] {
        for seed in [5, 6] {
            let discs = gas(seed, 20, 10.0, (0.3, 0.3), (1.0, 1.0));
            let settings = Settings { method: Some(method), ..box_settings(10.0, 1.0) };
            if let Err(why) = Plan::of(&settings, &discs).choose(Some(method), &settings, &discs) {
                panic!("{method}: {why}");
            }
            let mut world = world(settings, &discs);
            step(&mut world, &[], 0.5);
            assert!(pair.look(&mut world) > 0);
        }
    }
}
