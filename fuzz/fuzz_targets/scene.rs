//! Any text as a scene: refused with one line, or an arena that moves; never a panic or a hang.
#![no_main]

use carom::scene::file;
use carom::world::Instants;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    match file::parse(text, "scene.yaml") {
        Err(error) => assert!(!error.to_string().contains('\n')),
        Ok(scene) if scene.pucks.len() <= 100 => {
            let mut world = scene.world();
            for tick in 1..=10 {
                let advance_to = f64::from(tick) * 0.1;
                world.step(&[], Instants { heard_at: advance_to, advance_to });
            }
        }
        Ok(_) => {}
    }
});
