//! What a control tick costs: `cargo bench --bench ticks`.
//!
//! 22 robots and a ball between walls at 1 kHz, and 1000 driven pucks at 60 Hz, every velocity set
//! anew at every tick. The yardstick of the pucks is one broad phase: the touching pairs of the
//! same discs by the grid, in turns in the same run. The answer is checked first, against the plain
//! method fed with the same commands; a wrong one prints no time. Times are medians over blocks of
//! ticks; commands are drawn before the clock starts.

mod figures;

use std::hint::black_box;
use std::time::Instant;

use carom::detect::grid;
use carom::motion::plain::{Laws, Plain};
use carom::motion::ticks::Ticks;
use carom::world::{Contact, Disc, Owner, Walls};
use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use figures::median;

const BLOCKS: usize = 101;

fn main() {
    let (field, robots) = robots();
    let pucks = pucks(1_000, 0.3);
    let side = (1_000.0 * std::f64::consts::PI * 0.25 / 0.3f64).sqrt();
    let walls = Walls { min: DVec2::ZERO, max: DVec2::splat(side), restitution: 1.0 };
    let arena = Laws { walls: Some(walls), ..Laws::FREE };
    println!(
        "{:>28} {:>10} {:>12} {:>14} {:>14} {:>8}",
        "", "us a tick", "commands us", "broad phase us", "contacts/tick", "ratio"
    );
    let game = Scene { laws: field, discs: robots, tick: 1e-3, speed: 3.0, drive: Drive::Circles };
    game.check(1_500);
    game.measure("22 robots and a ball, 1 kHz", 200);
    let game = Scene { drive: Drive::Walk(0.01), ..game };
    game.check(1_500);
    game.measure("the same, pressed on walls", 200);
    let drive = Drive::Walk(1.0);
    let crowd = Scene { laws: arena, discs: pucks, tick: 1.0 / 60.0, speed: 1.0, drive };
    crowd.check(20);
    crowd.measure("1000 pucks, random, 60 Hz", 10);
    let crowd = Scene { drive: Drive::Circles, ..crowd };
    crowd.check(20);
    crowd.measure("the same, in circles", 10);
    let crowd = Scene { drive: Drive::Walk(0.05), ..crowd };
    crowd.check(20);
    crowd.measure("the same, pressed together", 10);
}

/// Discs whose velocities are set anew at every tick.
struct Scene {
    laws: Laws,
    discs: Vec<Disc>,
    /// s
    tick: f64,
    /// Largest component of a command, m/s.
    speed: f64,
    drive: Drive,
}

/// What the commands are like.
#[derive(Clone, Copy)]
enum Drive {
    /// Everyone round and round, at a rate of its own.
    Circles,
    /// A random walk, of which so much is new at a tick, 0 to 1. Nobody turns away from a wall or
    /// from others: in the end most are pressed on something, and have a contact at every tick.
    Walk(f64),
}

impl Scene {
    /// Commands, tick after tick.
    fn commands(&self) -> impl FnMut(&mut Vec<DVec2>) {
        let mut random = Random(Pcg64::seed_from_u64(7));
        let (speed, drive, tick) = (self.speed, self.drive, self.tick);
        let first = self.discs.iter().map(|_| (random.vector(), random.uniform() * 2.0 + 1.0));
        let mut wishes: Vec<(DVec2, f64)> = first.collect();
        move |commands| {
            for (wish, rate) in &mut wishes {
                *wish = match drive {
                    Drive::Circles => DVec2::from_angle(*rate * tick).rotate(*wish),
                    // It keeps its size.
                    Drive::Walk(new) => *wish * (1.0 - new * new).sqrt() + random.vector() * new,
                };
            }
            commands.clear();
            commands.extend(wishes.iter().map(|(wish, _)| *wish * speed));
        }
    }

    /// A wrong answer gets no time: the same contacts as the plain method, while rounding allows.
    fn check(&self, ticks: usize) {
        let mut arena = Ticks::new(self.laws, &self.discs, self.tick).expect("a tick");
        let mut judge = Plain::new(self.laws, &self.discs, 0.1);
        let (mut draw, mut commands) = (self.commands(), Vec::new());
        let (mut found, mut due) = (Vec::new(), Vec::new());
        for tick in 1..=ticks {
            draw(&mut commands);
            for (disc, velocity) in self.discs.iter().zip(&commands) {
                arena.set_velocity(disc.id, *velocity);
                judge.set_velocity(disc.id, *velocity);
            }
            let until = tick as f64 * self.tick;
            while arena.now() < until {
                arena.advance(until, &mut found).expect("no stall");
            }
            while judge.now() < until {
                judge.advance(until, &mut due).expect("no stall");
            }
        }
        assert!(due.len() > 20, "{} contacts", due.len());
        assert_eq!(found.len(), due.len());
        for (a, b) in found.iter().zip(&due) {
            assert_eq!((a.a, a.b), (b.a, b.b), "at {}", b.time);
            assert!((a.time - b.time).abs() < 1e-9);
        }
        let discs = arena.discs(Owner::Simulated).zip(judge.discs(Owner::Simulated));
        discs.for_each(|(a, b)| assert!(a.position.distance(b.position) < 1e-9));
        assert!(arena.relative_energy_drift().abs() < 1e-12);
    }

