//! What the live report costs a step: `cargo bench --bench live --no-default-features`.
//!
//! The same scene is stepped twice, in turns, with the account that `error_report` needs and
//! without it: the momentum booked, the step's duration noted, and once a second of wall time the
//! report made, which is measured by itself and added. Both read the clock as the node does in any
//! case. Both must come to the same bits, or no time is told. At 1 kHz means steps of 1 ms; free
//! running (`--rate 0`) means steps from one arena state to the next, at 60 Hz.

mod figures;

use std::hint::black_box;
use std::time::Instant;

use carom::messages::Time;
use carom::publish::error_report::{Facts, Interval, Totals, diagnostics};
use carom::scene::Scene;
use carom::world::{Disc, Instants, Owner, World};

use figures::median;

/// Pairs of runs, blocks of each in turns, and how long about a block is, s; of all blocks the
/// median is told.
const PAIRS: usize = 10;
const BLOCKS: usize = 20;
const BLOCK_S: f64 = 0.005;

fn main() {
    println!(
        "{:<10} {:>8} {:>14} {:>10} {:>18} {:>12} {:>10}",
        "scene",
        "steps of",
        "ns, without",
        "account",
        "a report a second",
        "of the time",
        "together"
    );
    for name in ["arena", "thousand", "break_shot"] {
        for (label, step) in [("1 ms", 1e-3), ("1/60 s", 1.0 / 60.0)] {
            measure(name, label, step);
        }
    }
}

/// A world and what is known of its steps.
struct Run {
    start: Instant,
    world: World,
    interval: Option<Interval>,
    steps: u64,
}

impl Run {
    fn new(name: &str, with: bool) -> Self {
        let mut world = Scene::load(name).expect("shipped").world();
        if with {
            world.keep_account();
        }
        Self { start: Instant::now(), world, interval: with.then(Interval::default), steps: 0 }
    }

    /// Run time of so many steps, s, with the looks at the clock that the node takes.
    fn steps(&mut self, count: u64, step: f64) -> f64 {
        let start = Instant::now();
        for _ in 0..count {
            self.steps += 1;
            let until = self.steps as f64 * step;
            black_box(Instant::now());
            while self.world.arena().is_some_and(|arena| arena.now() < until) {
                let begin = Instant::now();
                let heard_at = (begin - self.start).as_secs_f64();
                let outcome = self.world.step(&[], Instants { heard_at, advance_to: until });
                let end = Instant::now();
                if let Some(interval) = &mut self.interval {
                    interval.durations.note(end - begin);
                }
                black_box(outcome);
            }
        }
        start.elapsed().as_secs_f64()
    }

    fn discs(&self) -> Vec<Disc> {
        self.world.arena().expect("pucks").discs(Owner::Simulated).collect()
    }

    /// Run time of one report, s.
    fn report(&mut self) -> f64 {
        let arena = self.world.arena().expect("pucks");
        let totals =
            Totals { simulated: arena.now(), contacts: arena.contacts(), ..Totals::default() };
        let interval = self.interval.as_mut().expect("an account");
        let start = Instant::now();
        let told = interval.end(totals, 1.0, &Facts::default(), Some(arena));
        black_box((diagnostics(&told, Time::default()), told));
        start.elapsed().as_secs_f64()
    }
}

fn measure(name: &str, label: &str, step: f64) {
    let (mut ratios, mut times, mut reports) = (Vec::new(), Vec::new(), Vec::new());
    for pair in 0..PAIRS {
        // Where things lie in memory counts: the one is built first as often as the other.
        let first = pair.is_multiple_of(2);
        let (one, other) = (Run::new(name, first), Run::new(name, !first));
        let (mut full, mut bare) = if first { (one, other) } else { (other, one) };
        let about = bare.steps(200, step) / 200.0;
        full.steps(200, step);
        let count = ((BLOCK_S / about) as u64).clamp(10, 100_000);
        for block in 0..BLOCKS {
            let first_full = block.is_multiple_of(2).then(|| full.steps(count, step));
            let without = bare.steps(count, step);
            let with = first_full.unwrap_or_else(|| full.steps(count, step));
            ratios.push(with / without);
            times.push(1e9 * without / count as f64);
        }
        assert_eq!(bare.discs(), full.discs(), "{name}: other bits");
        let arena = full.world.arena().expect("pucks");
        let drift = arena.momentum_drift().expect("an account");
        assert!(drift.length() < 1e-11, "{name}: {drift}");
        reports.extend((0..BLOCKS).map(|_| full.report()));
    }
    let report = median(reports);
    let (account, share) = (100.0 * (median(ratios) - 1.0), 100.0 * report);
    println!(
        "{name:<10} {label:>8} {:>14.0} {account:>+8.2} % {:>15.1} us {share:>10.4} % \
         {:>+8.2} %",
        median(times),
        1e6 * report,
        account + share
    );
}
