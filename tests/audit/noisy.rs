//! The audit on recordings with noise: no false alarm, and deviations that are what they say.

use carom::audit::findings::Sight;
use carom::audit::{Bounds, Options};

use crate::audited;
use crate::common::Random;
use crate::recordings::{Gas, in_single, sampled, with_noise};

#[test]
fn probe_noise() {
    for (count, phi, rate) in [(100, 0.2, 240.0), (100, 0.2, 60.0), (100, 0.5, 240.0)] {
        for (position, velocity) in
            [(0.0, 0.0), (1e-6, 1e-5), (1e-5, 1e-4), (1e-4, 1e-3), (1e-3, 1e-2)]
        {
            let gas = Gas { restitution: 0.9, mass_max: 3.0, ..Gas::new(count, phi) };
            let (mut arena, settings) = gas.arena();
            let mut frames = sampled(&mut arena, rate, 480);
            let mut random = Random::new(7);
            with_noise(&mut frames, position, velocity, &mut random);
            if position == 0.0 {
                in_single(&mut frames);
            }
            let walls = settings.walls.unwrap();
            for told in [true, false] {
                let options = if told {
                    let bounds = Bounds { min: walls.min, max: walls.max, restitution: None };
                    Options { restitution: Some(0.9), walls: Some(bounds), ..Options::default() }
                } else {
                    Options::default()
                };
                let (f, c) = audited(frames.clone(), &options);
                let es: Vec<f64> = c
                    .iter()
                    .filter(|c| {
                        c.sight == Sight::Alone
                            && c.restitution.1 < 0.3
                            && matches!(c.b, carom::audit::findings::Met::Disc(_))
                    })
                    .map(|c| (c.restitution.0 - 0.9) / c.restitution.1)
                    .collect();
                let within =
                    |k: f64| es.iter().filter(|z| z.abs() <= k).count() as f64 / es.len() as f64;
                eprintln!(
                    "{count} {phi} {rate} noise {position} {velocity} told {told}: {:?} {:?} e {:?} w {:?} noise {:?} calibration n {} 1s {:.3} 2s {:.3} 3s {:.3}",
                    f.by_kind.iter().filter(|k| k.1 > 0).collect::<Vec<_>>(),
                    f.counts,
                    f.law.restitution,
                    f.law.walls.map(|w| w.restitution),
                    f.noise,
                    es.len(),
                    within(1.0),
                    within(2.0),
                    within(3.0)
                );
                for v in f.worst.iter().take(3) {
                    eprintln!("   {v:?}");
                }
            }
        }
    }
}
