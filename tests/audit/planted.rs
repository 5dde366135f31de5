//! One violation planted in each of many recordings: its kind, time and pair must be found, and
//! nothing else.

use carom::audit::findings::Kind;
use carom::audit::{Bounds, Options};
use carom::world::{Disc, Owner};

use crate::audited;
use crate::recordings::{Engine, Gas, Spoil};

/// How often a kind was planted, found by its name with time and pair, found by another name, and
/// how many other violations there were.
#[derive(Debug, Default)]
pub struct Tally {
    planted: u32,
    found: u32,
    otherwise: u32,
    beside: u64,
}

fn planted(how: Spoil, wanted: &[Kind], rate: f64, count: usize, seeds: u64) -> Tally {
    let mut tally = Tally::default();
    for seed in 1..=seeds {
        let (size_ratio, mass_max, restitution) = (1.5, 4.0, 0.9);
        let gas = Gas { size_ratio, mass_max, restitution, seed, ..Gas::new(count, 0.2) };
        let (arena, settings) = gas.arena();
        let discs: Vec<Disc> = arena.discs(Owner::Simulated).collect();
        let mut engine = Engine::new(discs, restitution, settings.walls);
        let clear = |discs: &[Disc], i: usize, j: usize, now: f64| {
            let (a, b) = (&discs[i], &discs[j]);
            let n = (b.position - a.position).normalize();
            let w = b.velocity - a.velocity;
            now > 0.2 && -w.dot(n) > 0.3 * w.length() && (a.mass - b.mass).abs() > 0.3
        };
        let (frames, spoilt) = engine.record(rate, (0.8 * rate) as usize, Some(how), clear);
        let Some(spoilt) = spoilt else { continue };
        let walls = settings.walls.expect("walls");
        let bounds = Bounds { min: walls.min, max: walls.max, restitution: None };
        let options =
            Options { restitution: Some(restitution), walls: Some(bounds), ..Options::default() };
        let (findings, _) = audited(frames, &options);
        tally.planted += 1;
        let mut same = 0;
        let mut named = false;
        for violation in &findings.violations {
            let pair = spoilt.pair.iter().all(|id| violation.discs.contains(id));
            let late = if matches!(how, Spoil::Late(_)) { 0.1 } else { 0.0 };
            let near = (violation.time_s - spoilt.time).abs() < 2.5 / rate + late;
            if pair && near {
                same += 1;
                named |= wanted.contains(&violation.kind);
            } else if std::env::var("AUDIT_SHOW").is_ok() {
                eprintln!("beside {how:?} {spoilt:?} {violation:?}");
            }
        }
        if !named && std::env::var("AUDIT_SHOW").is_ok() {
            eprintln!("not named {how:?} {spoilt:?} {:?}", findings.violations);
        }
        tally.found += u32::from(named);
        tally.otherwise += u32::from(!named && same > 0);
        tally.beside += findings.violations_in_all() - same;
    }
    tally
}

#[test]
fn probe_planted() {
    for rate in [240.0, 60.0] {
        for (how, wanted) in [
            (Spoil::Momentum, &[Kind::Momentum][..]),
            (Spoil::Energy, &[Kind::Energy]),
            (Spoil::Normal, &[Kind::Normal]),
            (Spoil::Sticking, &[Kind::Sticking]),
            (Spoil::SwappedMasses, &[Kind::SwappedMasses]),
            (Spoil::Scaled, &[Kind::ScaledVelocities]),
            (Spoil::Unseen, &[Kind::Missed, Kind::Tunnelling]),
            (Spoil::Late(0.2), &[Kind::Late]),
        ] {
            let tally = planted(how, wanted, rate, 60, 20);
            eprintln!("{rate} {how:?} {tally:?}");
        }
    }
}
