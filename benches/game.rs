//! What a game of robot soccer costs: `cargo bench --bench game`.
//!
//! The scene `ssl-a`, 22 robots and a ball at 1 kHz, run free: of each team one robot runs for the
//! ball, dribbles and kicks it, the others run about, commands 60 times a second; once with its
//! goals and once without, and once with all robots at rest. A game whose energy is not accounted
//! for, or that has an overlap, gets no time. Commands are drawn before the clock starts.

use std::time::Instant;

use carom::scene::Scene;
use carom::world::{Command, Disc, Frame, Instants, Owner, Settings, Wanted, World};
use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

const SECONDS: u32 = 60;
const PERIODS: u32 = 60;

fn main() {
    let scene = Scene::load("ssl-a").expect("shipped");
    println!(
        "{:>16} {:>12} {:>16} {:>14} {:>12} {:>10}",
        "", "us a tick", "slowest period", "contacts/tick", "real time x", "% of core"
    );
    run("a game", &scene, true);
    let open = Settings { segments: None, ..scene.settings };
    run("without goals", &Scene { settings: open, ..scene.clone() }, true);
    run("at rest", &scene, false);
}

fn run(name: &str, scene: &Scene, plays: bool) {
    let mut world = scene.world();
    let mut players = Players::new(scene);
    let (mut spent, mut slowest) = (0.0, 0.0f64);
    for period in 1..=SECONDS * PERIODS {
        let commands = if plays { players.command(&world) } else { Vec::new() };
        let until = f64::from(period) / f64::from(PERIODS);
        let instants = Instants { heard_at: 0.0, advance_to: until };
        let start = Instant::now();
        let mut outcome = world.step(&commands, instants);
        while world.arena().expect("pucks").now() < until && outcome.stall.is_none() {
            outcome = world.step(&[], instants);
        }
        let took = start.elapsed().as_secs_f64();
        assert_eq!(outcome.stall, None);
        (spent, slowest) = (spent + took, slowest.max(took));
    }
    let arena = world.arena().expect("pucks");
    assert!(arena.relative_energy_drift().abs() < 1e-12 && arena.largest_overlap() < 1e-12);
    let ticks = f64::from(SECONDS) / scene.settings.pace.tick;
    println!(
        "{name:>16} {:>12.2} {:>13.0} us {:>14.2} {:>12.0} {:>10.2}",
        spent / ticks * 1e6,
        slowest * 1e6,
        arena.contacts() as f64 / ticks,
        f64::from(SECONDS) / spent,
        100.0 * spent / f64::from(SECONDS),
    );
}

/// The robots of both teams, and where each of them wants to go.
struct Players {
    random: Pcg64,
    teams: [Vec<(u32, DVec2)>; 2],
    ball: u32,
}

impl Players {
    fn new(scene: &Scene) -> Self {
        let ball = scene.pucks.iter().find(|puck| puck.ball.is_some()).expect("a ball").disc.id;
        let teams = [0, 1].map(|team| {
            let of_team = scene
                .pucks
                .iter()
                .filter(|puck| puck.member.is_some_and(|member| member.team as u8 == team));
            of_team.map(|puck| (puck.disc.id, puck.disc.position)).collect()
        });
        Self { random: Pcg64::seed_from_u64(22), teams, ball }
    }

    fn uniform(&mut self) -> f64 {
        (self.random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn vector(&mut self, size: f64) -> DVec2 {
        (DVec2::new(self.uniform(), self.uniform()) * 2.0 - 1.0) * size
    }

    fn command(&mut self, world: &World) -> Vec<Command> {
        let discs: Vec<Disc> = world.arena().expect("pucks").discs(Owner::Simulated).collect();
        let place = |id: u32| discs.iter().find(|disc| disc.id == id).expect("there").position;
        let ball = place(self.ball);
        let mut commands = Vec::new();
        if (ball.x.abs() > 6.0 && ball.y.abs() > 1.0) || ball.y.abs() > 4.5 {
            let (position, velocity) = (self.vector(4.0), self.vector(1.0));
            commands.push(Command::PlacePuck { id: self.ball, position, velocity });
        }
        for team in 0..2 {
            let mut robots = std::mem::take(&mut self.teams[team]);
            robots.sort_by(|a, b| place(a.0).distance(ball).total_cmp(&place(b.0).distance(ball)));
            for (k, (id, target)) in robots.iter_mut().enumerate() {
                if self.uniform() < 1.0 / 90.0 {
                    *target = self.vector(4.0);
                }
                let (id, own) = (*id, place(*id));
                let to = if k == 0 { ball } else { *target };
                let heading = DVec2::from_angle(world.pose(id).expect("a robot").heading);
                let linear = (to - own).clamp_length_max(1.0) * 3.0;
                let angular = 5.0 * heading.angle_to(ball - own);
                let wanted = Wanted { linear, angular, frame: Frame::Arena };
                commands.push(Command::Drive { id, wanted });
                commands.push(Command::Dribble { id, on: k == 0 });
                if k == 0 && self.uniform() < 0.25 {
                    let speed = 1.0 + 5.5 * self.uniform();
                    commands.push(Command::Kick { id, speed });
                }
            }
            self.teams[team] = robots;
        }
        commands
    }
}
