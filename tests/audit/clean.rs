//! The audit: no false alarm on clean recordings, and every planted violation by its name.

use carom::audit::{Bounds, Options};

use crate::audited;
use crate::recordings::{Gas, sampled};

#[test]
fn probe() {
    for (count, phi) in [(100, 0.2), (100, 0.5), (1000, 0.2), (1000, 0.5)] {
        for rate in [240.0, 60.0] {
            for (ratio, mass, e) in [(1.0, 1.0, 1.0), (if phi < 0.3 { 2.0 } else { 1.2 }, 5.0, 0.9)]
            {
                let gas = Gas {
                    size_ratio: ratio,
                    mass_max: mass,
                    restitution: e,
                    ..Gas::new(count, phi)
                };
                let (mut arena, settings) = gas.arena();
                let c0 = arena.contacts();
                let frames = sampled(&mut arena, rate, 240);
                let walls = settings.walls.unwrap();
                for told in [true, false] {
                    let options = if told {
                        Options {
                            restitution: Some(e),
                            walls: Some(Bounds {
                                min: walls.min,
                                max: walls.max,
                                restitution: None,
                            }),
                            ..Options::default()
                        }
                    } else {
                        Options::default()
                    };
                    let t = std::time::Instant::now();
                    let (f, _) = audited(frames.clone(), &options);
                    eprintln!(
                        "{count} {phi} {rate} e{e} told {told}: violations {} {:?} true contacts {} {:?} law e {:?} walls {:?} noise {:?} ns/sample {:.0}",
                        f.violations_in_all(),
                        f.by_kind.iter().filter(|k| k.1 > 0).collect::<Vec<_>>(),
                        arena.contacts() - c0,
                        f.counts,
                        f.law.restitution,
                        f.law.walls.map(|w| (w.min.x, w.max.x - walls.max.x, w.restitution)),
                        f.noise,
                        t.elapsed().as_nanos() as f64 / f.counts.samples as f64
                    );
                    for v in f.worst.iter().take(3) {
                        eprintln!("   {v:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn debug() {
    for (n, phi, rate) in [(100, 0.2, 60.0), (100, 0.5, 240.0)] {
        let gas = Gas::new(n, phi);
        let (mut arena, _) = gas.arena();
        let frames = sampled(&mut arena, rate, 240);
        let options = Options { restitution: Some(1.0), ..Options::default() };
        let (f, _) = audited(frames, &options);
        eprintln!("{:?} {:?}", f.by_kind, f.counts);
        for v in &f.violations {
            eprintln!("   {v:?}");
        }
    }
}
