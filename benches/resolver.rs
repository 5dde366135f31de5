//! How long one message takes: `cargo bench --bench resolver`.
//!
//! Circles at area fraction 0.3, thrown at random, so that many overlap: detection and resolution
//! through `World::step`, as the node does it. The answer is checked first: pairs against all
//! pairs, velocities against the conservation laws; a wrong answer prints no time. Times are
//! medians; the yardstick, a bare impulse loop over the listed pairs, runs in between, and beside
//! it `resolve::listed`, the law of the exact methods over the same list.

use std::hint::black_box;
use std::time::Instant;

use carom::detect::{all_pairs, grid};
use carom::resolve;
use carom::world::{Command, Disc, Instants, Report, Settings, World};
use glam::DVec2;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

const REPEATS: usize = 301;

fn main() {
    println!(
        "{:>8} {:>8} {:>12} {:>12} {:>12} {:>12} {:>12} {:>12}",
        "circles",
        "pairs",
        "all pairs us",
        "grid us",
        "resolve us",
        "message us",
        "listed us",
        "bare us"
    );
    for count in [10, 30, 48, 100, 300, 1_000, 3_000, 10_000] {
        let discs = scene(count, 0.3, 1);
        check(&discs);
        let pairs = grid::touching_pairs(&discs, 0.0).expect("few");
        let repeats = (REPEATS * 1_000 / count.max(300)).max(21);
        let times = measure(&discs, &pairs, repeats);
        print!("{count:>8} {:>8}", pairs.len());
        times.iter().for_each(|time| print!(" {time:>12.2}"));
        println!();
    }
}

/// Random discs of diameter 1 at an area fraction, without regard to overlaps.
fn scene(count: usize, area_fraction: f64, seed: u64) -> Vec<Disc> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut uniform = move || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let side = (count as f64 * std::f64::consts::FRAC_PI_4 / area_fraction).sqrt();
    (0..count as u32)
        .map(|id| Disc {
            id,
            position: DVec2::new(uniform(), uniform()) * side,
            velocity: DVec2::new(uniform(), uniform()) * 2.0 - 1.0,
            radius: 0.5,
            mass: 1.0,
        })
        .collect()
}

/// A wrong answer gets no time.
fn check(discs: &[Disc]) {
    let pairs = all_pairs::touching_pairs(discs, 0.0).expect("few");
    assert_eq!(grid::touching_pairs(discs, 0.0).expect("few"), pairs);
    let mut after = discs.to_vec();
    resolve::touching::resolve(&mut after, &pairs, 1.0, 0.0);
    let energy = |discs: &[Disc]| discs.iter().map(Disc::kinetic_energy).sum::<f64>();
    let momentum = |discs: &[Disc]| discs.iter().map(|disc| disc.velocity).sum::<DVec2>();
    assert!((energy(&after) / energy(discs) - 1.0).abs() < 1e-12);
    assert!((momentum(&after) - momentum(discs)).length() < 1e-9);
    for &(i, j) in &pairs {
        assert!(resolve::pair::collide(&after[i], &after[j], 1.0).is_none(), "still approaching");
    }
    let (mut listed, mut one_by_one) = (discs.to_vec(), discs.to_vec());
    let count = resolve::listed::resolve(&mut listed, &pairs, 1.0);
    let impacts = pairs.iter().filter(|&&(i, j)| {
        let impact = resolve::pair::collide(&one_by_one[i], &one_by_one[j], 1.0);
        if let Some(impact) = impact {
            one_by_one[i].velocity = impact.velocity_a;
            one_by_one[j].velocity = impact.velocity_b;
        }
        impact.is_some()
    });
    assert_eq!(impacts.count(), count);
    for (a, b) in listed.iter().zip(&one_by_one) {
        assert!((a.velocity - b.velocity).length() < 1e-12, "another law");
    }
}

/// Medians in microseconds: all pairs, grid, resolve, the whole message, the list, the bare loop.
fn measure(discs: &[Disc], pairs: &[(usize, usize)], repeats: usize) -> [f64; 6] {
    let mut world = World::new(Settings::default(), &[]);
    let command = [Command::Observe(Report { discs: discs.to_vec(), time: 0.0 })];
    let instants = Instants { heard_at: 0.0, advance_to: 0.0 };
    let mut samples = [(); 6].map(|()| Vec::with_capacity(repeats));
    for _ in 0..repeats {
        samples[0].push(time(|| all_pairs::touching_pairs(discs, 0.0)));
        samples[1].push(time(|| grid::touching_pairs(discs, 0.0)));
        let mut scratch = discs.to_vec();
        samples[2].push(time(|| resolve::touching::resolve(&mut scratch, pairs, 1.0, 0.0)));
        samples[3].push(time(|| world.step(&command, instants)));
        let mut scratch = discs.to_vec();
        samples[4].push(time(|| resolve::listed::resolve(&mut scratch, pairs, 1.0)));
        let mut scratch = discs.to_vec();
        samples[5].push(time(|| bare(&mut scratch, pairs)));
    }
    samples.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

/// Microseconds of one call.
fn time<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64() * 1e6
}

/// The yardstick: one plain impulse for each listed pair, equal masses.
fn bare(discs: &mut [Disc], pairs: &[(usize, usize)]) {
    for &(i, j) in pairs {
        let d = discs[j].position - discs[i].position;
        let approach = (discs[j].velocity - discs[i].velocity).dot(d);
        if approach < 0.0 {
            let impulse = d * (approach / d.length_squared());
            discs[i].velocity += impulse;
            discs[j].velocity -= impulse;
        }
    }
}
