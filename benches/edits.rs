//! What a disc that comes and goes costs while an arena runs: `cargo bench --bench edits`.
//!
//! A gas of the event-driven method gets new discs where it has room for them, and loses them
//! again, between advances, and is put in other places; the yardstick is what all cells and
//! predictions cost at the start. Whether the results are right is for the tests to say
//! (`tests/core/edits.rs`); here the energy account must close, or no time is told. Medians over
//! blocks.

mod figures;

use std::time::Instant;

use carom::motion::events::Events;
use carom::motion::plain::Laws;
use carom::world::{Disc, Owner, Periodic};
use glam::DVec2;

use figures::median;

const BLOCKS: usize = 21;
const EDITS: usize = 1_000;

fn main() {
    println!("{:>9} {:>14} {:>14} {:>16}", "discs", "add+remove ns", "place ns", "all anew ns");
    for side in [32, 100, 316, 1_000] {
        measure(side);
    }
}

/// A square lattice at area fraction 0.3, with room for one more disc in the middle of four.
fn measure(side: u32) {
    let spacing = (std::f64::consts::FRAC_PI_4 / 0.3).sqrt();
    let count = side * side;
    let place = |k: u32| DVec2::new(f64::from(k % side), f64::from(k / side)) * spacing;
    let velocity = |k: u32| DVec2::from_angle(f64::from(k) * 2.4) * 1e-3;
    let disc =
        |k: u32| Disc { id: k, position: place(k), velocity: velocity(k), radius: 0.5, mass: 1.0 };
    let discs: Vec<Disc> = (0..count).map(disc).collect();
    let size = DVec2::splat(f64::from(side) * spacing);
    let laws = Laws { periodic: Some(Periodic { min: DVec2::ZERO, max: size }), ..Laws::FREE };
    let start = Instant::now();
    let mut arena = Events::new(laws, &discs);
    let all_anew = start.elapsed().as_secs_f64() * 1e9;
    arena.add(guest(&discs, spacing, 0)).expect("room");
    arena.remove(count).expect("it is there");
    let (mut both, mut moved) = (Vec::new(), Vec::new());
    for block in 0..BLOCKS {
        arena.pass(arena.now() + 0.01).expect("no stall");
        let guests: Vec<Disc> =
            (0..EDITS).map(|k| guest(&discs, spacing, block * EDITS + k)).collect();
        let start = Instant::now();
        for guest in &guests {
            arena.add(*guest).expect("room");
            arena.remove(guest.id).expect("it is there");
        }
        both.push(start.elapsed().as_secs_f64() * 1e9 / EDITS as f64);
        arena.add(guests[0]).expect("room");
        let start = Instant::now();
        for guest in &guests {
            arena.place(count, guest.position, guest.velocity).expect("room");
        }
        moved.push(start.elapsed().as_secs_f64() * 1e9 / EDITS as f64);
        arena.remove(count).expect("it is there");
    }
    assert!(arena.relative_energy_drift().abs() < 1e-12, "the account does not close");
    assert_eq!(arena.discs(Owner::Simulated).count(), count as usize);
    let (both, moved) = (median(both), median(moved));
    println!("{count:>9} {both:>14.0} {moved:>14.0} {all_anew:>16.0}");
}

/// A small disc in the middle of four, anywhere.
fn guest(discs: &[Disc], spacing: f64, k: usize) -> Disc {
    let host = discs[k.wrapping_mul(0x9e37_79b9) % discs.len()];
    let position = host.position + 0.5 * spacing;
    Disc {
        id: discs.len() as u32,
        position,
        velocity: DVec2::new(0.0, 1e-3),
        radius: 0.4,
        mass: 1.0,
    }
}