    /// Prints medians in microseconds: a whole tick, its commands alone, the yardstick.
    fn measure(&self, name: &str, ticks: usize) {
        let mut arena = Ticks::new(self.laws, &self.discs, self.tick).expect("a tick");
        let mut draw = self.commands();
        let mut commands: Vec<Vec<DVec2>> = vec![Vec::new(); ticks];
        let mut contacts: Vec<Contact> = Vec::new();
        let mut samples: [Vec<f64>; 3] = Default::default();
        let mut tick = 0;
        for _ in 0..BLOCKS {
            commands.iter_mut().for_each(&mut draw);
            let start = Instant::now();
            for commands in &commands {
                self.command(&mut arena, commands);
                tick += 1;
                contacts.clear();
                let until = tick as f64 * self.tick;
                arena.advance(until, black_box(&mut contacts)).expect("no stall");
            }
            samples[0].push(start.elapsed().as_secs_f64() * 1e6 / ticks as f64);
            let start = Instant::now();
            self.command(&mut arena, &commands[0]);
            samples[1].push(start.elapsed().as_secs_f64() * 1e6);
            let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
            let start = Instant::now();
            black_box(grid::touching_pairs(black_box(&discs), 0.0)).expect("few");
            samples[2].push(start.elapsed().as_secs_f64() * 1e6);
        }
        let rate = arena.contacts() as f64 / tick as f64;
        let [all, command, yardstick] = samples.map(median);
        let ratio = all / yardstick;
        println!(
            "{name:>28} {all:>10.2} {command:>12.2} {yardstick:>14.2} {rate:>14.2} {ratio:>8.2}"
        );
    }

    fn command(&self, arena: &mut Ticks, commands: &[DVec2]) {
        for (disc, velocity) in self.discs.iter().zip(commands) {
            arena.set_velocity(disc.id, *velocity);
        }
    }
}

struct Random(Pcg64);

impl Random {
    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec2 {
        DVec2::new(self.uniform(), self.uniform()) * 2.0 - 1.0
    }
}

/// Two teams of eleven and a ball on a field of 9 m by 6 m.
fn robots() -> (Laws, Vec<Disc>) {
    let walls = Walls { min: DVec2::ZERO, max: DVec2::new(9.0, 6.0), restitution: 0.8 };
    let laws = Laws { restitution: 0.8, walls: Some(walls), ..Laws::FREE };
    let mut random = Random(Pcg64::seed_from_u64(3));
    let mut discs: Vec<Disc> = Vec::new();
    while discs.len() < 23 {
        let (radius, mass) = if discs.len() < 22 { (0.09, 2.8) } else { (0.0215, 0.046) };
        let place = DVec2::new(random.uniform(), random.uniform());
        let position = radius + place * (walls.max - 2.0 * radius);
        if discs.iter().all(|disc| disc.position.distance(position) > disc.radius + radius) {
            let id = discs.len() as u32;
            discs.push(Disc { id, position, velocity: DVec2::ZERO, radius, mass });
        }
    }
    (laws, discs)
}

/// Discs of diameter 1 at random places without overlaps, at an area fraction in a square.
fn pucks(count: u32, area_fraction: f64) -> Vec<Disc> {
    let side = (f64::from(count) * std::f64::consts::FRAC_PI_4 / area_fraction).sqrt();
    let mut random = Random(Pcg64::seed_from_u64(5));
    let mut discs: Vec<Disc> = Vec::new();
    while (discs.len() as u32) < count {
        let place = DVec2::new(random.uniform(), random.uniform());
        let position = 0.5 + place * (side - 1.0);
        if discs.iter().all(|disc| disc.position.distance(position) > 1.0) {
            let id = discs.len() as u32;
            discs.push(Disc { id, position, velocity: DVec2::ZERO, radius: 0.5, mass: 1.0 });
        }
    }
    discs
}
