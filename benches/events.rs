//! scratch
use carom::motion::events::Events;
use carom::motion::plain::Laws;
use carom::world::{Disc, Periodic};
use glam::DVec2;
use std::time::Instant;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let n: usize = args[0].parse().unwrap();
    let phi: f64 = args[1].parse().unwrap();
    let k: u64 = args[2].parse().unwrap();
    // triangular lattice fitted
    let area = n as f64 * std::f64::consts::FRAC_PI_4 / phi;
    let l = area.sqrt();
    let mut cols = (l / (area / n as f64 * 2.0 / 3f64.sqrt()).sqrt()).round() as usize;
    let mut rows = n.div_ceil(cols);
    if rows % 2 == 1 {
        rows += 1;
    }
    while cols * rows < n {
        cols += 1;
    }
    let mut s = 88172645463325252u64;
    let mut rnd = || {
        s ^= s << 13;
        s ^= s >> 7;
        s ^= s << 17;
        (s >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut discs: Vec<Disc> = (0..n)
        .map(|i| {
            let (c, r) = (i % cols, i / cols);
            let x = (c as f64 + 0.25 + 0.5 * (r % 2) as f64) * l / cols as f64;
            let y = (r as f64 + 0.5) * l / rows as f64;
            let (u, v) = (rnd().max(1e-300), rnd());
            let g = (-2.0 * u.ln()).sqrt();
            let a = std::f64::consts::TAU * v;
            Disc {
                id: i as u32,
                position: DVec2::new(x, y),
                velocity: DVec2::new(g * a.cos(), g * a.sin()),
                radius: 0.5,
                mass: 1.0,
            }
        })
        .collect();
    let drift = discs.iter().map(|d| d.velocity).sum::<DVec2>() / n as f64;
    discs.iter_mut().for_each(|d| d.velocity -= drift);
    let e: f64 = discs.iter().map(Disc::kinetic_energy).sum();
    let f = (n as f64 / e).sqrt();
    discs.iter_mut().for_each(|d| d.velocity *= f);
    let laws =
        Laws { periodic: Some(Periodic { min: DVec2::ZERO, max: DVec2::splat(l) }), ..Laws::FREE };
    let _rate = if phi < 0.3 {
        1.287
    } else if phi < 0.6 {
        7.0
    } else {
        19.8
    };
    let t0 = Instant::now();
    let mut arena = Events::new(laws, &discs);
    let start_up = t0.elapsed();
    let mut sink: Vec<carom::world::Contact> = Vec::new();
    let run = |arena: &mut Events, count: u64, _sink: &mut Vec<carom::world::Contact>| {
        let target = arena.contacts() + count;
        while arena.contacts() < target {
            arena.pass(1e300).unwrap();
        }
    };
    run(&mut arena, 15 * n as u64, &mut sink);
    for _ in 0..3 {
        let (c0, s0) = (arena.contacts(), arena.now());
        let t0 = cpu();
        run(&mut arena, k, &mut sink);
        let t = cpu() - t0;
        let c = arena.contacts() - c0;
        println!(
            "{n} {phi} {:.1} ns/collision rate {:.4} drift {:.2e} overlap {:.2e} start {:.3}s",
            t / c as f64 * 1e9,
            2.0 * c as f64 / (n as f64 * (arena.now() - s0)),
            arena.relative_energy_drift(),
            arena.largest_overlap(),
            start_up.as_secs_f64()
        );
    }
}
