//! Any payload on a circle topic: decoded or refused, then answered; never a panic.
#![no_main]

use byteorder::LittleEndian;
use carom::messages::{CircleStates, Twist};
use carom::receive;
use carom::world::{Command, Instants, Settings, World};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|payload: &[u8]| {
    if let Ok((twist, _)) = cdr_encoding::from_bytes::<Twist, LittleEndian>(payload) {
        let _ = receive::velocity(&twist);
    }
    let Ok((states, _)) = cdr_encoding::from_bytes::<CircleStates, LittleEndian>(payload) else {
        return;
    };
    let Ok((report, _)) = receive::report(&states) else { return };
    let mut world = World::new(Settings::default(), &[]);
    world.step(&[Command::Observe(report)], Instants { heard_at: 0.0, advance_to: 0.0 });
});
