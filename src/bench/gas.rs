//! The gas that is measured, and what its physics must be.
//!
//! Equal elastic discs collide as often as kinetic theory says: `4 phi chi v / d` a disc, with
//! `chi` from published pressures, and between them from the equation of state of Santos, Lopez de
//! Haro and Yuste (doi:10.1063/1.469762). For other scenes there is no such number; energy and the
//! distance at contact are checked in all.

use std::fmt;

use glam::DVec2;
use serde::Serialize;

use crate::motion::arena::Arena;
use crate::plan::Method;
use crate::scene::lattice::Lattice;
use crate::scene::spread;
use crate::world::{Disc, Pace, Periodic, Settings, Walls};

/// Largest distance from contact at a collision, in smaller radii, and relative energy drift.
const ERROR_MAX: f64 = 1e-9;

/// Relative energy drift of steps: only the pair law changes a velocity.
const STEPS_DRIFT_MAX: f64 = 1e-12;

/// Part by which steps may differ from the collision rate of kinetic theory: contacts come late.
const STEPS_RATE: f64 = 0.15;

/// A gas to be measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas {
    /// Where and what.
    pub lattice: Lattice,
    /// Whether radii are of every octave up to the size ratio, instead of two.
    pub spread: bool,
    /// Restitution of pairs and walls.
    pub restitution: f64,
    /// Collisions of a disc before anything is measured.
    pub melt: f64,
    /// Length of a step of the methods that have one, s.
    pub step: f64,
}

impl Gas {
    /// The laws and the discs.
    ///
    /// # Errors
    /// What is wrong with the numbers.
    pub fn scene(&self) -> Result<(Settings, Vec<Disc>), String> {
        let crowded = || {
            let Lattice { area_fraction, count, walled, .. } = self.lattice;
            if count < 8 && !walled {
                return "a periodic box has 8 discs at least; or take --boundary walls".to_owned();
            }
            format!("discs at area fraction {area_fraction} do not fit: choose it lower")
        };
        let discs = if self.spread { spread::discs(&self.lattice) } else { self.lattice.discs() };
        let (discs, side) = discs.ok_or_else(crowded)?;
        let (min, max) = (DVec2::ZERO, DVec2::splat(side));
        let walls = Walls { min, max, restitution: self.restitution };
        let settings = Settings {
            restitution: self.restitution,
            periodic: (!self.lattice.walled).then_some(Periodic { min, max }),
            walls: self.lattice.walled.then_some(walls),
            pace: Pace { step: self.step, ..Pace::default() },
            ..Settings::default()
        };
        Ok((settings, discs))
    }

    /// Collisions of all discs before anything is measured.
    pub fn melt_collisions(&self) -> u64 {
        (0.5 * self.melt * self.lattice.count as f64) as u64
    }

    /// Judges a run of so many contacts in so many seconds.
    pub fn judge(&self, method: Method, arena: &Arena, contacts: u64, seconds: f64) -> Judgement {
        let rate = 2.0 * contacts as f64 / (self.lattice.count as f64 * seconds);
        let simple = self.restitution == 1.0
            && self.lattice.size_ratio == 1.0
            && self.lattice.mass_max == 1.0
            && !self.lattice.walled;
        let expected = expected_rate(self.lattice.area_fraction).filter(|_| simple);
        let of_all = |count: u64| count as f64 / arena.contacts().max(1) as f64;
        Judgement {
            method,
            rate,
            // Soft contacts last: there is no such number for them.
            rate_expected: expected.filter(|_| method != Method::Springs).map(|(rate, part)| {
                (rate, if method == Method::Steps { part.max(STEPS_RATE) } else { part })
            }),
            energy_drift: arena.relative_energy_drift(),
            largest_miss: arena.largest_miss(),
            late: arena.unseen().map(|unseen| of_all(unseen.late)),
            missed: arena.unseen().map(|unseen| of_all(unseen.missed + unseen.too_late)),
        }
    }
}

/// Compressibility factors by area fraction: the virial series (Clisby, McCoy,
/// doi:10.1007/s10955-005-8080-0) up to 0.6, from 0.45 on with what its ratios make of the rest
/// (0.15 % at most), 870 discs (Li et al., doi:10.1063/5.0126437) above.
const FACTORS: [(f64, f64); 14] = [
    (0.05, 1.10838774),
    (0.1, 1.23614364),
    (0.2, 1.57036618),
    (0.3, 2.06326214),
    (0.4, 2.82937526),
    (0.45, 3.3805),
    (0.5, 4.1063),
    (0.55, 5.0874),
    (0.6, 6.457),
    (0.67, 9.36233881),
    (0.676, 9.64956101),
    (0.68, 9.83276112),
    (0.686, 10.0799958),
    (0.69, 10.2095797),
];

