//! Any circles that are accepted, some of them pucks: finite answers, and momentum that stays.
#![no_main]

use carom::messages::{CircleState, CircleStates};
use carom::receive;
use carom::world::{Command, Instants, Settings, World};
use libfuzzer_sys::fuzz_target;

/// Eight bytes make a number: any bits, or one of a small grid, where contacts happen.
fn number(bytes: &[u8]) -> f64 {
    let mut whole = [0; 8];
    whole[..bytes.len()].copy_from_slice(bytes);
    match whole[7] {
        0..=127 => f64::from(whole[0] % 16) - 8.0,
        _ => f64::from_le_bytes(whole),
    }
}

fuzz_target!(|bytes: &[u8]| {
    let circles: Vec<CircleState> = bytes
        .chunks_exact(48)
        .take(40)
        .enumerate()
        .map(|(id, bytes)| {
            let [x, y, vx, vy, radius, mass] = std::array::from_fn(|k| number(&bytes[8 * k..8 * k + 8]));
            CircleState { id: id as u32, x, y, vx, vy, radius: radius.abs(), mass: mass.abs() }
        })
        .collect();
    let message = CircleStates { circles, ..CircleStates::default() };
    let (report, _) = receive::report(&message).expect("few");
    let (pucks, others) = report.discs.split_at(report.discs.len().min(3));
    let settings = Settings { restitution: 0.75, ..Settings::default() };
    let mut world = World::new(settings, pucks);
    let mut report = report.clone();
    report.discs = others.to_vec();
    for tick in 0..3 {
        let instants = Instants { heard_at: 0.0, advance_to: f64::from(tick) };
        let outcome = world.step(&[Command::Observe(report.clone())], instants);
        for answer in outcome.answers {
            assert!(answer.velocities.iter().all(|(_, v)| v.is_finite()));
            assert!(answer.contacts.iter().all(|c| c.impulse.is_finite() && c.impulse >= 0.0));
        }
    }
});
