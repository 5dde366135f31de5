//! Recordings with noise: deviations must be what they say, and nothing lawful be called wrong.

use carom::audit::Options;
use carom::audit::findings::{Collision, Findings, Met, Sight};

use crate::audited;
use crate::clean::told;
use crate::common::Random;
use crate::recordings::{Gas, sampled, with_noise};

const RESTITUTION: f64 = 0.9;

/// A gas with noise of positions, and a tenth a second of it of velocities.
fn noisy(area_fraction: f64, rate: f64, noise: f64, tell: bool) -> (Findings, Vec<Collision>) {
    let gas = Gas { restitution: RESTITUTION, mass_max: 3.0, ..Gas::new(100, area_fraction) };
    let (mut arena, settings) = gas.arena();
    let mut frames = sampled(&mut arena, rate, 480);
    with_noise(&mut frames, noise, 10.0 * noise, &mut Random::new(7));
    let options = if tell { told(RESTITUTION, settings.walls) } else { Options::default() };
    audited(frames, &options)
}

#[test]
fn noise_is_measured_and_no_violation() {
    for rate in [240.0, 60.0] {
        for noise in [1e-6, 1e-5, 1e-4] {
            for tell in [true, false] {
                let (findings, collisions) = noisy(0.2, rate, noise, tell);
                let worst = findings.worst.first();
                assert_eq!(findings.violations_in_all(), 0, "{rate} {noise}: {worst:?}");
                assert!((findings.noise.position / noise - 1.0).abs() < 0.1);
                assert!((findings.noise.velocity / (10.0 * noise) - 1.0).abs() < 0.1);
                assert!(collisions.len() > 400, "{}", collisions.len());
            }
        }
    }
}

#[test]
fn the_deviation_of_a_restitution_is_what_it_says() {
    let mut off = Vec::new();
    for (area_fraction, rate) in [(0.2, 240.0), (0.2, 60.0), (0.5, 240.0)] {
        let (_, collisions) = noisy(area_fraction, rate, 1e-5, true);
        let alone = collisions.iter().filter(|each| {
            each.sight == Sight::Alone && each.b != Met::Wall && each.restitution.1 < 0.3
        });
        off.extend(alone.map(|each| (each.restitution.0 - RESTITUTION) / each.restitution.1));
    }
    let within = |k: f64| off.iter().filter(|z| z.abs() <= k).count() as f64 / off.len() as f64;
    let shares = [1.0, 2.0, 3.0].map(within);
    println!("{} restitutions within 1, 2, 3 deviations: {shares:?}", off.len());
    assert!(off.len() > 2000, "{}", off.len());
    // Of a Gaussian 0.683, 0.954, 0.997.
    assert!((shares[0] - 0.683).abs() < 0.05, "{shares:?}");
    assert!((shares[1] - 0.954).abs() < 0.03, "{shares:?}");
    assert!(shares[2] > 0.99, "{shares:?}");
}

#[test]
fn a_dense_gas_in_heavy_noise_has_few_false_names() {
    // A position is unsure by a fiftieth of a radius here, and neighbours touch within that.
    for (noise, most) in [(1e-5, 0.002), (1e-4, 0.01), (1e-3, 0.05)] {
        let (findings, collisions) = noisy(0.5, 240.0, noise, true);
        let share = findings.violations_in_all() as f64 / collisions.len() as f64;
        println!("noise {noise} m: {share} of {} collisions", collisions.len());
        assert!(share <= most, "{noise}: {share} {:?}", findings.worst.first());
    }
}
