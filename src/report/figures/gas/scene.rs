//! The gas of the main plot, its true end, and what the scene makes of an error.
//!
//! Never a method under test: the truth is that of the judge of many digits.

use glam::DVec2;

use super::super::mover::{self, Mover, Scene};
use crate::bench;
use crate::bench::gas::Gas;
use crate::exact::UNIT_ROUNDOFF;
use crate::report::ReportError;
use crate::report::judge::{self, Truth};
use crate::scene::lattice::Lattice;
use crate::world::Pace;

/// Seed of the velocities.
pub const SEED: u64 = 1;

/// Collisions of a disc before the stretch that is shown: the lattice has melted.
pub const MELT: f64 = 30.0;

/// After the melt, so that no pair touches at the start, s.
const LEAVE: f64 = 0.05;

/// The size of the perturbation whose growth is measured, m: small enough for its square not to
/// count, large enough for rounding not to.
const PERTURBATION_M: f64 = 1.0 / (1u64 << 30) as f64;

/// A gas and where it ends.
pub struct Stretch {
    /// Share of the area that discs cover.
    pub area_fraction: f64,
    /// The discs at the start.
    pub scene: Scene,
    /// Where they are at the end.
    pub truth: Truth,
    /// By how much the plain method, which found the contacts, is off.
    pub plain: mover::Error,
    /// What becomes of a perturbation: the worst disc at the end, over that at the start.
    pub growth: f64,
}

impl Stretch {
    /// So many elastic discs of 1 kg between walls for so many seconds.
    ///
    /// # Errors
    /// [`ReportError::Wrong`] where the judge does not agree.
    pub fn new(count: usize, area_fraction: f64, seconds: f64) -> Result<Self, ReportError> {
        let wrong = |what: String| ReportError::Wrong(format!("gas at {area_fraction}: {what}"));
        let scene = melted(count, area_fraction, seconds).map_err(wrong)?;
        let mut arena = Mover::Plain.arena(&scene).map_err(wrong)?;
        let contacts = mover::contacts(&mut arena, seconds).map_err(wrong)?;
        let (settings, discs) = (&scene.settings, &scene.discs);
        let truth = judge::retell(settings, discs, &contacts, seconds).map_err(wrong)?;
        let plain = mover::Error::of(&mover::discs(&arena), &truth);
        let growth = growth(&scene).map_err(wrong)?;
        Ok(Self { area_fraction, scene, truth, plain, growth })
    }

    /// What one rounding of a coordinate at the start becomes, in radii: `u G`, times the largest
    /// coordinate. No method of doubles can be expected to do better.
    pub fn one_rounding(&self) -> f64 {
        let largest = |discs: &[crate::world::Disc]| {
            discs.iter().map(|disc| disc.position.abs().max_element()).fold(0.0, f64::max)
        };
        let radius = self.scene.discs[0].radius;
        UNIT_ROUNDOFF * self.growth * largest(&self.scene.discs) / radius
    }

    /// Contacts of a disc, with others and walls.
    pub fn contacts_per_disc(&self) -> f64 {
        2.0 * self.truth.contacts as f64 / self.scene.discs.len() as f64
    }
}

/// The gas, melted; ids are indices.
///
/// # Errors
/// What is wrong with the numbers.
pub fn melted(count: usize, area_fraction: f64, until: f64) -> Result<Scene, String> {
    let lattice =
        Lattice { count, area_fraction, size_ratio: 1.0, mass_max: 1.0, walled: true, seed: SEED };
    let step = Pace::default().step;
    let gas = Gas { lattice, spread: false, restitution: 1.0, melt: MELT, step };
    let (settings, discs) = gas.scene()?;
    let mut scene = Scene { settings, discs, until };
    let mut arena = Mover::Events.arena(&scene)?;
    bench::pass(&mut arena, step, gas.melt_collisions()).map_err(|error| error.to_string())?;
    let leave = arena.now() + LEAVE;
    mover::pass(&mut arena, leave)?;
    scene.discs = mover::discs(&arena);
    (0..).zip(&mut scene.discs).for_each(|(k, disc)| disc.id = k);
    Ok(scene)
}

/// The worst distance of two runs at the end that began a little apart, over that at the start
/// (along each axis).
fn growth(scene: &Scene) -> Result<f64, String> {
    let mut twin = scene.clone();
    for (k, disc) in (1u64..).zip(&mut twin.discs) {
        // Signs without a pattern: two bits of a multiple of the golden ratio.
        let bits = k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let sign = |bit: u32| if (bits >> bit) & 1 == 0 { 1.0 } else { -1.0 };
        disc.position += PERTURBATION_M * DVec2::new(sign(63), sign(62));
    }
    let end = |scene: &Scene| {
        let mut arena = Mover::Events.arena(scene)?;
        mover::pass(&mut arena, scene.until)?;
        Ok::<_, String>(mover::discs(&arena))
    };
    let (ours, theirs) = (end(scene)?, end(&twin)?);
    let apart = ours.iter().zip(&theirs).map(|(a, b)| a.position.distance(b.position));
    Ok(apart.fold(0.0, f64::max) / PERTURBATION_M)
}
