//! What a step of fixed length costs, a disc: `cargo bench --bench steps`.
//!
//! A gas of equal discs with a diameter of 1 m and velocities of 1 m/s a component, at 240 steps a
//! second, melted before the clock starts. The answer is checked first, and a wrong one prints no
//! time: the same bits as the plain form of the method after some hundred steps, then the energy of
//! the timed run and the rate of its contacts against kinetic theory. Times are medians of blocks.
//! `-- N` measures N discs instead of 1000, 10 000 and 100 000.

use std::time::Instant;

use carom::motion::plain::Laws;
use carom::motion::springs::{self, Ending, Scheme, Springs};
use carom::motion::steps::plain::PlainSteps;
use carom::motion::steps::{Stepping, Steps};
use carom::plan::BroadPhase;
use carom::scene::lattice::Lattice;
use carom::world::{Disc, Owner, Periodic, Walls};
use glam::DVec2;

const STEP: f64 = 1.0 / 240.0;
const BLOCKS: usize = 15;

fn main() {
    let counts: Vec<usize> =
        std::env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let counts = if counts.is_empty() { vec![1_000, 10_000, 100_000] } else { counts };
    println!(
        "{:>8} {:>5} {:>9} {:>7} {:>14} {:>8} {:>15} {:>9} {:>8} {:>10}",
        "discs",
        "phi",
        "boundary",
        "missed",
        "ns/disc-step",
        "least",
        "contacts/step",
        "late",
        "missed",
        "drift"
    );
    for &count in &counts {
        for area_fraction in [0.3, 0.6] {
            for (walled, count_missed) in [(true, false), (true, true), (false, false)] {
                Gas::new(count, area_fraction, walled, count_missed).measure();
            }
        }
    }
    println!("\nsprings of {STIFFNESS} N/m");
    println!("{:>8} {:>5} {:>14} {:>8} {:>10}", "discs", "phi", "ns/disc-step", "least", "drift");
    for count in counts.into_iter().filter(|count| *count <= 10_000) {
        for area_fraction in [0.3, 0.6] {
            measure_springs(&Gas::new(count, area_fraction, true, false));
        }
    }
}

/// Of a contact, N/m: one lasts for five steps.
const STIFFNESS: f64 = 1e4;

fn measure_springs(gas: &Gas) {
    let Gas { laws, discs, area_fraction, .. } = gas;
    let ending = Ending::NoAttraction;
    let laws = springs::Laws { stiffness: STIFFNESS, damping: 0.0, ending, walls: laws.walls };
    let (scheme, broad_phase) = (Scheme::ClosedForm, BroadPhase::Grid);
    let stepping = springs::Stepping { step: STEP, scheme, refuse_unstable: true, broad_phase };
    let count = discs.len() as f64;
    let steps = (200_000.0 / count).ceil();
    let mut arena = Springs::new(laws, discs, stepping).expect("sound");
    let mut contacts = Vec::new();
    arena.advance(1.0, &mut contacts).expect("few pairs");
    let mut times: Vec<f64> = (0..BLOCKS)
        .map(|_| {
            let (start, until) = (Instant::now(), arena.now() + steps * STEP);
            arena.advance(until + 1e-9, &mut contacts).expect("few pairs");
            start.elapsed().as_secs_f64() * 1e9 / (steps * count)
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let drift = arena.relative_energy_drift();
    assert!(drift.abs() < 1e-2, "{drift:e}");
    println!(
        "{count:>8} {area_fraction:>5} {:>14.1} {:>8.1} {drift:>+10.1e}",
        times[BLOCKS / 2],
        times[0]
    );
}

struct Gas {
    laws: Laws,
    discs: Vec<Disc>,
    stepping: Stepping,
    area_fraction: f64,
}

impl Gas {
    fn new(count: usize, area_fraction: f64, walled: bool, count_missed: bool) -> Self {
        let lattice =
            Lattice { count, area_fraction, size_ratio: 1.0, mass_max: 1.0, walled, seed: 1 };
        let (discs, side) = lattice.discs().expect("a gas that fits");
        let (min, max) = (DVec2::ZERO, DVec2::splat(side));
        let walls = walled.then_some(Walls { min, max, restitution: 1.0 });
        let periodic = (!walled).then_some(Periodic { min, max });
        let stepping = Stepping { count_missed, ..Stepping::of(STEP) };
        Self { laws: Laws { walls, periodic, ..Laws::FREE }, discs, stepping, area_fraction }
    }

    fn arena(&self) -> Steps {
        Steps::new(self.laws, &self.discs, self.stepping).expect("a step")
    }

    /// The same bits as the plain form.
    fn check(&self) {
        let steps = if self.discs.len() <= 1_000 { 500.0 } else { 100.0 };
        if self.discs.len() > 20_000 || (self.laws.periodic.is_some() && self.discs.len() > 2_000) {
            return;
        }
        let mut arena = self.arena();
        let grid = BroadPhase::Grid;
        let mut judge =
            PlainSteps::new(self.laws, &self.discs, self.stepping, grid).expect("a step");
        let (mut found, mut due) = (Vec::new(), Vec::new());
        arena.advance(steps * STEP, &mut found).expect("few pairs");
        judge.advance(steps * STEP, &mut due).expect("few pairs");
        assert!(!due.is_empty());
        assert!(found == due, "contacts differ");
        assert!(arena.discs(Owner::Simulated).eq(judge.discs()), "states differ");
        assert_eq!(arena.unseen(), judge.unseen());
    }

    fn measure(&self) {
        self.check();
        let mut arena = self.arena();
        let count = self.discs.len() as f64;
        advance(&mut arena, (4_000_000.0 / count).clamp(100.0, 2_000.0));
        let steps = (4_000_000.0 / count).ceil();
        let (began, contacts, late, missed) =
            (arena.now(), arena.contacts(), arena.unseen().late, unseen(&arena));
        let mut times: Vec<f64> = (0..BLOCKS)
            .map(|_| {
                let start = Instant::now();
                advance(&mut arena, steps);
                start.elapsed().as_secs_f64() * 1e9 / (steps * count)
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let contacts = (arena.contacts() - contacts) as f64;
        let rate = 2.0 * contacts / (count * (arena.now() - began));
        let expected = if self.area_fraction < 0.5 { 2.4 } else { 11.4 };
        assert!((rate / expected - 1.0).abs() < 0.15, "{rate} contacts a disc and second");
        let drift = arena.relative_energy_drift();
        assert!(drift.abs() < 1e-12, "{drift:e}");
        let boundary = if self.laws.walls.is_some() { "walls" } else { "periodic" };
        let share = |unseen: u64, before: u64| 100.0 * (unseen - before) as f64 / contacts;
        println!(
            "{count:>8} {:>5} {boundary:>9} {:>7} {:>14.2} {:>8.2} {:>15.1} {:>7.1} % {:>7.4} % \
             {drift:>+10.1e}",
            self.area_fraction,
            if self.stepping.count_missed { "counted" } else { "-" },
            times[BLOCKS / 2],
            times[0],
            contacts / (steps * BLOCKS as f64),
            share(arena.unseen().late, late),
            share(unseen(&arena), missed),
        );
    }
}

/// Contacts that were never resolved.
fn unseen(arena: &Steps) -> u64 {
    arena.unseen().missed + arena.unseen().too_late
}

fn advance(arena: &mut Steps, steps: f64) {
    let until = arena.now() + steps * STEP;
    // Half a step more, or rounding may leave the last one out.
    while arena.now() < until {
        arena.pass(until + 1e-9).expect("few pairs");
    }
}
