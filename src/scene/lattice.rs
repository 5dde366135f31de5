//! Discs on a lattice that fits a square: a start at any density up to the closest.
//!
//! The lattice is triangular, but square where that gives way at once and a triangular one would
//! melt slowly: in a dense fluid.
//!
//! Never used for statistics before the lattice has melted.

use std::ops::Range;

use glam::DVec2;

use super::batch::{self, Batch, scattered};
use crate::world::{Disc, Walls};

/// What shall lie on the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// How many discs.
    pub count: usize,
    /// Share of the area that they cover.
    pub area_fraction: f64,
    /// Radii of every second disc over those of the others, 1 or more; the smaller radius is 0.5 m.
    pub size_ratio: f64,
    /// Masses are uniform from 1 kg to this.
    pub mass_max: f64,
    /// Whether walls stand around it; else it repeats.
    pub walled: bool,
    /// Seed of velocities and masses.
    pub seed: u64,
}

/// Where a triangular lattice takes hundreds of collisions of a disc to melt (measured: at 0.68
/// and 1e5 discs the rate is 9 % low after 30, and right after 60 from a square one).
const DENSE_FLUID: Range<f64> = 0.55..0.695;

/// Columns and rows for so many discs.
fn lines(count: f64, is_square: bool) -> (f64, f64) {
    if is_square {
        let columns = count.sqrt().ceil().max(2.0);
        return (columns, (count / columns).ceil().max(2.0));
    }
    let columns = (count * 0.75f64.sqrt()).sqrt().round().max(2.0);
    (columns, 2.0 * (0.5 * count / columns).ceil())
}

impl Lattice {
    /// The discs, and the side of the square with its lower left corner at 0, m. Without total
    /// momentum, with a kinetic energy of 1 J a disc. `None` if they cannot lie so close.
    pub fn discs(&self) -> Option<(Vec<Disc>, f64)> {
        let radius = |k: usize| if k.is_multiple_of(2) { 0.5 } else { 0.5 * self.size_ratio };
        let covered: f64 = (0..self.count).map(|k| radius(k).powi(2)).sum();
        let side = (std::f64::consts::PI * covered / self.area_fraction).sqrt();
        let is_square = DENSE_FLUID.contains(&self.area_fraction);
        let (columns, rows) = lines(self.count as f64, is_square);
        let shift = if is_square { 0.0 } else { 0.5 };
        let largest = 2.0 * radius(1).max(radius(0));
        // Between walls the outermost touch them; in a periodic box no disc may meet itself.
        let (across, up, corner) = if self.walled {
            let room = side - largest;
            (room / (columns - 1.0 + shift), room / (rows - 1.0), 0.5 * largest)
        } else {
            (side / columns, side / rows, 0.25 * side / columns)
        };
        let close = across <= largest || DVec2::new(shift * across, up).length() <= largest;
        if close || (columns < 3.0 && !self.walled) {
            return None;
        }
        let sites = (columns * rows) as usize;
        let mut discs = self.drawn();
        for (k, disc) in discs.iter_mut().enumerate() {
            // Empty places are spread evenly.
            let site = k * sites / self.count;
            let (column, row) = ((site % columns as usize) as f64, site / columns as usize);
            let x = across * (column + shift * (row % 2) as f64);
            disc.position = corner + DVec2::new(x, up * row as f64);
            if self.walled {
                // No rounding may put it into the wall.
                disc.position = disc.position.min(DVec2::splat(side - 0.5 * largest));
            }
            disc.radius = radius(k);
        }
        settle(&mut discs);
        Some((discs, side))
    }

    /// Discs with random velocities and masses, wherever.
    pub(super) fn drawn(&self) -> Vec<Disc> {
        let (min, max) = (DVec2::splat(-1.0), DVec2::splat(1.0));
        scattered(&Batch {
            count: self.count,
            seed: self.seed,
            radius: batch::Range { min: 0.5, max: 0.5 },
            mass: batch::Range { min: 1.0, max: self.mass_max },
            speed: 1.0,
            region: Walls { min, max, restitution: 1.0 },
        })
    }
}

/// Takes the total momentum away and scales the energy.
pub(super) fn settle(discs: &mut [Disc]) {
    let mass: f64 = discs.iter().map(|disc| disc.mass).sum();
    let drift = discs.iter().map(|disc| disc.mass * disc.velocity).sum::<DVec2>() / mass;
    discs.iter_mut().for_each(|disc| disc.velocity -= drift);
    let energy: f64 = discs.iter().map(Disc::kinetic_energy).sum();
    let scale = (discs.len() as f64 / energy).sqrt();
    if scale.is_finite() {
        discs.iter_mut().for_each(|disc| disc.velocity *= scale);
    }
}