/// Collisions of a disc per unit of time, with `kT = m = d = 1`, and by what part they may differ:
/// `2 sqrt(pi) n chi` with `chi = (Z - 1) / (2 eta)`; `None` beyond the fluid.
fn expected_rate(area_fraction: f64) -> Option<(f64, f64)> {
    let eta = area_fraction;
    let tolerance = if eta <= 0.55 { 0.03 } else { 0.04 };
    let chi = (factor(eta)? - 1.0) / (2.0 * eta);
    let density = eta * std::f64::consts::FRAC_2_SQRT_PI * std::f64::consts::FRAC_2_SQRT_PI;
    Some((2.0 * std::f64::consts::PI.sqrt() * density * chi, tolerance))
}

/// The compressibility factor: the equation of state of Santos, Lopez de Haro and Yuste, with what
/// the published factors correct it by, straight between them.
fn factor(area_fraction: f64) -> Option<f64> {
    const CLOSEST: f64 = 0.906_899_682_117_108_9;
    const SQUARE: f64 = (2.0 * CLOSEST - 1.0) / (CLOSEST * CLOSEST);
    let simple = |eta: f64| 1.0 / (1.0 - 2.0 * eta + SQUARE * eta * eta);
    let correction = |(eta, factor): (f64, f64)| (factor - 1.0) / (simple(eta) - 1.0);
    let after = FACTORS.iter().position(|&(eta, _)| area_fraction <= eta)?;
    let at = |k: usize| (FACTORS[k].0, correction(FACTORS[k]));
    // Of a few discs the equation is right.
    let (high, low) = (at(after), after.checked_sub(1).map_or((0.0, 1.0), at));
    let part = (area_fraction - low.0) / (high.0 - low.0);
    let correction = low.1 + part * (high.1 - low.1);
    Some(1.0 + correction * (simple(area_fraction) - 1.0))
}

/// What was checked in a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// By which method; decides what must be right.
    #[serde(skip)]
    pub method: Method,
    /// Collisions of a disc per second of its time.
    pub rate: f64,
    /// What it should be, and by what part it may differ.
    pub rate_expected: Option<(f64, f64)>,
    /// Relative energy drift.
    pub energy_drift: f64,
    /// Largest distance from contact at a collision, in smaller radii.
    pub largest_miss: f64,
    /// Share of contacts that were resolved late, where steps are fixed.
    pub late: Option<f64>,
    /// Share of contacts that were never resolved.
    pub missed: Option<f64>,
}

impl Judgement {
    /// What is wrong, if anything.
    ///
    /// # Errors
    /// The first thing that is.
    pub fn verdict(&self) -> Result<(), String> {
        if let Some((rate, part)) = self.rate_expected
            && exceeds(self.rate / rate - 1.0, part)
        {
            return Err(format!(
                "{} collisions a disc and second, must be {} within {} %; more collisions or more \
                 discs scatter less",
                digits(self.rate),
                digits(rate),
                100.0 * part
            ));
        }
        let drift_max = match self.method {
            Method::Steps => STEPS_DRIFT_MAX,
            // Told, not judged: what the steps of springs lose is the method.
            Method::Springs => f64::MAX,
            _ => ERROR_MAX,
        };
        if exceeds(self.energy_drift, drift_max) {
            return Err(format!("relative energy drift {:e}", self.energy_drift));
        }
        if self.method.is_exact() && exceeds(self.largest_miss, ERROR_MAX) {
            return Err(format!("a collision {:e} radii from contact", self.largest_miss));
        }
        Ok(())
    }
}

/// A rate as it is told: four decimals, or digits that are none of nothing.
fn digits(rate: f64) -> String {
    if rate.abs() < 0.01 { format!("{rate:.3e}") } else { format!("{rate:.4}") }
}

/// Whether a size is beyond a bound, or no number.
fn exceeds(size: f64, bound: f64) -> bool {
    size.is_nan() || size.abs() > bound
}

impl fmt::Display for Judgement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>10} collisions of a disc per second", digits(self.rate))?;
        if let Some((rate, part)) = self.rate_expected {
            write!(f, " (kinetic theory: {} within {} %)", digits(rate), 100.0 * part)?;
        }
        writeln!(f, "\n{:>+10.1e} relative energy drift", self.energy_drift)?;
        write!(f, "{:>10.1e} radii from contact at most at a collision", self.largest_miss)?;
        if let (Some(late), Some(missed)) = (self.late, self.missed) {
            write!(f, "\n{:>9.2} % of contacts late, ", 100.0 * late)?;
            write!(f, "{:.4} % missed", 100.0 * missed)?;
        }
        Ok(())
    }
}

impl fmt::Display for Gas {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Lattice { count, area_fraction, size_ratio, mass_max, walled, seed } = self.lattice;
        let boundary = if walled { "walls" } else { "periodic" };
        write!(f, "{count} discs, area fraction {area_fraction}, {boundary}, seed {seed}")?;
        if size_ratio != 1.0 {
            let all = if self.spread { " and all between" } else { "" };
            write!(f, ", sizes 1:{size_ratio}{all}")?;
        }
        if mass_max != 1.0 {
            write!(f, ", masses 1 to {mass_max}")?;
        }
        if self.restitution != 1.0 {
            write!(f, ", restitution {}", self.restitution)?;
        }
        Ok(())
    }
}
